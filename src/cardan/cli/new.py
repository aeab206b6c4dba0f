"""`cardan new`: a file to start from."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from cardan.cli.common import (
    CAMPAIGN_KIND,
    LANG_OPTION,
    ExampleChoice,
    TemplateChoice,
    announce_application,
    echo,
    progress_line,
    write_output,
)
from cardan.cli.exit_codes import (
    NoRepeatedOptionCommand,
    exit_with_code_2_on_known_errors,
    raise_command_error,
)
from cardan.cli.new_imports import ImportedFiles, write_imported
from cardan.cli.quantity import QuantityParam

_INPUT_FILE = click.Path(exists=True, dir_okay=False, path_type=Path)


@click.command(cls=NoRepeatedOptionCommand)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--kind", type=TemplateChoice(), default="truck", show_default=True,
              help="What it is about.")  # fmt: skip
@click.option("--example", type=ExampleChoice(), metavar="NAME",
              help="A worked example instead: a whole vehicle, or the folder of a case with its "
              "bracket and recordings.")  # fmt: skip
@click.option("--wheelbase-from", type=QuantityParam("mm", "m", "in"), metavar="LENGTH",
              help="Write two files: of this wheelbase and of that of --wheelbase-to.")  # fmt: skip
@click.option("--wheelbase-to", type=QuantityParam("mm", "m", "in"), metavar="LENGTH",
              help="Wheelbase after the change; the last shaft takes it up.")  # fmt: skip
@click.option("--of", "own", type=_INPUT_FILE, metavar="APPLICATION",
              help="Change this application in place of a starter: its wheelbase, duty or "
              "hardpoints.")  # fmt: skip
@click.option("--vecto", "job", type=_INPUT_FILE, metavar="JOB",
              help="The powertrain of a VECTO job (.vecto); its geometry is left to "
              "enter.")  # fmt: skip
@click.option("--vmod", type=_INPUT_FILE, metavar="RESULTS",
              help="The duty cycle of a trip that VECTO simulated (.vmod), for --vecto or "
              "--of.")  # fmt: skip
@click.option("--duty-from", "recording", type=_INPUT_FILE, metavar="RECORDING",
              help="The duty cycle of a recording with shaft torque and speed, for --vecto or "
              "--of.")  # fmt: skip
@click.option("--torque", metavar="CHANNEL[:UNIT]",
              help="Shaft torque in --duty-from; found by unit and name otherwise.")  # fmt: skip
@click.option("--speed", metavar="CHANNEL[:UNIT]",
              help="Shaft speed in --duty-from, or the vehicle's speed; found by unit and name "
              "otherwise.")  # fmt: skip
@click.option("--hardpoints", type=_INPUT_FILE, metavar="TABLE",
              help="Points of the line from a table: name, x [mm], y [mm], z [mm].")  # fmt: skip
@click.option("--bep", "measures", type=_INPUT_FILE, metavar="TABLE",
              help="Wheelbase and axle spacing of a chassis from a table of ISO 21308 codes: "
              "BEP-L011, value [mm].")  # fmt: skip
@click.option("--force", is_flag=True, help="Replace the file.")
@LANG_OPTION
@exit_with_code_2_on_known_errors
def new(
    file: Path,
    *,
    kind: str,
    example: str | None,
    wheelbase_from: float | None,
    wheelbase_to: float | None,
    own: Path | None,
    job: Path | None,
    vmod: Path | None,
    recording: Path | None,
    torque: str | None,
    speed: str | None,
    hardpoints: Path | None,
    measures: Path | None,
    force: bool,
    lang: str,
) -> None:
    """Write a commented FILE to start from.

    A `small` one holds what a body builder knows of a line; `truck`, `6x4` and `bus` a whole
    vehicle, with one line, with two, with three shafts; `industrial` a machine on its foundation.

    With `--kind campaign` FILE is a recording: its campaign is written next to it, with its name
    and .yaml.

    With two wheelbases it writes FILE-3600.yaml and FILE-4500.yaml: the application before and
    after the change, for `cardan check` to hold side by side.

    With --vecto it holds what the job says. Values that no file gives are placeholders, listed in
    the file: nothing is evaluated before they are replaced.

    With --vmod, --duty-from, --bep or --hardpoints alone every other value is that of the starter
    or of --of.
    """
    from cardan.application import templates
    from cardan.render.i18n import Translator

    say = Translator(lang)
    if (wheelbase_from is None) != (wheelbase_to is None):
        raise_command_error("--wheelbase-from and --wheelbase-to are given together")
    if recording is None and (torque is not None or speed is not None):
        raise_command_error("--torque and --speed name channels of --duty-from: give a recording")
    imports = ImportedFiles(
        job=job, vmod=vmod, recording=recording, torque=torque, speed=speed,
        hardpoints=hardpoints, measures=measures,
    )  # fmt: skip
    if imports.files:
        if example is not None or wheelbase_from is not None or kind == CAMPAIGN_KIND:
            raise_command_error(
                "--vecto, --vmod, --duty-from, --hardpoints and --bep go with a starter or --of, "
                "not with --example, a campaign or another wheelbase"
            )
        write_imported(file, imports, kind=_kind_given(kind), own=own, replace=force,
                       say=say)  # fmt: skip
        return
    if example is not None:
        if _kind_given(kind) is not None:
            raise_command_error("--kind is a starter, --example a worked example: give one of them")
        if wheelbase_from is not None or own is not None:
            raise_command_error("--example is written as it is: change its wheelbase with --of")
        _write_example(example, file, replace=force, say=say)
        return
    if kind == CAMPAIGN_KIND:
        if wheelbase_from is not None or own is not None:
            raise_command_error("a campaign has no wheelbase: leave --wheelbase-from and --of out")
        _write_campaign(file, replace=force, say=say)
        return
    if wheelbase_from is not None and wheelbase_to is not None:
        _write_before_and_after(
            file, kind, own, from_=wheelbase_from, to=wheelbase_to, replace=force, say=say
        )
        return
    if own is not None:
        raise_command_error(
            "--of changes an application: give --wheelbase-from and --wheelbase-to, --vmod, "
            "--duty-from, --hardpoints or --bep"
        )
    write_output(file, templates.template_text(kind), replace=force)
    announce_application(file, say)


def _kind_given(kind: str) -> str | None:
    """Return the kind of starter that the command line names; None if it names none."""
    told = click.get_current_context().get_parameter_source("kind")
    return None if told is ParameterSource.DEFAULT else kind


def _write_example(name: str, out: Path, *, replace: bool, say: Any) -> None:
    """Write a worked example: an application, or the files of a case into a folder."""
    from cardan.application.templates import example_path

    source = example_path(name)
    if source.is_file():
        write_output(out, source.read_bytes(), replace=replace)
        announce_application(out, say)
        return
    files = {out / p.name: p for p in sorted(source.iterdir())}
    if (there := [path for path in files if path.exists()]) and not replace:
        raise_command_error(f"{there[0]} is there already; --force replaces it")
    out.mkdir(parents=True, exist_ok=True)
    for path, from_ in files.items():
        write_output(path, from_.read_bytes())
    echo(
        say(
            "{count} files are written into {folder}; {readme} says what to run.",
            count=len(files), folder=out, readme=out / "README.md",
        )
    )  # fmt: skip


def _write_campaign(recording: Path, *, replace: bool, say: Any) -> None:
    """Write a campaign next to its recording."""
    from cardan.topics.recording.campaign_template_presentation import campaign_template
    from cardan.topics.recording.recording_overview import survey_recording

    out = recording.with_suffix(".yaml")
    if recording.suffix.lower() in (".yaml", ".yml"):
        raise_command_error(
            f"--kind {CAMPAIGN_KIND} takes a recording, and writes the campaign next to it; got "
            f"{recording.name}"
        )

    def content() -> Iterator[bytes]:
        # Begun behind the look at what is there already: a long recording takes minutes.
        with progress_line("reading") as line:
            found = survey_recording(recording, tell=lambda doing, _, __: line.write(doing))
        yield campaign_template(found).encode()

    write_output(out, content(), replace=replace)
    echo(
        say(
            "{file} is written; fill in its strength, and `cardan life {file}` evaluates it.",
            file=out,
        )
    )


def _write_before_and_after(
    file: Path,
    kind: str,
    own: Path | None,
    *,
    from_: float,
    to: float,
    replace: bool,
    say: Any,
) -> None:
    """Write the applications of two wheelbases, and print what the change requires of the line."""
    from cardan.application import reader
    from cardan.application.templates import template_text
    from cardan.application.wheelbase import text_with_wheelbase
    from cardan.core.units import mm
    from cardan.schema.yaml_tree import read_text

    text = template_text(kind) if own is None else read_text(own)
    _check_wheelbase(own, from_)
    source: dict[str, Any] = {} if own is None else {"name": str(own), "folder": own.parent}
    before = text_with_wheelbase(text, wheelbase=from_, from_wheelbase=from_, **source)
    after = text_with_wheelbase(before, wheelbase=to, from_wheelbase=from_, **source)
    stem = file.with_suffix("")
    files = [stem.with_name(f"{stem.name}-{size / mm:.0f}.yaml") for size in (from_, to)]
    if files[0] == files[1]:
        raise_command_error("the two wheelbases are the same")
    for one, content in zip(files, (before, after), strict=True):
        write_output(one, content, replace=replace)
    first, second = files
    echo(
        say(
            "{first} and {second} are written; `cardan check {first} {second}` compares them.",
            first=first, second=second,
        )
    )  # fmt: skip
    applications = [
        reader.loads(content, name=str(one), folder=source.get("folder"))
        for one, content in zip(files, (before, after), strict=True)
    ]
    for line in _advice(*applications, after_file=second, say=say):
        echo(line)


def _check_wheelbase(own: Path | None, from_: float) -> None:
    """Refuse an application whose own wheelbase is another than the one to start from."""
    from cardan.application import reader
    from cardan.core.units import mm

    vehicle = None if own is None else reader.read(own).vehicle
    if vehicle is not None and abs(float(vehicle.wheelbase) - from_) > 0.5 * mm:
        raise_command_error(
            f"{own}: vehicle.wheelbase is {float(vehicle.wheelbase) / mm:.6g} mm, "
            f"--wheelbase-from is {from_ / mm:.6g} mm"
        )


def _advice(before: Any, after: Any, *, after_file: Path, say: Any) -> Any:
    """Yield how much longer the last shafts are, and whether a further shaft is needed."""
    from cardan.application.wheelbase import lines_that_follow_rear_axle
    from cardan.approval.approval import approve_driveline
    from cardan.core.units import mm

    for was, now in zip(
        lines_that_follow_rear_axle(before), lines_that_follow_rear_axle(after), strict=True
    ):
        last, old = now.line.shafts[-1], was.line.shafts[-1]
        yield say(
            "Line {line}: shaft {number} is {length} mm long in place of {before} mm.",
            line=now.line.name, number=len(now.line.shafts),
            length=f"{last.length / mm:.0f}", before=f"{old.length / mm:.0f}",
        )  # fmt: skip
        whirls = [
            c
            for c in approve_driveline(after).checks
            if c.quantity == "critical_speed_ratio" and c.line == now.line.name
        ]
        worst = max(whirls, key=lambda c: c.value, default=None)
        if worst is None:
            yield say("Its critical speed is not evaluated: speed_rpm and the tube are not given.")
        elif worst.grade == "fail":
            yield say(
                "It turns at {ratio} times its critical speed, {most} at most: it is too long. A "
                "further shaft with a centre bearing, or a larger tube, is needed; "
                "`cardan size {file}` proposes them.",
                ratio=say.compact_number(worst.value, 3), most=say.compact_number(worst.bound, 3),
                file=after_file,
            )  # fmt: skip
    if after.vehicle is not None:
        yield say("Axle loads are those of before: correct vehicle.loads by the new wheelbase.")
    if after.obstacles:
        yield say("Obstacles are where they were: move those that moved with the axle.")

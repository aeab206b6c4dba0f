"""`cardan new` from files of others: a VECTO job, its results, a recording, tables of measures."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cardan.cli.common import announce_application, echo, write_output
from cardan.cli.exit_codes import raise_command_error

if TYPE_CHECKING:
    from cardan.application.duty_collective import DutyCollective
    from cardan.core.message import TranslatableMessage
    from cardan.model.application import Application


@dataclass(frozen=True, kw_only=True)
class ImportedFiles:
    """Files that an application is made of; None where none is given."""

    job: Path | None
    vmod: Path | None
    recording: Path | None
    torque: str | None
    speed: str | None
    hardpoints: Path | None
    measures: Path | None

    @property
    def files(self) -> tuple[Path, ...]:
        """Those that are given."""
        all_ = (self.job, self.vmod, self.recording, self.hardpoints, self.measures)
        return tuple(one for one in all_ if one is not None)


def write_imported(
    out: Path,
    imports: ImportedFiles,
    *,
    kind: str | None,
    own: Path | None,
    replace: bool,
    say: Any,
) -> None:
    """Write an application with what files of other tools say, and print what was read."""
    from cardan.application import reader
    from cardan.application.bep_measures import read_measures, text_with_measures
    from cardan.application.duty_collective import duty_section, text_with_duty
    from cardan.application.hardpoint_table import read_hardpoints, text_with_hardpoints
    from cardan.schema.atomic_write import check_output_paths

    if sum(one is not None for one in (imports.job, own, kind)) > 1:
        raise_command_error("--vecto, --of and --kind are three bases: give one of them")
    if imports.vmod is not None and imports.recording is not None:
        raise_command_error("--vmod and --duty-from are two duty cycles: give one of them")
    if (imports.vmod or imports.recording) and imports.job is None and own is None:
        option = "--vmod" if imports.vmod else "--duty-from"
        raise_command_error(f"{option} is the duty of a vehicle: give it with --vecto or --of")
    check_output_paths({"FILE": out}, inputs=imports.files)
    text, remarks = _base(imports, kind, own)
    said = [_note(imports.job, remark, say) for remark in remarks if imports.job]
    source: dict[str, Any] = {} if own is None else {"folder": own.parent}
    application = reader.loads(
        text, name=str(own) if own else f"application of {imports.job or kind}", **source
    )
    if imports.measures is not None:
        measures = read_measures(imports.measures)
        text, notes = text_with_measures(
            text, application, measures, moves_line=imports.hardpoints is None, **source
        )
        said += [_note(imports.measures, note, say) for note in notes]
    if imports.hardpoints is not None:
        points = read_hardpoints(imports.hardpoints)
        text = text_with_hardpoints(text, application, points, source=str(imports.hardpoints))
        name = imports.hardpoints.name
        said.append(say("{file}: {count} points.", file=name, count=len(points)))
    if imports.vmod is not None or imports.recording is not None:
        duty = _duty(imports, application)
        text = text_with_duty(text, duty_section(duty))
        said.append(
            say(
                "duty: {classes} classes of {time} s, {moving} % of it in motion; {origin}.",
                classes=len(duty.share),
                time=f"{duty.duration:.0f}",
                moving=f"{100 * duty.driving_share:.0f}",
                origin=say.translate_message(duty.origin),
            )
        )
    left = reader.loads(text, name=str(out), **source).placeholders  # what is written can be read
    write_output(out, text, replace=replace)
    for line in said:
        echo(line)
    if left:
        echo(say("{file} is written; enter the values of: {keys}.", file=out, keys=", ".join(left)))
    else:
        announce_application(out, say)


def _duty(imports: ImportedFiles, application: "Application") -> "DutyCollective":
    """Return the duty cycle of modal results or of a recording, for an application's vehicle."""
    axle, tyre = application.lines[0].axle, application.tyre
    ratio = None if axle is None else float(axle.ratio)
    radius = None if tyre is None else float(tyre.dynamic_radius or tyre.static_radius)
    if imports.recording is not None:
        from cardan.topics.recording.measured_duty import read_measured_duty

        return read_measured_duty(
            imports.recording, speed=imports.speed, torque=imports.torque,
            axle_ratio=ratio, tyre_radius=radius,
        )  # fmt: skip
    assert imports.vmod is not None
    from cardan.application.relation_context import RelationContext
    from cardan.application.simulated_duty import read_simulated_duty

    most = float(RelationContext(application=application).largest_torque)
    return read_simulated_duty(
        imports.vmod, axle_ratio=ratio, dynamic_radius=radius,
        largest_torque=most if most > 0 else float("inf"),
    )  # fmt: skip


def _note(file: Path, note: "TranslatableMessage", say: Any) -> str:
    """Return what a file says that is worth a line."""
    return f"{file.name}: {say.translate_message(note)}."


def _base(
    imports: ImportedFiles, kind: str | None, own: Path | None
) -> tuple[str, tuple["TranslatableMessage", ...]]:
    """Return the text that the files change, and what a job says that is not carried over."""
    if imports.job is not None:
        from cardan.application.vecto_application import application_text_of_vecto_job
        from cardan.application.vecto_job import read_job

        job = read_job(imports.job)
        return application_text_of_vecto_job(job), job.remarks
    if own is not None:
        from cardan.schema.yaml_tree import read_text

        return read_text(own), ()
    from cardan.application.templates import template_text

    return template_text(kind or "truck"), ()

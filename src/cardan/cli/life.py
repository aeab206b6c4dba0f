"""`cardan life`: from a recording to damage, life and cause, held against limits."""

import contextlib
from io import BytesIO
from pathlib import Path
from typing import Any

import click

from cardan.base.errors import DesignError, NotInstalled
from cardan.cli.common import (
    JSON,
    LANG,
    OUT,
    OUTSIDE,
    UNTOLD,
    claim,
    progress,
    publish,
    put_lines,
    read,
    screen,
    write,
    write_json,
)
from cardan.cli.ending import Once, kindly, leave


def _drawable(_: click.Context, __: click.Parameter, out: Path | None) -> Path | None:
    """Refuse a figure whose ending names no kind, before anything is read."""
    if out is not None and out.suffix not in ("", ".svg", ".png", ".pdf"):
        msg = f"a figure ends in .svg, .png or .pdf, got {out.name!r}"
        raise click.BadParameter(msg)
    return out


@click.command(cls=Once)
@click.argument("recording", type=click.Path(dir_okay=False, path_type=Path))
@click.option(
    "--gauge",
    "gauges",
    multiple=True,
    metavar="CHANNEL[:UNIT]",
    help="A channel of stress or strain; may be repeated. Strain is multiplied by Young's modulus.",
)
@click.option(
    "--rosette",
    "rosettes",
    multiple=True,
    metavar="NAME=A,B,C[:UNIT]",
    help="Three channels of one rosette.",
)
@click.option(
    "--rosette-kind",
    type=click.Choice(["rectangular", "delta"]),
    default="rectangular",
    show_default=True,
)
@click.option(
    "--rosette-measure",
    "rosette_measure",
    type=click.Choice(["mises", "principal", "planes"]),
    default="mises",
    show_default=True,
    help="The stress of a rosette that is counted; planes: on 20 planes, a gauge each.",
)
@click.option("--modulus-GPa", "modulus_GPa", type=float, default=206.0, show_default=True)
@click.option(
    "--sn",
    metavar="MPa,CYCLES,SLOPE",
    help="S-N curve at the gauge, half failed: amplitude and cycles at the knee, slope.",
)
@click.option(
    "--scatter",
    type=float,
    default=0.0,
    show_default=True,
    help="Standard deviation of log10 strength.",
)
@click.option(
    "--gauge-error",
    type=float,
    default=0.0,
    show_default=True,
    help="Relative standard deviation of the stress scale.",
)
@click.option(
    "--miner",
    type=click.Choice(["original", "elementary", "modified"]),
    default="modified",
    show_default=True,
)
@click.option(
    "--mean-stress",
    type=click.Choice(["none", "goodman", "gerber", "swt", "walker", "fkm"]),
    default="none",
    show_default=True,
)
@click.option("--ultimate-MPa", "ultimate_MPa", type=float)
@click.option("--mean-sensitivity", type=float, help="M of fkm, or the exponent of walker (0.65).")
@click.option(
    "--residue",
    type=click.Choice(["half", "repeat", "discard"]),
    default="half",
    show_default=True,
    help="What the open residue counts for.",
)
@click.option("--allowed", type=float, default=1.0, show_default=True, help="Damage at failure.")
@click.option(
    "--zero",
    type=click.Choice(["none", "start", "median", "drift"]),
    default="none",
    show_default=True,
    help="What is taken off each channel as zero.",
)
@click.option("--low-pass-Hz", "low_pass_Hz", type=float, help="Count nothing faster.")
@click.option(
    "--scale",
    multiple=True,
    metavar="CHANNEL=FACTOR[,OFFSET]:UNIT",
    help="Of a channel in V or mV/V: its value times FACTOR plus OFFSET is in UNIT.",
)
@click.option(
    "--speed",
    metavar="CHANNEL[:UNIT]",
    help="Shaft speed: with it, causes are told. In km/h with --axle-ratio and --tyre-radius-m.",
)
@click.option("--tacho", metavar="CHANNEL", help="Shaft tacho, in place of a speed.")
@click.option("--pulses", type=int, default=1, show_default=True, help="Of the tacho, per turn.")
@click.option(
    "--estimate-speed",
    metavar="GAUGE",
    help="No speed: find it in this channel. It gives no angle to trust.",
)
@click.option(
    "--joint-orders",
    default="2,4",
    show_default=True,
    help="Of 2, 4 and 6: where they run with others' is said. Theirs is sought at all of them.",
)
@click.option("--engine", metavar="CHANNEL[:UNIT]", help="Engine speed.")
@click.option(
    "--engine-orders",
    default="",
    help="Half its cylinders, and twice that; 3,6 assumed, and then in direct gear order 2 may "
    "always be the engine's.",
)
@click.option("--axle-ratio", type=float, help="Shaft turns per wheel turn: wheel orders.")
@click.option("--tyre-radius-m", type=float, help="With the axle ratio: kilometres.")
@click.option("--torque", metavar="CHANNEL[:UNIT]", help="Shaft torque.")
@click.option(
    "--predicted",
    multiple=True,
    metavar="GAUGE=MPa_per_kNm",
    help="Order-2 stress the geometry predicts, to hold against the measured.",
)
@click.option(
    "--application",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Application file that predicts it instead, with --unit-stress.",
)
@click.option(
    "--unit-stress",
    "unit_stress",
    multiple=True,
    metavar="GAUGE=X,Y,Z",
    help="MPa at the gauge for 1 kN of the bearing along each vehicle axis.",
)
@click.option("--state", default="gvw", show_default=True, help="State of the application.")
@click.option("--bearing", type=int, default=1, show_default=True, help="Centre bearing number.")
@click.option(
    "--strain-life",
    "strain_life",
    metavar="MPa,B,STRAIN,C[,MPa,N]",
    help="Life until a crack by the local strain, with memory: σf', b, εf', c; K' and n' "
    "follow unless given.",
)
@click.option(
    "--notch",
    type=float,
    help="K_t from the gauge to a notch, by Neuber; without it the gauge felt the strain itself.",
)
@click.option(
    "--strain-mean",
    "strain_mean",
    type=click.Choice(["swt", "morrow", "none"]),
    default="swt",
    show_default=True,
    help="What the mean stress of a loop does.",
)
@click.option(
    "--crack",
    metavar="MM,MM,C,M",
    help="Growth of a crack from one length to another: C ΔK^M, m a cycle, ΔK in MPa√m.",
)
@click.option(
    "--crack-threshold", type=float, default=0.0, show_default=True, help="ΔK that grows it, MPa√m."
)
@click.option(
    "--crack-shape", type=float, default=1.12, show_default=True, help="Y of K = Y S √(πa)."
)
@click.option(
    "--service-hours",
    type=float,
    help="Odds of failure in as many hours (FORM, SORM, sampled): scatter of strength, of the "
    "damage at failure and of the gauge.",
)
@click.option(
    "--miner-scatter",
    type=float,
    default=0.3,
    show_default=True,
    help="Coefficient of variation of the damage at failure.",
)
@click.option(
    "--usage",
    is_flag=True,
    help="Tell when and where the damage came: by gear, speed and torque, the largest stresses, "
    "the long run with its interval, and how short a test can be.",
)
@click.option(
    "--identify",
    is_flag=True,
    help="Hold the recorded orders against the application's line on rubber, and look for its "
    "stiffness, loss, yoke phase, unbalance and the bracket's mode.",
)
@click.option(
    "--corrected",
    type=OUT,
    help="With --identify: the application's file with what was found otherwise; comments stay.",
)
@click.option(
    "--load-history",
    "load_history",
    type=OUT,
    help="With --identify: the force on the bearing over the recording, as CSV.",
)
@click.option(
    "--changed",
    type=click.Path(dir_okay=False, path_type=Path),
    help="With --identify: another application, driven as the recording was; damage and life that "
    "it promises.",
)
@click.option(
    "--changed-history",
    "changed_history",
    type=OUT,
    help="With --changed: the force on its bearing over the recording, as CSV.",
)
@click.option("--rate", type=float, help="Samples a second, above what the file says.")
@click.option(
    "--time",
    metavar="NAME[:UNIT]",
    help="Time column, its unit if the file has none.",
)
@click.option("--group", default="", help="Group of an HDF5, TDMS or MDF4 file.")
@click.option(
    "--mask",
    multiple=True,
    metavar="[CHANNEL=]KIND[@FROM..TO]",
    help="Make a hole of what looks wrong (sentinel, spike, dropout, freeze, noise, repeat), or of "
    "a time in seconds, FROM..TO; take a zero-step, a change of gain or hum off; may be repeated. "
    "Nothing is masked by itself.",
)
@click.option(
    "--accept",
    multiple=True,
    metavar="[CHANNEL=]KIND[@FROM..TO]",
    help="It was what the part felt (also clip, drift, hum), or is as it was said (unit, rate, "
    "strength); may be repeated.",
)
@click.option(
    "--between-samples",
    type=click.Choice(["auto", "yes", "no"]),
    default="auto",
    show_default=True,
    help="Look for crests between samples; auto: where they lose 1 % or more.",
)
@click.option("--target-hours", type=float, help="Fail where a gauge lives shorter.")
@click.option(
    "--limits",
    metavar="PROFILE",
    help="Limit profile: its fatigue_life and fatigue_damage are held against every gauge.",
)
@JSON
@click.option("--plot", type=OUT, callback=_drawable, help="A figure: svg, png.")
@click.option("--html", type=OUT, help="A report: a page of its own.")
@click.option("--pdf", type=OUT, help="A report: a document.")
@OUTSIDE
@LANG
@UNTOLD
@kindly
def life(
    recording: Path,
    *,
    application: Path | None,
    json_out: str | None,
    plot: Path | None,
    html: Path | None,
    pdf: Path | None,
    corrected: Path | None,
    load_history: Path | None,
    changed: Path | None,
    changed_history: Path | None,
    allow_outside: bool,
    lang: str,
    quiet: bool,
    **options: Any,
) -> None:
    """Damage and life at the gauges of a RECORDING, and who did it.

    A RECORDING that ends in .yaml is a campaign: a file that names recordings and says of all
    what the options say of one. Of the options only the outputs
    --json, --html and --pdf, --lang and --quiet go with it, and of one that names a single
    recording --corrected, --load-history and --changed-history.

    Held against --target-hours and the rows of --limits, where either is given. Exit code 0
    where every gauge passes or warns or nothing was asked, 1 where one fails or is vetoed or
    the life of one that is asked about is not known, 2 for a bad file or option.
    """
    from cardan.report import life as report
    from cardan.report.language import Language
    from cardan.report.screen import folded
    from cardan.study.campaign import Campaign
    from cardan.study.recording import listen, verdict_on

    _thrifty()
    say = Language(lang)
    if recording.suffix.lower() in (".yaml", ".yml"):
        _campaign(
            recording, json_out=json_out, html=html, pdf=pdf, corrected=corrected,
            load_history=load_history, changed_history=changed_history,
            allow_outside=allow_outside, say=say, quiet=quiet,
        )  # fmt: skip
        return
    if options["sn"] is None:
        msg = "a recording is asked with an S-N curve: --sn MPa,CYCLES,SLOPE"
        raise DesignError(msg)
    if (corrected or load_history) and not options["identify"]:
        name = "--corrected" if corrected else "--load-history"
        msg = f"{name} tells what --identify finds: ask for that too"
        raise DesignError(msg)
    if changed_history and changed is None:
        msg = "--changed-history is the force on the bearing of a --changed application: name one"
        raise DesignError(msg)
    outputs = claim(
        recording, application, changed, options["limits"], json_out=json_out, plot=plot,
        html=html, pdf=pdf, corrected=corrected, load_history=load_history,
        changed_history=changed_history,
    )  # fmt: skip
    predicting, instead = (
        read(path, None, allow_outside=allow_outside, outputs=outputs) if path else None
        for path in (application, changed)
    )
    campaign = Campaign(application=predicting, changed=instead, **options)
    with progress(say("reading"), quiet=quiet) as line:
        found = listen(
            recording, campaign, lambda doing, _, __: line.write(report.under_way(doing, say)),
            draw=bool(html or pdf),
        )  # fmt: skip
    if json_out is not None:
        write_json(report.document(found), json_out)
    if json_out != "-":
        put_lines(folded(report.terminal(found, say), screen()))
    if plot:
        _draw(plot, found)
    if html or pdf:
        from cardan.report import recording_story as story

        issue = _issue(recording, application, changed, text=False)
        told = story.recording(found, say=say, issue=issue)
        publish(told, say=say, html=html, pdf=pdf, quiet=quiet)
    if found.answer is not None:
        _write_identified(campaign, found.answer, corrected, load_history, changed_history)
    leave(verdict_on(found) or "pass")


def _thrifty() -> None:
    """Let threads take their memory from one place: each else keeps what it has done with.

    It is worth 100 MB on a long recording, and nothing can be said where there is no glibc.
    """
    import ctypes

    with contextlib.suppress(OSError, AttributeError, TypeError):
        ctypes.CDLL(None).mallopt(-8, 1)  # M_ARENA_MAX


def _write_identified(
    campaign: Any, of: Any, corrected: Path | None, history: Path | None, changed: Path | None
) -> None:
    """Write what follows from an identification, where there is one.

    Raises
    ------
    DesignError
        If it tells nothing of the line: an earlier file would be taken for its answer.
    """
    if of.identification is None:
        return
    asked = {"--corrected": corrected, "--load-history": history, "--changed-history": changed}
    named = [name for name, path in asked.items() if path is not None]
    if of.identification.doubts and named:
        msg = f"{named[0]} writes nothing: nothing is told of the line by this recording"
        raise DesignError(msg)
    if corrected is not None:
        write(corrected, of.identification.text())
    if history is not None:
        write(history, _history(campaign, of))
    if changed is not None:
        write(changed, _history(campaign, of, changed=True))


def _history(campaign: Any, of: Any, *, changed: bool = False) -> str:
    """Return the force on the bearing over a recording as a table, of the changed line if asked."""
    from cardan.study.recording import history_of

    time, force = history_of(campaign, of, changed=changed)
    rows = (f"{t:.5f},{x:.4g},{y:.4g},{z:.4g}" for t, (x, y, z) in zip(time, force, strict=True))
    return "\n".join(("time_s,x_N,y_N,z_N", *rows)) + "\n"


def _campaign(
    path: Path, *, json_out: str | None, html: Path | None, pdf: Path | None,
    corrected: Path | None, load_history: Path | None, changed_history: Path | None,
    allow_outside: bool, say: Any, quiet: bool,
) -> None:  # fmt: skip
    """Ask all the recordings of a campaign's file."""
    from cardan.files.campaign import read as read_campaign
    from cardan.report import life as report
    from cardan.report.screen import folded
    from cardan.study.campaign import keyed
    from cardan.study.recording import listen_to_all, verdict_on

    context = click.get_current_context()
    given = click.core.ParameterSource.COMMANDLINE
    own = {"recording", "json_out", "html", "pdf", "lang", "quiet", "allow_outside", "corrected",
           "load_history", "changed_history"}  # fmt: skip
    beside = [
        n for n in context.params if n not in own and context.get_parameter_source(n) == given
    ]
    if beside:
        option = beside[0].replace("_", "-")
        msg = f"--{option} is said in the campaign's file, {path.name}, not beside it"
        raise DesignError(msg)
    outputs = {
        "json_out": json_out, "html": html, "pdf": pdf, "corrected": corrected,
        "load_history": load_history, "changed_history": changed_history,
    }  # fmt: skip
    claim(path, **outputs)
    written = read_campaign(path, allow_outside=allow_outside)
    claim(*written.named, **outputs)
    with progress(say("reading"), quiet=quiet) as line:
        found = listen_to_all(
            written, draw=bool(html or pdf),
            tell=lambda doing, _, __: line.write(report.under_way(doing, say)),
            identified=bool(corrected or load_history), changed=bool(changed_history),
        )  # fmt: skip
    if json_out is not None:
        write_json(report.mix_document(found), json_out)
    if json_out != "-":
        put_lines(folded(map(keyed, report.mix_terminal(found, say)), screen()))
    if html or pdf:
        from cardan.report import recording_story as story

        told = story.campaign(found, say=say, issue=_issue(path, *written.named, text=True))
        publish(told, say=say, html=html, pdf=pdf, quiet=quiet)
    if found.answer is not None and any((corrected, load_history, changed_history)):
        ((_, _, heard),) = found.answer.parts
        _write_identified(found.answer.campaign, heard, corrected, load_history, changed_history)
    leave(verdict_on(found) or "pass")


def _issue(first: Path, *others: Path | None, text: bool) -> Any:
    """Return what says which report this is: the day, the files it is of and what they held."""
    from datetime import date
    from hashlib import file_digest

    from cardan.report.blocks import Issue

    def print_(path: Path) -> str:
        with path.open("rb") as file:
            return file_digest(file, "sha256").hexdigest()[:16]

    paths = tuple(dict.fromkeys(p for p in (first, *others) if p is not None))
    return Issue(
        date=date.today().isoformat(),
        files=tuple(click.format_filename(p, shorten=True) for p in paths),
        prints=tuple(map(print_, paths)),
        texts=(first.read_text(encoding="utf-8-sig"),) if text else (),
    )


def _draw(out: Path, found: Any) -> None:
    """Draw a figure to a file whose ending says of which kind."""
    from cardan.report import life as report

    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        msg = "--plot needs matplotlib; pip install 'cardan[report]'"
        raise NotInstalled(msg) from error
    sheet = Figure(figsize=(11, 10), layout="constrained")
    of = found.answer
    report.figure(sheet, recording=of.recording, lives=of.lives, causes=of.causes)
    drawn = BytesIO()
    sheet.savefig(drawn, format=out.suffix.removeprefix(".") or "svg")
    write(out, drawn.getvalue())

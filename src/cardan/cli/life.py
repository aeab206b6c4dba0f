"""`cardan life`: from a recording to damage, life and cause."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

import click

from cardan.base.errors import CardanError
from cardan.base.units import GPa, MPa, deg, rpm
from cardan.cli.common import (
    JSON,
    OUT,
    OUTSIDE,
    UNTOLD,
    claim,
    progress,
    put_lines,
    read,
    write,
    write_json,
)
from cardan.cli.ending import kindly, leave

_TURN = 2 * math.pi
_STRESS = {
    "MPa": 1e6, "N/mm2": 1e6, "N/mm²": 1e6, "kPa": 1e3, "Pa": 1.0, "ksi": 6.894757293e6,
}  # fmt: skip
_STRAIN = {
    "um/m": 1e-6, "µm/m": 1e-6, "μm/m": 1e-6, "ue": 1e-6, "uE": 1e-6, "µε": 1e-6, "με": 1e-6,
    "ustrain": 1e-6, "microstrain": 1e-6, "m/m": 1.0, "mm/m": 1e-3, "%": 1e-2,
}  # fmt: skip
_SPEED = {
    "rpm": rpm / _TURN, "1/min": rpm / _TURN, "U/min": rpm / _TURN, "min-1": rpm / _TURN,
    "Hz": 1.0, "1/s": 1.0, "rad/s": 1 / _TURN,
}  # fmt: skip
_TORQUE = {"Nm": 1.0, "N·m": 1.0, "N.m": 1.0, "kNm": 1e3, "kN·m": 1e3, "kN.m": 1e3}


def _unit(recording: Any, channel: str, given: str | None, table: dict[str, float]) -> float:
    """SI value of a channel's unit, given by hand or by the file."""
    name = given or recording.channel(channel).unit
    if name not in table:
        said = repr(name) if name else "no unit"
        msg = f"{channel}: {said}; write {channel}:UNIT with one of {', '.join(table)}"
        raise ValueError(msg)
    return table[name]


def _named(text: str) -> tuple[str, str | None]:
    """Split CHANNEL:UNIT; channel names may hold colons, units do not."""
    name, _, unit = text.rpartition(":")
    known = (*_STRESS, *_STRAIN, *_SPEED, *_TORQUE)
    return (name, unit) if name and unit in known else (text, None)


def _measures(name: str) -> dict[str, Any]:
    """Return what is counted of a rosette, by the ending of the gauge's name."""
    from cardan.fatigue import strain

    if name == "planes":
        angles = range(0, 180, 10)
        return {f"@{a}": partial(strain.PlaneStress.normal, angle=a * deg) for a in angles}
    return {"": strain.signed_mises if name == "mises" else strain.largest}


def _gauges(
    recording: Any,
    singles: tuple[str, ...],
    rosettes: tuple[str, ...],
    *,
    kind: str,
    measure: str,
    modulus: float,
) -> tuple[Any, ...]:
    from cardan.fatigue.strain import DELTA, RECTANGULAR, direct, rosette_gauge

    found: list[Any] = []
    for text in singles:
        channel, given = _named(text)
        factor = _unit(
            recording, channel, given,
            _STRESS | {u: modulus * v for u, v in _STRAIN.items()},
        )  # fmt: skip
        found.append(direct(channel, channel, factor=factor))
    for text in rosettes:
        name, _, rest = text.partition("=")
        grids, given = _named(rest)
        channels = tuple(grids.split(","))
        if len(channels) != 3:
            msg = f"a rosette is NAME=A,B,C with three channels, got {text!r}"
            raise ValueError(msg)
        unit = _unit(recording, channels[0], given, _STRAIN)
        angles = DELTA if kind == "delta" else RECTANGULAR
        found += [
            rosette_gauge(
                name + end, channels, unit=unit, angles=angles, modulus=modulus, measure=of
            )
            for end, of in _measures(measure).items()
        ]
    return tuple(found)


def _curve(text: str, miner: str, scatter: float) -> Any:
    from cardan.fatigue.strength import SNCurve

    try:
        amplitude, cycles, slope = (float(v) for v in text.split(","))
    except ValueError:
        msg = f"an S-N curve is AMPLITUDE_MPa,CYCLES,SLOPE at its knee, got {text!r}"
        raise ValueError(msg) from None
    curve = SNCurve(amplitude=amplitude * MPa, cycles=cycles, slope=slope, scatter=scatter)
    variants: dict[str, Callable[[], SNCurve]] = {
        "original": curve.original, "elementary": curve.elementary, "modified": curve.modified,
    }  # fmt: skip
    return variants[miner]()


def _correction(name: str, ultimate: float | None, sensitivity: float | None) -> Any:
    from cardan.fatigue import correction as c

    if name in ("goodman", "gerber"):
        if ultimate is None:
            msg = f"{name} needs the tensile strength: --ultimate-MPa"
            raise ValueError(msg)
        return partial(getattr(c, name), ultimate=ultimate * MPa)
    if name == "fkm":
        if sensitivity is None and ultimate is None:
            msg = "fkm needs the tensile strength (--ultimate-MPa) or --mean-sensitivity"
            raise ValueError(msg)
        M = sensitivity if sensitivity is not None else c.mean_sensitivity((ultimate or 0) * MPa)
        return partial(c.fkm, sensitivity=M)
    if name == "walker":
        return partial(c.walker, exponent=0.65 if sensitivity is None else sensitivity)
    return c.swt if name == "swt" else c.uncorrected


def _rotation(recording: Any, *, speed: str | None, tacho: str | None, pulses: int) -> Any:
    from cardan.fatigue.orders import rotation_from_pulses, rotation_from_speed

    if tacho is not None:
        return rotation_from_pulses(recording.pieces([tacho]), rate=recording.rate, per_turn=pulses)
    if speed is not None:
        channel, given = _named(speed)
        unit = _unit(recording, channel, given, _SPEED)
        return rotation_from_speed(recording.pieces([channel]), rate=recording.rate, unit=unit)
    return None


def _predictions(how: dict[str, Any]) -> dict[str, float]:
    """Order-2 stress per shaft torque, Pa per N m, by gauge: given, or of an application."""
    found: dict[str, float] = {}
    if how["unit_stress"]:
        if how["application"] is None:
            msg = "--unit-stress needs the --application whose bearing loads it is for"
            raise ValueError(msg)
        import numpy as np

        from cardan.study.recorded import predicted_stress

        application = read(how["application"], None, allow_outside=how["allow_outside"])
        for text in how["unit_stress"]:
            name, _, axes = text.rpartition("=")
            unit = np.array(_numbers(axes)) * MPa / 1e3
            if unit.shape != (3,):
                msg = f"a unit stress is GAUGE=X,Y,Z in MPa per kN, got {text!r}"
                raise ValueError(msg)
            found[name] = predicted_stress(
                application, unit_stress=unit, state=how["state"], bearing=how["bearing"]
            )
    for text in how["predicted"]:
        name, _, value = text.rpartition("=")
        try:
            found[name] = float(value) * MPa / 1e3
        except ValueError:
            msg = f"a prediction is GAUGE=MPa_per_kNm, got {text!r}"
            raise ValueError(msg) from None
    return found


def _numbers(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(v) for v in text.split(","))
    except ValueError:
        msg = f"expected numbers with commas between, got {text!r}"
        raise ValueError(msg) from None


@click.command()
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
    "measure",
    type=click.Choice(["mises", "principal", "planes"]),
    default="mises",
    show_default=True,
    help="The stress of a rosette that is counted; planes: on 18 planes, a gauge each.",
)
@click.option("--modulus-GPa", "modulus", type=float, default=206.0, show_default=True)
@click.option(
    "--sn",
    required=True,
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
@click.option("--ultimate-MPa", "ultimate", type=float)
@click.option(
    "--mean-sensitivity", "sensitivity", type=float, help="M of fkm, or the exponent of walker."
)
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
@click.option("--low-pass-Hz", "low_pass", type=float, help="Count nothing faster.")
@click.option("--speed", metavar="CHANNEL[:UNIT]", help="Shaft speed: with it, causes are told.")
@click.option("--tacho", metavar="CHANNEL", help="Shaft tacho, in place of a speed.")
@click.option("--pulses", type=int, default=1, show_default=True, help="Of the tacho, per turn.")
@click.option(
    "--estimate-speed",
    metavar="GAUGE",
    help="No speed: find it in this channel. Loads that channel whole.",
)
@click.option("--joint-orders", default="2,4", show_default=True)
@click.option("--engine", metavar="CHANNEL[:UNIT]", help="Engine speed.")
@click.option("--engine-orders", default="3,6", show_default=True)
@click.option("--axle-ratio", type=float, help="Shaft turns per wheel turn: wheel orders.")
@click.option("--tyre-radius-m", "radius", type=float, help="With the axle ratio: kilometres.")
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
@click.option("--rate", type=float, help="Samples a second, above what the file says.")
@click.option("--time", help="Name of the time column.")
@click.option("--group", default="", help="HDF5 or TDMS group.")
@click.option("--target-hours", type=float, help="Exit 1 if a gauge lives shorter.")
@JSON
@click.option("--plot", type=OUT, help="A figure: svg, png.")
@OUTSIDE
@UNTOLD
@kindly
def life(recording: Path, **how: Any) -> None:
    """Damage and life at the gauges of a RECORDING, and who did it.

    Exit code 0, 1 where a gauge lives shorter than asked, 2 for a bad file or option.
    """
    claim(recording, how["application"], json_out=how["json_out"], plot=how["plot"])
    try:
        lives = _run(recording, **how)
    except ImportError as error:
        extra = "report" if error.name == "matplotlib" else "fatigue,recordings"
        msg = f"this needs {error.name}; pip install 'cardan[{extra}]'"
        raise CardanError(msg) from error
    except ValueError as error:  # of an option, or of what a recording holds
        raise CardanError(str(error)) from error
    target = how["target_hours"]
    leave("fail" if target and min(one.life.hours for one in lives) < target else "pass")


def _draw(out: Path, **found: Any) -> None:
    """Draw a figure to a file whose ending says of which kind."""
    from matplotlib.figure import Figure

    from cardan.report import life as report

    sheet = Figure(figsize=(11, 7.5), layout="constrained")
    report.figure(sheet, **found)
    drawn = BytesIO()
    sheet.savefig(drawn, format=out.suffix.removeprefix(".") or "svg")
    write(out, drawn.getvalue())


def _plan(source: Any, **how: Any) -> Any:
    """Return what is counted, and held against which strength."""
    from cardan.fatigue import conditioning, rainflow
    from cardan.fatigue.life import Plan

    rules = {
        "half": rainflow.half_cycles, "repeat": rainflow.repeating, "discard": rainflow.discarded
    }  # fmt: skip
    zeros = {
        "none": conditioning.no_zero, "start": conditioning.zero_at_start,
        "median": conditioning.zero_at_median, "drift": conditioning.slow_drift,
    }  # fmt: skip
    gauges = _gauges(
        source, how["gauges"], how["rosettes"], kind=how["rosette_kind"], measure=how["measure"],
        modulus=how["modulus"] * GPa,
    )  # fmt: skip
    return Plan(
        gauges=gauges, curve=_curve(how["sn"], how["miner"], how["scatter"]),
        correction=_correction(how["mean_stress"], how["ultimate"], how["sensitivity"]),
        rule=rules[how["residue"]], baseline=zeros[how["zero"]], low_pass=how["low_pass"],
        allowed=how["allowed"], gauge_error=how["gauge_error"],
    )  # fmt: skip


def _shaft(source: Any, **how: Any) -> Any:
    """Return the shaft's rotation: measured, counted, or found in a gauge."""
    shaft = _rotation(source, speed=how["speed"], tacho=how["tacho"], pulses=how["pulses"])
    if shaft is None and how["estimate_speed"]:
        from cardan.fatigue.orders import estimated_rotation

        signal = source.whole([how["estimate_speed"]])[0]
        return estimated_rotation(signal, rate=source.rate)
    return shaft


def _listened(source: Any, plan: Any, tell: Callable[[str, float], None], **how: Any) -> Any:
    """Return the lives at the gauges, and their causes where a speed tells them apart."""
    from cardan.fatigue import life as room
    from cardan.fatigue.cause import separation, suspects

    healths = room.look(source, channels=plan.channels, progress=tell)
    shaft, ratio, radius = _shaft(source, **how), how["axle_ratio"], how["radius"]
    distance = math.nan
    if shaft is not None and ratio and radius:
        distance = float(shaft.turns[-1] - shaft.turns[0]) / ratio * _TURN * radius
    lives = room.life(source, plan=plan, healths=healths, distance=distance, progress=tell)
    if shaft is None:
        return lives, None
    engine = _rotation(source, speed=how["engine"], tacho=None, pulses=1)
    named = suspects(
        shaft, joint_orders=_numbers(how["joint_orders"]), engine=engine,
        engine_orders=_numbers(how["engine_orders"]),
        wheel=shaft.geared(1 / ratio) if ratio else None,
    )  # fmt: skip
    torque = None
    if how["torque"]:
        channel, given = _named(how["torque"])
        torque = (channel, _unit(source, channel, given, _TORQUE))
    causes = room.causes(
        source, plan=plan, healths=healths, how=separation(named, rate=source.rate),
        torque=torque, predicted=_predictions(how), progress=tell,
    )  # fmt: skip
    return lives, causes


@dataclass(frozen=True, kw_only=True)
class Heard:
    """A recording, what was counted in it, the lives at its gauges, and their causes."""

    recording: Any
    plan: Any
    lives: list[Any]
    causes: Any


def asked(path: str | Path, **options: Any) -> Heard:
    """Return what a recording tells a script, with the options of the command.

    `gauge=["bracket:MPa"], sn="90,2e6,5", low_pass_Hz=400`: their names with _ for -, lists
    where an option may be repeated, numbers where it has commas between them.
    """
    several = {p.opts[0] for p in life.params if getattr(p, "multiple", False)}
    said: list[str] = []
    for name, value in options.items():
        option = f"--{name.replace('_', '-')}"
        each = value if option in several and not isinstance(value, str) else [value]
        for one in each:
            text = one if isinstance(one, str | Path) else _commas(one)
            said += [option] if one is True else [option, str(text)]
    try:
        how = life.make_context("life", [*said, "--", str(path)]).params
    except click.ClickException as error:
        raise CardanError(error.format_message()) from error

    def silent(name: str, seconds: float, total: float | None) -> None:
        """Tell nobody."""

    return heard(how.pop("recording"), silent, **how)


def _commas(value: Any) -> str:
    """Return a number, or numbers with commas between."""
    return ",".join(map(str, value)) if hasattr(value, "__iter__") else str(value)


def heard(path: Path, tell: Callable[[str, float, float | None], None], **how: Any) -> Heard:
    """Return what a recording tells; `how` are the parameters of the command.

    `tell` takes what is being done, how many seconds are, and of how many, where that is
    known.
    """
    from cardan.files.recordings import open_recording

    source = open_recording(path, rate=how["rate"], time=how["time"], group=how["group"])
    if not how["gauges"] and not how["rosettes"]:
        msg = f"name the gauges with --gauge; {path.name} has {', '.join(source.names)}"
        raise ValueError(msg)
    plan = _plan(source, **how)
    total = source.samples / source.rate if source.samples else None
    lives, causes = _listened(source, plan, lambda name, s: tell(name, s, total), **how)
    return Heard(recording=source, plan=plan, lives=lives, causes=causes)


def _run(path: Path, **how: Any) -> list[Any]:
    from cardan.report import life as report

    with progress("reading", quiet=how["quiet"]) as line:

        def tell(name: str, seconds: float, total: float | None) -> None:
            line.at(f"{name} {seconds / total:.0%}" if total else f"{name} {seconds:.0f} s")

        found = heard(path, tell, **how)
    source, plan, lives, causes = found.recording, found.plan, found.lives, found.causes
    if how["json_out"] is not None:
        write_json(report.contract(source, plan=plan, lives=lives, causes=causes), how["json_out"])
    if how["json_out"] != "-":
        put_lines(report.lines(source, plan=plan, lives=lives, causes=causes))
    if how["plot"]:
        _draw(how["plot"], recording=source, lives=lives, causes=causes)
    return lives

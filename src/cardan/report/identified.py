"""What a recording says of its application: terminal and JSON."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from cardan.base.units import MPa
from cardan.fatigue.background import Mode
from cardan.fatigue.damage import Life
from cardan.report.language import EN, Language
from cardan.report.terminal import columns
from cardan.study.identification import Departure, Identification, Parameter
from cardan.study.promise import Promised
from cardan.study.recording import Heard

NAMES = {
    "vertical": "vertical stiffness",
    "lateral": "lateral stiffness",
    "loss": "loss factor",
    "phase": "yoke phase",
    "gain": "measured over computed stress",
    "mode": "mode of the bracket",
    "mode damping": "damping of that mode",
    "unbalance": "unbalance at the rear end",
}
"""What the numbers are called."""


def parameter(of: Parameter, say: Language) -> tuple[str, ...]:
    """Return a number as a row: name, part, as written, as found, its interval, what of it."""

    def told(value: float) -> str:
        return "-" if math.isnan(value) else say.short(of.told_in_unit(value), 4)

    name = say(NAMES[of.name]) + (f" [{of.unit}]" if of.unit else "")
    where = say("bracket") if of.name.startswith("mode") else say.part(of.part)
    if of.told:
        said = say("otherwise than written") if of.differs else (
            say("as written") if not math.isnan(of.was) else ""
        )  # fmt: skip
    elif of.assumed:
        said = say("more assumed than told") if not of.differs else (
            say("otherwise than written, but more assumed than told")
        )  # fmt: skip
    else:
        return name, where, told(of.was), "-", "-", say("not told by this recording")
    between = say("{low} to {high}", low=told(of.low), high=told(of.high))
    return name, where, told(of.was), told(of.value), between, said


WAYS = "along the shaft", "sideways", "vertical"
"""Ways of a force on the bearing."""

ROAD = "mode that road and engine shake"
DAMPING = "its damping ratio"


def modes(of: Identification, say: Language) -> list[tuple[str, ...]]:
    """Return what is felt beside the orders as rows like those of numbers."""
    if not of.shaken:
        return [(say(ROAD) + " [Hz]", "-", "-", "-", "-", say("not told by this recording"))]
    return [row for mode in of.shaken for row in _mode(of, mode, say)]


def _mode(of: Identification, mode: Mode, say: Language) -> Iterator[tuple[str, ...]]:
    """Yield a mode's frequency, with what may be known of it, and its damping."""
    felt = ", ".join(g for g, one in zip(of.gauges, mode.felt, strict=True) if one)
    way, line = of.way(mode), of.line(mode)
    remarks = [] if way is None else [say("felt as a force {way}", way=say(WAYS[way]))]
    if line is not None:
        remarks.append(say("the line on its rubber, {hertz} Hz?", hertz=say.short(line, 3)))
    for name, (low, found, high), remark in (
        (say(ROAD) + " [Hz]", mode.frequency, "; ".join(remarks)),
        (say(DAMPING), mode.damping, ""),
    ):
        between = say("{low} to {high}", low=say.short(low, 3), high=say.short(high, 3))
        yield name, felt, "-", say.short(found, 3), between, remark


def doubts(of: Identification, say: Language) -> list[str]:
    """Return why nothing is told, a sentence each."""
    return [say("nothing is told: {doubt}", doubt=say.said(doubt)) for doubt in of.doubts]


def unkept(say: Language) -> str:
    """Return that of a line of which nothing is told no change is foretold."""
    return say("nothing is promised of the changed line")


def lines(of: Identification, say: Language = EN) -> Iterator[str]:
    """Yield what a recording says of its application as lines of text."""
    yield say(
        "{application}, {state}: order 2 as recorded against computed",
        application=of.application.title, state=say.state(of.state),
    )  # fmt: skip
    before, after = (say.number(100 * m) for m in of.misfit)
    yield say(
        "  unexplained of its energy: {before} % as written, {after} % as identified",
        before=before, after=after,
    )  # fmt: skip
    yield from (f"  {line}" for line in doubts(of, say))
    head = (say("number"), say("of"), say("written"), say("found"), say("90 % interval"), "")
    rows = [head, *(parameter(p, say) for p in of.parameters), *modes(of, say)]
    yield from (f"  {line}" for line in columns(rows, words=(0, 1, 5)))


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def document(of: Identification) -> dict[str, Any]:
    """Return what was found as the JSON contract has it; null is not known."""
    at = of.cuts.windows
    return {
        "application": of.application.title,
        "state": of.state,
        "centre_bearing": of.bearing,
        "unexplained": {"written": of.misfit[0], "found": of.misfit[1]},
        "doubts": [str(doubt) for doubt in of.doubts],
        "parameters": [
            {
                "name": NAMES[p.name],
                "part": str(p.part),
                "unit": p.unit or None,
                "written": _number(p.told_in_unit(p.was)),
                "found": _number(p.told_in_unit(p.value)) if p.told else None,
                "interval": [p.told_in_unit(p.low), p.told_in_unit(p.high)] if p.told else None,
                "otherwise": p.otherwise,
                "assumed": [p.told_in_unit(v) for v in (p.value, p.low, p.high)]
                if p.assumed
                else None,
                "address": p.address or None,
            }
            for p in of.parameters
        ],
        "modes": [
            {
                "frequency_Hz": m.frequency[1],
                "interval_Hz": [m.frequency[0], m.frequency[2]],
                "damping": m.damping[1],
                "damping_interval": [m.damping[0], m.damping[2]],
                "gauges": [g for g, felt in zip(of.gauges, m.felt, strict=True) if felt],
                "shape": list(m.shape),
                "way": None if (way := of.way(m)) is None else WAYS[way],
                "line_Hz": of.line(m),
            }
            for m in of.shaken
        ],
        "orders": [
            {
                "gauge": gauge,
                "order": order,
                "windows": [
                    {
                        "time_s": at.time[w],
                        "rpm": at.speed[w] * 60,
                        "torque_Nm": of.torque[w],
                        "measured_MPa": _number(abs(of.cuts.amplitude[g, k, w]) / MPa),
                        "measured_deg": _number(np.angle(of.cuts.amplitude[g, k, w], deg=True)),
                        "noise_MPa": _number(of.cuts.noise[g, k, w] / MPa),
                        "written_MPa": _number(abs(of.written[g, k, w]) / MPa),
                        "written_deg": _number(np.angle(of.written[g, k, w], deg=True)),
                        "found_MPa": _number(abs(of.found[g, k, w]) / MPa),
                        "found_deg": _number(np.angle(of.found[g, k, w], deg=True)),
                    }
                    for w in range(at.time.size)
                ],
            }
            for g, gauge in enumerate(of.gauges)
            for k, order in enumerate(of.cuts.orders)
        ],
    }


def kept(of: Heard, say: Language = EN) -> Iterator[str]:
    """Yield what a changed line promises as lines of text."""
    yield say("Driven so with the changed line")
    yield from (f"  {line}" for line in columns(promise(of.promised, say), words=(0,)))
    yield from (f"  {line}" for line in departed(of.departures, say))


def departed(of: Sequence[Departure], say: Language) -> Iterator[str]:
    """Yield where a changed line is not what was found, a sentence each."""
    for one in of:
        p, unit = one.found, f" {one.found.unit}".rstrip()
        low, found, high = (say.short(p.told_in_unit(v), 4) for v in (p.low, p.value, p.high))
        own = say("not given")
        if not math.isnan(one.value):
            own = say.short(p.told_in_unit(one.value), 4) + unit
        yield say(
            "{name} of {part}: in the changed application {value}, in the recording {found}{unit} "
            "({low} to {high})",
            name=say(NAMES[p.name]), part=say.part(p.part), value=own, found=found, unit=unit,
            low=low, high=high,
        )  # fmt: skip
    if of:
        yield say(
            "unless these are the change that is meant, the promise is of another line: write the "
            "change into the application as --corrected writes it"
        )


def promise(of: Sequence[Promised], say: Language) -> list[tuple[str, ...]]:
    """Return what a changed line promises as rows, their heads first."""

    def long(life: Life) -> str:
        return say.short(life.hours, 4) if math.isfinite(life.hours) else say("no end")

    head = (say("gauge"), say("damage"), say("with the change"), say("hours"),
            say("with the change"))  # fmt: skip
    return [head] + [
        (p.gauge, say.small(p.recorded.damage, 4), say.small(p.changed.damage, 4),
         long(p.recorded), long(p.changed))
        for p in of
    ]  # fmt: skip


def departing(of: Sequence[Departure]) -> list[dict[str, Any]]:
    """Return where a changed line is not what was found as the JSON contract has it."""
    return [
        {
            "name": NAMES[one.found.name], "part": str(one.found.part),
            "unit": one.found.unit or None, "found": one.found.told_in_unit(one.found.value),
            "interval": [one.found.told_in_unit(v) for v in (one.found.low, one.found.high)],
            "changed": _number(one.found.told_in_unit(one.value)), "address": one.found.address,
        }
        for one in of
    ]  # fmt: skip


def promises(of: Sequence[Promised]) -> list[dict[str, Any]]:
    """Return what a changed line promises as the JSON contract has it; null lasts for ever."""
    return [
        {
            "gauge": p.gauge, "damage_recorded": _number(p.recorded.damage),
            "hours_recorded": _number(p.recorded.hours), "damage": _number(p.changed.damage),
            "hours": _number(p.changed.hours),
        }
        for p in of
    ]  # fmt: skip

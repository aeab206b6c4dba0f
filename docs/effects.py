"""Tables of docs/method.md: how much each effect changes the force on a centre bearing.

Each effect is a change of an example's text; the numbers are those of `cardan check` on the text so
changed. Rubber is linear unless a row says otherwise.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from cardan import check
from cardan.application import reader
from cardan.approval.approval import Approval
from cardan.model.application import Application

EXAMPLES = Path(__file__).parents[1] / "examples"
Change = tuple[str, str]
"""A pattern in an application's text, and what replaces each match."""

BEARING = "from_rear_joint_mm"
LINEAR: Change = (BEARING, f"travel_mm: 60, {BEARING}")
"""A stop that no linear rubber of the examples reaches."""
RIGID: Change = (r", vertical_stiffness_N_mm: [\d.]+, lateral_stiffness_N_mm: [\d.]+", "")
NO_SQUAT: Change = (r"( +)windup_stiffness_kNm_deg", r"\1squat: false\n\1windup_stiffness_kNm_deg")
NO_WINDUP: Change = (r"windup_stiffness_kNm_deg: \d+", "windup_stiffness_kNm_deg: 1000000")
NO_TWIST: Change = (r"\n( +)- (tube: [^\n]+)", r"\n\1- \2\n\1  tube_length_mm: 5")


def rubber(**keys: float) -> Change:
    """Return the change that adds keys to every centre bearing."""
    written = "".join(f"{key}: {value:g}, " for key, value in keys.items())
    return BEARING, written + BEARING


def stiffness(factor: float) -> Change:
    """Return the change of the refuse collector's rubber by a factor."""
    old = "vertical_stiffness_N_mm: 200, lateral_stiffness_N_mm: 120"
    return (
        old,
        f"vertical_stiffness_N_mm: {200 * factor:g}, lateral_stiffness_N_mm: {120 * factor:g}",
    )


def gvw(keys: str) -> Change:
    """Return the change that adds keys to the laden state."""
    return r"\n  - gvw\n", f"\n  - {{name: gvw, kind: gvw, {keys}}}\n"


PARTS: Mapping[str, tuple[Change, ...]] = {
    "rigid bearings": (RIGID,),
    "on linear rubber, $\\eta$ 0.1 assumed": (LINEAR,),
    "the same, an axle that does not squat": (LINEAR, NO_SQUAT),
    "the same, an axle that does not wind up": (LINEAR, NO_WINDUP),
    "the same, shafts that torque does not twist": (LINEAR, NO_TWIST),
    "the same, $\\eta$ 0.05": (LINEAR, rubber(loss_factor=0.05)),
    "the same, $\\eta$ 0.2": (LINEAR, rubber(loss_factor=0.2)),
    "with a stop at 15 mm, 5 times as stiff": (rubber(stop_stiffness_ratio=5, travel_mm=15),),
    "with a stop at 15 mm, 20 times as stiff": (rubber(stop_stiffness_ratio=20, travel_mm=15),),
}
"""Rows of the first table, by what is computed."""

TRUCKS = {
    "medium truck": ("medium-truck-4x2", 1),
    "refuse collector, bearing 2": ("refuse-collector-6x2", 2),
    "tandem": ("tandem-6x4", 1),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect:
    """A row of the second table: what changes, the values to show, and what the verdict does."""

    change: tuple[Change, ...]
    shows: tuple[tuple[str, str], ...]
    """Name to print and quantity; the state is the laden one, or all after a star."""
    in_the_verdict: str
    on: tuple[Change, ...] = (LINEAR,)


DYNAMIC, PEAK = ("dynamic", "centre_bearing_dynamic"), ("peak", "centre_bearing_peak")
MEAN = ("mean", "centre_bearing_static")
EFFECTS: Mapping[str, Effect] = {
    "frame sags by 10 mm at bearing 2": Effect(
        change=(gvw("bearing_offset_mm: {2: [0, -10]}"),), shows=(DYNAMIC, PEAK),
        in_the_verdict="with a state's `bearing_offset_mm`",
    ),
    "frame twists by 10 mm sideways there": Effect(
        change=(gvw("bearing_offset_mm: {2: [10, 0]}"),), shows=(DYNAMIC, PEAK),
        in_the_verdict="the same",
    ),
    "gearbox slope + 0.5° with the frame": Effect(
        change=(("gearbox_slope: {side_deg: 4.0}", "gearbox_slope: {side_deg: 4.5}"),),
        shows=(DYNAMIC, PEAK), in_the_verdict="with a state's own geometry",
    ),
    "rubber hot, 0.7 of its stiffness": Effect(
        change=(stiffness(0.7),),
        shows=(DYNAMIC, ("thrust over critical", "spline_compression_utilisation")),
        in_the_verdict="named if it worsens the verdict",
    ),
    "rubber cold, twice its stiffness": Effect(
        change=(stiffness(2),), shows=(DYNAMIC, ("largest peak", "*centre_bearing_peak")),
        in_the_verdict="the same",
    ),
    "stop of the rubber at 15 mm, 20 times as stiff": Effect(
        change=(rubber(stop_stiffness_ratio=20, travel_mm=15),), on=(), shows=(DYNAMIC, PEAK),
        in_the_verdict="solved; a lower bound if thrust alone reaches the stop",
    ),
    "spline friction 0.11 instead of 0.08": Effect(
        change=(("friction: 0.08", "friction: 0.11"),), shows=(MEAN, PEAK),
        in_the_verdict="`friction` of the spline",
    ),
    "tyres hold 5 % less": Effect(
        change=(("friction: 0.8 ", "friction: 0.76 "),), shows=(MEAN, PEAK),
        in_the_verdict="`friction` of the tyre",
    ),
    "last joint 10 mm to the right, as by a rolling axle": Effect(
        change=(("3350, -40,", "3350, -30,"),), shows=(DYNAMIC,), in_the_verdict="left out",
    ),
    "balance grade G40 instead of G16": Effect(
        change=(("balance_grade: G16", "balance_grade: G40"),),
        shows=(("largest peak", "*centre_bearing_peak"),), in_the_verdict="`balance_grade`",
    ),
    "yokes' inertia, 0.025 kg·m² each": Effect(
        change=((r"( +)balance_grade", r"\1yoke_inertia_kgm2: [0.025, 0.025]\n\1balance_grade"),),
        shows=(DYNAMIC,), in_the_verdict="0 without `yoke_inertia_kgm2`",
    ),
}  # fmt: skip
"""Rows of the second table: the refuse collector, bearing 2."""


def changed_text(example: str, changes: tuple[Change, ...]) -> str:
    """Return an example's text with changes; ValueError if one finds nothing to replace."""
    text = (EXAMPLES / f"{example}.yaml").read_text(encoding="utf-8")
    for pattern, new in changes:
        text, count = re.subn(pattern, new, text)
        if not count:
            msg = f"{example}: {pattern!r} is not in the file"
            raise ValueError(msg)
    return text


def changed(example: str, changes: tuple[Change, ...]) -> Application:
    """Return an example with changes of its text."""
    return reader.loads(changed_text(example, changes), folder=EXAMPLES)


def largest(found: Approval, quantity: str, bearing: int) -> float:
    """Return the largest value of a bearing or the line, laden; after a star, of every state."""
    name = quantity.removeprefix("*")
    values = [
        c.value
        for c in found.checks
        if c.quantity == name
        and (c.when.name == "gvw" or name != quantity)
        and (c.part.kind != "centre bearing" or c.part.number == bearing)
    ]
    return max(values)


def parts_table() -> str:
    """Return the largest dynamic force of each model on each truck, laden, in N."""
    rows = [f"| laden, N | {' | '.join(TRUCKS)} |", "|---|" + "---:|" * len(TRUCKS)]
    for name, changes in PARTS.items():
        found = (
            largest(check(changed(file, changes)), "centre_bearing_dynamic", bearing)
            for file, bearing in TRUCKS.values()
        )
        rows.append(f"| {name} | {' | '.join(f'{value:.0f}' for value in found)} |")
    return "\n".join(rows)


def effects_table() -> str:
    """Return each effect with the values before and after it."""
    file, bearing = TRUCKS["refuse collector, bearing 2"]
    linear = check(changed(file, (LINEAR,)))
    rows = ["| effect | size, forces in N | in the verdict |", "|---|---|---|"]
    for name, effect in EFFECTS.items():
        found = check(changed(file, (*effect.on, *effect.change)))
        sizes = (
            f"{word} {_shown(largest(linear, q, bearing))} → {_shown(largest(found, q, bearing))}"
            for word, q in effect.shows
        )
        rows.append(f"| {name} | {', '.join(sizes)} | {effect.in_the_verdict} |")
    return "\n".join(rows)


def _shown(value: float) -> str:
    return f"{value:.0f}" if value >= 10 else f"{value:.2f}"

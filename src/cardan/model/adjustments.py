"""What a workshop can move of a line, declared once: how far, in which steps, what it does.

The file's `adjust` table, `fix`, the sensitivities, the JSON contract and the words of
reports read these declarations.
"""

import re
from collections.abc import Callable, Iterable
from typing import Literal

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import deg, mm, percent
from cardan.model.application import PermittedAdjustment
from cardan.model.parts import Line


@dataclass(frozen=True, slots=True, kw_only=True)
class AdjustmentAmounts:
    """How far things of a line are moved, in V variants; filled by each movable thing.

    Attributes
    ----------
    bearing_shift : (V, 1, n-2, 3) m
        Of each centre bearing.
    shim : (V, 1) rad
        Turn of the axle on its springs, the pinion's nose rising.
    input_axle_shim : (V, 1) rad
        The same of the axle that the line leaves, if it leaves one.
    phases : (V, 1, n-1) rad
        Yoke phases added to those installed.
    stiffness_increase : (V, 1) 1
        Share by which the rubber of all centre bearings is stiffer.
    loss_factor_increase : (V, 1) 1
        Share by which its loss factor is higher.
    bearing_offset_increase : (V, 1) m
        How much farther ahead of their rear joints all centre bearings sit.
    """

    bearing_shift: FloatArray
    shim: FloatArray
    input_axle_shim: FloatArray
    phases: FloatArray
    stiffness_increase: FloatArray
    loss_factor_increase: FloatArray
    bearing_offset_increase: FloatArray

    @classmethod
    def zero(cls, line: Line, *, variants: int) -> "AdjustmentAmounts":
        """Return what moves nothing of a line."""
        joints = line.joint_count
        return cls(
            bearing_shift=np.zeros((variants, 1, joints - 2, 3)),
            shim=np.zeros((variants, 1)),
            input_axle_shim=np.zeros((variants, 1)),
            phases=np.zeros((variants, 1, joints - 1)),
            stiffness_increase=np.zeros((variants, 1)),
            loss_factor_increase=np.zeros((variants, 1)),
            bearing_offset_increase=np.zeros((variants, 1)),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Adjustment:
    """A kind of thing that may be moved. Lengths in m, angles in rad.

    `apply` enters the amounts (V,) of one part, from 1, into what is moved; `count` is how
    many parts a line has. `default_range` is how far it may go if not given: engineering judgement,
    assumed. `extremes_only` marks what is set at the ends of its range, not between;
    `explicit_only` what takes other parts, so that it moves only where the file says so.
    """

    key: str
    description: str
    """What the file's key is for."""
    subject: Literal["centre bearing", "axle", "shaft", "line"]
    dimension: Literal["length", "angle", "share"]
    count: Callable[[Line], int]
    apply: Callable[[AdjustmentAmounts, int, FloatArray], None]
    default_range: tuple[float, float]
    probe_step: float
    """How far it is moved to see what that does."""
    available_range: Callable[[Line], tuple[float, float]] = lambda _: (-np.inf, np.inf)
    """How far a line lets it go."""
    resolution: float = 0.0
    """Steps a workshop sets if not given: packing plates, wedges. Engineering judgement,
    assumed; 0: any."""
    extremes_only: bool = False
    explicit_only: bool = False
    label: str
    """What moves, in few words, with {part}."""
    increase_text: str
    decrease_text: str
    """What moving it up or down its range is called, with {part} and {amount}."""
    shows_sign: bool = False
    """Whether words give the amount with its sign."""

    @property
    def unit(self) -> str:
        """The unit amounts are shown in, as a key of the file ends."""
        return {"length": "mm", "angle": "deg", "share": "percent"}[self.dimension]

    @property
    def unit_value(self) -> float:
        """SI value of one of that unit."""
        return {"length": mm, "angle": deg, "share": percent}[self.dimension]


def _shift(axis: int) -> Callable[[AdjustmentAmounts, int, FloatArray], None]:
    def move(moved: AdjustmentAmounts, part: int, amount: FloatArray) -> None:
        moved.bearing_shift[:, 0, part - 1, axis] = amount

    return move


def _shim(moved: AdjustmentAmounts, part: int, amount: FloatArray) -> None:
    del part  # an axle has one
    moved.shim[:, 0] = amount


def _turn(moved: AdjustmentAmounts, part: int, amount: FloatArray) -> None:
    moved.phases[:, 0, part - 1] += amount


def _stiffen(moved: AdjustmentAmounts, part: int, amount: FloatArray) -> None:
    del part  # the mounts of a line are bought alike
    moved.stiffness_increase[:, 0] = amount


def _damp(moved: AdjustmentAmounts, part: int, amount: FloatArray) -> None:
    del part
    moved.loss_factor_increase[:, 0] = amount


def _bring_ahead(moved: AdjustmentAmounts, part: int, amount: FloatArray) -> None:
    del part
    moved.bearing_offset_increase[:, 0] = amount


def _hung_on_rubber(line: Line) -> int:
    return int(any(s.centre_bearing and s.centre_bearing.stiffness for s in line.shafts))


def _set_ahead(line: Line) -> int:
    """One where every centre bearing has room to come nearer its joint."""
    places = [s.centre_bearing.from_rear_joint for s in line.shafts if s.centre_bearing]
    return int(bool(places) and all(np.min(place) > 0 for place in places))


def _along_its_shaft(line: Line) -> tuple[float, float]:
    """Not past its joint, nor into the first tenth of its shaft."""
    hung = [(s.length, s.centre_bearing.from_rear_joint) for s in line.shafts if s.centre_bearing]
    back = min(float(np.min(place)) for _, place in hung)
    forth = min(float(np.min(0.9 * np.asarray(length) - place)) for length, place in hung)
    return -back, max(forth, 0.0)


_DECLARED = (
    Adjustment(
        key="bearing_height",
        description="centre bearings, up positive",
        subject="centre bearing",
        dimension="length",
        count=lambda line: len(line.shafts) - 1,
        apply=_shift(2),
        default_range=(-30 * mm, 30 * mm),
        probe_step=10 * mm,
        resolution=5 * mm,
        label="vertical position of bearing {part}",
        increase_text="bearing {part} up {amount} mm",
        decrease_text="bearing {part} down {amount} mm",
    ),
    Adjustment(
        key="bearing_side",
        description="centre bearings, to the right positive",
        subject="centre bearing",
        dimension="length",
        count=lambda line: len(line.shafts) - 1,
        apply=_shift(1),
        default_range=(-30 * mm, 30 * mm),
        probe_step=10 * mm,
        resolution=5 * mm,
        label="lateral position of bearing {part}",
        increase_text="bearing {part} to the right {amount} mm",
        decrease_text="bearing {part} to the left {amount} mm",
    ),
    Adjustment(
        key="shim",
        description="axle, pinion nose up positive",
        subject="axle",
        dimension="angle",
        count=lambda _: 1,
        apply=_shim,
        default_range=(-3 * deg, 3 * deg),
        probe_step=1 * deg,
        resolution=0.5 * deg,
        label="shim of the axle",
        increase_text="pinion angle {amount}° (shim)",
        decrease_text="pinion angle {amount}° (shim)",
        shows_sign=True,
    ),
    Adjustment(
        key="phase",
        description="yoke phases, counted from those installed",
        subject="shaft",
        dimension="angle",
        count=lambda line: len(line.shafts),
        apply=_turn,
        default_range=(0.0, 90 * deg),
        probe_step=90 * deg,
        extremes_only=True,
        shows_sign=True,
        label="phase of shaft {part}",
        increase_text="rear yoke of shaft {part} turned {amount} deg",
        decrease_text="rear yoke of shaft {part} turned {amount} deg",
    ),
    Adjustment(
        key="twist",
        description="yokes welded at any angle, counted from those installed",
        subject="shaft",
        dimension="angle",
        count=lambda line: len(line.shafts),
        apply=_turn,
        default_range=(-90 * deg, 90 * deg),
        probe_step=15 * deg,
        resolution=1 * deg,
        explicit_only=True,
        shows_sign=True,
        label="weld of the rear yoke of shaft {part}",
        increase_text="rear yoke of shaft {part} welded {amount} deg on",
        decrease_text="rear yoke of shaft {part} welded {amount} deg on",
    ),
    Adjustment(
        key="bearing_stiffness",
        description="all rubber, stiffer positive",
        subject="line",
        dimension="share",
        count=_hung_on_rubber,
        apply=_stiffen,
        default_range=(-0.5, 1.0),
        probe_step=0.3,
        resolution=0.05,
        explicit_only=True,
        label="stiffness of all rubber",
        increase_text="rubber of all bearings stiffer by {amount} %",
        decrease_text="rubber of all bearings softer by {amount} %",
    ),
    Adjustment(
        key="bearing_loss",
        description="loss factor of all rubber, higher positive",
        subject="line",
        dimension="share",
        count=_hung_on_rubber,
        apply=_damp,
        default_range=(-0.5, 1.0),
        probe_step=0.5,
        resolution=0.05,
        explicit_only=True,
        label="loss factor of all rubber",
        increase_text="rubber of all bearings with {amount} % more loss factor",
        decrease_text="rubber of all bearings with {amount} % less loss factor",
    ),
    Adjustment(
        key="bearing_place",
        description="all centre bearings, away from their rear joints positive",
        subject="line",
        dimension="length",
        count=_set_ahead,
        apply=_bring_ahead,
        default_range=(-50 * mm, 50 * mm),
        available_range=_along_its_shaft,
        probe_step=25 * mm,
        resolution=5 * mm,
        explicit_only=True,
        label="place of all bearings",
        increase_text="all bearings {amount} mm farther from their rear joints",
        decrease_text="all bearings {amount} mm nearer their rear joints",
    ),
)

ADJUSTMENTS: dict[str, Adjustment] = {m.key: m for m in _DECLARED}
"""The declarations by key, in the order of the file's table."""


def permitted_adjustments_by_name(lines: Iterable[Line]) -> dict[str, PermittedAdjustment]:
    """Return what can be moved of lines by its name: the key of `adjust`, and which part.

    `bearing_height_mm[1]`, `shim_deg`; of several lines `front.shim_deg`.
    """
    lines = tuple(lines)
    found: dict[str, PermittedAdjustment] = {}
    for line in lines:
        for m in ADJUSTMENTS.values():
            for part in range(1, m.count(line) + 1):
                name = f"{m.key}_{m.unit}" + ("" if m.subject in ("axle", "line") else f"[{part}]")
                found[f"{line.name}.{name}" if len(lines) > 1 else name] = PermittedAdjustment(
                    adjustment_key=m.key,
                    part=part,
                    low=m.default_range[0],
                    high=m.default_range[1],
                    line=line.name,
                    step=m.resolution,
                )
    return found


def known_names_matching_pattern(name: str, known: Iterable[str]) -> list[str]:
    """Return which of the known names one stands for; `[*]` stands for every part."""
    if "[*]" not in name:
        return [k for k in known if k == name]
    pattern = re.compile(re.escape(name).replace(r"\[\*\]", r"\[\d+\]"))
    return [k for k in known if pattern.fullmatch(k)]


def first_known_name_matching_pattern(name: str, known: Iterable[str]) -> str:
    """Return the known name one stands for; of several parts the first, however they are listed.

    Raises
    ------
    ValueError
        If it stands for none.
    """
    return min(
        known_names_matching_pattern(name, known),
        key=lambda one: [int(k) for k in re.findall(r"\d+", one)],
    )

"""What a workshop can move of a line, declared once: how far, in which steps, what it does.

The file's `adjust` table, `fix`, the sensitivities, the JSON contract and the words of
reports read these declarations.
"""

import re
from collections.abc import Callable, Iterable
from typing import Literal

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.frozen import dataclass
from cardan.base.units import deg, mm, percent
from cardan.model.application import Adjustable
from cardan.model.parts import Line


@dataclass(frozen=True, slots=True, kw_only=True)
class Moved:
    """How far things of a line are moved, in V variants; filled by each movable thing.

    Attributes
    ----------
    bearing_shift : (V, 1, n-2, 3) m
        Of each centre bearing.
    shim : (V, 1) rad
        Turn of the axle on its springs, the pinion's nose rising.
    shim_ahead : (V, 1) rad
        The same of the axle that the line leaves, if it leaves one.
    phases : (V, 1, n-1) rad
        Yoke phases added to those installed.
    stiffer : (V, 1) 1
        Share by which the rubber of all centre bearings is stiffer.
    lossier : (V, 1) 1
        Share by which its loss factor is higher.
    ahead : (V, 1) m
        How much farther ahead of their rear joints all centre bearings sit.
    """

    bearing_shift: FloatArray
    shim: FloatArray
    shim_ahead: FloatArray
    phases: FloatArray
    stiffer: FloatArray
    lossier: FloatArray
    ahead: FloatArray

    @classmethod
    def still(cls, line: Line, *, variants: int) -> "Moved":
        """Return what moves nothing of a line."""
        joints = line.joint_count
        return cls(
            bearing_shift=np.zeros((variants, 1, joints - 2, 3)),
            shim=np.zeros((variants, 1)),
            shim_ahead=np.zeros((variants, 1)),
            phases=np.zeros((variants, 1, joints - 1)),
            stiffer=np.zeros((variants, 1)),
            lossier=np.zeros((variants, 1)),
            ahead=np.zeros((variants, 1)),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Movable:
    """A kind of thing that may be moved. Lengths in m, angles in rad.

    `move` enters the amounts (V,) of one part, from 1, into what is moved; `count` is how
    many parts a line has. `reach` is how far it may go where nobody says: house practice,
    assumed. `choice` marks what is set at the ends of its range, not between; `fitted` what
    takes other parts, so that it moves only where the file says so.
    """

    key: str
    says: str
    """What the file's key is for."""
    of: Literal["centre bearing", "axle", "shaft", "line"]
    measure: Literal["length", "angle", "share"]
    count: Callable[[Line], int]
    move: Callable[[Moved, int, FloatArray], None]
    reach: tuple[float, float]
    step: float
    """How far it is moved to see what that does."""
    room: Callable[[Line], tuple[float, float]] = lambda _: (-np.inf, np.inf)
    """How far a line lets it go."""
    resolution: float = 0.0
    """Steps a workshop sets where nobody says others: packing plates, wedges. House practice,
    assumed; 0: any."""
    choice: bool = False
    fitted: bool = False
    called: str
    """What moves, in few words, with {part}."""
    forth: str
    back: str
    """What moving it up or down its range is called, with {part} and {amount}."""
    signed: bool = False
    """Whether words give the amount with its sign."""

    @property
    def unit(self) -> str:
        """The unit amounts are shown in, as a key of the file ends."""
        return {"length": "mm", "angle": "deg", "share": "percent"}[self.measure]

    @property
    def worth(self) -> float:
        """SI value of one of that unit."""
        return {"length": mm, "angle": deg, "share": percent}[self.measure]


def _shift(axis: int) -> Callable[[Moved, int, FloatArray], None]:
    def move(moved: Moved, part: int, amount: FloatArray) -> None:
        moved.bearing_shift[:, 0, part - 1, axis] = amount

    return move


def _shim(moved: Moved, part: int, amount: FloatArray) -> None:
    del part  # an axle has one
    moved.shim[:, 0] = amount


def _turn(moved: Moved, part: int, amount: FloatArray) -> None:
    moved.phases[:, 0, part - 1] += amount


def _stiffen(moved: Moved, part: int, amount: FloatArray) -> None:
    del part  # the mounts of a line are bought alike
    moved.stiffer[:, 0] = amount


def _damp(moved: Moved, part: int, amount: FloatArray) -> None:
    del part
    moved.lossier[:, 0] = amount


def _bring_ahead(moved: Moved, part: int, amount: FloatArray) -> None:
    del part
    moved.ahead[:, 0] = amount


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
    Movable(
        key="bearing_height", says="centre bearings, up positive",
        of="centre bearing", measure="length", count=lambda line: len(line.shafts) - 1,
        move=_shift(2), reach=(-30 * mm, 30 * mm), step=10 * mm, resolution=5 * mm,
        called="height of bearing {part}",
        forth="bearing {part} up {amount} mm", back="bearing {part} down {amount} mm",
    ),
    Movable(
        key="bearing_side", says="centre bearings, to the right positive",
        of="centre bearing", measure="length", count=lambda line: len(line.shafts) - 1,
        move=_shift(1), reach=(-30 * mm, 30 * mm), step=10 * mm, resolution=5 * mm,
        called="side of bearing {part}",
        forth="bearing {part} to the right {amount} mm",
        back="bearing {part} to the left {amount} mm",
    ),
    Movable(
        key="shim", says="axle, pinion nose up positive",
        of="axle", measure="angle", count=lambda _: 1,
        move=_shim, reach=(-3 * deg, 3 * deg), step=1 * deg, resolution=0.5 * deg,
        called="shim of the axle",
        forth="pinion nose up {amount} deg", back="pinion nose down {amount} deg",
    ),
    Movable(
        key="phase", says="yoke phases, counted from those installed",
        of="shaft", measure="angle", count=lambda line: len(line.shafts),
        move=_turn, reach=(0.0, 90 * deg), step=90 * deg, choice=True, signed=True,
        called="phase of shaft {part}",
        forth="rear yoke of shaft {part} turned {amount} deg",
        back="rear yoke of shaft {part} turned {amount} deg",
    ),
    Movable(
        key="twist", says="yokes welded at any angle, counted from those installed",
        of="shaft", measure="angle", count=lambda line: len(line.shafts),
        move=_turn, reach=(-90 * deg, 90 * deg), step=15 * deg, resolution=1 * deg,
        fitted=True, signed=True,
        called="weld of the rear yoke of shaft {part}",
        forth="rear yoke of shaft {part} welded {amount} deg on",
        back="rear yoke of shaft {part} welded {amount} deg on",
    ),
    Movable(
        key="bearing_stiffness", says="all rubber, stiffer positive",
        of="line", measure="share", count=_hung_on_rubber,
        move=_stiffen, reach=(-0.5, 1.0), step=0.3, resolution=0.05, fitted=True,
        called="stiffness of all rubber",
        forth="rubber of all bearings stiffer by {amount} %",
        back="rubber of all bearings softer by {amount} %",
    ),
    Movable(
        key="bearing_loss", says="loss factor of all rubber, higher positive",
        of="line", measure="share", count=_hung_on_rubber,
        move=_damp, reach=(-0.5, 1.0), step=0.5, resolution=0.05, fitted=True,
        called="loss factor of all rubber",
        forth="rubber of all bearings with {amount} % more loss factor",
        back="rubber of all bearings with {amount} % less loss factor",
    ),
    Movable(
        key="bearing_place", says="all centre bearings, away from their rear joints positive",
        of="line", measure="length", count=_set_ahead,
        move=_bring_ahead, reach=(-50 * mm, 50 * mm), room=_along_its_shaft, step=25 * mm,
        resolution=5 * mm, fitted=True,
        called="place of all bearings",
        forth="all bearings {amount} mm farther from their rear joints",
        back="all bearings {amount} mm nearer their rear joints",
    ),
)  # fmt: skip

MOVABLES: dict[str, Movable] = {m.key: m for m in _DECLARED}
"""The declarations by key, in the order of the file's table."""


def movable(lines: Iterable[Line]) -> dict[str, Adjustable]:
    """Return what can be moved of lines by its name: the key of `adjust`, and which part.

    `bearing_height_mm[1]`, `shim_deg`; of several lines `front.shim_deg`.
    """
    lines = tuple(lines)
    found: dict[str, Adjustable] = {}
    for line in lines:
        for m in MOVABLES.values():
            for part in range(1, m.count(line) + 1):
                name = f"{m.key}_{m.unit}" + ("" if m.of in ("axle", "line") else f"[{part}]")
                found[f"{line.name}.{name}" if len(lines) > 1 else name] = Adjustable(
                    what=m.key,
                    part=part,
                    low=m.reach[0],
                    high=m.reach[1],
                    line=line.name,
                    step=m.resolution,
                )
    return found


def meant(name: str, known: Iterable[str]) -> list[str]:
    """Return which of the known names one stands for; `[*]` stands for every part."""
    if "[*]" not in name:
        return [k for k in known if k == name]
    pattern = re.compile(re.escape(name).replace(r"\[\*\]", r"\[\d+\]"))
    return [k for k in known if pattern.fullmatch(k)]


def first(name: str, known: Iterable[str]) -> str:
    """Return the known name one stands for; of several parts the first, however they are listed.

    Raises
    ------
    ValueError
        If it stands for none.
    """
    return min(meant(name, known), key=lambda one: [int(k) for k in re.findall(r"\d+", one)])

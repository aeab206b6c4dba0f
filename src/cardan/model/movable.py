"""What a workshop can move of a line, declared once: how far, in which steps, what it does.

The file's `adjust` table, `fix`, the sensitivities, the JSON contract and the words of
reports read these declarations.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.units import deg, mm
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
    phases : (V, 1, n-1) rad
        Yoke phases added to those installed.
    """

    bearing_shift: FloatArray
    shim: FloatArray
    phases: FloatArray

    @classmethod
    def still(cls, line: Line, *, variants: int) -> "Moved":
        """Return what moves nothing of a line."""
        joints = line.joint_count
        return cls(
            bearing_shift=np.zeros((variants, 1, joints - 2, 3)),
            shim=np.zeros((variants, 1)),
            phases=np.zeros((variants, 1, joints - 1)),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Movable:
    """A kind of thing that may be moved. Lengths in m, angles in rad.

    `move` enters the amounts (V,) of one part, from 1, into what is moved; `count` is how
    many parts a line has. `reach` is how far it may go where nobody says: house practice,
    assumed. `choice` marks what is set at the ends of its range, not between.
    """

    key: str
    says: str
    """What the file's key is for."""
    of: Literal["centre bearing", "axle", "shaft"]
    measure: Literal["length", "angle"]
    count: Callable[[Line], int]
    move: Callable[[Moved, int, FloatArray], None]
    reach: tuple[float, float]
    step: float
    """How far it is moved to see what that does."""
    resolution: float = 0.0
    """Steps a workshop can set; 0: any."""
    choice: bool = False
    forth: str
    back: str
    """What moving it up or down its range is called, with {part} and {amount}."""
    signed: bool = False
    """Whether words give the amount with its sign."""

    @property
    def unit(self) -> str:
        """The unit amounts are shown in, as a key of the file ends."""
        return "mm" if self.measure == "length" else "deg"

    @property
    def worth(self) -> float:
        """SI value of one of that unit."""
        return mm if self.measure == "length" else deg


def _shift(axis: int) -> Callable[[Moved, int, FloatArray], None]:
    def move(moved: Moved, part: int, amount: FloatArray) -> None:
        moved.bearing_shift[:, 0, part - 1, axis] = amount

    return move


def _shim(moved: Moved, part: int, amount: FloatArray) -> None:
    del part  # an axle has one
    moved.shim[:, 0] = amount


def _turn(moved: Moved, part: int, amount: FloatArray) -> None:
    moved.phases[:, 0, part - 1] += amount


_DECLARED = (
    Movable(
        key="bearing_height", says="centre bearings, up positive",
        of="centre bearing", measure="length", count=lambda line: len(line.shafts) - 1,
        move=_shift(2), reach=(-30 * mm, 30 * mm), step=10 * mm, resolution=1 * mm,
        forth="bearing {part} up {amount} mm", back="bearing {part} down {amount} mm",
    ),
    Movable(
        key="bearing_side", says="centre bearings, to the right positive",
        of="centre bearing", measure="length", count=lambda line: len(line.shafts) - 1,
        move=_shift(1), reach=(-30 * mm, 30 * mm), step=10 * mm, resolution=1 * mm,
        forth="bearing {part} to the right {amount} mm",
        back="bearing {part} to the left {amount} mm",
    ),
    Movable(
        key="shim", says="axle, pinion nose up positive",
        of="axle", measure="angle", count=lambda _: 1,
        move=_shim, reach=(-3 * deg, 3 * deg), step=1 * deg, resolution=0.1 * deg,
        forth="pinion nose up {amount} deg", back="pinion nose down {amount} deg",
    ),
    Movable(
        key="phase", says="yoke phases, counted from those installed",
        of="shaft", measure="angle", count=lambda line: len(line.shafts),
        move=_turn, reach=(0.0, 90 * deg), step=90 * deg, choice=True, signed=True,
        forth="rear yoke of shaft {part} turned {amount} deg",
        back="rear yoke of shaft {part} turned {amount} deg",
    ),
)  # fmt: skip

MOVABLES: dict[str, Movable] = {m.key: m for m in _DECLARED}
"""The declarations by key, in the order of the file's table."""

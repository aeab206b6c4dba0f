"""What a quantity is: its one declaration, with how a line answers it.

Limits, tables, the JSON contract, the schema, `explain`, workbooks and documentation read
these declarations, so a quantity has one name, one unit and one value wherever it appears.
What it is called in other languages stands in the catalogues of `cardan.report.text`.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import field
from typing import Any, Literal, TypeAlias

import numpy as np

from cardan.base.arrays import BoolArray, FloatArray
from cardan.base.errors import DesignError
from cardan.base.formula import Formula
from cardan.base.frozen import dataclass
from cardan.base.part import LINE, Part
from cardan.base.source import Source
from cardan.base.units import UNITS
from cardan.base.verdict import Limit, Sense
from cardan.model.application import RIDING
from cardan.model.laminate import CompositeTube
from cardan.model.parts import JointKind, Tube
from cardan.quantity.points import Points
from cardan.quantity.response import Response

Of: TypeAlias = Callable[[Response], FloatArray]
"""Computes a quantity of a line, (..., states, parts) SI; nan where nothing is known."""
Parts: TypeAlias = Callable[[Response], tuple[Part, ...]]
Section: TypeAlias = Literal[
    "Demand", "Axle loads", "Slopes and lengths", "Joints", "Excitation", "Centre bearings",
    "Gearbox, axle and spline", "Couples and forks", "Speed and strength", "Room",
]  # fmt: skip

BY_PART = ("Axle loads", "Joints", "Centre bearings", "Couples and forks")
"""Sections that tell all of one part before the next; the others go by quantity."""

WRITTEN = {
    "1": "", "Nm": "N·m", "rad_s2": "rad/s²", "deg_min": "deg/min", "kg_m3": "kg/m³",
    "N_mm": "N/mm", "percent": "%", "per_s": "1/s",
    "Nm_rad": "N·m/rad", "kgm2": "kg·m²", "N_m": "N/m",
}  # fmt: skip
"""How people write the units whose names in keys cannot hold a slash or a dot."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Need:
    """Something an answer stands on.

    `met` tells where a line has it, (..., states, parts) or what broadcasts to that, and
    `idle` where the application says there is nothing to ask: a line that stands still.
    """

    gives: str
    """What an application gives to have it, by its keys."""
    met: Callable[[Response], BoolArray]
    idle: Callable[[Response], BoolArray] | None = None
    braked: str = ""
    """What gives it in a state that brakes wind up, where that is something else."""

    def lacking(self, r: Response, state: int) -> str:
        """Return what an application gives to have it in a state."""
        return (r.kinds[state] == "windup brake" and self.braked) or self.gives


LENGTHS = Need(gives="the length of each shaft", met=lambda r: np.array([[r.line.measured]]))
RUBBER = Need(
    gives="the stiffness of a centre bearing, and the tube of each shaft",
    met=lambda r: np.array([[r.held is not None or not r.line.measured]]),
)
"""Beside `LENGTHS`, without which nobody can tell."""


def _rated(gives: str, name: str) -> Need:
    return Need(gives=gives, met=lambda r: np.isfinite(r.rating(name)))


def _strong(tube: Tube | CompositeTube | None) -> bool:
    """Return whether somebody knows what a tube carries; of plies it is always known."""
    if isinstance(tube, CompositeTube):
        return True
    return tube is not None and tube.material.yield_strength is not None


SPEED = Need(
    gives="speed_rpm, or engine and gearbox",
    met=lambda r: np.isfinite(r.demand.speed)[..., None],
    idle=lambda r: (r.demand.speed == 0)[..., None],
)
COAST = Need(
    gives="coast_torque_Nm, or the brake torque of the engine",
    met=lambda r: np.isfinite(r.demand.coast_torque)[..., None],
)
REACH = Need(gives=SPEED.gives, met=SPEED.met)
"""How fast it turns, where what stands still is worth asking too."""
TORQUE = Need(
    gives="torque_Nm, or engine, gearbox, axle and tyre",
    braked=COAST.gives,
    met=lambda r: np.isfinite(r.demand.torque)[..., None],
    idle=lambda r: (r.demand.torque == 0)[..., None],
)
LOAD = Need(
    gives=TORQUE.gives,
    braked=TORQUE.braked,
    met=TORQUE.met,
    idle=lambda r: (
        (r.demand.torque == 0) & (r.gravity == 0) & (not r.application.include_unbalance)
    )[..., None],
)
"""Torque, or weight and unbalance where they count."""
TUBES = Need(
    gives="the tube of each shaft",
    met=lambda r: np.array([[s.tube is not None for s in r.line.shafts]]),
)
ALL_TUBES = Need(
    gives="the tube of each shaft",
    met=lambda r: np.array([[all(s.tube is not None for s in r.line.shafts)]]),
)
INERTIAS = Need(
    gives="length and tube, or polar_inertia_kgm2, of each shaft",
    met=lambda r: np.array([[r.inertias is not None]]),
)
YIELD = Need(
    gives="a tube material with its yield strength",
    met=lambda r: np.array([[_strong(s.tube) for s in r.line.shafts]]),
)
PEAK_RATING = _rated("a joint size with its peak torque", "peak_torque")
FATIGUE_RATING = _rated("a joint size with its reversing torque", "reversing_torque")
LIFE_RATING = Need(
    gives="a joint size with its life rating Td",
    met=lambda r: np.isfinite(r.life_ratings),
)


def _share_of(name: Literal["speed", "torque"], gives: str) -> Need:
    """Return the need of what a duty cycle by its name takes its points from."""
    return Need(
        gives=gives,
        met=lambda r: np.array([[all(np.isfinite(getattr(p, name)).any() for p in r.duty)]]),
    )


DUTY = (
    Need(gives="duty, or the name of a duty cycle", met=lambda r: np.array([[bool(r.duty)]])),
    _share_of("speed", SPEED.gives),
    _share_of("torque", TORQUE.gives),
)
"""A duty cycle, and what it takes its points from."""
STROKE = Need(
    gives="spline plunge_mm and draw_mm",
    met=lambda r: np.isfinite(r.spline_travel_margin)[..., None] | (not r.line.measured),
)
"""Beside `LENGTHS` as well."""
SLIDING = Need(gives="spline mean_radius_mm", met=lambda r: np.isfinite(r.spline_force)[..., None])
SPRINGS = Need(
    gives="a suspension, and the axle loads of the state",
    met=lambda r: np.isfinite(r.demand.suspension_frequency)[..., None],
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """A quantity of the field, declared once.

    `unit` is the unit it is shown in, a name of `cardan.base.units.UNITS`; inside the
    program its values are SI. `equation` is the formula that the
    function computing it comes to for symbols, or plain text that a terminal can print;
    `where` says what the symbols mean. `of` computes it for the `parts` of a line that have
    it; a quantity without is answered by another study than that of the driveline.
    """

    key: str
    name: str
    symbol: str
    unit: str
    equation: str | Formula
    source: Source
    where: dict[str, str] = field(default_factory=dict[str, str])
    use: str = ""
    """Limits of use: when the number can be trusted."""
    sense: Sense = "<="
    """Which side of a limit is safe."""
    signed: bool = False
    """Whether it has a direction: limits ask about its size."""
    parts: Parts | None = None
    of: Of | None = None
    sought: Callable[[Response], Points | None] | None = None
    """At which operating points its values stand, where it is sought over those."""
    shaken: bool = False
    """Whether it is large where an order meets a mode of the line on its rubber."""
    on_rubber: bool = False
    """Whether other rubber, or another place of a bearing, changes it."""
    at_points: bool = False
    """Whether limits ask it at every operating point of a state, not at its own alone."""
    sizes: bool = False
    """Whether it is of the engine's torque ahead, wherever the tyres slip."""
    needs: tuple[Need, ...] = ()
    states: frozenset[str] | None = None
    """Kinds of state in which it means anything; None is all."""
    rating: str = ""
    """Where a catalogue's joint brings a limit of its own, beside a profile's."""
    own_first: bool = False
    """Whether a joint's own limit takes the place of a profile's."""
    section: Section | None = None
    """Where tables show it; None where they do not."""
    quiet: bool = False
    """Whether tables leave it out where it is 0 in every state."""
    methods: Mapping[str, Of] = field(default_factory=dict[str, Of])
    """The field's approximations that tables show beside it, by name."""
    study: str = ""
    """The study that answers it, where that is not the driveline in its states."""
    contract: str = ""
    """Where the JSON contract holds it in a state: `joints.angle_deg`; "" where it does not."""

    @property
    def stated(self) -> str:
        """Its equation as plain text: of a quantity that has a letter, what that is."""
        if isinstance(self.equation, str):
            return self.equation
        lettered = not re.search("[ /²]", self.symbol)
        return f"{self.symbol} = {self.equation}" if lettered else str(self.equation)

    @property
    def formula(self) -> Formula:
        """Its equation as a formula, for who prints it of cells."""
        assert isinstance(self.equation, Formula)
        return self.equation

    @property
    def factor(self) -> float:
        """SI value of one display unit."""
        return UNITS[self.unit]

    @property
    def unit_name(self) -> str:
        """The display unit as people write it: rad/s², N·m."""
        return WRITTEN.get(self.unit, self.unit)

    def own(self, r: Response) -> tuple[Limit | None, ...]:
        """Return the limit that each joint's catalogue brings, None where it has none."""
        if not self.rating:
            return ()
        rated: list[tuple[Any, Any]] = [
            (size, getattr(size, self.rating) if size else None) for size in r.sizes
        ]
        if any(np.ndim(value) for _, value in rated):
            msg = f"{self.rating} of a joint is a limit, and limits have no variants"
            raise DesignError(msg)
        return tuple(
            Limit(quantity=self.key, maximum=value, source=size.source_of(self.rating))
            if size and value
            else None
            for size, value in rated
        )

    def of_parts(self, r: Response) -> tuple[Part, ...]:
        """Return the parts of a line that have it."""
        return self.parts(r) if self.parts else ()

    def values(self, r: Response) -> FloatArray:
        """Return its values, (..., states, parts) SI; nan where a need is not met."""
        assert self.of is not None  # asked of the driveline's own quantities
        values = self.of(r)
        for need in self.needs:
            values = np.where(need.met(r), values, np.nan)
        if self.states is None:
            return values
        meant = np.array([[kind in self.states] for kind in r.kinds])
        return np.where(meant, values, np.nan)


def line(_: Response) -> tuple[Part, ...]:
    """Return the line as a whole."""
    return (LINE,)


def hung(r: Response) -> tuple[Part, ...]:
    """Return the line, if it has a centre bearing."""
    return (LINE,) if r.line.joint_count > 2 else ()


def joints(r: Response) -> tuple[Part, ...]:
    """Return the joints, gearbox first."""
    return tuple(Part("joint", k) for k in range(1, r.line.joint_count + 1))


def of_kind(r: Response, kind: JointKind) -> list[int]:
    """Return which joints, from 0, are of a kind."""
    return [k for k, one in enumerate(r.line.kinds) if one == kind]


def _joints_of(kind: JointKind) -> Parts:
    return lambda r: tuple(Part("joint", k + 1) for k in of_kind(r, kind))


crosses, double_cardans, tripods = (
    _joints_of("cross"), _joints_of("double cardan"), _joints_of("tripod")
)  # fmt: skip


def shafts(r: Response) -> tuple[Part, ...]:
    """Return the shafts, gearbox first."""
    return tuple(Part("shaft", k) for k in range(1, r.line.joint_count))


def last_shaft(r: Response) -> tuple[Part, ...]:
    """Return the last shaft, which holds the spline."""
    return shafts(r)[-1:]


def centre_bearings(r: Response) -> tuple[Part, ...]:
    """Return the centre bearings, gearbox first."""
    return tuple(Part("centre bearing", k) for k in range(1, r.line.joint_count - 1))


def of_line(value: Callable[[Response], FloatArray]) -> Of:
    """Return how to compute a quantity of the line as a whole from values (..., states)."""
    return lambda r: value(r)[..., None]


__all__ = [
    "ALL_TUBES",
    "BY_PART",
    "COAST",
    "DUTY",
    "FATIGUE_RATING",
    "INERTIAS",
    "LENGTHS",
    "LIFE_RATING",
    "LOAD",
    "PEAK_RATING",
    "REACH",
    "RIDING",
    "SLIDING",
    "SPEED",
    "SPRINGS",
    "STROKE",
    "TORQUE",
    "TUBES",
    "WRITTEN",
    "YIELD",
    "Need",
    "Of",
    "Parts",
    "Quantity",
    "Section",
    "centre_bearings",
    "crosses",
    "double_cardans",
    "hung",
    "joints",
    "last_shaft",
    "line",
    "of_kind",
    "of_line",
    "shafts",
    "tripods",
]  # fmt: skip

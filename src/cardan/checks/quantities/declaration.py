"""What a quantity is: its one declaration, with how a line answers it.

Limits, tables, the JSON contract, the schema, `explain`, workbooks and documentation read
these declarations, so a quantity has one name, one unit and one value wherever it appears.
What it is called in other languages stands in the catalogues of `cardan.render.locales`.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import field
from typing import Any, Literal, TypeAlias

import numpy as np

from cardan.checks.line_response import LineResponse
from cardan.core.arrays import ArrayLike, BoolArray, FloatArray
from cardan.core.errors import DesignError
from cardan.core.labels import WHOLE_LINE, Part
from cardan.core.lazy_dataclass import dataclass
from cardan.core.provenance import Source
from cardan.core.symbolic import Expression
from cardan.core.units import UNITS
from cardan.core.verdict import MARGIN_TOLERANCE, Limit, LimitSense
from cardan.model.application import STATE_KINDS_AT_LOADED_RIDE_HEIGHT
from cardan.model.laminate import CompositeTube
from cardan.model.parts import JointKind, Tube
from cardan.physics.vehicle.operating_points import LineOperatingPoints

QuantityFunction: TypeAlias = Callable[[LineResponse], FloatArray]
"""Computes a quantity of a line, (..., states, parts) SI; nan where nothing is known."""
PartSelector: TypeAlias = Callable[[LineResponse], tuple[Part, ...]]
ReportTableSection: TypeAlias = Literal[
    "Demand", "Axle loads", "Slopes and lengths", "Joints", "Excitation", "Centre bearings",
    "Gearbox, axle and spline", "Couples and forks", "Speed and strength", "Room",
]  # fmt: skip

SECTIONS_GROUPED_BY_PART = ("Axle loads", "Joints", "Centre bearings", "Couples and forks")
"""Sections that list all of one part before the next; the others go by quantity."""

UNIT_SYMBOLS = {
    "1": "", "Nm": "N·m", "rad_s2": "rad/s²", "deg_min": "deg/min", "kg_m3": "kg/m³",
    "N_mm": "N/mm", "percent": "%", "per_s": "1/s",
    "Nm_rad": "N·m/rad", "kgm2": "kg·m²", "N_m": "N/m",
}  # fmt: skip
"""How people write the units whose names in keys cannot hold a slash or a dot."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Requirement:
    """Something an answer stands on.

    `met` is where a line has it, (..., states, parts) or what broadcasts to that, and
    `idle` where the application says there is nothing to evaluate: a line that stands still.
    """

    required_input: str
    """What an application gives to have it, by its keys."""
    is_met: Callable[[LineResponse], BoolArray]
    is_idle: Callable[[LineResponse], BoolArray] | None = None
    leaves_lower_bound: bool = False
    """Whether limits then still hold the quantity's `lower_bound` against them."""
    required_input_windup_brake: str = ""
    """What gives it in a state that brakes wind up, where that is something else."""

    def missing_input(self, r: LineResponse, state: int) -> str:
        """Return what an application gives to have it in a state."""
        return (
            r.state_kinds[state] == "windup brake" and self.required_input_windup_brake
        ) or self.required_input


NEEDS_SHAFT_LENGTHS = Requirement(
    required_input="the length of each shaft", is_met=lambda r: np.array([[r.line.has_lengths]])
)
NEEDS_MOUNT_STIFFNESS = Requirement(
    required_input="the tube of each shaft",
    is_met=lambda r: np.array(
        [[r.mounts.mounted_line is not None or r.mounts.is_rigid or not r.line.has_lengths]]
    ),
)
"""Given with `NEEDS_SHAFT_LENGTHS`; a bearing without a stiffness is rigid."""


def _rated(gives: str, name: str) -> Requirement:
    return Requirement(required_input=gives, is_met=lambda r: np.isfinite(r.inputs.rating(name)))


def _strong(tube: Tube | CompositeTube | None) -> bool:
    """Return whether it is known what a tube carries; of plies it is always known."""
    if isinstance(tube, CompositeTube):
        return True
    return tube is not None and tube.material.yield_strength is not None


NEEDS_SPEED = Requirement(
    required_input="speed_rpm, or engine and gearbox",
    is_met=lambda r: np.isfinite(r.demand.speed)[..., None],
    is_idle=lambda r: (r.demand.speed == 0)[..., None],
)
NEEDS_COAST_TORQUE = Requirement(
    required_input="coast_torque_Nm, or the brake torque of the engine",
    is_met=lambda r: np.isfinite(r.demand.coast_torque)[..., None],
)
NEEDS_SPEED_ZERO_ALLOWED = Requirement(
    required_input=NEEDS_SPEED.required_input, is_met=NEEDS_SPEED.is_met
)
"""How fast it turns, where what stands still counts too."""
NEEDS_TORQUE = Requirement(
    required_input="torque_Nm, or engine, gearbox, axle and tyre",
    required_input_windup_brake=NEEDS_COAST_TORQUE.required_input,
    is_met=lambda r: np.isfinite(r.demand.torque)[..., None],
    is_idle=lambda r: (r.demand.torque == 0)[..., None],
)
NEEDS_TORQUE_WEIGHT_OR_UNBALANCE = Requirement(
    required_input=NEEDS_TORQUE.required_input,
    required_input_windup_brake=NEEDS_TORQUE.required_input_windup_brake,
    is_met=NEEDS_TORQUE.is_met,
    is_idle=lambda r: (
        (r.demand.torque == 0) & (r.inputs.gravity == 0) & (not r.application.include_unbalance)
    )[..., None],
)
"""Torque, or weight and unbalance where they count."""
NEEDS_TUBE_OF_SHAFT = Requirement(
    required_input="the tube of each shaft",
    is_met=lambda r: np.array([[s.tube is not None for s in r.line.shafts]]),
)
NEEDS_ALL_TUBES = Requirement(
    required_input="the tube of each shaft",
    is_met=lambda r: np.array([[all(s.tube is not None for s in r.line.shafts)]]),
)
NEEDS_SHAFT_INERTIAS = Requirement(
    required_input="length and tube, or polar_inertia_kgm2, of each shaft",
    is_met=lambda r: np.array([[r.inputs.shaft_inertias is not None]]),
)
NEEDS_YIELD_STRENGTH = Requirement(
    required_input="a tube material with its yield strength",
    is_met=lambda r: np.array([[_strong(s.tube) for s in r.line.shafts]]),
)
NEEDS_PEAK_TORQUE_RATING = _rated("a joint size with its peak torque", "peak_torque")
NEEDS_FATIGUE_TORQUE_RATING = _rated("a joint size with its reversing torque", "reversing_torque")
NEEDS_LIFE_RATING = Requirement(
    required_input="a joint size with its life rating Td",
    is_met=lambda r: np.isfinite(r.strength.life_ratings),
)


def _share_of(name: Literal["speed", "torque"], gives: str) -> Requirement:
    """Return the need of what a duty cycle by its name takes its points from."""
    return Requirement(
        required_input=gives,
        is_met=lambda r: np.array(
            [[all(np.isfinite(getattr(p, name)).any() for p in r.inputs.duty_points)]]
        ),
    )


NEEDS_DUTY_CYCLE = (
    Requirement(
        required_input="duty, or the name of a duty cycle",
        is_met=lambda r: np.array([[bool(r.inputs.duty_points)]]),
    ),
    _share_of("speed", NEEDS_SPEED.required_input),
    _share_of("torque", NEEDS_TORQUE.required_input),
)
"""A duty cycle, and what it takes its points from."""
NEEDS_SPLINE_STROKE = Requirement(
    required_input="spline plunge_mm and draw_mm",
    is_met=lambda r: (
        np.isfinite(r.clearances.spline_travel_margin)[..., None] | (not r.line.has_lengths)
    ),
)
"""Given in addition to `NEEDS_SHAFT_LENGTHS`."""
NEEDS_SPLINE_RADIUS = Requirement(
    required_input="spline mean_radius_mm",
    is_met=lambda r: np.isfinite(r.inputs.spline_force)[..., None],
)
NEEDS_SUSPENSION = Requirement(
    required_input="a suspension, and the axle loads of the state",
    is_met=lambda r: np.isfinite(r.demand.suspension_frequency)[..., None],
)


RATING_INPUTS = {
    "angle_max": "angle_max_deg of the joint",
    "speed_angle_max": "n_beta_max_deg_min of the joint",
    "speed_max": "speed_max_rpm of the joint",
}
"""What an application gives for a rating of a joint that is no cross, by its keys."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """A quantity of the field, declared once.

    `unit` is the unit it is shown in, a name of `cardan.core.units.UNITS`; inside the
    program its values are SI. `equation` is the formula that the function computing it comes to
    for symbols, in the unit it is shown in, or plain text that a terminal can print;
    `symbol_meanings` says what the symbols mean. `compute` gives it for the `parts` of a line that
    have it; a quantity without is answered by another study than that of the driveline.

    Raises
    ------
    ValueError
        For a unit that `cardan.core.units.UNITS` does not know.
    """

    key: str
    name: str
    symbol: str
    unit: str
    equation: str | Expression
    source: Source
    symbol_meanings: dict[str, str] = field(default_factory=dict[str, str])
    validity: str = ""
    """Limits of use: when the number can be trusted."""
    sense: LimitSense = "<="
    """Which side of a limit is safe."""
    signed: bool = False
    """Whether it has a direction: limits apply to its size."""
    parts: PartSelector | None = None
    compute: QuantityFunction | None = None
    validity_margin: QuantityFunction | None = None
    """Share still free of the range in which its values hold, negative beyond it: limits then hold
    its `lower_bound` against them, and warn at least."""
    lower_bound: QuantityFunction | None = None
    """What it is at least beyond that range."""
    unproved_margin: Callable[[LineResponse, ArrayLike], FloatArray | None] | None = None
    """Of many designs: the share that is certainly free of a threshold (..., 1, 1), as
    `validity_margin`; None where its values are solved."""
    worst_beyond: QuantityFunction | None = None
    """What it is at worst beyond that range: a limit whose grade that leaves needs no warning."""
    find_worst_points: Callable[[LineResponse], LineOperatingPoints | None] | None = None
    """At which operating points its values stand, where it is sought over those."""
    has_resonance: bool = False
    """Whether it is large where an order meets a mode of the line on its rubber."""
    depends_on_mounts: bool = False
    """Whether other rubber, or another place of a bearing, changes it."""
    at_all_points: bool = False
    """Whether limits apply to it at every operating point of a state, not at its own alone."""
    uses_engine_torque: bool = False
    """Whether it is of the engine's torque ahead, wherever the tyres slip."""
    requirements: tuple[Requirement, ...] = ()
    states: frozenset[str] | None = None
    """Kinds of state in which it means anything; None is all."""
    rating_attribute: str = ""
    """Where a catalogue's joint brings a limit of its own, in addition to a profile's."""
    rating_replaces_profile: bool = False
    """Whether a joint's own limit takes the place of a profile's."""
    rating_of_other_kinds: str = ""
    """What a joint that is no cross must be rated by, where profiles limit crosses: a profile's
    limits do not apply to it, and without the rating it is not evaluated."""
    limit_by_definition: Limit | None = None
    """What each of its parts is held to under any profile: they are those that a file rates."""
    joint_kinds: frozenset[JointKind] | None = None
    """Kinds of joint that it means something of, where its parts are joints; None is all."""
    section: ReportTableSection | None = None
    """Where tables show it; None where they do not."""
    hidden_if_zero: bool = False
    """Whether tables leave it out where it is 0 in every state."""
    approximations: Mapping[str, QuantityFunction] = field(
        default_factory=dict[str, QuantityFunction]
    )
    """The field's approximations that tables show next to it, by name."""
    study: str = ""
    """The study that answers it, where that is not the driveline in its states."""
    json_path: str = ""
    """Where the JSON contract holds it in a state: `joints.angle_deg`; "" where it does not."""

    def __post_init__(self) -> None:
        if self.unit not in UNITS:
            msg = f"{self.key}: cardan.core.units.UNITS has no unit {self.unit!r}"
            raise ValueError(msg)

    @property
    def equation_text(self) -> str:
        """Its equation as plain text: of a quantity that has a letter, what that is."""
        if isinstance(self.equation, str):
            return self.equation
        lettered = not re.search("[ /²]", self.symbol)
        return f"{self.symbol} = {self.equation}" if lettered else str(self.equation)

    @property
    def formula(self) -> Expression:
        """Its equation as a formula, to be printed with cells."""
        assert isinstance(self.equation, Expression)
        return self.equation

    @property
    def si_factor(self) -> float:
        """SI value of one display unit."""
        return UNITS[self.unit]

    @property
    def unit_symbol(self) -> str:
        """The display unit as people write it: rad/s², N·m."""
        return UNIT_SYMBOLS.get(self.unit, self.unit)

    def rated_limits(self, r: LineResponse) -> tuple[Limit | None, ...]:
        """Return the limit that each part's own rating brings, None where it has none."""
        if self.limit_by_definition is not None:
            return (self.limit_by_definition,) * len(self.parts_of(r))
        if not self.rating_attribute:
            return ()
        rated: list[tuple[Any, Any]] = [
            (size, getattr(size, self.rating_attribute) if size else None) for size in r.joint_sizes
        ]
        if any(np.ndim(value) for _, value in rated):
            msg = f"{self.rating_attribute} of a joint is a limit, and limits have no variants"
            raise DesignError(msg)
        return tuple(
            Limit(quantity=self.key, maximum=value, source=size.source_of(self.rating_attribute))
            if size and value
            else None
            for size, value in rated
        )

    def needs_own_rating(self, r: LineResponse) -> BoolArray:
        """Return which parts a profile's limits were not written for, (parts,) or (1,)."""
        return np.array(r.line.is_cross) == 0 if self.rating_of_other_kinds else np.array([False])

    def has_own_rating(self, r: LineResponse) -> BoolArray:
        """Return which parts bring a limit that takes the place of a profile's, (parts,)."""
        rating = self.rating_of_other_kinds or self.rating_attribute
        if not rating:
            return np.array([False])
        return np.array([
            size is not None and getattr(size, rating) is not None for size in r.joint_sizes
        ])  # fmt: skip

    def means_something_of(self, r: LineResponse) -> BoolArray:
        """Return which parts are of its kinds of joint, (parts,) or (1,)."""
        kinds = self.joint_kinds
        if kinds is None:
            return np.array([True])
        return np.array([kind in kinds for kind in r.line.joint_kinds])

    def parts_of(self, r: LineResponse) -> tuple[Part, ...]:
        """Return the parts of a line that have it."""
        return self.parts(r) if self.parts else ()

    def values(self, r: LineResponse, *, lower_bounds: bool = False) -> FloatArray:
        """Return its values, (..., states, parts) SI; nan where a need is not met.

        Or what it is at least beyond the range in which they hold.
        """
        assert self.compute is not None  # of the driveline's own quantities
        values = (self.lower_bound if lower_bounds and self.lower_bound else self.compute)(r)
        if self.joint_kinds is not None:
            values = np.where(self.means_something_of(r), values, np.nan)
        for need in self.requirements:
            if not (lower_bounds and need.leaves_lower_bound):
                values = np.where(need.is_met(r), values, np.nan)
        if self.states is None:
            return values
        meant = np.array([[kind in self.states] for kind in r.state_kinds])
        return np.where(meant, values, np.nan)

    def values_and_bounds(self, r: LineResponse) -> tuple[FloatArray, BoolArray]:
        """Return its values as limits hold them, (..., states, parts) SI, and which are bounds.

        A lower bound stands where the rubber goes beyond a stop and is not solved with it.
        """
        values = self.values(r)
        if self.lower_bound is None or self.validity_margin is None:
            return values, np.zeros(values.shape, dtype=bool)
        beyond = np.broadcast_to(self.validity_margin(r) < -MARGIN_TOLERANCE, values.shape)
        if not beyond.any():
            return values, beyond
        least = np.where(beyond, self.values(r, lower_bounds=True), values)
        return least, beyond & ~np.isnan(least)


def whole_line(_: LineResponse) -> tuple[Part, ...]:
    """Return the line as a whole."""
    return (WHOLE_LINE,)


def line_on_rubber(r: LineResponse) -> tuple[Part, ...]:
    """Return the line, if it has a centre bearing that gives: on rigid ones nothing swings."""
    return (WHOLE_LINE,) if r.line.joint_count > 2 and not r.mounts.is_rigid else ()


def all_joints(r: LineResponse) -> tuple[Part, ...]:
    """Return the joints, gearbox first."""
    return tuple(Part("joint", k) for k in range(1, r.line.joint_count + 1))


def joint_indices_of_kind(r: LineResponse, kind: JointKind) -> list[int]:
    """Return which joints, from 0, are of a kind."""
    return [k for k, one in enumerate(r.line.joint_kinds) if one == kind]


def _joints_of(kind: JointKind) -> PartSelector:
    return lambda r: tuple(Part("joint", k + 1) for k in joint_indices_of_kind(r, kind))


cross_joints, double_cardan_joints, tripod_joints = (
    _joints_of("cross"), _joints_of("double cardan"), _joints_of("tripod")
)  # fmt: skip


def all_shafts(r: LineResponse) -> tuple[Part, ...]:
    """Return the shafts, gearbox first."""
    return tuple(Part("shaft", k) for k in range(1, r.line.joint_count))


def last_shaft(r: LineResponse) -> tuple[Part, ...]:
    """Return the last shaft, which holds the spline."""
    return all_shafts(r)[-1:]


def all_centre_bearings(r: LineResponse) -> tuple[Part, ...]:
    """Return the centre bearings, gearbox first."""
    return tuple(Part("centre bearing", k) for k in range(1, r.line.joint_count - 1))


def make_whole_line_quantity_function(
    value: Callable[[LineResponse], FloatArray],
) -> QuantityFunction:
    """Return how to compute a quantity of the line as a whole from values (..., states)."""
    return lambda r: value(r)[..., None]


__all__ = [
    "NEEDS_ALL_TUBES",
    "NEEDS_COAST_TORQUE",
    "NEEDS_DUTY_CYCLE",
    "NEEDS_FATIGUE_TORQUE_RATING",
    "NEEDS_LIFE_RATING",
    "NEEDS_PEAK_TORQUE_RATING",
    "NEEDS_SHAFT_INERTIAS",
    "NEEDS_SHAFT_LENGTHS",
    "NEEDS_SPEED",
    "NEEDS_SPEED_ZERO_ALLOWED",
    "NEEDS_SPLINE_RADIUS",
    "NEEDS_SPLINE_STROKE",
    "NEEDS_SUSPENSION",
    "NEEDS_TORQUE",
    "NEEDS_TORQUE_WEIGHT_OR_UNBALANCE",
    "NEEDS_TUBE_OF_SHAFT",
    "NEEDS_YIELD_STRENGTH",
    "RATING_INPUTS",
    "SECTIONS_GROUPED_BY_PART",
    "STATE_KINDS_AT_LOADED_RIDE_HEIGHT",
    "UNIT_SYMBOLS",
    "PartSelector",
    "Quantity",
    "QuantityFunction",
    "ReportTableSection",
    "Requirement",
    "all_centre_bearings",
    "all_joints",
    "all_shafts",
    "cross_joints",
    "double_cardan_joints",
    "joint_indices_of_kind",
    "last_shaft",
    "line_on_rubber",
    "make_whole_line_quantity_function",
    "tripod_joints",
    "whole_line",
]  # fmt: skip

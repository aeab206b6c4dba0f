"""What the vibration study of an application found: modes, torques, zones, launches."""

from dataclasses import dataclass

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.labels import EvaluationCondition, Part
from cardan.model.application import Application, GearboxAndAxleRotors
from cardan.model.parts import Line
from cardan.model.powertrain import Launch
from cardan.physics.dynamics.torsional_network import (
    TorsionalModes,
)
from cardan.topics.torsion.launch_study import (
    LaunchResult,
)
from cardan.topics.torsion.powertrain_model import (
    AssumedValue,
    PowertrainModel,
    VehicleTorsionModel,
)

EXCITED_ORDERS = (2, 4)
"""Orders of the turning that joints excite."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ModeSensitivity:
    """How the modes of a gear move with something assumed, over its range.

    `frequencies` (2, modes) rad/s are those at its low and at its high end, `gear` the one in
    which they move most.
    """

    assumption: AssumedValue
    gear: str
    frequencies: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class ParametricResonance:
    """Where twice the speed meets a sum of two torsional frequencies, or one of them twice.

    Attributes
    ----------
    modes
        Counted from 1, the rigid turning apart.
    speed : (G, S) rad/s
        At its middle.
    nearest_speed : (G, S) rad/s
        The nearest speed that the gear has; nan where it has none.
    growth : (G, S) 1/s
        Of the zone's own multiplier, at that speed.
    openness : (G, S) 1
        What the joints feed at its middle over what damping takes: above 1 it is open.
    """

    modes: tuple[int, int]
    speed: FloatArray
    nearest_speed: FloatArray
    growth: FloatArray
    openness: FloatArray

    @property
    def part(self) -> Part:
        """What a check of it is of."""
        return Part("zone", *self.modes)

    @property
    def opening_angle_factor(self) -> FloatArray:
        """Joint angles over those there are, (G, S) 1, at which the zone opens."""
        return 1 / np.sqrt(np.maximum(self.openness, 1e-300))

    @property
    def opening_damping_factor(self) -> FloatArray:
        """Damping over what there is, (G, S) 1, below which the zone opens."""
        return self.openness


@dataclass(frozen=True, kw_only=True, eq=False)
class PowertrainVibration:
    """The vehicle with its clutch closed, or slipping, in G gears and S states.

    Attributes
    ----------
    powertrain
        Its parts.
    modes : (G, S, n)
        With the tyres stuck to the road; the first is no mode, the line turning as one.
    damping : (G, S, n) 1
        Ratio of each mode where order 2 meets it, or at the nearest speed the gear has.
    ranges : (G, S, 2) rad/s
        Speeds of the main line; nan where there are none.
    torque, speed : (G, S, orders, springs) N m, rad/s
        Largest vibratory torque of each order in each spring, and the speed it has it at.
    mean_torque : (G, S, springs) N m
        Torque that the springs carry at the gear's full torque, each sign kept.
    worst_vibratory_torque : (G, S, springs) N m
        Largest sum of the orders' torques at one speed.
    peak_torque, vibratory_ratio : (G, S, springs) N m, 1
        Largest sum of mean and vibratory torque at one speed; largest vibratory torque over
        the mean at the same speed.
    acceleration : (G, S, lines) rad/s²
        Largest of each line's pinion.
    """

    powertrain: PowertrainModel
    modes: TorsionalModes
    damping: FloatArray
    ranges: FloatArray
    torque: FloatArray
    speed: FloatArray
    mean_torque: FloatArray
    worst_vibratory_torque: FloatArray
    peak_torque: FloatArray
    vibratory_ratio: FloatArray
    acceleration: FloatArray

    @property
    def frequencies(self) -> FloatArray:
        """Of the modes without the rigid turning, (G, S, n - 1) rad/s."""
        return self.modes.frequency[..., 1:]


@dataclass(frozen=True, kw_only=True, eq=False)
class LineVibration:
    """What of the vibration is one line's own.

    Attributes
    ----------
    line
        Which line.
    lateral_growth : (G, hung shafts) 1/s
        Largest growth of each shaft on a rubber bearing; nan where the bearing is rigid.
    """

    line: Line
    lateral_growth: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class VibrationResult:
    """The answer: the vehicle in torsion, and each line's hung shafts.

    Attributes
    ----------
    application, surroundings
        What was requested, and what went before it; `given` names those of the latter.
    drivetrain
        The parts, and what was assumed of them.
    gears : the G ranges of speed
    states : the S states
    closed, slipping
        The vehicle with its clutch closed and slipping.
    zones
        Parametric zones of first order, the clutch closed.
    speeds, amplitudes : (k,) rad/s, (G, S, orders, k) N m
        Largest torque of the main line in forced motion; nan where a gear has no such speed.
    firing_torque : (G, springs) N m
        Largest torque of the engine's firing order in each spring at the gear's speeds.
    shifts
        How the modes move with what was assumed.
    launches
        Starts from rest: those of the file, or a smooth one and a dropped clutch.
    failed_launches
        Those that could not be followed, and why.
    doubts
        What could not be evaluated, in words.
    """

    application: Application
    surroundings: GearboxAndAxleRotors
    given: frozenset[str]
    drivetrain: VehicleTorsionModel
    gears: tuple[EvaluationCondition, ...]
    states: tuple[str, ...]
    closed: PowertrainVibration
    slipping: PowertrainVibration
    zones: tuple[ParametricResonance, ...]
    speeds: FloatArray
    amplitudes: FloatArray
    firing_torque: FloatArray
    shifts: tuple[ModeSensitivity, ...]
    lines: tuple[LineVibration, ...]
    launches: tuple[LaunchResult, ...] = ()
    failed_launches: tuple[tuple[Launch, str], ...] = ()
    doubts: tuple[str, ...] = ()


def any_known(values: FloatArray) -> bool:
    """Return whether any of some values is a number."""
    return bool(np.isfinite(values).any())


def heaviest_driving_state_index(of: VibrationResult) -> int:
    """Return the place of the heaviest state in which the vehicle drives."""
    drives = np.isfinite(of.closed.ranges).all((0, 2))
    return int(np.where(drives, of.drivetrain.mass, -1.0).argmax())


def mode_shapes_referred_to_main_line(of: PowertrainVibration, g: int, s: int) -> FloatArray:
    """Return shapes (n, modes) of a gear, turned as the main line turns, at most 1."""
    shape = of.modes.shape[g, s]
    rigid = np.abs(shape[:, 0])
    wheels = [k for k, (_, p) in enumerate(of.powertrain.freedoms) if p.kind == "wheels"]
    scale = np.where(rigid > 1e-6 * rigid.max(), rigid, rigid[wheels[0]])
    turned = shape[:, 1:] / scale[:, None]
    return turned / np.abs(turned).max(0)

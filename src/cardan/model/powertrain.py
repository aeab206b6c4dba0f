"""What turns and springs between engine and road, besides the line itself. All SI.

Every number may be None: not given. What is assumed for it is not the parts' business.
"""

import itertools
from math import pi

import numpy as np

from cardan.core.errors import DesignError, require_positive, values_of_first_violating_case
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import Metre, NewtonMetre, Radian, RadianPerSecond


@dataclass(frozen=True, slots=True, kw_only=True)
class Clutch:
    """A friction clutch and the damper in its disc.

    Attributes
    ----------
    stiffness, damping, hysteresis : N m/rad, N m s/rad, N m
        Of the damper; a curve of `angle` rad and `torque` N m may stand in place of stiffness.
    disc_inertia : kg m²
        On the friction's side of the damper.
    capacity : N m
        Largest torque that the friction holds.
    """

    stiffness: float | None = None
    hysteresis: NewtonMetre | None = None
    damping: float | None = None
    disc_inertia: float | None = None
    capacity: NewtonMetre | None = None
    angle: tuple[Radian, ...] = ()
    torque: tuple[NewtonMetre, ...] = ()

    def __post_init__(self) -> None:
        require_positive(
            "a clutch",
            stiffness=self.stiffness, disc_inertia=self.disc_inertia, capacity=self.capacity,
        )  # fmt: skip
        if len(self.angle) != len(self.torque):
            msg = "a clutch's curve needs as many angles as torques"
            raise DesignError(msg)
        for name, values in (("angles", self.angle), ("torques", self.torque)):
            if not all(np.all(b > a) for a, b in itertools.pairwise(values)):
                msg = f"the {name} of a clutch's curve must rise"
                raise DesignError(msg)

    def stiffness_at(self, torque: NewtonMetre) -> float | None:
        """Return the slope of the curve where it carries a torque, else the stiffness, N m/rad."""
        if not self.torque:
            return self.stiffness
        slopes = [
            (b - a) / (y - x)
            for (a, b), (x, y) in zip(
                itertools.pairwise(self.torque), itertools.pairwise(self.angle), strict=True
            )
        ]
        return slopes[min(sum(torque >= t for t in self.torque[1:-1]), len(slopes) - 1)]


@dataclass(frozen=True, slots=True, kw_only=True)
class DualMassFlywheel:
    """A flywheel in two halves with a spring between; the engine's inertia is the first."""

    stiffness: float
    secondary_inertia: float
    damping: float | None = None

    def __post_init__(self) -> None:
        require_positive(
            "a dual-mass flywheel",
            stiffness=self.stiffness, secondary_inertia=self.secondary_inertia,
        )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueConverter:
    """A torque converter in place of the clutch; it carries by its fluid until it locks up."""

    stall_torque_ratio: float = 1.0
    pump_inertia: float | None = None
    turbine_inertia: float | None = None
    lockup_stiffness: float | None = None

    def __post_init__(self) -> None:
        require_positive(
            "a converter",
            stall_torque_ratio=self.stall_torque_ratio, pump_inertia=self.pump_inertia,
            turbine_inertia=self.turbine_inertia, lockup_stiffness=self.lockup_stiffness,
        )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class GearboxRotors:
    """What turns and springs in a gearbox: inertia at its input, the rest at its output.

    `stiffness` and `output_inertia` hold one value, or one a gear from the lowest.
    """

    input_inertia: float | None = None
    output_inertia: tuple[float, ...] = ()
    stiffness: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class AxleRotors:
    """What turns and springs in an axle.

    Attributes
    ----------
    pinion_inertia, flange_inertia, pinion_stiffness : kg m², kg m², N m/rad
        The pinion, the flange of the last joint, and the shaft between them.
    ring_inertia, housing_inertia : kg m²
        Ring gear with differential; the housing about the axle.
    half_shafts : (left, right) N m/rad
        Between differential and wheels.
    hub_ratio : 1
        Half shaft speed over wheel speed where hubs reduce; the pinion's ratio holds it.
    locked
        Whether the differential is: an open one splits torque equally.
    """

    pinion_inertia: float | None = None
    flange_inertia: float | None = None
    pinion_stiffness: float | None = None
    ring_inertia: float | None = None
    housing_inertia: float | None = None
    half_shafts: tuple[float, float] | None = None
    hub_ratio: float = 1.0
    locked: bool = False

    @property
    def half_shaft_stiffness(self) -> float | None:
        """Of both half shafts as one spring between differential and wheels, N m/rad.

        An open differential gives both the same torque, and turns by the mean of their
        ends: 4 / (1/kl + 1/kr). A locked one turns both alike: kl + kr.
        """
        if self.half_shafts is None:
            return None
        left, right = self.half_shafts
        return left + right if self.locked else 4 / (1 / left + 1 / right)


@dataclass(frozen=True, slots=True, kw_only=True)
class InterAxleDifferential:
    """The differential between the axles of a tandem.

    `torque_split` is the share of the torque that goes on to the axle behind; a locked one
    turns both alike.
    """

    torque_split: float = 0.5
    through_inertia: float | None = None
    cage_inertia: float | None = None
    locked: bool = False

    def __post_init__(self) -> None:
        share = self.torque_split
        if wrong := values_of_first_violating_case((share > 0) & (share < 1), share):
            msg = f"torque_split of an inter-axle differential must be within 0 and 1: {wrong[0]:g}"
            raise DesignError(msg)


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelRotors:
    """Wheels with their tyres: `inertia` kg m² each, hubs and brakes at each end of an axle."""

    inertia: float | None = None
    per_axle: int | None = None
    hub_inertia: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Launch:
    """A start from rest.

    Attributes
    ----------
    gear
        Name of the gear.
    ramp : s
        In which the clutch's torque rises from nothing to `clutch_torque`.
    clutch_torque : N m
        What the clutch carries at the end of the ramp; None: the engine's largest torque.
    capacity : 1
        What the clutch holds at most, over `clutch_torque`: a dropped clutch slips above it.
    engine_speed : rad/s
        Before the clutch grips; None: where the full-load curve starts.
    grade : rad
        Slope of the road, up positive.
    load
        The state of that name says how the vehicle is loaded.
    play : rad
        Backlash at the pinion, for tip-in with rattle; 0 for none.
    """

    gear: str = "1"
    ramp: float = 0.5
    clutch_torque: NewtonMetre | None = None
    capacity: float = 1.0
    engine_speed: RadianPerSecond | None = None
    grade: Radian = 0.0
    load: str | None = None
    play: Radian = 0.0

    def __post_init__(self) -> None:
        require_positive(
            "a launch", ramp=self.ramp, capacity=self.capacity, torque=self.clutch_torque
        )


def torsion_bar_stiffness(*, diameter: Metre, length: Metre, shear_modulus: float) -> float:
    """Torsional stiffness of a round bar, G π d⁴ / (32 l), N m/rad."""
    return shear_modulus * pi * diameter**4 / (32 * length)

"""What is computed of one joint, or of two: the motion, the limits, the largest angles."""

from collections.abc import Mapping
from dataclasses import dataclass

from cardan.core.errors import DesignError
from cardan.core.units import Radian
from cardan.physics.kinematics.equivalent_angle import angle_for_acceleration
from cardan.physics.kinematics.hooke_joint import (
    PIN_IN_PLANE,
    angle_for_irregularity,
    angle_for_max_acceleration,
)
from cardan.topics.joint.joint_pair import JointPair
from cardan.topics.joint.single_joint import SingleJoint


@dataclass(frozen=True, kw_only=True)
class OutputLimit:
    """A limit of the output's motion, and the largest angle of a single joint that keeps it.

    Attributes
    ----------
    quantity
        "acceleration" (largest, rad/s²) or "irregularity" (largest less smallest speed over the
        mean, 1).
    maximum, value
        What is allowed, and what the output has, in those units.
    largest_angle : rad
        Of a single joint, or the largest equivalent angle of two; exact.
    approximate_angle : rad or None
        The same by ω² β², for the acceleration.
    """

    quantity: str
    maximum: float
    value: float
    largest_angle: Radian
    approximate_angle: Radian | None

    @property
    def kept(self) -> bool:
        """Whether the value is within the limit, to 1e-9 of it."""
        return self.value <= self.maximum * (1 + 1e-9)


@dataclass(frozen=True, kw_only=True)
class JointResult:
    """One joint, or two with a shaft between them, and the limits of their output.

    Attributes
    ----------
    joint
        The joint, or the driving joint of two.
    pair
        Both joints, if there are two.
    limits
        Those that were given.
    """

    joint: SingleJoint
    pair: JointPair | None = None
    limits: tuple[OutputLimit, ...] = ()

    @property
    def output(self) -> SingleJoint:
        """The joint that turns the output: the only one, or the equivalent of two."""
        return self.joint if self.pair is None else self.pair.output

    @property
    def keeps_limits(self) -> bool:
        """Whether the output is within each limit."""
        return all(limit.kept for limit in self.limits)

    @property
    def phase_tolerance(self) -> Radian | None:
        """Deviation from the best phase that keeps each limit, rad; nan if no phase does.

        None without a second joint or without limits.
        """
        if self.pair is None or not self.limits:
            return None
        return self.pair.phase_tolerance(min(limit.largest_angle for limit in self.limits))


def joint_result(
    *,
    speed: float,
    angle: float | None = None,
    angle2: float | None = None,
    phase: float | None = None,
    plane_angle: float | None = None,
    torque: float | None = None,
    across: float | None = None,
    pin: float = PIN_IN_PLANE,
    acceleration_limit: float | None = None,
    irregularity_limit: float | None = None,
) -> JointResult:
    """Return what one joint does, or two; all SI.

    Without an angle the joint has the largest angle that keeps the limits.

    Raises
    ------
    DesignError
        If there is neither an angle nor a limit, a second joint without the angle of the first,
        a phase without a second joint, or a value that cannot be.
    """
    maxima = {"acceleration": acceleration_limit, "irregularity": irregularity_limit}
    given = {name: value for name, value in maxima.items() if value is not None}
    for name, value in given.items():
        if not 0 < value < float("inf"):
            msg = f"the {name} limit of a joint must be above 0, got {value:g}"
            raise DesignError(msg)
    if angle2 is None and not (phase is None and plane_angle is None):
        msg = "a phase and the angle between the planes need a second joint, angle2"
        raise DesignError(msg)
    if angle is None:
        angle = _angle_within(given, speed, single=angle2 is None)
    joint = SingleJoint(angle=angle, speed=speed, torque=torque, across=across, pin=pin)
    pair = (
        None
        if angle2 is None
        else JointPair(
            first=joint, angle2=angle2, phase=phase or 0.0, plane_angle=plane_angle or 0.0
        )
    )
    output = joint if pair is None else pair.output
    values = {"acceleration": output.max_acceleration, "irregularity": output.irregularity}
    return JointResult(
        joint=joint,
        pair=pair,
        limits=tuple(_limit(name, value, values[name], speed) for name, value in given.items()),
    )


def _angle_within(maxima: Mapping[str, float], speed: float, *, single: bool) -> Radian:
    """Return the largest angle of a single joint within limits, rad."""
    if not single:
        msg = "two joints need both angles: the angle of the first is missing"
        raise DesignError(msg)
    if not maxima:
        msg = "a joint needs its angle, or a limit of acceleration or irregularity"
        raise DesignError(msg)
    SingleJoint(angle=0.0, speed=speed)  # checks the speed
    return min(_largest_angles(name, value, speed)[0] for name, value in maxima.items())


def _limit(quantity: str, maximum: float, value: float, speed: float) -> OutputLimit:
    exact, approximate = _largest_angles(quantity, maximum, speed)
    return OutputLimit(
        quantity=quantity, maximum=maximum, value=value,
        largest_angle=exact, approximate_angle=approximate,
    )  # fmt: skip


def _largest_angles(quantity: str, maximum: float, speed: float) -> tuple[Radian, Radian | None]:
    """Return the largest angle of a joint at a limit, exactly and by ω² β², rad."""
    if quantity == "irregularity":
        return float(angle_for_irregularity(maximum)), None
    exact = float(angle_for_max_acceleration(maximum / speed**2))
    return exact, float(angle_for_acceleration(maximum, speed=speed))

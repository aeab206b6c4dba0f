"""One universal joint by itself: how unevenly it turns, how its cross moves, what it takes."""

from dataclasses import dataclass

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.errors import DesignError
from cardan.core.units import Metre, NewtonMetre, Radian, RadianPerSecond, deg
from cardan.physics.kinematics import hooke_joint as joint
from cardan.physics.kinematics.hooke_joint import PIN_IN_PLANE, CrossMotion
from cardan.physics.strength.torsional_strength import cross_journal_force


def require_joint_angle(angle: Radian) -> None:
    """Raise a DesignError if a joint angle is negative or reaches π/2."""
    if not 0 <= angle < np.pi / 2:
        msg = (
            f"the angle of a joint must be at least 0 and below 90 deg, where it locks; got "
            f"{angle / deg:g} deg"
        )
        raise DesignError(msg)


@dataclass(frozen=True, kw_only=True)
class SingleJoint:
    """A Hooke joint at an angle, its driving shaft turning uniformly.

    Attributes
    ----------
    angle : rad
        Between the two shafts, below π/2.
    speed : rad/s
        Of the driving shaft.
    torque : N m
        In the driving shaft, if it is known.
    across : m
        Between the middles of opposite needle rows, if it is known.
    pin : rad
        Where the driving pin axis stands at θ = 0: `PIN_IN_PLANE` or `PIN_NORMAL_TO_PLANE`.
    """

    angle: Radian
    speed: RadianPerSecond
    torque: NewtonMetre | None = None
    across: Metre | None = None
    pin: Radian = PIN_IN_PLANE

    def __post_init__(self) -> None:
        require_joint_angle(self.angle)
        for name in ("speed", "torque", "across"):
            value = getattr(self, name)
            if value is not None and not 0 < value < np.inf:
                msg = f"the {name} of a joint must be above 0, got {value:g}"
                raise DesignError(msg)

    # Over the turn

    @property
    def max_lead_angle(self) -> Radian:
        """Largest angle by which the driven shaft is ahead or behind, rad."""
        return float(joint.angle_lead_amplitude(self.angle))

    @property
    def max_lead_input_angles(self) -> FloatArray:
        """Input angles of that, where both shafts run equally fast, (4,) rad."""
        return joint.equal_speed_angles(self.angle, pin=self.pin)

    @property
    def driven_speed_range(self) -> tuple[RadianPerSecond, RadianPerSecond]:
        """Least and largest speed of the driven shaft, rad/s."""
        low, high = joint.speed_range(self.angle)
        return float(low) * self.speed, float(high) * self.speed

    @property
    def irregularity(self) -> float:
        """Swing of the driven speed over the mean, 1."""
        return float(joint.irregularity(self.angle))

    @property
    def max_acceleration(self) -> float:
        """Largest acceleration of the driven shaft, rad/s²."""
        return float(joint.max_acceleration(self.angle)) * self.speed**2

    @property
    def max_acceleration_by_method(self) -> dict[str, float | None]:
        """The same by name: exact, and as the field approximates it, rad/s²; None where not."""
        each = {name: float(of(self.angle)) for name, of in joint.MAX_ACCELERATION_FORMULAS.items()}
        return {n: None if np.isnan(each[n]) else each[n] * self.speed**2 for n in each}

    @property
    def max_acceleration_input_angles(self) -> FloatArray:
        """Input angles of the largest acceleration, (4,) rad."""
        return joint.max_acceleration_angles(self.angle, pin=self.pin)

    @property
    def max_cross_rates(self) -> tuple[RadianPerSecond, RadianPerSecond]:
        """Largest rates of the cross in its driving and its driven yoke, rad/s.

        ω₁ tan β, where the driven shaft is fastest, and ω₁ sin β, where it is slowest: the
        peaks of ω_r2 = -ω₂ sin β sin θ and ω_r1 = ω₂ sin β cos θ / cos γ.
        """
        return self.speed * float(np.tan(self.angle)), self.speed * float(np.sin(self.angle))

    # Torque

    @property
    def driven_torque_range(self) -> tuple[NewtonMetre, NewtonMetre] | None:
        """Least and largest torque in the driven shaft, N m: nothing is lost."""
        if self.torque is None:
            return None
        low, high = joint.speed_range(self.angle)
        return self.torque * float(low), self.torque * float(high)

    @property
    def max_secondary_couples(self) -> tuple[NewtonMetre, NewtonMetre] | None:
        """Largest secondary couples on the driving and the driven shaft, N m.

        The couple of the journals stands square to the cross. On the driving shaft T tan γ
        is left, with γ up to β; on the driven shaft T₂ tan γ₂, at most T sin β, where T₂ is
        T cos β.
        """
        if self.torque is None:
            return None
        return (
            self.torque * float(np.tan(self.angle)),
            self.torque * float(np.sin(self.angle)),
        )

    @property
    def max_journal_force(self) -> float | None:
        """Largest force on a journal, and on the fork's arm behind it, N."""
        if self.torque is None or self.across is None:
            return None
        return float(cross_journal_force(self.torque, across=self.across, angle=self.angle))

    # Round the turn

    def curves_over_turn(self, theta: FloatArray) -> "SingleJointCurves":
        """Return everything at input angles (...) rad."""
        speed = self.speed * joint.speed_ratio(theta, beta=self.angle, pin=self.pin)
        cross = joint.cross_motion(theta, beta=self.angle, speed=self.speed, pin=self.pin)
        torque = self.torque
        driven = None if torque is None else torque * self.speed / speed
        return SingleJointCurves(
            input_angle=theta,
            lead_angle=joint.angle_lead(theta, beta=self.angle, pin=self.pin),
            driven_speed=speed,
            driven_acceleration=joint.output_acceleration(
                theta, beta=self.angle, speed=self.speed, pin=self.pin
            ),
            cross_motion=cross,
            driven_torque=driven,
            secondary_couples=None
            if driven is None or torque is None
            else (
                np.abs(torque * np.tan(cross.driving_angle)),
                np.abs(driven * np.tan(cross.driven_angle)),
            ),
        )


@dataclass(frozen=True, kw_only=True)
class SingleJointCurves:
    """A joint round its turn, each (...): rad, rad/s, rad/s², N m."""

    input_angle: FloatArray
    lead_angle: FloatArray
    driven_speed: FloatArray
    driven_acceleration: FloatArray
    cross_motion: CrossMotion
    driven_torque: FloatArray | None
    secondary_couples: tuple[FloatArray, FloatArray] | None

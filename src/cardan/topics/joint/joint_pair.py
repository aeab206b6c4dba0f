"""Two universal joints with a shaft between them: what is left of the fluctuation."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cardan.core.errors import DesignError
from cardan.core.units import Radian, deg
from cardan.physics.kinematics import joint_pair as pair
from cardan.physics.kinematics.equivalent_angle import ae7_equivalent_angle, ae7_phasor_terms
from cardan.topics.joint.single_joint import SingleJoint, require_joint_angle

ROUNDING_SHARE = 1e-15
"""Residual phasor, as a share of both joints' sum, below which it is rounding and counts as 0."""


@dataclass(frozen=True, kw_only=True)
class JointPair:
    """A joint, a shaft and a second joint.

    Attributes
    ----------
    first
        The driving joint.
    angle2 : rad
        Of the driven joint, from 0 to below π/2.
    phase : rad
        Yoke phase of the shaft between: from the driven pin axis of joint 1 to the driving pin
        axis of joint 2, right-handed about the shaft.
    plane_angle : rad
        From the plane of joint 1 to the plane of joint 2, right-handed about the shaft: 0 for
        the W arrangement, π for the Z arrangement.
    """

    first: SingleJoint
    angle2: Radian
    phase: Radian = 0.0
    plane_angle: Radian = 0.0

    def __post_init__(self) -> None:
        require_joint_angle(self.angle2)
        for name, value in (
            ("yoke phase", self.phase), ("angle between the planes", self.plane_angle),
        ):  # fmt: skip
            if not -2 * np.pi <= value <= 2 * np.pi:
                msg = f"the {name} must be from -360 to 360 deg, got {value / deg:g} deg"
                raise DesignError(msg)

    @property
    def arrangement(self) -> str:
        """Name of the arrangement: "W", "Z", or "" if the two joints have different planes."""
        turned = abs(np.remainder(self.plane_angle + np.pi, 2 * np.pi) - np.pi)
        return {True: "W"}.get(turned < 1e-9, "Z" if abs(turned - np.pi) < 1e-9 else "")

    @cached_property
    def output(self) -> SingleJoint:
        """Single joint that turns the output exactly as the two joints do.

        Its angle is the equivalent angle; its cross is none of the two.
        """
        return self._output(self.phase)

    @property
    def ae7_equivalent_angle(self) -> Radian:
        """Equivalent angle by AE-7, for small angles: √|β₁² - β₂² e^{2i(δ - ψ)}|, rad."""
        # ψ is right-handed, hence from right to up; AE-7 counts the side view down.
        side = [0.0, -self.angle2 * float(np.sin(self.plane_angle))]
        top = [self.first.angle, self.angle2 * float(np.cos(self.plane_angle))]
        terms = ae7_phasor_terms(side, top, phases=[self.phase])
        return float(ae7_equivalent_angle(terms.sum()))

    @property
    def best_phase(self) -> Radian:
        """Yoke phase that leaves the least fluctuation, in (-π/2, π/2] rad."""
        return float(pair.phase_of_least_fluctuation(self.plane_angle))

    @property
    def output_at_best_phase(self) -> SingleJoint:
        """The same as `output` with the best phase: what no phase removes."""
        return self._output(self.best_phase)

    def phase_tolerance(self, equivalent_angle: Radian) -> Radian:
        """Deviation from the best phase that keeps an equivalent angle, rad; nan if none does."""
        return float(pair.phase_tolerance(self.first.angle, self.angle2, limit=equivalent_angle))

    def _output(self, phase: Radian) -> SingleJoint:
        first = self.first
        phasor = complex(
            pair.pair_phasor(first.angle, self.angle2, phase=phase, plane_angle=self.plane_angle)
        )
        both = np.tan(first.angle / 2) ** 2 + np.tan(self.angle2 / 2) ** 2
        if abs(phasor) <= ROUNDING_SHARE * both:
            phasor = 0j
        return replace(
            first,
            angle=float(pair.equivalent_angle_of_phasor(phasor)),
            pin=first.pin + float(np.angle(phasor)) / 2,
            across=None,
        )

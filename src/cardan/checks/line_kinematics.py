"""How the joints of a line turn: angles, pairs of joints, excitation."""

from collections.abc import Callable
from functools import cached_property

import numpy as np

from cardan.checks.line_inputs import LineInputs
from cardan.core.arrays import FloatArray, stack_on_last_axis
from cardan.core.lazy_dataclass import dataclass
from cardan.model.parts import JointKind, JointSize
from cardan.physics.kinematics import constant_velocity
from cardan.physics.kinematics import equivalent_angle as equivalent
from cardan.physics.kinematics.equivalent_angle import KinematicExcitation
from cardan.physics.kinematics.joint_chain import (
    yoke_phases_as_if_all_crosses,
)


@dataclass(frozen=True, kw_only=True)
class LineKinematics:
    """Angles of a line's joints and the excitation by them, (..., states)."""

    inputs: LineInputs

    @cached_property
    def joint_plane_positions(self) -> FloatArray:
        """Positions of the joint planes, (..., n) rad in [0, 2 pi)."""
        return equivalent.joint_plane_angle(self.side_angles, self.top_angles)

    @cached_property
    def side_angles(self) -> FloatArray:
        """Side view angles at the joints, (..., n) rad."""
        return np.diff(self.inputs.layout.side, axis=-1)

    @cached_property
    def top_angles(self) -> FloatArray:
        """Plan view angles at the joints, (..., n) rad."""
        return np.diff(self.inputs.layout.top, axis=-1)

    @property
    def paired_shafts(self) -> tuple[int, ...]:
        """Shafts, from 0, whose two joints are there to cancel: every other, from the rear.

        With an odd number of joints the first stands alone, as service procedures have it.
        Both are crosses: a joint of constant velocity has nothing to cancel.
        """
        crosses, found, k = self.inputs.line.is_cross, list[int](), self.inputs.line.joint_count - 1
        while k > 0:
            paired = crosses[k] and crosses[k - 1]
            if paired:
                found.append(k - 1)
            k -= 2 if paired else 1
        return tuple(found[::-1])

    @property
    def unpaired_joints(self) -> tuple[int, ...]:
        """Joints, from 0, that are crosses without another on their shaft to cancel them."""
        paired = {j for k in self.paired_shafts for j in (k, k + 1)}
        return tuple(
            k for k, cross in enumerate(self.inputs.line.is_cross) if cross and k not in paired
        )

    @cached_property
    def pair_angle_differences(self) -> FloatArray:
        """What is left of each pair's two angles, yoke phase considered, (..., pairs) rad.

        |D_k² - e^{2iε} D_{k+1}²| / (|D_k| + |D_{k+1}|): the difference of the two angles
        where both lie in one plane and the yokes are in line.
        """
        bend = self.inputs.joint_angles * np.exp(1j * self.joint_plane_positions)
        k = list(self.paired_shafts)
        front, rear = bend[..., k], bend[..., [j + 1 for j in k]]
        left = np.abs(front**2 - np.exp(2j * self.inputs.phases[..., k]) * rear**2)
        both = np.abs(front) + np.abs(rear)
        return np.divide(left, both, out=np.zeros_like(left), where=both > 0)

    @property
    def phasor_angles(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Side and plan view angles (..., n) and phases (..., n-1), rad, for AE-7's phasors.

        Those of crosses: others count as straight, with the yokes behind them a quarter turn on.
        """
        kinds = np.array(self.inputs.line.is_cross)
        phases = yoke_phases_as_if_all_crosses(self.inputs.phases, self.inputs.line.is_cross)
        return self.side_angles * kinds, self.top_angles * kinds, phases

    @cached_property
    def excitation(self) -> KinematicExcitation:
        """Torsional and inertia excitation at top speed, exactly; without torques."""
        return equivalent.excitation_of_rotating_chain(
            self.inputs.chain_rotation, speed=self.inputs.demand.speed
        )

    @cached_property
    def inertia_torques(self) -> tuple[FloatArray, FloatArray]:
        """Torques to accelerate the shafts, drive and overrun, (...) N m; nan without inertias."""
        if self.inputs.shaft_inertias is None:
            return np.asarray(np.nan), np.asarray(np.nan)
        return equivalent.shaft_inertia_torques(
            self.inputs.chain_rotation,
            speed=self.inputs.demand.speed,
            inertias=self.inputs.shaft_inertias,
        )

    @cached_property
    def approximate_excitations(self) -> dict[str, KinematicExcitation]:
        """The same by each approximation of the field, by name."""
        side, top, phases = self.phasor_angles
        return equivalent.excitation_approximations(
            side,
            top,
            phases=phases,
            speed=self.inputs.demand.speed,
            inertias=self.inputs.shaft_inertias,
        )

    @cached_property
    def double_cardan_speed_fluctuation(self) -> FloatArray:
        """Speed swing of each double cardan by itself, (..., n) 1; nan of others."""
        return self._of_kind(
            "double cardan",
            lambda size, beta: (
                constant_velocity.double_cardan_irregularity(
                    beta, length=size.centre_distance, ball=size.ball_from_rear
                )
                if size.centre_distance is not None and size.ball_from_rear is not None
                else np.full_like(beta, np.nan)
            ),
        )

    @cached_property
    def tripod_orbit_radius(self) -> FloatArray:
        """Radius in which the centre of each tripod goes round, (..., n) m; nan of others."""
        return self._of_kind(
            "tripod",
            lambda size, beta: (
                constant_velocity.tripod_orbit_radius(beta, radius=size.pitch_radius)
                if size.pitch_radius is not None
                else np.full_like(beta, np.nan)
            ),
        )

    def _of_kind(
        self, kind: JointKind, value: Callable[[JointSize, FloatArray], FloatArray]
    ) -> FloatArray:
        return stack_on_last_axis(
            value(size, beta) if size and size.kind == kind else np.full_like(beta, np.nan)
            for size, beta in zip(
                self.inputs.joint_sizes, np.moveaxis(self.inputs.joint_angles, -1, 0), strict=True
            )
        )

"""Forces and moments of a line whose centre bearings do not move."""

from functools import cached_property
from typing import Any

import numpy as np

from cardan.checks.line_inputs import SAMPLES_PER_TURN, LineInputs
from cardan.core.arrays import FloatArray, stack_on_last_axis
from cardan.core.lazy_dataclass import dataclass
from cardan.physics.loads.flange_reactions import flange_bearing_forces
from cardan.physics.loads.half_turn_fourier import HalfTurnSeries
from cardan.physics.loads.small_angle import small_angle_bearing_forces
from cardan.physics.loads.statics import (
    JointLoads,
    UnbalanceForces,
    joint_loads,
    unbalance_forces,
)
from cardan.physics.strength import torsional_strength as strength


@dataclass(frozen=True, kw_only=True)
class RigidLineLoads:
    """Loads on joints, bearings and shafts of a line on rigid bearings, (..., states)."""

    inputs: LineInputs

    @cached_property
    def joint_loads(self) -> JointLoads:
        """Forces round the turn at the state's torque, with weight where it is requested."""
        return joint_loads(
            self.inputs.layout,
            self.inputs.twisted_chain_rotation,
            self.inputs.line,
            torque=self.inputs.demand.torque,
            gravity=self.inputs.gravity,
            elastic=True,
        )

    @cached_property
    def joint_loads_with_inertia(self) -> tuple[JointLoads, ...]:
        """The same with what speeds the shafts up: with no thrust, and with either one.

        At the state's speed, the gearbox turning uniformly; a sliding fit that sticks holds any
        thrust between plus and minus its slip force.
        """
        slip = np.nan_to_num(self.inputs.spline_force)
        speed = np.nan_to_num(self.inputs.demand.speed)[..., None, None]
        turned = self.inputs.turned(self.inputs.demand.torque, samples=4 * SAMPLES_PER_TURN)
        return tuple(
            joint_loads(
                self.inputs.layout,
                turned,
                self.inputs.line,
                torque=self.inputs.demand.torque,
                inertias=self.inputs.shaft_inertias,
                accelerations=speed**2 * turned.acceleration,
                gravity=self.inputs.gravity,
                thrust=sign * slip,
                elastic=True,
            )
            for sign in (0, 1, -1)
        )

    @property
    def joint_forces(self) -> FloatArray:
        """Largest force through each joint at the worst thrust, (..., n) N."""
        return np.maximum.reduce([f.joint_forces.peak for f in self.joint_loads_with_inertia])

    @cached_property
    def unbalance_forces(self) -> UnbalanceForces | None:
        """Forces once a turn at top speed; None unless requested."""
        if not self.inputs.application.include_unbalance:
            return None
        return unbalance_forces(
            self.inputs.layout, self.inputs.line, speed=self.inputs.demand.speed
        )

    @cached_property
    def rigid_bearing_peaks(self) -> FloatArray:
        """Largest force on each centre bearing if it is rigid, (..., n-2) N."""
        once = self.unbalance_forces
        peak = self.joint_loads.bearing_forces.peak
        return peak + once.bearing_forces if once else peak

    @cached_property
    def small_angle_bearing_forces(self) -> tuple[FloatArray, FloatArray]:
        """Static (..., n-2, 3) N and dynamic (..., n-2) N force by the small-angle formula.

        Weight, where it is requested, is added as it is: it knows no small angles.
        """
        with np.errstate() if self.inputs.line.has_lengths else np.errstate(invalid="ignore"):
            cycle = small_angle_bearing_forces(
                self.inputs.layout, self.inputs.line, torque=self.inputs.demand.torque
            )
        weight = joint_loads(
            self.inputs.layout,
            self.inputs.chain_rotation,
            self.inputs.line,
            torque=0.0,
            gravity=self.inputs.gravity,
            elastic=True,
        )
        return cycle.static + weight.bearing_forces.static, cycle.dynamic

    @cached_property
    def secondary_couples(self) -> tuple[FloatArray, FloatArray]:
        """Largest secondary couple of each joint on the member ahead and behind, (..., n) N m.

        What is left of a cross's moment across a member: T tan β at most on the driving one.
        """
        moment, d = self.joint_loads.joint_moments.waves, self.inputs.layout.directions
        ahead, behind = (_across(moment, axis).peak for axis in (d[..., :-1, :], d[..., 1:, :]))
        return ahead, behind

    @cached_property
    def bending_moments(self) -> FloatArray:
        """Largest bending moment in each shaft, (..., n-1) N m, at the state's torque.

        Without weight a shaft carries nothing between its joints and its bearing, so the
        moment is largest at one of them.
        """
        ahead, behind = self.secondary_couples
        ends = np.maximum(behind[..., :-1], ahead[..., 1:])
        hung = [
            s.centre_bearing.from_rear_joint for s in self.inputs.line.shafts if s.centre_bearing
        ]
        if not hung:
            return ends
        light = (
            joint_loads(
                self.inputs.layout,
                self.inputs.twisted_chain_rotation,
                self.inputs.line,
                torque=self.inputs.demand.torque,
                elastic=True,
            )
            if self.inputs.gravity
            else self.joint_loads
        )
        force = light.joint_forces.waves[..., 1:-1, :, :]
        moment = light.joint_moments.waves[..., 1:-1, :, :]
        d = self.inputs.layout.directions[..., 1:-2, :]
        arm = (stack_on_last_axis(hung)[..., None] * d)[..., None, :]
        inside = np.maximum(ends[..., :-1], _across(-moment - np.cross(arm, force), d).peak)
        last = np.broadcast_to(ends[..., -1:], (*inside.shape[:-1], 1))
        return np.concatenate([inside, last], axis=-1)

    @cached_property
    def journal_force(self) -> FloatArray:
        """Largest force on a journal of each cross and its fork arm, (..., n) N.

        At the state's torque; nan where the size of the cross is not known. The two crosses of
        a double cardan bend half its angle each.
        """
        across = stack_on_last_axis(
            np.nan if s is None or s.cup_spacing is None else s.cup_spacing
            for s in self.inputs.joint_sizes
        )
        uneven = np.abs(self.inputs.chain_rotation.phasors[..., :-1])
        uneven = np.concatenate([np.zeros_like(uneven[..., :1]), uneven], axis=-1)
        largest = np.abs(self.inputs.demand.torque)[..., None] * (1 + uneven) / (1 - uneven)
        share = np.array([
            0.5 if kind == "double cardan" else 1.0 for kind in self.inputs.line.joint_kinds
        ])  # fmt: skip
        bent = share * self.inputs.joint_angles
        return strength.cross_journal_force(largest, across=across, angle=bent)

    @property
    def cup_pressure(self) -> FloatArray:
        """Mean pressure of each joint's cups in their yokes, (..., n) Pa; nan where unknown."""
        sizes = [(s and s.cup_diameter, s and s.cup_length) for s in self.inputs.joint_sizes]
        diameter, length = (
            stack_on_last_axis(np.nan if v is None else v for v in column)
            for column in zip(*sizes, strict=True)
        )
        return strength.bearing_cup_pressure(self.journal_force, diameter=diameter, length=length)

    @cached_property
    def end_bearing_forces(self) -> dict[str, FloatArray]:
        """Largest radial force on the bearings behind the flanges, (...) N by GWB's letters.

        A and B carry the gearbox output, E and F the pinion; B and E are nearer the joint.
        At the worst thrust, and with the shafts' inertia. nan where spacing and overhang are
        not given.
        """
        each = [self._behind(forces) for forces in self.joint_loads_with_inertia]
        return {letter: np.maximum.reduce([f[letter] for f in each]) for letter in "ABEF"}

    @cached_property
    def static_end_bearing_forces(self) -> dict[str, FloatArray]:
        """The same without thrust and inertia."""
        return self._behind(self.joint_loads)

    def _behind(self, forces: JointLoads) -> dict[str, FloatArray]:
        line, d = self.inputs.line, self.inputs.layout.directions
        ends = {
            "AB": (forces.gearbox_force, forces.gearbox_moment, d[..., 0, :],
                   line.gearbox_bearing_spacing, line.gearbox_bearing_overhang),
            "FE": (forces.pinion_force, forces.pinion_moment, -d[..., -1, :],
                   line.pinion_bearing_spacing, line.pinion_bearing_overhang),
        }  # fmt: skip
        cases = forces.joint_forces.waves.shape[:-3]
        found = dict.fromkeys("ABEF", np.full(cases, np.nan))
        for letters, (force, moment, outward, spacing, overhang) in ends.items():
            if spacing is not None and overhang is not None:
                pair = flange_bearing_forces(
                    force, moment, outward=outward, spacing=spacing, overhang=overhang
                )
                found |= {k: c.peak for k, c in zip(letters, pair, strict=True)}
        return found


def _across(moment: Any, axis: FloatArray) -> HalfTurnSeries:
    """Return what is across axes (..., 3) of moments with waves (..., K, 3)."""
    along = axis[..., None, :]
    return HalfTurnSeries(moment - (moment * along).sum(-1, keepdims=True) * along)

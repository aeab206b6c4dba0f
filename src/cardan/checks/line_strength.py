"""Strength of a line's tubes and joints: critical speeds, utilisations, life."""

from dataclasses import fields, replace
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from cardan.checks.line_inputs import LineInputs
from cardan.checks.rigid_line_loads import RigidLineLoads
from cardan.core.arrays import ArrayLike, FloatArray, stack_on_last_axis
from cardan.core.lazy_dataclass import dataclass
from cardan.model.laminate import CompositeTube
from cardan.model.parts import JointSize, Line, Tube
from cardan.physics.kinematics.joint_chain import (
    joint_angles,
)
from cardan.physics.strength import beams
from cardan.physics.strength import bearing_life as life
from cardan.physics.strength import composite_tube as composite
from cardan.physics.strength import critical_speed as whirl
from cardan.physics.strength import torsional_strength as strength
from cardan.physics.vehicle.state_demand import (
    LineStateDemand,
    demand_with_axle_moved_by_torque,
)


@dataclass(frozen=True, kw_only=True)
class LineStrength:
    """Critical speeds, utilisations and life of tubes and joints, (..., states)."""

    inputs: LineInputs
    rigid_loads: RigidLineLoads

    @cached_property
    def critical_speeds(self) -> FloatArray:
        """Critical speed of each shaft by itself, (..., n-1) rad/s; nan without a tube."""
        tubes = [s.tube for s in self.inputs.line.shafts]
        lengths = np.moveaxis(self.inputs.layout.lengths, -1, 0)
        return stack_on_last_axis(
            np.full_like(length, np.nan) if tube is None else _alone(tube, length)
            for tube, length in zip(tubes, lengths, strict=True)
        )

    @property
    def line_modes(self) -> whirl.WhirlModes | None:
        """How the line whirls as beams on its bearings; None without tubes.

        As installed: a spline's travel changes it by less than its own uncertainty.
        """
        if self.inputs.demand not in _MODES:
            _MODES[self.inputs.demand] = _line_modes(
                self.inputs.line, self.inputs.demand.installed.layout.lengths
            )
        return _MODES[self.inputs.demand]

    @cached_property
    def line_critical_speed(self) -> FloatArray:
        """Lowest speed that bends the line as beams on its bearings, (...) rad/s.

        The same in every state; nan without tubes.
        """
        modes = self.line_modes
        return whirl.line_critical_speed(modes) if modes else np.asarray(np.nan)

    @cached_property
    def mount_resonance_speed(self) -> FloatArray:
        """Lowest speed at which the line bounces on its rubber, (...) rad/s; nan if it has none."""
        modes = self.line_modes
        found = whirl.bearing_resonance_speed(modes) if modes else np.asarray(np.nan)
        return np.where(np.isfinite(found), found, np.nan)

    @cached_property
    def sizing_torque(self) -> FloatArray:
        """Largest torque round a turn at each joint, (..., n) N m, for the joints' size.

        From the engine where it is known, of an operating point in its gear, unless a state
        carries more, times the application's shock factor; where brakes wind the axle up, what
        the line carries.
        """
        demand = self.inputs.demand
        braked = np.array([kind == "windup brake" for kind in self.inputs.state_kinds])
        own = np.isnan(demand.engine_torque) | braked
        asked = np.where(own, demand.torque, np.fmax(demand.engine_torque, np.abs(demand.torque)))
        uneven = np.abs(self.inputs.chain_rotation.phasors[..., :-1])
        uneven = np.concatenate([np.zeros_like(uneven[..., :1]), uneven], axis=-1)
        largest = self.inputs.application.shock_factor * np.abs(asked)
        return largest[..., None] * (1 + uneven) / (1 - uneven)

    @property
    def joint_torque_utilisation(self) -> FloatArray:
        """Largest torque at each joint over its elastic limit, (..., n); nan where not known."""
        return self.sizing_torque / self.inputs.rating("peak_torque")

    @cached_property
    def joint_fatigue_utilisation(self) -> FloatArray:
        """Share of each joint's fatigue rating, from overrun to drive torque, (..., n).

        Every state's torques taken as a swing that comes back for ever; nan where the
        catalogue has no reversing torque.
        """
        reversing, pulsating = (
            self.inputs.rating("reversing_torque"),
            self.inputs.rating("pulsating_torque"),
        )
        return strength.joint_fatigue_utilisation(
            np.maximum(self.inputs.demand.torque, 0.0)[..., None],  # in overrun: from 0
            lowest=-np.nan_to_num(self.inputs.demand.coast_torque)[..., None],
            reversing=reversing,
            pulsating=np.where(np.isnan(pulsating), reversing, pulsating),
        )

    @cached_property
    def tube_shear_utilisation(self) -> FloatArray:
        """Shear stress of each tube over yield in shear, (..., n-1); nan where not known.

        Of a composite tube the share of its strength, at the ply that fails first.
        """
        torque = np.abs(self.inputs.demand.torque)
        shock = self.inputs.application.shock_factor

        def used(tube: Tube | CompositeTube | None) -> FloatArray:
            if isinstance(tube, CompositeTube):
                return composite.strength_utilisation(tube, torque * shock)
            if tube is None or tube.material.yield_strength is None:
                return np.full_like(torque, np.nan)
            return strength.tube_utilisation(
                torque,
                outer=tube.outer,
                inner=tube.inner,
                yield_strength=tube.material.yield_strength,
                shock_factor=shock,
            )

        return stack_on_last_axis(used(s.tube) for s in self.inputs.line.shafts)

    @cached_property
    def tube_fatigue_utilisation(self) -> FloatArray:
        """Share of each tube's endurance in shear, from overrun to drive torque, (..., n-1).

        nan of a composite tube, and where the material's endurance is not known.
        """
        highest = np.maximum(self.inputs.demand.torque, 0.0)  # in overrun: from 0
        lowest = -np.nan_to_num(self.inputs.demand.coast_torque)

        def used(tube: Tube | CompositeTube | None) -> FloatArray:
            if not isinstance(tube, Tube) or tube.material.fatigue_shear is None:
                return np.full_like(highest, np.nan)
            ultimate = tube.material.ultimate_strength
            return strength.tube_fatigue_utilisation(
                highest,
                lowest=lowest,
                outer=tube.outer,
                inner=tube.inner,
                fatigue_shear=tube.material.fatigue_shear,
                ultimate_shear=np.inf
                if ultimate is None
                else strength.ULTIMATE_SHEAR_RATIO * ultimate,
            )

        return stack_on_last_axis(used(s.tube) for s in self.inputs.line.shafts)

    @cached_property
    def tube_stress_utilisation(self) -> FloatArray:
        """Von Mises stress of torque and bending in each tube over yield, (..., n-1)."""
        torque, bending = np.abs(self.inputs.demand.torque), self.rigid_loads.bending_moments

        def used(tube: Tube | CompositeTube | None, moment: FloatArray) -> FloatArray:
            if not isinstance(tube, Tube) or tube.material.yield_strength is None:
                return np.full_like(moment, np.nan)
            shear = strength.tube_shear_stress(torque, outer=tube.outer, inner=tube.inner)
            normal = strength.tube_bending_stress(moment, outer=tube.outer, inner=tube.inner)
            stress = strength.von_mises_stress(shear, normal=normal)
            return self.inputs.application.shock_factor * stress / tube.material.yield_strength

        tubes = (s.tube for s in self.inputs.line.shafts)
        return stack_on_last_axis(
            used(t, m) for t, m in zip(tubes, np.moveaxis(bending, -1, 0), strict=True)
        )

    @cached_property
    def tube_buckling_utilisation(self) -> FloatArray:
        """Torque over what buckles the wall of each tube, (..., n-1); nan without a tube.

        Between the joint centres, ends pinned, in the sense plies hold less well.
        """
        lengths = np.moveaxis(self.inputs.demand.installed.layout.lengths, -1, 0)

        def holds(tube: Tube | CompositeTube | None, length: FloatArray) -> ArrayLike:
            if tube is None:
                return np.nan
            if isinstance(tube, Tube):
                return strength.tube_buckling_torque(
                    outer=tube.outer, inner=tube.inner, length=length,
                    modulus=tube.material.youngs_modulus, poisson=tube.material.poisson,
                )  # fmt: skip
            return composite.min_buckling_torque(tube, length)

        tubes = (s.tube for s in self.inputs.line.shafts)
        held = stack_on_last_axis(
            holds(t, length) for t, length in zip(tubes, lengths, strict=True)
        )
        torque = np.abs(self.inputs.demand.torque) * self.inputs.application.shock_factor
        return torque[..., None] / held

    @property
    def life_ratings(self) -> FloatArray:
        """Torque Td of each joint for its rated life, (n,) N m; nan where not published."""
        found = (
            life.rated_torque_if_life_computable(size) if size else None
            for size in self.inputs.joint_sizes
        )
        return stack_on_last_axis(np.nan if rating is None else rating for rating in found)

    @cached_property
    def duty_angles(self) -> FloatArray:
        """Joint angles (points, ..., n) rad as the torques of the duty cycle have the axle."""
        each = [(p.torque, p.speed) for p in self.inputs.duty_points]
        cases = np.broadcast_shapes(
            self.inputs.joint_angles.shape[:-1], *(np.shape(v) for p in each for v in p)
        )
        torque, speed = (
            np.stack([np.broadcast_to(v, cases) for v in column])
            for column in zip(*each, strict=True)
        )

        def named(case: tuple[int, ...]) -> str:
            return f"point {case[0] + 1} of the duty cycle with {torque[case]:.4g} N m"

        under = demand_with_axle_moved_by_torque(
            self.inputs.demand, torque=torque, speed=speed, named=named
        )
        found = joint_angles(self.inputs.layout_for(under).directions)
        return np.broadcast_to(found, (len(each), *cases, found.shape[-1]))

    @cached_property
    def needle_bearing_life(self) -> FloatArray:
        """Life of each joint's needle bearings, (..., n) s; nan where not known.

        Over the duty cycle, at the joint angles of each state that lasts as each point's torque
        has them, unless the cycle gives its own. Worst torque and top speed of a vehicle never
        meet, so without a cycle there is no life.
        """
        duty = self.inputs.duty_points
        if not duty:
            return np.full(self.inputs.joint_angles.shape, np.nan)
        torque, speed, shares = (
            stack_on_last_axis(getattr(p, v) for p in duty)[..., None, :]
            for v in ("torque", "speed", "share")
        )
        fixed = stack_on_last_axis(np.nan if p.angle is None else p.angle for p in duty)[
            ..., None, :
        ]
        angle = np.where(np.isnan(fixed), np.moveaxis(self.duty_angles, 0, -1), fixed)
        wear = life.cross_joint_life_consumption_rate(
            torque,
            speed=speed,
            angle=angle,
            rated_torque=self.life_ratings[..., None],
            prime_mover_factor=self.inputs.application.prime_mover_factor,
        )
        each = list(np.moveaxis(wear, -2, 0))
        for k, size in enumerate(self.inputs.joint_sizes):
            if size and size.kind != "cross":
                each[k] = life.life_consumption_rate(
                    _over_duty(size),
                    torque[..., 0, :],
                    speed=speed[..., 0, :],
                    angle=angle[..., k, :],
                    prime_mover_factor=self.inputs.application.prime_mover_factor,
                )
        wear = np.stack(np.broadcast_arrays(*each), axis=-2)
        hours = life.joint_life(wear, shares=shares)
        return np.where(self.inputs.sustained_states[:, None], hours, np.nan)


_MODES: WeakKeyDictionary[LineStateDemand, whirl.WhirlModes | None] = WeakKeyDictionary()
"""Critical modes of each line in question: once for all layouts that keep its shafts."""


def _alone(tube: Tube | CompositeTube, length: FloatArray) -> FloatArray:
    """Return the critical speed of a shaft by itself: with shear, if it is of plies."""
    if isinstance(tube, CompositeTube):
        return composite.timoshenko_critical_speed(tube, length)
    return whirl.slender_tube_critical_speed(
        length,
        outer=tube.outer,
        inner=tube.inner,
        youngs_modulus=tube.material.youngs_modulus,
        density=tube.material.density,
    )


def _line_modes(line: Line, lengths: FloatArray) -> whirl.WhirlModes | None:
    """Return a line's critical modes; None without tubes."""
    if any(s.tube is None for s in line.shafts) or not np.isfinite(lengths).all():
        return None
    return whirl.synchronous_whirl_modes(beams.beam_model(line, lengths=lengths))


def _over_duty(size: JointSize) -> JointSize:
    """Return a joint whose own numbers, where they vary, leave an axis for a duty cycle."""
    varied = {f.name: getattr(size, f.name) for f in fields(size)}
    return replace(size, **{k: np.asarray(v)[..., None] for k, v in varied.items() if np.ndim(v)})

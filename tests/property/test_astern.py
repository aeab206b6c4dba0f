"""A line that turns backwards is the mirror image of one that turns ahead.

Mirrored on the vehicle's middle plane, every motion and force stays as large; what turned
backwards turns ahead, and a torque that pushed backwards pushes ahead. No other symmetry
takes a reverse gear for a forward one: rubber that damps tells them apart.
"""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from cardan.application import reader
from cardan.checks.line_on_mounts import mounted_line_of, nan_where_no_point
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.checks.stroke_thrust import stroke_thrust
from cardan.checks.worst_points import growth_rates_at
from cardan.core.units import rpm
from cardan.model.layout import Layout
from cardan.physics.kinematics.joint_chain import rotate_chain
from cardan.physics.loads.centre_bearing import ThrustEffect, bearing_forces, joint_forces
from cardan.physics.loads.parametric_instability import line_swing_growth_rate, two_mode_growth
from cardan.physics.vehicle.operating_points import (
    demand_at_operating_points,
    operating_points_on_curves,
    torque_curves,
)
from cardan.physics.vehicle.resolved_line import resolve_line_references
from cardan.physics.vehicle.state_demand import LineStateDemand, line_state_demand
from cardan.physics.vehicle.static_state import LineBeforeAxleWindup
from cardan.topics.bracket.forced_response import _along

EXAMPLES = Path(__file__).parents[2] / "examples"
MIRROR = np.array([1.0, -1.0, 1.0])


@pytest.fixture(scope="module", params=["refuse-collector-6x2", "tandem-6x4"])
def truck(request) -> LineResponse:
    """A line on rubber out of balance, its pinion beside the middle and its torque uneven."""
    given = reader.read(EXAMPLES / f"{request.param}.yaml")
    application = replace(given, include_unbalance=True)
    installed = next(i for i in application.lines if i.line.joint_count > 2)
    return compute_line_response(
        application, line_state_demand(resolve_line_references(application, installed))
    )


def astern(r: LineResponse) -> LineStateDemand:
    """The line at points of its reverse gear, some where order 2 meets modes."""
    found = torque_curves(r.demand)
    gear = found.directions.index("reverse")
    speed = np.linspace(60.0, 700.0, 33)[:, None] * rpm * np.ones(len(r.demand.states))
    return demand_at_operating_points(r.demand, found, curve=np.full(len(speed), gear), speed=speed)


def image(r: LineResponse, of: LineStateDemand) -> tuple[LineResponse, LineStateDemand]:
    """The mirrored line, ahead."""
    laid = seen(r.layout_for(of))
    return (
        r.with_inputs(layout=laid, phases=-r.phases),
        replace(of, torque=-of.torque, sense=-of.sense, layout=laid),
    )


def seen(laid: Layout) -> Layout:
    """A layout in the mirror."""
    return Layout(points=laid.points * MIRROR, directions=laid.directions * MIRROR)


class Mirrored(LineBeforeAxleWindup):
    """A vehicle whose lines have every torque the other way round."""

    def axle_motion_under(self, torque, **how):
        return super().axle_motion_under(-torque, **how)


def mirrored_thrust(r: LineResponse, ahead: LineStateDemand) -> ThrustEffect:
    """What thrust does to the mirrored line, its suspension going through the mirrored stroke."""
    demand, curves = r.demand, r.mounts.torque_curves
    of = {f.name: getattr(demand.static_state, f.name) for f in fields(demand.static_state)}
    demand = replace(
        demand, torque=-demand.torque, static_state=Mirrored(**of), layout=seen(demand.layout),
        undisplaced_layout=seen(demand.undisplaced_layout),
    )  # fmt: skip
    one = r.with_inputs(demand=demand, layout=seen(r.layout), phases=-r.phases)
    found = stroke_thrust(
        one.inputs, one.mounts.reduced_mounted_line, replace(curves, torque=-curves.torque)
    )
    return found.effect(ahead.torque, r.inputs.spline_force_at(ahead.torque))


def test_reverse_bearing_forces_mirror_forward_bearing_forces(truck):
    of = astern(truck)
    assert (of.torque[np.isfinite(of.torque)] < 0).all()
    assert (of.signed_speed[np.isfinite(of.speed)] < 0).all()
    mirrored, ahead = image(truck, of)
    held = truck.with_inputs(layout=truck.layout_for(of)).mounts.mounted_line
    thrust = mirrored_thrust(truck, ahead)
    assert np.abs(thrust.force).max() > 100.0
    for gives in (False, True):  # newtons, or how far the rubber lets it go
        found = truck.mounts.bearing_forces_at(of, truck.layout_for(of), on=held, gives=gives)
        other = nan_where_no_point(
            bearing_forces(
                mirrored.layout, mirrored.line, mirrored.phases, thrust=thrust, gives=gives,
                held=mirrored.mounts.mounted_line,
                **mirrored.mounts.force_inputs(ahead, inertia=True),
            ),
            ahead,
        )  # fmt: skip
        assert np.nanmax(found.order1) > (1e-6 if gives else 0.1)
        for name in ("static", "dynamic", "peak", "order1"):
            one, two = getattr(found, name), getattr(other, name)
            np.testing.assert_allclose(one, two, rtol=1e-9)
        # As time goes by, not as the cross turns.
        least = 1e-10 * np.nanmax(np.abs(other.waves))
        np.testing.assert_allclose(found.waves, other.waves * MIRROR, atol=least)


def test_reverse_joint_forces_mirror_forward_joint_forces(truck):
    of = astern(truck)
    mirrored, ahead = image(truck, of)
    each = []
    for r, asked in ((truck.with_inputs(layout=truck.layout_for(of)), of), (mirrored, ahead)):
        cut = mounted_line_of(r.inputs, cut=True)
        runs = r.mounts.force_inputs(asked, inertia=True)
        each.append(
            joint_forces(r.layout, r.line, r.phases, held=r.mounts.mounted_line, cut=cut, **runs)
        )
    np.testing.assert_allclose(each[0].dynamic, each[1].dynamic, rtol=1e-9)
    np.testing.assert_allclose(each[0].peak, each[1].peak, rtol=1e-9)


def test_reverse_growth_rates_mirror_forward_growth_rates(truck):
    of = astern(truck)
    mirrored, ahead = image(truck, of)
    for how in (line_swing_growth_rate, two_mode_growth):
        one, two = (
            how(
                r.mounts.reduced_mounted_line,
                r.mounts.reduced_mounted_line.order2_coupling(
                    rotate_chain(r.layout.directions, phases=r.phases, crosses=r.line.is_cross)
                ),
                speed=np.nan_to_num(asked.signed_speed),
                torque=np.nan_to_num(asked.torque),
            )
            for r, asked in (
                (truck.with_inputs(layout=truck.layout_for(of)), of),
                (mirrored, ahead),
            )
        )
        np.testing.assert_allclose(one, two, rtol=1e-6, atol=1e-6)


def test_studies_of_reverse_gear_use_negative_rotation(truck):
    """What swinging and a bracket's response ask at points of the gear, as the line has it."""
    of = astern(truck)
    found, laid = torque_curves(truck.demand), truck.layout_for(of)
    gear = found.directions.index("reverse")
    at = operating_points_on_curves(found, curve=np.full(len(of.speed), gear), speed=of.speed)
    swung = growth_rates_at(
        truck.mounts, at, truck.mounts.reduced_mounted_line, laid, how=line_swing_growth_rate
    ).results.growth[..., 0]
    pace, torque = np.nan_to_num(-of.speed), np.nan_to_num(of.torque)
    phases = truck.line.phases_under_torque(truck.phases, torque)
    turned = rotate_chain(laid.directions, phases=phases, crosses=truck.line.is_cross)
    known = np.isfinite(of.torque)
    right, other = (
        line_swing_growth_rate(
            truck.mounts.reduced_mounted_line,
            truck.mounts.reduced_mounted_line.order2_coupling(turned),
            speed=k * pace,
            torque=torque,
        )[known]
        for k in (1, -1)
    )
    np.testing.assert_allclose(swung[known], right, rtol=1e-8)
    assert np.abs(right - other).max() > 1e-5  # next to nothing, and told apart
    state = int(np.flatnonzero(known.any(axis=0))[0])
    held = truck.mounts.bearing_forces_at(of, laid)
    torque, waves = _along(truck, of.speed[:, state], found, [gear], state=state, bearing=0)
    np.testing.assert_allclose(torque[0], of.torque[:, state], rtol=1e-12)
    np.testing.assert_allclose(waves[0], held.waves[:, state, 0], rtol=1e-6, atol=1e-6)


def test_reverse_differs_from_overrun_in_bearing_force():
    """The same torque on the same line: one bearing feels two thirds, the other a third more."""
    application = reader.read(EXAMPLES / "refuse-collector-6x2.yaml")
    r = compute_line_response(
        application, line_state_demand(resolve_line_references(application, application.lines[0]))
    )
    back = astern(r)
    laid = r.layout_for(back)
    found, held = (
        r.mounts.bearing_forces_at(of, laid) for of in (back, replace(back, sense=-back.sense))
    )
    gvw = r.demand.states.index("gvw")
    worst = [np.nanmax(of.dynamic[:, gvw], axis=0) for of in (found, held)]
    assert worst[0] / worst[1] == pytest.approx([0.70, 1.32], abs=0.1)

"""A line that turns backwards is the mirror image of one that turns ahead.

Mirrored on the vehicle's middle plane, every motion and force stays as large; what turned
backwards turns ahead, and a torque that pushed backwards pushes ahead. No other symmetry
takes a reverse gear for a forward one: rubber that damps tells them apart.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cardan import files
from cardan.base.units import rpm
from cardan.demand.line import resolve
from cardan.demand.points import curves, demand_at, placed
from cardan.demand.states import Demand, demand
from cardan.kinematics.chain import turn
from cardan.loads.parametric import growth, of_two
from cardan.loads.running import at_joints
from cardan.model.layout import Layout
from cardan.quantity import points
from cardan.quantity.response import Response, respond
from cardan.study.bracket_forced import _along

EXAMPLES = Path(__file__).parents[2] / "examples"
MIRROR = np.array([1.0, -1.0, 1.0])


@pytest.fixture(scope="module", params=["refuse-collector-6x2", "tandem-6x4"])
def truck(request) -> Response:
    """A line on rubber out of balance, its pinion beside the middle and its torque uneven."""
    given = files.read(EXAMPLES / f"{request.param}.yaml")
    application = replace(given, include_unbalance=True)
    installed = next(i for i in application.lines if i.line.joint_count > 2)
    return respond(application, demand(resolve(application, installed)))


def astern(r: Response) -> Demand:
    """The line at points of its reverse gear, some where order 2 meets modes."""
    found = curves(r.demand)
    gear = found.directions.index("reverse")
    speed = np.linspace(60.0, 700.0, 33)[:, None] * rpm * np.ones(len(r.demand.states))
    return demand_at(r.demand, found, curve=np.full(len(speed), gear), speed=speed)


def image(r: Response, of: Demand) -> tuple[Response, Demand]:
    """The mirrored line, ahead."""
    laid = r.lay(of)
    seen = Layout(points=laid.points * MIRROR, directions=laid.directions * MIRROR)
    return (
        replace(r, layout=seen, phases=-r.phases),
        replace(of, torque=-of.torque, sense=-of.sense, layout=seen),
    )


def test_bearings_carry_the_mirror_image(truck):
    of = astern(truck)
    assert (of.torque[np.isfinite(of.torque)] < 0).all()
    assert (of.turning[np.isfinite(of.speed)] < 0).all()
    mirrored, ahead = image(truck, of)
    held = replace(truck, layout=truck.lay(of)).held
    for gives in (False, True):  # newtons, or how far the rubber lets it go
        found = points.run(truck, of, truck.lay(of), on=held, gives=gives)
        seen = points.run(mirrored, ahead, mirrored.layout, gives=gives)
        assert np.nanmax(found.order1) > (1e-6 if gives else 0.1)
        for name in ("static", "dynamic", "peak", "order1"):
            one, two = getattr(found, name), getattr(seen, name)
            np.testing.assert_allclose(one, two, rtol=1e-9)
        # As time goes by, not as the cross turns.
        least = 1e-10 * np.nanmax(np.abs(seen.waves))
        np.testing.assert_allclose(found.waves, seen.waves * MIRROR, atol=least)


def test_joints_carry_the_mirror_image(truck):
    of = astern(truck)
    mirrored, ahead = image(truck, of)
    each = []
    for r, asked in ((replace(truck, layout=truck.lay(of)), of), (mirrored, ahead)):
        cut = points.held(r, cut=True)
        runs = points._asked(r, asked, inertia=True)
        each.append(at_joints(r.layout, r.line, r.phases, held=r.held, cut=cut, **runs))
    np.testing.assert_allclose(each[0].dynamic, each[1].dynamic, rtol=1e-9)
    np.testing.assert_allclose(each[0].peak, each[1].peak, rtol=1e-9)


def test_swinging_grows_as_in_the_mirror(truck):
    of = astern(truck)
    mirrored, ahead = image(truck, of)
    for how in (growth, of_two):
        one, two = (
            how(
                r.quick,
                r.quick.swing(turn(r.layout.directions, phases=r.phases, crosses=r.line.crosses)),
                speed=np.nan_to_num(asked.turning), torque=np.nan_to_num(asked.torque),
            )
            for r, asked in ((replace(truck, layout=truck.lay(of)), of), (mirrored, ahead))
        )  # fmt: skip
        np.testing.assert_allclose(one, two, rtol=1e-6, atol=1e-6)


def test_rooms_that_ask_a_reverse_gear_turn_it_backwards(truck):
    """What swinging and a bracket's response ask at points of the gear, as the line has it."""
    of = astern(truck)
    found, laid = curves(truck.demand), truck.lay(of)
    gear = found.directions.index("reverse")
    at = placed(found, curve=np.full(len(of.speed), gear), speed=of.speed)
    swung = points._swinging(truck, at, truck.quick, laid, how=growth).running.growth[..., 0]
    pace, torque = np.nan_to_num(-of.speed), np.nan_to_num(of.torque)
    phases = truck.line.twisted(truck.phases, torque)
    turned = turn(laid.directions, phases=phases, crosses=truck.line.crosses)
    known = np.isfinite(of.torque)
    right, other = (
        growth(truck.quick, truck.quick.swing(turned), speed=k * pace, torque=torque)[known]
        for k in (1, -1)
    )
    np.testing.assert_allclose(swung[known], right, rtol=1e-8)
    assert np.abs(right - other).max() > 1e-5  # next to nothing, and told apart
    state = int(np.flatnonzero(known.any(axis=0))[0])
    held = points.run(truck, of, laid)
    torque, waves = _along(truck, of.speed[:, state], found, [gear], state=state, bearing=0)
    np.testing.assert_allclose(torque[0], of.torque[:, state], rtol=1e-12)
    np.testing.assert_allclose(waves[0], held.waves[:, state, 0], rtol=1e-6, atol=1e-6)


def test_a_truck_that_backs_is_none_that_holds_back():
    """The same torque on the same line: one bearing feels two thirds, the other a third more."""
    application = files.read(EXAMPLES / "refuse-collector-6x2.yaml")
    r = respond(application, demand(resolve(application, application.lines[0])))
    back = astern(r)
    laid = r.lay(back)
    found, held = (points.run(r, of, laid) for of in (back, replace(back, sense=-back.sense)))
    gvw = r.demand.states.index("gvw")
    worst = [np.nanmax(of.dynamic[:, gvw], axis=0) for of in (found, held)]
    assert worst[0] / worst[1] == pytest.approx([0.70, 1.32], abs=0.1)

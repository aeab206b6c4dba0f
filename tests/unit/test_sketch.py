"""Where worst points are sought, the sketch of a line says what the line itself says."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cardan import files
from cardan.demand.line import resolve
from cardan.demand.points import curves, placed
from cardan.demand.states import demand
from cardan.loads.sketch import Sizes, Sketch
from cardan.quantity import points
from cardan.quantity.response import Response, respond

EXAMPLES = Path(__file__).parents[2] / "examples"


def line(name: str, *, stiff: bool = False, straight: bool = False) -> Response:
    """A line of an example; an axle that no torque winds up, shafts that none twists."""
    application = files.read(EXAMPLES / f"{name}.yaml")
    if stiff:
        suspension = replace(application.suspension, windup_stiffness=1e12, squats=False)
        application = replace(application, suspension=suspension)
    installed = next(i for i in application.lines if i.line.joint_count > 2)
    if straight:
        shafts = tuple(replace(s, tube_length=1e-9) for s in installed.line.shafts)
        installed = replace(installed, line=replace(installed.line, shafts=shafts))
    return respond(application, demand(resolve(application, installed)))


def both(r: Response, count: int = 60):
    """What bearings carry at random points: of the sketch, and of the line's slowest modes."""
    found, random = curves(r.demand), np.random.default_rng(7)
    shape = (count, *found.fastest.shape[1:])
    curve = random.integers(0, len(found.gears), shape)
    fastest = np.take_along_axis(found.fastest, curve, axis=0)
    speed = fastest * random.uniform(0, 1, shape) ** 3  # modes are met slowly
    quick = r.held.slowest(2 * (r.line.joint_count - 2))
    drawn = points._sketch(r, placed(found, curve=curve, speed=speed), quick)
    sketched = points._sketched(r, found, curve, speed, drawn)[0].running
    whole = points._at(r, found, curve, speed, quick=quick).running
    return sketched, whole


@pytest.mark.parametrize("name", ["refuse-collector-6x2", "medium-truck-4x2", "tandem-6x4"])
def test_it_differs_by_what_a_parabola_leaves_out(name):
    """Wind-up and squat are 8 deg at most, half of that from the middle: (0.07 rad)^3 of a dozen.

    And where torque is half the largest, 3/8 of twice its twist squared: (0.05 rad)^2.
    """
    sketched, whole = both(line(name))
    for force in points.FORCES:
        near, right = (getattr(of, force) for of in (sketched, whole))
        assert (np.isnan(near) == np.isnan(right)).all()
        assert np.nanmax(np.abs(near - right)) < 5e-3 * np.nanmax(right)


def test_nothing_is_left_out_where_nothing_winds_up():
    sketched, whole = both(line("refuse-collector-6x2", stiff=True, straight=True))
    for force in points.FORCES:
        near, right = (getattr(of, force) for of in (sketched, whole))
        assert np.nanmax(np.abs(near - right)) < 1e-8 * np.nanmax(right)


def test_points_of_many_variants_are_those_of_few(monkeypatch):
    """Packed state by state they are what each is by itself, to rounding."""
    r = line("refuse-collector-6x2")
    random = np.random.default_rng(11)
    r = replace(r, phases=r.phases + random.normal(0, 0.05, (9, 1, r.line.joint_count - 1)))
    found, shape = r.curves, (50, *r.curves.fastest.shape[1:])
    curve = random.integers(0, len(found.gears), shape)
    speed = np.take_along_axis(found.fastest, curve, axis=0) * random.uniform(0, 1.1, shape)
    curve[30:], speed[30:] = curve[:20], speed[:20]  # some come again
    drawn, at = r.tries.drawn, placed(found, curve=curve, speed=speed)
    assert np.isnan(at.torque[:, 0, 0]).any()
    given = {"speed": at.sense * at.speed, "on_axle": points.on_axle_at(r.demand, at)}
    given["travel"] = np.broadcast_to(points.ride_at(r.demand, at).shift[..., 2], at.torque.shape)
    given |= {"torque": at.torque, "slip": r.slip_at(at.torque)}
    computed, some = [], Sketch._some
    monkeypatch.setattr(
        Sketch, "_some", lambda *a, **k: computed.append(np.size(a[2])) or some(*a, **k)
    )
    for gives in (False, True):
        computed.clear()
        many = drawn.at(**given, gives=gives)[0]
        assert sum(computed) < 0.7 * speed.size
        for first in range(0, 50, 10):
            few = drawn.at(**{k: v[first : first + 10] for k, v in given.items()}, gives=gives)[0]
            for force in points.FORCES:
                np.testing.assert_allclose(
                    getattr(many, force)[first : first + 10], getattr(few, force), rtol=1e-11
                )


def test_the_next_larger_points_are_those_of_a_sort():
    """What is not there comes last; where there are too few points the last one stands again."""
    r, random = line("medium-truck-4x2"), np.random.default_rng(3)
    force = random.integers(0, 5, (4, 3, 2)).astype(float)
    force[random.uniform(size=force.shape) < 0.3] = np.nan
    speed = np.arange(12.0).reshape(4, 3)
    points_ = points.Points(
        curves=r.own_curves, curve=speed.astype(int), speed=speed, torque=speed,
        running=Sizes(static=force, dynamic=force, peak=force),
    )  # fmt: skip
    order = np.argsort(-np.nan_to_num(force, nan=-np.inf), axis=0, kind="stable")
    for rank, found in enumerate(points._foremost(points_, "peak", 6)):
        at = order[min(rank, 3)]
        np.testing.assert_array_equal(found.speed, speed[at, np.arange(3)[:, None]])
        right = np.take_along_axis(force, at[None], axis=0)[0]
        np.testing.assert_array_equal(found.running.dynamic, right)
    assert np.isnan(force).any()


def test_a_line_that_lies_as_it_is_told_has_worst_points_too():
    """Whoever says where a line runs says it for every torque: none winds it up."""
    r = line("medium-truck-4x2")
    fixed = respond(r.application, r.demand, lay=lambda _: r.layout)
    stiff = line("medium-truck-4x2", stiff=True)
    stays = [s for s, name in enumerate(r.demand.states) if not name.startswith("windup")]
    for name in ("static", "dynamic", "peak"):
        ours, theirs = (x.bearing_force(name)[..., stays, :] for x in (fixed, stiff))
        np.testing.assert_allclose(ours, theirs, rtol=1e-6)

"""Where worst points are sought, the sketch of a line says what the line itself says."""

from dataclasses import replace

import numpy as np
import pytest
from repository import EXAMPLES

from cardan.application import reader
from cardan.checks.candidate_points import screened_forces_at, screening_model_of
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.checks.operating_point_results import OperatingPointResults, largest_points
from cardan.checks.worst_points import FORCE_KINDS
from cardan.physics.loads.screening import BearingForceScreeningModel, ForceMagnitudes
from cardan.physics.vehicle.operating_points import (
    axle_motion_at_points,
    housing_torque_at_points,
    operating_points_on_curves,
    torque_curves,
)
from cardan.physics.vehicle.resolved_line import resolve_line_references
from cardan.physics.vehicle.state_demand import line_state_demand


def line(
    name: str, *, stiff: bool = False, straight: bool = False, slippery: bool = False
) -> LineResponse:
    """A line of an example; an axle no torque winds up, shafts none twists, no friction."""
    application = reader.read(EXAMPLES / f"{name}.yaml")
    if stiff:
        suspension = replace(application.suspension, windup_stiffness=1e12, squats=False)
        application = replace(application, suspension=suspension)
    installed = next(i for i in application.lines if i.line.joint_count > 2)
    if straight:
        shafts = tuple(replace(s, tube_length=1e-9) for s in installed.line.shafts)
        installed = replace(installed, line=replace(installed.line, shafts=shafts))
    if slippery:
        *front, last = installed.line.shafts
        last = replace(last, spline=replace(last.spline, friction=0.0))
        installed = replace(installed, line=replace(installed.line, shafts=(*front, last)))
    return compute_line_response(
        application, line_state_demand(resolve_line_references(application, installed))
    )


def both(r: LineResponse, count: int = 60):
    """What bearings carry at random points: of the sketch, and of the line's slowest modes."""
    found, random = torque_curves(r.demand), np.random.default_rng(7)
    shape = (count, *found.max_speed.shape[1:])
    curve = random.integers(0, len(found.gears), shape)
    fastest = np.take_along_axis(found.max_speed, curve, axis=0)
    speed = fastest * random.uniform(0, 1, shape) ** 3  # modes are met slowly
    quick = r.mounts.mounted_line.modal_reduction(2 * (r.line.joint_count - 2))
    drawn = screening_model_of(
        r.mounts, operating_points_on_curves(found, curve=curve, speed=speed), quick
    )
    sketched = screened_forces_at(r.mounts, curve, speed, drawn)[0].results
    whole = r.mounts.bearing_forces_at_points(curve, speed, quick=quick).results
    return sketched, whole


@pytest.mark.parametrize("name", ["refuse-collector-6x2", "medium-truck-4x2", "tandem-6x4"])
def test_screening_error_is_below_parabola_remainder(name):
    """Wind-up and squat are 8 deg at most, half of that from the middle: (0.07 rad)^3 of a dozen.

    And where torque is half the largest, 3/8 of twice its twist squared: (0.05 rad)^2.
    """
    sketched, whole = both(line(name))
    for force in FORCE_KINDS:
        near, right = (getattr(of, force) for of in (sketched, whole))
        assert (np.isnan(near) == np.isnan(right)).all()
        assert np.nanmax(np.abs(near - right)) < 5e-3 * np.nanmax(right)


def test_screening_is_exact_without_windup():
    sketched, whole = both(line("refuse-collector-6x2", stiff=True, straight=True))
    for force in FORCE_KINDS:
        near, right = (getattr(of, force) for of in (sketched, whole))
        assert np.nanmax(np.abs(near - right)) < 1e-8 * np.nanmax(right)


def test_packed_variant_points_equal_single_points(monkeypatch):
    """Packed state by state they are what each is by itself, to rounding."""
    r = line("refuse-collector-6x2")
    random = np.random.default_rng(11)
    r = r.with_inputs(phases=r.phases + random.normal(0, 0.05, (9, 1, r.line.joint_count - 1)))
    found, shape = r.mounts.torque_curves, (50, *r.mounts.torque_curves.max_speed.shape[1:])
    curve = random.integers(0, len(found.gears), shape)
    speed = np.take_along_axis(found.max_speed, curve, axis=0) * random.uniform(0, 1.1, shape)
    curve[30:], speed[30:] = curve[:20], speed[:20]  # some come again
    drawn, at = (
        r.mount_loads.candidate_points.screening_model,
        operating_points_on_curves(found, curve=curve, speed=speed),
    )
    assert np.isnan(at.torque[:, 0, 0]).any()
    given = {"speed": at.sense * at.speed, "on_axle": housing_torque_at_points(r.demand, at)}
    given["travel"] = np.broadcast_to(
        axle_motion_at_points(r.demand, at).shift[..., 2], at.torque.shape
    )
    given |= {"torque": at.torque, "slip": r.inputs.spline_force_at(at.torque)}
    computed, some = [], BearingForceScreeningModel._some
    monkeypatch.setattr(
        BearingForceScreeningModel,
        "_some",
        lambda *a, **k: computed.append(np.size(a[2])) or some(*a, **k),
    )
    for gives in (False, True):
        computed.clear()
        many = drawn.bearing_forces_at(**given, gives=gives)[0]
        assert sum(computed) < 0.7 * speed.size
        for first in range(0, 50, 10):
            few = drawn.bearing_forces_at(
                **{k: v[first : first + 10] for k, v in given.items()}, gives=gives
            )[0]
            for force in FORCE_KINDS:
                np.testing.assert_allclose(
                    getattr(many, force)[first : first + 10], getattr(few, force), rtol=1e-11
                )


def test_forces_and_travel_solved_once_equal_each_alone():
    """To the last bit; and what lies in the way changes neither."""
    r = line("refuse-collector-6x2")
    of, found = r.mount_loads.candidate_points, r.mount_loads.screened_forces
    drawn = of.screening_model
    bare = drawn.without_obstacles()
    assert found.obstacle_reach.results.reach.shape[-1] > 0
    for gives, once in ((False, found.forces), (True, found.travel)):
        for model, places in ((drawn, found.obstacle_reach.results.reach.shape[-1]), (bare, 0)):
            alone, reach = screened_forces_at(
                r.mounts, of.curve_index, of.speed, model, gives=gives
            )
            assert reach.results.reach.shape[-1] == places
            for force in FORCE_KINDS:
                np.testing.assert_array_equal(
                    getattr(once.results, force), getattr(alone.results, force)
                )


def test_next_larger_points_match_sort():
    """What is not there comes last; where there are too few points the last one stands again."""
    r, random = line("medium-truck-4x2"), np.random.default_rng(3)
    force = random.integers(0, 5, (4, 3, 2)).astype(float)
    force[random.uniform(size=force.shape) < 0.3] = np.nan
    speed = np.arange(12.0).reshape(4, 3)
    points_ = OperatingPointResults(
        curves=r.mounts.demand_torque_curves, curve_index=speed.astype(int),
        speed=speed, torque=speed,
        results=ForceMagnitudes(static=force, dynamic=force, peak=force),
    )  # fmt: skip
    order = np.argsort(-np.nan_to_num(force, nan=-np.inf), axis=0, kind="stable")
    for rank, found in enumerate(largest_points(points_, "peak", 6)):
        at = order[min(rank, 3)]
        np.testing.assert_array_equal(found.speed, speed[at, np.arange(3)[:, None]])
        right = np.take_along_axis(force, at[None], axis=0)[0]
        np.testing.assert_array_equal(found.results.dynamic, right)
    assert np.isnan(force).any()


def test_line_with_given_layout_has_worst_points():
    """Whoever says where a line runs says it for every torque: none winds it up.

    Nor has it places between its states for a suspension to go through: without friction no
    spline minds them.
    """
    r = line("medium-truck-4x2", slippery=True)
    fixed = compute_line_response(r.application, r.demand, lay=lambda _: r.layout)
    stiff = line("medium-truck-4x2", stiff=True, slippery=True)
    stays = [s for s, name in enumerate(r.demand.states) if not name.startswith("windup")]
    for name in ("static", "dynamic", "peak"):
        ours, theirs = (x.mount_loads.bearing_force(name)[..., stays, :] for x in (fixed, stiff))
        np.testing.assert_allclose(ours, theirs, rtol=1e-6)

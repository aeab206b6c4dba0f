"""No point of a dense sweep of speed, in any gear and direction, is above the worst one found."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from case_selection import select

from cardan.application import reader
from cardan.approval.driveline_study import evaluate_limits
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.checks.quantities.registry import LINE_QUANTITIES
from cardan.checks.worst_points import FORCE_KINDS
from cardan.core.provenance import SOURCE_DERIVED
from cardan.core.units import rpm
from cardan.core.verdict import Limit
from cardan.model.parts import CentreBearing
from cardan.physics.vehicle.operating_points import demand_at_operating_points, torque_curves
from cardan.physics.vehicle.resolved_line import resolve_line_references
from cardan.physics.vehicle.state_demand import line_state_demand

EXAMPLES = Path(__file__).parents[2] / "examples"
SHORT = 0.99
"""Share of the sweep's largest that is found at least: on 48 random lines 0.992 was reached."""
TRUCKS = ("refuse-collector-6x2", "medium-truck-4x2", "tandem-6x4")


def responses(name: str) -> list[LineResponse]:
    application = reader.read(EXAMPLES / f"{name}.yaml")
    hung = [i for i in application.lines if i.line.joint_count > 2]
    return [
        compute_line_response(
            application, line_state_demand(resolve_line_references(application, i))
        )
        for i in hung
    ]


def swept(r: LineResponse, speeds: np.ndarray, *, gives: bool = False):
    """Return what bearings carry, or how far they go, at all speeds of all curves, (P, S, n-2)."""
    found = torque_curves(r.demand)
    every = np.broadcast_to(speeds[:, None, None], (len(speeds), *found.max_speed.shape))
    asked = demand_at_operating_points(
        r.demand, found, **dict(zip(("curve", "speed"), found.points_at(every), strict=True))
    )
    return r.mounts.bearing_forces_at(asked, r.layout_for(asked), gives=gives)


@pytest.mark.slow
@pytest.mark.parametrize("name", TRUCKS)
def test_worst_bearing_force_bounds_dense_speed_sweep(name):
    for r in responses(name):
        speeds = np.concatenate([np.arange(4.0, 600.0, 4.0), np.arange(600.0, 3000.0, 60.0)]) * rpm
        found = swept(r, speeds)
        for force in FORCE_KINDS:
            dense = np.nanmax(getattr(found, force), axis=0)
            worst = getattr(r.mount_loads.worst_bearing_forces[force].results, force)
            assert (worst >= dense * SHORT).all(), (
                r.line.name,
                force,
                (dense / worst).max(),
            )
            assert (worst > 0).all()


@pytest.mark.slow
@pytest.mark.parametrize("name", [*TRUCKS, "vecto-6x2"])
def test_worst_bearing_travel_bounds_dense_speed_sweep(name):
    for r in responses(name):
        speeds = np.concatenate([np.arange(4.0, 600.0, 4.0), np.arange(600.0, 3000.0, 60.0)]) * rpm
        dense = np.nanmax(swept(r, speeds, gives=True).peak, axis=0)
        worst = r.mount_loads.worst_bearing_travel.results.peak
        assert (worst >= dense * SHORT).all(), (r.line.name, (dense / worst).max())


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3, 6, 10, 12, 20, 22, 46])
def test_worst_force_bounds_dense_sweep_for_random_rubber(seed):
    """Random rubber, losses and torque stiffness: modes that meet, cross and lie far apart.

    Among them a line that order 4 shakes most (20), one whose torque moves its modes (12),
    two crests of a height (3, 6), a mean that is largest beside a crest (10), and means that
    are alike in two gears (22, 46).
    """
    random = np.random.default_rng(seed)
    (r, *_) = responses(TRUCKS[seed % 3])
    shafts = tuple(
        s if s.centre_bearing is None else replace(
            s,
            centre_bearing=CentreBearing(
                from_rear_joint=s.centre_bearing.from_rear_joint,
                stiffness=tuple(10 ** random.uniform(4.7, 6.0, size=2)),
                loss_factor=float(random.uniform(0.05, 0.3)),
            ),
        )
        for s in r.line.shafts
    )  # fmt: skip
    installed = r.application.lines[0]
    other = replace(installed, line=replace(installed.line, shafts=shafts))
    application = replace(r.application, lines=(other,))
    soft = compute_line_response(
        application, line_state_demand(resolve_line_references(application, other))
    )
    found = swept(soft, np.geomspace(40.0, 1400.0, 180) * rpm)
    for force in FORCE_KINDS:
        dense = np.nanmax(getattr(found, force), axis=0)
        worst = getattr(soft.mount_loads.worst_bearing_forces[force].results, force)
        assert (worst >= dense * SHORT).all(), (force, (dense / worst).max())


def test_worst_points_of_batched_variants_equal_single_ones():
    (r, *_) = responses("medium-truck-4x2")
    shift = np.zeros((2, 1, 1, 3))
    many = compute_line_response(
        r.application, r.demand, lay=lambda of: of.corrected_layout(bearing_shift=shift)
    )
    for force in FORCE_KINDS:
        one = getattr(r.mount_loads.worst_bearing_forces[force].results, force)
        two = getattr(many.mount_loads.worst_bearing_forces[force].results, force)
        assert two.shape == (2, *one.shape)
        assert two == pytest.approx(np.stack([one, one]), rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("name", select(TRUCKS, "medium-truck-4x2"))
def test_worst_corner_bounds_all_points_between_corners(name):
    """Every quantity that limits ask at all points, from standstill to the end of each curve.

    Where springs stiffen between two torques too: as an axle squats its shaft first comes nearer
    to what is above or below, and then the wind-up lifts its nose.
    """
    asked = set[str]()
    for r in responses(name):
        found = torque_curves(r.demand)
        speeds = np.linspace(0.0, np.nanmax(found.max_speed), 60)
        every = np.broadcast_to(speeds[:, None, None], (len(speeds), *found.max_speed.shape))
        every = np.concatenate([every, found.max_speed[None]])
        at = demand_at_operating_points(
            r.demand, found, **dict(zip(("curve", "speed"), found.points_at(every), strict=True))
        )
        dense = r.with_inputs(demand=at, layout=r.layout_for(at))
        for quantity in (q for q in LINE_QUANTITIES.values() if q.at_all_points):
            limit = Limit(
                quantity=quantity.key, source=SOURCE_DERIVED, maximum=1.0, sense=quantity.sense
            )
            there = quantity.values(dense)
            there = np.abs(there) if quantity.signed else there
            sign = 1.0 if quantity.sense == "<=" else -1.0
            worst = np.nanmax(sign * there, axis=0, initial=-np.inf)
            allowed = 0.01 * np.abs(worst) + 1e-12
            for asking in evaluate_limits(  # none of what the line has no part of
                r.with_inputs(application=replace(r.application, limits=(limit,))),
                quantities=[quantity.key],
            ):
                asked.add(quantity.key)
                known = ~np.isnan(asking.values) & np.isfinite(worst)
                assert (sign * asking.values + allowed >= worst)[known].all(), (
                    r.line.name,
                    quantity.key,
                )
    assert len(asked) > 5

"""Laws of operating points: corners bound their curves, and variants go as they go alone."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cardan.application import overrides, reader
from cardan.model.application import Application
from cardan.physics.vehicle.operating_points import demand_at_operating_points, torque_curves
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references
from cardan.physics.vehicle.torque import largest_torque_from_standstill

ROOT = Path(__file__).parents[2]
PATHS = (*sorted((ROOT / "examples").glob("*.yaml")), ROOT / "tests" / "truck.yaml")
NAMES = {path.stem: path for path in PATHS}
shares = st.floats(0, 1)


@cache
def application(name: str) -> Application:
    text = NAMES[name].read_text(encoding="utf-8")
    reverse = "" if "  reverse_ratio" in text else "  reverse_ratio: 6.9\n"
    text = text.replace("gearbox:\n", f"gearbox:\n  retarder_torque_Nm: 900\n{reverse}")
    if "  brake_torque_Nm: 14000" not in text:
        text = text.replace("\n  reference: gvw\n", "\n  reference: gvw\n  brake_torque_Nm: 9000\n")
    return reader.loads(text, folder=NAMES[name].parent)


@pytest.mark.slow
@settings(max_examples=30)
@given(name=st.sampled_from(sorted(NAMES)), share=st.lists(shares, min_size=40, max_size=40))
def test_torque_between_corners_is_bounded_by_corners(name, share):
    """And no less: straight between neighbours, which rounding alone may pass."""
    of = application(name)
    for installed in of.lines:
        found = torque_curves(line_state_demand(resolve_line_references(of, installed)))
        corners = found.corner_speeds
        at_corners = found.torque_at(corners)
        np.testing.assert_array_equal(np.isnan(at_corners), np.isnan(corners))
        spread = np.array(share).reshape(-1, *(1,) * found.max_speed.ndim)
        speed = spread * found.max_speed
        torque = found.torque_at(speed)
        for case in np.argwhere(~np.isnan(found.max_speed)):
            one = (slice(None), *case)
            known = ~np.isnan(corners[one])
            straight = np.interp(speed[one], corners[one][known], at_corners[one][known])
            np.testing.assert_allclose(torque[one], straight, rtol=1e-12)
        # nanmax of a curve that a state lacks is nan, and says so
        there = ~np.isnan(found.max_speed)
        most = np.nanmax(np.abs(at_corners[:, there]), axis=0)
        assert (np.abs(torque[:, there]) <= most * (1 + 1e-12)).all()


curves_of_engines = st.lists(
    st.tuples(st.floats(1, 100), st.floats(0, 3000)), min_size=1, max_size=8
)


@given(points=curves_of_engines, share=shares)
def test_from_standstill_is_largest_torque_at_or_above_speed(points, share):
    """By its definition, over a fine grid of engine speeds and the curve's own corners."""
    speed = np.cumsum([s for s, _ in points])
    torque = np.array([t for _, t in points])
    x = share * speed[-1]
    above = np.concatenate([[max(x, speed[0])], speed[speed >= x]])
    expected = np.interp(above, speed, torque).max()
    assert np.interp(x, *largest_torque_from_standstill(speed, torque)) == pytest.approx(
        expected, rel=1e-9, abs=1e-9
    )


CHANGES = {
    "refuse-collector-6x2": (
        "engine.torque_Nm[2]", "gearbox.ratios[1]", "gearbox.reverse_ratio", "axle.ratio",
        "suspension.windup_stiffness_kNm_deg", "suspension.brake_torque_Nm", "tyre.friction",
        "driveline.shafts[1].centre_bearing.from_rear_joint_mm", "states[1].speed_rpm",
    ),
    "tandem-6x4": (
        "engine.brake_torque_Nm", "gearbox.retarder_torque_Nm", "gearbox.reverse_ratio",
        "drivelines.inter-axle.axle.efficiency", "drivelines.inter-axle.torque_share",
    ),
}  # fmt: skip


@pytest.mark.slow
@settings(max_examples=25)
@given(data=st.data())
def test_operating_points_of_batched_variants_equal_single_ones(data):
    name = data.draw(st.sampled_from(sorted(CHANGES)))
    numbers = overrides.addresses(application(name))
    some = data.draw(st.lists(st.sampled_from(CHANGES[name]), min_size=1, max_size=3, unique=True))
    by = np.array(data.draw(st.lists(st.floats(0.92, 1.04), min_size=3, max_size=3)))
    changes = {at: numbers[at] * by for at in some}
    share = np.array(data.draw(st.lists(shares, min_size=2, max_size=2)))

    def points(changes):
        of = overrides.change(application(name), changes)
        for installed in of.lines:
            asked = line_state_demand(resolve_line_references(of, installed))
            found = torque_curves(asked)
            row = np.arange(len(found.gears)).repeat(share.size)
            fastest = np.repeat(found.max_speed, share.size, axis=0)
            speed = np.tile(share, len(found.gears)).reshape(-1, *(1,) * (fastest.ndim - 1))
            yield demand_at_operating_points(asked, found, curve=row, speed=speed * fastest)

    batch = list(points(changes))
    for v in range(by.size):
        alone = list(points({at: float(to[v]) for at, to in changes.items()}))
        for together, one in zip(batch, alone, strict=True):
            for get in (lambda d: d.torque, lambda d: d.speed, lambda d: d.pitch,
                        lambda d: d.spline_travel, lambda d: d.layout.points):  # fmt: skip
                value, expected = get(together), get(one)
                if value.ndim > expected.ndim:
                    value = value[:, v]
                size = np.nanmax(np.abs(expected), initial=0.0)
                np.testing.assert_allclose(value, expected, rtol=1e-12, atol=1e-12 * size)

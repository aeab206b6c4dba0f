"""A rigid foot on springs that only push: Navier's trapezium, and beyond the core a triangle."""

import numpy as np
import pytest

from cardan.base.errors import DesignError, NotConverged
from cardan.bracket.joint import Joint
from cardan.model.bracket import Bolts, usual_preload

WIDE, COUNT = 0.3, 60
Y = (np.arange(COUNT) + 0.5) / COUNT * WIDE - WIDE / 2


def foot(*, out_of_middle=0.0):
    """Two rows of patches along y, on springs of their own; one bolt, out of the middle along y."""
    places = np.array([(x, y, 0.0) for x in (-0.01, 0.01) for y in Y])
    ways = np.tile(np.eye(3), (len(places), 1))
    at = np.repeat(places, 3, axis=0)
    ways = np.concatenate([ways, np.eye(3)[[2]], np.eye(3), np.zeros((6, 3))])
    at = np.concatenate([at, [(0.0, out_of_middle, 0.0)], np.zeros((9, 3))])
    rigid = np.concatenate([ways, np.cross(at, ways)], axis=1)
    gives = np.where(np.arange(len(ways)) < 3 * len(places), 1e-9, 0.0)
    return Joint(
        compliance=np.diag(gives), rigid=rigid, rubs=np.ones(len(places), dtype=bool),
        stress=np.zeros((0, len(ways), 6)), upright=2, bolts=1,
    )  # fmt: skip


def pressure(tight):
    """Force of the frame on each step along y, N."""
    return -tight.forces[: 6 * COUNT].reshape(2, COUNT, 3)[..., 2].sum(axis=0)


def test_within_the_core_all_of_a_foot_presses():
    found = pressure(foot(out_of_middle=WIDE / 12).tightened(Bolts(preload=1000.0)))
    assert found.sum() == pytest.approx(1000.0)
    assert found.max() == pytest.approx(1000 / COUNT * 1.5, rel=1 / COUNT)


def test_beyond_the_core_a_foot_lifts_off_and_a_triangle_is_left():
    """Three times what the force is from the edge presses; its peak is twice the mean there."""
    away = 0.3 * WIDE
    tight = foot(out_of_middle=away).tightened(Bolts(preload=1000.0))
    found, long = pressure(tight), 3 * (WIDE / 2 - away)
    assert (found > 0).sum() * WIDE / COUNT == pytest.approx(long, rel=0.05)
    assert found.max() == pytest.approx(2 * 1000 / long * WIDE / COUNT, rel=0.05)
    assert found.min() >= 0.0


def test_a_foot_holds_by_friction_and_no_more():
    tight = foot().tightened(Bolts(preload=1000.0, friction=0.15))
    held = tight.under([0, 140.0, 0, *6 * [0]])
    assert held[: 6 * COUNT].reshape(-1, 3)[:, 1].sum() == pytest.approx(-140.0)
    with pytest.raises(NotConverged, match="slip or open"):
        tight.under([0, 200.0, 0, *6 * [0]])


def test_a_foot_pulled_off_by_more_than_its_bolt_is_told():
    tight = foot().tightened(Bolts(preload=1000.0))
    with pytest.raises(NotConverged):
        tight.under([0, 0, -1100.0, *6 * [0]])


def test_a_bolt_of_8_8_is_tightened_by_its_hole():
    assert usual_preload(11e-3) == pytest.approx(27.3e3, rel=1e-2)
    with pytest.raises(DesignError, match="preload above 0"):
        Bolts(preload=0.0)

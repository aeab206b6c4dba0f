"""Distances between segments, by hand and by brute force."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from cardan.model.application import Obstacle
from cardan.model.layout import layout_from_slopes
from cardan.model.parts import CentreBearing, JointSize, Line, Shaft, Tube
from cardan.physics.vehicle.clearance import clearances, closest_segment_points

coordinate = st.integers(-3, 3).map(float)
point = st.tuples(coordinate, coordinate, coordinate)


def segment_distance(a, b, c, d):
    return np.linalg.norm(closest_segment_points(a, b, c, d)[1], axis=-1).min(axis=-1)


@given(a=point, b=point, c=point, d=point)
@settings(max_examples=60)
def test_segment_distance_matches_fine_grid(a, b, c, d):
    """The grid's distance is at most half a step along each segment too long."""
    a, b, c, d = map(np.array, (a, b, c, d))
    s = np.linspace(0, 1, 101)[:, None]
    p, q = a + s * (b - a), c + s * (d - c)
    grid = np.linalg.norm(p[:, None] - q[None], axis=-1).min()
    step = (np.linalg.norm(b - a) + np.linalg.norm(d - c)) / 200
    found = segment_distance(a, b, c, d)
    assert grid - step - 1e-12 <= found <= grid + 1e-12


def test_clearance_to_moving_beam_matches_hand_calculation():
    """A 100 mm shaft runs level; a 60 mm beam crosses 200 mm below and rises with the axle."""
    line = Line(shafts=(Shaft(length=2.0, tube=Tube(outer=0.1, wall=0.003)),))
    layout = layout_from_slopes(side=[0, 0, 0], top=[0, 0, 0], lengths=[2.0])
    beam = Obstacle(
        name="beam", start=(1, -1, -0.2), end=(1, 1, -0.2), radius=0.03, travel_share=1.0
    )
    free = clearances(layout, line, (beam,), travel=[0.0, 0.05])
    assert free.shape == (2, 1, 1)
    assert free.ravel() == pytest.approx([0.2 - 0.05 - 0.03, 0.15 - 0.05 - 0.03], abs=1e-15)


def test_segment_distance_matches_bounded_least_squares():
    """The two places, from 0 to 1 on each, that lie nearest: whichever ends or middles they are."""
    rng = np.random.default_rng(3)
    a, b, c, d = rng.normal(size=(4, 60, 3))
    d[:10] = c[:10] + (b - a)[:10]  # parallel
    b[10:15] = a[10:15]  # a point
    found = segment_distance(a, b, c, d)
    for k in range(60):
        u, v, w = b[k] - a[k], d[k] - c[k], c[k] - a[k]
        best = lsq_linear(np.stack([u, -v], axis=-1), w, bounds=(0, 1), tol=1e-14)
        assert found[k] == pytest.approx(np.sqrt(2 * best.cost), rel=1e-6)


def test_yoke_envelope_is_wider_than_tube():
    """A pin 60 mm under the middle joint, 10 mm thick: tubes of 70 clear it, a swing of 140 hits.

    The yokes of both shafts turn in the same ball; 200 mm along only the tube is there.
    """
    tube = Tube(outer=0.07, wall=0.003)
    hung = CentreBearing(from_rear_joint=0.1)
    shafts = (Shaft(length=1.0, tube=tube, centre_bearing=hung), Shaft(length=1.0, tube=tube))
    layout = layout_from_slopes(side=[0, 0, 0, 0], top=[0, 0, 0, 0], lengths=[1.0, 1.0])
    pin, behind = (
        Obstacle(name=name, start=(x, -1, -0.06), end=(x, 1, -0.06), radius=0.005)
        for name, x in (("under the joint", 1.0), ("behind it", 1.2))
    )
    size = JointSize(name="wide", swing_diameter=0.14)
    bare = Line(shafts=shafts)
    clear = clearances(layout, bare, (pin, behind), travel=0.0)
    assert clear == pytest.approx(np.array([[0.02, np.hypot(0.2, 0.06) - 0.04], [0.02, 0.02]]))
    told = clearances(layout, replace(bare, joints=(None, size, None)), (pin, behind), travel=0.0)
    ball = np.hypot(0.2, 0.06) - 0.07 - 0.005
    assert told == pytest.approx(np.array([[-0.015, ball], [-0.015, min(0.02, ball)]]))
    ends = clearances(layout, replace(bare, joints=(size, None, size)), (pin, behind), travel=0.0)
    assert ends == pytest.approx(clear)

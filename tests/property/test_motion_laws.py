"""Laws of a line that follows its axle and its bearings."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from cardan.model.layout import Layout, layout_from_points
from cardan.model.parts import CentreBearing, Line, Shaft
from cardan.physics.vehicle.axle_motion import AxleMotion, layout_after_axle_motion

slopes = st.floats(-0.15, 0.15)
shifts = st.tuples(*[st.floats(-0.06, 0.06)] * 3)


@st.composite
def lines(draw):
    """A line of two to five joints through points that are no multiple of anything."""
    n = draw(st.integers(2, 5))
    spans = draw(st.lists(st.floats(0.5, 1.8), min_size=n - 1, max_size=n - 1))
    side = draw(st.lists(slopes, min_size=n + 1, max_size=n + 1))
    top = draw(st.lists(slopes, min_size=n + 1, max_size=n + 1))
    steps = [(s, s * t, -s * v) for s, t, v in zip(spans, top[1:-1], side[1:-1], strict=True)]
    points = np.concatenate([[[0.2, 0.1, 0.9]], np.array([0.2, 0.1, 0.9]) + np.cumsum(steps, 0)])
    ends = [(1.0, top[k], -side[k]) for k in (0, -1)]
    behind = draw(st.lists(st.floats(0, 0.3), min_size=n - 2, max_size=n - 2))
    # The lengths of the parts are on purpose not those between the points.
    shafts = [Shaft(length=1.0, centre_bearing=CentreBearing(from_rear_joint=b)) for b in behind]
    line = Line(shafts=(*shafts, Shaft(length=1.0)))
    return line, layout_from_points(points, gearbox=ends[0], pinion=ends[1])


def bearings_of(layout, line):
    """Bearing centres of a layout, (n-2, 3)."""
    behind = [s.centre_bearing.from_rear_joint for s in line.shafts[:-1]]
    return np.array(
        [p - b * d for p, b, d in zip(
            layout.points[1:-1], behind, layout.directions[1:-2], strict=True
        )]
    ).reshape(-1, 3)  # fmt: skip


def same(one, other, atol=1e-13):
    np.testing.assert_allclose(one.points, other.points, atol=atol)
    np.testing.assert_allclose(one.directions, other.directions, atol=atol)


@settings(max_examples=40)
@given(drawn=lines())
def test_zero_motion_changes_nothing(drawn):
    line, layout = drawn
    same(layout_after_axle_motion(layout, line, pinion_arm=(-0.4, 0, 0.05)), layout)


@settings(max_examples=60)
@given(drawn=lines(), shift=shifts, pitch=slopes, bearing=shifts)
def test_shafts_keep_length_and_frame_points_stay_fixed(drawn, shift, pitch, bearing):
    line, layout = drawn
    new = layout_after_axle_motion(
        layout,
        line,
        bearing_shift=bearing,
        last_shift=shift,
        pinion_pitch=pitch,
        pinion_arm=(-0.4, 0.0, 0.05),
    )
    np.testing.assert_array_equal(new.points[0], layout.points[0])
    np.testing.assert_array_equal(new.directions[0], layout.directions[0])
    np.testing.assert_allclose(new.lengths[:-1], layout.lengths[:-1], rtol=1e-13)
    # Every bearing lies on its shaft, between its joints.
    centres = bearings_of(layout, line) + bearing
    for front, along, centre in zip(new.points, new.directions[1:], centres, strict=False):
        np.testing.assert_allclose(np.cross(centre - front, along), 0, atol=1e-13)
        assert (centre - front) @ along > 0
    # Members run from joint to joint.
    np.testing.assert_allclose(
        new.points[:-1] + new.lengths[:, None] * new.directions[1:-1], new.points[1:], atol=1e-13
    )
    np.testing.assert_allclose(np.linalg.norm(new.directions, axis=-1), 1, rtol=1e-13)


@settings(max_examples=40)
@given(drawn=lines(), shift=shifts, pitch=slopes)
def test_axle_motion_moves_only_last_shaft(drawn, shift, pitch):
    line, layout = drawn
    new = layout_after_axle_motion(layout, line, last_shift=shift, pinion_pitch=pitch)
    np.testing.assert_allclose(new.points[:-1], layout.points[:-1], atol=1e-13)
    np.testing.assert_allclose(new.points[-1], layout.points[-1] + shift, atol=1e-13)
    # A pitch is a change of the pinion's side slope, and of nothing else.
    np.testing.assert_allclose(new.side[-1], layout.side[-1] + pitch, atol=1e-13)
    np.testing.assert_allclose(new.directions[-1][1], layout.directions[-1][1], rtol=1e-14)


@settings(max_examples=40)
@given(drawn=lines(), shift=shifts, pitch=slopes, bearing=shifts)
def test_mirrored_line_moves_as_mirror_image(drawn, shift, pitch, bearing):
    line, layout = drawn
    mirror = np.array([1.0, -1.0, 1.0])
    other = Layout(points=layout.points * mirror, directions=layout.directions * mirror)
    ride = {"pinion_pitch": pitch, "pinion_arm": (-0.4, 0.0, 0.1)}
    new = layout_after_axle_motion(layout, line, bearing_shift=bearing, last_shift=shift, **ride)
    seen = layout_after_axle_motion(
        other, line, bearing_shift=mirror * bearing, last_shift=mirror * shift, **ride
    )
    same(seen, Layout(points=new.points * mirror, directions=new.directions * mirror))


@settings(max_examples=40)
@given(drawn=lines(), shift=shifts, pitch=slopes)
def test_equal_axle_motions_move_inter_axle_line_rigidly(drawn, shift, pitch):
    """An inter-axle line whose ends ride alike, about one centre: a rigid motion."""
    _, layout = drawn
    layout = Layout(points=layout.points[[0, -1]], directions=layout.directions[[0, 1, -1]])
    layout = layout_from_points(
        layout.points, gearbox=layout.directions[0], pinion=layout.directions[-1]
    )
    centre = np.array([0.6, 0.0, 0.5])
    new = layout_after_axle_motion(
        layout,
        Line(shafts=(Shaft(length=1.0),)),
        last_shift=shift,
        pinion_pitch=pitch,
        pinion_arm=layout.points[-1] - centre,
        first=AxleMotion(shift=shift, pitch=pitch, joint_offset=layout.points[0] - centre),
    )
    np.testing.assert_allclose(new.lengths, layout.lengths, rtol=1e-13)
    np.testing.assert_allclose(
        new.directions @ new.directions.T, layout.directions @ layout.directions.T, atol=1e-13
    )


@settings(max_examples=20)
@given(drawn=lines(), seed=st.integers(0, 2**32 - 1))
def test_batched_variants_and_states_equal_single_ones(drawn, seed):
    line, layout = drawn
    random, bearings = np.random.default_rng(seed), len(line.shafts) - 1
    bearing = random.uniform(-0.05, 0.05, (3, 1, bearings, 3))
    shift = random.uniform(-0.05, 0.05, (2, 3))
    pitch = random.uniform(-0.1, 0.1, (3, 2))
    arm = (-0.4, 0.0, 0.1)
    found = layout_after_axle_motion(
        layout, line, bearing_shift=bearing, last_shift=shift, pinion_pitch=pitch, pinion_arm=arm
    )
    assert found.points.shape == (3, 2, *layout.points.shape)
    assert found.directions.shape == (3, 2, *layout.directions.shape)
    for v in range(3):
        for s in range(2):
            alone = layout_after_axle_motion(
                layout,
                line,
                bearing_shift=bearing[v, 0],
                last_shift=shift[s],
                pinion_pitch=pitch[v, s],
                pinion_arm=arm,
            )
            same(found[v, s], alone, atol=1e-15)

"""What is in the way: the distance between shafts and obstacles, state by state."""

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray, stack_on_last_axis, stack_vectors_on_last_axes
from cardan.core.lazy_dataclass import dataclass
from cardan.model.application import Obstacle
from cardan.model.layout import Layout, vector_length
from cardan.model.parts import Line
from cardan.physics.kinematics.joint_chain import dot_product


@dataclass(frozen=True, kw_only=True, eq=False)
class ShaftObstacleClearances:
    """Where shafts may be nearest to obstacles: five places each, (..., n-1, obstacles, 5).

    Attributes
    ----------
    clearance : m
        Distance there, less what both are thick; negative is interference.
    shaft_fraction : 1
        How far along the shaft that is, 0 at its front joint.
    direction : (..., 3)
        Unit vector from the obstacle to the shaft; nothing where their axes meet.
    """

    clearance: FloatArray
    shaft_fraction: FloatArray
    direction: FloatArray


def clearances(
    layout: Layout, line: Line, obstacles: tuple[Obstacle, ...], *, travel: ArrayLike
) -> FloatArray:
    """Return the free distance between each shaft and each obstacle, (..., n-1, obstacles) m."""
    return shaft_obstacle_clearances(layout, line, obstacles, travel=travel).clearance.min(axis=-1)


def shaft_obstacle_clearances(
    layout: Layout, line: Line, obstacles: tuple[Obstacle, ...], *, travel: ArrayLike
) -> ShaftObstacleClearances:
    """Return how free shafts are of obstacles where these may be nearest.

    Shafts are round bars of their tube's diameter (lines where no tube is known) between
    joint centres, with a ball at each joint whose yokes' swing is known; obstacles are capsules
    that follow the axle by their share of its `travel` (...) m, up positive.
    """
    starts = stack_vectors_on_last_axes(o.start for o in obstacles)[..., None, :, :]
    ends = stack_vectors_on_last_axes(o.end for o in obstacles)[..., None, :, :]
    radii = stack_on_last_axis(o.radius for o in obstacles)[..., None, :]
    rise = np.asarray(travel, dtype=float)[..., None] * stack_on_last_axis(
        o.travel_share for o in obstacles
    )
    lift = stack_on_last_axis((0.0, 0.0, rise))[..., None, :, :]
    points = layout.points[..., :, None, :]
    share, away = closest_segment_points(
        points[..., :-1, :, :], points[..., 1:, :, :], starts + lift, ends + lift
    )
    distance = vector_length(away)
    return ShaftObstacleClearances(
        clearance=distance - _thick(line)[..., None, :] - radii[..., None],
        shaft_fraction=share,
        direction=away / np.where(distance > 0, distance, 1.0)[..., None],
    )


def _thick(line: Line) -> FloatArray:
    """Return half of what shafts are thick at the places that `between` has, (..., n-1, 5) m."""
    bars = stack_on_last_axis(s.tube.outer / 2 if s.tube else 0.0 for s in line.shafts)
    sizes = line.joints or (None,) * line.joint_count
    yokes = stack_on_last_axis(
        s.swing_diameter / 2 if s and s.swing_diameter else 0.0 for s in sizes
    )
    ends = (np.maximum(bars, yokes[..., k : yokes.shape[-1] - 1 + k]) for k in (0, 1))
    return stack_on_last_axis((*ends, bars, bars, bars))


def closest_segment_points(
    a: ArrayLike, b: ArrayLike, c: ArrayLike, d: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Return where segments ab and cd, points (..., 3) m, may be nearest to each other.

    Five places, as a share (..., 5) of ab, and the vector (..., 5, 3) m from cd to there: the
    nearest points of the two lines, if both lie on their segments, and each of the four end
    points with what the other segment has nearest to it.
    """
    a, b, c, d = (np.asarray(p, dtype=float) for p in (a, b, c, d))
    u, v, w = b - a, d - c, a - c
    uu, uv, vv = dot_product(u, u), dot_product(u, v), dot_product(v, v)
    uw, vw = dot_product(u, w), dot_product(v, w)
    det = uu * vv - uv**2
    crossing = det > 1e-12 * uu * vv  # parallel lines have their nearest points at ends too
    safe = np.where(crossing, det, 1.0)
    s, t = (uv * vw - vv * uw) / safe, (uu * vw - uv * uw) / safe
    inside = crossing & (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    none, one = np.zeros_like(det), np.ones_like(det)
    s, t = (
        np.stack(np.broadcast_arrays(*places), axis=-1)
        for places in (
            (none, one, _share(-uw, uu), _share(uv - uw, uu), np.where(inside, s, none)),
            (_share(vw, vv), _share(uv + vw, vv), none, one, np.where(inside, t, none)),
        )
    )
    u, v, w = (part[..., None, :] for part in (u, v, w))
    return s, w + s[..., None] * u - t[..., None] * v


def _share(reach: FloatArray, length2: FloatArray) -> FloatArray:
    """Return how far along a segment a point is nearest to it.

    `length2` is the square of the segment, which may have no length, and `reach` its scalar
    product with the point from where it begins.
    """
    return np.clip(reach / np.where(length2 > 0, length2, 1.0), 0.0, 1.0)

"""What is in the way: the distance between shafts and obstacles, state by state."""

from functools import reduce

import numpy as np

from cardan.base.arrays import ArrayLike, FloatArray, stacked, vectors
from cardan.kinematics.chain import dot
from cardan.model.application import Obstacle
from cardan.model.layout import Layout, size
from cardan.model.parts import Line


def clearances(
    layout: Layout, line: Line, obstacles: tuple[Obstacle, ...], *, travel: ArrayLike
) -> FloatArray:
    """Return the free distance between each shaft and each obstacle, (..., n-1, obstacles) m.

    Shafts are round bars of their tube's diameter (lines where no tube is known) between
    joint centres; obstacles are capsules that follow the axle by their share of its
    `travel` (...) m, up positive. Negative is interference.
    """
    starts = vectors(o.start for o in obstacles)[..., None, :, :]
    ends = vectors(o.end for o in obstacles)[..., None, :, :]
    radii = stacked(o.radius for o in obstacles)[..., None, :]
    rise = np.asarray(travel, dtype=float)[..., None] * stacked(o.travel_share for o in obstacles)
    lift = stacked((0.0, 0.0, rise))[..., None, :, :]
    points = layout.points[..., :, None, :]
    distance = segment_distance(
        points[..., :-1, :, :], points[..., 1:, :, :], starts + lift, ends + lift
    )
    bars = stacked(s.tube.outer / 2 if s.tube else 0.0 for s in line.shafts)
    return distance - bars[..., None] - radii


def segment_distance(a: ArrayLike, b: ArrayLike, c: ArrayLike, d: ArrayLike) -> FloatArray:
    """Return the shortest distance between segments ab and cd, points (..., 3) m.

    The nearest points of the two lines, if both lie on their segments, or else the nearest
    of the four end points to the other segment.
    """
    a, b, c, d = (np.asarray(p, dtype=float) for p in (a, b, c, d))
    u, v, w = b - a, d - c, a - c
    uu, uv, vv = dot(u, u), dot(u, v), dot(v, v)
    uw, vw = dot(u, w), dot(v, w)
    det = uu * vv - uv**2
    crossing = det > 1e-12 * uu * vv  # parallel lines have their nearest points at ends too
    safe = np.where(crossing, det, 1.0)
    s, t = (uv * vw - vv * uw) / safe, (uu * vw - uv * uw) / safe
    inside = crossing & (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    between = size(w + s[..., None] * u - t[..., None] * v)
    ends = (
        _beside(w, v, length2=vv, reach=vw),
        _beside(w + u, v, length2=vv, reach=uv + vw),
        _beside(-w, u, length2=uu, reach=-uw),
        _beside(v - w, u, length2=uu, reach=uv - uw),
    )
    return np.where(inside, between, reduce(np.minimum, ends))


def _beside(
    point: FloatArray, along: FloatArray, *, length2: FloatArray, reach: FloatArray
) -> FloatArray:
    """Return the distance of a point (..., 3) to a segment, both from where that begins.

    `length2` is the square of the segment, which may have no length, and `reach` its scalar
    product with the point.
    """
    share = np.clip(reach / np.where(length2 > 0, length2, 1.0), 0.0, 1.0)
    return size(point - share[..., None] * along)

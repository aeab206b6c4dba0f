"""Where a margin is zero in a plane of two parameters: charts by their boundaries.

A stability chart is its boundary; the area on either side needs no sampling. `zero_contour`
starts from a coarse grid, divides only the cells the zero may cross and ends with
bracketed steps along their edges; `instability_tongue` follows a zone from where it is wide down to
its tip, however narrow it gets; `find_zeros` finds every zero along one parameter.
Source: adaptive marching squares, Lorensen & Cline (1987).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from cardan.core.arrays import FloatArray, IntArray

MarginFunction: TypeAlias = Callable[[FloatArray, FloatArray], FloatArray]
"""A function of x (points,) and y (points,) that is positive on one side of its boundary."""

ChartProgress: TypeAlias = Callable[[int, int], None]


def _zero(
    f: Callable[[FloatArray, IntArray], FloatArray],
    at_low: FloatArray,
    at_high: FloatArray,
    *,
    tolerance: float,
) -> FloatArray:
    """Zeros in [0, 1] of many brackets at once, by Ridders' method (1979).

    `f` takes places and which brackets they belong to. The bracket halves at least every
    step, and a smooth zero doubles its digits; brackets that have settled are left alone.
    """
    low, high = np.zeros(at_low.size), np.ones(at_low.size)
    a, b = at_low.astype(float), at_high.astype(float)
    best = np.full(at_low.size, 2.0)
    busy: IntArray = np.arange(at_low.size)
    while busy.size:
        left_end, width = low[busy], high[busy] - low[busy]
        fl, fh = a[busy], b[busy]
        middle = left_end + width / 2
        fm = f(middle, busy)
        root = np.sqrt(np.maximum(fm**2 - fl * fh, 0.0))
        shift = width / 2 * np.sign(fl - fh) * fm / np.where(root > 0, root, 1.0)
        x = np.clip(middle + shift, left_end, left_end + width)
        fx = f(x, busy)
        for place, value in ((middle, fm), (x, fx)):
            left = (value > 0) == (a[busy] > 0)
            up = left & (place > low[busy])
            down = ~left & (place < high[busy])
            low[busy[up]], a[busy[up]] = place[up], value[up]
            high[busy[down]], b[busy[down]] = place[down], value[down]
        moved = np.abs(x - best[busy])
        best[busy] = x
        busy = busy[(moved > tolerance) & (high[busy] - low[busy] > tolerance) & (fx != 0)]
    return best


@dataclass(frozen=True, slots=True, kw_only=True)
class ZeroContour:
    """The line where a margin is zero, as straight pieces between points on it.

    Attributes
    ----------
    segments : (pieces, 2, 2)
        Start and end of each piece, x and y.
    evaluations
        How often the margin was evaluated.
    cell_size : (2,)
        Width and height of the finest cells.
    """

    segments: FloatArray
    evaluations: int
    cell_size: FloatArray

    @property
    def points(self) -> FloatArray:
        """Points on the line, (points, 2)."""
        return np.unique(self.segments.reshape(-1, 2), axis=0)


def zero_contour(
    margin: MarginFunction,
    *,
    x: tuple[float, float],
    y: tuple[float, float],
    start: tuple[int, int] = (16, 16),
    levels: int = 4,
    tolerance: float = 1e-6,
    progress: ChartProgress | None = None,
) -> ZeroContour:
    """Find the zero line of a margin in a rectangle, evaluating only near it.

    Parameters
    ----------
    margin
        Called with arrays of points; should be signed and smooth on both sides
        (a growth rate of a damped system is).
    x, y
        The rectangle.
    start
        Cells of the first grid. Growth rates are flat outside a zone, so a zone is found
        where a corner falls into it or the slopes seen point to it: a zone narrower than a
        cell is missed, or ends where it is. Follow such ones with `instability_tongue`.
    levels
        How often cells are halved.
    tolerance
        Of a point along its cell edge, as a share of the edge.
    progress
        Called with levels done and levels in all.
    """
    nx, ny = start[0] << levels, start[1] << levels
    known: dict[int, float] = {}
    asked = 0

    def place(code: IntArray) -> tuple[FloatArray, FloatArray]:
        i, j = np.divmod(code, ny + 1)
        return x[0] + (x[1] - x[0]) * i / nx, y[0] + (y[1] - y[0]) * j / ny

    def values(i: IntArray, j: IntArray) -> FloatArray:
        nonlocal asked
        code = i * (ny + 1) + j
        unique, back = np.unique(code, return_inverse=True)
        new = np.array([c for c in unique.tolist() if c not in known], dtype=int)
        if new.size:
            asked += new.size
            known.update(zip(new.tolist(), np.asarray(margin(*place(new))).tolist(), strict=True))
        return np.array([known[c] for c in unique.tolist()])[back].reshape(code.shape)

    step = 1 << levels
    i, j = (
        a.ravel()
        for a in np.meshgrid(np.arange(0, nx, step), np.arange(0, ny, step), indexing="ij")
    )
    around = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    level = 0
    while True:
        corner = values(i[:, None] + step * around[:, 0], j[:, None] + step * around[:, 1])
        crossed = (corner > 0).any(-1) & ~(corner > 0).all(-1)
        if progress:
            progress(level, levels)
        if level == levels:
            break
        # A cell may hide a zero if its margin could reach it on the slopes of its corners.
        reach = np.abs(np.diff(corner, axis=-1, append=corner[:, :1])).max(-1)
        keep = crossed | (np.abs(corner).min(-1) <= reach)
        i, j, step, level = i[keep], j[keep], step // 2, level + 1
        i = (i[:, None] + step * around[:, 0]).ravel()
        j = (j[:, None] + step * around[:, 1]).ravel()
    i, j, corner = i[crossed], j[crossed], corner[crossed]

    # Each crossed edge once, then all of them together.
    ends = np.stack([around, np.roll(around, -1, axis=0)], axis=1)  # (edge, end, 2)
    inside = corner > 0
    cut = inside != np.roll(inside, -1, axis=-1)
    cell, edge = np.nonzero(cut)
    nodes = np.stack([i[cell], j[cell]], -1)[:, None, :] + step * ends[edge]
    codes = np.sort(nodes[..., 0] * (ny + 1) + nodes[..., 1], axis=-1)
    lines, back = np.unique(codes, axis=0, return_inverse=True)
    back = back.ravel()
    first, last = (np.stack(place(lines[:, k]), axis=-1) for k in (0, 1))
    at = [np.array([known[c] for c in lines[:, k].tolist()]) for k in (0, 1)]

    def along(s: FloatArray, which: IntArray) -> FloatArray:
        nonlocal asked
        asked += s.size
        p = first[which] + s[:, None] * (last - first)[which]
        return np.asarray(margin(p[:, 0], p[:, 1]))

    s = _zero(along, at[0], at[1], tolerance=tolerance)
    points = (first + s[:, None] * (last - first))[back]
    # Cells have two cuts, or four at a saddle: edges then pair up in the order they come.
    pieces = points[: len(points) // 2 * 2].reshape(-1, 2, 2)
    size = np.array([(x[1] - x[0]) / nx, (y[1] - y[0]) / ny])
    return ZeroContour(segments=pieces, evaluations=asked, cell_size=size)


@dataclass(frozen=True, slots=True, kw_only=True)
class InstabilityTongue:
    """A zone that narrows to a tip.

    Attributes
    ----------
    tip : (2,)
        x and y of its lowest point; on the edge of the rectangle where it reaches that.
    low, high : (rows, 2)
        Its edges on the side of small and of large x, from the top to the tip.
    """

    tip: FloatArray
    low: FloatArray
    high: FloatArray

    @property
    def outline(self) -> FloatArray:
        """The line round it, (2 rows - 1, 2), down one side and up the other."""
        return np.concatenate([self.low, self.high[-2::-1]])


def instability_tongue(
    margin: MarginFunction,
    *,
    centre: float,
    x: tuple[float, float],
    y: tuple[float, float],
    reach: float = 0.05,
    rows: int = 24,
    tolerance: float = 1e-7,
) -> InstabilityTongue | None:
    """Follow a zone of positive margin downwards, from the top of a rectangle to its tip.

    A zone closes like a parabola: near its tip it is narrower than any grid, and a chart by
    cells alone draws it too short. Here each row is searched where the one above it had the
    crest, as closely as that one was wide.

    Parameters
    ----------
    margin
        As for `zero_contour`.
    centre
        x at which theory has the zone: where a combination of frequencies is met.
    x, y
        The rectangle; the zone is widest at its top.
    reach
        How far from the centre the crest is looked for at the top, as a share of the rectangle.
    rows
        To the tip, closer together towards it.
    tolerance
        Of the tip's height, as a share of the rectangle.

    Returns
    -------
    InstabilityTongue
        None if no point of the top row near the centre is in a zone.
    """

    def crest(at: float, middle: float, half: float) -> tuple[float, float]:
        """Return where a row's margin is largest about a place, and how large."""
        samples, best, value = 33, 0, np.array([-np.inf])
        for _ in range(6):
            grid = np.linspace(max(middle - half, x[0]), min(middle + half, x[1]), samples)
            value = np.asarray(margin(grid, np.full(samples, at)))
            best = int(np.nanargmax(value))
            middle, half = float(grid[best]), 2 * half / (samples - 1) * 1.5
            if value[best] > 0 and half < 1e-3 * (x[1] - x[0]):
                break
        return middle, float(value[best])

    def sides(at: float, inside: float, step: float) -> tuple[float, float]:
        """Return both edges of the zone about a place inside."""
        away = step * 1.6 ** np.arange(24)
        way = np.clip(inside + np.array([-1.0, 1.0])[:, None] * away, *x).astype(np.float64)
        value = np.asarray(margin(way.ravel(), np.full(way.size, at))).reshape(way.shape)
        first = np.where((value <= 0).any(-1), (value <= 0).argmax(-1), way.shape[-1] - 1)
        pick = np.arange(2), first
        far, out = way[pick], value[pick]
        near: FloatArray = np.where(first > 0, way[np.arange(2), first - 1], inside)
        ends: FloatArray = np.asarray(margin(near, np.full(2, at)))
        closed = out <= 0  # else the zone reaches the rectangle's side

        def along(s: FloatArray, which: IntArray) -> FloatArray:
            return np.asarray(margin((near[which] + s * (far - near)[which]), np.full(s.size, at)))

        shut = np.where(closed, out, -ends).astype(float)
        s = np.where(closed, _zero(along, np.asarray(ends, np.float64), shut, tolerance=1e-9), 1.0)
        low, high = (near + s * (far - near)).tolist()
        return low, high

    size = x[1] - x[0]
    place, value = crest(y[1], centre, reach * size)
    if not value > 0:
        return None
    low: list[tuple[float, float]] = []
    high: list[tuple[float, float]] = []

    def row(at: float, inside: float, step: float) -> float:
        """Add a row's edges; return how wide the zone is there."""
        left, right = sides(at, inside, step)
        low.append((left, at))
        high.append((right, at))
        return right - left

    wide = row(y[1], place, 1e-3 * size)
    open_at, step = y[1], (y[1] - y[0]) / rows
    while open_at - step > y[0] and step > tolerance * (y[1] - y[0]):
        middle = (low[-1][0] + high[-1][0]) / 2
        if len(low) > 1:  # the crest bends: on from where the last two rows point
            before = (low[-2][0] + high[-2][0]) / 2
            middle += (middle - before) * step / max(low[-2][1] - low[-1][1], 1e-300)
        found, value = crest(open_at - step, middle, 0.75 * wide)
        if value > 0:
            open_at -= step
            place, wide = found, row(open_at, found, 0.05 * wide)
        else:
            step /= 2
    if open_at - step <= y[0] and step > tolerance * (y[1] - y[0]):
        found, value = crest(y[0], place, 0.75 * wide)
        if value > 0:
            row(y[0], found, 0.05 * wide)
    tip = np.array([place, low[-1][1]])
    return InstabilityTongue(tip=tip, low=np.array(low), high=np.array(high))


def find_zeros(
    margin: Callable[[FloatArray], FloatArray],
    *,
    between: tuple[float, float],
    start: int = 200,
    tolerance: float = 1e-10,
) -> FloatArray:
    """All zeros (zeros,) of a margin along one parameter that `start` samples can separate.

    None is looked for next to samples that are nan, which could not be solved.
    """
    grid = np.linspace(*between, start + 1)
    value = np.asarray(margin(grid))
    known = np.isfinite(value)
    at = np.flatnonzero(((value[:-1] > 0) != (value[1:] > 0)) & known[:-1] & known[1:])
    low, width = grid[at], grid[at + 1] - grid[at]
    s = _zero(
        lambda s, which: np.asarray(margin(low[which] + s * width[which])),
        value[at],
        value[at + 1],
        tolerance=tolerance,
    )
    return low + s * width

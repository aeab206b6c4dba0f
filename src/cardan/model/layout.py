"""Where a line runs: joint centres and member directions, in the vehicle's frame.

x points rearward, y to the vehicle's right, z up. Member 0 is the gearbox output, members
1 to n-1 are the shafts, member n is the pinion; joint k sits between members k-1 and k.
"""

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray, stack_on_last_axis
from cardan.core.lazy_dataclass import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """Joint centres and member directions; cases on leading axes.

    Attributes
    ----------
    points : (..., n, 3) m
        Joint centres, gearbox first.
    directions : (..., n+1, 3) 1
        Unit vectors of the members, pointing rearward.
    """

    points: FloatArray
    directions: FloatArray

    @property
    def lengths(self) -> FloatArray:
        """Distances between neighbouring joint centres, (..., n-1) m."""
        return vector_length(np.diff(self.points, axis=-2))

    @property
    def side(self) -> FloatArray:
        """Side-view slopes, (..., n+1) rad: down to the rear is positive."""
        d = self.directions
        return np.arctan2(-d[..., 2], d[..., 0])

    @property
    def top(self) -> FloatArray:
        """Top-view slopes, (..., n+1) rad: to the right going rearward is positive."""
        d = self.directions
        return np.arctan2(d[..., 1], d[..., 0])

    def __getitem__(self, case: object) -> "Layout":
        """Return the layout of some of the cases on the leading axes."""
        return Layout(points=self.points[case], directions=self.directions[case])  # type: ignore[index]


def vector_length(vector: FloatArray) -> FloatArray:
    """Return how long vectors (..., 3) are, (...)."""
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    return np.sqrt(x * x + y * y + z * z)


def unit_vector(vector: ArrayLike) -> FloatArray:
    """Return vectors (..., 3) scaled to length 1."""
    vector = np.asarray(vector, dtype=float)
    return vector / vector_length(vector)[..., None]


def direction_from_slopes(*, side: ArrayLike, top: ArrayLike) -> FloatArray:
    """Return unit vectors (..., 3) of members with side and plan view slopes (...) rad.

    A slope is the angle seen in its view, so d is along (1, tan top, -tan side).
    """
    side, top = np.broadcast_arrays(np.asarray(side, float), np.asarray(top, float))
    return unit_vector(stack_on_last_axis((1.0, np.tan(top), -np.tan(side))))


def layout_from_slopes(*, side: ArrayLike, top: ArrayLike, lengths: ArrayLike) -> Layout:
    """Return the layout of members with given slopes (..., n+1) rad and shafts (..., n-1) m.

    The first joint is the origin.
    """
    directions = direction_from_slopes(side=side, top=top)
    lengths = np.asarray(lengths, dtype=float)
    steps = lengths[..., None] * directions[..., 1:-1, :]
    start = np.zeros_like(steps[..., :1, :])
    return Layout(
        points=np.concatenate([start, np.cumsum(steps, axis=-2)], axis=-2), directions=directions
    )


def layout_from_joint_angles(*, side: ArrayLike, top: ArrayLike, lengths: ArrayLike) -> Layout:
    """Return the layout of view angles at the joints (..., n) rad, the gearbox level.

    An angle is the change of slope at its joint, as application sheets tabulate it.
    """
    side, top = (
        np.insert(np.cumsum(np.asarray(a, dtype=float), axis=-1), 0, 0.0, axis=-1)
        for a in (side, top)
    )
    return layout_from_slopes(side=side, top=top, lengths=lengths)


def layout_from_points(points: ArrayLike, *, gearbox: ArrayLike, pinion: ArrayLike) -> Layout:
    """Return the layout through joint centres (..., n, 3) m between two flange directions.

    `gearbox` and `pinion` are vectors (..., 3) along the flanges, pointing rearward.
    """
    points = np.asarray(points, dtype=float)
    members = shaft_and_end_directions(
        unit_vector(gearbox), unit_vector(np.diff(points, axis=-2)), unit_vector(pinion)
    )
    return Layout(points=points, directions=members)


def shaft_and_end_directions(
    gearbox: FloatArray, shafts: FloatArray, pinion: FloatArray
) -> FloatArray:
    """Return the directions of all members (..., n+1, 3) of shafts (..., n-1, 3) and ends."""
    members = [gearbox, *(shafts[..., k, :] for k in range(shafts.shape[-2])), pinion]
    return _side_by_side(members)


def joint_centres_from_bearings(
    first: ArrayLike, bearings: ArrayLike, last: ArrayLike, *, lengths: ArrayLike
) -> FloatArray:
    """Return the joint centres (..., n, 3) m of a line hung on its bearings.

    What the frame holds stays: the first joint (..., 3) and the bearing centres
    (..., n-2, 3). Each hung shaft runs from its front joint through its bearing with its
    own length, `lengths` (..., n-2) m, so the chain stays connected whatever moves; the
    last shaft takes up the rest in its spline.
    """
    points = [np.asarray(first, dtype=float)]
    bearings, lengths = np.asarray(bearings, dtype=float), np.asarray(lengths, dtype=float)
    for k in range(bearings.shape[-2]):
        along = unit_vector(bearings[..., k, :] - points[-1])
        points.append(points[-1] + lengths[..., k, None] * along)
    points.append(np.asarray(last, dtype=float))
    return _side_by_side(points)


def _side_by_side(vectors: list[FloatArray]) -> FloatArray:
    """Return vectors (..., 3) of each joint or member together, (..., n, 3)."""
    found = np.stack(np.broadcast_arrays(*vectors))
    return np.moveaxis(found, 0, -2)

"""How a line follows what carries it: axle and centre bearings move, the chain stays connected."""

from dataclasses import replace

import numpy as np

from cardan.core.arrays import ArrayLike, BoolArray, FloatArray, stack_on_last_axis
from cardan.core.errors import DesignError
from cardan.core.lazy_dataclass import dataclass
from cardan.model.layout import (
    Layout,
    joint_centres_from_bearings,
    shaft_and_end_directions,
    unit_vector,
    vector_length,
)
from cardan.model.parts import Line


@dataclass(frozen=True, kw_only=True)
class AxleMotion:
    """How an axle moves and what rides on it, in the line's own frame.

    Attributes
    ----------
    shift : (..., 3) m
        Of the wheel centre.
    pitch : (...) rad
        About y: the nose of a pinion that faces the gearbox rises.
    joint_offset : (..., 3) m
        From the wheel centre to the joint the axle carries, before it moves.
    lead_shift : (..., 3) m
        What the axle ahead, where joint 1 leaves one, has moved more than this one.
    lead_pitch : (...) rad
        What that has pitched more.
    """

    shift: ArrayLike = 0.0
    pitch: ArrayLike = 0.0
    joint_offset: ArrayLike = (0.0, 0.0, 0.0)
    lead_shift: ArrayLike = (0.0, 0.0, 0.0)
    lead_pitch: ArrayLike = 0.0

    def of_axle_ahead(self, arm: FloatArray) -> "AxleMotion":
        """Return the motion of the axle ahead, its joint (..., 3) m from its wheel centre."""
        return AxleMotion(
            shift=np.asarray(self.shift, dtype=float) + np.asarray(self.lead_shift, dtype=float),
            pitch=np.asarray(self.pitch, dtype=float) + np.asarray(self.lead_pitch, dtype=float),
            joint_offset=arm,
        )

    def where(self, chosen: BoolArray, other: "AxleMotion") -> "AxleMotion":
        """Return this motion where `chosen` (..., S) holds, another elsewhere; arms are alike."""

        def pick(mine: ArrayLike, its: ArrayLike, at: BoolArray) -> ArrayLike:
            return mine if mine is its else np.where(at, mine, its)

        return replace(
            self,
            shift=pick(self.shift, other.shift, chosen[..., None]),
            pitch=pick(self.pitch, other.pitch, chosen),
            lead_shift=pick(self.lead_shift, other.lead_shift, chosen[..., None]),
            lead_pitch=pick(self.lead_pitch, other.lead_pitch, chosen),
        )

    def displace(self, point: FloatArray, along: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return where a joint centre and a member's direction (..., 3) have gone."""
        arm = np.asarray(self.joint_offset, dtype=float)
        swing = _pitched(arm, self.pitch) - arm
        return point + np.asarray(self.shift, dtype=float) + swing, _pitched(along, self.pitch)


def _pitched(vector: FloatArray, pitch: ArrayLike) -> FloatArray:
    """Vectors (..., 3) turned about y by (...) rad: what points against x rises."""
    sin, cos = np.sin(pitch), np.cos(pitch)
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    return stack_on_last_axis((x * cos + z * sin, y, z * cos - x * sin))


def _turned(
    layout: Layout, bearing_shift: ArrayLike, last_shift: ArrayLike, pitch: ArrayLike
) -> Layout:
    """Return a layout without given lengths: only its pinion can turn where it is."""
    if np.any(np.asarray(bearing_shift) != 0) or np.any(np.asarray(last_shift) != 0):
        msg = "what moves a bearing or the axle needs length_mm of every shaft"
        raise DesignError(msg)
    d = layout.directions
    ride = AxleMotion(shift=np.zeros(3), pitch=pitch, joint_offset=np.zeros(3))
    _, pinion = ride.displace(np.zeros(3), d[..., -1, :])
    turned = shaft_and_end_directions(d[..., 0, :], d[..., 1:-1, :], pinion)
    points = np.broadcast_to(layout.points, (*turned.shape[:-2], *layout.points.shape[-2:]))
    return Layout(points=points, directions=turned)


def layout_after_axle_motion(
    layout: Layout,
    line: Line,
    *,
    bearing_shift: ArrayLike = 0.0,
    last_shift: ArrayLike = 0.0,
    pinion_pitch: ArrayLike = 0.0,
    pinion_arm: ArrayLike = (0.0, 0.0, 0.0),
    first: AxleMotion | None = None,
) -> Layout:
    """Layout after axle and centre bearings have moved; the chain stays connected.

    The frame holds joint 1, the gearbox's direction and the bearing centres. Each hung shaft
    keeps its length and runs from its front joint through its bearing; the last joint and
    the pinion go with the axle, and the last shaft takes up what is left. Where nothing
    moves, nothing changes.

    Parameters
    ----------
    layout : (..., n, 3) m
        Where the line runs before. Its own distances are the lengths that are kept.
    line
        Says where on its shaft each bearing sits.
    bearing_shift : (..., n-2, 3) m
        Of each centre bearing.
    last_shift : (..., 3) m
        Of the wheel centre (of the last joint, without pitch or arm).
    pinion_pitch : (...) rad
        Of the axle about y, the pinion's nose rising.
    pinion_arm : (..., 3) m
        From the wheel centre to the last joint, before.
    first
        The ride of joint 1 and the member before it, where an axle carries those too.

    Returns
    -------
    Layout
        Leading axes are those of all arguments, broadcast: variants and states at once.

    Notes
    -----
    A bearing lets its shaft slide and tilt in it. Yoke phases belong to the shafts and stay.
    Derived.
    """
    points, d = layout.points, layout.directions
    if not line.has_lengths:
        return _turned(layout, bearing_shift, last_shift, pinion_pitch)
    steps = np.diff(points, axis=-2)[..., :-1, :]
    lengths = vector_length(steps)
    behind = stack_on_last_axis(
        s.centre_bearing.from_rear_joint for s in line.shafts if s.centre_bearing
    )
    back = behind / lengths
    bearings = points[..., 1:-1, :] - back[..., None] * steps
    front, gearbox = points[..., 0, :], d[..., 0, :]
    if first is not None:
        front, gearbox = first.displace(front, gearbox)
    axle = AxleMotion(shift=last_shift, pitch=pinion_pitch, joint_offset=pinion_arm)
    last, pinion = axle.displace(points[..., -1, :], d[..., -1, :])
    new = joint_centres_from_bearings(
        front, bearings + np.asarray(bearing_shift, dtype=float), last, lengths=lengths
    )
    return Layout(
        points=new,
        directions=shaft_and_end_directions(gearbox, unit_vector(np.diff(new, axis=-2)), pinion),
    )

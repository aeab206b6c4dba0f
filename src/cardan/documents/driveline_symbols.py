"""Parts of a driveline as they are drawn in its views: tubes, yokes, crosses, flanges, bearings.

Positions are pixels of the page; `along` is the unit vector of a member on the page, away from
the joint. What a part measures across is true to the scale along the line, whatever the view
exaggerates: offsets are, thickness never.
"""

from collections.abc import Iterator

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.model.parts import JointKind
from cardan.render import svg
from cardan.render.svg import SECONDARY_COLOUR, SERIES_COLOURS, TEXT_COLOUR, VERDICT_COLOURS

STEEL_COLOUR, DARK_STEEL_COLOUR, END_COLOUR = "#c4d2df", "#9db4c8", "#dcdfe4"
EAR_HALF_HEIGHTS_PX = (13.0, 24.0)
YOKE_LENGTH_TO_HALF_HEIGHT = 1.7
CROSS_RADIUS_PX = 4.0
EXTENSION_PX, ARC_RADIUS_PX = 74.0, 62.0
"""How far a member's axis is drawn on beyond a joint, and where its angle is marked on it."""
FRAME_GAP_PX = 30.0
"""From the highest centre bearing to the frame, which no file places."""
LEAST_SHARE = 0.05


def ear_half_height(thickness: float) -> float:
    """Return how far a yoke's ears reach from its axis, px, of a tube so thick."""
    return float(np.clip(0.55 * thickness, *EAR_HALF_HEIGHTS_PX))


def _placed(at: FloatArray, along: FloatArray, points: list[tuple[float, float]]) -> FloatArray:
    """Return points (n, 2) px given as distances along a member and to its left."""
    across = np.array([-along[1], along[0]])
    return np.array([at + a * along + b * across for a, b in points])


def _outline(points: FloatArray, *, fill: str, stroke: str, stroke_width: float) -> str:
    x, y = points.T
    return svg.path(x, y, close=True, fill=fill, stroke=stroke, stroke_width=stroke_width)


def tube(start: FloatArray, end: FloatArray, thickness: float, *, is_shaft: bool) -> str:
    """Return a tube, or the end of a gearbox or axle, between two points."""
    length = float(np.hypot(*(end - start)))
    if length < 1.0:
        return ""
    half = thickness / 2
    corners = [(0.0, -half), (length, -half), (length, half), (0.0, half)]
    return _outline(
        _placed(start, (end - start) / length, corners),
        fill=STEEL_COLOUR if is_shaft else END_COLOUR, stroke=SECONDARY_COLOUR, stroke_width=0.8,
    )  # fmt: skip


def yoke(
    joint: FloatArray, along: FloatArray, *, length: float, half_height: float, pin: float
) -> Iterator[str]:
    """Yield a yoke whose pins stand `pin` rad out of the page's plane: a fork, or its ear's face.

    In between both, each as large as it is seen.
    """
    seen, faced = abs(np.cos(pin)), abs(np.sin(pin))
    if faced > LEAST_SHARE:
        half = 0.55 * half_height * faced
        face = [(-5.0, -half), (length * 0.7, -half), (length, -half * 0.6),
                (length, half * 0.6), (length * 0.7, half), (-5.0, half)]  # fmt: skip
        yield _outline(_placed(joint, along, face), fill=DARK_STEEL_COLOUR,
                       stroke=TEXT_COLOUR, stroke_width=1)  # fmt: skip
    if seen > LEAST_SHARE:
        h = half_height * seen
        inner = h * 0.68
        fork = [(-4.0, h), (length * 0.6, h), (length, h * 0.5), (length, -h * 0.5),
                (length * 0.6, -h), (-4.0, -h), (-4.0, -inner), (length * 0.5, -inner),
                (length * 0.72, 0.0), (length * 0.5, inner), (-4.0, inner)]  # fmt: skip
        yield _outline(_placed(joint, along, fork), fill=DARK_STEEL_COLOUR,
                       stroke=TEXT_COLOUR, stroke_width=1)  # fmt: skip
        (x1, x2), (y1, y2) = _placed(joint, along, [(0.0, h + 3), (0.0, -h - 3)]).T
        yield svg.line(x1, y1, x2, y2, stroke=SERIES_COLOURS[1], stroke_width=1.2)


def joint_centre(
    joint: FloatArray, along: FloatArray, kind: JointKind, *, half_height: float
) -> Iterator[str]:
    """Yield the middle of a joint: a cross, the ball of a constant-velocity joint, a disc."""
    x, y = joint
    if kind == "flexible disc":
        h = half_height
        across = _placed(joint, along, [(-3.0, -h), (3.0, -h), (3.0, h), (-3.0, h)])
        yield _outline(across, fill=SECONDARY_COLOUR, stroke=TEXT_COLOUR, stroke_width=1)
    elif kind != "cross":
        yield svg.circle(
            x, y, 0.75 * half_height, fill=DARK_STEEL_COLOUR, stroke=TEXT_COLOUR, stroke_width=1.2
        )
        if kind == "double cardan":
            for a, b in _placed(joint, along, [(-5.0, 0.0), (5.0, 0.0)]):
                yield svg.circle(a, b, 2.5, fill="#ffffff", stroke=TEXT_COLOUR)
    yield svg.circle(x, y, CROSS_RADIUS_PX, fill="#ffffff", stroke=TEXT_COLOUR, stroke_width=1.4)


def flange(joint: FloatArray, along: FloatArray, *, length: float, half_height: float) -> str:
    """Return the companion flange that the yoke of a gearbox or an axle is bolted to."""
    h = half_height
    corners = [(length, -h), (length + 5, -h), (length + 5, h), (length, h)]
    return _outline(_placed(joint, along, corners), fill=SECONDARY_COLOUR,
                    stroke=TEXT_COLOUR, stroke_width=1)  # fmt: skip


def operating_angle(joint: FloatArray, before: FloatArray, after: FloatArray) -> Iterator[str]:
    """Yield a joint's angle in the view: the axis drawn on straight, and an arrow off it."""
    straight = joint + EXTENSION_PX * before
    yield svg.line(*joint, *straight, stroke=SERIES_COLOURS[1], stroke_width=0.9,
                   stroke_dasharray="4 3")  # fmt: skip
    start, turn = np.arctan2(before[1], before[0]), float(
        np.arctan2(before[0] * after[1] - before[1] * after[0], before @ after)
    )  # fmt: skip
    round_ = start + turn * np.linspace(0.0, 1.0, 9)
    x, y = joint[0] + ARC_RADIUS_PX * np.cos(round_), joint[1] + ARC_RADIUS_PX * np.sin(round_)
    if abs(turn) * ARC_RADIUS_PX > 1.0:
        yield svg.path(x[:-1], y[:-1], stroke=SERIES_COLOURS[1], stroke_width=1.2)
        yield svg.arrow(x[-2], y[-2], x[-1], y[-1], size=6, stroke=SERIES_COLOURS[1])


def centre_bearing(
    at: FloatArray, thickness: float, *, frame_y: float | None, is_on_rubber: bool
) -> Iterator[str]:
    """Yield a centre bearing in its rubber and its bracket, up to the frame if there is one."""
    colour, half = VERDICT_COLOURS["pass"], thickness / 2 + 7
    x, y = at
    for side in (-1, 1):
        edge = y + side * thickness / 2
        yield svg.rect(x - 4, edge, 8, side * 3, fill=TEXT_COLOUR)  # the bearing's ring
        if is_on_rubber:
            yield svg.rect(x - 6, edge + side * 3, 12, side * 4, fill=SECONDARY_COLOUR)
    yield svg.rect(x - 7, y - half, 14, 2 * half, fill="none", stroke=colour, stroke_width=2)
    if frame_y is not None:
        yield svg.line(x, y - half, x, frame_y, stroke=colour, stroke_width=2)
        yield svg.line(x - 12, frame_y, x + 12, frame_y, stroke=colour, stroke_width=3)


def frame(x1: float, x2: float, y: float, said: str) -> Iterator[str]:
    """Yield the lower edge of the frame that centre bearings hang on; its height is no input."""
    yield svg.line(x1, y - 2, x2, y - 2, stroke=SECONDARY_COLOUR, stroke_width=1.2,
                   stroke_dasharray="14 4 2 4")  # fmt: skip
    yield svg.text(x1, y - 6, said, font_size=10.5, fill=SECONDARY_COLOUR)

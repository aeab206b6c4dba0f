"""Drawings of a line: where it runs, how its yokes stand, how its joints add up.

Side view as seen from the vehicle's left (rear to the right, up is up), plan view from
above (rear to the right, the vehicle's right up), end views looking forward from the axle.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from cardan.checks.line_response import LineResponse
from cardan.core.arrays import ComplexArray, FloatArray
from cardan.core.errors import DesignError
from cardan.core.labels import Part
from cardan.core.units import deg, mm
from cardan.core.verdict import Check, worst_first_key
from cardan.documents import driveline_symbols as symbols
from cardan.documents.yoke_phasing_drawing import yoke_phasing_drawing
from cardan.model.application import Obstacle
from cardan.model.layout import Layout
from cardan.model.parts import CentreBearing
from cardan.physics.kinematics.equivalent_angle import ae7_phasor_terms
from cardan.physics.kinematics.joint_chain import joint_angles
from cardan.render import svg
from cardan.render.chart import Chart, DataSeries
from cardan.render.fonts import truncate
from cardan.render.i18n import Translator
from cardan.render.label_placement import Box, LabelPlacer, bar_boxes, text_box
from cardan.render.phrases import check_state_phrase
from cardan.render.svg import (
    GRID_COLOUR,
    HALO,
    SECONDARY_COLOUR,
    SERIES_COLOURS,
    TEXT_COLOUR,
    VERDICT_COLOURS,
    Figure,
)
from cardan.topics.design.suspension_travel import line_at_operating_point

DRAWING_WIDTH_PX = 780.0
"""On a page of A4 letters of 11 px are then 7 pt high."""
MARGIN_LEFT_PX, MARGIN_RIGHT_PX, MARGIN_TOP_PX, MARGIN_BOTTOM_PX = 24.0, 160.0, 18.0, 46.0
MAX_VIEW_HEIGHT_PX = 250.0
"""Height a view may take, pixels; what is left of it is used to exaggerate."""

VERTICAL_EXAGGERATIONS = (10, 5, 2, 1)
MAX_STATE_VIEW_HEIGHT_PX = 90.0
"""The same of the view on the sheet to sign, whose letters are the larger the lower it is."""
MAX_THICKNESS_PX = 46.0
"""How thick the thickest tube may be drawn: a short line is drawn shorter than the page."""
DEFAULT_THICKNESS_M = 0.05
"""How thick a member is drawn whose tube is not known."""
LABEL_DROP_PX = 34.0
TUBE_GAP_PX = 6.0
MEASURE_PLACES = (0.5, 0.38, 0.62, 0.26, 0.74, 0.14, 0.86)
"""Shares of a member's length at which its slope and length may stand, best first."""
LEAST_OFFSET_M = 5e-4
"""How far a line must be from straight in a view to be worth drawing in it."""
LEAST_TURN = 5e-5
"""Angle, rad, from which a joint is drawn as bending up or down: what three digits show."""
MAX_STATE_CHARACTERS = 22
"""Of the names of states at a pinion: what has room in the margin."""
END_STUB_TO_LINE_LENGTH_RATIO = 0.07
"""Length of the gearbox and pinion stubs drawn, over that of the line."""

UPWARD_AXIS_INDEX_BY_VIEW = {"side": 2, "top": 1}
"""The component that runs up the page in each view."""


def worst_state_index(response: LineResponse) -> int:
    """Return the number of the state that shakes most; where no speed is given, by angle."""
    joint = response.kinematics.excitation.torsional
    shakes = joint.angle if np.isnan(joint.acceleration).all() else joint.acceleration
    return int(np.nanargmax(shakes))


def state_to_draw(
    response: LineResponse, checks: Iterable[Check], name: str | None = None
) -> tuple[int, Check | None]:
    """Return the number of the state to draw: one of a name, else where the worst check is.

    And that check, if it was evaluated at an operating point. Without a check in a state it is the
    state which shakes most.
    """
    states = response.demand.states
    if name is not None:
        if name not in states:
            msg = f"there is no state {name} to draw; there are: {', '.join(states)}"
            raise DesignError(msg)
        return states.index(name), None
    mine = [c for c in checks if c.line == response.line.name and c.when.name in states]
    worst = min(mine, key=worst_first_key, default=None)
    if worst is None:
        return worst_state_index(response), None
    return states.index(worst.when.name), worst if worst.point else None


def _clearance_text(of: Obstacle, free: float, at: Check | None, say: Translator) -> str:
    """Return what room there is to an obstacle: that of the check, where it is about that."""
    if at and at.quantity == "clearance_on_rubber" and at.part.other == of.name:
        return say("{room} mm free on rubber", room=say.compact_number(at.value / mm, 4))
    return say("{room} mm free", room=say.compact_number(free / mm, 4))


def side_view_in_state(
    response: LineResponse, say: Translator, s: int, at: Check | None = None
) -> Figure:
    """Return the side view of a line in one state, tubes and obstacles true to scale.

    Wound up as at the operating point of a check there. The room an obstacle leaves in that
    state stands next to it.
    """
    if at and at.point:
        response = line_at_operating_point(response, at.point)
    layout, c = response.layout[s], UPWARD_AXIS_INDEX_BY_VIEW["side"]
    rise = float(np.broadcast_to(response.demand.travel, response.joint_angles.shape[:-1])[s])
    there = tuple(_obstacle_at_travel(o, rise) for o in response.inputs.obstacles)
    page = _view_scale(
        response, layout, layout, there, c, exaggerations=(1,), tallest=MAX_STATE_VIEW_HEIGHT_PX
    )
    angles = np.diff(layout.side)
    state = check_state_phrase(at, say) if at else say.state(response.demand.states[s])
    title = say("The line ({state}) from the left, true to scale", state=state)
    true = response.joint_angles[s]
    alt = f"{title}. " + "; ".join(
        f"{say.part(Part('joint', k))}: {say.compact_number(a / deg, 3)} deg"
        for k, a in enumerate(true, 1)
    )
    room = response.clearances.obstacle_clearances[s].min(axis=0) if there else ()
    said = [_clearance_text(o, float(free), at, say) for o, free in zip(there, room, strict=True)]
    labels = _labels(response, layout, page, there, c)
    joints = list(_joint_labels(layout, page, labels, c, true, angles, say))
    drawn = [
        *(_obstacle_bar(o, page, c) for o in there),
        *_line(response, layout, page, "side", say),
        *_measures(layout, page, labels, "side", say),
        *joints,
        *_obstacle_labels(there, said, page, labels, c),
        *_scale_bar(page, say),
    ]
    note = _operating_angle_note(response, say)
    return Figure(
        title=title,
        svg=svg.svg_document(DRAWING_WIDTH_PX, page.height, *drawn, alt=alt),
        alt=alt,
        note=note,
    )


def _operating_angle_note(response: LineResponse, say: Translator) -> str:
    said = say(
        "At each joint its operating angle and which way it bends in this view; on each shaft its "
        "slope and length."
    )
    yoke = say("The gearbox's yoke is drawn upright.")
    hung = any(s.centre_bearing for s in response.line.shafts)
    frame = (say("The frame's height is not given: it is drawn above the line."),) if hung else ()
    return " ".join((said, yoke, *frame))


def _obstacle_at_travel(o: Obstacle, rise: float) -> Obstacle:
    """Return an obstacle where the axle has risen by so much."""
    up = rise * o.travel_share
    (x1, y1, z1), (x2, y2, z2) = o.start, o.end
    return replace(o, start=(x1, y1, z1 + up), end=(x2, y2, z2 + up))


def has_known_geometry(response: LineResponse) -> bool:
    """Return whether it is known where the line runs, and not its slopes alone."""
    return response.line.has_lengths


def line_drawings(response: LineResponse, say: Translator) -> tuple[Figure, ...]:
    """Return every drawing of a line: views if it has lengths, no plan view if it is straight."""
    points = response.layout.points
    is_straight = float(np.ptp(points[..., UPWARD_AXIS_INDEX_BY_VIEW["top"]])) < LEAST_OFFSET_M
    names = ("side",) if is_straight else ("side", "top")
    names = names if has_known_geometry(response) else ()
    return (
        *(side_or_top_view_drawing(response, say, name=name) for name in names),
        yoke_phasing_drawing(response, say),
        joint_plane_drawing(response, say),
        phasor_drawing(response, say),
    )


@dataclass(frozen=True, kw_only=True)
class _ViewScale:
    """How metres become pixels in a view: along, up, and how much more up than along."""

    start: float
    low: float
    scale: float
    exaggeration: int
    height: float

    def x(self, along: float) -> float:
        return MARGIN_LEFT_PX + (along - self.start) * self.scale

    def y(self, up: float) -> float:
        return self.height - MARGIN_BOTTOM_PX - (up - self.low) * self.scale * self.exaggeration


def side_or_top_view_drawing(response: LineResponse, say: Translator, *, name: str) -> Figure:
    """Return the `side` or `top` view: as installed, the states behind it, what is in the way."""
    reference, layout = response.demand.installed.layout, response.layout
    c = UPWARD_AXIS_INDEX_BY_VIEW[name]
    obstacles = response.inputs.obstacles
    page = _view_scale(response, reference, layout, obstacles if name == "side" else (), c)
    is_side = name == "side"
    slopes = reference.side if is_side else reference.top
    angles = np.diff(slopes) if is_side else -np.diff(slopes)  # down the page is positive
    shown = joint_angles(reference.directions) if is_side else np.abs(angles)
    title = say("Side view, from the left") if is_side else say("Plan view")
    if page.exaggeration == 1:
        scale = say("to scale")
    else:
        scale = say("to scale, exaggerated {times} times across", times=page.exaggeration)
    alt = f"{title}, {scale}. " + "; ".join(
        f"{say.part(Part('joint', k))}: {say.compact_number(a / deg, 3)} deg"
        for k, a in enumerate(shown, 1)
    )
    labels = _labels(response, reference, page, obstacles, c)
    moves = float(np.abs(layout.points - reference.points).max()) > LEAST_OFFSET_M
    if moves:
        _take_state_lines(labels, layout, page, c)
    joints = list(_joint_labels(reference, page, labels, c, shown, angles, say))
    drawn = [
        *(_obstacle_bar(o, page, c) for o in obstacles),
        *(_states(response, page, c, say) if moves else ()),
        *_line(response, reference, page, name, say),
        *_measures(reference, page, labels, name, say),
        *joints,
        *_obstacle_labels(obstacles, _least_clearance_texts(response, say), page, labels, c),
        *_scale_bar(page, say),
    ]
    bend = (
        _operating_angle_note(response, say)
        if is_side
        else say("At each joint its angle in this view, on each shaft its slope and length.")
    )  # fmt: skip
    note = " ".join((
        *((say("Bold: as installed. Light: the states, named at the pinion."),) if moves else ()),
        bend,
        *((say("Offsets are exaggerated, tubes are not."),) if page.exaggeration > 1 else ()),
    ))  # fmt: skip
    return Figure(
        title=f"{title}, {scale}",
        svg=svg.svg_document(DRAWING_WIDTH_PX, page.height, *drawn, alt=alt),
        alt=alt,
        note=note,
    )


def _view_scale(
    response: LineResponse,
    reference: Layout,
    layout: Layout,
    obstacles: tuple[Obstacle, ...],
    c: int,
    *,
    exaggerations: Sequence[int] = VERTICAL_EXAGGERATIONS,
    tallest: float = MAX_VIEW_HEIGHT_PX,
) -> _ViewScale:
    """Return the scales of a view in which everything has room."""
    thick = max(s.tube.outer if s.tube else DEFAULT_THICKNESS_M for s in response.line.shafts)
    points = np.concatenate(
        [reference.points[None], layout.points.reshape(-1, *reference.points.shape)]
    )
    along, up = points[..., 0], points[..., c]
    length = float(np.ptp(along))
    near = [
        (p[c] - o.radius, p[c] + o.radius)
        for o in obstacles
        for p in (o.start, o.end)
        if abs(p[c] - up.mean()) < 0.3 * length
    ]
    low = min([float(up.min()), *(a for a, _ in near)])
    high = max([float(up.max()), *(b for _, b in near)])
    scale = min(
        (DRAWING_WIDTH_PX - MARGIN_LEFT_PX - MARGIN_RIGHT_PX)
        / (length * (1 + 2 * END_STUB_TO_LINE_LENGTH_RATIO)),
        MAX_THICKNESS_PX / thick,
        (tallest - 2 * TUBE_GAP_PX) / (high - low + thick),
    )
    # Tubes are as thick whatever the offsets are exaggerated by.
    around = thick * scale + 2 * TUBE_GAP_PX
    times = next((k for k in exaggerations if (high - low) * scale * k + around <= tallest), 1)
    hangs = c == UPWARD_AXIS_INDEX_BY_VIEW["side"] and bool(_hung_bearings(response))
    top = MARGIN_TOP_PX + (symbols.FRAME_GAP_PX if hangs else 0.0)
    tall = (high - low) * scale * times + around + LABEL_DROP_PX
    height = tall + top + MARGIN_BOTTOM_PX
    return _ViewScale(
        start=float(along.min()) - END_STUB_TO_LINE_LENGTH_RATIO * length,
        low=low - (around / 2 + LABEL_DROP_PX) / (scale * times),
        scale=scale,
        exaggeration=times,
        height=height,
    )


def _ends(layout: Layout) -> FloatArray:
    """Return the points of a line with its gearbox and pinion stubs, (..., n+2, 3)."""
    points, d = layout.points, layout.directions
    stub = END_STUB_TO_LINE_LENGTH_RATIO * np.linalg.norm(
        points[..., -1:, :] - points[..., :1, :], axis=-1, keepdims=True
    )
    first = points[..., :1, :] - stub * d[..., :1, :]
    last = points[..., -1:, :] + stub * d[..., -1:, :]
    return np.concatenate([first, points, last], axis=-2)


def _states(response: LineResponse, page: _ViewScale, c: int, say: Translator) -> Iterator[str]:
    """Yield every state as a light line, and names with leaders next to their pinions."""
    lines = _ends(response.layout)
    names = [say.state(s) for s in response.demand.states]
    ends: dict[tuple[float, float], list[str]] = {}
    for points, name in zip(lines, names, strict=True):
        x, y = [page.x(p) for p in points[:, 0]], [page.y(p) for p in points[:, c]]
        yield svg.path(x, y, stroke=SERIES_COLOURS[5], stroke_width=1.1, stroke_opacity=0.75)
        ends.setdefault((round(float(x[-1])), round(float(y[-1]))), []).append(name)
    place = -np.inf
    for (x, y), said in sorted(ends.items(), key=lambda e: e[0][1]):
        place = max(y, place + 13)
        shown = ", ".join(said) if len(said) < 3 else f"{said[0]}, {said[1]} …"
        yield svg.path(
            [x + 2, x + 36, x + 40], [y, place, place], stroke=SECONDARY_COLOUR, stroke_width=0.6
        )
        yield svg.text(x + 43, place + 3.5, truncate(shown, MAX_STATE_CHARACTERS), font_size=10.5)


def _axis(page: _ViewScale, layout: Layout, c: int) -> tuple[FloatArray, FloatArray]:
    """Return a line's axis with its stubs on the page, (n+2, 2) px, and members' directions."""
    points = np.array([(page.x(p[0]), page.y(p[c])) for p in _ends(layout)])
    steps = np.diff(points, axis=0)
    return points, steps / np.linalg.norm(steps, axis=-1, keepdims=True)


def _thickness(response: LineResponse, member: int, page: _ViewScale) -> float:
    """Return how thick a member is drawn, px: true to the scale along the line."""
    shafts = response.line.shafts
    shaft = shafts[member - 1] if 0 < member <= len(shafts) else None
    wide = shaft.tube.outer if shaft and shaft.tube else DEFAULT_THICKNESS_M
    return max(wide * page.scale, 4.0)


def _line(
    response: LineResponse,
    layout: Layout,
    page: _ViewScale,
    name: str,
    say: Translator,
) -> Iterator[str]:
    """Yield a line with its parts and operating angles."""
    c = UPWARD_AXIS_INDEX_BY_VIEW[name]
    points, along = _axis(page, layout, c)
    kinds, last = response.line.joint_kinds, len(points) - 1
    room = np.linalg.norm(np.diff(points, axis=0), axis=-1)
    ear = symbols.ear_half_height(max(_thickness(response, k, page) for k in range(last)))
    yokes = np.minimum(symbols.YOKE_LENGTH_TO_HALF_HEIGHT * ear, 0.3 * room)
    for k in range(last):
        ends = (points[k] + (yokes[k] if k > 0 else 0.0) * along[k],
                points[k + 1] - (yokes[k] if k < last - 1 else 0.0) * along[k])  # fmt: skip
        yield symbols.tube(*ends, _thickness(response, k, page), is_shaft=0 < k < last - 1)
    yield svg.path(points[:, 0], points[:, 1], stroke=TEXT_COLOUR, stroke_width=0.8,
                   stroke_dasharray="12 3 2 3")  # fmt: skip
    yield from _bearings(response, layout, page, name, say)
    yield symbols.flange(points[1], -along[0], length=yokes[0], half_height=ear)
    yield symbols.flange(points[-2], along[-1], length=yokes[-1], half_height=ear)
    # The gearbox's yoke is taken upright, as it stands when a line is fitted.
    pin = 0.0 if name == "side" else np.pi / 2
    for k, kind in enumerate(kinds, 1):
        yield from symbols.operating_angle(points[k], along[k - 1], along[k])
        if kind == "cross":
            yield from symbols.yoke(
                points[k], -along[k - 1], length=yokes[k - 1], half_height=ear, pin=pin
            )
            yield from symbols.yoke(
                points[k], along[k], length=yokes[k], half_height=ear, pin=pin + np.pi / 2
            )
        yield from symbols.joint_centre(points[k], along[k], kind, half_height=ear)
        pin += np.pi / 2 + (response.line.shafts[k - 1].phase if k < len(kinds) else 0.0)


def _measures(
    layout: Layout, page: _ViewScale, labels: LabelPlacer, name: str, say: Translator
) -> Iterator[str]:
    """Yield each member's slope and length below the line, off what an obstacle covers."""
    points, _ = _axis(page, layout, UPWARD_AXIS_INDEX_BY_VIEW[name])
    slopes = layout.side if name == "side" else layout.top
    y = page.height - 26
    for k, slope in enumerate(slopes):
        said = f"{say.compact_number(slope / deg, 3)}°"
        if 0 < k < len(slopes) - 1:
            said += f" · {say.compact_number(layout.lengths[k - 1] / mm, 4)} mm"
        places = [points[k] + s * (points[k + 1] - points[k]) for s in MEASURE_PLACES]
        boxes = [text_box(p[0], y, (said,), font_size=11, anchor="middle") for p in places]
        at = places[labels.place(boxes)]
        yield svg.line(at[0], at[1], at[0], y - 11, stroke=GRID_COLOUR, stroke_width=0.8)
        yield svg.text(at[0], y, said, anchor="middle", font_size=11, **HALO)


def _labels(
    response: LineResponse,
    layout: Layout,
    page: _ViewScale,
    obstacles: Iterable[Obstacle],
    c: int,
) -> LabelPlacer:
    """Return the page of a view with what its parts and obstacles take of it."""
    points, _ = _axis(page, layout, c)
    labels = LabelPlacer(Box(0.0, 0.0, DRAWING_WIDTH_PX, page.height))
    ear = 2 * symbols.EAR_HALF_HEIGHTS_PX[0]
    for k in range(len(points) - 1):
        thick = max(_thickness(response, k, page), ear)
        labels.taken += bar_boxes(points[k], points[k + 1], thick)
    for o in obstacles:
        start, end = (np.array([page.x(p[0]), page.y(p[c])]) for p in (o.start, o.end))
        labels.taken += bar_boxes(start, end, _obstacle_width(o, page))
    return labels


def _take_state_lines(labels: LabelPlacer, layout: Layout, page: _ViewScale, c: int) -> None:
    """Keep labels off the light lines of the states."""
    for ends in _ends(layout):
        points = np.array([(page.x(p[0]), page.y(p[c])) for p in ends])
        for a, b in pairwise(points):
            labels.taken += bar_boxes(a, b, 2.0)


def _hung_bearings(response: LineResponse) -> list[tuple[int, CentreBearing]]:
    """Return the centre bearings with the indices of their shafts."""
    return [
        (k, shaft.centre_bearing)
        for k, shaft in enumerate(response.line.shafts[:-1])
        if shaft.centre_bearing
    ]


def _span_above(axis: FloatArray, y: float, around: FloatArray) -> tuple[float, float]:
    """Return from where to where a line (n, 2) px stays below a height, around places (k,)."""
    x = np.linspace(axis[0, 0], axis[-1, 0], 200)
    clear = np.interp(x, axis[:, 0], axis[:, 1]) >= y
    ahead = x[~clear & (x < around.min())]
    behind = x[~clear & (x > around.max())]
    return (
        float(ahead.max() if len(ahead) else x[0]), float(behind.min() if len(behind) else x[-1])
    )  # fmt: skip


def _bearings(
    response: LineResponse, layout: Layout, page: _ViewScale, name: str, say: Translator
) -> Iterator[str]:
    """Yield the centre bearings, hung on the frame."""
    c = UPWARD_AXIS_INDEX_BY_VIEW[name]
    hung = _hung_bearings(response)
    if not hung:
        return
    at = np.array([
        layout.points[k + 1] - bearing.from_rear_joint * layout.directions[k + 1]
        for k, bearing in hung
    ])  # fmt: skip
    places = np.array([(page.x(p[0]), page.y(p[c])) for p in at])
    thick = [_thickness(response, k + 1, page) for k, _ in hung]
    top = float(min(y - t / 2 for (_, y), t in zip(places, thick, strict=True)))
    frame_y = top - symbols.FRAME_GAP_PX if name == "side" else None
    if frame_y is not None:
        axis, _ = _axis(page, layout, c)
        start, end = _span_above(axis, frame_y + max(thick) / 2 + 8, places[:, 0])
        yield from symbols.frame(start, end, frame_y, say("frame"))
    for (k, bearing), place, t in zip(hung, places, thick, strict=True):
        yield from symbols.centre_bearing(
            place, t, frame_y=frame_y, is_on_rubber=bool(bearing.stiffness)
        )
        said = say.part(Part("centre bearing", k + 1))
        y = frame_y - 6 if frame_y is not None else place[1] - t / 2 - 12
        yield svg.text(
            place[0], y, said, anchor="middle", font_size=11, fill=VERDICT_COLOURS["pass"]
        )


def _joint_labels(
    layout: Layout,
    page: _ViewScale,
    labels: LabelPlacer,
    c: int,
    angles: FloatArray,
    turns: FloatArray,
    say: Translator,
) -> Iterator[str]:
    """Yield the joints' numbers and angles, with the way each bends up or down the page."""
    for k, (p, angle, turn) in enumerate(zip(layout.points, angles, turns, strict=True), 1):
        way = "" if abs(turn) < LEAST_TURN else " ↑" if turn < 0 else " ↓"
        said = f"{say.compact_number(angle / deg, 3)}°{way}"
        x, y = page.x(p[0]), page.y(p[c])
        places = [
            (x + right, y + drop)
            for drop in (LABEL_DROP_PX, -LABEL_DROP_PX, 1.5 * LABEL_DROP_PX, -1.5 * LABEL_DROP_PX)
            for right in (0.0, 18.0, -24.0)
        ]
        a, b = places[labels.place([_joint_label_box(*q, said) for q in places])]
        yield svg.circle(a - 14, b, 9, fill="#ffffff", stroke=TEXT_COLOUR, stroke_width=1.2)
        yield svg.text(a - 14, b + 4, str(k), anchor="middle", font_size=11, font_weight="bold")
        yield svg.text(a, b + 4, said, font_weight="bold", **HALO)


def _joint_label_box(x: float, y: float, said: str) -> Box:
    """Return the rectangle of a joint's number in its circle and its angle to the right."""
    text = text_box(x, y + 4, (said,), font_size=12)
    return Box(x - 24, y - 10, text.right, y + 10)


def _least_clearance_texts(response: LineResponse, say: Translator) -> list[str]:
    """Return the least room that any state leaves each obstacle."""
    said: list[str] = []
    for k in range(len(response.inputs.obstacles)):
        free = response.clearances.obstacle_clearances[..., k].min(-1)
        s = int(np.argmin(free))
        said.append(
            say(
                "{room} mm in {state}",
                room=say.compact_number(free[s] / mm, 4),
                state=say.state(response.demand.states[s]),
            )
        )
    return said


def _obstacle_width(o: Obstacle, page: _ViewScale) -> float:
    return max(2 * o.radius * page.scale, 3.0)


def _obstacle_bar(o: Obstacle, page: _ViewScale, c: int) -> str:
    """Return an obstacle."""
    (x1, y1), (x2, y2) = ((p[0], p[c]) for p in (o.start, o.end))
    return svg.path(
        [page.x(x1), page.x(x2) + 0.01],
        [page.y(y1), page.y(y2)],
        stroke="#c08a5a",
        stroke_width=_obstacle_width(o, page),
        stroke_linecap="round",
        stroke_opacity=0.55,
    )


def _obstacle_labels(
    obstacles: Sequence[Obstacle],
    said: Sequence[str],
    page: _ViewScale,
    labels: LabelPlacer,
    c: int,
) -> Iterator[str]:
    """Yield each obstacle's name with a text below it, next to it where nothing else stands."""
    for o, words in zip(obstacles, said, strict=True):
        half = _obstacle_width(o, page) / 2
        along = [page.x(p[0]) for p in (o.start, o.end)]
        across = np.clip([page.y(p[c]) for p in (o.start, o.end)], 0.0, page.height)
        middle, lines = float(across.mean()), (o.name, words)
        heights = np.linspace(across.min() - half, across.max() + half, 24)
        heights = heights[np.argsort(np.abs(heights - middle), kind="stable")]
        right, left = max(along) + half + 6, min(along) - half - 6
        places = [(x, float(y), anchor) for y in heights
                  for x, anchor in ((right, "start"), (left, "end"))]  # fmt: skip
        places += [(float(np.mean(along)), y, "middle")
                   for y in (across.max() + half + 14, across.min() - half - 18)]  # fmt: skip
        boxes = [text_box(x, y, lines, font_size=10.5, anchor=a) for x, y, a in places]
        x, y, anchor = places[labels.place(boxes)]
        for k, line in enumerate(lines):
            yield svg.text(
                x, y + 13 * k, line, anchor=anchor, font_size=10.5, fill="#7a4a1c", **HALO
            )


def _scale_bar(page: _ViewScale, say: Translator) -> Iterator[str]:
    """Yield a bar of a round length along the line."""
    size = next(m for m in (1.0, 0.5, 0.2, 0.1, 0.05) if m * page.scale < 320 or m == 0.05)
    y = page.height - 10
    x1, x2 = MARGIN_LEFT_PX, MARGIN_LEFT_PX + size * page.scale
    yield svg.path([x1, x1, x2, x2], [y - 4, y, y, y - 4], stroke=SECONDARY_COLOUR)
    said = f"{say.compact_number(size / mm)} mm"
    if page.exaggeration > 1:
        said += "  (" + say("along the line; {times}:1 across", times=page.exaggeration) + ")"
    yield svg.text(x2 + 6, y, said, font_size=10.5, fill=SECONDARY_COLOUR)


def joint_plane_drawing(response: LineResponse, say: Translator) -> Figure:
    """Return the joints' planes seen from behind: which way each bends, and how much."""
    s = worst_state_index(response)
    side, top = response.kinematics.side_angles[s] / deg, response.kinematics.top_angles[s] / deg
    reach = max(float(np.hypot(side, top).max()), 0.1) * 1.15
    chart = Chart(
        say=say,
        x=(-reach, reach),
        y=(-reach, reach),
        equal_aspect=True,
        width=460,
        height=380,
        x_label=say("bend to the right, plan view angle [deg]"),
        y_label=say("bend upward, − side view angle [deg]"),
    )
    for k, (bv, bh) in enumerate(zip(side, top, strict=True)):
        chart.add_elements(
            svg.arrow(
                *chart.point_to_pixels(0, 0),
                *chart.point_to_pixels(bh, -bv),
                stroke=SERIES_COLOURS[k % 7],
                stroke_width=2.2,
            )
        )
        chart.add_series(
            DataSeries(
                name=_joint_text(response, s, k, say),
                x=np.array([bh]),
                y=np.array([-bv]),
                draw_line=False,
                draw_markers=True,
                labels=(str(k + 1),),
            ),
            k,
        )
    title = say("Joint planes in {state}", state=say.state(response.demand.states[s]))
    alt = f"{title}. " + "; ".join(
        _joint_text(response, s, k, say) for k in range(response.line.joint_count)
    )
    note = say(
        "Seen from behind, looking forward: where each joint bends the line. Position φ is "
        "counted from the right, over down."
    )
    return chart.to_figure(title=title, alt=alt, note=note)


def _joint_text(response: LineResponse, s: int, k: int, say: Translator) -> str:
    """Return a joint with angle and position."""
    angle, position = (
        response.joint_angles[s, k] / deg,
        response.kinematics.joint_plane_positions[s, k] / deg,
    )
    part = say.part(Part("joint", k + 1))
    return f"{part}: β {say.compact_number(angle, 3)}°, φ {say.compact_number(position, 4)}°"


def phasor_drawing(response: LineResponse, say: Translator) -> Figure:
    """Return how the joints add up or cancel: AE-7's phasors of squared angles, head to tail."""
    s = worst_state_index(response)
    side, top, phases = response.kinematics.phasor_angles
    terms = ae7_phasor_terms(side[s], top[s], phases=phases)
    terms = terms / deg**2
    ends: ComplexArray = np.cumsum(np.concatenate([np.zeros_like(terms[:1]), terms]))
    total = ends[-1]
    radii: list[tuple[str, float]] = []
    speed = response.demand.speed[s]
    for limit in response.application.limits:
        if limit.quantity == "torsional_acceleration" and speed > 0:
            radii += [
                (grade, bound / speed**2 / deg**2)
                for grade, bound in (("warn", limit.normal), ("fail", limit.maximum))
                if bound is not None
            ]
    reach = 1.1 * max(
        [float(np.abs(ends).max()), 0.05, *(r for _, r in radii if r < 6 * np.abs(ends).max())]
    )
    chart = Chart(
        say=say,
        x=(-reach, reach),
        y=(-reach, reach),
        equal_aspect=True,
        width=460,
        height=380,
        x_label=say("along position 0 [deg²]"),
        y_label=say("along position 45 deg [deg²]"),
    )
    turn = np.linspace(0, 2 * np.pi, 97)
    for grade, radius in radii:
        if radius < 1.5 * reach:
            x, y = chart.to_pixels(radius * np.cos(turn), radius * np.sin(turn))
            inside = (np.abs(radius * np.cos(turn)) <= chart.x[1]) & (
                np.abs(radius * np.sin(turn)) <= chart.y[1]
            )
            x = np.where(inside, x, np.nan)
            chart.add_elements(
                svg.path(x, y, stroke=VERDICT_COLOURS[grade], stroke_dasharray="5 3")
            )
    # Joints in one plane add up along one line: drawn next to each other they can be distinguished.
    apart = 7.0 if float(np.ptp(ends.imag)) < 0.02 * float(np.ptp(ends.real)) else 0.0
    for k, (a, b) in enumerate(pairwise(ends)):
        (x1, y1), (x2, y2) = (
            chart.point_to_pixels(a.real, a.imag),
            chart.point_to_pixels(b.real, b.imag),
        )
        y1, y2 = y1 - apart * (k + 1), y2 - apart * (k + 1)
        chart.add_elements(
            svg.arrow(x1, y1, x2, y2, stroke=SERIES_COLOURS[k % 7], stroke_width=2.2)
        )
        chart.add_elements(
            svg.text(
                (x1 + x2) / 2,
                (y1 + y2) / 2 - 4,
                str(k + 1),
                font_size=11,
                fill=SERIES_COLOURS[k % 7],
            )
        )
        chart.add_legend_entry(say.part(Part("joint", k + 1)), k)
    chart.add_elements(
        svg.arrow(
            *chart.point_to_pixels(0, 0),
            *chart.point_to_pixels(total.real, total.imag),
            stroke=TEXT_COLOUR,
            stroke_width=3,
            size=12,
        )
    )
    state = say.state(response.demand.states[s])
    title = say("How the joints add up in {state}", state=state)
    angle = say.number(float(np.sqrt(abs(total))))
    note = say(
        "Each joint adds an arrow as long as its squared angle, turned by twice its position and "
        "by the yoke phases before it (AE-7). Black: the sum, equivalent angle {angle} deg. "
        "Dashed circles: limits of torsional acceleration at this speed.",
        angle=angle,
    )
    return chart.to_figure(title=title, alt=f"{title}. {note}", note=note)

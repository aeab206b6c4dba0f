"""How the yokes of each shaft stand to each other: what a workshop assembles them by."""

from collections.abc import Iterator

import numpy as np

from cardan.checks.line_response import LineResponse
from cardan.core.labels import Part
from cardan.core.units import deg
from cardan.render import svg
from cardan.render.i18n import Translator
from cardan.render.svg import SECONDARY_COLOUR, SERIES_COLOURS, TEXT_COLOUR, Figure

COLUMNS = 3
"""Shafts side by side; the drawing of one shaft is as wide, so that its yokes are no larger."""


def yoke_phasing_drawing(response: LineResponse, say: Translator) -> Figure:
    """Return how the yokes of each shaft stand to each other, for assembly."""
    shafts = response.line.shafts
    each = 240.0
    drawn: list[str] = []
    words: list[str] = []
    for k, shaft in enumerate(shafts):
        x = 10 + (k % COLUMNS) * (each + 20)
        y = 20 + (k // COLUMNS) * 190
        said = _phase_text(shaft.phase, say)
        words.append(f"{say.part(Part('shaft', k + 1))}: {said}")
        drawn += [
            svg.text(x, y, f"{say.part(Part('shaft', k + 1))}: {said}", font_weight="bold"),
            *_yoke_shapes(x, y + 55, each, shaft.phase),
            *_pin_axes_dial(x + each / 2, y + 128, shaft.phase, say),
        ]
    rows = -(-len(shafts) // COLUMNS)
    alt = say("Yoke phasing") + ". " + "; ".join(words)
    note = say(
        "Pin axis: the axis of a yoke's two ears. Dial: front yoke (solid) and rear yoke (dashed) "
        "of the shaft seen from the gearbox, looking rearward; a positive phase turns the rear "
        "yoke clockwise."
    )
    height = 20 + 190.0 * rows
    return Figure(
        title=say("Yoke phasing"),
        svg=svg.svg_document(20 + COLUMNS * (each + 20), height, *drawn, alt=alt),
        alt=alt,
        note=note,
    )


def _phase_text(phase: float, say: Translator) -> str:
    """Return a phase in words, with its angle where it is an odd one."""
    turned = round(phase / deg, 6) % 180
    if turned in (0, 180):
        return say("in phase (0°)")
    if turned == 90:
        return say("90° out of phase")
    return say("turned {angle} deg", angle=say.compact_number(phase / deg, 4))


def _yoke_shapes(x: float, y: float, wide: float, phase: float) -> Iterator[str]:
    """Yield a shaft from the side, its front yoke's ears up and down."""
    ear, tube = 17.0, 9.0
    ear_style = {"fill": "#9db4c8", "stroke": TEXT_COLOUR, "stroke_width": 1.2}
    a, b = x + 46, x + wide - 46
    yield svg.rect(
        a, y - tube, b - a, 2 * tube, fill="#e3eaf1", stroke=TEXT_COLOUR, stroke_width=1.4
    )
    for end, way, turned in ((a, -1.0, 0.0), (b, 1.0, phase)):
        up, out = abs(np.cos(turned)), abs(np.sin(turned))
        tip = end + way * 40
        if up > 0.05:
            for side in (-1, 1):
                yield svg.path(
                    [end, end + way * 12, tip, tip, end + way * 16, end],
                    [
                        y,
                        y + side * ear * up,
                        y + side * ear * up,
                        y + side * (ear * up - 6 * up),
                        y + side * (ear * up - 6 * up),
                        y,
                    ],
                    close=True,
                    **ear_style,
                )
            yield svg.line(
                tip - way * 8,
                y - ear * up - 5,
                tip - way * 8,
                y + ear * up + 5,
                stroke=SERIES_COLOURS[1],
                stroke_width=1.2,
                stroke_dasharray="5 2 1 2",
            )
        if out > 0.05:
            yield svg.path(
                [end, tip, tip, end],
                [y - 9 * out, y - 9 * out, y + 9 * out, y + 9 * out],
                close=True,
                **ear_style,
            )
            yield svg.circle(
                tip - way * 10,
                y,
                6 * out,
                fill="#ffffff",
                stroke=SERIES_COLOURS[1],
                stroke_width=1.4,
            )


def _pin_axes_dial(x: float, y: float, phase: float, say: Translator) -> Iterator[str]:
    """Yield the two pin axes seen from the gearbox; right-handed about the shaft is clockwise."""
    r = 34.0
    yield svg.circle(x, y, r, fill="none", stroke=SECONDARY_COLOUR)
    yield svg.line(x, y - r - 5, x, y + r + 5, stroke=SERIES_COLOURS[0], stroke_width=3)
    sx, sy = (r + 5) * np.sin(phase), -(r + 5) * np.cos(phase)
    yield svg.line(
        x - sx,
        y - sy,
        x + sx,
        y + sy,
        stroke=SERIES_COLOURS[1],
        stroke_width=3,
        stroke_dasharray="6 4",
    )
    yield svg.text(
        x - r - 14, y + 4, say("front yoke"), anchor="end", font_size=11, fill=SERIES_COLOURS[0]
    )
    yield svg.text(x + r + 14, y + 4, say("rear yoke"), font_size=11, fill=SERIES_COLOURS[1])

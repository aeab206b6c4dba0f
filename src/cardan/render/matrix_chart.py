"""Charts of a matrix: cells over two axes, coloured by the power of ten of their value."""

from collections.abc import Sequence
from math import ceil, floor, log10

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.render import svg
from cardan.render.chart import CHART_HEIGHT_PX, Chart, power_of_ten_text
from cardan.render.i18n import Translator
from cardan.render.svg import SECONDARY_COLOUR, Figure

SEQUENTIAL_COLOURS = ("#c6dff0", "#7fb8dc", "#3a86c0", "#7a3f9a", "#c2255c", "#7d0d2b")
"""Colours of rising values, each darker or redder than the one before; apart in grey, too."""
CELL_BACKGROUND_COLOUR = "#f3f6f9"
"""Behind the cells, so that the darkest are seen on a dark page."""
MAX_POWERS = 12
"""Powers of ten that have a colour; what is smaller has that of the smallest."""


def matrix_chart(
    say: Translator,
    *,
    title: str,
    alt: str,
    x: tuple[float, float],
    y: tuple[float, float],
    cells: Sequence[tuple[float, float, float]],
    width: float,
    x_label: str,
    y_label: str,
    values: str,
    height: float = CHART_HEIGHT_PX,
    note: str = "",
) -> Figure:
    """Return a chart of a matrix and its diagonal; the legend is the scale of its colours.

    Parameters
    ----------
    x, y
        Ranges of the axes, in the units of their labels.
    cells
        Left and lower edge of each cell that is not empty, and its value above 0.
    width
        Of a cell along both axes.
    values
        What the values are, for the legend.
    """
    chart = Chart(say=say, x=x, y=y, x_label=x_label, y_label=y_label, height=height)
    (left, right), (bottom, top) = chart.to_pixels(np.array(x), np.array(y))
    chart.add_elements(
        svg.rect(left, bottom, right - left, top - bottom, fill=CELL_BACKGROUND_COLOUR)
    )
    powers: FloatArray = np.array([floor(log10(v) + 1e-9) for _, _, v in cells], float)
    highest = int(powers.max(initial=0))
    lowest = max(int(powers.min(initial=highest)), highest - MAX_POWERS + 1)
    colours = {p: _colour(p - lowest, highest - lowest) for p in range(lowest, highest + 1)}
    for (x1, y1, _), power in zip(cells, powers.tolist(), strict=True):
        (px1, px2), (py1, py2) = chart.to_pixels(
            np.array([x1, x1 + width]), np.array([y1, y1 + width])
        )
        colour = colours[max(int(power), lowest)]
        chart.add_elements(svg.rect(px1, py2, px2 - px1, py1 - py2, fill=colour))
    low, high = max(x[0], y[0]), min(x[1], y[1])
    diagonal = (*chart.point_to_pixels(low, low), *chart.point_to_pixels(high, high))
    chart.add_elements(svg.line(*diagonal, stroke=SECONDARY_COLOUR, stroke_dasharray="4 3"))
    for power in range(lowest, highest + 1) if len(cells) else ():
        begins, ends = _bound(power, say), _bound(power + 1, say)
        said = f"{begins} … {ends}" if power > lowest or lowest == highest else f"< {ends}"
        chart.add_legend_swatch(f"{values} {said}" if power == lowest else said, colours[power])
    return chart.to_figure(title=title, alt=alt, note=note)


def _bound(power: int, say: Translator) -> str:
    return say.compact_number(10.0**power) if -3 < power < 4 else power_of_ten_text(power)


def _colour(place: int, last: int) -> str:
    """Return the colour of a place from 0 to a last one."""
    at = (len(SEQUENTIAL_COLOURS) - 1) * (place / last if last else 1.0)
    low, high = (_channels(SEQUENTIAL_COLOURS[k]) for k in (floor(at), ceil(at)))
    mixed = (round(a + (at % 1) * (b - a)) for a, b in zip(low, high, strict=True))
    return "#" + "".join(f"{part:02x}" for part in mixed)


def _channels(colour: str) -> tuple[int, ...]:
    """Return red, green and blue of a colour, 0 to 255."""
    return tuple(int(colour[k : k + 2], 16) for k in (1, 3, 5))

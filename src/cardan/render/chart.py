"""Charts as own SVG: axes with units, series distinguished without colour, limits as bands.

A report is made in a second and holds twenty of them; a plotting library needs longer to
start than all of them take to write.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import ceil, floor, log10

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.verdict import Limit
from cardan.render import svg
from cardan.render.i18n import Translator
from cardan.render.label_placement import Box, LabelPlacer, bar_boxes, text_box
from cardan.render.svg import (
    GRID_COLOUR,
    HALO,
    SECONDARY_COLOUR,
    SERIES_COLOURS,
    SERIES_DASHES,
    TEXT_COLOUR,
    VERDICT_COLOURS,
    Figure,
)

CHART_WIDTH_PX, CHART_HEIGHT_PX = 540.0, 330.0
MARGIN_LEFT_PX, MARGIN_RIGHT_PX, MARGIN_TOP_PX, MARGIN_BOTTOM_PX = 66.0, 16.0, 14.0, 44.0

MAX_CURVE_POINTS_TO_AVOID = 400
"""Points of a curve that labels keep off."""

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

MIN_CATEGORY_COUNT_FOR_BAR_WIDTH = 5
"""Categories that bars are drawn as wide as for, at least."""


@dataclass(frozen=True, kw_only=True)
class DataSeries:
    """Values to draw: as a line, as points, or both; `labels` name the points."""

    name: str
    x: FloatArray
    y: FloatArray
    draw_line: bool = True
    draw_markers: bool = False
    labels: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class LimitBand:
    """A range of a chart's values in which a check warns or fails; `axis` says of which axis.

    It begins at its low end, with a line there, or `line_at_high_end` at its high one.
    """

    low: float
    high: float
    grade: str = "fail"
    axis: str = "y"
    line_at_high_end: bool = False


@dataclass(frozen=True, kw_only=True)
class ReferenceLine:
    """One value of the y axis that something is held against, with its name."""

    value: float
    name: str
    grade: str = ""


def ticks(low: float, high: float, count: int = 6) -> FloatArray:
    """Return round values between two, about `count` of them."""
    span = high - low
    raw = span / count
    size = 10.0 ** floor(log10(raw))
    step = next(m * size for m in (1, 2, 5, 10) if m * size >= raw * (1 - 1e-9))
    first, last = ceil(low / step - 1e-9), floor(high / step + 1e-9)
    return step * np.arange(first, last + 1, dtype=np.float64)


def logarithmic_ticks(low: float, high: float, count: int = 10) -> FloatArray:
    """Return logarithms of round numbers between two logarithms: 1, 2, 5, 10 or powers of ten."""
    steps = (0.0, np.log10(2), np.log10(5)) if high - low <= 3 else (0.0,)
    every = max(ceil((high - low) / count), 1)
    found = np.array([k + s for k in range(floor(low), ceil(high) + 1, every) for s in steps])
    return found[(found >= low - 1e-9) & (found <= high + 1e-9)]


def power_of_ten_text(exponent: int) -> str:
    """Return a power of ten: 10⁶."""
    return "10" + str(exponent).translate(SUPERSCRIPTS)


def axis_range(
    *values: FloatArray | float, zero: bool = False, room: float = 0.06
) -> tuple[float, float]:
    """Return the range of values with some room around it, from zero if requested."""
    every = np.concatenate([np.ravel(v).astype(float) for v in values])
    every = every[np.isfinite(every)]
    low, high = (float(every.min()), float(every.max())) if every.size else (0.0, 1.0)
    if zero:
        low, high = min(low, 0.0), max(high, 0.0)
    if high - low < 1e-9 * max(abs(high), 1e-9) or high == low:
        low, high = low - max(abs(low), 1) * 0.1, high + max(abs(high), 1) * 0.1
    wide = room * (high - low)
    return (low if zero and low == 0 else low - wide), (high if zero and high == 0 else high + wide)


def limit_bands(limits: Sequence[Limit], *, factor: float, top: float) -> tuple[LimitBand, ...]:
    """Return where limits warn and fail, up to a highest value, in display units."""
    bands: list[LimitBand] = []
    for limit in limits:
        if limit.band or limit.sense != "<=":
            continue
        first, last = limit.normal, limit.maximum
        if first is not None:
            end = top if last is None else last / factor
            bands.append(LimitBand(low=first / factor, high=end, grade="warn"))
        if last is not None:
            bands.append(LimitBand(low=last / factor, high=max(top, last / factor), grade="fail"))
    return tuple(bands)


@dataclass
class Chart:
    """Axes on which things are drawn; x and y are ranges in the units of their labels."""

    say: Translator
    x: tuple[float, float]
    y: tuple[float, float]
    x_label: str
    y_label: str
    equal_aspect: bool = False
    width: float = CHART_WIDTH_PX
    height: float = CHART_HEIGHT_PX
    categories: tuple[str, ...] = ()
    show_y_values: bool = True
    """Whether the y axis has numbers; names may stand in the chart instead."""
    x_logarithmic: bool = False
    y_logarithmic: bool = False
    """Whether values along the axis are given as logarithms to ten; its numbers are of them."""
    _drawn: list[str] = field(default_factory=list[str])
    _legend: list[tuple[str, str]] = field(default_factory=list[tuple[str, str]])
    _labels: LabelPlacer = field(init=False)
    _level_names: list[tuple[str, float, float, str]] = field(
        default_factory=list[tuple[str, float, float, str]]
    )

    def __post_init__(self) -> None:
        right, bottom = self.width - MARGIN_RIGHT_PX, self.height - MARGIN_BOTTOM_PX
        self._labels = LabelPlacer(Box(MARGIN_LEFT_PX, MARGIN_TOP_PX, right, bottom))
        if self.equal_aspect:  # grow the axis that has room, so that circles stay round
            wide, high = (
                self.width - MARGIN_LEFT_PX - MARGIN_RIGHT_PX,
                self.height - MARGIN_TOP_PX - MARGIN_BOTTOM_PX,
            )
            scale = max((self.x[1] - self.x[0]) / wide, (self.y[1] - self.y[0]) / high)
            self.x = _widened_range(self.x, scale * wide)
            self.y = _widened_range(self.y, scale * high)

    def to_pixels(
        self, x: FloatArray | float, y: FloatArray | float
    ) -> tuple[FloatArray, FloatArray]:
        """Return the pixels of values."""
        right, bottom = self.width - MARGIN_RIGHT_PX, self.height - MARGIN_BOTTOM_PX
        px = MARGIN_LEFT_PX + (np.asarray(x, float) - self.x[0]) / (self.x[1] - self.x[0]) * (
            right - MARGIN_LEFT_PX
        )
        py = bottom - (np.asarray(y, float) - self.y[0]) / (self.y[1] - self.y[0]) * (
            bottom - MARGIN_TOP_PX
        )
        return px, py

    def point_to_pixels(self, x: float, y: float) -> tuple[float, float]:
        """Return the pixel of one point."""
        px, py = self.to_pixels(x, y)
        return float(px), float(py)

    def add_elements(self, *elements: str) -> None:
        """Draw elements that are placed already."""
        self._drawn += elements

    def add_band(self, band: LimitBand) -> None:
        """Shade a range."""
        along = self.x if band.axis == "x" else self.y
        low, high = max(band.low, along[0]), min(band.high, along[1])
        if high <= low:
            return
        (x1, y1), (x2, y2) = (
            (self.point_to_pixels(low, self.y[0]), self.point_to_pixels(high, self.y[1]))
            if band.axis == "x"
            else (self.point_to_pixels(self.x[0], low), self.point_to_pixels(self.x[1], high))
        )
        colour = VERDICT_COLOURS[band.grade]
        self.add_elements(svg.rect(x1, y1, x2 - x1, y2 - y1, fill=colour, fill_opacity=0.13))
        edge = {"stroke": colour, "stroke_width": 1, "stroke_dasharray": "4 3"}
        x, y = (x2, y2) if band.line_at_high_end else (x1, y1)
        if band.axis == "y":
            self._labels.taken.append(Box(x1, y - 0.6, x2, y + 0.6))
        self.add_elements(
            svg.line(x, y1, x, y2, **edge) if band.axis == "x" else svg.line(x1, y, x2, y, **edge)
        )

    def add_reference_line(self, level: ReferenceLine, *, above: float = 4) -> None:
        """Draw a line across at a value, with its name at the right end, so far above it.

        Or below it, or further left: the name is placed once everything else is.
        """
        x1, y = self.point_to_pixels(self.x[0], level.value)
        if not MARGIN_TOP_PX - 1 <= y <= self.height - MARGIN_BOTTOM_PX + 1:
            return
        x2 = self.width - MARGIN_RIGHT_PX
        colour = VERDICT_COLOURS.get(level.grade, TEXT_COLOUR)
        self.add_elements(
            svg.line(x1, y, x2, y, stroke=colour, stroke_width=1.2, stroke_dasharray="6 3")
        )
        self._labels.taken.append(Box(x1, y - 0.6, x2, y + 0.6))
        self._level_names.append((level.name, y, above, colour))

    def _placed_level_names(self) -> Iterator[str]:
        right = self.width - MARGIN_RIGHT_PX - 4
        for name, y, above, colour in self._level_names:
            spots = [
                (right - left, base)
                for left in (0.0, 90.0, 180.0, 270.0)
                for base in (y - above, y + above + 8)
            ]
            boxes = [text_box(*at, (name,), font_size=11, anchor="end") for at in spots]
            a, b = spots[self._labels.place(boxes)]
            yield svg.text(a, b, name, anchor="end", font_size=11, fill=colour, **HALO)

    def add_series(self, of: DataSeries, index: int) -> None:
        """Draw a series in the colour and dash of its place."""
        colour = SERIES_COLOURS[index % len(SERIES_COLOURS)]
        dash = SERIES_DASHES[index % len(SERIES_DASHES)] or None
        x, y = self.to_pixels(of.x, of.y)
        if of.draw_line:
            self.add_elements(
                svg.path(x, y, stroke=colour, stroke_width=1.8, stroke_dasharray=dash)
            )
            self._labels.taken += _curve_boxes(x, y)
        if of.draw_markers:
            self._labels.taken += [
                Box(a - 4, b - 4, a + 4, b + 4) for a, b in zip(x.tolist(), y.tolist(), strict=True)
            ]
            self.add_elements(
                *(
                    self.marker(float(a), float(b), index)
                    for a, b in zip(x, y, strict=True)
                    if np.isfinite(a) and np.isfinite(b)
                )
            )
        for said, a, b in zip(of.labels, x, y, strict=False):
            if np.isfinite(a) and np.isfinite(b):
                self._label(said, float(a), float(b), colour)
        if of.name:
            key = (
                svg.line(0, -4, 22, -4, stroke=colour, stroke_width=2, stroke_dasharray=dash)
                if of.draw_line
                else ""
            )
            self._legend.append(
                (of.name, key + (self.marker(11, -4, index) if of.draw_markers else ""))
            )

    def _label(self, said: str, x: float, y: float, colour: str) -> None:
        """Name a point next to it, where nothing stands yet."""
        wide = text_box(x, y, (said,), font_size=10.5).right - x
        spots = [
            (x + way - (wide if way < 0 else 0), y + drop)
            for drop in (-6, 14, -19, 27, -32, -45, -58)
            for way in (6, -6)
        ]
        boxes = [text_box(*at, (said,), font_size=10.5) for at in spots]
        a, b = spots[self._labels.place(boxes)]
        if abs(b - y) > 15:
            self.add_elements(
                svg.line(x, y, a + (0 if a > x else wide), b - 3, stroke=colour, stroke_width=0.6)
            )
        self.add_elements(svg.text(a, b, said, font_size=10.5, fill=colour, **HALO))

    def add_envelope(self, x: FloatArray, low: FloatArray, high: FloatArray) -> None:
        """Fill from the lowest to the highest value of columns (n,); a gap where one is nan."""
        colour = SERIES_COLOURS[0]
        known = np.isfinite(low) & np.isfinite(high)
        turns = np.flatnonzero(np.diff(known.astype(np.int8), prepend=0, append=0))
        for first, last in turns.reshape(-1, 2):
            across = np.concatenate([x[first:last], x[first:last][::-1]])
            px, py = self.to_pixels(
                across, np.concatenate([low[first:last], high[first:last][::-1]])
            )
            self.add_elements(
                svg.path(px, py, close=True, fill=colour, stroke=colour, stroke_width=0.8)
            )

    def add_legend_swatch(self, name: str, colour: str) -> None:
        """Name a fill in the legend."""
        self._legend.append((name, svg.rect(0, -9, 22, 10, fill=colour)))

    def add_legend_entry(self, name: str, index: int) -> None:
        """Name a colour in the legend."""
        colour = SERIES_COLOURS[index % len(SERIES_COLOURS)]
        self._legend.append((name, svg.line(0, -4, 22, -4, stroke=colour, stroke_width=3)))

    def marker(self, x: float, y: float, index: int, size: float = 3.6) -> str:
        """Return a mark at a pixel, its shape that of a series' place."""
        colour = SERIES_COLOURS[index % len(SERIES_COLOURS)]
        if index % 3 == 0:
            return svg.circle(x, y, size, fill=colour)
        if index % 3 == 1:
            return svg.rect(x - size, y - size, 2 * size, 2 * size, fill=colour)
        return svg.path(
            [x, x - size * 1.2, x + size * 1.2],
            [y - size * 1.3, y + size, y + size],
            close=True,
            fill=colour,
            stroke="none",
        )

    def to_figure(self, *, title: str, alt: str, note: str = "") -> Figure:
        """Return the chart as a figure, axes behind and legend below."""
        rows = _legend_row_widths(
            [name for name, _ in self._legend], self.width - MARGIN_LEFT_PX - MARGIN_RIGHT_PX
        )
        legend: list[str] = []
        keys = iter(self._legend)
        for k, row in enumerate(rows):
            x = MARGIN_LEFT_PX
            for wide in row:
                name, key = next(keys)
                place = f"translate({x:.1f} {self.height + 14 + 17 * k:.1f})"
                legend.append(
                    svg.group([key, svg.text(28, 0, name, font_size=11)], transform=place)
                )
                x += wide
        height = self.height + (8 + 17 * len(rows) if rows else 0)
        drawn = svg.svg_document(
            self.width, height,
            *self._axes(), *self._drawn, *self._placed_level_names(), *legend, alt=alt,
        )  # fmt: skip
        return Figure(title=title, svg=drawn, alt=alt, note=note)

    @staticmethod
    def _ticks(along: tuple[float, float], *, logarithmic: bool) -> FloatArray:
        return logarithmic_ticks(*along) if logarithmic else ticks(*along)

    def _tick_text(self, value: float, *, logarithmic: bool) -> str:
        """Return the number at a tick; a power of ten from 10 000 on and below 0.01."""
        if not logarithmic:
            return self.say.compact_number(value)
        if -2 <= value < 4:
            return self.say.compact_number(10**value)
        return power_of_ten_text(round(value))

    def _axes(self) -> list[str]:
        """Return grid, ticks and labels."""
        left, right, bottom = (
            MARGIN_LEFT_PX,
            self.width - MARGIN_RIGHT_PX,
            self.height - MARGIN_BOTTOM_PX,
        )
        out: list[str] = []
        for value in (
            self._ticks(self.y, logarithmic=self.y_logarithmic) if self.show_y_values else ()
        ):
            _, y = self.point_to_pixels(self.x[0], float(value))
            out.append(svg.line(left, y, right, y, stroke=GRID_COLOUR))
            said = self._tick_text(float(value), logarithmic=self.y_logarithmic)
            out.append(svg.text(left - 6, y + 4, said, anchor="end", font_size=11))
        if self.categories:
            step = 1 if len(self.categories) <= 5 else 0
            for k, name in enumerate(self.categories):
                x, _ = self.point_to_pixels(k, self.y[0])
                room = int((right - left) / len(self.categories) / 5.6)
                said = name if step or len(name) <= room else name[: max(room - 1, 3)] + "…"
                out.append(svg.text(x, bottom + 16, said, anchor="middle", font_size=11))
        else:
            full_turn = self.x == (0.0, 360.0)
            for value in (
                60.0 * np.arange(7)
                if full_turn
                else self._ticks(self.x, logarithmic=self.x_logarithmic)
            ):
                x, _ = self.point_to_pixels(float(value), self.y[0])
                out.append(svg.line(x, MARGIN_TOP_PX, x, bottom, stroke=GRID_COLOUR))
                said = self._tick_text(float(value), logarithmic=self.x_logarithmic)
                out.append(svg.text(x, bottom + 16, said, anchor="middle", font_size=11))
        out.append(
            svg.path([left, left, right], [MARGIN_TOP_PX, bottom, bottom], stroke=SECONDARY_COLOUR)
        )
        if self.show_y_values and not self.y_logarithmic and self.y[0] < 0 < self.y[1]:
            _, y = self.point_to_pixels(self.x[0], 0.0)
            out.append(svg.line(left, y, right, y, stroke=SECONDARY_COLOUR))
        if not self.categories and not self.x_logarithmic and self.x[0] < 0 < self.x[1]:
            x, _ = self.point_to_pixels(0.0, self.y[0])
            out.append(svg.line(x, MARGIN_TOP_PX, x, bottom, stroke=SECONDARY_COLOUR))
        middle = (left + right) / 2
        out.append(svg.text(middle, self.height - 8, self.x_label, anchor="middle"))
        turn = f"rotate(-90 14 {(MARGIN_TOP_PX + bottom) / 2:.1f})"
        out.append(
            svg.text(
                14, (MARGIN_TOP_PX + bottom) / 2, self.y_label, anchor="middle", transform=turn
            )
        )
        return out


def bar_chart(
    say: Translator,
    *,
    title: str,
    alt: str,
    categories: Sequence[str],
    groups: Sequence[tuple[str, FloatArray]],
    y_label: str,
    levels: Sequence[ReferenceLine] = (),
    bands: Sequence[LimitBand] = (),
    top: float | None = None,
    note: str = "",
) -> Figure:
    """Return a chart of bars: a group of them for each category."""
    y = axis_range(*(v for _, v in groups), *(lv.value for lv in levels), top or 0.0, zero=True)
    spare = max(
        0.0, (MIN_CATEGORY_COUNT_FOR_BAR_WIDTH - len(categories)) / 2
    )  # or one state would be one giant bar
    chart = Chart(
        say=say,
        x=(-0.5 - spare, len(categories) - 0.5 + spare),
        y=y,
        x_label="",
        y_label=y_label,
        categories=tuple(categories),
    )
    for band in bands:
        chart.add_band(band)
    wide = 0.8 / len(groups)
    for g, (name, values) in enumerate(groups):
        colour = SERIES_COLOURS[g % len(SERIES_COLOURS)]
        for k, value in enumerate(values):
            if not np.isfinite(value):
                continue
            x1, y1 = chart.point_to_pixels(k - 0.4 + g * wide, 0.0)
            x2, y2 = chart.point_to_pixels(k - 0.4 + (g + 0.92) * wide, float(value))
            chart.add_elements(svg.rect(x1, y1, x2 - x1, y2 - y1, fill=colour))
        chart.add_legend_entry(name, g)
    for level in levels:
        chart.add_reference_line(level)
    return chart.to_figure(title=title, alt=alt, note=note)


def line_chart(
    say: Translator,
    *,
    title: str,
    alt: str,
    series: Sequence[DataSeries],
    x_label: str,
    y_label: str,
    bands: Sequence[LimitBand] = (),
    levels: Sequence[ReferenceLine] = (),
    zero: bool = False,
    x: tuple[float, float] | None = None,
    y: tuple[float, float] | None = None,
    categories: tuple[str, ...] = (),
    x_logarithmic: bool = False,
    y_logarithmic: bool = False,
    height: float = CHART_HEIGHT_PX,
    note: str = "",
) -> Figure:
    """Return a chart of series over a common axis; logarithmic values are given as logarithms."""
    chart = Chart(
        say=say,
        x=x or axis_range(*(s.x for s in series), room=0.03),
        y=y or axis_range(*(s.y for s in series), *(lv.value for lv in levels), zero=zero),
        x_label=x_label,
        y_label=y_label,
        categories=categories,
        x_logarithmic=x_logarithmic,
        y_logarithmic=y_logarithmic,
        height=height,
    )
    for band in bands:
        chart.add_band(band)
    for level in levels:
        chart.add_reference_line(level)
    for k, s in enumerate(series):
        chart.add_series(s, k)
    return chart.to_figure(title=title, alt=alt, note=note)


def _curve_boxes(x: FloatArray, y: FloatArray) -> Iterator[Box]:
    """Yield what a curve takes of the page; of a long recording nothing, it fills the page."""
    points = np.column_stack([x, y])
    for a, b in pairwise(points) if len(points) <= MAX_CURVE_POINTS_TO_AVOID else ():
        if np.isfinite(a).all() and np.isfinite(b).all():
            yield from bar_boxes(a, b, 2.0)


def _widened_range(of: tuple[float, float], span: float) -> tuple[float, float]:
    """Return a range grown about its middle."""
    middle = sum(of) / 2
    return middle - span / 2, middle + span / 2


def _legend_row_widths(names: list[str], width: float) -> list[list[float]]:
    """Return the widths of a legend's entries, row by row."""
    rows: list[list[float]] = []
    for name in names:
        wide = 44 + 6.1 * len(name)
        if not rows or sum(rows[-1]) + wide > width:
            rows.append([])
        rows[-1].append(wide)
    return rows

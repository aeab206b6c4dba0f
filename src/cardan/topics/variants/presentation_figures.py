"""Figures of a study of variants: histograms, bars, maps, parallel axes, Pareto fronts."""

from collections.abc import Iterator
from math import isfinite

import numpy as np

from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.arrays import FloatArray
from cardan.core.verdict import VERDICTS, Limit, worst_first_key
from cardan.render import svg
from cardan.render.chart import Chart, LimitBand, axis_range
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.screen_layout import percent_text
from cardan.render.svg import SECONDARY_COLOUR, SERIES_COLOURS, TEXT_COLOUR, VERDICT_COLOURS, Figure
from cardan.topics.variants.presentation import (
    MAX_SHOWN_LIMITS,
    factor_label,
    limit_name,
    limits_by_failures,
    sobol_column_label,
    sobol_columns,
)
from cardan.topics.variants.statistics import (
    StatisticState,
    YieldMap,
    halved_tolerance_yields,
    sobol_indices,
    yield_map_cell_counts,
)
from cardan.topics.variants.study_result import VariantStudyResult

MAX_PARALLEL_AXES = 7
"""Inputs across which lines of variants go, at most."""

HISTOGRAM_BINS = 40
"""Bars of a histogram, about."""


# --------------------------------------------------------------------------- figures


def figures(of: VariantStudyResult, say: Translator = ENGLISH) -> Iterator[Figure]:
    """Yield histograms with their limits, bars of what decides, maps and the front."""
    for k in most_informative_limits(of):
        yield histogram_figure(of, k, say)
    if "tighter" in of.statistics and len(of.tolerance_factors) > 1:
        yield _gains(of, say)
    if "sobol" in of.statistics:
        for column in sobol_columns(of):
            yield sobol_figure(of, column, say)
    if len(of.sampling_plan.names) > 1 and "first" in of.statistics:
        yield parallel_coordinates_figure(of, say)
    for chart, state in of.maps:
        yield yield_map_figure(of, chart, state, say)
    if "pareto" in of.statistics and len(of.statistics["pareto"]["place"]):
        yield pareto_front_figure(of, say)


def most_informative_limits(of: VariantStudyResult) -> list[int]:
    """Return the limits whose scatter matters most: those that some variants pass and some not."""
    grades = of.statistics["counts"]["grades"] / of.independent_count
    split = [k for k in limits_by_failures(of) if 0 < grades[k, 2] < 1 or 0 < grades[k, 1] < 1]
    others = [k for k in limits_by_failures(of) if k not in split and grades[k, 2] > 0]
    return (split + others)[:MAX_SHOWN_LIMITS] or limits_by_failures(of)[:2]


def histogram_figure(of: VariantStudyResult, k: int, say: Translator = ENGLISH) -> Figure:
    """Return how the values of a limit scatter, with its bounds."""
    limit = of.limits[k][1]
    q, state = QUANTITIES[limit.quantity], of.statistics["values"]
    places, counts = yield_map_cell_counts(state, k)
    places = places / q.si_factor
    ends = [
        b / q.si_factor for b in (limit.normal, limit.maximum, *(limit.band or ())) if b is not None
    ]
    low, high = sorted((state["least"][k] / q.si_factor, state["most"][k] / q.si_factor))
    near = [b for b in ends if low - (high - low) <= b <= high + (high - low)]
    x = axis_range(np.array([low, high, *near]), room=0.04)
    edges = np.linspace(low, high, HISTOGRAM_BINS + 1) if high > low else np.array([x[0], x[1]])
    heights, _ = np.histogram(np.clip(places, low, high), edges, weights=counts)
    heights = 100 * heights / counts.sum()
    chart = Chart(
        say=say, x=x, y=(0.0, 1.1 * float(heights.max())),
        x_label=f"{say.name(q.key)} [{q.unit_symbol or '1'}]", y_label=say("share of variants [%]"),
    )  # fmt: skip
    for band in _bands(limit, q.si_factor, x):
        chart.add_band(band)
    for left, right, height in zip(edges, edges[1:], heights, strict=False):
        if height:
            (x1, y1), (x2, y2) = (
                chart.point_to_pixels(left, 0.0),
                chart.point_to_pixels(right, height),
            )
            chart.add_elements(
                svg.rect(x1 + 0.3, y2, max(x2 - x1 - 0.6, 0.6), y1 - y2, fill=SERIES_COLOURS[0])
            )
    at = _installed(of, k)
    if at is not None and x[0] <= at / q.si_factor <= x[1]:
        (x1, y1), (_, y2) = (
            chart.point_to_pixels(at / q.si_factor, 0.0),
            chart.point_to_pixels(at / q.si_factor, chart.y[1]),
        )
        chart.add_elements(
            svg.line(x1, y1, x1, y2, stroke=TEXT_COLOUR, stroke_width=1.4, stroke_dasharray="5 3")
        )
        chart.add_elements(svg.text(x1 + 4, y2 + 12, say("as it is"), font_size=11))
    grades = of.statistics["counts"]["grades"][k] / of.independent_count
    note = say(
        "{fail} fail, {warn} warn; of every variant the state and part where it is worst.",
        fail=percent_text(grades[2], say), warn=percent_text(grades[1], say),
    )  # fmt: skip
    title = limit_name(limit, say)
    return chart.to_figure(title=title, alt=f"{title}. {note}", note=note)


def _installed(of: VariantStudyResult, k: int) -> float | None:
    line, limit = of.limits[k]
    mine = [c for c in of.installed.checks if c.limit == limit and c.line == line]
    if not mine:
        return None
    return min(mine, key=worst_first_key).value


def _bands(limit: Limit, factor: float, x: tuple[float, float]) -> Iterator[LimitBand]:
    """Yield where a limit warns and fails along the x axis."""
    if limit.band:
        low, high = (b / factor for b in limit.band)
        yield LimitBand(low=low, high=high, grade="warn", axis="x")
        return
    first, last = (None if b is None else b / factor for b in (limit.normal, limit.maximum))
    above = limit.sense == "<="
    if first is not None:
        end = last if last is not None else (x[1] if above else x[0])
        low, high = min(first, end), max(first, end)
        yield LimitBand(low=low, high=high, grade="warn", axis="x", line_at_high_end=not above)
    if last is not None:
        end = max(x[1], last) if above else min(x[0], last)
        low, high = min(last, end), max(last, end)
        yield LimitBand(low=low, high=high, grade="fail", axis="x", line_at_high_end=not above)


def _gains(of: VariantStudyResult, say: Translator) -> Figure:
    """Return what halving each tolerance wins."""
    passes, error = halved_tolerance_yields(of.statistics["tighter"])
    factors = of.tolerance_factors
    gain, spread = 100 * (passes[:, 0] - of.yield_), 200 * error[:, 0]
    return _sideways(
        say,
        title=say("What halving each tolerance wins"),
        names=[of.sampling_plan.name_of(f) for f in factors],
        values=gain,
        errors=spread,
        x_label=say("gain in yield [%]"),
        least=1.0,
        digits=1,
    )


def sobol_figure(of: VariantStudyResult, column: int, say: Translator = ENGLISH) -> Figure:
    """Return the total Sobol indices of one output as bars."""
    found = sobol_indices(of.statistics["sobol"])
    what = sobol_column_label(of, column, say)
    return _sideways(
        say,
        title=say("Where the variance comes from: {what}", what=what),
        names=[factor_label(of, f, say) for f in of.sampling_plan.factors],
        values=found.total[column],
        errors=2 * found.total_error[column],
        inner=found.first[column],
        x_label=say("share of the variance: dark alone, light with what it does with others"),
    )


def _sideways(
    say: Translator,
    *,
    title: str,
    names: list[str],
    values: FloatArray,
    errors: FloatArray,
    x_label: str,
    inner: FloatArray | None = None,
    least: float = 0.01,
    digits: int = 2,
) -> Figure:
    """Return bars that lie, longest on top, names in the chart, which reaches to `least` at least.

    Values are given to so many digits behind the point.
    """
    order = np.argsort(np.nan_to_num(values), kind="stable")[-16:]
    high = float(np.nan_to_num(values + errors).max(initial=least))
    low = min(0.0, float(np.nan_to_num(values - errors).min(initial=0.0)))
    chart = Chart(
        say=say, x=axis_range(np.array([low, high]), zero=True), y=(0.0, float(len(order))),
        x_label=x_label, y_label="", show_y_values=False, height=90 + 30.0 * len(order),
    )  # fmt: skip
    for row, k in enumerate(order.tolist()):
        value, error = float(values[k]), float(errors[k])
        if not isfinite(value):
            continue
        for size, colour in (
            (value, SERIES_COLOURS[0] if inner is None else SECONDARY_COLOUR),
            *(() if inner is None else ((float(max(inner[k], 0.0)), SERIES_COLOURS[0]),)),
        ):
            (x1, y1), (x2, y2) = (
                chart.point_to_pixels(0.0, row + 0.12),
                chart.point_to_pixels(size, row + 0.5),
            )
            chart.add_elements(
                svg.rect(min(x1, x2), y2, max(abs(x2 - x1), 0.8), y1 - y2, fill=colour)
            )
        (x1, y1), (x2, _) = (chart.point_to_pixels(value + s * error, row + 0.31) for s in (-1, 1))
        chart.add_elements(svg.line(x1, y1, x2, y1, stroke=TEXT_COLOUR, stroke_width=1.2))
        (x0, y0) = chart.point_to_pixels(max(low, 0.0), row + 0.58)
        said = f"{names[k]}: {say.with_decimal_sign(f'{round(value, digits) + 0.0:.{digits}f}')}"
        chart.add_elements(svg.text(x0 + 4, y0, said, font_size=11))
    most = names[int(order[-1])] if len(order) else ""
    return chart.to_figure(title=title, alt=f"{title}. {say('most')}: {most}")


def yield_map_figure(
    of: VariantStudyResult, chart: YieldMap, state: StatisticState, say: Translator = ENGLISH
) -> Figure:
    """Return the yield over two inputs, cell by cell."""
    (a, b), (wide, high) = chart.edges, chart.shape
    drawn = Chart(
        say=say,
        x=(a[0], a[-1]),
        y=(b[0], b[-1]),
        x_label=of.sampling_plan.names[chart.columns[0]],
        y_label=of.sampling_plan.names[chart.columns[1]],
    )
    for i in range(wide):
        for j in range(high):
            count = state["count"][i, j]
            if not count:
                continue
            fit = float(state["passes"][i, j] / count)
            (x1, y1), (x2, y2) = (
                drawn.point_to_pixels(a[i], b[j]),
                drawn.point_to_pixels(a[i + 1], b[j + 1]),
            )
            drawn.add_elements(svg.rect(x1, y2, x2 - x1, y1 - y2, fill=_mixed(fit), stroke="none"))
            if wide <= 10 and high <= 12:
                said = say.with_decimal_sign(f"{100 * fit:.0f}")
                drawn.add_elements(
                    svg.text((x1 + x2) / 2, (y1 + y2) / 2 + 4, said, anchor="middle", font_size=11,
                             fill="#ffffff" if fit < 0.25 or fit > 0.85 else "#1a1a1a")
                )  # fmt: skip
    title = say("Yield over {one} and {other}", one=drawn.x_label, other=drawn.y_label)
    fit = state["passes"] / np.maximum(state["count"], 1)
    left = state["sum"] / np.maximum(state["known"], 1)
    best = np.unravel_index(  # of cells with the same yield the one of most margin
        np.where((state["count"] > 0) & (fit == fit.max()), left, -np.inf).argmax(), fit.shape
    )
    note = say(
        "From red, none may be built, to green, all of them; white where no variant lies. Best at "
        "{one} and {other}.",
        one=say.compact_number(chart.cell_centres[0][best[0]], 3),
        other=say.compact_number(chart.cell_centres[1][best[1]], 3),
    )
    return drawn.to_figure(title=title, alt=f"{title}. {note}", note=note)


def _mixed(fit: float) -> str:
    """Return a colour between that of what fails and that of what passes, lighter between."""
    ends = VERDICT_COLOURS["fail"], "#f4ecd0", VERDICT_COLOURS["pass"]
    one, other = (ends[0], ends[1]) if fit < 0.5 else (ends[1], ends[2])
    t = 2 * fit if fit < 0.5 else 2 * fit - 1
    parts = zip(_rgb(one), _rgb(other), strict=True)
    return "#" + "".join(f"{round(p + t * (q - p)):02x}" for p, q in parts)


def _rgb(colour: str) -> tuple[int, int, int]:
    digits = colour.removeprefix("#")
    red, green, blue = (int(digits[k : k + 2], 16) for k in (0, 2, 4))
    return red, green, blue


def parallel_coordinates_figure(of: VariantStudyResult, say: Translator = ENGLISH) -> Figure:
    """Return the first variants as lines across what varies and the smallest margin.

    Of many inputs those are shown that go most with the margin; what fails lies on top.
    """
    state = of.statistics["first"]
    known = np.isfinite(state["margin"])
    inputs, margin = state["inputs"][known], 100 * state["margin"][known]
    verdict = state["verdict"][known]
    spread = inputs.std(axis=0)
    moves = np.flatnonzero(spread > 0)
    off = (inputs[:, moves] - inputs[:, moves].mean(axis=0)) / spread[moves]
    told = np.abs(off.T @ (margin - margin.mean()))
    moves = np.sort(moves[np.argsort(-told, kind="stable")[:MAX_PARALLEL_AXES]])
    values = np.column_stack([inputs[:, moves], margin])
    low, high = values.min(axis=0), values.max(axis=0)
    wide = np.where(high > low, high - low, 1.0)
    names = [*(of.sampling_plan.names[k] for k in moves), say("smallest margin [%]")]
    places = np.arange(len(names), dtype=float)
    chart = Chart(
        say=say, x=(-0.3, len(names) - 0.7), y=(-0.06, 1.06), x_label="", y_label="",
        categories=tuple(map(str, range(1, len(names) + 1))), show_y_values=False,
    )  # fmt: skip
    for grade in VERDICTS:  # the worst on top
        for row in np.flatnonzero(verdict == VERDICTS.index(grade)):
            x, y = chart.to_pixels(places, (values[row] - low) / wide)
            chart.add_elements(
                svg.path(
                    x,
                    y,
                    stroke=VERDICT_COLOURS.get(grade, TEXT_COLOUR),
                    stroke_width=0.8,
                    stroke_opacity=0.45,
                )
            )
    for k, place in enumerate(places.tolist()):
        (x, bottom), (_, top) = chart.point_to_pixels(place, 0.0), chart.point_to_pixels(place, 1.0)
        chart.add_elements(svg.line(x, bottom, x, top, stroke=TEXT_COLOUR, stroke_width=1))
        for y, value in ((bottom + 12, low[k]), (top - 5, high[k])):
            said = say.compact_number(float(value), 4)
            chart.add_elements(svg.text(x, y, said, anchor="middle", font_size=10.5))
    title = say("Variants across what varies")
    note = say(
        "{count} variants, each a line: {axes}.", count=len(values),
        axes=say.join(*(f"{k} {name}" for k, name in enumerate(names, 1))),
    )  # fmt: skip
    return chart.to_figure(title=title, alt=f"{title}. {note}", note=note)


def pareto_front_figure(of: VariantStudyResult, say: Translator = ENGLISH) -> Figure:
    """Return the front over its first two goals."""
    state, goals = of.statistics["pareto"], of.variants.ask.pareto
    titles = {
        "margin": say("smallest margin [%]"), "cost": say("cost"), "mass": say("mass [kg]"),
    }  # fmt: skip
    sign = {"margin": -100.0, "cost": 1.0, "mass": 1.0}
    y, x = (sign[g] * state["goals"][:, k] for k, g in enumerate(goals[:2]))
    chart = Chart(
        say=say,
        x=axis_range(x),
        y=axis_range(y),
        x_label=titles[goals[1]],
        y_label=titles[goals[0]],
    )
    for a, b, verdict in zip(x.tolist(), y.tolist(), state["verdict"].tolist(), strict=True):
        px, py = chart.point_to_pixels(a, b)
        chart.add_elements(
            svg.circle(px, py, 3.6, fill=VERDICT_COLOURS.get(VERDICTS[verdict], TEXT_COLOUR))
        )
    title = say("What no other variant beats")
    return chart.to_figure(title=title, alt=title)

"""Four figures of a life report: stress over time, rainflow matrix, load collective, damage."""

import math
from collections.abc import Sequence

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.units import MPa, hour
from cardan.physics.fatigue.damage import LifeEstimate
from cardan.physics.fatigue.rainflow import Cycles
from cardan.physics.fatigue.rainflow_matrix import RainflowTable
from cardan.physics.signals.assessment import AssessmentSettings, GaugeAssessment
from cardan.physics.signals.faults.waveform import FAULT_MISSING_SAMPLES
from cardan.render import svg
from cardan.render.chart import (
    MARGIN_BOTTOM_PX,
    MARGIN_TOP_PX,
    Chart,
    DataSeries,
    axis_range,
    line_chart,
)
from cardan.render.i18n import Translator
from cardan.render.matrix_chart import matrix_chart
from cardan.render.svg import SERIES_COLOURS, Figure
from cardan.topics.recording.load_collective import (
    curve_amplitude,
    load_collective,
    stress_reserve,
)
from cardan.topics.recording.recording_assessment import RecordingAssessment
from cardan.topics.recording.stress_history import (
    MASKED_BY_TIME_KIND,
    MarkedStretches,
    StressHistory,
    marked_stretches,
)

WIDE_PX, HISTORY_HEIGHT_PX, DAMAGE_HEIGHT_PX = 900.0, 152.0, 122.0
"""Size of the figures over time, which take the width of a page."""
PAIR_HEIGHT_PX = 240.0
"""Height of the figures that stand side by side."""
LANE_PX = 9.0
"""Height of the row in which a kind of suspect data is marked above the stress."""
MIN_MARK_PX = 1.6
"""Width of a mark, at least: one sample of an hour is seen."""
MATRIX_BINS = 40
"""Bins of a drawn matrix along an axis, at most."""
MAX_BARS = 12
"""Recordings with a bar of their own; the others are one."""
TIME_UNITS = (("s", 1.0, 600.0), ("min", 60.0, 4 * 3600.0), ("h", 3600.0, math.inf))
"""Units of an axis of time, s, and how long a recording may be for each."""


def _time_unit(seconds: float) -> tuple[str, float]:
    """Return the unit for a length of time, and its length, s."""
    return next((name, size) for name, size, most in TIME_UNITS if seconds < most)


def _duration_text(seconds: float, say: Translator) -> str:
    unit, size = next(
        (name, size) for name, size, _ in reversed(TIME_UNITS) if seconds >= size or name == "s"
    )
    return f"{say.compact_number(seconds / size, 4)} {unit}"


def _time_label(unit: str, say: Translator) -> str:
    return {"s": say("time, s"), "min": say("time, min"), "h": say("time, h")}[unit]


# --------------------------------------------------------------------------- stress over time


def history_figure(
    of: StressHistory,
    marks: Sequence[MarkedStretches],
    say: Translator,
    *,
    gauge: str,
    recording: str,
    duration: float,
    start: float = 0.0,
) -> Figure:
    """Return smallest and largest stress over a whole recording, with its suspect data marked.

    `start` is the time of the recording's first sample on the clock of its file, s.
    """
    unit, size = _time_unit(start + duration)
    low, high = of.low / MPa, of.high / MPa
    x: FloatArray = np.asarray(start + of.column_length * (np.arange(low.size) + 0.5), float) / size
    bottom, top = axis_range(low, high)
    lanes = LANE_PX * len(marks)
    plot = HISTORY_HEIGHT_PX - MARGIN_TOP_PX - MARGIN_BOTTOM_PX
    chart = Chart(
        say=say,
        x=(start / size, (start + duration) / size),
        y=(bottom, top + (top - bottom) * lanes / plot),
        x_label=_time_label(unit, say),
        y_label=say("stress, MPa"),
        width=WIDE_PX,
        height=HISTORY_HEIGHT_PX + lanes,
    )
    chart.add_envelope(x, low, high)
    names: list[str] = []
    for lane, one in enumerate(marks):
        colour = SERIES_COLOURS[1 + lane % (len(SERIES_COLOURS) - 1)]
        _add_marks(chart, one, MARGIN_TOP_PX + LANE_PX * lane, colour, start=start, unit=size)
        names.append(_mark_text(one, say))
        chart.add_legend_swatch(names[-1], colour)
    said = "; ".join(names) if names else say("no suspect data found")
    return chart.to_figure(
        title=say(
            "{gauge} in {recording}: smallest and largest stress over time", gauge=gauge,
            recording=recording,
        ),
        alt=say(
            "Stress of {gauge} over {duration}, from {low} to {high} MPa. Marked: {marks}.",
            gauge=gauge, duration=_duration_text(duration, say), marks=said,
            low=say.compact_number(float(np.nanmin(low)), 4),
            high=say.compact_number(float(np.nanmax(high)), 4),
        ),
    )  # fmt: skip


def _mark_text(of: MarkedStretches, say: Translator) -> str:
    """Return a kind of suspect data, and how many of its stretches are in which state."""
    if of.kind == MASKED_BY_TIME_KIND:
        return say("masked by time: {count}", count=len(of.masked))
    if of.kind == FAULT_MISSING_SAMPLES:  # without a sample nothing is to be decided
        return f"{say(of.kind)}: {sum(map(len, (of.masked, of.undecided, of.accepted)))}"
    states = (
        (say("masked"), of.masked), (say("undecided"), of.undecided), (say("accepted"), of.accepted)
    )  # fmt: skip
    counts = ", ".join(f"{len(runs)} {name}" for name, runs in states if len(runs))
    return f"{say(of.kind)}: {counts}"


def _add_marks(
    chart: Chart, of: MarkedStretches, y: float, colour: str, *, start: float, unit: float
) -> None:
    """Mark stretches in a row, and shade the stress there; accepted ones are pale."""
    height = chart.height - MARGIN_BOTTOM_PX - MARGIN_TOP_PX
    for runs, dark in ((of.accepted, 0.4), (of.undecided, 1.0), (of.masked, 1.0)):
        for x1, x2 in _pixel_spans(chart, (start + runs) / unit):
            chart.add_elements(
                svg.rect(x1, y + 1, x2 - x1, LANE_PX - 2, fill=colour, fill_opacity=dark),
                svg.rect(x1, MARGIN_TOP_PX, x2 - x1, height, fill=colour, fill_opacity=0.14),
            )


def _pixel_spans(chart: Chart, runs: FloatArray) -> list[tuple[float, float]]:
    """Return the pixels that runs (k, 2) take along an axis, those that touch as one."""
    if not len(runs):
        return []
    (first, _), (last, _) = (chart.to_pixels(runs[:, k], 0.0) for k in (0, 1))
    spans: list[tuple[float, float]] = []
    for a, b in zip(first.tolist(), np.maximum(last, first + MIN_MARK_PX).tolist(), strict=True):
        if spans and a <= spans[-1][1]:
            spans[-1] = spans[-1][0], max(spans[-1][1], b)
        else:
            spans.append((a, b))
    return spans


def recorded_history(of: RecordingAssessment, gauge: GaugeAssessment) -> StressHistory | None:
    """Return the stress history of a gauge in a recording; None where none was made."""
    figures = of.figures
    if figures is None or gauge.name not in figures.gauges or not figures.histories:
        return None
    return figures.histories[figures.gauges.index(gauge.name)]


def recording_history_figures(
    of: RecordingAssessment, gauge: GaugeAssessment, say: Translator
) -> tuple[Figure, ...]:
    """Return stress and damage of a gauge over a recording; nothing where no history was made."""
    history, recording = recorded_history(of, gauge), of.recording
    if history is None:
        return ()
    marks = marked_stretches(gauge.channel_reports, rules=of.plan.fault_rules, rate=recording.rate)
    where = {"duration": gauge.quality.recorded_time, "start": recording.start_time}
    return (
        history_figure(
            history, marks, say, gauge=gauge.name, recording=recording.name, **where
        ),
        stretch_damage_figure(history, say, gauge=gauge.name, **where),
    )  # fmt: skip


# --------------------------------------------------------------------------- cycles


def matrix_figure(of: RainflowTable, say: Translator, *, gauge: str) -> Figure:
    """Return the from-to rainflow matrix of a gauge, in colours by powers of ten."""
    drawn = drawn_matrix(of)
    edges = drawn.width / MPa
    start: FloatArray = np.asarray(drawn.row * edges, float)
    end: FloatArray = np.asarray(drawn.column * edges, float)
    low, high = axis_range(start, end, start + edges, end + edges, room=0.03)
    return matrix_chart(
        say,
        title=say("{gauge}: rainflow matrix", gauge=gauge),
        alt=say(
            "Cycles of {gauge} by the stress from which and to which they go: {count} cycles, the "
            "largest range {range} MPa.",
            gauge=gauge,
            count=say.compact_number(of.total),
            range=say.compact_number(float(of.cycles().range.max(initial=0.0)) / MPa, 4),
        ),
        x=(low, high),
        y=(low, high),
        cells=list(zip(end.tolist(), start.tolist(), drawn.count.tolist(), strict=True)),
        width=edges,
        x_label=say("to, MPa"),
        y_label=say("from, MPa"),
        values=say("cycles"),
        height=PAIR_HEIGHT_PX,
        note=say(
            "{count} cycles, a half cycle as 0.5; bins of {width} MPa.",
            count=say.compact_number(of.total), width=say.compact_number(edges, 3),
        ),
    )  # fmt: skip


def drawn_matrix(of: RainflowTable) -> RainflowTable:
    """Return a matrix in the narrowest bins of which an axis has at most `MATRIX_BINS`."""
    places = np.concatenate([of.row, of.column])
    width, reach = of.width, int(np.ptp(places)) + 1 if places.size else 1
    while reach > MATRIX_BINS - 1:
        width, reach = 2 * width, math.ceil(reach / 2)
    return of.coarsened(width)


def collective_figure(
    cycles: Cycles,
    life: LifeEstimate,
    plan: AssessmentSettings,
    say: Translator,
    *,
    gauge: str,
    known: bool,
    required: float | None,
) -> Figure | None:
    """Return the S-N curve with a gauge's load collective; None without a cycle.

    `known` says whether the life is known; `required` is the life of its limit, s.
    """
    found = load_collective(cycles, plan.correction)
    if found is None:
        return None
    curve, largest = plan.curve, float(found.amplitude[-1])
    passages = {say("load collective, one passage"): 1.0}
    if required is not None:
        name = say("collective in {hours} h (limit)", hours=_hours(required, say))
        passages[name] = required / life.duration
    if known and 0 < life.damage < math.inf:
        name = say("collective at the life, {hours} h", hours=_hours(life.hours * hour, say))
        passages[name] = plan.allowed / life.damage
    knee, total = math.log10(curve.cycles), float(found.cycles[0]) * max(passages.values())
    end = max(knee + 1, math.log10(max(total, 1.0)))
    least = min(found.amplitude[0] * 2.5, 0.4 * curve.amplitude)
    most = 1.25 * max(largest, float(curve_amplitude(curve, 10 ** max(knee - 3, 0.0))))
    y = math.log10(least / MPa), math.log10(most / MPa)
    borne = np.linspace(-0.5, end, 300)
    series = [_curve_series(say("S-N curve, {share} failed", share=say.percentage(curve.failure)),
                            borne, curve_amplitude(curve, 10**borne), y)]  # fmt: skip
    if curve.scatter > 0:
        sure = curve.at_failure_share(0.1)
        series.append(
            _curve_series(
                say("S-N curve, {share} failed", share=say.percentage(0.1)), borne,
                curve_amplitude(sure, 10**borne), y,
            )
        )  # fmt: skip
    for name, times in passages.items():
        count = np.log10(np.maximum(found.cycles * times, 10**-0.5))
        series.append(_curve_series(name, count, found.amplitude, y))
    limited = math.isinf(curve.slope_beyond_knee)
    strength = say.compact_number(curve.amplitude / MPa, 4)
    knee_text = (
        say("endurance limit {stress} MPa", stress=strength)
        if limited
        else say("knee of the S-N curve {stress} MPa", stress=strength)
    )
    series.append(_curve_series(knee_text, np.array([-0.5, end]), np.full(2, curve.amplitude), y))
    ratio = say.compact_number(largest / curve.amplitude, 3)
    size = say.compact_number(largest / MPa, 3)
    notes = [
        say("Largest amplitude {stress} MPa, {ratio} times the endurance limit.", stress=size,
            ratio=ratio)
        if limited
        else say("Largest amplitude {stress} MPa, {ratio} times that at the knee.", stress=size,
                 ratio=ratio)
    ]  # fmt: skip
    if known and required is not None:
        factor = stress_reserve(cycles, life, plan, seconds=required)
        if math.isfinite(factor):
            notes.append(
                say(
                    "Safety: {factor} times the recorded stress is allowed for {hours} h.",
                    factor=say.compact_number(factor, 3), hours=_hours(required, say),
                )
            )  # fmt: skip
    return line_chart(
        say,
        title=say("{gauge}: S-N curve and load collective", gauge=gauge),
        alt=say("Stress amplitude at zero mean over cycles: S-N curve and load collective.")
        + " " + " ".join(notes),
        series=series,
        x=(-0.5, end), y=y, x_logarithmic=True, y_logarithmic=True,
        x_label=say("cycles of at least this amplitude; cycles to failure"),
        y_label=say("amplitude at zero mean, MPa"),
        height=PAIR_HEIGHT_PX,
        note=" ".join(notes),
    )  # fmt: skip


def _curve_series(
    name: str, x: FloatArray, amplitude: FloatArray, y: tuple[float, float]
) -> DataSeries:
    """Return a line over logarithms of cycles, without what is outside of the axis."""
    height = np.log10(amplitude / MPa)
    return DataSeries(
        name=name, x=x, y=np.where((height >= y[0]) & (height <= y[1]), height, np.nan)
    )


def _hours(seconds: float, say: Translator) -> str:
    return say.compact_number(float(f"{seconds / hour:.3g}"))


# --------------------------------------------------------------------------- damage


def stretch_damage_figure(
    of: StressHistory,
    say: Translator,
    *,
    gauge: str,
    duration: float,
    start: float = 0.0,
) -> Figure:
    """Return the share of a recording's damage that each of its stretches has."""
    unit, size = _time_unit(start + duration)
    shares = of.damage_shares
    chart = Chart(
        say=say,
        x=(start / size, (start + duration) / size),
        y=axis_range(100 * shares, 1.0, zero=True),
        x_label=_time_label(unit, say),
        y_label=say("damage, %"),
        width=WIDE_PX,
        height=DAMAGE_HEIGHT_PX,
    )
    ends = np.minimum(of.stretch_length * np.arange(shares.size + 1), duration)
    for k, share in enumerate(shares.tolist()):
        x1, y1 = chart.point_to_pixels((start + ends[k]) / size, 0.0)
        x2, y2 = chart.point_to_pixels((start + ends[k + 1]) / size, 100 * share)
        chart.add_elements(
            svg.rect(x1 + 0.5, y1, max(x2 - x1 - 1, 0.5), y2 - y1, fill=SERIES_COLOURS[0])
        )
    worst = int(np.argmax(shares))
    note = say(
        "Most damage: {share} from {first} to {last} {unit}. Cycles count where they close.",
        share=say.percentage(float(shares[worst])),
        first=say.compact_number(float(start + ends[worst]) / size, 4),
        last=say.compact_number(float(start + ends[worst + 1]) / size, 4),
        unit=unit,
    )
    length = _duration_text(of.stretch_length, say)
    return chart.to_figure(
        title=say("{gauge}: share of the damage of each {length}", gauge=gauge, length=length),
        alt=say("Bars of the share of the damage over time.") + " " + note,
        note=note,
    )


def recording_damage_figure(
    names: Sequence[str], damages: FloatArray, say: Translator, *, gauge: str
) -> Figure:
    """Return the share of a mix's damage of each recording, as often as it is driven, (k,) 1."""
    names, damages = _largest_bars(names, np.nan_to_num(damages), say)
    shares = damages / damages.sum() if damages.sum() > 0 else np.zeros_like(damages)
    chart = Chart(
        say=say,
        x=(-0.6, len(names) - 0.4),
        y=axis_range(100 * shares, 1.0, zero=True, room=0.2),
        x_label=say("recording"),
        y_label=say("damage, %"),
        width=WIDE_PX,
        height=DAMAGE_HEIGHT_PX,
        categories=tuple(names),
    )
    for k, share in enumerate(shares.tolist()):
        x1, y1 = chart.point_to_pixels(k - 0.35, 0.0)
        x2, y2 = chart.point_to_pixels(k + 0.35, 100 * share)
        chart.add_elements(
            svg.rect(x1, y1, x2 - x1, y2 - y1, fill=SERIES_COLOURS[0]),
            svg.text((x1 + x2) / 2, y2 - 4, say.percentage(share), anchor="middle", font_size=11),
        )
    said = "; ".join(
        f"{name} {say.percentage(share)}" for name, share in zip(names, shares, strict=True)
    )
    return chart.to_figure(
        title=say("{gauge}: share of the damage of each recording", gauge=gauge),
        alt=say("Bars of the share of the mix's damage: {shares}.", shares=said),
        note=say("Each recording as often as it is driven in the mix."),
    )


def _largest_bars(
    names: Sequence[str], damages: FloatArray, say: Translator
) -> tuple[list[str], FloatArray]:
    """Return at most `MAX_BARS` bars in their order; the smallest are added up in the last."""
    if len(names) <= MAX_BARS:
        return list(names), damages
    kept = np.sort(np.argsort(-damages, kind="stable")[: MAX_BARS - 1])
    rest = float(damages.sum() - damages[kept].sum())
    other = say("{count} others", count=len(names) - kept.size)
    return [*(names[int(k)] for k in kept), other], np.append(damages[kept], rest)

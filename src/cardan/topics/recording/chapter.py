"""A recording's part of a report: gauges, pictures, orders, causes, Haigh's diagram."""

import math
from collections.abc import Iterator, Sequence
from io import BytesIO
from typing import Any, TypeAlias

import numpy as np

from cardan.approval.study import StudyResult
from cardan.core.arrays import ComplexArray, FloatArray
from cardan.core.optional_import import import_optional
from cardan.core.units import MPa
from cardan.physics.fatigue.mean_stress import MeanStressCorrection
from cardan.physics.fatigue.rainflow import range_pairs
from cardan.physics.signals.assessment import AssessmentSettings, GaugeAssessment
from cardan.physics.signals.cause_assessment import DamageCausesByGauge
from cardan.physics.signals.order_cuts import OrderCuts
from cardan.render.blocks import Block, Chapter, Figures, Picture, Table, Text
from cardan.render.chart import Chart, DataSeries, LimitBand, axis_range, line_chart
from cardan.render.i18n import Translator
from cardan.render.svg import SERIES_COLOURS, Figure, line, rect, text
from cardan.topics.recording import alternative_life_presentation as otherwise
from cardan.topics.recording import method_presentation as counting
from cardan.topics.recording import usage_presentation as used
from cardan.topics.recording.campaign_assessment import CampaignAssessment
from cardan.topics.recording.finding_phrases import finding_messages
from cardan.topics.recording.identification_presentation import (
    doubt_sentences,
    mode_rows,
    no_change_prediction_sentence,
    parameter_change_sentences,
    parameter_row,
    predicted_life_rows,
)
from cardan.topics.recording.identification_result import IdentificationResult
from cardan.topics.recording.life_figures_report import recording_history_figures
from cardan.topics.recording.presentation import (
    bus_error_lines,
    channel_fault_lines,
    customer_damage_lines,
    damage_cause_rows,
    data_quality_lines,
    gauge_rows,
    joint_damage_share_lines,
    recording_mix_gauge_rows,
    recording_mix_gauge_sentences,
    recording_note_text,
)
from cardan.topics.recording.recording_assessment import RecordingAssessment, ReportFigures

MAX_DRAWN_WINDOWS = 1200
"""Windows of an order cut that are drawn, at most."""
MAX_HISTORY_HEIGHT_MM = 52.0
"""Height on paper of a gauge's stress over time, at most."""
_Cut: TypeAlias = tuple[str, FloatArray, ComplexArray, ComplexArray]
"""Name, speeds in rpm, and of an order what has an amplitude and what has a phase, (n,) Pa."""


def study_chapters(
    found: StudyResult[CampaignAssessment], say: Translator, *, short: bool = False
) -> Iterator[Chapter]:
    """Yield the chapters of recordings that were evaluated with an application."""
    assert found.answer is not None  # of a study that answered
    yield from campaign_chapters(found.answer, say, short=short)


def campaign_chapters(
    of: CampaignAssessment, say: Translator, *, short: bool = False
) -> Iterator[Chapter]:
    """Yield what a campaign's recordings come to together, and a chapter of each.

    `short` leaves out a mix of one, and the orders that the joints do not make.
    """
    if len(of.parts) > 1 or not short:
        yield Chapter(title=say("The mix"), blocks=tuple(recording_mix_blocks(of, say)))
    for name, _, heard in of.parts:
        yield Chapter(title=name, blocks=tuple(recording_blocks(heard, say, short=short)))


def recording_mix_blocks(of: CampaignAssessment, say: Translator) -> Iterator[Block]:
    """Yield what recordings come to together, gauge by gauge."""
    for one in of.lives:
        head, *rows = recording_mix_gauge_rows(of, one, say)
        yield Table(
            caption=say("{gauge}: what each recording does in the mix", gauge=one.name),
            head=(say("recording"), *head[1:]),
            rows=tuple((row[0].strip(), *row[1:]) for row in rows),
        )
        yield Text(paragraphs=tuple(recording_mix_gauge_sentences(of, one, say)))
    yield from otherwise.report_blocks(of.alternative_lives, say)
    if of.customer_share:
        yield Text(paragraphs=tuple(customer_damage_lines(of, say)))


def recording_blocks(
    of: RecordingAssessment, say: Translator, *, short: bool = False, shown: str = ""
) -> Iterator[Block]:
    """Yield what a recording did to its gauges, and its causes.

    `shown` is the gauge whose stress over time is drawn elsewhere; `short` draws that of none.

    Raises
    ------
    MissingDependencyError
        Without matplotlib.
    """
    paragraphs = [recording_note_text(note, say) for note in of.recording.notes] + list(
        channel_fault_lines(of.recording, of.lives, say)
    )
    if paragraphs:
        yield Text(paragraphs=tuple(paragraphs))
    head, *rows = gauge_rows(of.lives, say)
    yield Table(
        caption=say("Gauges"), head=head, rows=tuple(rows),
        grades=tuple(("fail" if one.vetoed else "", *[""] * 6) for one in of.lives),
    )  # fmt: skip
    yield from counting.report_blocks(of, say)
    rate = of.recording.rate
    yield Text(
        paragraphs=tuple(s for one in of.lives for s in data_quality_lines(one, rate=rate, say=say))
    )
    yield Figures(figures=(_pairs(of.lives, of.causes, say), _field(of.lives, of.plan, of, say)))
    for one in () if short else of.lives:
        over_time = () if one.name == shown else recording_history_figures(of, one, say)
        if over_time:
            yield Figures(figures=over_time, wide=True, max_height_mm=MAX_HISTORY_HEIGHT_MM)
    if of.figures is not None:
        yield from _pictures(of.figures, of.recording.name, say)
        if of.figures.cuts is not None:
            cuts, names = of.figures.cuts, of.figures.gauges
            found, surest = of.identification, of.causes and of.causes.best_synchronised
            # A tacho counts turns as they come.
            late = surest.lag_interval if surest and not of.options.tacho else None
            for order in (2.0,) if short else (2.0, 1.0, 4.0):
                figures = order_cut_figures(cuts, names, order, say, found=found, late=late)
                yield Figures(figures=tuple(figures))
    if of.alternative_readings:
        yield Text(
            paragraphs=tuple(
                line for one in of.alternative_readings for line in bus_error_lines(one, say)
            )
        )
    if of.causes is not None:
        yield from _causes(of.causes, say)
    for one in of.usage:
        yield from used.report_blocks(one, say)
    yield from otherwise.report_blocks(of.alternative_lives, say)
    if of.identification is not None:
        yield from parameter_identification_blocks(of.identification, say)
    if of.predicted_lives:
        head, *rows = predicted_life_rows(of.predicted_lives, say)
        yield Table(
            caption=say("Driven so with the changed line"), head=head, rows=tuple(rows), words=1
        )
        yield Text(paragraphs=tuple(parameter_change_sentences(of.parameter_changes, say)))
    elif of.lacks_prediction:
        yield Text(paragraphs=(no_change_prediction_sentence(say),))


# --------------------------------------------------------------------------- cycles


def _pairs(
    lives: Sequence[GaugeAssessment], causes: DamageCausesByGauge | None, say: Translator
) -> Figure:
    """Return how often each range came, as recorded and without the joints."""
    series: list[DataSeries] = []

    def added(name: str, cycles: Any) -> None:
        top = float(cycles.range.max(initial=0.0))
        if top > 0:
            ranges = np.linspace(0, top, 160)[1:]
            count = np.maximum(range_pairs(cycles, ranges=ranges), 0.5)
            series.append(DataSeries(name=name, x=np.log10(count), y=ranges / MPa))

    places = {} if causes is None else {n: k for k, n in enumerate(causes.gauges)}
    for one in lives:
        if one.has_signal:
            added(one.name, one.cycles)
            if causes is not None and one.name in places:
                without = say("{gauge} without the joints", gauge=one.name)
                added(without, causes.cycles_without_joints[places[one.name]])
    return line_chart(
        say, title=say("Cycles of at least a range"), series=series,
        alt=say("Ranges of stress over how many cycles reach them."),
        x_label=say("cycles of at least this range, power of ten"),
        y_label=say("range, MPa"), zero=True,
        note=say("The gap between the two lines of a gauge is what goes with the joints.")
        if places else "",
    )  # fmt: skip


def equal_damage_amplitude_at_mean(
    mean: FloatArray, *, amplitude: float, correction: MeanStressCorrection
) -> FloatArray:
    """Return the amplitude (...) Pa that does at a mean (...) what `amplitude` does at zero.

    By bisection, as any correction rises with the amplitude; nan where none does.
    """
    low, high = np.zeros_like(mean), np.full_like(mean, 4 * amplitude)
    for _ in range(60):
        middle = (low + high) / 2
        more = correction(middle, mean) < amplitude
        low, high = np.where(more, middle, low), np.where(more, high, middle)
    return np.where(high >= 4 * amplitude * (1 - 1e-9), np.nan, high)


def _field(
    lives: Sequence[GaugeAssessment],
    plan: AssessmentSettings,
    of: RecordingAssessment,
    say: Translator,
) -> Figure:
    """Return the Haigh diagram: cycles of field and model, and what the part bears."""
    worst = max(
        (one for one in lives if one.has_signal), key=lambda one: np.nan_to_num(one.life.damage),
        default=None,
    )  # fmt: skip
    knee = plan.curve.amplitude
    field = worst.cycles if worst is not None else None
    mean = np.array([0.0]) if field is None else (field.start + field.end) / 2
    size = np.array([0.0]) if field is None else field.amplitude
    model = _computed(of.identification, worst.name if worst else "")
    x = axis_range(mean / MPa, *(m / MPa for m, _ in model), room=0.1)
    y = axis_range(size / MPa, knee / MPa * 1.2, *(a / MPa for _, a in model), zero=True)
    chart = Chart(
        say=say, x=x, y=y, x_label=say("mean stress, MPa"), y_label=say("stress amplitude, MPa"),
    )  # fmt: skip
    if field is not None and field.count.size:
        _shaded(chart, mean / MPa, size / MPa, field.count)
        chart.add_legend_entry(
            say("{gauge}: cycles of the field", gauge=worst.name if worst else ""), 0
        )
    means = np.linspace(x[0], x[1], 200)
    chart.add_series(
        DataSeries(
            name=say("amplitude at the knee of the S-N curve"),
            x=means,
            y=equal_damage_amplitude_at_mean(
                means * MPa, amplitude=knee, correction=plan.correction
            )
            / MPa,
        ),
        1,
    )
    for m, a in model:
        chart.add_series(
            DataSeries(name=say("order 2 of the model"), x=m / MPa, y=a / MPa, draw_line=False,
                   draw_markers=True), 2,
        )  # fmt: skip
    return chart.to_figure(
        title=say("Haigh diagram"),
        alt=say("Amplitude over mean of the counted cycles, and the line the part bears for long."),
        note=say("The darker, the more cycles (by powers of ten)."),
    )


def _shaded(chart: Chart, x: FloatArray, y: FloatArray, count: FloatArray) -> None:
    """Draw how many cycles fall into each of 40 by 30 cells, by the power of ten."""
    columns, rows = np.linspace(*chart.x, 41), np.linspace(*chart.y, 31)
    found, _, _ = np.histogram2d(x, y, bins=(columns, rows), weights=count)
    top = max(math.log10(max(float(found.max()), 1.0)) + 1, 1.0)
    for i, k in zip(*np.nonzero(found > 0), strict=True):
        (x1, x2), (y1, y2) = chart.to_pixels(columns[i : i + 2], rows[k : k + 2])
        dark = 0.15 + 0.8 * max(math.log10(float(found[i, k])) + 1, 0.0) / top
        chart.add_elements(
            rect(x1, y2, x2 - x1, y1 - y2, fill=SERIES_COLOURS[0], fill_opacity=round(dark, 2))
        )


def _computed(of: IdentificationResult | None, gauge: str) -> list[tuple[FloatArray, FloatArray]]:
    """Return mean and amplitude of the model's order 2 at a gauge, where there is a model."""
    if of is None or gauge not in of.gauges:
        return []
    g = of.gauges.index(gauge)
    every = max(of.torque.size // 60, 1)
    return [(of.mean_stress[g, ::every], np.abs(of.computed_after[g, 1, ::every]))]


# --------------------------------------------------------------------------- pictures


def _pictures(of: ReportFigures, name: str, say: Translator) -> Iterator[Block]:
    """Yield each gauge's spectrogram and order map as a picture."""
    for k, gauge in enumerate(of.gauges):
        if k >= len(of.spectrograms):
            continue
        order = of.order_maps[k] if k < len(of.order_maps) else None
        yield Picture(
            title=say("{gauge} in {recording}", gauge=gauge, recording=name),
            png=_drawn(of.spectrograms[k], order, say),
            alt=say("Stress over time and frequency, and over shaft speed and order."),
            note=say("What turns with the shaft stands upright in the order map; a mode leans.")
            if order is not None else "",
        )  # fmt: skip


def _drawn(power: Any, order: Any, say: Translator) -> bytes:
    """Return a spectrogram, and an order map where there is one, as a picture."""
    import_optional("matplotlib")
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure as Sheet

    sheet: Any = Sheet(figsize=(11 if order is not None else 6, 3.6), dpi=110, layout="constrained")
    FigureCanvasAgg(sheet)
    axes = sheet.subplots(1, 2 if order is not None else 1, squeeze=False)[0]
    scale = 1 if power.time[-1] < 600 else 60
    _mapped(
        sheet, axes[0], power.time / scale, power.frequency, np.sqrt(power.density) / MPa,
        say("MPa/√Hz"), say,
    )  # fmt: skip
    axes[0].set(xlabel=say("time, s") if scale == 1 else say("time, min"),
                ylabel=say("frequency, Hz"))  # fmt: skip
    if order is not None:
        _mapped(
            sheet, axes[1], order.order, order.speed * 60, order.amplitude.T / MPa,
            say("amplitude, MPa"), say,
        )  # fmt: skip
        axes[1].set(xlabel=say("order of the shaft"), ylabel=say("shaft speed, rpm"),
                    xticks=range(int(order.order[-1]) + 1))  # fmt: skip
        axes[1].grid(axis="x", color="white", lw=0.4, alpha=0.4)
    out = BytesIO()
    sheet.savefig(out, format="png", metadata={"Software": None})
    return out.getvalue()


def _mapped(
    sheet: Any, axis: Any, x: FloatArray, y: FloatArray, z: FloatArray, label: str, say: Translator
) -> None:
    """Draw a map in powers of ten over three decades, with its scale."""
    from matplotlib.colors import LogNorm
    from matplotlib.ticker import FuncFormatter

    top = float(np.nanmax(z)) if np.isfinite(z).any() else 1.0
    top = top if top > 0 else 1.0
    shown = axis.pcolormesh(
        x, y, np.maximum(z, 1e-12 * top), norm=LogNorm(top / 1e3, top), cmap="viridis",
        rasterized=True,
    )  # fmt: skip

    def short(value: float, _: Any) -> str:
        return say.compact_number(float(value), 4)

    figures = FuncFormatter(short)
    sheet.colorbar(shown, ax=axis, label=label, format=figures)
    axis.xaxis.set_major_formatter(figures)
    axis.yaxis.set_major_formatter(figures)


# --------------------------------------------------------------------------- orders


def order_cut_figures(
    cuts: OrderCuts, names: Sequence[str], order: float, say: Translator, *,
    found: IdentificationResult | None = None, late: tuple[float, float] | None = None,
) -> Iterator[Figure]:  # fmt: skip
    """Yield amplitude and phase of an order against speed, recorded and computed.

    Computed values are drawn for one gauge at a time: the dots of all gauges would overlap.
    `late`, low and high s, is how much later than its speed the stress may come: by that
    the phase tilts.
    """
    k, title = cuts.orders.index(order), say("Order {order}", order=say.compact_number(order))
    every = max(cuts.windows.time.size // MAX_DRAWN_WINDOWS, 1)
    speed = cuts.windows.speed[::every] * 60
    shown: dict[str, list[_Cut]] = {}
    for g, name in enumerate(names):
        z, noise = cuts.amplitude[g, k, ::every], cuts.noise[g, k, ::every]
        # Where an order is not above its noise it has no phase.
        clear = np.where(np.abs(z) > 3 * noise, z, np.nan)
        if found is None:
            shown.setdefault(title, []).append((name, speed, z, clear))
        else:
            shown[f"{title}, {name}"] = [(say("recorded"), speed, z, clear)]
    if found is not None:
        at = found.cuts.windows.speed * 60
        for said, values in (
            (say("as written"), found.computed_before),
            (say("found"), found.computed_after),
        ):
            for g, name in enumerate(found.gauges):
                shown[f"{title}, {name}"].append((said, at, values[g, k], values[g, k]))
    for one, series in shown.items():
        yield from _cut(one, series, phase_error_by_lag_sentence(late, say), say)


def _cut(title: str, shown: Sequence[_Cut], tilts: str, say: Translator) -> Iterator[Figure]:
    """Yield an amplitude and a phase, each series in dots."""

    def dots(name: str, x: FloatArray, y: FloatArray) -> DataSeries:
        return DataSeries(name=name, x=x, y=y, draw_line=False, draw_markers=True)

    yield line_chart(
        say, title=say("{order}: amplitude", order=title),
        series=[dots(name, x, np.abs(z) / MPa) for name, x, z, _ in shown],
        alt=say("Amplitude over shaft speed, window by window."),
        x_label=say("shaft speed, rpm"), y_label=say("amplitude, MPa"), zero=True,
    )  # fmt: skip
    yield line_chart(
        say, title=say("{order}: phase", order=title),
        series=[dots(name, x, np.angle(z, deg=True)) for name, x, _, z in shown],
        alt=say("Phase over shaft speed, window by window."),
        x_label=say("shaft speed, rpm"), y_label=say("phase against the shaft, deg"),
        y=(-190.0, 190.0),
        note=say("Only where the order stands three times above its noise.") + tilts,
    )  # fmt: skip


def phase_error_by_lag_sentence(late: tuple[float, float] | None, say: Translator) -> str:
    """Return what a lag between `late`, s, does to a phase, as a sentence more; none if nothing."""
    if late is None:
        return ""
    low, high = (say.compact_number(1e3 * at, 2) for at in late)
    return " " + say(
        "The stress comes {low} to {high} ms after its speed (90 % interval): within that the "
        "phase is uncertain, by {tilt} deg up or down for each hertz.",
        low=low, high=high, tilt=say.compact_number(180 * (late[1] - late[0]), 2),
    )  # fmt: skip


# --------------------------------------------------------------------------- causes


def _causes(of: DamageCausesByGauge, say: Translator) -> Iterator[Block]:
    """Yield the causes of damage, with the interval of the joints' part."""
    yield Figures(figures=(_removed(of, say),))
    for k, name in enumerate(of.gauges):
        head, *rows = damage_cause_rows(name, of, k, say)
        yield Table(
            caption=head[0], head=(say("cause"), *head[1:]),
            rows=tuple((row[0].strip(), *row[1:]) for row in rows),
        )  # fmt: skip
        yield Text(paragraphs=tuple(s.strip() for s in joint_damage_share_lines(name, of, k, say)))
    doubts = tuple(
        say("doubt: {doubt}", doubt=say.translate_message(d)) for d in finding_messages(of.doubts)
    )
    yield Text(
        paragraphs=(
            say(
                "Shares are Shapley values; without it and alone are damages over that of all "
                "together."
            ),
            *doubts,
        )
    )


def _removed(of: DamageCausesByGauge, say: Translator) -> Figure:
    """Return what goes with the joints at each gauge, with its interval."""
    count = len(of.gauges)
    chart = Chart(
        say=say, x=(-10.0, 105.0), y=(-0.6, count - 0.4),
        x_label=say("damage that would go with the joints, %"), y_label="", show_y_values=False,
        height=90.0 + 46 * count,
    )  # fmt: skip
    chart.add_band(LimitBand(low=-10, high=25, grade="pass", axis="x"))
    chart.add_band(LimitBand(low=35, high=105, grade="fail", axis="x"))
    for k, (name, e) in enumerate(zip(of.gauges, of.joint_attributions, strict=True)):
        low, high = (100 * v for v in e.interval)
        (x1, y), (x2, _) = (
            chart.point_to_pixels(max(low, -10), k),
            chart.point_to_pixels(min(high, 105), k),
        )
        chart.add_elements(
            line(
                x1,
                y,
                x2,
                y,
                stroke=SERIES_COLOURS[k % len(SERIES_COLOURS)],
                stroke_width=7,
                stroke_opacity=0.45,
            )
        )
        x, _ = chart.point_to_pixels(100 * e.damage_share, k)
        chart.add_elements(chart.marker(x, y, k, 5.0))
        # Next to a right end it would leave the figure.
        at, anchor = (x1, "start") if low < 50 else (x2, "end")
        told = f"{name}: {say(e.verdict).upper()}"
        chart.add_elements(text(at, y - 9, told, anchor=anchor, font_size=11))
    return chart.to_figure(
        title=say("What goes with the joints"),
        alt=say("Share of damage removed at each gauge with its 90 % interval."),
        note=say(
            "Joints dominate if the interval begins at 35 % or above and its middle is 50 % or "
            "more; they do not dominate if it ends at 25 % or below."
        ),
    )


def parameter_identification_blocks(of: IdentificationResult, say: Translator) -> Iterator[Block]:
    """Yield what a recording says of its application."""
    before, after = (say.number(100 * m) for m in of.misfit)
    shaken = mode_rows(of, say)
    yield Table(
        caption=say(
            "{application}, {state}: order 2 as recorded against computed",
            application=of.application.title, state=say.state(of.state),
        ),
        head=(say("number"), say("of"), say("written"), say("found"), say("90 % interval"), ""),
        rows=(*(parameter_row(p, say) for p in of.parameters), *shaken),
        words=2,
        grades=(
            *(("", "", "", "", "", "warn" if p.contradicts_file else "") for p in of.parameters),
            *(("",) * 6 for _ in shaken),
        ),
    )  # fmt: skip
    yield Text(
        paragraphs=(
            say(
                "  unexplained of its energy: {before} % as written, {after} % as identified",
                before=before, after=after,
            ).strip(),
            *doubt_sentences(of, say),
        )
    )  # fmt: skip

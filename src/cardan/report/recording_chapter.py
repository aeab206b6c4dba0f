"""A recording's part of a report: gauges, pictures, orders, causes, Haigh's diagram."""

import math
from collections.abc import Iterator, Sequence
from io import BytesIO
from typing import Any, TypeAlias

import numpy as np

from cardan.base.arrays import ComplexArray, FloatArray
from cardan.base.units import MPa
from cardan.fatigue.correction import Correction
from cardan.fatigue.cuts import Cuts
from cardan.fatigue.life import Causes, GaugeLife, Plan
from cardan.fatigue.rainflow import range_pairs
from cardan.report import counting, otherwise, used
from cardan.report.blocks import Block, Chapter, Figures, Picture, Table, Text
from cardan.report.chart import Band, Chart, Series, bounds, plot
from cardan.report.extra import needed
from cardan.report.identified import departed, doubts, modes, parameter, promise, unkept
from cardan.report.language import Language
from cardan.report.life import (
    channels,
    customers,
    gauges,
    misread,
    mix_rows,
    mix_says,
    shared,
    told,
    trust,
)
from cardan.report.svg import PALETTE, Figure, line, rect, text
from cardan.study.identification import Identification
from cardan.study.recording import Heard, Mix, Pictures

DOTS = 1200
"""Windows of an order cut that are drawn, at most."""
_Cut: TypeAlias = tuple[str, FloatArray, ComplexArray, ComplexArray]
"""Name, speeds in rpm, and of an order what has an amplitude and what has a phase, (n,) Pa."""


def chapters(of: Mix, say: Language, *, short: bool = False) -> Iterator[Chapter]:
    """Yield what a campaign's recordings come to together, and a chapter of each.

    `short` leaves out a mix of one, and the orders that the joints do not make.
    """
    if len(of.parts) > 1 or not short:
        yield Chapter(title=say("The mix"), blocks=tuple(mix(of, say)))
    for name, _, heard in of.parts:
        yield Chapter(title=name, blocks=tuple(chapter(heard, say, short=short)))


def mix(of: Mix, say: Language) -> Iterator[Block]:
    """Yield what recordings come to together, gauge by gauge."""
    for one in of.lives:
        head, *rows = mix_rows(of, one, say)
        yield Table(
            caption=say("{gauge}: what each recording does in the mix", gauge=one.name),
            head=(say("recording"), *head[1:]),
            rows=tuple((row[0].strip(), *row[1:]) for row in rows),
        )
        yield Text(paragraphs=tuple(mix_says(of, one, say)))
    yield from otherwise.blocks(of.otherwise, say)
    if of.customer:
        yield Text(paragraphs=tuple(customers(of, say)))


def chapter(of: Heard, say: Language, *, short: bool = False) -> Iterator[Block]:
    """Yield what a recording did to its gauges, and who did it.

    Raises
    ------
    MissingExtra
        Without matplotlib.
    """
    paragraphs = [say.error(say.given(note)) for note in of.recording.notes] + list(
        channels(of.recording, of.lives, say)
    )
    if paragraphs:
        yield Text(paragraphs=tuple(paragraphs))
    head, *rows = gauges(of.lives, say)
    yield Table(
        caption=say("Gauges"), head=head, rows=tuple(rows),
        grades=tuple(("fail" if one.vetoed else "", *[""] * 6) for one in of.lives),
    )  # fmt: skip
    yield from counting.blocks(of, say)
    rate = of.recording.rate
    yield Text(paragraphs=tuple(s for one in of.lives for s in trust(one, rate=rate, say=say)))
    yield Figures(figures=(_pairs(of.lives, of.causes, say), _field(of.lives, of.plan, of, say)))
    if of.pictures is not None:
        yield from _pictures(of.pictures, of.recording.name, say)
        if of.pictures.cuts is not None:
            cuts, names = of.pictures.cuts, of.pictures.gauges
            found, surest = of.identification, of.causes and of.causes.surest
            # A tacho counts turns as they come.
            late = surest.lags if surest and not of.campaign.tacho else None
            for order in (2.0,) if short else (2.0, 1.0, 4.0):
                figures = order_cut(cuts, names, order, say, found=found, late=late)
                yield Figures(figures=tuple(figures))
    if of.misread:
        yield Text(paragraphs=tuple(line for one in of.misread for line in misread(one, say)))
    if of.causes is not None:
        yield from _causes(of.causes, say)
    for one in of.used:
        yield from used.blocks(one, say)
    yield from otherwise.blocks(of.otherwise, say)
    if of.identification is not None:
        yield from identification(of.identification, say)
    if of.promised:
        head, *rows = promise(of.promised, say)
        yield Table(
            caption=say("Driven so with the changed line"), head=head, rows=tuple(rows), words=1
        )
        yield Text(paragraphs=tuple(departed(of.departures, say)))
    elif of.unkept:
        yield Text(paragraphs=(unkept(say),))


# --------------------------------------------------------------------------- cycles


def _pairs(lives: Sequence[GaugeLife], causes: Causes | None, say: Language) -> Figure:
    """Return how often each range came, as recorded and without the joints."""
    series: list[Series] = []

    def added(name: str, cycles: Any) -> None:
        top = float(cycles.range.max(initial=0.0))
        if top > 0:
            ranges = np.linspace(0, top, 160)[1:]
            count = np.maximum(range_pairs(cycles, ranges=ranges), 0.5)
            series.append(Series(name=name, x=np.log10(count), y=ranges / MPa))

    places = {} if causes is None else {n: k for k, n in enumerate(causes.gauges)}
    for one in lives:
        if one.heard:
            added(one.name, one.cycles)
            if causes is not None and one.name in places:
                without = say("{gauge} without the joints", gauge=one.name)
                added(without, causes.without[places[one.name]])
    return plot(
        say, title=say("Cycles of at least a range"), series=series,
        alt=say("Ranges of stress over how many cycles reach them."),
        x_label=say("cycles of at least this range, power of ten"),
        y_label=say("range, MPa"), zero=True,
        note=say("The gap between the two lines of a gauge is what goes with the joints.")
        if places else "",
    )  # fmt: skip


def haigh(mean: FloatArray, *, amplitude: float, correction: Correction) -> FloatArray:
    """Return the amplitude (...) Pa that does at a mean (...) what `amplitude` does at nought.

    By bisection, as any correction rises with the amplitude; nan where none does.
    """
    low, high = np.zeros_like(mean), np.full_like(mean, 4 * amplitude)
    for _ in range(60):
        middle = (low + high) / 2
        more = correction(middle, mean) < amplitude
        low, high = np.where(more, middle, low), np.where(more, high, middle)
    return np.where(high >= 4 * amplitude * (1 - 1e-9), np.nan, high)


def _field(lives: Sequence[GaugeLife], plan: Plan, of: Heard, say: Language) -> Figure:
    """Return the Haigh diagram: cycles of field and model, and what the part bears."""
    worst = max(
        (one for one in lives if one.heard), key=lambda one: np.nan_to_num(one.life.damage),
        default=None,
    )  # fmt: skip
    knee = plan.curve.amplitude
    field = worst.cycles if worst is not None else None
    mean = np.array([0.0]) if field is None else (field.start + field.end) / 2
    size = np.array([0.0]) if field is None else field.amplitude
    model = _computed(of.identification, worst.name if worst else "")
    x = bounds(mean / MPa, *(m / MPa for m, _ in model), room=0.1)
    y = bounds(size / MPa, knee / MPa * 1.2, *(a / MPa for _, a in model), zero=True)
    chart = Chart(
        say=say, x=x, y=y, x_label=say("mean stress, MPa"), y_label=say("stress amplitude, MPa"),
    )  # fmt: skip
    if field is not None and field.count.size:
        _shaded(chart, mean / MPa, size / MPa, field.count)
        chart.key(say("{gauge}: cycles of the field", gauge=worst.name if worst else ""), 0)
    means = np.linspace(x[0], x[1], 200)
    chart.series(
        Series(
            name=say("amplitude at the knee of the S-N curve"), x=means,
            y=haigh(means * MPa, amplitude=knee, correction=plan.correction) / MPa,
        ),
        1,
    )  # fmt: skip
    for m, a in model:
        chart.series(
            Series(name=say("order 2 of the model"), x=m / MPa, y=a / MPa, joined=False,
                   points=True), 2,
        )  # fmt: skip
    return chart.figure(
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
        (x1, x2), (y1, y2) = chart.at(columns[i : i + 2], rows[k : k + 2])
        dark = 0.15 + 0.8 * max(math.log10(float(found[i, k])) + 1, 0.0) / top
        chart.put(rect(x1, y2, x2 - x1, y1 - y2, fill=PALETTE[0], fill_opacity=round(dark, 2)))


def _computed(of: Identification | None, gauge: str) -> list[tuple[FloatArray, FloatArray]]:
    """Return mean and amplitude of the model's order 2 at a gauge, where there is a model."""
    if of is None or gauge not in of.gauges:
        return []
    g = of.gauges.index(gauge)
    every = max(of.torque.size // 60, 1)
    return [(of.mean[g, ::every], np.abs(of.found[g, 1, ::every]))]


# --------------------------------------------------------------------------- pictures


def _pictures(of: Pictures, name: str, say: Language) -> Iterator[Block]:
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


def _drawn(power: Any, order: Any, say: Language) -> bytes:
    """Return a spectrogram, and an order map where there is one, as a picture."""
    needed("matplotlib")
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
    sheet: Any, axis: Any, x: FloatArray, y: FloatArray, z: FloatArray, label: str, say: Language
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
        return say.short(float(value), 4)

    figures = FuncFormatter(short)
    sheet.colorbar(shown, ax=axis, label=label, format=figures)
    axis.xaxis.set_major_formatter(figures)
    axis.yaxis.set_major_formatter(figures)


# --------------------------------------------------------------------------- orders


def order_cut(
    cuts: Cuts, names: Sequence[str], order: float, say: Language, *,
    found: Identification | None = None, late: tuple[float, float] | None = None,
) -> Iterator[Figure]:  # fmt: skip
    """Yield amplitude and phase of an order against speed, recorded and computed.

    What is computed stands beside one gauge at a time: of all of them nobody could tell the dots
    apart. `late`, low and high s, is how much later than its speed the stress may come: by that
    the phase tilts.
    """
    k, title = cuts.orders.index(order), say("Order {order}", order=say.short(order))
    every = max(cuts.windows.time.size // DOTS, 1)
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
        for said, values in ((say("as written"), found.written), (say("found"), found.found)):
            for g, name in enumerate(found.gauges):
                shown[f"{title}, {name}"].append((said, at, values[g, k], values[g, k]))
    for one, series in shown.items():
        yield from _cut(one, series, tilting(late, say), say)


def _cut(title: str, shown: Sequence[_Cut], tilts: str, say: Language) -> Iterator[Figure]:
    """Yield an amplitude and a phase, each series in dots."""

    def dots(name: str, x: FloatArray, y: FloatArray) -> Series:
        return Series(name=name, x=x, y=y, joined=False, points=True)

    yield plot(
        say, title=say("{order}: amplitude", order=title),
        series=[dots(name, x, np.abs(z) / MPa) for name, x, z, _ in shown],
        alt=say("Amplitude over shaft speed, window by window."),
        x_label=say("shaft speed, rpm"), y_label=say("amplitude, MPa"), zero=True,
    )  # fmt: skip
    yield plot(
        say, title=say("{order}: phase", order=title),
        series=[dots(name, x, np.angle(z, deg=True)) for name, x, _, z in shown],
        alt=say("Phase over shaft speed, window by window."),
        x_label=say("shaft speed, rpm"), y_label=say("phase against the shaft, deg"),
        y=(-190.0, 190.0),
        note=say("Only where the order stands three times above its noise.") + tilts,
    )  # fmt: skip


def tilting(late: tuple[float, float] | None, say: Language) -> str:
    """Return what a lag between `late`, s, does to a phase, as a sentence more; none if nothing."""
    if late is None:
        return ""
    low, high = (say.short(1e3 * at, 2) for at in late)
    return " " + say(
        "The stress comes {low} to {high} ms after its speed, by odds of nine in ten: within that "
        "nobody knows how the phase runs, {tilt} deg up or down for each hertz.",
        low=low, high=high, tilt=say.short(180 * (late[1] - late[0]), 2),
    )  # fmt: skip


# --------------------------------------------------------------------------- causes


def _causes(of: Causes, say: Language) -> Iterator[Block]:
    """Yield who did the damage, with the interval of the joints' part."""
    yield Figures(figures=(_removed(of, say),))
    for k, name in enumerate(of.gauges):
        head, *rows = shared(name, of, k, say)
        yield Table(
            caption=head[0], head=(say("cause"), *head[1:]),
            rows=tuple((row[0].strip(), *row[1:]) for row in rows),
        )  # fmt: skip
        yield Text(paragraphs=tuple(s.strip() for s in told(name, of, k, say)))
    doubts = tuple(say("doubt: {doubt}", doubt=say.said(d)) for d in of.doubts)
    yield Text(
        paragraphs=(
            say(
                "Shares are Shapley values; without it and alone are damages over that of all "
                "together."
            ),
            *doubts,
        )
    )


def _removed(of: Causes, say: Language) -> Figure:
    """Return what goes with the joints at each gauge, with its interval."""
    count = len(of.gauges)
    chart = Chart(
        say=say, x=(-10.0, 105.0), y=(-0.6, count - 0.4),
        x_label=say("damage that would go with the joints, %"), y_label="", values=False,
        height=90.0 + 46 * count,
    )  # fmt: skip
    chart.band(Band(low=-10, high=25, grade="pass", along="x"))
    chart.band(Band(low=35, high=105, grade="fail", along="x"))
    for k, (name, e) in enumerate(zip(of.gauges, of.evidence, strict=True)):
        low, high = (100 * v for v in e.interval)
        (x1, y), (x2, _) = chart.spot(max(low, -10), k), chart.spot(min(high, 105), k)
        chart.put(line(x1, y, x2, y, stroke=PALETTE[k % len(PALETTE)], stroke_width=7,
                       stroke_opacity=0.45))  # fmt: skip
        x, _ = chart.spot(100 * e.removed, k)
        chart.put(chart.mark(x, y, k, 5.0))
        # Beside a right end it would leave the figure.
        at, anchor = (x1, "start") if low < 50 else (x2, "end")
        told = f"{name}: {say(e.finding).upper()}"
        chart.put(text(at, y - 9, told, anchor=anchor, font_size=11))
    return chart.figure(
        title=say("What goes with the joints"),
        alt=say("Share of damage removed at each gauge with its 90 % interval."),
        note=say(
            "Guilty where the interval begins at 35 % or above and its middle is 50 % or more, "
            "innocent where it ends at 25 % or below."
        ),
    )


def identification(of: Identification, say: Language) -> Iterator[Block]:
    """Yield what a recording says of its application."""
    before, after = (say.number(100 * m) for m in of.misfit)
    shaken = modes(of, say)
    yield Table(
        caption=say(
            "{application}, {state}: order 2 as recorded against computed",
            application=of.application.title, state=say.state(of.state),
        ),
        head=(say("number"), say("of"), say("written"), say("found"), say("90 % interval"), ""),
        rows=(*(parameter(p, say) for p in of.parameters), *shaken),
        words=2,
        grades=(
            *(("", "", "", "", "", "warn" if p.otherwise else "") for p in of.parameters),
            *(("",) * 6 for _ in shaken),
        ),
    )  # fmt: skip
    yield Text(
        paragraphs=(
            say(
                "  unexplained of its energy: {before} % as written, {after} % as identified",
                before=before, after=after,
            ).strip(),
            *doubts(of, say),
        )
    )  # fmt: skip

"""The bracket's chapter of a report: cases, hot spots, gauges, frequencies, life, a picture."""

from collections.abc import Iterator
from dataclasses import replace
from io import BytesIO

import numpy as np

from cardan.base.units import MPa, N, mm, rpm
from cardan.model.bracket import Zone
from cardan.report import svg
from cardan.report.blocks import Block, Figures, Picture, Table, Text
from cardan.report.bracket import (
    MARKED,
    MICRO,
    SHOWN,
    bent_far,
    better,
    counted,
    crossed,
    first_hours,
    highest,
    hours,
    hours_of,
    hours_within,
    in_contact,
    known,
    lies,
    lives,
    parted,
    picture,
    pulled_off,
    remarks,
    response,
    span,
    telling_cases,
    untold,
    used,
    vague,
    worn,
    worst_use,
)  # fmt: skip
from cardan.report.bracket_scene import scene
from cardan.report.chart import Chart, Level, Series, bars, plot
from cardan.report.language import Language
from cardan.report.svg import INK, Figure
from cardan.report.wording import curve
from cardan.study.bracket import BracketAnswer
from cardan.study.bracket_forced import Forced
from cardan.study.bracket_judge import ORDERS, Judged
from cardan.study.bracket_life import strengths
from cardan.study.finding import Finding

_APART, _ALIKE = 0.05, 0.01
"""Share of a diagram's height that names of lines need, and below which two lines are one."""
_MARK = 4.0
"""Radius of a ring where an order meets a frequency, in pixels."""
_SHOWN = 0.03
"""Share of the largest stress below which a chart over speed ends."""


def chapter(found: Finding[BracketAnswer], say: Language) -> Iterator[Block]:
    """Yield what a study of a bracket found, original beside reinforced.

    Raises
    ------
    NotInstalled
        Without matplotlib.
    """
    assert found.answer is not None  # of a study that answered
    yield from told(found, say)
    yield _picture(found.answer, say)


def told(found: Finding[BracketAnswer], say: Language) -> Iterator[Block]:
    """Yield what a study of a bracket found, but for the picture of its stress."""
    of = found.answer
    assert of is not None  # of a study that answered
    yield Text(paragraphs=(say("The bracket of bearing {bearing}", bearing=of.bracket.bearing),))
    yield _compared(of, say)
    if len(of.variants) > 1:
        yield Text(paragraphs=(better(*of.variants[:2], say),))
    yield Text(
        paragraphs=(
            *(told for v in of.variants for told in crossed(v, say)),
            *(r for v in of.variants for r in (*response(v, say), *remarks(of, v, say))),
        )
    )
    for v in of.variants:
        yield _features(v, say)
        yield _stresses(v, say)
        if of.bracket.gauges:
            yield _readings(of, v, say)
        if lives(v):
            yield _damage(v, say)
    yield Figures(figures=tuple(figures(of, say)))
    yield Text(paragraphs=(*parted(of, found.checks, say), *notes(of, say)))


def _compared(of: BracketAnswer, say: Language) -> Table:
    """Return the variants side by side."""
    rows = [(say("mass, kg"), [v.mass for v in of.variants])]
    rows += [
        (
            say("stiffness at the bearing along {axis}, N/mm", axis=axis),
            [1 / float(v.compliance[k, k]) / (N / mm) for v in of.variants],
        )
        for k, axis in enumerate("xyz")
    ]
    if all(v.forced is None for v in of.variants):  # else the diagram has those of the line
        rows += [
            (
                say("frequency {mode}, loaded, Hz", mode=k + 1),
                [float(v.carried[k]) for v in of.variants],
            )
            for k in range(len(of.variants[0].carried))
        ]
    rows += [
        (say("first frequency by itself, Hz"), [float(v.frequencies[0]) for v in of.variants]),
        (
            say("highest stress, MPa"),
            [float(v.worst.hot.max()) / MPa for v in of.variants],
        ),
    ]
    if of.bracket.fatigue is not None and all(np.isfinite(used(v)).any() for v in of.variants):
        rows.append((
            worst_use(of, say),
            [100 * float(np.nanmax(used(v))) for v in of.variants],
        ))  # fmt: skip
    if all(lives(v) for v in of.variants):
        worst = [max(e.per_turn for e in lives(v)) for v in of.variants]
        rows.append((say("largest damage of a turn of the shaft"), worst))
    told = [(name, *(say.number(x) if x > 1e-4 or x == 0 else say.pointed(f"{x:.2e}")
                     for x in values)) for name, values in rows]  # fmt: skip
    if all(known(hours_of(v)) for v in of.variants):
        told.append((_of_hours(of.variants[0], say), *(first_hours(v, say) for v in of.variants)))
    return Table(
        caption=say("Original and reinforced") if len(of.variants) > 1 else say("The bracket"),
        head=("", *(say(v.name) for v in of.variants)),
        rows=tuple(told),
    )


def _of_hours(v: Judged, say: Language) -> str:
    """Return what hours to failure are told of."""
    as_recorded = v.lasting and not v.duty
    return say("hours to failure, driven as recorded") if as_recorded else say("hours to failure")


def _features(v: Judged, say: Language) -> Table:
    """Return where a crack may start: place, stress, use of the fatigue limit, life."""
    stress, cases = highest(v)
    share, lasts, within = used(v), hours_of(v), hours_within(v)
    return Table(
        caption=say("Where a crack may start: {name}", name=say(v.name)),
        head=(
            say("feature"), say("load case of its highest stress"), say("at x, y, z [mm]"), "MPa",
            say("fatigue use"), _of_hours(v, say),
        ),
        rows=tuple(
            (
                f"H{k + 1} {say.part(f.part)}" if k < MARKED else say.part(f.part),
                say.occasion(cases[k].case.when),
                say.pointed("  ".join(f"{round(x / mm)}" for x in f.point)),
                say.pointed(f"{stress[k] / MPa:.1f} ± {f.error * stress[k] / MPa:.1f}"),
                "-" if np.isnan(share[k]) else f"{100 * share[k]:.0f} %",
                hours(float(lasts[k]), say, within[k]),
            )
            for k, f in enumerate(v.shown)
        ),
        words=3,
    )  # fmt: skip


def _stresses(v: Judged, say: Language) -> Table:
    """Return the cases of a variant that stress it most."""

    def one(value: float) -> str:
        return say.pointed(f"{value / MPa:.1f}")

    caption = say("Stresses in MPa: {name}", name=say(v.name))
    if len(v.outcomes) > SHOWN:
        caption += say(", the highest {shown} of {count} cases", shown=SHOWN, count=len(v.outcomes))
    return Table(
        caption=caption,
        head=(say("case"), say("worst at"), "von Mises", say("tension"), say("compression")),
        rows=tuple(
            (
                say.occasion(o.case.when),
                say.part(v.features[int(o.hot.argmax())].part),
                one(o.von_mises.value), one(o.highest.value), one(o.lowest.value),
            )
            for o in telling_cases(v)
        ),
        words=2,
    )  # fmt: skip


def _readings(of: BracketAnswer, v: Judged, say: Language) -> Table:
    """Return what the gauges read, lowest and highest."""
    return Table(
        caption=say("Gauges, microstrain: {name}", name=say(v.name)),
        head=(say("case"), *(gauge.name for gauge in of.bracket.gauges)),
        rows=tuple(
            (
                say.occasion(o.case.when),
                *(say.pointed(span(low / MICRO, high / MICRO)) for low, high in o.strain.tolist()),
            )
            for o in telling_cases(v)
        ),
    )


def _damage(v: Judged, say: Language) -> Table:
    """Return damage and life."""

    def small(value: float) -> str:
        return "-" if value != value else say.pointed(f"{value:.3g}").replace("inf", "∞")

    return Table(
        caption=say("Damage and life where it is worst: {name}", name=say(v.name)),
        head=(
            say("case"),
            say("worst at"),
            say("damage per turn"),
            say("damage per hour"),
            say("hours to the first failure"),
        ),
        rows=tuple(
            (
                say.occasion(e.when),
                say.part(v.features[int(np.nanargmax(e.spots))].part) if e.worst > 0 else "",
                small(e.per_turn),
                small(e.per_hour),
                hours(e.hours, say, e.hours_within),
            )
            for e in worn(v)
        ),
        words=2,
    )


def figures(of: BracketAnswer, say: Language) -> Iterator[Figure]:
    """Yield the response over speed, Campbell's diagram, stress case by case, and Haigh's."""
    for v in of.variants:
        if v.forced is not None:
            yield _over_speed(v, v.forced, say)
    yield _campbell(of, say)
    yield _cases(of, say)
    if strengths(of.bracket):
        yield _haigh(of, say)


def _over_speed(v: Judged, forced: Forced, say: Language) -> Figure:
    """Return the stress that shaking makes at the worst feature, over speed, gear by gear."""
    of = forced.swept
    worst, at, k = forced.worst
    shakes = np.nan_to_num(forced.stress[..., k]).max(axis=0) > _SHOWN * forced.stress[worst, at, k]
    top = 1.1 * float(of.speed[shakes].max())
    drawn = of.speed <= top
    series = [
        Series(name=name, x=of.speed[drawn] / rpm, y=values[drawn] / MPa)
        for name, values in (
            *((curve(of, c, say), forced.stress[c, :, k]) for c in range(len(of.gears))),
            (say("{curve}, rigid bracket", curve=curve(of, worst, say)), forced.rigid[worst, :, k]),
        )
        if np.isfinite(values[drawn]).sum() > 1
    ]
    series = [
        replace(s, x=s.x[np.isfinite(s.y)], y=s.y[np.isfinite(s.y)]) for s in series
    ]  # fmt: skip
    part = say.part(v.features[k].part)
    title = say("Stress amplitude over speed at {part}: {name}", part=part, name=say(v.name))
    return plot(
        say,
        title=title,
        alt=f"{title}. " + " ".join(response(v, say)),
        series=series,
        x_label=say("shaft speed [rpm]"),
        y_label=say("stress amplitude [MPa]"),
        x=(0.0, 1.03 * top / rpm),
        zero=True,
        note=say(
            "{state}, at full load: orders 2 and up of the joints, through the line on its rubber "
            "and the bracket's own modes.", state=say.state(of.state),
        ),
    )  # fmt: skip


def _campbell(of: BracketAnswer, say: Language) -> Figure:
    """Return the orders' frequencies against speed, with the installed bracket's own."""
    v = of.variants[0]
    top = 1.1 * (of.top_speed / rpm if of.top_speed == of.top_speed else 3000.0)
    hertz = 1.1 * max(ORDERS) * top / 60
    frame = Chart(
        say=say, x=(0.0, top), y=(0.0, hertz), x_label=say("shaft speed [rpm]"),
        y_label=say("frequency [Hz]"),
    )  # fmt: skip
    for k, order in enumerate(ORDERS):
        x = np.array([0.0, top])
        frame.series(Series(name=say("order {order}", order=order), x=x, y=order * x / 60), k)
    beside: list[str] = []
    if v.forced is not None:
        names = [say(name) for name in v.forced.swept.names]
        own = list(zip(v.forced.swept.frequencies.tolist(), names, strict=True))
    else:
        own = [(f, say("mode {mode}", mode=k)) for k, f in enumerate(v.carried.tolist(), 1)]
    own = [(f, name) for f, name in own if f <= hertz]
    for k, (frequency, name) in enumerate(own):
        # Of lines that lie close the topmost bears all their names.
        beside.append(f"{name} {say.pointed(f'{frequency:.1f}')}")
        last = k + 1 == len(own) or own[k + 1][0] - frequency > _APART * hertz
        if last or own[k + 1][0] - frequency > _ALIKE * hertz:  # else their dashes make a bar
            level = Level(value=frequency, name=f"{say.list(*beside)} Hz" if last else "")
            frame.level(level, above=_MARK + 4)
        beside = [] if last else beside
        for order in ORDERS:
            at = 60 * frequency / order
            if at < top:
                frame.put(svg.circle(*frame.spot(at, frequency), _MARK, fill="none", stroke=INK))
    title = (
        say("Campbell's diagram of the line on rubber and bracket")
        if v.forced is not None
        else say("Speeds against the bracket's frequencies, with what it carries")
    )
    modes = say.list(*(f"{name} {say.number(f)} Hz" for f, name in own))
    return frame.figure(title=title, alt=f"{title}: {modes}")


def _cases(of: BracketAnswer, say: Language) -> Figure:
    """Return the highest stress of each variant, case by case, highest first."""
    cases = telling_cases(of.variants[0])
    names = [say.occasion(o.case.when) for o in cases]
    groups = [
        (
            say(v.name),
            np.array([
                next(o for o in v.outcomes if o.case.when == c.case.when).von_mises.value / MPa
                for c in cases
            ]),
        )
        for v in of.variants
    ]  # fmt: skip
    limit = of.bracket.material.yield_strength
    levels = [Level(value=limit / MPa, name=say("yield strength"), grade="fail")] if limit else []
    title = say("Highest stress, load case by load case")
    return bars(
        say, title=title, alt=f"{title}: {say.list(*names)}", groups=groups, levels=levels,
        categories=[str(k) for k in range(1, len(names) + 1)], y_label=say("von Mises stress, MPa"),
        note="; ".join(f"{k}: {name}" for k, name in enumerate(names, 1)),
    )  # fmt: skip


def _haigh(of: BracketAnswer, say: Language) -> Figure:
    """Return amplitude against mean of each zone's worst feature, and what each zone bears."""
    v, found = of.variants[0], strengths(of.bracket)
    lasting = [o for o in v.outcomes if o.case.repeats]
    series: list[Series] = []
    means = [float(o.mean[k]) / MPa for o in lasting for k in range(len(v.shown))]
    low, high = min([0.0, *means]), max([1.0, *means])
    for zone in dict.fromkeys(f.zone for f in v.features if f.zone in found):
        mine = [k for k, f in enumerate(v.features) if f.zone == zone]
        at = [max(mine, key=lambda k: float(np.nan_to_num(o.used[k]))) for o in lasting]
        x = np.array([o.mean[k] for o, k in zip(lasting, at, strict=True)]) / MPa
        y = np.array([o.amplitude[k] for o, k in zip(lasting, at, strict=True)]) / MPa
        series.append(Series(name=say(zone), x=x, y=y, joined=False, points=True))
    x = np.linspace(low, high, 41)
    borne: dict[tuple[float, ...], list[str]] = {}
    zones: dict[Zone, None] = dict.fromkeys(f.zone for f in v.features if f.zone in found)
    for zone in zones:
        # The amplitude that comes to the knee's: halving finds it, for corrections grow with it.
        least, most = np.zeros_like(x), np.full_like(x, 4 * found[zone].curve.amplitude)
        for _ in range(40):
            middle = (least + most) / 2
            over = found[zone].used(middle, x * MPa) > 1
            least, most = np.where(over, least, middle), np.where(over, middle, most)
        # Of zones that bear the same one line would hide the other.
        borne.setdefault(tuple((least / MPa).round(6)), []).append(say(zone))
    for y, names in borne.items():
        name = say("{zone}, borne at the knee", zone=", ".join(names))
        series.append(Series(name=name, x=x, y=np.array(y)))
    title = say("Haigh's diagram: amplitude against mean, each zone in each case")
    return plot(
        say, title=title, alt=title, series=series, x_label=say("mean stress [MPa]"),
        y_label=say("stress amplitude [MPa]"), zero=True,
    )  # fmt: skip


def notes(of: BracketAnswer, say: Language) -> Iterator[str]:
    """Yield what a reader of the numbers should know."""
    yield say(
        "Every place of the surface is asked. At toes and clamped borders, where the stress of a "
        "model depends on its mesh, the structural stress counts: carried on from 0.4 and 1.0 "
        "thicknesses away. ± is the estimated error of the refined mesh."
    )
    yield say(
        "The flange is held in two ways that have its stiffness between them, sliding under its "
        "bolts and clamped as one with the frame; of each feature the worse is told. In contact "
        "with the frame (`bolts`) stress may come to more than by either."
    )
    yield lies(say)
    for note in (in_contact, pulled_off, bent_far):
        yield from dict.fromkeys(told for v in of.variants for told in note(v, say))
    yield from (
        f"{say(v.name)}: {told}"
        for v in of.variants for told in (*vague(v, say), *untold(of, v, say))
    )  # fmt: skip
    if found := strengths(of.bracket):
        yield say(
            "Zones bear: {list}, amplitude at the knee.",
            list="; ".join(
                f"{say(zone)} {say.number(one.curve.amplitude / MPa)} MPa"
                + (f" ({one.name})" if one.name else "")
                for zone, one in found.items()
            ),
        )
        yield say("The throat of a weld, and its root, are not assessed.")
    if of.variants[0].forced is not None:
        loss = say.short(of.bracket.loss)
        yield say(
            "At the worst points and over the duty cycle the line swings on its rubber and on this "
            "bracket, which swings itself; the bracket loses {loss} of its energy in a radian. "
            "States at their own torque and top speed, on rigid bearings, and loads by hand are "
            "quasi-static.",
            loss=say("{value} (assumed)", value=loss) if of.bracket.loss_assumed else loss,
        )
    else:
        yield say("Loads are quasi-static: right below the natural frequencies.")
    if any(lives(v) for v in of.variants):
        yield counted(of, say)


def _picture(of: BracketAnswer, say: Language) -> Picture:
    """Return the variants under the original's worst case, still and to be turned about."""
    drawn = BytesIO()
    picture(of, drawn, say=say)
    first = of.variants[0]
    case = say.occasion(first.worst.case.when)
    found = next(o for o in first.outcomes if o is first.worst).von_mises
    alt = say(
        "The bracket deformed under {case}, coloured by von Mises stress; the highest, "
        "{stress} MPa, is at x {x}, y {y}, z {z} mm from the bearing's centre.",
        case=case, stress=say.pointed(f"{found.value / MPa:.1f}"),
        **{a: say.pointed(f"{p / mm:.0f}") for a, p in zip("xyz", found.point, strict=True)},
    )  # fmt: skip
    return Picture(
        title=say("Stress where it is worst: {case}", case=case),
        png=drawn.getvalue(), alt=alt, scene=scene(of, say=say),
    )  # fmt: skip

"""The bracket's chapter of a report: cases, hot spots, gauges, frequencies, life, a picture."""

from collections.abc import Iterator
from dataclasses import replace
from io import BytesIO

import numpy as np

from cardan.approval.study import StudyResult
from cardan.core.units import MPa, N, mm, rpm
from cardan.model.bracket import FatigueZone
from cardan.render import svg
from cardan.render.blocks import Block, Chapter, Figures, Picture, Table, Text
from cardan.render.chart import Chart, DataSeries, ReferenceLine, bar_chart, line_chart
from cardan.render.i18n import Translator
from cardan.render.phrases import torque_curve_name
from cardan.render.svg import TEXT_COLOUR, Figure
from cardan.topics.bracket.assessment import BracketResult
from cardan.topics.bracket.forced_response import ForcedResponse
from cardan.topics.bracket.life import fatigue_strength_by_zone
from cardan.topics.bracket.phrases import (
    contact_notes,
    contact_recommendation,
    damage_method_sentence,
    finite_element_solution_remarks,
    first_failure_text,
    forced_response_sentences,
    hours_text,
    joint_face_lift_off_notes,
    large_displacement_notes,
    life_bounds_note,
    number_range_text,
    resonance_sentences,
    stop_notes,
    uncertain_stress_notes,
    unknown_strength_notes,
    utilisation_label,
    variant_comparison_sentence,
)
from cardan.topics.bracket.presentation_picture import write_picture
from cardan.topics.bracket.presentation_values import (
    MAX_LISTED_CASES,
    MAX_MARKED_FATIGUE_FEATURES,
    STRAIN_PER_MICROSTRAIN,
    any_known,
    damage_results,
    feature_hours_bounds,
    feature_hours_to_failure,
    highest_stress,
    max_fatigue_utilisation,
    most_damaging_results,
    most_stressed_cases,
)
from cardan.topics.bracket.registration import REGISTRATION
from cardan.topics.bracket.scene import scene_html
from cardan.topics.bracket.shape_assessment import RESONANCE_CHECK_ORDERS
from cardan.topics.bracket.shape_result import ShapeAssessment

_APART, _ALIKE = 0.05, 0.01
"""Share of a diagram's height that names of lines need, and below which two lines are one."""
_MARK = 4.0
"""Radius of a ring where an order meets a frequency, in pixels."""
_SHOWN = 0.03
"""Share of the largest stress below which a chart over speed ends."""


def bracket_chapters(
    found: StudyResult[BracketResult], say: Translator, *, short: bool = False
) -> Iterator[Chapter]:
    """Yield the chapter on the bracket, the same in a short report."""
    del short
    yield Chapter(title=say(REGISTRATION.title), blocks=tuple(bracket_blocks(found, say)))


def bracket_blocks(found: StudyResult[BracketResult], say: Translator) -> Iterator[Block]:
    """Yield what a study of a bracket found, original next to reinforced.

    Raises
    ------
    MissingDependencyError
        If typst is not installed.
    """
    assert found.answer is not None  # of a study that answered
    yield from bracket_blocks_without_picture(found, say)
    yield _picture(found.answer, say)


def bracket_blocks_without_picture(
    found: StudyResult[BracketResult], say: Translator
) -> Iterator[Block]:
    """Yield what a study of a bracket found, but for the picture of its stress."""
    of = found.answer
    assert of is not None  # of a study that answered
    yield Text(paragraphs=(say("The bracket of bearing {bearing}", bearing=of.bracket.bearing),))
    yield _compared(of, say)
    if len(of.variants) > 1:
        yield Text(paragraphs=(variant_comparison_sentence(*of.variants[:2], say),))
    yield Text(
        paragraphs=(
            *(told for v in of.variants for told in resonance_sentences(v, say)),
            *(
                r
                for v in of.variants
                for r in (
                    *forced_response_sentences(v, say),
                    *finite_element_solution_remarks(of, v, say),
                )
            ),
        )
    )
    for v in of.variants:
        yield _features(v, say)
        yield _stresses(v, say)
        if of.bracket.gauges:
            yield _readings(of, v, say)
        if damage_results(v):
            yield _damage(v, say)
    yield Figures(figures=tuple(bracket_figures(of, say)))
    yield Text(paragraphs=(*contact_recommendation(of, found.checks, say), *bracket_notes(of, say)))


def _compared(of: BracketResult, say: Translator) -> Table:
    """Return the variants side by side."""
    rows = [(say("mass, kg"), [v.mass for v in of.variants])]
    rows += [
        (
            say("stiffness at the bearing along {axis}, N/mm", axis=axis),
            [1 / float(v.compliance[k, k]) / (N / mm) for v in of.variants],
        )
        for k, axis in enumerate("xyz")
    ]
    if all(
        v.forced_response is None for v in of.variants
    ):  # else the diagram has those of the line
        rows += [
            (
                say("frequency {mode}, loaded, Hz", mode=k + 1),
                [float(v.loaded_frequencies[k]) for v in of.variants],
            )
            for k in range(len(of.variants[0].loaded_frequencies))
        ]
    rows += [
        (say("first frequency by itself, Hz"), [float(v.frequencies[0]) for v in of.variants]),
        (
            say("highest stress, MPa"),
            [float(v.worst_case.feature_stress.max()) / MPa for v in of.variants],
        ),
    ]
    if of.bracket.fatigue is not None and all(
        np.isfinite(max_fatigue_utilisation(v)).any() for v in of.variants
    ):
        rows.append((
            utilisation_label(of, say),
            [100 * float(np.nanmax(max_fatigue_utilisation(v))) for v in of.variants],
        ))  # fmt: skip
    if all(damage_results(v) for v in of.variants):
        worst = [max(e.damage_per_turn for e in damage_results(v)) for v in of.variants]
        rows.append((say("largest damage of a turn of the shaft"), worst))
    told = [(name, *(say.number(x) if x > 1e-4 or x == 0 else say.with_decimal_sign(f"{x:.2e}")
                     for x in values)) for name, values in rows]  # fmt: skip
    if all(any_known(feature_hours_to_failure(v)) for v in of.variants):
        told.append(
            (_of_hours(of.variants[0], say), *(first_failure_text(v, say) for v in of.variants))
        )
    return Table(
        caption=say("Original and reinforced") if len(of.variants) > 1 else say("The bracket"),
        head=("", *(say(v.name) for v in of.variants)),
        rows=tuple(told),
    )


def _of_hours(v: ShapeAssessment, say: Translator) -> str:
    """Return what hours to failure refer to."""
    as_recorded = v.life_results and not v.duty_damage
    return say("hours to failure, driven as recorded") if as_recorded else say("hours to failure")


def _features(v: ShapeAssessment, say: Translator) -> Table:
    """Return where a crack may start: place, stress, use of the fatigue limit, life."""
    stress, cases = highest_stress(v)
    share, lasts, within = (
        max_fatigue_utilisation(v),
        feature_hours_to_failure(v),
        feature_hours_bounds(v),
    )
    return Table(
        caption=say("Where a crack may start: {name}", name=say(v.name)),
        head=(
            say("feature"),
            say("load case of its highest stress"),
            say("at x, y, z [mm]"),
            "MPa",
            say("fatigue use"),
            _of_hours(v, say),
        ),
        rows=tuple(
            (
                f"H{k + 1} {say.part(f.part)}"
                if k < MAX_MARKED_FATIGUE_FEATURES
                else say.part(f.part),
                say.occasion(cases[k].case.when),
                say.with_decimal_sign("  ".join(f"{round(x / mm)}" for x in f.point)),
                say.with_decimal_sign(f"{stress[k] / MPa:.1f} ± {f.error * stress[k] / MPa:.1f}"),
                "-" if np.isnan(share[k]) else f"{100 * share[k]:.0f} %",
                hours_text(float(lasts[k]), say, within[k]),
            )
            for k, f in enumerate(v.listed_features)
        ),
        words=3,
    )


def _stresses(v: ShapeAssessment, say: Translator) -> Table:
    """Return the cases of a variant that stress it most."""

    def one(value: float) -> str:
        return say.with_decimal_sign(f"{value / MPa:.1f}")

    caption = say("Stresses in MPa: {name}", name=say(v.name))
    if len(v.case_results) > MAX_LISTED_CASES:
        caption += say(
            ", the highest {shown} of {count} cases",
            shown=MAX_LISTED_CASES,
            count=len(v.case_results),
        )
    return Table(
        caption=caption,
        head=(say("case"), say("worst at"), "von Mises", say("tension"), say("compression")),
        rows=tuple(
            (
                say.occasion(o.case.when),
                say.part(v.features[int(o.feature_stress.argmax())].part),
                one(o.von_mises.value), one(o.max_principal.value), one(o.min_principal.value),
            )
            for o in most_stressed_cases(v)
        ),
        words=2,
    )  # fmt: skip


def _readings(of: BracketResult, v: ShapeAssessment, say: Translator) -> Table:
    """Return what the gauges read, lowest and highest."""
    return Table(
        caption=say("Gauges, microstrain: {name}", name=say(v.name)),
        head=(say("case"), *(gauge.name for gauge in of.bracket.gauges)),
        rows=tuple(
            (
                say.occasion(o.case.when),
                *(
                    say.with_decimal_sign(
                        number_range_text(
                            low / STRAIN_PER_MICROSTRAIN, high / STRAIN_PER_MICROSTRAIN
                        )
                    )
                    for low, high in o.gauge_strain_range.tolist()
                ),
            )
            for o in most_stressed_cases(v)
        ),
    )


def _damage(v: ShapeAssessment, say: Translator) -> Table:
    """Return damage and life."""

    def small(value: float) -> str:
        return "-" if value != value else say.with_decimal_sign(f"{value:.3g}").replace("inf", "∞")

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
                say.part(v.features[int(np.nanargmax(e.hot_spot_damage))].part)
                if e.worst_damage > 0
                else "",
                small(e.damage_per_turn),
                small(e.damage_per_hour),
                hours_text(e.hours_to_failure, say, e.hours_bounds),
            )
            for e in most_damaging_results(v)
        ),
        words=2,
    )


def bracket_figures(of: BracketResult, say: Translator) -> Iterator[Figure]:
    """Yield the response over speed, Campbell's diagram, stress case by case, and Haigh's."""
    for v in of.variants:
        if v.forced_response is not None:
            yield _over_speed(v, v.forced_response, say)
    yield _campbell(of, say)
    yield _cases(of, say)
    if fatigue_strength_by_zone(of.bracket):
        yield _haigh(of, say)


def _over_speed(v: ShapeAssessment, forced: ForcedResponse, say: Translator) -> Figure:
    """Return the stress that shaking makes at the worst feature, over speed, gear by gear."""
    of = forced.sweep
    worst, at, k = forced.worst
    shakes = np.nan_to_num(forced.stress[..., k]).max(axis=0) > _SHOWN * forced.stress[worst, at, k]
    top = 1.1 * float(of.speed[shakes].max())
    drawn = of.speed <= top
    series = [
        DataSeries(name=name, x=of.speed[drawn] / rpm, y=values[drawn] / MPa)
        for name, values in (
            *(
                (torque_curve_name(of, c, say), forced.stress[c, :, k])
                for c in range(len(of.gears))
            ),
            (
                say("{curve}, rigid bracket", curve=torque_curve_name(of, worst, say)),
                forced.rigid_stress[worst, :, k],
            ),
        )
        if np.isfinite(values[drawn]).sum() > 1
    ]
    series = [
        replace(s, x=s.x[np.isfinite(s.y)], y=s.y[np.isfinite(s.y)]) for s in series
    ]  # fmt: skip
    part = say.part(v.features[k].part)
    title = say("Stress amplitude over speed at {part}: {name}", part=part, name=say(v.name))
    return line_chart(
        say,
        title=title,
        alt=f"{title}. " + " ".join(forced_response_sentences(v, say)),
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


def _campbell(of: BracketResult, say: Translator) -> Figure:
    """Return the orders' frequencies against speed, with the installed bracket's own."""
    v = of.variants[0]
    top = 1.1 * (of.top_speed / rpm if of.top_speed == of.top_speed else 3000.0)
    hertz = 1.1 * max(RESONANCE_CHECK_ORDERS) * top / 60
    frame = Chart(
        say=say, x=(0.0, top), y=(0.0, hertz), x_label=say("shaft speed [rpm]"),
        y_label=say("frequency [Hz]"),
    )  # fmt: skip
    for k, order in enumerate(RESONANCE_CHECK_ORDERS):
        x = np.array([0.0, top])
        frame.add_series(
            DataSeries(name=say("order {order}", order=order), x=x, y=order * x / 60), k
        )
    beside: list[str] = []
    if v.forced_response is not None:
        names = [say(name) for name in v.forced_response.sweep.mode_names]
        own = list(zip(v.forced_response.sweep.frequencies.tolist(), names, strict=True))
    else:
        own = [
            (f, say("mode {mode}", mode=k)) for k, f in enumerate(v.loaded_frequencies.tolist(), 1)
        ]
    own = [(f, name) for f, name in own if f <= hertz]
    for k, (frequency, name) in enumerate(own):
        # Of lines that lie close the topmost bears all their names.
        beside.append(f"{name} {say.with_decimal_sign(f'{frequency:.1f}')}")
        last = k + 1 == len(own) or own[k + 1][0] - frequency > _APART * hertz
        if last or own[k + 1][0] - frequency > _ALIKE * hertz:  # else their dashes make a bar
            level = ReferenceLine(value=frequency, name=f"{say.join(*beside)} Hz" if last else "")
            frame.add_reference_line(level, above=_MARK + 4)
        beside = [] if last else beside
        for order in RESONANCE_CHECK_ORDERS:
            at = 60 * frequency / order
            if at < top:
                frame.add_elements(
                    svg.circle(
                        *frame.point_to_pixels(at, frequency),
                        _MARK,
                        fill="none",
                        stroke=TEXT_COLOUR,
                    )
                )
    title = (
        say("Campbell's diagram of the line on rubber and bracket")
        if v.forced_response is not None
        else say("Speeds against the bracket's frequencies, with what it carries")
    )
    modes = say.join(*(f"{name} {say.number(f)} Hz" for f, name in own))
    return frame.to_figure(title=title, alt=f"{title}: {modes}")


def _cases(of: BracketResult, say: Translator) -> Figure:
    """Return the highest stress of each variant, case by case, highest first."""
    cases = most_stressed_cases(of.variants[0])
    names = [say.occasion(o.case.when) for o in cases]
    groups = [
        (
            say(v.name),
            np.array([
                next(o for o in v.case_results if o.case.when == c.case.when).von_mises.value / MPa
                for c in cases
            ]),
        )
        for v in of.variants
    ]  # fmt: skip
    limit = of.bracket.material.yield_strength
    levels = (
        [ReferenceLine(value=limit / MPa, name=say("yield strength"), grade="fail")]
        if limit
        else []
    )
    title = say("Highest stress, load case by load case")
    return bar_chart(
        say, title=title, alt=f"{title}: {say.join(*names)}", groups=groups, levels=levels,
        categories=[str(k) for k in range(1, len(names) + 1)], y_label=say("von Mises stress, MPa"),
        note="; ".join(f"{k}: {name}" for k, name in enumerate(names, 1)),
    )  # fmt: skip


def _haigh(of: BracketResult, say: Translator) -> Figure:
    """Return amplitude against mean of each zone's worst feature, and what each zone bears."""
    v, found = of.variants[0], fatigue_strength_by_zone(of.bracket)
    lasting = [o for o in v.case_results if o.case.repeats]
    series: list[DataSeries] = []
    means = [float(o.mean[k]) / MPa for o in lasting for k in range(len(v.listed_features))]
    low, high = min([0.0, *means]), max([1.0, *means])
    for zone in dict.fromkeys(f.zone for f in v.features if f.zone in found):
        mine = [k for k, f in enumerate(v.features) if f.zone == zone]
        at = [max(mine, key=lambda k: float(np.nan_to_num(o.utilisation[k]))) for o in lasting]
        x = np.array([o.mean[k] for o, k in zip(lasting, at, strict=True)]) / MPa
        y = np.array([o.amplitude[k] for o, k in zip(lasting, at, strict=True)]) / MPa
        series.append(DataSeries(name=say(zone), x=x, y=y, draw_line=False, draw_markers=True))
    x = np.linspace(low, high, 41)
    borne: dict[tuple[float, ...], list[str]] = {}
    zones: dict[FatigueZone, None] = dict.fromkeys(f.zone for f in v.features if f.zone in found)
    for zone in zones:
        # The amplitude that comes to the knee's: halving finds it, for corrections grow with it.
        least, most = np.zeros_like(x), np.full_like(x, 4 * found[zone].curve.amplitude)
        for _ in range(40):
            middle = (least + most) / 2
            over = found[zone].utilisation(middle, x * MPa) > 1
            least, most = np.where(over, least, middle), np.where(over, middle, most)
        # Of zones that bear the same one line would hide the other.
        borne.setdefault(tuple((least / MPa).round(6)), []).append(say(zone))
    for y, names in borne.items():
        name = say("{zone}, borne at the knee", zone=", ".join(names))
        series.append(DataSeries(name=name, x=x, y=np.array(y)))
    title = say("Haigh's diagram: amplitude against mean, each zone in each case")
    return line_chart(
        say, title=title, alt=title, series=series, x_label=say("mean stress [MPa]"),
        y_label=say("stress amplitude [MPa]"), zero=True,
    )  # fmt: skip


def bracket_notes(of: BracketResult, say: Translator) -> Iterator[str]:
    """Yield what a reader of the numbers should know."""
    yield say(
        "Every place of the surface is evaluated. At toes and clamped borders, where the stress "
        "of a model depends on its mesh, the structural stress counts, extrapolated from 0.4 and "
        "1.0 thicknesses. ± is the estimated error of the refined mesh."
    )
    yield say(
        "The flange is held in two ways that have its stiffness between them, sliding under its "
        "bolts and clamped as one with the frame; for each feature the worse counts. In contact "
        "with the frame (`bolts`) stress may exceed both."
    )
    yield life_bounds_note(say)
    for note in (stop_notes, contact_notes, joint_face_lift_off_notes, large_displacement_notes):
        yield from dict.fromkeys(told for v in of.variants for told in note(v, say))
    yield from (
        f"{say(v.name)}: {told}"
        for v in of.variants
        for told in (*uncertain_stress_notes(v, say), *unknown_strength_notes(of, v, say))
    )
    if found := fatigue_strength_by_zone(of.bracket):
        yield say(
            "Zones bear: {list}, amplitude at the knee.",
            list="; ".join(
                f"{say(zone)} {say.number(one.curve.amplitude / MPa)} MPa"
                + (f" ({one.name})" if one.name else "")
                for zone, one in found.items()
            ),
        )
        yield say("The throat of a weld, and its root, are not assessed.")
    if of.variants[0].forced_response is not None:
        loss = say.compact_number(of.bracket.loss)
        yield say(
            "At the worst points and over the duty cycle the line swings on its rubber and on this "
            "bracket, which swings itself; the bracket loses {loss} of its energy in a radian. "
            "States at their own torque and top speed, on rigid bearings, and loads by hand are "
            "quasi-static.",
            loss=say("{value} (assumed)", value=loss) if of.bracket.loss_assumed else loss,
        )
    else:
        yield say("Loads are quasi-static: right below the natural frequencies.")
    if any(damage_results(v) for v in of.variants):
        yield damage_method_sentence(of, say)


def _picture(of: BracketResult, say: Translator) -> Picture:
    """Return the variants under the original's worst case, still and to be turned about."""
    drawn = BytesIO()
    write_picture(of, drawn, say=say)
    first = of.variants[0]
    case = say.occasion(first.worst_case.case.when)
    found = next(o for o in first.case_results if o is first.worst_case).von_mises
    alt = say(
        "The bracket deformed under {case}, coloured by von Mises stress; the highest, "
        "{stress} MPa, is at x {x}, y {y}, z {z} mm from the bearing's centre.",
        case=case,
        stress=say.with_decimal_sign(f"{found.value / MPa:.1f}"),
        **{
            a: say.with_decimal_sign(f"{p / mm:.0f}")
            for a, p in zip("xyz", found.point, strict=True)
        },
    )
    return Picture(
        title=say("Stress where it is worst: {case}", case=case),
        png=drawn.getvalue(), alt=alt, scene=scene_html(of, say=say),
    )  # fmt: skip

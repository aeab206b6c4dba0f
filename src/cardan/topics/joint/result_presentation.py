"""One joint or two as text, report and JSON: output, best phase, limits, the turn."""

from collections.abc import Iterator
from dataclasses import replace
from math import isnan, pi
from typing import Any

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.units import deg, rpm
from cardan.core.version import __version__
from cardan.render.blocks import Chapter, Figures, ReportDocument, Table, Text
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.svg import Figure
from cardan.render.terminal import report_table_lines
from cardan.render.text_layout import DEFAULT_WIDTH_COLUMNS, fold_lines
from cardan.topics.joint import presentation as one_joint
from cardan.topics.joint.joint_pair import JointPair
from cardan.topics.joint.joint_result import JointResult, OutputLimit
from cardan.topics.joint.presentation import (
    CURVE_POINT_COUNT,
    RADIANS_PER_ARCMINUTE,
    half_turn_angles_text,
    significant_digits_text,
)
from cardan.topics.joint.single_joint import SingleJoint

LIMIT_UNITS = {"acceleration": ("rad/s²", 1.0), "irregularity": ("%", 0.01)}
"""Unit of each limited quantity, and what one of it is worth, SI."""


def text_lines(
    of: JointResult, say: Translator = ENGLISH, *, width: int = DEFAULT_WIDTH_COLUMNS
) -> Iterator[str]:
    """Yield a joint, or two, line by line of text."""
    yield from fold_lines([*_titles(of, say), one_joint.zero_angle_sentence(of.joint, say)], width)
    for table in result_tables(of, say):
        yield from report_table_lines(table, width)
    yield from fold_lines(phase_tolerance_sentences(of, say), width)
    yield from report_table_lines(turn_table(of, say), width)


def summary_lines(of: JointResult, say: Translator = ENGLISH) -> Iterator[str]:
    """Yield a joint, or two, in two to five short lines."""
    yield from _titles(of, say)
    yield f"  {_motion_text(of.output, say)}"
    if of.pair is not None:
        yield say(
            "  equivalent angle {exact} deg (AE-7: {approximate} deg)",
            exact=significant_digits_text(of.output.angle / deg, say),
            approximate=significant_digits_text(of.pair.ae7_equivalent_angle / deg, say),
        )
        yield say(
            "  best phase {phase} deg leaves {angle} deg",
            phase=say.compact_number(round(of.pair.best_phase / deg, 3)),
            angle=significant_digits_text(of.pair.output_at_best_phase.angle / deg, say),
        )
    for limit in of.limits:
        unit, factor = LIMIT_UNITS[limit.quantity]
        yield say(
            "  limit {limit} {unit}: {grade}; largest angle {angle} deg",
            limit=say.compact_number(limit.maximum / factor, 5), unit=unit,
            grade=_grade(limit, say),
            angle=significant_digits_text(limit.largest_angle / deg, say),
        )  # fmt: skip


def _motion_text(of: SingleJoint, say: Translator) -> str:
    return say(
        "irregularity {share} %, acceleration ±{acceleration} rad/s², angle ±{lead} min",
        share=significant_digits_text(100 * of.irregularity, say),
        acceleration=significant_digits_text(of.max_acceleration, say),
        lead=significant_digits_text(of.max_lead_angle / RADIANS_PER_ARCMINUTE, say),
    )


def _titles(of: JointResult, say: Translator) -> Iterator[str]:
    yield one_joint.report_title(of.joint, say)
    if of.pair is not None:
        yield joint_pair_description(of.pair, say)


def joint_pair_description(of: JointPair, say: Translator) -> str:
    """Return what the second joint is, and how it stands to the first."""
    said = say(
        "Second joint at {angle} deg, yoke phase {phase} deg, planes {planes} deg apart",
        angle=say.compact_number(of.angle2 / deg),
        phase=say.compact_number(of.phase / deg),
        planes=say.compact_number(of.plane_angle / deg),
    )
    if not of.arrangement:
        return said
    return f"{said} ({say('{letter} arrangement', letter=of.arrangement)})"


def result_tables(of: JointResult, say: Translator) -> Iterator[Table]:
    """Yield the numbers of the output of two joints, of the joint, and of the limits."""
    alone = one_joint.results_table(of.joint, say)
    if of.pair is not None:
        yield pair_table(of.pair, say)
        alone = replace(alone, caption=say("Shaft between, and the cross of joint 1"))
    yield alone
    if of.limits:
        yield limits_table(of, say)


def pair_table(of: JointPair, say: Translator) -> Table:
    """Return the output of two joints, and what the best phase leaves, as a table."""
    return Table(
        caption=say("Output shaft behind both joints"),
        head=(say("quantity"), say("value"), say("unit"), say("at θ [deg]")),
        rows=tuple(_pair_rows(of, say)),
        words=1,
    )


def _pair_rows(of: JointPair, say: Translator) -> Iterator[tuple[str, ...]]:
    out, best = of.output, of.output_at_best_phase
    moves = out.angle > 0
    slowest, fastest = (rate / rpm for rate in out.driven_speed_range)
    yield say("Equivalent angle"), significant_digits_text(out.angle / deg, say), "deg", ""
    approximate = significant_digits_text(of.ae7_equivalent_angle / deg, say)
    yield f"  ({say('AE-7, small angles')})", approximate, "deg", ""
    lead = significant_digits_text(out.max_lead_angle / RADIANS_PER_ARCMINUTE, say)
    at = half_turn_angles_text(out.max_lead_input_angles, say) if moves else ""
    yield say("Angle ahead or behind, largest"), f"±{lead}", "min", at
    yield say("Speed, least"), significant_digits_text(slowest, say, 5), "rpm", ""
    yield say("Speed, largest"), significant_digits_text(fastest, say, 5), "rpm", ""
    yield _irregularity_row(say("Irregularity"), out, say)
    at = half_turn_angles_text(out.max_acceleration_input_angles, say) if moves else ""
    yield (*_acceleration_row(say("Acceleration, largest"), out, say)[:3], at)
    if out.driven_torque_range:
        low, high = (significant_digits_text(t, say, 5) for t in out.driven_torque_range)
        yield say("Torque in the output shaft, least"), low, "N·m", ""
        yield say("Torque in the output shaft, largest"), high, "N·m", ""
    phase = say.compact_number(round(of.best_phase / deg, 3))
    yield say("Yoke phase of least irregularity"), phase, "deg", ""
    left = significant_digits_text(best.angle / deg, say)
    yield f"  {say('equivalent angle there')}", left, "deg", ""
    yield _irregularity_row(f"  {say('irregularity there')}", best, say)
    yield _acceleration_row(f"  {say('acceleration there, largest')}", best, say)


def _irregularity_row(name: str, of: SingleJoint, say: Translator) -> tuple[str, ...]:
    return name, significant_digits_text(100 * of.irregularity, say), "%", ""


def _acceleration_row(name: str, of: SingleJoint, say: Translator) -> tuple[str, ...]:
    return name, f"±{significant_digits_text(of.max_acceleration, say)}", "rad/s²", ""


def limits_table(of: JointResult, say: Translator) -> Table:
    """Return each limit with the value, the largest angle that keeps it, and ω² β²."""
    return Table(
        caption=say("Limits of the output"),
        head=(
            say("quantity"), say("unit"), "", say("value"), say("limit"),
            say("largest angle [deg]"),
            say("by ω² β² [deg]"),
        ),
        rows=tuple(_limit_row(limit, say) for limit in of.limits),
        words=3,
    )  # fmt: skip


def _limit_row(of: OutputLimit, say: Translator) -> tuple[str, ...]:
    unit, factor = LIMIT_UNITS[of.quantity]
    name = {
        "acceleration": say("Acceleration, largest"), "irregularity": say("Irregularity"),
    }[of.quantity]  # fmt: skip
    near = of.approximate_angle
    return (
        name, unit, _grade(of, say), significant_digits_text(of.value / factor, say),
        say.compact_number(of.maximum / factor, 5),
        significant_digits_text(of.largest_angle / deg, say),
        "-" if near is None or near >= pi / 2 else significant_digits_text(near / deg, say),
    )  # fmt: skip


def _grade(of: OutputLimit, say: Translator) -> str:
    return say("within") if of.kept else say("beyond")


def phase_tolerance_sentences(of: JointResult, say: Translator) -> Iterator[str]:
    """Yield how far the yoke phase may deviate from the best one within the limits."""
    tolerance, pair = of.phase_tolerance, of.pair
    if tolerance is None or pair is None:
        return
    if isnan(tolerance):
        yield say("No yoke phase keeps the limits: the two joint angles differ too much.")
    elif tolerance >= pi / 2:
        yield say("Every yoke phase keeps the limits.")
    else:
        yield say(
            "The limits hold for a yoke phase of {phase} ± {tolerance} deg.",
            phase=say.compact_number(round(pair.best_phase / deg, 3)),
            tolerance=significant_digits_text(tolerance / deg, say, 3),
        )


def turn_table(of: JointResult, say: Translator) -> Table:
    """Return half a turn of the joint, or of the shaft between two and of the output."""
    if of.pair is None:
        return one_joint.half_turn_table(of.joint, say)
    at = one_joint.half_turn_input_angles()
    middle, out = of.joint.curves_over_turn(at), of.output.curves_over_turn(at)
    columns: list[tuple[str, FloatArray]] = [
        (say("shaft between, ahead [min]"), middle.lead_angle / RADIANS_PER_ARCMINUTE),
        (say("output, ahead [min]"), out.lead_angle / RADIANS_PER_ARCMINUTE),
        (say("output, speed [rpm]"), out.driven_speed / rpm),
        (say("output, acceleration [rad/s²]"), out.driven_acceleration),
    ]
    if out.driven_torque is not None:
        columns.append((say("output, torque [N·m]"), out.driven_torque))
    return one_joint.half_turn_columns_table(columns, say)


def joint_report(of: JointResult, say: Translator) -> ReportDocument:
    """Return a joint, or two, as a report."""
    say = say.with_minus_sign
    sentences = (
        *(() if of.pair is None else (joint_pair_description(of.pair, say),)),
        *phase_tolerance_sentences(of, say), one_joint.zero_angle_sentence(of.joint, say),
    )  # fmt: skip
    subtitle = "One universal joint by itself" if of.pair is None else "Two universal joints"
    return ReportDocument(
        language=say.code,
        title=one_joint.report_title(of.joint, say),
        subtitle=say(subtitle),
        grade="",
        verdict="",
        facts=((say("Made with"), f"cardan {__version__}"),),
        chapters=(
            Chapter(
                title=say("What it does"),
                blocks=(*result_tables(of, say), Text(paragraphs=sentences)),
            ),
            Chapter(
                title=say("Round the turn"),
                blocks=(Figures(figures=figures(of, say)), turn_table(of, say)),
            ),
        ),
    )


def figures(of: JointResult, say: Translator) -> tuple[Figure, ...]:
    """Return the curves round a turn: of two joints those of the output first."""
    if of.pair is None:
        return one_joint.figures(of.joint, say)
    theta = np.linspace(0, 360, CURVE_POINT_COUNT)
    middle, out = (j.curves_over_turn(theta * deg) for j in (of.joint, of.output))
    names = say("shaft between"), say("output")
    pairs = (
        (say("Angle ahead of the driving shaft"), "min",
         (middle.lead_angle / RADIANS_PER_ARCMINUTE, out.lead_angle / RADIANS_PER_ARCMINUTE)),
        (say("Speed behind each joint"), "rpm",
         (middle.driven_speed / rpm, out.driven_speed / rpm)),
        (say("Acceleration behind each joint"), "rad/s²",
         (middle.driven_acceleration, out.driven_acceleration)),
    )  # fmt: skip
    drawn = [(title, unit, tuple(zip(names, curves, strict=True))) for title, unit, curves in pairs]
    return (
        *one_joint.curve_charts(theta, drawn, say),
        *one_joint.figures(of.joint, say)[3:],  # the cross and the couples of joint 1
    )


def json_document(of: JointResult) -> dict[str, Any]:
    """Return a joint, or two, for programs: numbers, and curves at every degree of a turn."""
    found = one_joint.json_document(of.joint)
    if of.pair is not None:
        found["pair"] = _pair_json(of.pair)
    if of.limits:
        found["limits"] = [
            {
                "quantity": limit.quantity,
                "unit": "rad/s2" if limit.quantity == "acceleration" else "1",
                "limit": limit.maximum,
                "value": limit.value,
                "kept": limit.kept,
                "largest_angle_deg": limit.largest_angle / deg,
                "small_angle_deg": None
                if limit.approximate_angle is None
                else limit.approximate_angle / deg,
            }
            for limit in of.limits
        ]
    if (tolerance := of.phase_tolerance) is not None:
        found["pair"]["phase_tolerance_deg"] = None if isnan(tolerance) else tolerance / deg
    return found


def _pair_json(of: JointPair) -> dict[str, Any]:
    best = of.output_at_best_phase
    c = of.output.curves_over_turn(np.arange(360.0) * deg)
    return {
        "angle2_deg": of.angle2 / deg,
        "phase_deg": of.phase / deg,
        "plane_angle_deg": of.plane_angle / deg,
        "arrangement": of.arrangement or None,
        "output": {
            **_motion_json(of.output),
            "ae7_equivalent_angle_deg": of.ae7_equivalent_angle / deg,
        },
        "best_phase_deg": of.best_phase / deg,
        "output_at_best_phase": _motion_json(best),
        "curves": {
            "theta_deg": np.arange(360.0).tolist(),
            "ahead_min": (c.lead_angle / RADIANS_PER_ARCMINUTE).tolist(),
            "speed_rpm": (c.driven_speed / rpm).tolist(),
            "acceleration_rad_s2": c.driven_acceleration.tolist(),
        },
    }


def _motion_json(of: SingleJoint) -> dict[str, float]:
    low, high = of.driven_speed_range
    return {
        "equivalent_angle_deg": of.angle / deg,
        "ahead_min": of.max_lead_angle / RADIANS_PER_ARCMINUTE,
        "least_rpm": low / rpm,
        "largest_rpm": high / rpm,
        "irregularity": of.irregularity,
        "acceleration_rad_s2": of.max_acceleration,
    }

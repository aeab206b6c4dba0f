"""Messages about the limits of a line: values, grades, worst points, what is pending."""

from collections.abc import Iterator, Sequence
from itertools import islice
from math import isfinite

import numpy as np

from cardan.application.limit_profiles import limits_to_evaluate
from cardan.approval.driveline_study import EvaluatedLimit, check_limit_at_part, evaluate_limits
from cardan.checks.line_response import LineResponse
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.arrays import BoolArray
from cardan.core.verdict import MARGIN_TOLERANCE, Limit
from cardan.documents.line_drawing import worst_state_index
from cardan.render.i18n import Translator
from cardan.render.phrases import check_state_phrase, citation
from cardan.topics.design.suspension_travel import does_torque_wind_up_axle
from cardan.web.correction_handlers import IMMEDIATE_QUANTITIES, OPERATING_POINT_QUANTITIES
from cardan.web.parsed_document import Json, round_significant, round_significant_list

GRADE_SORT_WEIGHT = 1e6
"""What a grade weighs against margins: a failure goes first."""


def evaluated_limits(
    r: LineResponse, quantities: frozenset[str] = IMMEDIATE_QUANTITIES
) -> Iterator[tuple[int, EvaluatedLimit]]:
    """Yield each limit that applies to a line somewhere, with its number."""
    for k, a in enumerate(evaluate_limits(r, quantities=quantities)):
        if a.may_apply.any():
            yield k, a


def limit_rows(
    r: LineResponse, say: Translator, quantities: frozenset[str] = IMMEDIATE_QUANTITIES
) -> Iterator[Json]:
    """Yield each limit of a line with its values, (states, parts), and where each was found."""
    every = list(evaluated_limits(r, quantities))
    for (k, a), graded in zip(every, graded_values([a for _, a in every]), strict=True):
        yield {
            **limit_message(a.limit, r, k, say),
            "parts": [say.part(p) if p.kind != "line" else "" for p in a.parts],
            "kinds": [[p.kind, p.number, str(p.other)] for p in a.parts],
            **graded,
            **({"bounds": bounds.tolist()} if (bounds := _are_lower_bounds(a)).any() else {}),
            **(
                {"points": _worst_point_texts(r, a, say), "spots": _worst_point_torques(r, a)}
                if a.worst_points
                else {}
            ),
        }


def graded_values(of: Sequence[EvaluatedLimit]) -> Iterator[Json]:
    """Yield the values of each limit with what it makes of them, (states, parts)."""
    if not of:
        return
    judged = [a.grades_and_margins() for a in of]
    known = [~np.isnan(a.values) for a in of]
    numbers = [
        *(a.values / QUANTITIES[a.limit.quantity].si_factor for a in of),
        *(np.where(k, margins, np.nan) for k, (_, margins) in zip(known, judged, strict=True)),
    ]
    # A hand waits for all of them: what is done to each number is done to all at once.
    told = iter(round_significant_list(np.concatenate([n.ravel() for n in numbers])))
    rows = [[list(islice(told, n.shape[1])) for _ in n] for n in numbers]
    for k, (values, margins) in enumerate(zip(rows[: len(of)], rows[len(of) :], strict=True)):
        grades = np.where(known[k], judged[k][0], -1).tolist()
        yield {
            "values": values,
            "margins": margins,
            "grades": [[None if g < 0 else g for g in row] for row in grades],
        }


def deciding_state_index(r: LineResponse) -> int:
    """Return the state with the worst of what is known at once; without limits, of most shaking."""
    worst = np.full(len(r.demand.states), -np.inf)
    for _, a in evaluated_limits(r):
        known = ~np.isnan(a.values)
        grades, margins = a.grades_and_margins()
        bad = GRADE_SORT_WEIGHT * grades - margins
        worst = np.maximum(worst, np.where(known, bad, -np.inf).max(axis=1))
    return int(worst.argmax()) if isfinite(worst.max()) else worst_state_index(r)


def limit_id(r: LineResponse, limit: Limit, k: int) -> str:
    """Return the name that the page knows the k-th part of a limit by."""
    return f"{r.line.name}/{limit.quantity}/{k}"


def limit_message(limit: Limit, r: LineResponse, k: int, say: Translator) -> Json:
    """Return a limit: its quantity, bounds, unit and source."""
    q = QUANTITIES[limit.quantity]

    def shown(value: float | None) -> float | None:
        return None if value is None else round_significant(value / q.si_factor)

    return {
        "id": limit_id(r, limit, k),
        "quantity": limit.quantity,
        "line": r.line.name,
        "name": say.name(limit.quantity),
        "unit": q.unit_symbol,
        "sense": "band" if limit.band else limit.sense,
        "normal": shown(limit.normal),
        "maximum": shown(limit.maximum),
        "band": [shown(b) for b in limit.band] if limit.band else None,
        "required": limit.required,
        "source": citation(limit.source, say),
    }


def _are_lower_bounds(a: EvaluatedLimit) -> BoolArray:
    """Return which values are known as lower bounds alone, (states, parts)."""
    return a.validity_margin < -MARGIN_TOLERANCE


def _worst_point_texts(r: LineResponse, a: EvaluatedLimit, say: Translator) -> list[list[str]]:
    """Return where in its state each value was found worst."""
    states, parts = a.values.shape
    return [
        [
            check_state_phrase(c, say) if (c := check_limit_at_part(r, a, s, p)) else ""
            for p in range(parts)
        ]
        for s in range(states)
    ]


def _worst_point_torques(r: LineResponse, a: EvaluatedLimit) -> list[list[Json | None]]:
    """Return under what torque in its state each value was found worst; None where its own."""
    assert a.worst_points is not None
    found: list[list[Json | None]] = []
    for s in range(len(a.values)):
        at = [
            a.worst_points.operating_point((s, p)) if does_torque_wind_up_axle(r) else None
            for p in range(a.values.shape[1])
        ]
        found.append(
            [
                {"torque_Nm": round_significant(q.torque), "way": q.direction} if q else None
                for q in at
            ]
        )
    return found


def pending_limits(r: LineResponse, say: Translator) -> Iterator[Json]:
    """Yield the limits whose values come with a later answer."""
    for k, limit in enumerate(
        m
        for m in limits_to_evaluate(r.application)
        if m.quantity in OPERATING_POINT_QUANTITIES and not m.if_given
    ):
        if r.line.joint_count > 2:
            yield limit_message(limit, r, k, say)

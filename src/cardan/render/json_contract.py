"""Parts of the JSON contract that every document of it shares: checks, coverage, data, numbers."""

from math import isfinite, pi
from typing import Any

import numpy as np

from cardan.application.quantity_lookup import declared_quantity
from cardan.approval.coverage import CheckCoverage
from cardan.approval.data_provenance import CatalogueDatum
from cardan.core.labels import EvaluationCondition, OperatingPoint, OrderCrossing, Part
from cardan.core.units import rpm
from cardan.core.verdict import Check, UnevaluatedCheck
from cardan.core.version import __version__

JSON_FORMAT_VERSION = ".".join(__version__.split(".")[:2])


SIGNIFICANT_DIGITS = 12
"""Significant digits of a number: what is left of it on every machine."""


def check_json(of: Check) -> dict[str, Any]:
    """Return one check, in the unit its quantity is shown in."""
    quantity = declared_quantity(of.quantity)
    return {
        "quantity": of.quantity,
        "line": of.line,
        **_location_json(of.when, of.part),
        "value": of.value / quantity.si_factor,
        "limit": of.bound / quantity.si_factor,
        "sense": "outside" if of.limit.band else of.limit.sense,
        "unit": quantity.unit_symbol,
        "margin": of.margin,
        "verdict": of.grade,
        **({"is_lower_bound": True} if of.is_lower_bound else {}),
        "source": str(of.limit.source),
        "how_read": of.how_read or None,
        **({"point": operating_point_json(of.point)} if of.point else {}),
        **({"mode": _mode_json(of.mode)} if of.mode else {}),
        **(
            {
                "value_within": _interval_json(of.within, quantity.si_factor),
                "may_be": of.worst_possible_grade,
                "may_be_as_good_as": of.best_possible_grade,
            }
            if of.within
            else {}
        ),
        **(
            {
                "assumed": [
                    {"input": a.name, "low": a.low, "high": a.high, "unit": a.unit}
                    for a in of.assumed
                ]
            }
            if of.assumed
            else {}
        ),
        **({"settled_by": list(of.deciding_inputs)} if of.deciding_inputs else {}),
    }


def _interval_json(ends: tuple[float, float], factor: float) -> list[float | None]:
    """Return between what a value may lie; None for no end."""
    return [end / factor if isfinite(end) else None for end in ends]


def _mode_json(mode: OrderCrossing) -> dict[str, Any]:
    return {
        "shape": mode.shape, "frequency_Hz": mode.frequency / (2 * pi), "order": mode.order,
    }  # fmt: skip


def catalogue_datum_json(of: CatalogueDatum) -> dict[str, Any]:
    """Return a row of data that the numbers stand on, and how its values were read."""
    return {
        "line": of.line,
        "kind": of.kind,
        "name": of.name,
        "parts": list(of.part_numbers),
        "source": str(of.source),
        "how_read": of.source.how_read or None,
        "apart": dict(of.source.apart),
        "note": of.note,
    }


def operating_point_json(of: OperatingPoint) -> dict[str, Any]:
    """Return an operating point."""
    return {
        "gear": of.gear,
        "direction": of.direction,
        "speed_rpm": of.speed / rpm,
        "torque_Nm": of.torque,
        **({"spline": "stuck"} if of.is_spline_stuck else {}),
    }


def coverage_json(of: CheckCoverage) -> dict[str, Any]:
    """Return what was evaluated, and what was not, with the missing input."""
    return {
        "asked": of.total,
        "answered": of.evaluated,
        "unanswered": [unevaluated_json(u) for u in of.unevaluated],
    }


def unevaluated_json(of: UnevaluatedCheck) -> dict[str, Any]:
    """Return one limit that applies and got no number."""
    return {
        "quantity": of.quantity,
        "line": of.line,
        **_location_json(of.when, of.part),
        "needs": list(of.missing_inputs),
        "required": of.limit.required,
    }


def _location_json(when: EvaluationCondition, part: Part) -> dict[str, Any]:
    """Return when and of what, in words and as what they are."""
    return {
        "state": str(when),
        "part": str(part),
        "when": {"kind": when.kind, "name": when.name, "what": when.what},
        "of": {"kind": part.kind, "number": part.number, "other": part.other},
    }


def to_json_types(value: Any) -> Any:
    """Return a document of Python's own types, with null for what is not a number.

    Numbers keep as many digits as are the same on every machine.
    """
    if isinstance(value, dict):
        return {k: to_json_types(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [to_json_types(v) for v in value]
    if isinstance(value, float | np.floating):
        return float(f"{value:.{SIGNIFICANT_DIGITS}g}") if isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value

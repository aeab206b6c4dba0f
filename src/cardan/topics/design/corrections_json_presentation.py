"""Corrections as the JSON contract has them."""

from typing import Any

from cardan.model.adjustments import ADJUSTMENTS
from cardan.render.json_contract import check_json, to_json_types, unevaluated_json
from cardan.topics.design.corrections import Correction
from cardan.topics.design.robustness import ToleranceModel, ToleranceYield


def corrections_json(of: tuple[Correction, ...]) -> list[dict[str, Any]]:
    """Return corrections, with what they move in mm and deg and the verdict each gives."""
    return to_json_types(
        [
            {
                "line": p.line,
                "verdict": p.verdict,
                "cost": p.cost,
                "margin": p.margin,
                "margin_before": p.margin_before,
                "smallest_margin": p.approval.smallest_margin,
                "smallest_margin_before": p.installed_approval.smallest_margin,
                "moves": [
                    {
                        "what": m.adjustable.adjustment_key,
                        "part": m.adjustable.part,
                        f"amount_{movable.unit}": m.amount / movable.unit_value,
                    }
                    for m in p.adjustments
                    for movable in (ADJUSTMENTS[m.adjustable.adjustment_key],)
                ],
                "survival": production_yield_json(p.tolerance_yield, p.tolerance_model),
                "checks": [check_json(c) for c in p.checks],
                "unanswered": [unevaluated_json(u) for u in p.unevaluated],
            }
            for p in of
        ]
    )


def production_yield_json(
    found: ToleranceYield | None, trucks: ToleranceModel | None
) -> dict[str, Any] | None:
    """Return how many trucks keep what is proposed; null where nothing scatters."""
    if found is None or trucks is None:
        return None
    return {
        "share": found.share,
        "share_without_warnings": found.share_without_warnings,
        "each_asked": found.individually_evaluated,
        "lost": found.most_failed_quantity or None,
        "tighten_first": found.best_tightening
        and {"name": found.best_tightening[0], "share": found.best_tightening[1]},
        "assumed": trucks.assumed,
        "tolerances": [
            {"name": name, "kind": s.kind, "value": s.values[0]} for name, s in trucks.tolerances
        ],
    }

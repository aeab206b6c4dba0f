"""The JSON document of a study of variants."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.verdict import VERDICTS
from cardan.render.json_contract import JSON_FORMAT_VERSION, to_json_types
from cardan.topics.variants.evaluation import UNEVALUATED_GRADE_CODE
from cardan.topics.variants.statistics import (
    StatisticState,
    halved_tolerance_yields,
    quantile,
    sobol_indices,
)
from cardan.topics.variants.study_result import VariantStudyResult

# --------------------------------------------------------------------------- for programs


def json_document(of: VariantStudyResult) -> dict[str, Any]:
    """Return a study as the document that `cardan study --json` writes."""
    ask, counts, drawn = of.variants.ask, of.statistics["counts"], of.sampling_plan
    found: dict[str, Any] = {
        "cardan": JSON_FORMAT_VERSION,
        "application": of.installed.application.title,
        "profile": of.installed.application.profile,
        "verdict_as_it_is": of.installed.verdict,
        "variants": of.count,
        "asked": of.requested_count,
        "drawn_by_themselves": of.independent_count,
        "points": drawn.method,
        "seed": drawn.seed,
        "inputs": [
            {
                "name": drawn.name_of(f),
                "as_it_is": drawn.nominal[f.input],
                "kind": f.spread.kind,
                "values": list(f.spread.values),
                "tolerance": f.tolerance,
            }
            for f in (*drawn.grids, *drawn.factors)
        ],
        "correlated": [
            {"between": [one, other], "correlation": r} for one, other, r in of.variants.correlated
        ],
        "read_anew": list(of.evaluator.unvectorised_inputs),
        "shares": of.shares,
        "cannot_exist": int(counts["refused"]),
        "lower_bounds_alone": of.lower_bound_share,
        "limits": [] if ask.yield_only else [_limit(of, k) for k in range(len(of.limits))],
        "worst": [
            {
                "variant": int(place),
                "verdict": VERDICTS[int(v)],
                "margin": float(m),
                "limit": of.limit_names[int(k)] if k != UNEVALUATED_GRADE_CODE else None,
                "inputs": dict(zip(drawn.names, inputs.tolist(), strict=True)),
            }
            for place, v, m, k, inputs in _rows(
                of.statistics["worst"], "place", "verdict", "margin", "limit", "inputs"
            )
        ],
    }
    if of.changed_files:
        found["changed_while_running"] = [
            {
                "file": file.name,
                "sha256_at_start": file.digest_before,
                "sha256_at_end": file.digest_after,
            }
            for file in of.changed_files
        ]
    if ask.yield_:
        found["yield"] = {
            "share": of.yield_,
            "confidence": ask.confidence,
            "clopper_pearson": list(of.interval()),
            "wilson": list(of.interval(exact=False)),
        }
    if ask.yield_only:
        found["yield"]["not_evaluated_on_rubber"] = of.stopped_count
    if "tighter" in of.statistics:
        passes, error = halved_tolerance_yields(of.statistics["tighter"])
        found["halved_tolerances"] = [
            {"name": drawn.name_of(f), "yield": float(p), "standard_error": float(e)}
            for f, p, e in zip(of.tolerance_factors, passes[:, 0], error[:, 0], strict=True)
        ]
    if "sobol" in of.statistics:
        found["sobol"] = _indices(of)
    if of.variants.ask.rare:
        found["rare"] = [
            {
                "limit": of.limit_names[of.limits.index((r.line, r.limit))],
                "failure": r.failure_probability,
                "ways": len(r.failure_modes),
                "beta": r.first_order.beta if r.first_order else None,
                "first_order": r.first_order.failure_probability
                if r.first_order and not r.first_order.sampled
                else None,
                "second_order": r.second_order.failure_probability if r.second_order else None,
                "standard_error": r.sampled.standard_error if r.sampled else None,
                "most_likely": dict(zip(drawn.names, r.inputs.tolist(), strict=True)),
            }
            for r in of.rare_failures
        ]
        found["rare_beyond"] = [
            of.limit_names[of.limits.index((r.line, r.limit))] for r in of.negligible_failures
        ]
    if of.surrogate_yield:
        f = of.surrogate_yield
        found["foretold"] = {
            "count": f.count,
            "taught": f.training_count,
            "yield": f.share,
            "interval": [f.low, f.high],
            "wrongly_failing": f.false_failures,
            "wrongly_fit": f.false_passes,
            "of_those_asked": f.without_surrogate,
        }
    if "pareto" in of.statistics:
        found["pareto"] = [
            {
                "variant": int(place),
                "verdict": VERDICTS[int(v)],
                **{
                    g: float(-x if g == "margin" else x)
                    for g, x in zip(ask.pareto, goals, strict=True)
                },
                "inputs": dict(zip(drawn.names, inputs.tolist(), strict=True)),
            }
            for place, v, goals, inputs in _rows(
                of.statistics["pareto"], "place", "verdict", "goals", "inputs"
            )
        ]
    if of.maps:
        found["maps"] = [
            {
                "over": [drawn.names[k] for k in chart.columns],
                "edges": [list(e) for e in chart.edges],
                "count": state["count"].astype(int).tolist(),
                "yield": (
                    state["passes"] / np.where(state["count"], state["count"], np.nan)
                ).tolist(),
            }
            for chart, state in of.maps
        ]
    return to_json_types(found)


def _rows(state: StatisticState, *names: str) -> Iterator[tuple[Any, ...]]:
    yield from zip(*(state[n] for n in names), strict=True)


def _limit(of: VariantStudyResult, k: int) -> dict[str, Any]:
    (line, limit), counts = of.limits[k], of.statistics["counts"]
    values, number, q = of.statistics["values"], len(of.limits), QUANTITIES[limit.quantity]
    grades = (counts["grades"][k] / of.independent_count).tolist()
    return {
        "name": of.limit_names[k],
        "quantity": limit.quantity,
        "line": line,
        "unit": q.unit_symbol,
        "normal": None if limit.normal is None else limit.normal / q.si_factor,
        "maximum": None if limit.maximum is None else limit.maximum / q.si_factor,
        "shares": dict(zip(("pass", "warn", "fail", "no answer"), grades, strict=True)),
        "fails_alone": float(counts["alone"][k] / of.independent_count),
        "lower_bounds": float(of.lower_bound_shares[k]),
        "least": float(values["least"][k] / q.si_factor),
        "most": float(values["most"][k] / q.si_factor),
        "smallest_margin": float(values["least"][number + k]),
        "quantiles": [
            {
                "share": s,
                "value": quantile(values, k, s) / q.si_factor,
                "margin": quantile(values, number + k, s),
            }
            for s in of.variants.ask.quantiles
        ],
    }


def _indices(of: VariantStudyResult) -> list[dict[str, Any]]:
    found = sobol_indices(of.statistics["sobol"])
    titles = ["margin", "may be built", *of.limit_names]
    return [
        {
            "of": title,
            "factors": [
                {
                    "name": of.sampling_plan.name_of(f),
                    "tolerance": f.tolerance,
                    "first": float(found.first[c, k]),
                    "first_error": float(found.first_error[c, k]),
                    "total": float(found.total[c, k]),
                    "total_error": float(found.total_error[c, k]),
                }
                for k, f in enumerate(of.sampling_plan.factors)
            ],
        }
        for c, title in enumerate(titles)
        if np.isfinite(found.total[c]).any()
    ]

"""Limits that leave no value between them: each is a requirement, and both are named."""

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from cardan.approval.driveline_study import EvaluatedLimit, evaluate_limits
from cardan.checks.line_response import LineResponse
from cardan.checks.quantities.registry import LINE_QUANTITIES, QUANTITIES
from cardan.core.labels import Part
from cardan.core.message import TranslatableMessage, translatable_message
from cardan.core.verdict import Limit

_LIMITS_OF_ONE_ANGLE = frozenset({
    "joint_angle", "joint_angle_min", "compound_angle", "odd_joint_angle"
})  # fmt: skip
"""Quantities that are the same angle, limited from above and from below under several names."""


def conflicting_limits(responses: Sequence[LineResponse]) -> Iterator[TranslatableMessage]:
    """Yield each pair of limits that no value of a part satisfies, once for a line.

    A lower bound that reaches an upper one leaves at most that one number. Bounds of both
    kinds count: where the pair is a maximum and a normal one, the line warns whatever it is.
    """
    for r in responses:
        for group in _groups(r):
            asked = list(evaluate_limits(r, quantities=group))
            lower, upper = ([q for q in asked if q.limit.sense == s] for s in (">=", "<="))
            for low, high in product(lower, upper):
                bounds = _crossed_bounds(low.limit, high.limit)
                parts = _common_parts(low, high)
                if bounds and parts:
                    yield _message(r, low.limit, high.limit, bounds, parts)


def _groups(r: LineResponse) -> Iterator[frozenset[str]]:
    """Yield the quantities of a line that are one number, where bounds of them cross."""
    found: dict[frozenset[str], list[Limit]] = {}
    for key in LINE_QUANTITIES:
        group = _LIMITS_OF_ONE_ANGLE if key in _LIMITS_OF_ONE_ANGLE else frozenset({key})
        own = (m for m in LINE_QUANTITIES[key].rated_limits(r) if m is not None)
        limits = (*(m for m in r.application.limits if m.quantity == key), *own)
        found.setdefault(group, []).extend(limits)
    for group, limits in found.items():
        pairs = product(*([m for m in limits if m.sense == s] for s in (">=", "<=")))
        if any(_crossed_bounds(low, high) for low, high in pairs):
            yield group


def _crossed_bounds(low: Limit, high: Limit) -> tuple[float, float] | None:
    """Return the gravest bounds, SI, of a lower and an upper limit that leave no room."""
    for one, other in product(("maximum", "normal"), repeat=2):
        least, most = getattr(low, one), getattr(high, other)
        if least is not None and most is not None and least >= most:
            return least, most
    return None


def _common_parts(one: EvaluatedLimit, other: EvaluatedLimit) -> tuple[Part, ...]:
    """Return the parts that both limits apply to in some state."""
    places = {part: k for k, part in enumerate(other.parts)}
    return tuple(
        part
        for k, part in enumerate(one.parts)
        if part in places
        and np.any(one.may_apply[:, k] & other.may_apply[:, places[part]])
        and not one.lacks_rating[k]
        and not other.lacks_rating[places[part]]
    )


def _message(
    r: LineResponse, low: Limit, high: Limit, bounds: tuple[float, float], parts: tuple[Part, ...]
) -> TranslatableMessage:
    """Return the sentence that names both limits."""
    below, above = (QUANTITIES[m.quantity] for m in (low, high))
    return translatable_message(
        "limits of line {line}, {parts}, leave no room between them: {lower} at least {least} "
        "{unit} ({lower_source}), {upper} at most {most} {unit} ({upper_source})",
        line=r.line.name,
        parts=parts,
        lower=below.name,
        least=f"{bounds[0] / below.si_factor:.4g}",
        lower_source=str(low.source),
        upper=above.name,
        most=f"{bounds[1] / above.si_factor:.4g}",
        upper_source=str(high.source),
        unit=below.unit_symbol,
    )

"""Given numbers that the verdict rests on: how far each may be off before a criterion fails."""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress

import numpy as np

from cardan.application.overrides import addresses, change
from cardan.approval.driveline_study import evaluate_limits
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.checks.quantities.registry import LINE_QUANTITIES
from cardan.core.arrays import FloatArray
from cardan.core.compiled import without_compiled_loops
from cardan.core.errors import CardanError
from cardan.core.lazy_dataclass import dataclass
from cardan.core.verdict import Check
from cardan.model.application import Application
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references

RELATIVE_STEP = 0.01
"""Share by which each number is changed, one at a time, to find how a criterion follows it."""

MAX_RELATIVE_CHANGE = 0.25
"""Share up to which a slope says where a criterion fails, roughly: assumed."""

MAX_REFINED_CHANGES = 6
"""Numbers, those of the least change, whose change is searched where the criterion fails."""

SECANT_STEPS = 3
MAX_RESIDUAL_SHARE = 0.02
"""Share of the room as given that the last secant step may miss the maximum by."""

CONVERGED_SHARE = 1e-7
"""Share of the room as given below which a secant would be of rounding errors."""

MAX_ROUNDING_SHARE = 0.015
"""Share of a change that rounding may add to it."""

OUTWARD_SHARE = 0.001
"""Share of a change that is added before rounding, so that what is printed is exceeded."""

MAX_DECIDING_INPUTS = 2
MAX_TRIED_QUANTITIES = 3
MAX_CHANGED_NUMBERS = 500
"""Numbers of a file above which none are changed: long duties and curves take too long."""

RATING_KEYS = (".angle_max", ".n_beta_max", ".speed_max")
"""Ratings of a joint that are limits: limits have no variants."""

GEOMETRY_KEYS = ("points", "slopes", "joint_angles", "length")
"""Keys that states may give once more, so that a change of one alone is refused."""


@dataclass(frozen=True, kw_only=True)
class DecidingInput:
    """A number of the file and where its criterion would fail, both in the key's unit."""

    key: str
    given: float
    fails_at: float

    @property
    def rounded_outward(self) -> float:
        """Where it fails in three digits, or more if those add too much; rounded outward."""
        change = self.fails_at - self.given
        end = self.fails_at + OUTWARD_SHARE * change
        outward = math.ceil if change > 0 else math.floor
        magnitude = math.floor(math.log10(abs(end))) if end else 0
        found = end
        for digits in range(3, 7):
            decimals = digits - 1 - magnitude
            found = round(outward(end * 10.0**decimals) / 10.0**decimals, decimals)
            if abs(found - self.fails_at) <= MAX_ROUNDING_SHARE * abs(change):
                break
        return found


@dataclass(frozen=True, kw_only=True)
class DecidingInputs:
    """The check that is nearest to its maximum, and the given numbers that it rests on most."""

    check: Check
    inputs: tuple[DecidingInput, ...]


def deciding_inputs(
    responses: Sequence[LineResponse], checks: Sequence[Check]
) -> DecidingInputs | None:
    """Return the given numbers by which the check nearest to its maximum fails first.

    Each number is changed by `RELATIVE_STEP` alone; those by whose change, taken as linear, the
    worst state's value reaches its maximum first are changed so far, and by secants on. Criteria
    on rubber are left out: they would take seconds. Where no number decides the nearest quantity,
    the next is tried.

    Returns
    -------
    DecidingInputs or None
        None if a check fails, if no number within `MAX_RELATIVE_CHANGE` decides, or if the
        application is not as it was read.
    """
    if any(c.grade == "fail" for c in checks):
        return None
    nearest: dict[str, Check] = {}
    for check in sorted(filter(_has_maximum, checks), key=_margin_to_maximum):
        nearest.setdefault(check.quantity, check)
    for check in list(nearest.values())[:MAX_TRIED_QUANTITIES]:
        response = next((r for r in responses if r.line.name == check.line), None)
        if response is None or response.layout.points.ndim > 3:
            return None
        try:
            inputs = _inputs_of(response, check)
        except CardanError:
            return None
        if inputs:
            return DecidingInputs(check=check, inputs=inputs)
    return None


def _inputs_of(response: LineResponse, check: Check) -> tuple[DecidingInput, ...]:
    """Return the given numbers by which a check fails first, one of each list."""
    numbers = _given_numbers(response.application)
    found = _relative_changes(response, numbers, check)
    by_list: dict[str, str] = {}
    for key in sorted(found, key=lambda key: abs(found[key])):
        by_list.setdefault(key.partition("[")[0] if key.endswith("]") else key, key)
    nearest = list(by_list.values())[:MAX_REFINED_CHANGES]
    refined = _refined_changes(response, numbers, check, {key: found[key] for key in nearest})
    return tuple(
        DecidingInput(key=key, given=numbers[key], fails_at=numbers[key] * (1 + needed))
        for key, needed in sorted(refined.items(), key=lambda item: abs(item[1]))
    )[:MAX_DECIDING_INPUTS]


def _margin_to_maximum(c: Check) -> float:
    return float(c.limit.margin(c.value, to="maximum"))


def _has_maximum(c: Check) -> bool:
    quantity = LINE_QUANTITIES.get(c.quantity)
    on_rubber = quantity is None or quantity.depends_on_mounts
    return not on_rubber and c.limit.maximum is not None and bool(np.isfinite(c.value))


def _given_numbers(application: Application) -> dict[str, float]:
    """Return the numbers that the file itself gives by address, without those of catalogues."""
    return {
        key: float(value)
        for key, value in addresses(application).items()
        if isinstance(value, int | float)
        and value
        and ".share_" not in key  # all of a duty make 100
        and not any(rating in key for rating in RATING_KEYS)
        and _is_typed(application, key)
    }


def _is_typed(application: Application, key: str) -> bool:
    """Return whether the file itself gives a number; catalogue values stand where a name does."""
    own, above = (application.source_locations.get(k) for k in (key, key.rpartition(".")[0]))
    return own is not None and (
        above is None or (own.line, own.column) != (above.line, above.column)
    )


def _relative_changes(
    response: LineResponse, numbers: Mapping[str, float], check: Check
) -> dict[str, float]:
    """Return by what share of itself each number makes a check fail, where it is small enough."""
    if not 0 < len(numbers) <= MAX_CHANGED_NUMBERS:
        return {}
    try:
        return _linear_changes(response, numbers, check)
    except CardanError:
        others = {k: v for k, v in numbers.items() if not any(g in k for g in GEOMETRY_KEYS)}
        return _linear_changes(response, others, check) if others else {}


def _linear_changes(
    response: LineResponse, numbers: Mapping[str, float], check: Check
) -> dict[str, float]:
    values = _changed_values(response, numbers, check, dict.fromkeys(numbers, RELATIVE_STEP))
    assert check.limit.maximum is not None
    with np.errstate(divide="ignore", invalid="ignore"):
        slopes = (values - check.value) / RELATIVE_STEP
        needed = np.where(np.isfinite(slopes), (check.limit.maximum - check.value) / slopes, np.nan)
    return {
        key: share
        for key, share in zip(numbers, needed.tolist(), strict=True)
        if abs(share) <= MAX_RELATIVE_CHANGE  # a nan is not
    }


def _refined_changes(
    response: LineResponse,
    numbers: Mapping[str, float],
    check: Check,
    predicted: Mapping[str, float],
) -> dict[str, float]:
    """Return by what share of itself each number makes a check fail, by secants.

    A number is left out where they lead to no end, as where the file refuses it.
    """
    if not predicted:
        return {}
    assert check.limit.maximum is not None
    before, beyond_before = np.zeros(len(predicted)), check.value - check.limit.maximum
    room, at = abs(beyond_before), np.array(list(predicted.values()))
    beyond = np.full(len(predicted), np.nan)
    for _ in range(SECANT_STEPS):
        shares = dict(zip(predicted, at.tolist(), strict=True))
        beyond = _values_where_accepted(response, numbers, check, shares) - check.limit.maximum
        with np.errstate(divide="ignore", invalid="ignore"):
            step = beyond * (at - before) / (beyond - beyond_before)
        before, beyond_before = at, beyond
        at = at - np.where(np.abs(beyond) <= CONVERGED_SHARE * room, 0.0, step)
    ends = np.where(np.abs(beyond) <= MAX_RESIDUAL_SHARE * room, at, np.nan)
    return {
        key: share
        for key, share in zip(predicted, ends.tolist(), strict=True)
        if abs(share) <= MAX_RELATIVE_CHANGE  # a nan is not
    }


def _values_where_accepted(
    response: LineResponse, numbers: Mapping[str, float], check: Check, shares: Mapping[str, float]
) -> FloatArray:
    """Return the worst values with numbers changed one at a time; nan where a file refuses one."""
    usable = {key: share for key, share in shares.items() if np.isfinite(share)}
    found = dict.fromkeys(shares, np.nan)
    try:
        if usable:
            values = _changed_values(response, numbers, check, usable)
            found |= dict(zip(usable, values.tolist(), strict=True))
    except CardanError:
        for key, share in usable.items():
            with suppress(CardanError):
                found[key] = float(_changed_values(response, numbers, check, {key: share})[0])
    return np.array(list(found.values()))


def _changed_values(
    response: LineResponse, numbers: Mapping[str, float], check: Check, shares: Mapping[str, float]
) -> FloatArray:
    """Return the worst value with each number changed alone by a share of itself, (count,)."""
    columns = 1 + np.diag(list(shares.values()))
    changes = {key: numbers[key] * column for key, column in zip(shares, columns, strict=True)}
    varied = change(response.application, changes, warn=False)
    installed = next(i for i in varied.lines if i.line.name == check.line)
    with without_compiled_loops():
        demand = line_state_demand(resolve_line_references(varied, installed))
        return _worst_values(response, compute_line_response(varied, demand), check, len(shares))


def _worst_values(
    response: LineResponse, varied: LineResponse, check: Check, count: int
) -> FloatArray:
    """Return the worst value of all states that a check's limit and part have, (count,)."""
    quantities = frozenset({check.quantity})
    before, after = (evaluate_limits(r, quantities=quantities) for r in (response, varied))
    sign = 1 if check.limit.sense == "<=" else -1
    worst = np.full(count, -np.inf)
    for old, new in zip(before, after, strict=True):
        if old.limit == check.limit and check.part in old.parts:
            shape = (count, new.values.shape[-2], len(new.parts))
            part = sign * np.broadcast_to(new.values, shape)[..., new.parts.index(check.part)]
            worst = np.maximum(worst, np.where(np.isnan(part), -np.inf, part).max(axis=-1))
    return sign * worst

"""Relations of an application's own limits to those of the profiles that come with the package."""

from collections.abc import Iterable, Iterator
from functools import cache
from math import nan
from typing import NamedTuple

from cardan.application.limit_profiles import (
    INLINE_LIMITS_NAME,
    OVERRIDDEN_PROFILE_SUFFIX,
    load_profile,
    profile_names,
)
from cardan.application.quantity_lookup import declared_quantity
from cardan.application.relation_context import (
    ComparedValue,
    ComparedValues,
    RelationContext,
    ratio,
)
from cardan.core.units import deg
from cardan.core.verdict import Limit, LimitSense
from cardan.model.application import Application

BOUND_TOLERANCE = 1e-9
"""Relative difference by which bounds of two files count as equal."""


class LimitBound(NamedTuple):
    """One number of a limit: its key in a file, its value in SI, and on which side it is safe."""

    key: str
    value: float
    sense: LimitSense


def compare_looser_limits(of: RelationContext) -> ComparedValues:
    """1 for each bound of a file's own limits that no shipped profile has as loose, else 0."""
    for at, limit in _own_limits(of.application):
        for bound in _bounds(limit):
            if (loosest := _loosest_bound(limit, bound, _shipped_profiles())) is None:
                continue
            looser = _is_looser(bound, loosest)
            keys = f"{at}.{bound.key}", f"{at}.{bound.key.partition('[')[0]}", at
            detail = _compared_text(limit, bound, loosest)
            yield ComparedValue(keys, float(looser), detail=detail)


def compare_limits_over_profile(of: RelationContext) -> ComparedValues:
    """How much looser each own bound is than that of the profile of its vehicle, as a factor.

    That is the profile it changes, else the one of the vehicle's class. nan where
    `compare_looser_limits` names it, and where the profile has no bound, or 0.
    """
    name = of.application.profile.removesuffix(OVERRIDDEN_PROFILE_SUFFIX)
    against: tuple[str, ...] = ()
    if name not in profile_names():
        name, against = (of.vehicle_class or "").replace(" ", "-"), (of.heaviest_address,)
    if name not in profile_names():
        return
    profile = load_profile(name)[1]
    for at, limit in _own_limits(of.application):
        for bound in _bounds(limit):
            usual = _loosest_bound(limit, bound, (profile,))
            loosest = _loosest_bound(limit, bound, _shipped_profiles())
            if bound.key not in ("normal", "maximum") or not usual or loosest is None:
                continue
            factor = ratio(*((bound.value, usual) if bound.sense == "<=" else (usual, bound.value)))
            keys = f"{at}.{bound.key}", at
            detail = f"{_compared_text(limit, bound, usual)}, {name}"
            value = nan if _is_looser(bound, loosest) else factor
            yield ComparedValue(keys, value, against, detail)


def compare_limits_without_maximum(of: RelationContext) -> ComparedValues:
    """1 for each quantity that never fails by a file's own limits, and by shipped ones does."""
    own: dict[tuple[str, LimitSense], list[tuple[str, Limit]]] = {}
    for at, limit in _own_limits(of.application):
        own.setdefault((limit.quantity, limit.sense), []).append((at, limit))
    for (quantity, sense), rows in own.items():
        if all(limit.maximum is None for _, limit in rows) and not all(r.band for _, r in rows):
            shipped = [
                [one.maximum for one in limits if (one.quantity, one.sense) == (quantity, sense)]
                for limits in _shipped_profiles()
            ]
            held = [some for some in shipped if some]
            lost = bool(held) and all(any(m is not None for m in some) for some in held)
            yield ComparedValue((rows[0][0],), float(lost), detail=quantity)


def compare_unused_inputs(of: RelationContext) -> ComparedValues:
    """How many inputs a file gives for which the profile that it names has no limit."""
    application = of.application
    if application.profile.partition(",")[0] not in profile_names():
        return
    inputs = {
        "duty (joint_life)": bool(application.duty or application.duty_cycle),
        "obstacles (clearance)": bool(application.obstacles),
    }
    limited = {limit.quantity for limit in application.limits}
    unused = [
        name
        for name, given in inputs.items()
        if given and name.partition("(")[2].rstrip(")") not in limited
    ]
    against = tuple(name.partition(" ")[0] for name in unused)
    yield ComparedValue(("limits",), float(len(unused)), against, ", ".join(unused))


def _own_limits(application: Application) -> Iterator[tuple[str, Limit]]:
    """Yield the limits that no shipped profile states as they are, each with its address."""
    name, limits = application.profile, application.limits
    if name in profile_names() and limits == load_profile(name)[1]:
        return
    if name == INLINE_LIMITS_NAME:
        yield from ((f"limits[{k}]", limit) for k, limit in enumerate(limits, 1))
    elif name.endswith(OVERRIDDEN_PROFILE_SUFFIX):
        at = "limits.overrides[{}]".format
        count = next(k for k in range(len(limits) + 1) if at(k + 1) not in
                     application.source_locations)  # fmt: skip
        yield from ((at(k), limit) for k, limit in enumerate(limits[len(limits) - count :], 1))
    else:
        yield from (("limits", limit) for limit in limits)


def _bounds(limit: Limit) -> Iterator[LimitBound]:
    """Yield the numbers of a limit; a band is looser the narrower it is."""
    for key, value in (("maximum", limit.maximum), ("normal", limit.normal)):
        if value is not None:
            yield LimitBound(key, value, limit.sense)
    if limit.band is not None:
        yield LimitBound("band[1]", limit.band[0], "<=")
        yield LimitBound("band[2]", limit.band[1], ">=")
    if limit.above_angle is not None:
        yield LimitBound("above_angle", limit.above_angle, "<=")


def _is_looser(bound: LimitBound, other: float) -> bool:
    """Whether a bound lets pass what another does not."""
    slack = bound.value - other if bound.sense == "<=" else other - bound.value
    return slack > BOUND_TOLERANCE * max(abs(other), abs(bound.value))


def _loosest_bound(
    limit: Limit, bound: LimitBound, profiles: Iterable[tuple[Limit, ...]]
) -> float | None:
    """Return the loosest of a bound in some profiles; None where none states it.

    Profiles that have no `normal` of a quantity have it pass up to its maximum.
    """
    alike = [
        one
        for limits in profiles
        for one in limits
        if (one.quantity, one.sense) == (limit.quantity, limit.sense)
    ]
    found = [b.value for one in alike for b in _bounds(one) if b.key == bound.key]
    if bound.key == "normal" and not found:
        found = [one.maximum for one in alike if one.maximum is not None]
    if bound.key == "above_angle":
        found += [0.0 for one in alike if one.above_angle is None]
    worst = max if bound.sense == "<=" else min
    return worst(found, default=None)


def _compared_text(limit: Limit, bound: LimitBound, loosest: float) -> str:
    """Return a bound against the loosest shipped one, in the unit of its quantity: 1.2 > 0.75."""
    quantity = declared_quantity(limit.quantity)
    angle = bound.key == "above_angle"
    scale, unit = (deg, "°") if angle else (quantity.si_factor, quantity.unit_symbol)
    sign = ">" if bound.sense == "<=" else "<"
    text = f"{bound.value / scale:.4g} {sign} {loosest / scale:.4g} {unit}".rstrip()
    return f"{limit.quantity}, {text}"


@cache
def _shipped_profiles() -> tuple[tuple[Limit, ...], ...]:
    """Return the limits of each shipped profile."""
    return tuple(load_profile(name)[1] for name in profile_names())

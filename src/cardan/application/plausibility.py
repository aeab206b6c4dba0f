"""Contradictions between values of an application: warnings, evaluated from a table of relations.

A measure by itself has its usual range in `cardan.schema.fields`; here it is compared with others,
of the file and of catalogues. Each relation is a row of `PLAUSIBILITY_RULES`.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import islice
from math import inf

import numpy as np

from cardan.application.limit_profiles import load_profile
from cardan.application.plausibility_rules import PLAUSIBILITY_RULES
from cardan.application.relation_context import ComparedValue, PlausibilityRule, RelationContext
from cardan.application.source_location import locate_yaml_address
from cardan.core.arrays import ArrayLike
from cardan.core.errors import FileIssue, SourceLocation
from cardan.model.application import Application
from cardan.schema.node_reader import MAX_ISSUES

__all__ = [
    "PLAUSIBILITY_RULES",
    "PlausibilityRule",
    "plausibility_warnings",
    "with_limit_profile",
]

MAX_SHOWN_NUMBERS = 12
"""Numbers of a list that a warning prints: a curve of more is named, not printed."""


def plausibility_warnings(
    application: Application, numbers: Mapping[str, ArrayLike] | None = None
) -> tuple[FileIssue, ...]:
    """Return a warning for each value that contradicts others, at its own key.

    Parameters
    ----------
    application
        With single numbers, not arrays of variants.
    numbers
        Numbers of its file by address, in the file's units: warnings print them.
    """
    of = RelationContext(application=application)
    with np.errstate(all="ignore"):
        found = (w for rule in PLAUSIBILITY_RULES for w in _rule_warnings(rule, of, numbers or {}))
        return tuple(islice(dict.fromkeys(found), MAX_ISSUES))  # one joint may stand for all


def with_limit_profile(application: Application, limits: str) -> Application:
    """Return an application under the limits of a profile, shipped or a file, in place of its own.

    Its values are compared anew: what looks wrong of those limits carries their name.

    Raises
    ------
    InvalidFileError
        If there is no such profile, or with everything wrong in its file.
    """
    name, found = load_profile(limits)
    changed = replace(application, profile=name, limits=found)
    written = application.written
    numbers = {**written.numbers, **written.fixed_numbers} if written else {}
    alone = tuple(w for w in application.warnings if not w.relation)
    odd = {w.key for w in alone}
    others = (
        replace(w, key=limits, value="", line=0, column=0)
        if w.key.partition(".")[0] == "limits"
        else w
        for w in plausibility_warnings(changed, numbers)
        if w.key not in odd
    )
    every = sorted(dict.fromkeys((*alone, *others)), key=lambda w: (w.line, w.column))
    return replace(changed, warnings=tuple(every))


def _rule_warnings(
    rule: PlausibilityRule, of: RelationContext, numbers: Mapping[str, ArrayLike]
) -> Iterator[FileIssue]:
    low, high = rule.range_for(of)
    for compared in rule.values(of):
        if not (compared.value < low or compared.value > high):  # a nan is not known
            continue
        range_ = f"{low:.4g} to {high:.4g}" if high < inf else f"{low:.4g} or more"
        number = f"{compared.value:.3g}{rule.unit}"
        found = locate_yaml_address(of.application, *compared.addresses)
        key = found.key if found else compared.addresses[0]
        value = _numbers_text(key, numbers)
        names = tuple(address.rpartition(".")[2] for address in compared.addresses[:-1])
        if compared.default and not key.rpartition(".")[2].startswith(names):
            key, value = f"{key}.{names[0]}", f"nothing, {compared.default} is taken"
        yield FileIssue(
            message=rule.message.format(detail=compared.detail)
            or f"{rule.description} is {number}, where {range_} is usual",
            value=value,
            hint=rule.hint,
            key=key,
            line=found.line if found else 0,
            column=found.column if found else 0,
            relation=rule.name,
            source=rule.source,
            against=tuple(_places_of_others(of, compared, key, numbers)),
        )


def _places_of_others(
    of: RelationContext, compared: ComparedValue, key: str, numbers: Mapping[str, ArrayLike]
) -> Iterator[tuple[SourceLocation, str]]:
    """Yield where each value stands that one was compared with, and its numbers."""
    for address in compared.against:
        found = locate_yaml_address(of.application, address)
        name = address.rpartition(".")[2]
        if found and found.key != key and name.split("[")[0] in found.key:
            yield found, _numbers_text(found.key, numbers)


def _numbers_text(key: str, numbers: Mapping[str, ArrayLike]) -> str:
    """Return the numbers of a file at a key or in the list there; empty for a table."""
    if key in numbers:
        return f"{numbers[key]:g}"
    listed = [v for k, v in numbers.items() if k.startswith(f"{key}[") and k.endswith("]")]
    flat = listed if 0 < len(listed) <= MAX_SHOWN_NUMBERS else []
    return f"[{', '.join(f'{v:g}' for v in flat)}]" if flat else ""

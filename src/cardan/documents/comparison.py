"""Variants side by side: what differs in the input, and what it does to each limit."""

from collections.abc import Sequence
from dataclasses import dataclass

from cardan.approval.approval import Approval
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.verdict import Check, CheckGrade, worst_first_key
from cardan.documents.inputs_table import input_rows
from cardan.render.check_texts import lower_bound_mark
from cardan.render.i18n import Translator


@dataclass(frozen=True, kw_only=True)
class Variant:
    """One application among several, and its name among the others."""

    name: str
    approval: Approval


@dataclass(frozen=True, kw_only=True)
class ComparisonRow:
    """One row: a value for each variant, "-" where it has none, with its grade if it has one."""

    name: str
    values: tuple[str, ...]
    grades: tuple[CheckGrade | None, ...]

    @property
    def grades_differ(self) -> bool:
        """Whether the variants' grades differ."""
        return len(set(self.grades)) > 1


def input_differences(of: Sequence[Variant], say: Translator) -> tuple[ComparisonRow, ...]:
    """Return what variants say differently, in the order they first say it."""
    said = [_input_values(v, say) for v in of]
    keys = dict.fromkeys(key for one in said for key in one)
    rows = (
        ComparisonRow(
            name=f"{group}: {name}",
            values=tuple(one.get((group, name), "-") for one in said),
            grades=(None,) * len(of),
        )
        for group, name in keys
    )
    return tuple(r for r in rows if len(set(r.values)) > 1)


def _input_values(of: Variant, say: Translator) -> dict[tuple[str, str], str]:
    """Return what a variant says by group and name; what it says twice as one value."""
    found: dict[tuple[str, str], str] = {}
    for i in input_rows(of.approval.application, say):
        key = (i.group, i.name)
        found[key] = f"{found[key]}; {i.value}" if key in found else i.value
    return found


def limit_differences(of: Sequence[Variant], say: Translator) -> tuple[ComparisonRow, ...]:
    """Return the worst check of each quantity for each variant, the worst rows first."""
    worst: list[dict[tuple[str, str, str], Check]] = []
    for v in of:
        mine: dict[tuple[str, str, str], Check] = {}
        for c in sorted(v.approval.checks, key=worst_first_key):
            mine.setdefault((c.quantity, c.line, c.limit.sense), c)
        worst.append(mine)
    keys = dict.fromkeys(key for mine in worst for key in mine)
    several = any(len(v.approval.line_responses) > 1 for v in of)
    ranked = sorted(keys, key=lambda k: min(worst_first_key(m[k]) for m in worst if k in m))
    return tuple(
        _comparison_row(key, [m.get(key) for m in worst], say, several=several) for key in ranked
    )


def _comparison_row(
    key: tuple[str, str, str], checks: list[Check | None], say: Translator, *, several: bool
) -> ComparisonRow:
    """Return the row of one quantity."""
    quantity, line, _ = key
    q = QUANTITIES[quantity]
    unit = f" [{q.unit_symbol}]" if q.unit_symbol else ""
    name = f"{line}: {say.name(quantity)}" if several else say.name(quantity)
    return ComparisonRow(
        name=name + unit,
        values=tuple(_value_with_margin(c, say) if c else "-" for c in checks),
        grades=tuple(c.grade if c else None for c in checks),
    )


def _value_with_margin(c: Check, say: Translator) -> str:
    """Return a check's value in its declared unit with its margin; ≥ before a lower bound."""
    value = say.number(c.value / QUANTITIES[c.quantity].si_factor)
    return f"{lower_bound_mark(c)}{value} ({say.margin_percent(c.margin)})"

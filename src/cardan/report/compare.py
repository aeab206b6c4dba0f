"""Variants side by side: what differs in the input, and what it does to each limit."""

from collections.abc import Sequence
from dataclasses import dataclass

from cardan.base.verdict import Check, Grade, badness
from cardan.quantity.quantities import QUANTITIES
from cardan.report.inputs import inputs
from cardan.report.language import Language
from cardan.study.approval import Approval


@dataclass(frozen=True, kw_only=True)
class Variant:
    """One application among several, and how it is called beside the others."""

    name: str
    approval: Approval


@dataclass(frozen=True, kw_only=True)
class Compared:
    """One row: a value for each variant, "-" where it has none, with its grade if it has one."""

    name: str
    values: tuple[str, ...]
    grades: tuple[Grade | None, ...]

    @property
    def changed(self) -> bool:
        """Whether the variants' grades differ."""
        return len(set(self.grades)) > 1


def differences(of: Sequence[Variant], say: Language) -> tuple[Compared, ...]:
    """Return what variants say differently, in the order they first say it."""
    said = [_said(v, say) for v in of]
    keys = dict.fromkeys(key for one in said for key in one)
    rows = (
        Compared(
            name=f"{group}: {name}",
            values=tuple(one.get((group, name), "-") for one in said),
            grades=(None,) * len(of),
        )
        for group, name in keys
    )
    return tuple(r for r in rows if len(set(r.values)) > 1)


def _said(of: Variant, say: Language) -> dict[tuple[str, str], str]:
    """Return what a variant says by group and name; what it says twice as one value."""
    found: dict[tuple[str, str], str] = {}
    for i in inputs(of.approval.application, say):
        key = (i.group, i.name)
        found[key] = f"{found[key]}; {i.value}" if key in found else i.value
    return found


def effects(of: Sequence[Variant], say: Language) -> tuple[Compared, ...]:
    """Return the worst check of each quantity for each variant, the worst rows first."""
    worst: list[dict[tuple[str, str, str], Check]] = []
    for v in of:
        mine: dict[tuple[str, str, str], Check] = {}
        for c in sorted(v.approval.checks, key=badness):
            mine.setdefault((c.quantity, c.line, c.limit.sense), c)
        worst.append(mine)
    keys = dict.fromkeys(key for mine in worst for key in mine)
    several = any(len(v.approval.responses) > 1 for v in of)
    ranked = sorted(keys, key=lambda k: min(badness(m[k]) for m in worst if k in m))
    return tuple(
        _compared(key, [m.get(key) for m in worst], say, several=several) for key in ranked
    )


def _compared(
    key: tuple[str, str, str], checks: list[Check | None], say: Language, *, several: bool
) -> Compared:
    """Return the row of one quantity."""
    quantity, line, _ = key
    q = QUANTITIES[quantity]
    unit = f" [{q.unit_name}]" if q.unit_name else ""
    name = f"{line}: {say.name(quantity)}" if several else say.name(quantity)
    return Compared(
        name=name + unit,
        values=tuple(
            f"{say.number(c.value / q.factor)} ({say.percent(c.margin)})" if c else "-"
            for c in checks
        ),
        grades=tuple(c.grade if c else None for c in checks),
    )

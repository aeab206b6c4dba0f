"""What a study of variants came to, in words: how many pass, and which limits they fail."""

from collections.abc import Iterator

import numpy as np

from cardan.base.verdict import GRADES, Grade
from cardan.quantity.quantities import QUANTITIES
from cardan.report.blocks import Table
from cardan.report.language import EN, Language
from cardan.study.sweep import Held, Sweep


def summary(of: Sweep, say: Language = EN) -> str:
    """Return what the variants came to in a line."""
    said = [f"{_share(share, say)} {say(verdict)}" for verdict, share in of.shares.items() if share]
    return say(
        "{title}: {count} variants, {verdicts}",
        title=of.installed.application.title,
        count=of.count,
        verdicts=", ".join(said),
    )


def tables(of: Sweep, say: Language = EN) -> Iterator[Table]:
    """Yield what varies, and what each limit came to, the worst first."""
    yield Table(
        caption=say("What varies"),
        head=(say("input"), say("lowest"), say("median"), say("highest")),
        rows=tuple(
            (v.name, *(say.short(float(q(v.values)), 4) for q in (np.min, np.median, np.max)))
            for v in of.varied
        ),
    )
    several = len(of.installed.application.lines) > 1
    held = [h for h in of.held if np.isfinite(h.margins).any()]
    held.sort(key=lambda h: (-_part(h, "fail"), -_part(h, "warn"), np.nanmin(h.margins)))
    yield Table(
        caption=say("Every limit over all variants"),
        head=(
            say("limit"), *(say(g) for g in GRADES), say("smallest margin"), say("median margin"),
        ),
        rows=tuple(
            (
                say.list(h.line if several else "", _limit(h, say)),
                *(_share(_part(h, g), say) for g in GRADES),
                say.percent(float(np.nanmin(h.margins))),
                say.percent(float(np.nanmedian(h.margins))),
            )
            for h in held
        ),
    )  # fmt: skip


def _limit(of: Held, say: Language) -> str:
    """Return which limit it is, with its bound: a quantity may have several."""
    limit, q = of.limit, QUANTITIES[of.limit.quantity]
    bounds = limit.band or tuple(b for b in (limit.normal, limit.maximum) if b is not None)
    shown = " … ".join(say.number(b / q.factor) for b in bounds)
    sense = say("outside") if limit.band else limit.sense
    return f"{say.name(q.key)} {sense} {shown} {q.unit_name}".rstrip()


def _part(of: Held, grade: Grade) -> float:
    """Return the share of variants in which a limit has a grade."""
    return float(np.mean(of.grades == GRADES.index(grade)))


def _share(share: float, say: Language) -> str:
    return say.pointed(f"{100 * share:.1f} %")

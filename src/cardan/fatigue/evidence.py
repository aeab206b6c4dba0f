"""What the joints are answerable for at a gauge: a share of its damage, with its doubt."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cardan.base.said import Said, said

GUILTY, INNOCENT, CANNOT_TELL = "guilty", "innocent", "cannot tell"

ACQUITTED = 0.25
"""Share of the damage up to which they are innocent, at most."""
CONVICTED = 0.35
"""From which they are guilty, at least, if half of it is theirs most likely."""
UNHEARD_OF = 0.05
"""Share of the damage, done at a speed that nobody knows, from which that is said."""

UNTRUSTED = said("the speed gives no angle to trust: all that is near order 2 may be theirs")
UNLOADED = said("no torque tells when the joints pull: all that is near order 2 may be theirs")
FAINT = said("little is locked to the shaft: the interval is wider by a tenth")
SLIPPING = said("what is locked does not explain the large cycles: the angle may slip")
RATTLING = said("order 6 is locked too, as of rattling contact: they may have done more")
ALIKE = said("an engine order runs with order 2: phase and torque are the same, either did it")
UNHEARD = said(
    "no engine speed and no engine orders are given: an engine of four cylinders in direct gear "
    "does the same as the joints"
)

STEADY = said(
    "order 2 is the same whatever the torque, and what joints do goes with it: a wheel's, a bent "
    "flange's, or is the torque another's?"
)
TONE = said(
    "neither speed nor torque changes: a tone of its own, of a pump or a fan, would do the same as "
    "the joints"
)
DOUBLED = said("what goes with the torque turns at twice the speed given: is it the shaft's own?")
HALVED = said("what goes with the torque turns at half the speed given: is it the shaft's own?")
SCALED = said(
    "more is locked beside the orders of the speed given: is its scale wrong, as by a number of "
    "teeth, or does something else turn there?"
)
BORROWED = said(
    "what is locked goes with another scale of the speed, and at that one an order of the wheels "
    "lies, or the engine in direct gear says that the speed is right: it may be another's"
)
BESIDE = said("more stands close beside order 2 than farther off: angles that ride may hide them")
PASSING = said(
    "what stands about order 2 comes and goes with it, though nothing is locked: angles that ride "
    "may hide them"
)

BRIEF = said(
    "what does the damage comes with a torque of a few seconds: too short to tell whose it is"
)

KNOCKING = said(
    "blows come where order 2 is loud, as of a stop that it reaches: they may be theirs"
)

PULLING = said(
    "crests rise and fall with the torque, as of a stop that the line stands on: no road does that"
)

STANDING = said(
    "by its speed the shaft hardly turned: what does the damage is locked to nothing that is known"
)
NEGATIVE = said(
    "for a third of the time under way and more the shaft's speed is below nought: reverse, or it "
    "is not what it is taken for"
)
UNSEEN = said(
    "for a third of the time under way and more nothing says how fast the shaft turned: its speed "
    "is missing, or stands still while the engine's changes"
)
SWAPPED = said(
    "the engine turns at less than six tenths of the shaft's speed, as in no gear: are the two "
    "swapped, or is one wrong?"
)
MEANWHILE = said(
    "damage was done while nothing said how fast the shaft turned: all of that may be theirs"
)
SPOILT = said("the gauge is vetoed: whose the damage is hangs on what spoiled the recording")

DOUBTS = (
    STANDING,
    NEGATIVE,
    UNSEEN,
    SWAPPED,
    MEANWHILE,
    SPOILT,
    UNTRUSTED,
    UNLOADED,
    FAINT,
    SLIPPING,
    RATTLING,
    ALIKE,
    UNHEARD,
    STEADY,
    TONE,
    DOUBLED,
    HALVED,
    SCALED,
    BORROWED,
    BESIDE,
    PASSING,
    BRIEF,
    KNOCKING,
    PULLING,
)
"""What may widen an interval."""


@dataclass(frozen=True)
class Tried:
    """How often a finding was wrong, of gauges whose truth is known (docs/verification.md)."""

    wrong: int
    cases: int

    @property
    def at_most(self) -> float:
        """Share of wrong ones that is exceeded with odds of 1 in 40 (Clopper & Pearson)."""
        from scipy.stats import beta

        return float(beta.ppf(0.975, self.wrong + 1, self.cases - self.wrong))


TRIED = {
    GUILTY: (Tried(0, 683), Tried(0, 953)),
    INNOCENT: (Tried(0, 489), Tried(13, 804)),
}
"""Of innocent gauges that were called guilty, and guilty ones that were called innocent: on drives
as they come, and on drives whose line was made to stand on its stop. Seeds 650000, 670000,
710000 and 741000 on; 662000, 672000, 712000, 740000 and 746000 on.
Innocent: a truth below 0.25; guilty: from 0.5. `tests/verify/tried.py` counts them anew."""


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """What the joints are answerable for at one gauge.

    Attributes
    ----------
    removed
        Share of the damage that goes with the joints' stress, 1.
    interval
        Low and high of 90 %.
    strength
        F, energy of the fit over that at phantoms; how surely something is locked.
    modes
        Frequency Hz and damping of the bracket's modes that the joints shake.
    ratio, lag : 1 and s
        What the stress says of the speed's scale, and how late it comes.
    lags : s
        Low and high of 90 % of that lag; a phase tilts by 360 degrees times it for each hertz.
    doubts
        What widened the interval, a sentence each.
    """

    removed: float
    interval: tuple[float, float]
    strength: float
    modes: tuple[tuple[float, float], ...] = ()
    ratio: float = 1.0
    lag: float = 0.0
    lags: tuple[float, float] = (-np.inf, np.inf)
    doubts: tuple[Said, ...] = ()

    def unknown(self, doubt: Said) -> "Evidence":
        """Return evidence that tells nothing, for a doubt."""
        low = min(self.interval[0], 0.0)
        return replace(self, interval=(low, 1.0), doubts=(doubt, *self.doubts))

    def with_unheard(self, share: float) -> "Evidence":
        """Return it where a share of the damage was done at a speed that nobody knows."""
        if not share > 0:
            return self
        low, high = self.interval
        doubts = (*self.doubts, MEANWHILE) if share > UNHEARD_OF else self.doubts
        return replace(self, interval=(low, min(high + share, 1.0)), doubts=doubts)

    @property
    def finding(self) -> str:
        """Return "guilty", "innocent" or "cannot tell"."""
        low, high = self.interval
        if low >= CONVICTED and self.removed >= 0.5:
            return GUILTY
        return INNOCENT if high <= ACQUITTED else CANNOT_TELL


def together(parts: Sequence[Evidence], weights: Sequence[float]) -> Evidence:
    """Return the evidence of stretches as one, each by its share of the damage.

    Ends of intervals are added as they are: what one stretch does not know, the next may not
    either.
    """
    w = np.asarray(weights, float)
    w = w / w.sum() if w.sum() > 0 else np.full(w.size, 1 / max(w.size, 1))
    if len(parts) == 1:
        return parts[0]
    chief = parts[int(np.argmax(w))]
    low, high = (float(w @ [p.interval[k] for p in parts]) for k in (0, 1))
    return replace(
        chief, removed=float(w @ [p.removed for p in parts]), interval=(low, high),
        strength=max(p.strength for p in parts),
        doubts=tuple(dict.fromkeys(d for p in parts for d in p.doubts)),
    )  # fmt: skip

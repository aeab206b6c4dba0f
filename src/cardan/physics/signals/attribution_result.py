"""What the joints are answerable for at a gauge: a share of its damage, with its doubt."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cardan.core.finding import Finding

JOINTS_DOMINANT, JOINTS_NOT_DOMINANT, UNDETERMINED = (
    "joints dominate",
    "joints do not dominate",
    "undetermined",
)

NOT_DOMINANT_MAX_SHARE = 0.25
"""Largest share of the damage at which joints do not dominate."""
DOMINANT_MIN_SHARE = 0.35
"""Least share from which joints dominate, if their most likely share is half or more."""
MIN_NOTED_UNKNOWN_SPEED_DAMAGE_SHARE = 0.05
"""Share of the damage, done at unknown speed, from which a doubt is reported."""

DOUBT_NO_RELIABLE_SHAFT_ANGLE = Finding("no-reliable-angle")
DOUBT_NO_TORQUE = Finding("no-torque")
DOUBT_WEAK_SYNCHRONOUS_PART = Finding("weak-synchronous-part")
DOUBT_SHAFT_ANGLE_MAY_SLIP = Finding("angle-slip")
DOUBT_ORDER_6_SUGGESTS_RATTLE = Finding("order-6")
DOUBT_ENGINE_ORDER_OVERLAP = Finding("engine-order-overlap")
DOUBT_NO_ENGINE_SPEED = Finding("no-engine-speed")
DOUBT_TORQUE_INDEPENDENT = Finding("torque-independent")
DOUBT_CONSTANT_FREQUENCY = Finding("constant-frequency")
DOUBT_RESPONSE_STEP = Finding("response-step")
DOUBT_DOUBLE_SPEED = Finding("double-speed")
DOUBT_HALF_SPEED = Finding("half-speed")
DOUBT_SPEED_SCALE = Finding("speed-scale")
DOUBT_SPEED_OF_OTHER_SHAFT = Finding("foreign-speed")
DOUBT_SIDEBANDS = Finding("sidebands")
DOUBT_INTERMITTENT_SIDEBANDS = Finding("intermittent-sidebands")
DOUBT_SHORT_TORQUE_PULSE = Finding("short-torque-pulse")
DOUBT_BUMP_STOP_IMPACTS = Finding("bump-stop-impacts")
DOUBT_LINE_RESTS_ON_BUMP_STOP = Finding("bump-stop-preload")
DOUBT_SHAFT_STOPPED = Finding("shaft-stopped")
DOUBT_NEGATIVE_SPEED = Finding("negative-speed")
DOUBT_SPEED_MISSING = Finding("speed-missing")
DOUBT_SPEEDS_SWAPPED = Finding("speeds-swapped")
DOUBT_DAMAGE_WITHOUT_SPEED = Finding("damage-without-speed")
DOUBT_DATA_REJECTED = Finding("data-rejected")


@dataclass(frozen=True)
class ErrorRate:
    """How often a finding was wrong, of gauges whose truth is known (docs/verification.md)."""

    wrong: int
    cases: int

    @property
    def upper_bound(self) -> float:
        """Share of wrong ones that is exceeded with odds of 1 in 40 (Clopper & Pearson)."""
        from scipy.stats import beta

        return float(beta.ppf(0.975, self.wrong + 1, self.cases - self.wrong))


VALIDATED_ERROR_RATES = {
    JOINTS_DOMINANT: (ErrorRate(0, 683), ErrorRate(0, 953)),
    JOINTS_NOT_DOMINANT: (ErrorRate(0, 489), ErrorRate(13, 804)),
}
"""Rate of gauges without joint damage called joint-dominated, and the reverse: on drives
as they come, and on drives whose line was made to stand on its stop. Seeds 650000, 670000,
710000 and 741000 on; 662000, 672000, 712000, 740000 and 746000 on.
Not dominated: a true share below 0.25; dominated: from 0.5. `tests/verify/tried.py` counts them
anew."""


@dataclass(frozen=True, kw_only=True)
class JointAttribution:
    """What the joints are answerable for at one gauge.

    Attributes
    ----------
    damage_share
        Share of the damage that goes with the joints' stress, 1.
    interval
        Low and high of 90 %.
    f_statistic
        F, energy of the fit over that at phantoms; how surely something is locked.
    modes
        Frequency Hz and damping of the bracket's modes that the joints shake.
    ratio, lag : 1 and s
        What the stress says of the speed's scale, and how late it comes.
    lag_interval : s
        Low and high of 90 % of that lag; a phase tilts by 360 degrees times it for each hertz.
    doubts
        What widened the interval.
    """

    damage_share: float
    interval: tuple[float, float]
    f_statistic: float
    modes: tuple[tuple[float, float], ...] = ()
    ratio: float = 1.0
    lag: float = 0.0
    lag_interval: tuple[float, float] = (-np.inf, np.inf)
    doubts: tuple[Finding, ...] = ()

    def undetermined(self, doubt: Finding) -> "JointAttribution":
        """Return evidence that determines nothing, with a doubt."""
        low = min(self.interval[0], 0.0)
        return replace(self, interval=(low, 1.0), doubts=(doubt, *self.doubts))

    def with_unknown_speed_share(self, share: float) -> "JointAttribution":
        """Return the evidence with a doubt if a share of the damage was done at unknown speed."""
        if not share > 0:
            return self
        low, high = self.interval
        doubts = (
            (*self.doubts, DOUBT_DAMAGE_WITHOUT_SPEED)
            if share > MIN_NOTED_UNKNOWN_SPEED_DAMAGE_SHARE
            else self.doubts
        )
        return replace(self, interval=(low, min(high + share, 1.0)), doubts=doubts)

    @property
    def verdict(self) -> str:
        """Return "joints dominate", "joints do not dominate" or "undetermined"."""
        low, high = self.interval
        if low >= DOMINANT_MIN_SHARE and self.damage_share >= 0.5:
            return JOINTS_DOMINANT
        return JOINTS_NOT_DOMINANT if high <= NOT_DOMINANT_MAX_SHARE else UNDETERMINED


def combine_attributions(
    parts: Sequence[JointAttribution], weights: Sequence[float]
) -> JointAttribution:
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
    # Of one kind with values of their own, the first stretch's.
    doubts: dict[str, Finding] = {}
    for doubt in (d for p in parts for d in p.doubts):
        doubts.setdefault(doubt.code, doubt)
    return replace(
        chief, damage_share=float(w @ [p.damage_share for p in parts]), interval=(low, high),
        f_statistic=max(p.f_statistic for p in parts),
        doubts=tuple(doubts.values()),
    )  # fmt: skip

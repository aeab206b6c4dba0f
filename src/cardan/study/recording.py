"""Ask a recording how long its gauges live, and who did the damage.

The question is asked of a recording and a campaign rather than of an application: where
there is one it only predicts. What is limited are rows of a profile, and a target.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from cardan.base.errors import NotInstalled
from cardan.base.part import Occasion, Part
from cardan.base.units import hour
from cardan.base.verdict import Check, Limit, Unanswered, Verdict
from cardan.fatigue import life as room
from cardan.fatigue.angle import Angle
from cardan.fatigue.cause import separation, suspects
from cardan.fatigue.conditioning import Health
from cardan.fatigue.life import Causes, GaugeLife, Plan
from cardan.fatigue.orders import Rotation
from cardan.fatigue.recording import Recording
from cardan.files.recordings import open_recording
from cardan.study.approval import coverage_of, verdict_of
from cardan.study.campaign import NAME, TURN, Campaign, numbers
from cardan.study.finding import Finding, Tell, silent

NEEDS = "a recording in which all its channels move"
"""What a gauge needs that said nothing: no samples, or one value throughout."""

DECIDE: Mapping[str, str] = {
    "sentinel": "a word on its sentinels, which decide the damage: --mask or --accept sentinel",
    "spike": "a word on its spikes, which decide the damage: --mask or --accept spike",
    "dropout": "a word on its dropouts, which decide the damage: --mask or --accept dropout",
    "clip": "a recording that is not clipped, or --accept clip",
    "drift": "a word on its drift, which decides the damage: --zero drift or --accept drift",
    "hole": "a recording in which it is alive for a quarter of the time",
}
"""What a gauge needs whose answer is vetoed, by the kind of fault that leaves none."""


@dataclass(frozen=True, kw_only=True)
class Heard:
    """The answer: what a recording did to its gauges.

    Attributes
    ----------
    lives
        One a gauge of the plan; nan at those that have no samples.
    causes
        Of the gauges that said something, in their order; None where no speed tells causes
        apart.
    profile
        The limits' name; "" where no profile was asked.
    """

    recording: Recording
    plan: Plan
    lives: tuple[GaugeLife, ...]
    causes: Causes | None
    profile: str


@dataclass(frozen=True)
class RecordingStudy:
    """How long the gauges of a recording live, held against a campaign's limits."""

    campaign: Campaign
    name: str = NAME

    def run(self, recording: Recording, tell: Tell = silent) -> Finding[Heard]:
        """Ask.

        Raises
        ------
        DesignError
            If the recording lacks what the campaign names, or holds nothing at all.
        BadFile
            If the recording or the profile cannot be read as meant.
        """
        campaign = self.campaign
        profile, limits = campaign.asked()
        recording = campaign.scaled(recording)
        predicted, plan = campaign.predictions(), campaign.plan(recording)
        progress = _progress(recording, tell)
        healths = room.look(recording, channels=plan.channels, progress=progress)
        campaign.hold(recording, samples=max(h.samples for h in healths.values()))
        angle = campaign.shaft(recording)
        shaft = None if angle is None else angle.rotation
        lives = room.counted(
            recording, plan=plan, healths=healths, distance=_distance(campaign, shaft),
            progress=progress,
        )  # fmt: skip
        heard = [g for g, one in zip(plan.gauges, lives, strict=True) if one.heard]
        causes = None
        if angle is not None and heard:
            causes = _causes(
                campaign, recording, replace(plan, gauges=tuple(heard)), angle, healths=healths,
                predicted=predicted, progress=progress,
            )  # fmt: skip
        when = Occasion("recording", recording.name)
        return Finding(
            study=NAME,
            answer=Heard(
                recording=recording, plan=plan, lives=tuple(lives), causes=causes, profile=profile
            ),
            checks=tuple(_checks(lives, limits, when=when, line=campaign.line)),
            unanswered=tuple(_unanswered(lives, limits, when=when, line=campaign.line)),
        )


def listen(path: Path, campaign: Campaign, tell: Tell = silent) -> Finding[Heard]:
    """Open a recording and ask it: what a command and the public face call.

    Raises
    ------
    CardanError
        If the recording, the profile or an option of the campaign is not as it should be, or
        an optional library is absent. Whatever else is raised is the program's own fault.
    """
    try:
        recording = open_recording(
            path, rate=campaign.rate, time=campaign.time, group=campaign.group
        )
        return RecordingStudy(campaign).run(recording, tell)
    except ImportError as error:
        msg = f"this needs {error.name}; pip install 'cardan[fatigue,recordings]'"
        raise NotInstalled(msg) from error


def verdict_on(found: Finding[Heard]) -> Verdict | None:
    """Return what the gauges come to; None where nothing was asked of them.

    Where a life is vetoed the recording was asked and has no answer, limit or not.
    """
    coverage = coverage_of(found)
    if not coverage.asked:
        spoiled = found.answer is not None and any(one.vetoed for one in found.answer.lives)
        return "incomplete" if spoiled else None
    return verdict_of(found.checks, missed=bool(coverage.missed))


def _progress(recording: Recording, tell: Tell) -> room.Progress:
    """Return what tells the seconds done, of how many where that is known."""
    total = recording.samples / recording.rate if recording.samples else 0.0

    def told(name: str, seconds: float) -> None:
        if total:
            tell(f"{name} {seconds / total:.0%}", 0, 0)
        else:
            tell(f"{name} {seconds:.0f} s", 0, 0)

    return told


def _distance(campaign: Campaign, shaft: Rotation | None) -> float:
    """Return what was driven in the recording, m; nan where nobody knows."""
    ratio, radius = campaign.axle_ratio, campaign.tyre_radius_m
    if shaft is None or ratio is None or radius is None:
        return math.nan
    return float(shaft.turns[-1] - shaft.turns[0]) / ratio * TURN * radius


def _causes(
    campaign: Campaign, recording: Recording, plan: Plan, angle: Angle, *,
    healths: dict[str, Health], predicted: dict[str, float], progress: room.Progress,
) -> Causes:  # fmt: skip
    """Return who did the damage at a plan's gauges."""
    ratio, shaft = campaign.axle_ratio, angle.rotation
    named = suspects(
        shaft, joint_orders=numbers(campaign.joint_orders), engine=campaign.engine_of(recording),
        engine_orders=numbers(campaign.engine_orders),
        wheel=None if ratio is None else shaft.geared(1 / ratio),
    )  # fmt: skip
    return room.causes(
        recording, plan=plan, healths=healths, how=separation(named, rate=recording.rate),
        angle=angle, torque=campaign.torque_of(recording), predicted=predicted, progress=progress,
    )  # fmt: skip


_VALUES: dict[str, Callable[[GaugeLife], float]] = {
    "fatigue_life": lambda one: one.life.hours * hour,
    "fatigue_damage": lambda one: one.life.damage,
}
"""What a limit asks about of a gauge, SI."""


def _checks(
    lives: Sequence[GaugeLife], limits: Sequence[Limit], *, when: Occasion, line: str
) -> Iterator[Check]:
    """Yield a check for each limit and gauge that said something."""
    for limit in limits:
        for one in lives:
            if _known(one, limit):
                yield Check(
                    quantity=limit.quantity, line=line, when=when, part=_part(one),
                    value=_VALUES[limit.quantity](one), limit=limit,
                )  # fmt: skip


def _unanswered(
    lives: Sequence[GaugeLife], limits: Sequence[Limit], *, when: Occasion, line: str
) -> Iterator[Unanswered]:
    """Yield each limit and gauge that got no number, or one that cannot be trusted.

    A broken wire lives for ever.
    """
    for limit in limits:
        for one in lives:
            if not _known(one, limit):
                needs = tuple(DECIDE[k] for k in one.quality.vetoes) if one.vetoed else (NEEDS,)
                yield Unanswered(limit=limit, line=line, when=when, part=_part(one), needs=needs)


def _known(one: GaugeLife, limit: Limit) -> bool:
    told = one.heard and not one.vetoed
    return told and not math.isnan(_VALUES[limit.quantity](one))


def _part(one: GaugeLife) -> Part:
    return Part("gauge", 0, one.name)

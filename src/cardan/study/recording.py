"""Ask a recording how long its gauges live, and who did the damage.

The question is asked of a recording and a campaign rather than of an application: where
there is one it only predicts. What is limited are rows of a profile, and a target.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import numpy as np

from cardan.base.arrays import BoolArray, FloatArray
from cardan.base.errors import (
    BadFile,
    CardanError,
    DesignError,
    NotInstalled,
    RefusedInFile,
)
from cardan.base.part import Occasion, Part
from cardan.base.units import hour
from cardan.base.verdict import Check, Limit, Unanswered, Verdict
from cardan.fatigue import life as room
from cardan.fatigue.angle import DARK, Angle
from cardan.fatigue.background import Mode, background, modes
from cardan.fatigue.beside import FOUR_CYLINDERS
from cardan.fatigue.cause import FIRING, separation, suspects
from cardan.fatigue.conditioning import Health, finer, slow_drift
from cardan.fatigue.cuts import Cuts, order_cuts, windows
from cardan.fatigue.damage import InTurn, Life, in_turn, miner
from cardan.fatigue.evidence import GUILTY, INNOCENT, SPOILT, Evidence, together
from cardan.fatigue.fault import DRIFT, ZERO_STEP
from cardan.fatigue.life import Causes, GaugeLife, Plan
from cardan.fatigue.maps import OrderMap, Spectrogram, order_maps, spectrograms
from cardan.fatigue.orders import Rotation
from cardan.fatigue.quality import VETO, decided
from cardan.fatigue.rainflow import Cycles, ResidueRule, discarded, join, repeating
from cardan.fatigue.recording import Recording, alongside, between
from cardan.fatigue.usage import Usage, customer, second_at, seconds_in, usage
from cardan.files.campaign import Campaigned, Drive, Segment
from cardan.files.campaign import read as campaigned
from cardan.files.recordings import open_recording
from cardan.model.application import Application
from cardan.study.approval import coverage_of, verdict_of
from cardan.study.campaign import ASKED, NAME, TURN, Campaign, Misread, keyed, numbers
from cardan.study.finding import Finding, Tell, silent
from cardan.study.identification import (
    COUNTED,
    Departure,
    Identification,
    departures,
    identify,
)
from cardan.study.otherwise import Otherwise, Turned, grown, mixed, odds, strained
from cardan.study.promise import Promised, bearing_history, promised
from cardan.study.usage import Used, used

NEEDS = "a recording in which all its channels move"
"""What a gauge needs that said nothing: no samples, or one value throughout."""

NEEDS_CUSTOMERS = "three recordings or more, of a customer each, that all did damage there"
"""What a gauge needs of which nothing is told of customers."""

DECIDE: Mapping[str, str] = {
    "sentinel": "a word on its sentinels, which decide the damage: --mask or --accept sentinel",
    "spike": "a word on its spikes, which decide the damage: --mask or --accept spike",
    "dropout": "a word on its dropouts, which decide the damage: --mask or --accept dropout",
    "clip": "a recording that is not clipped, or --accept clip",
    "zero-step": "a word on the steps of its zero, which decide the damage: --mask or --accept "
    "zero-step",
    "gain": "a word on its gain, whose changes decide the damage: --mask or --accept gain",
    "noise": "a word on its noise, which decides the damage: --mask or --accept noise",
    "repeat": "a word on what was stored twice, which decides the damage: --mask or --accept "
    "repeat",
    "drift": "a word on its drift, which decides the damage: --zero drift or --accept drift",
    "hole": "a recording in which it is alive for a quarter of the time",
    "hum": "a word on its hum, which decides the damage: --mask or --accept hum",
    "unit": "the unit its numbers are in, or --accept unit",
    "rate": "a recording sampled as its stress moves, or --accept rate",
    "bit": "a recording whose converter moves all its bits, or --accept bit",
    "strength": "the tensile strength of its part, or --accept strength",
}
"""What a gauge needs whose answer is vetoed, by the kind of fault that leaves none."""


@dataclass(frozen=True, kw_only=True)
class Pictures:
    """What a report draws of the gauges that said something, in their order.

    Attributes
    ----------
    gauges
        Their names.
    spectrograms
        Power over time and frequency, Pa²/Hz.
    order_maps
        Amplitude over speed and order, Pa; none where nothing is known to turn.
    cuts
        Orders 1, 2 and 4 window by window, Pa.
    """

    gauges: tuple[str, ...]
    spectrograms: tuple[Spectrogram, ...]
    order_maps: tuple[OrderMap, ...]
    cuts: Cuts | None


@dataclass(frozen=True, kw_only=True)
class OtherWay:
    """A channel with numbers that are none, and the answer with these taken otherwise.

    Attributes
    ----------
    misread
        Where they are, and how they are taken.
    turns
        That the shaft would make more.
    evidence
        What the joints would be answerable for, by gauge.
    """

    misread: Misread
    turns: float
    evidence: Mapping[str, Evidence]


@dataclass(frozen=True, kw_only=True)
class Heard:
    """The answer: what a recording did to its gauges.

    Attributes
    ----------
    campaign
        What it was asked.
    lives
        One a gauge of the plan; nan at those that have no samples.
    causes
        Of the gauges that said something, in their order; None where no speed tells causes
        apart.
    profile
        The limits' name; "" where no profile was asked.
    angle
        How far the shaft has turned, as the stress has it; None where nobody knows.
    identification
        What the recording says of its application; None where it was not asked.
    pictures
        Its gauges as arrays to draw; None where nobody wants to.
    used
        When and where its gauges' damage came; none where it was not asked.
    promised
        What gauges would do with the changed line; none where none was given.
    otherwise
        Its gauges judged by strain, by a crack, by odds; none where it was not asked.
    misread
        Channels of speed and torque in which a bus wrote that it had no value.
    """

    recording: Recording
    campaign: Campaign
    plan: Plan
    lives: tuple[GaugeLife, ...]
    causes: Causes | None
    profile: str
    angle: Angle | None = None
    identification: Identification | None = None
    pictures: Pictures | None = None
    used: tuple[Used, ...] = ()
    promised: tuple[Promised, ...] = ()
    otherwise: tuple[Otherwise, ...] = ()
    misread: tuple[OtherWay, ...] = ()

    @property
    def departures(self) -> tuple[Departure, ...]:
        """Where a changed line, of which something is promised, departs from what was found."""
        if self.campaign.changed is None or self.identification is None or not self.promised:
            return ()
        return departures(self.identification, self.campaign.changed)

    @property
    def unkept(self) -> bool:
        """Return whether a changed line was asked about, and nothing is known of the driven one."""
        asked = self.campaign.changed is not None and self.identification is not None
        return asked and not self.promised


@dataclass(frozen=True)
class RecordingStudy:
    """How long the gauges of a recording live, held against a campaign's limits."""

    campaign: Campaign
    name: str = NAME
    draw: bool = False
    """Whether the answer holds what a report draws: three more passes."""

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
        samples = max(h.samples for h in healths.values())
        seconds = samples / recording.rate
        campaign.hold(recording, samples=samples)
        beyond = campaign.beyond(seconds)
        angle = campaign.shaft(recording)
        ends = _unsaid(campaign, recording, angle, seconds)
        recording = replace(recording, notes=(*recording.notes, *beyond, *ends))
        plan = replace(plan, fastest=_fastest(angle))
        lives = room.counted(
            recording, plan=plan, healths=healths, distance=_distance(campaign, angle, seconds),
            progress=progress,
        )  # fmt: skip
        _masked_out(recording, plan, lives)
        heard = [g for g, one in zip(plan.gauges, lives, strict=True) if one.heard]
        causes = None
        if angle is not None and heard:
            causes = _causes(
                campaign, recording, replace(plan, gauges=tuple(heard)), angle, healths=healths,
                predicted=predicted, progress=progress,
            )  # fmt: skip
            causes = _unspoilt(causes, lives)
        misread = tuple(
            _other_ways(
                campaign, recording, replace(plan, gauges=tuple(heard)), angle, healths=healths,
                predicted=predicted, progress=progress,
            )
        )  # fmt: skip
        when = Occasion("recording", recording.name)
        if angle is not None and causes is not None:
            angle = _told_angle(angle, causes)
        identified, kept = None, tuple[Promised, ...]()
        if campaign.identify and angle is not None:
            identified = _identified(
                campaign, recording, plan, angle, healths=healths, lives=lives, progress=progress
            )
            if campaign.changed is not None and not identified.doubts:
                kept = _promised(
                    campaign, recording, plan, identified, angle.rotation, healths=healths,
                    lives=lives, progress=progress,
                )  # fmt: skip
        told = ()
        if campaign.usage and heard:
            told = _used(
                campaign, recording, replace(plan, gauges=tuple(heard)), angle, healths=healths,
                lives=[one for one in lives if one.heard], samples=samples, progress=progress,
            )  # fmt: skip
        others = _otherwise(
            campaign, recording, plan, healths=healths, lives=lives, progress=progress
        )
        pictures = None
        if self.draw and heard:
            pictures = _pictures(
                recording, replace(plan, gauges=tuple(heard)), angle, healths=healths,
                seconds=lives[0].quality.recorded, progress=progress,
            )  # fmt: skip
        return Finding(
            study=NAME,
            answer=Heard(
                recording=recording,
                campaign=campaign,
                plan=plan,
                lives=tuple(lives),
                causes=causes,
                profile=profile,
                angle=angle,
                identification=identified,
                pictures=pictures,
                used=told,
                promised=kept,
                otherwise=others,
                misread=misread,
            ),
            checks=tuple(_checks(lives, limits, when=when, line=campaign.line)),
            unanswered=tuple(_unanswered(lives, limits, when=when, line=campaign.line)),
        )


def listen(
    path: Path, campaign: Campaign, tell: Tell = silent, *, draw: bool = False
) -> Finding[Heard]:
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
        return RecordingStudy(campaign, draw=draw).run(recording, tell)
    except ImportError as error:
        msg = f"this needs {error.name}; pip install 'cardan[fatigue,recordings]'"
        raise NotInstalled(msg) from error


BETWEEN = 0.1
"""Share of a mix's damage from which cycles between its parts are told."""

CUSTOMERS = "the share of customers asked for"
"""Of whom a life is, where it is not of the mix."""

FEWEST_CUSTOMERS = 3
"""Recordings from which anything is told of customers."""


@dataclass(frozen=True)
class Mixed:
    """One gauge in a mix of recordings.

    Attributes
    ----------
    name
        Of the gauge.
    parts
        What each recording did to it, and how often that is driven in the mix.
    between
        Damage of cycles from one part to another, were they driven in turn again and again.
    order
        How they follow each other then; None where that is not asked.
    hidden
        Kinds of fault for which a recording would have no answer whole, and of which its segments
        show nothing: their levels decide, and nobody said whether the part felt that.
    """

    name: str
    parts: tuple[tuple[GaugeLife, float], ...]
    between: float = 0.0
    order: InTurn | None = None
    hidden: tuple[str, ...] = ()

    @property
    def life(self) -> Life:
        """Of the mix: damages, times and ways, each as often as it is driven."""

        def total(of: Callable[[Life], float]) -> float:
            return sum(times * of(one.life) for one, times in self.parts)

        return Life(
            damage=total(lambda one: one.damage), duration=total(lambda one: one.duration),
            distance=total(lambda one: one.distance), allowed=self.parts[0][0].life.allowed,
        )  # fmt: skip

    @property
    def in_turn(self) -> Life | None:
        """Of the mix with its parts driven in turn; None where that says nothing else."""
        if not self.between > BETWEEN * self.life.damage:
            return None
        return replace(self.life, damage=self.life.damage + self.between)

    @property
    def turned(self) -> Turned | None:
        """The same with its cycles; None where it says nothing else."""
        if self.in_turn is None or self.order is None:
            return None
        return Turned(join([self.cycles, self.order.cycles]), self.in_turn, self.order)

    @property
    def cycles(self) -> Cycles:
        """Of the mix: those of each recording as often as it is driven."""
        return join(one.cycles.repeated(times) for one, times in self.parts)

    @property
    def heard(self) -> bool:
        """Whether it said something in every recording."""
        return all(one.heard for one, _ in self.parts)

    @property
    def vetoes(self) -> tuple[str, ...]:
        """Kinds of fault that spoil it in any of them."""
        each = (kind for one, _ in self.parts for kind in one.vetoes)
        return tuple(dict.fromkeys((*each, *self.hidden)))


@dataclass(frozen=True)
class Customer:
    """One gauge of a share of customers: what they do in the time of the mix, and at most."""

    name: str
    life: Life
    at_most: Life
    heard: bool = True
    vetoes: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Mix:
    """The answer of a campaign: its recordings, and what they come to together.

    Attributes
    ----------
    title
        Of the campaign.
    parts
        Name, how often it is driven, and what was heard in each.
    lives
        One a gauge.
    profile
        The limits' name; "" where no profile was asked.
    customer
        Share of customers that is asked for; 0 for none.
    whose
        Which recording of the file each part is of, in their order.
    allowed
        Damage at failure.
    campaign
        What was asked of every recording.
    otherwise
        The mix's gauges judged by strain, by a crack, by odds; none where it was not asked.
    """

    title: str
    parts: tuple[tuple[str, float, Heard], ...]
    lives: tuple[Mixed, ...]
    profile: str
    customer: float = 0.0
    whose: tuple[int, ...] = ()
    allowed: float = 1.0
    campaign: Campaign | None = None
    otherwise: tuple[Otherwise, ...] = ()

    @property
    def customers(self) -> dict[str, tuple[float, float]]:
        """Damage a second that a share of customers stays below at each gauge, and its bound.

        Each recording of the file is taken for a customer, its segments for what he drives; a
        gauge that some did no damage to has no answer.
        """
        found: dict[str, tuple[float, float]] = {}
        for one in self.lives if self.customer else ():
            driven: dict[int, list[tuple[GaugeLife, float]]] = {}
            for whose, part in zip(self.whose, one.parts, strict=True):
                driven.setdefault(whose, []).append(part)
            each = [Mixed(one.name, tuple(parts)).life for parts in driven.values()]
            rates = [life.damage / life.duration for life in each if life.duration > 0]
            if len(rates) >= FEWEST_CUSTOMERS and min(rates) > 0 and not one.vetoes:
                found[one.name] = customer(rates, quantile=self.customer)
        return found

    def evidence(self, gauge: str) -> Evidence | None:
        """Return what the joints are answerable for at a gauge, of the mix's damage."""
        told: list[tuple[Evidence, float]] = []
        for (_, times, heard), (one, _) in zip(
            self.parts, next(m for m in self.lives if m.name == gauge).parts, strict=True
        ):
            if heard.causes is not None and gauge in heard.causes.gauges:
                where = heard.causes.gauges.index(gauge)
                told.append((heard.causes.evidence[where], times * one.life.damage))
        return together([e for e, _ in told], [w for _, w in told]) if told else None


EDGE = 1.0
"""How near the end of a segment a step of the zero is that it cannot show, s."""


@dataclass(frozen=True)
class _Driven:
    """A recording whole, and from when to when its segments are, s."""

    campaign: Campaign
    whole: Recording
    segments: Sequence[tuple[float, float]]

    def hides(self, channels: Sequence[str]) -> Iterator[str]:
        """Yield what is wrong with the level of channels that no segment can show: a look more."""
        whole = self.campaign.scaled(self.whole)
        plan = self.campaign.plan(whole)
        if plan.baseline is slow_drift:
            return
        for channel, health in room.look(whole, channels=channels).items():
            book = decided(health, channel=channel, rules=plan.rules, rate=whole.rate)
            if DRIFT in book and book[DRIFT].open.size:
                yield DRIFT
            steps = book[ZERO_STEP].open[:, 0] / whole.rate if ZERO_STEP in book else ()
            if any(not any(a + EDGE < t < b - EDGE for a, b in self.segments) for t in steps):
                yield ZERO_STEP


def listen_to_all(
    of: Path | Campaigned, *, limits: Sequence[Limit] = (), allow_outside: bool = False,
    tell: Tell = silent, draw: bool = False, identified: bool = False, changed: bool = False,
    checked: Application | None = None,
) -> Finding[Mix]:  # fmt: skip
    """Ask every recording of a campaign, and hold the mix against its limits and others.

    It is a file, or was read already.

    `checked` is the application whose verdict they will be part of: the campaign's own, if it names
    one.
    `identified` where what is wanted follows from the identification of its only recording, and
    `changed` where it is of the changed line: refused before anything is read if there is none.

    Raises
    ------
    CardanError
        As `listen`, of the file and of each recording.
    """
    written = campaigned(of, allow_outside=allow_outside) if isinstance(of, Path) else of
    try:
        return _listened(
            written, limits=limits, tell=tell, draw=draw, identified=identified, changed=changed,
            checked=checked,
        )  # fmt: skip
    except (BadFile, NotInstalled):
        raise
    except CardanError as error:
        raise RefusedInFile(error, file=written.name, worded=keyed) from error


def _listened(
    written: Campaigned, *, limits: Sequence[Limit], tell: Tell, draw: bool, identified: bool,
    changed: bool, checked: Application | None,
) -> Finding[Mix]:  # fmt: skip
    """Ask every recording of a campaign that was read."""
    asked = Campaign(**written.options)
    if asked.application is not None and checked is not None:
        _same_design(asked.application, checked)
    count = sum(len(drive.segments or (None,)) for drive in written.drives)
    if (identified or changed) and not (count == 1 and asked.identify):
        msg = (
            f"--corrected and the histories are of one recording with identify: {written.name} has "
            f"{count}" + ("" if count != 1 else " without it")
        )
        raise DesignError(msg)
    if changed and asked.changed is None:
        msg = f"--changed-history needs an application to be driven: `changed` in {written.name}"
        raise DesignError(msg)
    profile, own = asked.asked()
    limits = (*own, *limits)
    parts: list[tuple[str, float, Heard]] = []
    whose: list[int] = []
    drives: list[_Driven] = []
    for k, drive in enumerate(written.drives):
        campaign, whole = driven(asked, drive)
        segments, before = drive.segments or (None,), list[tuple[str, float, float]]()
        for segment in segments:
            name, times, recording, seconds = drive.name, drive.times, whole, 0.0
            heard = campaign
            if segment is not None:
                name, times = f"{drive.name}, {segment.name}", times * segment.times
                first, last = _times(campaign, whole, segment)
                seconds, recording = last - first, between(whole, first, last)
                heard = campaign.within(first, last)
                twice = tuple(_twice(segment.name, first, last, before))
                recording = replace(recording, notes=(*recording.notes, *twice))
                before.append((segment.name, first, last))
            answer = (
                RecordingStudy(heard, draw=draw).run(replace(recording, name=name), tell).answer
            )
            assert answer is not None
            answer = _ended(answer, seconds)
            parts.append((name, times, answer))
            whose.append(k)
        spans = [(first, last) for _, first, last in before] or [(0.0, math.inf)]
        drives.append(_Driven(campaign, whole, spans))
    names = [one.name for one in parts[0][2].lives]
    lives = tuple(
        _mixed(
            Mixed(name, tuple((heard.lives[k], times) for _, times, heard in parts)),
            drives,
            parts[0][2].plan,
        )
        for k, name in enumerate(names)
    )
    when = Occasion("recording", written.title)
    mix = Mix(
        title=written.title,
        parts=tuple(_crossed(parts)),
        lives=lives,
        profile=profile,
        customer=written.customer,
        whose=tuple(whose),
        allowed=asked.allowed,
        campaign=asked,
        otherwise=tuple(_mixed_otherwise(asked, parts, lives)),
    )
    theirs, unknown = _customers(mix)
    whom, line = replace(when, what=CUSTOMERS), asked.line
    ends = {one.name: end for one in lives if (end := one.in_turn) is not None}
    most = {one.name: one.at_most for one in theirs}
    return Finding(
        study=NAME,
        answer=mix,
        checks=(
            *_checks(lives, limits, when=when, line=line, ends=ends),
            *_checks(theirs, limits, when=whom, line=line, ends=most),
        ),
        unanswered=(
            *_unanswered(lives, limits, when=when, line=line),
            *_unanswered(unknown, limits, when=whom, line=line, needs=(NEEDS_CUSTOMERS,)),
        ),
    )


def _mixed(one: Mixed, drives: Sequence[_Driven], plan: Plan) -> Mixed:
    """Return a gauge of a mix with what happens between its parts."""
    if not one.heard:
        return one
    # What is left out of the count by choice is not put back here.
    rule = repeating if plan.rule is discarded else plan.rule

    def gained(parts: Sequence[tuple[GaugeLife, float]], rule: ResidueRule) -> tuple[InTurn, float]:
        order = in_turn(
            [life.residue for life, _ in parts], times=[times for _, times in parts],
            curve=plan.curve, correction=plan.correction, rule=rule,
        )  # fmt: skip
        return order, miner(order.cycles, curve=plan.curve, correction=plan.correction)

    hidden, place = list[str](), 0
    for drive in drives:
        own = one.parts[place : (place := place + len(drive.segments))]
        _, more = gained(own, repeating)
        if more > VETO * sum(times * life.life.damage for life, times in own):
            hidden += drive.hides(tuple(own[0][0].health))
    order, between = gained(one.parts, rule)
    return replace(one, between=between, order=order, hidden=tuple(dict.fromkeys(hidden)))


def _customers(of: Mix) -> tuple[list[Customer], list[Mixed]]:
    """Return gauges as a share of customers has them, and those of which nobody can tell that."""
    told, known, unknown = of.customers, list[Customer](), list[Mixed]()
    for one in of.lives if of.customer else ():
        if one.name in told:
            life = one.life
            own, most = (replace(life, damage=r * life.duration) for r in told[one.name])
            known.append(Customer(one.name, own, most))
        elif one.heard and not one.vetoes:
            unknown.append(one)
    return known, unknown


def driven(asked: Campaign, drive: Drive) -> tuple[Campaign, Recording]:
    """Return what is asked of one recording of a campaign, and that recording."""
    own = {
        k: (*getattr(asked, k), *v) if k in ("mask", "accept", "scale") else v
        for k, v in drive.options.items()
    }
    campaign = replace(asked, limits=None, target_hours=None, **own)
    whole = _opened(drive.file, campaign)
    for file, late in drive.beside:
        whole = alongside(whole, _opened(file, Campaign(sn=asked.sn)), late=late)
    return campaign, whole


def _twice(
    name: str, first: float, last: float, before: Iterable[tuple[str, float, float]]
) -> Iterator[str]:
    """Yield what of a segment, s, is of those before it too."""
    for other, begins, ends in before:
        both = min(last, ends) - max(first, begins)
        if both > 0:
            yield f"{name} and {other} have {both:.4g} s in common, which count in both"


def _ended(answer: Heard, asked: float) -> Heard:
    """Return an answer that says where its recording ended before its segment did, s."""
    there = max(one.quality.recorded for one in answer.lives)
    if there > asked - 1:
        return answer
    of = answer.recording
    note = f"{of.name} is of {asked:g} s, and the recording ends after {there:g} s of them"
    return replace(answer, recording=replace(of, notes=(*of.notes, note)))


def _crossed(parts: Sequence[tuple[str, float, Heard]]) -> Iterator[tuple[str, float, Heard]]:
    """Yield parts, with a note where the findings of two gauges change places from one to another.

    One gauge may be guilty on one road and not on the next; that two do so against each other is
    how exchanged plugs look.
    """
    before: list[tuple[str, dict[str, str]]] = []
    for name, times, heard in parts:
        found = {} if heard.causes is None else {
            gauge: e.finding
            for gauge, e in zip(heard.causes.gauges, heard.causes.evidence, strict=True)
        }  # fmt: skip
        guilty, innocent = (
            [g for g, finding in found.items() if finding == of] for of in (GUILTY, INNOCENT)
        )
        notes = [
            f"{one} is guilty here and {other} is not, and in {earlier} it was the other way "
            "round: are their channels exchanged?"
            for earlier, then in before
            for one in guilty
            for other in innocent
            if then.get(one) == INNOCENT and then.get(other) == GUILTY
        ]
        before.append((name, found))
        if notes:
            of = heard.recording
            heard = replace(heard, recording=replace(of, notes=(*of.notes, *notes[:1])))
        yield name, times, heard


def _same_design(driven: Application, checked: Application) -> None:
    """Refuse recordings of one design in the verdict of another: its gauges never felt that."""
    if driven.written is None or checked.written is None:
        return
    was, now = driven.written.numbers, checked.written.numbers
    both = was.keys() & now.keys()
    other = [k for k in {**was, **now} if k not in both or not np.array_equal(was[k], now[k])]
    if other:
        first = other[0]
        msg = (
            f"the recordings are of {driven.written.name}, where {first} is "
            f"{was.get(first, 'not given')}; in {checked.written.name}, which is checked, it is "
            f"{now.get(first, 'not given')}: check the one that was driven, or name in "
            "`application` the one that was"
        )
        raise DesignError(msg)


def _mixed_otherwise(
    campaign: Campaign, parts: Sequence[tuple[str, float, Heard]], lives: Sequence[Mixed]
) -> Iterator[Otherwise]:
    """Yield what a mix comes to otherwise, at each gauge that every recording has an answer of."""
    told = [{o.gauge: o for o in heard.otherwise} for _, _, heard in parts]
    for one in lives:
        if all(one.name in of for of in told):
            yield mixed(
                one, [(of[one.name], times) for of, (_, times, _) in zip(told, parts, strict=True)],
                parts[0][2].plan, gauge=one.name, turned=one.turned, strained=campaign.strained,
                crack=campaign.cracked, hours=campaign.service_hours,
                miner_scatter=campaign.miner_scatter,
            )  # fmt: skip


def _times(campaign: Campaign, recording: Recording, segment: Segment) -> tuple[float, float]:
    """Return from when to when a segment is, s.

    Raises
    ------
    DesignError
        If it is by place and nobody knows the way, or the way ends before it.
    """
    if not segment.by_way:
        return segment.first, segment.last
    angle = campaign.shaft(campaign.scaled(recording))
    ratio, radius = campaign.axle_ratio, campaign.tyre_radius_m
    if angle is None or ratio is None or radius is None:
        msg = (
            f"segment {segment.name} is by place: that needs the shaft's speed or tacho, "
            "axle_ratio and tyre_radius_m"
        )
        raise DesignError(msg)
    of = angle.rotation
    way = (of.turns - of.turns[0]) / ratio * TURN * radius
    if segment.first >= way[-1]:
        msg = (
            f"segment {segment.name} begins at {segment.first / 1e3:g} km, the way ends at "
            f"{way[-1] / 1e3:.4g} km"
        )
        raise DesignError(msg)
    first, last = (float(np.interp(v, way, of.time)) for v in (segment.first, segment.last))
    return max(first, 0.0), last


def _opened(path: Path, campaign: Campaign) -> Recording:
    try:
        return open_recording(path, rate=campaign.rate, time=campaign.time, group=campaign.group)
    except ImportError as error:
        msg = f"this needs {error.name}; pip install 'cardan[fatigue,recordings]'"
        raise NotInstalled(msg) from error


def verdict_on(found: Finding[Heard] | Finding[Mix]) -> Verdict | None:
    """Return what the gauges come to; None where nothing was asked of them.

    Where a life is vetoed, or no gauge says anything, the recording was asked and has no answer,
    limit or not.
    """
    coverage = coverage_of(found)
    if not coverage.asked:
        lives = found.answer.lives if found.answer is not None else ()
        spoiled = any(one.vetoes for one in lives) or not any(one.heard for one in lives)
        return "incomplete" if spoiled else None
    return verdict_of(found.checks, missed=bool(coverage.missed))


KNOWN = Limit(quantity="fatigue_life", sense=">=", maximum=0.0, required=True, source=ASKED)
"""That anything be known of a life: what is asked of a recording that nobody limits."""


def unheard(found: Finding[Mix]) -> Iterator[Unanswered]:
    """Yield the gauges of a campaign whose life is not known, where no limit asks for it."""
    of = found.answer
    if of is not None and of.campaign is not None and not coverage_of(found).asked:
        when = Occasion("recording", of.title)
        yield from _unanswered(of.lives, (KNOWN,), when=when, line=of.campaign.line)


def _progress(recording: Recording, tell: Tell) -> room.Progress:
    """Return what tells the seconds done, of how many where that is known."""
    total = recording.samples / recording.rate if recording.samples else 0.0

    def told(name: str, seconds: float) -> None:
        if total:
            tell(f"{name} {seconds / total:.0%}", 0, 0)
        else:
            tell(f"{name} {seconds:.0f} s", 0, 0)

    return told


QUICK = 60.0
"""Turns a second that few propshafts reach: 3600 rpm."""
OPEN = 0.1
"""Share of a recording without a speed from which nobody knows its way."""


def _unheard(angle: Angle, seconds: float) -> tuple[float, float]:
    """Return for how long nothing says the speed at either end of a recording, s."""
    first, last = angle.ends
    return max(first, 0.0), max(seconds - last, 0.0)


def _held(angle: Angle, seconds: float) -> bool:
    """Return whether so little of a speed is missing that the speed beside may stand in."""
    return sum(_unheard(angle, seconds)) + float(np.diff(angle.holes).sum()) <= OPEN * seconds


def _unsaid(
    campaign: Campaign, recording: Recording, angle: Angle | None, seconds: float
) -> Iterator[str]:
    """Yield what to know of a speed that begins late, ends early or is not there between."""
    if angle is None:
        return
    if campaign.tacho and (apart := campaign.held_apart(recording)) < QUICK:
        yield (
            f"{campaign.tacho}: {campaign.pulses} pulses a turn are held apart up to "
            f"{apart * 60:.0f} rpm; a shaft that turned much faster would be told as slower"
        )
    channel, driven = campaign.speed, campaign.axle_ratio is not None
    found: list[str] = []
    back = float(np.diff(angle.negative).sum())
    signless = angle.negative if not angle.sized else angle.negative[:0]
    if back and angle.sized:
        yield (
            f"{channel}: negative for {back:.3g} s: reverse, or its sign is the other way round; "
            "it counts by its size"
        )
    elif back:
        found.append(
            f"{channel}: negative for {back:.3g} s, one number throughout: reverse, its sign the "
            "other way round, or a number for none"
        )
    lost = _unheard(angle, seconds)
    ends = np.array([(0.0, lost[0]), (seconds - lost[1], seconds)])
    if any(lost) and not _within(ends[np.array(lost) > 0], signless).all():
        found.append(
            f"{channel}: no speed in the first {lost[0]:.3g} s and the last {lost[1]:.3g} s"
        )
    holes = angle.holes[~_within(angle.holes, signless)]
    if len(holes):
        long = np.diff(holes)[:, 0]
        found.append(
            f"{channel}: no speed for {long.sum():.3g} s, longest hole {long.max():.3g} s, the "
            f"first at {holes[0, 0]:.4g} s"
        )
    for said in found:
        if not driven or campaign.tyre_radius_m is None:
            yield f"{said}: damage there is of no band of speed"
        elif _held(angle, seconds):
            yield (
                f"{said}: damage there is of no band of speed, km are counted with the speed beside"
            )
        else:
            yield f"{said}: damage there is of no band of speed, and km are not known"


def _within(runs: FloatArray, others: FloatArray) -> BoolArray:
    """Return which of some runs (k, 2) s are one of others (m, 2) but for a moment at its ends."""
    off = np.abs(runs[:, None] - others[None]).max(-1)
    return (off < DARK).any(-1)


def _distance(campaign: Campaign, angle: Angle | None, seconds: float) -> float:
    """Return what was driven in a recording that lasts so long, m; nan where nobody knows."""
    ratio, radius = campaign.axle_ratio, campaign.tyre_radius_m
    if angle is None or ratio is None or radius is None or not _held(angle, seconds):
        return math.nan
    shaft = angle.rotation
    turned = float(shaft.turns[-1] - shaft.turns[0])
    # Who is said to have turned nowhere was not driven: the speed is not what it is taken for.
    return turned / ratio * TURN * radius if turned > 0 else math.nan


def _unspoilt(causes: Causes, lives: Sequence[GaugeLife]) -> Causes:
    """Return causes that accuse and acquit nobody at a gauge that is vetoed."""
    vetoed = {one.name for one in lives if one.vetoed}
    return replace(
        causes,
        evidence=[
            e.unknown(SPOILT) if name in vetoed else e
            for name, e in zip(causes.gauges, causes.evidence, strict=True)
        ],
    )


def _fastest(angle: Angle | None) -> float:
    """Return how fast a shaft's order 2 moves, Hz, but for a twentieth of its time under way."""
    if angle is None:
        return 0.0
    speed = angle.rotation.speed(angle.rotation.time)
    moving = speed[speed > 0.5]
    return 2 * float(np.quantile(moving, 0.95, overwrite_input=True)) if moving.size else 0.0


def _masked_out(recording: Recording, plan: Plan, lives: Sequence[GaugeLife]) -> None:
    """Refuse rules that leave nothing of a gauge that had something to say."""
    for one in lives:
        spoke = not any(h.dead for h in one.health.values())
        if spoke and not one.heard and any(r.mask for r in plan.rules):
            msg = (
                f"--mask leaves nothing of {one.name}: {one.quality.live:.4g} s of the "
                f"{one.quality.recorded:.4g} s of {recording.name}; mask less, or leave it out"
            )
            raise DesignError(msg)


def _causes(
    campaign: Campaign, recording: Recording, plan: Plan, angle: Angle, *,
    healths: dict[str, Health], predicted: dict[str, float], progress: room.Progress,
) -> Causes:  # fmt: skip
    """Return who did the damage at a plan's gauges."""
    ratio, shaft = campaign.axle_ratio, angle.rotation
    orders = numbers(campaign.engine_orders) if campaign.engine_orders else ()
    named = suspects(
        shaft, joint_orders=numbers(campaign.joint_orders), engine=campaign.engine_of(recording),
        engine_orders=orders or FIRING,
        wheel=None if ratio is None else shaft.geared(1 / ratio),
    )  # fmt: skip
    return room.causes(
        campaign.without_torque(recording), plan=plan, healths=healths,
        how=separation(named, rate=recording.rate),
        angle=angle, torque=campaign.torque_of(recording), predicted=predicted,
        engine_orders=orders, progress=progress,
    )  # fmt: skip


def _other_ways(
    campaign: Campaign, recording: Recording, plan: Plan, angle: Angle | None, *,
    healths: dict[str, Health], predicted: dict[str, float], progress: room.Progress,
) -> Iterator[OtherWay]:  # fmt: skip
    """Yield what it would come to if numbers of a bus that are no speeds were taken otherwise."""
    for one in campaign.misread(recording):
        other = campaign.other_way(one)
        turned = other.shaft(recording)
        evidence: dict[str, Evidence] = {}
        if turned is not None and plan.gauges:
            found = _causes(
                other, recording, plan, turned, healths=healths, predicted=predicted,
                progress=progress,
            )  # fmt: skip
            evidence = dict(zip(found.gauges, found.evidence, strict=True))
        turns = math.nan
        if turned is not None and angle is not None:
            turns = float(np.ptp(turned.rotation.turns) - np.ptp(angle.rotation.turns))
        yield OtherWay(misread=one, turns=turns, evidence=evidence)


def _told_angle(angle: Angle, causes: Causes) -> Angle:
    """Return an angle with the ratio and lag that the surest gauge has found.

    A tacho counts every turn as it comes, so nothing is found better than that.
    """
    if angle.lag <= COUNTED:
        return angle
    surest = causes.surest
    if surest is None or (surest.ratio == 1 and surest.lag == 0):
        return angle
    of = angle.rotation
    return replace(angle, rotation=Rotation(of.time + surest.lag, surest.ratio * of.turns))


def _identified(
    campaign: Campaign, recording: Recording, plan: Plan, angle: Angle, *,
    healths: dict[str, Health], lives: Sequence[GaugeLife], progress: room.Progress,
) -> Identification:  # fmt: skip
    """Return what a recording says of the campaign's application."""
    units = campaign.unit_stresses()
    gauges = tuple(
        g for g, one in zip(plan.gauges, lives, strict=True) if g.name in units and one.heard
    )
    if not gauges:
        msg = "no gauge of --unit-stress says anything: nothing to identify the application from"
        raise DesignError(msg)
    assert campaign.application is not None  # `Campaign` refuses
    own, seconds = replace(plan, gauges=gauges), lives[0].quality.recorded
    stress = room.stresses(recording, plan=own, healths=healths, name="identify", progress=progress)
    found = identify(
        campaign.application, stress, rate=recording.rate, gauges=[g.name for g in gauges],
        units=np.stack([units[g.name] for g in gauges]), angle=angle,
        torque=campaign.read_torque(recording), seconds=seconds, state=campaign.state,
        bearing=campaign.bearing,
    )  # fmt: skip
    stress = room.stresses(recording, plan=own, healths=healths, name="modes", progress=progress)
    return replace(found, shaken=_shaken(campaign, recording, stress, angle, seconds=seconds))


def _shaken(
    campaign: Campaign, recording: Recording, stress: Iterable[FloatArray], angle: Angle, *,
    seconds: float,
) -> tuple[Mode, ...]:  # fmt: skip
    """Return the modes that gauges feel beside the orders of shaft and engine."""
    orders = numbers(campaign.engine_orders) if campaign.engine_orders else ()
    return modes(
        background(
            stress, rate=recording.rate, seconds=seconds, angle=angle,
            engine=campaign.engine_of(recording),
            engine_orders=orders or (*FIRING, FOUR_CYLINDERS),
        )
    )  # fmt: skip


def _promised(
    campaign: Campaign, recording: Recording, plan: Plan, of: Identification, rotation: Rotation,
    *, healths: dict[str, Health], lives: Sequence[GaugeLife], progress: room.Progress,
) -> tuple[Promised, ...]:  # fmt: skip
    """Return what the changed line promises at the gauges that the line was identified by.

    Of one that is vetoed nothing.
    """
    changed = campaign.changed
    assert changed is not None  # who asks looks
    sound = {one.name: one for one in lives if not one.vetoed}
    own = _identifying(plan, of)
    own = replace(own, gauges=tuple(g for g in own.gauges if g.name in sound))
    if not own.gauges:
        return ()
    stress = room.stresses(recording, plan=own, healths=healths, name="changed", progress=progress)
    try:
        return promised(
            of, changed, stress, rate=recording.rate, rotation=rotation,
            torque=campaign.read_torque(recording), seconds=lives[0].quality.recorded, plan=own,
            lives=[sound[g.name] for g in own.gauges],
        )  # fmt: skip
    except DesignError as error:
        msg = f"the changed application: {error}"
        raise DesignError(msg) from None


def _identifying(plan: Plan, of: Identification) -> Plan:
    """Return the plan of the gauges that the line was identified by."""
    return replace(plan, gauges=tuple(g for g in plan.gauges if g.name in of.gauges))


def history_of(
    campaign: Campaign, of: Heard, *, changed: bool = False
) -> tuple[FloatArray, FloatArray]:
    """Return the force on the bearing over a recording, (n,) s and (n, 3) N, as `bearing_history`.

    Of the line as it was identified, or of the campaign's changed one.
    """
    assert of.identification is not None  # who asks looks
    assert of.angle is not None
    healths = {name: one for life in of.lives for name, one in life.health.items()}
    stress = room.stresses(
        of.recording, plan=_identifying(of.plan, of.identification), healths=healths, name="force"
    )
    return bearing_history(
        of.identification, stress, rate=of.recording.rate, rotation=of.angle.rotation,
        torque=campaign.read_torque(of.recording), seconds=of.lives[0].quality.recorded,
        application=campaign.changed if changed else None,
    )  # fmt: skip


def _used(
    campaign: Campaign, recording: Recording, plan: Plan, angle: Angle | None, *,
    healths: dict[str, Health], lives: Sequence[GaugeLife], samples: int,
    progress: room.Progress,
) -> tuple[Used, ...]:  # fmt: skip
    """Return when and where the damage of a plan's gauges came."""

    def one_by_one() -> Iterator[Usage]:
        for gauge in plan.gauges:
            stress = room.stresses(
                recording, plan=replace(plan, gauges=(gauge,)), healths=healths, name="usage",
                progress=progress,
            )  # fmt: skip
            yield from usage(
                stress, rate=recording.rate, curve=plan.curve, correction=plan.correction,
                rule=plan.rule,
            )  # fmt: skip

    ratio, radius = campaign.axle_ratio, campaign.tyre_radius_m
    per_turn = math.nan if ratio is None or radius is None else TURN * radius / ratio
    return used(
        one_by_one(), lives, count=seconds_in(samples, rate=recording.rate), plan=plan, angle=angle,
        engine=campaign.engine_of(recording) if angle is not None else None,
        torque=campaign.read_torque(recording) if campaign.torque else None, per_turn=per_turn,
        begins=recording.begins, held=angle is None or _held(angle, samples / recording.rate),
        second=second_at(recording.rate),
    )  # fmt: skip


def _otherwise(
    campaign: Campaign, recording: Recording, plan: Plan, *, healths: dict[str, Health],
    lives: Sequence[GaugeLife], progress: room.Progress,
) -> tuple[Otherwise, ...]:  # fmt: skip
    """Return a plan's gauges as their strain, a crack and odds have them, those with an answer."""
    by_strain, crack, hours = campaign.strained, campaign.cracked, campaign.service_hours
    if by_strain is None and crack is None and hours is None:
        return ()
    told = [
        (g, one) for g, one in zip(plan.gauges, lives, strict=True) if one.heard and not one.vetoed
    ]
    if not told:
        return ()
    gauges, own = zip(*told, strict=True)
    strains: Sequence[tuple[float | None, float]] = [(None, math.nan)] * len(own)
    if by_strain is not None:
        sharp = any(not math.isnan(one.quality.samples_only) for one in own)

        def pieces() -> Iterator[FloatArray]:
            stress = room.stresses(
                recording, plan=replace(plan, gauges=gauges), healths=healths, name="strain",
                progress=progress,
            )  # fmt: skip
            return finer(stress) if sharp else stress

        largest = [max(abs(one.low), abs(one.high)) for one in own]
        strains = strained(pieces, largest, by_strain, rule=plan.rule)
    return tuple(
        Otherwise(
            gauge=one.name, duration=one.life.duration, allowed=plan.allowed,
            strain_damage=damage, strain=strain,
            growth=None if crack is None else grown(one, crack),
            odds=None if hours is None else odds(
                one, plan, hours=hours, miner_scatter=campaign.miner_scatter
            ),
        )
        for one, (damage, strain) in zip(own, strains, strict=True)
    )  # fmt: skip


def _pictures(
    recording: Recording, plan: Plan, angle: Angle | None, *, healths: dict[str, Health],
    seconds: float, progress: room.Progress,
) -> Pictures:  # fmt: skip
    """Return what a report draws of a plan's gauges."""

    def stress() -> Iterator[FloatArray]:
        return room.stresses(recording, plan=plan, healths=healths, name="draw", progress=progress)

    rate, maps, cuts = recording.rate, list[OrderMap](), None
    top = HEARD
    if angle is not None:
        at = windows(angle.rotation, until=seconds)
        if at.time.size:
            top = max(HEARD, 6 * float(at.speed.max()))
            maps = order_maps(stress(), rate=rate, rotation=angle.rotation, at=at)
            cuts = order_cuts(stress(), rate=rate, rotation=angle.rotation, at=at)
    return Pictures(
        gauges=tuple(g.name for g in plan.gauges),
        spectrograms=tuple(spectrograms(stress(), rate=rate, seconds=seconds, top=top)),
        order_maps=tuple(maps), cuts=cuts,
    )  # fmt: skip


HEARD = 60.0
"""Hz up to which a spectrogram shows a bracket's stress, unless its shaft's orders go higher."""


class Lived(Protocol):
    """What limits are asked of: a gauge in a recording, or in a mix of some."""

    @property
    def name(self) -> str:
        """Of the gauge."""
        ...

    @property
    def life(self) -> Life:
        """Damage and what follows from it."""
        ...

    @property
    def heard(self) -> bool:
        """Whether it said anything."""
        ...

    @property
    def vetoes(self) -> tuple[str, ...]:
        """Kinds of fault that spoil what it said."""
        ...


_VALUES: dict[str, Callable[[Life], float]] = {
    "fatigue_life": lambda life: life.hours * hour,
    "fatigue_damage": lambda life: life.damage,
}
"""What a limit asks about of a gauge, SI."""

NOTHING: Mapping[str, Life] = {}


def _checks(
    lives: Sequence[Lived], limits: Sequence[Limit], *, when: Occasion, line: str,
    ends: Mapping[str, Life] = NOTHING,
) -> Iterator[Check]:  # fmt: skip
    """Yield a check for each limit and gauge that said something.

    `ends` are lives of gauges that may be as well, by what nobody recorded.
    """
    for limit in limits:
        asked = _VALUES[limit.quantity]
        for one in lives:
            if _known(one, limit):
                value, within = asked(one.life), None
                if one.name in ends:
                    low, high = sorted((value, asked(ends[one.name])))
                    within = (low, high)
                yield Check(
                    quantity=limit.quantity, line=line, when=when, part=_part(one),
                    value=value, limit=limit, within=within,
                )  # fmt: skip


def _unanswered(
    lives: Sequence[Lived], limits: Sequence[Limit], *, when: Occasion, line: str,
    needs: tuple[str, ...] = (),
) -> Iterator[Unanswered]:  # fmt: skip
    """Yield each limit and gauge that got no number, or one that cannot be trusted.

    A broken wire lives for ever. Where `needs` are said no number of them can be.
    """
    for limit in limits:
        for one in lives:
            if needs or not _known(one, limit):
                lacks = needs or tuple(DECIDE[k] for k in one.vetoes) or (NEEDS,)
                yield Unanswered(limit=limit, line=line, when=when, part=_part(one), needs=lacks)


def _known(one: Lived, limit: Limit) -> bool:
    told = one.heard and not one.vetoes
    return told and not math.isnan(_VALUES[limit.quantity](one.life))


def _part(one: Lived) -> Part:
    return Part("gauge", 0, one.name)

"""A recording that was brought, or those of a campaign: channels, suspects, life and causes."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.errors import CardanError, NotInstalled
from cardan.base.units import MPa
from cardan.fatigue import life as room
from cardan.fatigue.conditioning import Health
from cardan.fatigue.evidence import Evidence
from cardan.fatigue.fault import DRIFT, HOLE, KINDS, REMOVABLE
from cardan.fatigue.recording import Channel, Recording, between
from cardan.files.campaign import Campaigned, Segment
from cardan.files.pasted import entered
from cardan.files.recordings import open_recording
from cardan.report import recording_story as story
from cardan.report.blocks import Issue, Story
from cardan.report.language import Language
from cardan.report.life import mix_life, under_way
from cardan.study import recording as study
from cardan.study.campaign import SPEED, STRAIN, STRESS, TORQUE, Campaign
from cardan.study.finding import Finding
from cardan.study.recording import Heard, Mix, RecordingStudy
from cardan.web.document import Document, Json, Tell, f, fs, g
from cardan.web.told import told

BINS = 400
"""Stretches of a channel that its smallest and largest values are told of."""

PLACES = 40
"""Places of a kind of fault that are told, the longest."""

DRAWN = 64
"""Channels that are drawn."""

WORDS: Mapping[str, tuple[str, ...]] = {"engine": ("engine", "motor"), "tacho": ("tacho",)}
"""What tells such a channel by its name, where its unit tells nothing."""


def brought(_: Document, args: Json, say: Language, tell: Tell) -> Json:
    """Return what a recording holds, channel by channel, and where it looks wrong."""
    recording = _opened(args)
    roles = {c.name: _role(c) for c in recording.channels[:DRAWN]}
    return _looked(recording, roles, say, tell)


def driven(read: Document, args: Json, say: Language, tell: Tell) -> Json:
    """Return what a recording of a campaign holds in the channels that are asked about."""
    of = _campaign(read)
    drive = of.drives[min(int(args.get("drive", 0)), len(of.drives) - 1)]
    try:
        campaign, recording = study.driven(Campaign(**of.options), drive)
    except ImportError as error:
        raise _missing(error) from error
    recording = replace(campaign.scaled(recording), name=drive.name)
    drifts = campaign.zero != "drift"
    return _looked(recording, campaign.roles(recording), say, tell, drifts=drifts)


def _looked(
    recording: Recording,
    roles: Mapping[str, str],
    say: Language,
    tell: Tell,
    *,
    drifts: bool = True,
) -> Json:
    """Return channels of a recording, and where those of gauges look wrong.

    `drifts` is false where what drifts is taken off.
    """
    names = tuple(n for n in recording.names if n in roles)[:DRAWN]
    healths = room.look(recording, channels=names, progress=_progress(recording, say, tell))
    samples = max(h.samples for h in healths.values())
    healths = {n: h if roles[n] in ("gauge", "") else h.of_no_gauge() for n, h in healths.items()}
    low, high = _envelope(recording, names, samples=samples)
    return {
        "name": recording.name,
        "rate": g(recording.rate),
        "seconds": f(samples / recording.rate),
        "notes": [say.error(say.given(n)) for n in recording.notes],
        "left": len(recording.names) - len(names),
        "channels": [
            {
                "name": c.name, "unit": c.unit, "role": roles[c.name],
                "low": g(h.low), "high": g(h.high), "lowest": fs(a, 4), "highest": fs(b, 4),
                "suspects": _suspects(h, recording.rate, say, drifts=drifts),
                "said": [say.said(s) for s in h.findings(rate=recording.rate, unit=c.unit)],
            }
            for c, h, a, b in zip(
                map(recording.channel, names), (healths[n] for n in names), low, high, strict=True
            )
        ],
    }  # fmt: skip


def lived(_: Document, args: Json, say: Language, tell: Tell) -> Json:
    """Return what a recording did to its gauges, and who did it."""
    options = {k: v for k, v in args.items() if k in ASKED and v not in ("", [], None)}
    numbers = {k: _typed(args, k, label, say) for k, label in _FIELDS.items() if args.get(k)}
    curve = ",".join(repr(numbers[k]) for k in ("amplitude", "cycles", "slope") if k in numbers)
    if "modulus" in numbers:
        options["modulus_GPa"] = numbers["modulus"]
    campaign = Campaign.of(sn=curve, target_hours=numbers.get("hours"), **options)
    recording = _opened(args)
    if {"first", "last"} & numbers.keys():
        recording = between(recording, numbers.get("first", 0.0), numbers.get("last") or 1e12)
    try:
        found = RecordingStudy(campaign, draw=True).run(recording, _reading(say, tell))
    except ImportError as error:
        raise _missing(error) from error
    heard = found.answer
    assert heard is not None
    return {
        "name": recording.name,
        "orders": _orders(heard),
        "causes": _causes(heard, say),
        "open": [
            {"rule": f"{one.name}={k}", "said": f"{one.name}: {say(k)}", "mask": k in REMOVABLE}
            for one in heard.lives
            for k in one.vetoes
            if k != HOLE
        ],
        **_story(story.recording(replace(found, answer=_undrawn(heard)), say=say, issue=Issue())),
    }


def listened(read: Document, say: Language, tell: Tell, *, draw: bool = True) -> Finding[Mix]:
    """Ask every recording of a campaign."""
    try:
        return study.listen_to_all(_campaign(read), tell=_reading(say, tell), draw=draw)
    except ImportError as error:
        raise _missing(error) from error


def mixed(read: Document, _: Json, say: Language, tell: Tell) -> Json:
    """Return what the recordings of a campaign did to its gauges, and who did it."""
    found = listened(read, say, tell)
    mix = found.answer
    assert mix is not None
    evidence = {one.name: mix.evidence(one.name) for one in mix.lives}
    bare = tuple((name, times, _undrawn(heard)) for name, times, heard in mix.parts)
    told = story.campaign(
        replace(found, answer=replace(mix, parts=bare)), say=say, issue=Issue()
    )  # fmt: skip
    return {
        "name": mix.title,
        "orders": [
            {**row, "gauge": f"{name}: {row['gauge']}"}
            for name, _, heard in mix.parts
            for row in _orders(heard)
        ][:DRAWN],
        "causes": [{**_removed(n, e, say), "shares": []} for n, e in evidence.items() if e],
        "lives": {one.name: mix_life(one, say) for one in mix.lives},
        **_story(told),
    }


def listed(of: Campaigned, say: Language) -> Json:
    """Return what a campaign names, and what is asked of it."""
    asked, profile = Campaign(**of.options), of.options["limits"]
    amplitude, cycles, slope = map(float, asked.sn.split(","))
    facts = (
        (
            say("S-N curve at the gauge, half failed, at its knee"),
            f"{say.short(amplitude)} MPa, {cycles:.0f}, {say.short(slope)}",
        ),
        *((say(word), getattr(asked, key)) for key, word in _TURNING.items()),
        (say("hours to live"), asked.target_hours and say.short(asked.target_hours)),
        (say("Limits"), profile and Path(profile).name),
    )
    return {
        "title": of.title,
        "asked": [
            [say("gauge"), ", ".join((*asked.gauges, *asked.rosettes))],
            *([label, value] for label, value in facts if value),
        ],
        "drives": [
            {
                "name": d.name, "times": say.short(d.times),
                "more": [
                    *(f"+ {path.name}" for path, _ in d.beside),
                    *(_segment(s, say) for s in d.segments),
                ],
                **{k: [*getattr(asked, k), *d.options[k]] for k in ("mask", "accept")},
            }
            for d in of.drives
        ],
    }  # fmt: skip


def _segment(of: Segment, say: Language) -> str:
    """Return a stretch in words: up: 0 … 30 s × 2."""
    unit, scale = ("km", 1e3) if of.by_way else ("s", 1.0)
    first, last, times = (say.short(v) for v in (of.first / scale, of.last / scale, of.times))
    return f"{of.name}: {first} … {last} {unit} × {times}"


_TURNING = {"speed": "shaft speed", "tacho": "tacho", "torque": "shaft torque",
            "engine": "engine speed"}  # fmt: skip


def _campaign(read: Document) -> Campaigned:
    if read.recordings is None:
        msg = f"{read.name} is no campaign of recordings"
        raise CardanError(msg)
    return read.recordings


def _reading(say: Language, tell: Tell) -> Callable[[str, int, int], None]:
    """Return what tells the page what a study does, and how far a pass is; none is read whole."""
    return lambda doing, _, __: tell({"doing": under_way(doing, say)})


ASKED = frozenset({
    "gauges", "speed", "torque", "engine", "tacho", "mask", "accept", "zero",
})  # fmt: skip
"""What the page may say of a campaign: options of `cardan life`."""

_FIELDS = {
    "amplitude": "amplitude [MPa]", "cycles": "cycles", "slope": "slope", "first": "from [s]",
    "last": "to [s]", "hours": "hours to live", "modulus": "Young's modulus [GPa]",
}  # fmt: skip
"""Numbers that are typed, and what they are called there."""


def _opened(args: Json) -> Recording:
    """Return the recording that was brought, by the name it had where it came from."""
    of = args["recording"]
    try:
        return replace(open_recording(Path(of["path"])), name=of["name"])
    except ImportError as error:
        raise _missing(error) from error


def _missing(error: ImportError) -> NotInstalled:
    return NotInstalled(f"this needs {error.name}; pip install 'cardan[fatigue,recordings]'")


def _typed(args: Json, key: str, label: str, say: Language) -> float:
    """Return a number that was typed."""
    try:
        return entered(args[key], decimal=say.decimal)
    except ValueError as error:
        msg = f"{say(label)}: {say.error(str(error))}, {args[key]!r}"
        raise CardanError(msg) from None


def _progress(recording: Recording, say: Language, tell: Tell) -> room.Progress:
    """Return what tells how far a look has come, in seconds of the recording."""
    whole = round((recording.samples or 0) / recording.rate)

    def progress(_: str, seconds: float) -> None:
        tell({"doing": say("reading"), **({"done": round(seconds), "of": whole} if whole else {})})

    return progress


def _envelope(
    recording: Recording, names: tuple[str, ...], *, samples: int
) -> tuple[FloatArray, FloatArray]:
    """Return the smallest and largest values of channels, stretch by stretch, (channels, bins)."""
    bins = min(BINS, samples)
    low = np.full((len(names), bins), np.inf)
    high = -low
    begun = 0
    for piece in recording.pieces(names):
        at = (begun + np.arange(piece.shape[1])) * bins // samples
        starts = np.flatnonzero(np.diff(at, prepend=-1))
        there = np.isnan(piece)
        least = np.minimum.reduceat(np.where(there, np.inf, piece), starts, axis=1)
        most = np.maximum.reduceat(np.where(there, -np.inf, piece), starts, axis=1)
        low[:, at[starts]] = np.minimum(low[:, at[starts]], least)
        high[:, at[starts]] = np.maximum(high[:, at[starts]], most)
        begun += piece.shape[1]
    return low, high


def _role(of: Channel) -> str:
    """Return what a channel is by its unit, and its name where that says which: a guess.

    An engine's speed is in units of speed: its torque, or strain on its mount, is none.
    """
    name = of.name.lower()
    named = next((role for role, words in WORDS.items() if any(w in name for w in words)), "")
    units = (("gauge", STRESS), ("gauge", STRAIN), ("speed", SPEED), ("torque", TORQUE))
    measured = next((role for role, known in units if of.unit in known and of.unit != "Hz"), "")
    if measured == "torque" and named:
        return ""
    return named if named and measured in ("", "speed") else measured


def _suspects(of: Health, rate: float, say: Language, *, drifts: bool) -> list[Json]:
    """Return where a channel looks wrong, kind by kind, in seconds."""
    found: list[Json] = []
    for kind in (k for k in KINDS if k in of.faults):
        runs = of.faults[kind].runs
        longest = np.sort(np.argsort(runs[:, 0] - runs[:, 1], kind="stable")[:PLACES])
        found.append({
            "kind": kind, "said": say(kind), "count": of.faults[kind].count,
            "mask": kind in REMOVABLE, "places": fs(runs[longest] / rate, 6),
        })  # fmt: skip
    if of.drifts and drifts:
        found.append({"kind": DRIFT, "said": say(DRIFT), "count": 1, "mask": False, "places": []})
    return found


def _orders(of: Heard) -> list[Json]:
    """Return each gauge's amplitude over shaft speed and order."""
    if of.pictures is None:
        return []
    return [
        {
            "gauge": name, "rpm": fs(m.speed * 60, 2), "order": fs(m.order, 4),
            "MPa": fs(m.amplitude.T / MPa, 4),
        }
        for name, m in zip(of.pictures.gauges, of.pictures.order_maps, strict=False)
    ]  # fmt: skip


def _causes(of: Heard, say: Language) -> list[Json]:
    """Return what would go with the joints at each gauge with its interval, and all shares."""
    if of.causes is None:
        return []
    shares = [
        [{"cause": c, "said": say(c), "share": f(a.share(c), 4)} for c in a.causes]
        for a in of.causes.attributions
    ]
    rows = zip(of.causes.gauges, of.causes.evidence, shares, strict=True)
    return [{**_removed(name, e, say), "shares": share} for name, e, share in rows]


def _removed(gauge: str, of: Evidence, say: Language) -> Json:
    """Return what would go with the joints at a gauge, with its interval."""
    return {
        "gauge": gauge, "removed": f(of.removed, 4), "low": f(of.interval[0], 4),
        "high": f(of.interval[1], 4), "finding": of.finding, "said": say(of.finding),
    }  # fmt: skip


def _undrawn(of: Heard) -> Heard:
    """Return an answer without what the page draws itself."""
    return replace(of, pictures=of.pictures and replace(of.pictures, spectrograms=()))


def _story(of: Story) -> Json:
    """Return what a report says of recordings."""
    return {
        "grade": of.grade,
        "verdict": of.verdict,
        "summary": of.summary,
        "chapters": [{"title": c.title, "blocks": told(c.blocks)} for c in of.chapters],
    }

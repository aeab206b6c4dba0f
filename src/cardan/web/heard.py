"""A recording that was brought: its channels and what looks wrong in them; life and causes."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.errors import CardanError, NotInstalled
from cardan.base.units import MPa
from cardan.fatigue import life as room
from cardan.fatigue.conditioning import Health
from cardan.fatigue.fault import KINDS, REMOVABLE
from cardan.fatigue.recording import Channel, Recording, between
from cardan.files.recordings import open_recording
from cardan.report.blocks import Issue
from cardan.report.language import Language
from cardan.report.recording_story import recording as story
from cardan.study.campaign import SPEED, STRAIN, STRESS, TORQUE, Campaign
from cardan.study.recording import Heard, RecordingStudy
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
    names = recording.names[:DRAWN]
    healths = room.look(recording, channels=names, progress=_progress(recording, say, tell))
    samples = max(h.samples for h in healths.values())
    roles = {c.name: _role(c) for c in recording.channels if c.name in healths}
    healths = {n: h if roles[n] in ("gauge", "") else h.of_no_gauge() for n, h in healths.items()}
    low, high = _envelope(recording, names, samples=samples)
    return {
        "name": recording.name,
        "rate": g(recording.rate),
        "seconds": f(samples / recording.rate),
        "notes": [say.given(n) for n in recording.notes],
        "left": len(recording.names) - len(names),
        "channels": [
            {
                "name": c.name, "unit": c.unit, "role": roles[c.name],
                "low": g(h.low), "high": g(h.high), "lowest": fs(a, 4), "highest": fs(b, 4),
                "suspects": _suspects(h, recording.rate, say),
                "said": [say.said(s) for s in h.findings(rate=recording.rate, unit=c.unit)],
            }
            for c, h, a, b in zip(recording.channels, healths.values(), low, high, strict=False)
        ],
    }  # fmt: skip


def lived(_: Document, args: Json, say: Language, tell: Tell) -> Json:
    """Return what a recording did to its gauges, and who did it."""
    options = {k: v for k, v in args.items() if k in ASKED and v not in ("", [], None)}
    campaign = Campaign.of(**options)
    recording = _opened(args)
    if args.get("first") or args.get("last"):
        first, last = (_seconds(args, k) for k in ("first", "last"))
        recording = between(recording, first or 0.0, last or 1e12)
    try:
        found = RecordingStudy(campaign, draw=True).run(
            recording,
            lambda doing, _, __: (
                tell({"doing": f"{say('reading')}: {doing.rpartition(' ')[2]}"})
                if doing.endswith("%")
                else tell({"doing": say("reading")})
            ),
        )
    except ImportError as error:
        raise _missing(error) from error
    heard = found.answer
    assert heard is not None
    return {
        "name": recording.name,
        "orders": _orders(heard),
        "causes": _causes(heard, say),
        **_story(replace(found, answer=_undrawn(heard)), say),
    }


ASKED = frozenset({
    "gauges", "sn", "speed", "torque", "engine", "tacho", "mask", "accept", "target_hours",
    "mean_stress", "ultimate_MPa", "engine_orders",
})  # fmt: skip
"""What the page may say of a campaign: options of `cardan life`."""


def _opened(args: Json) -> Recording:
    """Return the recording that was brought, by the name it had where it came from."""
    of = args["recording"]
    try:
        return replace(open_recording(Path(of["path"])), name=of["name"])
    except ImportError as error:
        raise _missing(error) from error


def _missing(error: ImportError) -> NotInstalled:
    return NotInstalled(f"this needs {error.name}; pip install 'cardan[fatigue,recordings]'")


def _seconds(args: Json, key: str) -> float:
    """Return a time that was typed."""
    try:
        return float(str(args.get(key) or 0).replace(",", "."))
    except ValueError:
        msg = f"a time is a number of seconds, got {args[key]!r}"
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
    """Return what a channel is by its unit, or by its name: a guess for the form."""
    name = of.name.lower()
    for role, words in WORDS.items():
        if any(w in name for w in words):
            return role
    units = (("gauge", STRESS), ("gauge", STRAIN), ("speed", SPEED), ("torque", TORQUE))
    return next((role for role, known in units if of.unit in known and of.unit != "Hz"), "")


def _suspects(of: Health, rate: float, say: Language) -> list[Json]:
    """Return where a channel looks wrong, kind by kind, in seconds."""
    found: list[Json] = []
    for kind in (k for k in KINDS if k in of.faults):
        runs = of.faults[kind].runs
        longest = np.sort(np.argsort(runs[:, 0] - runs[:, 1], kind="stable")[:PLACES])
        found.append({
            "kind": kind, "said": say(kind), "count": of.faults[kind].count,
            "mask": kind in REMOVABLE, "places": fs(runs[longest] / rate, 6),
        })  # fmt: skip
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
    return [
        {
            "gauge": name, "removed": f(e.removed, 4), "low": f(e.interval[0], 4),
            "high": f(e.interval[1], 4), "finding": e.finding, "said": say(e.finding),
            "shares": [
                {"cause": c, "said": say(c), "share": f(a.share(c), 4)} for c in a.causes
            ],
        }
        for name, e, a in zip(of.causes.gauges, of.causes.evidence, of.causes.attributions,
                              strict=True)
    ]  # fmt: skip


def _undrawn(of: Heard) -> Heard:
    """Return an answer without what the page draws itself."""
    return replace(of, pictures=of.pictures and replace(of.pictures, spectrograms=()))


def _story(found: Any, say: Language) -> Json:
    """Return what a report says of a recording."""
    of = story(found, say=say, issue=Issue())
    return {
        "grade": of.grade,
        "verdict": of.verdict,
        "summary": of.summary,
        "chapters": [{"title": c.title, "blocks": told(c.blocks)} for c in of.chapters],
    }

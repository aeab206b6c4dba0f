"""A recording that was brought, or those of a campaign: channels, suspects, life and causes."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cardan.application.paste_import import parse_localised_number
from cardan.approval.study import StudyResult
from cardan.core.arrays import FloatArray
from cardan.core.errors import CardanError, MissingDependencyError
from cardan.core.units import MPa
from cardan.physics.signals import assessment as room
from cardan.physics.signals.attribution_result import JointAttribution
from cardan.physics.signals.channel_units import KIND_AND_SI_FACTOR_BY_UNIT
from cardan.physics.signals.conditioning import ChannelReport
from cardan.physics.signals.faults.registry import FAULT_KINDS, MASKABLE_OR_CORRECTABLE_FAULTS
from cardan.physics.signals.faults.waveform import FAULT_MISSING_SAMPLES
from cardan.physics.signals.faults.whole_channel import FAULT_DRIFT
from cardan.physics.signals.recording import Channel, Recording, time_slice
from cardan.readers.dispatch import open_recording
from cardan.render.blocks import Figures, ReportDateAndSourceStamp, ReportDocument
from cardan.render.i18n import Translator
from cardan.topics.recording import campaign_study
from cardan.topics.recording import report as story
from cardan.topics.recording.campaign_assessment import CampaignAssessment
from cardan.topics.recording.campaign_schema import CampaignSpec, RecordingSegment
from cardan.topics.recording.channel_reading import channel_unit
from cardan.topics.recording.channel_roles import guess_channel_role
from cardan.topics.recording.finding_phrases import finding_message
from cardan.topics.recording.option_table import workbench_fields
from cardan.topics.recording.options import AnalysisOptions
from cardan.topics.recording.presentation import progress_text, recording_mix_life_text
from cardan.topics.recording.recording_assessment import RecordingAssessment
from cardan.topics.recording.study import RecordingStudy
from cardan.web.block_serialiser import report_blocks_to_messages
from cardan.web.parsed_document import (
    Json,
    ParsedDocument,
    PartialResultCallback,
    round_decimals,
    round_decimals_list,
    round_significant,
)

CHANNEL_ENVELOPE_BINS = 400
"""Stretches of a channel that its smallest and largest values are sent for."""

MAX_FAULT_INTERVALS_PER_KIND = 40
"""Places of a kind of fault that are sent, the longest."""

MAX_DRAWN_CHANNELS = 64
"""Channels that are drawn."""

_PAGE_ROLES = ("gauge", "speed", "torque", "engine", "tacho")
"""What the page needs a channel for."""


def inspect_upload(
    _: ParsedDocument, args: Json, say: Translator, tell: PartialResultCallback
) -> Json:
    """Return what a recording holds, channel by channel, and where it looks wrong."""
    recording = _open_upload(args)
    roles = {c.name: _channel_role(c) for c in recording.channels[:MAX_DRAWN_CHANNELS]}
    return _channel_overview(recording, roles, say, tell)


def inspect_campaign_recording(
    read: ParsedDocument, args: Json, say: Translator, tell: PartialResultCallback
) -> Json:
    """Return what a recording of a campaign holds in the channels in question."""
    of = _campaign_of(read)
    drive = of.drives[min(int(args.get("drive", 0)), len(of.drives) - 1)]
    try:
        asked = AnalysisOptions(**of.options)
        campaign, recording = campaign_study.recording_and_options(asked, drive)
    except ImportError as error:
        raise _missing_dependency(error) from error
    recording = replace(campaign.scale_channels(recording), name=drive.name)
    drifts = campaign.zero != "drift"
    return _channel_overview(recording, campaign.channel_roles(recording), say, tell, drifts=drifts)


def _channel_overview(
    recording: Recording,
    roles: Mapping[str, str],
    say: Translator,
    tell: PartialResultCallback,
    *,
    drifts: bool = True,
) -> Json:
    """Return channels of a recording, and where those of gauges look wrong.

    `drifts` is false where what drifts is taken off.
    """
    names = tuple(n for n in recording.names if n in roles)[:MAX_DRAWN_CHANNELS]
    healths = room.survey_channel_quality(
        recording, channels=names, progress=_seconds_reporter(recording, say, tell)
    )
    samples = max(h.samples for h in healths.values())
    healths = {
        n: h if roles[n] in ("gauge", "") else h.without_gauge_faults() for n, h in healths.items()
    }
    low, high = _envelope(recording, names, samples=samples)
    return {
        "name": recording.name,
        "rate": round_significant(recording.rate),
        "seconds": round_decimals(samples / recording.rate),
        "notes": [say.error(say.translate_if_known(n)) for n in recording.notes],
        "left": len(recording.names) - len(names),
        "channels": [
            {
                "name": c.name,
                "unit": c.unit,
                "role": roles[c.name],
                "low": round_significant(h.low),
                "high": round_significant(h.high),
                "lowest": round_decimals_list(a, 4),
                "highest": round_decimals_list(b, 4),
                "suspects": _fault_rows(h, recording.rate, say, drifts=drifts),
                "said": [
                    say.translate_message(finding_message(s))
                    for s in h.findings(rate=recording.rate, unit=c.unit)
                ],
            }
            for c, h, a, b in zip(
                map(recording.channel, names), (healths[n] for n in names), low, high, strict=True
            )
        ],
    }


def analyse_upload(
    _: ParsedDocument, args: Json, say: Translator, tell: PartialResultCallback
) -> Json:
    """Return what a recording did to its gauges, and its causes."""
    numbers = {
        k: _parsed_number(args, k, label, say) for k, label in _NUMBER_LABELS.items() if args.get(k)
    }
    curve = ",".join(repr(numbers[k]) for k in ("amplitude", "cycles", "slope") if k in numbers)
    options: dict[str, Any] = {"sn": curve}
    for name, one in _WORKBENCH_FIELDS.items():
        value = (numbers if one.entry_label else args).get(one.entry or name)
        if value not in ("", [], None):
            options[name] = value
    campaign = AnalysisOptions.from_values(**options)
    recording = _open_upload(args)
    if {"first", "last"} & numbers.keys():
        recording = time_slice(recording, numbers.get("first", 0.0), numbers.get("last") or 1e12)
    try:
        found = RecordingStudy(campaign, draw=True).run(recording, _progress_reporter(say, tell))
    except ImportError as error:
        raise _missing_dependency(error) from error
    heard = found.answer
    assert heard is not None
    return {
        "name": recording.name,
        "orders": _order_maps(heard),
        "causes": _cause_rows(heard, say),
        "open": [
            {
                "rule": f"{one.name}={k}",
                "said": f"{one.name}: {say(k)}",
                "mask": k in MASKABLE_OR_CORRECTABLE_FAULTS,
            }
            for one in heard.lives
            for k in one.vetoes
            if k != FAULT_MISSING_SAMPLES
        ],
        **_report_message(
            *(
                story.recording_report(
                    replace(found, answer=answer), say=say, issue=ReportDateAndSourceStamp()
                )
                for answer in (heard, _without_pictures(heard))
            )
        ),
    }


def analyse_campaign(
    read: ParsedDocument, say: Translator, tell: PartialResultCallback, *, draw: bool = True
) -> StudyResult[CampaignAssessment]:
    """Assess every recording of a campaign."""
    try:
        return campaign_study.analyse_campaign(
            _campaign_of(read), tell=_progress_reporter(say, tell), draw=draw
        )
    except ImportError as error:
        raise _missing_dependency(error) from error


def campaign_result(
    read: ParsedDocument, _: Json, say: Translator, tell: PartialResultCallback
) -> Json:
    """Return what the recordings of a campaign did to its gauges, and its causes."""
    found = analyse_campaign(read, say, tell)
    mix = found.answer
    assert mix is not None
    evidence = {one.name: mix.evidence(one.name) for one in mix.lives}
    bare = tuple((name, times, _without_pictures(heard)) for name, times, heard in mix.parts)
    told = (
        story.campaign_report(
            replace(found, answer=answer), say=say, issue=ReportDateAndSourceStamp()
        )
        for answer in (mix, replace(mix, parts=bare))
    )
    return {
        "name": mix.title,
        "orders": [
            {**row, "gauge": f"{name}: {row['gauge']}"}
            for name, _, heard in mix.parts
            for row in _order_maps(heard)
        ][:MAX_DRAWN_CHANNELS],
        "causes": [{**_removable_share(n, e, say), "shares": []} for n, e in evidence.items() if e],
        "lives": {one.name: recording_mix_life_text(one, say) for one in mix.lives},
        **_report_message(*told),
    }


def campaign_overview(of: CampaignSpec, say: Translator) -> Json:
    """Return what a campaign names, and what is computed from it."""
    asked, profile = AnalysisOptions(**of.options), of.options["limits"]
    amplitude, cycles, slope = map(float, asked.sn.split(","))
    facts = (
        (
            say("S-N curve at the gauge, half failed, at its knee"),
            f"{say.compact_number(amplitude)} MPa, {cycles:.0f}, {say.compact_number(slope)}",
        ),
        *(
            (say(one.overview_label), getattr(asked, name))
            for name, one in _WORKBENCH_FIELDS.items()
            if one.overview_label
        ),
        (say("hours to live"), asked.target_hours and say.compact_number(asked.target_hours)),
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
                "name": d.name, "times": say.compact_number(d.times),
                "more": [
                    *(f"+ {path.name}" for path, *_ in d.second_files),
                    *(_segment_text(s, say) for s in d.segments),
                ],
                **{k: [*getattr(asked, k), *d.options[k]] for k in ("mask", "accept")},
            }
            for d in of.drives
        ],
    }  # fmt: skip


def _segment_text(of: RecordingSegment, say: Translator) -> str:
    """Return a stretch in words: up: 0 … 30 s × 2."""
    unit, scale = ("km", 1e3) if of.by_distance else ("s", 1.0)
    first, last, times = (
        say.compact_number(v) for v in (of.first / scale, of.last / scale, of.times)
    )
    return f"{of.name}: {first} … {last} {unit} × {times}"


def _campaign_of(read: ParsedDocument) -> CampaignSpec:
    if read.recording_campaign is None:
        msg = f"{read.name} is no campaign of recordings"
        raise CardanError(msg)
    return read.recording_campaign


def _progress_reporter(
    say: Translator, tell: PartialResultCallback
) -> Callable[[str, int, int], None]:
    """Return the function that sends the page a study's stage and progress; none is read whole."""
    return lambda doing, _, __: tell({"doing": progress_text(doing, say)})


_WORKBENCH_FIELDS = workbench_fields()
"""What the page may say of an analysis: options of `cardan life`."""

_NUMBER_LABELS = {
    "amplitude": "amplitude [MPa]", "cycles": "cycles", "slope": "slope", "first": "from [s]",
    "last": "to [s]",
} | {
    one.entry or name: one.entry_label
    for name, one in _WORKBENCH_FIELDS.items() if one.entry_label
}  # fmt: skip
"""Numbers that are typed, and what they are called there."""


def _open_upload(args: Json) -> Recording:
    """Return the recording that was brought, by the name it had where it came from."""
    of = args["recording"]
    try:
        databases = [Path(path) for path in of.get("databases", ())]
        return replace(open_recording(Path(of["path"]), dbc=databases), name=of["name"])
    except ImportError as error:
        raise _missing_dependency(error) from error


def _missing_dependency(error: ImportError) -> MissingDependencyError:
    return MissingDependencyError(
        f"this needs {error.name}; pip install 'cardan[fatigue,recordings]'"
    )


def _parsed_number(args: Json, key: str, label: str, say: Translator) -> float:
    """Return a number that was typed."""
    try:
        return parse_localised_number(args[key], decimal=say.decimal_sign)
    except ValueError as error:
        msg = f"{say(label)}: {say.error(str(error))}, {args[key]!r}"
        raise CardanError(msg) from None


def _seconds_reporter(
    recording: Recording, say: Translator, tell: PartialResultCallback
) -> room.ProgressCallback:
    """Return the function that reports how far a preview has come, in seconds of the recording."""
    whole = round((recording.samples or 0) / recording.rate)

    def progress(_: str, seconds: float) -> None:
        tell({"doing": say("reading"), **({"done": round(seconds), "of": whole} if whole else {})})

    return progress


def _envelope(
    recording: Recording, names: tuple[str, ...], *, samples: int
) -> tuple[FloatArray, FloatArray]:
    """Return the smallest and largest values of channels, stretch by stretch, (channels, bins)."""
    bins = min(CHANNEL_ENVELOPE_BINS, samples)
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


def _channel_role(of: Channel) -> str:
    """Return what a channel is, a guess; "" of what the page does not need.

    A gauge, a speed or a torque needs a unit to be taken for one.
    """
    role = guess_channel_role(of)
    known = role in ("engine", "tacho") or channel_unit(of) in KIND_AND_SI_FACTOR_BY_UNIT
    return role if role in _PAGE_ROLES and known else ""


def _fault_rows(of: ChannelReport, rate: float, say: Translator, *, drifts: bool) -> list[Json]:
    """Return where a channel looks wrong, kind by kind, in seconds."""
    found: list[Json] = []
    for kind in (k for k in FAULT_KINDS if k in of.faults):
        runs = of.faults[kind].runs
        longest = np.sort(
            np.argsort(runs[:, 0] - runs[:, 1], kind="stable")[:MAX_FAULT_INTERVALS_PER_KIND]
        )
        found.append(
            {
                "kind": kind,
                "said": say(kind),
                "count": of.faults[kind].count,
                "mask": kind in MASKABLE_OR_CORRECTABLE_FAULTS,
                "places": round_decimals_list(runs[longest] / rate, 6),
            }
        )
    if of.drifts and drifts:
        found.append(
            {"kind": FAULT_DRIFT, "said": say(FAULT_DRIFT), "count": 1, "mask": False, "places": []}
        )
    return found


def _order_maps(of: RecordingAssessment) -> list[Json]:
    """Return each gauge's amplitude over shaft speed and order."""
    if of.figures is None:
        return []
    return [
        {
            "gauge": name,
            "rpm": round_decimals_list(m.speed * 60, 2),
            "order": round_decimals_list(m.order, 4),
            "MPa": round_decimals_list(m.amplitude.T / MPa, 4),
        }
        for name, m in zip(of.figures.gauges, of.figures.order_maps, strict=False)
    ]


def _cause_rows(of: RecordingAssessment, say: Translator) -> list[Json]:
    """Return what would go with the joints at each gauge with its interval, and all shares."""
    if of.causes is None:
        return []
    shares = [
        [{"cause": c, "said": say(c), "share": round_decimals(a.share(c), 4)} for c in a.causes]
        for a in of.causes.attributions
    ]
    rows = zip(of.causes.gauges, of.causes.joint_attributions, shares, strict=True)
    return [{**_removable_share(name, e, say), "shares": share} for name, e, share in rows]


def _removable_share(gauge: str, of: JointAttribution, say: Translator) -> Json:
    """Return what would go with the joints at a gauge, with its interval."""
    return {
        "gauge": gauge,
        "removed": round_decimals(of.damage_share, 4),
        "low": round_decimals(of.interval[0], 4),
        "high": round_decimals(of.interval[1], 4),
        "finding": of.verdict,
        "said": say(of.verdict),
    }


def _without_pictures(of: RecordingAssessment) -> RecordingAssessment:
    """Return an answer without what the page draws itself."""
    return replace(of, figures=of.figures and replace(of.figures, spectrograms=(), histories=()))


def _report_message(of: ReportDocument, bare: ReportDocument) -> Json:
    """Return what a report says of recordings: figures of its first page, the rest of a `bare` one.

    The figures are those of the gauge that governs; tables of that page are of paper's size.
    """
    first = of.chapters[0]
    figures = tuple(block for block in first.blocks if isinstance(block, Figures))
    chapters = (*([replace(first, blocks=figures)] if figures else []), *bare.chapters[1:])
    return {
        "grade": of.grade,
        "verdict": of.verdict,
        "summary": of.summary,
        "chapters": [
            {"title": c.title, "blocks": report_blocks_to_messages(c.blocks)} for c in chapters
        ],
    }

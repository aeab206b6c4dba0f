"""A folder of applications as a library: what each comes to; reports to take away."""

import json
from base64 import b64encode
from collections import OrderedDict
from datetime import date
from hashlib import sha256
from pathlib import Path

from cardan.approval.approval import Approval, approve_application
from cardan.core.errors import CardanError
from cardan.core.verdict import CHECK_GRADES, worst_first_key
from cardan.render.blocks import ReportDateAndSourceStamp, ReportDocument
from cardan.render.i18n import LANGUAGE_CODES, Translator
from cardan.render.media import REPORT_MEDIA
from cardan.render.phrases import check_location, error_text, verdict_text
from cardan.schema.node_reader import ReferencedFile
from cardan.topics.recording import campaign_schema as campaign
from cardan.web import recording_handlers as heard
from cardan.web.parsed_document import (
    Json,
    ParsedDocument,
    PartialResultCallback,
    parse_document,
    round_significant,
    with_relative_file_names,
)

REPORT_MEDIA_TYPES = {
    **{medium.name: medium.media_type for medium in REPORT_MEDIA},
    "json": "application/json",
    "xlsx": "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet",
}  # fmt: skip
"""Reports by the end of their name, and their media types."""

MAX_CACHED_STATUSES = 500
"""Texts whose status is not computed again."""

_STATUS_CACHE: OrderedDict[tuple[str, str], tuple[Json, tuple[ReferencedFile, ...]]] = OrderedDict()
"""Rows, and the files that their texts name."""


def file_statuses(
    _: ParsedDocument, args: Json, say: Translator, tell: PartialResultCallback
) -> Json:
    """Return what each of some texts comes to; those that cannot be read say why."""
    found: list[Json] = []
    given = args.get("texts", [])
    for k, one in enumerate(given):
        tell({"doing": one["name"], "done": k, "of": len(given), "rows": found})
        key = sha256(one["text"].encode("utf-8", "surrogatepass")).hexdigest(), say.code
        known = _STATUS_CACHE.pop(key, None)
        if known is None or not all(b.is_unchanged for b in known[1]):
            known = _text_status(one, args.get("folder"), say)
        _STATUS_CACHE[key], row = known, known[0]
        while len(_STATUS_CACHE) > MAX_CACHED_STATUSES:
            _STATUS_CACHE.popitem(last=False)
        found.append({**row, "file": one["file"], "name": one["name"], "draft": one["draft"]})
    return {"rows": found}


def _text_status(
    one: Json, folder: str | None, say: Translator
) -> tuple[Json, tuple[ReferencedFile, ...]]:
    """Return title, verdict, counts and the worst check of a text, and the files it names."""
    read = parse_document(one["text"], one["name"], Path(folder) if folder else None)
    return _status_row(read, say), tuple(read.referenced_files)


def _status_row(read: ParsedDocument, say: Translator) -> Json:
    title = ""
    try:
        title = campaign.campaign_title(read.manuscript) or ""
        if of := read.recording_campaign:
            count = say.count("{count} recording", "{count} recordings", len(of.drives))
            return {"title": of.title, "verdict": None, "why": count}
        found = approve_application(read.application)
    except CardanError as error:
        why = with_relative_file_names(error_text(error, say), read.folder).splitlines()[0]
        return {"title": title, "verdict": None, "why": why[:300]}
    worst = min(found.checks, key=worst_first_key, default=None)
    return {
        "title": found.application.title,
        "profile": found.application.profile,
        "verdict": found.verdict,
        "headline": verdict_text(found, say),
        "counts": {grade: sum(c.grade == grade for c in found.checks) for grade in CHECK_GRADES},
        "worst": None if worst is None else {
            "name": say.name(worst.quantity), "margin": round_significant(worst.margin),
            "where": check_location(worst, say, several=len(found.line_responses) > 1),
        },
        "why": "",
    }  # fmt: skip


def export_report(
    read: ParsedDocument, args: Json, _: Translator, tell: PartialResultCallback
) -> Json:
    """Return a report as a file to take away, in any of the languages."""
    kind = args.get("kind", "html")
    say = Translator(args["lang"] if args.get("lang") in LANGUAGE_CODES else "en")
    if read.recording_campaign:
        data = _campaign_report(read, args, say, tell)
    else:
        tell({"doing": say("calculating"), "done": 0, "of": 1})
        data = _approval_report(approve_application(read.application), read, args, say, tell)
    return {
        "name": f"{Path(read.name).stem}.{say.code}.{kind}",
        "media": REPORT_MEDIA_TYPES[kind],
        "data": b64encode(data).decode(),
    }


def _campaign_report(
    read: ParsedDocument, args: Json, say: Translator, tell: PartialResultCallback
) -> bytes:
    """Return the report of a campaign, as `cardan life` makes it."""
    kind = args.get("kind", "html")
    if kind == "xlsx":
        names = ", ".join(medium.name for medium in REPORT_MEDIA)
        msg = f"a campaign has no workbook: take {names} or json"
        raise CardanError(msg)
    found = heard.analyse_campaign(read, say, tell, draw=kind != "json")
    if kind == "json":
        from cardan.topics.recording import json_presentation as life

        return _json_bytes(life.campaign_json_document(found))
    from cardan.topics.recording import report as recording_story

    return _rendered_report(
        recording_story.campaign_report(found, say=say, issue=_report_stamp(read, args)), kind
    )


def _approval_report(
    found: Approval, read: ParsedDocument, args: Json, say: Translator, tell: PartialResultCallback
) -> bytes:
    kind = args.get("kind", "html")
    if kind == "json":
        from cardan.documents import approval_json as contract

        return _json_bytes(contract.json_document(found))
    if kind == "xlsx":
        from cardan.documents import workbook

        return workbook.workbook_bytes(found, say=say)
    from cardan.documents import approval_report as story

    told = story.approval_report(
        found, say=say, issue=_report_stamp(read, args),
        tell=lambda done, of: tell(
            {"doing": say("looking for corrections"), "done": done, "of": of}
        ),
    )  # fmt: skip
    return _rendered_report(told, kind)


def _json_bytes(told: Json) -> bytes:
    return (json.dumps(told, indent=1, ensure_ascii=False) + "\n").encode()


def _report_stamp(read: ParsedDocument, args: Json) -> ReportDateAndSourceStamp:
    """Return what says which report this is: the day, the file and what it says."""
    own = sha256(read.text.encode("utf-8", "surrogatepass")).hexdigest()[:16]
    return ReportDateAndSourceStamp(
        date=date.today().isoformat(), file_names=(read.name,), file_texts=(read.text,),
        fingerprints=(args.get("print") or own,),
    )  # fmt: skip


def _rendered_report(told: ReportDocument, kind: str) -> bytes:
    medium = next(one for one in REPORT_MEDIA if one.name == kind)
    content = medium.write(told)
    return content.encode() if isinstance(content, str) else content

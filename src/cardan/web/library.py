"""A folder of applications as a library: what each comes to; reports to take away."""

import json
from base64 import b64encode
from collections import OrderedDict
from datetime import date
from hashlib import sha256
from pathlib import Path

from cardan.base.errors import CardanError
from cardan.base.verdict import GRADES, badness
from cardan.border.table import Beside
from cardan.files import campaign
from cardan.report.blocks import Issue, Story
from cardan.report.language import CODES, Language
from cardan.report.wording import place, refused
from cardan.study.approval import Approval, approve
from cardan.web import heard
from cardan.web.document import Document, Json, Tell, document, g, here

KINDS = {
    "html": "text/html", "pdf": "application/pdf", "json": "application/json",
    "xlsx": "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet",
}  # fmt: skip
"""Reports by the end of their name, and their media types."""

KEPT = 500
"""Texts whose status is not asked again."""

_STATUS: OrderedDict[tuple[str, str], tuple[Json, tuple[Beside, ...]]] = OrderedDict()
"""Rows, and the files that their texts name."""


def status(_: Document, args: Json, say: Language, tell: Tell) -> Json:
    """Return what each of some texts comes to; those that cannot be read say why."""
    found: list[Json] = []
    given = args.get("texts", [])
    for k, one in enumerate(given):
        tell({"doing": one["name"], "done": k, "of": len(given), "rows": found})
        key = sha256(one["text"].encode("utf-8", "surrogatepass")).hexdigest(), say.code
        known = _STATUS.pop(key, None)
        if known is None or not all(b.same for b in known[1]):
            known = _status(one, args.get("folder"), say)
        _STATUS[key], row = known, known[0]
        while len(_STATUS) > KEPT:
            _STATUS.popitem(last=False)
        found.append({**row, "file": one["file"], "name": one["name"], "draft": one["draft"]})
    return {"rows": found}


def _status(one: Json, folder: str | None, say: Language) -> tuple[Json, tuple[Beside, ...]]:
    """Return title, verdict, counts and the worst check of a text, and the files it names."""
    read = document(one["text"], one["name"], Path(folder) if folder else None)
    return _row(read, say), tuple(read.beside)


def _row(read: Document, say: Language) -> Json:
    title = ""
    try:
        title = campaign.title(read.manuscript) or ""
        if of := read.recordings:
            count = say.count("{count} recording", "{count} recordings", len(of.drives))
            return {"title": of.title, "verdict": None, "why": count}
        found = approve(read.application)
    except CardanError as error:
        why = here(refused(error, say), read.folder).splitlines()[0]
        return {"title": title, "verdict": None, "why": why[:300]}
    worst = min(found.checks, key=badness, default=None)
    return {
        "title": found.application.title,
        "profile": found.application.profile,
        "verdict": found.verdict,
        "counts": {grade: sum(c.grade == grade for c in found.checks) for grade in GRADES},
        "worst": None if worst is None else {
            "name": say.name(worst.quantity), "margin": g(worst.margin),
            "where": place(worst, say, several=len(found.responses) > 1),
        },
        "why": "",
    }  # fmt: skip


def report(read: Document, args: Json, _: Language, tell: Tell) -> Json:
    """Return a report as a file to take away, in any of the languages."""
    kind = args.get("kind", "html")
    say = Language(args["lang"] if args.get("lang") in CODES else "en")
    if read.recordings:
        data = _campaign(read, args, say, tell)
    else:
        tell({"doing": say("asking"), "done": 0, "of": 1})
        data = _made(approve(read.application), read, args, say, tell)
    return {
        "name": f"{Path(read.name).stem}.{say.code}.{kind}",
        "media": KINDS[kind],
        "data": b64encode(data).decode(),
    }


def _campaign(read: Document, args: Json, say: Language, tell: Tell) -> bytes:
    """Return the report of a campaign, as `cardan life` makes it."""
    kind = args.get("kind", "html")
    if kind == "xlsx":
        msg = "a campaign has no workbook: take html, pdf or json"
        raise CardanError(msg)
    found = heard.listened(read, say, tell, draw=kind != "json")
    if kind == "json":
        from cardan.report import life

        return _json(life.mix_document(found))
    from cardan.report import recording_story

    return _published(recording_story.campaign(found, say=say, issue=_issue(read, args)), kind)


def _made(found: Approval, read: Document, args: Json, say: Language, tell: Tell) -> bytes:
    kind = args.get("kind", "html")
    if kind == "json":
        from cardan.report import contract

        return _json(contract.approval(found))
    if kind == "xlsx":
        from cardan.report import workbook

        return workbook.workbook(found, say=say)
    from cardan.report import story

    told = story.whole(
        found, say=say, issue=_issue(read, args),
        tell=lambda done, of: tell(
            {"doing": say("looking for corrections"), "done": done, "of": of}
        ),
    )  # fmt: skip
    return _published(told, kind)


def _json(told: Json) -> bytes:
    return (json.dumps(told, indent=1, ensure_ascii=False) + "\n").encode()


def _issue(read: Document, args: Json) -> Issue:
    """Return what says which report this is: the day, the file and what it says."""
    own = sha256(read.text.encode("utf-8", "surrogatepass")).hexdigest()[:16]
    return Issue(
        date=date.today().isoformat(), files=(read.name,), texts=(read.text,),
        prints=(args.get("print") or own,),
    )  # fmt: skip


def _published(told: Story, kind: str) -> bytes:
    if kind == "pdf":
        from cardan.report import pdf

        return pdf.document(told)
    from cardan.report import html

    return html.page(told).encode()

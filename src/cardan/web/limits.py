"""The limits that an application is held against, and deviations from them that somebody signs."""

from datetime import date

from cardan.base.errors import BadFile, Problem
from cardan.base.verdict import Limit
from cardan.border.document import visible
from cardan.files.deviation import SIGNED, Deviation, deviated
from cardan.files.pasted import entered
from cardan.model.application import GIVEN
from cardan.quantity.quantities import QUANTITIES
from cardan.report.language import Language
from cardan.report.wording import cited
from cardan.web.document import Document, Json, Tell, g


def listed(read: Document, _: Json, say: Language, __: Tell) -> Json:
    """Return every limit of an application in its own order, with its source."""
    app, text = read.application, read.manuscript
    return {
        "profile": app.profile,
        "named": text.written("limits") or text.written("limits.profile") or "",
        "plain": "limits" not in text or text.written("limits") is not None,
        "limits": [_row(limit, say) for limit in app.limits],
    }


def _row(limit: Limit, say: Language) -> Json:
    q = QUANTITIES[limit.quantity]
    return {
        "quantity": limit.quantity,
        "name": say.name(limit.quantity),
        "unit": q.unit_name,
        "sense": "band" if limit.band else limit.sense,
        "normal": None if limit.normal is None else g(limit.normal / q.factor),
        "maximum": None if limit.maximum is None else g(limit.maximum / q.factor),
        "band": [g(b / q.factor) for b in limit.band] if limit.band else None,
        "states": sorted(say("as given" if s == GIVEN else s) for s in limit.states)
        if limit.states
        else [],
        "required": limit.required,
        "source": cited(limit.source, say),
        "signed": SIGNED in str(limit.source),
    }


def deviation(read: Document, args: Json, say: Language, _: Tell) -> Json:
    """Return the edits that make a limit another, with a source that says who and why."""
    app = read.application
    which = int(args.get("which", 0))
    if which >= len(app.limits):
        problem = Problem(message="there is no such limit", key="which", value=str(which))
        raise BadFile(read.name, (problem,))
    bounds = {key: _bound(args.get(key, ""), key, say) for key in ("normal", "maximum")}
    to = Deviation(
        **bounds, reason=visible(args.get("reason", "")), by=visible(args.get("by", "")),
        on=date.today().isoformat(),
    )  # fmt: skip
    edits = deviated(read.manuscript, app.limits, which, to, profile=app.profile)
    return {"draft": read.manuscript.with_(edits)}


def _bound(typed: str, key: str, say: Language) -> float | None:
    if not typed.strip():
        return None
    try:
        return entered(typed, decimal=say.decimal)
    except ValueError as error:
        problem = Problem(message=str(error), key=key, value=typed[:40])
        raise BadFile(key, (problem,)) from None

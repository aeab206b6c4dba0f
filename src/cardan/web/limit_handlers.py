"""The limits that an application is held against, and signed deviations from them."""

from datetime import date

from cardan.application.limit_deviation import (
    LIMIT_SOURCE_SIGNATORY_SEPARATOR,
    LimitDeviationRecord,
    limit_deviation_file_changes,
)
from cardan.application.paste_import import parse_localised_number
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.errors import FileIssue, InvalidFileError
from cardan.core.verdict import Limit
from cardan.model.application import STATE_KIND_WITH_GIVEN_GEOMETRY
from cardan.render.i18n import Translator
from cardan.render.phrases import citation
from cardan.schema.yaml_tree import replace_hidden_characters
from cardan.web.parsed_document import (
    Json,
    ParsedDocument,
    PartialResultCallback,
    round_significant,
)


def list_limits(read: ParsedDocument, _: Json, say: Translator, __: PartialResultCallback) -> Json:
    """Return every limit of an application in its own order, with its source."""
    app, text = read.application, read.manuscript
    return {
        "profile": app.profile,
        "named": text.scalar_text("limits") or text.scalar_text("limits.profile") or "",
        "plain": "limits" not in text or text.scalar_text("limits") is not None,
        "limits": [_limit_row(limit, say) for limit in app.limits],
    }


def _limit_row(limit: Limit, say: Translator) -> Json:
    q = QUANTITIES[limit.quantity]
    return {
        "quantity": limit.quantity,
        "name": say.name(limit.quantity),
        "unit": q.unit_symbol,
        "sense": "band" if limit.band else limit.sense,
        "normal": None if limit.normal is None else round_significant(limit.normal / q.si_factor),
        "maximum": None
        if limit.maximum is None
        else round_significant(limit.maximum / q.si_factor),
        "band": [round_significant(b / q.si_factor) for b in limit.band] if limit.band else None,
        "states": sorted(
            say("as given" if s == STATE_KIND_WITH_GIVEN_GEOMETRY else s) for s in limit.states
        )
        if limit.states
        else [],
        "required": limit.required,
        "source": citation(limit.source, say),
        "signed": LIMIT_SOURCE_SIGNATORY_SEPARATOR in str(limit.source),
    }


def draft_with_limit_deviation(
    read: ParsedDocument, args: Json, say: Translator, _: PartialResultCallback
) -> Json:
    """Return the edits that make a limit another, with a source that says who and why."""
    app = read.application
    which = int(args.get("which", 0))
    if which >= len(app.limits):
        problem = FileIssue(message="there is no such limit", key="which", value=str(which))
        raise InvalidFileError(read.name, (problem,))
    bounds = {key: _parsed_bound(args.get(key, ""), key, say) for key in ("normal", "maximum")}
    to = LimitDeviationRecord(
        **bounds,
        reason=replace_hidden_characters(args.get("reason", "")),
        by=replace_hidden_characters(args.get("by", "")),
        on=date.today().isoformat(),
    )
    edits = limit_deviation_file_changes(
        read.manuscript, app.limits, which, to, profile=app.profile
    )
    return {"draft": read.manuscript.with_changes(edits)}


def _parsed_bound(typed: str, key: str, say: Translator) -> float | None:
    if not typed.strip():
        return None
    try:
        return parse_localised_number(typed, decimal=say.decimal_sign)
    except ValueError as error:
        problem = FileIssue(message=str(error), key=key, value=typed[:40])
        raise InvalidFileError(key, (problem,)) from None

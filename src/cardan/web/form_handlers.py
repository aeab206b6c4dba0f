"""From a form's fields, or a pasted table, to a file: what it would say, and its verdict."""

import numpy as np

from cardan.application.form import application_text_from_form, texts_of_both_wheelbases
from cardan.application.layout_writer import layout_changes
from cardan.application.paste_import import parse_hardpoints
from cardan.approval.approval import approve_driveline
from cardan.core.errors import FileIssue, InvalidFileError
from cardan.core.units import UNITS, deg
from cardan.core.verdict import worst_first_key
from cardan.model.layout import layout_from_points
from cardan.render.i18n import Translator
from cardan.render.phrases import unevaluated_limit_lines, verdict_text
from cardan.web.parsed_document import (
    Json,
    ParsedDocument,
    PartialResultCallback,
    check_to_json,
    parse_document,
    round_decimals_list,
    round_significant,
)

PASTED_TABLE_DISPLAY_NAME = "points"
"""What a pasted table is called."""


def preview_new_application_form(
    _: ParsedDocument, args: Json, say: Translator, __: PartialResultCallback
) -> Json:
    """Return the text that a form comes to, and what it comes to where it is held to limits."""
    text = application_text_from_form(args, decimal=say.decimal_sign)
    read = parse_document(text, "form", None)
    found = approve_driveline(read.application)
    drafts = texts_of_both_wheelbases(text, args, decimal=say.decimal_sign)
    r = read.responses[0]
    return {
        "draft": drafts[0],
        **({} if len(drafts) == 1 else {"after": _changed_wheelbase(drafts[1], say)}),
        "verdict": found.verdict,
        "headline": verdict_text(found, say),
        "angles": round_decimals_list(r.joint_angles[0] / deg, 3),
        "equivalent": round_significant(float(r.kinematics.excitation.torsional.angle[0] / deg)),
        "unanswered": unevaluated_limit_lines(found, say),
        "warnings": [say.localise_numbers(say.error(p.message)) for p in read.application.warnings],
        "checks": [
            check_to_json(c, found, say) for c in sorted(found.checks, key=worst_first_key)[:8]
        ],
    }


def _changed_wheelbase(text: str, say: Translator) -> Json:
    """Return the text of an application after its wheelbase changed, and its verdict."""
    found = approve_driveline(parse_document(text, "form", None).application)
    return {
        "draft": text,
        "verdict": found.verdict,
        "headline": verdict_text(found, say),
        "checks": [
            check_to_json(c, found, say) for c in sorted(found.checks, key=worst_first_key)[:3]
        ],
    }


def edits_for_pasted_points(
    read: ParsedDocument, args: Json, _: Translator, __: PartialResultCallback
) -> Json:
    """Return the edits that put pasted points in place of those of a line.

    Raises
    ------
    InvalidFileError
        If the line does not have as many joints.
    """
    app = read.application
    of = app.lines[min(int(args.get("line", 0)), len(app.lines) - 1)]
    unit = "in" if args.get("unit") == "in" else "mm"
    rows = np.array(parse_hardpoints(args.get("points", ""), unit=unit))
    if len(rows) != of.line.joint_count:
        message = f"line {of.line.name} has {of.line.joint_count} joints"
        raise InvalidFileError(
            PASTED_TABLE_DISPLAY_NAME,
            (FileIssue(message=message, key=PASTED_TABLE_DISPLAY_NAME, value=f"{len(rows)} rows"),),
        )
    rows *= UNITS[unit]
    if args.get("axes") == "front":
        rows[:, :2] *= -1
    d = of.layout.directions
    return {
        "edits": layout_changes(
            of, layout_from_points(rows, gearbox=d[0], pinion=d[-1]), read.manuscript
        )
    }

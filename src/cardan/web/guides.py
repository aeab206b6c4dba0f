"""From a form's fields, or a pasted table, to a file: what it would say, and its verdict."""

import numpy as np

from cardan.base.errors import BadFile, Problem
from cardan.base.units import UNITS, deg
from cardan.base.verdict import badness
from cardan.files.guided import drafted
from cardan.files.pasted import hardpoints
from cardan.files.placing import placed
from cardan.model.layout import from_points
from cardan.report.language import Language
from cardan.report.wording import unanswered
from cardan.study.approval import assess
from cardan.web.document import Document, Json, Tell, document, fs, g, other

SHEET = "points"
"""What a pasted table is called."""


def guided(_: Document, args: Json, say: Language, __: Tell) -> Json:
    """Return the text that a form comes to, and what it comes to where it is held to limits."""
    text = drafted(args, decimal=say.decimal)
    read = document(text, "form", None)
    found = assess(read.application)
    r = read.responses[0]
    return {
        "draft": text,
        "verdict": found.verdict,
        "angles": fs(r.angles[0] / deg, 3),
        "equivalent": g(float(r.excitation.torsional.angle[0] / deg)),
        "unanswered": unanswered(found, say),
        "warnings": [say.spelt(say.error(p.message)) for p in read.application.warnings],
        "checks": [other(c, found, say) for c in sorted(found.checks, key=badness)[:8]],
    }


def pasted(read: Document, args: Json, _: Language, __: Tell) -> Json:
    """Return the edits that put pasted points in place of those of a line.

    Raises
    ------
    BadFile
        If the line does not have as many joints.
    """
    app = read.application
    of = app.lines[min(int(args.get("line", 0)), len(app.lines) - 1)]
    unit = "in" if args.get("unit") == "in" else "mm"
    rows = np.array(hardpoints(args.get("points", ""), unit=unit))
    if len(rows) != of.line.joint_count:
        message = f"line {of.line.name} has {of.line.joint_count} joints"
        raise BadFile(SHEET, (Problem(message=message, key=SHEET, value=f"{len(rows)} rows"),))
    rows *= UNITS[unit]
    if args.get("axes") == "front":
        rows[:, :2] *= -1
    d = of.layout.directions
    return {"edits": placed(of, from_points(rows, gearbox=d[0], pinion=d[-1]), read.manuscript)}

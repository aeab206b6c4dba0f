"""The parametric workbook: AE-7, torque, bearing loads, critical speed and life as formulas.

For users without Python: an angle, a length, a torque or a speed changed in the sheet of
inputs or of states changes every result. What needs the exact chain stands next to it as
values, marked so. Columns of states are the same in every sheet, so a formula reads down
its own column.
"""

import re
from collections.abc import Mapping
from datetime import datetime
from io import BytesIO
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np

from cardan.approval.approval import Approval
from cardan.approval.registry import study_registrations
from cardan.approval.study import DRIVELINE_STUDY_NAME, StudyResult
from cardan.checks.line_response import LineResponse
from cardan.core.labels import EvaluationCondition, Part
from cardan.core.optional_import import import_optional
from cardan.core.verdict import VERDICTS, Check, Limit, Verdict
from cardan.documents import workbook_summary as front
from cardan.documents.workbook_calculation import CalculationSheet, result_label
from cardan.documents.workbook_criteria import write_criteria_sheet
from cardan.documents.workbook_inputs import write_general_inputs, write_line_inputs
from cardan.documents.workbook_limits import LimitRow, LimitSheet, write_verdict
from cardan.documents.workbook_results import ResultsSheet
from cardan.documents.workbook_states import StatesSheet
from cardan.render.i18n import Translator
from cardan.render.phrases import verdict_texts, verdict_word
from cardan.render.xlsx import (
    NOT_COMPUTED_PLACEHOLDER,
    WorkbookWriter,
)

FIXED_CREATION_DATE = datetime(2000, 1, 1)
"""What a workbook says it was made on: when it really was is not what it is about."""


def workbook_bytes(of: Approval, *, say: Translator) -> bytes:
    """Return the workbook of an application, all its lines, as an .xlsx file.

    Raises
    ------
    MissingDependencyError
        If XlsxWriter is not installed.
    """
    xlsxwriter = import_optional("xlsxwriter")
    raw = BytesIO()
    file = xlsxwriter.Workbook(raw, {"in_memory": True})
    file.set_properties({"created": FIXED_CREATION_DATE})  # the same application, the same bytes
    book = WorkbookWriter(file, say)
    tags = dict(zip((r.line.name for r in of.line_responses), _cell_name_prefixes(of), strict=True))
    opening = front.add_empty_summary_sheet(book)
    inputs = book.add_sheet(say("Inputs"))
    top = write_general_inputs(inputs, of.application)
    for r in of.line_responses:
        write_line_inputs(inputs, r, tag=tags[r.line.name])
    judged: list[LimitSheet] = []
    texts = verdict_texts(of, say)
    for r in of.line_responses:
        end = f" {r.line.name}" if len(tags) > 1 else ""
        judged.append(_write_line_sheets(book, r, tag=tags[r.line.name], end=end, texts=texts))
    judged += [
        _write_study_sheet(book, finding, say, several=len(tags) > 1)
        for finding in of.study_results
        if finding.study != DRIVELINE_STUDY_NAME and (finding.checks or finding.unevaluated)
    ]
    write_verdict(inputs, top, judged, name="verdict", texts=texts)
    criteria = write_criteria_sheet(book, of, judged, places=front.MAX_DECIDING_CHECKS)
    front.fill_summary_sheet(opening, of, judged, criteria, texts)
    book.write_original_inputs()
    book.file.close()
    return _without_placeholders(raw.getvalue())


def _cell_name_prefixes(of: Approval) -> list[str]:
    """Return what begins the names of each line's cells; nothing where there is one line."""
    if len(of.line_responses) < 2:
        return ["" for _ in of.line_responses]
    tags: list[str] = []
    for r in of.line_responses:
        tag = re.sub(r"\W", "_", r.line.name) + "_"
        tag = tag if tag[0].isalpha() or tag[0] == "_" else f"_{tag}"
        taken = {t.casefold() for t in tags}
        tags.append(f"{tag}{len(tags) + 1}_" if tag.casefold() in taken else tag)
    return tags


def _without_placeholders(data: bytes) -> bytes:
    """Return a workbook without what stands for results that are not computed yet.

    A spreadsheet may believe the results in a file; one that is missing it computes.
    """
    out = BytesIO()
    with ZipFile(BytesIO(data)) as old, ZipFile(out, "w", ZIP_DEFLATED) as new:
        for item in old.infolist():
            content = old.read(item)
            if item.filename.startswith("xl/worksheets/sheet"):
                content = content.replace(
                    f"</f><v>{NOT_COMPUTED_PLACEHOLDER}</v>".encode(), b"</f>"
                )
                content = content.replace(b"</f><v></v>", b"</f>")
            item.date_time = (
                FIXED_CREATION_DATE.year,
                FIXED_CREATION_DATE.month,
                FIXED_CREATION_DATE.day,
                0,
                0,
                0,
            )
            new.writestr(item, content)
    return out.getvalue()


def _write_study_sheet(
    book: WorkbookWriter, of: StudyResult[Any], say: Translator, *, several: bool
) -> LimitSheet:
    """Write the limits of a study after the driveline's: all as computed."""
    title = say(study_registrations()[of.study].title)
    sheet = book.add_sheet(title)
    sheet.sheet.set_column(0, 0, 60)
    sheet.sheet.set_column(1, 3, 12)
    when = list(dict.fromkeys(c.when for c in of.checks))
    sheet.title(title, (say("As computed: what cardan found; stale once an input is changed."),))
    top = sheet.row
    sheet.row += 1
    judged = LimitSheet(sheet, [say.occasion(w) for w in when] or [""])
    judged.write_section(say("Checks, as computed"))
    rows: dict[tuple[Limit, str, Part], dict[EvaluationCondition, Check]] = {}
    for c in of.checks:
        rows.setdefault((c.limit, c.line, c.part), {})[c.when] = c
    every = np.ones(judged.count, dtype=bool)
    for (limit, line, part), found in rows.items():
        label = say.join(line if several else "", result_label(limit.quantity, part, say))
        each = [found.get(w) for w in when]
        judged.write_limit_row(
            LimitRow(
                label=label,
                limit=limit,
                values=np.array([c.value if c else np.nan for c in each]),
                validity_margin=np.array([c.validity_margin if c else np.inf for c in each]),
                may_apply=every,
                missing=~every,
                line=line,
                line_in_label=True,
            )
        )
    for u in of.unevaluated:
        label = say.join(u.line if several else "", result_label(u.quantity, u.part, say))
        nothing, first = np.full(judged.count, np.nan), np.arange(judged.count) == 0
        judged.write_limit_row(
            LimitRow(
                label=label,
                limit=u.limit,
                values=nothing,
                may_apply=every,
                missing=first,
                missing_inputs=u.missing_inputs,
                line=u.line,
                line_in_label=True,
            )
        )
    judged.write_sheet_verdict(top, "", {v: verdict_word(v, say) for v in VERDICTS})
    sheet.sheet.freeze_panes(0, 1)
    return judged


def _write_line_sheets(
    book: WorkbookWriter,
    response: LineResponse,
    *,
    tag: str,
    end: str,
    texts: Mapping[Verdict, str],
) -> LimitSheet:
    """Write states, calculation and results of a line; return the rows of limits."""
    say = book.say
    states = StatesSheet(book, response, title=say("States") + end, tag=tag)
    calculation = CalculationSheet(book, states, title=say("Calculation") + end)
    results = ResultsSheet(book, calculation, title=say("Results") + end)
    states.write()
    calculation.write()
    return results.write(texts)

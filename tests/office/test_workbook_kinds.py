"""A workbook of a line with joints of other kinds, computed anew by LibreOffice."""

import openpyxl
import pytest
from spreadsheet import recalculated

import cardan
from cardan.documents.workbook import workbook_bytes
from cardan.render.i18n import Translator

pytestmark = pytest.mark.office

TEXT = """\
title: Front line
speed_rpm: 2500
torque_Nm: 900
limits: van
driveline:
  slopes: {side_deg: [3.0, 1.0, 4.5, 2.0], top_deg: [0.0, 1.5, -0.8, 0.6]}
  joints:
    - {name: ours, kind: double cardan, peak_Nm: 2500}
    - 1410
    - {name: theirs, kind: tripod, peak_Nm: 3000}
  shafts:
    - length_mm: 1200
      tube: {outer_mm: 90, layup: [{ply: T300/5208, angle_deg: [45, -45], times: 8}]}
      phase_deg: 20
      centre_bearing: {from_rear_joint_mm: 140}
    - {length_mm: 1500, tube: 3.500x0.083in}
"""


def test_live_formulas_recalculate_to_stored_values(tmp_path):
    """Cells that the file stores a number in: AE-7's with the yokes behind what keeps the speed."""
    file, book = tmp_path / "line.yaml", tmp_path / "line.xlsx"
    file.write_text(TEXT, encoding="utf-8")
    book.write_bytes(workbook_bytes(cardan.check(cardan.read(file)), say=Translator("en")))
    formulas, stored = openpyxl.load_workbook(book), openpyxl.load_workbook(book, data_only=True)
    (anew,) = recalculated([book], tmp_path)
    held = 0
    for sheet in formulas:
        for row in sheet.iter_rows():
            for cell in row:
                was = stored[sheet.title][cell.coordinate].value
                if str(cell.value).startswith("=") and isinstance(was, int | float):
                    now = anew.book[sheet.title][cell.coordinate].value
                    assert now == pytest.approx(was, rel=1e-6, abs=1e-9), (sheet.title, cell)
                    held += 1
    assert held > 100

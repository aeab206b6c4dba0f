"""A spreadsheet that recomputes: changes go in by name, numbers come out by name.

LibreOffice is told to compute every formula anew when it loads a file; without that it
would echo the values the file came with.
"""

import shutil
import subprocess
from pathlib import Path

import openpyxl

HARD_RECALCULATION = """<?xml version="1.0" encoding="UTF-8"?>
<oor:items xmlns:oor="http://openoffice.org/2001/registry"
 xmlns:xs="http://www.w3.org/2001/XMLSchema" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
<item oor:path="/org.openoffice.Office.Calc/Formula/Load"><prop oor:name="OOXMLRecalcMode"
 oor:op="fuse"><value>0</value></prop></item>
</oor:items>
"""


class Sheet:
    """A workbook whose cells are found by their names."""

    def __init__(self, path: Path, *, values: bool, written: Path | None = None) -> None:
        self.path, self.written = path, written or path
        self.book = openpyxl.load_workbook(path, data_only=values)

    def cells(self, name: str) -> list:
        """Return the cells of a name."""
        ((sheet, place),) = self.book.defined_names[name].destinations
        found = self.book[sheet][place.replace("$", "")]
        return list(found[0]) if isinstance(found, tuple) else [found]

    def numbers(self, name: str) -> list:
        """Return the values of the cells of a name."""
        return [c.value for c in self.cells(name)]

    def change(self, name: str, values: list) -> None:
        """Type values into the cells of a name, None leaves one as it is."""
        for cell, value in zip(self.cells(name), values, strict=True):
            if value is not None:
                cell.value = value


def recalculated(books: list[Path], folder: Path) -> list[Sheet]:
    """Return workbooks as LibreOffice computes them, all in one run of it."""
    office = shutil.which("soffice") or shutil.which("libreoffice")
    assert office, "LibreOffice is not installed"
    profile, out = folder / "profile", folder / "recalculated"
    (profile / "user").mkdir(parents=True, exist_ok=True)
    (profile / "user" / "registrymodifications.xcu").write_text(HARD_RECALCULATION)
    subprocess.run(
        [office, f"-env:UserInstallation={profile.as_uri()}", "--headless", "--norestore",
         "--convert-to", "xlsx", "--outdir", str(out), *map(str, books)],
        check=True, capture_output=True, timeout=900,
    )  # fmt: skip
    return [Sheet(out / b.name, values=True, written=b) for b in books]

"""Make the gallery: every example's report in three languages, as small pictures.

    python docs/reports/make.py [EXAMPLE...]

Needs the extra `report` and Pillow. Verdict, drawings and plots of each report stand side
by side; the whole gallery stays under 2.1 MB.
"""

import sys
from dataclasses import replace
from hashlib import sha256
from io import BytesIO
from pathlib import Path

from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[1]))

from picture_numbers import record_numbers

from cardan.application import reader
from cardan.approval.approval import approve_driveline
from cardan.documents import approval_report as story
from cardan.render.i18n import LANGUAGE_CODES, Translator
from cardan.render.pdf import page_images
from cardan.topics.design.corrections import find_corrections
from cardan.topics.design.sensitivity import check_sensitivities

HERE = Path(__file__).parent
EXAMPLES = sorted((HERE.parents[1] / "examples").glob("*.yaml"))
PPI = 66
COLOURS = 64
MOST = 2_200_000
"""Bytes that all pictures may take."""


def picture(of: story.ReportDocument) -> Image.Image:
    """Return the first page of a report beside its drawings and its plots."""
    wanted = [c for c in of.chapters[1:] if any(isinstance(b, story.Figures) for b in c.blocks)][:2]
    sheets = [
        page_images(of, ppi=PPI)[0],
        *(page_images(_only(of, [c]), ppi=PPI)[0] for c in wanted),
    ]
    images = [Image.open(BytesIO(s)).convert("RGB") for s in sheets]
    wide, high = sum(i.width for i in images), max(i.height for i in images)
    whole = Image.new("RGB", (wide, high), "white")
    x = 0
    for image in images:
        whole.paste(image, (x, 0))
        x += image.width
    return whole.quantize(COLOURS)


def _only(of: story.ReportDocument, chapters: list[story.Chapter]) -> story.ReportDocument:
    """Return a story of some of its chapters."""
    return replace(of, chapters=tuple(chapters), facts=())


def main() -> None:
    """Write the pictures."""
    chosen = sys.argv[1:]
    for path in (e for e in EXAMPLES if not chosen or e.stem in chosen):
        found = approve_driveline(reader.read(path))
        helps, fixes = check_sensitivities(found), find_corrections(found.application, count=2)
        for code in LANGUAGE_CODES:
            told = story.approval_report_from_results(
                found, helps=helps, fixes=fixes, say=Translator(code),
                issue=story.ReportDateAndSourceStamp(date="2026-11-20", file_names=(path.name,),
                                  fingerprints=(sha256(path.read_bytes()).hexdigest()[:16],)),
            )  # fmt: skip
            out = HERE / f"{path.stem}.{code}.png"
            picture(told).save(out, optimize=True)
            print(f"{out.name}: {out.stat().st_size / 1e3:.0f} kB")
        record_numbers(f"reports/{path.stem}.*.png", path.stem, found)
    total = sum(picture.stat().st_size for picture in HERE.glob("*.png"))
    assert total < MOST, f"the gallery takes {total / 1e6:.2f} MB"


if __name__ == "__main__":
    main()

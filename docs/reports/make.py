"""Make the gallery: every example's report in three languages, as small pictures.

    python docs/reports/make.py [EXAMPLE...]

Needs the extra `report` and Pillow. Verdict, drawings and plots of each report stand side
by side; the whole gallery stays under 2 MB.
"""

import sys
from dataclasses import replace
from hashlib import sha256
from io import BytesIO
from pathlib import Path

from PIL import Image

from cardan import files
from cardan.report import story
from cardan.report.language import CODES, Language
from cardan.report.pdf import pages
from cardan.study.approval import assess
from cardan.study.fix import fix
from cardan.study.sensitivity import sensitivities

HERE = Path(__file__).parent
EXAMPLES = sorted((HERE.parents[1] / "examples").glob("*.yaml"))
PPI = 66
COLOURS = 64
MOST = 2_000_000
"""Bytes that all pictures may take."""


def picture(of: story.Story) -> Image.Image:
    """Return the first page of a report beside its drawings and its plots."""
    wanted = [c for c in of.chapters if any(isinstance(b, story.Figures) for b in c.blocks)][:2]
    sheets = [pages(of, ppi=PPI)[0], *(pages(_only(of, [c]), ppi=PPI)[0] for c in wanted)]
    images = [Image.open(BytesIO(s)).convert("RGB") for s in sheets]
    wide, high = sum(i.width for i in images), max(i.height for i in images)
    whole = Image.new("RGB", (wide, high), "white")
    x = 0
    for image in images:
        whole.paste(image, (x, 0))
        x += image.width
    return whole.quantize(COLOURS)


def _only(of: story.Story, chapters: list[story.Chapter]) -> story.Story:
    """Return a story of some of its chapters."""
    return replace(of, chapters=tuple(chapters), facts=())


def main() -> None:
    """Write the pictures."""
    chosen = sys.argv[1:]
    for path in (e for e in EXAMPLES if not chosen or e.stem in chosen):
        found = assess(files.read(path))
        helps, fixes = sensitivities(found), fix(found.application, count=2)
        for code in CODES:
            told = story.approval(
                found, helps=helps, fixes=fixes, say=Language(code),
                issue=story.Issue(date="2026-11-20", files=(path.name,),
                                  prints=(sha256(path.read_bytes()).hexdigest()[:16],)),
            )  # fmt: skip
            out = HERE / f"{path.stem}.{code}.png"
            picture(told).save(out, optimize=True)
            print(f"{out.name}: {out.stat().st_size / 1e3:.0f} kB")
    total = sum(picture.stat().st_size for picture in HERE.glob("*.png"))
    assert total < MOST, f"the gallery takes {total / 1e6:.2f} MB"


if __name__ == "__main__":
    main()

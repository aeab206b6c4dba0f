"""What a chapter of a report says, as the page shows it: tables, texts, figures."""

from collections.abc import Iterable

from cardan.render.blocks import Block, BulletList, Figures, Table, Text
from cardan.web.parsed_document import Json


def report_blocks_to_messages(blocks: Iterable[Block]) -> list[Json]:
    """Return the blocks that a page can show; pictures it draws itself."""
    found: list[Json] = []
    for b in blocks:
        match b:
            case Table():
                found.append({
                    "kind": "table", "caption": b.caption, "head": b.head, "rows": b.rows,
                    "grades": b.grades, "words": b.words,
                })  # fmt: skip
            case Text():
                found.append({"kind": "text", "paragraphs": b.paragraphs})
            case BulletList():
                every = [say for point, more in b.points for say in (point, *more)]
                found.append({"kind": "text", "paragraphs": every})
            case Figures():
                found += [
                    {"kind": "figure", "title": f.title, "svg": f.svg, "alt": f.alt, "note": f.note}
                    for f in b.figures
                ]
            case _:
                pass
    return found

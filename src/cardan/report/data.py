"""What data an approval stands on, and how each row was read: terminal and reports."""

from collections.abc import Iterator

from cardan.base.part import Part
from cardan.report.blocks import Block, Table
from cardan.report.language import Language
from cardan.report.wording import cited, how_read
from cardan.study.approval import Approval
from cardan.study.data import Datum


def named(of: Datum, say: Language, *, several: bool) -> str:
    """Return a row by its name, and what of the line is of it."""
    kind = "joint" if of.kind == "joint" else "shaft"
    parts = say.list(*(say.part(Part(kind, number)) for number in of.parts))
    name = f"{say(of.kind)} {of.name} ({parts})"
    return f"{of.line}: {name}" if several else name


def lines(of: Approval, say: Language) -> Iterator[str]:
    """Yield a line for each row, without its source; nothing of an application of none."""
    several = len(of.application.lines) > 1
    for datum in of.data:
        read = how_read(datum.source, say) or say("nobody says how it was read")
        yield f"{named(datum, say, several=several)}: {read}"


def blocks(of: Approval, say: Language) -> Iterator[Block]:
    """Yield the table of all rows, with source and note."""
    if not of.data:
        return
    several = len(of.application.lines) > 1
    yield Table(
        caption=say("Data it stands on, and how it was read"),
        head=(say("data"), say("source"), say("note")),
        rows=tuple(
            (named(d, say, several=several), cited(d.source, say), say.given(d.note))
            for d in of.data
        ),
        words=3,
    )

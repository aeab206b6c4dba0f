"""What data an approval stands on, and how each row was read: terminal and reports."""

from collections.abc import Iterator

from cardan.approval.approval import Approval
from cardan.approval.data_provenance import CatalogueDatum
from cardan.core.labels import Part
from cardan.render.blocks import Block, Table
from cardan.render.i18n import Translator
from cardan.render.phrases import citation, source_digitisation_phrase


def catalogue_input_title(of: CatalogueDatum, say: Translator, *, several: bool) -> str:
    """Return a row by its name, and what of the line is of it."""
    parts = say.join(*(say.part(Part(of.part_kind, number)) for number in of.part_numbers))
    name = f"{say(of.kind)} {of.name} ({parts})"
    return f"{of.line}: {name}" if several else name


def text_lines(of: Approval, say: Translator) -> Iterator[str]:
    """Yield a line for each row, without its source; nothing of an application of none."""
    several = len(of.application.lines) > 1
    for datum in of.catalogue_data:
        read = source_digitisation_phrase(datum.source, say) or say("how it was read is not stated")
        yield f"{catalogue_input_title(datum, say, several=several)}: {read}"


def report_blocks(of: Approval, say: Translator) -> Iterator[Block]:
    """Yield the table of all rows, with source and note."""
    if not of.catalogue_data:
        return
    several = len(of.application.lines) > 1
    yield Table(
        caption=say("Data it stands on, and how it was read"),
        head=(say("data"), say("source"), say("note")),
        rows=tuple(
            (
                catalogue_input_title(d, say, several=several),
                citation(d.source, say),
                say.translate_if_known(d.note),
            )
            for d in of.catalogue_data
        ),
        words=3,
    )

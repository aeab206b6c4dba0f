"""How the numbers of a row were read: one word for all, and for those that differ."""

from dataclasses import replace
from typing import Annotated, TypeAlias

from cardan.core.provenance import PROVENANCE_CODES, Source
from cardan.schema.field_types import MAX_PROSE_CHARACTERS, TextField
from cardan.schema.node_reader import NodeReader, nearest_name_hint


class _ProvenanceCodeField(TextField):
    """A word of `PROVENANCE_CODES`, and after it what was read otherwise."""

    singular = f"{', '.join(PROVENANCE_CODES[:-1])} or {PROVENANCE_CODES[-1]}"

    def __init__(self) -> None:
        super().__init__(MAX_PROSE_CHARACTERS)

    def read(self, here: NodeReader) -> tuple[str, tuple[tuple[str, str], ...]]:
        """Return the word for all, and the words of the values that differ."""
        first, *others = (part.strip() for part in self.read_text_value(here).split(";"))
        found: list[tuple[str, str]] = []
        for part in others:
            names, _, word = part.rpartition(":")
            if not names:
                self.reject(here, "write what differs as `normal: assumed`, behind a semicolon")
            found += ((name.strip(), self._word(word.strip(), here)) for name in names.split(","))
        return self._word(first, here), tuple(found)

    def _word(self, word: str, here: NodeReader) -> str:
        if word not in PROVENANCE_CODES:
            self.reject(here, nearest_name_hint(word, PROVENANCE_CODES))
        return word


ProvenanceCode: TypeAlias = Annotated[
    tuple[str, tuple[tuple[str, str], ...]], _ProvenanceCodeField()
]
"""`second hand`, or `second hand; n_beta_max, speed_max: re-read`."""


def with_provenance_code(
    source: Source, read: tuple[str, tuple[tuple[str, str], ...]] | None
) -> Source:
    """Return a source with how its numbers were read, if given."""
    return source if read is None else replace(source, how_read=read[0], apart=read[1])

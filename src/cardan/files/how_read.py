"""How the numbers of a row were read: one word for all, and for those that differ."""

from dataclasses import replace
from typing import Annotated, TypeAlias

from cardan.base.source import HOW_READ, Source
from cardan.border.table import PROSE, Here, Text, nearest


class _HowRead(Text):
    """A word of `HOW_READ`, and after it what was read otherwise."""

    one = f"{', '.join(HOW_READ[:-1])} or {HOW_READ[-1]}"

    def __init__(self) -> None:
        super().__init__(PROSE)

    def read(self, here: Here) -> tuple[str, tuple[tuple[str, str], ...]]:
        """Return the word for all, and the words of the values that differ."""
        first, *others = (part.strip() for part in self.text(here).split(";"))
        found: list[tuple[str, str]] = []
        for part in others:
            names, _, word = part.rpartition(":")
            if not names:
                self.refuse(here, "write what differs as `normal: assumed`, behind a semicolon")
            found += ((name.strip(), self._word(word.strip(), here)) for name in names.split(","))
        return self._word(first, here), tuple(found)

    def _word(self, word: str, here: Here) -> str:
        if word not in HOW_READ:
            self.refuse(here, nearest(word, HOW_READ))
        return word


HowRead: TypeAlias = Annotated[tuple[str, tuple[tuple[str, str], ...]], _HowRead()]
"""`second hand`, or `second hand; n_beta_max, speed_max: re-read`."""


def with_reading(source: Source, read: tuple[str, tuple[tuple[str, str], ...]] | None) -> Source:
    """Return a source with how its numbers were read, where somebody said."""
    return source if read is None else replace(source, how_read=read[0], apart=read[1])

"""What a report is made of, before any medium shapes it: chapters of texts, tables, figures."""

from collections.abc import Iterator
from dataclasses import field
from typing import TYPE_CHECKING, TypeAlias

from cardan.core.lazy_dataclass import dataclass
from cardan.core.version import __version__

if TYPE_CHECKING:
    from cardan.render.svg import Figure


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table: the first `words` columns are text, the others numbers.

    `grades` colours cells, "" leaves one plain.
    """

    caption: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    words: int = 1
    grades: tuple[tuple[str, ...], ...] = ()
    blank: bool = False


@dataclass(frozen=True, kw_only=True)
class Text:
    """Paragraphs."""

    paragraphs: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class BulletList:
    """Points, each with what follows from it."""

    points: tuple[tuple[str, tuple[str, ...]], ...]
    caption: str = ""


@dataclass(frozen=True, kw_only=True)
class Figures:
    """Figures that stand together; wide ones one below the other.

    On paper none is taller than `max_height_mm`, if that is given.
    """

    figures: "tuple[Figure, ...]"
    wide: bool = False
    max_height_mm: float | None = None


@dataclass(frozen=True, kw_only=True)
class CodeBlock:
    """A text to show as it is."""

    caption: str
    text: str


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A picture in pixels, and what a page that can move shows under it."""

    title: str
    png: bytes
    alt: str
    note: str = ""
    scene: str = ""
    """A fragment of HTML; a document on paper leaves it out."""


Block: TypeAlias = Table | Text | BulletList | Figures | Picture | CodeBlock


@dataclass(frozen=True, kw_only=True)
class Chapter:
    """A heading and what stands under it."""

    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True, kw_only=True)
class ReportDateAndSourceStamp:
    """What says which report this is: the day, the file and what it held."""

    date: str = ""
    file_names: tuple[str, ...] = ()
    fingerprints: tuple[str, ...] = ()
    """The first figures of each file's SHA-256."""
    file_texts: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class ReportDocument:
    """A whole report."""

    language: str
    title: str
    subtitle: str
    grade: str
    verdict: str
    facts: tuple[tuple[str, str], ...]
    chapters: tuple[Chapter, ...]
    is_sheet: bool = False
    """Whether the first chapter is a sheet to sign, with a page for itself."""
    summary: str = ""
    """Line of text next to the verdict."""
    date: str = ""
    version: str = field(default=__version__)


def all_figures(of: ReportDocument) -> "Iterator[Figure]":
    """Yield every figure of a story, in order."""
    for chapter in of.chapters:
        for block in chapter.blocks:
            if isinstance(block, Figures):
                yield from block.figures

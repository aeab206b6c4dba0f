"""What a report is made of, before any medium shapes it: chapters of texts, tables, figures."""

from collections.abc import Iterator
from dataclasses import field
from typing import TYPE_CHECKING, TypeAlias

from cardan import __version__
from cardan.base.frozen import dataclass

if TYPE_CHECKING:
    from cardan.report.svg import Figure


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table: the first `words` columns are text, the others numbers.

    `grades` colours cells, "" leaves one plain; `row_heads` says whether the first column
    names its row.
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
class Points:
    """Points, each with what follows from it."""

    points: tuple[tuple[str, tuple[str, ...]], ...]
    caption: str = ""


@dataclass(frozen=True, kw_only=True)
class Figures:
    """Figures that stand together; wide ones one below the other."""

    figures: "tuple[Figure, ...]"
    wide: bool = False


@dataclass(frozen=True, kw_only=True)
class Verbatim:
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


Block: TypeAlias = Table | Text | Points | Figures | Picture | Verbatim


@dataclass(frozen=True, kw_only=True)
class Chapter:
    """A heading and what stands under it."""

    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True, kw_only=True)
class Issue:
    """What says which report this is: the day, the file and what it held."""

    date: str = ""
    files: tuple[str, ...] = ()
    prints: tuple[str, ...] = ()
    """The first figures of each file's SHA-256."""
    texts: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Story:
    """A whole report."""

    language: str
    title: str
    subtitle: str
    grade: str
    verdict: str
    facts: tuple[tuple[str, str], ...]
    chapters: tuple[Chapter, ...]
    summary: str = ""
    """What stands beside the verdict, in a line."""
    date: str = ""
    version: str = field(default=__version__)


def figures(of: Story) -> "Iterator[Figure]":
    """Yield every figure of a story, in order."""
    for chapter in of.chapters:
        for block in chapter.blocks:
            if isinstance(block, Figures):
                yield from block.figures

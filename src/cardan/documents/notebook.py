"""What a notebook shows: parts of a story as a fragment of HTML that needs nothing else.

One rule keeps it safe: what is not `Markup` is text, and text is escaped.
"""

from collections.abc import Callable, Iterable
from html import escape
from pathlib import Path

from cardan.approval.approval import Approval
from cardan.checks.line_response import LineResponse
from cardan.core.errors import CardanError
from cardan.core.lazy_dataclass import dataclass
from cardan.documents.approval_report import verdict_report_blocks
from cardan.documents.line_drawing import (
    joint_plane_drawing,
    phasor_drawing,
    side_or_top_view_drawing,
    yoke_phasing_drawing,
)
from cardan.render.blocks import Block, BulletList, Chapter, Figures, Table, Text
from cardan.render.fonts import truncate
from cardan.render.html import VERDICT_SYMBOLS
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.phrases import approval_counts_text, is_partial_approval, verdict_text
from cardan.render.svg import VERDICT_COLOURS, AttributeValue, Figure, svg_element
from cardan.schema.atomic_write import write_atomically

PAPER_STYLE = "background:#fff"
"""What figures and grades stand on: their colours are those of print, the notebook may be dark."""

VERDICT_STYLES = {
    k: f"color:{v};{PAPER_STYLE}" for k, v in {**VERDICT_COLOURS, "incomplete": "#6639ba"}.items()
}
MAX_TITLE_CHARACTERS = 200
"""Characters of a title that have room."""

LINE_VIEWS: dict[str, Callable[[LineResponse], Figure]] = {
    "side": lambda r: side_or_top_view_drawing(r, ENGLISH, name="side"),
    "top": lambda r: side_or_top_view_drawing(r, ENGLISH, name="top"),
    "yokes": lambda r: yoke_phasing_drawing(r, ENGLISH),
    "planes": lambda r: joint_plane_drawing(r, ENGLISH),
    "phasors": lambda r: phasor_drawing(r, ENGLISH),
}
"""Drawings of a line by name, as reports have them."""


class Markup(str):
    """HTML that is finished: everything in it is escaped that has to be."""

    __slots__ = ()


def html_element(name: str, *inside: str, **attributes: AttributeValue) -> Markup:
    """Return an element around texts, which are escaped, and markup, which is not.

    >>> str(html_element("b", "1 < 2", html_element("i", "&")))
    '<b>1 &lt; 2<i>&amp;</i></b>'
    """
    safe = [i if isinstance(i, Markup) else escape(i) for i in inside]
    return Markup(svg_element(name, *(safe or [""]), **attributes))


def approval_html(of: Approval, say: Translator) -> Markup:
    """Return the verdict, each line from its side, each limit where it is worst, and notes."""
    grade = "warn" if is_partial_approval(of) and of.verdict == "pass" else of.verdict
    said = f"{VERDICT_SYMBOLS[grade]} {verdict_text(of, say)}"
    return html_element(
        "div",
        html_element(
            "p",
            html_element("strong", truncate(of.application.title, MAX_TITLE_CHARACTERS)),
            ": ",
            html_element("strong", said, style=VERDICT_STYLES[grade]),
            f" ({approval_counts_text(of, say)}; "
            f"{say('limits: {profile}', profile=of.application.profile)})",
        ),
        *(_figure(side_or_top_view_drawing(r, say, name="side").svg) for r in of.line_responses),
        report_blocks_html(verdict_report_blocks(of, say)),
    )


def report_blocks_html(of: Iterable[Block]) -> Markup:
    """Return texts, points and tables of a story one below the other."""
    return html_element("div", *(part for block in of for part in _block(block)))


def chapters_html(of: Iterable[Chapter]) -> Markup:
    """Return chapters of a story one below the other."""
    return html_element("div", *(report_blocks_html(chapter.blocks) for chapter in of))


def _figure(svg: str) -> Markup:
    return html_element("div", Markup(svg), style=PAPER_STYLE)


@dataclass(frozen=True, kw_only=True)
class Drawing(Figure):
    """A drawing that shows itself in a notebook and saves itself as SVG."""

    def __repr__(self) -> str:
        return f'{self.title} ({len(self.svg) // 1000 + 1} kB of SVG; .save("view.svg"))'

    def _repr_html_(self) -> str:
        return _figure(self.svg)

    def save(self, path: str | Path, *, replace: bool = False) -> Path:
        """Write the drawing into an SVG file and return its path.

        Raises
        ------
        CardanError
            If the name does not end in .svg, or the file exists and `replace` is False.
        """
        if Path(path).suffix.lower() != ".svg":
            msg = f"a drawing ends in .svg; got {Path(path).name}"
            raise CardanError(msg)
        return write_atomically(path, self.svg, replace=replace)


def line_drawing(of: LineResponse, view: str) -> Drawing:
    """Return a view of a line: side, top, yokes, planes or phasors."""
    found = LINE_VIEWS[view](of)
    return Drawing(title=found.title, svg=found.svg, alt=found.alt, note=found.note)


def preformatted_html(said: str) -> Markup:
    """Return a text of a terminal as it stands."""
    return html_element("pre", said)


def _block(of: Block) -> Iterable[Markup]:
    match of:
        case Text():
            yield from (html_element("p", paragraph) for paragraph in of.paragraphs)
        case BulletList():
            yield html_element("p", html_element("strong", of.caption))
            yield html_element(
                "ul",
                *(
                    html_element("li", point, *(html_element("div", f) for f in follows))
                    for point, follows in of.points
                ),
                style="list-style:none",
            )
        case Table():
            yield _table(of)
        case Figures():
            yield from (_figure(f.svg) for f in of.figures)
        case _:
            return


def _table(of: Table) -> Markup:
    def cell(name: str, said: str, k: int, grade: str = "") -> Markup:
        style = "text-align:" + ("left" if k < of.words else "right;white-space:nowrap")
        return html_element(
            name, said, style=style + (f";{VERDICT_STYLES[grade]}" if grade else "")
        )

    graded = of.grades or (("",) * len(of.head),) * len(of.rows)
    return html_element(
        "table",
        html_element("caption", of.caption),
        html_element(
            "thead", html_element("tr", *(cell("th", h, k) for k, h in enumerate(of.head)))
        ),
        html_element(
            "tbody",
            *(
                html_element(
                    "tr",
                    *(
                        cell("td", said, k, grade)
                        for k, (said, grade) in enumerate(zip(row, grades, strict=True))
                    ),
                )
                for row, grades in zip(of.rows, graded, strict=True)
            ),
        ),
    )

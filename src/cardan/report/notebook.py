"""What a notebook shows: parts of a story as a fragment of HTML that needs nothing else.

One rule keeps it safe: what is not `Markup` is text, and text is escaped.
"""

from collections.abc import Iterable
from html import escape

from cardan.report.blocks import Block, Chapter, Figures, Points, Table, Text
from cardan.report.drawing import view
from cardan.report.html import MARKS
from cardan.report.language import Language
from cardan.report.paper import shortened
from cardan.report.story import verdict
from cardan.report.svg import GRADED, Value, element
from cardan.report.wording import counts
from cardan.study.approval import Approval

PAPER = "background:#fff"
"""What figures and grades stand on: their colours are those of print, the notebook may be dark."""

COLOURS = {k: f"color:{v};{PAPER}" for k, v in {**GRADED, "incomplete": "#6639ba"}.items()}
TITLE = 200
"""Characters of a title that have room."""


class Markup(str):
    """HTML that is finished: everything in it is escaped that has to be."""

    __slots__ = ()


def tag(name: str, *inside: str, **attributes: Value) -> Markup:
    """Return an element around texts, which are escaped, and markup, which is not.

    >>> tag("b", "1 < 2", tag("i", "&"))
    '<b>1 &lt; 2<i>&amp;</i></b>'
    """
    safe = [i if isinstance(i, Markup) else escape(i) for i in inside]
    return Markup(element(name, *(safe or [""]), **attributes))


def approval(of: Approval, say: Language) -> Markup:
    """Return the verdict, each line from its side, each limit where it is worst, and notes."""
    grade = of.verdict
    said = f"{MARKS[grade]} {say(grade).upper()}"
    return tag(
        "div",
        tag(
            "p",
            tag("strong", shortened(of.application.title, TITLE)),
            ": ",
            tag("strong", said, style=COLOURS[grade]),
            f" ({counts(of, say)}; {say('limits: {profile}', profile=of.application.profile)})",
        ),
        *(_figure(view(r, say, name="side").svg) for r in of.responses),
        blocks(verdict(of, say)),
    )


def blocks(of: Iterable[Block]) -> Markup:
    """Return texts, points and tables of a story one below the other."""
    return tag("div", *(part for block in of for part in _block(block)))


def chapters(of: Iterable[Chapter]) -> Markup:
    """Return chapters of a story one below the other."""
    return tag("div", *(blocks(chapter.blocks) for chapter in of))


def _figure(svg: str) -> Markup:
    return tag("div", Markup(svg), style=PAPER)


def text(said: str) -> Markup:
    """Return a text of a terminal as it stands."""
    return tag("pre", said)


def _block(of: Block) -> Iterable[Markup]:
    match of:
        case Text():
            yield from (tag("p", paragraph) for paragraph in of.paragraphs)
        case Points():
            yield tag("p", tag("strong", of.caption))
            yield tag(
                "ul",
                *(
                    tag("li", point, *(tag("div", f) for f in follows))
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
        return tag(name, said, style=style + (f";{COLOURS[grade]}" if grade else ""))

    graded = of.grades or (("",) * len(of.head),) * len(of.rows)
    return tag(
        "table",
        tag("caption", of.caption),
        tag("thead", tag("tr", *(cell("th", h, k) for k, h in enumerate(of.head)))),
        tag(
            "tbody",
            *(
                tag(
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

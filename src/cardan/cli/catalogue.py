"""`cardan catalogue`: what is on the shelves, and what of it carries a torque."""

from pathlib import Path
from typing import Any

import click

from cardan.base.units import UNITS
from cardan.cli.common import JSON, LANG, POSITIVE, claim, put_lines, write_json
from cardan.cli.ending import Once, kindly, refuse


class Measure(click.ParamType[float]):
    """A number with its unit, the first of these where none is written."""

    name = "number"

    def __init__(self, *units: str) -> None:
        self.units = {u.replace("_", "/"): UNITS[u] for u in units}

    def convert(self, value: Any, param: Any, ctx: Any) -> float:
        """Return the number, SI."""
        import re

        if isinstance(value, float):
            return value
        text = str(value).strip().replace("·", "").replace(" ", "")
        found = re.fullmatch(r"([0-9]+(?:[.,][0-9]+)?)([A-Za-z°/\-]*)", text)
        named = found[2].replace("°", "deg").replace("-", "") if found else ""
        known = {u.casefold(): worth for u, worth in self.units.items()}
        worth = known.get(named.casefold(), next(iter(known.values())) if not named else None)
        if found is None or worth is None:
            like = " or ".join(f"12{u}" for u in self.units)
            self.fail(f"{value} is no number with one of these units: {like}", param, ctx)
        return float(found[1].replace(",", ".")) * worth


@click.command(cls=Once)
@click.argument("shelf", required=False, metavar="[KIND]")
@click.argument("words", nargs=-1, metavar="[NAME]...")
@click.option(
    "--for",
    "torque",
    type=Measure("Nm", "kNm", "lbft"),
    metavar="TORQUE",
    help="Joints and tubes that carry it, shocks included, smallest first: 1200Nm, 900lbft.",
)
@click.option("--speed", type=Measure("rpm", "rad_s"), metavar="SPEED", help="That it turns at.")
@click.option("--angle", type=Measure("deg", "rad"), metavar="ANGLE", help="Of a joint.")
@click.option("--hours", type=POSITIVE, help="That a joint shall live under it.")
@click.option(
    "--length", type=Measure("mm", "m", "in"), metavar="LENGTH", help="Of a tube that turns."
)
@click.option(
    "--prime-mover",
    type=click.Choice(["electric", "petrol", "diesel"]),
    default="electric",
    show_default=True,
    help="That drives a joint, for its life.",
)
@click.option(
    "--count", type=click.IntRange(1), default=12, show_default=True, help="Of what fits, at most."
)
@click.option(
    "--file",
    type=click.Path(dir_okay=False, path_type=Path),
    help="An application whose own catalogues count too.",
)
@JSON
@LANG
@kindly
def catalogue(
    shelf: str | None,
    words: tuple[str, ...],
    *,
    torque: float | None,
    speed: float | None,
    angle: float | None,
    hours: float | None,
    length: float | None,
    prime_mover: str,
    count: int,
    file: Path | None,
    json_out: str | None,
    lang: str,
) -> None:
    """List what is on a shelf, or what of it carries a torque, with source and how it was read.

    KIND is joints, tubes, materials, plies, details, metals, tyres, bearings, limits, torsion
    or typical; without one they are counted. NAME leaves the rows that it is a part of; of one
    row everything is shown. A star says that some of a row's values were read otherwise.
    """
    from cardan.files.shelf import SHELVES
    from cardan.files.shelf import shelf as rows_of
    from cardan.report import shelf as told
    from cardan.report.language import Language

    say = Language(lang)
    claim(file, json_out=json_out)
    own = _own(file)
    if shelf is None:
        put_lines(told.shelves({name: len(rows_of(name, own)) for name in SHELVES}, say))
        return
    name = _meant(shelf, tuple(SHELVES))
    rows = _named(rows_of(name, own), words, name)
    if torque is None:
        if any(x is not None for x in (speed, angle, hours, length)):
            refuse("--speed, --angle, --hours and --length go with --for, a torque")
        if json_out is not None:
            write_json(told.document(rows), json_out)
        if json_out != "-":
            put_lines(told.card(rows[0], say) if len(rows) == 1 else told.lines(rows, say))
        return
    if name not in ("joints", "tubes"):
        refuse(f"--for asks joints and tubes what they carry; {name} carry no torque")
    from cardan.base.units import hour
    from cardan.shaft.life import PRIME_MOVER_FACTORS
    from cardan.study.selection import Asked, fits

    asked = Asked(
        torque=torque,
        speed=speed,
        angle=angle,
        life=None if hours is None else hours * hour,
        prime_mover_factor=PRIME_MOVER_FACTORS[prime_mover],
        length=length,
    )
    if hours is not None and not asked.whole:
        refuse("--hours needs --speed and --angle: a life is one of turning and swinging")
    found = fits(rows, asked)
    if json_out is not None:
        write_json(told.document(found), json_out)
    if json_out != "-":
        put_lines(told.fitting(found, asked, count, say))


def _own(file: Path | None) -> Any:
    """Return the catalogues that an application's file brings along."""
    if file is None:
        return None
    from cardan import files
    from cardan.files.application import catalogue_of

    return catalogue_of(files.read(file))


def _meant(word: str, names: tuple[str, ...]) -> str:
    """Return the shelf that is meant: one joint is of the joints."""
    from cardan.border.table import nearest

    same = [name for name in names if word.casefold() in (name, name.removesuffix("s"))]
    if not same:
        refuse(f"there is no catalogue of {word}; {nearest(word, names)}")
    return same[0]


def _named(rows: Any, words: tuple[str, ...], shelf: str) -> Any:
    """Return the row of a name, or else those that all words are found in."""
    from cardan.border.table import nearest

    asked = " ".join(words).casefold()
    exact = [r for r in rows if r.name.casefold().replace(" ", "") == asked.replace(" ", "")]
    if exact and words:
        return exact
    kept = [
        r for r in rows
        if all(w.casefold() in " ".join((r.name, *r.cells.values())).casefold() for w in words)
    ]  # fmt: skip
    if not kept:
        advice = nearest(" ".join(words), [r.name for r in rows])
        refuse(f"no row of {shelf} is called or says {' '.join(words)}; {advice}")
    return kept

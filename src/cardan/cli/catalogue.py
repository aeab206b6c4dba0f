"""`cardan catalogue`: parts of each kind, and which of them carry a torque."""

from pathlib import Path
from typing import Any

import click

from cardan.cli.common import (
    JSON_OPTION,
    LANG_OPTION,
    POSITIVE_FLOAT,
    echo_lines,
    validate_output_paths,
    write_json,
)
from cardan.cli.exit_codes import (
    NoRepeatedOptionCommand,
    exit_with_code_2_on_known_errors,
    raise_command_error,
)
from cardan.core.units import UNITS


class QuantityParam(click.ParamType[float]):
    """A number with its unit, the first of these where none is written."""

    name = "number"

    def __init__(self, *units: str) -> None:
        self.units = {u.replace("_", "/"): UNITS[u] for u in units}

    def convert(self, value: Any, param: Any, ctx: Any) -> float:
        """Return the number, SI."""
        import re

        from cardan.schema.quantity_parser import parse_marked_angle

        if isinstance(value, float):
            return value
        if "deg" in self.units and (angle := parse_marked_angle(str(value))) is not None:
            return angle * UNITS["deg"]
        text = str(value).strip().replace("·", "").replace(" ", "")
        found = re.fullmatch(r"([0-9]+(?:[.,][0-9]+)?)([A-Za-z°/\-]*)", text)
        named = found[2].replace("°", "deg").replace("-", "") if found else ""
        known = {u.casefold(): worth for u, worth in self.units.items()}
        worth = known.get(named.casefold(), next(iter(known.values())) if not named else None)
        if found is None or worth is None:
            like = " or ".join(f"12{u}" for u in self.units)
            self.fail(f"{value} is no number with one of these units: {like}", param, ctx)
        return float(found[1].replace(",", ".")) * worth


@click.command(cls=NoRepeatedOptionCommand)
@click.argument("shelf", required=False, metavar="[KIND]")
@click.argument("words", nargs=-1, metavar="[NAME]...")
@click.option(
    "--for",
    "torque",
    type=QuantityParam("Nm", "kNm", "lbft"),
    metavar="TORQUE",
    help="Joints and tubes that carry it, shocks included, smallest first: 1200Nm, 900lbft.",
)
@click.option(
    "--speed", type=QuantityParam("rpm", "rad_s"), metavar="SPEED", help="That it turns at."
)
@click.option("--angle", type=QuantityParam("deg", "rad"), metavar="ANGLE", help="Of a joint.")
@click.option("--hours", type=POSITIVE_FLOAT, help="That a joint shall live under it.")
@click.option(
    "--length", type=QuantityParam("mm", "m", "in"), metavar="LENGTH", help="Of a tube that turns."
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
@JSON_OPTION
@LANG_OPTION
@exit_with_code_2_on_known_errors
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
    """List a catalogue, or what of it carries a torque, with source and how it was read.

    KIND is joints, tubes, materials, plies, details, metals, tyres, bearings, limits, torsion
    or typical; without one they are counted. NAME leaves the rows that it is a part of; of one
    row everything is shown. A star says that some of a row's values were read otherwise.
    """
    from cardan.application.catalogue_rows import PART_KIND_OR_FILE_BY_CATALOGUE_NAME
    from cardan.application.catalogue_rows import rows_of_catalogue as rows_of
    from cardan.documents import catalogue_listing as told
    from cardan.render.i18n import Translator

    say = Translator(lang)
    validate_output_paths(file, json_out=json_out)
    own = _application_catalogues(file)
    if shelf is None:
        echo_lines(
            told.catalogue_overview_lines(
                {name: len(rows_of(name, own)) for name in PART_KIND_OR_FILE_BY_CATALOGUE_NAME}, say
            )
        )
        return
    name = _matching_catalogue(shelf, tuple(PART_KIND_OR_FILE_BY_CATALOGUE_NAME))
    rows = _matching_rows(rows_of(name, own), words, name)
    if torque is None:
        if any(x is not None for x in (speed, angle, hours, length)):
            raise_command_error("--speed, --angle, --hours and --length go with --for, a torque")
        if json_out is not None:
            write_json(told.json_document(rows), json_out)
        if json_out != "-":
            echo_lines(
                told.row_detail_lines(rows[0], say)
                if len(rows) == 1
                else told.catalogue_row_lines(rows, say)
            )
        return
    if name not in ("joints", "tubes"):
        raise_command_error(f"--for chooses joints and tubes by torque; {name} carry no torque")
    from cardan.core.units import hour
    from cardan.physics.strength.bearing_life import PRIME_MOVER_FACTORS
    from cardan.topics.design.part_selection import PartRequirement, rank_candidates

    asked = PartRequirement(
        torque=torque,
        speed=speed,
        angle=angle,
        life=None if hours is None else hours * hour,
        prime_mover_factor=PRIME_MOVER_FACTORS[prime_mover],
        length=length,
    )
    if hours is not None and not asked.has_life_data:
        raise_command_error(
            "--hours needs --speed and --angle: a life is one of turning and swinging"
        )
    found = rank_candidates(rows, asked)
    if json_out is not None:
        write_json(told.json_document(found), json_out)
    if json_out != "-":
        echo_lines(told.part_candidate_lines(found, asked, count, say))


def _application_catalogues(file: Path | None) -> Any:
    """Return the catalogues that an application's file brings along."""
    if file is None:
        return None
    from cardan.application import reader
    from cardan.application.reader import catalogue_of_application

    return catalogue_of_application(reader.read(file))


def _matching_catalogue(word: str, names: tuple[str, ...]) -> str:
    """Return the kind of part that is meant: one joint is of the joints."""
    from cardan.schema.node_reader import nearest_name_hint

    same = [name for name in names if word.casefold() in (name, name.removesuffix("s"))]
    if not same:
        raise_command_error(f"there is no catalogue of {word}; {nearest_name_hint(word, names)}")
    return same[0]


def _matching_rows(rows: Any, words: tuple[str, ...], shelf: str) -> Any:
    """Return the row of a name, or else those that all words are found in."""
    from cardan.schema.node_reader import nearest_name_hint

    asked = " ".join(words).casefold()
    exact = [r for r in rows if r.name.casefold().replace(" ", "") == asked.replace(" ", "")]
    if exact and words:
        return exact
    kept = [
        r for r in rows
        if all(w.casefold() in " ".join((r.name, *r.cells.values())).casefold() for w in words)
    ]  # fmt: skip
    if not kept:
        advice = nearest_name_hint(" ".join(words), [r.name for r in rows])
        raise_command_error(f"no row of {shelf} is called or says {' '.join(words)}; {advice}")
    return kept

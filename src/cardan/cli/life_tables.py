"""Tables that `cardan life` writes: rainflow matrices, damage and orders over time."""

from collections.abc import Callable, Mapping
from functools import wraps
from pathlib import Path
from typing import Any, TypeAlias

import click

from cardan.cli.common import OUTPUT_PATH, write_output
from cardan.core.errors import DesignError

TablePaths: TypeAlias = Mapping[str, Path]
"""Files of tables, by the names of their options."""

_HELP = {
    "from_to": "Rainflow matrix of each gauge, from where to where, with bin edges: .csv, "
    ".parquet. Of a campaign: of all recordings, each as often as it is driven.",
    "range_mean": "The same by range and mean.",
    "damage_track": "Damage of each gauge second by second: .csv, .parquet.",
    "order_track": "Orders 1, 2, 4 of the shaft at each gauge over time: amplitude, phase, noise.",
}
TABLE_NAMES = tuple(_HELP)


def add_output_table_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add an option for each table; the command gets them as `tables`."""

    @wraps(command)
    def with_tables(**options: Any) -> None:
        paths = {name: options.pop(name) for name in TABLE_NAMES}
        command(tables={name: path for name, path in paths.items() if path}, **options)

    for name in reversed(TABLE_NAMES):
        with_tables = click.option(
            f"--{name.replace('_', '-')}", metavar="OUT", type=OUTPUT_PATH, help=_HELP[name],
            callback=_check_suffix,
        )(with_tables)  # fmt: skip
    return with_tables


def _check_suffix(_: click.Context, __: click.Parameter, out: Path | None) -> Path | None:
    """Refuse a table whose ending names no kind, before anything is read."""
    if out is not None and out.suffix.lower() not in (".csv", ".parquet"):
        msg = f"a table ends in .csv or .parquet, got {out.name!r}"
        raise click.BadParameter(msg)
    return out


def check_tables(tables: TablePaths, options: Mapping[str, Any]) -> None:
    """Refuse tables of what options do not give, before anything is read.

    Raises
    ------
    DesignError
        If orders are wanted and nothing says how the shaft turns.
    """
    turning = ("speed", "tacho", "estimate_speed")
    if "order_track" in tables and not any(options.get(name) for name in turning):
        msg = "--order-track needs the shaft's angle: name --speed or --tacho"
        raise DesignError(msg)


def write_tables(answer: Any, tables: TablePaths) -> None:
    """Write the tables that have a path, of a recording or a campaign."""
    if not tables:
        return
    from cardan.topics.recording.result_tables import (
        damage_track,
        order_track,
        rainflow_matrices,
    )
    from cardan.topics.recording.table_files import table_bytes

    made: dict[str, Callable[[], Any]] = {
        "from_to": lambda: rainflow_matrices(answer, "from-to").columns(),
        "range_mean": lambda: rainflow_matrices(answer, "range-mean").columns(),
        "damage_track": lambda: damage_track(answer),
        "order_track": lambda: order_track(answer),
    }
    for name, path in tables.items():
        write_output(path, table_bytes(made[name](), path))

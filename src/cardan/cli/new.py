"""`cardan new`: a file to start from."""

from pathlib import Path

import click

from cardan.cli.common import Kinds, put, write
from cardan.cli.ending import Once, kindly


@click.command(cls=Once)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--kind", type=Kinds(), default="truck", show_default=True,
              help="What it is about.")  # fmt: skip
@click.option("--force", is_flag=True, help="Replace the file.")
@kindly
def new(file: Path, *, kind: str, force: bool) -> None:
    """Write a commented FILE to start from.

    A `small` one holds what a protractor measures under the truck; `truck`, `6x4` and `bus` a whole
    vehicle, with one line, with two, with three shafts; `industrial` a machine on its foundation.
    """
    from cardan import files

    write(file, files.starter(kind), replace=force)
    put(f"{file} is written; `cardan check {file}` assesses it.")

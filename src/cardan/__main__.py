"""`python -m cardan` is `cardan`."""

from cardan.cli import cli

cli(prog_name="cardan")

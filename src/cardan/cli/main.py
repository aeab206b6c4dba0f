"""The group of all commands; each is imported where it is called."""

import gc
import os
from importlib import import_module
from typing import Any

import click

from cardan import __version__
from cardan.cli.ending import ending
from cardan.cli.plain import use_plain_letters

# Matrices here are small and many: BLAS's own threads cost more than they bring. Before NumPy.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# What a command makes lasts as long as it does: looking for cycles as often as Python does
# finds few, in a tenth of the time of a check.
gc.set_threshold(50_000, 20, 50)

NAMES = (
    "bracket", "catalogue", "check", "explain", "fix", "joint", "life", "new", "schema", "serve",
    "size", "stability", "verify",
)  # fmt: skip
"""The commands: each is the function of its name in the module of its name."""


class Commands(click.Group):
    """Commands that are imported where they are called, and end as they should."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands."""
        return sorted([*super().list_commands(ctx), *NAMES])

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command by its name."""
        if cmd_name in NAMES:
            return getattr(import_module(f"cardan.cli.{cmd_name}"), cmd_name)
        return super().get_command(ctx, cmd_name)

    def make_context(self, *args: Any, **extra: Any) -> click.Context:
        """Read the command line; help and version are printed here."""
        use_plain_letters()
        with ending(debug=False):
            return super().make_context(*args, **extra)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command that is called."""
        with ending(debug=ctx.params["debug"]):
            return super().invoke(ctx)


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--debug", is_flag=True, help="Show where in the program a fault happened.")
@click.version_option(__version__, "-V", "--version", prog_name="cardan")
def cli(*, debug: bool) -> None:
    """Cardan drivelines, from hardpoints to verdict."""

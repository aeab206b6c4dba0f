"""The group of all commands; each is imported where it is called."""

import gc
import os
from importlib import import_module
from typing import Any

import click

from cardan.cli.ascii_fallback import install_ascii_fallback
from cardan.cli.exit_codes import (
    command_line_error,
    exit_cleanly_on_interrupt_or_bug,
    usage_command_error,
)
from cardan.cli.standard_streams import open_standard_streams
from cardan.core.version import __version__

# Matrices here are small and many: BLAS's own threads cost more than they bring. Before NumPy.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# What a command makes lasts as long as it does: looking for cycles as often as Python does
# finds few, in a tenth of the time of a check.
gc.set_threshold(50_000, 20, 50)

COMMAND_GROUPS = {
    "Approve a driveline": ("new", "check", "fix", "size", "serve"),
    "Variants, dynamics, bracket": ("study", "stability", "bracket"),
    "Recordings": ("life", "convert"),
    "Look up": ("joint", "explain", "catalogue", "verify"),
    "Editor and shell": ("schema", "completion"),
}
"""The commands by purpose: each is the function of its name in the module of its name."""

COMMAND_NAMES = tuple(sorted(name for names in COMMAND_GROUPS.values() for name in names))


class LazyGroup(click.Group):
    """Commands that are imported where they are called, and end as they should."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands."""
        return sorted([*super().list_commands(ctx), *COMMAND_NAMES])

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command by its name."""
        if cmd_name in COMMAND_NAMES:
            return getattr(import_module(f"cardan.cli.{cmd_name}"), cmd_name)
        return super().get_command(ctx, cmd_name)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands by purpose, each with its whole summary."""
        for title, names in COMMAND_GROUPS.items():
            with formatter.section(title):
                commands = ((name, self.get_command(ctx, name)) for name in names)
                formatter.write_dl(
                    [(name, c.get_short_help_str(limit=200)) for name, c in commands if c]
                )

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """Return the command of a line; of a name that is none, the nearest is named."""
        if args and self.get_command(ctx, args[0]) is None and not args[0].startswith("-"):
            from cardan.schema.node_reader import nearest_name_hint

            hint = nearest_name_hint(args[0], COMMAND_NAMES)
            raise command_line_error((f"there is no command {args[0]}", hint), args)
        return super().resolve_command(ctx, args)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the line; --version with --all prints the versions of all parts."""
        if set(args) in ({"--version", "--all"}, {"-V", "--all"}):
            from cardan.cli.versions import version_lines

            click.echo("\n".join(version_lines()))
            ctx.exit()
        try:
            return super().parse_args(ctx, args)
        except click.NoSuchOption as error:
            raise usage_command_error(error, ctx, args) from error

    def main(self, *args: Any, **extra: Any) -> Any:
        """Run the command line, whatever became of the standard streams."""
        open_standard_streams()
        return super().main(*args, **extra)

    def make_context(self, *args: Any, **extra: Any) -> click.Context:
        """Read the command line; help and version are printed here."""
        install_ascii_fallback()
        with exit_cleanly_on_interrupt_or_bug(debug=False):
            return super().make_context(*args, **extra)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command that is called."""
        with exit_cleanly_on_interrupt_or_bug(debug=ctx.params["debug"]):
            return super().invoke(ctx)


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--debug", is_flag=True, help="Show where in the program a fault happened.")
@click.version_option(
    __version__, "-V", "--version", prog_name="cardan",
    help="Show the version and exit; with --all, those of Python and of every library too.",
)  # fmt: skip
def cli(*, debug: bool) -> None:
    """Cardan drivelines, from hardpoints to verdict."""

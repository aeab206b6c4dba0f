"""The command line: read, ask, print; a module for each command."""

from cardan.cli.main import cli

__all__ = ["cli"]

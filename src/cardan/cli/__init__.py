"""The command line: read, compute, print; a module for each command."""

from cardan.cli.main import cli

__all__ = ["cli"]

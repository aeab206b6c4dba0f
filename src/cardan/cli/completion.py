"""`cardan completion`: what a shell needs to complete commands and options."""

import click
from click.shell_completion import get_completion_class

from cardan.cli.exit_codes import NoRepeatedOptionCommand


@click.command(cls=NoRepeatedOptionCommand)
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
def completion(shell: str) -> None:
    """Print the script by which SHELL completes commands and options.

    Write it where the shell reads it when it starts: `eval "$(cardan completion bash)"` in
    ~/.bashrc, the same with zsh in ~/.zshrc, and for fish `cardan completion fish >
    ~/.config/fish/completions/cardan.fish`.
    """
    from cardan.cli.main import cli

    found = get_completion_class(shell)
    assert found is not None  # of the choices above
    click.echo(found(cli, {}, "cardan", "_CARDAN_COMPLETE").source())

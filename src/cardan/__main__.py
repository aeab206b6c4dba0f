"""`python -m cardan` is `cardan`."""

import os


def main() -> None:
    """Run the command line; Ctrl-C ends it without a traceback from here on."""
    try:
        from cardan.core.interrupts import exit_on_interrupts

        exit_on_interrupts()
    except KeyboardInterrupt:
        os._exit(130)
    from cardan.cli import cli

    cli(prog_name="cardan")


if __name__ == "__main__":
    main()

"""How a run ends, and with which exit code.

0     passes, or only warns
1     something fails, or a limit the profile requires has no answer
2     a file or an option is not as it should be; nothing was done
3     the program is at fault: to be reported
130   stopped from the keyboard
141   nobody reads on: a closed pipe
"""

import os
import re
import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from functools import wraps
from typing import Any, NoReturn, TypeVar

import click

from cardan import __version__
from cardan.base.errors import CardanError

BAD_VERDICT, BAD_INPUT, OWN_FAULT, STOPPED, NO_READER = 1, 2, 3, 130, 141
REPORT = "CONTRIBUTING.md"
"""Where it is said how to report a fault of the program."""

_LANG = re.compile(r"(?m)^--lang[=\n](it|pt)$")
"""Another language, asked for on a command line of one argument each line."""

Command = TypeVar("Command", bound=Callable[..., Any])


class Refused(click.ClickException):
    """Nothing was done, and why: a line for each reason."""

    exit_code = BAD_INPUT

    def __init__(self, message: str, word: str = "error") -> None:
        super().__init__(message)
        self.word = word

    def show(self, file: Any = None) -> None:
        """Print the reasons."""
        for line in self.message.splitlines() or [""]:
            click.echo(f"{self.word}: {line}", file=file or sys.stderr)


class Once(click.Command):
    """A command that refuses an option given twice: one of the two would be passed over."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the options and arguments; what is wrong is said in the language asked for."""
        lang = _LANG.search("\n".join(args))
        try:
            return self._parsed(ctx, args)
        except click.UsageError as error:
            if lang is None:
                raise
            from cardan.report.language import Language

            say = Language(lang[1])
            said = (error.format_message(), f"see {ctx.command_path} --help")
            raise Refused("; ".join(map(say.error, said)), word=say("error")) from error

    def _parsed(self, ctx: click.Context, args: list[str]) -> list[str]:
        _, _, order = self.make_parser(ctx).parse_args(args=list(args))
        for option in order:
            single = isinstance(option, click.Option) and not (option.multiple or option.count)
            if single and order.count(option) > 1:
                name = max(option.opts, key=len)
                ctx.fail(f"{name} is given {order.count(option)} times; say it once")
        return super().parse_args(ctx, args)


def kindly(command: Command) -> Command:
    """Return a command that turns what it refuses into a message and exit code 2."""

    @wraps(command)
    def guarded(*args: Any, **kwargs: Any) -> Any:
        try:
            return command(*args, **kwargs)
        except BrokenPipeError:
            raise
        except (CardanError, OSError, Refused) as error:
            raise _told(error, kwargs.get("lang", "en")) from error

    return guarded  # type: ignore[return-value]


def _told(error: Exception, lang: str) -> Refused:
    """Return an error in the words of a language."""
    if lang == "en":
        return Refused(str(error))
    from cardan.report.language import Language
    from cardan.report.wording import refused

    say = Language(lang)
    return Refused(refused(error, say), word=say("error"))


def refuse(message: str) -> NoReturn:
    """Do nothing more, and say why."""
    raise Refused(message)


def leave(*verdicts: str) -> NoReturn:
    """End with the exit code of verdicts: 1 where something fails or has no answer."""
    bad = any(v in ("fail", "incomplete") for v in verdicts)
    raise SystemExit(BAD_VERDICT if bad else 0)


@contextmanager
def ending(*, debug: bool) -> Generator[None, None, None]:
    """End a run that was stopped, that nobody reads, or that met a fault of the program."""
    try:
        yield
    except KeyboardInterrupt:
        click.echo(file=sys.stderr)  # the line after the terminal's own ^C
        raise SystemExit(STOPPED) from None
    except BrokenPipeError:
        _hush()
        raise SystemExit(NO_READER) from None
    except (click.ClickException, click.exceptions.Exit, click.Abort):
        raise
    except Exception as error:  # the last door: nobody above it can help
        if debug:
            import traceback

            traceback.print_exc()
        click.echo(_fault(error), file=sys.stderr)
        raise SystemExit(OWN_FAULT) from error


def _hush() -> None:
    """Let what is still to be written go nowhere, so that Python says nothing at its end."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, stream.fileno())
            os.close(nowhere)


def _fault(error: Exception) -> str:
    """Return what somebody who reports a fault has to know."""
    import platform
    import shlex

    given = shlex.join(sys.argv[1:])
    return (
        f"error: cardan itself is at fault: {type(error).__name__}: {error}\n"
        f"  cardan {__version__}, Python {platform.python_version()}, {platform.system()}\n"
        f"  command: cardan {given}\n"
        f"  {REPORT} says how to report it; `cardan --debug {given}` shows where it happened"
    )

"""How a run ends, and with which exit code.

0     passes, or only warns
1     something fails, or a limit the profile requires is not evaluated
2     a file or an option is not as it should be; nothing was done
3     the program is at fault: to be reported
130   stopped from the keyboard
141   a closed pipe: the output is no longer read
"""

import os
import re
import sys
from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import contextmanager, suppress
from functools import wraps
from typing import Any, NoReturn, TypeVar

import click

from cardan.cli.language import locale_language
from cardan.core.errors import CardanError
from cardan.core.interrupts import EXIT_INTERRUPTED, interrupts_raised
from cardan.core.version import __version__

EXIT_NOT_APPROVED, EXIT_INVALID_INPUT, EXIT_INTERNAL_ERROR, EXIT_BROKEN_PIPE = 1, 2, 3, 141
BUG_REPORT_GUIDE = "CONTRIBUTING.md"
"""Where it is said how to report a fault of the program."""

_LANG = re.compile(r"(?m)^--lang[=\n](en|it|pt)$")
"""The language requested on a command line of one argument each line."""

_QUOTED = re.compile(r"'([^']+)' is not one of")

Command = TypeVar("Command", bound=Callable[..., Any])


class CommandError(click.ClickException):
    """Nothing was done, and why: a line for each reason."""

    exit_code = EXIT_INVALID_INPUT

    def __init__(self, message: str, word: str = "error") -> None:
        super().__init__(message)
        self.word = word

    def show(self, file: Any = None) -> None:
        """Print the reasons."""
        for line in self.message.splitlines() or [""]:
            click.echo(f"{self.word}: {line}", file=file or sys.stderr)


class NoRepeatedOptionCommand(click.Command):
    """A command that refuses an option given twice: one of the two would be passed over."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the options and arguments; errors are in the requested language."""
        given = tuple(args)  # of which the parser takes away
        try:
            return self._parse_unique(ctx, args)
        except click.UsageError as error:
            raise usage_command_error(error, ctx, given) from error

    def _parse_unique(self, ctx: click.Context, args: list[str]) -> list[str]:
        _, _, order = self.make_parser(ctx).parse_args(args=list(args))
        for option in order:
            single = isinstance(option, click.Option) and not (option.multiple or option.count)
            if single and order.count(option) > 1:
                name = max(option.opts, key=len)
                ctx.fail(f"{name} is given {order.count(option)} times; say it once")
        return super().parse_args(ctx, args)


def usage_command_error(
    error: click.UsageError, ctx: click.Context, args: Sequence[str]
) -> CommandError:
    """Return an error of a command line as any other, in the language that the line names."""
    said = (error.format_message(), _nearest_choice(error), f"see {ctx.command_path} --help")
    return command_line_error(said, args)


def command_line_error(said: Iterable[str], args: Sequence[str]) -> CommandError:
    """Return what is wrong with a command line, in the language that it names."""
    named = _LANG.search("\n".join(args))
    lang = named[1] if named else locale_language()
    if lang == "en":
        return CommandError("; ".join(one.removesuffix(".") for one in said if one))
    from cardan.render.i18n import Translator

    say = Translator(lang)
    return CommandError("; ".join(say.error(one) for one in said if one), word=say("error"))


def _nearest_choice(error: click.UsageError) -> str:
    """Return the nearest choice of an option, in an error about another word."""
    choice = getattr(getattr(error, "param", None), "type", None)
    wrong = _QUOTED.match(error.message)
    if not (isinstance(choice, click.Choice) and wrong):
        return ""
    from difflib import get_close_matches  # needed for bad lines alone

    close = get_close_matches(wrong[1], [str(c) for c in choice.choices], n=1)
    return f"did you mean {close[0]}?" if close else ""


def exit_with_code_2_on_known_errors(command: Command) -> Command:
    """Return a command that turns what it refuses into a message and exit code 2."""

    @wraps(command)
    def guarded(*args: Any, **kwargs: Any) -> Any:
        try:
            return command(*args, **kwargs)
        except BrokenPipeError:
            raise
        except (CardanError, OSError, CommandError) as error:
            raise _translated_error(error, kwargs.get("lang") or locale_language()) from error

    return guarded  # type: ignore[return-value]


def _translated_error(error: Exception, lang: str) -> CommandError:
    """Return an error in the words of a language."""
    if lang == "en":
        return CommandError(str(error))
    from cardan.render.i18n import Translator
    from cardan.render.phrases import error_text

    say = Translator(lang)
    return CommandError(error_text(error, say), word=say("error"))


def raise_command_error(message: str) -> NoReturn:
    """Do nothing more, and say why."""
    raise CommandError(message)


def exit_with_verdicts(*verdicts: str) -> NoReturn:
    """End with the exit code of verdicts: 1 where something fails or is not evaluated."""
    bad = any(v in ("fail", "incomplete") for v in verdicts)
    raise SystemExit(EXIT_NOT_APPROVED if bad else 0)


@contextmanager
def exit_cleanly_on_interrupt_or_bug(*, debug: bool) -> Generator[None, None, None]:
    """End a run that was stopped, lost its reader, or met a fault of the program."""
    try:
        with interrupts_raised():
            yield
    except KeyboardInterrupt:
        click.echo(file=sys.stderr)  # the line after the terminal's own ^C
        raise SystemExit(EXIT_INTERRUPTED) from None
    except BrokenPipeError:
        _discard_output()
        raise SystemExit(EXIT_BROKEN_PIPE) from None
    except (click.ClickException, click.exceptions.Exit, click.Abort):
        raise
    except Exception as error:  # the last handler: none above it can help
        if debug:
            import traceback

            traceback.print_exc()
        click.echo(_bug_report(error), file=sys.stderr)
        raise SystemExit(EXIT_INTERNAL_ERROR) from error


def _discard_output() -> None:
    """Let what is still to be written go nowhere, so that Python says nothing at its end."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, stream.fileno())
            os.close(nowhere)


def _bug_report(error: Exception) -> str:
    """Return what the report of a fault has to contain."""
    import platform
    import shlex

    given = shlex.join(sys.argv[1:])
    return (
        f"error: cardan itself is at fault: {type(error).__name__}: {error}\n"
        f"  cardan {__version__}, Python {platform.python_version()}, {platform.system()}\n"
        f"  command: cardan {given}\n"
        f"  {BUG_REPORT_GUIDE} says how to report it; `cardan --debug {given}` shows where it "
        f"happened"
    )

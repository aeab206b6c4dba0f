"""Languages: what a report says, and how it writes a number.

Every text is looked up by its English wording in a catalogue of `cardan.render.locales`, names
of quantities too, so the code that prints it can be read. A catalogue is all that a language
needs: its file names it, and its head says which decimal sign it writes and how it counts. What a
catalogue lacks is said in English; the tests, and `make texts`, list it.
"""

import gettext
import math
import re
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import get_args

from cardan.application.quantity_lookup import declared_quantity
from cardan.core.labels import EvaluationCondition, Part
from cardan.core.lazy_dataclass import dataclass
from cardan.core.message import TranslatableMessage
from cardan.model.vehicle import SuspensionState

_CATALOGUE_FOLDER = Path(__file__).with_name("locales")

LANGUAGE_CODES = ("en", *sorted(p.stem for p in _CATALOGUE_FOLDER.glob("*.po")))
"""The languages by code: English, and one for each catalogue."""

UNTRANSLATED_MESSAGES_SEEN: set[tuple[str, str]] = set()
"""Texts missing in a catalogue, and shown in English: code and text."""

_SUSPENSION_STATES = frozenset(get_args(SuspensionState))

_STATE_NAMES = {
    "jounce": "bump",
    "windup": "axle wind-up (drive)",
    "windup brake": "axle wind-up (braking)",
}
"""States by the field's names, where those differ from the keys of a file."""

_SOURCE_SEPARATORS = re.compile(r"(; |: |, (?=citing )| \(|\))")
"""What stands between the pieces of a source."""

_PUBLICATION_PLACES = re.compile(
    r"(?<=, )(ch\.|chapter|section|table|example|equation|figure)(?= \d)"
)
"""Words for a place in a publication, ahead of its number."""

TranslationKey = tuple[str, str]
"""Context, "" for most, and English wording."""


@cache
def message_catalogue(code: str) -> Mapping[TranslationKey, str]:
    """Return the texts of a language by context and English wording; its head by ("", "").

    English has none: it says what it is given.
    """
    if code == "en":
        return {}
    return dict(_entries((_CATALOGUE_FOLDER / f"{code}.po").read_text(encoding="utf-8")))


def _entries(text: str) -> Iterator[tuple[TranslationKey, str]]:
    """Yield what a .po file translates. Its strings are escaped as JSON's are."""
    from json import loads  # English has no file

    for block in text.split("\n\n"):
        parts: dict[str, str] = {}
        name = ""
        for line in block.splitlines():
            if line.startswith("#") or not line.strip():
                continue
            word, quote, rest = line.partition('"')
            name = word.strip() or name
            parts[name] = parts.get(name, "") + loads(quote + rest)
        if "msgid" in parts:
            key = parts.get("msgctxt", ""), parts["msgid"]
            forms = [text for name, text in parts.items() if name.startswith("msgstr[")]
            yield key, _PLURAL_SEPARATOR.join(forms) if forms else parts["msgstr"]


_PLURAL_SEPARATOR = "\0"
"""Between the plural forms of a text, as in gettext's own compiled catalogues."""


@cache
def _catalogue_header(code: str) -> Mapping[str, str]:
    """Return the fields of a catalogue's head."""
    head = message_catalogue(code).get(("", ""), "")
    return dict(line.split(": ", 1) for line in head.splitlines() if ": " in line)


def _decimal_sign(code: str) -> str:
    """Return the decimal sign that a catalogue's head names; a point where it names none."""
    return _catalogue_header(code).get("X-Decimal", ".")


@cache
def _plural_rule(code: str) -> Callable[[int], int]:
    """Return which form a count takes, by the rule of a catalogue's head; English's without."""
    rule = _catalogue_header(code).get("Plural-Forms", "").partition("plural=")[2]
    return gettext.c2py(rule.strip(" ;") or "n != 1")


_PLACEHOLDER = re.compile(r"\{(\d)\}")
"""What a refusal names, by its place in the sentence."""

_NUMBER_WITH_UNIT = re.compile(r"([-+]?\d+\.\d+(?:e[-+]?\d+)?)((?: ?%| [^\s.]+)?)")
"""A number with decimals that a sentence was given, and its unit."""

_DECIMAL_NUMBER = re.compile(r"(?<![\w.,])\d+\.\d+(?![\w.,]*\d)")
"""The same inside a sentence, where it is no part of a name or a date."""

_NEGATIVE_SIGN = re.compile(r"(?<![\d.,e])-(?=\d)")
"""What stands before a number below nothing; between two numbers it is another sign."""

_NON_WORD = re.compile(r"\(\.\+\?\)|\W")
MIN_LETTERS_IN_ERROR_PATTERN = 5
"""Letters below which a pattern only joins what it names: and, or."""


@cache
def _error_patterns(code: str) -> tuple[tuple[re.Pattern[str], str], ...]:
    """Return what readers refuse, as patterns with their translation, those that say most first."""
    found = {e: t for (context, e), t in message_catalogue(code).items() if context == "error"}
    said = sorted(found, key=lambda e: -len(_PLACEHOLDER.sub("", e)))
    return tuple(
        (
            re.compile(_PLACEHOLDER.sub("(.+?)", re.sub(r"([^\w\s{}])", r"\\\1", e)), re.DOTALL),
            found[e],
        )
        for e in said
    )


@dataclass(frozen=True)
class Translator:
    """Says in its language what it is given in English.

    A number below nothing has a hyphen before it, which any screen shows and any search finds,
    or where it is `with_minus_sign`, in a report or on the workbench, a minus sign.
    """

    code: str = "en"
    minus: str = "-"

    def __post_init__(self) -> None:
        if self.code not in LANGUAGE_CODES:
            msg = f"there is no language {self.code}; there are: {', '.join(LANGUAGE_CODES)}"
            raise ValueError(msg)

    @property
    def decimal_sign(self) -> str:
        """The sign before decimals."""
        return _decimal_sign(self.code)

    @property
    def with_minus_sign(self) -> "Translator":
        """The language as pages are set in it."""
        return Translator(self.code, minus="−")

    def __call__(self, said: str, /, **values: object) -> str:
        """Return a text of the catalogue with its values filled in; in English where it lacks it.

        Of a text that has plural forms, the last.
        """
        if self.code != "en" and said and ("", said) not in message_catalogue(self.code):
            UNTRANSLATED_MESSAGES_SEEN.add((self.code, said))
        said = self.translate_if_known(said).rpartition(_PLURAL_SEPARATOR)[2]
        return said.format(**values) if values else said

    def count(self, one: str, many: str, count: int, /, **values: object) -> str:
        """Return a text in the form that a count takes; {count} in it is the count.

        >>> ENGLISH.count("{count} shaft", "{count} shafts", 2)
        '2 shafts'
        """
        forms = (
            message_catalogue(self.code)
            .get(("", one), f"{one}{_PLURAL_SEPARATOR}{many}")
            .split(_PLURAL_SEPARATOR)
        )
        return forms[_plural_rule(self.code)(count)].format(count=count, **values)

    def translate_message(self, of: TranslatableMessage) -> str:
        """Return a sentence that was made below, its words and sentences inside it too."""

        def filled(value: object) -> object:
            if isinstance(value, TranslatableMessage):
                return self.translate_message(value)
            if isinstance(value, tuple):
                return self.join(*(str(filled(one)) for one in value))
            if isinstance(value, str) and value in _SUSPENSION_STATES:
                return self.state(value)
            if isinstance(value, str):
                number = _NUMBER_WITH_UNIT.fullmatch(value)
                return (
                    self.with_decimal_sign(number[1]) + number[2]
                    if number
                    else self.translate_if_known(value)
                )
            return self.part(value) if isinstance(value, Part) else value

        return self(of.text, **{name: filled(value) for name, value in of.values})

    def localise_numbers(self, said: str) -> str:
        """Return a sentence with its numbers as the language writes them: 2,5 rpm."""
        return _DECIMAL_NUMBER.sub(lambda number: self.with_decimal_sign(number[0]), said)

    def translate_if_known(self, said: str) -> str:
        """Return a text that is ours or a publication's: translated where it is ours."""
        found = message_catalogue(self.code)
        return found.get(("", said), found.get(("quantity", said), said)) if said else said

    def source(self, said: str) -> str:
        """Return what a source says in our words; titles of publications stay as they are.

        A source is made of pieces, `normal 0.67: Engineering judgement, assumed`, and a
        piece that the catalogue has is said in the language.
        """
        if self.code == "en":
            return said
        if ("", said) in message_catalogue(self.code):
            return self(said)
        return "".join(
            piece if k % 2 else self._piece(piece)
            for k, piece in enumerate(_SOURCE_SEPARATORS.split(said))
        )

    def _piece(self, said: str) -> str:
        """Return a piece of a source: ours, or one of a bound like `normal 300`."""
        bound = re.fullmatch(r"(normal|maximum) (\S+)", said)
        if bound:
            return f"{self(bound[1])} {self.with_decimal_sign(bound[2])}"
        if said and ("", said) in message_catalogue(self.code):
            return self(said)
        return _PUBLICATION_PLACES.sub(lambda found: self(found[0]), said)

    def error(self, said: str) -> str:
        """Return what a reader refuses, in the language where the catalogue has its sentence.

        Errors are made in English where they are found, far below; here their sentences are
        known by their pattern, and what they name is put where the language has it.
        """
        listed = [message_catalogue(self.code).get(("error", one), "") for one in said.split(", ")]
        if all(listed):
            return ", ".join(listed)
        tries = ((pattern.fullmatch(said), other) for pattern, other in _error_patterns(self.code))
        found, other = next(((f, o) for f, o in tries if f), (None, said))
        where, colon, what = said.partition(": ")
        # Of "F: A or B" the sentence "A or B" says more than "{0} or {1}" does of the whole.
        if colon and (
            found is None or len(_NON_WORD.sub("", found.re.pattern)) < MIN_LETTERS_IN_ERROR_PATTERN
        ):
            inner = self.error(what)
            if found is None or inner != what:
                where = message_catalogue(self.code).get(("error", where), where)
                return f"{where}{colon}{inner}"
        if found is None:
            return said
        return _PLACEHOLDER.sub(lambda at: self.error(found[int(at[1]) + 1]), other)

    def name(self, quantity: str) -> str:
        """Return the name of a quantity."""
        english = declared_quantity(quantity).name
        return message_catalogue(self.code).get(("quantity", english), english)

    def part(self, part: Part) -> str:
        """Return what a number is of; what the user named keeps its name."""
        match part.kind:
            case "line":
                return self("line")
            case "clearance":
                shaft = self.part(Part("shaft", part.number))
                return self("{part} to {other}", part=shaft, other=part.other)
            case "mode":
                return self("mode {mode}, order {order}", mode=part.number, order=part.other)
            case "zone" if part.number == part.other:
                return self("zone of mode {mode}", mode=part.number)
            case "zone":
                return self("zone of modes {mode} + {other}", mode=part.number, other=part.other)
            case "gauge":
                return str(part.other)
            case kind if not part.number:
                return self(kind)
            case kind:
                return f"{self(kind)} {part.number}"

    def occasion(self, when: EvaluationCondition) -> str:
        """Return where a number applies; a state that the user named keeps its name."""
        match when.kind:
            case "gear":
                gear = self("gear {gear}", gear=when.name)
                return f"{gear}, {self(when.what)}" if when.what else gear
            case "speed":
                return self(when.name)
            case "launch":
                return self("launch in gear {gear}, {time} s", gear=when.name,
                            time=self.with_decimal_sign(str(when.what)))  # fmt: skip
            case "duty":
                return self("duty cycle, {state}", state=self.state(when.name))
            case "state":
                return self.state(when.name)
            case _:
                return f"{self.state(when.name)}: {self(when.what)}" if when.what else when.name

    def state(self, name: str) -> str:
        """Return a state's name: one of the suspension's in the language, else as it is."""
        known = name in _SUSPENSION_STATES or name == "as given"
        return self(_STATE_NAMES.get(name, name)) if known else name

    def number(self, value: float, figures: int = 4) -> str:
        """Return a number as an engineer writes it down: four figures."""
        if math.isnan(value):
            return "-"
        if math.isinf(value):
            return "∞" if value > 0 else f"{self.minus}∞"
        if abs(value) < 1e-10:
            return "0"
        size = math.floor(math.log10(abs(value)))
        places = figures - 1
        plain = f"{value:.{max(0, places - size)}f}"
        return self.with_decimal_sign(plain if -3 <= size < 7 else f"{value:.{places}e}")

    def compact_number(self, value: float, digits: int = 6) -> str:
        """Return a number without the zeros that say nothing; what is left of nothing is 0."""
        value = 0.0 if abs(value) < 5e-10 else value
        return self.with_decimal_sign(f"{value:.{digits}g}")

    def significant_number(self, value: float, digits: int) -> str:
        """Return a number of which the least is something, as damage and odds are."""
        return self.with_decimal_sign(f"{value:.{digits}g}")

    def percentage(self, value: float, places: int = 0) -> str:
        """Return a share in per cent, to so many decimals: `12.5 %`."""
        return self.with_decimal_sign(f"{100 * value:z.{places}f} %")

    def margin_percent(self, margin: float) -> str:
        """Return a margin as a share in per cent, cut where it says nothing more."""
        if math.isinf(margin) and margin > 0:
            return "∞"
        if margin < -9.99:
            return f"< {self.minus}999 %"
        if margin > 99.99:
            return ">9999 %"
        if 1e-9 < abs(margin) < 0.0095:  # a warning by a hair is none at +0 %
            return self.with_decimal_sign(f"{100 * margin:+.2g} %")
        return self.with_decimal_sign(f"{round(100 * margin) + 0:+d} %")

    def margin_text(self, margin: float) -> str:
        """Return a margin in per cent; beyond +-100 % in words, where a number says no more."""
        if margin < -1:
            return self("far beyond")
        return self("ample") if margin > 1 else self.margin_percent(margin)

    def join(self, *parts: str) -> str:
        """Return parts as a list in a line."""
        return ", ".join(p for p in parts if p)

    def with_decimal_sign(self, number: str) -> str:
        """Return a number with the language's decimal sign, and its minus."""
        found = number.replace(".", _decimal_sign(self.code))
        return found if self.minus == "-" else _NEGATIVE_SIGN.sub(self.minus, found)


ENGLISH = Translator("en")
"""English, which everything is written in first."""

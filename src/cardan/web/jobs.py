"""What a page may ask as a job, and in which shape: nothing else reaches a worker."""

from collections.abc import Callable, Mapping
from math import inf
from typing import Any, TypeAlias

from cardan.border.document import LONGEST

MOST = 4
"""Jobs of one page at a time; they are done one after another."""

LIGHT = frozenset({"limits", "deviate", "script", "moved", "ghost", "guided", "pasted"})
"""Jobs that are done at once: they do not wait behind those that take minutes."""

BESIDE = frozenset({"library", "compare", "map", "speeds"})
"""Jobs of several files, and what a view asks by itself: they do not wait there either, and what
a hand asks for does not wait behind them."""

VARIANTS = 12
"""Variants of a file that are kept."""

Json: TypeAlias = dict[str, Any]
Shape: TypeAlias = Callable[[Json, str], Any]


class Wrong(Exception):  # noqa: N818  never leaves this room
    """A message that the page does not send."""


class TooMuch(Wrong):
    """One that it does send, and that is more than is taken: it is told so."""


def text(said: Mapping[str, Any], key: str, most: int = LONGEST + 1) -> str:
    """Return a text of a message."""
    found = said.get(key)
    if not isinstance(found, str):
        raise Wrong
    if len(found) > most:
        msg = f"{key} is longer than {most} characters"
        raise TooMuch(msg)
    return found


def whole(said: Mapping[str, Any], key: str, below: int) -> int:
    """Return a whole number of a message, from 0."""
    value = said.get(key)
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise Wrong
    if value >= below:
        msg = f"{key} is beyond {below - 1}"
        raise TooMuch(msg)
    return value


def number(value: Any, *, most: float) -> float:
    """Return a number, no larger than may be either way."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < inf:
        raise Wrong
    if abs(value) > most:
        msg = f"a number is beyond {most:g}"
        raise TooMuch(msg)
    return float(value)


def several(said: Mapping[str, Any], key: str, most: int) -> list[Any]:
    """Return a list of a message."""
    rows = said.get(key)
    if not isinstance(rows, list):
        raise Wrong
    if len(rows) > most:
        msg = f"{key} are more than {most}"
        raise TooMuch(msg)
    return rows


def arguments(job: str, said: Any) -> Json:
    """Return the arguments of a job: each is left out, or has its shape."""
    if not isinstance(said, dict) or not said.keys() <= ARGUMENTS[job].keys():
        raise Wrong
    return {key: ARGUMENTS[job][key](said, key) for key in said}


def _below(most: int) -> Shape:
    return lambda said, key: whole(said, key, most)


def _typed(most: int = 200) -> Shape:
    return lambda said, key: text(said, key, most)


def _rows(keys: tuple[str, ...], most: int) -> Shape:
    """Return the shape of a list of rows of typed fields."""

    def read(said: Json, key: str) -> list[Json]:
        rows = several(said, key, most)
        if not all(isinstance(row, dict) and row.keys() <= set(keys) for row in rows):
            raise Wrong
        return [{k: text(row, k, 200) for k in row} for row in rows]

    return read


def texts(said: Json, key: str) -> list[dict[str, str]]:
    """Return named texts: variants of a file."""
    rows = several(said, key, VARIANTS)
    if not all(isinstance(row, dict) and row.keys() == {"name", "text"} for row in rows):
        raise Wrong
    return [{"name": text(row, "name", 100), "text": text(row, "text")} for row in rows]


def _amounts(said: Json, key: str) -> list[Json]:
    """Return amounts of moves, by what moves."""
    rows = several(said, key, 40)
    if not all(isinstance(row, dict) and row.keys() == {"id", "amount"} for row in rows):
        raise Wrong
    return [{"id": text(r, "id", 60), "amount": number(r["amount"], most=1e6)} for r in rows]


def _names(said: Json, key: str) -> list[str]:
    return [text({key: name}, key, 60) for name in several(said, key, 60)]


def _words(said: Json, key: str) -> list[str]:
    """Return what is said of a recording: channels, and rules of what looks wrong in them."""
    return [text({key: row}, key, 300) for row in several(said, key, 200)]


def _truth(said: Json, key: str) -> bool:
    if not isinstance(said[key], bool):
        raise Wrong
    return said[key]


def _one_of(*choices: str) -> Shape:
    def read(said: Json, key: str) -> str:
        if said[key] not in choices:
            raise Wrong
        return str(said[key])

    return read


def _files(said: Json, key: str) -> list[int]:
    """Return files by their numbers on the desk."""
    return [whole({key: row}, key, 10_000) for row in several(said, key, VARIANTS)]


LINE: dict[str, Shape] = {"line": _below(100)}
PASTED: dict[str, Shape] = {"points": _typed(20_000), "unit": _typed(), "axes": _typed()}
FORM: dict[str, Shape] = {
    "title": _typed(300),  # as a file's
    **{key: _typed() for key in ("speed", "torque", "limits")},
    **PASTED,
    "members": _rows(("side", "top"), 8),
    "shafts": _rows(("length", "phase", "tube", "bearing"), 6),
}

ARGUMENTS: dict[str, dict[str, Shape]] = {
    "speeds": {"line": _below(100), "state": _below(1000)},
    "torsion": {},
    "guided": FORM,
    "fix": {**LINE, "hold": _names},
    "map": {**LINE, "x": _typed(60), "y": _typed(60), "sought": _truth},
    "moved": {**LINE, "moves": _amounts},
    "yield": {
        **LINE,
        "sigmas": _rows(("id", "amount"), 40),
        "sought": _truth,
        "count": _below(65_537),
    },
    "limits": {},
    "library": {},
    "script": {**LINE, "saved": text, "hold": _names},
    "report": {"kind": _one_of("html", "pdf", "xlsx", "json"), "lang": _typed(8)},
    "deviate": {
        "which": _below(500),
        "normal": _typed(40),
        "maximum": _typed(40),
        "reason": _typed(1000),
        "by": _typed(200),
    },
    "ghost": {},
    "recording": {},
    "life": {
        **dict.fromkeys(("gauges", "mask", "accept"), _words),
        **{key: _typed(300) for key in ("speed", "torque", "engine", "tacho")},
        **dict.fromkeys(
            ("amplitude", "cycles", "slope", "first", "last", "hours", "modulus"), _typed(40)
        ),
        "zero": _one_of("none", "start", "median", "drift"),
    },
    "drive": {"drive": _below(10_000)},
    "campaign": {},
    "bracket": {},
    "compare": {"variants": texts, "files": _files},
    "pasted": {**PASTED, **LINE},
}
"""By job and argument."""

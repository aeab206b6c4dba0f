"""What a page may request as a job, and in which shape: nothing else reaches a worker."""

from collections.abc import Callable, Mapping
from math import inf
from typing import Any, TypeAlias

from cardan.render.media import REPORT_MEDIA
from cardan.schema.yaml_tree import MAX_FILE_CHARACTERS

MAX_JOBS_PER_PAGE = 4
"""Jobs of one page at a time; they are done one after another."""

JOBS_RUN_WITHOUT_QUEUE = frozenset(
    {"limits", "deviate", "script", "moved", "ghost", "guided", "pasted"}
)
"""Jobs that are done at once: they do not wait behind those that take minutes."""

JOBS_QUEUED_SEPARATELY_FOR_VIEWS = frozenset({"library", "compare", "map", "speeds"})
"""Jobs of several files, and what a view requests by itself: they do not wait there either, and
what a drag requests does not wait behind them."""

MAX_VARIANTS = 12
"""Variants of a file that are kept."""

Json: TypeAlias = dict[str, Any]
ArgumentReader: TypeAlias = Callable[[Json, str], Any]


class InvalidMessageError(Exception):
    """A message that the page does not send."""


class MessageTooLargeError(InvalidMessageError):
    """A job that it may send, and that is larger than accepted: the page gets an error."""


def text_field(said: Mapping[str, Any], key: str, most: int = MAX_FILE_CHARACTERS + 1) -> str:
    """Return a text of a message."""
    found = said.get(key)
    if not isinstance(found, str):
        raise InvalidMessageError
    if len(found) > most:
        msg = f"{key} is longer than {most} characters"
        raise MessageTooLargeError(msg)
    return found


def integer_field(said: Mapping[str, Any], key: str, below: int) -> int:
    """Return a whole number of a message, from 0."""
    value = said.get(key)
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise InvalidMessageError
    if value >= below:
        msg = f"{key} is beyond {below - 1}"
        raise MessageTooLargeError(msg)
    return value


def bounded_number(value: Any, *, most: float) -> float:
    """Return a number, no larger than may be either way."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < inf:
        raise InvalidMessageError
    if abs(value) > most:
        msg = f"a number is beyond {most:g}"
        raise MessageTooLargeError(msg)
    return float(value)


def list_field(said: Mapping[str, Any], key: str, most: int) -> list[Any]:
    """Return a list of a message."""
    rows = said.get(key)
    if not isinstance(rows, list):
        raise InvalidMessageError
    if len(rows) > most:
        msg = f"{key} are more than {most}"
        raise MessageTooLargeError(msg)
    return rows


def read_arguments(job: str, said: Any) -> Json:
    """Return the arguments of a job: each is left out, or has its shape."""
    if not isinstance(said, dict) or not said.keys() <= JOB_ARGUMENTS[job].keys():
        raise InvalidMessageError
    return {key: JOB_ARGUMENTS[job][key](said, key) for key in said}


def _integer_below(most: int) -> ArgumentReader:
    return lambda said, key: integer_field(said, key, most)


def _text_up_to(most: int = 200) -> ArgumentReader:
    return lambda said, key: text_field(said, key, most)


def _rows_of_texts(keys: tuple[str, ...], most: int) -> ArgumentReader:
    """Return the shape of a list of rows of typed fields."""

    def read(said: Json, key: str) -> list[Json]:
        rows = list_field(said, key, most)
        if not all(isinstance(row, dict) and row.keys() <= set(keys) for row in rows):
            raise InvalidMessageError
        return [{k: text_field(row, k, 200) for k in row} for row in rows]

    return read


def variants_field(said: Json, key: str) -> list[dict[str, str]]:
    """Return named texts: variants of a file."""
    rows = list_field(said, key, MAX_VARIANTS)
    if not all(isinstance(row, dict) and row.keys() == {"name", "text"} for row in rows):
        raise InvalidMessageError
    return [{"name": text_field(row, "name", 100), "text": text_field(row, "text")} for row in rows]


def _amounts_field(said: Json, key: str) -> list[Json]:
    """Return amounts of moves, by what moves."""
    rows = list_field(said, key, 40)
    if not all(isinstance(row, dict) and row.keys() == {"id", "amount"} for row in rows):
        raise InvalidMessageError
    return [
        {"id": text_field(r, "id", 60), "amount": bounded_number(r["amount"], most=1e6)}
        for r in rows
    ]


def _names_field(said: Json, key: str) -> list[str]:
    return [text_field({key: name}, key, 60) for name in list_field(said, key, 60)]


def _texts_field(said: Json, key: str) -> list[str]:
    """Return what is said of a recording: channels, and rules of what looks wrong in them."""
    return [text_field({key: row}, key, 300) for row in list_field(said, key, 200)]


def _boolean_field(said: Json, key: str) -> bool:
    if not isinstance(said[key], bool):
        raise InvalidMessageError
    return said[key]


def _one_of(*choices: str) -> ArgumentReader:
    def read(said: Json, key: str) -> str:
        if said[key] not in choices:
            raise InvalidMessageError
        return str(said[key])

    return read


def _files_field(said: Json, key: str) -> list[int]:
    """Return files by their numbers in the workspace."""
    return [integer_field({key: row}, key, 10_000) for row in list_field(said, key, MAX_VARIANTS)]


DRIVELINE_INDEX_ARGUMENT_READERS: dict[str, ArgumentReader] = {"line": _integer_below(100)}
PASTED_POINTS_ARGUMENTS: dict[str, ArgumentReader] = {
    "points": _text_up_to(20_000),
    "unit": _text_up_to(),
    "axes": _text_up_to(),
}
FORM_ARGUMENTS: dict[str, ArgumentReader] = {
    "title": _text_up_to(300),  # as a file's
    **{
        key: _text_up_to()
        for key in (
            *("speed", "torque", "engine_speed", "engine_torque", "ratios", "reverse", "limits"),
            *("joint", "joint_name", "joint_peak", "joint_reversing", "joint_bearing"),
            *("joint_angle", "wheelbase_from", "wheelbase_to"),
        )
    },
    **PASTED_POINTS_ARGUMENTS,
    "members": _rows_of_texts(("side", "top"), 8),
    "shafts": _rows_of_texts(
        ("length", "phase", "tube", "outer", "wall", "bearing", "vertical", "lateral"), 6
    ),
}

JOB_ARGUMENTS: dict[str, dict[str, ArgumentReader]] = {
    "speeds": {"line": _integer_below(100), "state": _integer_below(1000)},
    "torsion": {},
    "guided": FORM_ARGUMENTS,
    "fix": {**DRIVELINE_INDEX_ARGUMENT_READERS, "hold": _names_field},
    "map": {
        **DRIVELINE_INDEX_ARGUMENT_READERS,
        "x": _text_up_to(60),
        "y": _text_up_to(60),
        "sought": _boolean_field,
    },
    "moved": {**DRIVELINE_INDEX_ARGUMENT_READERS, "moves": _amounts_field},
    "yield": {
        **DRIVELINE_INDEX_ARGUMENT_READERS,
        "sigmas": _rows_of_texts(("id", "amount"), 40),
        "sought": _boolean_field,
        "count": _integer_below(65_537),
    },
    "limits": {},
    "library": {},
    "script": {**DRIVELINE_INDEX_ARGUMENT_READERS, "saved": text_field, "hold": _names_field},
    "report": {
        "kind": _one_of(*(medium.name for medium in REPORT_MEDIA), "xlsx", "json"),
        "lang": _text_up_to(8),
    },
    "deviate": {
        "which": _integer_below(500),
        "normal": _text_up_to(40),
        "maximum": _text_up_to(40),
        "reason": _text_up_to(1000),
        "by": _text_up_to(200),
    },
    "ghost": {},
    "recording": {},
    "life": {
        **dict.fromkeys(("gauges", "mask", "accept"), _texts_field),
        **{key: _text_up_to(300) for key in ("speed", "torque", "engine", "tacho")},
        **dict.fromkeys(
            ("amplitude", "cycles", "slope", "first", "last", "hours", "modulus"), _text_up_to(40)
        ),
        "zero": _one_of("none", "start", "median", "drift"),
    },
    "drive": {"drive": _integer_below(10_000)},
    "campaign": {},
    "bracket": {},
    "compare": {"variants": variants_field, "files": _files_field},
    "pasted": {**PASTED_POINTS_ARGUMENTS, **DRIVELINE_INDEX_ARGUMENT_READERS},
}
"""By job and argument."""

"""Wrong files by the thousand: an answer, a refusal that names the place, and nothing else.

A good file is taken apart and changed where its own schema says what stands there: numbers
into plausible wrong ones (another unit, a lost sign, a swapped neighbour) and into what no
driveline has, texts into code, lists into none or thousands, keys left out, given to the
wrong table, or added from the schema. What comes out is read and assessed: it may be refused
(`InvalidFileError`, `DesignError`), it may not raise anything else, nor take long.

`CARDAN_FUZZ=20000 python -m pytest tests/property/test_files_fuzz.py` tries more than the
hundred of every run; CARDAN_FUZZ_SEED takes others.
"""

import copy
import os
import time
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from cardan.application.json_schema import application_schema
from cardan.application.reader import loads
from cardan.application.source_location import error_with_location
from cardan.application.templates import template_text
from cardan.approval.approval import approve_driveline
from cardan.core.errors import DesignError, InvalidFileError

ROOT = Path(__file__).parents[2]
COUNT = int(os.environ.get("CARDAN_FUZZ", "100"))
SEED = int(os.environ.get("CARDAN_FUZZ_SEED", "1"))
OUT = os.environ.get("CARDAN_FUZZ_OUT", "")
"""A folder for what breaks, to look at all of it; without one the first ends the run."""
LONG = 2.0
"""Seconds of processor time in which a file is answered; the first answer also pays imports."""

SCHEMA = application_schema()
EXAMPLES = sorted((ROOT / "examples").glob("*.yaml"))
BASES = [
    yaml.safe_load(text)
    for text in [
        template_text("small"),
        template_text("truck"),
        *(p.read_text(encoding="utf-8") for p in EXAMPLES),
    ]
]

FACTORS = [25.4, 1 / 25.4, 10, 0.1, 100, 0.01, 1e3, 1e-3, 60, 1 / 60, 57.3, 1 / 57.3, 4.45, 9.81,
           2, 0.5, -1, 1.2, 0.8]  # fmt: skip
NUMBERS = [0, -0.0, 1, -1, 5e-324, 1e-300, 1e-30, 1e-9, 1e9, 1e12, 1e13, 1e300, 90, 89.999, 75, 180,
           0.5, 100, 2**63, -(2**63), float("nan"), float("inf")]  # fmt: skip
TEXTS = ["", " ", "\x1b]0;x\x07", "\x00", "\u202egvw", "\u2066", "\ufffe", "gvw",
         "<script>alert(1)</script>",
         "=1+1", "{{7*7}}", "%s%n", "../../etc/passwd", "/etc/passwd", "a" * 100_000, "\n\n\n", "'",
         '"', "👩\u200d🔧", "no", "null", "2,7", "1e9", "windup", "full rebound", "long-haul",
         "heavy-truck", "elbe", "1810", "120x4", "𝕏" * 300]  # fmt: skip
OTHERS = [None, True, [], {}, [[]], [None], {"a": None}, [1, 2, 3], {1: [0, 1]}, "x", 7]
COUNTS = [0, 1, 2, 5, 13, 201, 2001]


class Fuzz:
    """Changes of one file, drawn from a generator so that a seed repeats them."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)

    def pick(self, some: Any) -> Any:
        return some[int(self.rng.integers(len(some)))]

    def changed(self, document: Any) -> Any:
        document = copy.deepcopy(document)
        for _ in range(self.pick([1, 1, 1, 2, 3, 6])):
            holder, key, rule = self.pick(list(places(document, SCHEMA)))
            if isinstance(holder, dict) and self.rng.random() < 0.1:
                holder.pop(key, None)
            elif isinstance(holder, dict) and self.rng.random() < 0.15:
                self.add(holder, rule["within"])
            elif self.rng.random() < 0.06:
                other, its, _ = self.pick(list(places(document, SCHEMA)))
                if key in holder if isinstance(holder, dict) else True:
                    holder[key] = copy.deepcopy(other[its])
            elif not isinstance(holder, dict) or key in holder:
                holder[key] = self.wrong(holder[key], rule["schema"])
        return document

    def add(self, holder: dict[Any, Any], within: dict[str, Any]) -> None:
        """Add a key that the schema knows there, with a value it describes or nearly so."""
        known = resolved(within).get("properties", {})
        if known:
            key = self.pick(list(known))
            holder[key] = self.made(known[key])

    def made(self, rule: dict[str, Any], depth: int = 0) -> Any:
        rule = resolved(rule)
        if "anyOf" in rule:
            return self.made(self.pick(rule["anyOf"]), depth)
        if "enum" in rule:
            return self.pick(rule["enum"])
        kind = rule.get("type")
        if kind == "object" and depth < 4:
            made = {}
            for key, value in rule.get("properties", {}).items():
                if key in rule.get("required", ()) or self.rng.random() < 0.3:
                    made[key] = self.made(value, depth + 1)
            if rule.get("additionalProperties"):
                made[self.pick([1, 2, "gvw", "main", "a"])] = self.made(
                    rule["additionalProperties"], depth + 1
                )
            return made
        if kind == "array" and depth < 5:
            count = rule.get("minItems", 0) + int(self.rng.integers(3))
            if rule.get("maxItems") == rule.get("minItems"):
                count = rule.get("minItems", 0)
            return [self.made(rule["items"], depth + 1) for _ in range(count)]
        if kind in ("number", "integer"):
            return self.number(self.rng.normal() * 10 ** self.rng.uniform(-3, 4), rule)
        return self.pick(TEXTS) if kind != "boolean" else self.pick([True, False])

    def number(self, value: float, rule: dict[str, Any]) -> Any:
        """Return a plausible wrong number, one at a bound, or one from nowhere."""
        bounds = [
            rule[b]
            for b in ("minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum")
            if b in rule
        ]
        draw = self.rng.random()
        if draw < 0.55:
            return float(value) * self.pick(FACTORS)
        if draw < 0.75 and bounds:
            return self.pick(bounds) * self.pick([1, 1, 0.999, 1.001, 0.5, 2])
        return self.pick(NUMBERS)

    def wrong(self, value: Any, rule: dict[str, Any]) -> Any:
        """Return something else in place of a value."""
        draw = self.rng.random()
        if draw < 0.08:
            return copy.deepcopy(self.pick(OTHERS))
        if draw < 0.16:
            return self.made(rule)
        if isinstance(value, bool):
            return not value
        if isinstance(value, (int, float)):
            return self.number(value, resolved(rule))
        if isinstance(value, str):
            return self.pick(TEXTS)
        if isinstance(value, list) and value:
            how = self.pick(["times", "reverse", "less", "one", "scaled"])
            if how == "times":
                return [copy.deepcopy(v) for v in value] * self.pick(COUNTS)
            if how == "reverse":
                return value[::-1]
            if how == "less":
                return value[:-1]
            if how == "scaled":
                factor = self.pick(FACTORS)
                return scaled(value, factor)
            return value[:1]
        if isinstance(value, dict) and value:
            if self.rng.random() < 0.2:
                return {f"{k}{n}": v for n in range(self.pick(COUNTS)) for k, v in value.items()}
            return {self.pick(TEXTS) if self.rng.random() < 0.3 else k: v for k, v in value.items()}
        return self.pick(OTHERS)


def scaled(value: Any, factor: float) -> Any:
    """Return a list with every number in it times a factor."""
    if isinstance(value, list):
        return [scaled(v, factor) for v in value]
    plain = isinstance(value, (int, float)) and not isinstance(value, bool)
    return value * factor if plain else value


def resolved(rule: dict[str, Any]) -> dict[str, Any]:
    while "$ref" in rule:
        rule = SCHEMA["$defs"][rule["$ref"].rpartition("/")[2]]
    return rule


def places(node: Any, rule: dict[str, Any]) -> Iterator[tuple[Any, Any, dict[str, Any]]]:
    """Yield every value of a document: what holds it, under which key, by which schema."""
    rule = resolved(rule)
    if isinstance(node, dict):
        inside = next((r for r in map(resolved, choices(rule)) if r.get("type") == "object"), {})
        for key, value in node.items():
            own = inside.get("properties", {}).get(key, inside.get("additionalProperties") or {})
            yield node, key, {"schema": own, "within": inside}
            yield from places(value, own)
    elif isinstance(node, list):
        inside = next((r for r in map(resolved, choices(rule)) if r.get("type") == "array"), {})
        for k, value in enumerate(node):
            own = inside.get("items", {})
            yield node, k, {"schema": own, "within": {}}
            yield from places(value, own)


def choices(rule: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield a rule's alternatives, or itself."""
    yield from (c for r in rule.get("anyOf", [rule]) for c in [resolved(r)])


def text_of(document: Any) -> str:
    return yaml.safe_dump(document, allow_unicode=False, sort_keys=False, width=200)


def answered(text: str) -> str:
    """Read and assess a text: how it was answered; raises whatever is no answer."""
    with warnings.catch_warnings():
        # A RuntimeWarning is for whoever looks into a room; here a file must be answered.
        warnings.simplefilter("ignore")
        try:
            application = loads(text, name="f.yaml")
        except InvalidFileError as error:
            return _told([p.format_with_location("f.yaml") for p in error.problems], "refused")
        try:
            approve_driveline(application)
        except DesignError as error:
            return _told(
                [error_with_location(error, application, "f.yaml")], "refused when assessed"
            )
    found = [w.format_with_location("f.yaml") for w in application.warnings]
    return _told(found, "warned") if found else "silent"


def _told(lines: list[str], how: str) -> str:
    """Return how a file was answered, if every line of the answer says where."""
    assert lines
    for line in lines:
        assert line.isprintable()
        assert line.startswith("f.yaml:")
    return how


@pytest.mark.slow
@pytest.mark.parametrize("part", range(10))
def test_invalid_file_never_crashes_or_hangs_reader(part):
    counts: dict[str, int] = {}
    for k in range(part, COUNT, 10):
        fuzz = Fuzz(SEED * 1_000_003 + k)
        text = text_of(fuzz.changed(fuzz.pick(BASES)))
        started = time.process_time()
        try:
            how = answered(text)
        except Exception as error:  # noqa: BLE001  whatever it is, it is what we look for
            how = "broken"
            if not OUT:
                pytest.fail(f"change {k} of seed {SEED}: {error!r}\n{text[:5000]}")
            (Path(OUT) / f"{k}.yaml").write_text(f"# {error!r:.300}\n{text}", encoding="utf-8")
        if how != "broken" and time.process_time() - started > LONG:
            started = time.process_time()
            answered(text)
            took = time.process_time() - started
            assert took < LONG, f"change {k} of seed {SEED} took {took:.1f} s\n{text[:5000]}"
        counts[how] = counts.get(how, 0) + 1
    print(counts)  # noqa: T201  what a long run wants to know
    assert "broken" not in counts, counts


@pytest.mark.slow
def test_fuzz_base_files_are_evaluated():
    """Else every change would be refused for what was wrong before it."""
    assert {answered(text_of(base)) for base in BASES} == {"silent"}

"""Approvals as SARIF, which code hosts show at the line of the file that a result concerns.

A result a criterion (one limit on one line of shafts): exceeded ones are errors, those beyond
what is recommended are warnings, and required limits without a value are errors too. Rules are
the quantities, by their keys. Source: OASIS, SARIF Version 2.1.0, 27 March 2020.
"""

import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote

from cardan.application.source_location import locate_yaml_address
from cardan.approval.approval import Approval
from cardan.core.labels import Part
from cardan.core.verdict import Check, UnevaluatedCheck
from cardan.core.version import __version__
from cardan.documents.criteria import criteria_of, full_condition_text, full_name, limit_qualifiers
from cardan.model.application import Application
from cardan.render.check_texts import limit_text, unit_text, value_text
from cardan.render.i18n import Translator
from cardan.render.phrases import limit_grouping_key

SARIF_VERSION = "2.1.0"
SARIF_SCHEMA = (
    "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"
)
"""Name of the schema that the log follows; nothing is fetched from there."""

_LEVELS = {"fail": "error", "warn": "warning"}

_LINE_KEYS = {
    "joint": "joints[{number}]",
    "shaft": "shafts[{number}]",
    "clearance": "shafts[{number}]",
    "centre bearing": "shafts[{number}].centre_bearing",
}
"""Keys of a line by the kind of part that they describe."""

_TABLES = {
    "vehicle": "vehicle", "front axle": "vehicle", "driven rear axle": "vehicle",
    "rear axle": "vehicle", "auxiliary axle": "vehicle", "engine": "engine",
    "gearbox": "gearbox", "pinion": "axle", "axle housing": "axle", "sheet": "bracket",
    "cut edge": "bracket", "weld toe": "bracket", "bolt border": "bracket", "bolts": "bracket",
    "hot spot": "bracket", "gauge": "bracket", "clutch": "clutch",
}  # fmt: skip
"""Sections of a file by the kind of part that they describe."""


def sarif_text(found: Iterable[tuple[str, Approval]], say: Translator) -> str:
    """Return a SARIF log of approvals as text; see `sarif_log`."""
    return json.dumps(sarif_log(found, say), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def sarif_log(found: Iterable[tuple[str, Approval]], say: Translator) -> dict[str, Any]:
    """Return a SARIF log of approvals, each with the path of its file as it was given."""
    results = [one for name, of in found for one in _results(name, of, say)]
    rules = [
        {"id": key, "shortDescription": {"text": say.name(key)}}
        for key in sorted({one["ruleId"] for one in results})
    ]
    driver = {"name": "cardan", "semanticVersion": __version__, "rules": rules}
    return {
        "$schema": SARIF_SCHEMA,
        "version": SARIF_VERSION,
        "runs": [{"tool": {"driver": driver}, "columnKind": "unicodeCodePoints",
                  "results": results}],
    }  # fmt: skip


def _results(name: str, of: Approval, say: Translator) -> Iterator[dict[str, Any]]:
    """Yield the results of one file, the worst first."""
    missed = {limit_grouping_key(u): u for u in of.coverage.unevaluated if u.limit.required}
    named = limit_qualifiers([*of.checks, *missed.values()], of.application)
    for criterion in criteria_of(of.checks):
        c = criterion.worst
        if c.grade in _LEVELS:
            value = f"{value_text(c, say)} {unit_text(c)}".rstrip()
            text = (
                f"{full_name(c, say, named)}: {say.join(value, limit_text(c, say))}; "
                f"{say('worst case')}: {full_condition_text(c, say)}; {c.limit.source}"
            )
            yield _result(name, of.application, c, _LEVELS[c.grade], text)
    for u in missed.values():
        needs = "; ".join(say.translate_if_known(need) for need in u.missing_inputs)
        reason = say("(input missing: {inputs})", inputs=needs) if needs else ""
        text = f"{full_name(u, say, named)}: {say('not evaluated')} {reason}".rstrip()
        yield _result(name, of.application, u, "error", text)


def _result(
    name: str, application: Application, of: Check | UnevaluatedCheck, level: str, text: str
) -> dict[str, Any]:
    """Return one result at the line of the key that describes its part."""
    at = locate_yaml_address(application, _address(of.line, of.part))
    region = {"startLine": at.line, "startColumn": at.column} if at else {"startLine": 1}
    place = {"artifactLocation": {"uri": _uri(name)}, "region": region}
    limit = of.limit
    bound = "maximum" if limit.normal is None and limit.band is None else "recommended"
    states = "+".join(sorted(limit.states or {"all states"}))
    criterion = (of.line, of.quantity, limit.sense, bound, states)
    return {
        "ruleId": of.quantity,
        "level": level,
        "message": {"text": text},
        "locations": [{"physicalLocation": place}],
        # Stays the same while lines move in the file and values change.
        "partialFingerprints": {"cardanCriterion/v1": "/".join(criterion)},
    }


def _address(line: str, part: Part) -> str:
    """Return the key that describes a part; its line's or the vehicle's where none does."""
    if not line or part.kind in _TABLES:
        return _TABLES.get(part.kind, "vehicle")
    key = _LINE_KEYS.get(part.kind, "").format(number=part.number)
    return f"drivelines.{line}.{key}".rstrip(".")


def _uri(name: str) -> str:
    """Return a file's path as a URI: relative as it was given, absolute with its scheme."""
    path = Path(name)
    return path.as_uri() if path.is_absolute() else quote(path.as_posix())

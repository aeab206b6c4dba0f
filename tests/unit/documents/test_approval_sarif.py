"""The SARIF log, held against rules of SARIF 2.1.0 and against the JSON contract."""

import json
from urllib.parse import unquote

import jsonschema
import pytest
from click.testing import CliRunner
from repository import EXAMPLES

from cardan.application import reader
from cardan.approval.approval import approve_application
from cardan.cli import cli
from cardan.documents.approval_json import json_document
from cardan.documents.approval_sarif import sarif_log
from cardan.render.i18n import ENGLISH, Translator

COUNTED_FROM_1 = {"type": "integer", "minimum": 1}
SARIF_RULES = {  # SARIF 2.1.0: 3.13, 3.14, 3.18, 3.19, 3.27, 3.29, 3.30
    "required": ["version", "runs"],
    "properties": {
        "version": {"const": "2.1.0"},
        "runs": {"minItems": 1, "items": {
            "required": ["tool", "results"],
            "properties": {
                "tool": {"required": ["driver"], "properties": {"driver": {
                    "required": ["name"],
                    "properties": {"rules": {"uniqueItems": True, "items": {"required": ["id"]}}},
                }}},
                "results": {"items": {
                    "required": ["message", "ruleId", "locations"],
                    "properties": {
                        "level": {"enum": ["none", "note", "warning", "error"]},
                        "message": {"required": ["text"]},
                        "partialFingerprints": {"additionalProperties": {"type": "string"}},
                        "locations": {"minItems": 1, "items": {"properties": {
                            "physicalLocation": {
                                "required": ["artifactLocation"],
                                "properties": {
                                    "artifactLocation": {"properties": {
                                        "uri": {"pattern": r"^[A-Za-z0-9._~:/%-]+$"},
                                    }},
                                    "region": {"properties": {
                                        "startLine": COUNTED_FROM_1, "startColumn": COUNTED_FROM_1,
                                    }},
                                },
                            },
                        }}},
                    },
                }},
            },
        }},
    },
}  # fmt: skip


def place_of(result):
    return result["locations"][0]["physicalLocation"]


def levels(results):
    return {(r["ruleId"], r["level"]) for r in results}


@pytest.mark.parametrize("example", ["van", "medium-truck-4x2"])
def test_sarif_holds_each_criterion_that_is_not_met(example):
    found = approve_application(reader.read(EXAMPLES / f"{example}.yaml"))
    log = sarif_log([(f"trucks/{example}.yaml", found)], ENGLISH)
    jsonschema.validate(log, SARIF_RULES)
    (run,) = log["runs"]
    worse = {"fail": "error", "warn": "warning"}
    checks = [c for c in json_document(found)["checks"] if c["verdict"] in worse]
    failed = {c["quantity"] for c in checks if c["verdict"] == "fail"}
    assert {q for q, level in levels(run["results"]) if level == "error"} == failed
    assert {q for q, _ in levels(run["results"])} == {c["quantity"] for c in checks}
    rules = [rule["id"] for rule in run["tool"]["driver"]["rules"]]
    assert set(rules) == {r["ruleId"] for r in run["results"]}
    prints = [r["partialFingerprints"]["cardanCriterion/v1"] for r in run["results"]]
    assert len(set(prints)) == len(prints)
    assert {place_of(r)["artifactLocation"]["uri"] for r in run["results"]} == {
        f"trucks/{example}.yaml"
    }


TIPPER = """title: "Tipper"
speed_rpm: 2500
torque_Nm: 1500
driveline:
  joints: ["2030", "2030", "2030"]
  slopes: {side_deg: [3, 1, 12, 2]}
  shafts:
    - {length_mm: 1200, tube: 90x3, centre_bearing: {from_rear_joint_mm: 140}}
    - {length_mm: 1500}
limits: body-builder
"""


def test_result_stands_at_the_line_of_its_part_and_missing_input_is_an_error(tmp_path):
    (tmp_path / "a tipper.yaml").write_text(TIPPER, "utf-8")
    file, out = tmp_path / "a tipper.yaml", tmp_path / "out.sarif"
    result = CliRunner().invoke(cli, ["check", str(file), "--sarif", str(out), "-q"])
    assert result.exit_code == 1, result.output
    log = json.loads(out.read_text("utf-8"))
    jsonschema.validate(log, SARIF_RULES)
    results = log["runs"][0]["results"]
    text = TIPPER.splitlines()
    at = {r["ruleId"]: text[place_of(r)["region"]["startLine"] - 1] for r in results}
    assert "joints" in at["joint_angle"]
    missing = [r for r in results if "input missing" in r["message"]["text"]]
    assert missing
    assert {r["level"] for r in missing} == {"error"}
    uri = place_of(results[0])["artifactLocation"]["uri"]
    assert uri.startswith("file:///")
    assert unquote(uri.removeprefix("file://")) == str(file)


def test_part_of_a_shaft_stands_at_its_shaft():
    found = approve_application(reader.read(EXAMPLES / "refuse-collector-6x2.yaml"))
    text = (EXAMPLES / "refuse-collector-6x2.yaml").read_text("utf-8").splitlines()
    log = sarif_log([("a.yaml", found)], Translator("pt"))
    (clearance,) = (r for r in log["runs"][0]["results"] if r["ruleId"] == "clearance")
    (bearing,) = (r for r in log["runs"][0]["results"] if r["ruleId"] == "centre_bearing_dynamic")
    starts = [k for k, line in enumerate(text, 1) if line.startswith("    - tube")]
    assert place_of(clearance)["region"]["startLine"] == starts[2]
    assert "centre_bearing" in text[place_of(bearing)["region"]["startLine"] - 1]
    assert "pior caso" in clearance["message"]["text"]

"""The JUnit report, read by a parser that knows nothing of this program."""

import xml.etree.ElementTree as ET

import pytest
from click.testing import CliRunner
from repository import EXAMPLES

from cardan.application import reader
from cardan.approval.approval import approve_application
from cardan.cli import cli
from cardan.documents.approval_json import json_document
from cardan.documents.approval_junit import junit_xml


def suites(*found):
    return list(ET.fromstring(junit_xml(found)))


@pytest.mark.parametrize("example", ["van", "medium-truck-4x2"])
def test_junit_counts_what_the_json_contract_holds(example):
    found = approve_application(reader.read(EXAMPLES / f"{example}.yaml"))
    (suite,) = suites((example, found))
    document = json_document(found)
    verdicts = [c["verdict"] for c in document["checks"]]
    open_points = document["coverage"]["unanswered"]
    assert int(suite.get("tests")) == len(verdicts) + len(open_points) == len(suite)
    assert int(suite.get("failures")) == verdicts.count("fail")
    assert len(suite.findall("testcase/system-out")) == verdicts.count("warn")
    assert int(suite.get("skipped")) == sum(not o["required"] for o in open_points)
    assert int(suite.get("errors")) == sum(o["required"] for o in open_points)
    bounds = sum(c.get("is_lower_bound", False) for c in document["checks"])
    assert ET.tostring(suite, "unicode").count("at least ") == bounds
    names = [(case.get("classname"), case.get("name")) for case in suite]
    assert len(set(names)) == len(names)


INCOMPLETE = """title: "Tipper"
speed_rpm: 2500
torque_Nm: 1500
driveline:
  joints: "2030"
  slopes: {side_deg: [3, 1, 4.5, 2]}
  shafts:
    - {length_mm: 1200, tube: 90x3, centre_bearing: {from_rear_joint_mm: 140}}
    - {length_mm: 1500}
limits: body-builder
"""


def test_required_check_not_evaluated_is_an_error(tmp_path):
    """Without the second tube the line is INCOMPLETE: no server may show that as passed."""
    (tmp_path / "a.yaml").write_text(INCOMPLETE, "utf-8")
    files = [str(tmp_path / "a.yaml"), str(EXAMPLES / "van.yaml")]
    out = tmp_path / "out.xml"
    result = CliRunner().invoke(cli, ["check", *files, "--junit", str(out), "-q"])
    assert result.exit_code == 1, result.output
    first, second = ET.fromstring(out.read_bytes())
    assert (first.get("name"), int(first.get("failures"))) == (files[0], 0)
    assert int(first.get("errors")) > 0
    assert int(second.get("errors")) == 0


def test_name_that_no_xml_may_hold_is_replaced():
    found = approve_application(reader.loads(INCOMPLETE, name="a.yaml"))
    (suite,) = suites(("a\x07\x1b.yaml", found))
    assert suite.get("name") == "a\ufffd\ufffd.yaml"

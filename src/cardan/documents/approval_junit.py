"""Approvals as a JUnit test report, which servers of continuous integration show as it is.

A suite a file, a test case a check: a failed check is a failure, a required one that could not be
evaluated an error, any other that was not evaluated is skipped. A warning passes, and stands in
the case's output. The names are those of the JSON contract, the same in every language.
"""

import re
from collections.abc import Iterable
from typing import Any
from xml.etree import ElementTree as ET

from cardan.approval.approval import Approval
from cardan.documents.approval_json import json_document

_NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What no XML document may hold, not even escaped (XML 1.0, production 2)."""


def junit_xml(found: Iterable[tuple[str, Approval]]) -> bytes:
    """Return a JUnit report of approvals, each with the name of its file."""
    root = ET.Element("testsuites", name="cardan check")
    for name, approval in found:
        _add_suite(root, name, json_document(approval))
    for key in ("tests", "failures", "errors", "skipped"):
        root.set(key, str(sum(int(suite.get(key, 0)) for suite in root)))
    ET.indent(root)
    text = ET.tostring(root, encoding="unicode", xml_declaration=False)
    return (
        '<?xml version="1.0" encoding="utf-8"?>\n' + _NOT_XML.sub("\ufffd", text) + "\n"
    ).encode()


def _add_suite(root: ET.Element, name: str, document: dict[str, Any]) -> None:
    """Add the suite of one file."""
    suite = ET.SubElement(root, "testsuite", name=name)
    for check in document["checks"]:
        bound = f"{check['sense']} {_number(check['limit'])} {check['unit']}".strip()
        case = _add_case(suite, check, bound)
        least = "at least " if check.get("is_lower_bound") else ""
        value = f"{least}{_number(check['value'])} {check['unit']}".strip()
        said = f"{value}, limit {bound}; {check['source']}"
        if check["verdict"] == "fail":
            ET.SubElement(case, "failure", message=said, type=check["quantity"])
        elif check["verdict"] == "warn":
            ET.SubElement(case, "system-out").text = f"warning: {said}"
    for open_point in document["coverage"]["unanswered"]:
        case = _add_case(suite, open_point, "not evaluated")
        kind = "error" if open_point["required"] else "skipped"
        ET.SubElement(case, kind, message=f"needs {'; '.join(open_point['needs'])}")
    for key, tag in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
        suite.set(key, str(len(suite.findall(f"testcase/{tag}"))))
    suite.set("tests", str(len(suite.findall("testcase"))))


def _add_case(suite: ET.Element, of: dict[str, Any], last: str) -> ET.Element:
    """Add the case of one check: its line as the class, quantity, part, state and limit as name."""
    name = ", ".join(one for one in (of["quantity"], of["part"], of["state"], last) if one)
    return ET.SubElement(suite, "testcase", classname=of["line"] or "vehicle", name=name)


def _number(value: float | None) -> str:
    return "infinite" if value is None else f"{value:.6g}"

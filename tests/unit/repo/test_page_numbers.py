"""Numbers in the prose of the pages are those of today's program.

Output on the pages is printed while they are built; `test_report_pictures.py` has the pictures'.
"""

import json
import re
import runpy
from functools import cache

import pytest
import yaml
from repository import ROOT

import cardan
from cardan.application import reader
from cardan.application.templates import template_text

EFFECTS = runpy.run_path(str(ROOT / "docs/effects.py"))


@cache
def golden(example):
    return json.loads((ROOT / f"tests/golden/{example}.json").read_text(encoding="utf-8"))


@cache
def page(name):
    """Return a page's text in one line."""
    return " ".join((ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8").split())


def values(example, quantity, state=None):
    checks = golden(example)["checks"]
    return [c[4] for c in checks if c[0] == quantity and state in (None, c[2]) and c[4] is not None]


def smallest(example, quantity):
    return min(values(example, quantity))


def largest(example, quantity):
    return max(values(example, quantity))


def of_state(example, state, *keys):
    found = next(s for s in golden(example)["states"] if s["name"] == state)
    for key in keys:
        found = found[key]
    return found


COLLECTOR, CHAIN = "refuse-collector-6x2", "three-joint-chain"
OVERRUN = "coast", "acceleration_rad_s2"
STATED = [
    ("method", r"clears its beam by ([\d.]+) mm", lambda: smallest(COLLECTOR, "clearance")),
    ("method", r"it hits the beam by ([\d.]+) mm",
     lambda: -smallest(COLLECTOR, "clearance_on_rubber")),
    ("method", r"([\d.]+) mm off the beam in bump",
     lambda: of_state(COLLECTOR, "jounce", "clearances_mm", "auxiliary beam")),
    ("method", r"comes within ([\d.]+) mm when it pulls",
     lambda: smallest(COLLECTOR, "clearance")),
    ("method", r"laden in overrun: ([\d.]+) rad/s² instead of",
     lambda: of_state(COLLECTOR, "gvw", "approximations", "in_plane", *OVERRUN)),
    ("method", r"laden in overrun: [\d.]+ rad/s² instead of ([\d.]+)",
     lambda: of_state(COLLECTOR, "gvw", *OVERRUN)),
    ("index", r"shaft 3 comes within ([\d.]+) mm", lambda: smallest(COLLECTOR, "clearance")),
    ("studies", r"give ([\d.]+) checks", lambda: len(golden(COLLECTOR)["checks"])),
    ("studies", r"limits of ([\d.]+) quantities",
     lambda: len({c[0] for c in golden(COLLECTOR)["checks"]})),
    *((name, rf"{word} ([\d.]+) rad/s²", lambda: largest(CHAIN, "torsional_acceleration"))
      for name, word in (("tutorial", "acceleration is"), ("inicio.pt", "torcional é"),
                         ("inizio.it", "torsionale è"))),
]  # fmt: skip
"""Page, words with a number, and where it is from."""


@pytest.mark.parametrize(("name", "words", "now"), STATED, ids=[f"{n}: {w}" for n, w, _ in STATED])
def test_number_in_prose_is_of_today(name, words, now):
    stated = re.findall(words, page(name))
    assert stated, "the page no longer has these words"
    for number in stated:
        digits = len(number.partition(".")[2])
        assert float(number) == pytest.approx(now(), abs=0.51 * 10.0**-digits)


def test_decay_of_examples_on_rubber_lies_in_stated_range():
    low, high = map(
        float,
        re.findall(r"decay of the examples.*?(\d+) to (\d+) per second", page("verification"))[0],
    )
    found = [
        -v for p in (ROOT / "tests/golden").glob("*.json") for v in values(p.stem, "swing_growth")
    ]
    assert low <= round(min(found))
    assert round(max(found)) <= high


def travels(node):
    """Yield each travel of a bearing on linear rubber, mm, in a part of a document."""
    if isinstance(node, dict):
        if "travel_mm" in (node.get("travel") or ()):
            yield node["travel"]["travel_mm"]
        node = list(node.values())
    for item in node if isinstance(node, list) else ():
        yield from travels(item)


def test_travel_of_linear_rubber_lies_in_stated_range():
    """Of the examples whose rubber would go beyond the stop that is assumed, 15 mm."""
    (stated,) = re.findall(r"would move by (\d+) to (\d+) mm in the examples", page("method"))
    documents = (golden(p.stem) for p in (ROOT / "tests/golden").glob("*.json"))
    largest_of = [max(travels(d["states"]), default=0.0) for d in documents]
    beyond = [travel for travel in largest_of if travel > 15]
    assert [f"{min(beyond):.0f}", f"{max(beyond):.0f}"] == list(stated)


@pytest.mark.parametrize("name", [*EFFECTS["PARTS"], *EFFECTS["EFFECTS"]])
def test_change_of_effect_table_applies_to_its_examples(name):
    """Each pattern is in the file, and the text so changed is still YAML."""
    if name in EFFECTS["PARTS"]:
        trucks, changes = [file for file, _ in EFFECTS["TRUCKS"].values()], EFFECTS["PARTS"][name]
    else:
        effect = EFFECTS["EFFECTS"][name]
        trucks, changes = [COLLECTOR], (*effect.on, *effect.change)
    for truck in trucks:
        assert yaml.safe_load(EFFECTS["changed_text"](truck, changes))
    with pytest.raises(ValueError, match="is not in the file"):
        EFFECTS["changed_text"](COLLECTOR, (("no such key", ""),))


@pytest.mark.parametrize(
    ("key", "value"),
    [("wheelbase_mm", "189"), ("dynamic_radius_mm", "465"), ("pinion_slope: {side_deg", "-2.4")],
)
def test_warning_on_page_is_printed_for_starter(key, value):
    starter = template_text("truck")
    assert starter.count(f"{key}: ") == 1
    text = re.sub(rf"({re.escape(key)}: )[-\d.]+", rf"\g<1>{value}", starter)
    printed = [w.format_with_location("truck.yaml") for w in reader.loads(text).warnings]
    assert any(warning in page("application-file") for warning in printed), printed


@pytest.mark.slow
def test_launch_of_medium_truck_is_of_today():
    """Peak over T i, smooth and dropped, and the share of the joints, as the table has them."""
    application = cardan.read(ROOT / "examples/medium-truck-4x2.yaml")
    smooth, dropped = cardan.stability(application).to_dict()["vehicle"]["launches"]
    text = page("torsion")
    assert f"| half a second | {smooth['shares']['ramp']:.2f} |" in text
    ramp, sticking = (dropped["shares"][k] for k in ("ramp", "if tyres could not slide"))
    assert f"0.05 s | {ramp:.2f}; {sticking:.2f} if its tyres could not slide |" in text
    assert f"peak by {100 * smooth['shares']['joints']:.1f} % in the smooth" in text
    (passing, lasting) = (smooth["bearings"][0][k] for k in ("passing_N", "steady_N"))
    assert f"carries {passing:.0f} N" in text
    assert f"would give {lasting:.0f} N" in text

"""How far a centre bearing goes on its rubber: by hand, and against the stop that a file tells."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import cardan
from cardan import files
from cardan.cli import cli
from cardan.demand.states import demand, resolve
from cardan.quantity.quantities import QUANTITIES
from cardan.quantity.response import respond
from cardan.study.driveline import asked

EXAMPLES = Path(__file__).parents[2] / "examples"
COLLECTOR = (EXAMPLES / "refuse-collector-6x2.yaml").read_text(encoding="utf-8")
UP, LEVEL, LOSS = 200.0, 120.0, 0.1  # N/mm, and the share of it that the rubber loses
KEY = "centre_bearing_travel_utilisation"


def rods(speed: float, *, plane: str, more: str = "", torque: float = 1.0) -> str:
    """Two rods of 20 and 25 kg that bend in one plane: their crosses push square to it.

    A tube of next to no mass, and a third of the rod's at the joint where the bearing is: a mass
    of 15 kg on one spring.
    """
    light = "{name: light, youngs_modulus_GPa: 2000, density_kg_m3: 50}"
    own = 50 * np.pi * 0.4999 * 0.0001  # kg/m of the tube, and kg m of it about a diameter
    about = own * 0.25**2 / 2
    thin = f"tube: {{outer_mm: 500, wall_mm: 0.1, material: {light}}}"
    front, rear = (20 - 1.2 * own) / 3 - about / 1.2, (25 - 1.5 * own) / 3 - about / 1.5
    bent, flat = "[3, 1, 4.5, 2]", "[0, 0, 0, 0]"
    side, top = (bent, flat) if plane == "level" else (flat, bent)
    return f"""
title: Two slender shafts
torque_Nm: {torque}
speed_rpm: 2400
driveline:
  slopes: {{side_deg: {side}, top_deg: {top}}}
  shafts:
    - length_mm: 1200
      {thin}
      yoke_mass_kg: [0, {front}]
      polar_inertia_kgm2: 1e-7
      centre_bearing:
        from_rear_joint_mm: 0
        vertical_stiffness_N_mm: {UP}
        lateral_stiffness_N_mm: {LEVEL}
        loss_factor: {LOSS}
        {more}
    - length_mm: 1500
      {thin}
      yoke_mass_kg: [{rear}, 0]
      polar_inertia_kgm2: 1e-7
states: [{{name: here, speed_rpm: {speed}}}]
limits: protractor
"""


def told(folder: Path, text: str) -> dict:
    file, out = folder / "line.yaml", folder / "line.json"
    file.write_text(text, encoding="utf-8")
    done = CliRunner().invoke(cli, ["check", str(file), "--json", str(out), "-q"])
    assert done.exit_code in (0, 1), done.output
    return json.loads(out.read_text(encoding="utf-8"))


def bearing(folder: Path, text: str) -> dict:
    return told(folder, text)["states"][0]["centre_bearings"][0]


PLANES = pytest.mark.parametrize(("plane", "stiffness"), [("level", LEVEL), ("upright", UP)])


@PLANES
def test_slowly_it_goes_by_its_force_over_its_stiffness(tmp_path, plane, stiffness):
    """The mean of crosses that bend in a plane lies in it, and order 2 goes round in a circle.

    So the mean presses the rubber of its own way, and order 2 goes farthest where that is softer:
    at standstill, as rubber that turns loses, and is stiffer.
    """
    found = bearing(tmp_path, rods(10, plane=plane))
    steady, swing = np.linalg.norm(found["static_N"]), found["orders"]["2"]
    goes = found["on_rubber"]["travel"]
    assert goes["steady_mm"] == pytest.approx(steady / stiffness, rel=1e-5)
    assert goes["travel_mm"] == pytest.approx(steady / stiffness + swing / LEVEL, rel=1e-3)
    assert goes["speed_rpm"] == 0
    assert goes["stop_mm"] is None


def swung(swing: float, speed: np.ndarray) -> np.ndarray:
    """Return how far a force that goes round twice a turn swings 15 kg on two springs, in mm.

    Level x and upright y are masses on one spring each, x = F/(k (1 + iη) - m W²); half the
    longer axis of the ellipse of (x, i y) is √((|x|² + |y|² + |x² - y²|)/2).
    """
    W = 2 * speed * np.pi / 30
    x, y = (swing / (1000 * k * (1 + 1j * LOSS) - 15 * W**2) for k in (LEVEL, UP))
    return 1000 * np.sqrt((abs(x) ** 2 + abs(y) ** 2 + abs(x**2 - y**2)) / 2)


@PLANES
@pytest.mark.parametrize("top", [300, 800])
def test_in_resonance_it_goes_as_a_mass_on_a_spring(tmp_path, plane, stiffness, top):
    """Its modes are at 427 and 551 rpm: at 300 it is worst at its highest speed, at 800 there."""
    found = bearing(tmp_path, rods(top, plane=plane))
    steady, swing = np.linalg.norm(found["static_N"]), found["orders"]["2"]
    speeds = np.arange(1.0, top + 0.5, 0.5)
    closed = swung(swing, speeds)
    goes = found["on_rubber"]["travel"]
    assert goes["travel_mm"] == pytest.approx(steady / stiffness + closed.max(), rel=2e-3)
    assert goes["speed_rpm"] == pytest.approx(speeds[closed.argmax()], rel=2e-3)


def test_of_bracket_and_rubber_in_series_it_is_the_rubber_that_travels(tmp_path):
    """The same force goes through both, and a bracket as soft as the rubber gives as much."""
    seat = "bracket: {stiffness_N_mm: [1e6, 120, 200]}"
    alone, hung = (bearing(tmp_path, rods(10, plane="level", more=m)) for m in ("", seat))
    alone, hung = (b["on_rubber"]["travel"]["travel_mm"] for b in (alone, hung))
    assert hung == pytest.approx(alone, rel=0.01)


def test_weight_set_the_line_where_it_hangs(tmp_path):
    light, heavy = (bearing(tmp_path, rods(10, plane="level") + more)
                    for more in ("", "include: [gravity]\n"))  # fmt: skip
    assert heavy["static_N"][2] < light["static_N"][2] - 100
    light, heavy = (b["on_rubber"]["travel"]["steady_mm"] for b in (light, heavy))
    assert heavy == pytest.approx(light, rel=1e-6)


def without(key: str) -> str:
    """Return the collector without a key at its left edge."""
    return re.sub(rf"(?ms)^{key}:.*?(?=^\w|\Z)", "", COLLECTOR)


def stopped(at: str, *, bearings: int = 2) -> str:
    """Return the collector whose bearings' rubber ends somewhere."""
    return COLLECTOR.replace("centre_bearing: {", f"centre_bearing: {{travel_mm: {at}, ", bearings)


def test_a_stop_is_held_against_what_it_is_asked_of(tmp_path):
    """Its second bearing goes 41.0 mm in jounce: 42 hold that, 40 do not, and nobody asks else."""
    plain = told(tmp_path, COLLECTOR)
    assert not [c for c in plain["checks"] if c["quantity"] == KEY]
    assert not any("beyond its stop" in n for n in plain["notes"])
    goes = {
        (s["name"], k): b["on_rubber"]["travel"]["travel_mm"]
        for s in plain["states"] for k, b in enumerate(s["centre_bearings"], 1)
    }  # fmt: skip
    farthest = max(goes.values())
    assert farthest == goes["jounce", 2] == pytest.approx(40.99, abs=0.05)
    for stop, verdict in ((42, "pass"), (40, "fail")):
        found = told(tmp_path, stopped(str(stop)))
        checks = {(c["state"], c["part"]): c for c in found["checks"] if c["quantity"] == KEY}
        assert len(checks) == len(goes)
        for (state, k), mm in goes.items():
            one = checks[state, f"centre bearing {k}"]
            assert one["value"] == pytest.approx(mm / stop, rel=1e-6)
            assert one["limit"] == 1.0
        assert checks["jounce", "centre bearing 2"]["verdict"] == verdict
        assert checks["jounce", "centre bearing 2"]["mode"]["order"] == 2
        beyond = [n for n in found["notes"] if "beyond its stop" in n]
        assert len(beyond) == (verdict == "fail")
        others = [c for c in found["checks"] if c["quantity"] != KEY]
        assert others == plain["checks"]
        assert found["coverage"]["unanswered"] == plain["coverage"]["unanswered"]
    assert beyond[0].startswith(
        "centre bearing 2 of line main goes beyond its stop in jounce: up to 41 mm, where its "
        "rubber has 40"
    )


def test_a_stop_of_one_bearing_asks_about_that_one(tmp_path):
    text = stopped("20").replace("travel_mm: 20, ", "", 1)
    parts = {c["part"] for c in told(tmp_path, text)["checks"] if c["quantity"] == KEY}
    assert parts == {"centre bearing 2"}


def test_how_far_it_goes_is_told_where_no_stop_is_known(tmp_path):
    """Beside a stop that is known, and nothing in the way, the stop speaks for itself."""
    text = without("obstacles")
    loose = [n for n in told(tmp_path, text)["notes"] if "linear" in n]
    assert "centre bearing 2" in loose[0]
    kept = text.replace("centre_bearing: {", "centre_bearing: {travel_mm: 40, ")
    assert not [n for n in told(tmp_path, kept)["notes"] if "linear" in n]
    (other,) = (n for n in told(tmp_path, kept.replace("travel_mm: 40, ", "", 1))["notes"]
                if "linear" in n)  # fmt: skip
    assert "centre bearing 1" in other


def test_what_does_not_give_has_no_travel(tmp_path):
    file = tmp_path / "line.yaml"
    text = rods(10, plane="level", more="travel_mm: 15")
    for name, value in (("vertical", UP), ("lateral", LEVEL)):
        text = text.replace(f"{name}_stiffness_N_mm: {value}\n", "\n")
    file.write_text(text, encoding="utf-8")
    done = CliRunner().invoke(cli, ["check", str(file)])
    assert done.exit_code == 2
    assert "centre_bearing.travel_mm: what gives has a travel" in done.output


def test_a_limit_of_its_own_asks_how_far_and_says_what_is_missing(tmp_path):
    limits = "limits: [{quantity: centre_bearing_travel, unit: mm, maximum: 36, source: ours}]\n"
    checks = told(tmp_path, without("limits") + "\n" + limits)["checks"]
    failed = {(c["state"], c["part"]) for c in checks if c["verdict"] == "fail"}
    assert failed == {("jounce", "centre bearing 2")}
    rigid = rods(10, plane="level").replace("limits: protractor\n", limits)
    for name, value in (("vertical", UP), ("lateral", LEVEL)):
        rigid = rigid.replace(f"{name}_stiffness_N_mm: {value}\n", "\n")
    (one,) = told(tmp_path, rigid)["coverage"]["unanswered"]
    assert "the stiffness of a centre bearing" in one["needs"][0]


def test_stops_and_stiffness_vary_beside_each_other():
    """Of a batch each variant has the numbers that it has alone."""
    truck = files.loads(stopped("30"))
    at = "driveline.shafts[2].centre_bearing."
    drawn = {
        at + "travel_mm": np.array([20.0, 30.0, 40.0]),
        at + "lateral_stiffness_N_mm": np.array([100.0, 120.0, 150.0]),
    }

    def answers(changes):
        changed = files.change(truck, changes)
        r = respond(changed, demand(resolve(changed, changed.lines[0])))
        (one,) = (q.values for q in asked(r) if q.limit.quantity == KEY)
        return one, QUANTITIES["centre_bearing_travel"].values(r)

    together = answers(drawn)
    for k in range(3):
        alone = answers({name: float(values[k]) for name, values in drawn.items()})
        for found, expected in zip(together, alone, strict=True):
            assert found[k] == pytest.approx(expected, rel=1e-9)
    assert together[0][0].max() > 1.2 > together[0][2].max()


def test_a_study_counts_what_meets_its_stop():
    """Every variant's worst is the 40.99 mm of the second bearing in jounce, over its own stop."""
    at = "driveline.shafts[2].centre_bearing.travel_mm"
    found = cardan.study(files.loads(stopped("30")), {at: [35, 50]}, n=8).to_frame()
    assert list(found[KEY]) == pytest.approx(list(40.994 / found[at]), rel=1e-4)
    assert found[KEY].min() < 1 < found[KEY].max()

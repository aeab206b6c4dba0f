"""What a file leaves out, and an answer is the better for, is said: key by key, one at a time."""

import copy
from pathlib import Path

import pytest
import yaml

from cardan import files
from cardan.base.part import Occasion, Part
from cardan.base.source import ASSUMED
from cardan.base.units import deg, rpm
from cardan.base.verdict import Check, Limit
from cardan.quantity.quantities import QUANTITIES
from cardan.report import wording
from cardan.report.language import EN
from cardan.study.approval import assess

TRUCK = yaml.safe_load(
    (Path(__file__).parents[2] / "examples/medium-truck-4x2.yaml").read_text("utf-8")
)
SHAFTS = ("driveline", "shafts")
LACKING = {
    "nothing slides in the last shaft": [(*SHAFTS, 1, "spline")],
    "is taken to slide freely": [(*SHAFTS, 1, "spline", "mean_radius_mm")],
    "the yokes of line main weigh nothing": [(*SHAFTS, k, "yoke_mass_kg") for k in (0, 1)],
    "does not move the axle of line main: suspension would say": [("suspension",)],
    "does not move the axle of line main: axle would say": [("axle",)],
    "does not wind up the axle": [("suspension", "windup_stiffness_kNm_deg")],
    "carry all of the axle's load": [("suspension", "unsprung_mass_kg")],
    "nothing stops the axle": [("suspension", "jounce_deflection_mm")],
    "rises straight up": [("suspension", "linkage")],
    "is taken at the wheel's centre": [("axle", "pinion")],
    "pull in gvw: tyre would say": [("tyre",)],
    "braking is not asked": [("suspension", "brake_torque_Nm")],
    "backing is not asked": [("gearbox", "reverse_ratio")],
}


def noted(change) -> list[str]:
    table = copy.deepcopy(TRUCK)
    table["states"] = ["gvw"]
    change(table)
    return [str(note) for note in assess(files.loads(yaml.safe_dump(table))).noted]


def drop(table, *path):
    *way, last = path
    for key in way:
        table = table[key]
    table.pop(last)


def test_of_a_whole_file_nothing_is():
    notes = noted(lambda _: None)
    for said in LACKING:
        assert not any(said in note for note in notes), said


@pytest.mark.parametrize("said", LACKING)
def test_what_is_left_out_is_told(said):
    notes = noted(lambda table: [drop(table, *path) for path in LACKING[said]])
    assert [note for note in notes if said in note] != []


def test_a_load_state_that_is_lacking_is_told_by_its_key():
    """Its height is given, so naming `cg_height_mm` would send its reader looking."""
    notes = noted(lambda table: (drop(table, "vehicle", "loads", "gvw"),
                                 table.update(states=[{"name": "as it lies"}])))  # fmt: skip
    assert any("pull in as it lies: vehicle.loads.gvw would say how far" in n for n in notes)


def test_a_sliding_fit_ahead_of_the_last_shaft_is_told():
    def moved(table):
        front, rear = table["driveline"]["shafts"]
        front["spline"] = rear.pop("spline")

    notes = noted(moved)
    assert any("a spline ahead of the last shaft of line main" in note for note in notes)
    assert any("nothing slides in the last shaft of line main" in note for note in notes)


def test_a_joint_that_plunges_needs_no_spline():
    pick_up = files.read(Path(__file__).parents[2] / "examples/pick-up-4x4.yaml")
    assert pick_up.lines[0].line.shafts[-1].spline is None
    assert not any("nothing slides" in str(note) for note in assess(pick_up).noted)


def test_rubber_on_which_a_joint_locks_is_told_and_all_else_is():
    """Hung far ahead of its joint a shaft is a lever of fifteen: it was an error, of no place."""
    bearing = {"from_rear_joint_mm": 800, "vertical_stiffness_N_mm": 100,
               "lateral_stiffness_N_mm": 100}  # fmt: skip

    def soft(table):
        table["driveline"]["shafts"][0]["centre_bearing"] = bearing

    assert any("a joint of line main locks: the rubber is too soft" in n for n in noted(soft))


@pytest.mark.parametrize(
    ("states", "verdict"), [(["gvw"], "incomplete"), (["gvw", "jounce"], "fail")]
)
def test_a_limit_that_is_required_of_states_that_are_not_there_has_no_answer(states, verdict):
    """At the stops the bearing carries 2540 N: without them nobody knows, and nothing passes."""
    table = copy.deepcopy(TRUCK)
    required = {"quantity": "centre_bearing_dynamic", "maximum": 1000, "states": ["stops"],
                "required": True, "source": "us"}  # fmt: skip
    wide = {"quantity": "joint_angle", "maximum": 20, "source": "us"}
    table["states"], table["limits"] = states, [wide, required]
    found = assess(files.loads(yaml.safe_dump(table)))
    assert found.verdict == verdict
    asks = [u for u in found.coverage.unanswered if u.quantity == "centre_bearing_dynamic"]
    assert [u.needs for u in asks] == (
        [("states: full rebound / rebound / jounce",)] if verdict == "incomplete" else []
    )
    # What is not required may go unasked.
    table["limits"] = [wide, {**required, "required": False}]
    again = assess(files.loads(yaml.safe_dump(table)))
    assert again.coverage.missed == ()


@pytest.mark.parametrize(
    ("states", "told"),
    [
        (["gvw"], ""),
        (["gvw", {"name": "kerb", "kind": "gvw", "travel_mm": 120}], "kerb"),
        (["gvw", {"name": "hole", "travel_mm": -400}], "hole"),
        (["jounce", "full rebound", "windup"], ""),
    ],
)
def test_an_axle_beyond_its_stops_is_told(states, told):
    """The truck's are at 49 mm over gvw and 151 under it."""
    notes = noted(lambda table: table.update(states=states))
    found = [n for n in notes if "beyond its strap or bump stop" in n]
    assert found == ([] if not told else [n for n in notes if f"bump stop in {told}, which" in n])
    assert len(found) == bool(told)


def test_a_line_between_axles_is_told_what_turns_it_unevenly():
    tandem = assess(files.read(Path(__file__).parents[2] / "examples/tandem-6x4.yaml"))
    main = tandem.responses[0]
    swings = QUANTITIES["torsional_acceleration"].values(main)[:, 0]
    (note,) = (str(n) for n in tandem.noted if "as if the axle that it leaves" in str(n))
    assert f"swings by {swings.max():.4g} rad/s²" in note
    assert f"in {main.demand.states[swings.argmax()]}," in note


def test_a_limit_that_both_lines_together_would_break_is_told():
    """Alone the inter-axle line swings by 25 rad/s² in windup brake, and the main one by 85."""
    path = Path(__file__).parents[2] / "examples/tandem-6x4.yaml"
    table = yaml.safe_load(path.read_text("utf-8"))
    told = []
    for most in (100, 120):
        table["limits"] = [{"quantity": "torsional_acceleration", "maximum": most, "source": "us"}]
        found = assess(files.loads(yaml.safe_dump(table)))
        told.append([str(n) for n in found.noted if "where both swing alike" in str(n)])
    assert told[0] == ["where both swing alike the pinion of line inter-axle has 109.9 rad/s² for "
                       "25.1 in windup brake: fail"]  # fmt: skip
    assert told[1] == []


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (337.0808, ("337.08", "337.05")),
        (337.05, ("337.1", "337.1")),
        (340.0, ("340.0", "337.1")),
    ],
)
def test_a_value_is_told_apart_from_the_bound_that_it_misses(value, shown):
    """A row that fails must not read 337.1 <= 337.1."""
    limit = Limit(quantity="n_beta", source=ASSUMED, maximum=337.05 * rpm * deg)
    check = Check(
        quantity="n_beta", line="main", when=Occasion("state", "gvw"), part=Part("joint", 1),
        value=value * rpm * deg, limit=limit,
    )  # fmt: skip
    assert wording.held(check, EN) == shown

"""What a file leaves out, and an answer is the better for, is said: key by key, one at a time."""

import copy

import pytest
import yaml
from repository import EXAMPLES

from cardan.application import reader
from cardan.approval.approval import approve_driveline
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.labels import EvaluationCondition, Part
from cardan.core.provenance import SOURCE_ASSUMED
from cardan.core.units import deg, rpm
from cardan.core.verdict import Check, Limit
from cardan.render import phrases as wording
from cardan.render.i18n import ENGLISH

TRUCK = yaml.safe_load((EXAMPLES / "medium-truck-4x2.yaml").read_text("utf-8"))
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
    "braking is not evaluated": [("suspension", "brake_torque_Nm")],
    "reverse is not evaluated": [("gearbox", "reverse_ratio")],
}


def noted(change) -> list[str]:
    table = copy.deepcopy(TRUCK)
    table["states"] = ["gvw"]
    change(table)
    return [
        str(note) for note in approve_driveline(reader.loads(yaml.safe_dump(table))).note_messages
    ]


def drop(table, *path):
    *way, last = path
    for key in way:
        table = table[key]
    table.pop(last)


def test_complete_file_has_no_missing_input_notes():
    notes = noted(lambda _: None)
    for said in LACKING:
        assert not any(said in note for note in notes), said


@pytest.mark.slow
@pytest.mark.parametrize("said", LACKING)
def test_omitted_input_is_reported(said):
    notes = noted(lambda table: [drop(table, *path) for path in LACKING[said]])
    assert [note for note in notes if said in note] != []


def test_missing_load_state_is_reported_by_its_key():
    """Its height is given, so naming `cg_height_mm` would send its reader looking."""
    notes = noted(lambda table: (drop(table, "vehicle", "loads", "gvw"),
                                 table.update(states=[{"name": "as it lies"}])))  # fmt: skip
    assert any("pull in as it lies: vehicle.loads.gvw would say how far" in n for n in notes)


def test_spline_ahead_of_last_shaft_is_reported():
    def moved(table):
        front, rear = table["driveline"]["shafts"]
        front["spline"] = rear.pop("spline")

    notes = noted(moved)
    assert any("a spline ahead of the last shaft of line main" in note for note in notes)
    assert any("nothing slides in the last shaft of line main" in note for note in notes)


def test_plunging_joint_needs_no_spline():
    pick_up = reader.read(EXAMPLES / "pick-up-4x4.yaml")
    assert pick_up.lines[0].line.shafts[-1].spline is None
    assert not any(
        "nothing slides" in str(note) for note in approve_driveline(pick_up).note_messages
    )


def test_too_soft_mount_that_locks_joint_is_reported():
    """Hung far ahead of its joint a shaft is a lever of fifteen: it was an error, of no place."""
    bearing = {"from_rear_joint_mm": 800, "vertical_stiffness_N_mm": 100,
               "lateral_stiffness_N_mm": 100}  # fmt: skip

    def soft(table):
        table["driveline"]["shafts"][0]["centre_bearing"] = bearing

    assert any("a joint of line main locks: the rubber is too soft" in n for n in noted(soft))


@pytest.mark.parametrize(
    ("states", "verdict"), [(["gvw"], "incomplete"), (["gvw", "jounce"], "fail")]
)
def test_required_limit_on_missing_load_states_is_not_evaluated(states, verdict):
    """At the stops the bearing carries 2540 N: without them nobody knows, and nothing passes."""
    table = copy.deepcopy(TRUCK)
    required = {"quantity": "centre_bearing_dynamic", "maximum": 1000, "states": ["stops"],
                "required": True, "source": "us"}  # fmt: skip
    wide = {"quantity": "joint_angle", "maximum": 20, "source": "us"}
    table["states"], table["limits"] = states, [wide, required]
    found = approve_driveline(reader.loads(yaml.safe_dump(table)))
    assert found.verdict == verdict
    asks = [u for u in found.coverage.unevaluated if u.quantity == "centre_bearing_dynamic"]
    assert [u.missing_inputs for u in asks] == (
        [("states: full rebound / rebound / jounce",)] if verdict == "incomplete" else []
    )
    # What is not required may go unasked.
    table["limits"] = [wide, {**required, "required": False}]
    again = approve_driveline(reader.loads(yaml.safe_dump(table)))
    assert again.coverage.missing_required == ()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("states", "told"),
    [
        (["gvw"], ""),
        (["gvw", {"name": "kerb", "kind": "gvw", "travel_mm": 120}], "kerb"),
        (["gvw", {"name": "hole", "travel_mm": -400}], "hole"),
        (["jounce", "full rebound", "windup"], ""),
    ],
)
def test_axle_travel_beyond_stops_is_reported(states, told):
    """The truck's are at 49 mm over gvw and 151 under it."""
    notes = noted(lambda table: table.update(states=states))
    found = [n for n in notes if "beyond its strap or bump stop" in n]
    assert found == ([] if not told else [n for n in notes if f"bump stop in {told}, which" in n])
    assert len(found) == bool(told)


def test_inter_axle_line_reports_uneven_rotation_of_its_input():
    tandem = approve_driveline(reader.read(EXAMPLES / "tandem-6x4.yaml"))
    main = tandem.line_responses[0]
    swings = QUANTITIES["torsional_acceleration"].values(main)[:, 0]
    (note,) = (
        str(n) for n in tandem.note_messages if "uniform speed of the axle that it leaves" in str(n)
    )
    assert f"fluctuates by {swings.max():.4g} rad/s²" in note
    assert f"in {main.demand.states[swings.argmax()]}," in note


def test_combined_excitation_of_tandem_lines_beyond_limit_is_reported():
    """Alone the inter-axle line swings by 25 rad/s² in windup brake, and the main one by 85."""
    path = EXAMPLES / "tandem-6x4.yaml"
    table = yaml.safe_load(path.read_text("utf-8"))
    told = []
    for most in (100, 120):
        table["limits"] = [{"quantity": "torsional_acceleration", "maximum": most, "source": "us"}]
        found = approve_driveline(reader.loads(yaml.safe_dump(table)))
        told.append([str(n) for n in found.note_messages if "where both swing alike" in str(n)])
    assert told[0] == ["where both swing alike the pinion of line inter-axle has 109.9 rad/s² for "
                       "25.1 in windup brake: exceeded"]  # fmt: skip
    assert told[1] == []


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (337.0808, ("337.08", "337.05")),
        (337.05, ("337.1", "337.1")),
        (340.0, ("340.0", "337.1")),
    ],
)
def test_failing_value_is_displayed_different_from_its_bound(value, shown):
    """A row that fails must not read 337.1 <= 337.1."""
    limit = Limit(quantity="n_beta", source=SOURCE_ASSUMED, maximum=337.05 * rpm * deg)
    check = Check(
        quantity="n_beta",
        line="main",
        when=EvaluationCondition("state", "gvw"),
        part=Part("joint", 1),
        value=value * rpm * deg,
        limit=limit,
    )
    assert wording.value_and_bound(check, ENGLISH) == shown

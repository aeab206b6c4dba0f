"""A bracket under a line that swings, loads by hand on top of it, recordings: no solver."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from repository import ROOT

from cardan.application import reader
from cardan.approval.approval import approve_driveline
from cardan.core.errors import DesignError, InvalidFileError
from cardan.core.units import g
from cardan.model.bracket import BracketLoadCase
from cardan.model.bracket_compliance import reduce_to_bracket_compliance
from cardan.physics.fatigue.rainflow import rainflow, repeating, turning_points
from cardan.render.i18n import Translator
from cardan.topics.bracket.assessment import (
    duty_cycle_cases,
    load_cases,
    load_cases_from_recordings,
)
from cardan.topics.bracket.forced_response import (
    bearing_force_sweep,
    has_elastic_mount,
    largest_normal_stress_amplitude,
    line_response_on_bracket,
)

TRUCK = ROOT / "docs" / "gallery" / "bracket_failure.yaml"
GIVES = reduce_to_bracket_compliance(
    np.diag([1 / 3e6, 1 / 0.8e6, 1 / 4e6]), frequencies=[2 * np.pi * 180], inertia=np.zeros((3, 3)),
    motion=[[0.0, 0.8, 0.0]],
)  # fmt: skip


def truck(more=""):
    return reader.loads(TRUCK.read_text(encoding="utf-8") + more)


@pytest.fixture(scope="module")
def response():
    return approve_driveline(truck()).line_responses[0]


def bearing_of(response):
    return response.line.shafts[1].centre_bearing


def test_bearing_stiffness_of_file_includes_bracket_in_series(response):
    """Its stiffness is that of both: what the bracket gives is taken off, not counted twice."""
    plain = replace(truck().bracket, rubber=None)
    assert has_elastic_mount(response, plain)
    on = line_response_on_bracket(response, plain, GIVES)
    up, level = bearing_of(on).stiffness
    assert 1 / up + 1 / 4e6 == pytest.approx(1 / 200e3)
    assert 1 / level + 1 / 0.8e6 == pytest.approx(1 / 120e3)
    # So the slowest modes are those of the check, but for the mass of the bracket.
    both = (r.mounts.mounted_line.natural_frequencies()[0, :4] for r in (on, response))
    assert next(both) == pytest.approx(next(both), rel=1e-3)


ALONG = reduce_to_bracket_compliance(
    np.diag([1 / 60e3, 1 / 0.8e6, 1 / 4e6]), frequencies=[np.sqrt(60e3 / 4)],
    motion=[[0.5, 0, 0]], inertia=np.diag([4 / 60e3**2, 0, 0]),
)  # fmt: skip
"""4 kg on 60 N/mm along the shaft: with 150 N/mm of rubber, which the shaft holds still."""


def test_axially_soft_bracket_has_axial_mode(response):
    """It was called lateral. One mass on two springs, by hand; no order of the joints meets it."""
    on = line_response_on_bracket(response, truck().bracket, ALONG)
    modes, w = on.mounts.mounted_line.modes(), np.sqrt((60e3 + 150e3) / 4)
    k = modes.mode_names(0).index("axial")
    assert modes.frequency[0, k] == pytest.approx(w, rel=2e-3)
    assert modes.bracket_share[0, k] == pytest.approx(60 / 210, rel=0.01)
    assert sorted(modes.mode_names(0)[:4]) == ["bounce", "lateral", "pitch", "yaw"]
    assert [Translator(code)("axial") for code in ("pt", "it")] == ["axial", "assiale"]
    of = bearing_force_sweep(on, 1)
    q = np.abs(of.speed - w / 2).argmin()
    assert np.nanmax(np.abs(of.force_amplitudes[:, q, 1, 0])) < 0.01 * np.nanmax(
        np.abs(of.force_amplitudes[:, :, 1, 2])
    )
    states = len(on.demand.states)
    spots = SimpleNamespace(
        torque=np.zeros((states, 1)), speed=np.full((states, 1), w / 2), is_spline_stuck=None
    )
    assert on.mount_loads.order_crossings(spots)[0] == [None]
    lateral = modes.frequency[0, modes.mode_names(0).index("lateral")]
    spots.speed[:] = lateral / 2
    assert on.mount_loads.order_crossings(spots)[0][0].shape == "lateral"


def test_bracket_rubber_is_in_series_with_bracket(response):
    own = truck().bracket
    on = line_response_on_bracket(response, own, GIVES)
    assert bearing_of(on).stiffness == (200e3, 120e3)
    assert bearing_of(on).axial_stiffness == 150e3
    assert (
        on.mounts.mounted_line.natural_frequencies()[0, 0]
        < 0.99 * response.mounts.mounted_line.natural_frequencies()[0, 0]
    )


def test_bearing_is_rigid_if_bracket_takes_all_compliance(response):
    """A bracket softer than the file says of both: it alone gives, no mode is lost."""
    plain = replace(truck().bracket, rubber=None)
    soft = reduce_to_bracket_compliance(
        np.diag([1e-5] * 3), frequencies=np.zeros(0), inertia=np.zeros((3, 3)),
        motion=np.zeros((0, 3)),
    )  # fmt: skip
    on = line_response_on_bracket(response, plain, soft)
    assert bearing_of(on).stiffness is None
    assert (
        on.mounts.mounted_line.natural_frequencies()[0, 0]
        < response.mounts.mounted_line.natural_frequencies()[0, 0]
    )
    assert np.isfinite(on.mount_loads.worst_bearing_forces["peak"].results.peak).any()


def test_remaining_rubber_compliance_is_kept_per_direction(response):
    """Across nothing is left, up it is: both went rigid, and ±32 µm/m of a gauge were told ±6."""
    plain = replace(truck().bracket, rubber=None)
    soft = reduce_to_bracket_compliance(
        np.diag([1e-5, 1.001 / 120e3, 1 / 4e6]), frequencies=np.zeros(0), inertia=np.zeros((3, 3)),
        motion=np.zeros((0, 3)),
    )  # fmt: skip
    up, level = bearing_of(line_response_on_bracket(response, plain, soft)).stiffness
    assert 1 / up + 1 / 4e6 == pytest.approx(1 / 200e3)
    assert level == pytest.approx(100 * 120e3 / 1.001)


def test_forced_response_needs_rubber_stiffness(response):
    bare = replace(
        response.line.shafts[1], centre_bearing=replace(bearing_of(response), stiffness=None)
    )
    shafts = (response.line.shafts[0], bare, response.line.shafts[2])
    line = replace(response.line, shafts=shafts)
    demand = replace(response.demand, installed=replace(response.demand.installed, line=line))
    assert not has_elastic_mount(
        response.with_inputs(demand=demand), replace(truck().bracket, rubber=None)
    )


def test_worst_operating_points_include_bracket_compliance(response):
    """Loads on rigid bearings are as they were; what comes at a speed moves with the modes."""
    own = truck().bracket
    on = line_response_on_bracket(response, own, GIVES)
    before, after = ({str(c.when): c for c in load_cases(own, r)} for r in (response, on))
    assert before.keys() == after.keys()
    for name, case in after.items():
        was = before[name]
        if name.endswith("worst point"):
            assert case.is_dynamic
            assert not was.is_dynamic
            assert case.operating_point.speed < was.operating_point.speed
        else:
            assert not case.is_dynamic
            assert np.array_equal(case.loads, was.loads)
    duty = on.with_inputs(application=replace(on.application, duty=()))
    assert duty_cycle_cases(own, duty) == {}


def test_speed_sweep_peak_matches_worst_operating_point(response):
    """The sweep's crest is the worst point's order content, in the same state."""
    own = truck().bracket
    on = line_response_on_bracket(response, own, GIVES)
    found = bearing_force_sweep(on, 1)
    assert found.state == "windup"
    assert set(found.directions) <= {"drive", "reverse", "brake"}
    size = np.abs(found.force_amplitudes).sum(axis=-2)[..., 1]
    c, q = np.unravel_index(int(np.nan_to_num(size).argmax()), size.shape)
    s = on.demand.states.index("windup")
    best = on.mount_loads.worst_bearing_forces["dynamic"].results
    assert size[c, q] == pytest.approx(np.abs(best.waves[s, 1, :, 1]).sum(), rel=0.02)
    # Far below every mode the bracket is none to the line.
    assert found.force_amplitudes[c, 0, 0, 1] == pytest.approx(
        found.rigid_force_amplitudes[c, 0, 0, 1], rel=0.02
    )
    assert "lateral" in found.mode_names
    assert "bracket" in found.mode_names


def test_stress_amplitude_matches_load_history():
    """Both orders where they add up, on the plane of the largest swing; the swing of the mode."""
    unit = np.zeros((1, 10, 6))
    unit[0, 0, 0], unit[0, 1, 1], unit[0, 9, 0] = 2e6, 1e6, 5e11
    normals = np.array([[0.0, 0.0, 1.0]])
    waves = np.array([[[3.0, 0, 0], [0, 1j, 0], [0.5, 0, 0]]])
    speed = np.array([20.0])
    found = largest_normal_stress_amplitude(unit, normals, waves, speed=speed)
    assert found == pytest.approx(np.array([[2e6 * 3.5]]))
    own = reduce_to_bracket_compliance(
        np.diag([1e-6] * 3), frequencies=[90.0], inertia=np.zeros((3, 3)), motion=[[0.05, 0, 0]]
    )
    with_swing = largest_normal_stress_amplitude(unit, normals, waves, speed=speed, seat=own)
    by_hand = sum(
        abs(2e6 * f + own.dynamic_increment([f, 0, 0], k * 20.0)[:3] @ [2e6, 0, 0]
            + 5e11 * own.dynamic_increment([f, 0, 0], k * 20.0)[3])
        for k, f in ((2, 3.0), (6, 0.5))
    )  # fmt: skip
    assert with_swing == pytest.approx(np.array([[by_hand]]), rel=1e-6)
    assert abs(by_hand / 7e6 - 1) > 0.05


def test_load_case_on_state_adds_both_loads(response):
    """The pothole's four g are counted from standing still, which gravity counts already."""
    found = truck("").bracket
    pothole = replace(found.cases[0], name="pothole in jounce", state="jounce")
    side = replace(
        pothole, name="kerb", acceleration=(0.0, 0.0, 0.0), force=(0.0, 3000.0, 0.0), state="gvw"
    )
    own = replace(found, cases=(found.cases[0], pothole, side))
    cases = {str(c.when): c for c in load_cases(own, response)}
    base = cases["jounce: worst point"]
    pothole, kerb = cases["pothole in jounce"], cases["kerb"]
    more = pothole.alternatives[0].loads - base.loads
    a = 3 * g if response.inputs.gravity else 4 * g
    assert more == pytest.approx(np.tile([0, 0, -32 * a, 0, 0, 0, 0, 0, a], (len(more), 1)))
    assert pothole.alternatives[0].operating_point == base.operating_point
    assert not any(case.repeats for case in (pothole, *pothole.alternatives))
    more = kerb.alternatives[0].loads - cases["gvw: worst point"].loads
    assert more == pytest.approx(np.tile([0, 3000, 0] + [0] * 6, (len(more), 1)))
    # At every point that the bearing is asked at: where its forces add up to most comes first.
    points = [case.operating_point for case in kerb.alternatives]
    assert len(set(points)) > 20
    loads = np.concatenate([case.loads for case in kerb.alternatives])
    assert len(kerb.extreme_loads) < 30  # which the mesh is made for
    assert np.abs(kerb.extreme_loads[:, :3]).max(axis=0) == pytest.approx(
        np.abs(loads[:, :3]).max(axis=0), rel=0.02
    )
    alone = cases["pothole at 4 g"].loads
    assert alone == pytest.approx(np.array([[0, 0, -32 * 4 * g, 0, 0, 0, 0, 0, 4 * g]]))
    dark = response.with_inputs(demand=replace(response.demand, torque=0 * response.demand.torque))
    with pytest.raises(DesignError, match="whose torque is unknown"):
        list(
            load_cases(
                replace(own, cases=(side,)),
                _without_points(dark.with_inputs(demand=replace(
                    dark.demand, torque=np.full_like(response.demand.torque, np.nan)))),
            )
        )  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(
    ("given", "adds"),
    [
        ((0, 3, 0), (0, 3, 0)),
        ((2, 0, 0), (2, 0, 0)),
        ((0, 3, 1), (0, 3, 0)),
        ((0, 0, 1e-3), (0, 0, -1)),
    ],
)
def test_lateral_load_case_keeps_gravity_of_state(response, given, adds):
    """Three g sideways took one g downwards off: the frame fell freely, and nobody had said so."""
    weighs = response.with_inputs(application=replace(response.application, include_gravity=True))
    side = BracketLoadCase(name="kerb", acceleration=tuple(g * np.array(given)), state="gvw")
    own = replace(truck("").bracket, cases=(side,))
    cases = {str(c.when): c for c in load_cases(own, weighs)}
    more = cases["kerb"].alternatives[0].loads - cases["gvw: worst point"].loads
    a = g * np.array(adds)
    found = np.concatenate([-own.carried_mass * a, np.zeros(3), a])
    assert more == pytest.approx(np.tile(found, (len(more), 1)), abs=2e-3 * 32 * g)


def _without_points(response):
    response.mount_loads.__dict__["worst_bearing_forces"] = {}
    return response


def test_load_case_with_unknown_state_is_rejected():
    text = TRUCK.read_text(encoding="utf-8").replace(
        "acceleration_g: [0, 0, 4]}", "acceleration_g: [0, 0, 4], state: jouncing}"
    )
    with pytest.raises(InvalidFileError, match="no state of this name") as failed:
        reader.loads(text)
    assert "did you mean jounce" in str(failed.value)


def written(tmp_path, head, rows, gauges=True, more=""):
    (tmp_path / "run.csv").write_text(
        head + "\n" + "\n".join(",".join(f"{v:.6g}" for v in row) for row in rows) + "\n"
    )
    text = TRUCK.read_text(encoding="utf-8")
    text += f"  recordings: [{{name: field, file: run.csv{more}}}]\n"
    if not gauges:
        at = text.index("  gauges:"), text.index("  cases:")
        text = text[: at[0]] + text[at[1] :]
    (tmp_path / "a.yaml").write_text(text, encoding="utf-8")
    return reader.read(tmp_path / "a.yaml").bracket


def test_force_recording_is_read_as_written_by_life(tmp_path):
    t = np.arange(50) / 100
    force = np.stack([0 * t, 900 * np.sin(40 * t), 200 + 0 * t], axis=-1)
    own = written(tmp_path, "time_s,x_N,y_N,z_N", np.column_stack([t, force]))
    (one,) = own.recordings
    assert one.rate == pytest.approx(100)
    (case,) = load_cases_from_recordings(own, None)
    assert case.name == "field"
    assert case.loads[:, :3] == pytest.approx(force, rel=1e-4, abs=1e-3)
    assert case.duration == pytest.approx(0.5)
    assert case.is_dynamic


def test_strain_recording_is_converted_to_forces(tmp_path):
    t = np.arange(60) / 200
    force = np.stack([50 * np.cos(30 * t), 900 * np.sin(40 * t), 200 + 0 * t], axis=-1)
    influence = 1e-8 * np.random.default_rng(2).standard_normal((4, 9))
    read = 1e6 * force @ influence[:, :3].T
    head = "time_s," + ",".join(f"S{k} [um/m]" for k in range(1, 5))
    own = written(tmp_path, head, np.column_stack([t, read]))
    assert not list(load_cases_from_recordings(own, None))  # before anything is solved nobody knows
    solved = in_two_ways(influence)
    (case,) = load_cases_from_recordings(own, solved)
    assert case.recovered_loads.load_error.min() > 0
    assert case.loads[:, :3] == pytest.approx(force, rel=1e-4, abs=0.1)
    assert not case.is_dynamic


def in_two_ways(influence):
    """Return a bracket solved, its gauges half as sensitive where its flange is clamped."""
    sliding, clamped = (
        SimpleNamespace(
            hold=hold, influence=share * influence, influence_error=np.array([1e-10, 0, 0])
        )
        for hold, share in (("sliding", 1.0), ("clamped", 0.5))
    )
    return SimpleNamespace(sliding=sliding, clamped=clamped, boundary_cases=(sliding, clamped))


def test_forces_from_gauges_apply_to_sliding_flange(tmp_path):
    """As strains of the same recording; and its bracket swings in what gauges felt already."""
    t = np.arange(60) / 200
    force = np.stack([50 * np.cos(30 * t), 900 * np.sin(40 * t), 200 + 0 * t], axis=-1)
    influence = 1e-8 * np.random.default_rng(2).standard_normal((4, 9))
    head, rows = "time_s,x_N,y_N,z_N", np.column_stack([t, force])
    own = written(tmp_path, head, rows, more=", from_gauges: true")
    (before,) = load_cases_from_recordings(own, None)
    (case,) = load_cases_from_recordings(own, in_two_ways(influence))
    assert before.loads == pytest.approx(case.loads, rel=1e-6, abs=1e-6)
    assert case.loads[:, :3] == pytest.approx(force, rel=1e-4, abs=0.1)
    # Of how it was held nobody knows any more: clamped it is half as soft at every gauge.
    assert case.recovered_loads.load_error.max() > 0.2 * np.abs(force).max()
    assert not case.is_dynamic
    assert not before.is_dynamic


def test_forces_from_gauges_need_the_gauges(tmp_path):
    rows = [[k / 9, 1, 2, 3] for k in range(9)]
    with pytest.raises(
        InvalidFileError, match="from_gauges: needs the gauges they were read from, 3"
    ):
        written(tmp_path, "time_s,x_N,y_N,z_N", rows, gauges=False, more=", from_gauges: true")


@pytest.mark.parametrize(
    ("head", "rows", "said"),
    [
        ("time_s,y_N,z_N", [[0, 1, 2]] * 9, "has no channel x_N"),
        ("time_s,S1,S2", [[0, 1, 2]] * 9, "has no channel S3, S4"),
        ("time_s,S1 [MPa],S2,S3,S4", [[k / 9, 1, 2, 3, 4] for k in range(9)], "S1 is in MPa"),
        ("time_s,x_N [kN],y_N [kN],z_N [kN]", [[0, 1, 2, 3]] * 9, "x_N is in kN; forces are in N"),
        ("time_s,x_N,y_N,z_N", [[k / 9, 1, np.nan, 3] for k in range(9)], "no numbers"),
    ],
)
def test_unreadable_recording_is_rejected_with_file_and_line(tmp_path, head, rows, said):
    rows = [[k / 9, *row[1:]] for k, row in enumerate(rows)]
    with pytest.raises(InvalidFileError, match=said) as failed:
        written(tmp_path, head, rows)
    assert "a.yaml:" in str(failed.value)


def test_missing_recording_file_is_rejected(tmp_path):
    text = TRUCK.read_text(encoding="utf-8") + "  recordings: [{name: field, file: none.csv}]\n"
    (tmp_path / "a.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(InvalidFileError, match="no such file"):
        reader.read(tmp_path / "a.yaml")


def test_turning_points_preserve_damage():
    """A random walk thinned at 2 %: its damage, fifth power, within 1 %; far fewer samples."""
    random = np.random.default_rng(5)
    x = np.cumsum(random.standard_normal(20_000))
    x = x - np.convolve(x, np.ones(400) / 400, mode="same") + 0.3 * random.standard_normal(20_000)
    kept = turning_points(x, gate=0.02)

    def damage(signal):
        counted = rainflow(signal, rule=repeating)
        return float((counted.range**5 * counted.count).sum())

    assert len(kept) < 0.2 * len(x)
    assert damage(x[kept]) == pytest.approx(damage(x), rel=0.01)
    assert {0, len(x) - 1, int(x.argmax()), int(x.argmin())} <= set(kept.tolist())
    assert turning_points([3.0, 3.0, 3.0], gate=0.1).tolist() == [0, 2]

"""A truck calculated by hand: every held quantity in every state, against another author.

`by_hand.py` knows nothing of the program: it is METHOD's equations and textbook mechanics
written down for the truck of `by_hand.yaml`. Every check must have a value by hand, and every
value by hand its check.

Tolerances. What both sides have in closed form, or sampled round the turn with spectral
accuracy, differs by rounding: 1e-9, a million roundings. Angles of equivalent joints come
from an order 2 amplitude of 1e-4 to 1e-2 beside a mean of 1, of which rounding leaves 1e-12:
1e-9 as well. Peaks are found on both sides to the square root of rounding: 1e-7. The whole
line's critical speeds: 24 lumped beams of a shaft against four consistent ones, which are
0.1 % high, and more where a spline's mass sits within one (the kink that shear makes there
costs 1/n): 0.5 %.
"""

from functools import cache
from itertools import product
from math import isnan
from pathlib import Path

import by_hand
import numpy as np
import pytest

from cardan.application.reader import loads, read
from cardan.approval.approval import approve_driveline
from cardan.checks.quantities.registry import LINE_QUANTITIES, QUANTITIES
from cardan.documents import approval_json as contract

HERE = Path(__file__).parent
TRUCKS = {"by_hand.yaml": by_hand.TRUCK, "by_hand_front.yaml": by_hand.FRONT_TRUCK}

EITHER_TRUCK = pytest.mark.parametrize(
    "file", [pytest.param("by_hand.yaml", marks=pytest.mark.slow), "by_hand_front.yaml"]
)
"""The first meets its stops on many curves: its forces take 10 s."""

CLOSED, TURNED, BEAMS = 1e-9, 1e-7, 5e-3
DIGITS = 1e-11
"""The document prints twelve."""

SIGNED = (
    "torque", "axle_travel", "pinion_pitch", "side_angle", "top_angle", "spline_travel",
)  # fmt: skip
"""A limit asks how large these are, whichever way they go."""


@cache
def assessed(file):
    return approve_driveline(read(HERE / file))


def own(file, check):
    """A check's value at the state's own torque and speed, where it was asked elsewhere too."""
    if check.point is None:
        return check.value
    (response,) = (r for r in assessed(file).line_responses if r.line.name == check.line)
    quantity = QUANTITIES[check.quantity]
    at = response.demand.states.index(check.state), quantity.parts(response).index(check.part)
    value = float(quantity.values(response)[at])
    return abs(value) if quantity.signed else value


@cache
def by_pencil(file):
    return by_hand.calculated(TRUCKS[file])


@cache
def checked(file):
    """Checks by (quantity, state): their values by (line, part)."""
    found = {}
    for check in assessed(file).checks:
        of = found.setdefault((check.quantity, str(check.state)), {})
        of.setdefault((check.line, str(check.part)), []).append(check)
    return found


@cache
def expected(file):
    found = {}
    for (line, state), values in by_pencil(file)[0].items():
        for (quantity, part), value in values.items():
            size = abs(value) if quantity in SIGNED else value
            found.setdefault((quantity, state), {})[line, part] = size
    return found


NOT_BY_PENCIL = {
    "resonance_distance", "swing_growth", "joint_dynamic", "centre_bearing_travel",
    "centre_bearing_travel_utilisation", "clearance_on_rubber", "spline_compression_utilisation",
    "centre_bearing_dead_load", "spline_dead_load_shortening", "spline_stroke_shortening",
}  # fmt: skip
"""Modes on rubber under a torque: held against other numbers where they are computed."""
BY_ITSELF = {
    "axle_load_rest", "axle_load_slip", "axle_to_frame", "bending_moment", "couple_ahead",
    "couple_behind", "cup_pressure", "journal_force", "shaft_length", "side_slope", "top_slope",
    "tube_fatigue_utilisation", "tube_stress_utilisation", "gearbox_bearing_utilisation",
    "pinion_bearing_utilisation",
}  # fmt: skip
"""Worked by hand one by one in `unit/documents/test_delivered_values.py` or
`unit/checks/test_end_bearings.py`, not here."""
TOLD_BY_ITSELF = (
    "resonance_distance", "swing_growth_per_s", "members", "shafts", "axles",
    "axle_to_frame_mm", "axle_load_N",
    "driven_load_N", "spline_compression_utilisation", "spline_dead_load_shortening_mm",
    "spline_stroke_shortening_mm",
)  # fmt: skip
OF_JOINTS_BY_ITSELF = (
    "couple_ahead_Nm", "couple_behind_Nm", "journal_force_N", "cup_pressure_MPa",
)  # fmt: skip
"""The same in the document."""
STEADY = {"centre_bearing_static", "centre_bearing_dynamic", "centre_bearing_peak"}
BEAM = {"critical_speed_ratio", "half_critical_band", "line_critical_speed", "bearing_resonance"}


def tolerance(quantity, part):
    if quantity in BEAM and part == "line":
        return BEAMS
    smooth = quantity.endswith(("_acceleration", "_torque", "_force", "_peak"))
    return TURNED if smooth or quantity in ("irregularity", "equivalent_angle") else CLOSED


EVERYWHERE = pytest.mark.parametrize(
    ("file", "line", "state"),
    [
        (file, line.name, state.name)
        for file, truck in TRUCKS.items()
        for line, state in product(truck.lines, truck.states)
    ],
)


@pytest.mark.slow
@EVERYWHERE
def test_every_check_has_hand_calculated_value(file, line, state):
    """No check without a value by hand, no value without its check."""
    for quantity in {q for q, of in (*checked(file), *expected(file)) if of == state}:
        ours, hand = (of(file).get((quantity, state), {}) for of in (checked, expected))
        ours, hand = ({p: v for (of, p), v in both.items() if of == line} for both in (ours, hand))
        if quantity in STEADY and swings(file, line, state):
            hand = {}  # by itself, and no steady force is an answer
        assert set(ours) == set(hand), quantity
        for part, value in hand.items():
            wanted = pytest.approx(value, rel=tolerance(quantity, part), abs=1e-15)
            for check in ours[part]:
                asked = (
                    rigid(file, check)
                    if QUANTITIES[quantity].find_worst_points
                    else own(file, check)
                )
                assert asked == wanted, (quantity, part)


def swings(file, line, state):
    """Whether a line's swinging grows at some driven point: `test_parametric.py` holds that."""
    (r,) = (r for r in assessed(file).line_responses if r.line.name == line)
    worst = r.mount_loads.worst_growth_rate
    return worst is not None and bool(worst.results.growth[r.demand.states.index(state)].max() > 0)


def rigid(file, check):
    """A bearing's force as if it were rigid, at the state's own torque: what pencils can do.

    Limits ask for the worst operating point on rubber, which is held against an engine.
    """
    (response,) = (r for r in assessed(file).line_responses if r.line.name == check.line)
    values = QUANTITIES[check.quantity].approximations["rigid"](response)
    return values[response.demand.states.index(check.when.name), check.part.number - 1]


@pytest.mark.slow
@pytest.mark.parametrize("file", TRUCKS)
def test_every_limit_is_evaluated_once_as_written(file):
    """A joint's own rating stands beside the profile's angle, and in place of its speeds."""
    lines = {line.name: line for line in TRUCKS[file].lines}
    for (quantity, state), of in checked(file).items():
        for (line, part), checks in of.items():
            if quantity == "half_critical_band":
                wanted = [by_hand.BAND]
            else:
                wanted = [by_hand.LIMITS[quantity]]
            if part.startswith("joint "):
                joint = lines[line].joints[int(part[6:]) - 1]
                own = {"joint_angle": joint.angle, "n_beta": joint.speed_angle,
                       "joint_speed": joint.speed}.get(quantity, np.nan)  # fmt: skip
                if not isnan(own):
                    wanted = [*(wanted if quantity == "joint_angle" else []), (None, own)]
            given = [c.limit.band or (c.limit.normal, c.limit.maximum) for c in checks]
            assert len(given) == len(wanted), (quantity, state, part)
            for pair, want in zip(given, wanted, strict=True):
                for a, b in zip(pair, want, strict=True):
                    assert a == (None if b is None else pytest.approx(b, rel=1e-12)), quantity


def grade(quantity, value, normal, maximum):
    """Past normal a check warns, past maximum it fails."""
    past = [
        bound is not None
        and (value < bound if quantity in by_hand.MORE_IS_BETTER else value > bound)
        for bound in (normal, maximum)
    ]
    return "fail" if past[1] else "warn" if past[0] else "pass"


@EITHER_TRUCK
def test_verdicts_match_hand_calculation(file):
    for (quantity, _), of in checked(file).items():
        for checks in of.values():
            for check in checks:
                if quantity == "half_critical_band":
                    low, high = by_hand.BAND
                    wanted = "warn" if low < check.value < high else "pass"
                else:
                    limit = check.limit
                    wanted = grade(quantity, check.value, limit.normal, limit.maximum)
                    if wanted == "pass" and check.is_lower_bound:  # some rubber is at its stop
                        wanted = "warn"
                assert check.grade == wanted, str(check)


def free_to_stop(file, check):
    """The share of a stop's travel that the line's bearings have left; 15 mm, as none is given."""
    (response,) = (r for r in assessed(file).line_responses if r.line.name == check.line)
    travel = response.mount_loads.worst_bearing_travel.results.peak
    return 1 - travel[response.demand.states.index(check.state)].max() / 0.015


@pytest.mark.slow
@pytest.mark.parametrize("file", TRUCKS)
def test_printed_checks_match_hand_calculation(file):
    worth = {q: (unit, of) for unit, (of, group) in by_hand.SHOWN.items() for q in group}
    found = assessed(file)
    for check, row in zip(found.checks, contract.json_document(found)["checks"], strict=True):
        unit, factor = worth[check.quantity]
        value, limit = check.value, check.limit
        if limit.band:
            low, high = by_hand.BAND
            bound = low if value < (low + high) / 2 else high
            free = max(low - value, value - high) / bound
        else:
            first = [b for b in (limit.normal, limit.maximum) if b is not None]
            bound = first[-1] if row["verdict"] == "fail" else first[0]
            free = (bound - value) / bound
            free = -free if check.quantity in by_hand.MORE_IS_BETTER else free
        if check.is_lower_bound and row["verdict"] != "fail":  # no more is shown than the stop lets
            free = min(free, free_to_stop(file, check))
        assert row["unit"] == unit
        assert row["value"] == pytest.approx(value / factor, rel=DIGITS)
        assert row["limit"] == pytest.approx(bound / factor, rel=DIGITS)
        assert row["margin"] == pytest.approx(free, rel=1e-9, abs=1e-12), check.quantity


def leaves(of, path=()):
    """Numbers and vectors of a document by their path; what is not known is nan."""
    if isinstance(of, dict):
        items = of.items()
    elif isinstance(of, list | tuple) and of and isinstance(of[0], dict):
        items = enumerate(of)
    else:
        return {path: np.array(of, dtype=float)}
    return {p: v for key, inner in items for p, v in leaves(inner, (*path, key)).items()}


@cache
def told(file):
    """The document's numbers by line and state."""
    document = contract.json_document(assessed(file))
    first, *others = (line.name for line in TRUCKS[file].lines)
    found = {}
    for state in document["states"]:
        name, lines = state.pop("name"), state.pop("lines", {})
        assert state.pop("line") == first
        for of in (state, *lines.values()):
            assert of.pop("points")
            for key in TOLD_BY_ITSELF:
                of.pop(key, None)
            for row, key in product(of["joints"], OF_JOINTS_BY_ITSELF):
                row.pop(key)
            for bearing in of["centre_bearings"]:
                bearing.pop("on_rubber")
                bearing.pop("dead_load_N")
            for joint in of["joint_forces"]:
                joint.pop("dynamic_N")
        assert set(lines) == set(others)
        found |= {(line, name): leaves(of) for line, of in {first: state, **lines}.items()}
    return found


@cache
def drawn(file):
    return {key: leaves(of) for key, of in by_pencil(file)[1].items()}


@pytest.mark.slow
@EVERYWHERE
def test_json_document_matches_hand_calculation(file, line, state):
    """The numbers that other programs read, in the units their keys say.

    The small-angle forces are taken at a ten-thousandth of the angles, where what is left
    of the second order is 1e-8 of the first: 1e-6.
    """
    ours, hand = told(file)[line, state], drawn(file)[line, state]
    assert {path for path in ours if path[0] != "clearances_on_rubber_mm"} == set(hand)
    for path, value in hand.items():
        rough = 1e-6 if "approximations" in path else TURNED
        rel = BEAMS if path[-1] == "line_critical_speed_rpm" else rough
        assert np.array_equal(np.isnan(ours[path]), np.isnan(value)), path
        size = np.linalg.norm(np.nan_to_num(value))
        apart = np.linalg.norm(np.nan_to_num(ours[path] - value))
        assert apart <= rel * size + 1e-9, path


@EITHER_TRUCK
def test_demand_of_vehicle_matches_hand_calculation(file):
    """J3311's torques, axle loads at rest and at slip, rise and pitch of the axle."""
    for response in assessed(file).line_responses:
        for s, state in enumerate(TRUCKS[file].states):
            hand = by_pencil(file)[2][response.line.name, state.name]
            for name, value in hand.items():
                ours = getattr(response.demand, name)[s]
                wanted = pytest.approx(value, rel=CLOSED, abs=1e-12, nan_ok=True)
                assert ours == wanted, (response.line.name, state.name, name)


@EITHER_TRUCK
def test_beam_model_matches_hand_calculation(file):
    for response in assessed(file).line_responses:
        bends, bounces = by_pencil(file)[3][response.line.name]
        assert response.strength.line_critical_speed == pytest.approx(bends, rel=BEAMS)
        if np.isfinite(bounces):
            assert response.strength.mount_resonance_speed == pytest.approx(bounces, rel=BEAMS)
        else:
            assert isnan(response.strength.mount_resonance_speed)


@EITHER_TRUCK
def test_parts_are_read_with_hand_calculated_properties(file):
    """What a whirling line does not tell apart: up from sideways, where all shafts are round."""
    for installed, hand in zip(assessed(file).application.lines, TRUCKS[file].lines, strict=True):
        for shaft, wanted in zip(installed.line.shafts, hand.shafts, strict=True):
            if shaft.centre_bearing and wanted.rubber != by_hand.RIGID:
                assert shaft.centre_bearing.stiffness == pytest.approx(wanted.rubber, rel=1e-12)
            material, tube = shaft.tube.material, wanted.tube
            assert shaft.tube.outer == pytest.approx(tube.outer, rel=1e-12)
            assert shaft.tube.inner == pytest.approx(tube.inner, rel=1e-12)
            assert material.youngs_modulus == pytest.approx(tube.E, rel=1e-12)
            assert material.poisson == tube.nu
            assert material.density == tube.rho
            assert shaft.mass == pytest.approx(wanted.mass, rel=1e-12)
            assert shaft.polar_inertia == pytest.approx(wanted.polar_inertia, rel=1e-12)


def test_rear_line_may_have_own_springs():
    """The bogie's springs moved into its line; the vehicle's are now others, and not its own."""
    file, opening = "by_hand_front.yaml", "suspension:                       # of the bogie\n"
    text = (HERE / file).read_text(encoding="utf-8")
    before, rest = text.split(opening)
    springs, after = rest.split("\n\n", 1)
    own = "    suspension:\n" + "".join(f"    {row}\n" for row in springs.splitlines())
    share = "    torque_share: 0.62\n"
    moved = before + opening + springs.replace("[262]", "[510]") + "\n\n"
    moved += after.replace(share, own + share)
    found = approve_driveline(loads(moved, name=file, folder=HERE))
    (response,) = (r for r in found.line_responses if r.line.name == "main")
    frequencies = {c.state: c.value for c in found.checks
                   if (c.quantity, c.line) == ("suspension_frequency", "main")}  # fmt: skip
    values, _, demands, _ = by_pencil(file)
    for s, state in enumerate(by_hand.FRONT_TRUCK.states):
        hand = demands["main", state.name]
        assert response.demand.travel[s] == pytest.approx(hand["travel"], rel=CLOSED, abs=1e-12)
        assert response.demand.pitch[s] == pytest.approx(hand["pitch"], rel=CLOSED, abs=1e-12)
        wanted = values["main", state.name].get(("suspension_frequency", "line"))
        assert frequencies.get(state.name) == (wanted and pytest.approx(wanted, rel=CLOSED))


@pytest.mark.slow
def test_torque_given_by_state_overrides_torque_of_application():
    """It stands for engine and tyres at the gearbox output, of which each line has its share."""
    text = "torque_kNm: 5\n" + (HERE / "by_hand.yaml").read_text(encoding="utf-8")
    found = approve_driveline(loads(text, name="by_hand.yaml", folder=HERE))
    for response, line in zip(found.line_responses, by_hand.TRUCK.lines, strict=True):
        for s, state in enumerate(by_hand.TRUCK.states):
            if state.kind != "windup brake":
                at_gearbox = 5000 if isnan(state.torque) else state.torque
                wanted = pytest.approx(at_gearbox * line.torque_share, rel=CLOSED)
                assert response.demand.torque[s] == wanted, state.name


OF_OTHER_KINDS = {
    "tube_buckling_utilisation", "joint_swing", "joint_orbit", "disc_axial_utilisation",
}  # fmt: skip
"""Of plies, double cardans, tripods and discs, which these trucks have not: tests of their own."""


@pytest.mark.slow
def test_truck_files_cover_every_limitable_quantity():
    wanted = set(LINE_QUANTITIES) - OF_OTHER_KINDS - NOT_BY_PENCIL - BY_ITSELF
    for file in TRUCKS:
        assert {limit.quantity for limit in assessed(file).application.limits} == wanted
    assert {quantity for file in TRUCKS for quantity, _ in checked(file)} == wanted

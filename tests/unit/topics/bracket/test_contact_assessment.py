"""A bracket in its bolts, from loads to the verdict: on a rigid foot, and by a whole study."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from bolted_foot import COUNT, coupled, foot
from brackets import LINE
from click.testing import CliRunner

from cardan.cli import cli
from cardan.model.bracket import Bolts
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.topics.bracket.contact_assessment import BoltedContactAnalysis
from cardan.topics.bracket.life import ZoneFatigueStrength

PRELOAD, FRICTION = 1000.0, 0.15
BEARS = PRELOAD * FRICTION
SHARES = ((0.6, 1.3), (0.7, 1.2))
"""Of the stress told by the sliding way, that friction makes at two places, by either way."""


def contact() -> BoltedContactAnalysis:
    """A foot whose two places feel the force along y: told 1 Pa per N, really a share of it."""
    joint = foot()
    stress = np.zeros((len(joint.compliance), 4, 6))
    along = 3 * np.arange(2 * COUNT) + 1
    unit = np.zeros((2, 9, 6))
    unit[:, 1, 0] = 1.0
    for place in (0, 1):  # of the sliding way, then of the clamped one, which tells half
        for way in (0, 1):
            stress[along, 2 * way + place, 0] = -SHARES[way][place]  # it stands against the force
    zones = SimpleNamespace(normals=np.tile([0.0, 0, 1], (2, 1)), kind=np.zeros(2, dtype=int))
    both = tuple(SimpleNamespace(unit_stress=unit * size, zones=zones) for size in (1.0, 0.5))
    object.__setattr__(joint, "stress", stress)
    here = np.arange(2)
    solved = SimpleNamespace(
        boundary_cases=both,
        contact_model=SimpleNamespace(flange=joint, places=(here, here)),
    )
    curve = ZoneFatigueStrength(SNCurve(amplitude=1e3, cycles=1e6, slope=5))
    return BoltedContactAnalysis.from_solution(
        solved, (here, here), bolts=Bolts(preload=PRELOAD, friction=FRICTION),
        count=2, strength={"sheet": curve},
    )  # fmt: skip


def pulled(*forces: float) -> np.ndarray:
    """Loads (t, 9) of forces along y."""
    loads = np.zeros((len(forces), 9))
    loads[:, 1] = forces
    return loads


def test_stress_amplitude_in_contact_is_conservative():
    """0.7 and 1.3 of what is told, each and a fifth more."""
    found = contact().stress_factors([pulled(0, 90, 40, -60, 30)])
    assert found == pytest.approx([0.84, 1.56], rel=5e-3)


def test_contact_factor_uses_pass_with_largest_amplitude():
    """One that does not swing says nothing."""
    of = contact()
    assert of.stress_factors([pulled(90, -90), pulled(60, 60)]) == pytest.approx(
        [0.84, 1.56], rel=5e-3
    )


def test_contact_factor_is_one_if_bolts_slip():
    assert (contact().stress_factors([pulled(0, 1.2 * BEARS)]) == 1.0).all()


def test_slip_utilisation_is_that_of_worst_moment():
    history = pulled(*np.random.default_rng(5).uniform(-0.7, 0.5, 200) * BEARS, 0.8 * BEARS)
    assert contact().slip_utilisation(history) == pytest.approx(0.8, rel=0.03)
    assert contact().slip_utilisation(pulled(1.6 * BEARS)) == pytest.approx(1.6, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("swapped", [False, True])
def test_slip_utilisation_is_the_worse_of_both_frame_stiffnesses(swapped):
    """On a bed as soft as a tenth of the ground a foot slips under a tenth less than on a hard one.

    Whichever of the two bears less is told.
    """
    joint = replace(coupled(np.random.default_rng(1)), elastic_frame_stiffness=1 / (1e-8 * 1e-4))
    bolts = Bolts(preload=PRELOAD, friction=0.3)
    frames = [on.tighten(bolts) for on in (joint, joint.on_elastic_frame)]
    loads = np.random.default_rng(25).normal(size=9) * ([100] * 3 + [30] * 3 + [0] * 3)
    loads /= frames[0].equilibrium_slip_utilisation(loads)[0]
    each = [on.slip_utilisation(loads)[0] for on in frames]
    assert each[1] > 1.05 * each[0]
    hard, soft = reversed(frames) if swapped else frames
    of = BoltedContactAnalysis(
        on_rigid_frame=hard,
        on_elastic_frame=soft,
        solved=None,
        place_features=(),
        feature_count=0,
        strength={},
    )
    assert of.slip_utilisation(loads[None]) == each[1]


# --------------------------------------------------------------------------- a whole study

FILE = (
    LINE
    + "duty: [{share_percent: 100, torque_Nm: 8000, speed_rpm: 400}]\n"
    + """\
bracket:
  u_shape: {seat_diameter_mm: 100, width_mm: 90, thickness_mm: 9, height_mm: 90, flange_mm: 75,
            bend_radius_mm: 12, bolt_diameter_mm: 17, bolt_pitch_mm: 45}
  element_mm: 25
  fatigue: {amplitude_MPa: 8, cycles: 1.0e+6, slope: 5, cut_edge: {range_MPa: 8, slope: 5}}
  bolts: {preload_kN: 30, friction: 0.12}
  cases: [{name: kerb, force_N: [0, 30000, 0]}, {name: mild, force_N: [0, 300, 0]}]
"""
)


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """Exit code, what the terminal says, and the JSON."""
    folder = tmp_path_factory.mktemp("bolts")
    (folder / "own.yaml").write_text(FILE, encoding="utf-8")
    done = CliRunner().invoke(
        cli, ["bracket", str(folder / "own.yaml"), "--json", str(folder / "out.json")]
    )
    return done.exit_code, done.output, json.loads((folder / "out.json").read_text("utf-8"))


@pytest.mark.bracket
def test_slipping_bolts_fail_verdict_and_study_continues(told):
    """30 kN across a flange whose four bolts rub by 14.4 kN: more than twice what they hold."""
    code, said, found = told
    assert code == 1
    assert found["verdict"] == "fail"
    slips = {c["name"]: c["slip_utilisation"] for c in found["variants"][0]["cases"]}
    assert slips["kerb"] > 0.98 * 30 / (4 * 30 * 0.12)
    assert slips["mild"] < 0.05
    rows = [c for c in found["checks"] if c["quantity"] == "bracket_slip_utilisation"]
    # The duty cycle's own loads are asked as well, at their own torque and speed.
    (rides,) = (d["slip_utilisation"] for d in found["variants"][0]["duty"])
    assert 0 < rides < 1
    assert sorted(r["value"] for r in rows) == pytest.approx(sorted([*slips.values(), rides]))
    assert [r["verdict"] for r in rows if r["value"] > 1] == ["fail"]
    assert "kerb: the bolts slip or open" in " ".join(said.split())


@pytest.mark.bracket
def test_bolted_bracket_study_reports_contact_and_held_results(told):
    """Utilisation and life are those in contact, by the share that stands beside them."""
    _, said, found = told
    variant = found["variants"][0]
    contact_ = variant["contact"]
    assert (contact_["preload_N"], contact_["friction"]) == (30e3, 0.12)
    case = next(c for c in variant["cases"] if c["name"] == contact_["case"])
    times, held = contact_["swing_over_held"], contact_["fatigue_utilisation_held"]
    assert case["swing_over_held"] == times
    assert min(times) < 0.98
    assert max(times) < 1.5
    most = max(h["fatigue_utilisation"] for h in variant["hot_spots"])
    assert most == pytest.approx(max(map(float.__mul__, times, held)), rel=0.03)
    # Every history has its own, and loads by hand, which nobody repeats, have none.
    assert {tuple(c["swing_over_held"]) for c in variant["cases"] if "swing_over_held" in c} > {
        tuple(times)
    }
    assert "swing_over_held" not in next(c for c in variant["cases"] if c["name"] == "mild")
    life, alone = variant["duty"][0]["life_hours"], contact_["life_hours_held"]
    assert min(times) ** -9 * alone > life > max(times) ** -9 * alone
    assert life != pytest.approx(alone, rel=1e-3)
    assert "In bolts of 30.00 kN" in said

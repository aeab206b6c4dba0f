"""A bracket in its bolts, from loads to the verdict: on a rigid foot, and by a whole study."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from brackets import LINE
from click.testing import CliRunner
from test_bracket_joint import COUNT, coupled, foot

from cardan.cli import cli
from cardan.fatigue.strength import SNCurve
from cardan.model.bracket import Bolts
from cardan.study.bracket_contact import Contact
from cardan.study.bracket_life import Strength

PRELOAD, FRICTION = 1000.0, 0.15
BEARS = PRELOAD * FRICTION
SHARES = ((0.6, 1.3), (0.7, 1.2))
"""Of the stress told by the sliding way, that friction makes at two places, by either way."""


def contact() -> Contact:
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
    both = tuple(SimpleNamespace(unit=unit * size, zones=zones) for size in (1.0, 0.5))
    object.__setattr__(joint, "stress", stress)
    here = np.arange(2)
    solved = SimpleNamespace(both=both, bolted=SimpleNamespace(joint=joint, places=(here, here)))
    curve = Strength(SNCurve(amplitude=1e3, cycles=1e6, slope=5))
    return Contact.of(
        solved, (here, here), bolts=Bolts(preload=PRELOAD, friction=FRICTION),
        count=2, strength={"sheet": curve},
    )  # fmt: skip


def pulled(*forces: float) -> np.ndarray:
    """Loads (t, 9) of forces along y."""
    loads = np.zeros((len(forces), 9))
    loads[:, 1] = forces
    return loads


def test_swings_in_contact_are_those_of_friction_on_their_safe_side():
    """0.7 and 1.3 of what is told, each and a fifth more."""
    found = contact().times([pulled(0, 90, 40, -60, 30)])
    assert found == pytest.approx([0.84, 1.56], rel=5e-3)


def test_of_passes_the_one_counts_in_which_a_place_swings_most():
    """One that does not swing says nothing."""
    of = contact()
    assert of.times([pulled(90, -90), pulled(60, 60)]) == pytest.approx([0.84, 1.56], rel=5e-3)


def test_where_the_bolts_slip_stress_stays_as_told():
    assert (contact().times([pulled(0, 1.2 * BEARS)]) == 1.0).all()


def test_what_the_bolts_hold_is_told_of_the_worst_moment():
    history = pulled(*np.random.default_rng(5).uniform(-0.7, 0.5, 200) * BEARS, 0.8 * BEARS)
    assert contact().share(history) == pytest.approx(0.8, rel=0.03)
    assert contact().share(pulled(1.6 * BEARS)) == pytest.approx(1.6, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("swapped", [False, True])
def test_what_the_bolts_hold_is_asked_of_both_frames(swapped):
    """On a bed as soft as a tenth of the ground a foot slips under a tenth less than on a hard one.

    Whichever of the two bears less is told.
    """
    joint = replace(coupled(np.random.default_rng(1)), thick=1 / (1e-8 * 1e-4))
    bolts = Bolts(preload=PRELOAD, friction=0.3)
    frames = [on.tightened(bolts) for on in (joint, joint.on_thick)]
    loads = np.random.default_rng(25).normal(size=9) * ([100] * 3 + [30] * 3 + [0] * 3)
    loads /= frames[0].unbalanced(loads)[0]
    each = [on.share(loads)[0] for on in frames]
    assert each[1] > 1.05 * each[0]
    hard, soft = reversed(frames) if swapped else frames
    of = Contact(tight=hard, soft=soft, solved=None, features=(), count=0, strength={})
    assert of.share(loads[None]) == each[1]


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
def test_bolts_that_slip_fail_the_verdict_and_end_no_study(told):
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
def test_a_study_in_bolts_tells_contact_and_the_two_ways(told):
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

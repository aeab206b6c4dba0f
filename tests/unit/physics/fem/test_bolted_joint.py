"""A rigid foot on springs that only push: Navier's trapezium, and beyond the core a triangle."""

from dataclasses import replace

import numpy as np
import pytest
from bolted_foot import COUNT, WIDE, Y, coupled, foot

from cardan.core.errors import ConvergenceError, DesignError
from cardan.model.bracket import Bolts, default_bolt_preload
from cardan.topics.bracket.contact_assessment import enlarge_by_contact_error


def pressure(tight):
    """Force of the frame on each step along y, N."""
    return -tight.forces[: 6 * COUNT].reshape(2, COUNT, 3)[..., 2].sum(axis=0)


def test_preload_within_core_presses_whole_foot():
    found = pressure(foot(out_of_middle=WIDE / 12).tighten(Bolts(preload=1000.0)))
    assert found.sum() == pytest.approx(1000.0, rel=1e-3)
    assert found.max() == pytest.approx(1000 / COUNT * 1.5, rel=1 / COUNT)


def test_preload_beyond_core_gives_triangular_pressure():
    """Three times what the force is from the edge presses; its peak is twice the mean there."""
    away = 0.3 * WIDE
    tight = foot(out_of_middle=away).tighten(Bolts(preload=1000.0))
    found, long = pressure(tight), 3 * (WIDE / 2 - away)
    assert (found > 0).sum() * WIDE / COUNT == pytest.approx(long, rel=0.05)
    assert found.max() == pytest.approx(2 * 1000 / long * WIDE / COUNT, rel=0.05)
    assert found.min() >= 0.0


@pytest.mark.parametrize(("squeezes", "sticks"), [(0.5e-12, True), (5e-12, False)])
def test_bolt_head_spreading_is_balanced_by_friction(squeezes, sticks):
    """A head that spreads the foot by itself: friction holds what it can of that, in balance.

    Without it the spread is whole; as it was, and a flange stood off by two thirds too much.
    """
    of, head, preload = foot(), 6 * COUNT, 1000.0
    along = 3 * np.arange(2 * COUNT) + 1
    out = squeezes * np.tile(Y, 2) / (WIDE / 2)
    compliance = of.compliance.copy()
    compliance[along, head] = compliance[head, along] = out
    tight = replace(of, compliance=compliance).tighten(Bolts(preload=preload, friction=0.15))
    rubs, bears = tight.forces[along], 0.15 * preload / (2 * COUNT)
    if sticks:  # what sticks gives a twentieth of what its patch does
        assert rubs == pytest.approx(-preload * out / 1.05e-9, rel=1e-2, abs=1e-3 * bears)
    far = np.abs(np.tile(Y, 2)) > 0.4 * WIDE
    assert np.allclose(np.abs(rubs[far]), bears, rtol=0.02) != sticks
    assert rubs.sum() == pytest.approx(0.0, abs=1e-3 * preload)


def test_foot_shear_is_limited_by_friction():
    tight = foot().tighten(Bolts(preload=1000.0, friction=0.15))
    held = tight.added_forces([0, 140.0, 0, *6 * [0]])
    assert held[: 6 * COUNT].reshape(-1, 3)[:, 1].sum() == pytest.approx(-140.0, rel=1e-3)
    with pytest.raises(ConvergenceError, match="slip or open"):
        tight.added_forces([0, 200.0, 0, *6 * [0]])


@pytest.mark.parametrize("seed", range(8))
def test_contact_forces_satisfy_equilibrium_and_friction(seed):
    """Balance, no pull, no rubbing beyond what friction bears."""
    rng = np.random.default_rng(seed)
    joint = coupled(rng)
    tight = joint.tighten(Bolts(preload=1000.0, friction=0.3))
    for _ in range(25):
        push, turned = np.array([60, 60, 300]), np.array([60, 3, 3])
        load = np.concatenate(
            [rng.uniform(-1, 1, 3) * push, rng.uniform(-1, 1, 3) * turned, np.zeros(3)]
        )
        whole = tight.forces + tight.added_forces(load)
        each = whole[: 3 * joint.patch_count].reshape(-1, 3)
        assert np.abs(joint.rigid_body_work.T @ whole).max() < 1e-3 * np.abs(whole).sum()
        assert np.maximum(each[:, 2], 0.0).sum() <= 1e-9
        rub = np.hypot(*each[:, :2].T)
        over = np.maximum(rub - 0.3 * np.maximum(-each[:, 2], 0), 0.0)
        assert over.sum() <= 1e-9


def test_foot_slips_at_friction_limit_and_opens_at_preload():
    """By balance, and by what contact bears, here the same: the share of 150 N and of 1000 N."""
    tight = foot().tighten(Bolts(preload=1000.0, friction=0.15))
    for load, whole in (((0, 140.0, 0), 150), ((140.0, 0, 0), 150), ((0, 0, -700.0), 1000)):
        loads = np.array([*load, *6 * [0]])
        share, plane = tight.equilibrium_slip_utilisation(loads)
        assert share == pytest.approx(np.abs(loads).max() / whole, rel=0.02)
        assert plane @ loads == pytest.approx(share)
        assert tight.slip_utilisation(loads)[0] == pytest.approx(share, rel=0.03)
    assert (
        tight.equilibrium_slip_utilisation(np.array([0, 0, 900.0, *6 * [0]]))[0] == 0.0
    )  # it is pressed on


@pytest.mark.parametrize("seed", range(8))
def test_equilibrium_capacity_is_bounded_by_its_plane(seed):
    """Other loads have no smaller share than the plane of one says."""
    tight = coupled(np.random.default_rng(3)).tighten(Bolts(preload=1000.0, friction=0.3))
    loads = np.random.default_rng(seed).normal(size=(2, 9)) * ([100] * 3 + [3] * 3 + [0] * 3)
    _, plane = tight.equilibrium_slip_utilisation(loads[0])
    assert tight.equilibrium_slip_utilisation(loads[1])[0] >= plane @ loads[1] - 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("seed", [21, 25, 30])
def test_contact_capacity_is_below_equilibrium_capacity(seed):
    """What presses moves as it slips; up to what is told contact is found, and beyond it none."""
    tight = coupled(np.random.default_rng(1)).tighten(Bolts(preload=1000.0, friction=0.3))
    loads = np.random.default_rng(seed).normal(size=9) * ([100] * 3 + [30] * 3 + [0] * 3)
    loads *= 0.9 / tight.equilibrium_slip_utilisation(loads)[0]
    share, _ = tight.slip_utilisation(loads)
    assert 1.1 < share < 1.4
    tight.added_forces(loads / share * 0.97)
    with pytest.raises(ConvergenceError, match="slip or open"):
        tight.added_forces(loads / share * 1.04)


def test_pull_beyond_bolt_preload_is_rejected():
    tight = foot().tighten(Bolts(preload=1000.0))
    with pytest.raises(ConvergenceError):
        tight.added_forces([0, 0, -1100.0, *6 * [0]])


def test_preload_of_8_8_bolt_follows_hole_size():
    assert default_bolt_preload(11e-3) == pytest.approx(27.3e3, rel=1e-2)
    with pytest.raises(DesignError, match="preload above 0"):
        Bolts(preload=0.0)


def test_contact_factor_is_conservative():
    """By as much as CalculiX may have more, though two ways to be held had less."""
    assert enlarge_by_contact_error(np.array([0.6, 0.95, 1.2])) == pytest.approx([0.72, 1.14, 1.44])


def test_compliant_frame_evens_out_contact_pressure():
    """Springs in series: a foot thrice as soft in its middle, on a bed ten times as soft as it."""
    of, soft = foot(), np.tile(np.abs(Y) < WIDE / 4, 2)
    own = np.where(soft, 3e-9, 1e-9)
    compliance = of.compliance.copy()
    normal = 3 * np.arange(2 * COUNT) + 2
    compliance[normal, normal] = own
    of = replace(of, compliance=compliance, elastic_frame_stiffness=1 / (1e-8 * 1e-4))
    for on, ratio in ((of, 3.0), (of.on_elastic_frame, 13 / 11)):
        presses = on.tighten(Bolts(preload=1000.0)).forces[normal]
        assert presses.sum() == pytest.approx(-1000.0, rel=1e-3)
        assert presses[~soft].mean() / presses[soft].mean() == pytest.approx(ratio, rel=1e-2)

"""A rigid foot on springs that only push: Navier's trapezium, and beyond the core a triangle."""

from dataclasses import replace

import numpy as np
import pytest

from cardan.base.errors import DesignError, NotConverged
from cardan.bracket.joint import Joint
from cardan.model.bracket import Bolts, usual_preload
from cardan.study.bracket_contact import on_its_safe_side

WIDE, COUNT = 0.3, 60
Y = (np.arange(COUNT) + 0.5) / COUNT * WIDE - WIDE / 2


def foot(*, out_of_middle=0.0):
    """Two rows of patches along y, on springs of their own; one bolt, out of the middle along y."""
    places = np.array([(x, y, 0.0) for x in (-0.01, 0.01) for y in Y])
    ways = np.tile(np.eye(3), (len(places), 1))
    at = np.repeat(places, 3, axis=0)
    ways = np.concatenate([ways, np.eye(3)[[2]], np.eye(3), np.zeros((6, 3))])
    at = np.concatenate([at, [(0.0, out_of_middle, 0.0)], np.zeros((9, 3))])
    rigid = np.concatenate([ways, np.cross(at, ways)], axis=1)
    gives = np.where(np.arange(len(ways)) < 3 * len(places), 1e-9, 0.0)
    return Joint(
        compliance=np.diag(gives), rigid=rigid,
        stress=np.zeros((len(ways), 0, 6)), upright=2, bolts=1, area=np.full(len(places), 1e-4),
    )  # fmt: skip


def coupled(rng):
    """The same on an elastic ground that what presses dents around it."""
    of = foot()
    places = np.array([(x, y) for x in (-0.01, 0.01) for y in Y])
    apart = np.linalg.norm(places[:, None] - places[None], axis=-1)
    dent = 1e-9 / (1 + apart / 0.01) * (1 + 0.3 * rng.random())
    compliance = np.zeros_like(of.compliance)
    compliance[: 6 * COUNT, : 6 * COUNT] = np.kron(dent, np.diag([1.2, 1.2, 1.0]))
    return replace(of, compliance=compliance, rigid=np.concatenate([
        of.rigid[: 6 * COUNT + 4], np.eye(6)[3:], np.zeros((3, 6))
    ]))  # fmt: skip


def pressure(tight):
    """Force of the frame on each step along y, N."""
    return -tight.forces[: 6 * COUNT].reshape(2, COUNT, 3)[..., 2].sum(axis=0)


def test_within_the_core_all_of_a_foot_presses():
    found = pressure(foot(out_of_middle=WIDE / 12).tightened(Bolts(preload=1000.0)))
    assert found.sum() == pytest.approx(1000.0, rel=1e-3)
    assert found.max() == pytest.approx(1000 / COUNT * 1.5, rel=1 / COUNT)


def test_beyond_the_core_a_foot_lifts_off_and_a_triangle_is_left():
    """Three times what the force is from the edge presses; its peak is twice the mean there."""
    away = 0.3 * WIDE
    tight = foot(out_of_middle=away).tightened(Bolts(preload=1000.0))
    found, long = pressure(tight), 3 * (WIDE / 2 - away)
    assert (found > 0).sum() * WIDE / COUNT == pytest.approx(long, rel=0.05)
    assert found.max() == pytest.approx(2 * 1000 / long * WIDE / COUNT, rel=0.05)
    assert found.min() >= 0.0


@pytest.mark.parametrize(("squeezes", "sticks"), [(0.5e-12, True), (5e-12, False)])
def test_what_a_head_squeezes_out_rubs_from_the_start(squeezes, sticks):
    """A head that spreads the foot by itself: friction holds what it can of that, in balance.

    Without it the spread is whole; as it was, and a flange stood off by two thirds too much.
    """
    of, head, preload = foot(), 6 * COUNT, 1000.0
    along = 3 * np.arange(2 * COUNT) + 1
    out = squeezes * np.tile(Y, 2) / (WIDE / 2)
    compliance = of.compliance.copy()
    compliance[along, head] = compliance[head, along] = out
    tight = replace(of, compliance=compliance).tightened(Bolts(preload=preload, friction=0.15))
    rubs, bears = tight.forces[along], 0.15 * preload / (2 * COUNT)
    if sticks:  # what sticks gives a twentieth of what its patch does
        assert rubs == pytest.approx(-preload * out / 1.05e-9, rel=1e-2, abs=1e-3 * bears)
    far = np.abs(np.tile(Y, 2)) > 0.4 * WIDE
    assert np.allclose(np.abs(rubs[far]), bears, rtol=0.02) != sticks
    assert rubs.sum() == pytest.approx(0.0, abs=1e-3 * preload)


def test_a_foot_holds_by_friction_and_no_more():
    tight = foot().tightened(Bolts(preload=1000.0, friction=0.15))
    held = tight.under([0, 140.0, 0, *6 * [0]])
    assert held[: 6 * COUNT].reshape(-1, 3)[:, 1].sum() == pytest.approx(-140.0, rel=1e-3)
    with pytest.raises(NotConverged, match="slip or open"):
        tight.under([0, 200.0, 0, *6 * [0]])


@pytest.mark.parametrize("seed", range(8))
def test_what_a_foot_bears_obeys_contact_and_friction(seed):
    """Balance, no pull, no rubbing beyond what friction bears."""
    rng = np.random.default_rng(seed)
    joint = coupled(rng)
    tight = joint.tightened(Bolts(preload=1000.0, friction=0.3))
    for _ in range(25):
        push, turned = np.array([60, 60, 300]), np.array([60, 3, 3])
        load = np.concatenate(
            [rng.uniform(-1, 1, 3) * push, rng.uniform(-1, 1, 3) * turned, np.zeros(3)]
        )
        whole = tight.forces + tight.under(load)
        each = whole[: 3 * joint.patches].reshape(-1, 3)
        assert np.abs(joint.rigid.T @ whole).max() < 1e-3 * np.abs(whole).sum()
        assert np.maximum(each[:, 2], 0.0).sum() <= 1e-9
        rub = np.hypot(*each[:, :2].T)
        over = np.maximum(rub - 0.3 * np.maximum(-each[:, 2], 0), 0.0)
        assert over.sum() <= 1e-9


def test_a_foot_slides_at_its_friction_and_opens_at_its_preload():
    """By balance, and by what contact bears, here the same: the share of 150 N and of 1000 N."""
    tight = foot().tightened(Bolts(preload=1000.0, friction=0.15))
    for load, whole in (((0, 140.0, 0), 150), ((140.0, 0, 0), 150), ((0, 0, -700.0), 1000)):
        loads = np.array([*load, *6 * [0]])
        share, plane = tight.unbalanced(loads)
        assert share == pytest.approx(np.abs(loads).max() / whole, rel=0.02)
        assert plane @ loads == pytest.approx(share)
        assert tight.share(loads)[0] == pytest.approx(share, rel=0.03)
    assert tight.unbalanced(np.array([0, 0, 900.0, *6 * [0]]))[0] == 0.0  # it is pressed on


@pytest.mark.parametrize("seed", range(8))
def test_what_balance_bears_is_bounded_by_its_plane(seed):
    """Other loads have no smaller share than the plane of one says."""
    tight = coupled(np.random.default_rng(3)).tightened(Bolts(preload=1000.0, friction=0.3))
    loads = np.random.default_rng(seed).normal(size=(2, 9)) * ([100] * 3 + [3] * 3 + [0] * 3)
    _, plane = tight.unbalanced(loads[0])
    assert tight.unbalanced(loads[1])[0] >= plane @ loads[1] - 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("seed", [21, 25, 30])
def test_contact_bears_less_than_balance(seed):
    """What presses moves as it slips; up to what is told contact is found, and beyond it none."""
    tight = coupled(np.random.default_rng(1)).tightened(Bolts(preload=1000.0, friction=0.3))
    loads = np.random.default_rng(seed).normal(size=9) * ([100] * 3 + [30] * 3 + [0] * 3)
    loads *= 0.9 / tight.unbalanced(loads)[0]
    share, _ = tight.share(loads)
    assert 1.1 < share < 1.4
    tight.under(loads / share * 0.97)
    with pytest.raises(NotConverged, match="slip or open"):
        tight.under(loads / share * 1.04)


def test_a_foot_pulled_off_by_more_than_its_bolt_is_told():
    tight = foot().tightened(Bolts(preload=1000.0))
    with pytest.raises(NotConverged):
        tight.under([0, 0, -1100.0, *6 * [0]])


def test_a_bolt_of_8_8_is_tightened_by_its_hole():
    assert usual_preload(11e-3) == pytest.approx(27.3e3, rel=1e-2)
    with pytest.raises(DesignError, match="preload above 0"):
        Bolts(preload=0.0)


def test_contact_is_told_on_its_safe_side():
    """By as much as CalculiX may have more, though two ways to be held had less."""
    assert on_its_safe_side(np.array([0.6, 0.95, 1.2])) == pytest.approx([0.72, 1.14, 1.44])


def test_a_frame_that_gives_evens_out_what_presses():
    """Springs in series: a foot thrice as soft in its middle, on a bed ten times as soft as it."""
    of, soft = foot(), np.tile(np.abs(Y) < WIDE / 4, 2)
    own = np.where(soft, 3e-9, 1e-9)
    compliance = of.compliance.copy()
    normal = 3 * np.arange(2 * COUNT) + 2
    compliance[normal, normal] = own
    of = replace(of, compliance=compliance, thick=1 / (1e-8 * 1e-4))
    for on, ratio in ((of, 3.0), (of.on_thick, 13 / 11)):
        presses = on.tightened(Bolts(preload=1000.0)).forces[normal]
        assert presses.sum() == pytest.approx(-1000.0, rel=1e-3)
        assert presses[~soft].mean() / presses[soft].mean() == pytest.approx(ratio, rel=1e-2)

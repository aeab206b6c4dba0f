"""Strain-life: Neuber, Masing and memory against equations solved otherwise and loops by hand.

Dowling, Mechanical Behavior of Materials, 4th ed., ch. 14; Clormann & Seeger, Stahlbau 55 (1986).
"""

import numpy as np
import pytest
from scipy.optimize import brentq

from cardan.core.errors import DesignError
from cardan.core.units import GPa, MPa
from cardan.physics.fatigue.rainflow import discarded, half_cycles, rainflow, repeating
from cardan.physics.fatigue.strain_life import (
    CyclicMaterial,
    NotchStrainTracker,
    material_from_strain_life_curve,
)
from cardan.topics.recording.alternative_life_models import StrainLifeSettings, strain_life_damage

STEEL = CyclicMaterial(
    modulus=206 * GPa, strength=900 * MPa, exponent=-0.09, ductility=0.6, ductility_exponent=-0.6,
    hardening=1000 * MPa, hardening_exponent=0.15,
)  # fmt: skip


def strain_life(x, *, material, law="swt", notch=None):
    """Damage of a whole history, and its largest strain amplitude."""
    follower = NotchStrainTracker(material, largest=np.abs(x).max(), notch=notch)
    loops = (follower.update(x), follower.remaining_loops())
    largest = max(one.amplitude.max(initial=0.0) for one in loops)
    return sum(one.damage(material, law=law) for one in loops), largest


def strain(stress):
    return stress / 206e9 + (stress / 1e9) ** (1 / 0.15)


@pytest.mark.parametrize("elastic", [50e6, 300e6, 900e6])
def test_neuber_stress_satisfies_its_equation(elastic):
    kt = 2.2
    ours = float(STEEL.stress(np.array(elastic), notch=kt))
    theirs = brentq(lambda s: s * strain(s) - (kt * elastic) ** 2 / 206e9, 1.0, kt * elastic)
    assert ours == pytest.approx(theirs, rel=1e-9)
    measured = float(STEEL.stress(np.array(elastic), notch=None))
    assert strain(measured) == pytest.approx(elastic / 206e9, rel=1e-9)


@pytest.mark.parametrize("law", ["swt", "morrow", "none"])
def test_strain_life_satisfies_its_equation(law):
    amplitude, mean = 3e-3, 120e6
    top = mean + 350e6

    def misfit(logs):
        two = np.exp(logs)
        if law == "swt":
            return 900e6**2 / 206e9 * two**-0.18 + 900e6 * 0.6 * two**-0.69 - top * amplitude
        lift = 900e6 - (mean if law == "morrow" else 0)
        return lift / 206e9 * two**-0.09 + 0.6 * two**-0.6 - amplitude

    theirs = np.exp(brentq(misfit, 0, 40)) / 2
    ours = STEEL.cycles_to_failure(*map(np.array, (amplitude, mean, top)), law)
    assert float(ours) == pytest.approx(theirs, rel=1e-9)


def loops(history, *, notch=None, cuts=()):
    x = np.array(history) * 1e6
    follower = NotchStrainTracker(STEEL, largest=np.abs(x).max(), notch=notch)
    parts = [follower.update(part) for part in np.split(x, cuts)]
    return parts, follower.remaining_loops()


def test_masing_memory_matches_hand_calculation():
    """0, 400, -100, 200, -100 ... the inner loop hangs on the way down, and is forgotten."""
    parts, rest = loops([0, 400, -100, 200, -300, 400])
    (inner,) = [p for p in parts if p.amplitude.size]

    def on_curve(size):
        return brentq(lambda s: strain(s) - size / 206e9, 0, size)

    def back(size):
        return 2 * on_curve(size / 2)

    top = on_curve(400e6)
    low = top - back(500e6)
    high = low + back(300e6)
    assert inner.mean[0] == pytest.approx((low + high) / 2, rel=1e-5)
    assert inner.top[0] == pytest.approx(high, rel=1e-5)
    assert inner.amplitude[0] == pytest.approx(strain((high - low) / 2), rel=1e-5)
    # As if the loop had not been: -300 is reached from 400 on one way.
    end = top - back(700e6)
    assert rest.top[0] == pytest.approx(top, rel=1e-5)
    assert rest.mean[0] == pytest.approx((top + end) / 2, rel=1e-5)


def test_overload_reduces_mean_stress_of_later_cycles():
    """After a high crest the same cycles run at a lower mean, and live longer: Dowling, 14.5."""
    cycle = [100, 500] * 20
    plain, _ = strain_life(np.array([0, *cycle]) * 1e6, material=STEEL, notch=2.0)
    after, _ = strain_life(np.array([0, 700, *cycle]) * 1e6, material=STEEL, notch=2.0)
    alone, _ = strain_life(np.array([0, 700, 100]) * 1e6, material=STEEL, notch=2.0)
    assert after - alone < 0.8 * plain


def test_hysteresis_loops_match_rainflow():
    x = 300 * np.random.default_rng(0).normal(size=4000)
    parts, rest = loops([0, *x], cuts=[17, 800, 2500])
    count = sum(p.count.sum() for p in (*parts, rest))
    ranges = rainflow(np.array([0, *x])).range
    counted = rainflow(np.array([0, *x])).count[ranges > 2e-3 * np.abs(x).max()].sum()
    # HCM closes against the first loading, ASTM's residue does not: some loops of 2700.
    assert count == pytest.approx(counted, rel=0.01)
    whole, _ = loops([0, *x])
    both = [sum(p.damage(STEEL, law="swt") for p in of) for of in (parts, whole)]
    assert both[0] == pytest.approx(both[1], rel=1e-9)


def ishlinskii(x, size):
    """Response to a history that begins at rest, by stops in parallel: Prandtl (1928).

    Independent of memory and loops: a stop follows until it slides, and `size` (S) is that of the
    first loading.
    """
    r = np.linspace(0, 1.001 * np.abs(x).max(), 4001)
    slope = np.append(np.diff([size(s) for s in r]) / np.diff(r), 0.0)
    weight, y, out = -np.diff(slope), np.zeros(r.size - 1), []
    for v, before in zip(x, [0.0, *x[:-1]], strict=True):
        y = np.clip(y + v - before, -r[1:], r[1:])
        out.append(weight @ y)
    return np.array(out)


@pytest.mark.slow
def test_open_branches_follow_strain_path():
    """By stops: a leg of first loading had been taken for one of the doubled curve, 5 % of damage.

    40, -50 .. 310, -320 never closes: each leg lies on the curve of first loading.
    """
    x = np.array([v * (-1) ** k for k, v in enumerate(range(40, 330, 10))]) * 1e6
    _, rest = loops([0, *(x / 1e6)], notch=2.2)
    local = ishlinskii(x, lambda s: float(STEEL.stress(np.array(s), notch=2.2)))
    extent = ishlinskii(x, lambda s: strain(float(STEEL.stress(np.array(s), notch=2.2))))
    legs = np.abs(np.diff(extent)) / 2
    assert rest.amplitude[-legs.size :] == pytest.approx(legs, rel=1e-3)
    assert rest.top[-legs.size :] == pytest.approx(np.maximum(local[1:], local[:-1]), rel=1e-3)


@pytest.mark.slow
def test_residue_damage_follows_selected_rule():
    """`repeat`: the second passage, by stops; all three had told the same."""
    x = np.array([0, 200, -70, 188, -60, 160, -50, 90, 10]) * 1e6

    def damage(rule):
        of = StrainLifeSettings(material=STEEL, notch_factor=2.2)
        pieces = lambda: iter(np.split(x[None], [3], axis=1))  # noqa: E731
        ((told, _),) = strain_life_damage(pieces, [np.abs(x).max()], of, rule=rule)
        return told

    twice = np.concatenate([x, x])
    local = ishlinskii(twice, lambda s: float(STEEL.stress(np.array(s), notch=2.2)))
    extent = ishlinskii(twice, lambda s: strain(float(STEEL.stress(np.array(s), notch=2.2))))
    open_, done = [], 0.0
    for k in range(twice.size):
        # A sample that turns nowhere is on its way.
        if len(open_) > 1 and (twice[k] - twice[open_[-1]]) * (
            twice[open_[-1]] - twice[open_[-2]]
        ) >= 0:  # fmt: skip
            open_.pop()
        open_.append(k)
        while len(open_) > 3:
            a, b, c, d = twice[open_[-4:]]
            if not (abs(c - b) <= abs(b - a) and abs(c - b) <= abs(d - c)):
                break
            one, other = open_[-3:-1]
            if k >= x.size:
                size = np.array(abs(extent[one] - extent[other]) / 2)
                top = np.array(max(local[one], local[other]))
                done += 1 / float(STEEL.cycles_to_failure(size, np.array(0.0), top, "swt"))
            del open_[-3:-1]
    assert damage(repeating) == pytest.approx(done, rel=1e-3)
    halves, closed = damage(half_cycles), damage(discarded)
    assert closed < halves < 2 * done
    assert closed == pytest.approx(0.0, abs=1e-12)  # each way is smaller than the one before


def test_elastic_cycles_follow_basquin():
    """Small stresses: a line of slope -1/b, K_t a factor."""
    hard = material_from_strain_life_curve(
        modulus=206 * GPa, strength=2000 * MPa, exponent=-0.1, ductility=1e-9,
        ductility_exponent=-0.6,
    )  # fmt: skip
    x = np.array([0, *[200, -200] * 50]) * 1e6
    damage, amplitude = strain_life(x, material=hard, law="none", notch=1.5)
    assert amplitude == pytest.approx(300e6 / 206e9, rel=1e-3)
    each = 2 * (300 / 2000) ** (1 / 0.1)
    assert damage == pytest.approx(49.5 * each, rel=0.02)


def test_invalid_strain_life_material_is_rejected():
    with pytest.raises(DesignError, match="exponent of a strain-life curve"):
        material_from_strain_life_curve(
            modulus=2e11, strength=9e8, exponent=0.1, ductility=0.5, ductility_exponent=-0.6
        )
    with pytest.raises(DesignError, match="ductility of a strain-life curve"):
        material_from_strain_life_curve(
            modulus=2e11, strength=9e8, exponent=-0.1, ductility=0, ductility_exponent=-0.6
        )

"""Laws and tendencies of whirl, strength and life."""

from dataclasses import replace

import numpy as np
import pytest
from campbell import campbell_diagram
from hypothesis import given, settings
from hypothesis import strategies as st

from cardan.core.units import deg, mm
from cardan.model.parts import CentreBearing, Line, Shaft, Tube
from cardan.physics.strength.beams import beam_model
from cardan.physics.strength.bearing_life import (
    cross_joint_life_consumption_rate,
    joint_life,
)
from cardan.physics.strength.critical_speed import (
    bearing_resonance_speed,
    line_critical_speed,
    synchronous_whirl_modes,
)
from cardan.physics.strength.torsional_strength import joint_fatigue_utilisation, tube_shear_stress

few = settings(max_examples=20)
rubber = st.floats(2e4, 5e6)


@st.composite
def lines(draw):
    """Draw beams of two or three shafts on rubber."""
    shafts = []
    count = draw(st.integers(1, 3))
    for k in range(count):
        length = draw(st.floats(0.6, 2.2))
        outer = draw(st.floats(60, 130)) * mm
        shafts.append(
            Shaft(
                length=length,
                tube=Tube(outer=outer, wall=draw(st.floats(2, 6)) * mm),
                yoke_mass=(draw(st.floats(0, 8)), draw(st.floats(0, 8))),
                yoke_inertia=draw(st.floats(0, 0.05)),
                centre_bearing=CentreBearing(
                    from_rear_joint=draw(st.floats(0, 0.4)) * length,
                    stiffness=(draw(rubber), draw(rubber)),
                )
                if k < count - 1
                else None,
            )
        )
    return beam_model(Line(shafts=tuple(shafts)))


def speeds(beams, modes=4):
    """Return the lowest critical speeds, forward and backward."""
    return synchronous_whirl_modes(beams, modes=modes).frequency


@few
@given(beams=lines(), more=st.floats(1.01, 1.5))
def test_longer_line_has_lower_critical_speed(beams, more):
    longer = replace(
        beams,
        length=more * beams.length,
        overhang=more * beams.overhang,
        spline_position=more * beams.spline_position,
    )
    assert np.all(speeds(longer) < speeds(beams))


@few
@given(beams=lines(), more=st.floats(1.01, 100))
def test_stiffer_bearings_never_lower_critical_speed(beams, more):
    stiffer = replace(beams, bearing_stiffness=more * beams.bearing_stiffness)
    assert np.all(speeds(stiffer) >= speeds(beams) * (1 - 1e-9))


@few
@given(beams=lines(), more=st.floats(0.1, 20))
def test_heavier_yokes_never_raise_critical_speed(beams, more):
    heavier = replace(beams, yoke_mass=beams.yoke_mass + more)
    assert np.all(speeds(heavier) <= speeds(beams) * (1 + 1e-9))


@few
@given(beams=lines())
def test_rigid_bearings_have_no_bounce_mode(beams):
    """Rounding once left a rigid bearing 1/ω² of 1e-23: it bounced at 2e11 rad/s."""
    rigid = replace(beams, bearing_stiffness=np.full_like(beams.bearing_stiffness, np.inf))
    modes = synchronous_whirl_modes(rigid)
    assert np.isinf(bearing_resonance_speed(modes))
    assert np.isfinite(line_critical_speed(modes))


@few
@given(beams=lines())
def test_rotated_line_has_equal_critical_speeds(beams):
    """Lying the line on its side changes which plane is which, and nothing else."""
    turned = replace(beams, bearing_stiffness=beams.bearing_stiffness[..., ::-1])
    assert speeds(turned) == pytest.approx(speeds(beams), rel=1e-7)


@few
@given(beams=lines(), scale=st.floats(0.1, 10))
def test_scaled_model_has_scaled_critical_speeds(beams, scale):
    """Geometrically similar, of one material, on rubber k ~ size: speeds go as 1/size."""
    power = {
        "length": 1, "overhang": 1, "spline_position": 1, "bending_stiffness": 4,
        "shear_stiffness": 2, "mass_per_length": 2, "rotary_inertia": 4, "yoke_mass": 3,
        "spline_mass": 3, "yoke_inertia": 5, "bearing_stiffness": 1,
    }  # fmt: skip
    model = replace(beams, **{k: getattr(beams, k) * scale**p for k, p in power.items()})
    assert speeds(model) * scale == pytest.approx(speeds(beams), rel=1e-6)


@few
@given(beams=lines())
def test_finer_elements_converge_from_above(beams):
    """Rayleigh: displacements of too few freedoms are too stiff, never too soft."""
    coarse, fine = (synchronous_whirl_modes(beams, modes=2, elements=n).frequency for n in (4, 8))
    assert np.all(fine <= coarse * (1 + 1e-9))
    assert np.all(coarse < 1.02 * fine)


@few
@given(beams=lines(), speed=st.floats(0, 600))
def test_whirl_frequencies_are_equal_for_both_rotation_senses(beams, speed):
    """Turning the other way swaps forward and backward and no frequency."""
    one, other = campbell_diagram(beams, speeds=[speed, -speed], modes=4).frequency
    assert one == pytest.approx(other, rel=1e-7)


@few
@given(
    torque=st.floats(1, 1e5), more=st.floats(1.001, 3), beta=st.floats(0, 20), n=st.floats(1, 700)
)
def test_higher_torque_speed_or_angle_shortens_joint_life(torque, more, beta, n):
    def life(torque, n, beta):
        return joint_life(
            cross_joint_life_consumption_rate(
                torque, speed=n, angle=beta * deg, rated_torque=2000.0, prime_mover_factor=1.25
            )
        )

    now = life(torque, n, beta)
    assert life(torque * more, n, beta) == pytest.approx(now / more ** (10 / 3))
    assert life(torque, n * more, beta) == pytest.approx(now / more)
    assert life(torque, n, (3 + beta) * more) < life(torque, n, 3 + beta)
    assert life(-torque, -n, beta) == now
    assert life(torque, n, min(beta, 3)) == life(torque, n, 0)


@few
@given(shares=st.lists(st.floats(0.01, 1), min_size=1, max_size=5), torques=st.floats(1, 1e4))
def test_duty_cycle_of_equal_points_equals_single_point(shares, torques):
    """However it is divided; and lives between those of its points otherwise."""
    shares = np.array(shares) / sum(shares)
    used = cross_joint_life_consumption_rate(
        torques * np.linspace(1, 2, shares.size),
        speed=100.0, angle=0.1, rated_torque=2e3, prime_mover_factor=1.0,
    )  # fmt: skip
    lives = 1 / used
    mixed = joint_life(used, shares=shares)
    assert lives.min() * (1 - 1e-12) <= mixed <= lives.max() * (1 + 1e-12)
    assert joint_life(np.full(shares.size, used[0]), shares=shares) == pytest.approx(lives[0])


@few
@given(outer=st.floats(0.03, 0.2), ratio=st.floats(0.01, 0.98), torque=st.floats(1, 1e5))
def test_shear_stress_integrates_to_torque(outer, ratio, torque):
    """∫ τ r dA over the section, with τ growing as r, is the torque again."""
    a, b = ratio * outer / 2, outer / 2
    x, w = np.polynomial.legendre.leggauss(4)
    r, w = (a + b) / 2 + (b - a) / 2 * x, w * (b - a) / 2
    tau = tube_shear_stress(torque, outer=outer, inner=2 * a) * r / b
    assert (w * tau * r * 2 * np.pi * r).sum() == pytest.approx(torque, rel=1e-9)


@few
@given(low=st.floats(-1, 1), less=st.floats(0.01, 1), ratio=st.floats(1, 2))
def test_larger_torque_range_increases_fatigue_utilisation(low, less, ratio):
    """From the same top a lower bottom is never easier, pulsating rated up to twice reversing."""
    wide, narrow = (
        joint_fatigue_utilisation(1.0, lowest=b, reversing=1.0, pulsating=ratio)
        for b in (low - less, low)
    )
    if low - less >= -1:
        assert wide >= narrow - 1e-12


def test_softer_flanges_never_raise_natural_frequencies():
    """A van's tube on flanges from rigid to 6000 N/mm, one of 15 kg: Rayleigh's theorem.

    At 10,000 N/mm the slowest mode has 48 % of its energy in the tube, and the next that has more
    than half is five times as fast. Below, the slowest is the heavy flange's alone.
    """
    tube = Tube(outer=88.9 * mm, wall=1.651 * mm)
    shaft = Shaft(length=1.434, tube=tube, yoke_mass=(1.8, 1.8))
    stiffness = np.geomspace(1e10, 6e6, 60)
    beams = replace(
        beam_model(Line(shafts=(shaft,))),
        flange_stiffness=stiffness[:, None, None] * np.ones((2, 2)),
        flange_mass=np.array([15.0, 0.0]),
    )
    found = line_critical_speed(synchronous_whirl_modes(beams))
    assert np.all(np.diff(found) < 0)

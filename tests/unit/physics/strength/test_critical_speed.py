"""The line as beams: shapes, limits, and what a Campbell diagram must do."""

from dataclasses import replace

import numpy as np
import pytest
from campbell import campbell_diagram

from cardan.core.errors import DesignError
from cardan.core.units import kg, mm
from cardan.model.material import Material
from cardan.model.parts import CentreBearing, Line, Shaft, Spline, Tube
from cardan.physics.strength.beams import BeamModel, beam_model
from cardan.physics.strength.critical_speed import (
    bearing_resonance_speed,
    line_critical_speed,
    slender_tube_critical_speed,
    synchronous_whirl_modes,
)

TUBE = Tube(outer=101.6 * mm, wall=3.2 * mm)


def truck(*, overhang=140 * mm, stiffness=(1.5e5, 2.5e5), spline=True):
    """Return three unlike shafts with yokes, the last with a spline."""
    bearing = CentreBearing(from_rear_joint=overhang, stiffness=stiffness)
    slip = Spline(mass=6 * kg, from_front_joint=250 * mm) if spline else None
    return Line(
        shafts=(
            Shaft(
                length=1.2, tube=TUBE, yoke_mass=(5, 6), yoke_inertia=0.03, centre_bearing=bearing
            ),
            Shaft(
                length=1.4, tube=TUBE, yoke_mass=(6, 6), yoke_inertia=0.03, centre_bearing=bearing
            ),
            Shaft(
                length=1.7, tube=Tube(outer=120 * mm, wall=4 * mm), yoke_mass=(7, 5), spline=slip
            ),
        )
    )


def test_batched_lines_equal_single_lines():
    """A stack of lines, stiffnesses and lengths at once is each of them by itself."""
    beams = beam_model(truck())
    lengths = beams.length * np.linspace(0.9, 1.1, 3)[:, None, None]
    rubber = beams.bearing_stiffness * np.array([0.5, 2.0])[:, None, None]
    both = synchronous_whirl_modes(
        replace(beams, length=lengths, bearing_stiffness=rubber), modes=6
    )
    assert both.frequency.shape == (3, 2, 6)
    assert both.shape.shape == (3, 2, 6, both.station.shape[-1], 2)
    for i in range(3):
        for j in range(2):
            one = replace(beams, length=lengths[i, 0], bearing_stiffness=rubber[j])
            alone = synchronous_whirl_modes(one, modes=6)
            assert both.frequency[i, j] == pytest.approx(alone.frequency, rel=1e-9)
            assert both.bending_share[i, j] == pytest.approx(alone.bending_share, abs=1e-9)
            assert both.station[i, j] == pytest.approx(alone.station)


def test_every_beam_array_accepts_a_batch_axis():
    """Every array of a line may carry the cases; here each doubles in its turn."""
    beams = replace(
        beam_model(truck()), flange_stiffness=np.full((2, 2), 2e6), flange_mass=np.full(2, 20.0)
    )
    first = synchronous_whirl_modes(beams, modes=4).frequency
    for name in (f for f in BeamModel.__dataclass_fields__ if f != "length"):
        value = getattr(beams, name)
        doubled = replace(beams, **{name: np.stack([value, 2 * value])})
        found = synchronous_whirl_modes(doubled, modes=4).frequency
        assert found[0] == pytest.approx(first, rel=1e-9)
        assert abs(found[1] / first - 1).max() > 1e-6, name


def test_zero_bearing_overhang_is_a_continuous_limit():
    """Overhang and softness may go to nothing, alone or together, in one array."""
    beams = beam_model(truck(stiffness=None))
    overhang = np.array([0.0, 1e-9, 1e-3, 0.1])[:, None] * np.ones(2)
    rigid = line_critical_speed(synchronous_whirl_modes(replace(beams, overhang=overhang)))
    assert rigid[1] == pytest.approx(rigid[0], rel=1e-6)
    assert rigid[2] == pytest.approx(rigid[0], rel=5e-3)
    assert rigid[3] > 1.05 * rigid[0] or rigid[3] < 0.95 * rigid[0]
    near = replace(beams, bearing_stiffness=np.full((2, 2), 1e14))
    assert line_critical_speed(synchronous_whirl_modes(near)) == pytest.approx(
        line_critical_speed(synchronous_whirl_modes(beams)), rel=1e-6
    )


def test_bearing_resonance_on_rubber_is_below_critical_speed():
    """On truck rubber the line bounces far below where it bends; on rigid bearings never."""
    modes = synchronous_whirl_modes(beam_model(truck()))
    assert bearing_resonance_speed(modes) < 0.3 * line_critical_speed(modes)
    assert np.isinf(
        bearing_resonance_speed(synchronous_whirl_modes(beam_model(truck(stiffness=None))))
    )
    assert np.all((modes.bending_share > -1e-12) & (modes.bending_share < 1 + 1e-12))


def test_pure_backward_mode_is_not_a_critical_speed():
    """Alike in both directions, the lowest mode is purely backward: the next one counts."""
    beams = beam_model(truck(stiffness=None))
    modes = synchronous_whirl_modes(beams)
    assert modes.forward_share[0] == pytest.approx(0, abs=1e-9)
    assert line_critical_speed(modes) > 1.001 * modes.frequency[0]
    sound = np.isfinite(modes.frequency)
    pure = np.minimum(modes.forward_share, 1 - modes.forward_share)[sound]
    assert pure.max() < 1e-6
    mixed = synchronous_whirl_modes(beam_model(truck()), modes=4).forward_share
    assert np.all((mixed > 0.01) & (mixed < 0.99))


def test_campbell_curve_crosses_order_1_at_critical_speed():
    """Two different eigenproblems: at Ω = ω the one must give the other's answer."""
    beams = beam_model(truck())
    critical = synchronous_whirl_modes(beams, modes=6)
    at = campbell_diagram(beams, speeds=critical.frequency, modes=8)
    for k, speed in enumerate(critical.frequency):
        near = np.argmin(abs(at.frequency[k] - speed))
        assert at.frequency[k, near] == pytest.approx(speed, rel=1e-8)
        assert at.forward_share[k, near] == pytest.approx(critical.forward_share[k], abs=1e-5)
        assert at.bending_share[k, near] == pytest.approx(critical.bending_share[k], abs=1e-6)


def test_spin_separates_forward_and_backward_whirl():
    """At rest the pairs are one; with speed forward rises and backward falls."""
    shaft = Line(shafts=(Shaft(length=0.8, tube=TUBE),))
    modes = campbell_diagram(beam_model(shaft), speeds=[0.0, 200.0, 400.0], modes=2)
    rest, slow, fast = modes.frequency
    assert rest[0] == pytest.approx(rest[1], rel=1e-9)
    assert fast[0] < slow[0] < rest[0] < slow[1] < fast[1]
    assert modes.forward_share[1:] == pytest.approx(np.array([[0, 1], [0, 1]]), abs=1e-6)


def test_mode_shapes_are_zero_at_rigid_supports():
    """No motion at gearbox, axle and rigid bearings; the largest is 1; halves of a sine."""
    modes = synchronous_whirl_modes(beam_model(truck(stiffness=None)), modes=6)
    x = modes.station
    held = [np.argmin(abs(x - at)) for at in (0.0, 1.06, 2.46, 4.3)]
    assert x[held] == pytest.approx([0.0, 1.06, 2.46, 4.3])
    assert abs(modes.shape[:, held]).max() < 1e-12
    assert np.hypot(*np.moveaxis(modes.shape, -1, 0)).max(-1) == pytest.approx(1)
    one = synchronous_whirl_modes(beam_model(Line(shafts=(Shaft(length=2.0, tube=TUBE),))), modes=1)
    sine = np.sin(np.pi * one.station / 2.0)
    # A circle is all amplitudes at once: each plane has 1/√2 of it. Cubics end on the sine.
    assert abs(one.shape[0]) == pytest.approx(np.stack([sine, sine], axis=-1) / 2**0.5, abs=1e-9)


def test_spline_mass_counts_once_at_any_position():
    """On a node, between nodes, at either end: the same kilograms, never none or twice."""
    beams = beam_model(Line(shafts=(Shaft(length=1.2, tube=TUBE),)))
    places = np.linspace(0, 1.2, 25)[:, None]
    heavy = replace(beams, spline_mass=np.full(1, 5.0), spline_position=places)
    speed = synchronous_whirl_modes(heavy, modes=1).frequency[:, 0]
    bare = synchronous_whirl_modes(beams, modes=1).frequency[0]
    assert speed[[0, -1]] == pytest.approx([bare, bare], rel=1e-9)  # held ends carry it
    assert speed == pytest.approx(speed[::-1], rel=1e-9)
    assert np.all(np.diff(speed[:13]) < 0)
    # Rayleigh's quotient with a sine, whose square is what mass counts, is within 1 % here;
    # the kilograms lost or doubled would be 20 %.
    mass = TUBE.mass_per_length * 1.2 / 2
    guess = bare / np.sqrt(1 + 5.0 / mass * np.sin(np.pi * places[:, 0] / 1.2) ** 2)
    assert speed == pytest.approx(guess, rel=0.01)


def test_shear_coefficient_matches_cowper_for_bar_and_thin_tube():
    """Cowper's table 1 for ν = 0.3: 0.886 for a bar, 0.531 for a thin tube."""
    bar, thin = Tube(outer=0.1, wall=0.05), Tube(outer=0.1, wall=1e-6)
    assert bar.shear_coefficient == pytest.approx(0.886, abs=5e-4)
    assert thin.shear_coefficient == pytest.approx(0.531, abs=5e-4)


def test_line_without_tubes_is_rejected():
    with pytest.raises(DesignError, match=r"shaft 1 of line main has no tube"):
        beam_model(Line(shafts=(Shaft(length=1.0),)))


def test_critical_speed_broadcasts_lengths_and_diameters():
    """Lengths and diameters broadcast."""
    speeds = slender_tube_critical_speed(
        np.array([[1.0], [2.0]]),
        outer=np.array([0.09, 0.1, 0.12]),
        inner=0.08,
        youngs_modulus=206e9,
        density=7850,
    )
    assert speeds.shape == (2, 3)
    assert speeds[0] / speeds[1] == pytest.approx(4)


def test_aluminium_and_steel_tubes_have_similar_critical_speed():
    """E/ρ is nearly the same: 70/2700 against 206/7850."""
    light = Material(name="6061", youngs_modulus=70e9, density=2700, poisson=0.33)
    tubes = TUBE, replace(TUBE, material=light)
    steel, aluminium = (
        synchronous_whirl_modes(
            beam_model(Line(shafts=(Shaft(length=1.5, tube=t),))), modes=1
        ).frequency[0]
        for t in tubes
    )
    assert aluminium / steel == pytest.approx(np.sqrt(70 / 2700 * 7850 / 206), rel=2e-3)

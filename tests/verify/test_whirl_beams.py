"""A line as beams against exact solutions: Timoshenko (1921), Rayleigh, Euler; Nelson (1980).

Each reference here is the differential equation solved by hand, with no elements in it.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from campbell import campbell_diagram
from scipy.optimize import brentq

from cardan.core.units import mm
from cardan.model.parts import CentreBearing, Line, Shaft, Tube
from cardan.physics.strength.beams import beam_model
from cardan.physics.strength.critical_speed import (
    bearing_resonance_speed,
    line_critical_speed,
    slender_tube_critical_speed,
    synchronous_whirl_modes,
)

TUBE = Tube(outer=101.6 * mm, wall=3.2 * mm)
L = 1.5
EI, m, J = TUBE.bending_stiffness, TUBE.mass_per_length, TUBE.polar_inertia_per_length / 2
SIMPLE = np.pi**2 / L**2 * np.sqrt(EI / m)


def line(*, shafts=1, tube=TUBE, length=L, overhang=0.0, stiffness=None, yokes=(0.0, 0.0)):
    """Return equal shafts hung on equal bearings."""
    bearing = CentreBearing(from_rear_joint=overhang, stiffness=stiffness)
    return Line(
        shafts=tuple(
            Shaft(
                length=length,
                tube=tube,
                yoke_mass=yokes,
                centre_bearing=bearing if k < shafts - 1 else None,
            )
            for k in range(shafts)
        )
    )


def slender(beams):
    """Return beams of Euler: no shear, no rotary inertia."""
    return replace(
        beams,
        shear_stiffness=np.full_like(beams.shear_stiffness, np.inf),
        rotary_inertia=np.zeros_like(beams.rotary_inertia),
    )


def lowest(beams, **options):
    """Return the lowest critical speed of any kind."""
    return synchronous_whirl_modes(beams, modes=1, **options).frequency[..., 0]


def order(error, elements):
    """Return the order of convergence between neighbouring numbers of elements."""
    return -np.diff(np.log(error)) / np.diff(np.log(elements))


@pytest.mark.parametrize("n", [4, 8, 16])
def test_uniform_shaft_formula_is_limit_of_beam_elements(n):
    """Cubic elements are too stiff by (π/n)⁴/1440; so must our two numbers differ.

    The next term of the series is (π/n)² smaller, and so is the tolerance.
    """
    simple = slender_tube_critical_speed(
        L,
        outer=TUBE.outer,
        inner=TUBE.inner,
        youngs_modulus=TUBE.material.youngs_modulus,
        density=TUBE.material.density,
    )
    excess = lowest(slender(beam_model(line())), elements=n) / simple - 1
    assert excess == pytest.approx((np.pi / n) ** 4 / 1440, rel=(np.pi / n) ** 2 / 10)


def test_line_on_rigid_bearings_whirls_as_its_longest_shaft():
    """Three shafts on rigid bearings whirl like the longest of them alone."""
    beams = slender(beam_model(line(shafts=3), lengths=[1.2, 1.5, 1.1]))
    alone = slender(beam_model(line()))
    assert line_critical_speed(synchronous_whirl_modes(beams)) == pytest.approx(
        lowest(alone), rel=1e-9
    )


def pinned(k, *, sense, tube=TUBE, kappa=None):
    """Exact synchronous speed of a pinned Timoshenko shaft, half waves of wave number k.

    (S k² - m ω²)(E I k² + S - (1 - 2 sense) J ω²) = S² k² for w = W sin kx, θ = Θ cos kx:
    sense is +1 forward and -1 backward, and a quadratic in ω² remains.
    """
    if kappa is None:  # Cowper's table, in the ratio of radii
        nu, ratio = tube.material.poisson, tube.inner / tube.outer
        kappa = 6 * (1 + nu) * (1 + ratio**2) ** 2
        kappa /= (7 + 6 * nu) * (1 + ratio**2) ** 2 + (20 + 12 * nu) * ratio**2
    S = kappa * tube.material.youngs_modulus / (2 * (1 + tube.material.poisson)) * tube.area
    I = np.pi / 64 * (tube.outer**4 - tube.inner**4)  # noqa: E741
    bend, rotary = tube.material.youngs_modulus * I, tube.material.density * I
    mass, effective = tube.material.density * tube.area, rotary * (1 - 2 * sense)
    roots = np.roots(
        [mass * effective, -(S * k**2 * effective + mass * (bend * k**2 + S)), S * bend * k**4]
    )
    return np.sqrt(min(r.real for r in roots if r.real > 0))


@pytest.mark.parametrize("half_waves", [1, 2, 3])
@pytest.mark.parametrize("sense", [1, -1])
def test_pinned_timoshenko_shaft_matches_exact_solution(half_waves, sense):
    """Shear, rotary inertia and gyroscopic moments against the exact quadratic.

    An element's shear is constant, and the best constants leave the share s (kh)²/12 of the
    energy out, s = x/(1+x) with x = E I k²/S the share of shear in it: speeds are s (kh)²/24
    high, beside Euler's (kh)⁴/1440. Rotary inertia changes that by its own share, (kr)².
    """
    k = half_waves * np.pi / L
    exact, beams = pinned(k, sense=sense), beam_model(line())
    x = EI * k**2 / beams.shear_stiffness[0]
    elements = np.array([8, 16, 32, 64])
    h = L / elements
    error = []
    for n in elements:
        modes = synchronous_whirl_modes(beams, elements=int(n))
        of_sense = modes.frequency[
            modes.forward_share > 0.5 if sense > 0 else modes.forward_share < 0.5
        ]
        error.append(of_sense[half_waves - 1] / exact - 1)
    predicted = x / (1 + x) * (k * h) ** 2 / 24 + (k * h) ** 4 / 1440
    kr2 = k**2 * TUBE.second_moment / TUBE.area
    assert error == pytest.approx(predicted, rel=3 * kr2 + 0.03)
    assert order(error, elements)[-1] == pytest.approx(2, abs=0.02)


def test_shear_and_gyroscopic_effects_match_first_order():
    """To first order: -½ (E/κG) (kr)² for shear, +½ (kr)² for a forward, -3/2 for a backward."""
    tube = Tube(outer=40 * mm, wall=2 * mm)
    r2 = tube.second_moment / tube.area
    kr2 = (np.pi / L) ** 2 * r2
    kappa = 2 * 1.3 / (4 + 3 * 0.3)  # Cowper's thin tube
    simple = np.pi**2 / L**2 * np.sqrt(tube.bending_stiffness / tube.mass_per_length)
    speeds = synchronous_whirl_modes(beam_model(line(tube=tube)), modes=2, elements=32).frequency
    shear = -2.6 / kappa / 2
    assert (speeds / simple - 1) / kr2 == pytest.approx([shear - 1.5, shear + 0.5], abs=0.05)


def test_rotating_rayleigh_shaft_matches_exact_whirl():
    """Whirl ω of a pinned shaft turning at Ω, no shear: a quadratic in ω.

    (m + J k²) ω² - 2 J k² Ω ω - E I k⁴ = 0; the synchronous root is
    Ω² = E I k⁴ / (m - J k²). Source: Dimentberg, Flexural Vibrations of Rotating Shafts.
    """
    tube = Tube(outer=0.3, wall=0.01)  # stout, so that the gyroscopes show
    bend, mass, rotary = (
        tube.bending_stiffness,
        tube.mass_per_length,
        tube.polar_inertia_per_length / 2,
    )
    beams = beam_model(line(tube=tube))
    beams = replace(beams, shear_stiffness=np.full(1, np.inf))
    k, speed = np.pi / L, 2000.0
    middle, half = rotary * k**2 * speed, mass + rotary * k**2
    root = np.sqrt(middle**2 + half * bend * k**4)
    forward, backward = (root + middle) / half, (root - middle) / half
    assert forward / backward > 1.08
    found = campbell_diagram(beams, speeds=[speed], modes=2, elements=24).frequency[0]
    # 24 elements: the shapes are exact, so the error is the beam's own (π/24)⁴/1440.
    assert found == pytest.approx([backward, forward], rel=1e-6)
    critical = np.sqrt(bend * k**4 / (mass - rotary * k**2))
    speeds = synchronous_whirl_modes(beams, elements=24)
    assert speeds.frequency[speeds.forward_share > 0.5][0] == pytest.approx(critical, rel=1e-6)


@pytest.mark.parametrize("stiffness", [1e4, 3e5, 5e6, 1e8])
@pytest.mark.parametrize("yoke", [0.0, 12.0])
def test_two_hinged_shafts_on_spring_match_exact_solution(stiffness, yoke):
    """x³ (coth x - cot x) E I / L³ = k - M ω², with ω² = E I x⁴ / (m L⁴): symmetric whirl.

    Each shaft pinned at its outer end, its inner end free of moment; the spring and the
    yokes on it take half their force from each.
    """
    beams = slender(
        beam_model(line(shafts=2, stiffness=(stiffness, stiffness), yokes=(yoke / 2, yoke / 2)))
    )

    def unbalanced(x):
        force = x**3 * (1 / np.tanh(x) - 1 / np.tan(x)) * EI / L**3
        return force - stiffness + yoke * EI * x**4 / (m * L**4)

    x = brentq(unbalanced, 1e-3, np.pi * (1 - 1e-9))
    exact = x**2 / L**2 * np.sqrt(EI / m)
    assert lowest(beams, elements=16) == pytest.approx(exact, rel=2e-6)


@pytest.mark.parametrize("overhang", [0.05, 0.14, 0.4])
@pytest.mark.parametrize("tip", [0.0, 8.0])
def test_overhung_yoke_matches_exact_solution(overhang, tip):
    """A shaft pinned in front, on a rigid bearing, with a yoke on its overhung end.

    Behind it hangs a shaft without mass, which so far from its own support carries nothing.
    Solved by the two spans' deflections joined in slope and moment at the bearing.
    """
    beams = slender(beam_model(line(shafts=2, overhang=overhang, yokes=(0.0, tip))))
    beams = replace(beams, mass_per_length=np.array([m, 1e-9]))
    a, b = L - overhang, overhang

    def mismatch(beta):
        s, c, S, C = np.sin(beta * a), np.cos(beta * a), np.sinh(beta * a), np.cosh(beta * a)
        front = np.array([beta * (c - s / S * C), -(beta**2) * 2 * s])
        load = tip * beta / m  # the yoke's M ω² over the shaft's E I β³
        s, c, S, C = np.sin(beta * b), np.cos(beta * b), np.sinh(beta * b), np.cosh(beta * b)
        even, odd = c + C + load * (S - s), s + S
        mix = -even / odd
        slope = beta * (S - s + load * (C - c) + mix * (c + C))
        moment = beta**2 * (C - c + load * (S + s) + mix * (S - s))
        return front[0] * moment + front[1] * slope

    beta = brentq(mismatch, 0.3 / L, 1.0001 * np.pi / a)
    exact = beta**2 * np.sqrt(EI / m)
    assert lowest(beams, elements=16) == pytest.approx(exact, rel=5e-6)


@pytest.mark.parametrize("stiffness", [(2e5, 4e5), (3e6, 1e6), (np.inf, 2e6)])
def test_orthotropic_bearing_matches_exact_solution(stiffness):
    """Two stout Rayleigh shafts hinged on a bearing, gyroscopes and all, solved exactly.

    Forward and backward whirl are E I w'''' + j Ω² w'' - m Ω² w = 0 with j = -J and 3 J, and
    only the bearing couples them: with end stiffnesses F and B of a shaft,
    (2F + k)(2B + k) = d² where k ± d are the bearing's two stiffnesses.
    """
    tube = Tube(outer=0.25, wall=0.006)
    beams = beam_model(line(shafts=2, tube=tube, stiffness=stiffness))
    beams = replace(beams, shear_stiffness=np.full(2, np.inf))
    bend, mass, rotary = (
        tube.bending_stiffness,
        tube.mass_per_length,
        tube.polar_inertia_per_length / 2,
    )

    def end(omega, j):
        p2 = (j + np.sqrt(j**2 + 4 * bend * mass / omega**2)) * omega**2 / (2 * bend)
        q2 = p2 - j * omega**2 / bend
        p, q = np.sqrt(p2), np.sqrt(q2)
        A, B = 1 / np.sin(p * L) / p2, 1 / np.sinh(q * L) / q2  # no moment at the hinge
        w = A * np.sin(p * L) + B * np.sinh(q * L)
        slope = A * p * np.cos(p * L) + B * q * np.cosh(q * L)
        bent = -A * p**3 * np.cos(p * L) + B * q**3 * np.cosh(q * L)
        return -(bend * bent + j * omega**2 * slope) / w

    def unbalanced(omega):
        F, B = 2 * end(omega, -rotary), 2 * end(omega, 3 * rotary)
        k1, k2 = stiffness
        if np.isinf(k1):
            return (F + B) / 2 + k2
        k, d = (k1 + k2) / 2, (k1 - k2) / 2
        return (F + k) * (B + k) - d**2

    found = synchronous_whirl_modes(beams, elements=16, modes=2)
    for omega in found.frequency:
        at = np.array([unbalanced(omega * x) for x in (1 - 2e-6, 1 + 2e-6)])
        assert at[0] * at[1] < 0  # a root within the elements' own error


def test_stiff_line_bounces_as_rigid_links():
    """Two hung shafts and a third, far stiffer than their rubber: a 2 x 2 problem by hand.

    The links' ends move by the two bearings' heights; the kinetic energy of a uniform link
    is m L (u² + u v + v²)/6.
    """
    overhang, yokes, k = 0.2, (3.0, 5.0), np.array([4e5, 7e5])
    beams = beam_model(line(shafts=3, overhang=overhang, yokes=yokes))
    beams = slender(replace(beams, bearing_stiffness=np.stack([k, k], axis=-1)))
    beams = replace(beams, bending_stiffness=np.full(3, 1e6 * EI))
    up = L / (L - overhang)
    # Rows: joint heights 1..4 in terms of the heights of the two bearings.
    joint2 = np.array([up, 0.0])
    joint3 = joint2 + (np.array([0.0, 1.0]) - joint2) * up
    joints = [np.zeros(2), joint2, joint3, np.zeros(2)]
    M = np.zeros((2, 2))
    for u, v in pairwise(joints):
        link = np.outer(u, u) + np.outer(v, v) + (np.outer(u, v) + np.outer(v, u)) / 2
        M += m * L / 3 * link + yokes[0] * np.outer(u, u) + yokes[1] * np.outer(v, v)
    exact = np.sqrt(np.linalg.eigvals(np.linalg.solve(M, np.diag(k))).min())
    modes = synchronous_whirl_modes(beams)
    # Bending takes (bounce/bending)² ~ 1e-6 off; elements are exact for straight links.
    assert bearing_resonance_speed(modes) == pytest.approx(exact, rel=1e-5)


def test_heavy_spline_on_light_shaft_matches_closed_form():
    """A mass M at a from one end, b from the other: ω² = 3 E I L/(M a² b²), and with shear.

    1/k = a² b²/(3 E I L) + a b/(κ G A L). The mass sits on a node: static shapes are exact.
    """
    beams = beam_model(line())
    a, mass = L / 4, 30.0
    light = replace(
        beams,
        mass_per_length=np.full(1, 1e-6),
        rotary_inertia=np.zeros(1),
        spline_mass=np.array([mass]),
        spline_position=np.array([a]),
    )
    S = beams.shear_stiffness[0]
    b = L - a
    soft = a**2 * b**2 / (3 * EI * L) + a * b / (S * L)
    assert lowest(light) == pytest.approx(1 / np.sqrt(mass * soft), rel=1e-6)

"""Forced motion on rubber against EXUDYN, a 3-D multibody engine run to a steady state.

The engine has rigid shafts, crosses, a spline, springs and dampers, and nothing of this
program's equations (`rubber_engine.py`). Three lines bent in both views with phases of their
own, on one, two and three centre bearings.

At small torque the theory is linear in it: half the difference of drive and coast is free of
what the shafts' inertia does, and of what grows with the square of the torque. At a truck's
torque the geometry moves, and is itself shaken twice a turn.
"""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from case_selection import long
from rubber_engine import WHEEL, Rigid, Steady, Swinging, across
from test_rubber import BENT, PUBLISHED, TWO, laid

from cardan.model.bracket_compliance import reduce_to_bracket_compliance
from cardan.model.layout import Layout
from cardan.model.parts import CentreBearing, Flange, Line, Shaft, Spline, Tube
from cardan.physics.kinematics.joint_chain import rotate_chain
from cardan.physics.loads.centre_bearing import bearing_forces, joint_forces
from cardan.physics.loads.half_turn_fourier import semi_major_axis
from cardan.physics.loads.mounted_line_model import mounted_line
from cardan.physics.loads.rubber_mount import MountedLine
from cardan.physics.loads.statics import joint_loads

pytestmark = [
    pytest.mark.oracle,
    pytest.mark.filterwarnings("ignore"),  # the engine's own deprecations
]

rpm = np.pi / 30
LOSS = 0.1
UNTWISTED = 1e-9
"""m of tube that torque can twist: the engine's shafts do not, but where it is told to let them."""


def line(*shafts: tuple[float, float, float | None], drum: float | None = None) -> Line:
    """Lengths m, phases rad, bearings ahead of the rear joint m; kg m² of the first shaft."""
    return Line(
        shafts=tuple(
            Shaft(
                length=length,
                phase=phase,
                tube=Tube(outer=0.1, wall=0.004),
                tube_length=UNTWISTED,
                yoke_mass=(5.0, 6.0),
                polar_inertia_given=None if k else drum,
                centre_bearing=None if over is None else CentreBearing(from_rear_joint=over),
                spline=Spline(mass=6.0, from_front_joint=0.3) if over is None else None,
            )
            for k, (length, phase, over) in enumerate(shafts)
        )
    )


CROSSED = np.pi / 2
THREE = (1.2, 0.0, 0.14), (1.1, CROSSED, 0.16), (1.5, 0.3, None)
FOUR = (1.0, CROSSED, 0.14), (1.2, 0.0, 0.1), (0.9, CROSSED, 0.0), (1.4, -0.6, None)
WINDING = {"side": [3.0, 1.0, 4.0, 0.5, 3.0, 1.0], "top": [0.0, 1.5, -0.8, 1.2, -0.5, 1.0]}
NEARLY_STRAIGHT = {view: np.divide(slopes, 4) for view, slopes in WINDING.items()}

# A line, its slopes in deg, its bearings (vertical, lateral) in N/m.
LINES = {
    "one": (TWO, PUBLISHED, (200e3, 120e3)),
    "two": (line(*THREE), BENT, (200e3, 120e3)),
    "three": (line(*FOUR), WINDING, (220e3, 140e3)),
    # How a shaft's spin answers to its tilt is left out: of order I_a tan²β, so a heavy
    # brake drum shows its gyroscope alone where the line is nearly straight.
    "a drum": (line(*FOUR, drum=1.0), NEARLY_STRAIGHT, (220e3, 140e3)),
}


@cache
def of(name: str) -> tuple[Line, Layout, MountedLine]:
    of_line, slopes, stiffness = LINES[name]
    where = laid(of_line, **slopes)
    held = mounted_line(where, of_line, stiffness=(*stiffness, 0.0), loss=LOSS, sines=0)
    return of_line, where, held


def rigid(shaft: Shaft) -> Rigid:
    """A pipe, point masses on its axis, a thin disc: about their centre."""
    outer, inner = shaft.tube.outer / 2, shaft.tube.outer / 2 - shaft.tube.wall
    pipe = shaft.tube.material.density * np.pi * (outer**2 - inner**2) * shaft.length
    places = [(pipe, shaft.length / 2), (shaft.yoke_mass[0], 0), (shaft.yoke_mass[1], shaft.length)]
    if shaft.spline:
        places.append((shaft.spline.mass, shaft.spline.from_front_joint))
    mass, at = np.array(places).T
    centre = mass @ at / mass.sum()
    across = pipe * (3 * (outer**2 + inner**2) + shaft.length**2) / 12
    return Rigid(
        mass=mass.sum(),
        centre=centre,
        transverse=across + mass @ (at - centre) ** 2,
        polar=shaft.polar_inertia_given or pipe * (outer**2 + inner**2) / 2,
    )


def engine(name: str, torque: float, speed: float, *, steps: int, **held: Any) -> Steady:
    of_line, where, _ = of(name)
    bearings = [s.centre_bearing for s in of_line.shafts if s.centre_bearing]
    return Swinging(
        where.points, where.directions, of_line.phases, [rigid(s) for s in of_line.shafts],
        [b.from_rear_joint for b in bearings],
        stiffness=LINES[name][2], loss=LOSS, torque=torque, speed=speed,
        **held,
    ).run(steps=steps)  # fmt: skip


def odd(name: str, torque: float, speed: float, **held: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the part odd in torque of the engine's order 2: forces, and speeds."""
    # The trapezoidal rule errs by (2 pi / steps)² / (6 loss) at resonance: 2e-4.
    drive, coast = (engine(name, sign * torque, speed, steps=600, **held) for sign in (1, -1))
    return (drive.force - coast.force) / 2, (drive.velocity - coast.velocity) / 2


@pytest.mark.parametrize(
    ("name", "speed"),
    [
        ("one", 427.2), ("two", 448.6), ("three", 363.0), ("a drum", 363.0),
        *long(("one", 256.0), ("one", 773.0), ("two", 174.0), ("two", 628.0),
              ("three", 218.0), ("three", 704.0)),
    ],
)  # fmt: skip
def test_force_odd_in_torque_matches_exudyn(name, speed):
    """Force, both ways and with its phase, below, at and above resonance; and its power."""
    of_line, where, held = of(name)
    torque, speed = 200.0, speed * rpm
    force, velocity = odd(name, torque, speed)
    turned = rotate_chain(where.directions, phases=of_line.phases, samples=16)
    push = held.forces_from_joint_moments(
        joint_loads(where, turned, of_line, torque=torque).joint_moments.order(2)
    )
    found = held.response(push, frequency=2 * speed, speed=speed)
    apart = np.linalg.norm(force - found.bearing_forces, axis=-1)
    assert (apart < 1e-3 * np.linalg.norm(force, axis=-1)).all()
    # What the moments feed in is what the engine's dampers take out of it.
    fed = speed * np.imag(np.conj(found.coordinates) @ push)
    lost = np.real(force * np.conj(velocity)).sum() / 2
    assert fed == pytest.approx(lost, rel=2e-3)


@pytest.mark.parametrize(
    ("name", "speed"), [("two", 428.0), *long(("one", 390.0), ("one", 1010.0))]
)
def test_bearing_in_elastic_bracket_matches_exudyn(name, speed):
    """A mass on springs, in series with the rubber: at the line's resonance and at its own."""
    of_line, where, held = of(name)
    torque, speed = 200.0, speed * rpm
    mass, stiffness, loss = 15.0, np.array([3e6, 0.7e6, 1.1e6]), 0.06
    force, _ = odd(name, torque, speed, bracket=(mass, stiffness, loss))
    turned = rotate_chain(where.directions, phases=of_line.phases, samples=16)
    couple = joint_loads(where, turned, of_line, torque=torque).joint_moments.order(2)
    give = reduce_to_bracket_compliance(
        np.diag(1 / stiffness), frequencies=np.sqrt(stiffness / mass),
        motion=np.eye(3) / np.sqrt(mass), inertia=np.diag(mass / stiffness**2), loss=loss,
    )  # fmt: skip
    hung = held.with_bracket(0, give)
    found = hung.response(hung.forces_from_joint_moments(couple), frequency=2 * speed, speed=speed)
    apart = np.linalg.norm(force - found.bearing_forces, axis=-1)
    assert (apart < 1e-3 * np.linalg.norm(force, axis=-1)).all()
    rigid_ = held.response(
        held.forces_from_joint_moments(couple), frequency=2 * speed, speed=speed
    ).bearing_forces
    assert np.abs(rigid_ - found.bearing_forces)[0].max() > 0.1 * np.abs(found.bearing_forces).max()


TAIL = Flange(stiffness=(0.9e6, 0.5e6), loss_factor=0.06, mass=18.0)
AXLE = Flange(stiffness=(1.2e6, 2.0e6), loss_factor=0.04, mass=40.0)


@pytest.mark.parametrize(
    ("name", "speed"), [("two", 980.0), *long(("one", 420.0), ("one", 1150.0), ("two", 428.0))]
)
def test_elastic_gearbox_tail_and_axle_match_exudyn(name, speed):
    """Masses on springs under the flanges, near the line's resonance and near their own.

    Forces on bearings, and those in the springs of the flanges less what their masses take.
    """
    of_line, where, _ = of(name)
    soft = replace(of_line, gearbox_flange=TAIL, pinion_flange=AXLE)
    stiffness, torque, speed = (*LINES[name][2], 0.0), 200.0, speed * rpm
    own = {"tail": (TAIL.mass, TAIL.stiffness, TAIL.loss_factor),
           "axle": (AXLE.mass - WHEEL, AXLE.stiffness, AXLE.loss_factor)}  # fmt: skip
    force, velocity = odd(name, torque, speed, **own)
    held, cut = (
        mounted_line(where, soft, stiffness=stiffness, loss=LOSS, sines=0, cut=c)
        for c in (False, True)
    )
    couple = joint_loads(
        where,
        rotate_chain(where.directions, phases=of_line.phases, samples=16),
        of_line,
        torque=torque,
    ).joint_moments.order(2)
    found = held.response(held.forces_from_joint_moments(couple), frequency=2 * speed, speed=speed)
    hung = len(of_line.shafts) - 1
    apart = np.linalg.norm(force[:hung] - found.bearing_forces, axis=-1)
    assert (apart < 1e-3 * np.linalg.norm(force[:hung], axis=-1)).all()
    # What a joint hands its flange: the spring's force, and what shakes the mass on it.
    at, small = (
        joint_forces(where, soft, soft.phases, torque=t, speed=speed, held=held, cut=cut).waves[
            :, 0
        ]
        for t in (torque, -torque)
    )
    ours = (at - small)[[0, -1]] / 2 * [[-1], [1]]
    taken = 2j * speed * np.array([[TAIL.mass], [AXLE.mass]]) * velocity[hung:]
    theirs = force[hung:] + taken
    across_ = [np.stack(across(d)) for d in where.directions[[0, -1]]]
    ours = np.stack([a.T @ (a @ v) for a, v in zip(across_, ours, strict=True)])
    # Above a mode of the axle the two nearly cancel.
    both = np.linalg.norm(force[hung:]) + np.linalg.norm(taken)
    assert np.linalg.norm(ours - theirs) < 1e-3 * both
    rigid_ = (
        of(name)[2]
        .response(of(name)[2].forces_from_joint_moments(couple), frequency=2 * speed, speed=speed)
        .bearing_forces
    )
    assert np.abs(rigid_ - found.bearing_forces).max() > 0.02 * np.abs(found.bearing_forces).max()


@pytest.mark.parametrize(
    ("name", "torque", "speed"),
    [
        ("one", 10e3, 551.9), ("two", 5e3, 448.6), ("two", 5e3, 720.0), ("three", 5e3, 363.0),
        *long(("one", 10e3, 256.0), ("one", 10e3, 773.0), ("two", 3e3, 174.0),
              ("two", 3e3, 448.6), ("two", 5e3, 290.1), ("three", 5e3, 218.0),
              ("three", 5e3, 704.0), ("two", 5e3, 174.0), ("three", 5e3, 502.7)),
    ],
)  # fmt: skip
def test_force_at_truck_torque_matches_exudyn(name, torque, speed):
    """Set down by the mean force, stiffened by the torque; within 2 % of the engine's."""
    of_line, where, held = of(name)
    speed = speed * rpm
    found = bearing_forces(
        where, of_line, of_line.phases, torque=torque, speed=speed, held=held,
        inertias=np.array([s.polar_inertia for s in of_line.shafts]),
    )  # fmt: skip
    expected = semi_major_axis(engine(name, torque, speed, steps=400).force)
    assert found.order_amplitudes[..., 0] == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize(("torque", "speed"), [(-4e3, 363.0), *long((5e3, 218.0), (5e3, 502.7))])
def test_shaft_twist_by_torque_matches_exudyn(torque, speed):
    """Shafts on torsion springs, 4 L / G J by hand: 5 deg from yoke to yoke, 18 % of force.

    Four times as soft as their tubes, as thin ones are; within 0.6 % of the engine's.
    """
    stiff, where, held = of("three")
    soft = replace(stiff, shafts=tuple(replace(s, tube_length=4 * s.length) for s in stiff.shafts))
    rigidity = 206e9 / 2.6 * np.pi / 32 * (0.1**4 - 0.092**4)
    springs = [rigidity / (4 * s.length) for s in stiff.shafts]
    expected = semi_major_axis(
        engine("three", torque, speed * rpm, steps=400, torsion=springs).force
    )
    untwisted, found = (
        bearing_forces(
            where, line, line.phases, torque=torque, speed=speed * rpm, held=held,
            inertias=np.array([s.polar_inertia for s in stiff.shafts]),
        ).order_amplitudes[..., 0]
        for line in (stiff, soft)
    )  # fmt: skip
    assert found == pytest.approx(expected, rel=0.006)
    assert np.abs(untwisted / expected - 1).max() > 0.05

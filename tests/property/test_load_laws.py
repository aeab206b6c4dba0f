"""Laws of the loads round a turn, for any line."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cardan.model.layout import Layout, layout_from_slopes
from cardan.model.parts import CentreBearing, Line, Shaft, Spline, Tube
from cardan.physics.kinematics.joint_chain import rotate_chain
from cardan.physics.loads.small_angle import small_angle_bearing_forces
from cardan.physics.loads.statics import JointLoads, joint_loads

slopes = st.floats(-0.15, 0.15)
SAMPLES = 16
GRAVITY = 9.81


@st.composite
def lines(draw: st.DrawFn) -> tuple[Layout, Line]:
    """Two to five joints, 3-D, any phases, bearings ahead of their joints, either freedom."""
    n = draw(st.integers(2, 5))
    side, top = (draw(st.lists(slopes, min_size=n + 1, max_size=n + 1)) for _ in range(2))
    lengths = draw(st.lists(st.floats(0.5, 2.5), min_size=n - 1, max_size=n - 1))
    shafts = tuple(
        Shaft(
            length=length,
            phase=draw(st.floats(-np.pi, np.pi)),
            centre_bearing=CentreBearing(from_rear_joint=draw(st.floats(0, 0.3)))
            if k < n - 2
            else None,
            tube=Tube(outer=0.09, wall=0.003),
            yoke_mass=(draw(st.floats(0, 9)), draw(st.floats(0, 9))),
            spline=Spline(mass=draw(st.floats(0, 9)), from_front_joint=0.2),
        )
        for k, length in enumerate(lengths)
    )
    line = Line(
        shafts=shafts, axial_freedom=draw(st.sampled_from(["last_shaft", "gearbox_flange"]))
    )
    return layout_from_slopes(side=side, top=top, lengths=lengths), line


def carried(layout: Layout, line: Line, torque: float = 1000.0, **more: object) -> JointLoads:
    spin = rotate_chain(layout.directions, phases=line.phases, samples=SAMPLES)
    return joint_loads(layout, spin, line, torque=torque, **more)  # type: ignore[arg-type]


def scale(found: JointLoads) -> float:
    """Return the largest force about: what rounding errors are measured against."""
    return 1e-300 + np.abs(found.joint_forces.waves).max()


@settings(max_examples=60)
@given(case=lines())
def test_forces_and_moments_on_every_shaft_balance(case: tuple[Layout, Line]):
    layout, line = case
    found = carried(layout, line, gravity=GRAVITY, thrust=350.0)
    force, moment = found.joint_forces.values(SAMPLES), found.joint_moments.values(SAMPLES)
    bearing, d = found.bearing_forces.values(SAMPLES), layout.directions
    for k, shaft in enumerate(line.shafts):
        length, axis = layout.lengths[k], d[k + 1]
        assert shaft.tube
        assert shaft.spline
        down = np.array([0, 0, -GRAVITY])
        forces = [
            (0.0, force[k]),
            (length, -force[k + 1]),
            (0.0, shaft.yoke_mass[0] * down),
            (length, shaft.yoke_mass[1] * down),
            (length / 2, shaft.tube.mass_per_length * shaft.length * down),
            (shaft.spline.from_front_joint, shaft.spline.mass * down),
        ]
        if shaft.centre_bearing:
            forces.append((length - shaft.centre_bearing.from_rear_joint, -bearing[k]))
        total = sum(f for _, f in forces)
        about = sum(np.cross(x * axis, f) for x, f in forces) + moment[k] - moment[k + 1]
        assert np.abs(total).max() < 1e-10 * scale(found)
        assert np.abs(about).max() < 1e-10 * (1000.0 + scale(found))


@settings(max_examples=40)
@given(case=lines())
def test_bearings_and_spline_carry_only_admissible_forces(case: tuple[Layout, Line]):
    layout, line = case
    found = carried(layout, line, thrust=350.0)
    d = layout.directions
    along = np.einsum("k...i,ki->k...", found.bearing_forces.values(SAMPLES), d[1:-2])
    assert np.abs(along).max(initial=0.0) < 1e-10 * scale(found)
    sliding = {"last_shaft": (-2, d[-2]), "gearbox_flange": (0, d[0])}[line.axial_freedom]
    joint, axis = sliding
    pulled = found.joint_forces.values(SAMPLES)[joint] @ axis
    assert pulled == pytest.approx(np.full(SAMPLES, -350.0), rel=1e-9, abs=1e-10 * scale(found))


@settings(max_examples=40)
@given(case=lines())
def test_joint_moments_are_admissible_for_cross(case: tuple[Layout, Line]):
    """M = T [d - a (a . d)] / (d' . d) at every angle, with the pins the turn itself gives."""
    layout, line = case
    spin = rotate_chain(layout.directions, phases=line.phases, samples=SAMPLES)
    moments = joint_loads(layout, spin, line, torque=1000.0).joint_moments.values(SAMPLES)
    a, (u, v) = spin.driving_pins, (layout.directions[:-1], layout.directions[1:])
    torque = 1000.0 / np.concatenate([np.ones((1, SAMPLES)), spin.speed[:-1]])
    expected = v[:, None] - a * np.einsum("kni,ki->kn", a, v)[..., None]
    expected *= (torque / np.einsum("ki,ki->k", u, v)[:, None])[..., None]
    assert moments == pytest.approx(expected, rel=0, abs=1e-10 * 1000)


@settings(max_examples=40)
@given(case=lines())
def test_input_power_equals_output_power(case: tuple[Layout, Line]):
    layout, line = case
    spin = rotate_chain(layout.directions, phases=line.phases, samples=SAMPLES)
    found = joint_loads(layout, spin, line, torque=1000.0)
    power = found.torques.values(SAMPLES)[1:, :, 0] * spin.speed
    assert power == pytest.approx(np.full_like(power, 1000.0), rel=1e-12)
    # The cross's moment has the torque that arrives along the member behind it.
    arriving = np.einsum("kni,ki->kn", found.joint_moments.values(SAMPLES), layout.directions[1:])
    assert arriving == pytest.approx(found.torques.values(SAMPLES)[1:, :, 0], rel=1e-11)


@settings(max_examples=40)
@given(case=lines(), speed=st.floats(0, 400), inertia=st.floats(0, 0.5))
def test_power_difference_equals_rate_of_kinetic_energy(
    case: tuple[Layout, Line], speed: float, inertia: float
):
    """Over a turn nothing is lost; within it the kinetic energy's rate is what is missing."""
    layout, line = case
    spin = rotate_chain(layout.directions, phases=line.phases)
    found = joint_loads(
        layout,
        spin,
        line,
        torque=1000.0,
        inertias=[inertia] * len(line.shafts),
        accelerations=speed**2 * spin.acceleration,
    )
    out = found.torques.values()[-1, :, 0] * spin.speed[-1] * speed
    energy = inertia / 2 * ((speed * spin.speed[:-1]) ** 2).sum(axis=0)
    order = np.arange(len(spin.theta) // 2 + 1)
    rate = speed * np.fft.irfft(1j * order * np.fft.rfft(energy))
    whole = 1000.0 * speed + np.abs(rate).max()
    assert out + rate == pytest.approx(np.full_like(out, 1000.0 * speed), abs=1e-9 * whole)


@settings(max_examples=40)
@given(case=lines())
def test_mirrored_vehicle_has_mirrored_loads(case: tuple[Layout, Line]):
    """Mirrored left to right phases change sign, and the torque turns the other way."""
    layout, line = case
    mirror = np.array([1.0, -1.0, 1.0])
    mirrored = Layout(points=layout.points * mirror, directions=layout.directions * mirror)
    shafts = tuple(replace(s, phase=-s.phase) for s in line.shafts)
    there = carried(mirrored, replace(line, shafts=shafts), torque=-1000.0, gravity=GRAVITY)
    here = carried(layout, line, gravity=GRAVITY)
    room = 1e-10 * scale(here)
    for found, image in (
        (here.bearing_forces, there.bearing_forces),
        (here.joint_forces, there.joint_forces),
    ):
        assert image.static == pytest.approx(found.static * mirror, rel=0, abs=room)
        # The gearbox turns the other way too: θ is -θ there, and an amplitude its conjugate.
        assert image.order(2) == pytest.approx(found.order(2).conj() * mirror, rel=0, abs=room)


@settings(max_examples=40)
@given(case=lines(), factor=st.floats(-3, 3))
def test_loads_scale_with_torque(case: tuple[Layout, Line], factor: float):
    once, more = carried(*case), carried(*case, torque=1000.0 * factor)
    for name in ("joint_forces", "joint_moments", "bearing_forces", "torques"):
        expected = factor * getattr(once, name).waves
        assert getattr(more, name).waves == pytest.approx(expected, rel=1e-12, abs=1e-12)


@settings(max_examples=30)
@given(case=lines(), side=slopes, top=slopes)
def test_straight_line_carries_no_force(case: tuple[Layout, Line], side: float, top: float):
    _, line = case
    n = line.joint_count
    layout = layout_from_slopes(side=[side] * (n + 1), top=[top] * (n + 1), lengths=line.lengths)
    found = carried(layout, line)
    # Rounding of a moment of 1000 N m over the shortest shaft, and its lever.
    assert np.abs(found.joint_forces.waves).max() < 1e-10
    assert np.abs(found.bearing_forces.waves).max(initial=0.0) < 1e-10


@settings(max_examples=30)
@given(case=lines(), angle=st.floats(-1, 1))
def test_rotated_vehicle_has_rotated_loads(case: tuple[Layout, Line], angle: float):
    """About the vertical, so that the gearbox pin starts level again."""
    layout, line = case
    c, s = np.cos(angle), np.sin(angle)
    turned = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    moved = Layout(points=layout.points @ turned.T, directions=layout.directions @ turned.T)
    here, there = (carried(x, line, gravity=GRAVITY).joint_forces.waves for x in (layout, moved))
    assert there == pytest.approx(here @ turned.T, rel=0, abs=1e-10 * np.abs(here).max())


@settings(max_examples=30)
@given(case=lines())
def test_peak_is_above_samples_and_below_sum_of_orders(case: tuple[Layout, Line]):
    force = carried(*case, gravity=GRAVITY).joint_forces
    sampled = np.linalg.norm(force.values(720), axis=-1).max(axis=-1)
    bound = np.linalg.norm(force.static, axis=-1) + force.dynamic
    assert np.all(force.peak >= sampled * (1 - 1e-12))
    # Half a degree from the crest |F|² is less by order 4 at most: (4 π/720)²/2 of it.
    assert np.all(force.peak <= sampled * (1 + 2e-4) + 1e-9)
    assert np.all(force.peak <= bound * (1 + 1e-12))


@settings(max_examples=40)
@given(case=lines(), torque=st.floats(-20e3, 20e3))
def test_loads_are_linear_in_signed_torque(case: tuple[Layout, Line], torque: float):
    """A line that holds back pulls its bearings the other way, and as hard."""
    layout, line = case
    one, found = carried(layout, line, torque=1.0), carried(layout, line, torque=torque)
    for name in ("joint_forces", "joint_moments", "bearing_forces", "torques"):
        unit, waves = getattr(one, name).waves, getattr(found, name).waves
        # Below the smallest normal number nothing is proportional.
        rounding = 1e-13 * abs(torque) * (1 + np.abs(unit).max(initial=0.0)) + 1e-290
        np.testing.assert_allclose(waves, torque * unit, rtol=1e-13, atol=rounding)
    near, far = (small_angle_bearing_forces(layout, line, torque=t).waves for t in (1.0, torque))
    rounding = 1e-13 * abs(torque) * np.abs(near).max(initial=0.0) + 1e-290
    np.testing.assert_allclose(far, torque * near, rtol=1e-13, atol=rounding)

"""Loads of a line: cycles, weight, thrust, inertia, unbalance, end bearings."""

from dataclasses import replace
from functools import partial

import array_api_strict as strict
import numpy as np
import pytest

from cardan.core.arrays import FloatArray, array_namespace, in_chunks
from cardan.model.layout import Layout, layout_from_slopes
from cardan.model.parts import CentreBearing, Line, Shaft, Tube
from cardan.physics.kinematics.joint_chain import rotate_chain
from cardan.physics.loads.flange_reactions import flange_bearing_forces
from cardan.physics.loads.half_turn_fourier import HalfTurnSeries
from cardan.physics.loads.statics import (
    JointLoads,
    joint_loads,
    spline_slip_force,
    unbalance_forces,
)

TUBE = Tube(outer=0.1016, wall=0.0032)
LINE = Line(
    shafts=(
        Shaft(
            length=1.2,
            tube=TUBE,
            yoke_mass=(6.0, 8.0),
            centre_bearing=CentreBearing(from_rear_joint=0.14),
            balance_grade=16.0,
        ),
        Shaft(length=1.5, tube=TUBE, yoke_mass=(7.0, 5.0), balance_grade=40.0),
    )
)
LAYOUT = layout_from_slopes(
    side=np.radians([3, 1, 4.5, 2]), top=np.radians([0, 1.5, -0.8, 0.6]), lengths=LINE.lengths
)
LEVEL = layout_from_slopes(side=np.zeros(4), top=np.zeros(4), lengths=LINE.lengths)
DOWN = np.array([0, 0, -1.0])


def carried(layout: Layout = LAYOUT, line: Line = LINE, **given: object) -> JointLoads:
    spin = rotate_chain(layout.directions, phases=line.phases)
    return joint_loads(layout, spin, line, **{"torque": 0.0, **given})  # type: ignore[arg-type]


def size(vector: FloatArray) -> FloatArray:
    return np.linalg.norm(vector, axis=-1)


def test_load_cycle_is_mean_plus_orders():
    theta = 2 * np.pi * np.arange(24) / 24
    wave = np.stack([3 + 2 * np.cos(2 * theta - 0.4), 0 * theta, np.sin(4 * theta)], axis=-1)
    cycle = HalfTurnSeries.from_samples(wave)
    assert cycle.values(24) == pytest.approx(wave, abs=1e-14)
    assert cycle.static == pytest.approx([3, 0, 0], abs=1e-14)
    assert cycle.order(2) == pytest.approx([2 * np.exp(-0.4j), 0, 0], abs=1e-14)
    assert cycle.order(4) == pytest.approx([0, 0, -1j], abs=1e-14)
    assert cycle.order(1) == pytest.approx([0, 0, 0])
    assert cycle.order(40) == pytest.approx([0, 0, 0])


@pytest.mark.parametrize("phase", [0.0, 0.7, 2.0])
def test_dynamic_amplitude_is_major_half_axis_of_ellipse(phase: float):
    """An ellipse of half axes 5 and 2, anywhere round the turn."""
    ellipse = np.array([0, 5, 2j]) * np.exp(1j * phase)
    cycle = HalfTurnSeries(np.stack([np.array([9, 9, 9]), ellipse]))
    assert cycle.dynamic == pytest.approx(5.0, rel=1e-15)


def test_peak_between_samples_is_found():
    """Along one axis the peak is mean plus amplitude, wherever in the turn it falls."""
    phases = np.linspace(0, 6, 50)
    waves = np.zeros((50, 2, 3), complex)
    waves[:, 0, 1], waves[:, 1, 1] = -2.0, 3.0 * np.exp(1j * phases)
    assert HalfTurnSeries(waves).peak == pytest.approx(np.full(50, 5.0), rel=1e-14)


def test_peak_is_higher_of_two_crests():
    """An ellipse 5 by 2, moved by 1 and 1e-3: one of its two crests is 4e-4 higher.

    The best of the samples can stand on the lower one, depending on where the turn starts.
    """
    start = np.linspace(0, np.pi, 40)[:, None]
    ellipse = np.array([5, 2j, 0]) * np.exp(1j * start)
    middle = np.broadcast_to(np.array([1e-3, 1, 0]), ellipse.shape)
    cycle = HalfTurnSeries(np.stack([middle, ellipse], axis=-2))
    phi = np.linspace(0, 2 * np.pi, 40000)
    highest = np.hypot(1e-3 + 5 * np.cos(phi), 1 - 2 * np.sin(phi)).max()
    # Steps of 1.6e-4 rad miss a crest by half a step at most: (0.8e-4)²/2 of it, and less.
    assert cycle.peak == pytest.approx(np.full(40, highest), rel=1e-8)


def test_peak_of_constant_load_is_its_magnitude():
    assert HalfTurnSeries(np.array([[3.0, 0, -4], [0, 0, 0]], complex)).peak == pytest.approx(5.0)
    assert HalfTurnSeries(np.zeros((2, 3), complex)).peak == 0.0


def test_torque_behind_joint_varies_between_cosine_and_its_inverse():
    """One joint of angle β: what arrives is T cos β to T / cos β, mean T (1 + r²)/(1 - r²)."""
    beta = np.radians(20)
    layout = layout_from_slopes(side=[0, beta, beta], top=[0, 0, 0], lengths=[1.0])
    found = carried(layout, Line(shafts=(Shaft(length=1.0),)), torque=100.0).torques
    r = np.tan(beta / 2) ** 2
    assert found.peak[1] == pytest.approx(100 / np.cos(beta), rel=1e-14)
    assert found.values(64)[1].min() == pytest.approx(100 * np.cos(beta), rel=1e-14)
    assert found.static[1, 0] == pytest.approx(100 * (1 + r**2) / (1 - r**2), rel=1e-14)


def test_weight_is_carried_by_joints_and_bearings():
    """Level line: the hung shaft is a beam on joint 1 and bearing, joint 2 at its overhang."""
    found = carried(LEVEL, gravity=9.81)
    first, second = (9.81 * TUBE.mass_per_length * x for x in (1.2, 1.5))
    last = 7.0 * 9.81 + second / 2  # what the second shaft's front end hangs on joint 2
    bearing = (first * 0.6 + (8.0 * 9.81 + last) * 1.2) / (1.2 - 0.14)
    assert found.bearing_forces.static == pytest.approx(bearing * DOWN[None], rel=1e-13)
    assert found.joint_forces.static[1] == pytest.approx(-last * DOWN, rel=1e-13)
    assert found.pinion_force.static == pytest.approx((5.0 * 9.81 + second / 2) * DOWN, rel=1e-13)
    weight = 9.81 * sum(s.mass for s in LINE.shafts)
    parts = found.gearbox_force.static + found.pinion_force.static + bearing * DOWN
    assert parts == pytest.approx(weight * DOWN, rel=1e-13)
    assert found.joint_forces.amplitude(2) == pytest.approx(0.0)


def test_thrust_is_transmitted_forward_through_joints():
    """A level line just passes it on; the bearings feel nothing of it."""
    for freedom in ("last_shaft", "gearbox_flange"):
        found = carried(LEVEL, replace(LINE, axial_freedom=freedom), thrust=500.0)
        assert found.joint_forces.static == pytest.approx(np.tile([-500.0, 0, 0], (3, 1)))
        assert found.bearing_forces.static == pytest.approx(np.zeros((1, 3)))


def test_load_contributions_are_additive():
    spin = rotate_chain(LAYOUT.directions, phases=LINE.phases)
    inertia = {"inertias": [0.03, 0.04], "accelerations": 200.0**2 * spin.acceleration}
    every = carried(torque=800.0, gravity=9.81, thrust=120.0, **inertia).bearing_forces
    parts = [
        carried(torque=800.0, **inertia),
        carried(gravity=9.81),
        carried(thrust=120.0),
    ]
    total = sum(p.bearing_forces.values(64) for p in parts)
    assert every.values(64) == pytest.approx(total, rel=1e-12, abs=1e-10)


def test_orders_above_2_vanish_without_inertia():
    """A turn sampled with all its orders finds nothing in the others."""
    spin = rotate_chain(LAYOUT.directions, phases=LINE.phases)
    full = carried(
        torque=1000.0, inertias=[0.0, 0.0], accelerations=1e6 * spin.acceleration
    ).bearing_forces
    assert full.waves.shape[-2] > 2
    lean = carried(torque=1000.0).bearing_forces
    assert full.waves[:, :2] == pytest.approx(lean.waves, abs=1e-11)
    assert np.abs(full.waves[:, 2:]).max() < 1e-11


def test_shaft_inertia_gives_order_2_torque():
    """J α of the first shaft, α = ω² sin²β sin 2θ to first order, arrives everywhere behind it.

    With all but joint 1 straight: what is left out is of order β² of it.
    """
    beta, inertia, speed = np.radians(2.0), 0.05, 300.0
    layout = layout_from_slopes(side=[0, beta, beta, beta], top=np.zeros(4), lengths=LINE.lengths)
    spin = rotate_chain(layout.directions, phases=LINE.phases)
    found = carried(
        layout, inertias=[inertia, 0.0], accelerations=speed**2 * spin.acceleration
    ).torques
    assert found.amplitude(2)[0] == pytest.approx(0.0, abs=1e-12)
    expected = inertia * speed**2 * np.sin(beta) ** 2
    assert found.amplitude(2)[1:] == pytest.approx(np.full(3, expected), rel=2 * beta**2)


def test_inertia_torque_has_closed_form_for_uniform_input():
    """Against 256 angles of a turn: waves of Poisson's kernel, to rounding, at 12 degrees.

    There order 6 of the moments is a ten-thousandth of order 2, and counts.
    """
    layout = layout_from_slopes(
        side=np.radians([3, -9, 4, 12]), top=np.radians([0, 5, -7, 1]), lengths=LINE.lengths
    )
    spin = rotate_chain(layout.directions, phases=[0.4, -0.2], samples=256)
    given = {"torque": 800.0, "gravity": 9.81, "thrust": 50.0, "inertias": [0.3, 0.4]}
    for speed in (300.0, -300.0):
        found = joint_loads(layout, spin, LINE, speed=speed, highest=6, **given)
        right = joint_loads(layout, spin, LINE, accelerations=speed**2 * spin.acceleration, **given)
        for name in ("torques", "joint_moments", "joint_forces", "bearing_forces"):
            ours, theirs = (getattr(of, name).waves for of in (found, right))
            assert ours.shape[-2] == 4
            np.testing.assert_allclose(
                ours, theirs[..., :4, :], rtol=1e-9, atol=1e-13 * np.abs(theirs).max()
            )
    assert np.abs(found.joint_moments.order(6)).max() > 1e-6 * abs(found.joint_moments.waves).max()


def test_batched_cases_equal_single_cases():
    rng = np.random.default_rng(5)
    many = layout_from_slopes(
        side=rng.uniform(-0.1, 0.1, (2, 3, 4)),
        top=rng.uniform(-0.1, 0.1, (2, 3, 4)),
        lengths=rng.uniform(0.9, 1.6, (2, 3, 2)),
    )
    torque, thrust = rng.uniform(100, 900, (2, 3)), rng.uniform(-90, 90, 3)
    line = replace(LINE, axial_freedom="gearbox_flange")
    spin = rotate_chain(many.directions, phases=line.phases)
    inertia = {"inertias": np.array([0.03, 0.05]), "accelerations": 4e4 * spin.acceleration}
    found = carried(many, line, torque=torque, thrust=thrust, gravity=9.81, **inertia)
    for i in np.ndindex(2, 3):
        inertia["accelerations"] = 4e4 * spin.acceleration[i]
        one = carried(many[i], line, torque=torque[i], thrust=thrust[i[1]], gravity=9.81, **inertia)
        for name in ("joint_forces", "joint_moments", "bearing_forces", "torques"):
            here, there = getattr(found, name), getattr(one, name)
            assert here.waves[i] == pytest.approx(there.waves, rel=1e-12, abs=1e-12)
            assert here.peak[i] == pytest.approx(there.peak, rel=1e-12)


def test_one_layout_is_evaluated_for_many_torques():
    torque = np.array([100.0, -300.0])
    found = carried(torque=torque).bearing_forces
    assert found.static.shape == (2, 1, 3)
    assert found.static[1] == pytest.approx(-3 * found.static[0])


def test_chunked_sweep_equals_whole_sweep():
    rng = np.random.default_rng(6)
    side, top = rng.uniform(-0.1, 0.1, (2, 50, 4))

    def sweep(side: FloatArray, top: FloatArray, *, line: Line) -> JointLoads:
        return carried(
            layout_from_slopes(side=side, top=top, lengths=line.lengths), line, torque=1000.0
        )

    whole = sweep(side, top, line=LINE)
    parts = in_chunks(partial(sweep, line=LINE), side, top, size=16)
    assert parts.bearing_forces.peak == pytest.approx(whole.bearing_forces.peak, rel=1e-13)


def test_slip_force_is_friction_times_torque_over_radius():
    """3000 N m on a greased spline of 30 mm mean radius: 0.11 * 3000 / 0.03 = 11 kN."""
    assert spline_slip_force(3000.0, friction=0.11, mean_radius=0.03) == pytest.approx(11e3)
    assert spline_slip_force(-3000.0, friction=0.11, mean_radius=0.03) == pytest.approx(11e3)


def test_unbalance_of_one_shaft_loads_its_two_joints():
    """20 kg, G 16, 150 rad/s: half of 20 kg * 16 mm/s * 150 rad/s = 24 N at each end."""
    shaft = Shaft(length=1.4, yoke_mass=(10.0, 10.0))
    layout = layout_from_slopes(side=[0, 0.05, 0], top=[0.1, 0, 0], lengths=[1.4])
    found = unbalance_forces(layout, Line(shafts=(shaft,)), speed=150.0)
    assert found.joint_forces == pytest.approx([24.0, 24.0], rel=1e-12)
    assert found.bearing_forces.shape == (0,)


def test_unbalance_of_two_shafts_adds_at_bearing_on_joint():
    """Bearing at joint 2: the rear end of shaft 1 and the front end of shaft 2 meet there."""
    first = replace(LINE.shafts[0], centre_bearing=CentreBearing())
    line = replace(LINE, shafts=(first, LINE.shafts[1]))
    found = unbalance_forces(LEVEL, line, speed=200.0)
    ends = [s.mass / 2 * g * 1e-3 * 200.0 for s, g in zip(line.shafts, (16, 40), strict=True)]
    assert found.bearing_forces == pytest.approx([sum(ends)], rel=1e-12)
    assert found.joint_forces == pytest.approx([ends[0], ends[1], ends[1]], rel=1e-12)


def test_unbalance_force_is_worst_over_all_phase_combinations():
    """Bearing ahead of its joint: joint 1 is relieved by what hangs on the overhang.

    Its lever is -0.14/1.06 there, so the worst is one heavy spot against the others.
    """
    found = unbalance_forces(LEVEL, LINE, speed=200.0)
    ends = [s.mass / 2 * g * 1e-3 * 200.0 for s, g in zip(LINE.shafts, (16, 40), strict=True)]
    lever = 0.14 / 1.06
    assert found.joint_forces[0] == pytest.approx(ends[0] + lever * sum(ends), rel=1e-12)
    assert found.bearing_forces == pytest.approx([(1 + lever) * sum(ends)], rel=1e-12)


def test_unbalance_grows_with_the_square_of_speed():
    """The grade holds at the service speed; a shaft run at half of it feels a quarter."""
    speeds = np.array([100.0, 200.0])
    found = unbalance_forces(LAYOUT, LINE, speed=speeds, balanced_at=200.0).bearing_forces
    assert found[0] == pytest.approx(found[1] / 4, rel=1e-12)
    assert found[1] == pytest.approx(unbalance_forces(LAYOUT, LINE, speed=200.0).bearing_forces)


def test_unbalance_grade_defaults_to_g16():
    plain = replace(LINE, shafts=tuple(replace(s, balance_grade=None) for s in LINE.shafts))
    sixteen = replace(LINE, shafts=tuple(replace(s, balance_grade=16.0) for s in LINE.shafts))
    default, named = (
        unbalance_forces(LAYOUT, x, speed=200.0).bearing_forces for x in (plain, sixteen)
    )
    assert default == pytest.approx(named, rel=1e-15)
    coarse = unbalance_forces(LAYOUT, plain, speed=200.0, grade=40.0).bearing_forces
    assert coarse == pytest.approx(2.5 * named, rel=1e-12)


def test_end_bearing_pair_balances_force_and_moment():
    found = carried(torque=1000.0, gravity=9.81)
    axis, spacing, overhang = LAYOUT.directions[0], 0.3, 0.12
    far, near = flange_bearing_forces(
        found.gearbox_force,
        found.gearbox_moment,
        outward=axis,
        spacing=spacing,
        overhang=overhang,
    )
    force, moment = found.gearbox_force.values(8), found.gearbox_moment.values(8)
    across = force - (force @ axis)[:, None] * axis
    assert far.values(8) + near.values(8) == pytest.approx(across, abs=1e-10)
    # About the far bearing, square to the axis; the torque along it goes on into the gearbox.
    about = np.cross(spacing * axis, near.values(8))
    needed = moment + np.cross((spacing + overhang) * axis, force)
    needed -= (needed @ axis)[:, None] * axis
    assert about == pytest.approx(needed, abs=1e-10)


def test_bearing_force_peak_is_bounded_by_static_plus_dynamic():
    """Order 4 is empty; the peak is above static and dynamic, below their sum."""
    force = carried(torque=1000.0).bearing_forces
    assert force.amplitude(4) == pytest.approx([0.0])
    static, dynamic = size(force.static), force.dynamic
    assert np.maximum(static, dynamic) < force.peak < static + dynamic


@pytest.mark.parametrize("freedom", ["last_shaft", "gearbox_flange"])
def test_strict_array_api_namespace_gives_equal_loads(freedom: str):
    line = replace(LINE, axial_freedom=freedom)
    rng = np.random.default_rng(8)
    many = layout_from_slopes(
        side=rng.uniform(-0.1, 0.1, (5, 4)), top=np.zeros((5, 4)), lengths=line.lengths
    )
    there = Layout(points=strict.asarray(many.points), directions=strict.asarray(many.directions))
    given = {"gravity": 9.81, "thrust": 90.0}
    found = carried(there, line, torque=strict.asarray([1000.0] * 5), **given)
    wanted = carried(many, line, torque=np.full(5, 1000.0), **given)
    for name in ("joint_forces", "joint_moments", "bearing_forces", "torques"):
        here, here_too = getattr(found, name), getattr(wanted, name)
        assert array_namespace(here.waves) is strict
        for what in ("static", "dynamic"):
            value = np.asarray(getattr(here, what))
            assert value == pytest.approx(getattr(here_too, what), rel=1e-12, abs=1e-10)
        assert np.asarray(here.values(8)) == pytest.approx(here_too.values(8), rel=1e-12, abs=1e-10)

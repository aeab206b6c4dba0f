"""A line on rubber: METHOD's closed form, statics as its limit, the beam model, a gyroscope.

The closed form is that of METHOD section 15: two uniform slender shafts of 20 and 25 kg, the
bearing at joint 2, k_v 200 and k_l 120 N/mm, eta 0.1, 1000 N m. The beams are those of
`cardan.physics.strength.beams`, which know nothing of this room's coordinates.
"""

import numpy as np
import pytest
from scipy.linalg import eigh

from cardan.model.layout import Layout, direction_from_slopes, unit_vector
from cardan.model.material import Material
from cardan.model.parts import CentreBearing, Line, Shaft, Spline, Tube
from cardan.physics.kinematics.joint_chain import rotate_chain
from cardan.physics.loads.centre_bearing import bearing_forces
from cardan.physics.loads.half_turn_fourier import semi_major_axis
from cardan.physics.loads.mounted_line_model import mounted_line
from cardan.physics.loads.statics import joint_loads
from cardan.physics.strength.beams import assemble_beams, beam_model

RUBBER = (200e3, 120e3, 0.0)
rpm = np.pi / 30


def laid(line: Line, *, side, top, moved=0.0) -> Layout:
    """Return a line along slopes in degrees, its joints moved (n, 3)."""
    d = direction_from_slopes(side=np.radians(side), top=np.radians(top))
    steps = np.array(line.lengths)[:, None] * d[1:-1]
    points = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)]) + moved
    between = unit_vector(np.diff(points, axis=0))
    return Layout(points=points, directions=np.concatenate([d[:1], between, d[-1:]]))


def slender(mass: float, length: float) -> Tube:
    """A rod without thickness that does not bend: its mass is all it has."""
    thin = {"outer": 1e-3, "wall": 0.5e-3}
    area = Tube(**thin).area
    heavy = Material(name="rod", youngs_modulus=1e25, density=mass / length / area)
    return Tube(**thin, material=heavy)


TWO = Line(
    shafts=(
        Shaft(length=1.2, tube=slender(20, 1.2), centre_bearing=CentreBearing()),
        Shaft(length=1.5, tube=slender(25, 1.5)),
    )
)
THREE = Line(
    shafts=tuple(
        Shaft(
            length=length,
            tube=Tube(outer=0.1, wall=0.004),
            phase=phase,
            yoke_mass=(5.0, 6.0),
            yoke_inertia=0.02,
            centre_bearing=CentreBearing(from_rear_joint=0.14, stiffness=RUBBER[:2])
            if hung
            else None,
            spline=None if hung else Spline(mass=6.0, from_front_joint=0.3),
        )
        for length, hung, phase in ((1.2, True, 0.0), (1.1, True, np.pi / 2), (1.5, False, 0.3))
    )
)
BENT = {"side": [3.0, 1.0, 4.5, 2.0, 1.0], "top": [0.0, 1.5, -0.8, 0.6, 1.0]}
PUBLISHED = {"side": [3.0, 1.0, 4.5, 2.0], "top": [0.0, 1.5, -0.8, 0.6]}


def of(line: Line, where: Layout, *, torque=1000.0):
    phases = line.phases_under_torque(line.phases, torque)
    return joint_loads(
        where, rotate_chain(where.directions, phases=phases, samples=16), line, torque=torque
    )


def shaken(line, where, speeds, *, torque=0.0, order=2, sines=1, stiffness=RUBBER, loss=0.1):
    """Return the order 2 forces on the bearings at speeds (...), for 1000 N m."""
    on = mounted_line(where, line, stiffness=stiffness, loss=loss, sines=sines)
    push = on.forces_from_joint_moments(of(line, where).joint_moments.order(order))
    speeds = np.asarray(speeds, dtype=float)
    return on, push, on.response(push, frequency=order * speeds, speed=speeds, torque=torque)


@pytest.mark.parametrize(
    ("speed", "force"),
    [(0, 20.0899), (100, 21.239), (300, 39.127), (426.6, 207.10), (500, 105.89), (551.3, 203.99),
     (800, 18.265), (2400, 1.1272)],
)  # fmt: skip
def test_bearing_force_matches_closed_form_of_method_15(speed, force):
    where = laid(TWO, **PUBLISHED)
    *_, found = shaken(TWO, where, speed * rpm, sines=0)
    assert semi_major_axis(found.bearing_forces) == pytest.approx([force], rel=5e-5)


@pytest.mark.parametrize(
    ("speed", "force"),
    [(100, 21.2516), (426.6, 207.225), (500, 105.955), (551.3, 204.108), (800, 18.2756),
     (2400, 1.12789)],
)  # fmt: skip
def test_bearing_force_matches_exudyn_with_moving_geometry(speed, force):
    """EXUDYN, geometry moving, as METHOD prints it: within the last digit of what it gives."""
    where = laid(TWO, **PUBLISHED)
    held = mounted_line(where, TWO, stiffness=RUBBER, sines=0)
    found = bearing_forces(where, TWO, np.zeros(2), torque=1000.0, speed=speed * rpm, held=held)
    assert found.order_amplitudes[..., 0] == pytest.approx([force], rel=3e-5)
    assert (
        found.order_amplitudes[..., 1] < 2e-3 * force
    ).all()  # the moments' own, without inertia


def test_quasi_static_unbalance_equals_rigid_bearing_unbalance():
    where = laid(THREE, **BENT)
    on = mounted_line(where, THREE, stiffness=RUBBER)
    slow = 0.05
    soft, rigid = (
        bearing_forces(
            where, THREE, THREE.phases, torque=0.0, speed=slow, held=h, balanced_at=200.0
        )
        for h in (on, None)
    )
    assert soft.order1 == pytest.approx(rigid.order1, rel=1e-3)
    assert (soft.order1 > 0).all()


def test_static_force_is_worst_of_thrust_in_both_directions():
    where = laid(THREE, **BENT)
    phases = np.array(THREE.phases)
    still = rotate_chain(
        where.directions, phases=THREE.phases_under_torque(phases, 2000.0), samples=16
    )
    found = bearing_forces(where, THREE, phases, torque=2000.0, speed=0.0, slip=5000.0)
    each = [
        joint_loads(where, still, THREE, torque=2000.0, thrust=thrust).bearing_forces.static
        for thrust in (-5000.0, 0.0, 5000.0)
    ]
    sizes = np.linalg.norm(each, axis=-1)
    assert found.static == pytest.approx(sizes.max(axis=0), rel=1e-12)
    assert np.abs(found.thrust) == pytest.approx([5000.0, 5000.0])
    assert (sizes.max(axis=0) > 1.2 * sizes[1]).any()


def test_shaft_inertia_excites_order_4():
    where = laid(THREE, **BENT)
    phases, inertias = np.array(THREE.phases), np.array([0.05, 0.06, 0.08])
    slow, fast = (
        bearing_forces(
            where, THREE, phases, torque=2000.0, speed=n, inertias=inertias
        ).order_amplitudes
        for n in (100.0, 200.0)
    )
    assert fast[..., 1] == pytest.approx(4 * slow[..., 1], rel=1e-9)
    assert (slow[..., 1] > 0).all()


def test_resonances_match_closed_form():
    modes = mounted_line(laid(TWO, **PUBLISHED), TWO, stiffness=RUBBER, sines=0).modes()
    assert modes.frequency / 2 / rpm == pytest.approx([427.25, 551.90], abs=5e-3)
    assert modes.vertical_share == pytest.approx([0.0, 1.0], abs=1e-4)
    assert modes.damping_ratio == pytest.approx([0.05, 0.05], rel=1e-6)
    assert modes.bending_share == pytest.approx([0.0, 0.0], abs=1e-6)


def test_modes_of_batched_torques_equal_single_torques():
    """Torques (P, V, S) that come again, against LAPACK on K + T K_T over M one by one."""
    where = laid(THREE, **BENT)
    stiffness = np.multiply.outer([0.8, 1.0, 1.3], RUBBER)[:, None, None]
    on = mounted_line(where[None, None], THREE, stiffness=stiffness)
    torques = np.random.default_rng(1).choice([-4e3, 0.0, 9e3], size=(8, 3, 2))
    squares, shapes, decay = on.modes_with_decay(torques)
    found = on.natural_frequencies(torque=torques)
    still, lost = on._held
    for p, v, s in np.ndindex(torques.shape):
        K = still[v, 0] + torques[p, v, s] * on.torsion[0, 0]
        square, shape = eigh(K, on.mass[0, 0])
        np.testing.assert_allclose(squares[p, v, s], square, rtol=1e-9)
        np.testing.assert_allclose(found[p, v, s], np.sqrt(square), rtol=1e-9)
        np.testing.assert_allclose(np.abs(shapes[p, v, s]), np.abs(shape), atol=1e-6)
        share = np.diag(shape.T @ lost[v, 0] @ shape) / 2 / np.sqrt(square)
        np.testing.assert_allclose(decay[p, v, s], share, rtol=1e-6)
    # One torque of several variants is not one case: each has its own rubber.
    alike = on.natural_frequencies(torque=np.full((3, 1), 9e3))
    for v in range(3):
        square = eigh(still[v, 0] + 9e3 * on.torsion[0, 0], on.mass[0, 0])[0]
        np.testing.assert_allclose(alike[v, 0], np.sqrt(square), rtol=1e-9)


@pytest.mark.parametrize("sines", [0, 1, 2])
@pytest.mark.parametrize("order", [0, 2])
def test_quasi_static_forces_match_statics(sines, order):
    """What holds a shaft still does not ask how soft it hangs, to rounding."""
    where = laid(THREE, **BENT)
    on = mounted_line(where, THREE, stiffness=RUBBER, sines=sines)
    statics = of(THREE, where)
    found = on.response(
        on.forces_from_joint_moments(statics.joint_moments.order(order))
    ).bearing_forces
    assert found == pytest.approx(statics.bearing_forces.order(order), rel=1e-12, abs=1e-9)


@pytest.mark.parametrize("stiffness", [np.inf, 1e18])
def test_rigid_bearing_forces_match_statics_at_any_speed(stiffness):
    where = laid(THREE, **BENT)
    rigid = (stiffness, stiffness, 0.0)
    *_, found = shaken(THREE, where, 300.0, sines=0, stiffness=rigid, loss=0.0)
    statics = of(THREE, where).bearing_forces.order(2)
    assert found.bearing_forces == pytest.approx(statics, rel=1e-9, abs=1e-7)


def test_rigid_bearing_with_soft_bearing_is_stiff_limit():
    """As near as a very stiff one comes, in motion and in balance, and it hardly moves."""
    where = laid(THREE, **BENT)
    both = [
        mounted_line(where, THREE, stiffness=[(firm, firm, 0.0), RUBBER]) for firm in (np.inf, 1e11)
    ]
    push = both[0].forces_from_joint_moments(of(THREE, where).joint_moments.order(2))
    rigid, stiff = (on.response(push, frequency=90.0, speed=45.0, torque=5e3) for on in both)
    assert rigid.bearing_forces == pytest.approx(stiff.bearing_forces, rel=1e-4)
    rigid, stiff = (
        bearing_forces(where, THREE, THREE.phases, torque=5e3, speed=45.0, held=on) for on in both
    )
    assert rigid.dynamic == pytest.approx(stiff.dynamic, rel=1e-4)
    assert rigid.static == pytest.approx(stiff.static, rel=1e-4)


@pytest.mark.parametrize(("stiffness", "sines"), [(RUBBER, 1), ((2e6, 9e5, 0.0), 3)])
def test_modes_match_beam_model(stiffness, sines):
    """Another model, of elements. On rubber one sine in each tube is enough."""
    straight = laid(THREE, side=[0.0] * 5, top=[0.0] * 5)
    beams = beam_model(THREE)
    beams = type(beams)(
        **{name: getattr(beams, name) for name in beams.__slots__}
        | {"bearing_stiffness": np.array([stiffness[:2]] * 2)}
    )
    inverse = np.linalg.eigvalsh(assemble_beams(beams, 8).flexibility)[:, -4:]
    expected = np.sort((inverse**-0.5).ravel())[:6]
    found = mounted_line(straight, THREE, stiffness=stiffness, sines=sines).modes().frequency[:6]
    assert found == pytest.approx(expected, rel=2e-3)


def test_torque_stiffness_matches_derivative_of_exact_moments():
    """Moments of the exact chain, in lines moved by each coordinate: a difference quotient."""
    straight = {"side": np.multiply(BENT["side"], 0.01), "top": np.multiply(BENT["top"], 0.01)}
    where = laid(THREE, **straight)
    on = mounted_line(where, THREE, stiffness=RUBBER, sines=0)
    step, columns = 1e-5, []
    for motion in np.eye(on.mass.shape[-1]):
        joints = np.concatenate([on.front @ motion, (on.rear @ motion)[-1:]])
        push = [
            on.forces_from_joint_moments(
                of(THREE, laid(THREE, **straight, moved=by * joints)).joint_moments.static
            )
            for by in (-step, step)
        ]
        columns.append((push[0] - push[1]) / (2 * step) / 1000.0)
    assert np.abs(np.array(columns).T - on.torsion).max() < 2e-4
    assert abs(on.torsion).max() > 0.5


def test_order_2_stiffness_matches_derivative_of_exact_moments():
    """Order 2 of the exact chain's moments, in lines moved: a difference quotient."""
    straight = {"side": np.multiply(BENT["side"], 0.01), "top": np.multiply(BENT["top"], 0.01)}
    where = laid(THREE, **straight)
    on = mounted_line(where, THREE, stiffness=RUBBER, sines=0)
    phases = THREE.phases_under_torque(THREE.phases, 1000.0)
    swing = on.order2_coupling(rotate_chain(where.directions, phases=phases, samples=16))
    step, columns = 1e-5, []
    for motion in np.eye(on.mass.shape[-1]):
        joints = np.concatenate([on.front @ motion, (on.rear @ motion)[-1:]])
        push = [
            on.forces_from_joint_moments(
                of(THREE, laid(THREE, **straight, moved=by * joints)).joint_moments.order(2)
            )
            for by in (-step, step)
        ]
        columns.append((push[1] - push[0]) / (2 * step) / 1000.0)
    assert np.abs(np.array(columns).T - swing).max() < 1e-5
    assert np.abs(swing).max() > 1


def test_orders_0_2_and_4_are_in_equilibrium():
    """Each is what the others push it to, one by one, at a torque that ties them firmly."""
    where, torque, speed = laid(THREE, **BENT), 8e3, 30.0
    on = mounted_line(where, THREE, stiffness=RUBBER)
    still = rotate_chain(where.directions, phases=np.array(THREE.phases), samples=16)
    moments = of(THREE, where, torque=torque).joint_moments
    f0, f2 = (
        on.forces_from_joint_moments(moments.static),
        on.forces_from_joint_moments(moments.order(2)),
    )
    f4 = 0.01 * f2 * np.exp(0.7j)
    swing = on.order2_coupling(still)
    q0, q2, q4 = (
        m.coordinates for m in on.harmonic_balance((f0, f2, f4), swing, speed=speed, torque=torque)
    )
    tie = torque * swing

    def pushed_to(force, order):
        W = order * speed
        return on.response(force, frequency=W, speed=speed, torque=torque).coordinates

    mean = pushed_to(f0 + (tie @ np.conj(q2)).real / 2, 0)
    second = pushed_to(f2 + tie @ q0 + np.conj(tie) @ q4 / 2, 2)
    fourth = pushed_to(f4 + tie @ q2 / 2, 4)
    size = np.abs(q2).max()
    assert np.abs(mean - q0).max() < 1e-9 * size
    assert np.abs(second - q2).max() < 1e-9 * size
    assert np.abs(fourth - q4).max() < 1e-9 * size
    assert np.abs(q4).max() > 0.01 * size


def test_rubber_dissipation_equals_power_of_moments():
    on, push, found = shaken(THREE, laid(THREE, **BENT), np.array([30.0, 45.0, 80.0]), torque=5e3)
    fed = np.imag((np.conj(found.coordinates) * push).sum(-1))
    across = on.bearing @ found.coordinates[..., None, :, None]
    lost = 0.1 * (np.array(RUBBER) * np.abs(across[..., 0]) ** 2).sum((-2, -1))
    assert fed == pytest.approx(lost, rel=1e-9)
    assert (lost > 0).all()


def test_line_rotated_by_90_deg_has_equal_forces():
    """Turned by 90 degrees, with the rubber's directions exchanged, nothing is different."""
    where = laid(THREE, **BENT)
    turned = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    other = Layout(points=where.points @ turned.T, directions=where.directions @ turned.T)
    plain = (RUBBER[0], RUBBER[0], 0.0)
    *_, one = shaken(THREE, where, 40.0, stiffness=plain, torque=5e3)
    *_, two = shaken(THREE, other, 40.0, stiffness=plain, torque=5e3)
    assert semi_major_axis(two.bearing_forces) == pytest.approx(
        semi_major_axis(one.bearing_forces), rel=1e-9
    )


def test_spinning_shaft_precesses_as_gyroscope():
    """A rigid disc's gyroscope: one hung shaft with all its inertia, forward and backward.

    With J_t and J_p about a pin at one end and a spring k at the other, the whirl speeds of a
    spherical pendulum solve W² J - W Ω J_p - k L² = 0, forward, and + backward.
    """
    polar, omega = 40.0, 300.0
    line = Line(
        shafts=(
            Shaft(
                length=1.2, tube=slender(20, 1.2), polar_inertia_given=polar,
                centre_bearing=CentreBearing(),
            ),
            Shaft(length=500.0, tube=slender(1e-6, 500.0)),
        )
    )  # fmt: skip
    where = laid(line, side=[0.0] * 4, top=[0.0] * 4)
    on = mounted_line(where, line, stiffness=(2e5, 2e5, 0.0), loss=1e-9, sines=0)
    J = 20 * 1.2**2 / 3
    rise = np.sqrt((omega * polar / 2) ** 2 + J * 2e5 * 1.2**2)
    for whirl, forward in ((rise + omega * polar / 2, 1), (rise - omega * polar / 2, -1)):
        along = np.array([1.0, 1j * forward, 0, 0])[:2]  # up and level, as the shaft turns
        met, against, beside = (
            np.abs(on.response(push, frequency=W, speed=omega).coordinates).max()
            for push, W in (
                (along, whirl / J), (np.conj(along), whirl / J), (along, 1.01 * whirl / J)
            )
        )  # fmt: skip
        assert met > 1e3 * against
        assert met > 1e3 * beside

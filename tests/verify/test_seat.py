"""A line whose bearings hang in brackets that give, against matrices of another making.

The other way is physical: the bracket is a chain of masses on springs, none of them a mode,
and its masses stand beside the line's own coordinates.
"""

import numpy as np
import pytest
from test_rubber import BENT, PUBLISHED, RUBBER, THREE, TWO, laid, of

from cardan.model.bracket_compliance import BracketCompliance, reduce_to_bracket_compliance
from cardan.physics.loads.centre_bearing import bearing_forces
from cardan.physics.loads.half_turn_fourier import semi_major_axis
from cardan.physics.loads.mounted_line_model import mounted_line

rpm = np.pi / 30
SPEEDS = np.array([0.0, 100, 426.6, 500, 551.3, 800, 2400]) * rpm


class Masses:
    """A bracket of six masses on springs, three to the frame, three more to the seat."""

    def __init__(self, seed=3, *, stiff=4e6, heavy=1.2):
        random = np.random.default_rng(seed)
        links = random.standard_normal((9, 6))
        links[:3, 3:], links[6:, :3] = 0.0, 0.0  # to the frame; between; the seat's own
        self.K = links.T @ np.diag(stiff * random.uniform(0.5, 2, 9)) @ links + 1e5 * np.eye(6)
        self.M = np.diag(heavy * random.uniform(0.5, 2, 6))
        self.at = np.eye(6)[:, 3:]  # where the bearing sits

    def reduced(self, count, *, loss=0.02) -> BracketCompliance:
        """What finite elements would hand over: some modes, and statics."""
        low = np.linalg.cholesky(self.M)
        inverse = np.linalg.inv(low)
        squares, shapes = np.linalg.eigh(inverse @ self.K @ inverse.T)
        shapes = inverse.T @ shapes[:, :count]
        static = np.linalg.solve(self.K, self.at)
        self.columns = np.concatenate([static, shapes], axis=1)
        return reduce_to_bracket_compliance(
            self.at.T @ static, frequencies=np.sqrt(squares[:count]), motion=shapes.T @ self.at,
            inertia=static.T @ self.M @ static, loss=loss,
        )  # fmt: skip

    def whole(self, W, *, loss=0.02):
        return self.K * (1 + 1j * loss * np.sign(W)) - W**2 * self.M


def spring(*stiffness, loss=0.02) -> BracketCompliance:
    """A bracket that is a spring each way, and nothing else."""
    none = np.zeros((0, 3))
    return reduce_to_bracket_compliance(
        np.diag(1 / np.array(stiffness)), frequencies=np.zeros(0), motion=none,
        inertia=np.zeros((3, 3)), loss=loss,
    )  # fmt: skip


@pytest.mark.parametrize("modes", [0, 1, 3, 6])
def test_static_compliance_is_exact_for_any_number_of_modes(modes):
    masses = Masses()
    found = masses.reduced(modes)
    want = masses.at.T @ np.linalg.solve(masses.K, masses.at)
    assert found.static_compliance == pytest.approx(want, rel=1e-9, abs=1e-9 * want.max())
    assert found.dynamic_increment([1.0, 2.0, 3.0], 0.0) == pytest.approx(
        np.zeros(3 + modes), abs=1e-25
    )


@pytest.mark.parametrize("share", [0.3, 0.9, 1.0, 1.05])
def test_reduced_bracket_with_all_modes_matches_spring_mass_chain(share):
    """With every mode there is nothing left out: seat and each mass to rounding."""
    masses, force = Masses(), np.array([1.0, -2.0, 0.5])
    found = masses.reduced(6)
    W = share * found.frequencies[1]
    moved = np.linalg.solve(masses.whole(W), masses.at @ force)
    assert found.dynamic_compliance(W) @ force == pytest.approx(masses.at.T @ moved, rel=1e-9)
    still = masses.columns[:, :3] @ force
    inside = still + masses.columns @ found.dynamic_increment(force, W)
    assert inside == pytest.approx(moved, rel=1e-8, abs=1e-9 * np.abs(moved).max())


def test_three_modes_are_accurate_below_half_first_frequency():
    """Up to half the first frequency what is left out is below a thousandth."""
    masses = Masses()
    few = masses.reduced(2)
    W = 0.5 * few.frequencies[0]
    want = np.linalg.solve(masses.whole(W), masses.at)
    inside = masses.columns[:, :3] + masses.columns @ few.dynamic_increment(np.eye(3), W).T
    assert np.abs(inside - want).max() < 1e-3 * np.abs(want).max()


def test_history_is_filtered_order_by_order():
    """A wave that comes back is its own transfer; the mean does nothing beyond resting."""
    found = Masses().reduced(3)
    W, force = 0.8 * found.frequencies[0], np.array([1 + 1j, 2.0, -1j])
    t = np.arange(64) / 64
    history = 5 + (force * np.exp(2j * np.pi * 2 * t)[:, None]).real
    got = found.dynamic_increment_history(history, 2 * np.pi * 2 / W)
    want = (found.dynamic_increment(force, W) * np.exp(2j * np.pi * 2 * t)[:, None]).real
    assert got == pytest.approx(want, rel=1e-9, abs=1e-12 * np.abs(want).max())


def shaken(on, line, where, speed, torque=0.0):
    push = on.forces_from_joint_moments(of(line, where).joint_moments.order(2))
    return on.response(push, frequency=2 * speed, speed=speed, torque=torque)


def test_bracket_spring_is_in_series_with_rubber():
    """1 / (1/k + 1/k'), with their losses; along the vehicle's axes a straight line's own are."""
    where = laid(TWO, side=np.zeros(4), top=np.zeros(4))
    bent = of(TWO, laid(TWO, **PUBLISHED)).joint_moments.order(2)
    firm = 900e3, 700e3
    soft = [k * (1 + 0.1j) for k in RUBBER[:2]]
    give = [k * (1 + 0.02j) for k in firm]
    both = np.array([a * b / (a + b) for a, b in zip(soft, give, strict=True)])
    hung = mounted_line(where, TWO, stiffness=RUBBER).with_bracket(0, spring(1e6, firm[1], firm[0]))
    series = mounted_line(where, TWO, stiffness=[*both.real, 0.0], loss=0.0)
    for speed in SPEEDS[1:]:
        a = hung.response(hung.forces_from_joint_moments(bent), frequency=2 * speed, speed=speed)
        # Up and level by themselves have losses of their own.
        N = series.mass.shape[-1]
        rows = series.bearing.reshape(-1, N)[:2]
        whole = series.dynamic_stiffness(2 * speed, speed, 0.0) + 1j * (rows.T * both.imag) @ rows
        q = np.linalg.solve(whole, series.forces_from_joint_moments(bent))
        force = np.einsum("k,kx->x", both * (rows @ q), series.bearing_frame[0, :2])
        assert a.bearing_forces[0] == pytest.approx(force, rel=1e-6, abs=1e-9)


def test_rigid_bracket_equals_no_bracket():
    """Frequencies a million times as high: rigid brackets to 1e-9."""
    where = laid(THREE, **BENT)
    rigid = mounted_line(where, THREE, stiffness=RUBBER)
    masses = Masses(stiff=4e6 * 1e12).reduced(3)
    hung = rigid.with_bracket(0, masses).with_bracket(1, masses)
    for speed in SPEEDS:
        a, b = (shaken(on, THREE, where, speed).bearing_forces for on in (hung, rigid))
        assert np.abs(a - b).max() < 1e-9 * np.abs(b).max()


@pytest.mark.parametrize("torque", [0.0, 6000.0])
def test_line_in_brackets_matches_explicit_masses(torque):
    """The masses themselves beside the line, one bracket at each of two bearings."""
    where = laid(THREE, **BENT)
    one, two = Masses(1), Masses(2, stiff=2e6)
    on = mounted_line(where, THREE, stiffness=RUBBER)
    hung = on.with_bracket(0, one.reduced(6)).with_bracket(1, two.reduced(6))
    N = on.mass.shape[-1]
    for speed in SPEEDS[1:]:
        W = 2 * speed
        whole = np.zeros((N + 12, N + 12), dtype=complex)
        whole[:N, :N] = on.bending + torque * on.torsion - W**2 * on.mass
        whole[:N, :N] += 1j * W * speed * on.gyroscopic
        rows = np.zeros((2, 3, N + 12))
        rows[:, :, :N] = on.bearing
        for k, masses in enumerate((one, two)):
            here = slice(N + 6 * k, N + 6 * k + 6)
            whole[here, here] = masses.whole(W)
            rows[k, :, here] = -on.bearing_frame[k] @ masses.at.T
            whole += (rows[k].T * np.array(RUBBER) * (1 + 0.1j)) @ rows[k]
        push = np.zeros(N + 12, dtype=complex)
        push[:N] = on.forces_from_joint_moments(of(THREE, where).joint_moments.order(2))
        q = np.linalg.solve(whole, push)
        force = [
            (on.bearing_frame[k].T * np.array(RUBBER) * (1 + 0.1j)) @ rows[k] @ q for k in (0, 1)
        ]
        found = shaken(hung, THREE, where, speed, torque).bearing_forces
        assert np.abs(found - force).max() < 1e-8 * np.abs(force).max()


def test_modes_of_line_in_series_name_their_part():
    """A soft bracket takes the energy; at rest the bearing carries what statics says."""
    where = laid(THREE, **BENT)
    on = mounted_line(where, THREE, stiffness=RUBBER)
    soft = on.with_bracket(0, spring(20e3, 20e3, 20e3)).with_bracket(1, spring(20e3, 20e3, 20e3))
    assert soft.modes().mode_names().count("bracket") >= 4
    assert soft.modes().frequency[0] < on.modes().frequency[0] / 2
    still = shaken(soft, THREE, where, 0.0).bearing_forces
    assert semi_major_axis(still) == pytest.approx(
        semi_major_axis(of(THREE, where).bearing_forces.order(2)), rel=1e-6
    )


def test_running_analysis_includes_bracket():
    """Orders and set-down of `running` are those of the line in series, by its slow modes too."""
    where = laid(THREE, **BENT)
    phases = np.array(THREE.phases)
    hung = mounted_line(where, THREE, stiffness=RUBBER).with_bracket(0, spring(500e3, 500e3, 500e3))
    whole, quick = (
        bearing_forces(where, THREE, phases, torque=2000.0, speed=SPEEDS[3], held=h)
        for h in (hung, hung.modal_reduction(6))
    )
    rigid = bearing_forces(
        where, THREE, phases, torque=2000.0, speed=SPEEDS[3],
        held=mounted_line(where, THREE, stiffness=RUBBER),
    )  # fmt: skip
    assert quick.order_amplitudes[..., 0] == pytest.approx(whole.order_amplitudes[..., 0], rel=0.02)
    assert abs(rigid.order_amplitudes[0, 0] / whole.order_amplitudes[0, 0] - 1) > 0.05

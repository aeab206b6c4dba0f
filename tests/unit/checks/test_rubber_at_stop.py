"""A line of two bearings whose rubber meets its stop, by its own integration in time."""

import re

import numpy as np
import pytest
from repository import EXAMPLES
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

from cardan.application import reader
from cardan.checks import rubber_at_stop
from cardan.checks.line_response import compute_line_response
from cardan.model.layout import layout_from_points
from cardan.physics.loads.centre_bearing import loads_of_turning_line
from cardan.physics.loads.half_turn_fourier import semi_major_axis
from cardan.physics.loads.rubber_stop_receptance import StoppedLine, moved_by
from cardan.physics.loads.rubber_stop_response import StoppedMotion
from cardan.physics.loads.statics import bearing_forces_of_weight_and_thrust
from cardan.physics.vehicle.operating_points import demand_at_operating_points
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references

COLLECTOR = (EXAMPLES / "refuse-collector-6x2.yaml").read_text(encoding="utf-8")
MEDIUM = (EXAMPLES / "medium-truck-4x2.yaml").read_text(encoding="utf-8")
STOP, RATIO = 15e-3, 5.0


def response(text: str):
    application = reader.loads(text)
    return compute_line_response(
        application, line_state_demand(resolve_line_references(application, application.lines[0]))
    )


class _LineInTime:
    """A line in the coordinates of its slowest modes at one point, with stops of `RATIO`.

    Mass, gyroscope, torque's stiffness with its order 2, dampers that lose as much as the rubber
    at order 2, crosses' moments of orders 0, 2 and 4, and a mean offset of the bearings by thrust.
    """

    def __init__(self, r, state: int, curve: int, speed: float, thrust: int) -> None:
        mounts, inputs = r.mounts, r.inputs
        states = len(r.demand.states)
        asked = demand_at_operating_points(
            inputs.demand, mounts.torque_curves,
            curve=np.full((1, states), curve), speed=np.full((1, states), speed),
        )  # fmt: skip
        laid, how = inputs.layout_for(asked), mounts.force_inputs(asked, inertia=False)
        turned, carried = loads_of_turning_line(
            laid, inputs.line, inputs.phases, torque=how["torque"], speed=how["speed"]
        )
        on = mounts.reduced_mounted_line
        self.T, self.speed = float(how["torque"][0, state]), float(how["speed"][0, state])
        self.swing = self.T * on.order2_coupling(turned)[0, state]
        self.pushes = [
            on.forces_from_joint_moments(carried.joint_moments.order(k))[0, state]
            for k in (0, 2, 4)
        ]
        one = on.select_states([state])

        def own(values, axes):
            return np.broadcast_to(values, (1, *values.shape[-axes:]))[0]

        N = one.mass.shape[-1]
        self.K = one.stiffness_under_torque(self.T).reshape(N, N)
        self.M, self.G = own(one.mass, 2), own(one.gyroscopic, 2)
        self.rows = own(one.bearing, 3)[:, :2].reshape(-1, N)
        self.k, self.eta = own(one.stiffness, 2)[:, :2], own(one.loss, 1)
        self.C = (self.rows.T * (self.k * self.eta[:, None]).ravel()) @ self.rows
        force = mounts.thrust_effect(asked).force[thrust, 0, state]
        frame = own(one.bearing_frame, 3)
        local = (frame @ force[..., None])[..., 0]
        self.offset = (local[:, :2] / self.k).ravel()

    def stop(self, x: np.ndarray) -> np.ndarray:
        """Return what stops add to forces at the bearings, (B, 2) N."""
        found = np.zeros_like(x)
        for b, (u, k) in enumerate(zip(x, self.k, strict=True)):
            far = np.hypot(*u)
            if far > STOP:
                n, gap = u / far, far - STOP
                kn = k @ n**2
                found[b] = (RATIO - 1) * gap * (kn * n + gap / far * (k - kn) * n)
        return found

    def slope(self, t: float, state: np.ndarray, W: float) -> np.ndarray:
        N = len(self.M)
        q, v = state[:N], state[N:]
        wave = np.exp(1j * np.copysign(W, self.speed) * t)
        f = (self.pushes[0] + self.pushes[1] * wave + self.pushes[2] * wave**2).real
        x, vx = (self.rows @ q + self.offset).reshape(-1, 2), (self.rows @ v).reshape(-1, 2)
        lost = (self.stop(x + 1e-7 * vx) - self.stop(x - 1e-7 * vx)) / 2e-7
        lost = self.eta[:, None] / W * lost
        left = f - self.K @ q + (self.swing * wave).real @ q - self.C @ v / W
        left -= np.copysign(W / 2, self.speed) * (self.G @ v)
        left -= self.rows.T @ (self.stop(x) + lost).ravel()
        return np.concatenate([v, np.linalg.solve(self.M, left)])

    def largest_dynamic_force(self, speeds: np.ndarray, turns: int = 16) -> np.ndarray:
        """Return the largest of each bearing over rising speeds, the motion kept, N."""
        N = len(self.M)
        state, found = np.zeros(2 * N), np.zeros(len(self.k))
        for speed in speeds:
            W = 2 * speed
            end = turns * 2 * np.pi / W
            times = np.linspace(end * (1 - 2 / turns), end, 200)
            done = solve_ivp(
                self.slope, (0, end), state, args=(W,), t_eval=times, rtol=1e-4, atol=1e-6
            )
            state = done.y[:, -1]
            force = np.array([
                (k := self.k) * (x := (self.rows @ y[:N] + self.offset).reshape(-1, 2))
                + self.stop(x) + self.eta[:, None] * k / W * (self.rows @ y[N:]).reshape(-1, 2)
                for y in done.y.T
            ])  # fmt: skip
            away = np.linalg.norm(force - force.mean(axis=0), axis=-1)
            found = np.maximum(found, away.max(axis=0))
        return found


@pytest.mark.slow
def test_forces_of_two_bearings_at_stop_match_integration_in_time():
    """Axle at full rebound, in reverse: order 2 takes the second bearing to its stop."""
    text = COLLECTOR.replace(
        "centre_bearing: {", f"centre_bearing: {{travel_mm: 15, stop_stiffness_ratio: {RATIO:g}, "
    )
    r = response(text)
    solved, state = r.mount_loads.stop_response, r.demand.states.index("full rebound")
    assert solved.is_solved[state]
    worst = solved.points["dynamic"]
    curve, speed = int(worst.curve_index[state, 1]), float(worst.speed[state, 1])
    speeds = speed * np.arange(0.9, 1.03, 0.02)
    largest = np.max([
        _LineInTime(r, state, curve, speed, thrust).largest_dynamic_force(speeds)
        for thrust in (0, 1)
    ], axis=0)  # fmt: skip
    assert solved.force("dynamic")[state, 1] == pytest.approx(largest[1], rel=0.02)
    linear = r.mount_loads.bearing_force("dynamic")[state, 1]
    assert largest[1] > 1.1 * linear


def test_mean_force_of_sliding_thrust_at_stop_matches_statics_of_the_bent_line():
    """The medium truck's bearing: crosses' moments and slip force act where the stop holds it.

    Rigid statics of the line with its joint moved, against rubber and stop, with no stiffness of
    torque or thrust in it. The check adds other places of the stroke and what order 2 sets down.
    """
    more = f"{{travel_mm: 15, stop_stiffness_ratio: {RATIO:g}, "
    r = response(MEDIUM.replace("centre_bearing: {", f"centre_bearing: {more}"))
    inputs, states, state = r.inputs, len(r.demand.states), r.demand.states.index("gvw")
    solved = r.mount_loads.stop_response
    assert solved.is_solved[state]
    worst = solved.points["static"]
    asked = demand_at_operating_points(
        inputs.demand, r.mounts.torque_curves,
        curve=np.full((1, states), int(worst.curve_index[state, 0])),
        speed=np.full((1, states), float(worst.speed[state, 0])),
    )  # fmt: skip
    laid, T = inputs.layout_for(asked), np.nan_to_num(asked.torque)
    frame = np.broadcast_to(r.mounts.mounted_line.bearing_frame, (states, 1, 3, 3))[state, 0]
    k = np.broadcast_to(r.mounts.mounted_line.stiffness, (states, 1, 3))[state, 0, :2]
    slip = float(inputs.spline_force_at(T)[0, state])
    length = laid.lengths[0, state, 0]
    share = 1 - inputs.line.centre_bearings[0].from_rear_joint / length
    weight = bearing_forces_of_weight_and_thrust(laid, inputs.line, gravity=inputs.gravity)[0]

    def rigid(x):
        points, d = laid.points.copy(), laid.directions
        points[0, state, 1] += frame[:2].T @ (x / share)
        there = layout_from_points(points, gearbox=d[..., 0, :], pinion=d[..., -1, :])
        _, carried = loads_of_turning_line(there, inputs.line, inputs.phases, torque=T, speed=0 * T)
        _, pulled = bearing_forces_of_weight_and_thrust(there, inputs.line, gravity=0.0)
        return carried.bearing_forces.order(0).real[0, state, 0] - slip * pulled[0, state, 0]

    def rubber(x):
        far = np.hypot(*x)
        if far <= STOP:
            return k * x
        n, gap = x / far, far - STOP
        kn = k @ n**2
        return k * x + (RATIO - 1) * gap * (kn * n + gap / far * (k - kn) * n)

    bent = fsolve(lambda x: (frame @ rigid(x))[:2] - rubber(x), np.zeros(2))
    assert np.hypot(*bent) > STOP
    mean = np.linalg.norm(rigid(bent) + weight[0, state, 0])
    assert solved.force("static")[state, 0] == pytest.approx(mean, rel=0.04)
    assert r.mount_loads.bearing_force("static")[state, 0] > solved.force("static")[state, 0]


@pytest.fixture(scope="module")
def medium():
    return response(MEDIUM.replace("centre_bearing: {", "centre_bearing: {travel_mm: 15, "))


@pytest.fixture(scope="module")
def grid(medium):
    """The medium truck's line on linear rubber, along the curves on which it comes to a stop."""
    loads = medium.mount_loads
    sweeps = rubber_at_stop._sweeps(
        medium.mounts, loads.screened_forces.travel, loads.refined_forces,
        loads.rubber_stop_travel.reshape(-1), (loads._own_stop_margin("peak") < 0).any(-1),
    )  # fmt: skip
    return rubber_at_stop._Grid.of(medium.mounts, sweeps, medium.mounts.mounted_line)


def test_grid_of_linear_rubber_has_the_forces_and_travel_of_the_checks(medium, grid):
    """Mean, orders and order 1 of each curve's points, with the worst of its thrusts."""
    mounts, states = medium.mounts, len(medium.demand.states)
    assert (grid.speed < 0).any()
    assert (grid.speed > 0).any()
    for c in range(0, len(grid.sweeps.state), 4):
        s, of, thrust = grid.sweeps.state[c], np.full(3, c), np.arange(3)
        points = {
            "curve": np.full((80, states), grid.sweeps.curve[c]),
            "speed": np.repeat(grid.sweeps.speeds[:, [c]], states, axis=1),
        }
        travel, force = grid.travel(of, thrust), grid.force_of(of, thrust)
        for found, axes, gives in ((travel, 2, True), (force, 3, False)):
            known = mounts.bearing_forces_at_points(**points, gives=gives).results
            each = np.insert(found, 2, 0, axis=-1) if axes == 2 else found
            mean = np.linalg.norm(each[..., 0, :], axis=-1).max(axis=1)
            swing = semi_major_axis(rubber_at_stop._waves(each))[:, 0, 0].sum(-1)
            assert mean == pytest.approx(known.static[:, s, 0], rel=1e-12)
            assert swing == pytest.approx(known.dynamic[:, s, 0], rel=1e-12)
            whole = mean + swing + (0 if gives else grid.order1[:, c, 0])
            assert gives or whole == pytest.approx(known.peak[:, s, 0], rel=1e-12)


def test_forces_of_a_motion_follow_it_where_the_stop_is_no_stiffer(grid):
    """Twice linear rubber's motion beside weight has twice its force; the peak has order 1 too."""
    of, thrust = np.arange(len(grid.sweeps.state)), np.zeros(len(grid.sweeps.state), dtype=int)
    free = grid.travel(of, thrust)
    line = StoppedLine(
        free=free, receptance=grid.receptance(of, thrust), stiffness=grid.stiffness[of],
        stop=np.full((len(of), 1), 1e-9), ratio=np.ones((len(of), 1)),
    )  # fmt: skip
    place = np.repeat(np.arange(80.0)[:, None], len(of), axis=1)
    one, two = (
        grid.sizes(line, StoppedMotion(place=place, travel=k * free), of, thrust) for k in (1, 2)
    )
    turns = grid.speed != 0  # a line at rest loses nothing
    assert two["dynamic"][turns] == pytest.approx(2 * one["dynamic"][turns], rel=1e-9)
    assert two["travel"] == pytest.approx(2 * one["travel"], rel=1e-9)
    assert two["peak"] - two["static"] - two["dynamic"] == pytest.approx(grid.order1, rel=1e-6)


def test_push_in_proportion_to_travel_moves_the_line_as_stiffer_rubber_does(grid):
    """A fifth more stiffness as forces of a stop, X = X₀ - C ΔK X, and in the rubber itself.

    Ahead and astern, through resonance. The stop's line has fewer modes, and a stop loses twice
    the rubber's share at order 4: 4 % of the travel in resonance.
    """
    harder = re.sub(
        r"((?:vertical|lateral)_stiffness_N_mm: )(\d+)",
        lambda found: f"{found[1]}{1.2 * float(found[2])}",
        MEDIUM.replace("centre_bearing: {", "centre_bearing: {travel_mm: 15, "),
    )
    mounts, count = response(harder).mounts, len(grid.sweeps.state)
    of, none = np.arange(count), np.zeros(count, dtype=int)
    line = grid.line(of, none, np.array([STOP]), np.ones((count, 1)))
    shape, more = line.free.shape, np.tile(0.2 * grid.stiffness[:, 0], (1, line.free.shape[2]))
    size, at = more.shape[-1], line.receptance
    each = (v[:, own] for v, own in ((at.tied, at.tied_of), (at.alone, at.alone_of)))
    each = (v.reshape(-1, *v.shape[2:]) for v in each)
    moves = moved_by(*each, np.tile(np.eye(size), (shape[0] * count, 1, 1)))
    matrix = np.eye(size) + moves.reshape(*shape[:2], size, size) * more[:, None, :]
    moved = np.linalg.solve(matrix, line.free.reshape(*shape[:2], -1, 1)).reshape(shape)
    expected = rubber_at_stop._Grid.of(mounts, grid.sweeps, mounts.mounted_line).travel(of, none)
    size = np.abs(expected).max(axis=(2, 3))
    assert (np.abs(moved - expected).max(axis=(2, 3)) / size).max() < 0.05
    assert (np.abs(line.free - expected).max(axis=(2, 3)) / size).max() > 1


def test_range_of_stiffness_is_solved_where_linear_rubber_has_the_largest_force(medium):
    """No file gives the ratio: 20 in every state, 5 in the one with the largest peak force."""
    solved, linear = medium.mount_loads.stop_response, medium.mount_loads.refined_forces
    assert solved.ratios[:, 0].tolist() == [5.0, 20.0]
    soft, stiff = (np.isfinite(f[:, 0]) for f in solved.forces["peak"])
    met = np.where(stiff, np.nan_to_num(linear.results.peak[..., 0].max(axis=0)), 0.0)
    assert soft.sum() == 1
    assert soft[met.argmax()]
    assert stiff.sum() > 1
    assert solved.is_solved[stiff].all()  # followed far enough beyond linear rubber's crests

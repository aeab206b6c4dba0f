"""METHOD 16's launches from application files, and an integration of one that knows no `cardan`.

METHOD names some numbers of its two trucks and not others: the ramp's form, whether the driving
axle gains load as it pulls, and of the 6x4 its engine, its gear and its mass are not there. What
follows from what is there is asserted; a clutch whose torque rises straight and wheels that hold
what they hold standing give METHOD's numbers of the 4x2.
"""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from case_selection import select
from scipy.integrate import solve_ivp

from cardan.application import reader
from cardan.core.provenance import Source
from cardan.core.verdict import Limit
from cardan.model.powertrain import Launch
from cardan.physics.dynamics.launch import spring_parallel_damping_matrix
from cardan.physics.dynamics.torsional_network import torsional_modes
from cardan.physics.vehicle.state_demand import line_state_demand
from cardan.topics.torsion.launch_study import GearLosses, simulate_launch
from cardan.topics.torsion.powertrain_model import vehicle_torsion_model
from cardan.topics.torsion.vibration_checks import check_limit

TRUCK = Path(__file__).with_name("launch_4x2.yaml")
EXAMPLES = Path(__file__).parents[2] / "examples"


def started(app):
    parts = vehicle_torsion_model(app)
    asked = tuple(line_state_demand(x) for x in parts.lines)
    return parts, asked, [simulate_launch(parts, asked, w) for w in app.launches]


@pytest.fixture(scope="module")
def method():
    return started(reader.read(TRUCK))


@pytest.mark.slow
def test_launch_of_4x2_matches_method_16(method):
    """0.97 of T i by half a second, 1.08 by a dropped clutch, 1.43 if its tyres could not slide.

    Within 1.5 %: its inertias and its damping are not stated. It reverses, by some 3 % of T i
    (METHOD: -107 N.m, 1.7 %); joints add less than 0.25 % (METHOD: 0.2).
    """
    parts, _, (smooth, dropped) = method
    T = 956 * 6.70
    assert smooth.torque == pytest.approx(T)
    assert smooth.shares["ramp"] == pytest.approx(0.97, rel=0.015)
    assert dropped.shares["ramp"] == pytest.approx(1.08, rel=0.015)
    assert dropped.shares["if tyres could not slide"] == pytest.approx(1.43, rel=0.005)
    assert dropped.tyres_slid
    assert -0.05 * T < smooth.lowest_torque[smooth.first_shaft] < 0
    for begun in (smooth, dropped):
        assert abs(begun.shares["joints"]) < 2.5e-3
    # Mode 1 in first gear, closed and slipping, where METHOD has 26 rpm and up to 106.
    first = torsional_modes(parts.closed.line).frequency[0, 0, 1] / (2 * np.pi)
    slipping = torsional_modes(parts.slipping.line).frequency[0, 0, 1] / (2 * np.pi)
    assert 60 * first / 2 == pytest.approx(26, rel=0.04)
    assert 60 * slipping / 2 == pytest.approx(106, rel=0.01)


@pytest.mark.slow
def test_lowest_torque_of_launch_is_a_range_that_holds_published_integrations(method):
    """METHOD 16: +27, -107 and -170 N.m with 7600, 7700 and 7800 kg, 1.3 % of grip apart.

    They are of a truck whose inertias METHOD does not state, so that not the lowest torque but
    its range has to hold them, and the verdict says that it may be the other one.
    """
    parts, _, (smooth, _) = method
    low, high = smooth.lowest_range[:, smooth.first_shaft]
    assert low < -170
    assert high > 27
    assert low <= smooth.lowest_torque[smooth.first_shaft] <= high
    assert [a.name for a in smooth.assumed] == ["tyre.friction", "rolling resistance"]
    assert (smooth.assumed[0].low, smooth.assumed[0].high) == pytest.approx((0.76, 0.84))
    app = parts.application
    assert app.is_given("tyre.friction")
    limit = Limit(quantity="launch_reversal", normal=0.0, source=Source("Here"))
    of = SimpleNamespace(
        application=app, launches=[smooth], failed_launches=(),
        lines=[SimpleNamespace(line=app.lines[0].line)],
    )  # fmt: skip
    ((check,), _) = check_limit(of, limit)
    assert (check.grade, check.best_possible_grade) == ("warn", "pass")


@pytest.mark.slow
def test_order_2_torque_differs_between_shafts_and_is_small(method):
    """METHOD: 7.5 and 20 N.m in the two shafts; of angles that it does not state."""
    _, _, (smooth, _) = method
    shafts = [k for k, (_, p) in enumerate(smooth.springs) if p.kind == "shaft"]
    one, other = (float(np.nanmax(smooth.order2_amplitude[k])) for k in shafts)
    assert 3 < min(one, other) < max(one, other) < 40
    assert one != pytest.approx(other, rel=0.01)


@pytest.mark.slow
def test_launch_peak_of_6x4_depends_on_engine_inertia():
    """METHOD: 0.84, dropped 1.14, 1.43 stuck, of an engine and a gear that it does not state.

    Once clutch and engine turn as one, T i is shared: the vehicle gets m r² of m r² + J_e i². In
    a crawler that is a fifth, so half a second gives far less than T i; in a gear of half its
    ratio, a half, and METHOD's order of numbers. Between them lies 0.84.
    """
    app = reader.read(EXAMPLES / "tandem-6x4.yaml")
    parts = vehicle_torsion_model(app)
    asked = tuple(line_state_demand(x) for x in parts.lines)
    peaks = {}
    for gear in ("1", "3"):
        for ramp, capacity in ((0.5, 1.0), (0.05, 1.8)):
            found = simulate_launch(parts, asked, Launch(gear=gear, ramp=ramp, capacity=capacity))
            peaks[gear, ramp] = found.shares["ramp"]
            assert abs(found.shares["joints"]) < 4e-3
    assert peaks["1", 0.5] < 0.84 < peaks["3", 0.5] * 1.2
    assert peaks["1", 0.05] < 1.14 < peaks["3", 0.05] * 1.2
    assert all(peaks[g, 0.05] > 1.15 * peaks[g, 0.5] for g in ("1", "3"))


# ----- the same, written down once more ----------------------------------------------------------


class Truck:
    """The 4x2's parts as its file has them, with gears that lose; events change its equations.

    Engine and clutch at the engine's own speed, the axle at the wheels'. Freedoms: engine,
    disc, gearbox input (all i times slower here, so that they compare), joints 1 to 3, pinion,
    housing, wheels, vehicle. Friction is rigid: engine and disc slip or turn as one.
    """

    E, D, IN, J1, J2, J3, P, H, W, V = range(10)

    def __init__(self, *, ramp, capacity, gearbox=1.0, axle=1.0, damping, slides=True, leads=0.0,
                 windup=12e3 * 180 / np.pi):  # fmt: skip
        i, self.iD, self.r = 6.70, 4.18, 0.4209
        self.i, self.ramp, self.capacity, self.T = i, ramp, capacity, 956.0
        self.eta, self.axle, self.C, self.slides = gearbox, axle, damping, slides
        G, polar = 210e9 / 2.6, np.pi / 32 * (0.1**4 - 0.094**4)
        length = np.array([0.75, 0.95])
        tube, self.shafts = 7850 * polar * length, G * polar / length
        J = np.zeros(10)
        J[self.E], J[self.D], J[self.IN] = 3.5 * i**2, 0.04 * i**2, 0.06 * i**2
        J[self.J1], J[self.J2], J[self.J3] = 0.05, 0.014 + tube[0] / 2, 0.012 + tube[1] / 2
        J[self.P], J[self.H], J[self.W] = 0.02, 18.0, 4 * 6.5 + 2 * 1.5
        J[self.V] = 11990 * self.r**2 + 2 * 6.5
        self.J, self.ring = J, 0.25
        self.behind = np.array([0.012 + tube[0] / 2, 0.012 + tube[1] / 2, 0.015])
        self.clutch, self.box, self.pinion = 12000 * i**2, 150e3, 120e3
        self.half = 4 / (1 / 25.4e3 + 1 / 22.6e3)
        self.windup = windup
        self.tyre, self.sigma = 4 * 743e3 * self.r**2, 283 / 743
        self.grip = 0.8 * 7800 * 9.80665 * self.r
        self.road = 0.008 * 11990 * 9.80665 * self.r
        self.leads = leads * np.tan(np.radians([3.5, 1.0, 1.0]) / 2) ** 2 * np.array([1, -1, 1])

    def joints(self, u):
        X = self.leads * np.exp(2j * u)
        gain = (1 - self.leads**2) / np.abs(1 - X) ** 2
        lead = -np.angle(1 - X) + np.angle(1 - self.leads + 0j)
        return lead, gain, -gain * 4 * X.imag / np.abs(1 - X) ** 2

    def torques(self, q):
        lead, gain, bend = self.joints(q[self.J1 : self.P])
        turned = q[self.J1 : self.P] + lead
        return {
            "clutch": self.clutch * (q[self.D] - q[self.IN]),
            "box": self.box * (q[self.IN] - q[self.J1]),
            "shafts": self.shafts * (turned[:2] - q[self.J2 : self.P]),
            "pinion": self.pinion * (turned[2] - q[self.P]),
            "half": self.half * (q[self.P] / self.iD + q[self.H] - q[self.W]),
        }, gain, bend  # fmt: skip

    def rates(self, t, y, slips, slide, rolls):
        """y: q, q', and the tyre's torque; `slips`, `slide`, `rolls` say which way."""
        q, v, tread = y[:10], y[10:20], y[20]
        now, gain, bend = self.torques(q)
        rise = min(t / self.ramp, 1.0)
        f = -self.C @ v
        f[self.E] += min(self.capacity * rise, 1.0) * self.T * self.i
        f[self.D] -= now["clutch"]
        f[self.IN] += now["clutch"] - now["box"] / self.eta
        f[self.J1] += now["box"] - gain[0] * now["shafts"][0]
        f[self.J2] += now["shafts"][0] - gain[1] * now["shafts"][1]
        f[self.J3] += now["shafts"][1] - gain[2] * now["pinion"]
        joints = slice(self.J1, self.P)
        f[joints] -= self.behind * gain * bend * v[joints] ** 2
        f[self.P] += now["pinion"] - now["half"] / self.iD / self.axle
        f[self.H] -= now["half"] + self.windup * q[self.H]
        f[self.W] += now["half"] - tread
        f[self.V] += tread
        M = np.diag(self.J)
        M[joints, joints] += np.diag(self.behind * gain**2)
        # The ring turns by both; its gears lose what they pass to the pinion.
        M[self.P, self.P] += self.ring / self.iD**2 / self.axle
        M[self.P, self.H] += self.ring / self.iD / self.axle
        M[self.H, self.P] += self.ring / self.iD
        M[self.H, self.H] += self.ring
        carries = self.capacity * rise * self.T * self.i
        if slips:
            f[self.E] -= slips * carries
            f[self.D] += slips * carries
            a = np.linalg.solve(M, f) if rolls else self.stands(M, f)
        else:
            a = self.as_one(M, f, rolls)
        if rolls:
            a[self.V] -= np.sign(rolls) * self.road / self.J[self.V]
        spread = v[self.W] - v[self.V]
        fades = abs(v[self.V]) * self.r / self.sigma * tread
        return np.concatenate([v, a, [0.0 if slide else self.tyre * spread - fades]])

    def stands(self, M, f):
        a = np.zeros(10)
        a[: self.V] = np.linalg.solve(M[: self.V, : self.V], f[: self.V])
        return a

    def as_one(self, M, f, rolls):
        """Engine and disc together; the vehicle held by the road where it does not roll."""
        B = np.delete(np.eye(10), self.D, axis=1)
        B[self.D, self.E] = 1.0
        if not rolls:
            B = B[:, :-1]
        return B @ np.linalg.solve(B.T @ M @ B, B.T @ f)

    def margins(self, t, y, how):
        """What is left until engine and disc lock or slip, the tyres slide or hold, all rolls."""
        slips, slide, rolls = how
        rise = min(t / self.ramp, 1.0)
        given = min(self.capacity * rise, 1.0) * self.T * self.i
        a = self.rates(t, y, *how)[10 + self.E]
        passed = given - self.C[self.E] @ y[10:20] - self.J[self.E] * a
        return {
            "locks": y[10] - y[11] if slips else 1.0,
            "slips": 1.0 if slips else self.capacity * rise * self.T * self.i - abs(passed),
            "slides": self.grip - abs(y[20]) if self.slides and not slide else 1.0,
            "holds": slide * (y[10 + self.W] - y[10 + self.V]) if slide else 1.0,
            "rolls": 1.0 if rolls else self.road - abs(y[20]),
        }, passed  # fmt: skip

    def run(self, duration):
        y = np.zeros(21)
        y[10] = 1000 * np.pi / 30 / self.i
        t, slips, slide, rolls = 0.0, 1, 0, 0
        times, states = [], []
        events = {
            name: lambda t, y, *how, name=name: self.margins(t, y, how)[0][name]
            for name in ("locks", "slips", "slides", "holds", "rolls")
        }
        for event in events.values():
            event.terminal, event.direction = True, -1
        while t < duration:
            how = (slips, slide, rolls)
            # The ramp's corner is an end of its own, so that no step strides over it.
            until = min(self.ramp, duration) if t < self.ramp else duration
            done = solve_ivp(self.rates, (t, until), y, args=how, events=list(events.values()),
                             method="DOP853", rtol=1e-7, atol=1e-9, dense_output=True)  # fmt: skip
            at = np.arange(np.ceil(t * 2000), done.t[-1] * 2000) / 2000
            if at.size:
                times.append(at)
                states.append(done.sol(at))
            t, y = float(done.t[-1]), done.y[:, -1].copy()
            if done.status == 0:
                t = until
                continue
            (what,) = (n for n, e in zip(events, done.t_events, strict=True) if e.size)
            match what:
                case "locks":
                    slips = 0
                    y[10] = y[11] = (y[10] + y[11]) / 2
                case "slips":
                    slips = int(np.sign(self.margins(t, y, how)[1]))
                case "slides":
                    slide = int(np.sign(y[20]))
                case "holds":
                    slide = 0
                case "rolls":
                    rolls = 1
        self.time, y = np.concatenate(times), np.hstack(states)
        return np.array([self.torques(q)[0]["shafts"][0] for q in y[:10].T])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("launch", "loses", "stuck"),
    select(
        [(0, False, False), (1, False, False), (1, False, True), (1, True, False)], (1, False, True)
    ),
)
def test_launch_matches_independent_integration(launch, loses, stuck):
    """Events, rigid friction, gears that pass on a share: peak, and the whole course of torque.

    A thousandth of the peak is what a clutch's elastic grip, 50 times its damper, adds; of the
    course after a dropped clutch, whose tyres slide some milliseconds longer or less, ten.
    """
    app = reader.read(TRUCK)
    share = 0.95 if loses else 1.0
    axle = replace(app.lines[0].axle, efficiency=share)
    app = replace(
        app, gearbox=replace(app.gearbox, efficiency=share),
        lines=(replace(app.lines[0], axle=axle),), launches=(app.launches[launch],),
    )  # fmt: skip
    parts, _, (mine,) = started(app)
    one = (
        GearLosses.from_powertrain(parts, parts.closed)
        .apply_to(parts.closed.line.select_case([0], [0]))
        .select_case(0)
    )
    names = [p.kind for _, p in parts.closed.springs]
    damping = spring_parallel_damping_matrix(
        one, torsional_modes(one), slide=[names.index("clutch disc"), names.index("tyres")]
    )
    counts = np.array([0.95, 1, 1 / 0.95])[[0, 0, 0, 1, 1, 1, 1, 2, 2, 2]] if loses else 1.0
    wanted = app.launches[0]
    truck = Truck(
        ramp=wanted.ramp, capacity=wanted.capacity, gearbox=share, axle=share,
        damping=damping / np.reshape(counts, (-1, 1)), slides=not stuck,
    )  # fmt: skip
    duration = 0.9
    torque = truck.run(duration)
    case = 4 if stuck else 3  # tyres that stick have joints and firing: a half per cent
    course = mine.history.torque[case, :, mine.first_shaft]
    within = mine.history.time < duration
    off = 6e-3 if stuck else 1.5e-3
    assert course[within].max() == pytest.approx(torque.max(), rel=off)
    assert torque.max() > (1.05 if launch else 0.95) * mine.torque
    theirs = np.interp(mine.history.time[within], truck.time, torque)
    assert np.abs(course[within] - theirs).max() < (1.5e-2 if launch else 6e-3) * torque.max()


@pytest.mark.slow
def test_joint_torque_in_launch_matches_independent_integration():
    """While the clutch slips, to a hundredth of what they add; an axle that does not pitch.

    From lock-up on a rigid friction and one with a grip lose each other's phase.
    """
    app = reader.read(TRUCK)
    app = replace(
        app, suspension=replace(app.suspension, windup_stiffness=1e9), launches=app.launches[:1]
    )
    parts, _, (mine,) = started(app)
    one = parts.closed.line.select_case([0], [0]).select_case(0)
    names = [p.kind for _, p in parts.closed.springs]
    damping = spring_parallel_damping_matrix(
        one, torsional_modes(one), slide=[names.index("clutch disc"), names.index("tyres")]
    )
    bent, straight = (
        Truck(ramp=0.5, capacity=1.0, damping=damping, leads=leads, windup=1e9)
        for leads in (-1.0, 0.0)  # the first pin stands normal to the shafts' plane
    )
    duration = 0.36
    theirs = bent.run(duration) - straight.run(duration)
    k = mine.first_shaft
    added = mine.history.torque[2, :, k] - mine.history.torque[3, :, k]
    within = mine.history.time < duration
    assert mine.lockup_time > duration
    off = np.abs(added[within] - np.interp(mine.history.time[within], bent.time, theirs)).max()
    assert np.abs(theirs).max() > 1e-3 * mine.torque
    assert off < np.abs(theirs).max() / 100

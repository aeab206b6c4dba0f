"""Whole drives stepped through time, whose truth is a second run without the joints' swing.

Nothing of the program and nothing of `adversarial` is in here. An engine, a clutch, a gearbox
and a truck on an elastic driveline follow a driver over a road; wheels and body follow the
road's profile; the crosses of three joints hand the torque on by their pins, so that the
bearing's force has whatever orders it has; the line hangs in rubber with a stop, the rubber in
a bracket of some modes. Gauges and a bus write down what they can. For the truth bracket and
rubber are stepped again with the same road and engine, and of the joints only what their
force is in the mean of a turn.
"""

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from scipy.signal import firwin, lfilter

FINE = 2000.0
RATIOS = ((7.05, 4.13, 2.52, 1.59, 1.0, 0.78), (5.9, 3.4, 2.0, 1.33, 1.0), (3.5, 1.9, 1.2, 1.0))
AXLE, TYRE = 3.91, 0.49  # 1, m


@dataclass
class Drive:
    """A recording as a user would have it, and the truth of each gauge."""

    rate: float
    names: list[str]
    units: list[str]
    data: np.ndarray  # (channels, n), nan where nothing was written
    stress: np.ndarray  # (gauges, n) MPa, as it was
    without: np.ndarray  # (gauges, n) MPa, had the joints not swung
    orders: str  # of the engine, "" where nobody says
    about: dict = field(default_factory=dict)


# ---------------------------------------------------------------------------- truck and driver


@njit(cache=True)
def _driven(target, grade, ratios, direct, mass, inertia, full, cylinders, ripple, hurry, dt):
    """Speeds (rad/s) of shaft and engine, shaft torque, way, gear: clutch, shifts, shuffle."""
    n = target.size
    shaft, motor, torque = np.zeros(n), np.zeros(n), np.zeros(n)
    way, gears = np.zeros(n), np.zeros(n)
    stiff, loss = 9000.0, 60.0
    body = mass * (TYRE / AXLE) ** 2
    top = ratios.size - 1
    g = direct
    wg = wv = target[0] / TYRE * AXLE
    while g < top and wg * ratios[g] > 170:
        g += 1
    we = max(wg * ratios[g], 70.0)
    locked = wg * ratios[g] > 75.0
    twist = made = fired = x = 0.0
    since, shifting, letting, grip, after = 9.0, 0.0, 0.0, 0.0, g
    hard = 0.6 + 1.2 * (1 - hurry)
    for k in range(n):
        i = ratios[g]
        v = wv / AXLE * TYRE
        want = target[k] - v
        drag = mass * 9.81 * (0.007 * (v > 0.01) + grade[k]) + 3.2 * v * v
        pull = mass * min(max(0.8 * want, -2.0), hard) + drag
        pedal = pull * TYRE / AXLE / i / full
        brake = max(-pull / mass - 0.4, 0.0) if target[k] > 0.2 else 3.0
        since += dt
        if letting > 0:  # first the engine lets go
            letting -= dt
            asked = 0.0
            if letting <= 0 or abs(twist) * stiff < 150:
                letting, shifting = 0.0, 0.3 + 0.4 * hurry
        elif shifting > 0:  # the clutch is open, the engine goes to its next speed
            shifting -= dt
            asked, locked, grip = 0.0, False, 0.0
            we += dt / 0.12 * (max(wg * ratios[after], 65.0) - we)
            if shifting <= 0:
                g, since = after, 0.0
        elif locked:
            asked = min(max(pedal, 0.0), 1.0) * full
            if g < top and direct < top and we > 190 - 40 * (1 - min(pedal, 1.0)) and since > 1.2:
                after, letting = g + 1, 0.02 if hurry > 0.8 else 0.5
            elif g > 0 and direct < top and we < 80 and since > 1.2 and target[k] > 0.2:
                after, letting = g - 1, 0.02 if hurry > 0.8 else 0.5
            elif we < 62:
                locked, grip, since = False, 0.0, 0.0
                while g > 0 and wg * ratios[g - 1] < 130:
                    g -= 1
        elif target[k] > 0.2:  # the clutch comes in
            grip = min(grip + full * dt / (0.15 + 1.6 * hurry) * 2, 2.2 * full)
            asked = max(min(0.2 + pedal, 0.8), 0.0) * full
        else:
            grip, asked = 0.0, 0.0
        idle = 8.0 * (68.0 - we) if we < 68 else 0.0
        asked *= min(max((275.0 - we) / 15, 0.0), 1.0)
        made += dt / 0.12 * (asked - made)
        fired += we * dt
        push = made + idle - 0.4 * we * (made < 0.1 * full)
        push += ripple * (0.15 * full + abs(made)) * np.cos(cylinders / 2 * fired)
        t = stiff * twist + loss * (wg - wv)
        light = 0.5 + 0.08 * i * i
        if locked:
            wg += dt * (i * push - t) / (inertia * i * i + light)
            we = i * wg
        else:
            slip = we - i * wg
            held = grip * np.sign(slip)
            we = max(we + dt * (push - held) / inertia, 20.0)
            wg += dt * (i * held - t - 0.02 * stiff * dt * wg) / light
            if grip > 0 and slip * (we - i * wg) <= 0 and shifting <= 0:
                locked = True
        twist += dt * (wg - wv)
        stop = min(brake, 4.0) * mass * (v > 0)
        wv += dt * (t - (drag + stop) * TYRE / AXLE) / body
        if wv < 0:
            wv = 0.0
        x += wv / AXLE * TYRE * dt
        shaft[k], motor[k], torque[k], way[k], gears[k] = wg, we, t, x, i
    return shaft, motor, torque, way, gears


def _targets(rng, kind, t, ratio):
    """What the driver wants, m/s."""
    n, seconds = t.size, t[-1]
    if kind == "run-ups":
        low, high = 100 * TYRE / AXLE / ratio, 230 * TYRE / AXLE / ratio
        x = low + (high - low) * (0.5 - 0.5 * np.cos(2 * np.pi * t / rng.uniform(25, 60)))
    elif kind == "crawl":
        x = rng.uniform(95, 180) * TYRE / AXLE / ratio + 0.15 * np.sin(
            2 * np.pi * t / rng.uniform(9, 30)
        )
    elif kind == "cruise":
        x = rng.uniform(120, 220) * TYRE / AXLE / ratio + rng.uniform(0, 1.5) * np.sin(
            2 * np.pi * t / rng.uniform(20, 50)
        )
    elif kind == "highway":
        x = rng.uniform(150, 190) * TYRE / AXLE / ratio + rng.uniform(1, 3) * np.sin(
            2 * np.pi * t / rng.uniform(30, 80)
        )
    else:
        x, k = np.zeros(n), 0
        stops = kind == "town"
        while k < n:
            hold = int(rng.uniform(6, 18) * FINE)
            x[k : k + hold] = rng.uniform(4, 20)
            k += hold
            if stops and rng.uniform() < 0.5:
                x[k : k + int(3 * FINE)] = 0.0
                k += int(rng.uniform(3, 6) * FINE)
    width = int(1.5 * FINE)
    smooth = np.convolve(np.pad(x, width, mode="edge"), np.ones(width) / width, "same")
    return np.where(x == 0, 0.0, smooth[width:-width]), seconds


# ---------------------------------------------------------------------------- road and wheels


def _profile(rng, way, rough):
    """Height of the road under the wheel over time, with what lies on it."""
    step = 0.05
    length = way[-1] + 20
    m = int(length / step) + 8
    white = rng.normal(size=m)
    z = lfilter([1.0], [1, -np.exp(-2 * np.pi * 0.005 * step)], white)
    z *= rough * 2 * np.pi * 0.1 * np.sqrt(step) * 4e-3 * 5
    s = np.arange(m) * step
    for at in rng.uniform(5, length, rng.poisson(length / 400)):
        size, half = rng.uniform(0.015, 0.06) * rng.choice([-1, 1]), rng.uniform(0.2, 0.7)
        near = np.abs(s - at) < half
        z[near] += size * np.cos(np.pi * (s[near] - at) / 2 / half)
    if rng.uniform() < 0.2:  # a washboard turns with the wheels
        at, wave = rng.uniform(0, length), rng.uniform(0.25, 1.2)
        near = (s > at) & (s < at + rng.uniform(30, 120))
        z[near] += rng.uniform(1e-3, 5e-3) * np.sin(2 * np.pi * s[near] / wave)
    held = int(0.2 / step)  # what a tyre stands on
    z = np.convolve(z, np.ones(held) / held, "same")
    return np.interp(way, s, z)


@njit(cache=True)
def _shaken(z, shake, frame, dt):
    """Body and wheel on a road: travel m, acceleration of the frame where the bracket hangs."""
    n = z.size
    travel, out = np.zeros(n), np.zeros(n)
    ks, cs, kt, ct, m, u = 420e3, 16e3, 2.2e6, 3e3, 4500.0, 480.0
    xb = vb = xw = vw = q = p = 0.0
    w, d = 2 * np.pi * frame, 0.04
    old = z[0]
    xw = xb = z[0]
    for k in range(n):
        spring = ks * (xw - xb) + cs * (vw - vb)
        ab = spring / m
        aw = (kt * (z[k] - xw) + ct * ((z[k] - old) / dt - vw) - spring + shake[k]) / u
        old = z[k]
        vb += dt * ab
        vw += dt * aw
        xb += dt * vb
        xw += dt * vw
        p += dt * (spring / m - 2 * d * w * p - w * w * q)
        q += dt * p
        travel[k] = xw - xb
        out[k] = ab + 0.5 * w * w * q + 0.12 * aw
    return travel, out


# ---------------------------------------------------------------------------- joints


def _unit(a):
    return a / np.linalg.norm(a, axis=-1, keepdims=True)


def _slope(down, right):
    one = np.ones_like(down)
    return _unit(np.stack([one, np.tan(right) * one, -np.tan(down)], -1))


def _around(a, d, angle):
    """Turn pins a (n, 3), square to d, about it."""
    return np.cos(angle) * a + np.sin(angle) * np.cross(d, a)


def _dot(a, b):
    return (a * b).sum(-1)


def _bearing(turned, torque, spin, line, travel):
    """Force (n, 2) of a line on its bearing, sideways and up: each cross hands a moment on.

    A moment that a cross passes is square to both of its pins, whatever else it does.
    """
    one = np.ones(travel.size)
    p1, p2 = np.array([0.0, 0.0, 0.0]), np.array([line["L1"], 0.0, -line["L1"] * line["down1"]])
    p3 = np.stack(
        [
            (line["L1"] + line["L2"]) * one, line["L2"] * line["right"] * one,
            p2[2] - line["L2"] * line["down2"] + travel,
        ],
        -1,
    )  # fmt: skip
    d0 = _slope(line["gearbox"] * one, 0 * one)
    d1 = _unit((p2 - p1) * one[:, None])
    d2 = _unit(p3 - p2)
    d3 = _slope(line["pinion"] * one + line["wind"] * torque / 1e4 + 0.25 * travel, 0 * one)
    up = np.array([0.0, 0.0, 1.0])
    e1 = _unit(np.cross(up, d0))
    pin = np.cos(turned)[:, None] * e1 + np.sin(turned)[:, None] * np.cross(d0, e1)
    moments, T = [], torque
    members = (d0, d1, d2, d3)
    for k in range(3):
        other = _unit(np.cross(members[k + 1], pin))
        axis = np.cross(pin, other)
        moment = axis * (T / _dot(axis, members[k]))[:, None]
        moments.append(moment)
        T = _dot(moment, members[k + 1])
        if spin is not None and k < 2:  # what the shaft takes to be hurried and held
            d = members[k + 1]
            e = _unit(np.cross(up, d))
            angle = np.unwrap(np.arctan2(_dot(other, np.cross(d, e)), _dot(other, e)))
            T = T - spin[k] * np.gradient(np.gradient(angle)) * FINE**2
        if k < 2:
            pin = _around(other, members[k + 1], line["phase"][k])
    m1, m2, m3 = moments
    f2 = -np.cross(m2 - m3, d2) / line["L2"]
    force = -(np.cross(m1 - m2, d1) + line["L1"] * f2) / (line["L1"] - line["over"])
    return -force[:, 1:]


def _swing_and_mean(turned, torque, spin, line, travel):
    """Force on the bearing, and its mean over a turn at each moment, (n, 2) N each."""
    some = slice(None, None, 40)
    unit = np.full(travel[some].size, 1.0)
    # The pinion follows the torque; its mean force is in proportion to it besides.
    held = np.where(np.abs(torque[some]) > 1.0, torque[some], unit)
    phases = [
        _bearing(2 * np.pi * (k + 0.3) / 12 * unit, held, None, line, travel[some])
        for k in range(12)
    ]
    share = np.mean(phases, axis=0) / held[:, None]
    at, mine = np.arange(travel.size), np.arange(travel.size)[some]
    mean = np.stack([np.interp(at, mine, share[:, k]) * torque for k in (0, 1)], -1)
    return _bearing(turned, torque, spin, line, travel), mean


# ---------------------------------------------------------------------------- bracket


@njit(cache=True)
def _hung(force, base, mass, rubber, gap, modes, dt):
    """Force of the rubber (n, 2) and the bracket's modes (n, modes): stepped, stop and all."""
    n = force.shape[0]
    count = modes.shape[0]
    out, swung = np.zeros((n, 2)), np.zeros((n, count))
    x, v = np.zeros(2), np.zeros(2)
    q, p = np.zeros(count), np.zeros(count)
    for k in range(n):
        for a in range(2):
            stiff, loss = rubber[a, 0], rubber[a, 1]
            f = stiff * x[a] + loss * v[a]
            if abs(x[a]) > gap:
                f += 9 * stiff * (abs(x[a]) - gap) * np.sign(x[a])
            own = force[k, a] - (mass * base[k] if a == 1 else 0.3 * mass * base[k])
            v[a] += dt * (own - f) / mass
            x[a] += dt * v[a]
            out[k, a] = f
        for m in range(count):
            w, d = modes[m, 0], modes[m, 1]
            drive = modes[m, 2] * out[k, 0] + modes[m, 3] * out[k, 1] - modes[m, 4] * base[k]
            p[m] += dt * (w * w * (drive - q[m]) - 2 * d * w * p[m])
            q[m] += dt * p[m]
            swung[k, m] = q[m]
    return out, swung


# ---------------------------------------------------------------------------- what is written


def _bus(x, rate, *, hertz, late, step=0.0):
    """What a bus says of x: old, held and in steps."""
    every = max(int(rate / hertz), 1)
    old = np.concatenate([np.full(int(late * rate), x[0]), x])[: x.size]
    held = old[(np.arange(x.size) // every) * every]
    return np.round(held / step) * step if step else held


def _holes(rng, n, rate, count, longest):
    out = np.zeros(n, bool)
    for at in rng.uniform(0, n, count):
        out[int(at) : int(at + rng.uniform(0.3, longest) * rate)] = True
    return out


KINDS = {"town": 0.3, "country": 0.2, "run-ups": 0.15, "highway": 0.15, "cruise": 0.1, "crawl": 0.1}
SPEEDS = {"fine": 0.3, "bus": 0.3, "gps": 0.2, "wheels": 0.2}


def _one_of(rng, of):
    return str(rng.choice(list(of), p=list(of.values())))


def drive(seed, *, seconds=None, **asked):
    """Make a recording; what is not asked is drawn by the seed."""
    rng = np.random.default_rng([seed, 97])
    seconds = seconds or float(rng.uniform(60, 120))
    dt, n = 1 / FINE, int(seconds * FINE)
    t = np.arange(n) / FINE
    kind = asked.get("kind", _one_of(rng, KINDS))
    ratios = np.array(RATIOS[rng.integers(len(RATIOS))])
    cylinders = int(asked.get("cylinders", rng.choice([4, 6, 6, 8])))
    last = ratios.size - 1
    gear = {"highway": int(np.argmin(np.abs(ratios - 1))), "crawl": 0}.get(kind, 0)
    if kind in ("run-ups", "cruise"):
        gear = last - int(rng.integers(2))
    fixed = kind in ("run-ups", "highway", "cruise")
    target, _ = _targets(rng, kind, t, ratios[gear])
    crests = np.arange(0, seconds + 12, 12)
    hills = np.interp(t, crests, rng.normal(0, 0.02, crests.size))
    own = ratios[gear : gear + 1] if fixed or kind == "crawl" else ratios
    shaft, motor, torque, way, ratio = _driven(
        target, hills, own, 0, rng.uniform(7e3, 24e3), rng.uniform(1.5, 4.0),
        rng.uniform(600, 1600), cylinders, rng.uniform(0, 0.5), float(rng.uniform()), dt,
    )  # fmt: skip
    turned, fired = np.cumsum(shaft) * dt + rng.uniform(0, 6), np.cumsum(motor) * dt
    rolled = turned / AXLE
    uneven = sum(rng.uniform(0, 400) * np.cos(k * rolled + rng.uniform(0, 6)) for k in (1, 2, 3, 6))
    speed = shaft / AXLE * TYRE
    z = _profile(rng, way, asked.get("rough", 0.6 * rng.lognormal(0, 0.8)))
    travel, base = _shaken(z, uneven * np.minimum(speed / 15, 2) ** 2, rng.uniform(6, 14), dt)
    load = np.abs(torque / ratio)
    mount = rng.uniform(0, 0.8) * asked.get("engine", 1.0)
    base = base + mount * (0.2 + load / 800) * np.cos(cylinders / 2 * fired + 1)
    if cylinders == 4:  # its pistons swing twice a turn
        base = base + asked.get("engine", 1.0) * rng.uniform(0, 2) * (motor / 200) ** 2 * np.cos(
            2 * fired
        )
    if rng.uniform() < 0.15:  # a pump, a compressor
        base = base + rng.uniform(0, 1.5) * np.cos(2 * np.pi * rng.uniform(12, 60) * t)
    bent = asked.get("bent", float(rng.choice([0.0, 0.4, 1.2, 2.4], p=[0.3, 0.15, 0.25, 0.3])))
    rad = np.radians
    line = {
        "L1": rng.uniform(0.8, 1.5), "L2": rng.uniform(1.1, 1.9), "over": rng.uniform(0.08, 0.3),
        "down1": bent * rad(rng.uniform(-4, 4)), "down2": bent * rad(rng.uniform(-5, 5)),
        "right": bent * rad(rng.uniform(-3, 3)), "gearbox": bent * rad(rng.uniform(-4, 4)),
        "pinion": bent * rad(rng.uniform(-4, 4)), "wind": (bent > 0) * rad(rng.uniform(0, 2)),
        "phase": (rad(rng.choice([0, 90]) + rng.normal(0, 3)), rad(rng.normal(0, 3))),
    }  # fmt: skip
    spin = (rng.uniform(0.02, 0.08), rng.uniform(0.02, 0.08))
    moves = travel if bent > 0 else np.zeros_like(travel)
    swing, mean = _swing_and_mean(turned, torque, spin, line, moves)
    if bent == 0:
        swing = mean = np.zeros_like(swing)
    heavy = rng.uniform(0, 3e-3) * asked.get("unbalance", 1.0)
    spun = heavy * (shaft**2)[:, None] * np.stack([np.cos(turned), np.sin(turned)], -1)
    mass = rng.uniform(12, 30)
    hung = 2 * np.pi * rng.uniform(14, 45, 2)
    rubber = np.stack([mass * hung**2, 2 * rng.uniform(0.03, 0.12, 2) * mass * hung], -1)
    stop = rng.uniform() < 0.15
    stop = asked.get("stop", stop)
    count = int(rng.integers(2, 4))
    # A bracket is softer one way than another; its modes lie anywhere.
    modes = np.stack(
        [
            2 * np.pi * rng.uniform(18, 110, count), rng.uniform(0.006, 0.05, count),
            rng.uniform(-1, 1, count), rng.uniform(-1, 1, count), rng.uniform(0, 12, count),
        ],
        -1,
    )  # fmt: skip
    names = ["S1", "S2"]
    still = rng.uniform(-0.5, 0.5, (2, 2))
    shape = rng.uniform(-1, 1, (2, count))
    frame = rng.uniform(0, 0.1, 2)  # of a newton's stress a newton metre: the frame twists
    made = []
    reach = None
    for force in (swing, mean):
        felt, swung = _hung(force + spun, base, mass, rubber, 1.0, modes, dt)
        if stop:
            reach = reach or 0.5 * np.abs(felt).max() / rubber[:, 0].max()
            felt, swung = _hung(force + spun, base, mass, rubber, reach, modes, dt)
        made.append(still @ felt.T + shape @ swung.T + np.outer(frame, torque))
    rate = float(asked.get("rate", rng.choice([500.0, 500.0, 1000.0])))
    every = int(FINE / rate)
    low = firwin(161, 0.4 * rate, fs=FINE)

    def sampled(x):
        return lfilter(low, [1.0], np.pad(x, ((0, 0), (80, 80)), mode="edge"))[:, 160::every]

    stress, without = (sampled(x) for x in made)
    size = rng.uniform(50, 160) / np.abs(stress - stress.mean(-1, keepdims=True)).max(-1)
    stress, without = size[:, None] * stress, size[:, None] * without
    m = stress.shape[1]
    noise = rng.uniform(0.02, 0.5) * rng.normal(size=(2, m))
    stress, without = stress + noise, without + noise
    shaft, motor, torque, ratio = (x[::every][:m] for x in (shaft, motor, torque, ratio))
    # ---- gauges as written
    told = np.round(stress / 0.01) * 0.01
    fault = asked.get("gauge_fault", _one_of(
        rng, {"none": 0.55, "drift": 0.1, "clip": 0.08, "spikes": 0.09, "dropouts": 0.09,
              "sentinel": 0.09}
    ))  # fmt: skip
    clock = np.arange(m) / rate
    if fault == "drift":
        told += np.outer(rng.uniform(-15, 15, 2), clock / clock[-1])
    elif fault == "clip":
        top = rng.uniform(0.75, 0.97) * np.abs(told).max(-1, keepdims=True)
        told = np.clip(told, -top, top)
    elif fault == "spikes":
        told[:, rng.integers(0, m, 6)] += rng.choice([-1, 1], 6) * rng.uniform(200, 900, 6)
    elif fault == "dropouts":
        told[:, _holes(rng, m, rate, 3, 0.5)] = np.nan
    elif fault == "sentinel":
        for at in (0, *rng.integers(0, m, 3), m - 40):
            told[:, at : at + int(rng.integers(5, 60))] = -9999.0
    # ---- the speed as written, rpm
    rpm = shaft * 30 / np.pi
    source = asked.get("source", _one_of(rng, SPEEDS))
    scale = 1.0
    if source == "bus":
        rpm = _bus(
            rpm, rate, hertz=rng.choice([20, 50, 100]), late=rng.uniform(0, 0.15), step=0.125
        )
    elif source == "gps":
        scale = 1 + rng.normal(0, 0.015)
        seen = rpm * scale + rng.normal(0, 3, m) * (rpm > 20)
        rpm = _bus(seen, rate, hertz=rng.choice([1, 2, 5, 10]), late=rng.uniform(0.1, 1.0))
    elif source == "wheels":  # a tyre slips by what it pulls
        scale = 1 + rng.normal(0, 0.012)
        slip = rng.uniform(0, 0.02) * torque / 1e4
        rpm = _bus(rpm * scale * (1 - slip), rate, hertz=50, late=rng.uniform(0, 0.1), step=0.125)
    hole = asked.get(
        "speed_fault", _one_of(rng, {"none": 0.6, "missing": 0.15, "zero": 0.1, "error": 0.15})
    )
    if hole != "none":
        where = _holes(rng, m, rate, 3, 2.0)
        if hole == "error" and rng.uniform() < 0.5:
            where[: int(0.6 * rate)] = True
        rpm = np.where(where, {"missing": np.nan, "zero": 0.0, "error": 8191.875}[hole], rpm)
    names, units, rows = [*names, "speed"], ["MPa", "MPa", "rpm"], [*told, rpm]
    known = asked.get("engine_known", rng.uniform() < 0.7)
    if known:
        names, units = [*names, "engine"], [*units, "rpm"]
        rows.append(_bus(motor * 30 / np.pi, rate, hertz=50, late=rng.uniform(0, 0.08), step=0.125))
    sort = asked.get("torque", _one_of(rng, {"shaft": 0.55, "bus": 0.3, "none": 0.15}))
    if sort != "none":
        heard = torque
        if sort == "bus":  # what the engine says it makes, through the gear
            slow = lfilter([0.02], [1, -0.98], torque)
            heard = _bus(rng.normal(1, 0.08) * slow, rate, hertz=20, late=0.05, step=50.0)
        names, units, rows = [*names, "torque"], [*units, "Nm"], [*rows, heard]
    said = rng.uniform() < 0.5
    return Drive(
        rate=rate, names=names, units=units, data=np.stack(rows), stress=stress, without=without,
        orders=f"{cylinders / 2:g},{cylinders:g}" if said else "",
        about={
            "seed": seed, "kind": kind, "source": source, "scale": round(scale, 4), "hole": hole,
            "gauge": fault, "torque": sort, "engine": bool(known), "cylinders": cylinders,
            "bent": bent, "stop": bool(stop), "rate": rate,
            "modes": [(round(w / 2 / np.pi, 1), round(d, 3)) for w, d in modes[:, :2]],
            "hung": np.round(hung / 2 / np.pi, 1).tolist(),
        },
    )  # fmt: skip

"""A day of a refuse collector, driven in a multibody engine (EXUDYN), and the truth about it.

Who broke the bracket of the second centre bearing? Here it is known. The line of
`examples/refuse-collector/application.yaml` is driven on rubber 15 % softer than drawn, with one
weld 4 degrees off and a shaft unbalanced, on tubes that twist, in a bracket whose stresses CalculiX
gives (`collector_bracket.py`). Road, blows and engine shake the same bracket. Then the day is
driven again with a straight line, whose joints shake nothing, and with a line that was cured. The
recordings have the faults of real ones.

Nothing of the program's physics is in here but the places of the joints and the parts' masses:
bodies, cycles and damage are made by another hand.

    PYTHONPATH=src python tests/verify/collector_day.py joints examples/refuse-collector
"""

import json
import sys
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from adversarial import colour, smooth
from driven_engine import Driven, Driving, Mount, twisting
from test_rubber_engine import rigid

from cardan.application import reader
from cardan.checks.line_response import compute_line_response
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references

HERE = Path(__file__).parent
FOLDER = HERE.parents[1] / "examples" / "refuse-collector"
rpm = np.pi / 30
STEP, RATE = 5e-4, 1000
SOFT = 0.85
"""Stiffness of the true rubber over that of the drawing."""
DRAWN = 200e3, 120e3
"""N/m, vertical and lateral, of the rubber alone as drawn: the bracket is not in it."""
LOSS, MODES = 0.1, (2 * np.pi * 10.5, 2 * np.pi * 7.0)
"""Loss factor of the rubber, and rad/s at which its dampers have it, up and sideways: those of
the line's modes. Rubber loses the same share at any frequency; a damper does so at one."""
FIRST = 4e6, 0.9e6
"""N/m, vertical and lateral, of the first bearing's bracket, which nobody looks at."""
MASS = 6.0
"""kg of a bearing's housing and what of its bracket swings with it."""
CROOKED = np.radians(4)
HEAVY = 3e-3
"""kg m, off the axis at the rear end of the second shaft."""
GEARS = {"R": 5.03, "1": 3.49, "2": 1.86, "3": 1.41, "4": 1.00, "5": 0.75}
MODULUS = 210e9
KNEE, CYCLES, SLOPE = 169e6, 1e6, 5.0
"""What the sheet bears: Pa, cycles, slope, and below the knee 2 k - 1 (Haibach)."""
AT_GAUGE = 60e6
"""Pa at a gauge where it cracks beside it: the knee there."""


@dataclass(frozen=True)
class Leg:
    """Seconds, rpm at their end, N m meanwhile, gear, and how rough the road is."""

    seconds: float
    rpm: float
    torque: float
    gear: str = "1"
    rough: float = 1.0


def bin_to_bin() -> list[Leg]:
    """Launch in first, roll, brake, creep to the next bin."""
    return [Leg(6, 330, 3600), Leg(2, 300, 1200), Leg(4, 80, -500), Leg(2, 60, 300)]


def run() -> list[Leg]:
    """Return the run to the landfill: up through the gears, cruise, coast."""
    return [
        Leg(8, 480, 3400), Leg(1, 430, 0, "2"), Leg(8, 900, 2000, "2"), Leg(1, 860, 0, "3"),
        Leg(8, 1250, 1450, "3"), Leg(1, 1200, 0, "4"), Leg(12, 1800, 980, "4"),
        Leg(12, 1850, 500, "4"), Leg(10, 1100, -380, "4"), Leg(8, 500, -380, "4"),
        Leg(5, 80, -300, "4"),
    ]  # fmt: skip


def backwards() -> list[Leg]:
    """Stop, back up to the tip, stop."""
    return [Leg(2, 12, 0), Leg(2, -20, -300, "R"), Leg(5, -170, -2200, "R"),
            Leg(3, -20, 400, "R"), Leg(2, 30, 200)]  # fmt: skip


def landfill() -> list[Leg]:
    """Climb twice on a rough track."""
    up = [Leg(8, 400, 3650, rough=2.5), Leg(6, 60, -500, rough=2.5)]
    return [Leg(2, 60, 200), *up, *up]


def tracks() -> list[Leg]:
    """Drive gently on bad tracks, all day."""
    one = [Leg(8, 330, 1000, rough=6), Leg(12, 420, 700, rough=6), Leg(8, 120, -200, rough=6)]
    return [Leg(2, 60, 200), *one, *one, *one, Leg(4, 60, 100)]


def direct() -> list[Leg]:
    """Go up and down through the speeds in direct gear."""
    one = [Leg(18, 1900, 800, "4"), Leg(4, 1900, 500, "4"), Leg(16, 800, -380, "4")]
    return [Leg(2, 800, 300, "4"), *one, *one, Leg(4, 850, 300, "4")]


@dataclass(frozen=True, kw_only=True)
class Day:
    """What is driven, and what shakes the bracket beside the joints."""

    seed: int
    legs: tuple[Leg, ...]
    cylinders: int = 6
    engine: float = 30.0
    """N on the bracket at full torque, through the frame."""
    blows: int = 3
    """A minute: kerbs and potholes."""
    gauges: tuple[str, ...] = ("S1", "S2", "S3", "S4")
    faults: dict = field(default_factory=dict)


_JOINTS = (Leg(2, 60, 500), *(4 * bin_to_bin()), *run(), *backwards(), *landfill(),
           *(3 * bin_to_bin()))  # fmt: skip
DAYS = {
    "joints": Day(
        seed=1,
        legs=_JOINTS,
        faults={"S2": "spikes", "S3": "drift", "S4": "dropouts", "shaft_rpm": "missing"},
    ),
    "road": Day(seed=2, legs=tuple(tracks()), blows=12, gauges=("S1", "S3")),
    "engine": Day(seed=3, legs=tuple(direct()), cylinders=4, engine=250.0, gauges=("S1", "S3")),
}


@dataclass(frozen=True)
class Orders:
    """What the driver, the road and the engine do, at every step from 0."""

    time: np.ndarray
    speed: np.ndarray
    torque: np.ndarray
    engine: np.ndarray
    """rad/s."""
    road: np.ndarray
    """(n, 3) N on the second bracket, the engine's shaking with it."""


def orders(day: Day) -> Orders:
    """Return what happens on a day, whatever the line."""
    rng = np.random.default_rng(day.seed)
    legs = day.legs
    ends = np.cumsum([0] + [leg.seconds for leg in legs])
    time = np.arange(round(ends[-1] / STEP) + 1) * STEP
    speed = np.interp(time, ends, [legs[0].rpm] + [leg.rpm for leg in legs])
    speed = smooth(speed, 1600) * rpm
    shifts = np.repeat(ends, 2)[1:-1] + np.tile([0.15, -0.15], len(legs))

    def held(values: list[float]) -> np.ndarray:
        return smooth(np.interp(time, shifts, np.repeat(values, 2).astype(float)), 500)

    torque = held([leg.torque for leg in legs]) * np.clip(time / 0.3, 0, 1)
    torque *= 1 + 0.03 * colour(rng, time.size, 1 / STEP, low=0.05, high=2, slope=0.5)
    ratio = held([GEARS[leg.gear] for leg in legs])
    idle = np.where(torque > 100, 900, 650) * rpm
    engine = np.maximum(np.abs(speed) * ratio, smooth(idle, 800))
    rough = held([leg.rough for leg in legs]) * np.sqrt(0.05 + np.abs(speed) / (500 * rpm))
    road = np.zeros((time.size, 3))
    for axis, size in ((1, 60), (2, 150)):
        road[:, axis] = size * rough * colour(
            rng, time.size, 1 / STEP, low=1, high=90, slope=0.7
        )  # fmt: skip
    s = np.arange(0, 0.6, STEP)
    for at in np.sort(rng.uniform(2, ends[-1] - 2, round(day.blows * ends[-1] / 60))):
        k = int(at / STEP)
        ring = np.exp(-9 * s) * np.sin(2 * np.pi * rng.uniform(8, 20) * s)
        size = rng.lognormal(0, 0.35) * np.sqrt(rough[k]) * (abs(speed[k]) > 20 * rpm)
        road[k : k + s.size, 1:] += size * ring[:, None] * [rng.choice([-1, 1]) * 350, 1500]
    turns = np.cumsum(engine) * STEP
    share = 0.25 + np.abs(torque) * ratio.clip(max=1) / 1000 / ratio
    fires = day.engine * share * np.cos(day.cylinders / 2 * turns + 1.0)
    road[:, 1] += 0.5 * fires
    road[:, 2] += fires
    return Orders(time, speed, torque, engine, road)


def drive(
    day: Day, *, straight: bool = False, loss: float = LOSS, seconds: float | None = None,
    what: Orders | None = None,
) -> Driven:  # fmt: skip
    """Drive a day with the line as it is in gvw, with all its angles gone, or other rubber."""
    what = orders(day) if what is None else what
    n = what.time.size if seconds is None else int(seconds / STEP) + 1
    application = reader.read(FOLDER / "application.yaml")
    response = compute_line_response(
        application, line_state_demand(resolve_line_references(application, application.lines[0]))
    )
    of = response.demand.states.index("gvw")
    points, directions = response.layout.points[of], response.layout.directions[of]
    shafts = response.line.shafts
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=-1)
    if straight:
        ahead = directions[0]
        directions = np.tile(ahead, (len(directions), 1))
        points = points[0] + np.concatenate([[0], np.cumsum(lengths)])[:, None] * ahead
    phases = [s.phase for s in shafts]
    phases[1] += CROOKED
    table = json.loads((HERE / "collector_bracket.json").read_text())
    _, lateral, vertical = table["compliance_m_N"]
    soft = (SOFT * DRAWN[0], SOFT * DRAWN[1])
    brackets = FIRST, (1 / vertical, 1 / lateral)
    return Driving(
        points, directions, phases,
        [rigid(replace(s, length=length)) for s, length in zip(shafts, lengths, strict=True)],
        [s.centre_bearing.from_rear_joint for s in shafts if s.centre_bearing],
        mounts=[
            Mount(rubber=soft, loss=loss, at=MODES, mass=MASS, bracket=b, road=road)
            for b, road in zip(brackets, (None, what.road[:n]), strict=True)
        ],
        torque=what.torque[:n], speed=what.speed[:n], step=STEP, heavy={2: HEAVY},
        torsion=[twisting(s.tube, length) for s, length in zip(shafts, lengths, strict=True)],
    ).drive()  # fmt: skip


def struck(force: float) -> np.ndarray:
    """Return what the second bracket carries sideways, N, at 300 rpm; a blow of 5 ms at 0.4 s."""
    time = np.arange(round(0.9 / STEP) + 1) * STEP
    one, road = np.ones(time.size), np.zeros((time.size, 3))
    road[:, 1] = np.where((time > 0.4) & (time < 0.405), force, 0)
    what = Orders(time, 300 * rpm * one, 3000 * np.clip(time / 0.3, 0, 1), 100 * one, road)
    return drive(DAYS["joints"], what=what).force[1][:, 0]


def bracket_mode() -> tuple[float, float]:
    """Frequency Hz and damping ratio of the bracket sideways, housing and rubber with it.

    As it rings after a blow, the line's own slow swing beside it.
    """
    from scipy.optimize import least_squares

    rung = (struck(2000.0) - struck(0.0))[round(0.406 / STEP) :][: round(0.35 / STEP)]
    time = np.arange(rung.size) * STEP

    def left(x: np.ndarray) -> np.ndarray:
        waves = []
        for hertz, damping in x.reshape(2, 2):
            w = 2 * np.pi * hertz * (1j * np.sqrt(1 - damping**2) - damping)
            waves += [np.exp(w * time).real, np.exp(w * time).imag]
        basis = np.stack(waves, axis=-1)
        return basis @ np.linalg.lstsq(basis, rung, rcond=None)[0] - rung

    hertz, damping, _, _ = least_squares(left, [55, 0.05, 7, 0.05]).x
    return float(hertz), float(damping)


# --------------------------------------------------------------------------- the truth


def strains(driven: Driven, gauges: tuple[str, ...]) -> np.ndarray:
    """What gauges feel (g, n) of the force in the bracket, µm/m."""
    table = json.loads((HERE / "collector_bracket.json").read_text())
    unit = np.array([table["strain_per_N"][g][1:] for g in gauges])
    return 1e6 * unit @ driven.force[1].T


def turn_mean(x: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Mean of x (..., n) over the turn of the shaft about each moment: no order is left of it."""
    clock = np.maximum.accumulate(np.abs(angle - angle[0]) / (2 * np.pi))
    clock += 1e-9 * np.arange(clock.size)
    total = np.concatenate([np.zeros((*x.shape[:-1], 1)), np.cumsum(x, axis=-1)], axis=-1)
    n = np.arange(clock.size + 1.0)
    first = np.interp(clock - 0.5, clock, n[:-1])
    last = np.interp(clock + 0.5, clock, n[:-1])
    at = np.array(
        [np.interp(last, n, row) - np.interp(first, n, row) for row in np.atleast_2d(total)]
    )
    return (at / np.maximum(last - first, 1)).reshape(x.shape)


def cycles(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ranges of the closed cycles of x by the four-point rule, and of the residue's halves."""
    steps = np.diff(x)
    x = np.concatenate([x[:1], x[1:][steps != 0]])
    turn = np.flatnonzero(np.diff(np.sign(np.diff(x)))) + 1
    points = np.concatenate([x[:1], x[turn], x[-1:]]).tolist()
    stack: list[float] = []
    closed: list[float] = []
    for p in points:
        stack.append(p)
        while len(stack) >= 4:
            a, b, c, d = stack[-4:]
            if abs(c - b) <= abs(b - a) and abs(c - b) <= abs(d - c):
                closed.append(abs(c - b))
                del stack[-3:-1]
            else:
                break
    return np.array(closed), np.abs(np.diff(stack))


def damage(stress: np.ndarray, knee: float = KNEE) -> float:
    """Miner's sum of a stress history Pa, with the slope 2 k - 1 below the knee."""
    closed, half = cycles(stress)
    amplitude = np.concatenate([closed, half]) / 2
    count = np.concatenate([np.ones(closed.size), np.full(half.size, 0.5)])
    slope = np.where(amplitude >= knee, SLOPE, 2 * SLOPE - 1)
    return float((count * (amplitude / knee) ** slope).sum() / CYCLES)


def crack(driven: Driven) -> dict:
    """Where the surface suffers most, and how long it lasts there, h."""
    table = json.loads((HERE / "collector_bracket.json").read_text())
    unit = np.array(table["stress_Pa_per_N"])[:, 1:]  # (places, y z, 6)
    force = driven.force[1][::2]
    harmed = []
    for one in unit:
        size = np.abs(one @ np.array([1, 1, 1, 0, 0, 0])) + np.abs(one).max(-1)
        main = one[int(np.argmax(size))]
        # The plane that swings most, by the load that swings it most.
        _, ways = np.linalg.eigh(main[[[0, 3, 5], [3, 1, 4], [5, 4, 2]]])
        harm = []
        for x, y, z in ways.T:
            n = np.array([x * x, y * y, z * z, 2 * x * y, 2 * y * z, 2 * z * x])
            harm.append(damage(force @ (one @ n)))
        harmed.append(max(harm))
    worst = int(np.argmax(harmed))
    hours = driven.time[-1] / 3600 / harmed[worst]
    return {"place_mm": table["places_mm"][worst], "hours": hours,
            "damages": [float(f"{h:.4g}") for h in harmed]}  # fmt: skip


def truth(day: Day, whole: Driven, straight: Driven) -> dict:
    """What is true of a day: damage, life, peaks and the joints' part at each gauge."""
    felt, alone = strains(whole, day.gauges), strains(straight, day.gauges)
    slow = turn_mean(felt - alone, whole.angle)
    told = {}
    seconds = whole.time[-1]
    for name, all_, without in zip(day.gauges, felt, alone + slow, strict=True):
        a, b = (damage(1e-6 * MODULUS * s, AT_GAUGE) for s in (all_, without))
        told[name] = {
            "damage": a, "hours": seconds / 3600 / a, "damage_without_joints": b,
            "removed": 1 - b / a, "low_MPa": MODULUS * 1e-12 * all_.min(),
            "high_MPa": MODULUS * 1e-12 * all_.max(),
        }  # fmt: skip
    table = json.loads((HERE / "collector_bracket.json").read_text())
    _, lateral, vertical = table["compliance_m_N"]
    seats = {1: (1 / FIRST[0], 1 / FIRST[1]), 2: (vertical, lateral)}
    support = {
        f"{way}_{k}_N_mm": 1e-3 / (1 / (SOFT * DRAWN[i]) + seat[i])
        for k, seat in seats.items() for i, way in enumerate(("vertical", "lateral"))
    }  # fmt: skip
    return {
        "seconds": seconds, "gauges": told, "crack": crack(whole),
        "parameters": {**support, "loss": LOSS, "phase_2_deg": float(np.degrees(CROOKED)),
                       "unbalance_2_g_mm": HEAVY * 1e6},
    }  # fmt: skip


# --------------------------------------------------------------------------- the recording


def bus(x: np.ndarray, *, every: float, late: float, digit: float) -> np.ndarray:
    """Return what comes over a bus every so often and late, in digits."""
    step, back = round(every / STEP), round(late / STEP)
    k = (np.arange(x.size) // step) * step
    return np.round(x[np.maximum(k - back, 0)] / digit) * digit


def recorded(day: Day, whole: Driven) -> tuple[dict[str, np.ndarray], dict]:
    """Channels as a logger wrote them at 1 kHz, and what is spoiled: {channel: [[from, to]]}."""
    rng = np.random.default_rng(100 + day.seed)
    n = whole.time.size
    felt = strains(whole, day.gauges) + rng.normal(0, 1.0, (len(day.gauges), n))
    what = orders(day)
    speed = np.abs(np.gradient(whole.angle, whole.time)) / rpm
    channels = dict(zip(day.gauges, felt, strict=True))
    channels["shaft_rpm"] = bus(speed, every=0.02, late=0.08, digit=0.125)
    channels["engine_rpm"] = bus(what.engine[1 : n + 1] / rpm, every=0.02, late=0.05, digit=0.125)
    channels["torque_Nm"] = bus(
        what.torque[1 : n + 1] + rng.normal(0, 5, n), every=0.01, late=0.0, digit=2.0
    )
    mark = (whole.angle / (2 * np.pi) + 0.3) % 1 < 0.1  # a strip on the tube and its sensor
    channels["tacho_V"] = np.where(mark, 5.0, 0.0)
    channels = {name: x[1::2] for name, x in channels.items()}
    channels = {"Time_ms": np.arange(n // 2) * 1000 / RATE} | channels
    spoiled: dict[str, list[list[float]]] = {}
    for name, fault in day.faults.items():
        spoiled[name] = _spoil(rng, channels[name], fault)
    for name in day.gauges:
        channels[name] = np.round(channels[name] * 2) / 2
    return channels, spoiled


def _spoil(rng: np.random.Generator, x: np.ndarray, fault: str) -> list[list[float]]:
    """Spoil a channel in place; return where, s."""
    end = x.size / RATE
    if fault == "drift":
        t = np.arange(x.size) / RATE
        x += 900 * (1 - np.exp(-t / (0.4 * end)))
        return [[0.0, end]]
    if fault == "missing":  # what a bus writes where it knows nothing
        at = round(0.45 * end)
        x[at * RATE : at * RATE + 1500] = 8191.875
        return [[float(at), at + 1.5]]
    if fault == "spikes":
        places = np.sort(rng.uniform(0.2 * end, 0.25 * end, 14))
        for at in places:
            k = int(at * RATE)
            x[k : k + int(rng.integers(1, 3))] += rng.choice([-1, 1]) * rng.uniform(1200, 2500)
        return [[float(places[0]), float(places[-1])]]
    places = np.sort(rng.uniform(0.3 * end, 0.9 * end, 5))
    for at in places:
        k = int(at * RATE)
        x[k : k + int(rng.integers(40, 150))] = -1800.0
    return [[float(at), float(at) + 0.15] for at in places]


def write(day: Day, whole: Driven, path: Path) -> dict:
    """Write a recording as Parquet; return what is spoiled."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    channels, spoiled = recorded(day, whole)
    units = {
        "Time_ms": "ms",
        "shaft_rpm": "rpm",
        "engine_rpm": "rpm",
        "torque_Nm": "Nm",
        "tacho_V": "V",
    }
    table = pa.table({
        name: x.round().astype("int32") if name == "Time_ms" else x.astype("float32")
        for name, x in channels.items()
    })  # fmt: skip
    table = table.cast(pa.schema([
        pa.field(f.name, f.type, metadata={"unit": units.get(f.name, "um/m")})
        for f in table.schema
    ]))  # fmt: skip
    pq.write_table(
        table, path, compression="zstd", compression_level=19, use_dictionary=False,
        column_encoding={
            f.name: "DELTA_BINARY_PACKED" if f.name == "Time_ms" else "BYTE_STREAM_SPLIT"
            for f in table.schema
        },
    )  # fmt: skip
    return spoiled


def cured(day: Day, driven: Driven) -> dict:
    """What is true of a day with other rubber: at each gauge, and of the surface."""
    told = {}
    for name, felt in zip(day.gauges, strains(driven, day.gauges), strict=True):
        harm = damage(1e-6 * MODULUS * felt, AT_GAUGE)
        told[name] = {"damage": harm, "hours": driven.time[-1] / 3600 / harm}
    return {"gauges": told, "crack": crack(driven)}


def main(name: str, out: Path) -> None:
    """Drive a day twice, and write its recording and its truth."""
    day = DAYS[name]
    whole, straight = drive(day), drive(day, straight=True)
    out.mkdir(parents=True, exist_ok=True)
    spoiled = write(day, whole, out / f"{name}.parquet")
    known = truth(day, whole, straight) | {"spoiled_s": spoiled}
    if name == "joints":
        known["cured"] = cured(day, drive(day, loss=2 * LOSS))
        hertz, damping = bracket_mode()
        known["parameters"] |= {"bracket_mode_Hz": hertz, "bracket_mode_damping": damping}
    (out / f"{name}.truth.json").write_text(json.dumps(known, indent=1) + "\n")


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))

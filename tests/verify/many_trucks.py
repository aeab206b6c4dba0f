"""Trucks drawn at random and driven in a multibody engine (EXUDYN), with what is true of them.

The refuse collector's three shafts, each truck put together a little otherwise: joints, rubber,
brackets, welds, balance and gauges. Each is launched once or twice and driven off on a road of its
own; tubes twist under torque. Their file is one and the same: as drawn.

    PYTHONPATH=src:tests python tests/verify/many_trucks.py FIRST LAST

says how often the interval of each kind holds: of all fifty in half an hour of two cores.
"""

import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from adversarial import colour, smooth
from driven_engine import Driving, Mount, twisting
from test_rubber_engine import rigid

from cardan.application import reader
from cardan.checks.line_response import compute_line_response
from cardan.physics.signals.order_tracking import ShaftRotation
from cardan.physics.signals.shaft_angle import ShaftAngle
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references
from cardan.topics.recording.identification_result import IdentificationResult, IdentifiedParameter
from cardan.topics.recording.parameter_identification import identify_parameters

FILE = Path(__file__).parents[2] / "examples" / "refuse-collector" / "application.yaml"
rpm = np.pi / 30
STEP = 1e-3
RUBBER = 200e3, 120e3
"""N/m up and sideways, of the rubber alone as drawn."""
MODES = 10.5, 7.0
"""Hz of the line as drawn, up and sideways."""
UNITS = np.array([(0.0, -29e3, -4e3), (0.0, 45e3, 7e3), (0.0, 0.0, -14e3)])
"""Pa/N at three gauges, as the file of the campaign has them."""
GAUGES = "S1", "S2", "S3"


@dataclass(frozen=True, kw_only=True)
class Truck:
    """What is true of one; SI."""

    seed: int
    rubber: tuple  # of each bearing, up and sideways
    loss: tuple
    bracket: tuple
    mass: tuple
    phases: tuple
    heavy: float  # at the rear of the second shaft
    gain: tuple
    askew: tuple
    moved: tuple  # joints from where they are drawn
    road: float  # N rms up
    legs: tuple

    def supports(self) -> np.ndarray:
        """Rubber and bracket one behind the other (bearings, 2) N/m."""
        return 1 / (1 / np.array(self.rubber) + 1 / np.array(self.bracket))


def truck(seed: int) -> Truck:
    """Draw one."""
    rng = np.random.default_rng(seed)
    rubber = np.array(RUBBER) * np.exp(rng.normal(0, 0.2, (2, 2)))
    hard = rng.uniform(1800, 3700)
    start = [(6.0, rng.uniform(260, 380), hard), (2.0, 280, 0.3 * hard), (4.0, 80, -500),
             (2.0, 60, 300)]  # fmt: skip
    away = [(rng.uniform(6, 10), 480, hard), (1.0, 430, 0), (rng.uniform(6, 10), 900, 0.6 * hard),
            (8.0, rng.uniform(1100, 1500), 0.4 * hard)]  # fmt: skip
    return Truck(
        seed=seed,
        rubber=tuple(map(tuple, rubber)),
        loss=tuple(rng.uniform(0.06, 0.15, 2)),
        bracket=tuple(map(tuple, rubber * rng.uniform(6, 20, (2, 2)))),
        mass=tuple(rng.uniform(3, 8, 2)),
        phases=tuple(rng.normal(0, np.radians(2.5), 3)),
        heavy=float(rng.uniform(0, 4e-3)),
        gain=tuple(np.exp(rng.normal(0, 0.05, 3))),
        askew=tuple(np.exp(rng.normal(0, 0.05, 3))),
        moved=tuple(map(tuple, rng.normal(0, 1.5e-3, (4, 3)) * [0, 1, 1])),
        road=float(np.exp(rng.uniform(np.log(30), np.log(200)))),
        legs=((2.0, 60, 500), *(int(rng.integers(1, 3)) * start), *away),
    )  # fmt: skip


def drive(of: Truck) -> dict[str, np.ndarray]:
    """Drive it; what its gauges say at 1 kHz, Pa, and at 200 Hz turns and torque."""
    rng = np.random.default_rng(10_000 + of.seed)
    ends = np.cumsum([0] + [seconds for seconds, *_ in of.legs])
    time = np.arange(int(ends[-1] / STEP) + 1) * STEP
    speed = np.interp(time, ends, [60] + [to for _, to, _ in of.legs])
    speed = smooth(speed, round(0.8 / STEP)) * rpm
    held = np.repeat([torque for *_, torque in of.legs], 2).astype(float)
    shifts = np.repeat(ends, 2)[1:-1] + np.tile([0.15, -0.15], len(of.legs))
    torque = smooth(np.interp(time, shifts, held), round(0.25 / STEP)) * np.clip(time / 0.3, 0, 1)
    torque *= 1 + 0.03 * colour(rng, time.size, 1 / STEP, low=0.05, high=2, slope=0.5)
    rough = of.road * np.sqrt(0.05 + speed / (500 * rpm))
    road = np.stack(
        [
            share * rough * colour(rng, time.size, 1 / STEP, low=1, high=90, slope=0.7)
            for share in (0, 0.4, 1)
        ],
        axis=-1,
    )
    drawn = reader.read(FILE)
    response = compute_line_response(
        drawn, line_state_demand(resolve_line_references(drawn, drawn.lines[0]))
    )
    at = response.demand.states.index("gvw")
    points = response.layout.points[at] + np.array(of.moved)
    ways = np.diff(points, axis=0)
    lengths = np.linalg.norm(ways, axis=-1)
    directions = response.layout.directions[at].copy()
    directions[1:-1] = ways / lengths[:, None]
    shafts = response.line.shafts
    driven = Driving(
        points, directions, np.array([s.phase for s in shafts]) + of.phases,
        [rigid(replace(s, length=length)) for s, length in zip(shafts, lengths, strict=True)],
        [s.centre_bearing.from_rear_joint for s in shafts if s.centre_bearing],
        mounts=[
            # Each way loses its share at its own mode.
            Mount(rubber=r, loss=loss, mass=mass, bracket=b, road=shaken,
                  at=tuple(2 * np.pi * np.array(MODES) * np.sqrt(np.array(r) / RUBBER)))
            for r, loss, mass, b, shaken
            in zip(of.rubber, of.loss, of.mass, of.bracket, (None, road), strict=True)
        ],
        torque=torque, speed=speed, step=STEP, heavy={2: of.heavy},
        torsion=[twisting(s.tube, length) for s, length in zip(shafts, lengths, strict=True)],
    ).drive()  # fmt: skip
    felt = np.array(of.gain)[:, None] * UNITS[:, 1:]
    felt = felt * np.stack([np.ones(3), of.askew], axis=-1)
    stress = felt @ driven.force[1].T + rng.normal(0, 0.2e6, (3, driven.time.size))
    return {
        "stress": stress.astype(np.float32),
        "time": driven.time[::5] - STEP,
        "turns": driven.angle[::5] / (2 * np.pi) + 0.3,
        "torque": driven.torque[::5].astype(np.float32),
        "force": driven.force[1].astype(np.float32),
    }


def found(drive: dict[str, np.ndarray]) -> IdentificationResult:
    """Return what the recording of its drive says, held against the file as drawn."""
    return identify_parameters(
        reader.read(FILE), iter([drive["stress"].astype(float)]),
        rate=1 / STEP, gauges=GAUGES, units=UNITS,
        angle=ShaftAngle(ShaftRotation(drive["time"], drive["turns"]), lag=0.02),
        torque=(drive["torque"].astype(float), 0.2 / STEP), seconds=float(drive["time"][-1]),
        state="gvw", bearing=2,
    )  # fmt: skip


def true(of: Truck) -> dict[tuple, tuple[float, float]]:
    """What is so, by name and number or gauge, between two numbers where it is not one.

    A loss is of rubber and bracket together, which is not the same up and sideways.
    """
    held, told = of.supports(), {("unbalance", 2): (of.heavy, of.heavy)}
    for k, (own, rubber, loss) in enumerate(zip(held, of.rubber, of.loss, strict=True), 1):
        told |= {("vertical", k): (own[0],) * 2, ("lateral", k): (own[1],) * 2}
        told["loss", k] = float((own / rubber).min() * loss), loss
    told |= {("phase", k): (phase, phase) for k, phase in enumerate(of.phases, 1)}
    return told | {("gain", g): (gain, gain) for g, gain in zip(GAUGES, of.gain, strict=True)}


def held(of: Truck, parameters: Iterable[IdentifiedParameter]) -> Iterator[tuple[str, bool]]:
    """Yield each number's name, and whether its interval holds what is so."""
    known = true(of)
    for p in parameters:
        if bounds := known.get((p.name, p.part.other or p.part.number)):
            yield p.name, p.low <= bounds[1] and bounds[0] <= p.high


def _asked(seed: int) -> list[tuple[str, bool]]:
    """Return what `held` says of one, for a process of its own."""
    of = truck(seed)
    return list(held(of, found(drive(of)).parameters))


def shares(seeds: Iterable[int]) -> dict[str, tuple[int, int]]:
    """Return how many intervals of each kind hold what is so, and of how many."""
    inside, every = Counter(), Counter()
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        for told in pool.map(_asked, seeds):
            for name, holds in told:
                inside[name] += holds
                every[name] += 1
    return {name: (inside[name], every[name]) for name in every}


if __name__ == "__main__":
    first, last = map(int, sys.argv[1:])
    for kind, (inside, every) in shares(range(first, last)).items():
        print(f"{kind}: {inside} of {every}")  # noqa: T201

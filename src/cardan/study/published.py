"""Self-calibration: published cases, recomputed by this program on this machine.

Each case is a number somebody printed, with where; the tolerance is half a unit of its last
printed digit, unless the source is known to round more, and then the case says so.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cardan.base.source import E2, ELBE, J3311, SOUZA, Source
from cardan.base.units import deg, hour, inch, lbf, lbft, mm, rpm
from cardan.demand.suspension import table_rates
from cardan.demand.torque import low_gear_torque, wheel_slip_torque
from cardan.kinematics import equivalent, joint
from cardan.kinematics.chain import turn
from cardan.loads import Cycle, loads, small_angle
from cardan.model.layout import Layout, from_joint_angles, from_slopes
from cardan.model.parts import CentreBearing, Line, Shaft
from cardan.model.vehicle import Spring
from cardan.shaft import life, whirl

CHELSEA = Source("Parker Chelsea, manual HY25-1890-M1/US", "p. 5, Spicer joint operating angles")
AISCO = Source("AISCO, Universal joint sizing", "its life formula, worked by hand")
ENGINES = Source("Derived; confirmed by two independent multibody engines to 1e-9")
PROBLEMS = Source("Hooke's joint problems of mechanics courses; their book is not traced")
CALCULATOR = Source("A public calculator prints 7200 rpm; its own model gives 8284")


@dataclass(frozen=True, kw_only=True)
class Published:
    """One published number, and what this program computes for it, in the unit printed.

    `within` is the largest difference that rounding in print explains.
    """

    title: str
    source: Source
    expected: float
    computed: float
    within: float

    @property
    def difference(self) -> float:
        """Computed over published, less 1."""
        return self.computed / self.expected - 1

    @property
    def agrees(self) -> bool:
        """Whether the printed digits are met; nan is not."""
        return abs(self.computed - self.expected) <= self.within


def published() -> tuple[Published, ...]:
    """Recompute every published case."""
    return (
        *_one_joint(),
        *_chains(),
        *_demands(),
        *_forces(),
        *_speeds(),
        *_lives(),
    )


def _case(
    title: str, source: Source, expected: float, computed: object, within: float
) -> Published:
    """Return a case of a number that may come as an array without axes."""
    return Published(
        title=title,
        source=source,
        expected=expected,
        computed=float(np.asarray(computed)),
        within=within,
    )


def _one_joint() -> Iterator[Published]:
    """Yield cases of one Hooke joint."""
    low, high = joint.speed_range(25 * deg)
    yield _case("Hooke joint 25 deg at 100 rad/s: highest speed, rad/s", PROBLEMS, 110.34,
                100 * high, 5e-3)  # fmt: skip
    yield _case("Hooke joint 25 deg at 100 rad/s: lowest speed, rad/s", PROBLEMS, 90.63,
                100 * low, 5e-3)  # fmt: skip
    for angle, percent in ((10, 3.062), (15, 6.935)):
        yield _case(f"Irregularity of a joint at {angle} deg, %", PROBLEMS, percent,
                    100 * joint.irregularity(angle * deg), 5e-4)  # fmt: skip
    yield _case("Joint angle of 12.5 % irregularity, deg", PROBLEMS, 20.04,
                joint.angle_for_irregularity(0.125) / deg, 5e-3)  # fmt: skip
    at = joint.speed_ratio(np.pi / 2, beta=30 * deg, pin=joint.NORMAL)
    yield _case("Speed ratio at 30 deg, pin normal, a quarter on", E2, 1 / np.cos(30 * deg), at,
                1e-12)  # fmt: skip


def _chains() -> Iterator[Published]:
    """Yield cases of joint angles and lines."""
    side = np.array([-2.70, -1.25, 2.45]) * deg
    top = np.array([0.67, 0.13, -0.80]) * deg
    angles = equivalent.pythagorean_angle(side, top) / deg
    places = equivalent.position(side, top) / deg
    for k, (angle, place) in enumerate(((2.7819, 283.94), (1.2567, 275.94), (2.5773, 108.08))):
        yield _case(f"True angle of joint {k + 1}, deg", SOUZA.at("table 3"), angle, angles[k],
                    5e-5)  # fmt: skip
        yield _case(f"Position of joint {k + 1}, deg", SOUZA.at("table 3"), place, places[k],
                    6e-3)  # fmt: skip
    yield _case("Compound angle of 2.15 and 2.50 deg, deg", J3311.at("fig. 6"), 3.3,
                equivalent.pythagorean_angle(2.5 * deg, 2.15 * deg) / deg, 0.05)  # fmt: skip
    exact = {(0, 0): 3.5864, (90, 0): 1.7392, (0, 90): 0.7912, (90, 90): 3.9782}
    layout = from_joint_angles(side=side, top=top, lengths=[1.0, 1.0])
    for phases, angle in exact.items():
        names = ", ".join("crossed" if p else "aligned" for p in phases)
        found = equivalent.excitation(
            turn(layout.directions, phases=np.array(phases) * deg), speed=1.0
        )
        yield _case(f"Equivalent angle of the chain, {names}, deg", ENGINES, angle,
                    found.torsional.angle / deg, 5e-5)  # fmt: skip
    yield _case("Equivalent angle of U = 0.0027, deg", ELBE, 2.98,
                joint.angle_for_irregularity(0.0027) / deg, 5e-3)  # fmt: skip
    table = {3000: (5, 50), 2500: (7, 0), 2000: (8, 40), 1500: (11, 30)}
    for n, (whole, minutes) in table.items():
        # Printed in steps of 10 minutes of arc.
        found = equivalent.angle_for_acceleration(1000.0, speed=n * rpm) / deg
        yield _case(
            f"Largest joint angle at {n} rpm, deg", CHELSEA, whole + minutes / 60, found, 5 / 60
        )


def _demands() -> Iterator[Published]:
    """Yield cases of torque and suspension."""
    yield _case("Low gear torque LGT, lb-ft", J3311.at("p. 2"), 14603,
                low_gear_torque(1567.5 * lbft, ratio=10.96, efficiency=0.85) / lbft,
                0.5)  # fmt: skip
    yield _case("Wheel slip torque WST, lb-ft", J3311.at("p. 2"), 13024,
                wheel_slip_torque(40000 * lbf, radius=19.5 * inch, ratio=3.73) / lbft,
                0.5)  # fmt: skip
    spring = Spring(
        load=(0.0, 11562.0, 12749.0, 26233.0, 43345.0),
        deflection=tuple(x * mm for x in (0.0, 96.0, 105.0, 185.0, 273.0)),
    )
    first, *_, last = table_rates(spring) * mm
    yield _case("Spring rate before contact, N/mm (stated 120.6)", SOUZA.at("table 1"), 120.4,
                first, 0.05)  # fmt: skip
    yield _case("Spring rate after contact, N/mm (stated 192.2)", SOUZA.at("table 1"), 194.5,
                last, 0.05)  # fmt: skip


def _forces() -> Iterator[Published]:
    """Yield the centre-bearing force of a two-piece line."""
    layout = from_slopes(
        side=np.array([3.0, 1.0, 4.5, 2.0]) * deg,
        top=np.array([0.0, 1.5, -0.8, 0.6]) * deg,
        lengths=[1.2, 1.5],
    )
    line = Line(shafts=(Shaft(length=1.2, centre_bearing=CentreBearing()), Shaft(length=1.5)))
    cases = {
        "exact": (_exact_force(layout, line), 5.139, 20.090),
        "small angle": (small_angle(layout, line, torque=1000.0), 5.124, 20.049),
    }
    for name, (cycle, static, dynamic) in cases.items():
        yield _case(f"Centre bearing, static force, {name}, N", ENGINES, static,
                    np.linalg.norm(cycle.static), 5e-4)  # fmt: skip
        yield _case(f"Centre bearing, twice a turn, {name}, N", ENGINES, dynamic,
                    cycle.dynamic[0], 5e-4)  # fmt: skip


def _exact_force(layout: Layout, line: Line) -> Cycle:
    found = turn(layout.directions, phases=line.phases)
    return loads(layout, found, line, torque=1000.0).bearing_forces


def _speeds() -> Iterator[Published]:
    """Yield critical speeds."""
    found = whirl.critical_speed_inch(60 * inch, outer=3.5 * inch, inner=3.26 * inch)
    yield _case("Critical speed, 3.5 x 0.120 x 60 in, rpm", Source("SAE AE-7", "p. 267"), 6251,
                found / rpm, 0.5)  # fmt: skip
    found = whirl.critical_speed(
        48 * inch, outer=3 * inch, inner=2.76 * inch, youngs_modulus=200e9, density=7850.0
    )
    yield _case("Critical speed, 3 x 0.120 x 48 in, rpm", CALCULATOR, 8284, found / rpm, 0.5)


def _lives() -> Iterator[Published]:
    """Yield needle bearing lives."""
    for title, torque, n, beta, expected in (
        ("Joint life, Td 2000, T 500 N·m, 1500 rpm, 5 deg, h", 500.0, 1500, 5, 20319),
        ("Joint life at the rated torque, 100 rpm, 3 deg, h", 2000.0, 100, 3, 5000),
    ):
        worn = life.wear(
            torque, speed=n * rpm, angle=beta * deg, rated_torque=2000.0, prime_mover_factor=1.0
        )
        yield _case(title, AISCO, expected, life.joint_life(worn) / hour, 0.5)

"""Trucks calculated by hand: every number of a check, from first principles and nothing else.

A worked example to follow with paper and pencil. It imports nothing of the program it is held
against; its only inputs are the numbers of `by_hand.yaml`, written down once more below, and
textbook mechanics. Frame: x rearward, y to the right, z up. SI inside; the units of the file
stand beside the numbers.

Where there is a choice it takes another road than the program: the chain turns by its pin
axes at 720 angles, forces come from one linear system of equilibrium for a whole line, the
line's whirl from many short beams with lumped masses.
"""

from dataclasses import dataclass, field
from itertools import pairwise
from math import asin, atan, atan2, cos, hypot, inf, isnan, nan, pi, radians, sin, sqrt, tan

import numpy as np

# --------------------------------------------------------------------------- units

g = 9.80665  # m/s²
inch, mm = 0.0254, 0.001  # m
lb = 0.45359237  # kg
lbf = lb * g  # N
lbft = lbf * 12 * inch  # N m
psi = lbf / inch**2  # Pa
deg, rpm = pi / 180, 2 * pi / 60
MPa, GPa = 1e6, 1e9

# --------------------------------------------------------------------------- what a truck is


@dataclass(frozen=True)
class Tube:
    """Diameters, m; modulus and yield strength, Pa; density, kg/m³."""

    outer: float
    wall: float
    E: float
    nu: float
    rho: float
    strength: float

    @property
    def inner(self):
        return self.outer - 2 * self.wall

    @property
    def area(self):
        return pi / 4 * (self.outer**2 - self.inner**2)

    @property
    def I(self):  # noqa: E743, N802  the symbol of handbooks
        return pi / 64 * (self.outer**4 - self.inner**4)


@dataclass(frozen=True)
class Shaft:
    """Length, m; yoke phase, rad; masses, kg; inertias, kg m²; grade, mm/s."""

    length: float
    tube: Tube
    phase: float
    yokes: tuple
    yoke_inertia: float
    grade: float
    to_bearing: float = nan  # front joint to centre bearing
    rubber: tuple = ()  # vertical, lateral, N/m
    inertia: float | None = None  # in place of tube and yokes
    spline_mass: float = 0.0
    spline_at: float = 0.0  # behind the front joint

    @property
    def mass(self):
        return self.tube.rho * self.tube.area * self.length + sum(self.yokes) + self.spline_mass

    @property
    def polar_inertia(self):
        own = self.tube.rho * 2 * self.tube.I * self.length + self.yoke_inertia
        return own if self.inertia is None else self.inertia


@dataclass(frozen=True)
class Spline:
    """Travel from the reference state, in and out, m; mean radius, m; friction."""

    plunge: float
    draw: float
    radius: float
    friction: float


@dataclass(frozen=True)
class Joint:
    """Ratings, N m; Td of the needles; largest angle rad, speed times angle rad²/s, speed."""

    peak: float = nan
    reversing: float = nan
    pulsating: float = nan
    Td: float = nan
    angle: float = nan
    speed_angle: float = nan
    speed: float = nan


@dataclass(frozen=True)
class Obstacle:
    name: str
    start: tuple
    end: tuple
    radius: float
    share: float


@dataclass(frozen=True)
class Springs:
    """One spring's table, N and m; where the axle's states are on it; how the axle is led."""

    loads: tuple
    deflections: tuple
    per_axle: int
    unsprung: float  # kg
    reference: str
    full_rebound: float
    rebound: float
    jounce: float
    link: float  # radius, m
    link_angle: float
    pitch_rate: float  # rad/m
    windup: float = nan  # N m/rad
    brake: float = 0.0  # N m on one axle
    table: tuple = ()  # in place of the link: rise, rearward, m, and pitch, rad


@dataclass(frozen=True)
class Line:
    name: str
    start: tuple  # first joint, m
    side: tuple  # slopes of gearbox, shafts, pinion, rad; down to the rear positive
    top: tuple  # to the right going rearward positive
    shafts: tuple
    joints: tuple
    spline: Spline
    axle_ratio: float
    axle_efficiency: float
    pinion: tuple  # (x, z) of the last joint from the wheel centre, m
    axles_behind: float  # axles this line turns
    load_share: float = 1.0  # of the group's driven load that is on its wheels
    torque_share: float = 1.0  # of the gearbox output's torque
    push: float = 1.0  # part of what all driven wheels push that its own do
    speed_ratio: float = 1.0
    drives: str = "rear"
    output: tuple | None = None  # (x, z) of joint 1 from the wheel centre it rides on
    gearbox_bearings: tuple | None = None  # spacing, overhang, m
    pinion_bearings: tuple | None = None
    obstacles: tuple = ()
    springs: str = "rear"
    first_on_springs: bool = True  # asks for the springs' frequency
    ahead: float = 1.0  # -1 where the line runs forward
    floating: bool = False  # the gearbox flange slides, not the last shaft


@dataclass(frozen=True)
class Load:
    """W, its centre of gravity (behind front, above ground), and auxiliary axles (N, m)."""

    weight: float
    behind: float
    height: float
    auxiliary: tuple = ()


@dataclass(frozen=True)
class State:
    name: str
    load: str
    times: float = 1.0
    kind: str = ""
    travel: float = nan
    pitch: float = nan
    torque: float = nan
    speed: float = nan
    slopes: dict = field(default_factory=dict)  # line: (side, top, last length)


@dataclass(frozen=True)
class Truck:
    wheelbase: float
    grade: float  # rad
    loads: dict
    driven_front: float  # share of the front axles' load on driven wheels
    driven_rear: float  # of the rear group's
    rear_axles: int  # driven, in the rear group
    engine: tuple  # (rad/s, N m) points
    engine_brake: float
    ratios: tuple
    efficiency: float
    converter: float
    transfer: float
    gearbox_efficiency_j3311: float
    static_radius: float
    dynamic_radius: float
    friction: float
    springs: dict
    lines: tuple
    states: tuple
    duty: tuple  # (share, N m, rad/s, angle or nan)
    prime_mover: float
    shock: float
    top_speed: float = nan  # of the gearbox output, in place of the engine's
    coast: float = nan  # at the gearbox output, in place of the engine brake's
    gravity: bool = True
    unbalance: bool = True
    front_axles: int = 1


RIGID = (1e13, 1e13)
"""N/m: a thousand times what a shaft is from its joint to its bearing."""

# ------------------------------------------------------------------------ the truck: by_hand.yaml

STEEL_1 = {"E": 29.5e6 * psi, "nu": 0.29, "rho": 7810, "strength": 70000 * psi}
E355 = {"E": 210 * GPa, "nu": 0.3, "rho": 7850, "strength": 355 * MPa}
STEEL_3 = {"E": 207 * GPa, "nu": 0.3, "rho": 7850, "strength": 420 * MPa}
STEEL_4 = {"E": 205 * GPa, "nu": 0.3, "rho": 7830, "strength": 390 * MPa}

HAND_20 = Joint(
    peak=24000 * lbft, reversing=11800, pulsating=17600, Td=2650 * lbft,
    angle=25 * deg, speed_angle=21500 * rpm * deg, speed=4300 * rpm,
)  # fmt: skip
# A size rated by GWB's Lc = 1.5e-4 Td^(10/3), Td in kN m. Its fatigue is known reversing only.
HAND_24 = Joint(
    peak=31000 * lbft, reversing=14900, pulsating=14900,
    Td=1000 * (0.0114 / 1.5e-4) ** 0.3, angle=28 * deg, speed_angle=18200 * rpm * deg,
    speed=3950 * rpm,
)  # fmt: skip
IN_PLACE = Joint(
    peak=38000, reversing=9900 * lbft, pulsating=21500, Td=3100, angle=0.4,
    speed_angle=19600 * rpm * deg, speed=430,
)  # fmt: skip
INTER_AXLE = Joint(peak=16500 * lbft, Td=2480, angle=20 * deg, speed=4900 * rpm)


def _slopes_of_joints(first, angles):
    """Slopes of the members from the first one's and the change at every joint, degrees."""
    slopes = [first]
    for angle in angles:
        slopes.append(slopes[-1] + angle)
    return tuple(radians(s) for s in slopes)


MAIN = Line(
    name="main",
    start=(0.0, 0.0, 0.0),
    side=_slopes_of_joints(3.2, (-1.9, 1.4, 2.1, -2.6)),
    top=_slopes_of_joints(0.4, (0.7, -0.5, 1.1, -0.9)),
    shafts=(
        Shaft(
            length=41.5 * inch, tube=Tube(4.0 * inch, 0.134 * inch, **STEEL_1),
            phase=radians(12.5), to_bearing=(41.5 - 5.5) * inch,
            rubber=(1150 * lbf / inch, 700 * lbf / inch), yokes=(21 * lb, 26 * lb),
            yoke_inertia=0.018, grade=16,
        ),
        Shaft(
            length=0.980, tube=Tube(0.110, 0.0045, **E355), phase=radians(90),
            to_bearing=0.850, rubber=(260e3, 140e3), yokes=(8, 10.5),
            yoke_inertia=0.021, grade=25,
        ),
        Shaft(
            length=1.310, tube=Tube(0.120, 0.2 * inch, **STEEL_3), phase=-0.07,
            yokes=(11, 9), yoke_inertia=0.03, grade=40, spline_mass=15 * lb, spline_at=0.230,
        ),
    ),
    joints=(HAND_20, HAND_24, IN_PLACE, HAND_20),
    spline=Spline(plunge=0.048, draw=2.4 * inch, radius=1.35 * inch, friction=0.09),
    axle_ratio=5.29,
    axle_efficiency=0.955,
    pinion=(-21.5 * inch, 0.140),
    axles_behind=2,
    gearbox_bearings=(0.240, 4.1 * inch),
    pinion_bearings=(7.5 * inch, 0.150),
    obstacles=(
        Obstacle("axle arm", (2.1, -0.3, -0.26), (2.35, 0.42, -0.305), 1.6 * inch, 1.0),
        Obstacle(
            "air tank", (46 * inch, 9 * inch, -11 * inch), (46 * inch, 9 * inch, -11 * inch),
            0.140, 0.25,
        ),
    ),
)  # fmt: skip

# Points (4.0, 1.2, 35.0), (22.0, 1.5, 33.4), (46.0, 1.7, 31.1) in: slopes from differences.
_AHEAD, _BEHIND = (18.0 * inch, 0.3 * inch, -1.6 * inch), (24.0 * inch, 0.2 * inch, -2.3 * inch)


def _slopes(step):
    """Side and top view slope of a step from joint to joint."""
    return atan2(-step[2], step[0]), atan2(step[1], step[0])


THROUGH = Line(
    name="inter-axle",
    start=(4.0 * inch, 1.2 * inch, 35.0 * inch),
    side=(0.05, _slopes(_AHEAD)[0], _slopes(_BEHIND)[0], radians(2.4)),
    top=(0.0, _slopes(_AHEAD)[1], _slopes(_BEHIND)[1], radians(0.6)),
    shafts=(
        Shaft(
            length=hypot(*_AHEAD), tube=Tube(3.5 * inch, 0.0042, **STEEL_4), phase=radians(3),
            to_bearing=hypot(*_AHEAD) - 0.070, rubber=(125e6, 160e6), yokes=(9, 7),
            yoke_inertia=0.02, grade=31.5,
        ),
        Shaft(
            length=hypot(*_BEHIND), tube=Tube(0.092, 0.0038, **STEEL_4), phase=radians(-94),
            yokes=(6, 8), yoke_inertia=0.025, inertia=0.071, grade=16, spline_mass=5,
            spline_at=8 * inch,
        ),
    ),
    joints=(INTER_AXLE, HAND_24, HAND_20),
    spline=Spline(plunge=1.9 * inch, draw=0.037, radius=0.031, friction=0.12),
    axle_ratio=6.6125,
    axle_efficiency=0.955,
    pinion=(-0.390, 3.4 * inch),
    axles_behind=1,
    load_share=0.5,
    torque_share=0.5 * 0.8,
    push=0.5,
    speed_ratio=1.25,
    output=(12.5 * inch, 0.095),
    pinion_bearings=(0.170, 5.2 * inch),
    obstacles=(
        Obstacle(
            "brake chamber", (30 * inch, -6 * inch, 28 * inch), (0.94, -0.18, 0.76), 3 * inch, 0.8
        ),
    ),
    first_on_springs=False,
)  # fmt: skip

# The gross weight is known by its mass and what the front axle carries; its lever follows.
_FRONT, _GROSS = 14500 * lbf, 26000 * g

TRUCK = Truck(
    wheelbase=190 * inch,
    grade=atan(0.06),
    loads={
        "empty": Load(weight=24000 * lbf, behind=2.350, height=45 * inch),
        "gvw": Load(weight=_GROSS, behind=(_GROSS - _FRONT) / _GROSS * 190 * inch, height=1.550),
    },
    driven_front=0.0,
    driven_rear=1.0,
    rear_axles=2,
    engine=(
        (800 * rpm, 700 * lbft), (1400 * rpm, 860 * lbft),
        (1900 * rpm, 800 * lbft), (2400 * rpm, 640 * lbft),
    ),
    engine_brake=410 * lbft,
    ratios=(6.9, 4.1, 2.5, 1.6, 1.0, 0.78),
    efficiency=0.94,
    converter=1.4,
    transfer=1.3,
    gearbox_efficiency_j3311=0.80,  # automatic: it has a converter
    static_radius=19.6 * inch,
    dynamic_radius=0.521,
    friction=0.78,
    springs={
        "rear": Springs(
            loads=(0.0, 5200 * lbf, 10300 * lbf, 17500 * lbf),
            deflections=(0.0, 0.062, 0.113, 0.168),
            per_axle=2, unsprung=1900 * lb, reference="gvw",
            full_rebound=-0.038,  # the check strap
            rebound=-1 * inch,  # spring free, and an inch more
            jounce=0.168,  # metal to metal: the end of the table
            link=0.75 * 32 * inch, link_angle=radians(3.5),
            pitch_rate=0.004 * deg / mm, windup=21e3 / deg, brake=7200,
        )
    },
    lines=(MAIN, THROUGH),
    states=(
        State("full rebound", kind="full rebound", load="empty"),
        State("rebound", kind="rebound", load="empty"),
        State("empty", kind="empty", load="empty"),
        State("gvw", kind="gvw", load="gvw"),
        State("overload", kind="overload", load="gvw", times=1.1),
        State("jounce", kind="jounce", load="gvw"),
        State("windup", kind="windup", load="gvw"),
        State("windup brake", kind="windup brake", load="gvw"),
        State("braked empty", kind="windup brake", load="empty"),
        State(
            "on the retarder", kind="windup brake", load="gvw", torque=2700, speed=1400 * rpm
        ),
        State(
            "ramp crest", load="empty", travel=-0.041, pitch=radians(0.6),
            torque=2100 * lbft, speed=74,
        ),
        State(
            "on the bench", load="gvw", torque=3300, speed=910 * rpm,
            slopes={"main": (
                tuple(map(radians, (3.0, 2.2, 1.5, 5.5, 2.0))),
                tuple(map(radians, (0.4, 1.6, 0.2, 0.9, -0.3))),
                1.322,
            )},
        ),
        State("parked", load="gvw", torque=0, speed=0),
    ),
    duty=((0.22, 2600, 520 * rpm, nan), (0.78, 410 * lbft, 190, radians(4.4))),
    prime_mover=1.2,  # petrol
    shock=1.7,
)  # fmt: skip


# ------------------------------------------------------------------ the other: by_hand_front.yaml

NOT_RATED = Joint()
# Of the catalogue that comes with the program: 120x4 tube of E355-SR; GWB's 2045.
CATALOGUE_TUBE = Tube(0.120, 0.004, E=210 * GPa, nu=0.3, rho=7850, strength=450 * MPa)
GWB_2045 = Joint(
    peak=17000, reversing=5100, pulsating=7140, Td=1000 * (0.104 / 1.5e-4) ** 0.3,
    angle=25 * deg, speed_angle=19000 * rpm * deg, speed=4700 * rpm,
)  # fmt: skip
STEEL_5 = {"E": 208 * GPa, "nu": 0.28, "rho": 7800, "strength": 400 * MPa}
STEEL = {"E": 206 * GPa, "nu": 0.3, "rho": 7850, "strength": nan}

TRANSFER = Line(
    name="transfer",
    start=(0.0, 0.0, 0.0),
    side=tuple(map(radians, (4.1, 5.6, 4.9, 3.9))),
    top=tuple(map(radians, (0.0, -1.3, -0.5, 0.2))),
    shafts=(
        Shaft(
            length=38 * inch, tube=CATALOGUE_TUBE, phase=0.0, to_bearing=38 * inch - 0.090,
            rubber=(107e6, 107e6), yokes=(17 * lb, 17 * lb), yoke_inertia=0.02, grade=16,
        ),
        Shaft(
            length=40 * inch, tube=CATALOGUE_TUBE, phase=radians(2), yokes=(17 * lb, 17 * lb),
            yoke_inertia=0.02, grade=16,
        ),
    ),
    joints=(NOT_RATED,) * 3,
    spline=Spline(plunge=inf, draw=0.030, radius=0.029, friction=0.11),
    axle_ratio=nan,
    axle_efficiency=nan,
    pinion=(0.0, 0.0),
    axles_behind=2,
    drives="all",
    gearbox_bearings=(0.190, 0.088),
    obstacles=(Obstacle("hose", (0.12, -0.09, -0.11), (0.42, 0.095, -0.14), 0.012, 0.0),),
    first_on_springs=False,
)  # fmt: skip

REAR = Line(
    name="main",
    start=(0.0, 0.0, 0.0),
    side=(0.055, 0.021, 0.071, 0.043),
    top=tuple(map(radians, (0.4, 1.9, -0.8, 0.5))),
    shafts=(
        Shaft(
            length=1.130, tube=Tube(0.114, 0.004, **STEEL_5), phase=radians(33),
            to_bearing=1.130 - 6 * inch, rubber=RIGID, yokes=(10, 12), yoke_inertia=0.03, grade=16,
        ),
        Shaft(
            length=1.490, tube=Tube(0.127, 0.0045, **STEEL_5), phase=radians(88), yokes=(13, 9),
            yoke_inertia=0.04, grade=16, spline_mass=8, spline_at=0.160,
        ),
    ),
    joints=(HAND_20,) * 3,
    spline=Spline(plunge=0.031, draw=inf, radius=0.036, friction=0.1),
    axle_ratio=4.63,
    axle_efficiency=0.965,
    pinion=(-0.470, -0.035),
    axles_behind=1,
    torque_share=0.62 * 1.1,
    push=0.62,
    speed_ratio=0.91,
    gearbox_bearings=(6.2 * inch, 3.3 * inch),
    pinion_bearings=(0.155, 0.121),
    floating=True,
)  # fmt: skip

# Points (0, -310, 0) and (1080, -352, -118) mm.
FORWARD = Line(
    name="front",
    start=(0.0, -0.310, 0.0),
    side=(radians(4.2), atan2(0.118, 1.080), radians(5.5)),
    top=(0.0, atan2(-0.042, 1.080), radians(-0.7)),
    shafts=(
        Shaft(
            length=sqrt(1.080**2 + 0.042**2 + 0.118**2), tube=Tube(0.090, 0.004, **STEEL),
            phase=0.0, yokes=(6, 5), yoke_inertia=0.011, grade=16,
        ),
    ),
    joints=(GWB_2045, GWB_2045),
    spline=Spline(plunge=0.040, draw=0.025, radius=0.027, friction=0.11),
    axle_ratio=4.8,
    axle_efficiency=0.95,
    pinion=(-0.260, 0.060),
    axles_behind=1,
    torque_share=0.38 * 1.06,
    push=0.38,
    speed_ratio=0.95,
    drives="front",
    springs="front",
    ahead=-1.0,
    obstacles=(Obstacle("sump", (0.5, -0.42, -0.18), (0.5, -0.42, -0.18), 0.045, -0.5),),
)  # fmt: skip

_MEASURED = {
    "main": (
        # from the gearbox's own slopes on: changes of -1.5, 3.1, -2.2 and 1.2, -2.1, 0.3 deg
        tuple(0.055 + radians(a) for a in (0, -1.5, 1.6, -0.6)),
        tuple(radians(a) for a in (0.4, 1.6, -0.5, -0.2)),
        59 * inch,
    ),
    "front": (
        # points (4, -310, 0) and (1078, -349, -101) mm
        (radians(4.2), atan2(0.101, 1.074), radians(5.5)),
        (0.0, atan2(-0.039, 1.074), radians(-0.7)),
        sqrt(1.074**2 + 0.039**2 + 0.101**2),
        (0.004, -0.310, 0.0),
    ),
}


def _of_axles(front, rear, height, wheelbase=5.2):
    """A load known by what its axles carry, N: the centre of gravity divides them."""
    return Load(weight=front + rear, behind=rear / (front + rear) * wheelbase, height=height)


FRONT_TRUCK = Truck(
    wheelbase=5.2,
    grade=radians(4),
    loads={
        "curb": _of_axles(5300 * g, 5900 * g, 1.02),
        "empty": _of_axles(15400 * g - 19100 * lbf, 19100 * lbf, 1.24),
        "gvw": Load(31000 * g, 142 * inch, 1.61, auxiliary=((42e3, 251 * inch),)),
    },
    driven_front=1.0,
    driven_rear=0.62,
    rear_axles=1,
    engine=((2000 * rpm, 1450),),
    engine_brake=0.0,
    ratios=(7.4, 4.0, 2.1, 1.0),
    efficiency=0.96,
    converter=1.0,
    transfer=1.0,
    gearbox_efficiency_j3311=0.85,  # manual
    static_radius=0.503,
    dynamic_radius=0.503,
    friction=0.8,
    springs={
        "rear": Springs(
            loads=(0.0, 262e3), deflections=(0.0, 1.0), per_axle=2, unsprung=950,
            reference="curb",
            # Hanging, 950 kg pull two springs 17.8 mm; at least an inch counts.
            full_rebound=-1 * inch, rebound=-1 * inch, jounce=6.5 * inch,
            link=0.655, link_angle=-0.06, pitch_rate=-0.05, windup=17500 / deg,
        ),
        "front": Springs(
            loads=(0.0, 180e3 * 0.090, 180e3 * 0.090 + 260e3), deflections=(0.0, 0.090, 1.090),
            per_axle=2, unsprung=1000, reference="jounce",
            full_rebound=-1000 * g / 2 / 180e3,  # it hangs: 27.2 mm
            rebound=-1 * inch, jounce=0.205, link=nan, link_angle=nan, pitch_rate=nan,
            windup=9500 / deg,
            table=(
                (-0.130, -0.050, 0.040, 0.120), (-0.0095, -0.0021, 0.0012, 0.0029),
                tuple(map(radians, (1.1, 0.35, -0.4, -0.8))),
            ),
        ),
    },
    lines=(TRANSFER, REAR, FORWARD),
    states=(
        State("full rebound", kind="full rebound", load="empty"),
        State("curb", kind="curb", load="curb"),
        State("empty", kind="empty", load="empty"),
        State("gvw", kind="gvw", load="gvw"),
        State("overload", kind="overload", load="gvw", times=1.1),
        State("jounce", kind="jounce", load="gvw"),
        State("windup", kind="windup", load="gvw"),
        State("braked", kind="windup brake", load="empty"),
        State("half laden", kind="gvw", load="empty", speed=1210 * rpm),
        State("creeping", kind="windup", load="gvw", pitch=radians(0.9), torque=4100,
              speed=130 * rpm),
        State("as measured", load="curb", slopes=_MEASURED),
    ),
    duty=((0.35, 5100, 300 * rpm, nan), (0.65, 1500, 1500 * rpm, nan)),
    prime_mover=1.25,  # diesel, as nothing else is said
    shock=1.2,
    unbalance=False,
    top_speed=1910 * rpm,
    coast=1450 * lbft,
)  # fmt: skip


LIMITS = {  # normal, maximum in SI; or a band
    "joint_angle": (6 * deg, 9 * deg), "joint_angle_min": (0.01, None),
    "compound_angle": (None, 5 * deg), "end_angle_difference": (1 * deg, None),
    "odd_joint_angle": (2 * deg, None),
    "angle_for_speed": (None, 1000), "equivalent_angle": (None, 0.05),
    "torsional_acceleration": (300, 500), "inertia_drive_acceleration": (1000, 2000),
    "inertia_coast_acceleration": (1000, 2000), "inertia_drive_torque": (None, 50),
    "inertia_coast_torque": (None, 40 * lbft), "irregularity": (None, 0.0027),
    "centre_bearing_static": (None, 400 * lbf), "centre_bearing_dynamic": (None, 1200),
    "centre_bearing_peak": (None, 2500), "gearbox_bearing_force": (None, 9000),
    "pinion_bearing_force": (None, 9000), "spline_force": (None, 20000),
    "critical_speed_ratio": (None, 0.75), "joint_torque_utilisation": (None, 1),
    "joint_fatigue_utilisation": (None, 1), "tube_shear_utilisation": (None, 0.67),
    "joint_life": (10000 * 3600, 5000 * 3600), "n_beta": (None, 20000 * rpm * deg),
    "joint_speed": (None, 4000 * rpm), "spline_travel_margin": (0.4 * inch, 0.2 * inch),
    "clearance": (0.030, 0.020), "suspension_frequency": (1.3, None),
    "torque": (None, 12000), "engine_torque": (None, 9000 * lbft), "slip_torque": (None, 15000),
    "coast_torque": (None, 4000), "low_gear_torque": (None, 10000),
    "wheel_slip_torque": (None, 9000), "speed": (None, 300), "axle_load": (None, 100e3),
    "driven_load": (None, 40000 * lbf), "axle_travel": (None, 2 * inch),
    "pinion_pitch": (None, 0.02), "joint_position": (None, 270 * deg),
    "side_angle": (None, 6 * deg), "top_angle": (None, 1 * deg), "joint_force": (None, 3000),
    "critical_speed": (None, 4000 * rpm), "line_critical_speed": (None, 4000 * rpm),
    "bearing_resonance": (None, 600 * rpm), "spline_travel": (None, 0.010),
}  # fmt: skip
"""The limits of the files, all made up."""
BAND = (0.42, 0.58)
"""Of the critical speed: the joints shake it twice a turn."""
SHOWN = {
    "deg": (deg, ("joint_angle", "joint_angle_min", "compound_angle", "end_angle_difference",
                  "odd_joint_angle", "equivalent_angle", "pinion_pitch", "joint_position",
                  "side_angle", "top_angle")),
    "rad/s²": (1, ("angle_for_speed", "torsional_acceleration", "inertia_drive_acceleration",
                   "inertia_coast_acceleration")),
    "N·m": (1, ("inertia_drive_torque", "inertia_coast_torque", "torque", "engine_torque",
                "slip_torque", "coast_torque", "low_gear_torque", "wheel_slip_torque")),
    "N": (1, ("centre_bearing_static", "centre_bearing_dynamic", "centre_bearing_peak",
              "gearbox_bearing_force", "pinion_bearing_force", "spline_force", "joint_force",
              "axle_load", "driven_load")),
    "h": (3600, ("joint_life",)),
    "deg/min": (rpm * deg, ("n_beta",)),
    "rpm": (rpm, ("joint_speed", "speed", "critical_speed", "line_critical_speed",
                  "bearing_resonance")),
    "mm": (mm, ("spline_travel_margin", "clearance", "spline_travel", "axle_travel")),
    "Hz": (1, ("suspension_frequency",)),
    "": (1, ("irregularity", "critical_speed_ratio", "half_critical_band",
             "joint_torque_utilisation", "joint_fatigue_utilisation", "tube_shear_utilisation")),
}  # fmt: skip
"""Units in which readers see the quantities, and what they are worth."""
MORE_IS_BETTER = (
    "joint_angle_min", "joint_life", "spline_travel_margin", "clearance", "critical_speed",
    "line_critical_speed",
)  # fmt: skip

# --------------------------------------------------------------------------- 1  loads on the axles


def load_at_rest(truck, load, slope=0.0):
    """Front axles and rear group, N: moments about the front axle's contact."""
    held = sum(a for a, _ in load.auxiliary)
    lever = sum(a * x for a, x in load.auxiliary)
    rear = (load.weight * cos(slope) * load.behind - lever) / truck.wheelbase
    return load.weight * cos(slope) - held - rear, rear


def load_at_slip(truck, load, friction, front_driven, rear_driven, *, on_air=0.0):
    """The same while the driven wheels are about to slip, on the truck's grade.

    Unknown front F and rear R: F + R stays, and R grows by the force mu (sf F + sr R + A)
    times h/L, with A the load of wheels on air if they brake too. Two equations.
    """
    front, rear = load_at_rest(truck, load, truck.grade)
    moved = friction * load.height / truck.wheelbase
    equations = [[1.0, 1.0], [-moved * front_driven, 1.0 - moved * rear_driven]]
    return np.linalg.solve(equations, [front + rear, rear + moved * on_air])


def loads_on(truck, line, state):
    """On this line's axle at rest; on its wheels at rest, driving, coasting; axle braked. N."""
    load = truck.loads[state.load]

    def group(front, rear):
        parts = {"rear": (0, 1), "front": (1, 0), "all": (1, 1)}[line.drives]
        return (
            parts[0] * front * truck.driven_front + parts[1] * rear * truck.driven_rear
        ) * state.times

    axles = {
        "rear": truck.rear_axles,
        "front": truck.front_axles,
        "all": truck.rear_axles + truck.front_axles,
    }[line.drives]
    shares = truck.driven_front, truck.driven_rear
    still = group(*load_at_rest(truck, load))
    drive = group(*load_at_slip(truck, load, truck.friction, *shares))
    coast = group(*load_at_slip(truck, load, -truck.friction, *shares))
    # Where others unload this group, they push as little as the line's share leaves them.
    most, alone = {"drive": drive, "coast": coast}, line.load_share / line.push
    if line.drives == "front":
        lone = load_at_slip(truck, load, truck.friction, alone * truck.driven_front, 0.0)
        most["drive"] = max(drive, group(*lone))
    if line.drives == "rear":
        lone = load_at_slip(truck, load, -truck.friction, 0.0, alone * truck.driven_rear)
        most["coast"] = max(coast, group(*lone))
    on_air = sum(a for a, _ in load.auxiliary)
    height = load.height / truck.wheelbase
    pulls, drags = (
        k * truck.friction * (load_at_slip(truck, load, k * truck.friction, *shares) @ shares)
        for k in (1, -1)
    )
    all_brake = -truck.friction * (
        sum(load_at_slip(truck, load, -truck.friction, 1.0, 1.0, on_air=on_air)) + on_air
    )
    # What a newton moves onto this line's axle: off the front, onto the rear group.
    onto = group(-height, height) / axles
    if line.drives != "all" and state.kind in ("full rebound", "rebound", "jounce"):
        springs = truck.springs[line.springs]
        there = through(deflection(springs, state.kind, nan), springs.deflections, springs.loads)
        tyres = max(springs.per_axle * there + springs.unsprung * g, 0.0)
        tyres = tyres if tyres > 1e-6 else 0.0  # it hangs, but for rounding
        behind = line.load_share * axles * tyres
        rest = line.load_share * still  # J3311 asks for the load state's
        return {"axle": tyres, "brake": tyres, "rest": rest, "drive": behind, "coast": behind}
    brake = group(*load_at_slip(truck, load, -truck.friction, 1.0, 1.0, on_air=on_air))
    return {
        "axle": still / axles,
        "rest": line.load_share * still,
        "drive": line.load_share * most["drive"],
        "coast": line.load_share * most["coast"],
        "brake": brake / axles,
        "onto": {
            "newton": onto / state.times,
            "all wheels": sorted([onto * pulls, onto * drags]),
            "brake": onto * all_brake,
            "slope": (group(*load_at_rest(truck, load, truck.grade)) - still) / axles,
        },
    }


# --------------------------------------------------------------------------- 2  torque and speed


def torques(truck, line, state, load):
    """Torque of a line, N m: engine, slip, coast, J3311's two, and what governs."""
    lowest = truck.ratios[0] * truck.transfer
    best = max(t for _, t in truck.engine)
    engine = best * lowest * truck.converter * truck.efficiency * line.torque_share
    held = truck.engine_brake * lowest / truck.efficiency * line.torque_share
    grip = truck.friction * truck.static_radius / line.axle_ratio
    slip = grip * load["drive"] / line.axle_efficiency
    slip_back = grip * load["coast"] * line.axle_efficiency
    coast = min(held, slip_back) if isnan(truck.coast) else truck.coast * line.torque_share
    if not isnan(state.torque):
        torque = state.torque * line.torque_share
        if state.kind == "windup brake":
            torque = -torque  # a size; it holds back
    elif state.kind == "windup brake":
        torque = -coast
    else:
        torque = min(t for t in (engine, slip) if not isnan(t))
    # J3311-1: LGT = T TLGR TE SR TCR C, and WST = 0.71 W RR / (11.4 AR) in lb, in and lb-ft
    case = truck.transfer * (0.95 if truck.transfer != 1 else 1.0)
    low_gear = best * truck.ratios[0] * truck.gearbox_efficiency_j3311 * truck.converter * case
    wheel_slip = 0.71 * (load["rest"] / lbf) * (truck.dynamic_radius / inch)
    return {
        "torque": torque,
        "engine": engine,
        "slip": slip,
        "coast": coast,
        "low_gear": low_gear * line.torque_share,
        "wheel_slip": wheel_slip / (11.4 * line.axle_ratio) * lbft,
    }


def speed(truck, line, state):
    """Speed of a line, rad/s: governed speed in top gear, in wind-up in the lowest."""
    governed = truck.engine[-1][0]
    if not isnan(state.speed):
        output = state.speed
    elif state.kind == "windup":  # full torque is there in the lowest gear alone
        output = governed / (truck.ratios[0] * truck.transfer)
    elif not isnan(truck.top_speed):
        output = truck.top_speed
    else:
        output = governed / truck.ratios[-1]
    return output * line.speed_ratio


def reached_speed(truck, line, state):
    """Speed at which whirling is asked, rad/s: what engine and top gear reach, if that is more."""
    asked = speed(truck, line, state)
    if not isnan(state.speed) or state.kind == "windup":
        return asked
    return max(asked, truck.engine[-1][0] / truck.ratios[-1] * line.speed_ratio)


def nearest_to_half(*ratios):
    """Ratio of a speed to the critical one that is least off its half, 0.42 to 0.58."""
    return min(ratios, key=lambda of: max((0.42 - of) / 0.42, (of - 0.58) / 0.58))


# --------------------------------------------------------------------------- 3  where the axle is


def through(x, xs, ys):
    """Straight lines through a table, its ends going on."""
    k = 0
    while k < len(xs) - 2 and x > xs[k + 1]:
        k += 1
    return ys[k] + (ys[k + 1] - ys[k]) / (xs[k + 1] - xs[k]) * (x - xs[k])


def spring_load(springs, axle_load):
    return (axle_load - springs.unsprung * g) / springs.per_axle


def deflection(springs, kind, axle_load):
    stops = {"full rebound": springs.full_rebound, "rebound": springs.rebound,
             "jounce": springs.jounce}  # fmt: skip
    if kind in stops:
        return stops[kind]
    return through(spring_load(springs, axle_load), springs.loads, springs.deflections)


def suspension_frequency(springs, axle_load):
    """Of the mass a spring carries on its rate there, Hz."""
    load = spring_load(springs, axle_load)
    k = 0
    while k < len(springs.loads) - 2 and load > springs.loads[k + 1]:
        k += 1
    rate = (springs.loads[k + 1] - springs.loads[k]) / (
        springs.deflections[k + 1] - springs.deflections[k]
    )
    return sqrt(rate / (load / g)) / (2 * pi)


def axle_motion(truck, line, state, load, torque, *, driven=0.0):
    """Rise, rearward motion (m) and pitch (rad, pinion nose up) from the reference state.

    States of wind-up are moved by their torque, others by what drives them, if anything does.
    """
    springs = truck.springs[line.springs]
    at_reference = nan
    if springs.reference in truck.loads:
        at_reference = loads_on(truck, line, State("", load=springs.reference))["axle"]
    reference = deflection(springs, springs.reference, at_reference)
    if state.kind:
        rise = deflection(springs, state.kind, load["axle"]) - reference
    else:
        rise = 0.0 if isnan(state.travel) else state.travel
    through_axle = line.axle_ratio / line.axles_behind
    housing = 0.0
    if state.kind == "windup":
        driven = torque["torque"]
    if driven and state.kind != "windup brake":
        # The wheels push the ground back; the housing turns a nose that faces ahead up.
        housing = driven * through_axle * line.axle_efficiency
        push = housing * line.axles_behind / truck.static_radius / line.push
        least, most = load["onto"]["all wheels"]
        moved = min(max(load["onto"]["newton"] * push, least), most)
    if state.kind == "windup brake":
        held = springs.brake - torque["torque"] * through_axle / line.axle_efficiency
        grip = truck.friction * truck.static_radius * load["brake"]
        housing = -(min(held, grip) if springs.brake else grip)
        moved = load["onto"]["brake"] * -housing / grip
    if housing and line.name not in state.slopes:  # its springs hold it
        moved += load["onto"]["slope"]
        rise += squat(
            springs, line.ahead, rise, load["axle"], moved, housing, truck.static_radius,
            stands=reference + rise,
        )  # fmt: skip
    rearward, pitch = led(springs, rise)
    pitch += line.ahead * housing / springs.windup if housing and isnan(state.pitch) else 0.0
    if not isnan(state.pitch):
        pitch = state.pitch
    return rise, rearward, pitch


def led(springs, rise):
    """Rearward way and pitch of an axle that has risen."""
    if springs.table:
        rises, ways, turns = springs.table
        rearward = through(rise, rises, ways) - through(0, rises, ways)
        return rearward, through(rise, rises, turns) - through(0, rises, turns)
    # The link's pivot is ahead of the axle: as the axle rises the link turns about it.
    angle = asin(sin(springs.link_angle) - rise / springs.link)
    return springs.link * (cos(angle) - cos(springs.link_angle)), springs.pitch_rate * rise


def squat(springs, ahead, rise, axle_load, moved, housing, radius, *, stands):
    """How far the axle rises until no more work is done on it: halving, between the stops.

    A little further up, the springs take work; the load moved onto the axle does some, and so
    does the tyre's force, where tyre and ground meet: as the axle goes and as it pitches, wheels
    locked to it by a driveline that stands. Its stops are as far as from where it `stands`.
    """
    at_rest = through(spring_load(springs, axle_load), springs.loads, springs.deflections)
    force = housing / radius

    def left(up):
        there = through(at_rest + up, springs.deflections, springs.loads)
        taken = springs.per_axle * there - (axle_load - springs.unsprung * g)
        if springs.table:  # straight from row to row: about a millimetre each way
            step = 1e-3
            before, after = (led(springs, rise + up + k * step) for k in (-1, 1))
            slope, turn = ((b - a) / (2 * step) for a, b in zip(before, after, strict=True))
        else:
            slope = tan(asin(sin(springs.link_angle) - (rise + up) / springs.link))
            turn = springs.pitch_rate
        at_ground = force * (-slope + ahead * radius * turn)
        return moved + at_ground - taken

    low = min(springs.full_rebound - stands, 0.0)
    high = max(springs.jounce - stands, 0.0)
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if left(middle) > 0 else (low, middle)
    return (low + high) / 2


# --------------------------------------------------------------------------- 4  where the line runs


def unit(v):
    return np.asarray(v, float) / np.linalg.norm(v)


def direction(side, top):
    """Direction with slopes seen in side and top view."""
    return unit([1.0, tan(top), -tan(side)])


def laid_out(line, side, top, last=None, start=None):
    """Joint centres and directions of the members."""
    d = np.array([direction(s, t) for s, t in zip(side, top, strict=True)])
    lengths = [s.length for s in line.shafts]
    if last is not None:
        lengths[-1] = last
    points = [np.array(line.start if start is None else start)]
    for along, length in zip(d[1:-1], lengths, strict=True):
        points.append(points[-1] + length * along)
    return np.array(points), d


def nose_up(v, pitch):
    """A vector turned about y so that what points ahead (-x) rises."""
    x, y, z = v
    return np.array([x * cos(pitch) + z * sin(pitch), y, z * cos(pitch) - x * sin(pitch)])


def ridden(line, motion):
    """The line after its axle has moved: the chain stays connected.

    The frame holds joint 1 (unless it rides on an axle) and the centre bearings; each hung
    shaft runs from its front joint through its bearing; the spline takes up the rest.
    """
    points, d = laid_out(line, line.side, line.top)
    rise, rearward, pitch = motion

    def carried(point, arm):
        arm = np.array([arm[0], 0.0, arm[1]])
        moved = np.array([line.ahead * rearward, 0.0, rise])
        return point + moved + nose_up(arm, pitch) - arm

    new, along = points.copy(), d.copy()
    if line.output:
        new[0], along[0] = carried(points[0], line.output), nose_up(d[0], pitch)
    for k, shaft in enumerate(line.shafts[:-1]):
        bearing = points[k] + shaft.to_bearing * d[k + 1]  # fixed to the frame
        new[k + 1] = new[k] + shaft.length * unit(bearing - new[k])
    new[-1], along[-1] = carried(points[-1], line.pinion), nose_up(d[-1], pitch)
    for k in range(len(line.shafts)):
        along[k + 1] = unit(new[k + 1] - new[k])
    return new, along


def angle_between(u, v):
    return atan2(np.linalg.norm(np.cross(u, v)), float(np.dot(u, v)))


def view_angles(d):
    """Change of side and top view slope at every joint, rad."""
    side, top = np.arctan2(-d[:, 2], d[:, 0]), np.arctan2(d[:, 1], d[:, 0])
    return np.diff(side), np.diff(top)


def segment_distance(a, b, c, e):
    """Shortest distance of segments ab and ce: golden section, as distance is convex."""

    def to_segment(p):
        along = e - c
        size = along @ along
        s = 0.0 if size == 0 else min(1.0, max(0.0, (p - c) @ along / size))
        return float(np.linalg.norm(p - c - s * along))

    low, high, ratio = 0.0, 1.0, (sqrt(5) - 1) / 2
    for _ in range(60):
        s, t = high - ratio * (high - low), low + ratio * (high - low)
        if to_segment(a + s * (b - a)) < to_segment(a + t * (b - a)):
            high = t
        else:
            low = s
    return to_segment(a + low * (b - a))


# --------------------------------------------------------------------------- 5  how it turns

N = 720
THETA = 2 * pi * np.arange(N) / N


def peak(samples):
    """Largest size of a smooth periodic quantity: harmonics, then a parabola on the crest."""
    samples = np.asarray(samples)
    best = 0.0
    for sign in (1, -1):
        values = sign * samples
        k = int(np.argmax(values))
        c = np.fft.rfft(values)[:49] / N
        c[1:] *= 2
        theta = THETA[k] + np.array([-1, 0, 1]) * 1e-3
        for _ in range(3):
            low, mid, high = (np.exp(1j * np.outer(theta, np.arange(49))) @ c).real
            bend = low - 2 * mid + high
            if bend >= 0:
                break
            theta = theta + (theta[1] - theta[0]) * (low - high) / (2 * bend)
        best = max(best, values[k], mid)
    return best


def derivative(samples):
    """Of a smooth periodic quantity, by its harmonics."""
    orders = 1j * np.arange(N // 2 + 1)
    orders[-1] = 0
    return np.fft.irfft(np.fft.rfft(samples) * orders, N)


def integral(samples):
    """Of a smooth periodic quantity without a mean, by its harmonics, from theta = 0."""
    orders = np.arange(N // 2 + 1).astype(complex)
    orders[0] = 1
    c = np.fft.rfft(samples) / (1j * orders)
    c[0] = c[-1] = 0
    values = np.fft.irfft(c, N)
    return values - values[0]


def turned(d, phases):
    """Turn a chain: speed ratios (members, N), and per unit of gearbox torque the torque of
    each member (members, N) and the moment of each cross on the member behind (joints, N, 3).
    """
    e1 = unit(np.cross([0.0, 0.0, 1.0], d[0]))
    e2 = np.cross(d[0], e1)
    a = np.cos(THETA)[:, None] * e1 + np.sin(THETA)[:, None] * e2  # driving pin axis
    ratios, carried, moments = [np.ones(N)], [np.ones(N)], []
    for k in range(len(d) - 1):
        before, behind = d[k], d[k + 1]
        b = np.cross(behind, a)
        b /= np.linalg.norm(b, axis=1)[:, None]  # driven pin axis
        m = np.cross(a, b)  # the cross's plane
        ratios.append(ratios[-1] * (m @ before) / (m @ behind))
        moment = carried[-1][:, None] * (behind - a * (a @ behind)[:, None]) / (before @ behind)
        moments.append(moment)
        carried.append(moment @ behind)
        if k < len(phases):
            eps = phases[k]  # right-handed about the shaft
            a = b * cos(eps) + np.cross(behind, b) * sin(eps)
    return np.array(ratios), np.array(carried), np.array(moments)


def equivalent(phasor):
    """Angle of the one joint of this phasor: |E| = tan²(beta/2)."""
    return 2 * atan(sqrt(abs(phasor)))


def excitation(ratios, speed, inertias):
    """Torsional, drive and coast excitation at a speed, rad/s."""
    last, shafts = ratios[-1], ratios[1:-1]
    turning = derivative  # d(w/w0)/dtheta times w0² is the acceleration
    alpha = np.array([turning(r) for r in ratios])
    # Seen from a pinion that turns uniformly: w_j/w_n, over the pinion's own angle.
    back = np.array([turning(r / last) / last for r in ratios])
    behind = THETA + integral(last - last.mean())
    order_2 = np.exp(-2j * THETA)
    phasors = (ratios * order_2).mean(axis=1)
    from_axle = (shafts * np.exp(-2j * behind)).mean(axis=1)
    J = np.array(inertias)
    return {
        "equivalent_angle": equivalent(phasors[-1]),
        "torsional_acceleration": speed**2 * peak(alpha[-1]),
        "irregularity": peak(last - 1 + 1) + peak(-(last - 2)) - 2,
        "drive_angle": equivalent(phasors[1:-1].sum()),
        "coast_angle": equivalent(from_axle.sum()),
        "inertia_drive_acceleration": speed**2 * peak(alpha[1:-1].sum(axis=0)),
        "inertia_coast_acceleration": speed**2 * peak(back[1:-1].sum(axis=0)),
        "inertia_drive_torque": speed**2 * peak(J @ alpha[1:-1]),
        "inertia_coast_torque": speed**2 * peak(J @ back[1:-1]),
    }


def signs(phases):
    """s_k of AE-7: an aligned shaft flips the sign, a crossed one keeps it."""
    found = [1 + 0j]
    for eps in phases:
        found.append(-found[-1] * np.exp(2j * eps))
    return np.array(found)


def sum_of_squares(side, top, phases, speed, inertias, acceleration=None):
    """AE-7's phasors of small angles: angle, acceleration, inertia torque, irregularity."""
    squares = signs(phases) * (top + 1j * side) ** 2
    n = len(squares)
    sums = np.cumsum(squares)[:-1]  # of each shaft
    rear = sums - squares.sum()  # the same from the axle end
    J = np.array(inertias)
    drive = sum((n - k) * squares[k - 1] for k in range(1, n))
    coast = sum((k - 1) * squares[k - 1] for k in range(2, n + 1))
    found = {}
    for way, P, sums_of_shafts in (
        ("torsional", squares.sum(), None), ("drive", drive, sums), ("coast", coast, rear)
    ):  # fmt: skip
        angle = sqrt(abs(P))
        how = acceleration or (lambda angle: speed**2 * angle**2)
        found[way] = {"equivalent_angle_deg": angle / deg, "acceleration_rad_s2": how(angle)}
        if sums_of_shafts is None:
            found[way]["irregularity"] = sin(angle) * tan(angle)
        else:
            found[way]["torque_Nm"] = speed**2 * abs(J @ sums_of_shafts)
    return found


def approximations(side, top, phases, speed, inertias):
    """The field's, by name: AE-7's sum, as if in one plane, and two printed accelerations."""
    of = (phases, speed, inertias)
    return {
        "ae7": sum_of_squares(side, top, *of),
        "in_plane": sum_of_squares(0 * side, np.hypot(side, top), *of),
        "spicer_sine": sum_of_squares(side, top, *of, lambda b: (speed * sin(b)) ** 2),
        "spicer_rpm": sum_of_squares(
            side, top, *of, lambda b: 3.3403e-6 * (speed / rpm) ** 2 * (b / deg) ** 2
        ),
    }


# --------------------------------------------------------------------------- 6  forces


def equilibrium(line, points, d, at_ends, moments, thrust=0.0):
    """Forces of the joints on what is behind them, and on the bearings: one linear system.

    Unknown: F_1 ... F_n, then B_1 ... B_(n-2), three components each. A shaft feels F_k at
    its front, -F_(k+1) at its rear, what acts at its ends, the crosses' moments M_k and
    -M_(k+1), and -B_k from its bearing, which slides along it. The last shaft's two halves
    slide on each other: no more than `thrust` pulls between them; or, where the gearbox flange
    floats, that does.

    `at_ends` (shafts, 2, ..., 3) N, `moments` (joints, ..., 3) N m.
    """
    shafts = len(line.shafts)
    size = 6 * shafts
    extra = at_ends.shape[2:-1]
    A, rhs = np.zeros((size, size)), np.zeros((size, *extra))
    row = 0

    def joint(k):
        return slice(3 * k, 3 * k + 3)

    def bearing(k):
        return slice(3 * (shafts + 1 + k), 3 * (shafts + 1 + k) + 3)

    for k, shaft in enumerate(line.shafts):
        along = d[k + 1]
        length = float(np.linalg.norm(points[k + 1] - points[k]))
        e1 = unit(np.cross(along, [0.0, 0.0, 1.0]))
        e2 = np.cross(along, e1)
        front, rear = at_ends[k, 0], at_ends[k, 1]
        hung = k < shafts - 1
        # Forces: three directions of a hung shaft, two of a sliding one.
        for e in (e1, e2, along) if hung else (e1, e2):
            A[row, joint(k)], A[row, joint(k + 1)] = e, -e
            if hung:
                A[row, bearing(k)] = -e
            rhs[row] = -(front + rear) @ e
            row += 1
        # Moments about the front joint, across the shaft: e . (d x F) = F . (e x d).
        for e in (e1, e2):
            lever = np.cross(e, along)
            A[row, joint(k + 1)] = -length * lever
            if hung:
                A[row, bearing(k)] = -shaft.to_bearing * lever
            rhs[row] = -(moments[k] - moments[k + 1]) @ e - length * (rear @ lever)
            row += 1
        if hung:
            A[row, bearing(k)] = along  # a bearing does not hold its shaft along it
            row += 1
        elif not line.floating:
            A[row, joint(k)] = along
            rhs[row] = -front @ along - thrust
            A[row + 1, joint(k + 1)] = -along
            rhs[row + 1] = -rear @ along + thrust
            row += 2
        else:
            # The last shaft carries thrust; nothing holds the flange along its axis.
            A[row, joint(k)], A[row, joint(k + 1)] = along, -along
            rhs[row] = -(front + rear) @ along
            A[row + 1, joint(0)] = d[0]
            rhs[row + 1] = -thrust
            row += 2
    found = np.linalg.solve(A, rhs.reshape(size, -1)).reshape(size // 3, 3, *extra)
    found = np.moveaxis(found, 1, -1)
    return found[: shafts + 1], found[shafts + 1 :]


def small_angles(line, d, lengths, phases, few=1e-4):
    """Histories of the bearings' forces per torque and angle, as all angles go to nothing."""
    slopes = zip(np.arctan2(-d[:, 2], d[:, 0]), np.arctan2(d[:, 1], d[:, 0]), strict=True)
    flat = np.array([direction(few * side, few * top) for side, top in slopes])
    steps = [length * along for length, along in zip(lengths, flat[1:-1], strict=True)]
    points = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    at_ends = np.zeros((len(lengths), 2, N, 3))
    forces = equilibrium(line, points, flat, at_ends, turned(flat, phases)[2])[1] / few
    forces[..., 0] = 0.0  # along the line nothing is left
    return forces


def end_masses(shaft):
    """Half the tube and its own yoke at each end, the spline by its lever, kg."""
    tube = shaft.tube.rho * shaft.tube.area * shaft.length
    rear = shaft.spline_at / shaft.length
    return (
        tube / 2 + shaft.yokes[0] + shaft.spline_mass * (1 - rear),
        tube / 2 + shaft.yokes[1] + shaft.spline_mass * rear,
    )


def ellipse(history):
    """0-to-peak of order 2 along the major axis of its ellipse."""
    c = 2 * np.fft.fft(history, axis=0)[2] / N
    return float(np.linalg.svd(np.array([c.real, c.imag]), compute_uv=False)[0])


def crest(history):
    """Largest size of a vector over the turn, (N, 3)."""
    return sqrt(peak((history**2).sum(axis=1)))


def unbalance_forces(line, points, d, speed):
    """Worst force once a turn on each bearing: m/2 G w turning at each end of each shaft.

    Where the heavy spots are nobody knows: those of all ends act together.
    """
    shafts = len(line.shafts)
    total = np.zeros(shafts - 1)
    for k, shaft in enumerate(line.shafts):
        force = shaft.mass / 2 * (shaft.grade * mm) * speed
        e1 = unit(np.cross(d[k + 1], [0.0, 0.0, 1.0]))
        e2 = np.cross(d[k + 1], e1)
        for end in (0, 1):
            at_ends = np.zeros((shafts, 2, 2, 3))
            at_ends[k, end] = force * np.array([e1, e2])
            _, found = equilibrium(line, points, d, at_ends, np.zeros((shafts + 1, 2, 3)))
            for b in range(shafts - 1):
                total[b] += np.linalg.svd(found[b], compute_uv=False)[0]
    return total


def flange_bearings(force, moment, outward, spacing, overhang):
    """Histories of the radial forces on the far and near bearing behind a flange, N.

    Moments about the near one, across the axis: M + b o x F = -a o x F_far.
    """
    across = force - (force @ outward)[:, None] * outward
    about_near = moment + overhang * np.cross(outward, across)
    far = np.cross(outward, about_near) / spacing
    return far, across - far


def end_bearings(line, d, forces, moments):
    """Largest radial forces behind the flanges, by GWB's letters; nan where nobody says."""
    ends = dict.fromkeys("ABEF", nan)
    if line.gearbox_bearings:
        far, near = flange_bearings(-forces[0], -moments[0], d[0], *line.gearbox_bearings)
        ends |= {"A": crest(far), "B": crest(near)}
    if line.pinion_bearings:
        far, near = flange_bearings(forces[-1], moments[-1], -d[-1], *line.pinion_bearings)
        ends |= {"F": crest(far), "E": crest(near)}
    return ends


# --------------------------------------------------------------------------- 7  whirl


def tube_critical_speed(tube, length):
    """Of a uniform pinned tube, rad/s: (pi/L)² sqrt(EI/rho A)."""
    return (pi / length) ** 2 * sqrt(tube.E * tube.I / (tube.rho * tube.area))


def line_whirl(line, pieces=24):
    """Lowest speeds, rad/s, at which the line bends, and at which it bounces on its rubber.

    The line as installed, straight, hinged at its joints. Each shaft is cut into short
    Timoshenko beams; half of a piece's mass and rotary inertia sits at each of its ends.
    Whirl v cos(wt) up, w sin(wt) to the side, once a turn: K x = w² (M - J between planes) x.
    """
    lengths = [s.length for s in line.shafts]
    cuts = []
    for k, shaft in enumerate(line.shafts):
        marks = {0.0, lengths[k]}
        if shaft.rubber:
            marks.add(shaft.to_bearing)
        if shaft.spline_mass:
            marks.add(shaft.spline_at)
        marks, at = sorted(marks), [0.0]
        for low, high in pairwise(marks):
            count = max(2, round(pieces * (high - low) / lengths[k]))
            at += [low + (high - low) * i / count for i in range(1, count + 1)]
        cuts.append(at)
    # Freedoms of one plane: a rotation at every node; deflections, shared at the joints,
    # none at the first and last joint.
    free = 0
    deflect, rotate = [], []
    for k, at in enumerate(cuts):
        w, t = [], []
        for i in range(len(at)):
            t.append(free)
            free += 1
            if i == 0:
                w.append(-1 if k == 0 else deflect[-1][-1])
            elif i == len(at) - 1 and k == len(cuts) - 1:
                w.append(-1)
            else:
                w.append(free)
                free += 1
        deflect.append(w)
        rotate.append(t)
    K, M, J = np.zeros((free, free)), np.zeros(free), np.zeros(free)
    rubber = np.zeros((2, free))

    def put(values, place, amount):
        if place >= 0:
            values[place] += amount

    for k, (shaft, at) in enumerate(zip(line.shafts, cuts, strict=True)):
        tube = shaft.tube
        m2 = (tube.inner / tube.outer) ** 2
        kappa = (  # Cowper 1966
            6 * (1 + tube.nu) * (1 + m2) ** 2
            / ((7 + 6 * tube.nu) * (1 + m2) ** 2 + (20 + 12 * tube.nu) * m2)
        )  # fmt: skip
        G = tube.E / (2 * (1 + tube.nu))
        for i in range(len(at) - 1):
            h = at[i + 1] - at[i]
            phi = 12 * tube.E * tube.I / (kappa * G * tube.area * h**2)
            stiff = tube.E * tube.I / (h**3 * (1 + phi)) * np.array([
                [12, 6 * h, -12, 6 * h],
                [6 * h, (4 + phi) * h**2, -6 * h, (2 - phi) * h**2],
                [-12, -6 * h, 12, -6 * h],
                [6 * h, (2 - phi) * h**2, -6 * h, (4 + phi) * h**2],
            ])  # fmt: skip
            places = [deflect[k][i], rotate[k][i], deflect[k][i + 1], rotate[k][i + 1]]
            for p, at_p in enumerate(places):
                for q, at_q in enumerate(places):
                    if at_p >= 0 and at_q >= 0:
                        K[at_p, at_q] += stiff[p, q]
            for j in (i, i + 1):
                put(M, deflect[k][j], tube.rho * tube.area * h / 2)
                put(M, rotate[k][j], tube.rho * tube.I * h / 2)
                put(J, rotate[k][j], 2 * tube.rho * tube.I * h / 2)
        for i, yoke in ((0, shaft.yokes[0]), (-1, shaft.yokes[1])):
            put(M, deflect[k][i], yoke)
            # Half the yokes' inertia at each end; across the shaft a yoke has as much.
            put(M, rotate[k][i], shaft.yoke_inertia / 2)
            put(J, rotate[k][i], shaft.yoke_inertia / 2)
        if shaft.spline_mass:
            put(
                M,
                deflect[k][int(np.argmin(np.abs(np.array(at) - shaft.spline_at)))],
                shaft.spline_mass,
            )
        if shaft.rubber:
            bearing = deflect[k][int(np.argmin(np.abs(np.array(at) - shaft.to_bearing)))]
            for plane in (0, 1):
                rubber[plane, bearing] += shaft.rubber[plane]
    zero = np.zeros((free, free))
    stiffness = np.block([[K + np.diag(rubber[0]), zero], [zero, K + np.diag(rubber[1])]])
    mass = np.block([[np.diag(M), -np.diag(J)], [-np.diag(J), np.diag(M)]])
    inverse = np.linalg.inv(np.linalg.cholesky(stiffness))
    found, x = np.linalg.eigh(inverse @ mass @ inverse.T)
    bends, bounces = inf, inf
    for value, mode in zip(found[::-1], x.T[::-1], strict=True):
        if value <= 0 or (bends < inf and bounces < inf):
            break
        shape = inverse.T @ mode
        v, w = shape[:free], shape[free:]
        energy = shape @ stiffness @ shape
        in_rubber = (rubber[0] @ v**2 + rubber[1] @ w**2) / energy
        forward = 0.5 + (M * v * w).sum() / (M * (v**2 + w**2)).sum()
        if forward < 0.01:
            continue  # backward: unbalance does not excite it
        speed = 1 / sqrt(value)
        if in_rubber < 0.9:
            bends = min(bends, speed)
        elif RIGID not in [s.rubber for s in line.shafts]:
            bounces = min(bounces, speed)
    return bends, bounces


# --------------------------------------------------------------------------- 8  strength, life


def tube_shear(tube, torque):
    """Shear stress at the outside over yield in shear, by torsion of a round section."""
    stress = torque * (tube.outer / 2) / (2 * tube.I)
    return stress / (tube.strength / sqrt(3))


def fatigue(joint, highest, lowest):
    """Share of the fatigue rating of a torque that swings between two values.

    Reversing torque (mean 0) of Tdw is 1, pulsating (mean = amplitude = Tds/2) is 1; straight
    between.
    """
    swing, mean = abs(highest - lowest) / 2, abs(highest + lowest) / 2
    return swing / joint.reversing + mean * (2 / joint.pulsating - 1 / joint.reversing)


def life(truck, line, joint, angles):
    """Hours of a joint over the duty cycle: L = 1.5e6/(n beta K1) (Td/T)^(10/3)."""
    damage = 0.0
    for (share, torque, turning, own), angle in zip(truck.duty, angles, strict=True):
        beta = max(3.0, (angle if isnan(own) else own) / deg)
        n = turning * line.speed_ratio / rpm
        T = torque * line.torque_share
        hours = 1.5e6 / (n * beta * truck.prime_mover) * (joint.Td / T) ** (10 / 3)
        damage += share / hours
    return 1 / damage


# --------------------------------------------------------------------------- everything together

RARE = ("full rebound", "rebound", "jounce", "windup", "windup brake")
"""States nobody drives in for long: no life is spent in them."""
WITH_SPEED = (
    "angle_for_speed", "torsional_acceleration", "inertia_drive_acceleration",
    "inertia_coast_acceleration", "inertia_drive_torque", "inertia_coast_torque",
    "critical_speed_ratio", "half_critical_band", "n_beta", "joint_speed",
)  # fmt: skip
"""Quantities that standing still makes nought, so that nothing is asked."""
WITH_TORQUE = (
    "centre_bearing_dynamic", "spline_force", "joint_torque_utilisation",
    "joint_fatigue_utilisation", "tube_shear_utilisation",
)  # fmt: skip
"""The same of no torque."""


def paired_shafts(shafts):
    """Shafts whose two joints belong together, counted from the rear; and is joint 1 left?"""
    return list(range(shafts, 0, -2)), shafts % 2 == 0


def one_state(truck, line, state, whirl):
    """Everything of one line in one state: values of checks, and numbers of the document."""
    load = loads_on(truck, line, state)
    torque = torques(truck, line, state, load)
    T, w = torque["torque"], speed(truck, line, state)
    reached = reached_speed(truck, line, state)
    reference, d_reference = laid_out(line, line.side, line.top)
    if line.name in state.slopes:
        points, d = laid_out(line, *state.slopes[line.name])
        rise = (points[-1] - points[0] - reference[-1] + reference[0])[2]
    elif line.drives == "all":  # a transfer case is held by the frame
        points, d, rise = reference, d_reference, 0.0
    else:
        motion = axle_motion(truck, line, state, load, torque)
        points, d = ridden(line, motion)
        rise = motion[0]
    phases = [s.phase for s in line.shafts]
    n, shafts = len(line.joints), len(line.shafts)
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    travel = lengths[-1] - line.shafts[-1].length
    beta = [angle_between(d[k], d[k + 1]) for k in range(n)]
    # As the torque of each point of the duty cycle has the axle: of a state driven in for long.
    worn = [beta] * len(truck.duty)
    if state.kind not in RARE and line.name not in state.slopes and line.drives != "all":
        motions = (
            axle_motion(truck, line, state, load, torque, driven=T * line.torque_share)
            for _, T, _, _ in truck.duty
        )
        turns = [ridden(line, motion)[1] for motion in motions]
        worn = [[angle_between(d[k], d[k + 1]) for k in range(n)] for d in turns]
    worn = list(zip(*worn, strict=True))
    side, top = view_angles(d)
    place = [atan2(v, h) % (2 * pi) for v, h in zip(side, top, strict=True)]
    inertias = [s.polar_inertia for s in line.shafts]
    ratios, carried, _ = turned(d, phases)
    shaken = excitation(ratios, w, inertias)
    # What torque makes, it makes of yokes that it has turned: T L / G J, the rear one back.
    back = [T * s.length * 2 * (1 + s.tube.nu) / (s.tube.E * 2 * s.tube.I) for s in line.shafts]
    twisted, _, moments = turned(d, np.subtract(phases, back))

    pull = -g if truck.gravity else 0.0
    weight = np.array([[[0, 0, m * pull] for m in end_masses(s)] for s in line.shafts])
    at_ends = np.broadcast_to(weight[:, :, None, :], (shafts, 2, N, 3))
    joint_forces, bearing_forces = equilibrium(line, points, d, at_ends, T * moments)
    once = unbalance_forces(line, points, d, w) if truck.unbalance else np.zeros(shafts - 1)
    ends = end_bearings(line, d, joint_forces, T * moments)

    critical = [
        tube_critical_speed(s.tube, length) for s, length in zip(line.shafts, lengths, strict=True)
    ]
    spline = line.spline
    slip = abs(T) * spline.friction / spline.radius
    # What speeds the shafts up, as power over the gearbox's speed, is not handed on.
    sped = np.array(
        [J * w**2 * derivative(r) * r for J, r in zip(inertias, twisted[1:-1], strict=True)]
    )
    handed = T - np.concatenate([np.zeros((1, N)), np.cumsum(sped, axis=0)])
    pushed = [equilibrium(line, points, d, at_ends, handed[:, :, None] * moments, f)[0]
              for f in (0.0, slip, -slip)]  # fmt: skip
    strained = np.max([[crest(f) for f in forces] for forces in pushed], axis=0)
    at_worst = [end_bearings(line, d, forces, handed[:, :, None] * moments) for forces in pushed]
    worst_ends = {k: max(found[k] for found in at_worst) for k in "ABEF"}
    # Joints are sized for the engine; where brakes wind the axle up it drives nothing.
    largest = abs(T) if state.kind == "windup brake" else torque["engine"]
    sized = [truck.shock * largest * peak(carried[k]) for k in range(n)]
    gaps = {}
    for o in line.obstacles:
        up = np.array([0, 0, o.share * rise])
        for k, shaft in enumerate(line.shafts, 1):
            free = segment_distance(points[k - 1], points[k], o.start + up, o.end + up)
            gaps[k, o.name] = free - shaft.tube.outer / 2 - o.radius

    value = {}

    def say(quantity, part, number):
        if np.isfinite(number):
            value[quantity, part] = float(number)

    for k in range(n):
        part, joint = f"joint {k + 1}", line.joints[k]
        say("joint_angle", part, beta[k])
        say("joint_angle_min", part, beta[k])
        say("compound_angle", part, hypot(side[k], top[k]))
        say("angle_for_speed", part, w**2 * beta[k] ** 2)
        say("joint_torque_utilisation", part, sized[k] / joint.peak)
        say("joint_fatigue_utilisation", part, fatigue(joint, max(T, 0), -torque["coast"]))
        if state.kind not in RARE:
            say("joint_life", part, 3600 * life(truck, line, joint, worn[k]))
        say("n_beta", part, w * beta[k])
        say("joint_speed", part, w)
        say("joint_position", part, place[k])
        say("side_angle", part, side[k])
        say("top_angle", part, top[k])
        say("joint_force", part, strained[k])
    pairs, odd = paired_shafts(shafts)
    for k in pairs:
        front, rear = (beta[j] * np.exp(1j * place[j]) for j in (k - 1, k))
        apart = abs(front**2 - np.exp(2j * phases[k - 1]) * rear**2)
        say("end_angle_difference", f"shaft {k}", apart / (abs(front) + abs(rear)))
    if odd:
        say("odd_joint_angle", "joint 1", beta[0])
    for quantity in (
        "equivalent_angle", "torsional_acceleration", "irregularity", "inertia_drive_acceleration",
        "inertia_coast_acceleration", "inertia_drive_torque", "inertia_coast_torque",
    ):  # fmt: skip
        say(quantity, "line", shaken[quantity])
    for k in range(n - 2):
        part, history = f"centre bearing {k + 1}", bearing_forces[k]
        say("centre_bearing_static", part, np.linalg.norm(history.mean(axis=0)))
        say("centre_bearing_dynamic", part, ellipse(history))
        say("centre_bearing_peak", part, crest(history) + once[k])
    for letter, force in worst_ends.items():
        say("gearbox_bearing_force" if letter in "AB" else "pinion_bearing_force",
            f"bearing {letter}", force)  # fmt: skip
    say("spline_force", f"shaft {shafts}", slip)
    say(
        "spline_travel_margin", f"shaft {shafts}", min(spline.plunge + travel, spline.draw - travel)
    )
    for k in range(shafts):
        part = f"shaft {k + 1}"
        say("critical_speed_ratio", part, reached / critical[k])
        say("tube_shear_utilisation", part,
            tube_shear(line.shafts[k].tube, truck.shock * abs(T)))  # fmt: skip
    say("critical_speed_ratio", "line", reached / whirl[0])
    if max(beta) > 3 * deg:  # the file asks about half the critical speed above 3 deg only
        for part, of in zip((*(f"shaft {k + 1}" for k in range(shafts)), "line"),
                            (*critical, whirl[0]), strict=True):  # fmt: skip
            say("half_critical_band", part, nearest_to_half(w / of, reached / of))
    for (k, name), gap in gaps.items():
        say("clearance", f"shaft {k} to {name}", gap)
    if line.first_on_springs and state.kind in (
        "curb", "empty", "gvw", "overload", "windup", "windup brake",
    ):  # fmt: skip
        say("suspension_frequency", "line",
            suspension_frequency(truck.springs[line.springs], load["axle"]))  # fmt: skip
    for quantity, number in {
        "torque": T, "engine_torque": torque["engine"], "slip_torque": torque["slip"],
        "coast_torque": torque["coast"], "low_gear_torque": torque["low_gear"],
        "wheel_slip_torque": torque["wheel_slip"], "speed": w, "axle_load": load["axle"],
        "driven_load": load["drive"], "axle_travel": rise,
        "pinion_pitch": atan2(-d[-1][2], d[-1][0]) - line.side[-1],
        "line_critical_speed": whirl[0], "bearing_resonance": whirl[1],
    }.items():  # fmt: skip
        say(quantity, "line", number)
    for k in range(shafts):
        say("critical_speed", f"shaft {k + 1}", critical[k])
    say("spline_travel", f"shaft {shafts}", travel)
    nought = (WITH_SPEED if w == 0 else ()) + (WITH_TORQUE if T == 0 else ())
    value = {key: v for key, v in value.items() if key[0] not in nought}

    # What the weight alone does, and what a line does whose slopes are a ten-thousandth.
    heavy = equilibrium(line, points, d, at_ends[:, :, 0], 0 * moments[:, 0])[1]
    small = small_angles(line, d, lengths, phases)
    bearings = []
    for k in range(n - 2):
        history = bearing_forces[k]
        bearings.append({
            "shaft": k + 1,
            "static_N": history.mean(axis=0),
            "dynamic_N": ellipse(history),
            "peak_N": crest(history) + once[k],
            "orders": {"1": once[k], "2": ellipse(history), "4": 0.0},
            "approximations": {"small_angle": {
                "static_N": T * small[k].mean(axis=0) + heavy[k],
                "dynamic_N": abs(T) * ellipse(small[k]),
            }},
        })  # fmt: skip
    document = {
        "torque_Nm": T,
        "engine_torque_Nm": torque["engine"],
        "slip_torque_Nm": torque["slip"],
        "coast_torque_Nm": torque["coast"],
        "speed_rpm": w / rpm,
        "axle_travel_mm": rise / mm,
        "joints": [
            {
                "angle_deg": beta[k] / deg,
                "position_deg": place[k] / deg,
                "side_deg": side[k] / deg,
                "top_deg": top[k] / deg,
                "force_N": crest(joint_forces[k]),
                "life_h": nan if state.kind in RARE else life(truck, line, line.joints[k], worn[k]),
            }
            for k in range(n)
        ],
        "torsional": {
            "equivalent_angle_deg": shaken["equivalent_angle"] / deg,
            "acceleration_rad_s2": shaken["torsional_acceleration"],
            "irregularity": shaken["irregularity"],
        },
        **{
            way: {
                "equivalent_angle_deg": shaken[f"{way}_angle"] / deg,
                "acceleration_rad_s2": shaken[f"inertia_{way}_acceleration"],
                "torque_Nm": shaken[f"inertia_{way}_torque"],
            }
            for way in ("drive", "coast")
        },
        "approximations": approximations(side, top, phases, w, inertias),
        "centre_bearings": bearings,
        "joint_forces": [
            {"joint": k + 1, "mean_N": f.mean(axis=0), "peak_N": crest(f), "worst_N": worst}
            for k, (f, worst) in enumerate(zip(joint_forces, strained, strict=True))
        ],
        "critical_speeds_rpm": [c / rpm for c in critical],
        "line_critical_speed_rpm": whirl[0] / rpm,
        "spline_travel_mm": travel / mm,
        "end_bearings_N": ends,
        "end_bearings_worst_N": worst_ends,
        "spline_force_N": slip,
        "clearances_mm": {
            o.name: min(gaps[k, o.name] for k in range(1, n)) / mm for o in line.obstacles
        },
    }  # fmt: skip
    frequency = nan
    if line.drives != "all" and state.kind not in ("", "full rebound", "rebound", "jounce"):
        frequency = suspension_frequency(truck.springs[line.springs], load["axle"])
    asked = {
        "suspension_frequency": frequency,
        "low_gear_torque": torque["low_gear"],
        "wheel_slip_torque": torque["wheel_slip"],
        "axle_load": load["axle"],
        "driven_load": load["drive"],
        "pitch": np.arctan2(-d[-1, 2], d[-1, 0]) - line.side[-1],
        "travel": rise,
    }
    return value, document, asked


def calculated(truck):
    """All values by (line, state), of checks, of the document and of the demand."""
    values, documents, demands, whirls = {}, {}, {}, {}
    for line in truck.lines:
        whirls[line.name] = line_whirl(line)
        for state in truck.states:
            found = one_state(truck, line, state, whirls[line.name])
            key = line.name, state.name
            values[key], documents[key], demands[key] = found
    return values, documents, demands, whirls

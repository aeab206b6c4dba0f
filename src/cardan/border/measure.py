"""The measures of an application file: what is measured, in which units, and within what.

Each is a float to the program and a choice of units to the file: a key declared as `Size`
ends in `_mm`, `_m` or `_in`. Two ranges go with it. Outside its bounds a number is refused:
they hold a model car's shaft and a ship's, with room on either side, and keep out what no
driveline has and no arithmetic bears (a shaft of a thousandth of a millimetre). Outside the
usual range a reader is asked whether the unit is meant: that one holds the vehicles of every
day, vans to mining trucks. Both are our own judgement.
"""

from typing import Annotated, TypeAlias

from cardan.base.units import N, deg, g, hour, kg, kN, lb, lbf, mm, rpm, t
from cardan.border.table import ListOf, Number

LENGTHS = ("mm", "m", "in")
TORQUES = ("Nm", "kNm", "lbft")
MASSES = ("kg", "t", "lb")
FORCES = ("N", "kN", "lbf")
ANGLES = ("deg", "rad")
SPEEDS = ("rpm", "rad_s")
STRESSES = ("MPa", "GPa", "psi")
STIFFNESSES = ("N_mm", "kN_m", "N_m", "lbf_in")
STEEP = 80 * deg
"""Members slope less than this: a driveline runs from the gearbox to the axle."""

FAR = 200.0
"""Metres from the origin: the longest ship is 400 m long."""
FASTEST = 200e3 * rpm
"""A dental drill's turbine runs at twice that; a driveline of model size at a third."""
STRONGEST = 1e8
"""N m; the largest ship's shaft carries some 1e7."""
HEAVIEST = 1e6
"""kg; a mining truck weighs 600 t laden."""


def length(*, least: float, most: float = FAR, usual: tuple[float, float] | None = None) -> Number:
    """Return the rule of a length within bounds, m."""
    return Number(*LENGTHS, least=least, most=most, usual=usual)


COORDINATE = Number(*LENGTHS, least=-FAR, most=FAR)
Length: TypeAlias = Annotated[float, COORDINATE]
Size: TypeAlias = Annotated[float, length(least=0.01 * mm, most=20, usual=(0.2 * mm, 4))]
Distance: TypeAlias = Annotated[float, length(least=0, most=20, usual=(0.2 * mm, 4))]
ShaftLength: TypeAlias = Annotated[float, length(least=5 * mm, most=50, usual=(0.1, 6))]
TubeLength: TypeAlias = Annotated[float, length(least=5 * mm, most=50, usual=(5 * mm, 6))]
Diameter: TypeAlias = Annotated[float, length(least=1 * mm, most=3, usual=(15 * mm, 0.4))]
Wall: TypeAlias = Annotated[float, length(least=0.02 * mm, most=1.5, usual=(0.8 * mm, 25 * mm))]
PlyThickness: TypeAlias = Annotated[
    float, length(least=0.005 * mm, most=0.2, usual=(0.04 * mm, 10 * mm))
]
Wheelbase: TypeAlias = Annotated[float, length(least=50 * mm, most=100, usual=(1.5, 12))]
TyreRadius: TypeAlias = Annotated[float, length(least=5 * mm, most=5, usual=(0.2, 0.75))]
CentreHeight: TypeAlias = Annotated[float, length(least=5 * mm, most=20, usual=(0.3, 2.5))]
AxlePlace: TypeAlias = Annotated[
    float, Number(*LENGTHS, least=-100, most=100, usual=(0.1, 20))
]  # fmt: skip
BearingPlace: TypeAlias = Annotated[float, length(least=0, most=20, usual=(25 * mm, 0.8))]
SplineTravel: TypeAlias = Annotated[float, length(least=0.1 * mm, most=5, usual=(3 * mm, 0.5))]
RubberTravel: TypeAlias = Annotated[
    float, length(least=0.1 * mm, most=0.5, usual=(2 * mm, 60 * mm))
]
ToothRadius: TypeAlias = Annotated[float, length(least=0.2 * mm, most=1, usual=(5 * mm, 0.15))]
LinkLength: TypeAlias = Annotated[float, length(least=5 * mm, most=20, usual=(0.2, 3))]
Travel: TypeAlias = Annotated[float, Number(*LENGTHS, least=-5, most=5, usual=(0.5 * mm, 0.5))]
Travels: TypeAlias = Annotated[
    tuple[float, ...], ListOf(Number(*LENGTHS, least=-5, most=5, usual=(0.5 * mm, 0.5)))
]
Deflections: TypeAlias = Annotated[
    tuple[float, ...], ListOf(Number(*LENGTHS, least=-5, most=5, usual=(40 * mm, 1)))
]
Deflection: TypeAlias = Annotated[float, Number(*LENGTHS, least=-5, most=5, usual=(5 * mm, 1))]
Contact: TypeAlias = Annotated[float, length(least=0.1 * mm, most=5, usual=(5 * mm, 1))]
Point: TypeAlias = Annotated[tuple[float, float, float], ListOf(COORDINATE, "x", "y", "z")]
BesidePoint: TypeAlias = Annotated[
    tuple[float, float, float],
    ListOf(Number(*LENGTHS, least=-FAR, most=FAR, usual=(20 * mm, 20)), "x", "y", "z"),
]
"""Of what stands beside a line; a point of a bracket may lie closer to its origin."""
JointPoints: TypeAlias = Annotated[
    tuple[tuple[float, float, float], ...],
    ListOf(ListOf(Number(*LENGTHS, least=-FAR, most=FAR, usual=(0.1, 20)), "x", "y", "z"), most=20),
]

Torque: TypeAlias = Annotated[float, Number(*TORQUES, least=0, most=STRONGEST, usual=(20, 200e3))]
Curve: TypeAlias = Annotated[
    tuple[float, ...],
    ListOf(Number(*TORQUES, least=0, most=STRONGEST, usual=(20, 200e3)), least=1, most=1000),
]
Rating: TypeAlias = Annotated[
    float, Number(*TORQUES, least=1e-3, most=STRONGEST, usual=(20, 2e6))
]  # fmt: skip
Speed: TypeAlias = Annotated[
    float, Number(*SPEEDS, least=0, most=FASTEST, usual=(10 * rpm, 20e3 * rpm))
]
TopSpeed: TypeAlias = Annotated[
    float, Number(*SPEEDS, least=0, most=FASTEST, usual=(300 * rpm, 12e3 * rpm))
]
PositiveSpeed: TypeAlias = Annotated[
    float, Number(*SPEEDS, least=0.1 * rpm, most=FASTEST, usual=(10 * rpm, 20e3 * rpm))
]
EngineSpeed: TypeAlias = Annotated[
    float, Number(*SPEEDS, least=0, most=FASTEST, usual=(300 * rpm, 20e3 * rpm))
]
EngineSpeeds: TypeAlias = Annotated[
    tuple[float, ...],
    ListOf(
        Number(*SPEEDS, least=0, most=FASTEST, usual=(300 * rpm, 20e3 * rpm)), least=1, most=1000
    ),
]

Angle: TypeAlias = Annotated[
    float, Number(*ANGLES, least=0, below=90 * deg, usual=(0.2 * deg, 45 * deg))
]
Slope: TypeAlias = Annotated[
    float, Number(*ANGLES, above=-STEEP, below=STEEP, usual=(0.15 * deg, 45 * deg))
]
Slopes: TypeAlias = Annotated[
    tuple[float, ...],
    ListOf(Number(*ANGLES, above=-STEEP, below=STEEP, usual=(0.2 * deg, 45 * deg)), most=20),
]
"""Side view; in the top view a line may well be straight, so nothing is unusual there."""
FlatSlope: TypeAlias = Annotated[float, Number(*ANGLES, above=-STEEP, below=STEEP)]
FlatSlopes: TypeAlias = Annotated[
    tuple[float, ...], ListOf(Number(*ANGLES, above=-STEEP, below=STEEP), most=20)
]
LinkAngle: TypeAlias = Annotated[
    float, Number(*ANGLES, above=-60 * deg, below=60 * deg, usual=(0.15 * deg, 60 * deg))
]
Grade: TypeAlias = Annotated[
    float, Number(*ANGLES, above=-45 * deg, below=45 * deg, usual=(0.3 * deg, 45 * deg))
]
Pitch: TypeAlias = Annotated[
    float, Number(*ANGLES, least=-60 * deg, most=60 * deg, usual=(0.02 * deg, 20 * deg))
]
Pitches: TypeAlias = Annotated[
    tuple[float, ...], ListOf(Number(*ANGLES, least=-60 * deg, most=60 * deg))
]
Turn: TypeAlias = Annotated[float, Number(*ANGLES, least=-360 * deg, most=360 * deg)]

Mass: TypeAlias = Annotated[float, Number(*MASSES, least=0, most=HEAVIEST, usual=(0.01, 500))]
UnsprungMass: TypeAlias = Annotated[
    float, Number(*MASSES, least=0, most=HEAVIEST, usual=(20, 8e3))
]  # fmt: skip
VehicleMass: TypeAlias = Annotated[
    float, Number(*MASSES, least=0.1, most=10 * HEAVIEST, usual=(300, 200e3))
]
AxleLoad: TypeAlias = Annotated[
    float,
    Number(
        worth={"kg": kg * g, "t": t * g, "lb": lb * g, "N": N, "kN": kN, "lbf": lbf},
        least=0, most=10 * HEAVIEST * g, usual=(100 * g, 100e3 * g),
    ),
]  # fmt: skip
Forces: TypeAlias = Annotated[
    tuple[float, ...], ListOf(Number(*FORCES, least=-1e9, most=1e9, usual=(500, 2e6)))
]
Stiffness: TypeAlias = Annotated[
    float, Number(*STIFFNESSES, least=1, most=1e12, usual=(10e3, 50e6))
]  # fmt: skip
SpringRates: TypeAlias = Annotated[
    tuple[float, ...],
    ListOf(Number(*STIFFNESSES, least=1, most=1e12, usual=(2e3, 1e7)), least=1, most=20),
]
WindupStiffness: TypeAlias = Annotated[
    float,
    Number("kNm_deg", "Nm_deg", "Nm_rad", least=1e-2, most=1e12, usual=(100 / deg, 1e6 / deg)),
]
TorsionStiffness: TypeAlias = Annotated[
    float,
    Number("Nm_deg", "Nm_rad", "kNm_deg", "kNm_rad", least=1e-3, most=1e12, usual=(100.0, 1e9)),
]
TorsionStiffnesses: TypeAlias = Annotated[
    tuple[float, ...],
    ListOf(
        Number("Nm_deg", "Nm_rad", "kNm_deg", "kNm_rad", least=1e-3, most=1e12, usual=(100.0, 1e9)),
        least=1,
        most=64,
    ),
]
TorsionDamping: TypeAlias = Annotated[
    float, Number("Nms_rad", least=0, most=1e9, usual=(1e-3, 1e5))
]
Displacement: TypeAlias = Annotated[float, Number("l", least=1e-6, most=10, usual=(0.5e-3, 80e-3))]
Time: TypeAlias = Annotated[float, Number("s", least=1e-3, most=60, usual=(0.02, 10))]
SlipForce: TypeAlias = Annotated[float, Number(*FORCES, least=1, most=1e9, usual=(5e3, 2e6))]
Play: TypeAlias = Annotated[float, Number(*ANGLES, least=0, most=90 * deg, usual=(1e-4, 0.5))]
CurveAngles: TypeAlias = Annotated[
    tuple[float, ...], ListOf(Number(*ANGLES, least=-360 * deg, most=360 * deg), least=2, most=100)
]
CurveTorques: TypeAlias = Annotated[
    tuple[float, ...],
    ListOf(Number(*TORQUES, least=-STRONGEST, most=STRONGEST), least=2, most=100),
]
PositiveInertia: TypeAlias = Annotated[
    float, Number("kgm2", least=1e-9, most=1e7, usual=(1e-3, 1e3))
]  # fmt: skip
PositiveInertias: TypeAlias = Annotated[
    tuple[float, ...], ListOf(Number("kgm2", least=1e-9, most=1e7, usual=(1e-3, 1e3)), most=64)
]
PitchRate: TypeAlias = Annotated[
    float,
    Number(
        worth={"deg_mm": deg / mm, "rad_m": 1.0},
        least=-50, most=50, usual=(2e-4 * deg / mm, 0.1 * deg / mm),
    ),
]  # fmt: skip
Inertia: TypeAlias = Annotated[float, Number("kgm2", least=0, most=1e7, usual=(1e-5, 50))]
SpeedAngle: TypeAlias = Annotated[
    float,
    Number(
        "deg_min",
        least=rpm * deg, most=1e8 * rpm * deg, usual=(2e3 * rpm * deg, 1e6 * rpm * deg),
    ),
]  # fmt: skip
"""Speed times joint angle; catalogues' deg/min are rpm times degrees. SI: rad²/s."""

Stiff: TypeAlias = Annotated[
    float, Number("GPa", "MPa", "psi", least=1e6, most=2e12, usual=(1e9, 1e12))
]
Strength: TypeAlias = Annotated[
    float, Number(*STRESSES, least=1e5, most=2e10, usual=(1e7, 1e10))
]  # fmt: skip
Density: TypeAlias = Annotated[float, Number("kg_m3", least=50, most=30e3, usual=(500, 25e3))]

Hours: TypeAlias = Annotated[
    float, Number("h", least=hour, most=1e6 * hour, usual=(10 * hour, 1e5 * hour))
]
Factor: TypeAlias = Annotated[float, Number(least=1e-9, most=1e9)]
Cycles: TypeAlias = Annotated[float, Number(least=1, most=1e11, usual=(1e3, 1e9))]
LineRatio: TypeAlias = Annotated[float, Number(least=1e-3, most=1e3, usual=(0.1, 10))]
AxleRatio: TypeAlias = Annotated[float, Number(least=0.02, below=100, usual=(1.2, 20))]
GearRatio: TypeAlias = Annotated[float, Number(least=0.02, below=100, usual=(0.4, 30))]
GearRatios: TypeAlias = Annotated[
    tuple[float, ...], ListOf(Number(least=0.02, below=100, usual=(0.4, 30)), least=1, most=64)
]
TransferRatio: TypeAlias = Annotated[float, Number(least=0.1, below=100, usual=(1, 6))]
ConverterRatio: TypeAlias = Annotated[float, Number(least=1, below=10, usual=(1, 4))]
LossFactor: TypeAlias = Annotated[float, Number(above=0, below=1, usual=(0.02, 0.5))]
FrameLoss: TypeAlias = Annotated[float, Number(above=0, below=1, usual=(0.002, 0.1))]
"""Of bolted or welded steel, which loses less than rubber."""
Efficiency: TypeAlias = Annotated[float, Number(least=0.1, most=1, usual=(0.7, 1))]
Share: TypeAlias = Annotated[float, Number(least=1e-3, most=1)]
Part: TypeAlias = Annotated[float, Number(least=0, most=1)]
Percent: TypeAlias = Annotated[float, Number("percent", least=1e-8, most=1)]
Friction: TypeAlias = Annotated[float, Number(least=1e-3, most=2)]
TyreFriction: TypeAlias = Annotated[float, Number(least=1e-3, most=2, usual=(0.2, 1.5))]
SplineFriction: TypeAlias = Annotated[float, Number(least=1e-3, most=2, usual=(0.01, 0.5))]

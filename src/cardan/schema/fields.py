"""The measures of an application file: what is measured, in which units, and within what.

Each is a float to the program and a choice of units to the file: a key declared as `Size`
ends in `_mm`, `_m` or `_in`. Two ranges go with it. Outside its bounds a number is refused:
they hold a model car's shaft and a ship's, with room on either side, and keep out what no
driveline has and no arithmetic bears (a shaft of a thousandth of a millimetre). Outside the
usual range a warning doubts the unit: that one holds the vehicles of every
day, vans to mining trucks. Both are our own judgement.
"""

from typing import Annotated, TypeAlias

from cardan.core.units import N, deg, g, hour, kg, kN, lb, lbf, mm, rpm, t
from cardan.schema.field_types import ListField, NumberField

LENGTH_KEY_UNITS = ("mm", "m", "in")
TORQUE_KEY_UNITS = ("Nm", "kNm", "lbft")
MASS_KEY_UNITS = ("kg", "t", "lb")
FORCE_KEY_UNITS = ("N", "kN", "lbf")
ANGLE_KEY_UNITS = ("deg", "rad")
SPEED_KEY_UNITS = ("rpm", "rad_s")
STRESS_KEY_UNITS = ("MPa", "GPa", "psi")
STIFFNESS_KEY_UNITS = ("N_mm", "kN_m", "N_m", "lbf_in")
MAX_SHAFT_SLOPE_RAD = 80 * deg
"""Members slope less than this: a driveline runs from the gearbox to the axle."""

MAX_COORDINATE_M = 200.0
"""Metres from the origin: the longest ship is 400 m long."""
MAX_SPEED_RAD_S = 200e3 * rpm
"""A dental drill's turbine runs at twice that; a driveline of model size at a third."""
MAX_TORQUE_NM = 1e8
"""N m; the largest ship's shaft carries some 1e7."""
MAX_MASS_KG = 1e6
"""kg; a mining truck weighs 600 t laden."""


def length_field(
    *, least: float, most: float = MAX_COORDINATE_M, usual: tuple[float, float] | None = None
) -> NumberField:
    """Return the rule of a length within bounds, m."""
    return NumberField(*LENGTH_KEY_UNITS, least=least, most=most, usual=usual)


COORDINATE_FIELD = NumberField(*LENGTH_KEY_UNITS, least=-MAX_COORDINATE_M, most=MAX_COORDINATE_M)
Coordinate: TypeAlias = Annotated[float, COORDINATE_FIELD]
PartDimension: TypeAlias = Annotated[
    float, length_field(least=0.01 * mm, most=20, usual=(0.2 * mm, 4))
]
Distance: TypeAlias = Annotated[float, length_field(least=0, most=20, usual=(0.2 * mm, 4))]
ShaftLength: TypeAlias = Annotated[float, length_field(least=5 * mm, most=50, usual=(0.1, 6))]
TubeLength: TypeAlias = Annotated[float, length_field(least=5 * mm, most=50, usual=(5 * mm, 6))]
Diameter: TypeAlias = Annotated[float, length_field(least=1 * mm, most=3, usual=(15 * mm, 0.4))]
WallThickness: TypeAlias = Annotated[
    float, length_field(least=0.02 * mm, most=1.5, usual=(0.8 * mm, 25 * mm))
]
PlyThickness: TypeAlias = Annotated[
    float, length_field(least=0.005 * mm, most=0.2, usual=(0.04 * mm, 10 * mm))
]
Wheelbase: TypeAlias = Annotated[float, length_field(least=50 * mm, most=100, usual=(1.5, 12))]
TyreRadius: TypeAlias = Annotated[float, length_field(least=5 * mm, most=5, usual=(0.2, 0.75))]
CentreOfGravityHeight: TypeAlias = Annotated[
    float, length_field(least=5 * mm, most=20, usual=(0.3, 2.5))
]
AxlePosition: TypeAlias = Annotated[
    float, NumberField(*LENGTH_KEY_UNITS, least=-100, most=100, usual=(0.1, 20))
]  # fmt: skip
BearingPosition: TypeAlias = Annotated[float, length_field(least=0, most=20, usual=(25 * mm, 0.8))]
SplineTravel: TypeAlias = Annotated[
    float, length_field(least=0.1 * mm, most=5, usual=(3 * mm, 0.25))
]
BearingMountTravel: TypeAlias = Annotated[
    float, length_field(least=0.1 * mm, most=0.5, usual=(2 * mm, 60 * mm))
]
ToothMeanRadius: TypeAlias = Annotated[
    float, length_field(least=0.2 * mm, most=1, usual=(5 * mm, 0.15))
]
LinkLength: TypeAlias = Annotated[float, length_field(least=5 * mm, most=20, usual=(0.2, 3))]
AxleTravel: TypeAlias = Annotated[
    float, NumberField(*LENGTH_KEY_UNITS, least=-5, most=5, usual=(0.5 * mm, 0.5))
]
AxleTravelColumn: TypeAlias = Annotated[
    tuple[float, ...],
    ListField(NumberField(*LENGTH_KEY_UNITS, least=-5, most=5, usual=(0.5 * mm, 0.5))),
]
Deflections: TypeAlias = Annotated[
    tuple[float, ...],
    ListField(NumberField(*LENGTH_KEY_UNITS, least=-5, most=5, usual=(40 * mm, 1))),
]
Deflection: TypeAlias = Annotated[
    float, NumberField(*LENGTH_KEY_UNITS, least=-5, most=5, usual=(5 * mm, 1))
]
SecondSpringRateDeflection: TypeAlias = Annotated[
    float, length_field(least=0.1 * mm, most=5, usual=(5 * mm, 1))
]
PointCoordinates: TypeAlias = Annotated[
    tuple[float, float, float], ListField(COORDINATE_FIELD, "x", "y", "z")
]
ObstacleCoordinates: TypeAlias = Annotated[
    tuple[float, float, float],
    ListField(
        NumberField(
            *LENGTH_KEY_UNITS, least=-MAX_COORDINATE_M, most=MAX_COORDINATE_M, usual=(20 * mm, 20)
        ),
        "x",
        "y",
        "z",
    ),
]
"""Of what stands next to a line; a point of a bracket may lie closer to its origin."""
JointCoordinates: TypeAlias = Annotated[
    tuple[tuple[float, float, float], ...],
    ListField(
        ListField(
            NumberField(
                *LENGTH_KEY_UNITS, least=-MAX_COORDINATE_M, most=MAX_COORDINATE_M, usual=(0.1, 20)
            ),
            "x",
            "y",
            "z",
        ),
        most=20,
    ),
]

Torque: TypeAlias = Annotated[
    float, NumberField(*TORQUE_KEY_UNITS, least=0, most=MAX_TORQUE_NM, usual=(20, 200e3))
]
TorqueCurve: TypeAlias = Annotated[
    tuple[float, ...],
    ListField(
        NumberField(*TORQUE_KEY_UNITS, least=0, most=MAX_TORQUE_NM, usual=(20, 200e3)),
        least=1,
        most=1000,
    ),
]
TorqueRating: TypeAlias = Annotated[
    float, NumberField(*TORQUE_KEY_UNITS, least=1e-3, most=MAX_TORQUE_NM, usual=(20, 2e6))
]  # fmt: skip
Speed: TypeAlias = Annotated[
    float,
    NumberField(*SPEED_KEY_UNITS, least=0, most=MAX_SPEED_RAD_S, usual=(10 * rpm, 20e3 * rpm)),
]
TopSpeed: TypeAlias = Annotated[
    float,
    NumberField(*SPEED_KEY_UNITS, least=0, most=MAX_SPEED_RAD_S, usual=(300 * rpm, 12e3 * rpm)),
]
PositiveSpeed: TypeAlias = Annotated[
    float,
    NumberField(
        *SPEED_KEY_UNITS, least=0.1 * rpm, most=MAX_SPEED_RAD_S, usual=(10 * rpm, 20e3 * rpm)
    ),
]
EngineSpeed: TypeAlias = Annotated[
    float,
    NumberField(*SPEED_KEY_UNITS, least=0, most=MAX_SPEED_RAD_S, usual=(300 * rpm, 20e3 * rpm)),
]
EngineSpeeds: TypeAlias = Annotated[
    tuple[float, ...],
    ListField(
        NumberField(*SPEED_KEY_UNITS, least=0, most=MAX_SPEED_RAD_S, usual=(300 * rpm, 20e3 * rpm)),
        least=1,
        most=1000,
    ),
]

Angle: TypeAlias = Annotated[
    float, NumberField(*ANGLE_KEY_UNITS, least=0, below=90 * deg, usual=(0.2 * deg, 45 * deg))
]
Slope: TypeAlias = Annotated[
    float,
    NumberField(
        *ANGLE_KEY_UNITS,
        above=-MAX_SHAFT_SLOPE_RAD,
        below=MAX_SHAFT_SLOPE_RAD,
        usual=(0.15 * deg, 45 * deg),
    ),
]
Slopes: TypeAlias = Annotated[
    tuple[float, ...],
    ListField(
        NumberField(
            *ANGLE_KEY_UNITS,
            above=-MAX_SHAFT_SLOPE_RAD,
            below=MAX_SHAFT_SLOPE_RAD,
            usual=(0.2 * deg, 45 * deg),
        ),
        most=20,
    ),
]
"""Side view; in the plan view a line may well be straight, so nothing is unusual there."""
PlanViewSlope: TypeAlias = Annotated[
    float, NumberField(*ANGLE_KEY_UNITS, above=-MAX_SHAFT_SLOPE_RAD, below=MAX_SHAFT_SLOPE_RAD)
]
PlanViewSlopes: TypeAlias = Annotated[
    tuple[float, ...],
    ListField(
        NumberField(*ANGLE_KEY_UNITS, above=-MAX_SHAFT_SLOPE_RAD, below=MAX_SHAFT_SLOPE_RAD),
        most=20,
    ),
]
LinkAngle: TypeAlias = Annotated[
    float,
    NumberField(*ANGLE_KEY_UNITS, above=-60 * deg, below=60 * deg, usual=(0.15 * deg, 60 * deg)),
]
RoadGrade: TypeAlias = Annotated[
    float,
    NumberField(*ANGLE_KEY_UNITS, above=-45 * deg, below=45 * deg, usual=(0.3 * deg, 25 * deg)),
]
PitchAngle: TypeAlias = Annotated[
    float,
    NumberField(*ANGLE_KEY_UNITS, least=-60 * deg, most=60 * deg, usual=(0.02 * deg, 20 * deg)),
]
PitchAngles: TypeAlias = Annotated[
    tuple[float, ...], ListField(NumberField(*ANGLE_KEY_UNITS, least=-60 * deg, most=60 * deg))
]
YokePhaseAngle: TypeAlias = Annotated[
    float, NumberField(*ANGLE_KEY_UNITS, least=-360 * deg, most=360 * deg)
]

Mass: TypeAlias = Annotated[
    float, NumberField(*MASS_KEY_UNITS, least=0, most=MAX_MASS_KG, usual=(0.01, 500))
]
UnsprungMass: TypeAlias = Annotated[
    float, NumberField(*MASS_KEY_UNITS, least=0, most=MAX_MASS_KG, usual=(20, 8e3))
]  # fmt: skip
VehicleMass: TypeAlias = Annotated[
    float, NumberField(*MASS_KEY_UNITS, least=0.1, most=10 * MAX_MASS_KG, usual=(300, 200e3))
]
AxleLoad: TypeAlias = Annotated[
    float,
    NumberField(
        worth={"kg": kg * g, "t": t * g, "lb": lb * g, "N": N, "kN": kN, "lbf": lbf},
        least=0, most=10 * MAX_MASS_KG * g, usual=(100 * g, 100e3 * g),
    ),
]  # fmt: skip
SpringForceColumn: TypeAlias = Annotated[
    tuple[float, ...],
    ListField(NumberField(*FORCE_KEY_UNITS, least=-1e9, most=1e9, usual=(500, 2e6))),
]
BearingForceRating: TypeAlias = Annotated[
    float, NumberField(*FORCE_KEY_UNITS, least=0.1, most=1e9, usual=(200, 500e3))
]
Stiffness: TypeAlias = Annotated[
    float, NumberField(*STIFFNESS_KEY_UNITS, least=1, most=1e12, usual=(10e3, 50e6))
]  # fmt: skip
SpringRates: TypeAlias = Annotated[
    tuple[float, ...],
    ListField(
        NumberField(*STIFFNESS_KEY_UNITS, least=1, most=1e12, usual=(2e3, 1e7)), least=1, most=20
    ),
]
WindupStiffness: TypeAlias = Annotated[
    float,
    NumberField("kNm_deg", "Nm_deg", "Nm_rad", least=1e-2, most=1e12, usual=(100 / deg, 1e6 / deg)),
]
TorsionStiffness: TypeAlias = Annotated[
    float,
    NumberField(
        "Nm_deg", "Nm_rad", "kNm_deg", "kNm_rad", least=1e-3, most=1e12, usual=(100.0, 1e9)
    ),
]
TorsionStiffnesses: TypeAlias = Annotated[
    tuple[float, ...],
    ListField(
        NumberField(
            "Nm_deg", "Nm_rad", "kNm_deg", "kNm_rad", least=1e-3, most=1e12, usual=(100.0, 1e9)
        ),
        least=1,
        most=64,
    ),
]
TorsionDamping: TypeAlias = Annotated[
    float, NumberField("Nms_rad", least=0, most=1e9, usual=(1e-3, 1e5))
]
EngineDisplacement: TypeAlias = Annotated[
    float, NumberField("l", least=1e-6, most=10, usual=(0.5e-3, 80e-3))
]
RatedPower: TypeAlias = Annotated[float, NumberField("kW", least=1.0, most=1e9, usual=(10e3, 3e6))]
Duration: TypeAlias = Annotated[float, NumberField("s", least=1e-3, most=60, usual=(0.02, 10))]
TyreSlipStiffness: TypeAlias = Annotated[
    float, NumberField(*FORCE_KEY_UNITS, least=1, most=1e9, usual=(5e3, 2e6))
]
AngularPlay: TypeAlias = Annotated[
    float, NumberField(*ANGLE_KEY_UNITS, least=0, most=90 * deg, usual=(1e-4, 0.5))
]
DamperCurveAngles: TypeAlias = Annotated[
    tuple[float, ...],
    ListField(NumberField(*ANGLE_KEY_UNITS, least=-360 * deg, most=360 * deg), least=2, most=100),
]
DamperCurveTorques: TypeAlias = Annotated[
    tuple[float, ...],
    ListField(
        NumberField(*TORQUE_KEY_UNITS, least=-MAX_TORQUE_NM, most=MAX_TORQUE_NM), least=2, most=100
    ),
]
PositiveInertia: TypeAlias = Annotated[
    float, NumberField("kgm2", least=1e-9, most=1e7, usual=(1e-3, 1e3))
]  # fmt: skip
PositiveInertias: TypeAlias = Annotated[
    tuple[float, ...],
    ListField(NumberField("kgm2", least=1e-9, most=1e7, usual=(1e-3, 1e3)), most=64),
]
PitchRate: TypeAlias = Annotated[
    float,
    NumberField(
        worth={"deg_mm": deg / mm, "rad_m": 1.0},
        least=-50, most=50, usual=(2e-4 * deg / mm, 0.1 * deg / mm),
    ),
]  # fmt: skip
Inertia: TypeAlias = Annotated[float, NumberField("kgm2", least=0, most=1e7, usual=(1e-5, 50))]
SpeedAngleProduct: TypeAlias = Annotated[
    float,
    NumberField(
        "deg_min",
        least=rpm * deg, most=1e8 * rpm * deg, usual=(2e3 * rpm * deg, 1e6 * rpm * deg),
    ),
]  # fmt: skip
"""Speed times joint angle; catalogues' deg/min are rpm times degrees. SI: rad²/s."""

ElasticModulus: TypeAlias = Annotated[
    float, NumberField("GPa", "MPa", "psi", least=1e6, most=2e12, usual=(1e9, 1e12))
]
MaterialStrength: TypeAlias = Annotated[
    float, NumberField(*STRESS_KEY_UNITS, least=1e5, most=2e10, usual=(1e7, 1e10))
]  # fmt: skip
Density: TypeAlias = Annotated[float, NumberField("kg_m3", least=50, most=30e3, usual=(500, 25e3))]

LifeHours: TypeAlias = Annotated[
    float, NumberField("h", least=hour, most=1e6 * hour, usual=(10 * hour, 1e5 * hour))
]
PositiveFactor: TypeAlias = Annotated[float, NumberField(least=1e-9, most=1e9)]
CycleCount: TypeAlias = Annotated[float, NumberField(least=1, most=1e11, usual=(1e3, 1e9))]
DrivelineRatio: TypeAlias = Annotated[float, NumberField(least=1e-3, most=1e3, usual=(0.1, 10))]
AxleRatio: TypeAlias = Annotated[float, NumberField(least=0.02, below=100, usual=(1.2, 20))]
GearRatio: TypeAlias = Annotated[float, NumberField(least=0.02, below=100, usual=(0.4, 30))]
GearRatios: TypeAlias = Annotated[
    tuple[float, ...],
    ListField(NumberField(least=0.02, below=100, usual=(0.4, 30)), least=1, most=64),
]
TransferRatio: TypeAlias = Annotated[float, NumberField(least=0.1, below=100, usual=(1, 6))]
ConverterTorqueRatio: TypeAlias = Annotated[float, NumberField(least=1, below=10, usual=(1, 4))]
DampingLossFactor: TypeAlias = Annotated[float, NumberField(above=0, below=1, usual=(0.02, 0.5))]
SteelStructureLossFactor: TypeAlias = Annotated[
    float, NumberField(above=0, below=1, usual=(0.002, 0.1))
]
"""Of bolted or welded steel, which loses less than rubber."""
Efficiency: TypeAlias = Annotated[float, NumberField(least=0.1, most=1, usual=(0.7, 1))]
PositiveShare: TypeAlias = Annotated[float, NumberField(least=1e-3, most=1)]
ShareFromZeroToOne: TypeAlias = Annotated[float, NumberField(least=0, most=1)]
Percent: TypeAlias = Annotated[float, NumberField("percent", least=1e-8, most=1)]
TyreFriction: TypeAlias = Annotated[float, NumberField(least=1e-3, most=2, usual=(0.5, 1.2))]
SplineFriction: TypeAlias = Annotated[float, NumberField(least=1e-3, most=2, usual=(0.05, 0.5))]

"""The measures of an application file: what is measured, in which units, and what is usual.

Each is a float to the program and a choice of units to the file: a key declared as `Size`
ends in `_mm`, `_m` or `_in`. Usual magnitudes only make a reader ask whether the unit is
meant; bounds refuse.
"""

from typing import Annotated, TypeAlias

from cardan.base.units import N, deg, g, kg, kN, lb, lbf, mm, rpm, t
from cardan.border.table import ListOf, Number

LENGTHS = ("mm", "m", "in")
TORQUES = ("Nm", "kNm", "lbft")
MASSES = ("kg", "t", "lb")
FORCES = ("N", "kN", "lbf")
ANGLES = ("deg", "rad")
SPEEDS = ("rpm", "rad_s")
STRESSES = ("MPa", "GPa", "psi")
STEEP = 80 * deg
"""Members slope less than this: a driveline runs from the gearbox to the axle."""

Length: TypeAlias = Annotated[float, Number(*LENGTHS)]
Size: TypeAlias = Annotated[float, Number(*LENGTHS, above=0)]
Distance: TypeAlias = Annotated[float, Number(*LENGTHS, least=0)]
ShaftLength: TypeAlias = Annotated[float, Number(*LENGTHS, above=0, usual=(0.1, 6))]
Diameter: TypeAlias = Annotated[float, Number(*LENGTHS, above=0, usual=(15 * mm, 0.4))]
Wall: TypeAlias = Annotated[float, Number(*LENGTHS, above=0, usual=(0.8 * mm, 25 * mm))]
Wheelbase: TypeAlias = Annotated[float, Number(*LENGTHS, above=0, usual=(1.5, 12))]
TyreRadius: TypeAlias = Annotated[float, Number(*LENGTHS, above=0, usual=(0.2, 1.2))]
Deflections: TypeAlias = Annotated[tuple[float, ...], ListOf(Number(*LENGTHS, usual=(5 * mm, 1)))]
Point: TypeAlias = Annotated[tuple[float, float, float], ListOf(Number(*LENGTHS), "x", "y", "z")]

Torque: TypeAlias = Annotated[float, Number(*TORQUES, least=0, usual=(20, 200e3))]
Rating: TypeAlias = Annotated[float, Number(*TORQUES, above=0, usual=(20, 2e6))]
Speed: TypeAlias = Annotated[float, Number(*SPEEDS, least=0, usual=(10 * rpm, 20e3 * rpm))]
PositiveSpeed: TypeAlias = Annotated[float, Number(*SPEEDS, above=0, usual=(10 * rpm, 20e3 * rpm))]

Angle: TypeAlias = Annotated[
    float, Number(*ANGLES, least=0, below=90 * deg, usual=(0.2 * deg, 45 * deg))
]
Slope: TypeAlias = Annotated[float, Number(*ANGLES, above=-STEEP, below=STEEP)]
Slopes: TypeAlias = Annotated[
    tuple[float, ...],
    ListOf(Number(*ANGLES, above=-STEEP, below=STEEP, usual=(0.2 * deg, 45 * deg))),
]
"""Side view; in the top view a line may well be straight, so nothing is unusual there."""
FlatSlopes: TypeAlias = Annotated[
    tuple[float, ...], ListOf(Number(*ANGLES, above=-STEEP, below=STEEP))
]
Turn: TypeAlias = Annotated[float, Number(*ANGLES, least=-360 * deg, most=360 * deg)]

Mass: TypeAlias = Annotated[float, Number(*MASSES, least=0)]
VehicleMass: TypeAlias = Annotated[float, Number(*MASSES, above=0, usual=(300, 200e3))]
AxleLoad: TypeAlias = Annotated[
    float,
    Number(
        worth={"kg": kg * g, "t": t * g, "lb": lb * g, "N": N, "kN": kN, "lbf": lbf},
        least=0, usual=(100 * g, 100e3 * g),
    ),
]  # fmt: skip
Forces: TypeAlias = Annotated[tuple[float, ...], ListOf(Number(*FORCES))]
Stiffness: TypeAlias = Annotated[float, Number("N_mm", "kN_m", "N_m", "lbf_in", above=0)]
WindupStiffness: TypeAlias = Annotated[float, Number("kNm_deg", "Nm_deg", "Nm_rad", above=0)]
TorsionStiffness: TypeAlias = Annotated[
    float, Number("Nm_deg", "Nm_rad", "kNm_deg", above=0, usual=(100.0, 1e9))
]
PositiveInertia: TypeAlias = Annotated[float, Number("kgm2", above=0, usual=(1e-3, 1e3))]
PitchRate: TypeAlias = Annotated[float, Number(worth={"deg_mm": deg / mm, "rad_m": 1.0})]
Inertia: TypeAlias = Annotated[float, Number("kgm2", least=0)]
SpeedAngle: TypeAlias = Annotated[float, Number("deg_min", above=0)]
"""Speed times joint angle; catalogues' deg/min are rpm times degrees. SI: rad²/s."""

Stiff: TypeAlias = Annotated[float, Number("GPa", "MPa", "psi", above=0, usual=(1e9, 1e12))]
Strength: TypeAlias = Annotated[float, Number(*STRESSES, above=0, usual=(1e7, 1e10))]
Density: TypeAlias = Annotated[float, Number("kg_m3", above=0, usual=(500, 25e3))]

Factor: TypeAlias = Annotated[float, Number(above=0)]
Ratio: TypeAlias = Annotated[float, Number(above=0, below=100)]
Efficiency: TypeAlias = Annotated[float, Number(above=0, most=1)]
Share: TypeAlias = Annotated[float, Number(above=0, most=1)]
Part: TypeAlias = Annotated[float, Number(least=0, most=1)]
Percent: TypeAlias = Annotated[float, Number("percent", above=0, most=1)]
Friction: TypeAlias = Annotated[float, Number(above=0, most=2)]

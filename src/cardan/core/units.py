"""What one of each unit is worth in SI: multiply on the way in, divide on the way out."""

from math import pi
from typing import TypeAlias

Metre: TypeAlias = float
Kilogram: TypeAlias = float
Newton: TypeAlias = float
NewtonMetre: TypeAlias = float
Pascal: TypeAlias = float
Radian: TypeAlias = float
RadianPerSecond: TypeAlias = float

m = 1.0
mm = 1e-3
inch = 25.4e-3
ft = 12 * inch

kg = 1.0
lb = 0.45359237
t = 1e3

g = 9.80665
"""Standard acceleration of free fall, m/s² (ISO 80000-3)."""

N = 1.0
kN = 1e3
lbf = lb * g

Nm = 1.0
kNm = 1e3
lbft = lbf * ft

kW = 1e3

MPa = 1e6
GPa = 1e9
psi = lbf / inch**2

deg = pi / 180
percent = 1e-2
minute = 60.0
hour = 3600.0
rpm = 2 * pi / 60

UNITS: dict[str, float] = {
    "1": 1.0, "percent": 1e-2,
    "m": m, "mm": mm, "in": inch, "ft": ft,
    "kg": kg, "lb": lb, "t": t, "kgm2": 1.0,
    "N": N, "kN": kN, "lbf": lbf, "kgf": g,
    "Nm": Nm, "kNm": kNm, "lbft": lbft,
    "N_m": 1.0, "N_mm": N / mm, "kN_m": kN, "lbf_in": lbf / inch,
    "Nm_deg": Nm / deg, "kNm_deg": kNm / deg, "Nm_rad": Nm,
    "kNm_rad": kNm, "Nms_rad": Nm, "l": 1e-3, "kW": kW,
    "Pa": 1.0, "MPa": MPa, "GPa": GPa, "psi": psi, "kg_m3": 1.0,
    "rad": 1.0, "deg": deg, "deg_mm": deg / mm, "gmm": 1e-6,
    "rpm": rpm, "rad_s": 1.0, "rad_s2": 1.0, "per_s": 1.0, "deg_min": rpm * deg,
    "Hz": 1.0, "h": hour, "s": 1.0, "km_h": 1 / 3.6,
}  # fmt: skip
"""SI value of one unit, by the name a key of a file ends in (`length_mm`, `torque_lbft`).

`deg_min` is what catalogues call speed times joint angle: rpm times degrees.
"""

"""Torsional and lateral vibration; answered by the study of vibration."""

from cardan.checks.quantities.declaration import Quantity
from cardan.core.provenance import ASOKANTHAN_HWANG_1996, MAZZEI_1999, SOURCE_DERIVED

DECLARATIONS = (
    Quantity(
        key="torsional_resonance",
        study="vibration",
        name="Speed / torsional resonance",
        symbol="n/nr",
        unit="1",
        equation="n / nr,  nr = ωi / order",
        symbol_meanings={
            "n": "nearest speed of a gear's range",
            "ωi": "torsional natural frequency",
        },
        source=SOURCE_DERIVED,
        validity=(
            "The whole vehicle, clutch closed, joints straight. The joints excite orders 2 and 4."
        ),
    ),
    Quantity(
        key="torsional_growth",
        study="vibration",
        name="Growth of torsional vibration",
        symbol="λT",
        unit="per_s",
        equation="λT = −(di + dj)/2 + Re √(((di − dj + i s)/2)² + Hij Hji*/(4 ωi ωj))",
        symbol_meanings={
            "di": "decay ζi ωi of a mode of the zone",
            "s": "2 Ω − ωi − ωj",
            "Hij": "what the joints' order 2 makes of mode j in mode i",
        },
        source=ASOKANTHAN_HWANG_1996,
        validity="Of the zone's own motion, above 0 it grows; at the speed nearest to the zone.",
    ),
    Quantity(
        key="lateral_growth",
        study="vibration",
        name="Growth of lateral vibration",
        symbol="λL",
        unit="per_s",
        equation="λL = max Re ln ρ / T,  det(P − ρ) = 0",
        symbol_meanings={"P": "what half a turn makes of small lateral motions of a hung shaft"},
        source=MAZZEI_1999,
        validity="One shaft on its own rubber bearing, under the torque of the gear.",
    ),
    Quantity(
        key="torsional_amplitude_utilisation",
        study="vibration",
        name="Vibratory torque / endurance",
        symbol="TV/TDW",
        unit="1",
        equation="max over speeds of (|T2| + |T4|) / TDW",
        symbol_meanings={
            "T2, T4": "orders 2 and 4 of the torque",
            "TDW": "reversing torque of the joint",
        },
        source=SOURCE_DERIVED,
        validity="Steady running at full load, at the true peak of each resonance.",
    ),
    Quantity(
        key="torsional_peak_utilisation",
        study="vibration",
        name="Vibratory peak torque / rating",
        symbol="TP/TCS",
        unit="1",
        equation="max over speeds of (|T0| + |T2| + |T4|) / TCS",
        symbol_meanings={
            "T0": "mean torque",
            "T2, T4": "orders 2 and 4",
            "TCS": "peak torque of the joint",
        },
        source=SOURCE_DERIVED,
        validity="Steady running at full load, at the true peak of each resonance.",
    ),
    Quantity(
        key="torsional_reversal",
        study="vibration",
        name="Vibratory torque / mean torque",
        symbol="TV/T0",
        unit="1",
        equation="max over speeds of (|T2| + |T4|) / |T0|",
        symbol_meanings={"T0": "mean torque at full load", "T2, T4": "orders 2 and 4"},
        source=SOURCE_DERIVED,
        validity="Above 1 the torque reverses: teeth and splines part, and rattle.",
    ),
    Quantity(
        key="torsional_pinion_acceleration",
        study="vibration",
        name="Pinion vibratory acceleration",
        symbol="αP",
        unit="rad_s2",
        equation="αP = max over speeds of (4 Ω² |q2| + 16 Ω² |q4|)",
        symbol_meanings={"q2, q4": "orders 2 and 4 of the pinion's rotation"},
        source=SOURCE_DERIVED,
        validity="Of the vehicle as it vibrates; the line's joints by themselves are αR.",
    ),
    Quantity(
        key="launch_peak_utilisation",
        study="vibration",
        name="Launch torque / peak rating",
        symbol="TL/TCS",
        unit="1",
        equation="TL / TCS",
        symbol_meanings={
            "TL": "largest torque of a start from rest",
            "TCS": "peak torque of the joint",
        },
        source=SOURCE_DERIVED,
        validity="Clutch or converter by its ramp; tyres slide, the axle winds up.",
    ),
    Quantity(
        key="launch_reversal",
        study="vibration",
        name="Reversal in a launch",
        symbol="−Tmin/TL",
        unit="1",
        equation="−Tmin / TL",
        symbol_meanings={
            "Tmin": "lowest torque after half the peak was there",
            "TL": "largest torque",
        },
        source=SOURCE_DERIVED,
        validity="Above 0 the torque swings back through nothing.",
    ),
    Quantity(
        key="launch_bearing_force",
        study="vibration",
        name="Bearing force in a launch",
        symbol="FL",
        unit="N",
        equation="FL = max over time of |force on the bearing|,  M q'' + C q' + K q = f",
        symbol_meanings={
            "q": "the line's slowest motions on its rubber",
            "f": "the crosses' moments of each instant's torque and angle",
        },
        source=SOURCE_DERIVED,
        validity="The line passes its resonances during the start, at the worst thrust. The "
        "steady response at each instant is listed too; centre_bearing_peak limits it "
        "in every gear.",
    ),
)

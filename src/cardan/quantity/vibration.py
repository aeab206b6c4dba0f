"""Torsional and lateral vibration; answered by the study of vibration."""

from cardan.base.source import ASOKANTHAN, DERIVED, MAZZEI
from cardan.quantity.declared import Quantity

DECLARED = (
    Quantity(
        key="torsional_resonance",
        study="vibration",
        name="Speed over torsional resonance",
        symbol="n/nr",
        unit="1",
        equation="n / nr,  nr = ωi / order",
        where={"n": "nearest speed of a gear's range", "ωi": "torsional natural frequency"},
        source=DERIVED,
        use="The joints excite orders 2 and 4. Frequencies of the line with its joints straight.",
    ),
    Quantity(
        key="torsional_growth",
        study="vibration",
        name="Growth of torsional vibration",
        symbol="λT",
        unit="per_s",
        equation="λT = max Re ln ρ / T,  det(P − ρ) = 0",
        where={"P": "what half a turn makes of small motions about the forced one"},
        source=ASOKANTHAN,
        use="Above 0 the line shakes itself up; at the speeds nearest to the zones.",
    ),
    Quantity(
        key="lateral_growth",
        study="vibration",
        name="Growth of lateral vibration",
        symbol="λL",
        unit="per_s",
        equation="λL = max Re ln ρ / T,  det(P − ρ) = 0",
        where={"P": "what half a turn makes of small lateral motions of a hung shaft"},
        source=MAZZEI,
        use="One shaft on its own rubber bearing, under the torque of the gear.",
    ),
)

"""Fatigue of a recording's gauges and of a bracket; answered by their studies."""

from cardan.checks.quantities.declaration import Quantity
from cardan.core.provenance import (
    ASTM_E1049,
    MINER_1945,
    SHAPLEY_1953,
    SOURCE_DERIVED,
    WIRSCHING_1984,
)

DECLARATIONS = (
    Quantity(
        key="stress_range",
        name="Stress range",
        symbol="Δσ",
        unit="MPa",
        equation="Δσ = |σ2 − σ1| of each rainflow cycle",
        symbol_meanings={"σ1, σ2": "reversals that bound the cycle"},
        source=ASTM_E1049.with_place("section 5.4.4"),
        validity="What never closes, the residue, holds the largest cycle: say how it is counted.",
    ),
    Quantity(
        key="fatigue_damage",
        study="recording",
        name="Fatigue damage",
        symbol="D",
        unit="1",
        equation="D = Σ n / N",
        symbol_meanings={
            "n": "counted cycles",
            "N": "cycles to failure at their amplitude and mean",
        },
        source=MINER_1945,
        validity="Failure at 1 by Miner; at 0.3 to 0.5 in careful practice under service loads.",
    ),
    Quantity(
        key="fatigue_life",
        study="recording",
        sense=">=",
        name="Fatigue life",
        symbol="L",
        unit="h",
        equation="L = t Dc / D",
        symbol_meanings={
            "t": "length of the recording",
            "Dc": "damage at failure",
            "D": "its damage",
        },
        source=MINER_1945,
        validity="Of a vehicle that goes on driving what was recorded.",
    ),
    Quantity(
        key="damage_exponent",
        name="Damage exponent",
        symbol="κ",
        unit="1",
        equation="κ = d ln D / d ln σ",
        symbol_meanings={"D": "damage", "σ": "scale of the stress"},
        source=SOURCE_DERIVED,
        validity="A gauge that reads 1 % high overstates damage by κ %.",
    ),
    Quantity(
        key="damage_share",
        name="Share of the damage",
        symbol="φ",
        unit="percent",
        equation="φi = Σ |S|! (G−1−|S|)! / G! · (D(S ∪ i) − D(S)) / D, over S without i",
        symbol_meanings={
            "G": "number of causes",
            "S": "a choice of the other causes",
            "D(S)": "damage of the sum of their stresses",
        },
        source=SHAPLEY_1953,
        validity=(
            "Damage is not additive; these shares sum to 1. Negative: the cause spares the part."
        ),
    ),
    Quantity(
        key="reliability_index",
        name="Reliability index",
        symbol="β",
        unit="1",
        equation="β = min |u| with g(u) = 0,  Pf ≈ Φ(−β)",
        symbol_meanings={"u": "the scattered quantities as standard normals", "g": "limit state"},
        source=WIRSCHING_1984,
        validity="Exact where g is linear in u, as for lognormals under one S-N line.",
    ),
)

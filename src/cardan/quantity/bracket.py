"""Stress and life of a bracket; answered by its study."""

from cardan.base.source import DERIVED, MINER
from cardan.quantity.declared import Quantity

DECLARED = (
    Quantity(
        key="bracket_stress_utilisation",
        study="bracket",
        name="Bracket stress over yield",
        symbol="σv/Re",
        unit="1",
        equation="largest von Mises stress at the hot spots / Re",
        where={"Re": "yield strength of the bracket's material"},
        source=DERIVED,
        use="Converged at hot spots away from sharp edges; quasi-static loads.",
    ),
    Quantity(
        key="bracket_life",
        study="bracket",
        name="Life of the bracket",
        symbol="Lb",
        unit="h",
        equation="Lb = 1 / Σ pi Di",
        where={"pi": "shares of the duty cycle", "Di": "damage of an hour of each at a hot spot"},
        source=MINER,
        sense=">=",
        use="Over a duty cycle, at the hot spot that fares worst.",
    ),
)

"""Stress and life of a bracket; answered by its study."""

from cardan.base.source import DERIVED, IIW, MINER, VDI2230
from cardan.quantity.declared import Quantity

DECLARED = (
    Quantity(
        key="bracket_stress_utilisation",
        study="bracket",
        name="Bracket stress over yield",
        symbol="σv/Re",
        unit="1",
        equation="largest von Mises stress / Re",
        where={"Re": "yield strength of the bracket's material"},
        source=DERIVED,
        use="On a refined mesh, at the worst place; structural stress at toes and clamps; "
        "quasi-static loads.",
    ),
    Quantity(
        key="bracket_fatigue_utilisation",
        study="bracket",
        name="Bracket stress over its fatigue limit",
        symbol="σa/σD",
        unit="1",
        equation="amplitude at zero mean / amplitude borne at the knee",
        where={"σD": "of the zone: sheet, cut edge, weld toe, bolt border"},
        source=IIW,
        use="In each zone, under the load case that comes nearest; loads that repeat.",
    ),
    Quantity(
        key="bracket_life",
        study="bracket",
        name="Life of the bracket",
        symbol="Lb",
        unit="h",
        equation="Lb = 1 / Σ pi Di",
        where={"pi": "shares of the duty cycle", "Di": "damage of an hour of each"},
        source=MINER,
        sense=">=",
        use="Over a duty cycle, at the worst place of each zone's surface.",
    ),
    Quantity(
        key="bracket_slip_utilisation",
        study="bracket",
        name="Bracket load over what its bolts hold",
        symbol="F/Fs",
        unit="1",
        equation="F / Fs",
        where={"Fs": "the load, in the same proportions, under which the flange slides or opens"},
        source=VDI2230,
        use="With `bolts`: contact and friction between flange and frame, each case's worst "
        "moment; below a quarter by balance alone, of which contact bears 0.6 at least.",
    ),
    Quantity(
        key="bracket_resonance",
        study="bracket",
        name="Bracket frequency over excitation",
        symbol="f1/f2",
        unit="1",
        equation="f1 / (2 n)",
        where={
            "f1": "first frequency: of the bracket alone on rubber, else with what it carries",
            "n": "highest speed of the shaft",
        },
        source=DERIVED,
        sense=">=",
        use="Order 2 of the joints, at the highest speed; the flange sliding.",
    ),
)

"""Stress and life of a bracket; answered by its study."""

from cardan.checks.quantities.declaration import Quantity
from cardan.core.provenance import IIW_2016, MINER_1945, SOURCE_DERIVED, VDI_2230_2015

DECLARATIONS = (
    Quantity(
        key="bracket_stress_utilisation",
        study="bracket",
        name="Bracket stress / yield",
        symbol="σv/Re",
        unit="1",
        equation="largest von Mises stress / Re",
        symbol_meanings={"Re": "yield strength of the bracket's material"},
        source=SOURCE_DERIVED,
        validity="On a refined mesh, at the worst place; structural stress at toes and clamps; "
        "quasi-static loads.",
    ),
    Quantity(
        key="bracket_fatigue_utilisation",
        study="bracket",
        name="Bracket stress / fatigue limit",
        symbol="σa/σD",
        unit="1",
        equation="amplitude at zero mean / amplitude borne at the knee",
        symbol_meanings={"σD": "of the zone: sheet, cut edge, weld toe, bolt border"},
        source=IIW_2016,
        validity="In each zone, under the load case that comes nearest; loads that repeat.",
    ),
    Quantity(
        key="bracket_life",
        study="bracket",
        name="Life of the bracket",
        symbol="Lb",
        unit="h",
        equation="Lb = 1 / Σ pi Di",
        symbol_meanings={"pi": "shares of the duty cycle", "Di": "damage of an hour of each"},
        source=MINER_1945,
        sense=">=",
        validity="Over a duty cycle, at the worst place of each zone's surface.",
    ),
    Quantity(
        key="bracket_slip_utilisation",
        study="bracket",
        name="Bracket load / slip load of bolts",
        symbol="F/Fs",
        unit="1",
        equation="F / Fs",
        symbol_meanings={
            "Fs": "the load, in the same proportions, under which the flange slides or opens"
        },
        source=VDI_2230_2015,
        validity="With `bolts`: contact and friction between flange and frame, each case's worst "
        "moment; below a quarter by balance alone, of which contact bears 0.6 at least.",
    ),
    Quantity(
        key="bracket_resonance",
        study="bracket",
        name="Bracket frequency / excitation",
        symbol="f1/f2",
        unit="1",
        equation="f1 / (2 n)",
        symbol_meanings={
            "f1": "first frequency: of the bracket alone on rubber, else with what it carries",
            "n": "highest speed of the shaft",
        },
        source=SOURCE_DERIVED,
        sense=">=",
        validity="Order 2 of the joints, at the highest speed; the flange sliding.",
    ),
)

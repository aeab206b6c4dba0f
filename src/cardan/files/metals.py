"""What each kind of metal bears in fatigue: the guideline's factors, and the codes' classes."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from cardan.base.units import GPa, MPa
from cardan.fatigue.detail import Endurance
from cardan.files.typical import rows
from cardan.model.bracket import ZONES, Zone
from cardan.model.material import Metal

AS_SHEET = "sheet"
"""In place of a detail's name: of a casting an edge is skin as the rest is."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Borne:
    """What a kind of metal bears: by its strength, and by a detail of each zone that has one."""

    endurance: Endurance
    details: Mapping[Zone, str]


def key_of(zone: str) -> str:
    """Return what files call the curve of a zone."""
    return zone.replace(" ", "_")


@cache
def borne(metal: Metal) -> Borne | None:
    """Return what a kind of metal bears; None of one that neither guideline nor code covers."""
    row = next((r for r in rows("metals.csv") if r["name"] == metal), None)
    if row is None:
        return None
    return Borne(
        endurance=Endurance(
            share=float(row["fatigue_ratio"]),
            rough=(float(row["roughness_constant"]), float(row["least_ultimate_MPa"]) * MPa),
            mean=(float(row["mean_slope_per_GPa"]) / GPa, float(row["mean_base"])),
        ),
        details={zone: name for zone in ZONES if (name := row.get(key_of(zone), ""))},
    )

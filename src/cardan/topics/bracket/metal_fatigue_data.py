"""Fatigue data of each kind of metal: constants of the FKM guideline, detail classes of zones."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from cardan.application.typical_values import shipped_csv_rows
from cardan.core.units import GPa, MPa
from cardan.model.bracket import FATIGUE_ZONES, FatigueZone
from cardan.model.material import MetalKind
from cardan.physics.fatigue.detail_classes import MetalFatigueData

DETAIL_NAME_SAME_AS_SHEET = "sheet"
"""In place of a detail's name: of a casting an edge is skin as the rest is."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BracketMetalFatigueData:
    """Fatigue data of the zones of a bracket that is made of one kind of metal."""

    metal: MetalFatigueData
    """The constants by which its tensile strength gives its fatigue strength."""
    details: Mapping[FatigueZone, str]
    """The name of the catalogue's detail class of each zone that has one."""


def zone_curve_key(zone: str) -> str:
    """Return what files call the curve of a zone."""
    return zone.replace(" ", "_")


@cache
def fatigue_data_of_metal(metal: MetalKind) -> BracketMetalFatigueData | None:
    """Return what a kind of metal bears; None of one that neither guideline nor code covers."""
    row = next((r for r in shipped_csv_rows("metals.csv") if r["name"] == metal), None)
    if row is None:
        return None
    return BracketMetalFatigueData(
        metal=MetalFatigueData(
            fatigue_strength_factor=float(row["fatigue_ratio"]),
            roughness_constants=(
                float(row["roughness_constant"]),
                float(row["least_ultimate_MPa"]) * MPa,
            ),
            mean_stress_constants=(float(row["mean_slope_per_GPa"]) / GPa, float(row["mean_base"])),
        ),
        details={
            zone: name for zone in FATIGUE_ZONES if (name := row.get(zone_curve_key(zone), ""))
        },
    )

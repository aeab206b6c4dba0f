"""What a part is made of. All SI."""

from dataclasses import replace
from typing import Literal, TypeAlias, get_args

from cardan.core.errors import require_positive
from cardan.core.lazy_dataclass import dataclass
from cardan.core.provenance import SOURCE_ASSUMED, Source
from cardan.core.units import GPa, MPa, Pascal

MetalKind: TypeAlias = Literal[
    "steel", "cast steel", "ductile iron", "malleable iron", "grey iron",
    "aluminium", "cast aluminium", "magnesium", "other",
]  # fmt: skip
"""Kinds of metal, that codes distinguish in fatigue."""
METAL_KINDS: tuple[MetalKind, ...] = get_args(MetalKind)
_STEEL = 180 * GPa
"""No steel is softer: cast irons have up to 176, titanium 115, aluminium 70."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Material:
    """An isotropic material."""

    name: str
    youngs_modulus: Pascal
    density: float
    poisson: float = 0.3
    yield_strength: Pascal | None = None
    ultimate_strength: Pascal | None = None
    fatigue_shear: Pascal | None = None
    kind: MetalKind | None = None
    """What metal it is, if given."""
    welded_yield: Pascal | None = None
    """Yield strength next to a weld, where its heat lowers it."""
    source: Source = SOURCE_ASSUMED

    def __post_init__(self) -> None:
        require_positive("a material", youngs_modulus=self.youngs_modulus, density=self.density)

    @property
    def shear_modulus(self) -> Pascal:
        """G = E / (2 (1 + nu))."""
        return self.youngs_modulus / (2 * (1 + self.poisson))

    @property
    def metal(self) -> MetalKind:
        """What metal it is: as said, else steel where it is as stiff as one."""
        return self.kind or ("steel" if self.youngs_modulus >= _STEEL else "other")

    @property
    def weld_softens(self) -> bool:
        """Whether the heat of a weld lowers its strength."""
        return self.welded_yield is not None or self.metal in ("aluminium", "cast aluminium")

    @property
    def yield_strength_at_weld(self) -> Pascal | None:
        """Yield strength next to a weld; None if it is lower by an unknown amount."""
        return self.welded_yield if self.weld_softens else self.yield_strength


STEEL = Material(
    name="steel",
    youngs_modulus=206 * GPa,
    density=7850.0,
    source=Source("EN 13906-1, spring steel: E = 206 GPa", how_read="from memory"),
)

ASSUMED_TUBE_STEEL = replace(
    STEEL,
    name="E355-N",
    yield_strength=355 * MPa,
    ultimate_strength=490 * MPa,
    source=Source(
        "No material is given: strength of E355 +N (EN 10305-1), the least of the tube steels "
        "here; E 206 GPa of EN 13906-1",
        how_read="assumed",
    ),
)
"""Steel of a tube that a file gives by its sizes alone. A real one is rarely weaker or softer."""

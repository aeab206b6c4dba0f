"""What a part is made of. All SI."""

from typing import Literal, TypeAlias, get_args

from cardan.base.errors import positive
from cardan.base.frozen import dataclass
from cardan.base.source import ASSUMED, Source
from cardan.base.units import GPa, Pascal

Metal: TypeAlias = Literal[
    "steel", "cast steel", "ductile iron", "malleable iron", "grey iron",
    "aluminium", "cast aluminium", "magnesium", "other",
]  # fmt: skip
"""Kinds of metal, by which codes tell apart what bears in fatigue."""
METALS: tuple[Metal, ...] = get_args(Metal)
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
    kind: Metal | None = None
    """What metal it is, where somebody said so."""
    welded_yield: Pascal | None = None
    """Yield strength beside a weld, where its heat lowers it."""
    source: Source = ASSUMED

    def __post_init__(self) -> None:
        positive("a material", youngs_modulus=self.youngs_modulus, density=self.density)

    @property
    def shear_modulus(self) -> Pascal:
        """G = E / (2 (1 + nu))."""
        return self.youngs_modulus / (2 * (1 + self.poisson))

    @property
    def metal(self) -> Metal:
        """What metal it is: as said, else steel where it is as stiff as one."""
        return self.kind or ("steel" if self.youngs_modulus >= _STEEL else "other")

    @property
    def softens(self) -> bool:
        """Whether the heat of a weld lowers its strength."""
        return self.welded_yield is not None or self.metal in ("aluminium", "cast aluminium")

    @property
    def yield_beside_weld(self) -> Pascal | None:
        """Yield strength beside a weld; None where it is lower, and nobody said by how much."""
        return self.welded_yield if self.softens else self.yield_strength


STEEL = Material(
    name="steel",
    youngs_modulus=206 * GPa,
    density=7850.0,
    source=Source("EN 13906-1, spring steel: E = 206 GPa", how_read="from memory"),
)

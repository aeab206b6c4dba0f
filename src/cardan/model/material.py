"""What a part is made of. All SI."""

from cardan.base.errors import positive
from cardan.base.frozen import dataclass
from cardan.base.source import ASSUMED, Source
from cardan.base.units import GPa, Pascal


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
    source: Source = ASSUMED

    def __post_init__(self) -> None:
        positive("a material", youngs_modulus=self.youngs_modulus, density=self.density)

    @property
    def shear_modulus(self) -> Pascal:
        """G = E / (2 (1 + nu))."""
        return self.youngs_modulus / (2 * (1 + self.poisson))


STEEL = Material(
    name="steel",
    youngs_modulus=206 * GPa,
    density=7850.0,
    source=Source("EN 13906-1, spring steel: E = 206 GPa", how_read="from memory"),
)

"""Variants of an application: what varies, what scatters, and what is computed of all of them."""

from collections.abc import Iterable, Mapping
from dataclasses import field
from math import prod
from typing import Literal, TypeAlias

from cardan.core.lazy_dataclass import dataclass

VariationKind: TypeAlias = Literal["range", "choice", "grid", "normal", "uniform"]
ParetoObjective: TypeAlias = Literal["margin", "cost", "mass"]

MAX_VARIANTS = 100_000_000
"""Variants that are evaluated, or predicted, at most."""

MAX_GRID_POINTS = 100_000
"""Places of all grids crossed, at most: each shard holds them all."""


def grid_point_count(grids: Iterable["VariedNumber"]) -> int:
    """Return how many places grids have together, each with every other's.

    Raises
    ------
    ValueError
        If they are too many.
    """
    each = [len(g.values) for g in grids]
    if (found := prod(each)) > MAX_GRID_POINTS:
        places = " × ".join(map(str, each))
        msg = f"grids of {places} places are {found} variants, of {MAX_GRID_POINTS} at most"
        raise ValueError(msg)
    return found


@dataclass(frozen=True, slots=True, kw_only=True)
class VariedNumber:
    """How one number varies, in the unit that its key ends in.

    Attributes
    ----------
    kind
        Over a `range`; one of a `choice`, by chance; each of a `grid`, crossed with every
        other grid. `normal` and `uniform` go about the number as it is.
    values
        Lowest and highest; the choices; the places of the grid; the standard deviation; the
        half width.
    """

    kind: VariationKind
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class VariantOutputs:
    """What is computed of variants, in addition to how many come to each verdict.

    Attributes
    ----------
    yield_
        Whether the share that may be built is told, with its interval of `confidence`.
    yield_only
        Whether nothing else is: a variant that fails a limit without rubber is then not
        evaluated on rubber. No limit has a table, and no variant is among the worst.
    quantiles
        Of every limit's value and margin.
    worst
        How many of the worst variants are reported with all that varied in them.
    sobol
        Whether variance is shared out to what varies.
    pareto
        What is weighed against each other.
    search
        How many variants more are bred for that.
    maps
        Pairs of names, over which the yield is drawn.
    limits
        Quantities whose limits count; all where none is named.
    rare
        Whether the failure rate of limits that variants hardly ever fail is computed.
    foretold
        How many variants more are predicted from those evaluated, for the yield.
    rows
        Whether each variant is kept, and in which precision.
    """

    yield_: bool = True
    yield_only: bool = False
    confidence: float = 0.95
    quantiles: tuple[float, ...] = ()
    worst: int = 3
    sobol: bool = False
    pareto: tuple[ParetoObjective, ...] = ()
    search: int = 0
    maps: tuple[tuple[str, str], ...] = ()
    limits: tuple[str, ...] = ()
    rare: bool = False
    foretold: int = 0
    rows: Literal["float32", "float64"] | None = None

    def __post_init__(self) -> None:
        if len(set(self.pareto)) < len(self.pareto):
            msg = f"pareto weighs each once, against others, got {', '.join(self.pareto)}"
            raise ValueError(msg)
        if self.yield_only and (others := self.excluded_by_yield_only):
            msg = f"`ask`: yield_only reports nothing else: remove {', '.join(others)}"
            raise ValueError(msg)

    @property
    def excluded_by_yield_only(self) -> tuple[str, ...]:
        """The keys given that need every limit of every variant, or leave the yield out."""
        keys = ("quantiles", "sobol", "pareto", "maps", "rare", "foretold", "rows")
        return (*(("yield",) if not self.yield_ else ()), *(k for k in keys if getattr(self, k)))


@dataclass(frozen=True, slots=True, kw_only=True)
class VariantStudy:
    """A study of variants: what is chosen, what scatters about that, and what is computed.

    `vary` and `tolerances` go by the address of a number, or the key of something that can
    be moved; `[*]` stands for every part. `correlated` are pairs of names of tolerances with
    their correlation, of the normal numbers they are made of. Where it was read, errors name
    the `file` (that of the application without) and the `places`, line and column, of what varies,
    of `correlated` and of `ask`.
    """

    vary: Mapping[str, VariedNumber] = field(default_factory=dict[str, VariedNumber])
    tolerances: Mapping[str, VariedNumber] = field(default_factory=dict[str, VariedNumber])
    correlated: tuple[tuple[str, str, float], ...] = ()
    ask: VariantOutputs = field(default_factory=VariantOutputs)
    file: str = field(default="", repr=False, compare=False)
    places: Mapping[str, tuple[int, int]] = field(
        default_factory=dict[str, tuple[int, int]], repr=False, compare=False
    )


def without_addresses_of_study_section(addresses: Iterable[str]) -> list[str]:
    """Return the addresses without those of a study, which varies others but not itself."""
    return [at for at in addresses if not at.startswith("study.")]

"""Where variants lie: any stretch of them, from its places alone.

A variant's random numbers are those of its place in a stream that counts (Philox), so
a shard draws the same on every worker, at any time, whatever was drawn before.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Literal, TypeAlias

import numpy as np

from cardan.core.arrays import BoolArray, FloatArray
from cardan.core.lazy_dataclass import dataclass
from cardan.model.adjustments import known_names_matching_pattern
from cardan.model.variants import VariantStudy, VariedNumber, grid_point_count
from cardan.schema.node_reader import nearest_name_hint

SamplingMethod: TypeAlias = Literal["even", "random", "saltelli"]
"""How variants are spread: evenly (Sobol), by Monte Carlo, or in pairs for shares of variance."""

VARIANTS_PER_CHUNK = 128
"""Variants at a time: fewer pay more for each step, more of them leave the processor's cache."""

HALF_RANDOM_NUMBER_SPACING = 2.0**-54
"""Half the step of the random numbers: no number lies on the edge of (0, 1)."""

MIN_INDEPENDENT_VARIANCE_SHARE = 1e-9
"""Share of the variance that correlations leave free, at least: weights divide by it."""

MIN_UNIFORM_SAMPLE_EDGE_DISTANCE = 2.0**-32
"""How near to the edge evenly spread points may lie."""


@dataclass(frozen=True, kw_only=True)
class SampledVariable:
    """One thing that is drawn: an input varied, or the tolerance about it."""

    input: int
    spread: VariedNumber
    tolerance: bool = False


@dataclass(frozen=True, kw_only=True)
class SamplingPlan:
    """Where variants lie.

    Attributes
    ----------
    names
        What varies, `[*]` written out.
    nominal : (inputs,)
        Each as it is, in the unit of its name.
    factors
        What is drawn; several may change one input.
    grids
        Those that are gone through, not drawn.
    correlation_factor : (tolerances, tolerances)
        Lower factor of their correlations; None where they are independent.
    method, seed
        How they are spread, and which of all such spreads.
    """

    names: tuple[str, ...]
    nominal: tuple[float, ...]
    factors: tuple[SampledVariable, ...]
    grids: tuple[SampledVariable, ...] = ()
    correlation_factor: tuple[tuple[float, ...], ...] | None = None
    method: SamplingMethod = "random"
    seed: int = 0

    @property
    def group_size(self) -> int:
        """Variants that belong together: a whole grid, a base point with its pairs."""
        if self.method == "saltelli":
            return len(self.factors) + 2
        return grid_point_count(g.spread for g in self.grids)

    def name_of(self, factor: SampledVariable) -> str:
        """Return the name of what a factor changes."""
        return self.names[factor.input]

    def values(self, start: int, stop: int) -> FloatArray:
        """Return the inputs of variants from a place to another, (V, inputs)."""
        return self.inputs_at(self.unit_points(start, stop), start)

    def unit_points(self, start: int, stop: int) -> FloatArray:
        """Return the points of variants in the unit cube, (V, factors)."""
        count, wide = stop - start, len(self.factors)
        if not wide:
            return np.empty((count, 0))
        if self.method == "even":
            from scipy.stats.qmc import Sobol  # slow to import: only a study waits for it

            engine = Sobol(wide, rng=np.random.default_rng(self.seed))
            if start:
                engine.fast_forward(start)
                return np.clip(
                    engine.random(count),
                    MIN_UNIFORM_SAMPLE_EDGE_DISTANCE,
                    1 - MIN_UNIFORM_SAMPLE_EDGE_DISTANCE,
                )
            whole = engine.random_base2(int(count - 1).bit_length())
            return np.clip(
                whole[:count],
                MIN_UNIFORM_SAMPLE_EDGE_DISTANCE,
                1 - MIN_UNIFORM_SAMPLE_EDGE_DISTANCE,
            )
        if self.method == "random":
            return self._dice(start, stop, wide)
        first, last = start // self.group_size, -(-stop // self.group_size)
        one, other = np.split(self._dice(first, last, 2 * wide), 2, axis=1)
        pairs = np.repeat(one[:, None], wide + 2, axis=1)
        pairs[:, 1] = other
        for k in range(wide):
            pairs[:, 2 + k, k] = other[:, k]
        return pairs.reshape(-1, wide)[start - first * self.group_size :][:count]

    def _dice(self, start: int, stop: int, wide: int) -> FloatArray:
        """Return independent numbers (rows, wide) within (0, 1), row by row of the stream."""
        ticks = -(-wide // 4)  # Philox makes four at a time
        stream = np.random.Philox(key=self.seed, counter=start * ticks)
        found = np.random.Generator(stream).random((stop - start, 4 * ticks))
        return found[:, :wide] + HALF_RANDOM_NUMBER_SPACING

    def inputs_at(self, unit: FloatArray, start: int = 0, *, scattered: bool = True) -> FloatArray:
        """Return the inputs (V, inputs) at points (V, factors) of the unit cube.

        As they are, or as they were meant to be before they `scattered`.
        """
        found = np.tile(np.asarray(self.nominal, dtype=float), (len(unit), 1))
        place, before = np.arange(start, start + len(unit)), 1
        for grid in self.grids:
            places = np.asarray(grid.spread.values)
            found[:, grid.input] = places[place // before % len(places)]
            before *= len(places)
        normal = self.standard_normal(unit)
        for k, factor in enumerate(self.factors):
            if not factor.tolerance:
                found[:, factor.input] = _drawn(
                    factor.spread, unit[:, k], at=found[:, factor.input]
                )
        for k, factor in enumerate(self.factors):
            if factor.tolerance and scattered:
                found[:, factor.input] += _scattered(factor.spread, normal[:, k])
        return found

    def standard_normal(self, unit: FloatArray) -> FloatArray:
        """Return the standard normal numbers (V, factors) of points, tolerances correlated."""
        from scipy.special import ndtri

        found = ndtri(unit)
        if self.correlation_factor is not None:
            own = [k for k, f in enumerate(self.factors) if f.tolerance]
            found[:, own] = found[:, own] @ np.asarray(self.correlation_factor).T
        return found

    def independent(self, start: int, stop: int) -> BoolArray:
        """Return which variants are drawn by themselves, (V,): of pairs the two ends."""
        if self.method != "saltelli":
            return np.ones(stop - start, dtype=bool)
        return np.arange(start, stop) % self.group_size < 2


def _drawn(spread: VariedNumber, unit: FloatArray, *, at: FloatArray) -> FloatArray:
    """Return the values of a number (V,) at places within (0, 1)."""
    from scipy.special import ndtri

    values = np.asarray(spread.values)
    match spread.kind:
        case "choice" | "grid":
            return values[(unit * values.size).astype(int)]
        case "range":
            return values[0] + unit * (values[1] - values[0])
        case "normal":
            return at + values[0] * ndtri(unit)
        case "uniform":
            return at + values[0] * (2 * unit - 1)


def _scattered(spread: VariedNumber, normal: FloatArray) -> FloatArray:
    """Return how far numbers are off where standard normal numbers are these."""
    from scipy.special import ndtr

    if spread.kind == "normal":
        return spread.values[0] * normal
    return spread.values[0] * (2 * ndtr(normal) - 1)


def sampling_plan(
    variants: VariantStudy,
    known: Mapping[str, float],
    *,
    seed: int = 0,
    points: SamplingMethod | None = None,
) -> SamplingPlan:
    """Return where the variants of a study lie.

    Parameters
    ----------
    variants
        What varies and scatters.
    known
        Every number that may, as it is, by name.
    seed
        Another one gives other variants.
    points
        By default in pairs where variance is shared out, by Monte Carlo if there are
        tolerances, so that an interval can be given; evenly otherwise.

    Raises
    ------
    ValueError
        If nothing goes by a name, or correlations contradict each other.
    """
    vary = dict(_each(variants.vary, known))
    scatter = dict(_each(variants.tolerances, known))
    names = tuple(dict.fromkeys((*vary, *scatter)))
    if not names:
        msg = "nothing varies: name the address of a number, or a thing that can be moved"
        raise ValueError(msg)
    if points is None:
        points = (
            "saltelli" if variants.ask.sobol else "random" if scatter else "even"
        )  # fmt: skip
    chosen = [SampledVariable(input=names.index(n), spread=s) for n, s in vary.items()]
    crossed = points != "saltelli"  # pairs take the places of a grid by chance
    factors = (
        *(f for f in chosen if not crossed or f.spread.kind != "grid"),
        *(
            SampledVariable(input=names.index(n), spread=s, tolerance=True)
            for n, s in scatter.items()
        ),
    )
    found = SamplingPlan(
        names=names,
        nominal=tuple(float(known[n]) for n in names),
        factors=factors,
        grids=tuple(f for f in chosen if crossed and f.spread.kind == "grid"),
        method=points,
        seed=seed,
    )
    return replace(found, correlation_factor=_mixed(found, variants))


def _mixed(of: SamplingPlan, variants: VariantStudy) -> tuple[tuple[float, ...], ...] | None:
    """Return the lower factor of the tolerances' correlations; None where there are none."""
    if not variants.correlated:
        return None
    if of.method == "saltelli":
        msg = "`ask`: sobol needs independent inputs: remove correlated or sobol"
        raise ValueError(msg)
    names = [of.name_of(f) for f in of.factors if f.tolerance]
    whole = np.eye(len(names))
    for one, other, r in variants.correlated:
        for a in known_names_matching_pattern(one, names):
            for b in known_names_matching_pattern(other, names):
                if a != b:
                    i, j = names.index(a), names.index(b)
                    whole[i, j] = whole[j, i] = r
    if (least := np.linalg.eigvalsh(whole)[0]) < MIN_INDEPENDENT_VARIANCE_SHARE:
        what = (
            "contradict each other"
            if least < -MIN_INDEPENDENT_VARIANCE_SHARE
            else "leave one number no freedom of its own"
        )
        msg = f"correlated: these correlations {what}; make them smaller"
        raise ValueError(msg)
    return tuple(map(tuple, np.linalg.cholesky(whole).tolist()))


def _each(
    spreads: Mapping[str, VariedNumber], known: Mapping[str, float]
) -> Iterator[tuple[str, VariedNumber]]:
    """Yield what varies by its name, for `[*]` one after the other."""
    whose: dict[str, str] = {}
    for name, spread in spreads.items():
        found: Sequence[str] = known_names_matching_pattern(name, known)
        if not found:
            msg = (
                f"no number has the address {name}; "
                f"{nearest_name_hint(name.replace('*', '1'), known)}"
            )
            raise ValueError(msg)
        for one in found:
            if (other := whose.setdefault(one, name)) != name:
                msg = f"{name}: {one} goes by {other} too; name each number once"
                raise ValueError(msg)
            yield one, spread

"""A front that is bred: the unbeaten have variants of their own, generation by generation.

Variants drawn evenly leave a front where they happened to fall; NSGA-II goes on from the best, a
whole generation evaluated at once.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from importlib import import_module
from typing import Any, TypeAlias

import numpy as np

from cardan.application.variant_sampling import VARIANTS_PER_CHUNK, SamplingPlan
from cardan.core.arrays import FloatArray
from cardan.core.errors import MissingDependencyError
from cardan.model.variants import ParetoObjective
from cardan.topics.variants.evaluation import (
    EvaluatedVariants,
    LimitResults,
    VariantEvaluator,
)
from cardan.topics.variants.statistics import (
    WORST_ACCEPTABLE_VERDICT_INDEX,
    ParetoFront,
    StatisticState,
    adjustable_of_each_input,
)

GENERATION_SIZE = 64
"""Variants of a generation."""

INFEASIBLE_PENALTY = 1e9
"""Goal of what cannot exist."""

ObjectiveValuesCallback: TypeAlias = Callable[[FloatArray, FloatArray], None]
"""Takes the goals (V, goals) of a generation, and by how much each may not be built, (V,)."""


def evolve_pareto_front(
    bench: VariantEvaluator,
    goals: tuple[ParetoObjective, ...],
    front: StatisticState,
    *,
    count: int,
    start: int = 0,
    seed: int = 0,
    hear: Callable[[int], None] = lambda _: None,
) -> StatisticState:
    """Return what no other variant beats, of a front and of those bred for it.

    Parameters
    ----------
    bench
        The application, and what is chosen in it; a grid gives its places, each by itself.
    goals
        What is weighed.
    front
        What is unbeaten of the variants drawn.
    count
        How many are bred; the last generation is whole.
    start
        The place of the first, behind those drawn.
    seed
        Another one breeds others.
    hear
        Receives how many are done.

    Raises
    ------
    ValueError
        If something scatters: the lucky would win.
    MissingDependencyError
        If pymoo is not there.

    Notes
    -----
    NSGA-II (Deb et al., IEEE Trans. Evol. Comput. 6, 2002), with simulated binary crossover and
    polynomial mutation on the unit cube. What may be built beats what may not, and of those the
    one nearer to it is better. It proves nothing: another may be better still.
    """
    chosen = _chosen(bench.sampling_plan)
    table = replace(bench, sampling_plan=chosen)
    keep = ParetoFront(goals=goals, costs=adjustable_of_each_input(table), sampling_plan=chosen)
    done = 0
    for unit, tell in _generations(len(chosen.factors), len(goals), count=count, seed=seed):
        inputs = chosen.inputs_at(unit)
        parts = [
            table.evaluate(inputs[k : k + VARIANTS_PER_CHUNK])
            for k in range(0, len(inputs), VARIANTS_PER_CHUNK)
        ]
        rows = table.collect(
            inputs, LimitResults.concatenate(parts), unit, np.ones(len(unit), dtype=bool)
        )
        tell(keep.goal_values(rows, 0), _unfit(rows))
        front = keep.merge(front, keep.shard_state(rows, start + done))
        done += len(unit)
        hear(done)
    return front


def _chosen(drawing: SamplingPlan) -> SamplingPlan:
    """Return what is chosen, a grid's places by chance."""
    if any(f.tolerance for f in drawing.factors):
        msg = "search breeds what vary chooses: remove tolerances"
        raise ValueError(msg)
    return replace(drawing, factors=(*drawing.factors, *drawing.grids), grids=(), method="random")


def _unfit(rows: EvaluatedVariants) -> FloatArray:
    """Return by how much each may not be built, (V,): 0 where it may."""
    short = np.maximum(-np.nan_to_num(rows.margins, nan=-INFEASIBLE_PENALTY), 0.0)
    return np.where(rows.grades <= WORST_ACCEPTABLE_VERDICT_INDEX, 0.0, 1.0 + short)


def _generations(
    factors: int, goals: int, *, count: int, seed: int
) -> Iterator[tuple[FloatArray, ObjectiveValuesCallback]]:
    """Yield the points of a generation (V, factors) in the unit cube, and where to send results."""
    try:
        import_module("pymoo.config").Config.warnings["not_compiled"] = False
    except ModuleNotFoundError as error:
        msg = "search needs pymoo: pip install 'cardan[pareto]'"
        raise MissingDependencyError(msg) from error
    nsga2: Any = import_module("pymoo.algorithms.moo.nsga2").NSGA2
    problem_of: Any = import_module("pymoo.core.problem").Problem
    problem = problem_of(n_var=factors, n_obj=goals, n_ieq_constr=1, xl=0.0, xu=1.0)
    algorithm = nsga2(pop_size=GENERATION_SIZE)
    algorithm.setup(problem, termination=("n_eval", count), seed=seed)
    while algorithm.has_next():
        generation = algorithm.ask()

        def tell(weighed: FloatArray, unfit: FloatArray, of: Any = generation) -> None:
            of.set("F", np.nan_to_num(weighed, nan=INFEASIBLE_PENALTY))
            of.set("G", unfit[:, None])
            for one in of:
                one.evaluated |= {"F", "G"}
            algorithm.evaluator.n_eval += len(of)
            algorithm.tell(infills=of)

        yield np.clip(generation.get("X").astype(float), 0.0, 1 - 2.0**-53), tell

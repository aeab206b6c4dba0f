"""A study of many variants, shard by shard: in threads, processes or on a cluster.

A shard is a stretch of variants. Every worker draws the same, and its statistics are
joined in a fixed order, so the answer is the same to the last bit however it was
computed: at once, by many, or in pieces after the computer went down. A cluster is handed several
shards at a time, as many as take it `MAX_TASK_S`, and merges them where they were computed.
"""

from collections.abc import Callable, Generator, Mapping
from concurrent.futures import (
    FIRST_COMPLETED,
    Executor,
    Future,
    ThreadPoolExecutor,
    wait,
)
from contextlib import ExitStack, contextmanager
from functools import partial
from importlib import import_module
from os import cpu_count
from pathlib import Path
from threading import Event
from time import perf_counter

import numpy as np

from cardan.application.variant_sampling import SamplingMethod
from cardan.core.arrays import single_threaded_blas
from cardan.core.errors import DesignError
from cardan.core.status import ignore_status
from cardan.model.application import Application, require_no_placeholders
from cardan.model.variants import VariantStudy
from cardan.topics.variants.evaluation import (
    EvaluatedVariants,
    LimitResults,
    VariantEvaluator,
)
from cardan.topics.variants.executors import DaskExecutor
from cardan.topics.variants.pareto import evolve_pareto_front
from cardan.topics.variants.rare_failure import RareFailureEstimate, estimate_rare_failure
from cardan.topics.variants.shard_job import (
    ComputedShards,
    ShardJob,
    ShardResult,
    compute_shards,
    file_stamps,
    serialise_shard_job,
)
from cardan.topics.variants.shard_store import ShardStore
from cardan.topics.variants.shard_tree import (
    ShardNode,
    merged_statistics,
    next_node,
    shards_of,
)
from cardan.topics.variants.statistics import (
    StatisticState,
    requested_statistics,
)
from cardan.topics.variants.study_result import (
    ProgressCallback,
    StudyInterrupted,
    StudyProgress,
    VariantStudyResult,
    acceptable_and_independent,
)
from cardan.topics.variants.yield_surrogate import predict_yield

VARIANTS_PER_SHARD = 512
"""Variants of a shard, about: whole grids, or groups of pairs."""

MIN_FAILED_VARIANTS_PER_LIMIT = 20
"""Variants: of a limit that fewer fail the share is known badly."""

WORKER_TIMEOUT_S = 10.0
"""Seconds without a shard after which a cluster is checked for workers."""

QUEUE_DEPTH_PER_WORKER = 3
"""Tasks handed out for each worker: what waits costs memory."""

QUEUE_DEPTH_PER_CLUSTER_WORKER = 8
"""The same of a cluster, which is handed half of it at a time: the more, the less each costs."""

TASKS_PER_WORKER_AT_LAST = 3
"""Into so many tasks for each worker of a cluster is cut what is left: all end about together."""

TASK_OVERHEAD_S = 2.5e-3
"""Processor time of client and scheduler for a task. Tasks take so long that handing them out keeps
the two busy half of the time at most."""

MAX_TASK_S = 30.0
"""Seconds that shards handed to a cluster's worker at once take at most; half of that at least,
if there are enough. A lost worker costs as much."""


def run_study(
    application: Application,
    variants: VariantStudy,
    *,
    count: int = 10_000,
    seed: int = 0,
    points: SamplingMethod | None = None,
    folder: Path | None = None,
    resume: bool = False,
    executor: Executor | None = None,
    workers: int | None = 1,
    shard: int = VARIANTS_PER_SHARD,
    hear: ProgressCallback = ignore_status,
) -> VariantStudyResult:
    """Evaluate the driveline of many variants, and return their statistics.

    Parameters
    ----------
    application, variants
        As read from a file.
    count
        How many variants; whole grids, and whole groups of pairs.
    seed
        Of the points.
    folder
        Where each shard is kept as it is done; None keeps them in memory.
    resume
        Go on with what the folder holds; without, it must hold no study.
    executor
        Evaluates shards, `workers` at a time: any of `concurrent.futures`, or a cluster's. By
        default threads of this process; None as many as this machine, or a cluster, has.
    shard
        How many variants are evaluated at a time, about.
    hear
        Receives the progress.

    Raises
    ------
    ValueError
        If nothing goes by a name, or cannot vary as requested.
    InvalidFileError
        If the folder holds another study, or one already.
    StudyInterrupted
        If it was stopped from the keyboard; it holds the result of the shards done.
    DesignError
        If the application holds placeholders.
    """
    require_no_placeholders(application)
    job, asked = ShardJob.from_study(application, variants, seed=seed, points=points), variants.ask
    bench, stamps = job.evaluator, file_stamps(job)
    count, size = (
        bench.whole_count(count),
        -(-shard // bench.sampling_plan.group_size) * bench.sampling_plan.group_size,
    )
    spans = [(k, min(k + size, count)) for k in range(0, count, size)]
    store = ShardStore.open(folder, job, size, count=count, resume=resume) if folder else None
    found: dict[ShardNode, ShardResult] = {}
    done = {k for k, span in enumerate(spans) if store and store.contains(k, span)}
    damaged = store.damaged_records if store else 0
    damaged += sum(store.lacks_rows(k) for k in range(len(spans)) if k not in done) if store else 0
    before, begun = sum(spans[k][1] - spans[k][0] for k in done), perf_counter()
    finished = before

    def now(done: int, rare: tuple[int, int] | None = None, *, idle: bool = False) -> None:
        seconds, total = perf_counter() - begun, count + asked.search
        hear(StudyProgress(
            done_before=before, done=done, count=total, seconds=seconds, rare=rare, idle=idle,
            damaged=damaged,
        ))  # fmt: skip

    def keep(node: ShardNode, got: ShardResult) -> None:
        nonlocal finished, stamps
        if stamps != (stamps := file_stamps(job)) and (other := job.changed_inputs):
            msg = f"{other} changed while the study ran: begin it anew"
            raise DesignError(msg)
        shards = shards_of(node)
        if store:
            store.save(shards[0], spans[shards[0]], got, job)
        else:
            found[node] = got
        done.update(shards)
        finished += spans[shards[-1]][1] - spans[shards[0]][0]
        now(finished)

    now(before)
    todo = [k for k in range(len(spans)) if k not in done]
    stopped = False
    try:
        _run_shards(
            job, {k: spans[k] for k in todo}, keep, executor=executor, workers=workers,
            merged=store is None and not job.row_precision,
            idle=lambda: now(finished, idle=True),
        )  # fmt: skip
    except KeyboardInterrupt:
        stopped = True
        if not done:
            raise
    finally:
        if store:
            store.close()
    if store:
        store.put_in_order()
    each = {(0, k): store.load(k) for k in sorted(done)} if store else (
        {node: r.statistics for node, r in found.items()}
    )  # fmt: skip
    told = dict(merged_statistics(requested_statistics(bench, variants.ask), each))
    if asked.search and not stopped:
        try:
            told["pareto"] = evolve_pareto_front(
                bench, asked.pareto, told["pareto"], count=asked.search, start=count, seed=seed,
                hear=lambda more: now(count + min(more, asked.search)),
            )  # fmt: skip
        except KeyboardInterrupt:
            stopped = True
    hardly: list[RareFailureEstimate] = []
    if asked.rare and not stopped:
        few = _rarely_failing_limits(bench, told["counts"])
        try:
            for at, k in enumerate(few):
                now(count + asked.search, (at, len(few)))
                hardly.append(estimate_rare_failure(bench, k))
        except KeyboardInterrupt:
            stopped = True
    result = VariantStudyResult(
        evaluator=bench,
        variants=variants,
        requested_count=count,
        statistics=told,
        rows=_rows_in_memory(bench, found, spans),
        rare_failures=tuple(r for r in hardly if not r.is_negligible),
        negligible_failures=tuple(r for r in hardly if r.is_negligible),
        surrogate_yield=None
        if stopped or not asked.foretold
        else predict_yield(
            bench.sampling_plan,
            told["taught"],
            count=asked.foretold,
            start=count,
            confidence=asked.confidence,
            asked=acceptable_and_independent(told["counts"]),
            workers=workers or cpu_count() or 1,
        ),
        seconds=perf_counter() - begun,
    )
    if stopped:
        raise StudyInterrupted(result)
    return result


def _run_shards(
    job: ShardJob,
    spans: Mapping[int, tuple[int, int]],
    keep: Callable[[ShardNode, ShardResult], None],
    *,
    executor: Executor | None,
    workers: int | None,
    merged: bool,
    idle: Callable[[], None],
) -> None:
    """Have shards computed, and keep each as it comes; report while there is no worker.

    Workers of a cluster return them `merged` where each alone is not needed.
    """
    stop, cluster = Event(), executor if isinstance(executor, DaskExecutor) else None

    def there() -> int:
        return cluster.worker_threads if cluster else cpu_count() or 1

    def here(span: tuple[int, int]) -> ComputedShards:
        return ComputedShards(results=(job.run_shard(*span, stop),), seconds=0.0)

    with _open_workers(executor, workers or there()) as (of, own), ExitStack() as stack:
        parcel: bytes | str = b"" if own else serialise_shard_job(job)
        if cluster and spans:
            assert isinstance(parcel, bytes)
            parcel = stack.enter_context(cluster.held_by_workers(parcel))
        tasks = cluster or _ExecutorTasks(of)
        depth = QUEUE_DEPTH_PER_CLUSTER_WORKER if cluster else QUEUE_DEPTH_PER_WORKER
        todo, at, seconds = sorted(spans), 0, 0.0

        def call_of(node: ShardNode) -> Callable[[], ComputedShards]:
            some = [spans[k] for k in shards_of(node)]
            return partial(here, *some) if own else partial(
                compute_shards, parcel, some, merged=merged
            )  # fmt: skip

        try:
            while at < len(todo) or tasks.pending_count:
                many = max(there() if workers is None else workers, 1)
                # A cluster's workers get one shard each until the time it takes is known.
                slots = many if cluster and not seconds else many * depth
                if at < len(todo) and tasks.pending_count <= slots // 2:
                    calls: dict[ShardNode, Callable[[], ComputedShards]] = {}
                    while at < len(todo) and tasks.pending_count + len(calls) < slots:
                        left = (len(todo) - at) / many / TASKS_PER_WORKER_AT_LAST * seconds
                        most = min(MAX_TASK_S, max(left, 2 * many * TASK_OVERHEAD_S))
                        node = next_node(todo, at, most / seconds if cluster and seconds else 1)
                        at += len(shards_of(node))
                        calls[node] = call_of(node)
                    tasks.submit_all(calls)
                done = tasks.finished(WORKER_TIMEOUT_S)
                if not done and not there():
                    idle()
                for node, got in done:
                    seconds = got.seconds / len(shards_of(node))
                    nodes = [node] if len(got.results) == 1 else [(0, k) for k in shards_of(node)]
                    for own_node, result in zip(nodes, got.results, strict=True):
                        keep(own_node, result)
        finally:
            stop.set()
            tasks.cancel_all()


class _ExecutorTasks:
    """Calls that an executor of `concurrent.futures` makes."""

    def __init__(self, of: Executor) -> None:
        self._executor = of
        self._pending: dict[Future[ComputedShards], ShardNode] = {}

    @property
    def pending_count(self) -> int:
        """How many are out."""
        return len(self._pending)

    def submit_all(self, calls: Mapping[ShardNode, Callable[[], ComputedShards]]) -> None:
        """Hand out calls."""
        for node, call in calls.items():
            self._pending[self._executor.submit(call)] = node

    def finished(self, timeout: float) -> list[tuple[ShardNode, ComputedShards]]:
        """Return calls that are done, each with what it returned; wait for one."""
        done = wait(self._pending, timeout=timeout, return_when=FIRST_COMPLETED).done
        return [(self._pending.pop(future), future.result()) for future in done]

    def cancel_all(self) -> None:
        """Take back what is out."""
        for future in self._pending:
            future.cancel()


@contextmanager
def _open_workers(
    executor: Executor | None, workers: int
) -> Generator[tuple[Executor, bool], None, None]:
    """Give the executor of shards, and whether it shares this process's memory."""
    if executor is not None:
        yield executor, False
        return
    import_module("scipy.linalg")
    with (
        single_threaded_blas(),
        ThreadPoolExecutor(max(workers, 1), thread_name_prefix="study") as own,
    ):
        yield own, True


def _rarely_failing_limits(bench: VariantEvaluator, counts: StatisticState) -> list[int]:
    """Return the places of the limits that hardly ever failed."""
    fails, answered = counts["grades"][:, 2], counts["grades"][:, :3].sum(-1)
    return [
        k
        for k, (_, limit) in enumerate(bench.limits)
        if limit.maximum is not None and answered[k] and fails[k] < MIN_FAILED_VARIANTS_PER_LIMIT
    ]


def _rows_in_memory(
    bench: VariantEvaluator, found: Mapping[ShardNode, ShardResult], spans: list[tuple[int, int]]
) -> EvaluatedVariants | None:
    """Return each variant, where they were kept in memory."""
    kept = {k: found[0, k].rows for _, k in sorted(found) if (0, k) in found}
    parts = [(spans[k], rows) for k, rows in kept.items() if rows is not None]
    if not parts:
        return None
    return bench.collect(
        np.concatenate([inputs for _, (inputs, _) in parts]),
        LimitResults.concatenate([answers for _, (_, answers) in parts]),
        np.concatenate([bench.sampling_plan.unit_points(*span) for span, _ in parts]),
        np.concatenate([bench.sampling_plan.independent(*span) for span, _ in parts]),
    )

"""A stretch of variants, computed anywhere with the same result to the last bit.

A job travels to the worker that computes a shard; fingerprints of what it reads distinguish it from
another.
"""

import json
import pickle
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache, lru_cache
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from threading import Event
from time import perf_counter
from typing import Any

import numpy as np

from cardan.application.variant_sampling import SamplingMethod
from cardan.core.arrays import FloatArray, retain_freed_memory, single_threaded_blas
from cardan.core.errors import DesignError
from cardan.core.version import __version__
from cardan.model.application import Application
from cardan.model.variants import VariantStudy
from cardan.topics.variants.evaluation import (
    LimitResults,
    VariantEvaluator,
)
from cardan.topics.variants.shard_tree import merged_statistics
from cardan.topics.variants.statistics import (
    StatisticState,
    requested_statistics,
)

# --------------------------------------------------------------------------- running


@dataclass(frozen=True, kw_only=True)
class ShardJob:
    """What a worker needs for any shard; `fingerprints` distinguish it from another."""

    application: Application
    variants: VariantStudy
    seed: int
    points: SamplingMethod | None
    fingerprints: Mapping[str, str]

    @classmethod
    def from_study(
        cls, application: Application, variants: VariantStudy, *, seed: int = 0,
        points: SamplingMethod | None = None,
    ) -> "ShardJob":  # fmt: skip
        """Return the job of a study; the files that the application names by their whole paths.

        Raises
        ------
        DesignError
            If the application was not read from a file.
        """
        written = application.written
        if written is None:
            msg = f"application {application.title} was not read from a file: it has no variants"
            raise DesignError(msg)
        written = replace(
            written,
            folder=written.folder and written.folder.absolute(),
            referenced_files=tuple(p.absolute() for p in written.referenced_files),
        )
        return cls(
            application=replace(application, written=written), variants=variants, seed=seed,
            points=points, fingerprints=fingerprints(application, variants),
        )  # fmt: skip

    @property
    def evaluator(self) -> VariantEvaluator:
        """The bench; a worker makes it once."""
        return _evaluator_of(_CachedJob(self))

    @property
    def row_precision(self) -> str | None:
        """In which precision variants are kept, if at all."""
        return self.variants.ask.rows

    @property
    def changed_inputs(self) -> str:
        """What is not here, or not now, as it was where the study began."""
        return differing_inputs(self.fingerprints, fingerprints(self.application, self.variants))

    def run_shard(self, start: int, stop: int, stopped: Event | None = None) -> "ShardResult":
        """Return the statistics of a stretch of variants, and the rows where they are kept."""
        go_on = (lambda: not stopped.is_set()) if stopped else (lambda: True)
        rows = self.evaluator.evaluate_range(start, stop, go_on=go_on)
        found = requested_statistics(self.evaluator, self.variants.ask)
        return ShardResult(
            statistics={name: r.shard_state(rows, start) for name, r in found.items()},
            rows=(rows.inputs, rows.results) if self.row_precision else None,
        )


@dataclass(frozen=True, kw_only=True)
class ShardResult:
    """Statistics of a stretch of variants; their inputs and answers where they are kept."""

    statistics: Mapping[str, StatisticState]
    rows: tuple[FloatArray, LimitResults] | None = None


class _CachedJob:
    """A job by its identity: two jobs with one text are distinct, one is the same for ever."""

    def __init__(self, job: ShardJob) -> None:
        self.job = job
        written = job.application.written
        # Files next to it are read again with each change: the same text elsewhere is another job.
        self.known = (
            tuple(job.fingerprints.items()), job.seed, job.points, written and written.folder,
        )  # fmt: skip

    def __hash__(self) -> int:
        return hash(self.known)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _CachedJob) and self.known == other.known


@cache
def _evaluator_of(of: _CachedJob) -> VariantEvaluator:
    job = of.job
    if other := job.changed_inputs:
        msg = f"a worker has other {other} than where the study began"
        raise DesignError(msg)
    return VariantEvaluator.from_application(
        job.application, job.variants, seed=job.seed, points=job.points
    )


def serialise_shard_job(job: ShardJob) -> bytes:
    """Return a job as it is handed out with each shard: written once, and read once by a worker."""
    return pickle.dumps(job, protocol=pickle.HIGHEST_PROTOCOL)


@lru_cache(4)
def deserialise_shard_job(job: bytes) -> ShardJob:
    """Return the job that was handed out."""
    return pickle.loads(job)


_HELD_JOBS: dict[str, bytes] = {}
"""Jobs that a worker was sent once, by their names."""


def hold_shard_job(name: str, job: bytes) -> None:
    """Keep a job in this process, so that shards come with its name alone."""
    _HELD_JOBS[name] = job


def forget_shard_job(name: str) -> None:
    """Keep it no longer."""
    _HELD_JOBS.pop(name, None)


@dataclass(frozen=True, kw_only=True)
class ComputedShards:
    """Shards one after the other, each or merged, and the seconds they took."""

    results: tuple[ShardResult, ...]
    seconds: float


def compute_shards(
    job: bytes | str, spans: Sequence[tuple[int, int]], *, merged: bool = False
) -> ComputedShards:
    """Return the shards of a node, wherever this is called: each, or `merged` to one.

    `job` is what `serialise_shard_job` returned, or the name of one that is held here.
    """
    # Before it is looked for: another thread would load it meanwhile.
    import_module("scipy.linalg")
    begun = perf_counter()
    with single_threaded_blas(), retain_freed_memory():
        known = deserialise_shard_job(_HELD_JOBS[job] if isinstance(job, str) else job)
        found = tuple(known.run_shard(*span) for span in spans)
    if merged and len(found) > 1:
        every = requested_statistics(known.evaluator, known.variants.ask)
        told = merged_statistics(every, {(0, k): r.statistics for k, r in enumerate(found)})
        found = (ShardResult(statistics=told),)
    return ComputedShards(results=found, seconds=perf_counter() - begun)


def fingerprints(application: Application, variants: VariantStudy) -> dict[str, str]:
    """Return what distinguishes a study from another: the same prints, the same answers."""
    written = application.written
    assert written is not None  # as `ShardJob` has checked
    changes = {at: np.asarray(to).tolist() for at, to in written.changes.items()}
    # A set has another order in another process.
    limits = json.dumps([asdict(limit) for limit in application.limits], default=sorted)
    said = {
        "application": repr((written.text, changes)), "limits": limits, "study": repr(variants),
        "files": repr([sha256(_contents(p)).hexdigest() for p in written.referenced_files]),
    }  # fmt: skip
    prints = {name: sha256(text.encode()).hexdigest() for name, text in said.items()}
    return {"cardan": __version__, "numpy": np.__version__, **prints}


def _contents(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        msg = f"{path}, which the application names, cannot be read where the study is computed: "
        raise DesignError(msg + (error.strerror or "lost")) from None


def file_stamps(job: ShardJob) -> list[tuple[int, int] | None]:
    """Return when each file next to it was written, and its size; None of a lost one."""
    written = job.application.written
    paths = written.referenced_files if written else ()
    found = (p.stat() if p.exists() else None for p in paths)
    return [s and (s.st_mtime_ns, s.st_size) for s in found]


STUDY_FINGERPRINT_PART_LABELS = {
    "cardan": "version of cardan", "numpy": "version of NumPy", "application": "application",
    "files": "files that it names", "limits": "limits", "study": "vary, tolerances or ask",
}  # fmt: skip
"""What a print is of."""


def differing_inputs(was: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    """Return the names of what differs, with commas between; "" if nothing does."""
    differing = (name for name in now if was.get(name) != now[name])
    return ", ".join(STUDY_FINGERPRINT_PART_LABELS.get(name, name) for name in differing)

"""A study of many variants, shard by shard: in threads, processes or on a cluster.

A shard is a stretch of variants. Whoever asks it draws the same, and what is told of it is
joined in the order of the shards, so the answer is the same to the last bit however it was
computed: at once, by many, or in pieces after the computer went down.
"""

import json
import pickle
import zlib
from collections.abc import Callable, Generator, Mapping
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
    wait,
)
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, replace
from functools import cache, lru_cache
from hashlib import sha256
from importlib import import_module
from io import BytesIO
from os import cpu_count
from pathlib import Path
from threading import Event, local
from time import perf_counter
from types import TracebackType
from typing import Any, TypeAlias, cast
from zipfile import BadZipFile

import numpy as np

from cardan import __version__
from cardan.base.arrays import FloatArray, memory_kept, single_threaded
from cardan.base.errors import DesignError, NotInstalled
from cardan.base.verdict import VERDICTS, Limit, Verdict
from cardan.border import writer
from cardan.model.application import Application
from cardan.model.variants import Variants
from cardan.quantity.quantities import QUANTITIES
from cardan.study.approval import Approval
from cardan.study.breed import bred
from cardan.study.draw import Drawing, Points
from cardan.study.foretell import Foretold, foretold
from cardan.study.rare import Rare, rare
from cardan.study.reduce import (
    Map,
    Reduction,
    State,
    clopper_pearson,
    joined,
    reductions,
    wilson,
)
from cardan.study.sweep import Answers, Bench, Sweep, named

SHARD = 512
"""Variants of a shard, about: whole grids, or groups of pairs."""

HARDLY = 20
"""Variants: of a limit that fewer fail the share is known badly."""

WAIT = 10.0
"""Seconds without a shard after which it is asked whether a cluster has workers at all."""

AHEAD = 3
"""Shards handed out for each worker: what waits costs memory."""

MANIFEST = "manifest.json"

Heard: TypeAlias = Callable[["Progress"], None]
"""Takes how far a study has come."""


@dataclass(frozen=True, kw_only=True)
class Progress:
    """How far a study has come: variants done before this run and in all, and how many to do.

    With all of them done, how many limits have been asked how often they fail, and of how many.
    `idle` where nobody is there to ask any: a cluster without workers waits for some.
    """

    before: int
    done: int
    count: int
    seconds: float
    rare: tuple[int, int] | None = None
    idle: bool = False

    @property
    def rate(self) -> float:
        """Variants a second in this run."""
        return (self.done - self.before) / self.seconds if self.seconds > 0 else 0.0

    @property
    def left(self) -> float:
        """Seconds left; nan where nobody knows."""
        return (self.count - self.done) / self.rate if self.rate > 0 else float("nan")


def silent(progress: Progress) -> None:
    """Tell nobody."""


@dataclass(frozen=True, kw_only=True)
class Studied:
    """What a study of variants came to.

    Attributes
    ----------
    bench
        The application, and where its variants lie.
    variants
        What was asked.
    asked
        How many variants were to be asked; fewer are told of where the run was stopped.
    states
        What is told of them, by name (`cardan.study.reduce`); `pareto` of those bred besides.
    rows
        Each variant, where they were kept.
    rare
        How often limits fail that variants hardly ever did, where that was asked.
    beyond
        Those of them of which no failure was found that is near enough to count.
    foretold
        The yield of many more, foretold from those asked, where that was asked.
    seconds
        How long this run took.
    """

    bench: Bench
    variants: Variants
    asked: int
    states: Mapping[str, State]
    rows: Sweep | None = None
    rare: tuple[Rare, ...] = ()
    beyond: tuple[Rare, ...] = ()
    foretold: Foretold | None = None
    seconds: float = 0.0

    @property
    def installed(self) -> Approval:
        """The approval of the application as it stands."""
        return self.bench.installed

    @property
    def drawing(self) -> Drawing:
        """Where the variants lie."""
        return self.bench.drawing

    @property
    def limits(self) -> tuple[tuple[str, Limit], ...]:
        """Each limit with the line that it asks about."""
        return self.bench.limits

    @property
    def called(self) -> tuple[str, ...]:
        """A name for each limit."""
        return named(self.limits)

    @property
    def count(self) -> int:
        """How many variants were asked."""
        return int(self.states["counts"]["asked"])

    @property
    def own(self) -> int:
        """How many of them are drawn by themselves: shares are of those."""
        return int(self.states["counts"]["count"])

    @property
    def shares(self) -> dict[Verdict, float]:
        """The share of variants that comes to each verdict."""
        counts = self.states["counts"]["verdicts"] / self.own
        return dict(zip(VERDICTS, counts.tolist(), strict=True))

    @property
    def fit(self) -> int:
        """How many may be built: they pass or only warn."""
        return _fit(self.states["counts"])[0]

    @property
    def yield_(self) -> float:
        """The share of variants that may be built."""
        return self.fit / self.own

    def interval(self, *, exact: bool = True) -> tuple[float, float]:
        """Return the interval of the yield: Clopper and Pearson's, or Wilson's."""
        of = clopper_pearson if exact else wilson
        return of(self.fit, self.own, confidence=self.variants.ask.confidence)

    @property
    def maps(self) -> tuple[tuple[Map, State], ...]:
        """The maps that were asked for, with their cells."""
        found = reductions(self.bench, self.variants.ask)
        return tuple((m, self.states[n]) for n, m in found.items() if isinstance(m, Map))


# --------------------------------------------------------------------------- running


@dataclass(frozen=True, kw_only=True)
class Job:
    """What a worker has to know to ask any shard; `prints` tell it from another."""

    application: Application
    variants: Variants
    seed: int
    points: Points | None
    prints: Mapping[str, str]

    @classmethod
    def of(
        cls, application: Application, variants: Variants, *, seed: int = 0,
        points: Points | None = None,
    ) -> "Job":  # fmt: skip
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
            beside=tuple(p.absolute() for p in written.beside),
        )
        return cls(
            application=replace(application, written=written), variants=variants, seed=seed,
            points=points, prints=_prints(application, variants),
        )  # fmt: skip

    @property
    def bench(self) -> Bench:
        """The bench; a worker makes it once."""
        return _bench(_Once(self))

    @property
    def rows(self) -> str | None:
        """In which precision variants are kept, if at all."""
        return self.variants.ask.rows

    @property
    def changed(self) -> list[str]:
        """What is not here, or not now, as it was where the study began."""
        return _other(self.prints, _prints(self.application, self.variants))

    def shard(self, start: int, stop: int, stopped: Event | None = None) -> "Shard":
        """Return what is told of a stretch of variants, and the rows where they are kept."""
        go_on = (lambda: not stopped.is_set()) if stopped else (lambda: True)
        rows = self.bench.rows(start, stop, go_on=go_on)
        found = reductions(self.bench, self.variants.ask)
        return Shard(
            states={name: r.of(rows, start) for name, r in found.items()},
            rows=(rows.inputs, rows.answers) if self.rows else None,
        )


@dataclass(frozen=True, kw_only=True)
class Shard:
    """What is told of a stretch of variants; their inputs and answers where they are kept."""

    states: Mapping[str, State]
    rows: tuple[FloatArray, Answers] | None = None


class _Once:
    """A job by its identity: two jobs with one text are told apart, one is the same for ever."""

    def __init__(self, job: Job) -> None:
        self.job = job
        written = job.application.written
        # Files beside it are read again with each change: the same text elsewhere is another job.
        self.known = (
            tuple(job.prints.items()), job.seed, job.points, written and written.folder,
        )  # fmt: skip

    def __hash__(self) -> int:
        return hash(self.known)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Once) and self.known == other.known


@cache
def _bench(of: _Once) -> Bench:
    job = of.job
    if other := job.changed:
        msg = f"a worker has other {_listed(other)} than where the study began"
        raise DesignError(msg)
    return Bench.of(job.application, job.variants, seed=job.seed, points=job.points)


def packed(job: Job) -> bytes:
    """Return a job as it is handed out with each shard: written once, and read once by a worker."""
    return pickle.dumps(job, protocol=pickle.HIGHEST_PROTOCOL)


@lru_cache(4)
def unpacked(job: bytes) -> Job:
    """Return the job that was handed out."""
    return pickle.loads(job)


def _asked(job: bytes, start: int, stop: int) -> Shard:
    """Return a shard, wherever this is called."""
    import_module(
        "scipy.linalg"
    )  # before it is looked for: a thread beside would load it meanwhile
    with single_threaded(), memory_kept():
        return unpacked(job).shard(start, stop)


def study(
    application: Application,
    variants: Variants,
    *,
    count: int = 10_000,
    seed: int = 0,
    points: Points | None = None,
    folder: Path | None = None,
    resume: bool = False,
    executor: Executor | None = None,
    workers: int | None = 1,
    shard: int = SHARD,
    hear: Heard = silent,
) -> Studied:
    """Ask the driveline of many variants, and tell what they come to.

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
        Who asks shards, `workers` at a time: any of `concurrent.futures`, or a cluster's. By
        default threads of this process; None as many as this machine, or a cluster, has.
    shard
        How many variants are asked at a time, about.
    hear
        Told how far it has come.

    Raises
    ------
    ValueError
        If nothing goes by a name, or does not vary as is asked.
    BadFile
        If the folder holds another study, or one already.
    Stopped
        If it was stopped from the keyboard; it holds what is told of the shards done.
    """
    job, asked = Job.of(application, variants, seed=seed, points=points), variants.ask
    bench, stamps = job.bench, _stamps(job)
    count, size = bench.whole(count), -(-shard // bench.drawing.period) * bench.drawing.period
    spans = [(k, min(k + size, count)) for k in range(0, count, size)]
    store = Store.of(folder, job, size, count=count, resume=resume) if folder else None
    found: dict[int, Shard] = {}
    done = {k for k, span in enumerate(spans) if store and store.has(k, span)}
    before, begun = sum(spans[k][1] - spans[k][0] for k in done), perf_counter()
    finished = before

    def now(done: int, rare: tuple[int, int] | None = None, *, idle: bool = False) -> None:
        seconds, total = perf_counter() - begun, count + asked.search
        hear(Progress(
            before=before, done=done, count=total, seconds=seconds, rare=rare, idle=idle,
        ))  # fmt: skip

    def keep(k: int, got: Shard) -> None:
        nonlocal finished, stamps
        if stamps != (stamps := _stamps(job)) and (other := job.changed):
            msg = f"{_listed(other)} changed while the study ran: begin it anew"
            raise DesignError(msg)
        if store:
            store.keep(k, spans[k], got, job)
        else:
            found[k] = got
        done.add(k)
        finished += spans[k][1] - spans[k][0]
        now(finished)

    now(before)
    todo = [k for k in range(len(spans)) if k not in done]
    stopped = False
    try:
        _run(
            job, {k: spans[k] for k in todo}, keep, executor=executor, workers=workers,
            idle=lambda: now(finished, idle=True),
        )  # fmt: skip
    except KeyboardInterrupt:
        stopped = True
        if not done:
            raise
    told = _told(bench, variants, store, found, sorted(done))
    if asked.search and not stopped:
        try:
            told["pareto"] = bred(
                bench, asked.pareto, told["pareto"], count=asked.search, start=count, seed=seed,
                hear=lambda more: now(count + min(more, asked.search)),
            )  # fmt: skip
        except KeyboardInterrupt:
            stopped = True
    hardly: list[Rare] = []
    if asked.rare and not stopped:
        few = _hardly(bench, told["counts"])
        try:
            for at, k in enumerate(few):
                now(count + asked.search, (at, len(few)))
                hardly.append(rare(bench, k))
        except KeyboardInterrupt:
            stopped = True
    result = Studied(
        bench=bench, variants=variants, asked=count, states=told,
        rows=_kept(bench, found, dict(enumerate(spans))),
        rare=tuple(r for r in hardly if not r.far), beyond=tuple(r for r in hardly if r.far),
        foretold=None if stopped or not asked.foretold else foretold(
            bench.drawing, told["taught"], count=asked.foretold, start=count,
            confidence=asked.confidence, asked=_fit(told["counts"]),
            workers=workers or cpu_count() or 1,
        ),
        seconds=perf_counter() - begun,
    )  # fmt: skip
    if stopped:
        raise Stopped(result)
    return result


class Stopped(KeyboardInterrupt):
    """A study was stopped from the keyboard; `studied` is what is told of what was done."""

    def __init__(self, studied: Studied) -> None:
        super().__init__()
        self.studied = studied


def _run(
    job: Job,
    spans: Mapping[int, tuple[int, int]],
    keep: Callable[[int, Shard], None],
    *,
    executor: Executor | None,
    workers: int | None,
    idle: Callable[[], None],
) -> None:
    """Have shards asked, and keep each as it comes; say so while nobody is there to ask."""
    stop = Event()

    def there() -> int:
        return executor.there if isinstance(executor, Cluster) else cpu_count() or 1

    with _workers(executor, workers or there()) as (of, own):
        parcel = b"" if own else packed(job)
        pending: dict[Future[Shard], int] = {}
        waiting = iter(spans.items())
        try:
            while True:
                most = max(there() if workers is None else workers, 1) * AHEAD
                while len(pending) < most and (one := next(waiting, None)):
                    k, span = one
                    pending[
                        of.submit(job.shard, *span, stop)
                        if own
                        else of.submit(_asked, parcel, *span)
                    ] = k
                if not pending:
                    return
                done = wait(pending, timeout=WAIT, return_when=FIRST_COMPLETED).done
                if not done and not there():
                    idle()
                for future in done:
                    keep(pending.pop(future), future.result())
        finally:
            stop.set()
            if not (isinstance(executor, Cluster) and executor.gone):
                for future in pending:
                    future.cancel()


@contextmanager
def _workers(
    executor: Executor | None, workers: int
) -> Generator[tuple[Executor, bool], None, None]:
    """Give who asks shards, and whether it shares this process's memory."""
    if executor is not None:
        yield executor, False
        return
    import_module("scipy.linalg")
    with (
        single_threaded(),
        ThreadPoolExecutor(max(workers, 1), thread_name_prefix="study") as own,
    ):
        yield own, True


def _told(
    bench: Bench,
    variants: Variants,
    store: "Store | None",
    found: Mapping[int, Shard],
    done: list[int],
) -> dict[str, State]:
    """Return what shards come to together, in their order."""
    every: dict[str, Reduction] = reductions(bench, variants.ask)
    total: dict[str, State] = {}
    for k in done:
        states = store.states(k) if store else found[k].states
        total = {
            n: joined(r, [total[n], states[n]]) if total else states[n] for n, r in every.items()
        }
    return total


def _fit(counts: State) -> tuple[int, int]:
    """Return how many variants may be built, and of how many drawn by themselves."""
    found = dict(zip(VERDICTS, counts["verdicts"].tolist(), strict=True))
    return found["pass"] + found["warn"], int(counts["count"])


def _hardly(bench: Bench, counts: State) -> list[int]:
    """Return the places of the limits that hardly ever failed."""
    fails, answered = counts["grades"][:, 2], counts["grades"][:, :3].sum(-1)
    return [
        k
        for k, (_, limit) in enumerate(bench.limits)
        if limit.maximum is not None and answered[k] and fails[k] < HARDLY
    ]


# --------------------------------------------------------------------------- rows


def _columns(rows: Sweep, precision: str) -> dict[str, Any]:
    """Return variants as columns of a table: inputs as they are, what limits come to in units."""
    a = rows.answers
    found: dict[str, Any] = {
        n: v.astype(precision) for n, v in zip(rows.names, rows.inputs.T, strict=True)
    }
    found["verdict"] = rows.grades.astype(np.int8)
    found["margin"] = rows.margins.astype(precision)
    found["mass_kg"] = a.mass.astype(precision)
    for k, (name, (_, limit)) in enumerate(zip(named(rows.limits), rows.limits, strict=True)):
        factor = QUANTITIES[limit.quantity].factor
        found[name] = (a.values[k] / factor).astype(precision)
        found[f"{name} margin"] = a.margins[k].astype(precision)
        found[f"{name} grade"] = a.grades[k].astype(np.int8)
        if limit.required:
            found[f"{name} missed"] = a.missed[k]
    found["refused"] = a.refused
    return found


def _kept(
    bench: Bench, found: Mapping[int, Shard], spans: Mapping[int, tuple[int, int]]
) -> Sweep | None:
    """Return each variant, where they were kept in memory."""
    kept = {k: found[k].rows for k in sorted(found)}
    parts = [(spans[k], rows) for k, rows in kept.items() if rows is not None]
    if not parts:
        return None
    return bench.sweep(
        np.concatenate([inputs for _, (inputs, _) in parts]),
        Answers.together([answers for _, (_, answers) in parts]),
        np.concatenate([bench.drawing.unit(*span) for span, _ in parts]),
        np.concatenate([bench.drawing.own(*span) for span, _ in parts]),
    )


# --------------------------------------------------------------------------- keeping


@cache
def _tables() -> Any:
    """Return what writes tables, PyArrow; None where it is not installed."""
    try:
        import pyarrow as pa  # pyright: ignore[reportMissingTypeStubs]
        import pyarrow.parquet as pq  # pyright: ignore[reportMissingTypeStubs]
    except ModuleNotFoundError:
        return None
    return pa, pq


def _prints(application: Application, variants: Variants) -> dict[str, str]:
    """Return what tells a study from another: the same prints, the same answers."""
    written = application.written
    assert written is not None  # `Job.of` has looked
    changes = {at: np.asarray(to).tolist() for at, to in written.changes.items()}
    # A set has another order in another process.
    limits = json.dumps([asdict(limit) for limit in application.limits], default=sorted)
    said = {
        "application": repr((written.text, changes)), "limits": limits, "study": repr(variants),
        "files": repr([sha256(_contents(p)).hexdigest() for p in written.beside]),
    }  # fmt: skip
    prints = {name: sha256(text.encode()).hexdigest() for name, text in said.items()}
    return {"cardan": __version__, "numpy": np.__version__, **prints}


def _contents(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        msg = f"{path}, which the application names, cannot be read where the study is asked: "
        raise DesignError(msg + (error.strerror or "lost")) from None


def _stamps(job: Job) -> list[tuple[int, int] | None]:
    """Return when each file beside it was written, and its size; None of a lost one."""
    written = job.application.written
    paths = written.beside if written else ()
    found = (p.stat() if p.exists() else None for p in paths)
    return [s and (s.st_mtime_ns, s.st_size) for s in found]


TOLD = {
    "cardan": "version of cardan", "numpy": "version of NumPy", "application": "application",
    "files": "files that it names", "limits": "limits", "study": "vary, tolerances or ask",
}  # fmt: skip
"""What a print is of."""


def _manifest(path: Path) -> dict[str, Any]:
    """Return what a folder says that it holds."""
    with suppress(ValueError, OSError):
        found = json.loads(path.read_text(encoding="utf-8"))
        if isinstance(found, dict) and TOLD.keys() <= found.keys():
            return cast("dict[str, Any]", found)
    msg = f"{path} is none of this version's: name another folder"
    raise DesignError(msg)


def _other(was: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Return what differs, by its name."""
    return [TOLD.get(name, name) for name in now if was.get(name) != now[name]]


def _listed(names: list[str]) -> str:
    return ", ".join(names)


@dataclass(frozen=True, kw_only=True)
class Store:
    """A folder with a study's shards: each there whole, or not at all; its `rows` before it."""

    folder: Path
    size: int
    rows: bool

    @classmethod
    def of(cls, folder: Path, job: Job, size: int, *, count: int, resume: bool) -> "Store":
        """Return the store of a study; begin one, or go on with what is there.

        Raises
        ------
        DesignError
            If the folder holds another study, more than `count` variants of this one, or one
            without `resume`.
        """
        folder.mkdir(parents=True, exist_ok=True)
        manifest, found = folder / MANIFEST, cls(folder=folder, size=size, rows=bool(job.rows))
        now = {
            **job.prints, "title": job.application.title, "seed": job.seed, "shard": size,
            "inputs": list(job.bench.drawing.names), "points": job.bench.drawing.points,
        }  # fmt: skip
        if not manifest.exists():
            if any(folder.glob("shard-*.npz")):
                msg = (
                    f"{folder} holds shards, but no {MANIFEST} says of which study: name another "
                    "folder"
                )
                raise DesignError(msg)
            writer.write(manifest, json.dumps(now, indent=1, ensure_ascii=False) + "\n")
            return found
        if not resume:
            msg = (
                f"{folder} holds a study already: go on with it (--resume), or name another folder"
            )
            raise DesignError(msg)
        if other := _other(_manifest(manifest), now):
            msg = f"{folder} holds another study, with other {_listed(other)}: name another folder"
            raise DesignError(msg)
        if (reach := found.reach) > count:
            msg = (
                f"{folder} holds {reach} variants, more than {count}: ask for as many (--n "
                f"{reach}) or more, or name another folder"
            )
            raise DesignError(msg)
        return found

    @property
    def reach(self) -> int:
        """Behind which place no variant is there."""
        spans = (self._span(path) for path in self.folder.glob("shard-*.npz"))
        return max((stop for _, stop in filter(None, spans)), default=0)

    def has(self, k: int, span: tuple[int, int]) -> bool:
        """Return whether a shard of this stretch is there, with its rows; no shorter one."""
        rows = not self.rows or any(
            _length(self.folder / f"rows-{k:06d}{kind}") == span[1] - span[0]
            for kind in (".parquet", ".npz")
        )
        return rows and self._span(self._path(k)) == span

    @staticmethod
    def _span(path: Path) -> tuple[int, int] | None:
        """Return the stretch of a shard; None where it cannot be read whole, as of half a file."""
        try:
            with path.open("rb") as whole, np.load(whole) as file:
                if file.zip.testzip():
                    return None
                start, stop = file["span"].tolist()
                return start, stop
        except _UNREAD:
            return None

    def keep(self, k: int, span: tuple[int, int], shard: Shard, job: Job) -> None:
        """Keep a shard: its rows first, so that where the rest is they are too."""
        if shard.rows and job.rows:
            inputs, answers = shard.rows
            rows = job.bench.sweep(
                inputs, answers, job.bench.drawing.unit(*span), job.bench.drawing.own(*span)
            )
            self._write_rows(k, _columns(rows, job.rows))
        arrays = {f"{n}/{a}": v for n, state in shard.states.items() for a, v in state.items()}
        writer.write(self._path(k), _packed({"span": np.array(span), **arrays}), replace=True)

    def states(self, k: int) -> dict[str, State]:
        """Return what is told of a shard."""
        found: dict[str, dict[str, Any]] = {}
        with np.load(self._path(k)) as file:
            for name in file.files:
                of, slash, array = name.partition("/")
                if slash:
                    found.setdefault(of, {})[array] = file[name]
        return dict(found)

    def _write_rows(self, k: int, rows: Mapping[str, Any]) -> None:
        tables = _tables()
        if tables is None:
            writer.write(self.folder / f"rows-{k:06d}.npz", _packed(rows), replace=True)
            return
        out = BytesIO()
        arrow, parquet = tables
        parquet.write_table(arrow.table(dict(rows)), out, compression="zstd")
        writer.write(self.folder / f"rows-{k:06d}.parquet", out.getvalue(), replace=True)

    def _path(self, k: int) -> Path:
        return self.folder / f"shard-{k:06d}.npz"


_UNREAD = (OSError, ValueError, EOFError, KeyError, BadZipFile, zlib.error)
"""What reading a file comes to that is damaged, or not there."""


def _length(path: Path) -> int | None:
    """Return how many variants a file of rows holds; None where it is not there, or cut off."""
    tables = _tables()
    try:
        if path.suffix == ".parquet":
            return tables[1].read_metadata(path).num_rows if tables else None
        with path.open("rb") as whole, np.load(whole) as file:
            return len(file["verdict"])
    except _UNREAD:
        return None


def _packed(arrays: Mapping[str, Any]) -> bytes:
    out = BytesIO()
    np.savez_compressed(out, **arrays)
    return out.getvalue()


# --------------------------------------------------------------------------- who asks


@contextmanager
def workers_of(kind: str, count: int) -> Generator[Executor | None, None, None]:
    """Give who asks shards: `threads`, `processes`, or a Dask cluster by its address.

    Raises
    ------
    NotInstalled
        If a cluster is named and Dask is not there.
    DesignError
        If who asks them is gone for good.
    """
    gone = "; what was done is kept where --out names a folder: --resume goes on"
    if kind == "threads":
        yield None
    elif kind == "processes":
        with Processes(count) as pool:
            try:
                yield pool
            except BrokenExecutor as error:
                msg = f"a process that asked a shard was killed{gone}"
                raise DesignError(msg) from error
    else:
        try:
            dask: Any = import_module("distributed")
        except ModuleNotFoundError as error:
            msg = "a Dask cluster needs its package: pip install 'cardan[cluster]'"
            raise NotInstalled(msg) from error
        with dask.Client(kind) as client:
            try:
                yield Cluster(client)
            except (CancelledError, dask.KilledWorker) as error:
                msg = f"the cluster at {kind} is gone, or loses every worker{gone}"
                raise DesignError(msg) from error


class Cluster(Executor):
    """A Dask cluster by its client: an executor that knows how many there are to work."""

    def __init__(self, client: Any) -> None:
        self._client, self._executor = client, client.get_executor()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Hand a call to whoever is free."""
        try:
            return self._executor.submit(fn, *args, **kwargs)
        except Exception as error:
            if self.gone:
                raise CancelledError from error
            raise

    @property
    def gone(self) -> bool:
        """Whether its client gave the scheduler up."""
        return self._client.status in ("closing", "closed")

    @property
    def there(self) -> int:
        """How many threads of workers there are now; 1 where the scheduler does not answer."""
        try:
            return sum(self._client.ncores().values())
        except (OSError, TimeoutError, RuntimeError, AttributeError):
            return 1  # its client is closed, or closing: the shards it loses tell that


class Processes(ThreadPoolExecutor):
    """Processes that work, each at the end of a pipe of its own, which a thread here listens to.

    Those of `concurrent.futures` answer through one pipe for all: where one is killed half-way
    through what it says, whoever listens waits for the rest for ever.
    """

    def __init__(self, count: int) -> None:
        super().__init__(count)
        self._own = local()
        self._begun: list[tuple[Any, Any]] = []

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Hand a call to whichever process is free."""
        return super().submit(self._have, fn, args, kwargs)

    def _have(self, *call: Any) -> Any:
        pipe = self._pipe()
        try:
            pipe.send(call)
            done, found = pipe.recv()
        except (EOFError, OSError) as error:
            raise BrokenExecutor from error
        if done:
            return found
        raise found

    def _pipe(self) -> Any:
        """Return the pipe to this thread's process; begin it at its first call."""
        if not hasattr(self._own, "pipe"):
            from multiprocessing import get_context

            context = get_context("spawn")  # a fork of a process with threads may never wake
            self._own.pipe, its = context.Pipe()
            process = context.Process(target=_serve, args=(its,), daemon=True)
            process.start()
            its.close()  # so that its end is the end of the pipe
            self._begun.append((process, self._own.pipe))
        return self._own.pipe

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exc_tb: TracebackType | None,
    ) -> None:
        """End the processes, when they have done what they were handed."""
        super().__exit__(exc_type, exc_val, exc_tb)
        for process, pipe in self._begun:
            pipe.close()
            process.join()


def _serve(pipe: Any) -> None:
    """Do what comes through a pipe, until whoever hands it out is gone."""
    import signal
    from traceback import format_exc

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the keyboard is the other's
    with suppress(EOFError, OSError):
        while True:
            fn, args, kwargs = pipe.recv()
            try:
                pipe.send((True, fn(*args, **kwargs)))
            except Exception as error:  # noqa: BLE001  whoever handed it out is told
                error.add_note(format_exc())  # which a pipe leaves behind
                pipe.send((False, error))

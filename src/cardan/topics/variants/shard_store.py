"""A folder that keeps the shards of a study, so that it can be resumed."""

import errno
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import cache
from hashlib import file_digest, sha256
from io import BytesIO
from pathlib import Path
from time import perf_counter
from typing import Any, BinaryIO, cast

import numpy as np

from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.errors import DesignError
from cardan.schema import atomic_write as writer
from cardan.topics.variants.evaluation import (
    EvaluatedVariants,
    limit_names,
)
from cardan.topics.variants.shard_job import (
    STUDY_FINGERPRINT_PART_LABELS,
    ShardJob,
    ShardResult,
    differing_inputs,
)
from cardan.topics.variants.shard_log import (
    LogEntry,
    arrays_of_record,
    log_entries,
    log_record,
    record_of,
)
from cardan.topics.variants.statistics import (
    StatisticState,
)

MANIFEST_FILE_NAME, SHARD_LOG_FILE_NAME = "manifest.json", "shards.log"

SYNC_INTERVAL_S = 1.0
"""s: shards of the last second may be lost by a power cut, and are then computed again."""


# --------------------------------------------------------------------------- rows


def _row_columns(rows: EvaluatedVariants, precision: str) -> dict[str, Any]:
    """Return variants as columns of a table: inputs as they are, what limits come to in units."""
    a = rows.results
    found: dict[str, Any] = {
        n: v.astype(precision) for n, v in zip(rows.names, rows.inputs.T, strict=True)
    }
    found["verdict"] = rows.grades.astype(np.int8)
    found["margin"] = rows.margins.astype(precision)
    found["mass_kg"] = a.mass.astype(precision)
    for k, (name, (_, limit)) in enumerate(zip(limit_names(rows.limits), rows.limits, strict=True)):
        factor = QUANTITIES[limit.quantity].si_factor
        found[name] = (a.values[k] / factor).astype(precision)
        found[f"{name} margin"] = a.margins[k].astype(precision)
        found[f"{name} grade"] = a.grades[k].astype(np.int8)
        if limit.required:
            found[f"{name} missed"] = a.missed[k]
        if QUANTITIES[limit.quantity].validity_margin is not None:
            found[f"{name} lower bound"] = a.bounded[k]
    found["refused"] = a.infeasible
    return found


# --------------------------------------------------------------------------- keeping


@cache
def _arrow_modules() -> Any:
    """Return what writes tables, PyArrow; None where it is not installed."""
    try:
        import pyarrow as pa  # pyright: ignore[reportMissingTypeStubs]
        import pyarrow.parquet as pq  # pyright: ignore[reportMissingTypeStubs]
    except ModuleNotFoundError:
        return None
    return pa, pq


def _read_manifest(path: Path) -> dict[str, Any]:
    """Return what a folder says that it holds."""
    with suppress(ValueError, OSError):
        found = json.loads(path.read_text(encoding="utf-8"))
        if isinstance(found, dict) and STUDY_FINGERPRINT_PART_LABELS.keys() <= found.keys():
            return cast("dict[str, Any]", found)
    msg = f"{path} is none of this version's: name another folder"
    raise DesignError(msg)


class ShardStore:
    """A folder with a study's shards, in one file that is appended to; the `rows` of each before.

    A shard holds a digest of its statistics and of its file of rows. One that does not match is
    computed again.

    Attributes
    ----------
    damaged_records
        How many stretches of the file are no record: cut short, or changed.
    """

    def __init__(self, folder: Path, *, keeps_rows: bool) -> None:
        self.folder, self._keeps_rows = folder, keeps_rows
        self._path, self._file = folder / SHARD_LOG_FILE_NAME, None
        self._synced = perf_counter()
        every = list(log_entries(self._path))
        self.damaged_records = every.count(None)
        self._entries: dict[int, LogEntry] = {e.about["shard"]: e for e in every if e}

    @classmethod
    def open(
        cls, folder: Path, job: ShardJob, size: int, *, count: int, resume: bool
    ) -> "ShardStore":
        """Return the store of a study; begin one, or go on with what is there.

        Raises
        ------
        DesignError
            If the folder holds another study, more than `count` variants of this one, or one
            without `resume`.
        """
        folder.mkdir(parents=True, exist_ok=True)
        manifest = folder / MANIFEST_FILE_NAME
        found = cls(folder, keeps_rows=bool(job.row_precision))
        now = {
            **job.fingerprints,
            "title": job.application.title,
            "seed": job.seed,
            "shard": size,
            "inputs": list(job.evaluator.sampling_plan.names),
            "points": job.evaluator.sampling_plan.method,
        }
        if not manifest.exists():
            if (folder / SHARD_LOG_FILE_NAME).exists():
                msg = (
                    f"{folder} holds shards, but no {MANIFEST_FILE_NAME} says of which study: "
                    f"name another "
                    "folder"
                )
                raise DesignError(msg)
            writer.write_atomically(manifest, json.dumps(now, indent=1, ensure_ascii=False) + "\n")
            return found
        if not resume:
            msg = (
                f"{folder} holds a study already: go on with it (--resume), or name another folder"
            )
            raise DesignError(msg)
        if other := differing_inputs(_read_manifest(manifest), now):
            msg = f"{folder} holds another study, with other {other}: name another folder"
            raise DesignError(msg)
        if (reach := found.stored_count) > count:
            msg = (
                f"{folder} holds {reach} variants, more than {count}: request as many (--n "
                f"{reach}) or more, or name another folder"
            )
            raise DesignError(msg)
        return found

    @property
    def stored_count(self) -> int:
        """Behind which place no variant is there."""
        return max((e.about["span"][1] for e in self._entries.values()), default=0)

    def contains(self, k: int, span: tuple[int, int]) -> bool:
        """Return whether a shard of this stretch is there, with its rows; no shorter one."""
        entry = self._entries.get(k)
        return entry is not None and entry.about["span"] == list(span) and not self.lacks_rows(k)

    def lacks_rows(self, k: int) -> bool:
        """Return whether a shard is there whose rows are lost, or not as they were written."""
        entry = self._entries.get(k)
        if entry is None or not self._keeps_rows:
            return False
        return entry.about["rows"] not in map(_file_digest, self._rows_paths(k))

    def save(self, k: int, span: tuple[int, int], shard: ShardResult, job: ShardJob) -> None:
        """Keep a shard: its rows first, so that where the rest is they are too.

        Raises
        ------
        InvalidFileError
            If the file cannot be written.
        """
        rows_digest = ""
        if shard.rows and job.row_precision:
            inputs, answers = shard.rows
            rows = job.evaluator.collect(
                inputs,
                answers,
                job.evaluator.sampling_plan.unit_points(*span),
                job.evaluator.sampling_plan.independent(*span),
            )
            rows_digest = self._write_rows(k, _row_columns(rows, job.row_precision))
        about = {"shard": k, "span": list(span), "rows": rows_digest}
        record = log_record(
            about,
            {f"{n}/{a}": v for n, state in shard.statistics.items() for a, v in state.items()},
        )
        try:
            if self._file is None:
                self._file = self._path.open("ab", buffering=0)
            if self._file.write(record) < len(record):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            offset = self._file.tell() - len(record)
            if perf_counter() - self._synced > SYNC_INTERVAL_S:
                os.fsync(self._file.fileno())
                self._synced = perf_counter()
        except OSError as error:
            raise writer.write_error(self._path, error) from None
        self._entries[k] = LogEntry(offset=offset, length=len(record), about=about)

    def load(self, k: int) -> dict[str, StatisticState]:
        """Return the statistics of a shard."""
        found: dict[str, dict[str, Any]] = {}
        with self._path.open("rb") as file:
            for path, array in arrays_of_record(self._record(file, k)).items():
                name, _, key = path.partition("/")
                found.setdefault(name, {})[key] = array
        return dict(found)

    def close(self) -> None:
        """Let what was written survive a power cut, and end writing."""
        if self._file is not None:
            with self._file as file:
                os.fsync(file.fileno())
            self._file = None

    def put_in_order(self) -> None:
        """Write the file anew with each shard once, in their order, if it is not so already."""
        self.close()
        order = [self._entries[k] for k in sorted(self._entries)]
        ends = [0, *(e.offset + e.length for e in order)]
        if [e.offset for e in order] == ends[:-1] and ends[-1] == self._path.stat().st_size:
            return

        def records() -> Iterator[bytes]:
            with self._path.open("rb") as file:
                for k in sorted(self._entries):
                    yield self._record(file, k)

        writer.write_atomically(self._path, records(), replace=True)
        at = 0
        for k, entry in sorted(self._entries.items()):
            self._entries[k] = replace(entry, offset=at)
            at += entry.length

    def _record(self, file: BinaryIO, k: int) -> bytes:
        found = record_of(file, self._entries[k])
        if found is None:
            msg = f"{self._path} was changed by another run: end that, then go on with --resume"
            raise DesignError(msg)
        return found

    def _write_rows(self, k: int, rows: Mapping[str, Any]) -> str:
        """Write the variants of a shard in place of what stood for them; return their digest."""
        tables, (path, other) = _arrow_modules(), self._rows_paths(k)
        if tables is None:
            path, other, data = other, path, _npz_bytes(rows)
        else:
            out = BytesIO()
            arrow, parquet = tables
            parquet.write_table(arrow.table(dict(rows)), out, compression="zstd")
            data = out.getvalue()
        writer.write_atomically(path, data, replace=True)
        other.unlink(missing_ok=True)
        return sha256(data).hexdigest()

    def _rows_paths(self, k: int) -> tuple[Path, Path]:
        """Return where the variants of a shard stand, as a table or where PyArrow is missing."""
        return self.folder / f"rows-{k:06d}.parquet", self.folder / f"rows-{k:06d}.npz"


def _file_digest(path: Path) -> str | None:
    """Return the SHA-256 of a file; None where it cannot be read."""
    try:
        with path.open("rb") as file:
            return file_digest(file, "sha256").hexdigest()
    except OSError:
        return None


def _npz_bytes(arrays: Mapping[str, Any]) -> bytes:
    out = BytesIO()
    np.savez_compressed(out, **arrays)
    return out.getvalue()

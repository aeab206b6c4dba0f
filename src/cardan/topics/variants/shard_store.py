"""A folder that keeps the shards of a study, so that it can be resumed."""

import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from hashlib import file_digest, sha256
from io import BytesIO
from pathlib import Path
from typing import Any, cast

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
from cardan.topics.variants.statistics import (
    StatisticState,
)

MANIFEST_FILE_NAME = "manifest.json"


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


@dataclass(frozen=True, kw_only=True)
class ShardStore:
    """A folder with a study's shards: each there whole, or not at all; its `rows` before it.

    A shard holds a digest of its statistics and of its file of rows. One that does not match,
    or that an older version wrote without a digest, is computed again.
    """

    folder: Path
    size: int
    keeps_rows: bool

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
        manifest, found = (
            folder / MANIFEST_FILE_NAME,
            cls(folder=folder, size=size, keeps_rows=bool(job.row_precision)),
        )
        now = {
            **job.fingerprints,
            "title": job.application.title,
            "seed": job.seed,
            "shard": size,
            "inputs": list(job.evaluator.sampling_plan.names),
            "points": job.evaluator.sampling_plan.method,
        }
        if not manifest.exists():
            if any(folder.glob("shard-*.npz")):
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
        spans = (self._span(path) for path in self.folder.glob("shard-*.npz"))
        return max((stop for _, stop in filter(None, spans)), default=0)

    def contains(self, k: int, span: tuple[int, int]) -> bool:
        """Return whether a shard of this stretch is there, with its rows; no shorter one."""
        return self._stored_span(k) == span

    def is_damaged(self, k: int) -> bool:
        """Return whether a shard is there that is not as it was written, or has no digest."""
        return self._path(k).exists() and self._stored_span(k) is None

    def _stored_span(self, k: int) -> tuple[int, int] | None:
        """Return the stretch of a shard whose statistics and rows are as they were written."""
        found = _stored_arrays(self._path(k))
        if found is None:
            return None
        rows = str(found["rows"])
        if self.keeps_rows and rows not in map(_file_digest, self._rows_paths(k)):
            return None
        start, stop = found["span"].tolist()
        return start, stop

    @staticmethod
    def _span(path: Path) -> tuple[int, int] | None:
        """Return the stretch that a shard names, in whatever state it is; None without one."""
        try:
            with path.open("rb") as whole, np.load(whole) as file:
                start, stop = file["span"].tolist()
                return start, stop
        except Exception:  # noqa: BLE001  damage can come out as any error
            return None

    def save(self, k: int, span: tuple[int, int], shard: ShardResult, job: ShardJob) -> None:
        """Keep a shard: its rows first, so that where the rest is they are too."""
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
        arrays = {f"{n}/{a}": v for n, state in shard.statistics.items() for a, v in state.items()}
        arrays |= {"span": np.array(span), "rows": np.array(rows_digest)}
        arrays["digest"] = np.array(_digest(arrays))
        writer.write_atomically(self._path(k), _npz_bytes(arrays), replace=True)

    def load(self, k: int) -> dict[str, StatisticState]:
        """Return the statistics of a shard."""
        found: dict[str, dict[str, Any]] = {}
        with np.load(self._path(k)) as file:
            for name in file.files:
                of, slash, array = name.partition("/")
                if slash:
                    found.setdefault(of, {})[array] = file[name]
        return dict(found)

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

    def _path(self, k: int) -> Path:
        return self.folder / f"shard-{k:06d}.npz"


def _stored_arrays(path: Path) -> dict[str, Any] | None:
    """Return the arrays of a shard; None where they do not match their digest, or have none."""
    try:
        with path.open("rb") as whole, np.load(whole) as file:
            found = {name: file[name] for name in file.files}
        digest = str(found.pop("digest"))
    except Exception:  # noqa: BLE001  damage can come out as any error
        return None
    return found if digest == _digest(found) else None


def _digest(arrays: Mapping[str, Any]) -> str:
    """Return the SHA-256 of arrays with their names, types and shapes."""
    found = sha256()
    for name in sorted(arrays):
        array = np.asarray(arrays[name])
        found.update(repr((name, array.dtype.str, array.shape)).encode())
        found.update(array.tobytes())
    return found.hexdigest()


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

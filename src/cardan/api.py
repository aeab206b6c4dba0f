"""Public interface, `import cardan`: read, evaluate and show, from a script or a notebook.

Results are those of the studies, texts and documents those of the reports; nothing is computed
here and no other module imports it. Further functions evaluate one part without an application
file: a universal joint, a run-up, a joint with backlash, a steering column, internal damping, a
composite tube.
"""

import json
from collections.abc import Callable, Generator, Iterable, Mapping
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from functools import partial
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np

from cardan.application import source_location
from cardan.application.overrides import addresses, change
from cardan.application.plausibility import with_limit_profile
from cardan.application.reader import loads, read
from cardan.approval import approval as approvals
from cardan.approval.registry import studies_of_application
from cardan.approval.study import BRACKET_STUDY_NAME, DRIVELINE_STUDY_NAME, Study, StudyResult
from cardan.checks.quantities.registry import LIMITABLE_QUANTITIES, LINE_QUANTITIES, QUANTITIES
from cardan.core.errors import CardanError, DesignError
from cardan.core.labels import EvaluationCondition, Part
from cardan.core.optional_import import import_optional
from cardan.core.verdict import VERDICTS, Verdict
from cardan.documents import approval_json as contract
from cardan.model.application import Application, GearboxAndAxleRotors
from cardan.model.laminate import CompositeTube
from cardan.physics.dynamics.internal_damping import hysteretic_threshold, viscous_threshold
from cardan.physics.dynamics.joint_backlash import JointWithBacklash, simulate_rattle
from cardan.physics.dynamics.run_up import MotorDrivenShaft, resonance_passage, run_up_outcomes
from cardan.physics.dynamics.steering_shimmy import Steering, simulate_shimmy
from cardan.physics.strength.composite_tube import buckling_torques, lightest_layup
from cardan.render.blocks import ReportDateAndSourceStamp, ReportDocument
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.json_contract import check_json, unevaluated_json
from cardan.render.media import REPORT_MEDIA, ReportMedium
from cardan.render.phrases import check_sentence, worst_check_per_limit
from cardan.render.terminal import summary_lines, verdict_lines
from cardan.render.text_layout import without_colours
from cardan.schema.atomic_write import write_atomically
from cardan.schema.node_reader import nearest_name_hint
from cardan.topics.bracket.registration import BracketStudy
from cardan.topics.design import corrections as fixes
from cardan.topics.design import sizing as sizings
from cardan.topics.design.corrections_json_presentation import corrections_json
from cardan.topics.design.presentation import correction_lines
from cardan.topics.joint.notebook_presentation import Joint, joint
from cardan.topics.recording import rainflow_matrices as matrices
from cardan.topics.recording.registration import RecordingCampaignStudy
from cardan.topics.torsion.registration import VibrationStudy
from cardan.topics.variants import evaluation as sweeps
from cardan.topics.variants.runner import run_study
from cardan.topics.variants.study_result import VariantStudyResult

__all__ = [
    "Application",
    "Approval",
    "CompositeTube",
    "Corrections",
    "Joint",
    "JointWithBacklash",
    "MotorDrivenShaft",
    "QuantityValues",
    "RainflowMatrices",
    "RecordingResult",
    "Sizing",
    "Steering",
    "Sweep",
    "addresses",
    "bracket",
    "buckling_torques",
    "change",
    "check",
    "fix",
    "hysteretic_threshold",
    "joint",
    "life",
    "lightest_layup",
    "loads",
    "read",
    "read_rainflow",
    "resonance_passage",
    "run_up_outcomes",
    "simulate_rattle",
    "simulate_shimmy",
    "size",
    "stability",
    "study",
    "viscous_threshold",
    "write_drive_file",
]  # fmt: skip

ResultT = TypeVar("ResultT")

MAX_ROWS_OF_REPR, MAX_LINES_OF_REPR = 3, 6
"""Rows of checks or values, and lines of other text, that a repr shows; `print` shows all."""


# --------------------------------------------------------------------------- what is returned


class Approval(approvals.Approval):
    """Approval of an application: its verdict, with checks, data and notes.

    `verdict`, `checks`, `coverage` and `of(study)` are those of every approval.
    """

    def __repr__(self) -> str:
        summary = without_colours(summary_lines(self))
        worst = [c for c in worst_check_per_limit(self.checks) if c.grade != "pass"]
        rows = [f"  {check_sentence(c, ENGLISH)}" for c in worst[:MAX_ROWS_OF_REPR]]
        return "\n".join([summary, *rows, *_more(len(worst) - len(rows))])

    def __str__(self) -> str:
        return without_colours(verdict_lines(self))

    def _repr_html_(self) -> str:
        return _module("documents.notebook").approval_html(self, ENGLISH)

    def plot(self, view: str = "side", *, line: str | None = None) -> Any:
        """Draw a line as reports do: "side", "top", "yokes", "planes" or "phasors".

        The drawing shows itself in a notebook; `.save("side.svg")` writes it. `line` names one of
        several lines, the first by default.

        Raises
        ------
        ValueError
            If there is no such view or no such line.
        """
        views = _module("documents.notebook").LINE_VIEWS
        lines = {r.line.name: r for r in self.line_responses}
        if not lines:
            msg = f"{', '.join(self.studies)} alone has no drawing: use cardan.check"
            raise ValueError(msg)
        line = next(iter(lines)) if line is None else line
        for what, name, known in (("view", view, views), ("line", line, lines)):
            if name not in known:
                msg = f"there is no {what} {name}; {nearest_name_hint(name, tuple(known))}"
                raise ValueError(msg)
        return _module("documents.notebook").line_drawing(lines[line], view)

    def to_frame(self) -> Any:
        """Return a pandas frame with a row for each check, and for each that is not evaluated."""
        rows = [{**check_json(c), "required": c.limit.required} for c in self.checks]
        rows += [
            {
                **unevaluated_json(u),
                "unit": QUANTITIES[u.quantity].unit_symbol,
                "verdict": None,
            }
            for u in self.coverage.unevaluated
        ]
        names = (
            "quantity", "line", "state", "part", "value", "unit", "sense", "limit", "margin",
            "verdict", "required", "source", "needs",
        )  # fmt: skip
        return _frame({name: [row.get(name) for row in rows] for name in names})

    def quantity(self, key: str) -> "QuantityValues":
        """Return the values of a quantity by line, state and part, in the unit it is shown in.

        Of the driveline every one, whether a limit applies to it or not; of another study
        those that it held against a limit. Solved with rubber at its stop, or lower bounds there.
        """
        if key not in QUANTITIES or not (key in LINE_QUANTITIES or key in LIMITABLE_QUANTITIES):
            msg = (
                f"there is no quantity {key}; "
                f"{nearest_name_hint(key, (*LINE_QUANTITIES, *LIMITABLE_QUANTITIES))}"
            )
            raise ValueError(msg)
        q = QUANTITIES[key]
        if key not in LINE_QUANTITIES:
            found = [
                QuantityValue(
                    line=c.line, when=c.when, part=c.part,
                    value=c.value / q.si_factor, is_lower_bound=c.is_lower_bound,
                )
                for c in self.checks
                if c.quantity == key
            ]  # fmt: skip
        else:
            assert q.parts is not None
            found = [
                QuantityValue(
                    line=r.line.name,
                    when=EvaluationCondition("state", state),
                    part=part,
                    value=float(v) / q.si_factor,
                    is_lower_bound=bool(bound),
                )
                for r in self.line_responses
                for values, bounds in (q.values_and_bounds(r),)
                for state, row, least in zip(r.demand.states, values, bounds, strict=True)
                for part, v, bound in zip(q.parts(r), row, least, strict=True)
            ]
        return QuantityValues(quantity=key, unit=q.unit_symbol, values=tuple(found))

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON contract's document; of a study alone that of its own command."""
        if self.line_responses:
            return contract.json_document(self)
        if self.study_results[0].study == BRACKET_STUDY_NAME:
            return _module("topics.bracket.presentation_json").json_document(self)
        return _module("topics.torsion.presentation_json").json_document(self)

    def report(self, path: str | Path, *, lang: str = "en", corrections: bool = True) -> Path:
        """Write a report: .html, .pdf, .xlsx or .json, as the name ends.

        Pages and documents look for `corrections`: half a minute for three shafts, minutes
        for four.

        Raises
        ------
        CardanError
            If there is no report of that kind, or what it needs is not installed.
        """
        path, say = Path(path), Translator(lang)
        story = partial(_report_document, self, say, corrections=corrections)
        writers: dict[str, Callable[[], str | bytes]] = {
            **{f".{m.name}": partial(_written_report, m, story) for m in REPORT_MEDIA},
            ".xlsx": lambda: _module("documents.workbook").workbook_bytes(self, say=say),
            ".json": lambda: json.dumps(
                self.to_dict(), indent=1, ensure_ascii=False, allow_nan=False
            ) + "\n",
        }  # fmt: skip
        if path.suffix.lower() not in writers:
            msg = f"a report ends in {', '.join(writers)}; got {path.name}"
            raise CardanError(msg)
        if not self.line_responses and path.suffix.lower() != ".json":
            msg = f"a report tells of a driveline: check it, with studies=({self.studies[0]!r},)"
            raise CardanError(msg)
        from cardan.schema.atomic_write import check_output_paths, write_atomically

        check_output_paths({"the report": path}, inputs=_source_files(self.application))
        write_atomically(path, writers[path.suffix.lower()](), replace=True)
        return path


@dataclass(frozen=True, kw_only=True, repr=False)
class QuantityValue:
    """A number in the unit its quantity is shown in, and of what it is.

    The quantity may be more than a lower bound, as a force where rubber goes beyond its stop.
    """

    line: str
    when: EvaluationCondition
    part: Part
    value: float
    is_lower_bound: bool = False

    def __repr__(self) -> str:
        where = ENGLISH.join(self.line, ENGLISH.occasion(self.when), ENGLISH.part(self.part))
        least = ">= " if self.is_lower_bound else ""
        return f"{where}: {least}{ENGLISH.number(self.value)}"


@dataclass(frozen=True, kw_only=True, repr=False)
class QuantityValues:
    """The values of one quantity, in the unit it is shown in; nan where nothing is known."""

    quantity: str
    unit: str
    values: tuple[QuantityValue, ...]

    @property
    def worst(self) -> QuantityValue | None:
        """The value on the wrong side of all others; None where nothing is known."""
        known = [v for v in self.values if v.value == v.value]
        largest = QUANTITIES[self.quantity].sense == "<="
        return (max if largest else min)(known, key=lambda v: v.value, default=None)

    def to_frame(self) -> Any:
        """Return a pandas frame with a row for each value."""
        return _frame(
            {
                "line": [v.line for v in self.values],
                "state": [str(v.when) for v in self.values],
                "part": [str(v.part) for v in self.values],
                "value": [v.value for v in self.values],
                "unit": [self.unit] * len(self.values),
                "is_lower_bound": [v.is_lower_bound for v in self.values],
            }
        )

    def __repr__(self) -> str:
        if len(self.values) <= MAX_ROWS_OF_REPR:
            return str(self)
        head, *_ = str(self).splitlines()
        return "\n".join([head, f"  worst: {self.worst}", *_more(len(self.values) - 1)])

    def __str__(self) -> str:
        head = f"{QUANTITIES[self.quantity].name} [{self.unit or '1'}]"
        return "\n  ".join([head, *(map(repr, self.values) if self.values else ["no value"])])


class Corrections(tuple[fixes.Correction, ...]):
    """Corrections, best first."""

    __slots__ = ()

    def __repr__(self) -> str:
        return _first_lines(str(self))

    def __str__(self) -> str:
        return without_colours(correction_lines(self))

    def _repr_html_(self) -> str:
        return _module("documents.notebook").preformatted_html(str(self))

    def to_dict(self) -> list[dict[str, Any]]:
        """Return what `cardan fix --json` writes."""
        return corrections_json(self)


class Sizing(sizings.SizingResult):
    """Proposed parts: `remedies`, `unresolved` checks, and the `approval` with these parts."""

    def __repr__(self) -> str:
        return _first_lines(str(self))

    def __str__(self) -> str:
        return without_colours(_module("topics.design.sizing_presentation").text_lines(self))

    def _repr_html_(self) -> str:
        return _module("documents.notebook").preformatted_html(str(self))

    def to_dict(self) -> dict[str, Any]:
        """Return what `cardan size --json` writes."""
        return _module("topics.design.sizing_presentation").json_document(self)


class Sweep(VariantStudyResult):
    """Results of a study of variants: `yield_`, `interval()`, `shares`, and what was requested.

    Where each variant was kept also `verdicts`, `margins`, `input_columns` and `limit_columns`.
    """

    @property
    def evaluated_variants(self) -> sweeps.EvaluatedVariants:
        """Each variant.

        Raises
        ------
        DesignError
            If they were not kept.
        """
        if self.rows is None:
            msg = "the variants were not kept one by one: ask with rows, and without a folder"
            raise DesignError(msg)
        return self.rows

    @property
    def verdicts(self) -> tuple[Verdict, ...]:
        """What each variant comes to."""
        return self.evaluated_variants.verdicts

    @property
    def margins(self) -> Any:
        """The smallest margin of each variant, (V,)."""
        return self.evaluated_variants.margins

    @property
    def input_columns(self) -> tuple[sweeps.InputColumn, ...]:
        """Each number that varies."""
        return self.evaluated_variants.input_columns

    @property
    def limit_columns(self) -> tuple[sweeps.LimitColumn, ...]:
        """What each limit came to."""
        return self.evaluated_variants.limit_columns

    def __repr__(self) -> str:
        return _first_lines(str(self), MAX_ROWS_OF_REPR - 1)

    def __str__(self) -> str:
        return without_colours(
            _module("topics.variants.presentation").terminal_lines(self, ENGLISH)
        )

    def _repr_html_(self) -> str:
        return _module("documents.notebook").chapters_html(
            _module("topics.variants.presentation_report").chapters(self)
        )

    def to_dict(self) -> dict[str, Any]:
        """Return what `cardan study --json` writes."""
        return _module("topics.variants.presentation_json").json_document(self)

    def figures(self) -> tuple[Any, ...]:
        """Return histograms, bars and maps: each has a title and its `svg`."""
        return tuple(_module("topics.variants.presentation_figures").figures(self))

    def to_frame(self) -> Any:
        """Return a pandas frame with a row for each variant.

        What varied, the verdict, the smallest margin, and of each limit the value where it
        is worst, in the unit its quantity is shown in, and the margin there.
        """
        rows = self.evaluated_variants
        columns: dict[str, Any] = {v.name: v.values for v in rows.input_columns}
        columns |= {"verdict": rows.verdicts, "margin": rows.margins}
        for name, held in rows.named_limit_columns():
            columns[name] = held.values / QUANTITIES[held.limit.quantity].si_factor
            columns[f"{name} margin"] = held.margins
        frame = _frame(columns)
        frame["verdict"] = frame["verdict"].astype(
            _pandas().CategoricalDtype(VERDICTS, ordered=True)
        )
        return frame


class RecordingResult(StudyResult[Any]):
    """Results of a recording: the lives at its gauges and, if a speed is known, the causes.

    `answer` holds the recording, its `lives` and its `causes`; `verdict` is None where
    nothing was requested of them.
    """

    @property
    def verdict(self) -> Verdict | None:
        """What the gauges come to, held against a target or limits."""
        return _module("topics.recording.life_verdict").assessment_verdict(self)

    def __repr__(self) -> str:
        return _first_lines(str(self))

    def __str__(self) -> str:
        return without_colours(_module("topics.recording.presentation").terminal_lines(self))

    def _repr_html_(self) -> str:
        return _module("documents.notebook").preformatted_html(str(self))

    def to_dict(self) -> dict[str, Any]:
        """Return what `cardan life --json` writes."""
        return _module("topics.recording.json_presentation").json_document(self)

    def to_frame(self) -> Any:
        """Return a pandas frame with a row for each gauge."""
        names = ("name", "low_MPa", "high_MPa", "damage", "hours", "km", "damage_exponent")
        gauges = self.to_dict()["gauges"]
        return _frame({name: [g[name] for g in gauges] for name in names})

    def rainflow(self, kind: Literal["from-to", "range-mean"] = "from-to") -> "RainflowMatrices":
        """Return the rainflow matrix of each gauge; of a campaign that of its mix."""
        found = _module("topics.recording.result_tables").rainflow_matrices(self.answer, kind)
        return _as_api_result(RainflowMatrices, found)


class RainflowMatrices(matrices.RainflowMatrices):
    """Rainflow matrices of some gauges: to be kept, read again and merged.

    `tables` holds one a gauge, in Pa, with its `cycles()`; `merged(other, times=3)` counts another
    recording's three times on top.
    """

    def to_frame(self) -> Any:
        """Return a pandas frame with a row for each bin that holds any cycle, and its edges."""
        return _frame(self.columns())

    def write(self, path: str | Path, *, replace: bool = False) -> Path:
        """Write what `cardan life --from-to` or `--range-mean` writes: `.csv` or `.parquet`."""
        table_bytes = _module("topics.recording.table_files").table_bytes
        return write_atomically(path, table_bytes(self.columns(), Path(path)), replace=replace)


class RecordingCampaignResult(RecordingResult):
    """Results of a campaign of recordings: the lives at its gauges in the mix of all.

    `answer` holds the `parts`, recording by recording, and the `lives`.
    """

    def __str__(self) -> str:
        return without_colours(
            _module("topics.recording.presentation").campaign_terminal_lines(self)
        )

    def to_dict(self) -> dict[str, Any]:
        """Return what `cardan life --json` writes of a campaign."""
        return _module("topics.recording.json_presentation").campaign_json_document(self)

    def to_frame(self) -> Any:
        """Return a pandas frame with a row for each gauge and recording."""
        rows = [
            {"name": gauge["name"], **row}
            for gauge in self.to_dict()["gauges"]
            for row in gauge["recordings"]
        ]
        return _frame({name: [row[name] for row in rows] for name in rows[0]})


# --------------------------------------------------------------------------- requests


def check(
    app: Application,
    limits: str | Path | None = None,
    studies: Iterable[str] | None = None,
    recording: str | Path | None = None,
) -> Approval:
    """Hold an application against every limit, in every state.

    Parameters
    ----------
    app
        As read from a file.
    limits
        The name of a profile, or the file of one, in place of the application's own.
    studies
        Which to run with the driveline: "vibration", "bracket". By default vibration,
        where the file says what turns at both ends.
    recording
        A campaign's file, whose recordings are assessed too, for the same verdict.

    Raises
    ------
    DesignError
        If the driveline cannot exist in a state; the message says where in the file.
    """
    if limits is not None:
        app = with_limit_profile(app, str(limits))
    chosen = (
        approvals.default_studies(app)
        if studies is None
        else tuple(map(_study_named, dict.fromkeys((DRIVELINE_STUDY_NAME, *studies))))
    )
    if recording is not None:
        chosen = (
            *chosen,
            RecordingCampaignStudy(Path(recording), with_figures=True, allow_outside=True),
        )
    return _approve(app, *chosen)


def stability(app: Application, **torsion: float) -> Approval:
    """Hold each gear's speeds against torsional resonances, parametric zones and flutter.

    `torsion` goes before the file's own: `axle_inertia` kg m², `axle_stiffness` N m/rad,
    `gearbox_inertia`, `gearbox_stiffness`, `damping_ratio`, `rubber_loss`.
    """
    return _approve(app, VibrationStudy(GearboxAndAxleRotors(**torsion)))


def bracket(app: Application) -> Approval:
    """Evaluate the bracket of a centre bearing under the driveline's loads; takes minutes."""
    return _approve(app, BracketStudy())


def fix(
    app: Application, *, line: str | None = None, hold: Iterable[str] = (), count: int = 5
) -> Corrections:
    """Propose what to change, over all states at once, as `cardan fix` does."""
    with _locate_design_errors(app):
        return Corrections(fixes.find_corrections(app, line=line, hold=tuple(hold), count=count))


def size(app: Application, *, line: str | None = None) -> Sizing:
    """Propose other parts where moving cannot help, as `cardan size` does."""
    with _locate_design_errors(app):
        return _as_api_result(Sizing, sizings.propose_parts(app, line=line))


def study(
    app: Application,
    vary: Mapping[str, sweeps.InputVariationSpec] | None = None,
    *,
    tolerances: Mapping[str, sweeps.InputVariationSpec] | None = None,
    n: int = 10_000,
    seed: int = 0,
    out: str | Path | None = None,
    resume: bool = False,
    executor: Executor | None = None,
    workers: int = 1,
    **ask: Any,
) -> Sweep:
    """Evaluate the driveline of many variants at once.

    Parameters
    ----------
    app
        As read from a file.
    vary
        By the address of a number, as `cardan.addresses` has them, or the key of something
        that can be moved (`bearing_height_mm[1]`, `shim_deg`): `[low, high]`,
        `{"choice": [...]}`, `{"grid": [low, high, how many]}`, `{"normal": sigma}` or
        `{"uniform": half}`. Where nothing is said, what the file's `study` says.
    tolerances
        What scatters about that: `{"normal": sigma}` or `{"uniform": half}`.
    n, seed
        How many variants, and the seed of their points.
    out, resume
        A folder that keeps what is done, and whether to go on with what it holds.
    executor, workers
        Who computes, and how many at a time: any of `concurrent.futures`, or a cluster's
        `get_executor()`; by default threads.
    ask
        As in the file's `ask`: `quantiles=(0.05, 0.95)`, `sobol=True`, `worst=5`,
        `pareto=("margin", "cost")`, `maps=(("shim_deg", "axle.ratio"),)`, `confidence=0.95`.
        Without a folder each variant is kept, unless `rows` is None or `yield_only` is True.
    """
    if vary is None and tolerances is None and app.variants is not None:
        variants = app.variants
    else:
        variants = sweeps.build_variants(vary, tolerances)
    if out is None and not ask.get("yield_only", variants.ask.yield_only):
        ask = {"rows": "float64", **ask}
    variants = replace(variants, ask=replace(variants.ask, **ask))
    with _locate_design_errors(app):
        found = run_study(
            app, variants, count=n, seed=seed, folder=None if out is None else Path(out),
            resume=resume, executor=executor, workers=workers,
        )  # fmt: skip
        return _as_api_result(Sweep, found)


def life(recording: str | Path, **options: Any) -> RecordingResult:
    """Return damage and life at the gauges of a recording, and its causes.

    The options are those of `cardan.topics.recording.options.AnalysisOptions`, named as on the
    command line:
    `gauges=["bracket:MPa"], sn=(90, 2e6, 5), speed="shaft:rpm", low_pass_Hz=400`. A recording
    that ends in .yaml is a campaign's file, which says all of that itself.
    """
    if Path(recording).suffix.lower() in (".yaml", ".yml"):
        if options:
            msg = f"{next(iter(options))} belongs in the campaign's file, not in the call"
            raise DesignError(msg)
        return _as_api_result(
            RecordingCampaignResult,
            _module("topics.recording.campaign_study").analyse_campaign(
                Path(recording), allow_outside=True
            ),
        )
    campaign = import_module("cardan.topics.recording.options").AnalysisOptions.from_values(
        **options
    )
    return _as_api_result(
        RecordingResult,
        _module("topics.recording.study").analyse_recording(Path(recording), campaign),
    )


def read_rainflow(path: str | Path) -> RainflowMatrices:
    """Read the rainflow matrices of a file that `cardan life` or `RainflowMatrices.write` wrote.

    Raises
    ------
    InvalidFileError
        If it holds none, or a bin or a count that cannot be.
    """
    found = _module("topics.recording.table_files").read_rainflow_matrices(Path(path))
    return _as_api_result(RainflowMatrices, found)


def write_drive_file(
    path: str | Path, channels: Mapping[str, Any], *, rate: float,
    units: Mapping[str, str] | None = None, replace: bool = False,
) -> Path:  # fmt: skip
    """Write a drive file for a test rig, RPC III of 16-bit samples, and return its path.

    Parameters
    ----------
    path
        Usually `.drv`, or `.rsp`.
    channels : (n,)
        Samples of each channel by its name, of one length.
    rate : Hz
        Samples a second.
    units
        Of the channels, by name; those that are not named have none.
    replace
        Whether a file that is there already is written over.

    Raises
    ------
    DesignError
        If the channels differ in length, a sample is missing, or the format holds no such name.
    InvalidFileError
        If the file is there already or cannot be written.
    """
    from cardan.physics.signals.recording import recording_from_arrays
    from cardan.readers.rpc_writer import rpc_chunks

    rows = [np.asarray(x, dtype=float) for x in channels.values()]
    if len({row.shape for row in rows}) != 1 or rows[0].ndim != 1:
        msg = "channels of a drive file are lists of one length, got " + ", ".join(
            f"{name} {row.shape}" for name, row in zip(channels, rows, strict=True)
        )
        raise DesignError(msg)
    recording = recording_from_arrays(
        np.stack(rows), rate=rate, names=channels, name=Path(path).name,
        units=[(units or {}).get(name, "") for name in channels],
    )  # fmt: skip
    return write_atomically(path, rpc_chunks(recording), replace=replace)


# --------------------------------------------------------------------------- how


def _study_named(name: str) -> Study[Any]:
    if name not in studies_of_application():
        msg = f"there is no study {name}; {nearest_name_hint(name, studies_of_application())}"
        raise ValueError(msg)
    return studies_of_application()[name]


def _approve(app: Application, *studies: Study[Any]) -> Approval:
    with _locate_design_errors(app):
        return _as_api_result(Approval, approvals.approve_application(app, studies))


def _as_api_result(kind: type[ResultT], found: Any) -> ResultT:
    """Return what a room found, as what can show itself."""
    return kind(**{f.name: getattr(found, f.name) for f in fields(found)})


@contextmanager
def _locate_design_errors(app: Application) -> Generator[None, None, None]:
    """Name the place in its file that an impossible part stands at."""
    try:
        yield
    except DesignError as error:
        if app.written is None:
            raise
        raise DesignError(
            source_location.error_with_location(error, app, app.written.name)
        ) from error


def _module(name: str) -> Any:
    """Import a module of the package on first use."""
    return import_module(f"cardan.{name}")


def _written_report(medium: ReportMedium, story: Callable[[], ReportDocument]) -> str | bytes:
    """Return a report in a medium, made when it is written."""
    return medium.write(story())


def _report_document(of: Approval, say: Translator, *, corrections: bool) -> Any:
    issue = _document_stamp(of.application)
    return _module("documents.approval_report").approval_report(
        of, say=say, issue=issue, corrections=corrections
    )


def _document_stamp(app: Application) -> ReportDateAndSourceStamp:
    """Return what says which report this is: the day, the file, and what was changed in it."""
    from datetime import date

    written, today = app.written, date.today().isoformat()
    if written is None:
        return ReportDateAndSourceStamp(date=today)
    changes = "".join(f"# changed: {at}: {to}\n" for at, to in written.changes.items())
    text = written.text + (f"\n{changes}" if changes else "")
    return ReportDateAndSourceStamp(
        date=today,
        file_names=(Path(written.name).name,),
        fingerprints=(sha256(text.encode()).hexdigest()[:16],),
        file_texts=(text,),
    )


def _source_files(app: Application) -> tuple[Path, ...]:
    """Return the files that an application was read from."""
    written = app.written
    if written is None or written.folder is None:
        return ()
    return Path(written.name), *written.referenced_files


def _frame(columns: Mapping[str, Any]) -> Any:
    return _pandas().DataFrame(columns)


def _pandas() -> Any:
    return import_optional("pandas", extra="frame", purpose="a frame")


def _more(count: int) -> list[str]:
    """Return that print shows so many more rows; nothing if there are none."""
    return [f"  +{count} more: print"] if count > 0 else []


def _first_lines(text: str, count: int = MAX_LINES_OF_REPR) -> str:
    """Return the first lines of a text, and how many more print shows."""
    lines = text.splitlines()
    rest = len(lines) - count
    return "\n".join([*lines[:count], f"+{rest} lines: print"]) if rest > 1 else text

"""The public face, `import cardan`: read, ask, show, from a script or a notebook.

It translates and never calculates: every answer is that of a study, every word and every
document that of a report. Nothing below knows it. Beside those stand the sciences that ask a
part by itself, which no application file describes: a run-up, a joint with play, a steering
column, damping that turns, a tube of plies.
"""

import json
from collections.abc import Callable, Generator, Iterable, Mapping
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

from cardan import files
from cardan.base.errors import CardanError, DesignError, NotInstalled
from cardan.base.part import Occasion, Part
from cardan.base.verdict import VERDICTS, Verdict
from cardan.border.table import nearest
from cardan.dynamics.clearance import LooseJoint, rattle
from cardan.dynamics.damping import hysteretic_threshold, viscous_threshold
from cardan.dynamics.runup import Driven, fates, passage
from cardan.dynamics.shimmy import Steering, shimmy
from cardan.files import addresses, change, loads, read
from cardan.model.application import Application, Surroundings
from cardan.model.laminate import CompositeTube
from cardan.quantity.quantities import ANSWERED, LIMITABLE, QUANTITIES
from cardan.report import contract, terminal
from cardan.report.blocks import Issue
from cardan.report.language import EN, Language
from cardan.shaft.composite import buckling_torques, lightest
from cardan.study import approval as approvals
from cardan.study import fix as fixes
from cardan.study import shards
from cardan.study import sizing as sizings
from cardan.study import sweep as sweeps
from cardan.study.finding import BRACKET, DRIVELINE, Finding, Study
from cardan.study.studies import STUDIES, BracketStudy, CampaignStudy, VibrationStudy

__all__ = [
    "Application", "Approval", "CompositeTube", "Driven", "Life", "LooseJoint", "Proposals",
    "Sizing", "Steering", "Sweep", "Values", "addresses", "bracket", "buckling_torques", "change",
    "check", "fates", "fix", "hysteretic_threshold", "life", "lightest", "loads", "passage",
    "rattle", "read", "shimmy", "size", "stability", "study", "viscous_threshold",
]  # fmt: skip

Shown = TypeVar("Shown")


# --------------------------------------------------------------------------- what is returned


class Approval(approvals.Approval):
    """The answer to an application: one verdict, and all that it stands on.

    `verdict`, `checks`, `coverage` and `of(study)` are those of every approval.
    """

    def __repr__(self) -> str:
        return terminal.bare(terminal.verdict(self))

    def _repr_html_(self) -> str:
        return _report("notebook").approval(self, EN)

    def to_frame(self) -> Any:
        """Return a pandas frame with a row for each check, and for each that has no answer."""
        rows = [{**contract.check(c), "required": c.limit.required} for c in self.checks]
        rows += [
            {**contract.unanswered(u), "unit": QUANTITIES[u.quantity].unit_name, "verdict": None}
            for u in self.coverage.unanswered
        ]
        names = (
            "quantity", "line", "state", "part", "value", "unit", "sense", "limit", "margin",
            "verdict", "required", "source", "needs",
        )  # fmt: skip
        return _frame({name: [row.get(name) for row in rows] for name in names})

    def quantity(self, key: str) -> "Values":
        """Return the values of a quantity by line, state and part, in the unit it is shown in.

        Of the driveline every one, whether a limit asks about it or not; of another study
        those that it held against a limit.
        """
        if key not in QUANTITIES or not (key in ANSWERED or key in LIMITABLE):
            msg = f"there is no quantity {key}; {nearest(key, (*ANSWERED, *LIMITABLE))}"
            raise ValueError(msg)
        q = QUANTITIES[key]
        if key not in ANSWERED:
            found = [
                Value(line=c.line, when=c.when, part=c.part, value=c.value / q.factor)
                for c in self.checks
                if c.quantity == key
            ]
        else:
            assert q.parts is not None
            found = [
                Value(line=r.line.name, when=Occasion("state", state), part=part, value=float(v))
                for r in self.responses
                for state, row in zip(r.demand.states, q.values(r) / q.factor, strict=True)
                for part, v in zip(q.parts(r), row, strict=True)
            ]
        return Values(quantity=key, unit=q.unit_name, values=tuple(found))

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON contract's document; of a study alone that of its own command."""
        if self.responses:
            return contract.approval(self)
        if self.findings[0].study == BRACKET:
            return _report("bracket").contract(self)
        return _report("stability").document(self)

    def report(self, path: str | Path, *, lang: str = "en", corrections: bool = True) -> Path:
        """Write a report: .html, .pdf, .xlsx or .json, as the name ends.

        Pages and documents look for `corrections`: half a minute for three shafts, minutes
        for four.

        Raises
        ------
        CardanError
            If there is no report of that kind, or what it needs is not installed.
        """
        path, say = Path(path), Language(lang)
        writers: dict[str, Callable[[], str | bytes]] = {
            ".html": lambda: _report("html").page(_story(self, say, corrections=corrections)),
            ".pdf": lambda: _report("pdf").document(_story(self, say, corrections=corrections)),
            ".xlsx": lambda: _report("workbook").workbook(self, say=say),
            ".json": lambda: json.dumps(
                self.to_dict(), indent=1, ensure_ascii=False, allow_nan=False
            ) + "\n",
        }  # fmt: skip
        if path.suffix.lower() not in writers:
            msg = f"a report ends in {', '.join(writers)}; got {path.name}"
            raise CardanError(msg)
        if not self.responses and path.suffix.lower() != ".json":
            msg = f"a report tells of a driveline: check it, with studies=({self.studies[0]!r},)"
            raise CardanError(msg)
        from cardan.border.writer import claim, write

        claim({"the report": path}, inputs=_read_from(self.application))
        write(path, writers[path.suffix.lower()](), replace=True)
        return path


@dataclass(frozen=True, kw_only=True, repr=False)
class Value:
    """A number in the unit its quantity is shown in, and of what it is."""

    line: str
    when: Occasion
    part: Part
    value: float

    def __repr__(self) -> str:
        where = EN.list(self.line, EN.occasion(self.when), EN.part(self.part))
        return f"{where}: {EN.number(self.value)}"


@dataclass(frozen=True, kw_only=True, repr=False)
class Values:
    """The values of one quantity, in the unit it is shown in; nan where nothing is known."""

    quantity: str
    unit: str
    values: tuple[Value, ...]

    @property
    def worst(self) -> Value | None:
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
            }
        )

    def __repr__(self) -> str:
        head = f"{QUANTITIES[self.quantity].name} [{self.unit or '1'}]"
        return "\n  ".join([head, *map(repr, self.values)])


class Proposals(tuple[fixes.Proposal, ...]):
    """Corrections, best first."""

    __slots__ = ()

    def __repr__(self) -> str:
        return terminal.bare(terminal.proposals(self))

    def _repr_html_(self) -> str:
        return _report("notebook").text(repr(self))

    def to_dict(self) -> list[dict[str, Any]]:
        """Return what `cardan fix --json` writes."""
        return contract.proposals(self)


class Sizing(sizings.Sizing):
    """Other parts that would do: `remedies`, `hopeless`, and the `approval` with them."""

    def __repr__(self) -> str:
        return terminal.bare(_report("sizing").lines(self))

    def _repr_html_(self) -> str:
        return _report("notebook").text(repr(self))

    def to_dict(self) -> dict[str, Any]:
        """Return what `cardan size --json` writes."""
        return _report("sizing").document(self)


class Sweep(shards.Studied):
    """What variants come to: `yield_`, `interval()`, `shares`, and what else was asked.

    Where each variant was kept also `verdicts`, `margins`, `varied`, and each limit's `held`.
    """

    @property
    def kept(self) -> sweeps.Sweep:
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
        return self.kept.verdicts

    @property
    def margins(self) -> Any:
        """The smallest margin of each variant, (V,)."""
        return self.kept.margins

    @property
    def varied(self) -> tuple[sweeps.Varied, ...]:
        """Each number that varies."""
        return self.kept.varied

    @property
    def held(self) -> tuple[sweeps.Held, ...]:
        """What each limit came to."""
        return self.kept.held

    def __repr__(self) -> str:
        return terminal.bare(_report("study").terminal(self, EN))

    def _repr_html_(self) -> str:
        return _report("notebook").chapters(_report("study").chapters(self))

    def to_dict(self) -> dict[str, Any]:
        """Return what `cardan study --json` writes."""
        return _report("study").document(self)

    def figures(self) -> tuple[Any, ...]:
        """Return histograms, bars and maps: each has a title and its `svg`."""
        return tuple(_report("study").figures(self))

    def to_frame(self) -> Any:
        """Return a pandas frame with a row for each variant.

        What varied, the verdict, the smallest margin, and of each limit the value where it
        is worst, in the unit its quantity is shown in, and the margin there.
        """
        rows = self.kept
        columns: dict[str, Any] = {v.name: v.values for v in rows.varied}
        columns |= {"verdict": rows.verdicts, "margin": rows.margins}
        for name, held in rows.named():
            columns[name] = held.values / QUANTITIES[held.limit.quantity].factor
            columns[f"{name} margin"] = held.margins
        frame = _frame(columns)
        frame["verdict"] = frame["verdict"].astype(
            _pandas().CategoricalDtype(VERDICTS, ordered=True)
        )
        return frame


class Life(Finding[Any]):
    """What a recording tells: the lives at its gauges and, where a speed is known, the causes.

    `answer` holds the recording, its `lives` and its `causes`; `verdict` is None where
    nothing was asked of them.
    """

    @property
    def verdict(self) -> Verdict | None:
        """What the gauges come to, held against a target or limits."""
        return _recording().verdict_on(self)

    def __repr__(self) -> str:
        return terminal.bare(_report("life").terminal(self))

    def _repr_html_(self) -> str:
        return _report("notebook").text(repr(self))

    def to_dict(self) -> dict[str, Any]:
        """Return what `cardan life --json` writes."""
        return _report("life").document(self)

    def to_frame(self) -> Any:
        """Return a pandas frame with a row for each gauge."""
        names = ("name", "low_MPa", "high_MPa", "damage", "hours", "km", "damage_exponent")
        gauges = self.to_dict()["gauges"]
        return _frame({name: [g[name] for g in gauges] for name in names})


class LifeOfMix(Life):
    """What a campaign of recordings tells: the lives at its gauges in the mix of all.

    `answer` holds the `parts`, recording by recording, and the `lives`.
    """

    def __repr__(self) -> str:
        return terminal.bare(_report("life").mix_terminal(self))

    def to_dict(self) -> dict[str, Any]:
        """Return what `cardan life --json` writes of a campaign."""
        return _report("life").mix_document(self)

    def to_frame(self) -> Any:
        """Return a pandas frame with a row for each gauge and recording."""
        rows = [
            {"name": gauge["name"], **row}
            for gauge in self.to_dict()["gauges"]
            for row in gauge["recordings"]
        ]
        return _frame({name: [row[name] for row in rows] for name in rows[0]})


# --------------------------------------------------------------------------- what is asked


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
        Which to ask beside the driveline: "vibration", "bracket". By default vibration,
        where the file says what turns at both ends.
    recording
        A campaign's file, whose recordings are asked too, for the same verdict.

    Raises
    ------
    DesignError
        If the driveline cannot exist in a state; the message says where in the file.
    """
    if limits is not None:
        name, rows = files.limits(str(limits))
        app = replace(app, profile=name, limits=rows)
    chosen = (
        approvals.default_studies(app)
        if studies is None
        else tuple(map(_study, dict.fromkeys((DRIVELINE, *studies))))
    )
    if recording is not None:
        chosen = (*chosen, CampaignStudy(Path(recording), draw=True, allow_outside=True))
    return _approved(app, *chosen)


def stability(app: Application, **torsion: float) -> Approval:
    """Hold each gear's speeds against torsional resonances, parametric zones and flutter.

    `torsion` goes before the file's own: `axle_inertia` kg m², `axle_stiffness` N m/rad,
    `gearbox_inertia`, `gearbox_stiffness`, `damping_ratio`, `rubber_loss`.
    """
    return _approved(app, VibrationStudy(Surroundings(**torsion)))


def bracket(app: Application) -> Approval:
    """Judge the bracket of a centre bearing under the driveline's loads. Takes a while."""
    return _approved(app, BracketStudy())


def fix(
    app: Application, *, line: str | None = None, hold: Iterable[str] = (), count: int = 5
) -> Proposals:
    """Propose what to change, over all states at once, as `cardan fix` does."""
    with _told(app):
        return Proposals(fixes.fix(app, line=line, hold=tuple(hold), count=count))


def size(app: Application, *, line: str | None = None) -> Sizing:
    """Propose other parts where moving cannot help, as `cardan size` does."""
    with _told(app):
        return _shown(Sizing, sizings.sizing(app, line=line))


def study(
    app: Application,
    vary: Mapping[str, sweeps.Spread] | None = None,
    *,
    tolerances: Mapping[str, sweeps.Spread] | None = None,
    n: int = 10_000,
    seed: int = 0,
    out: str | Path | None = None,
    resume: bool = False,
    executor: Executor | None = None,
    workers: int = 1,
    **ask: Any,
) -> Sweep:
    """Ask the driveline of many variants at once.

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
        Without a folder each variant is kept, unless `rows` is None.
    """
    if vary is None and tolerances is None and app.variants is not None:
        variants = app.variants
    else:
        variants = sweeps.variants_of(vary, tolerances)
    if out is None:
        ask = {"rows": "float64", **ask}
    variants = replace(variants, ask=replace(variants.ask, **ask))
    with _told(app):
        found = shards.study(
            app, variants, count=n, seed=seed, folder=None if out is None else Path(out),
            resume=resume, executor=executor, workers=workers,
        )  # fmt: skip
        return _shown(Sweep, found)


def life(recording: str | Path, **options: Any) -> Life:
    """Return damage and life at the gauges of a recording, and who did it.

    The options are those of `cardan.study.campaign.Campaign`, named as on the command line:
    `gauges=["bracket:MPa"], sn=(90, 2e6, 5), speed="shaft:rpm", low_pass_Hz=400`. A recording
    that ends in .yaml is a campaign's file, which says all of that itself.
    """
    if Path(recording).suffix.lower() in (".yaml", ".yml"):
        if options:
            msg = f"{next(iter(options))} is said in the campaign's file, not beside it"
            raise DesignError(msg)
        return _shown(LifeOfMix, _recording().listen_to_all(Path(recording), allow_outside=True))
    campaign = import_module("cardan.study.campaign").Campaign.of(**options)
    return _shown(Life, _recording().listen(Path(recording), campaign))


# --------------------------------------------------------------------------- how


def _study(name: str) -> Study[Any]:
    if name not in STUDIES:
        msg = f"there is no study {name}; {nearest(name, STUDIES)}"
        raise ValueError(msg)
    return STUDIES[name]


def _approved(app: Application, *studies: Study[Any]) -> Approval:
    with _told(app):
        return _shown(Approval, approvals.approve(app, studies))


def _shown(kind: type[Shown], found: Any) -> Shown:
    """Return what a room found, as what can show itself."""
    return kind(**{f.name: getattr(found, f.name) for f in fields(found)})


@contextmanager
def _told(app: Application) -> Generator[None, None, None]:
    """Name the place in its file that an impossible part stands at."""
    try:
        yield
    except DesignError as error:
        if app.written is None:
            raise
        raise DesignError(files.located(error, app, app.written.name)) from error


def _report(medium: str) -> Any:
    """Return a module of reports, imported where something is shown by it."""
    return import_module(f"cardan.report.{medium}")


def _recording() -> Any:
    """Return the room that listens, imported where there is something to listen to."""
    return import_module("cardan.study.recording")


def _story(of: Approval, say: Language, *, corrections: bool) -> Any:
    issue = _issue(of.application)
    return _report("story").whole(of, say=say, issue=issue, corrections=corrections)


def _issue(app: Application) -> Issue:
    """Return what says which report this is: the day, the file, and what was changed in it."""
    from datetime import date

    written, today = app.written, date.today().isoformat()
    if written is None:
        return Issue(date=today)
    changes = "".join(f"# changed: {at}: {to}\n" for at, to in written.changes.items())
    text = written.text + (f"\n{changes}" if changes else "")
    return Issue(
        date=today,
        files=(Path(written.name).name,),
        prints=(sha256(text.encode()).hexdigest()[:16],),
        texts=(text,),
    )


def _read_from(app: Application) -> tuple[Path, ...]:
    """Return the files that an application was read from."""
    written = app.written
    if written is None or written.folder is None:
        return ()
    return Path(written.name), *written.beside


def _frame(columns: Mapping[str, Any]) -> Any:
    return _pandas().DataFrame(columns)


def _pandas() -> Any:
    try:
        return import_module("pandas")
    except ModuleNotFoundError as error:
        msg = "a frame needs pandas: pip install 'cardan[frame]'"
        raise NotInstalled(msg) from error

"""What to change: corrections, maps of two moves, and what remains where moves scatter."""

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from cardan.application.layout_writer import FileChanges
from cardan.application.paste_import import parse_localised_number
from cardan.application.variant_sampling import VARIANTS_PER_CHUNK
from cardan.approval.applied_adjustments import (
    AppliedAdjustment,
    all_adjustments,
    allowed_adjustments,
)
from cardan.approval.approval import Approval
from cardan.checks.line_response import LineResponse
from cardan.checks.quantities.registry import LINE_QUANTITIES
from cardan.core.arrays import FloatArray, IntArray
from cardan.core.errors import CardanError
from cardan.core.verdict import CHECK_GRADES, VERDICTS, UnevaluatedCheck
from cardan.model.adjustments import ADJUSTMENTS
from cardan.model.adjustments import permitted_adjustments_by_name as names_of
from cardan.model.application import PermittedAdjustment
from cardan.model.variants import VariantOutputs
from cardan.render.i18n import Translator
from cardan.render.phrases import adjustable_parameter_phrase, adjustment_phrase
from cardan.topics.design.correction_edits import correction_changes
from cardan.topics.design.corrections import Correction, find_corrections
from cardan.topics.design.phrases import (
    correction_improvement_sentence,
    correction_margins_sentence,
    production_tolerance_sentence,
    remaining_problem_sentences,
    tolerance_yield_sentences,
)
from cardan.topics.variants.evaluation import (
    UNEVALUATED_GRADE_CODE,
    InputVariationSpec,
    LimitResults,
    VariantEvaluator,
    build_variants,
    variant_verdicts,
)
from cardan.topics.variants.statistics import (
    WORST_ACCEPTABLE_VERDICT_INDEX,
    clopper_pearson_interval,
)
from cardan.web import script_export as script
from cardan.web.parsed_document import (
    Json,
    ParsedDocument,
    PartialResultCallback,
    round_decimals,
    round_decimals_list,
    round_significant,
)

OPERATING_POINT_QUANTITIES = frozenset(k for k, q in LINE_QUANTITIES.items() if q.find_worst_points)
"""Quantities that are sought over all operating points: a later answer than the others."""
IMMEDIATE_QUANTITIES = frozenset(LINE_QUANTITIES) - OPERATING_POINT_QUANTITIES
ORDERED_QUANTITIES_WITHOUT_POINT_SEARCH = tuple(
    k for k in LINE_QUANTITIES if k in IMMEDIATE_QUANTITIES
)

MARGIN_MAP_CELLS_PER_SIDE, SEARCHED_MAP_CELLS_PER_SIDE = 33, 13
"""Cells along each side of a map, and where bearing forces are sought in every cell."""

MARGIN_MAP_REFINEMENT_STRIDES = (4, 2, 1)
"""A map is sent as it gets finer: every fourth cell of its rows and columns first."""

YIELD_BATCH_VARIANTS = 128
"""Cases of a yield that are sent at a time."""

MAX_CORRECTIONS = 6
"""Corrections at most."""

YIELD_CONFIDENCE = 0.95
"""How sure the interval is that a yield is given with."""

FAIL_INDEX_IN_VERDICTS, INCOMPLETE_INDEX_IN_VERDICTS = (
    VERDICTS.index("fail"),
    VERDICTS.index("incomplete"),
)


def edits_for_adjustments(
    read: ParsedDocument, line: str, moves: Sequence[AppliedAdjustment]
) -> FileChanges:
    """Return the edits of a document that moves of a workshop come to."""
    r = next(r for r in read.responses if r.line.name == line)
    return correction_changes(r, moves, read.manuscript)


def adjustable_parameters_json(r: LineResponse, say: Translator) -> list[Json]:
    """Return what can be moved of a line, by names that `hold` knows."""
    free = {(a.adjustment_key, a.part) for a in allowed_adjustments(r)}
    return [
        {
            "id": _adjustable_id(a),
            "said": adjustable_parameter_phrase(a, say),
            "unit": m.unit,
            "low": round_decimals(a.low / m.unit_value, 3),
            "high": round_decimals(a.high / m.unit_value, 3),
            "step": round_decimals(m.resolution / m.unit_value, 3),
            "free": (a.adjustment_key, a.part) in free,
            "choice": m.extremes_only,
        }
        for a in all_adjustments(r)
        for m in (ADJUSTMENTS[a.adjustment_key],)
    ]


def _adjustable_id(a: PermittedAdjustment) -> str:
    return f"{a.adjustment_key} {a.part}"


def _response(read: ParsedDocument, args: Json) -> LineResponse:
    return read.responses[min(int(args.get("line", 0)), len(read.responses) - 1)]


def propose_corrections(
    read: ParsedDocument, args: Json, say: Translator, tell: PartialResultCallback
) -> Json:
    """Return corrections of a line with what each moves, gives, and would edit.

    The best that is known is sent from the first on.
    """
    r = _response(read, args)
    tell({"doing": say("looking for corrections")})
    free = {_adjustable_id(a) for a in allowed_adjustments(r)}
    hold = [name for name in args.get("hold", []) if name in free]
    found = find_corrections(
        read.application, line=r.line.name, hold=hold, count=MAX_CORRECTIONS,
        tell=lambda done, of: tell({"done": done, "of": of} if of > 1 else {}),
        show=lambda p: tell({"proposals": [_correction_message(read, p, say)]}),
    )  # fmt: skip
    return {
        "line": r.line.name,
        "command": script.correction_command(read.name, r.line.name, hold, say, MAX_CORRECTIONS),
        "scatter": production_tolerance_sentence(found[0].tolerance_model, say) if found else "",
        "proposals": [_correction_message(read, p, say) for p in found],
    }


def _smallest_margin(of: Approval) -> float | None:
    return None if of.smallest_margin is None else round_significant(of.smallest_margin)


def _correction_message(read: ParsedDocument, p: Correction, say: Translator) -> Json:
    return {
        "verdict": p.verdict,
        "cost": round_decimals(p.cost, 4),
        "margin": _smallest_margin(p.approval),
        "before": _smallest_margin(p.installed_approval),
        "moves": [adjustment_phrase(m, say) for m in p.adjustments],
        "margins": correction_margins_sentence(p, say),
        "survives": [
            correction_improvement_sentence(p, say),
            *tolerance_yield_sentences(p.tolerance_yield, p.tolerance_model, say),
        ],
        "counts": {grade: sum(c.grade == grade for c in p.checks) for grade in CHECK_GRADES},
        "left": remaining_problem_sentences(p, say),
        "edits": edits_for_adjustments(read, p.line, p.adjustments),
    }


# --------------------------------------------------------------------------- variants


def _variant_evaluator(
    read: ParsedDocument, *, sought: bool, **study: dict[str, InputVariationSpec]
) -> VariantEvaluator:
    """Return where variants of a document are evaluated, of all its lines."""
    limits = () if sought else ORDERED_QUANTITIES_WITHOUT_POINT_SEARCH
    try:
        return VariantEvaluator.from_application(
            read.application, build_variants(**study, ask=VariantOutputs(limits=limits))
        )
    except ValueError as error:
        raise CardanError(str(error)) from None


def _study_names(read: ParsedDocument) -> dict[tuple[str, str, int], str]:
    """Return what a study calls things that move, by line, kind and part."""
    every = names_of(i.line for i in read.application.lines)
    return {(a.line, a.adjustment_key, a.part): name for name, a in every.items()}


def _unanswered_elsewhere(bench: VariantEvaluator) -> list[UnevaluatedCheck]:
    """Return what is required, not evaluated as it stands, and not evaluated for variants."""
    mine = {(line, limit.quantity) for line, limit in bench.limits}
    missed = bench.installed.coverage.missing_required
    return [u for u in missed if (u.line, u.quantity) not in mine]


def _study_options(bench: VariantEvaluator, *, sought: bool, elsewhere: bool) -> dict[str, Any]:
    """Return the limits a command has to name so that its result is that of a bench.

    Limits that are named leave the others out, so none is if one of those is not evaluated.
    """
    mine = {limit.quantity for _, limit in bench.limits}
    return (
        {}
        if sought or elsewhere
        else {"limits": [k for k in ORDERED_QUANTITIES_WITHOUT_POINT_SEARCH if k in mine]}
    )


def _limit_names(bench: VariantEvaluator, say: Translator) -> list[str]:
    several = len(bench.application.lines) > 1
    return [
        say.join(line if several else "", say.name(limit.quantity)) for line, limit in bench.limits
    ]


# --------------------------------------------------------------------------- maps


def margin_map(
    read: ParsedDocument, args: Json, say: Translator, tell: PartialResultCallback
) -> Json:
    """Return what all lines come to over a field of two moves; coarse maps are sent before."""
    r = _response(read, args)
    every = {_adjustable_id(a): a for a in all_adjustments(r) if a.low < a.high}
    ids = [args.get(key, "") for key in ("x", "y")]
    known = [every[n] for n in ids if n in every]
    pair = known if len(known) == 2 and ids[0] != ids[1] else list(every.values())[:2]
    if len(pair) < 2:
        return {"x": None, "y": None}
    sought = args.get("sought") is True
    count = SEARCHED_MAP_CELLS_PER_SIDE if sought else MARGIN_MAP_CELLS_PER_SIDE
    called = _study_names(read)
    vary: dict[str, InputVariationSpec] = {
        called[a.line, a.adjustment_key, a.part]: {
            "grid": [
                round_significant(a.low / m.unit_value),
                round_significant(a.high / m.unit_value),
                count,
            ]
        }
        for a in pair
        for m in (ADJUSTMENTS[a.adjustment_key],)
    }
    bench = _variant_evaluator(read, sought=sought, vary=vary)
    cells = _MapCells(bench, say)
    ask = {
        "maps": [list(vary)],
        **_study_options(bench, sought=sought, elsewhere=bool(cells.elsewhere)),
    }
    commands = script.study_commands(read.name, "map", count * count, say, vary=vary, ask=ask)
    place = np.arange(count * count).reshape(count, count)  # the first varies fastest
    found: Json = {}
    for step in MARGIN_MAP_REFINEMENT_STRIDES:
        wanted = place[::step, ::step]
        cells.ask(wanted.ravel(), lambda done: tell({"done": done, "of": count * count}))
        found = {
            **{
                key: {
                    "id": _adjustable_id(a),
                    "said": adjustable_parameter_phrase(a, say),
                    "unit": ADJUSTMENTS[a.adjustment_key].unit,
                    "values": round_decimals_list(cells.inputs[at, k], 3),
                }
                for k, (key, a, at) in enumerate(
                    (("x", pair[0], wanted[0]), ("y", pair[1], wanted[:, 0]))
                )
            },
            "sought": sought,
            "commands": commands,
            **cells.told(wanted),
        }
        if step > 1:
            tell({"map": found})
    return found


class _MapCells:
    """Cells of a map, each evaluated once."""

    def __init__(self, bench: VariantEvaluator, say: Translator) -> None:
        self.bench, self.say = bench, say
        whole = bench.whole_count(1)
        self.inputs = bench.sampling_plan.values(0, whole)
        self.elsewhere = _unanswered_elsewhere(bench)
        self.names = [
            *_limit_names(bench, say),
            *(say.name(u.quantity) for u in self.elsewhere[:1]),
        ]
        self.verdict = np.full(whole, -1)
        self.margin = np.full(whole, np.nan)
        self.decides = np.full(whole, -1)

    def ask(self, places: IntArray, tell: Callable[[int], None]) -> None:
        """Evaluate the cells that have no result yet."""
        new = places[self.verdict[places] < 0]
        for first in range(0, new.size, VARIANTS_PER_CHUNK):
            tell(int((self.verdict >= 0).sum()))
            at = new[first : first + VARIANTS_PER_CHUNK]
            self._enter(at, self.bench.evaluate(self.inputs[at]))

    def _enter(self, at: IntArray, a: LimitResults) -> None:
        self.verdict[at] = variant_verdicts(a, elsewhere=bool(self.elsewhere))
        worst = np.array([*map(VERDICTS.index, CHECK_GRADES), UNEVALUATED_GRADE_CODE])[
            a.grades
        ]  # the last: nothing
        worst = np.where(
            a.missed | a.bounded, np.maximum(worst, INCOMPLETE_INDEX_IN_VERDICTS), worst
        )
        left = a.deciding_margins
        among = np.where(worst == worst.max(axis=0), left, np.inf)
        decides = np.where(np.isinf(among).all(axis=0), worst.argmax(axis=0), among.argmin(axis=0))
        self.margin[at] = np.take_along_axis(a.margins, decides[None], axis=0)[0]
        if self.elsewhere:
            decides[worst.max(axis=0) < INCOMPLETE_INDEX_IN_VERDICTS] = len(a.grades)
        self.decides[at] = decides
        for k in at[a.infeasible].tolist():  # each says for itself why it cannot exist
            self.decides[k] = self._named(self.bench.evaluate(self.inputs[[k]]).why)

    def _named(self, why: str) -> int:
        said = self.say("cannot be built: {why}", why=self.say.error(why))
        if said not in self.names:
            self.names.append(said)
        return self.names.index(said)

    def told(self, wanted: IntArray) -> Json:
        """Return some of the cells, as rows and columns."""
        return {
            "verdicts": self.verdict[wanted].tolist(),
            "margins": round_decimals_list(self.margin[wanted], 4),
            "decides": self.decides[wanted].tolist(),
            "names": list(self.names),
        }


def edits_for_adjustment_amounts(
    read: ParsedDocument, args: Json, _: Translator, __: PartialResultCallback
) -> Json:
    """Return the edits of moves by their amounts, each in the unit it is shown in."""
    r = _response(read, args)
    every = {_adjustable_id(a): a for a in all_adjustments(r)}
    moves = [
        AppliedAdjustment(
            adjustable=a, amount=row["amount"] * ADJUSTMENTS[a.adjustment_key].unit_value
        )
        for row in args.get("moves", [])
        if (a := every.get(row["id"])) and row["amount"]
    ]
    return {"edits": edits_for_adjustments(read, r.line.name, moves) if moves else {}}


# --------------------------------------------------------------------------- yield


def production_yield(
    read: ParsedDocument, args: Json, say: Translator, tell: PartialResultCallback
) -> Json:
    """Return the share that may be built where moves scatter, sent as it becomes surer."""
    r = _response(read, args)
    every, called = {_adjustable_id(a): a for a in all_adjustments(r)}, _study_names(read)
    amounts = ((every.get(row["id"]), row["amount"]) for row in args.get("sigmas", []))
    sigmas: dict[str, InputVariationSpec] = {
        called[a.line, a.adjustment_key, a.part]: {"normal": amount}
        for a, typed in amounts if a and (amount := _parsed_deviation(typed, a, say)) > 0
    }  # fmt: skip
    if not sigmas:
        return {"count": 0}
    bench = _variant_evaluator(read, sought=args.get("sought") is True, tolerances=sigmas)
    elsewhere, limits = _unanswered_elsewhere(bench), _limit_names(bench, say)
    count = max(1, int(args.get("count", 4096)))
    ask = _study_options(bench, sought=args.get("sought") is True, elsewhere=bool(elsewhere))
    commands = script.study_commands(read.name, "yield", count, say, tolerances=sigmas, ask=ask)
    found: list[IntArray] = []
    margins: list[FloatArray] = []
    lost: Counter[str] = Counter()
    told: Json = {}
    for start in range(0, count, YIELD_BATCH_VARIANTS):
        rows = bench.evaluate_range(start, min(start + YIELD_BATCH_VARIANTS, count))
        found.append(variant_verdicts(rows.results, elsewhere=bool(elsewhere)))
        margins.append(rows.margins)
        for said, grades, missed in zip(
            limits, rows.results.grades, rows.results.missed | rows.results.bounded, strict=True
        ):
            lost[said] += int(((grades == CHECK_GRADES.index("fail")) | missed).sum())
        lost[say("cannot be built")] += int(rows.results.infeasible.sum())
        if elsewhere:
            lost[say.name(elsewhere[0].quantity)] += rows.count
        told = _yield_message(np.concatenate(found), np.concatenate(margins), lost)
        told["commands"] = commands
        tell({"yield": told, "done": start + rows.count, "of": count})
    return told


def _parsed_deviation(typed: str, of: PermittedAdjustment, say: Translator) -> float:
    """Return a standard deviation that was typed; what is left empty does not scatter."""
    try:
        found = parse_localised_number(typed, decimal=say.decimal_sign) if typed.strip() else 0.0
        if found < 0:
            msg = "must be 0 or more"
            raise ValueError(msg)
    except ValueError as error:
        msg = f"{adjustable_parameter_phrase(of, say)}: {say.error(str(error))}, {typed!r}"
        raise CardanError(msg) from None
    return found


def _yield_message(of: IntArray, margins: FloatArray, lost: Counter[str]) -> Json:
    count, ends = of.size, np.linspace(-1, 1, 25)
    # What cannot be built has no margin, and less than any that does.
    left = np.clip(np.nan_to_num(margins, nan=-1.0), -1, 1)

    def share(hits: int) -> list[float | None]:
        return [
            round_decimals(v, 4)
            for v in (
                hits / count,
                *clopper_pearson_interval(hits, count, confidence=YIELD_CONFIDENCE),
            )
        ]

    return {
        "count": count,
        "shares": {v: share(int((of == k).sum())) for k, v in enumerate(VERDICTS)},
        "yield": share(int((of <= WORST_ACCEPTABLE_VERDICT_INDEX).sum())),
        "lost": [
            {"name": said, "share": round_decimals(n / count, 4)}
            for said, n in lost.most_common(6)
            if n
        ],
        "margins": round_decimals_list((ends[1:] + ends[:-1]) / 2, 3),
        "cases": [np.histogram(left[of == k], bins=ends)[0].tolist() for k in range(len(VERDICTS))],
    }

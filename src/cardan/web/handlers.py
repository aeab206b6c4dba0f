"""A document in, results out, as the front draws them: keys, numbers, arrays, names.

Nothing is remembered that could not be computed again: what is kept of the last documents saves
reading them twice. Lengths are in mm, angles in deg, as on the page; a value under a limit
is in the unit its quantity is shown in, and None where nothing is known.
"""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from itertools import islice
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from cardan.application import reader, source_location
from cardan.application.layout_writer import FileChanges
from cardan.application.yaml_edit import RawYaml
from cardan.approval.approval import approve_application
from cardan.approval.study import DRIVELINE_STUDY_NAME
from cardan.checks.line_response import LineResponse
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.errors import CardanError, DesignError, InvalidFileError
from cardan.core.labels import OperatingPoint
from cardan.core.units import deg, mm, rpm
from cardan.core.verdict import CHECK_GRADES, worst_first_key, worst_verdict
from cardan.documents.comparison import Variant, input_differences, limit_differences
from cardan.documents.first_screen import count_criteria_not_evaluated, criteria_grade_texts
from cardan.documents.inputs_table import input_rows
from cardan.model.application import InstalledLine
from cardan.physics.kinematics.equivalent_angle import ae7_phasor_terms
from cardan.physics.kinematics.joint_chain import rotate_chain, yoke_phases_as_if_all_crosses
from cardan.render.i18n import Translator
from cardan.render.phrases import (
    adjustment_phrase,
    note_sentences,
    unevaluated_limit_lines,
    verdict_text,
)
from cardan.topics.design.drag_handles import (
    HANDLE_KINDS,
    DragHandle,
    drag_handles_of,
    input_changes_for_drag,
)
from cardan.topics.design.phrases import worst_side_effect
from cardan.topics.design.sensitivity import AdjustmentEffect, CheckSensitivity, check_sensitivities
from cardan.topics.design.suspension_travel import (
    TravelRange,
    drive_mode_of_torque,
    line_at_axle_position,
    line_at_operating_point,
)
from cardan.web import bracket_handlers as seated
from cardan.web import correction_handlers as changes
from cardan.web import form_handlers as guides
from cardan.web import library, revisions
from cardan.web import limit_handlers as limits
from cardan.web import recording_handlers as heard
from cardan.web import script_export as script
from cardan.web import speed_handlers as speeds
from cardan.web.correction_handlers import OPERATING_POINT_QUANTITIES
from cardan.web.limit_messages import (
    deciding_state_index,
    evaluated_limits,
    graded_values,
    limit_id,
    limit_rows,
    pending_limits,
)
from cardan.web.line_messages import (
    layout_message,
    line_message,
    moving_numbers,
    obstacle_message,
    phasor_numbers,
    state_row,
)
from cardan.web.parsed_document import (
    Json,
    ParsedDocument,
    PartialResultCallback,
    check_to_json,
    parse_document,
    round_decimals,
    round_decimals_list,
    round_significant,
    with_relative_file_names,
)

TRAVEL_CURVE_POINTS = 61
"""Places of a slider that its curves are drawn through."""
SHAFT_TURN_CURVE_POINTS = 72
"""Points of a turn that the dial's curves are drawn through."""
YOKE_PHASE_CURVE_POINTS = 37
"""Yoke phases from 0 to 180 deg that the dial's sum is drawn for."""


MAX_ENTRIES_TRIED_FOR_HIDDEN_EFFECT = 40
"""Entries that are written otherwise and tried one by one: more of them show somewhere."""

BRAKING_WINDUP_KIND = "windup brake"
WINDUP_KINDS = ("windup", BRAKING_WINDUP_KIND)
"""Kinds of states that stand as their torque winds the axle up; others stand without."""

JOBS_DURING_DRAGGING = ("held", "graded")
"""Requests sent while a handle is dragged, each with a queue of its own."""


def _ignore_progress(_: Json) -> None:
    """Ignore progress."""


def handle_request(question: Json, tell: PartialResultCallback = _ignore_progress) -> Json:
    """Return the answer to a question; what is wrong with its document is an answer too.

    A job that takes long reports its progress.
    """
    folder = Path(question["folder"]) if question.get("folder") else None
    text, name = question["text"], question["name"]
    say = Translator(question["lang"]).with_minus_sign
    try:
        read = parse_document(text, name, folder)
        edits = _edits(read, question)
        if edits:
            read = read.with_edits(edits, held=question["job"] in JOBS_DURING_DRAGGING)
            text = read.text
        if question["job"] in _DOCUMENT_HANDLERS:
            found = _DOCUMENT_HANDLERS[question["job"]](read, question, say, tell)
        else:
            found = _JOB_HANDLERS[question["job"]](read, question["args"], say, tell)
    except CardanError as error:
        wrong = _problem_rows(error, text, name, folder, say)
        if question["job"] == "guided":
            # Of the excerpt that was made: the user of the form wrote no point in it.
            made = [p for p in wrong if p["line"]]
            for p in made:
                p |= {key: say.localise_numbers(p[key]) for key in ("message", "hint", "value")}
        return {"text": text, "problems": wrong}
    return {"text": text, "edits": edits, **found}


def referenced_file_stamps(question: Json, text: str) -> list[list[str | int]]:
    """Return the files that a text just answered of names, each with what it was, as stamped."""
    folder = Path(question["folder"]) if question.get("folder") else None
    return [
        [str(b.path), *b.stamp]
        for b in parse_document(text, question["name"], folder).referenced_files
    ]


def _problem_rows(
    error: CardanError, text: str, name: str, folder: Path | None, say: Translator
) -> list[Json]:
    """Return what is wrong with a document in the language, each with its place.

    Files of its folder go by their names there.
    """

    def told(said: str) -> str:
        return with_relative_file_names(say.error(said), folder)

    if isinstance(error, InvalidFileError):
        keys = ("key", "line", "column")
        of = Path(error.file)
        beside = f"{of.name}: " if folder and of.is_relative_to(folder) else ""
        return [
            {k: getattr(p, k) for k in keys}
            | {
                "message": f"{beside}{told(p.message)}",
                "hint": told(p.hint),
                "value": told(p.value),
            }
            for p in error.problems
        ]
    line = column = 0
    key = ""
    with suppress(CardanError):
        about = error.about if isinstance(error, DesignError) else ""
        if about and (
            found := source_location.locate_yaml_address(
                parse_document(text, name, folder).application, about
            )
        ):
            line, column, key = found.line, found.column, found.key
    return [{"message": told(str(error)), "key": key, "value": "", "hint": "", "line": line,
             "column": column}]  # fmt: skip


def _edits(read: ParsedDocument, question: Json) -> FileChanges:
    """Return the changes that a question makes to its document: by address, or by hand."""
    edits: FileChanges = dict(question.get("edits") or {})
    if drag := question.get("drag"):
        handle = DragHandle(kind=drag["kind"], number=drag["number"], line=drag["line"], axes="")
        assert handle.kind in HANDLE_KINDS
        by = np.array(drag["by_mm"], dtype=float) * mm
        edits |= input_changes_for_drag(read.application, handle, by, read.manuscript)
    return edits


# --------------------------------------------------------------------------- requests


def _live_result(
    read: ParsedDocument, question: Json, say: Translator, _: PartialResultCallback
) -> Json:
    """Return all that follows a change at once: lines, limits that need no operating points.

    Of a campaign it is what that names.
    """
    if of := read.recording_campaign:
        return {"campaign": heard.campaign_overview(of, say)}
    app = read.application
    rows = [row for r in read.responses for row in limit_rows(r, say)]
    return {
        "title": app.title,
        "profile": app.profile,
        "states": [state_row(read.responses[0], s, say) for s in range(len(app.states))],
        "worst": deciding_state_index(read.responses[0]),
        "lines": [line_message(r, read.manuscript, say) for r in read.responses],
        "obstacles": [obstacle_message(o) for o in app.obstacles],
        "handles": _handle_rows(read),
        "limits": rows,
        "pending": [row for r in read.responses for row in pending_limits(r, say)],
        "grade": _worst_grade(rows),
        "warnings": [
            {"message": say.error(p.message), "key": p.key, "hint": say.error(p.hint),
             "line": p.line, "column": p.column, "value": say.error(p.value)}
            for p in app.warnings
        ],
        **_pose_with_curves(read, question, say),
    }  # fmt: skip


def _dragged_line(
    read: ParsedDocument, question: Json, say: Translator, _: PartialResultCallback
) -> Json:
    """Return the numbers of the shown line that follow a hand."""
    shown = read.responses[_shown_line_index(read, question)]
    return {
        "lines": [{"name": shown.line.name, **moving_numbers(shown)}],
        "obstacles": [obstacle_message(o) for o in read.application.obstacles],
        **_pose_with_curves(read, question, say),
    }


def _dragged_limits(
    read: ParsedDocument, _: Json, __: Translator, ___: PartialResultCallback
) -> Json:
    """Return the numbers of the limits that follow a hand."""
    asked_of = [
        (limit_id(r, a.limit, k), a) for r in read.responses for k, a in evaluated_limits(r)
    ]
    told = graded_values([a for _, a in asked_of])
    rows = [{"id": name, **row} for (name, _), row in zip(asked_of, told, strict=True)]
    return {"limits": rows, "grade": _worst_grade(rows)}


def _shown_line_index(read: ParsedDocument, question: Json) -> int:
    """Return which line the page shows."""
    line = int((question.get("pose") or {}).get("line", 0))
    return min(max(line, 0), len(read.responses) - 1)


def _worst_grade(rows: list[Json]) -> str | None:
    """Return the worst grade of some limits; None where none has a value."""
    grades = {g for row in rows for s in row["grades"] for g in s if g is not None}
    return worst_verdict([CHECK_GRADES[g] for g in grades]) if grades else None


def _handle_rows(read: ParsedDocument) -> list[Json]:
    return [
        {"kind": h.kind, "number": h.number, "line": h.line, "ways": h.axes}
        for h in drag_handles_of(read.application, read.manuscript)
    ]


def _pose_result(
    read: ParsedDocument, question: Json, say: Translator, _: PartialResultCallback
) -> Json:
    """Return a line where a slider has it, and what its curves are."""
    return _pose_with_curves(read, question, say)


def _full_result(read: ParsedDocument, _: Json, say: Translator, __: PartialResultCallback) -> Json:
    """Return the verdict, and the limits that are sought over all operating points."""
    found = approve_application(read.application)
    others = [c for f in found.study_results if f.study != DRIVELINE_STUDY_NAME for c in f.checks]
    return {
        "verdict": found.verdict,
        "headline": verdict_text(found, say),
        "counted": criteria_grade_texts(found, say),
        "missed": count_criteria_not_evaluated(found),
        "unanswered": unevaluated_limit_lines(found, say),
        "notes": note_sentences(found, say),
        "limits": [
            row
            for r in found.line_responses
            for row in limit_rows(r, say, OPERATING_POINT_QUANTITIES)
        ],
        "others": [check_to_json(c, found, say) for c in sorted(others, key=worst_first_key)],
    }


def _helpful_adjustments(
    read: ParsedDocument, _: Json, say: Translator, __: PartialResultCallback
) -> Json:
    """Return what moving things does to each limit that does not pass, as edits to apply."""
    found = approve_application(read.application)
    helps: list[Json] = []
    for one in check_sensitivities(found):
        installed = next(i for i in read.application.lines if i.line.name == one.check.line)
        told = (e for e in one.helpful_effects if isfinite(one.best_adjustment(e)[1]))
        bars = [_adjustment_effect(read, installed, one, e, say) for e in told]
        helps.append({**check_to_json(one.check, found, say), "bars": bars})
    return {"helps": helps}


def _prepare_drag(
    read: ParsedDocument, _: Json, __: Translator, ___: PartialResultCallback
) -> Json:
    """Return nothing; the next drag request on this document need not wait for it."""
    for r in read.responses:
        list(evaluated_limits(r))
    return {}


_DOCUMENT_HANDLERS = {
    "live": _live_result,
    "held": _dragged_line,
    "graded": _dragged_limits,
    "ready": _prepare_drag,
    "pose": _pose_result,
    "full": _full_result,
    "help": _helpful_adjustments,
}


def _background_variant(
    read: ParsedDocument, _: Json, __: Translator, ___: PartialResultCallback
) -> Json:
    """Return where another variant's lines run, to be drawn behind this one's."""
    lines = [
        {
            "name": r.line.name,
            "states": {
                name: layout_message(r.layout[s], r.demand.installed)
                for s, name in enumerate(r.demand.states)
            },
            "angles": {
                name: round_decimals_list(r.joint_angles[s] / deg, 3)
                for s, name in enumerate(r.demand.states)
            },
        }
        for r in read.responses
    ]
    return {"lines": lines}


def _compare_variants(
    read: ParsedDocument, args: Json, say: Translator, tell: PartialResultCallback
) -> Json:
    """Return variants next to the text itself: verdicts, what they say and what it does.

    Of the `same` file also what no row shows as it is rounded; of a campaign all that is written
    otherwise, and the lives of those that have been evaluated.
    """
    given = args.get("variants", [])
    first = "" if args.get("same", True) else read.name
    named = [
        (first, read),
        *((v["name"], parse_document(v["text"], v["name"], read.folder)) for v in given),
    ]
    texts = [one.manuscript for _, one in named]
    every = dict.fromkeys(at for of in texts for at in of.addresses)
    rows = ((at, [of.scalar_text(at) or "-" for of in texts]) for at in every)
    written = {at: said for at, said in rows if len(set(said)) > 1}
    beside = {at: [one.referenced_paths(at) for _, one in named] for at in written}
    beside = {at: of for at, of in beside.items() if all(of)}
    contents = [
        row for at, of in beside.items() for row in _changed_file_rows(at, written[at], of, say)
    ]
    if read.recording_campaign:
        lives: list[dict[str, str]] = args.get("lives", [])
        gauges = dict.fromkeys(gauge for life in lives for gauge in life)
        return {
            "variants": [
                {"name": name, "verdict": None, "headline": "", "counted": {}} for name, _ in named
            ],
            "differences": [
                *({"name": at, "values": of} for at, of in written.items() if at not in beside),
                *contents,
            ],
            "effects": [
                {
                    "name": f"{gauge}: {say('hours to failure')}",
                    "values": [life.get(gauge, "-") for life in lives],
                    "grades": [None] * len(lives),
                }
                for gauge in gauges
            ],
        }
    found: list[Variant] = []
    for k, (name, one) in enumerate(named):
        tell({"doing": name, "done": k, "of": len(named)})
        found.append(Variant(name=name, approval=approve_application(one.application)))
    return {
        "variants": [
            {
                "name": v.name,
                "verdict": v.approval.verdict,
                "headline": verdict_text(v.approval, say),
                "counted": criteria_grade_texts(v.approval, say),
            }
            for v in found
        ],
        "differences": [
            *(
                {"name": d.name, "values": d.values}
                for d in input_differences(found, say)
                if d.name.rpartition(": ")[2] not in beside
            ),
            *(
                {"name": at, "values": of}
                for at, of in islice(written.items(), MAX_ENTRIES_TRIED_FOR_HIDDEN_EFFECT)
                if args.get("same", True)
                and at not in beside
                and _has_no_visible_effect(read, at, of, say)
            ),
            *contents,
        ],
        "effects": [
            {"name": e.name, "values": e.values, "grades": e.grades}
            for e in limit_differences(found, say)
        ],
    }


def _changed_file_rows(
    at: str, said: list[str], paths: list[list[Path]], say: Translator
) -> Iterator[Json]:
    """Give the row of a file that texts name at an address, where it is not the same one.

    One that a revision keeps counts as it was when that was released.
    """
    holds = {tuple(map(revisions.released_checksum, of)) for of in paths}
    if len(holds) > 1 or None in next(iter(holds)):
        values = [_file_status(text, of[0], say) for text, of in zip(said, paths, strict=True)]
        yield {"name": say("{key}: other contents", key=at), "values": values}


def _file_status(said: str, path: Path, say: Translator) -> str:
    """Return how a file is called, and whether it is there as it was when it was released."""
    now = revisions.current_checksum(path)
    if now is None:
        return say("{file}: is no longer there", file=said)
    return (
        said
        if now == revisions.released_checksum(path)
        else say("{file}: overwritten since", file=said)
    )


def _has_no_visible_effect(
    read: ParsedDocument, at: str, written: list[str], say: Translator
) -> bool:
    """Return whether inputs stay as they are where one entry is as others write it.

    What cannot be another by itself comes with others, which show.
    """
    tried: list[bool] = []
    for value in {*written} - {"-", read.manuscript.scalar_text(at)}:
        with suppress(CardanError):
            text = read.manuscript.with_changes({at: RawYaml(value)})
            other = reader.loads(text, name=read.name, folder=read.folder, warn=False)
            tried.append(input_rows(other, say) == input_rows(read.application, say))
    return bool(tried) and all(tried)


_JOB_HANDLERS = {
    "recording": heard.inspect_upload,
    "life": heard.analyse_upload,
    "drive": heard.inspect_campaign_recording,
    "campaign": heard.campaign_result,
    "bracket": seated.assess_bracket,
    "library": library.file_statuses,
    "report": library.export_report,
    "script": script.session_script,
    "limits": limits.list_limits,
    "deviate": limits.draft_with_limit_deviation,
    "fix": changes.propose_corrections,
    "map": changes.margin_map,
    "moved": changes.edits_for_adjustment_amounts,
    "yield": changes.production_yield,
    "ghost": _background_variant,
    "compare": _compare_variants,
    "guided": guides.preview_new_application_form,
    "pasted": guides.edits_for_pasted_points,
    "speeds": speeds.forces_over_speed,
    "torsion": speeds.vehicle_torsion,
}


def _adjustment_effect(
    read: ParsedDocument,
    installed: InstalledLine,
    of: CheckSensitivity,
    effect: AdjustmentEffect,
    say: Translator,
) -> Json:
    """Return what one move does to a check, what it spoils, and the edits that make it."""
    moved, value = of.best_adjustment(effect)
    return {
        "said": adjustment_phrase(moved, say),
        "spoilt": worst_side_effect(effect, say),
        "value": round_significant(value / QUANTITIES[of.check.quantity].si_factor),
        "gain": round_significant(of.best_margin_gain(effect)),
        "edits": changes.edits_for_adjustments(read, installed.line.name, [moved]),
    }


# --------------------------------------------------------------------------- sliders and dial


def _pose_with_curves(read: ParsedDocument, question: Json, say: Translator) -> Json:
    """Return where sliders have a line, their reach and curves, and its turn; or why not.

    While a hand moves, curves that stand still meanwhile are left for later: not wanted.
    """
    asked_for: Mapping[str, Any] = question.get("pose") or {}
    wanted = question.get("want", ("curves", "turn"))
    travel, torque = asked_for.get("travel_mm"), asked_for.get("torque_Nm")
    free = travel is not None or torque is not None
    if not (free or wanted):
        return {}
    place_ = _shown_line_index(read, question)
    r = read.responses[place_]
    s = asked_for.get("state")
    s = deciding_state_index(r) if s is None else min(max(int(s), 0), len(r.demand.states) - 1)
    reaches = read.travel_ranges[place_]
    low, high = reaches.travel
    height = float(r.demand.travel[s]) if travel is None else float(np.clip(travel * mm, low, high))
    # A state stands unwound, but for one that is wound up by its torque.
    own = (
        float(np.nan_to_num(r.demand.torque[s]))
        if r.state_kinds[s] in WINDUP_KINDS and not free
        else 0.0
    )
    turned = float(np.clip(own if torque is None else torque, *reaches.torque))
    braked = (
        asked_for.get("way") == "brake" and reaches.brake_windup_known
        if free
        else r.state_kinds[s] == BRAKING_WINDUP_KIND
    )
    turned = min(turned, 0.0) if braked else turned
    posed: Json = {
        "line": place_,
        "state": None if free else s,
        "travel": round_decimals(height / mm, 2),
        "torque": round_decimals(turned, 0),
        "way": "brake" if braked else drive_mode_of_torque(r, turned),
        "brakes": reaches.brake_windup_known,
        "travel_reach": [round_decimals(t / mm, 1) for t in reaches.travel],
        "torque_reach": [round_decimals(t, 0) for t in reaches.torque],
    }
    shown, k = r, s
    try:
        if free:
            if asked_for.get("way") and travel is None:
                posed["way"] = asked_for["way"]
                shown, k = (
                    line_at_operating_point(r, OperatingPoint("", posed["way"], 0.0, turned)),
                    s,
                )
                height = float(shown.demand.travel[s])
                posed["travel"] = round_decimals(height / mm, 2)
            else:
                app, of = read.application, r.demand.installed
                shown, k = (
                    line_at_axle_position(app, of, travel=[height], torque=turned, brakes=braked),
                    0,
                )
            posed["at"] = _axle_position_message(shown, k, r)
        if "curves" in wanted:
            posed |= _slider_curves(read, r, reaches, height, turned, brakes=braked)
    except DesignError as error:
        posed["stuck"] = say.error(str(error))
        shown, k = r, s
    if "turn" in wanted:
        posed["turn"] = _turn_curves(shown, k)
    return {"pose": posed}


def _axle_position_message(r: LineResponse, s: int, base: LineResponse) -> Json:
    """Return a line in one place of its axle."""
    return {
        "laid": layout_message(r.layout[s], r.demand.installed),
        "angles": round_decimals_list(r.joint_angles[s] / deg, 3),
        "side_angles": round_decimals_list(r.kinematics.side_angles[s] / deg, 3),
        "top_angles": round_decimals_list(r.kinematics.top_angles[s] / deg, 3),
        "positions": round_decimals_list(r.kinematics.joint_plane_positions[s] / deg, 1),
        "side": round_decimals_list(r.layout.side[s] / deg, 3),
        "top": round_decimals_list(r.layout.top[s] / deg, 3),
        "lengths": round_decimals_list(r.layout.lengths[s] / mm, 1),
        "plunge": round_decimals(float(r.clearances.spline_travel[s]) / mm, 4),
        "clearance": round_decimals_list(r.clearances.obstacle_clearances[s] / mm, 4),
        "phasors": phasor_numbers(r)[s],
        "equivalent": round_decimals(float(r.kinematics.excitation.torsional.angle[s]) / deg, 3),
        "pitch": round_decimals(
            float(r.layout.side[s, -1] - base.demand.installed.layout.side[-1]) / deg, 3
        ),
    }


def _slider_curves(
    read: ParsedDocument,
    r: LineResponse,
    of: TravelRange,
    height: float,
    torque: float,
    *,
    brakes: bool,
) -> Json:
    """Return what follows each slider while the other stays."""
    app, installed = read.application, r.demand.installed
    found: Json = {}
    most = min(of.torque[1], 0.0) if brakes else of.torque[1]
    for name, ends, unit in (("travel", of.travel, mm), ("torque", (of.torque[0], most), 1.0)):
        if not ends[1] > ends[0]:
            continue
        along = np.linspace(*ends, TRAVEL_CURVE_POINTS)
        at = {"travel": height, "torque": torque} | {name: along}
        over = line_at_axle_position(
            app,
            installed,
            travel=np.broadcast_to(at["travel"], along.shape),
            torque=at["torque"],
            brakes=brakes,
        )
        clear = (
            over.clearances.obstacle_clearances.min(axis=(-1, -2))
            if over.inputs.obstacles
            else None
        )
        found[f"over_{name}"] = {
            "x": round_decimals_list(along / unit, 1),
            "angles": round_decimals_list(over.joint_angles.T / deg, 3),
            "equivalent": round_decimals_list(over.kinematics.excitation.torsional.angle / deg, 3),
            "plunge": round_decimals_list(over.clearances.spline_travel / mm, 2),
            "clearance": None if clear is None else round_decimals_list(clear / mm, 2),
        }
    return found


def _turn_curves(r: LineResponse, s: int) -> Json:
    """Return speed of every member round the turn, and the sum over the phase of each shaft."""
    layout, phases = r.layout, np.asarray(r.phases, dtype=float)
    one = rotate_chain(
        layout.directions[s],
        phases=phases,
        crosses=r.line.is_cross,
        samples=SHAFT_TURN_CURVE_POINTS,
    )
    swept = np.linspace(0.0, np.pi, YOKE_PHASE_CURVE_POINTS)
    side, top, _ = r.kinematics.phasor_angles
    over: list[Any] = []
    for k in range(phases.shape[-1]):
        tried = np.tile(phases, (YOKE_PHASE_CURVE_POINTS, 1))
        tried[:, k] = swept
        terms = ae7_phasor_terms(
            side[s], top[s], phases=yoke_phases_as_if_all_crosses(tried, r.line.is_cross)
        )
        over.append(round_decimals_list(np.sqrt(np.abs(terms.sum(-1))) / deg, 3))
    speed = float(np.nan_to_num(r.demand.speed[s])) / rpm
    return {
        "theta": round_decimals_list(np.linspace(0, 360, SHAFT_TURN_CURVE_POINTS + 1), 1),
        "speed": round_decimals_list(
            100 * (np.concatenate([one.speed, one.speed[:, :1]], axis=-1) - 1), 4
        ),
        "rpm": round_decimals(speed, 0),
        "phases": round_decimals_list(swept / deg, 1),
        "over_phase": over,
    }

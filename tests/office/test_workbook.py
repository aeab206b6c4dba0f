"""The workbook recomputed by LibreOffice against `cardan`, unchanged and with changed inputs.

Both compute in double precision from the same numbers; formulas of a few dozen operations
agree to 1e-9 of the size of what is computed. Forces and phasors are sums in which large
terms cancel, so they are held to that share of the largest among the states.
"""

import json
import re
import sys
from dataclasses import replace
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest
from one_verdict import Case, cases, limit, made_up_bracket, put, read, verdict_of_headline

from cardan.application import duty_cycles, reader, templates
from cardan.approval.approval import approve_driveline
from cardan.approval.driveline_study import evaluate_limits
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.labels import WHOLE_LINE
from cardan.core.units import deg, mm, rpm
from cardan.core.verdict import CHECK_GRADES, GRADE_TEXTS, worst_verdict
from cardan.documents import approval_json as contract
from cardan.documents.workbook import workbook_bytes
from cardan.model.layout import layout_from_slopes
from cardan.model.parts import Tube
from cardan.render.i18n import LANGUAGE_CODES, Translator
from cardan.render.xlsx import FIRST_STATE_COLUMN

sys.path.insert(0, str(Path(__file__).parent))
from spreadsheet import Sheet, recalculated

pytestmark = pytest.mark.office

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.yaml"))
STARTERS = ("small", "truck")
HAND = Path(__file__).parents[1] / "verify/by_hand.yaml"
SPENT = {
    "points": "[{share_percent: 30, torque_Nm: 8000, speed_rpm: 300},"
    " {share_percent: 70, torque_Nm: 1500, speed_rpm: 1500, angle_deg: 5}]",
    "cycle": "construction",
}
"""Duties of a tandem, whose second line carries half the torque, but all behind a locked
differential at times; and of the truck that is
calculated by hand, whose second line turns faster too."""


def lasting():
    """Applications with two lines and a duty, in points and by name."""
    tandem = (EXAMPLES[0].parent / "tandem-6x4.yaml").read_text(encoding="utf-8")
    hand = reader.read(HAND)
    for what, duty in SPENT.items():
        yield f"tandem-{what}", reader.loads(f"{tandem}\nduty: {duty}\n")
        locked = "inter_axle: {torque_split: 0.5, locked: true}"
        yield f"tandem-locked-{what}", reader.loads(f"{tandem}\n{locked}\nduty: {duty}\n")
    yield "hand-points", hand
    yield "hand-cycle", replace(hand, duty=(), duty_cycle=duty_cycles.load_duty_cycle("long-haul"))


def applications():
    for path in EXAMPLES:
        yield path.stem, reader.read(path)
    for kind in STARTERS:
        yield kind, reader.loads(templates.template_text(kind))
    yield from lasting()


def expected(r: LineResponse) -> dict[str, np.ndarray]:
    """What the workbook's named rows must hold, in their units, for each state."""
    n, ae7 = r.line.joint_count, r.kinematics.approximate_excitations["ae7"]
    static, dynamic = r.rigid_loads.small_angle_bearing_forces
    found = {
        "torque": r.demand.torque,
        "speed": r.demand.speed / rpm,
        "equivalent_angle": ae7.torsional.angle / deg,
        "torsional_acceleration": ae7.torsional.acceleration,
        "inertia_drive_acceleration": ae7.drive.acceleration,
        "inertia_coast_acceleration": ae7.coast.acceleration,
    }
    if ae7.drive_torque is not None:
        found["inertia_drive_torque"] = ae7.drive_torque
        found["inertia_coast_torque"] = ae7.coast_torque
    for k in range(n):
        found[f"joint_angle_joint_{k + 1}"] = r.joint_angles[:, k] / deg
        found[f"n_beta_joint_{k + 1}"] = r.demand.speed / rpm * r.joint_angles[:, k] / deg
        found[f"joint_life_joint_{k + 1}"] = r.strength.needle_bearing_life[:, k] / 3600
    for k in range(2):  # AE-7 makes it uneven further back
        found[f"joint_torque_utilisation_joint_{k + 1}"] = r.strength.joint_torque_utilisation[:, k]
    for k in range(n - 2):
        found[f"centre_bearing_static_bearing_{k + 1}_small_angle"] = np.linalg.norm(
            static[:, k], axis=-1
        )
        found[f"centre_bearing_dynamic_bearing_{k + 1}_small_angle"] = dynamic[:, k]
    for k in range(n - 1):
        found[f"critical_speed_shaft_{k + 1}"] = r.strength.critical_speeds[:, k] / rpm
        found[f"critical_speed_ratio_shaft_{k + 1}"] = (
            r.inputs.reached_speed / r.strength.critical_speeds[:, k]
        )
        found[f"tube_shear_utilisation_shaft_{k + 1}"] = r.strength.tube_shear_utilisation[:, k]
    return {name: values for name, values in found.items() if np.isfinite(values).any()}


def held(sheet: Sheet, r: LineResponse, tag: str, *, without: tuple[str, ...] = ()) -> int:
    """Hold every named row of a line against cardan; return how many numbers were held."""
    numbers = 0
    for name, values in expected(r).items():
        if name.startswith(without):
            continue
        of_sheet = np.array([np.nan if v in (None, "") else v for v in sheet.numbers(tag + name)])
        scale = np.nanmax(np.abs(values))
        np.testing.assert_allclose(
            of_sheet, values, rtol=1e-9, atol=1e-9 * scale, err_msg=f"{sheet.path.stem}: {name}"
        )
        numbers += len(values)
    return numbers


def tag_of(found, r):
    name = r.line.name.replace("-", "_").replace(" ", "_")
    return f"{name}_" if len(found.line_responses) > 1 else ""


def changed(r: LineResponse, rng: np.random.Generator) -> tuple[dict[str, list], LineResponse]:
    """Other angles, lengths, torques, speeds, tubes and phases: as typed in, and as computed."""
    states, n = len(r.demand.states), r.line.joint_count
    side = r.layout.side / deg + rng.uniform(-2, 2, (states, n + 1))
    top = r.layout.top / deg + rng.uniform(-2, 2, (states, n + 1))
    lengths = r.layout.lengths / mm * rng.uniform(0.9, 1.1, (states, n - 1))
    torque, speed = rng.uniform(500, 9000, states), rng.uniform(800, 3000, states)
    share = r.demand.installed.torque_ratio * r.demand.installed.torque_share
    phases = rng.choice([0, 90, 12.5], n - 1).astype(float)
    shafts = []
    outers, walls = rng.uniform(80, 130, n - 1), rng.uniform(2.5, 6, n - 1)
    for s, phase, outer, wall in zip(r.line.shafts, phases, outers, walls, strict=True):
        tube = s.tube  # plies stay as thick as they are
        if isinstance(tube, Tube):
            tube = replace(tube, outer=outer * mm, wall=wall * mm)
        inertia = s.polar_inertia
        shafts.append(replace(s, phase=phase * deg, tube=tube, polar_inertia_given=inertia or None))
    line = replace(r.line, shafts=tuple(shafts))
    typed = {f"side_{k}": side[:, k].tolist() for k in range(n + 1)}
    typed |= {f"top_{k}": top[:, k].tolist() for k in range(n + 1)}
    typed |= {f"length_{k + 1}": lengths[:, k].tolist() for k in range(n - 1)}
    typed |= {"state_torques": torque.tolist(), "state_speeds": speed.tolist()}
    typed |= {"yoke_phases": phases.tolist()}
    tubes = [s.tube for s in line.shafts]
    typed["tube_outer"] = [t.outer / mm if t else None for t in tubes]
    typed["tube_wall"] = [t.wall / mm if t else None for t in tubes]
    demand = replace(
        r.demand,
        installed=replace(r.demand.installed, line=line),
        torque=torque * share,
        speed=speed * rpm * r.demand.installed.speed_ratio,
    )
    layout = layout_from_slopes(side=side * deg, top=top * deg, lengths=lengths * mm)
    application = replace(r.application, include_gravity=False)
    return typed, compute_line_response(
        application, demand, lay=lambda _: layout, phases=line.phases
    )


@pytest.fixture(scope="module")
def books(tmp_path_factory):
    """Every application's workbook recomputed, as written and with other inputs."""
    folder = tmp_path_factory.mktemp("books")
    cases, paths = {}, []
    rng = np.random.default_rng(3)
    for name, application in applications():
        found = approve_driveline(application)
        plain = folder / f"{name}.xlsx"
        plain.write_bytes(workbook_bytes(found, say=Translator("en")))
        sheet = Sheet(plain, values=False)
        others = []
        for r in found.line_responses:
            typed, other = changed(r, rng)
            for cell, values in typed.items():
                sheet.change(tag_of(found, r) + cell, values)
            for cell in list(sheet.book.defined_names):  # that line stays under torque
                if cell.startswith(f"{tag_of(found, r)}duty_more_"):
                    sheet.change(cell, [0.0] * len(r.inputs.duty_points))
            for k in range(r.line.joint_count - 2) if r.inputs.gravity else ():
                for axis in "xyz":
                    sheet.change(
                        f"{tag_of(found, r)}weight_{k + 1}_{axis}", [0.0] * len(r.demand.states)
                    )
            others.append(other)
        moved = folder / f"{name}-changed.xlsx"
        sheet.book.save(moved)
        cases[name] = (found, others)
        paths += [plain, moved]
    sheets = recalculated(paths, folder)
    return {
        name: (*case, sheets[2 * k], sheets[2 * k + 1])
        for k, (name, case) in enumerate(cases.items())
    }


LASTING = [f"{truck}-{what}" for truck in ("tandem", "hand") for what in SPENT]
NAMES = [*(p.stem for p in EXAMPLES), *STARTERS, *LASTING]
AS_COMPUTED = {"composite-van", "pick-up-4x4"}
"""Plies, and joints that are no crosses: what formulas of the workbook do not know stands there
as computed, and turns stale."""
LIVE = [name for name in NAMES if name not in AS_COMPUTED]


@pytest.mark.parametrize("name", LIVE)
def test_workbook_formulas_match_computed_responses(books, name):
    found, _, sheet, _ = books[name]
    for r in found.line_responses:
        assert held(sheet, r, tag_of(found, r)) > 10


@pytest.mark.parametrize("name", LIVE)
def test_workbook_results_follow_changed_inputs(books, name):
    found, others, _, sheet = books[name]
    for r in others:
        held(sheet, r, tag_of(found, r))


@pytest.mark.parametrize("name", LASTING)
def test_workbook_joint_life_matches_json_per_driveline(books, name):
    """Line by line what `cardan check --json` says: the second line's share of the torque and
    speed counts, and a named cycle is of what the line itself carries at most.

    Worst torque at top speed stood in place of a named cycle, and the gearbox's own torque in
    every line: 36 h where the contract says 9418, 2804 h where it says 28 258.
    """
    found, _, sheet, _ = books[name]
    states = json.loads(json.dumps(contract.json_document(found)))["states"]
    first, *others = found.line_responses
    held = 0
    for r in found.line_responses:
        own = [s if r is first else s["lines"][r.line.name] for s in states]
        for k in range(r.line.joint_count):
            hours = [s["joints"][k]["life_h"] for s in own]
            cells = sheet.numbers(f"{tag_of(found, r)}joint_life_joint_{k + 1}")
            assert [v or None for v in cells] == [h and pytest.approx(h, rel=1e-9) for h in hours]
            held += sum(h is not None for h in hours)
    assert others
    assert held > 10


@pytest.mark.parametrize("name", NAMES)
def test_workbook_has_no_error_cells(books, name):
    for sheet in books[name][2:]:
        for page in sheet.book:
            wrong = [c.coordinate for row in page.iter_rows() for c in row
                     if isinstance(c.value, str) and c.value.startswith(("#", "Err:"))]  # fmt: skip
            assert not wrong, f"{page.title}: {wrong}"


def test_workbook_defined_names_are_unique(tmp_path):
    """Excel repairs a file that names two cells alike; openpyxl and LibreOffice say nothing."""
    for name, application in applications():
        book = tmp_path / f"{name}.xlsx"
        book.write_bytes(workbook_bytes(approve_driveline(application), say=Translator("en")))
        xml = ZipFile(book).read("xl/workbook.xml").decode()
        names = re.findall(r'<definedName name="([^"]+)"', xml)
        assert len(names) > 30
        assert len(names) == len(set(names))


@pytest.mark.parametrize("name", NAMES)
def test_slip_torque_formula_follows_tyre_and_axle(books, name):
    """Engine and slip torque by their formulas, without a given torque."""
    found, _, sheet, _ = books[name]
    for r in found.line_responses:
        tag = tag_of(found, r)
        for row, values in (
            ("engine_torque", r.demand.engine_torque),
            ("slip_torque", r.demand.slip_torque),
        ):
            if np.isfinite(values).all():
                assert sheet.numbers(tag + row) == pytest.approx(values.tolist(), rel=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_workbook_verdicts_match_check(books, name):
    """Whatever stands in words is the same as written and recomputed: verdicts, row by row."""
    found, _, sheet, _ = books[name]
    written = Sheet(sheet.written, values=True)
    for book in (written, sheet):
        assert [*map(verdict_of_headline, book.numbers("verdict"))] == [found.verdict]
        assert book.numbers("changed_inputs") == [0]
    for page in sheet.book:
        for row in page.iter_rows():
            for cell in row:
                then = written.book[page.title][cell.coordinate].value
                if isinstance(then, str) or isinstance(cell.value, str):
                    assert (then or "") == (cell.value or ""), f"{page.title}: {cell.coordinate}"


GRADES_BY_TEXT = {text: grade for grade, text in GRADE_TEXTS.items()} | {"stale": "stale"}
"""Grades by what the English workbook calls them."""


def rows(sheet: Sheet, r: LineResponse, *, end: str) -> dict[tuple[str, str], list[str]]:
    """The verdicts of a line's rows of limits, by their labels and bounds."""
    page, at = sheet.book[f"Results{end}"[:31]], FIRST_STATE_COLUMN + len(r.demand.states) + 1
    found: dict[tuple, list[str]] = {}
    for row in page.iter_rows(max_col=at):
        label, verdict = row[0].value, row[-1].value
        if verdict in GRADES_BY_TEXT:
            grade = GRADES_BY_TEXT[verdict]
            found.setdefault((label, row[2].value, row[3].value), []).append(grade)
    return found


@pytest.mark.parametrize("name", LIVE)
def test_changed_inputs_update_live_rows_and_mark_others_stale(books, name):
    """Where formulas are exact, a row comes to what cardan's limits come to for those inputs."""
    found, others, _, sheet = books[name]
    assert sheet.numbers("changed_inputs")[0] > 3
    grades, say = set(), Translator("en")
    for r in others:
        end = f" {r.line.name}" if len(found.line_responses) > 1 else ""
        shown = rows(sheet, r, end=end)
        grades |= {v for vs in shown.values() for v in vs}
        for question in evaluate_limits(r):
            limit, q = question.limit, QUANTITIES[question.limit.quantity]
            if limit.quantity not in EXACT:
                continue
            for k, part in enumerate(question.parts):
                if not question.may_apply[:, k].any() or (
                    part == WHOLE_LINE and limit.quantity in WHIRL
                ):
                    continue
                values = question.own_point_values[:, k]  # live rows know no other point
                own = [limit.grade(v) for v in values[~np.isnan(values)]]
                label = say.join(say.name(q.key), "" if part == WHOLE_LINE else say.part(part))
                bounds = [b and pytest.approx(b / q.si_factor, rel=1e-12)
                          for b in limit.band or (limit.normal, limit.maximum)]  # fmt: skip
                got = [v for key, vs in shown.items() if key == (label, *bounds) for v in vs]
                assert got == ([worst_verdict(own)] if own else []), f"{label} {bounds}"
    worded = ("fail", "stale", "incomplete", "warn", "pass")
    verdict = next(v for v in worded if v in grades)
    (said,) = sheet.numbers("verdict")
    assert verdict_of_headline(said) == verdict.replace("stale", "stale: run cardan again")
    assert "stale" in grades or name in ALL_LIVE


@pytest.mark.parametrize("name", NAMES)
def test_criteria_sheet_ranks_as_check_does(books, name):
    """As exported every limit stands where it is worst, with the margin and grade of `check`."""
    found, _, sheet, _ = books[name]
    worst = {}
    for c in found.checks:
        key, order = (c.quantity, c.line, c.limit), (-CHECK_GRADES.index(c.grade), c.margin)
        worst[key] = min(worst.get(key, order), order)
    ranked = [
        (row[10].value, row[6].value) for row in sheet.book["Criteria"].iter_rows()
        if isinstance(row[10].value, float)
    ]  # fmt: skip
    grades = [round(-rank / 10_000) - 1 for rank, _ in sorted(ranked)]
    assert grades == [-grade for grade, _ in sorted(worst.values())]
    margins = np.array([margin for _, margin in sorted(ranked)])
    expected = np.minimum([margin for _, margin in sorted(worst.values())], 1e99)
    np.testing.assert_allclose(margins, expected, rtol=1e-9, atol=2e-9)


def front(sheet: Sheet) -> list[list]:
    """The rows of the first sheet, without what is empty."""
    cells = [[c.value for c in row if c.value is not None] for row in sheet.book["Front"].rows]
    return [row for row in cells if row]


VAN = next(p for p in EXAMPLES if p.stem == "van")
STALE_MARK = "stale: computed for the inputs as exported"


def test_front_follows_changed_inputs_or_says_that_it_is_stale(tmp_path):
    """The van's gearbox slope from 5.2 to 7.2 deg, another torque in wind-up, another limit.

    Over a verdict that followed the front kept a margin of -66 % and 497.2 rad/s² as exported.
    """
    found = approve_driveline(reader.read(VAN))
    (r,) = found.line_responses
    plain = tmp_path / "plain.xlsx"
    plain.write_bytes(workbook_bytes(found, say=Translator("en")))
    winds = r.demand.states.index("windup")
    torque, pinion = ([None] * len(r.demand.states) for _ in range(2))
    torque[winds], pinion[winds] = 2000.0, 5.5
    paths = [plain]
    for name, typed in {
        "slope": {"side_0": [7.2] * len(torque)},
        "torque": {"state_torques": torque},
        "both": {"state_torques": torque, "side_2": pinion},
    }.items():
        sheet = Sheet(plain, values=False)
        for key, values in typed.items():
            sheet.change(key, values)
        paths.append(tmp_path / f"{name}.xlsx")
        sheet.book.save(paths[-1])
    plain, slope, wound, both = recalculated(paths, tmp_path)

    # As exported: what cardan found.
    at = [row[0] for row in front(plain)].index("What decides")
    first = front(plain)[at + 1]
    assert first[:2] == ["Torsional acceleration", "axle wind-up (braking)"]
    assert first[-2:] == [pytest.approx(found.smallest_margin), "beyond recommended"]
    assert STALE_MARK not in str(front(plain))

    # Another slope: AE-7 of that slope decides, and the rest is marked.
    side = r.layout.side + np.array([2 * deg, 0, 0])
    layout = layout_from_slopes(side=side, top=r.layout.top, lengths=r.layout.lengths)
    moved = compute_line_response(
        replace(r.application, include_gravity=False), r.demand, lay=lambda _: layout,
        phases=r.line.phases,
    )  # fmt: skip
    shaken = moved.kinematics.approximate_excitations["ae7"].torsional.acceleration
    riding = [k for k, kind in enumerate(r.state_kinds) if kind != "full rebound"]
    worst = max(riding, key=lambda k: shaken[k])
    rows = front(slope)
    assert ["Verdict", "NOT APPROVED"] in rows
    assert ["smallest margin", "far beyond"] in rows
    assert rows[at + 1] == [
        "Torsional acceleration", Translator("en").state(r.demand.states[worst]),
        pytest.approx(shaken[worst]), "≤", 500, "rad/s²", "far beyond", "exceeded",
    ]  # fmt: skip
    assert 1030 < shaken[worst] < 1040
    assert sum(STALE_MARK in row for row in rows) == 4  # counts, coverage, drawing, charts

    # Another torque in wind-up: the joint's rating follows, the geometry there says it does not.
    used = 2000 * r.application.shock_factor / r.joint_sizes[0].peak_torque
    assert wound.numbers("joint_torque_utilisation_joint_1")[winds] == pytest.approx(used)
    assert front(wound)[at + 1][0] == "Joint torque / elastic limit, joint 1"
    assert wound.numbers("joint_angle_joint_2")[winds] == "stale"
    assert wound.numbers("geometry_of_other_torque") == np.eye(len(torque))[winds].tolist()
    assert both.numbers("geometry_of_other_torque") == [0] * len(torque)
    assert both.numbers("joint_angle_joint_2")[winds] == pytest.approx(
        abs(5.5 - np.degrees(r.layout.side[winds, 1])), rel=1e-9
    )


ALL_LIVE = ("small", "three-joint-chain")
"""Applications whose limits ask nothing that only cardan computes."""

EXACT = {
    "joint_angle", "joint_angle_min", "compound_angle", "angle_for_speed", "n_beta", "torque",
    "end_angle_difference", "odd_joint_angle", "critical_speed", "tube_shear_utilisation",
    "joint_life", "speed", "critical_speed_ratio", "half_critical_band", "joint_torque_utilisation",
}  # fmt: skip
"""What formulas say as exactly as cardan, of every part that limits may ask about."""

WHIRL = {"critical_speed_ratio", "half_critical_band"}
"""Of these, what is so of the shafts alone: the line as beams only cardan knows."""


# --------------------------------------------------------------------------- one verdict


def changed_by(case: Case, path: Path) -> Path:
    """A case's workbook with one input changed that no limit of it depends on."""
    sheet = Sheet(path, values=False)
    (tag,) = {n.removesuffix("polar_inertias") for n in sheet.book.defined_names
              if n.endswith("polar_inertias")}  # fmt: skip
    now = sheet.numbers(f"{tag}polar_inertias")
    if "inertia" in case.quantity:  # it depends on those: next to nothing else on this
        sheet.change("tyre_radius", [sheet.numbers("tyre_radius")[0] + 1e-4])
    else:
        sheet.change(f"{tag}polar_inertias", [v + 1e-4 for v in now])
    moved = path.with_stem(f"{path.stem}-changed")
    sheet.book.save(moved)
    return moved


@pytest.fixture(
    scope="module", params=["every eighth", pytest.param("every", marks=pytest.mark.long)]
)
def verdicts(request, tmp_path_factory):
    """Cases of quantities and verdicts, recomputed as written and with an input changed."""
    folder = tmp_path_factory.mktemp("verdicts")
    paths, found = [], {}
    for case in list(cases())[:: 8 if request.param == "every eighth" else 1]:
        with made_up_bracket():
            approval = read(put(folder, case.name, case.text), hangs=case.hangs)
        path = folder / f"{case.name}.xlsx"
        path.write_bytes(workbook_bytes(approval, say=Translator("en")))
        found[case.name] = case, approval
        paths += [path, changed_by(case, path)]
    sheets = recalculated(paths, folder)
    return {name: (*of, sheets[2 * k], sheets[2 * k + 1])
            for k, (name, of) in enumerate(found.items())}  # fmt: skip


def test_every_quantity_sets_workbook_verdict(verdicts):
    assert len(verdicts) > 7
    wrong = {}
    for name, (case, approval, sheet, _) in verdicts.items():
        assert approval.verdict == case.verdict
        said = [
            *map(verdict_of_headline, sheet.numbers("verdict")),
            *sheet.numbers("changed_inputs"),
        ]
        if said != [case.verdict, 0]:
            wrong[name] = said
    assert wrong == {}


LIVE = EXACT - WHIRL | {"side_angle", "top_angle", "joint_position", "engine_torque", "slip_torque"}


def test_changed_input_gives_live_verdict_or_stale_per_quantity(verdicts):
    """What fails live still fails; what only cardan knows is no longer known.

    That something is worse at another operating point only cardan knows.
    """
    wrong = {}
    for name, (case, approval, _, sheet) in verdicts.items():
        if not case.quantity:
            continue
        said, count = sheet.numbers("verdict")[0], sheet.numbers("changed_inputs")[0]
        said = verdict_of_headline(said)
        live = case.quantity in LIVE or case.verdict == "incomplete"
        expected = {case.verdict} if live else {"stale: run cardan again"}
        if case.quantity in APPROXIMATED:
            expected = {"pass", "warn", "fail"}
        if any(c.point for c in approval.checks):
            expected = {*expected, "stale: run cardan again"}
        if said not in expected or not count:
            wrong[name] = said, count
    assert wrong == {}


APPROXIMATED = {
    "equivalent_angle", "torsional_acceleration", "inertia_drive_acceleration",
    "inertia_coast_acceleration", "inertia_drive_torque", "inertia_coast_torque",
}  # fmt: skip


CHANGES = {"same": {}, "tyre": {"tyre_radius": 1.0}, "angle": {"side_1": 60},
           "blank": {"tyre_friction": None}}  # fmt: skip
COLLECTOR = Path(__file__).parents[2] / "examples" / "refuse-collector-6x2.yaml"


def test_failed_clearance_keeps_workbook_failed_until_inputs_change(tmp_path):
    """The refuse collector with room and joint angle as its only limits, in every language.

    `check` said FAIL and the workbook pass. Changed by hand it knows no more about the room;
    and it knows that an angle of 60 deg fails.
    """
    limits = [limit("clearance", maximum=15), limit("joint_angle", maximum=45)]
    text = COLLECTOR.read_text(encoding="utf-8")
    text = text.replace("limits: heavy-truck", f"limits: {json.dumps(limits)}")
    found = approve_driveline(reader.loads(text))
    assert found.verdict == "fail"
    paths = []
    for code in LANGUAGE_CODES:
        path = tmp_path / f"{code}.xlsx"
        path.write_bytes(workbook_bytes(found, say=Translator(code)))
        for name, change in CHANGES.items() if code == "en" else [("angle", CHANGES["angle"])]:
            sheet = Sheet(path, values=False)
            for key, value in change.items():
                for cell in sheet.cells(key)[:1]:
                    cell.value = value
            sheet.book.save(tmp_path / f"{code}-{name}.xlsx")
            paths.append(tmp_path / f"{code}-{name}.xlsx")
    said = [s.numbers("verdict")[0] for s in recalculated(paths, tmp_path)]
    stale = "stale: run cardan again"
    every, *others = [Translator(c)("not approved").upper() for c in LANGUAGE_CODES]
    assert said == [every, stale, every, stale, *others]

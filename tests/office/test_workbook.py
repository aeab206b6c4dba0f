"""The workbook recomputed by LibreOffice against `cardan`, unchanged and with changed inputs.

Both compute in double precision from the same numbers; formulas of a few dozen operations
agree to 1e-9 of the size of what is computed. Forces and phasors are sums in which large
terms cancel, so they are held to that share of the largest among the states.
"""

import re
import sys
from dataclasses import replace
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest

from cardan import files
from cardan.base.units import deg, mm, rpm
from cardan.base.verdict import worst
from cardan.model.layout import from_slopes
from cardan.quantity.response import Response, respond
from cardan.report.language import Language
from cardan.report.workbook import workbook
from cardan.study.approval import assess

sys.path.insert(0, str(Path(__file__).parent))
from spreadsheet import Sheet, recalculated

pytestmark = pytest.mark.office

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.yaml"))
STARTERS = ("small", "truck")


def applications():
    for path in EXAMPLES:
        yield path.stem, files.read(path)
    for kind in STARTERS:
        yield kind, files.loads(files.starter(kind))


def expected(r: Response) -> dict[str, np.ndarray]:
    """What the workbook's named rows must hold, in their units, for each state."""
    n, ae7 = r.line.joint_count, r.approximations["ae7"]
    static, dynamic = r.small_angle_bearings
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
        found[f"joint_angle_joint_{k + 1}"] = r.angles[:, k] / deg
        found[f"n_beta_joint_{k + 1}"] = r.demand.speed / rpm * r.angles[:, k] / deg
        found[f"joint_life_joint_{k + 1}"] = r.life[:, k] / 3600
    for k in range(n - 2):
        found[f"centre_bearing_static_bearing_{k + 1}"] = np.linalg.norm(static[:, k], axis=-1)
        found[f"centre_bearing_dynamic_bearing_{k + 1}"] = dynamic[:, k]
    for k in range(n - 1):
        found[f"critical_speed_shaft_{k + 1}"] = r.critical_speeds[:, k] / rpm
        found[f"critical_speed_ratio_shaft_{k + 1}"] = r.demand.speed / r.critical_speeds[:, k]
        found[f"tube_shear_utilisation_shaft_{k + 1}"] = r.tube_shear_utilisation[:, k]
    return {name: values for name, values in found.items() if np.isfinite(values).any()}


def held(sheet: Sheet, r: Response, tag: str, *, without: tuple[str, ...] = ()) -> int:
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
    return f"{r.line.name.replace('-', '_').replace(' ', '_')}_" if len(found.responses) > 1 else ""


def changed(r: Response, rng: np.random.Generator) -> tuple[dict[str, list], Response]:
    """Other angles, lengths, torques, speeds, tubes and phases: as typed in, and as computed."""
    states, n = len(r.demand.states), r.line.joint_count
    side = r.layout.side / deg + rng.uniform(-2, 2, (states, n + 1))
    top = r.layout.top / deg + rng.uniform(-2, 2, (states, n + 1))
    lengths = r.layout.lengths / mm * rng.uniform(0.9, 1.1, (states, n - 1))
    torque, speed = rng.uniform(500, 9000, states), rng.uniform(800, 3000, states)
    share = r.demand.installed.torque_ratio * (
        r.demand.installed.axle.torque_share if r.demand.installed.axle else 1.0
    )
    phases = rng.choice([0, 90, 12.5], n - 1).astype(float)
    shafts = []
    outers, walls = rng.uniform(80, 130, n - 1), rng.uniform(2.5, 6, n - 1)
    for s, phase, outer, wall in zip(r.line.shafts, phases, outers, walls, strict=True):
        tube = s.tube and replace(s.tube, outer=outer * mm, wall=wall * mm)
        inertia = s.polar_inertia
        shafts.append(replace(s, phase=phase * deg, tube=tube, polar_inertia_given=inertia or None))
    line = replace(r.line, shafts=tuple(shafts))
    typed = {f"side_{k}": side[:, k].tolist() for k in range(n + 1)}
    typed |= {f"top_{k}": top[:, k].tolist() for k in range(n + 1)}
    typed |= {f"length_{k + 1}": lengths[:, k].tolist() for k in range(n - 1)}
    typed |= {"state_torques": torque.tolist(), "state_speeds": speed.tolist()}
    typed |= {"yoke_phases": phases.tolist()}
    tubes = [s.tube for s in line.shafts]
    typed["tube_outer"] = [o if t else None for o, t in zip(outers, tubes, strict=True)]
    typed["tube_wall"] = [w if t else None for w, t in zip(walls, tubes, strict=True)]
    demand = replace(
        r.demand,
        installed=replace(r.demand.installed, line=line),
        torque=torque * share,
        speed=speed * rpm * r.demand.installed.speed_ratio,
    )
    layout = from_slopes(side=side * deg, top=top * deg, lengths=lengths * mm)
    application = replace(r.application, include_gravity=False)
    return typed, respond(application, demand, layout=layout, phases=line.phases)


@pytest.fixture(scope="module")
def books(tmp_path_factory):
    """Every application's workbook recomputed, as written and with other inputs."""
    folder = tmp_path_factory.mktemp("books")
    cases, paths = {}, []
    rng = np.random.default_rng(3)
    for name, application in applications():
        found = assess(application)
        plain = folder / f"{name}.xlsx"
        plain.write_bytes(workbook(found, say=Language("en")))
        sheet = Sheet(plain, values=False)
        others = []
        for r in found.responses:
            typed, other = changed(r, rng)
            for cell, values in typed.items():
                sheet.change(tag_of(found, r) + cell, values)
            for k in range(r.line.joint_count - 2) if r.gravity else ():
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


NAMES = [p.stem for p in EXAMPLES] + list(STARTERS)


@pytest.mark.parametrize("name", NAMES)
def test_formulas_give_what_cardan_gives(books, name):
    found, _, sheet, _ = books[name]
    for r in found.responses:
        assert held(sheet, r, tag_of(found, r)) > 10


@pytest.mark.parametrize("name", NAMES)
def test_results_follow_changed_inputs(books, name):
    found, others, _, sheet = books[name]
    for r in others:
        held(sheet, r, tag_of(found, r))


@pytest.mark.parametrize("name", NAMES)
def test_no_cell_is_an_error(books, name):
    for sheet in books[name][2:]:
        for page in sheet.book:
            wrong = [c.coordinate for row in page.iter_rows() for c in row
                     if isinstance(c.value, str) and c.value.startswith(("#", "Err:"))]  # fmt: skip
            assert not wrong, f"{page.title}: {wrong}"


def test_a_name_is_given_once(tmp_path):
    """Excel repairs a file that names two cells alike; openpyxl and LibreOffice say nothing."""
    for name, application in applications():
        book = tmp_path / f"{name}.xlsx"
        book.write_bytes(workbook(assess(application), say=Language("en")))
        xml = ZipFile(book).read("xl/workbook.xml").decode()
        names = re.findall(r'<definedName name="([^"]+)"', xml)
        assert len(names) > 30
        assert len(names) == len(set(names))


@pytest.mark.parametrize("name", NAMES)
def test_slip_torque_follows_tyre_and_axle(books, name):
    """Engine and slip torque by their formulas, without a given torque."""
    found, _, sheet, _ = books[name]
    for r in found.responses:
        tag = tag_of(found, r)
        for row, values in (
            ("engine_torque", r.demand.engine_torque),
            ("slip_torque", r.demand.slip_torque),
        ):
            if np.isfinite(values).all():
                assert sheet.numbers(tag + row) == pytest.approx(values.tolist(), rel=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_verdicts_of_the_workbook_are_those_of_its_limits(books, name):
    """Joint angles are exact in both, so the worst of their rows is the worst of the checks."""
    found, _, sheet, _ = books[name]
    for r in found.responses:
        tag = tag_of(found, r)
        for k in range(1, r.line.joint_count + 1):
            mine = [c for c in found.checks if c.line == r.line.name and c.part == f"joint {k}"
                    and c.quantity == "joint_angle"]  # fmt: skip
            first = sheet.cells(f"{tag}joint_angle_joint_{k}")[-1]
            shown = first.offset(column=1).value
            own = [c.grade for c in mine if c.limit == mine[0].limit]
            assert shown == worst(own)

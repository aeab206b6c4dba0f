"""Loops that numba compiles compute what the NumPy text computes, to 1e-10 of the largest value."""

import re
import subprocess
import sys
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import fields, is_dataclass, replace
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
from repository import EXAMPLES

from cardan.application import reader
from cardan.application.overrides import nominal_variable_values
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.core import compiled
from cardan.model.vehicle import Linkage, Spring, Suspension
from cardan.physics.kinematics import compiled_excitation
from cardan.physics.kinematics.equivalent_angle import shaft_inertia_torques
from cardan.physics.loads import compiled_line_loads, compiled_response
from cardan.physics.loads.spline_thrust import PLACES_OF_A_STROKE
from cardan.physics.vehicle import compiled_squat, compiled_torque
from cardan.physics.vehicle.operating_points import TorqueCurves, operating_points_on_curves
from cardan.physics.vehicle.resolved_line import resolve_line_references
from cardan.physics.vehicle.state_demand import line_state_demand
from cardan.physics.vehicle.suspension import squat_travel
from cardan.topics.variants.evaluation import (
    VariantEvaluator,
    build_variants,
)

SHARE_OF_LARGEST = 1e-10
"""The issue's bound; rounding comes to some 1e-14."""

ON_RUBBER = (
    "medium-truck-4x2", "refuse-collector-6x2", "tandem-6x4", "vecto-4x2", "vecto-6x2", "mtv-6x6",
    "pick-up-4x4",
)  # fmt: skip
"""All examples with a line on rubber."""

RANDOM_INPUTS = re.compile(
    r"(?!.*adjust\.)(.*\.)?"
    r"(points_mm\[2\]\[[23]\]|outer_mm|wall_mm|from_rear_joint_mm|\w+_stiffness_N_mm|"
    r"yoke_mass_kg\[\d\]|balance_grade|friction|mean_radius_mm|phase_deg\[\d\]|"
    r"bearing_\w+_mm\[\d\]|shim_deg)"
)
"""What differs between random applications: layout, tubes, rubber, masses, spline and phases."""

RANDOM_PER_EXAMPLE = 30


@contextmanager
def batches_compiled(least: float | None) -> Generator[None, None, None]:
    """Have batches of at least so many cases take the loops; None: no batch."""
    with pytest.MonkeyPatch.context() as patch:
        least = np.inf if least is None else least
        patch.setattr(compiled, "COMPILED_MIN_CASES", least)
        yield


def responses(name: str) -> Iterator[LineResponse]:
    """Each line of an example as it stands."""
    application = reader.read(EXAMPLES / f"{name}.yaml")
    for installed in application.lines:
        demand = line_state_demand(resolve_line_references(application, installed))
        yield compute_line_response(application, demand)


def arrays(of: Any, name: str) -> Iterator[tuple[str, np.ndarray]]:
    """Every array in nested dataclasses, by its name."""
    if isinstance(of, np.ndarray):
        yield name, of
    elif isinstance(of, dict):
        for key, value in of.items():
            yield from arrays(value, f"{name}.{key}")
    elif is_dataclass(of):
        for field in fields(of):
            yield from arrays(getattr(of, field.name), f"{name}.{field.name}")


def bearing_results(r: LineResponse) -> dict[str, np.ndarray]:
    """What is computed by loops: forces, travel, clearance, growth and thrust at the worst."""
    loads = r.mount_loads
    thrust = r.mounts.stroke_thrust
    found = {
        "forces": loads.worst_bearing_forces,
        "travel": loads.worst_bearing_travel,
        "clearance": loads.worst_obstacle_clearance,
        "growth": loads.worst_growth_rate,
    }
    named = dict(arrays(found, r.line.name))
    for field in fields(thrust) if thrust else ():
        if isinstance(value := getattr(thrust, field.name), np.ndarray):
            named[f"{r.line.name}.thrust.{field.name}"] = value
    return named


def assert_alike(found: dict[str, np.ndarray], reference: dict[str, np.ndarray]) -> None:
    assert found.keys() == reference.keys()
    for name, value in reference.items():
        other = found[name]
        if value.dtype.kind not in "fc":
            assert (other == value).all(), name
            continue
        known = np.isfinite(value)
        assert (other[~known] == value[~known]).all() or np.isnan(value[~known]).any(), name
        assert (np.isfinite(other) == known).all(), name
        largest = np.abs(value[known]).max(initial=0.0)
        off = np.abs(other[known] - value[known]).max(initial=0.0)
        assert off <= SHARE_OF_LARGEST * largest, (name, off / largest)


def check_example(name: str, *, least: float) -> None:
    for by_numpy, by_loops in zip(responses(name), responses(name), strict=True):
        with batches_compiled(None):
            reference = bearing_results(by_numpy)
        with batches_compiled(least):
            assert_alike(bearing_results(by_loops), reference)


LOOPS_OF_LOADS = (compiled_line_loads, compiled_response)
LOOPS_OF_POINTS = (compiled_excitation, compiled_squat, compiled_torque)


def run_as_plain_python(monkeypatch, modules: tuple[ModuleType, ...]) -> set[str]:
    """Have the loops of some modules run uncompiled; return the names of those that ran."""
    called = set[str]()

    def plain(function, *_):
        def run(*arguments):
            called.add(function.__name__)
            return function(*arguments)

        return run

    for module in modules:
        monkeypatch.setattr(module, "compiled", plain)
    return called


@pytest.mark.parametrize("name", [ON_RUBBER[0], pytest.param(ON_RUBBER[1], marks=pytest.mark.slow)])
def test_loops_as_plain_python_equal_numpy(name, monkeypatch):
    """Run uncompiled: with and without numba the text of each loop computes the same."""
    called = run_as_plain_python(monkeypatch, LOOPS_OF_LOADS)
    check_example(name, least=1)
    assert called == {
        "balanced_motions", "buckling_modes", "held_compressions", "mean_loads", "pair_growths",
        "responses", "screened_sizes",
    }  # fmt: skip


SPRING = Spring(load=(0.0, 15e3, 60e3), deflection=(-0.02, 0.08, 0.19))
LINK = Linkage(radius=0.5, angle=0.06, pitch_rate=0.07)


def test_links_that_differ_take_no_loop(monkeypatch):
    """Of a radius, or a spring, for each variant."""
    called = run_as_plain_python(monkeypatch, LOOPS_OF_POINTS)
    radius = np.linspace(0.4, 0.6, 25)[:, None]
    spring = Spring(
        load=(0.0, np.linspace(14e3, 16e3, 25)[:, None], 60e3), deflection=(0, 0.1, 0.2)
    )
    force = np.full((2, 25, 5), 20e3)
    given = {"travel": 0.0, "axle_load": 40e3, "drawn": 0.0, "force": force, "torque": 9e3}
    with batches_compiled(1):
        for link, leaf in ((replace(LINK, radius=radius), SPRING), (LINK, spring)):
            squat_travel(Suspension(spring=leaf, unsprung_mass=600.0, linkage=link), **given)
    assert not called


@pytest.mark.parametrize("linkage", [LINK, Linkage(pitch_rate=0.07)], ids=["link", "straight"])
def test_squat_of_rows_equals_squat_of_arrays(linkage, monkeypatch):
    """Of 250 axles: at both stops, between them, on both slopes of a spring; one is unknown."""
    called = run_as_plain_python(monkeypatch, LOOPS_OF_POINTS)
    rng = np.random.default_rng(7)
    shape = (2, 25, 5)
    suspension = Suspension(
        spring=SPRING, unsprung_mass=600.0, linkage=linkage, full_rebound_deflection=0.02,
        jounce_deflection=0.15,
    )  # fmt: skip
    force = rng.uniform(-60e3, 60e3, shape)
    force[1, 3, 2] = np.nan
    given = {
        "travel": rng.uniform(-0.03, 0.03, shape[1:]), "drawn": 0.3 * force, "force": force,
        "axle_load": rng.uniform(10e3, 90e3, shape[-1]), "torque": 0.45 * force, "ahead": -1.0,
    }  # fmt: skip
    with batches_compiled(None):
        reference = squat_travel(suspension, **given)
    assert not called
    with batches_compiled(1):
        found = squat_travel(suspension, **given)
    assert called == {"squat_of_rows"}
    assert np.isnan(found).sum() == 1
    assert found == pytest.approx(reference, abs=1e-14, nan_ok=True)
    assert (np.diff(np.sort(reference.ravel())) == 0).sum() > 5  # some are at a stop


def test_torque_of_points_equals_torque_along_curves(monkeypatch):
    """With jumps, repeated corners, a grip that some variants lack, and speeds off the curves."""
    called = run_as_plain_python(monkeypatch, LOOPS_OF_POINTS)
    rng = np.random.default_rng(8)
    curves, variants, states, corners = 3, 12, 4, 5
    speed = np.sort(rng.uniform(0, 300, (curves, 1, states, corners)), axis=-1)
    speed[..., 0], speed[1, ..., 3], speed[2, ..., 4] = 0.0, speed[1, ..., 2], speed[2, ..., 3]
    speed = np.broadcast_to(speed, (curves, variants, states, corners))
    torque = rng.uniform(-900, 900, (curves, variants, 1, corners))
    torque[0, 0, 0, 0] = 0.0
    limit = np.where(rng.random((curves, variants, states)) < 0.5, np.inf, 400.0)
    fastest = speed[..., -1].copy()
    fastest[2, :, 1] = np.nan
    of = TorqueCurves(
        gears=("1", "2", "3"), directions=("drive", "drive", "coast"), speed=speed,
        torque=np.broadcast_to(torque, speed.shape), torque_limit=limit, max_speed=fastest,
    )  # fmt: skip
    points = {
        "curve": rng.integers(0, curves, (9, variants, states)),
        "speed": rng.uniform(-20, 320, (9, variants, states)),
    }
    points["speed"][0] = speed[1, 0, 0, 2]  # where a curve jumps
    with batches_compiled(None):
        reference = operating_points_on_curves(of, **points)
    with batches_compiled(1):
        found = operating_points_on_curves(of, **points)
    assert called == {"torque_of_points"}
    assert 0.1 < np.isnan(reference.torque).mean() < 0.5
    for name in ("torque", "speed"):
        expected = getattr(reference, name)
        assert getattr(found, name) == pytest.approx(expected, rel=1e-12, nan_ok=True)


@pytest.mark.parametrize("largest_angle", [0.15, 0.9], ids=["small", "large"])
def test_crests_case_by_case_equal_crests_of_rows(largest_angle, monkeypatch):
    """Of three shafts behind joints up to 9 and 52 degrees: these have more than two peaks."""
    called = run_as_plain_python(monkeypatch, LOOPS_OF_POINTS)
    rng = np.random.default_rng(9)
    angles = rng.uniform(0, largest_angle, (2, 20, 6, 4))
    angles[0, 0, 0] = 0.0  # a straight line
    phasors = np.tan(angles / 2) ** 2 * np.exp(2j * np.pi * rng.random(angles.shape))
    turn = SimpleNamespace(phasors=phasors)
    inertias = rng.uniform(0.01, 0.1, (20, 6, 3))
    with batches_compiled(None):
        reference = shaft_inertia_torques(turn, speed=200.0, inertias=inertias)
    with batches_compiled(1):
        found = shaft_inertia_torques(turn, speed=200.0, inertias=inertias)
    assert called == {"plain_crests"}
    for one, other in zip(found, reference, strict=True):
        assert one == pytest.approx(other, rel=1e-12, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("name", ON_RUBBER)
def test_random_applications_come_to_the_same_compiled(name):
    """Thirty random applications of each example: every limit's value, margin and grade."""
    pytest.importorskip("numba")
    application = reader.read(EXAMPLES / f"{name}.yaml")
    known = nominal_variable_values(application)
    drawn = {
        key: {"uniform": 0.1 * abs(value) if value else 5.0}
        for key, value in known.items()
        if RANDOM_INPUTS.fullmatch(key)
    }
    bench = VariantEvaluator.from_application(application, build_variants(None, drawn), seed=5)
    assert not bench.unvectorised_inputs
    with batches_compiled(None):
        reference = bench.evaluate_range(0, RANDOM_PER_EXAMPLE).results
    with batches_compiled(RANDOM_PER_EXAMPLE):
        found = bench.evaluate_range(0, RANDOM_PER_EXAMPLE).results
    for k, row in enumerate(bench.limits):
        each = [
            {f"{row}.{f}": getattr(of, f)[k] for f in ("values", "margins", "left", "grades")}
            for of in (found, reference)
        ]
        assert_alike(*each)
    assert reference.infeasible.mean() < 0.5
    assert (found.infeasible == reference.infeasible).all()
    assert (found.bounded == reference.bounded).all()


def test_check_of_one_design_imports_no_numba():
    """Nor where a hundred numbers are varied one by one, as those of the van and the pick-up."""
    names = [str(EXAMPLES / f"{n}.yaml") for n in ("medium-truck-4x2", "van", "pick-up-4x4")]
    code = (
        "import sys; from cardan.cli import cli\n"
        f"for name in {names!r}:\n"
        "    try: cli(['check', name])\n"
        "    except SystemExit as end: assert end.code in (0, 1), name\n"
        "    assert 'numba' not in sys.modules, name"
    )
    subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL)


def test_batch_of_few_cases_takes_no_loop():
    assert not compiled.is_compiled_batch((12, 7))
    assert compiled.is_compiled_batch((128, 7))
    of_fix, of_study = (
        compiled.is_compiled_batch((n, 7), points=compiled.POINT_LOOP_CASE_FACTOR)
        for n in (63, 128)
    )
    assert of_study
    assert not of_fix
    assert not compiled.is_compiled_batch((3, 15, 12, 7), points=PLACES_OF_A_STROKE)
    assert compiled.is_compiled_batch((3, 15, 128, 7), points=PLACES_OF_A_STROKE)

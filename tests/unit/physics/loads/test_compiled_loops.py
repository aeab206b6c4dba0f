"""Loops that numba compiles compute what the NumPy text computes, to 1e-10 of the largest value."""

import re
import subprocess
import sys
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import pytest
from repository import EXAMPLES

from cardan.application import reader
from cardan.application.overrides import nominal_variable_values
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.core import compiled
from cardan.physics.loads import compiled_line_loads, compiled_response
from cardan.physics.loads.spline_thrust import PLACES_OF_A_STROKE
from cardan.physics.vehicle.resolved_line import resolve_line_references
from cardan.physics.vehicle.state_demand import line_state_demand
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


@pytest.mark.parametrize("name", [ON_RUBBER[0], pytest.param(ON_RUBBER[1], marks=pytest.mark.slow)])
def test_loops_as_plain_python_equal_numpy(name, monkeypatch):
    """Run uncompiled: with and without numba the text of each loop computes the same."""
    called = set[str]()

    def plain(function, *_):
        def run(*arguments):
            called.add(function.__name__)
            return function(*arguments)

        return run

    for module in (compiled_line_loads, compiled_response):
        monkeypatch.setattr(module, "compiled", plain)
    check_example(name, least=1)
    assert called == {
        "balanced_motions", "buckling_modes", "held_compressions", "mean_loads", "pair_growths",
        "responses", "screened_sizes",
    }  # fmt: skip


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
    code = (
        "import sys; from cardan.cli import cli\n"
        f"try: cli(['check', {str(EXAMPLES / 'medium-truck-4x2.yaml')!r}])\n"
        "except SystemExit as end: assert end.code in (0, 1)\n"
        "assert 'numba' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL)


def test_batch_of_few_cases_takes_no_loop():
    assert not compiled.is_compiled_batch((12, 7))
    assert compiled.is_compiled_batch((128, 7))
    assert not compiled.is_compiled_batch((3, 15, 12, 7), points=PLACES_OF_A_STROKE)
    assert compiled.is_compiled_batch((3, 15, 128, 7), points=PLACES_OF_A_STROKE)

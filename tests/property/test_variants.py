"""A batch of variants is what its variants are one by one: no second code path, for any number."""

from dataclasses import fields
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cardan.application import overrides, reader
from cardan.checks.line_response import compute_line_response
from cardan.checks.mount_loads import MountLoads
from cardan.checks.quantities.registry import LINE_QUANTITIES
from cardan.core.errors import DesignError, InvalidFileError
from cardan.model.application import Application
from cardan.model.layout import Layout
from cardan.physics.vehicle.state_demand import (
    LineStateDemand,
    line_state_demand,
    resolve_line_references,
)

ROOT = Path(__file__).parents[2]
PATHS = (*sorted((ROOT / "examples").glob("*.yaml")), ROOT / "tests" / "truck.yaml")
EXAMPLES = {path.stem: path for path in PATHS}

ROUNDING = 1e-12
"""Of the largest value about: sums over the states, the shafts and a turn cancel to some 1e-13."""


@pytest.fixture(scope="module", autouse=True)
def _linear_rubber():
    """Of a batch neither a stop nor a stuck spline is solved: limits then hold its bounds."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(MountLoads, "stop_response", None)
        patch.setattr(MountLoads, "stuck_forces", None)
        patch.setattr(MountLoads, "stuck_force_estimate", {})
        yield


@cache
def application(name: str) -> Application:
    return reader.read(EXAMPLES[name])


def found(of: Application) -> dict[str, np.ndarray]:
    """Every number of the demand on each line, and every quantity, states first behind variants."""
    values: dict[str, np.ndarray] = {}
    for installed in of.lines:
        asked = line_state_demand(resolve_line_references(of, installed))
        line = installed.line.name
        for name, value in _numbers(asked):
            values[f"{line}, {name}"] = value
        response = compute_line_response(of, asked)
        values |= {f"{line}, {key}": q.values(response) for key, q in LINE_QUANTITIES.items()}
        static, dynamic = response.rigid_loads.small_angle_bearing_forces
        values |= {f"{line}, small static": static, f"{line}, small dynamic": dynamic}
        for name, by in response.kinematics.approximate_excitations.items():
            values[f"{line}, {name}"] = by.coast.acceleration
    return values


def _numbers(asked: LineStateDemand):
    for f in fields(asked):
        value = getattr(asked, f.name)
        if isinstance(value, Layout):
            yield f"{f.name}.points", value.points
            yield f"{f.name}.directions", value.directions
        elif isinstance(value, np.ndarray):
            yield f.name, value
    yield "ride.shift", asked.axle_motion.shift
    yield "ride.pitch", asked.axle_motion.pitch
    if asked.gears:
        yield "gears.speed", asked.gears.speed
        yield "gears.torque", asked.gears.torque


def tried(name: str, changes: dict[str, float | np.ndarray]) -> dict[str, np.ndarray] | None:
    """What a changed example does; None where it is refused."""
    try:
        return found(overrides.change(application(name), changes))
    except (InvalidFileError, DesignError):
        return None


def compare(name: str, changes: dict[str, np.ndarray]) -> bool:
    """Hold the variants as a batch against the same one by one; whether they can be."""
    count = len(next(iter(changes.values())))
    batch = tried(name, changes)
    each = [tried(name, {at: float(c[v]) for at, c in changes.items()}) for v in range(count)]
    assert (batch is None) == (None in each), "refused as a batch, or one by one"
    if batch is None:
        return False
    for key, values in batch.items():
        alone = np.stack([one[key] for one in each])
        # What no variant changes has no axis for them; gears have one for states, of length 1.
        together = values[:, 0] if "gears" in key and values.ndim > alone.ndim else values
        together = np.broadcast_to(together, alone.shape)
        # A distance is what two numbers near 1 differ by: it is as exact as those.
        least = 1.0 if "distance" in key else 0.0
        size = np.abs(alone[np.isfinite(alone)]).max(initial=least)
        np.testing.assert_allclose(
            together, alone, rtol=ROUNDING, atol=ROUNDING * size, err_msg=f"{key} of {changes}"
        )
    return True


def varied(number: float, by: np.ndarray) -> np.ndarray:
    """A number some shares larger; what is 0 by as much of its unit."""
    return (number or 1.0) * (by - (0 if number else 1))


def factors(count: int):
    return st.lists(
        st.floats(0.9, 1.1).filter(lambda f: f != 1), min_size=count, max_size=count
    ).map(np.array)


@st.composite
def cases(draw: st.DrawFn):
    name = draw(st.sampled_from(sorted(EXAMPLES)))
    numbers = overrides.addresses(application(name))
    some = draw(st.lists(st.sampled_from(sorted(numbers)), min_size=1, max_size=4, unique=True))
    return name, {at: varied(numbers[at], draw(factors(3))) for at in some}


@pytest.mark.slow
@settings(max_examples=10)
@given(case=cases())
def test_batched_variants_equal_single_variants(case):
    compare(*case)


UNLIKE = ("composite-van", "pick-up-4x4", "three-joint-chain", "van", "medium-truck-4x2")
"""Composite tube, joints of other kinds, no vehicle, one shaft, and two on rubber; the others by
hand."""


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=pytest.mark.slow if name in UNLIKE else pytest.mark.long)
    for name in sorted(EXAMPLES)
])  # fmt: skip
def test_every_number_of_file_may_vary_in_batch(name: str):
    """By a percent, eight at a time; by itself what makes no sense beside its neighbours."""
    percent = np.array([0.99, 1.01])
    numbers = overrides.addresses(application(name))
    changes = [(at, varied(to, percent)) for at, to in numbers.items()]
    for start in range(0, len(changes), 8):
        some = dict(changes[start : start + 8])
        if not compare(name, some):
            for at, to in some.items():
                compare(name, {at: to})

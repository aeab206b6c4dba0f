"""The bracket's arithmetic, which needs no finite element engine."""

import re
import sys
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cardan.core.errors import DesignError, MissingDependencyError
from cardan.core.units import mm
from cardan.model.bracket import Bracket, BracketStrainGauge, FaceSelector, LShape, UShape
from cardan.physics.fatigue.critical_plane import (
    load_envelope,
    mohr_components,
    normal_stress_on_planes,
    plane_directions,
)
from cardan.physics.fem import stress
from cardan.physics.fem.adaptive_refinement import _firm_matters, _share_of_worst, _worse
from cardan.physics.fem.geometry import build_solid
from cardan.physics.fem.ngsolve_import import import_ngsolve
from cardan.physics.fem.strain_gauges import (
    correct_loads_for_flange_clamping,
    recover_loads,
    recover_loads_and_flange_clamping,
)
from cardan.physics.fem.stress import stress_extremes, superpose, von_mises
from cardan.render.i18n import Translator
from cardan.topics.bracket.boundary_case import BoundaryCase
from cardan.topics.bracket.case_evaluation import _pulls_off, _stressed
from cardan.topics.bracket.operating_points import _swung_most

stresses = arrays(float, (5, 6), elements=st.floats(-1e9, 1e9))
U = {
    "seat_diameter": 100 * mm, "width": 70 * mm, "thickness": 6 * mm,
    "height": 90 * mm, "flange": 55 * mm,
    "bend_radius": 10 * mm, "bolt_diameter": 11 * mm, "bolt_pitch": 40 * mm,
}  # fmt: skip
L = {
    "seat_diameter": 52 * mm, "width": 180 * mm, "wall_width": 144 * mm, "depth": 90 * mm,
    "thickness": 8 * mm,
    "height": 80 * mm, "rim": 24 * mm, "fillet": 5 * mm,
    "bolt_diameter": 11 * mm, "bolt_edge": 14 * mm,
}  # fmt: skip


@given(stresses)
def test_principal_stresses_are_eigenvalues(s):
    """Closed form against LAPACK; double roots halve the digits of the arc cosine."""
    expected = np.linalg.eigvalsh(stress.stress_tensor(s))
    assert stress.principal_stresses(s) == pytest.approx(
        expected, abs=1e-7 * max(np.abs(s).max(), 1)
    )


@given(stresses)
def test_von_mises_from_principal_stresses(s):
    a, b, c = np.moveaxis(np.linalg.eigvalsh(stress.stress_tensor(s)), -1, 0)
    expected = np.sqrt(((a - b) ** 2 + (b - c) ** 2 + (c - a) ** 2) / 2)
    assert stress.von_mises(s) == pytest.approx(
        expected, rel=1e-6, abs=max(1e-6 * np.abs(s).max(), 1e-100)
    )


def test_uniaxial_stress_along_a_direction():
    """Tension of 1 along n shows cos² of the angle on a plane turned by it."""
    n = np.array([1, 2, 2]) / 3
    one = np.outer(n, n)[[0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]]
    assert stress.von_mises(one) == pytest.approx(1)
    assert stress.normal_stress(one, n) == pytest.approx(1)
    assert stress.normal_stress(one, [2, -2, 1]) == pytest.approx(0, abs=1e-15)
    assert stress.max_normal_stress_swing_direction(np.stack([one, -one])) == pytest.approx(n) or (
        stress.max_normal_stress_swing_direction(np.stack([one, -one])) == pytest.approx(-n)
    )


@settings(max_examples=25)
@given(arrays(float, (8, 6), elements=st.floats(-100, 100)))
def test_the_critical_direction_swings_most(history):
    """No direction of many beats it by more than 2.5 degrees' worth."""
    best = np.ptp(stress.normal_stress(history, stress.max_normal_stress_swing_direction(history)))
    tried = np.random.default_rng(0).standard_normal((500, 3))
    assert (
        np.ptp(stress.normal_stress(history[:, None], tried), axis=0).max() <= best * 1.005 + 1e-9
    )


def test_extremes_over_a_history_are_those_of_each_moment():
    rng = np.random.default_rng(3)
    unit, loads = rng.standard_normal((40, 9, 6)), rng.standard_normal((7, 9))
    found = stress.stress_extremes(unit, loads)
    every = np.stack([unit.transpose(0, 2, 1) @ load for load in loads], axis=1)
    mises, ends = stress.von_mises(every), stress.principal_stresses(every)
    assert found.von_mises.value == pytest.approx(mises.max())
    assert mises[found.von_mises.point, found.von_mises.time] == pytest.approx(mises.max())
    assert found.max_principal.value == pytest.approx(ends.max())
    assert found.min_principal.value == pytest.approx(ends.min())
    assert stress.von_mises_envelope(unit, loads) == pytest.approx(mises.max(axis=1))


def test_chunks_change_nothing(monkeypatch):
    rng = np.random.default_rng(4)
    unit, loads = rng.standard_normal((40, 9, 6)), rng.standard_normal((7, 9))
    whole = stress.stress_extremes(unit, loads)
    monkeypatch.setattr(stress, "_CHUNK", 21)
    assert stress.stress_extremes(unit, loads) == whole


@given(arrays(float, (6, 3), elements=st.floats(-1e3, 1e3)))
def test_forces_come_back_from_their_strains(forces):
    influence = np.array([[60, 1, 3], [-60, 2, 3], [15, 20, -5], [0, -1, -30.0]]) * 1e-9
    back = recover_loads(influence, forces @ influence.T)
    assert back.loads == pytest.approx(forces, abs=1e-9)
    assert np.all(back.residual < 1e-15)
    gains = np.linalg.svd(influence, compute_uv=False)
    assert back.condition == pytest.approx(gains[0] / gains[-1])


def test_noise_is_told_as_it_is():
    """Scatter of recovered forces over many noisy readings, against the figure given."""
    influence = np.array([[60, 1, 3], [-60, 2, 3], [15, 20, -5], [0, -1, -30.0]]) * 1e-9
    noise = 1e-6 * np.random.default_rng(5).standard_normal((20_000, 4))
    back = recover_loads(influence, noise)
    assert back.loads.std(axis=0) == pytest.approx(back.noise, rel=0.02)  # 4 sigma of 20000
    assert np.sqrt((back.residual**2).mean()) == pytest.approx(0.5e-6, rel=0.02)  # 1 of 4 is left


@pytest.mark.slow
def test_how_far_an_influence_may_be_off_is_told_of_forces():
    """Scatter of forces read with influences off by chance, where they are largest."""
    influence = np.array([[60, 1, 3], [-60, 2, 3], [15, 20, -5], [0, -1, -30.0]]) * 1e-9
    unsure, forces = np.array([0.3, 0.1, 0.2]) * 1e-9, np.array([[100, -900, 50], [20, 100, 400.0]])
    off = unsure * np.random.default_rng(6).standard_normal((20_000, 4, 3))
    back = recover_loads(influence, forces @ influence.T, unsure=unsure)
    largest = np.array([100, 900, 400.0])
    read = np.array([recover_loads(influence, (influence + d) @ largest).loads for d in off])
    assert back.load_error == pytest.approx(read.std(axis=0), rel=0.02)  # 4 sigma of 20000
    # Exact but for rounding, of 900 N.
    assert recover_loads(influence, forces @ influence.T).load_error.max() < 1e-9


def test_what_no_force_explains_is_told_of_forces():
    """Gauges that read 5 % wrong, each by chance, of forces that swing: how many such scatter."""
    random = np.random.default_rng(8)
    influence = 1e-8 * random.standard_normal((6, 3))
    forces = random.normal(scale=[100, 300, 200], size=(50, 3))
    sizes = np.sqrt(np.mean((influence * forces.std(axis=0)) ** 2 * 3))
    told, true = [], []
    for _ in range(400):
        wrong = 0.05 * sizes * random.standard_normal((6, 1))
        read = forces @ influence.T + (wrong * np.sign(forces[:, 1])).T
        back = recover_loads(influence, read)
        at = np.abs(back.loads).max(axis=0)
        told.append(np.linalg.norm(back.inverse, axis=1) * back.unexplained_share * sizes)
        true.append(np.abs(back.loads - forces).max(axis=0))
        assert (back.strain_error(at) >= np.linalg.norm(back.influence_error * at, axis=1)).all()
    assert np.mean(told, axis=0) == pytest.approx(
        np.sqrt(np.mean(np.square(true), axis=0)), rel=0.15
    )
    three = recover_loads(influence[:3], forces @ influence[:3].T)
    assert three.unexplained_share == 0  # nobody knows


def test_blind_gauges_are_refused():
    two_alike = np.array([[60, 1, 3], [60, 1, 3], [15, 20, -5.0]]) * 1e-9
    with pytest.raises(DesignError, match="hardly feel a load along"):
        recover_loads(two_alike, np.zeros(3))
    with pytest.raises(DesignError, match="2 gauges cannot separate 3 loads"):
        recover_loads(two_alike[:2], np.zeros(2))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"thickness": float("nan")}, "thickness of a U bracket must be above 0"),
        (
            {"bolt_pitch": 60 * mm},
            "bolt_pitch of a U bracket is 60 mm, but may be 45.8 mm, by the washers",
        ),
        ({"bolt_pitch": 60 * mm, "width": 20 * mm}, "but has no room, by the washers on its width"),
        ({"bend_radius": 90 * mm}, "bend_radius of a U bracket is 90 mm, but may be 84 mm"),
        ({"gusset": 20 * mm, "gusset_height": 60 * mm}, "gusset with its weld"),
        ({"gusset": 5 * mm, "gusset_height": 95 * mm}, "gusset_height"),
        ({"gusset": 5 * mm, "gusset_height": 60 * mm, "fillet": 17 * mm}, "fillet|weld"),
    ],
)
def test_a_u_that_cannot_be_is_refused(change, says):
    with pytest.raises(DesignError, match=says):
        UShape(**U | change)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"wall_width": 200 * mm}, "wall_width of an L bracket is 200 mm"),
        ({"seat_diameter": 150 * mm}, "seat_diameter"),
        ({"bolt_edge": 10 * mm}, "for a washer"),
    ],
)
def test_an_l_that_cannot_be_is_refused(change, says):
    with pytest.raises(DesignError, match=says):
        LShape(**L | change)


@pytest.mark.parametrize(
    ("part", "of", "key", "value"),
    [
        (UShape, U | {"width": 0.2}, "bolt_diameter", 0.019), (UShape, U, "bolt_pitch", 0.4),
        (UShape, U | {"width": 0.2, "bolt_pitch": 0.1}, "bolt_diameter", 0.022),
        (UShape, U | {"flange": 0.2}, "bend_radius", 0.2), (LShape, L, "seat_diameter", 0.14),
        (LShape, L, "bolt_diameter", 0.013), (LShape, L, "bolt_edge", 0.06),
        (UShape, U | {"gusset": 3 * mm, "gusset_height": 21 * mm}, "fillet", 6 * mm),
    ],
)  # fmt: skip
def test_what_would_fit_is_told_in_the_files_own_measures_and_fits(part, of, key, value):
    """A washer is 2.2 times as wide as its hole: told of the hole. What is told is taken."""
    with pytest.raises(DesignError) as failed:
        part(**of | {key: value})
    told = re.search(
        rf"^{key} of .* is {value / mm:g} mm, but may be (.*) mm, by", str(failed.value)
    )
    assert told, failed.value
    fits = float(told[1]) * mm
    part(**of | {key: fits})
    with pytest.raises(DesignError):
        part(**of | {key: fits + 0.02 * mm})


@pytest.mark.parametrize("code", ["pt", "it"])
def test_a_shape_that_cannot_be_is_refused_in_the_language(code):
    for part, of, change in (
        (UShape, U, {"gusset": 0.3, "gusset_height": 0.05}), (UShape, U, {"bolt_pitch": 0.4}),
        (LShape, L, {"seat_diameter": 0.4}), (LShape, L, {"bolt_edge": 0.4}),
    ):  # fmt: skip
        with pytest.raises(DesignError) as failed:
            part(**of | change)
        told = Translator(code).error(f"a.yaml:3: bracket.u_shape.x_mm: {failed.value}")
        english = re.findall(r"\b(?:of|is|but|may|by|lower|room|the|bracket|with)\b", told)
        assert english == ["bracket"], told


def test_parts_refuse_nonsense():
    with pytest.raises(DesignError, match="either by its name or by a point"):
        FaceSelector()
    with pytest.raises(DesignError, match="direction that is not zero"):
        BracketStrainGauge(name="S1", point=(0, 0, 0), direction=(0, 0, 0))
    gauge = BracketStrainGauge(name="S1", point=(0, 0, 0), direction=(0, 0, 1))
    with pytest.raises(DesignError, match="different names"):
        Bracket(shape=UShape(**U), gauges=(gauge, gauge))
    with pytest.raises(DesignError, match="rubber"):
        Bracket(shape=UShape(**U), rubber=(1.0, 0.0, 1.0))


@pytest.mark.parametrize(
    ("error", "says"),
    [
        (ModuleNotFoundError("No module named 'ngsolve'", name="ngsolve"), r"cardan\[bracket\]"),
        (ImportError("libopenblas.so.0: cannot open shared object file"), "libquadmath0"),
    ],
)
def test_what_to_install_is_said(monkeypatch, error, says):
    """On a bare Linux NGSolve names libopenblas, which it brings; libquadmath is missing."""
    for name in ("ngsolve", "netgen", "netgen.occ"):
        monkeypatch.delitem(sys.modules, name, raising=False)

    def fail(_):
        raise error

    monkeypatch.setattr("cardan.physics.fem.ngsolve_import.import_module", fail)
    with pytest.raises(MissingDependencyError, match=says):
        import_ngsolve()
    with pytest.raises(MissingDependencyError, match=says):  # and not blamed on the shape
        build_solid(UShape(**U))


def test_the_highest_plain_stress_is_among_the_worst_whatever_fatigue_says():
    """A toe that bears a fifth of what the sheet does is the worst of three under either load.

    The sheet at 600 MPa beside 200 counts for a third by its weight, and yields first all the same:
    it, and what is within a tenth of it, is followed too; at 450 it is not.
    """
    high = np.array([[200.0, 50.0], [600.0, 600.0], [550.0, 450.0]])
    share = _share_of_worst(high, np.array([9.0, 1.0, 1.0]))
    assert share[:, 0] == pytest.approx([1, 1, 550 / 600])
    assert share[:, 1] == pytest.approx([450 / 600, 1, 450 / 600])
    plain = _share_of_worst(high, np.ones(3))
    np.testing.assert_allclose(plain, high / 600)
    heavy = _share_of_worst(high, np.array([90.0, 1.0, 1.0]))
    assert heavy[2] == pytest.approx([550 / 600, 450 / 4500])


def test_of_two_ways_to_be_held_the_worse_is_followed():
    """Under the second load the clamped flange makes bend 2 the worst of all; bend 3 it has alone.

    What is told of a feature is of the way whose top is higher, load by load.
    """
    sliding = {(0, 1): np.array([100.0, 50.0]), (0, 2): np.array([80.0, 60.0])}
    clamped = {(0, 1): np.array([90.0, 50.0]), (0, 2): np.array([82.0, 90.0])}
    alone = clamped | {(0, 3): np.array([10.0, 70.0])}
    found = _worse([sliding, alone], [sliding, alone])
    assert [*found] == [(0, 1), (0, 2), (0, 3)]
    np.testing.assert_array_equal(np.stack([*found.values()]), [[100, 50], [82, 90], [10, 70]])
    off = _worse([sliding, clamped], [{f: 0 * t for f, t in sliding.items()}, clamped])
    np.testing.assert_array_equal(off[0, 2], [82, 90])
    np.testing.assert_array_equal(off[0, 1], [0, 0])
    assert _firm_matters(sliding, found, found, np.ones(5))
    # Four per cent above the sliding one, or far below the worst: what slides tells enough.
    near = {(0, 1): np.array([104.0, 52.0]), (0, 2): np.array([80.0, 60.0])}
    near |= {(0, 3): np.array([60.0, 40.0])}
    assert not _firm_matters(sliding, near, near, np.ones(5))
    # But where its elements are too large to read it, it may be among the worst after all.
    assert _firm_matters(sliding, near, near | {(0, 3): np.array([60.0, 75.0])}, np.ones(5))


def test_what_pulls_straight_off_the_frame_is_known_by_its_largest_force():
    """The ring's outside is up: a pull down takes it off, one 40 degrees aside does not."""
    nodes = SimpleNamespace(
        points=np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
        faces=np.array([[0, 1, 2], [0, 1, 3]]), face_names=np.array(["bolt 1", "bolt 1 wall"]),
    )  # fmt: skip
    down, aside = np.array([0, 0, -2e3]), 2e3 * np.array([np.sin(0.7), 0, -np.cos(0.7)])
    assert _pulls_off(nodes, np.stack([down, aside / 2]))
    assert not _pulls_off(nodes, np.stack([down / 2, aside]))
    assert not _pulls_off(nodes, -down[None])
    assert not _pulls_off(nodes, 0 * down[None])


def test_of_a_long_recording_no_stress_is_missed():
    """Against every moment: a line stands, pulls one way, and is shaken where nothing feels it.

    Moments were asked that lie far from the mean: 5000 N were told as 534 MPa, and make 848.
    """
    random = np.random.default_rng(4)
    loads = random.uniform([-10, -500, 2990], [10, 500, 3010], size=(14_000, 3))
    loads[:1100, 2] = 0
    loads[9000:9009, 1] = 700
    loads[2000:3500, 0] = 4000
    unit = random.standard_normal((30, 3, 6)) * [[0.01], [1.0], [0.5]] * 1e5
    level, found = _stressed(unit, loads, np.sqrt(np.mean(unit**2, axis=(0, 2))))
    stress = superpose(unit, loads)
    assert level == pytest.approx(von_mises(stress).max(axis=1), rel=1e-12)
    assert found.von_mises.value == pytest.approx(level.max(), rel=1e-12)
    assert found.von_mises.point == level.argmax()
    every = stress_extremes(unit, loads)
    assert (found.max_principal.value, found.max_principal.point) == pytest.approx(
        (every.max_principal.value, every.max_principal.point)
    )


@pytest.mark.slow
def test_gauges_tell_how_the_flange_is_held():
    """Between two influences, a third of the way: by sine forces and gauges off by chance."""
    random = np.random.default_rng(9)
    sliding = 1e-8 * random.standard_normal((6, 3))
    change = 0.3e-8 * random.standard_normal((6, 3))
    forces = random.normal(scale=[100, 300, 200], size=(400, 3))
    unsure = np.full((6, 3), 0.02e-8)
    told, off = [], []
    for _ in range(200):
        true = sliding + change / 3 + unsure * random.standard_normal((6, 3))
        back = recover_loads_and_flange_clamping(
            sliding, sliding + change, forces @ true.T, unsure=unsure
        )
        told.append(back.flange_fixity)
        size = forces.std(axis=0)
        off.append(
            np.linalg.norm(back.load_error_components(size), axis=1)
            / (back.loads - forces).std(axis=0)
        )
    assert np.mean(told) == pytest.approx(1 / 3, abs=0.02)
    assert 0.01 < np.std(told) < 0.15
    # By how much forces are off, told within a factor of two in the mean, for each.
    rms = 1 / np.sqrt(np.mean(1 / np.square(off), axis=0))
    assert np.all((rms > 0.8) & (rms < 2.5)), rms
    # Three gauges know nothing of it.
    three = recover_loads_and_flange_clamping(
        sliding[:3], (sliding + change)[:3], forces @ sliding[:3].T, unsure=unsure[:3]
    )
    assert three.flange_fixity == 0
    other = recover_loads(sliding[:3] + change[:3], forces @ sliding[:3].T).loads
    assert np.abs(three.fixity_error) @ np.abs(forces[0]) == pytest.approx(
        np.abs(np.linalg.inv(sliding[:3]) @ change[:3]) @ np.abs(forces[0])
    )
    assert np.abs(other - forces).std() > 0


def test_forces_read_by_somebody_are_off_where_he_read_them():
    """Along what gauges hardly feel nobody read them: neither gauges nor flange move them there."""
    sliding = np.array([[60, 1, 3], [-60, 2, 3], [15, 1, -5], [0, -1, -30.0]]) * 1e-9
    clamped, forces = 1.2 * sliding, np.array([[10.0, 500, 40], [-20, 300, 10]])
    back = correct_loads_for_flange_clamping(
        sliding, clamped, forces, unsure=0.02 * np.abs(sliding)
    )
    assert back.loads is forces
    _, gains, ways = np.linalg.svd(sliding)
    assert gains[-1] < 0.2 * gains[0]
    assert back.load_error_components(np.array([10.0, 500, 40])).T @ ways[-1] == pytest.approx(
        0, abs=1e-6
    )
    assert back.fixity_error @ ways[0] == pytest.approx(0.2 * ways[0])


@pytest.mark.parametrize("force", [0.0, 500.0])
def test_a_long_recording_that_stands_still_is_one_moment(force):
    """A dead sensor, or a parked truck: nothing turns, and the program said it was at fault."""
    still = np.zeros((2001, 9))
    still[:, 0] = force
    way: Any = SimpleNamespace(rms_stress_per_load=np.ones(9))
    assert BoundaryCase.telling(way, still).tolist() == still[:1].tolist()


def test_a_point_that_is_told_is_asked_how_it_swings():
    """Its twin, a millionth the larger, went first, and was told beside it as if it were still."""
    unit, normals = np.zeros((1, 1, 6)), np.array([[0.0, 0, 1]])
    unit[..., 0] = 1.0
    way: Any = SimpleNamespace(
        held=SimpleNamespace(zones=SimpleNamespace(kind=np.zeros(1, dtype=int))), count=1,
        feature=np.zeros(1, dtype=int), flat=mohr_components(unit, normals),
        planes=lambda at: normal_stress_on_planes(unit[at], plane_directions(normals[at])),
    )  # fmt: skip
    wave = np.cos(2 * np.pi * np.arange(32) / 32)[None, :, None]
    points = [100 * wave, 100 * (1 + 1e-6) * wave]
    found = np.zeros((2, 4))
    at, reaches = np.zeros(1, dtype=int), [load_envelope(one) for one in points]
    _swung_most(way, at, points, reaches, {}, found, told=0)
    assert found[:, 0] == pytest.approx([100, 100], rel=1e-5)

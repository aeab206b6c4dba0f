"""The refinement a bracket goes through, on cases whose answer is published or exact.

Each starts from a coarse mesh and is left alone: no edge, no degree, no grading by hand. The
answer must lie within the error the refinement itself estimates, or 1 %, of the equivalent stress.
"""

from dataclasses import replace

import numpy as np
import pytest
from test_bracket_nafems import STEEL, D, quarter_ellipse

from cardan.physics.fem import adaptive_refinement as refine
from cardan.physics.fem.adaptive_refinement import ElasticityProblem, solve_adaptively
from cardan.physics.fem.ngsolve_import import import_ngsolve
from cardan.physics.fem.stress import von_mises

pytestmark = pytest.mark.bracket

XX, YY, ZZ = 0, 1, 2


def le1():
    """NAFEMS LE1: 92.7 MPa at D, plane stress; half of a thin plate about its middle plane."""
    shape = quarter_ellipse(0.05)
    held = {"x0": "x", "y0": "y", "bottom": "z"}
    return problem(shape, held, "outer", 10e6, size=0.6), (*D, 0.0), YY, 92.7e6


def le10():
    """NAFEMS LE10: -5.38 MPa at D on the loaded face of a thick plate."""
    shape = quarter_ellipse(0.3, 0.3)
    for edge in shape.edges:
        c = edge.center
        rim = (c.x / 3.25) ** 2 + (c.y / 2.75) ** 2 > 0.75
        if abs(c.z - 0.3) < 1e-6 and rim and abs(c.x) > 1e-3 and abs(c.y) > 1e-3:
            edge.name = "middle"
    held = {"x0": "x", "y0": "y", "outer": "xy"}
    made = problem(shape, held, "top", -1e6, size=0.4, held_edges={"middle": "z"})
    return made, (*D, 0.6), YY, -5.38e6


def hole():
    """A plate with a hole a tenth of its width: 3.032 by Heywood (1952)."""
    occ = import_ngsolve().occ
    d, W, L, t = 0.01, 0.1, 0.15, 0.001
    plate = occ.MoveTo(0, 0).Rectangle(L, W / 2).Face() - occ.WorkPlane().Circle(d / 2).Face()
    shape = plate.Extrude(t / 2 * occ.Z)
    held = named(shape, lambda c: {"x0": c.x, "y0": c.y, "z0": c.z, "pull": c.x - L})
    return problem(shape, held, "pull", 1.0, size=W / 6), (0, d / 2, 0.0), XX, 3.032


def cylinder():
    """Lame's thick cylinder under pressure inside: hoop p (b2 + a2) / (b2 - a2)."""
    occ = import_ngsolve().occ
    a, b, h = 1.0, 2.0, 0.4
    ring = occ.WorkPlane().Circle(b).Face() - occ.WorkPlane().Circle(a).Face()
    shape = (ring * occ.MoveTo(0, 0).Rectangle(3, 3).Face()).Extrude(h * occ.Z)
    held = named(shape, lambda c: {"x0": c.x, "y0": c.y, "z0": c.z * (c.z - h)}, inner=1.5)
    return problem(shape, held, "inner", -1.0, size=0.5), (a, 0.0, h / 2), YY, 5 / 3


def cavity():
    """A small hollow sphere in tension: (27 - 15 nu) / (2 (7 - 5 nu)); Goodier (1933)."""
    occ = import_ngsolve().occ
    a, W = 1.0, 7.0
    shape = occ.Box((0, 0, 0), (W, W, W)) - occ.Sphere((0, 0, 0), a)
    held = named(shape, lambda c: {"x0": c.x, "y0": c.y, "z0": c.z, "pull": c.z - W})
    nu = STEEL.poisson
    return (
        problem(shape, held, "pull", 1.0, size=2.5),
        (a, 0, 0),
        ZZ,
        (27 - 15 * nu) / (2 * (7 - 5 * nu)),
    )


def shaft():
    """A bar in tension, its ends free to shrink: 1 everywhere, and nothing to refine."""
    occ = import_ngsolve().occ
    shape = occ.Box((0, 0, 0), (1, 1, 4))
    held = named(shape, lambda c: {"x0": c.x, "y0": c.y, "z0": c.z, "pull": c.z - 4})
    return problem(shape, held, "pull", 1.0, size=1.0), (1.0, 0.5, 2.0), ZZ, 1.0


def bent():
    """A bar under a linear pull on its ends, M y / I exactly: 1 at its top."""
    occ, ngs = import_ngsolve().occ, import_ngsolve().ngs
    shape = occ.Box((0, -0.5, 0), (0.5, 0.5, 3))
    held = named(shape, lambda c: {"x0": c.x, "z0": c.z, "pull": c.z - 3})
    for edge in shape.edges:
        c = edge.center
        if abs(c.z) < 1e-7 and abs(c.y - 0.5) < 1e-7:
            edge.name = "top"
    made = problem(shape, {"x0": held["x0"], "z0": "z"}, "pull", 2 * ngs.y, size=0.7,
                   held_edges={"top": "y"})  # fmt: skip
    return made, (0.25, 0.5, 1.5), ZZ, 1.0


def sphere():
    """Lame's thick sphere under pressure inside: hoop p (b3 + 2 a3) / (2 (b3 - a3))."""
    occ = import_ngsolve().occ
    a, b = 1.0, 2.0
    shape = (occ.Sphere((0, 0, 0), b) - occ.Sphere((0, 0, 0), a)) * occ.Box((0, 0, 0), (3, 3, 3))
    held = named(shape, lambda c: {"x0": c.x, "y0": c.y, "z0": c.z})
    for face in shape.faces:
        c = face.center
        if face.name == "free" and np.hypot(np.hypot(c.x, c.y), c.z) < 1.5:
            face.name = "inner"
    return problem(shape, held, "inner", -1.0, size=0.7), (a, 0.0, 0.0), YY, 10 / 14


def ellipse():
    """An elliptic hole, twice as wide across the pull as along it: 1 + 2 a / b; Inglis (1913).

    Of an infinite plate; this is square and twelve times as wide as its hole, which adds 1.6 %:
    5.079 on a mesh of cubic elements, a fiftieth of the hole at its tip.
    """
    occ = import_ngsolve().occ
    W = 12.0
    plate = occ.MoveTo(0, 0).Rectangle(W, W).Face() - occ.WorkPlane().Ellipse(1.0, 0.5).Face()
    shape = plate.Extrude(0.02 * occ.Z)
    held = named(shape, lambda c: {"x0": c.x, "y0": c.y, "z0": c.z, "pull": c.y - W})
    return problem(shape, held, "pull", 1.0, size=2.5), (1.0, 0.0, 0.0), YY, 5.079


def pulled_both_ways():
    """A hole in a sheet pulled alike both ways: 2 (1 + d2 / W2 ...); Kirsch, as Lame's ring."""
    occ = import_ngsolve().occ
    a, b = 1.0, 8.0
    disc = occ.WorkPlane().Circle(b).Face() - occ.WorkPlane().Circle(a).Face()
    shape = (disc * occ.MoveTo(0, 0).Rectangle(9, 9).Face()).Extrude(0.05 * occ.Z)
    held = named(shape, lambda c: {"x0": c.x, "y0": c.y, "z0": c.z})
    for face in shape.faces:
        c = face.center
        if face.name == "free" and np.hypot(c.x, c.y) > 6:
            face.name = "rim"
    want = 2 * b**2 / (b**2 - a**2)
    return problem(shape, held, "rim", 1.0, size=2.0), (a, 0.0, 0.0), YY, want


def named(shape, of, *, inner=0.0):
    """Name faces by which of some numbers is nil at their centre; return those of symmetry."""
    for face in shape.faces:
        c = face.center
        name = next((n for n, v in of(c).items() if abs(v) < 1e-7), "free")
        face.name = "inner" if name == "free" and np.hypot(c.x, c.y) < inner else name
    return {"x0": "x", "y0": "y", "z0": "z"}


def problem(shape, held, loaded, pressure, *, size, held_edges=None):
    """A problem with a traction along the normal of a face."""

    def loads(body):
        normal = import_ngsolve().ngs.specialcf.normal(3)
        return body.traction(loaded, pressure * normal)[None]

    return ElasticityProblem(
        shape=shape,
        material=STEEL,
        fixed_faces=held,
        fixed_edges=held_edges or {},
        loads=loads,
        element_size=size,
        thickness=size,
    )


CASES = [le1, le10, hole, cylinder, cavity, shaft, bent, sphere, pulled_both_ways, ellipse]
TOP = {  # von Mises stress where it is highest: hoop, with radial and axial stress by the formulas
    hole: 3.032,
    cylinder: np.sqrt((5 / 3) ** 2 + 5 / 3 + 1),
    shaft: 1.0,
    sphere: 12 / 7,
    pulled_both_ways: 2 * 64 / 63,
    ellipse: 5.079,
}


@pytest.mark.parametrize("coarser", [0.7, 1.0])
@pytest.mark.parametrize("case", CASES)
def test_default_refinement_matches_published_solutions(case, coarser):
    made, point, component, want = case()
    made = replace(made, element_size=coarser * made.element_size)
    found = solve_adaptively(made, cases=[np.ones((1, 1))], watch=[point])
    stress, level = found.watched_stress[0, 0, component], von_mises(found.watched_stress[0, 0])
    error = found.watched_error[0]  # of the equivalent stress, a share of it
    assert abs(stress - want) < max(error, 0.01) * level, (stress, error, len(found.stress_maxima))
    assert error < 0.08
    if case in TOP:  # what a study tells: the highest of a feature, wherever it is
        tops = {
            key: found.stress_maxima[-1][key].max() for key in found.final_solution.zones.features
        }
        worst = max(tops, key=tops.__getitem__)
        assert abs(tops[worst] - TOP[case]) < max(found.error[worst], 0.01) * tops[worst]


def test_missed_stress_beyond_notch_is_reported_and_refined(monkeypatch):
    """A sheet fifty times as thin as its hole, meshed with elements far wider than it is thick.

    At the tip the elements are small and agree to half a per cent; 4.75 they say, and 4.84 when
    they are made smaller, where 5.08 is right: the large ones beyond the tip give too little.
    """
    made, point, component, want = ellipse()
    coarse = solve_adaptively(made, cases=[np.ones((1, 1))], watch=[point], levels=1)
    off = 1 - coarse.watched_stress[0, 0, component] / want
    assert off > 0.05
    assert off < coarse.watched_error[0] < 2 * off
    # Who does not ask what lies beyond refines at the tip, and is outside of what he says:
    monkeypatch.setattr(refine, "pollution_error", lambda *asked: np.zeros((len(asked[-1]), 1)))
    deaf = solve_adaptively(made, cases=[np.ones((1, 1))], watch=[point])
    assert abs(deaf.watched_stress[0, 0, component] / want - 1) > 1.5 * deaf.watched_error[0]

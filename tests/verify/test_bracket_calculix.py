"""A bracket against CalculiX (Dhondt, calculix.de), an independent program, on the same mesh."""

import calculix
import numpy as np
import pytest
from brackets import BRACKET, LINE
from scipy.spatial import cKDTree
from sharp_edges import singular_edge_points

from cardan.application.reader import read
from cardan.core.units import MPa, mm
from cardan.model.bracket import LShape, UShape
from cardan.model.material import STEEL
from cardan.physics.fem.geometry import build_solid
from cardan.physics.fem.stress import von_mises
from cardan.physics.fem.unit_loads import mesh_and_solve_unit_loads
from cardan.topics.bracket.assessment import BracketShapeAssessor
from cardan.topics.bracket.calculix_file import inp_text
from cardan.topics.bracket.solver_deck import solver_deck
from cardan.topics.bracket.vtk_file import (
    displacement_and_stress_at_case_peak,
    max_displacement_at_peak,
)

pytestmark = [pytest.mark.oracle, pytest.mark.bracket]

U = UShape(
    seat_diameter=100 * mm, width=70 * mm, thickness=6 * mm, height=90 * mm, flange=55 * mm,
    bend_radius=10 * mm, bolt_diameter=11 * mm, bolt_pitch=40 * mm,
)  # fmt: skip
L = LShape(
    seat_diameter=52 * mm, width=180 * mm, wall_width=144 * mm, depth=90 * mm, thickness=8 * mm,
    height=80 * mm, rim=24 * mm, fillet=5 * mm, bolt_diameter=11 * mm, bolt_edge=14 * mm,
    gusset=8 * mm, gusset_height=50 * mm,
)  # fmt: skip


@pytest.fixture(scope="module", params=[U, L], ids=["U", "L"])
def both(request, tmp_path_factory):
    units = mesh_and_solve_unit_loads(build_solid(request.param), STEEL, hold="clamped")
    nodes = units.elastic.nodes
    text = calculix.deck(
        nodes,
        STEEL,
        held=tuple(units.solid.fixed_faces("clamped")),
        loads=calculix.seat_loads(nodes),
        modes=6,
    )
    static, frequencies, _ = calculix.run(text, tmp_path_factory.mktemp("ccx"))
    return units, static, frequencies


def test_displacements_match_calculix(both):
    """To 1e-4 of the largest: CalculiX integrates curved elements with four points only."""
    units, static, _ = both
    ours = units.at_nodes[0]
    assert len(static) == 6
    for k, (u, _) in enumerate(static):
        assert np.abs(u - ours[:, k]).max() < 1e-4 * np.abs(ours[:, k]).max()


def gauge_sites(nodes, *, held, thickness):
    """Return which nodes lie on flat faces, clear of edges, in straight elements alone.

    CalculiX carries stress from four points inside an element to its corners in straight
    lines: exact in straight elements, where the comparison is made, and a few per cent off
    in curved ones. Both take the mean of the elements that meet at a corner.
    """
    corners = nodes.points[nodes.elements]
    ends = np.array([(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)])
    straight = corners[:, ends].mean(axis=2)
    bent = np.linalg.norm(corners[:, 4:] - straight, axis=-1).max(axis=1) > 1e-9
    edges = singular_edge_points(nodes, held=held)
    flat = np.zeros(len(nodes.points), dtype=bool)
    away, _ = cKDTree(edges).query(nodes.points[nodes.surface_nodes])
    clear = away > 1.5 * thickness
    flat[nodes.surface_nodes[clear]] = True
    flat[nodes.elements[bent]] = False
    flat[nodes.elements[:, 4:]] = False
    return flat


def test_stresses_at_gauge_sites_match_calculix(both):
    """On flat faces: to 1e-4 of the case's highest stress there, far below a gauge's 1 %."""
    units, static, _ = both
    nodes, ours = units.elastic.nodes, units.at_nodes[1]
    held = tuple(units.solid.fixed_faces("clamped"))
    flat = gauge_sites(nodes, held=held, thickness=units.solid.thickness)
    assert flat.sum() > 500
    for k, (_, s) in enumerate(static[:3]):
        level = von_mises(ours[flat, k]).max()
        assert np.abs(s[flat] - ours[flat, k]).max() < 1e-4 * level


def test_natural_frequencies_match_calculix(both):
    units, _, frequencies = both
    assert units.modes(6)[0] == pytest.approx(frequencies[:6], rel=1e-4)


def test_written_deck_gives_our_displacements_and_stresses(tmp_path):
    """`--inp`, in mm and MPa: forces, moments, accelerations, and the driveline's own loads.

    To 1e-4, as above; nothing is added to the deck but threads. Then its step of frequencies.
    """
    (tmp_path / "a.yaml").write_text(LINE + BRACKET + """\
  element_mm: 12
  cases:
    - {name: twist, force_N: [10, 20, 30], moment_Nm: [200, 100, -300]}
    - {name: pothole, acceleration_g: [0.5, 1, 4]}
""")  # fmt: skip
    application = read(tmp_path / "a.yaml")
    v = BracketShapeAssessor.from_application(application).assess(
        application.bracket.shape, name="original", levels=1
    )
    deck = solver_deck(application.bracket, v, title=application.title)
    static, _, _ = calculix.run(inp_text(deck), tmp_path)
    assert len(static) == len(v.case_results) > 3
    nodes = v.solved.nodes
    flat = gauge_sites(nodes, held=tuple(deck.held), thickness=v.solved.thickness)
    assert flat.sum() > 50
    for (u, s), o in zip(static, v.case_results, strict=True):
        moved = np.linalg.norm(u[: len(nodes.points)], axis=1).max() * mm
        assert moved == pytest.approx(max_displacement_at_peak(v, o).value, rel=1e-4)
        ours = displacement_and_stress_at_case_peak(v, o)[1][flat] / MPa
        assert np.abs(von_mises(s[: len(nodes.points)][flat]) - ours).max() < 1e-4 * ours.max()
    *head, step = inp_text(deck).partition("** Step 1:")[0].rpartition("** *STEP\n")
    text = "".join((*head[:1], "*STEP\n", step.replace("** ", "")))
    _, frequencies, _ = calculix.run(text, tmp_path)
    assert frequencies[:6] == pytest.approx(deck.frequencies, rel=1e-4)

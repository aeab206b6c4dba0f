"""A bracket against CalculiX (Dhondt, calculix.de), an independent program, on the same mesh."""

import calculix
import numpy as np
import pytest

from cardan.base.units import mm
from cardan.bracket.shape import solid
from cardan.bracket.stress import von_mises
from cardan.bracket.surface import away_from, sharp_edges
from cardan.bracket.unit import unit_solutions
from cardan.model.bracket import LShape, UShape
from cardan.model.material import STEEL

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
    units = unit_solutions(solid(request.param), STEEL, hold="clamped")
    nodes = units.elastic.nodes
    text = calculix.deck(
        nodes,
        STEEL,
        held=tuple(units.solid.held("clamped")),
        loads=calculix.seat_loads(nodes),
        modes=6,
    )
    static, frequencies, _ = calculix.run(text, tmp_path_factory.mktemp("ccx"))
    return units, static, frequencies


def test_displacements_agree(both):
    """To 1e-4 of the largest: CalculiX integrates curved elements with four points only."""
    units, static, _ = both
    ours = units.at_nodes[0]
    assert len(static) == 6
    for k, (u, _) in enumerate(static):
        assert np.abs(u - ours[:, k]).max() < 1e-4 * np.abs(ours[:, k]).max()


def test_stresses_agree_where_gauges_sit(both):
    """On flat faces: to 1e-4 of the case's highest stress there, far below a gauge's 1 %.

    CalculiX carries stress from four points inside an element to its corners in straight
    lines: exact in straight elements, where the comparison is made, and a few per cent off
    in curved ones. Both take the mean of the elements that meet at a corner.
    """
    units, static, _ = both
    nodes, ours = units.elastic.nodes, units.at_nodes[1]
    corners = nodes.points[nodes.elements]
    ends = np.array([(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)])
    straight = corners[:, ends].mean(axis=2)
    bent = np.linalg.norm(corners[:, 4:] - straight, axis=-1).max(axis=1) > 1e-9
    held = tuple(units.solid.held("clamped"))
    edges = sharp_edges(nodes, held=held)
    flat = np.zeros(len(nodes.points), dtype=bool)
    clear = away_from(nodes.points[nodes.surface], edges, distance=1.5 * units.solid.thickness)
    flat[nodes.surface[clear]] = True
    flat[nodes.elements[bent]] = False
    flat[nodes.elements[:, 4:]] = False
    assert flat.sum() > 500
    for k, (_, s) in enumerate(static[:3]):
        level = von_mises(ours[flat, k]).max()
        assert np.abs(s[flat] - ours[flat, k]).max() < 1e-4 * level


def test_natural_frequencies_agree(both):
    units, _, frequencies = both
    assert units.modes(6)[0] == pytest.approx(frequencies[:6], rel=1e-4)

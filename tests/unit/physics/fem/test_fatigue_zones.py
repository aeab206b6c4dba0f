"""Where a crack may start, and what decides it there: needs the extra cardan[bracket]."""

from dataclasses import replace

import numpy as np
import pytest

from cardan.core.units import mm
from cardan.model.bracket import UShape
from cardan.model.material import STEEL
from cardan.physics.fem import fatigue_zones as zones
from cardan.physics.fem.elasticity import assemble_elastic_solid
from cardan.physics.fem.fatigue_zones import (
    ZONE_BOLT_BORDER,
    ZONE_CUT_EDGE,
    ZONE_SHEET,
    ZONE_WELD_TOE,
    find_fatigue_zones,
    wall_thickness,
)
from cardan.physics.fem.geometry import build_solid
from cardan.physics.fem.meshing import mesh
from cardan.physics.fem.ngsolve_import import import_ngsolve
from cardan.physics.fem.stress import von_mises
from cardan.physics.fem.surface import find_surface_edges, project_to_surface

pytestmark = pytest.mark.bracket

T = 5 * mm
U = UShape(
    seat_diameter=100 * mm, width=70 * mm, thickness=6 * mm, height=90 * mm, flange=55 * mm,
    bend_radius=10 * mm, bolt_diameter=11 * mm, bolt_pitch=40 * mm, gusset=4 * mm,
    gusset_height=50 * mm,
)  # fmt: skip


@pytest.fixture(scope="module")
def plate():
    """A plate 100 by 60, 5 mm thick, with a block on its middle: four toes without a radius."""
    occ = import_ngsolve().occ
    shape = occ.Box((-0.05, -0.03, 0), (0.05, 0.03, T)) + occ.Box(
        (-0.01, -0.01, T / 2), (0.01, 0.01, 3 * T)
    )
    for face in shape.faces:
        face.name = "end" if face.center.x < -0.05 + 1e-9 else "free"
    return assemble_elastic_solid(mesh(shape, size=3 * mm), STEEL, held={"end": "xyz"})


def test_every_surface_node_is_covered_by_an_evaluation_point(plate):
    """Nothing is dropped: each node is told of by itself or by the nearest toe or border."""
    nodes = plate.nodes
    zones = find_fatigue_zones(nodes, held=("end",), thickness=T)
    every = zones.points(nodes)
    assert zones.nearest_place.min() >= 0
    away = np.linalg.norm(every[zones.nearest_place] - nodes.points[nodes.surface_nodes], axis=1)
    on_end = nodes.points[nodes.surface_nodes, 0] < -0.05 + 1e-9
    assert away[~on_end].max() <= 1.25 * T  # a wall from a toe, and to the middle of its edge
    kinds = {kind for kind, _ in zones.features}
    assert kinds == {ZONE_SHEET, ZONE_CUT_EDGE, ZONE_WELD_TOE, ZONE_BOLT_BORDER}
    # The toe is one chain round the block, seen from the plate and from the block.
    toes = zones.lines.points[zones.kind[len(zones.surface_stress_nodes) :] == ZONE_WELD_TOE]
    assert np.abs(toes[:, 2] - T).max() < 1e-9
    assert np.abs(np.abs(toes[:, :2]).max(axis=1) - 0.01).max() < 1e-9
    assert sum(kind == ZONE_WELD_TOE for kind, _ in zones.features) == 1


@pytest.mark.parametrize("broken", ["sharp", "MakeFillet", "MakeChamfer"])
def test_cut_edge_is_detected_with_sharp_or_broken_corners(broken):
    """By 0.5 mm of 5: then it was sheet, which bears twice as much, where FAT 125 asks for that."""
    shape = import_ngsolve().occ.Box((-0.01, -0.03, 0), (0.01, 0.03, T))
    if broken != "sharp":
        long = [e for e in shape.edges if abs(e.center.y) > 0.0299 and abs(e.center.x) < 1e-9]
        shape = getattr(shape, broken)(long, 0.5 * mm)
    for face in shape.faces:
        face.name = "end" if face.center.x < -0.01 + 1e-9 else "free"
    nodes = assemble_elastic_solid(mesh(shape, size=4 * mm), STEEL, held={"end": "xyz"}).nodes
    zones = find_fatigue_zones(nodes, held=("end",), thickness=T)
    x, y, _ = np.abs(nodes.points[zones.surface_stress_nodes]).T
    cut = zones.kind[: len(zones.surface_stress_nodes)] == ZONE_CUT_EDGE
    assert cut[(y > 0.0299) & (x < 0.004)].all()
    assert not cut[(y < 0.029) & (x < 0.004)].any()


def test_small_inner_fillet_is_not_a_cut_edge():
    """As narrow and as round as a broken corner, but inwards: sheet goes on there."""
    occ = import_ngsolve().occ
    shape = occ.Box((-0.02, 0, 0), (0.02, 0.01, T)) + occ.Box((0, 0, 0), (T, 0.01, 4 * T))
    toe = [
        e for e in shape.edges if abs(e.center.x * (e.center.x - T)) + abs(e.center.z - T) < 1e-9
    ]
    shape = shape.MakeFillet(toe, 0.5 * mm)
    nodes = assemble_elastic_solid(mesh(shape, size=4 * mm), STEEL, held={"default": "xyz"}).nodes
    assert not zones._breaking(nodes, find_surface_edges(nodes), 0.25 * T)[1].any()
    outside = shape.MakeFillet([e for e in shape.edges if abs(e.center.z - 4 * T) < 1e-9], 0.5 * mm)
    nodes = assemble_elastic_solid(mesh(outside, size=4 * mm), STEEL, held={"default": "xyz"}).nodes
    _, rounds = zones._breaking(nodes, find_surface_edges(nodes), 0.25 * T)
    found = nodes.points[nodes.faces[rounds[nodes.face_numbers]]]
    assert found[..., 2].min() > 4 * T - 0.6 * mm


@pytest.mark.parametrize("broken", ["MakeFillet", "MakeChamfer"])
@pytest.mark.parametrize(("size", "cut"), [((16, 14, 14), False), ((16, 20, 5), True)])
def test_broken_edges_of_solid_block_are_not_cut_edges(broken, size, cut):
    """A lug of 14 mm square in a bracket of 5 mm walls; of a plate all round it is one.

    With the patches where three of them meet.
    """
    x, y, z = (s * mm for s in size)
    occ = import_ngsolve().occ
    shape = occ.Box((0, 0, 0), (x, y, z))
    shape = getattr(shape, broken)([e for e in shape.edges if e.center.x > mm / 2], mm)
    for face in shape.faces:
        face.name = "end" if face.center.x < 1e-9 else "free"
    nodes = assemble_elastic_solid(mesh(shape, size=5 * mm), STEEL, held={"end": "xyz"}).nodes
    zones = find_fatigue_zones(nodes, held=("end",), thickness=T)
    own = zones.kind[: len(zones.surface_stress_nodes)] == ZONE_CUT_EDGE
    if not cut:
        assert not own.any()
        return
    at = nodes.points[zones.surface_stress_nodes]
    inside = np.abs(at[:, 1] - y / 2) < y / 2 - 1.01 * mm
    skin = inside & (at[:, 0] < x - 1.01 * mm)
    assert not own[skin].any()
    assert own[~skin].all()


def test_structural_stress_extrapolates_linear_field(plate):
    """sigma = 1.67 sigma(0.4 t) - 0.67 sigma(1.0 t), by hand on a field that is known."""
    nodes = plate.nodes
    zones = find_fatigue_zones(nodes, held=("end",), thickness=T)
    lines = zones.lines
    kind = zones.kind[len(zones.surface_stress_nodes) :]
    # On the plate ahead of the block: the toe at x = -10 mm, looking along -x.
    mine = (kind == ZONE_WELD_TOE) & (lines.normals[:, 2] > 0.9) & (lines.frames[:, 0, 0] < -0.9)
    assert mine.sum() > 3
    x = nodes.points[:, 0]
    stress = np.zeros((len(x), 1, 6))
    stress[:, 0, 0] = 100.0 + 4000.0 * (x + 0.01) ** 2 / T**2  # square in the distance
    stress[:, 0, 2] = 7.0  # across the surface: no such thing, and left out
    near, far = 100 + 4000 * 0.4**2, 100 + 4000 * 1.0**2
    found = lines.structural_stress(nodes, stress)[mine, 0]
    want = 0.4 / 0.6
    assert found[:, 0] == pytest.approx(near + want * (near - far), rel=0.02)
    assert np.abs(found[:, 1:]).max() < 1e-6 * near
    assert lines.can_extrapolate[mine].all()
    # Along the edge, off the corner, the distances are those of the rule.
    gap = np.linalg.norm(lines.near.points - lines.points, axis=1)[mine]
    assert gap == pytest.approx(0.4 * T, rel=0.02)


@pytest.mark.parametrize(
    ("gap", "rib", "alone"),
    [(1.0, 1.0, True), (1.1, 1.0, True), (0.7, 0.2, True), (1.6, 1.0, False)],
)
def test_structural_stress_ignores_adjacent_weld_toe(gap, rib, alone):
    """A strip, pulled and bent, with two ribs: by statics what acts between them is the nominal.

    Membrane and bending there are those of any section. 1.1 t apart they were told 0.79 and 0.73
    of it, for the second reading was the other toe's notch; beyond a narrow rib 0.97 and 0.96.
    """
    occ, z = import_ngsolve().occ, import_ngsolve().ngs.z
    t, wide, high = 10 * mm, 6 * mm, 22 * mm
    shape = occ.Box((-80 * mm, 0, 0), (80 * mm, wide, t))
    half = gap * t / 2
    for low, end in ((half, half + t), (-half - rib * t, -half)):
        shape += occ.Box((low, 0, t / 2), (end, wide, high))
    for face in shape.faces:
        x, y = face.center.x, face.center.y
        ends = {-80 * mm: "held", 80 * mm: "pulled"}
        face.name = next((name for at, name in ends.items() if abs(x - at) < 1e-9), "free")
        if y < 1e-9 or y > wide - 1e-9:
            face.name = "side"
    finer = [((x, wide / 2, h), 1.2 * mm) for h in (3 * mm, t) for x in np.linspace(-t, t, 7)]
    body = assemble_elastic_solid(
        mesh(shape, size=4 * mm, finer=finer), STEEL, held={"held": "xyz", "side": "y"}
    )
    ways = [(1.0, 0, 0), ((z - t / 2) / (t / 2), 0, 0)]
    loads = np.stack([body.traction("pulled", import_ngsolve().ngs.CF(way)) for way in ways])
    stress = body.stress_at_nodes(body.solve(loads))
    lines = find_fatigue_zones(body.nodes, held=("held",), thickness=t).lines
    mine = (np.abs(lines.points[:, 0] - half) < 1e-6) & (lines.frames[:, 0, 0] < -0.9)
    mine &= (lines.normals[:, 2] > 0.9) & (np.abs(lines.points[:, 1] - wide / 2) < wide / 3)
    assert mine.any()
    assert (lines.can_extrapolate[mine] != alone).all()
    told = lines.structural_stress(body.nodes, stress)[mine, :, 0]
    assert told == pytest.approx(1.02, abs=0.04)


def test_stress_peak_between_extrapolation_points_is_reported(plate):
    """A ridge 0.7 t from a toe: no node beyond the first reading stands higher than what is told.

    A fillet 0.75 t from a bolt's hole had 118 MPa, and the border that spoke for it said 17.
    """
    nodes = plate.nodes
    zones = find_fatigue_zones(nodes, held=("end",), thickness=T)
    x, y, z = nodes.points.T
    ahead = (z > T - 1e-9) & (np.abs(y) < 0.01)
    stress = np.zeros((len(x), 1, 6))
    stress[:, 0, 1] = ahead * np.exp(-(((x + 0.01 + 0.7 * T) / (0.2 * T)) ** 2))
    toes = zones.lines.points[zones.kind[len(zones.surface_stress_nodes) :] == ZONE_WELD_TOE]
    on = nodes.surface_nodes
    gap = np.linalg.norm(nodes.points[on, None] - toes[None], axis=-1).min(axis=1)
    highest = stress[on[gap > 0.5 * T], 0, 1].max()
    assert highest > 0.7
    assert von_mises(zones.stress(nodes, stress)).max() >= highest


def test_wall_thickness_is_measured(plate):
    """5 mm in the plate, from either side; where there is no other side the usual is taken."""
    at = [(0.03, 0.0, T), (0.03, 0.01, 0.0), (0.0, 0.0, 3 * T)]
    found = wall_thickness(plate.nodes, at, [(0, 0, 1), (0, 0, -1), (0, 0, 1)], usual=6 * mm)
    assert found[:2] == pytest.approx([T, T], rel=1e-6)
    assert found[2] == pytest.approx(6 * mm)
    thin = wall_thickness(
        plate.nodes, at[:1], [(0, 0, 1)], usual=8 * mm
    )  # looked for beyond the plate
    assert thin == pytest.approx([T], rel=1e-6)


def test_edge_turn_distinguishes_notch_and_outer_edge(plate):
    edges = find_surface_edges(plate.nodes)
    turns = np.degrees(edges.turn_angle)
    notch = turns > 20
    assert turns[notch] == pytest.approx(90, abs=1e-6)
    assert turns[~notch] == pytest.approx(-90, abs=1e-6)
    at = plate.nodes.points[edges.nodes[notch][:, 1]]
    assert at[:, 2] == pytest.approx(np.full(len(at), T))  # the block's toe, and nowhere else
    assert np.abs(at[:, :2]).max() < 0.011


def test_field_interpolation_is_quadratic_between_nodes(plate):
    nodes = plate.nodes
    at = project_to_surface(nodes, [(0.021, 0.013, 0.006), (-0.03, 0.0, -1.0)])
    x, y, z = nodes.points.T
    square = 3 * x * x - x * y + 2 * y + z
    px, py, pz = at.points.T
    assert at.interpolate(nodes, square) == pytest.approx(
        3 * px * px - px * py + 2 * py + pz, abs=1e-9
    )


def test_bracket_zone_names_do_not_depend_on_mesh():
    """Bends, cut edges, toes of welds, bolts: the same features however fine, however held."""
    body = build_solid(U)
    found = []
    for size, hold in ((10 * mm, "sliding"), (7 * mm, "sliding"), (10 * mm, "clamped")):
        held = body.fixed_faces(hold)
        made = assemble_elastic_solid(mesh(body.shape, size=size), STEEL, held=held)
        found.append(find_fatigue_zones(made.nodes, held=tuple(held), thickness=U.thickness))
    coarse, fine, clamped = (set(z.features) for z in found)
    assert {f for f in coarse if f[0] in (ZONE_WELD_TOE, ZONE_BOLT_BORDER)} == {
        f for f in fine if f[0] in (ZONE_WELD_TOE, ZONE_BOLT_BORDER)
    }
    assert {n for k, n in coarse if k == ZONE_BOLT_BORDER} == {1, 2, 3, 4}
    # Clamped, a border is still its own bolt's: the plane had been counted as the first of five.
    places = np.array(U.bolt_positions)[:, :2]
    for zone in found:
        lines = zone.lines.points[:, :2]
        nearest_bolt = np.linalg.norm(lines[:, None] - places, axis=-1).argmin(axis=1) + 1
        numbers = np.array([n for _, n in zone.features])[
            zone.feature[len(zone.surface_stress_nodes) :]
        ]
        borders = zone.kind[len(zone.surface_stress_nodes) :] == ZONE_BOLT_BORDER
        assert (numbers == nearest_bolt)[borders].all()
    # Each rib's weld meets the sheet in one toe and the rib in another.
    assert len({f for f in coarse if f[0] == ZONE_WELD_TOE}) == 4
    assert {f for f in clamped if f[0] == ZONE_WELD_TOE} == {
        f for f in coarse if f[0] == ZONE_WELD_TOE
    }
    # A weld's own face is not asked: its toes speak for it.
    zones = found[0]
    assert len(set(zones.nearest_place)) > 1000


def test_u_bracket_without_gusset_has_no_weld_toe():
    body = build_solid(replace(U, gusset=0.0))
    held = body.fixed_faces("sliding")
    made = assemble_elastic_solid(mesh(body.shape, size=10 * mm), STEEL, held=held)
    zones = find_fatigue_zones(made.nodes, held=tuple(held), thickness=U.thickness)
    assert {k for k, _ in zones.features} == {ZONE_SHEET, ZONE_CUT_EDGE, ZONE_BOLT_BORDER}


def test_bolt_names_sort_numerically():
    """Of ten bolts the border called 8 was that of bolt 7: "bolt 10" stood before "bolt 2"."""
    names = [f"bolt {k}" for k in range(1, 13)]
    assert sorted(sorted(names), key=zones._counted) == names

"""A bracket in real bolts against the two ways its flange is held: CalculiX, one-sided contact.

Four M10 tightened to 35 kN press a U's flanges against the frame, with friction of 0.15. What
2 kN more do is held against what both of our ways say of it, none of which knows bolts,
contact or friction, and against our own contact. Every pull comes on a flange just tightened:
what slipped in pulls before leaves a stress that no swing has. Pushed up after pulls along and
across the sheet has 32 MPa in CalculiX, by itself 25.

CalculiX: Dhondt, calculix.de.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import calculix
import numpy as np
import pytest

from cardan.core.units import mm
from cardan.model.bracket import Bolts, UShape
from cardan.model.material import STEEL
from cardan.physics.fem.bolted_joint import (
    CONTACT_RING_WIDTH_TO_HOLE_RATIO,
    condense_bracket_to_flange_contact,
)
from cardan.physics.fem.bracket_solid import HOLE_WALL_NAME_SUFFIX, MOUNT_FACE_NAME, BracketSolid
from cardan.physics.fem.elasticity import assemble_elastic_solid
from cardan.physics.fem.fatigue_zones import (
    ZONE_BOLT_BORDER,
    ZONE_CUT_EDGE,
    ZONE_SHEET,
    ZONE_WELD_TOE,
    FatigueZones,
    find_fatigue_zones,
)
from cardan.physics.fem.geometry import build_solid
from cardan.physics.fem.meshing import MeshNodes, mesh
from cardan.physics.fem.ngsolve_import import import_ngsolve
from cardan.physics.fem.stress import von_mises
from cardan.physics.fem.unit_loads import UnitSolutions, solve_unit_loads, unit_loads
from cardan.topics.bracket.contact_assessment import enlarge_by_contact_error

pytestmark = [pytest.mark.oracle, pytest.mark.bracket, pytest.mark.long]

U = UShape(
    seat_diameter=100 * mm, width=70 * mm, thickness=6 * mm, height=90 * mm, flange=55 * mm,
    bend_radius=10 * mm, bolt_diameter=11 * mm, bolt_pitch=40 * mm,
)  # fmt: skip
FORCE = 2000.0
HOLDS = ("sliding", "clamped")
PLANE = 1 + max(ZONE_SHEET, ZONE_CUT_EDGE, ZONE_BOLT_BORDER, ZONE_WELD_TOE)
"""Of the sheet what lies against the frame: in contact it is told by the worse of the two ways."""
KINDS = (ZONE_SHEET, PLANE, ZONE_CUT_EDGE, ZONE_BOLT_BORDER)
LOADS = {"along": (0, 1), "across": (1, 1), "up": (2, 1), "down": (2, -1)}


def bolt(place):
    """A bolt of 10 mm with its washer, from under the flange to 10 mm into the frame."""
    occ = import_ngsolve().occ
    x, y, z = place
    low = z - U.thickness
    start = occ.Pnt(x, y, low - 5 * mm)
    shank = occ.Cylinder(start, occ.Z, r=5 * mm, h=U.thickness + 15 * mm)
    body = shank + occ.Cylinder(start, occ.Z, r=U.bolt_diameter, h=5 * mm)
    for face in body.faces:
        known = {"top": z + 10 * mm, "bearing": low}
        face.name = next((n for n, at in known.items() if abs(face.center.z - at) < 1e-7), "free")
    return assemble_elastic_solid(mesh(body, size=4 * mm), STEEL, held={"top": "xyz"}).nodes


@dataclass(frozen=True, kw_only=True)
class Places:
    """Where either way of holding asks, and of what `KINDS` that is, (places,)."""

    nodes: MeshNodes
    zones: tuple[FatigueZones, ...]
    kind: np.ndarray

    @classmethod
    def of(cls, body, nodes):
        zones = tuple(
            find_fatigue_zones(nodes, held=tuple(body.fixed_faces(hold)), thickness=U.thickness)
            for hold in HOLDS
        )
        plane = np.unique(nodes.faces[nodes.face_names == MOUNT_FACE_NAME])
        kinds = [z.kind.copy() for z in zones]
        for kind, z in zip(kinds, zones, strict=True):
            against = np.isin(z.surface_stress_nodes, plane) & (
                kind[: len(z.surface_stress_nodes)] == ZONE_SHEET
            )
            kind[: len(z.surface_stress_nodes)][against] = PLANE
        return cls(nodes=nodes, zones=zones, kind=np.concatenate(kinds))

    def read(self, *each):
        """Stress (places, c, 6) from that at nodes of each way held."""
        return np.concatenate([
            z.stress(self.nodes, of) for z, of in zip(self.zones, each, strict=True)
        ])  # fmt: skip

    def highest(self, stress):
        """Highest von Mises stress (kinds, c) of that at places (places, c, 6)."""
        level = von_mises(stress)
        return np.stack([level[self.kind == kind].max(axis=0) for kind in KINDS])


@dataclass(frozen=True, kw_only=True)
class Held:
    """The two ways on one mesh; `hung` is held by nothing but its holes' walls."""

    body: BracketSolid
    ways: tuple[UnitSolutions, ...]
    hung: UnitSolutions
    places: Places

    @property
    def highest(self):
        """Highest von Mises stress (kinds, loads) of the worse of both ways."""
        each = (
            np.stack([sign * FORCE * way.at_nodes[1][:, k] for k, sign in LOADS.values()], axis=1)
            for way in self.ways
        )
        return self.places.highest(self.places.read(*each))

    @classmethod
    def of(cls, edge):
        """The bracket meshed with such edges under its washers."""
        body = build_solid(U)
        for face in body.shape.faces:
            if face.name in body.bolts:
                face.maxh = edge
        made = mesh(body.shape, size=10 * mm)  # one for all: two would not be alike
        walls = dict.fromkeys([bolt + HOLE_WALL_NAME_SUFFIX for bolt in body.bolts], "xyz")
        *ways, hung = (
            solve_unit_loads(body, assemble_elastic_solid(made, STEEL, held=to), size=10 * mm)
            for to in (*map(body.fixed_faces, HOLDS), walls)
        )
        places = Places.of(body, hung.elastic.nodes)
        return cls(body=body, ways=tuple(ways), hung=hung, places=places)


@pytest.fixture(scope="module")
def held():
    return Held.of(3.5 * mm)


@pytest.fixture(scope="module")
def fine():
    """Fine enough to tell how far out the heads' pressure reaches, as contact is judged on."""
    return Held.of(CONTACT_RING_WIDTH_TO_HOLE_RATIO * U.bolt_diameter)


@pytest.fixture(scope="module")
def real(held, tmp_path_factory):
    """CalculiX beyond what tightening does: stiffness (loads,), stress (kinds, loads), preload."""
    nodes = held.places.nodes
    corners = nodes.points[nodes.faces[:, :3]]
    places = np.array(U.bolt_positions)
    under = np.abs(corners[..., 2] - U.height + U.thickness).max(axis=1) < 1e-6
    away = np.linalg.norm(corners.mean(axis=1)[:, None, :2] - places[:, :2], axis=-1).min(axis=1)
    leg = U.seat_diameter / 2 + U.thickness
    near, far = leg - 5 * mm, leg + U.flange + 10 * mm
    frames = []
    for y0, y1 in ((-far, -near), (near, far)):
        flat = [(-U.width, y0), (U.width, y0), (U.width, y1), (-U.width, y1)]
        frames.append(np.array([(x, y, U.height + h) for h in (0, 20 * mm) for x, y in flat]))
    spread, bolts = calculix.seat_loads(nodes), [bolt(p) for p in U.bolt_positions]
    loads = [sign * FORCE * spread[k] for k, sign in LOADS.values()]
    folders = [tmp_path_factory.mktemp("ccx") for _ in loads]

    def alone(load, folder):
        text = calculix.bolted(
            nodes, bolts, frames, STEEL, under=under & (away < 1.5 * U.bolt_diameter),
            loads=[load], cooling=300,
        )  # fmt: skip
        (tight, at_rest), (u, stress) = calculix.run(text, folder, threads=1)[0]
        return (u - tight)[: len(load)], (stress - at_rest)[: len(load)]

    with ThreadPoolExecutor(2) as pool:
        moved, stress = zip(*pool.map(alone, loads, folders), strict=True)
    work = [float((f * u).sum()) for f, u in zip(loads, moved, strict=True)]
    preload = max(
        abs(float(v)) for folder in folders for v in (folder / "job.dat").read_text().split()[-3:]
    )
    at_nodes = np.stack(stress, axis=1)
    highest = held.places.highest(held.places.read(at_nodes, at_nodes))
    return FORCE**2 / np.array(work), highest, preload


def stiffness(units):
    """Return ours (loads,) N/m."""
    return np.array([1 / units.compliance[k, k] for k, _ in LOADS.values()])


def test_bolt_preload_is_below_proof_load(real):
    """M10 of 8.8 bears 37 kN at its proof load."""
    assert 30e3 < real[2] < 37e3


def test_contact_stiffness_lies_between_both_clamping_models(held, real):
    """But straight down, where the flange lifts off and the bolts give: 11 % below the softer."""
    soft, stiff = map(stiffness, held.ways)
    low = np.array([1.0, 1.0, 1.0, 0.85]) * soft
    assert np.all(low < real[0])
    assert np.all(real[0] < stiff)
    assert real[0][3] < soft[3]


def test_contact_stiffness_exceeds_hole_wall_clamping(held, real):
    """Washers that open, heads that tilt and bolts that stretch leave at least that: 71 of 77."""
    walls = stiffness(held.hung)
    assert np.all(walls < real[0]), walls / real[0]
    assert walls[3] > 0.9 * real[0][3]


def test_reported_stress_bounds_contact_stress(held, real):
    """The worse of both ways against contact, over the whole bracket and zone by zone.

    No less than contact, and at most 1.6 times as much. But the cut edge beside the washers is
    missed by an eighth where the flange is pulled down, which bends it over them.
    """
    over_all = held.highest.max(axis=0) / real[1].max(axis=0)
    assert np.all((over_all > 1.0) & (over_all < 1.6)), over_all
    least = np.array([[0.87 if kind == ZONE_CUT_EDGE else 1.0] for kind in KINDS])
    share = held.highest / real[1]
    assert np.all((share > least) & (share < 1.6)), share


@pytest.fixture(scope="module")
def bolted(fine):
    """Our own contact, condensed to its forces: stiffness (loads,), stress (kinds, loads).

    Third, the stress with the worse of a hard frame and one that gives as thick metal does.
    """
    body, places = fine.ways[0].elastic, fine.places

    def read(displacements):
        stress = body.stress_at_nodes(displacements)
        return places.read(stress, stress)

    joint = condense_bracket_to_flange_contact(
        body, unit_loads(body), bolts=fine.body.bolts, upright=2, thickness=U.thickness,
        read=read, tell=str,
    )  # fmt: skip
    stiff, highest = [], []
    for on in (joint, joint.on_elastic_frame):
        tight = on.tighten(Bolts(preload=34.5e3))
        forces = np.stack(
            [tight.added_forces(sign * FORCE * np.eye(9)[k]) for k, sign in LOADS.values()], axis=1
        )
        stiff.append(FORCE**2 / np.einsum("qc,qr,rc->c", forces, joint.compliance, forces))
        highest.append(places.highest(np.einsum("qps,qc->pcs", joint.stress, forces)))
    return stiff[0], highest[0], np.maximum(*highest)


def test_contact_stiffness_matches_calculix(bolted, real):
    """Within 5 %: how far out a head presses is known to a millimetre, which is a tenth.

    Pushed up, on a hard frame, within 16 % (15.04 are found): there CalculiX's contact springs
    give. Pulled down it lifts off, and is softer than the same flange pushed up: no sum of unit
    loads is.
    """
    assert np.all(np.abs(bolted[0] / real[0] - 1) < [0.05, 0.05, 0.16, 0.05]), bolted[0] / real[0]
    assert bolted[0][3] < 0.85 * bolted[0][2]


def test_contact_stress_matches_calculix(bolted, real):
    """At most 5 % less and 30 % more, with the worse of a hard frame and one that gives.

    Pushed straight up a hard frame alone leaves the bolts' border a quarter less than there.
    """
    share = bolted[2] / real[1]
    assert np.all((share > 0.95) & (share < 1.3)), share
    assert (
        bolted[1][KINDS.index(ZONE_BOLT_BORDER), 2]
        < 0.8 * real[1][KINDS.index(ZONE_BOLT_BORDER), 2]
    )


def test_reported_contact_stress_bounds_calculix(fine, bolted, real):
    """Zone by zone and load by load, with what is added; a flange that pries is no exception."""
    told = enlarge_by_contact_error(bolted[2])
    told[KINDS.index(PLANE)] = fine.highest[KINDS.index(PLANE)]
    assert np.all(told > real[1]), told / real[1]

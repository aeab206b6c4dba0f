"""A bracket in real bolts against the two ways its flange is held: CalculiX, one-sided contact.

Four M10 tightened to 35 kN press a U's flanges against the frame, with friction of 0.15. What
2 kN more do is held against what both of our ways say of it, none of which knows bolts,
contact or friction. CalculiX: Dhondt, calculix.de.
"""

import calculix
import numpy as np
import pytest

from cardan.base.units import mm
from cardan.bracket.elastic import elastic, mesh
from cardan.bracket.engine import engine
from cardan.bracket.joint import PATCH, condensed
from cardan.bracket.shape import WALL, solid
from cardan.bracket.stress import von_mises
from cardan.bracket.unit import solved, unit_loads
from cardan.bracket.zones import BORDER, CUT, SHEET, zones_of
from cardan.model.bracket import Bolts, UShape
from cardan.model.material import STEEL
from cardan.study.bracket_contact import on_its_safe_side

pytestmark = [pytest.mark.oracle, pytest.mark.bracket]

U = UShape(
    seat_diameter=100 * mm, width=70 * mm, thickness=6 * mm, height=90 * mm, flange=55 * mm,
    bend_radius=10 * mm, bolt_diameter=11 * mm, bolt_pitch=40 * mm,
)  # fmt: skip
FORCE = 2000.0
HOLDS = ("sliding", "clamped")
LOADS = {"along": (0, 1), "across": (1, 1), "up": (2, 1), "down": (2, -1)}


def bolt(place):
    """A bolt of 10 mm with its washer, from under the flange to 10 mm into the frame."""
    occ = engine().occ
    x, y, z = place
    low = z - U.thickness
    start = occ.Pnt(x, y, low - 5 * mm)
    shank = occ.Cylinder(start, occ.Z, r=5 * mm, h=U.thickness + 15 * mm)
    body = shank + occ.Cylinder(start, occ.Z, r=U.bolt_diameter, h=5 * mm)
    for face in body.faces:
        known = {"top": z + 10 * mm, "bearing": low}
        face.name = next((n for n, at in known.items() if abs(face.center.z - at) < 1e-7), "free")
    return elastic(mesh(body, size=4 * mm), STEEL, held={"top": "xyz"}).nodes


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """Our two ways, and CalculiX's motion and stress beyond what tightening does.

    Third, the stiffness of the same bracket held by nothing but its holes' walls.
    """
    body = solid(U)
    for face in body.shape.faces:
        if face.name in body.bolts:
            face.maxh = 3.5 * mm
    made = mesh(body.shape, size=10 * mm)  # one for all three: two would not be alike
    ways = [
        solved(body, elastic(made, STEEL, held=body.held(hold)), size=10 * mm) for hold in HOLDS
    ]
    walls = [bolt + WALL for bolt in body.bolts]
    hung = solved(body, elastic(made, STEEL, held=dict.fromkeys(walls, "xyz")), size=10 * mm)
    nodes = ways[0].elastic.nodes
    corners = nodes.points[nodes.faces[:, :3]]
    places = np.array(U.places)
    under = np.abs(corners[..., 2] - U.height + U.thickness).max(axis=1) < 1e-6
    away = np.linalg.norm(corners.mean(axis=1)[:, None, :2] - places[:, :2], axis=-1).min(axis=1)
    leg = U.seat_diameter / 2 + U.thickness
    near, far = leg - 5 * mm, leg + U.flange + 10 * mm
    frames = []
    for y0, y1 in ((-far, -near), (near, far)):
        flat = [(-U.width, y0), (U.width, y0), (U.width, y1), (-U.width, y1)]
        frames.append(np.array([(x, y, U.height + h) for h in (0, 20 * mm) for x, y in flat]))
    spread = calculix.seat_loads(nodes)
    loads = [sign * FORCE * spread[k] for k, sign in LOADS.values()]
    text = calculix.bolted(
        nodes, [bolt(p) for p in U.places], frames, STEEL,
        under=under & (away < 1.5 * U.bolt_diameter), loads=loads, cooling=300,
    )  # fmt: skip
    folder = tmp_path_factory.mktemp("ccx")
    found, _, _ = calculix.run(text, folder)
    told = (folder / "job.dat").read_text().split()
    n = len(nodes.points)
    moved = [(u - found[0][0])[:n] for u, _ in found[1:]]
    stress = np.stack([(s - found[0][1])[:n] for _, s in found[1:]], axis=1)
    work = [float((f * u).sum()) for f, u in zip(loads, moved, strict=True)]
    tight = max(abs(float(v)) for v in told[-3:])
    return ways, FORCE**2 / np.array(work), stress, tight, stiffness(hung)


def stiffness(units):
    """Return ours (loads,) N/m."""
    return np.array([1 / units.compliance[k, k] for k, _ in LOADS.values()])


def worst(units, hold, stress):
    """Highest von Mises stress (zones, loads) where this way of holding asks."""
    held = tuple(units.solid.held(hold))
    zones = zones_of(units.elastic.nodes, held=held, thickness=units.solid.thickness)
    level = von_mises(zones.stress(units.elastic.nodes, stress))
    return np.stack([level[zones.kind == k].max(axis=0, initial=0.0) for k in (SHEET, CUT, BORDER)])


def test_bolts_are_as_tight_as_their_class_allows(both):
    """M10 of 8.8 bears 37 kN at its proof load."""
    assert 30e3 < both[3] < 37e3


def test_the_stiffness_lies_between_the_two_ways(both):
    """But straight down, where the flange lifts off and the bolts give: 12 % below the softer."""
    ways, real, *_ = both
    soft, stiff = map(stiffness, ways)
    low = np.array([1.0, 1.0, 1.0, 0.85]) * soft
    assert np.all(low < real)
    assert np.all(real < stiff)
    assert real[3] < soft[3]


def test_no_pull_is_softer_than_the_holes_walls_alone(both):
    """Washers that open, heads that tilt and bolts that stretch leave at least that: 71 of 76."""
    _, real, *_, walls = both
    assert np.all(walls < real), walls / real
    assert walls[3] > 0.9 * real[3]


def test_what_is_told_is_never_less_than_the_worst_there_is(both):
    """The worse of both ways against contact, over the whole bracket and zone by zone.

    In all, and at the bolts, no less than contact, and at most 1.6 times as much; but where the
    flange is pulled down, which bends it over its washers: there the sheet under their rim, from
    0.4 thicknesses on, is the worst of all and 3 % less than contact has, and the cut edge beside
    them is missed by a quarter.
    """
    ways, _, real, *_ = both
    told = [
        np.stack([sign * FORCE * units.at_nodes[1][:, k] for k, sign in LOADS.values()], axis=1)
        for units in ways
    ]
    ours, theirs = (
        np.max([worst(u, h, s) for u, h, s in zip(ways, HOLDS, of, strict=True)], axis=0)
        for of in (told, [real, real])
    )
    over_all = ours.max(axis=0) / theirs.max(axis=0)
    sheet, cut, border = ours / theirs
    least = np.array([1.0 if load != "down" else 0.95 for load in LOADS])
    assert np.all((over_all > least) & (over_all < 1.6)), over_all
    assert np.all((border > 1.0) & (border < 1.6)), border
    assert np.all((sheet > 0.9) & (sheet < 1.6)), sheet
    assert np.all((cut > 0.72) & (cut < 1.6)), cut


@pytest.fixture(scope="module")
def bolted():
    """Our own contact, condensed to its forces: stiffness and worst stress of each load, by zone.

    Third, that of the worse of a hard frame and one that gives as thick metal does. On a mesh of
    its own, fine enough to tell how far out the heads' pressure reaches.
    """
    body = solid(U)
    for face in body.shape.faces:
        if face.name in body.bolts:
            face.maxh = PATCH * U.bolt_diameter
    held = elastic(mesh(body.shape, size=10 * mm), STEEL, held=body.held())
    zones = zones_of(held.nodes, held=tuple(body.held("clamped")), thickness=U.thickness)
    border = zones_of(held.nodes, held=tuple(body.held()), thickness=U.thickness)
    kinds = np.concatenate([zones.kind, border.kind[border.kind == BORDER]])

    def read(displacements):
        stress = held.stress_at_nodes(displacements)
        rings = border.stress(held.nodes, stress)[border.kind == BORDER]
        return np.concatenate([zones.stress(held.nodes, stress), rings])

    joint = condensed(
        held, unit_loads(held), bolts=body.bolts, upright=2, thickness=U.thickness, read=read,
        tell=str,
    )  # fmt: skip
    stiff, levels = [], []
    for on in (joint, joint.on_thick):
        tight = on.tightened(Bolts(preload=34.5e3))
        for k, sign in LOADS.values():
            forces = tight.under(sign * FORCE * np.eye(9)[k])
            stiff.append(FORCE**2 / float(forces @ joint.compliance @ forces))
            level = von_mises(np.einsum("qps,q->ps", joint.stress, forces))
            levels.append([level[kinds == kind].max() for kind in (SHEET, CUT, BORDER)])
    hard, soft = np.array(levels).reshape(2, len(LOADS), -1).swapaxes(1, 2)
    return np.array(stiff[: len(LOADS)]), hard, np.maximum(hard, soft)


def test_our_contact_is_as_stiff_as_calculix_has_it(both, bolted):
    """Within 7 %: how far out a head presses is known to a millimetre, which is a tenth.

    Pushed up, on a hard frame, within 15 %: there CalculiX's contact springs give, and what slipped
    in the pulls before has left gaps. Pulled down it lifts off, and is softer than the same flange
    pushed up: no sum of unit loads is.
    """
    assert np.all(np.abs(bolted[0] / both[1] - 1) < [0.07, 0.07, 0.15, 0.07]), bolted[0] / both[1]
    assert bolted[0][3] < 0.85 * bolted[0][2]


def test_our_contact_has_the_stress_of_calculix_where_it_is_high(both, bolted):
    """The highest of all within 15 %, with the worse of a hard frame and one that gives.

    Pushed straight up a hard frame alone leaves the bolts' border two fifths less than there.
    """
    ways, _, real, *_ = both
    theirs = np.max([worst(u, h, real) for u, h in zip(ways, HOLDS, strict=True)], axis=0)
    share = bolted[2].max(axis=0) / theirs.max(axis=0)
    assert np.all((share > 0.85) & (share < 1.15)), share


def test_what_is_told_of_contact_is_never_less_than_calculix_has(both, bolted):
    """Zone by zone and load by load, with what is added; a flange that pries is no exception.

    But for the sheet from 0.4 thicknesses off the washers' rim as it is pulled up: 5 % less.
    """
    ways, _, real, *_ = both
    theirs = np.max([worst(u, h, real) for u, h in zip(ways, HOLDS, strict=True)], axis=0)
    told = on_its_safe_side(bolted[2])
    least = np.array([[0.94 if load == "up" else 0.99 for load in LOADS], *2 * [4 * [0.99]]])
    assert np.all(told > least * theirs), told / theirs

"""Contact alone: ours against CalculiX's on one mesh, under the same heads, preload and friction.

Nothing else differs: heads press with the same forces on the same elements, the frame is hard,
and every pull comes on a flange just tightened: what slipped along before leaves a stress that no
swing has, and CalculiX seeks long what it left. Its contact springs are firm enough: five times as
firm, stress moves by less than a hundredth (23.1, 33.3, 40.6 MPa at borders; as firm as a fifth,
up to a tenth). CalculiX: Dhondt, calculix.de.
"""

from dataclasses import replace
from pathlib import Path

import calculix
import numpy as np
import pytest

from cardan.core.units import mm
from cardan.model.bracket import Bolts, FaceSelector, LShape, StepFileShape, UShape
from cardan.model.material import STEEL
from cardan.physics.fem.bolted_joint import (
    CONTACT_RING_WIDTH_TO_HOLE_RATIO,
    _heads,
    _rounds,
    condense_bracket_to_flange_contact,
)
from cardan.physics.fem.elasticity import assemble_elastic_solid
from cardan.physics.fem.fatigue_zones import (
    ZONE_BOLT_BORDER,
    ZONE_CUT_EDGE,
    ZONE_SHEET,
    ZONE_WELD_TOE,
    find_fatigue_zones,
)
from cardan.physics.fem.geometry import build_solid
from cardan.physics.fem.meshing import mesh
from cardan.physics.fem.stress import von_mises
from cardan.physics.fem.unit_loads import unit_loads
from cardan.topics.bracket.contact_assessment import enlarge_by_contact_error

# CalculiX seeks their slip for minutes, a quarter of an hour and more a pull.
pytestmark = [
    pytest.mark.oracle, pytest.mark.bracket, pytest.mark.long, pytest.mark.timeout(4 * 3600),
]  # fmt: skip

U = UShape(
    seat_diameter=100 * mm, width=70 * mm, thickness=6 * mm, height=90 * mm, flange=55 * mm,
    bend_radius=10 * mm, bolt_diameter=11 * mm, bolt_pitch=40 * mm,
)  # fmt: skip
L = LShape(
    seat_diameter=80 * mm, width=140 * mm, wall_width=110 * mm, depth=90 * mm, thickness=8 * mm,
    height=85 * mm, rim=15 * mm, fillet=6 * mm, bolt_diameter=11 * mm, bolt_edge=16 * mm,
)  # fmt: skip
RIBBED = replace(
    U, width=90 * mm, bolt_pitch=55 * mm, gusset=5 * mm, gusset_height=55 * mm, fillet=4 * mm
)
DRAWN = StepFileShape(
    path=str(Path(__file__).parents[2] / "examples/refuse-collector/bracket.step"),
    centre=(0, 0, 0), thickness=5 * mm, seat=(FaceSelector(name="seat"),),
    bolts=tuple(FaceSelector(name=f"bolt {k}") for k in (1, 2, 3, 4)),
)  # fmt: skip
ALL = (0, 0, 1), (0, 0, -1), (0, 1, 0)
PULLS = {
    "u": (U, *ALL), "l": (L, *ALL[1:]), "u with gussets": (RIBBED, *ALL), "step": (DRAWN, *ALL),
}  # fmt: skip
HOLE = 11 * mm
"""Of each of them."""
FORCE, PRELOAD = 2000.0, 34.5e3
KINDS = {
    ZONE_SHEET: "sheet",
    ZONE_CUT_EDGE: "cut edge",
    ZONE_WELD_TOE: "weld toe",
    ZONE_BOLT_BORDER: "bolt border",
}


@pytest.fixture(scope="module", params=PULLS)
def worst(request, tmp_path_factory):
    """Highest stress (zones, pulls) on a hard frame, on the worse of both, and in CalculiX.

    Last the stiffness (pulls,) on a hard frame over that in CalculiX.
    """
    part, *pulls = PULLS[request.param]
    body = build_solid(part)
    for face in body.shape.faces:
        if face.name in body.bolts:
            face.maxh = CONTACT_RING_WIDTH_TO_HOLE_RATIO * HOLE
    held = assemble_elastic_solid(
        mesh(body.shape, size=1.7 * body.thickness), STEEL, held=body.fixed_faces()
    )
    nodes = held.nodes
    clamped, sliding = (
        find_fatigue_zones(nodes, held=tuple(body.fixed_faces(hold)), thickness=body.thickness)
        for hold in ("clamped", "sliding")
    )
    border = sliding.kind == ZONE_BOLT_BORDER
    kinds = np.concatenate([clamped.kind, sliding.kind[border]])

    def of(stress):
        return np.concatenate(
            [clamped.stress(nodes, stress), sliding.stress(nodes, stress)[border]]
        )

    loads = unit_loads(held)
    joint = condense_bracket_to_flange_contact(
        held, loads, bolts=body.bolts, upright=2, thickness=body.thickness,
        read=lambda u: of(held.stress_at_nodes(u)), tell=str,
    )  # fmt: skip
    asked = FORCE * np.array([(*pull, *6 * [0]) for pull in pulls], dtype=float)
    ours, ways = [], []
    for on in (joint, joint.on_elastic_frame):
        tight = on.tighten(Bolts(preload=PRELOAD))
        forces = np.stack([tight.added_forces(one) for one in asked], axis=1)
        ours.append(von_mises(np.einsum("qps,qc->pcs", joint.stress, forces)))
        ways.append(np.einsum("qc,qr,rc->c", forces, joint.compliance, forces))
    low, high = nodes.points.min(axis=0) - 50 * mm, nodes.points.max(axis=0) + 50 * mm
    flat = [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
    rounds = _rounds(held, body.bolts, 2)
    brick = np.array([(x, y, rounds[0].place[2] + h) for h in (0, 20 * mm) for x, y in flat])
    heads = PRELOAD * _heads(held, rounds, 2, body.thickness).sum(axis=0)
    n, swings, work = len(nodes.points), [], []
    for one in asked:
        pull = calculix.nodal(held, one @ loads)
        text = calculix.pressed(
            nodes, brick, STEEL, heads=calculix.nodal(held, heads), loads=[pull]
        )
        ends = calculix.run(text, tmp_path_factory.mktemp("ccx"))[0]
        swings.append(ends[-1][1][:n] - ends[0][1][:n])
        work.append(float((pull * (ends[-1][0] - ends[0][0])[:n]).sum()))
    theirs = von_mises(of(np.stack(swings, axis=1)))
    known = [kind for kind in KINDS if (kinds == kind).any()]
    return (
        [KINDS[k] for k in known],
        *(
            np.stack([level[kinds == kind].max(axis=0) for kind in known])
            for level in (ours[0], np.maximum(*ours), theirs)
        ),
        np.array(work) / ways[0],
    )


def test_contact_stress_on_rigid_frame_matches_calculix(worst):
    """Zone by zone, pull by pull: at most 8 % less and 23 % more.

    But of the U with gussets pushed up a border has 16 % less: it is of 19 MPa, and 17 on a frame
    that gives.
    """
    _, hard, _, theirs, stiff = worst
    assert np.all(np.abs(stiff - 1) < 0.15), stiff
    assert np.all(hard > 0.8 * theirs), hard / theirs
    assert np.all(hard < 1.25 * theirs), hard / theirs
    assert np.mean(np.abs(hard / theirs - 1)) < 0.1


def test_reported_contact_stress_on_same_mesh_bounds_calculix(worst):
    zones, _, both, theirs, _ = worst
    told = enlarge_by_contact_error(both)
    assert np.all(told > theirs), (zones, told / theirs)

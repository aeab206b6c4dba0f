"""The gallery's bracket in its bolts, at its own load: swings of stress by CalculiX.

Writes `gallery_contact.json` beside this file: how far stress swings at each feature between two
loads of the gallery's worst case (jounce, on its rubber, where the bearing carries most), and of
its mildest peak in jounce. M10 bolts, their heads and the frame are solid there, contact is
one-sided with friction. Half an hour on two threads of a shared machine. The table that stands
there was made on the mesh of the gallery's whole study, on which contact is held against it in
`docs/bracket.md`; a mesh made for these loads alone leaves features that swing little coarser.

    PYTHONPATH=src python tests/verify/gallery_contact.py     # needs NGSolve (mesh) and ccx
"""

import json
from pathlib import Path
from tempfile import TemporaryDirectory

import calculix
import numpy as np

from cardan.base.units import MPa, mm
from cardan.bracket.elastic import elastic, mesh
from cardan.bracket.engine import engine
from cardan.bracket.solve import Task, solve
from cardan.fatigue.critical import on_planes, plane_directions
from cardan.files.catalogue import find
from cardan.model.bracket import ZONES, UShape

TABLE = Path(__file__).with_suffix(".json")
SHAPE = UShape(
    seat_diameter=120 * mm, width=64 * mm, thickness=5 * mm, height=120 * mm, flange=50 * mm,
    bend_radius=8 * mm, bolt_diameter=11 * mm, bolt_pitch=36 * mm,
)  # fmt: skip
MATERIAL = find("LNE380", "material")
LOADS = {
    "worst point": ((-188.1, -2569.5, -2904.8), (-112.5, 3644.1, -1600.7)),
    "peak": ((-44.1, -424.6, -585.9), (-39.4, 370.9, -443.8)),
}
"""Between these, N, the places that fare worst swing most."""
FRICTION, HEAD = 0.15, 8 * mm
SHOWN = 0.2
"""Share of the widest swing below which a feature is left out."""


def loads_of(ends):
    """Loads (2, 9) of two forces on the bearing."""
    return np.pad(np.array(ends), ((0, 0), (0, 6)))


def meshed():
    """The bracket solved on the mesh that its own loads ask for, its joint condensed."""
    cases = tuple(loads_of(ends) for ends in LOADS.values())
    task = Task(shape=SHAPE, material=MATERIAL, cases=cases, element=12 * mm, bolted=True)
    return solve(task, lambda _: None)


def swing(held, at, stress):
    """Amplitude (m,) Pa of the normal stress at places `at`, on the plane where it is widest."""
    on = on_planes(stress, plane_directions(held.zones.normals[at]))
    return np.ptp(on, axis=-1).max(axis=1) / 2


def by_feature(solved, each):
    """Return the widest swing of each feature, "zone number", of `each(held, places)` (m,) Pa."""
    found = {}
    for k, held in enumerate(solved.both):
        at = solved.bolted.places[k]
        for place, value in zip(at, each(k, held, at), strict=True):
            zone, number = held.zones.features[held.zones.feature[place]]
            name = f"{ZONES[zone]} {number}"
            found[name] = max(found.get(name, 0.0), float(value))
    return found


def bolt(place):
    """A bolt of 10 mm with its head, from under the flange to 10 mm into the frame."""
    occ = engine().occ
    x, y, z = place
    low = z - SHAPE.thickness
    start = occ.Pnt(x, y, low - 5 * mm)
    body = occ.Cylinder(start, occ.Z, r=5 * mm, h=SHAPE.thickness + 15 * mm)
    body += occ.Cylinder(start, occ.Z, r=HEAD, h=5 * mm)
    for face in body.faces:
        known = {"top": z + 10 * mm, "bearing": low}
        face.name = next((n for n, at in known.items() if abs(face.center.z - at) < 1e-7), "free")
    return elastic(mesh(body, size=4 * mm), MATERIAL, held={"top": "xyz"}).nodes


def table():
    """Return CalculiX's swings and the force of its bolts."""
    solved = meshed()
    nodes, places = solved.nodes, np.array(SHAPE.places)
    corners = nodes.points[nodes.faces[:, :3]]
    under = np.abs(corners[..., 2] - SHAPE.height + SHAPE.thickness).max(axis=1) < 1e-6
    away = np.linalg.norm(corners.mean(axis=1)[:, None, :2] - places[:, :2], axis=-1).min(axis=1)
    leg = SHAPE.seat_diameter / 2 + SHAPE.thickness
    near, far = leg - 5 * mm, leg + SHAPE.flange + 10 * mm
    frames = []
    for y0, y1 in ((-far, -near), (near, far)):
        w = SHAPE.width
        flat = [(-w, y0), (w, y0), (w, y1), (-w, y1)]
        frames.append(np.array([(x, y, SHAPE.height + h) for h in (0, 20 * mm) for x, y in flat]))
    spread = calculix.seat_loads(nodes)[:3]
    forces = np.concatenate(list(LOADS.values()))
    text = calculix.bolted(
        nodes, [bolt(p) for p in SHAPE.places], frames, MATERIAL, friction=FRICTION, cooling=305,
        under=under & (away < 1.5 * SHAPE.bolt_diameter),
        loads=[np.einsum("k,knx->nx", force, spread) for force in forces],
    )  # fmt: skip
    with TemporaryDirectory() as folder:
        found, _, _ = calculix.run(text, Path(folder))
        tight = max(abs(float(v)) for v in Path(folder, "job.dat").read_text().split()[-3:])
    n = len(nodes.points)
    swings = {}
    for k, case in enumerate(LOADS):
        first, last = ((found[j][1] - found[0][1])[:n, None] for j in (2 * k + 1, 2 * k + 2))

        def each(_, held, at, first=first, last=last):
            both = [held.zones.stress(nodes, stress)[at] for stress in (first, last)]
            return swing(held, at, np.concatenate(both, axis=1))

        told = by_feature(solved, each)
        top = max(told.values())
        swings[case] = {f: round(v / MPa, 1) for f, v in told.items() if v > SHOWN * top}
    return {"preload_N": tight, "swing_MPa": swings}


if __name__ == "__main__":
    TABLE.write_text(json.dumps(table(), indent=1) + "\n")

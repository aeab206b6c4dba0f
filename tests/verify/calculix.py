"""Drive CalculiX, an independent finite element program, on a mesh of ours."""

import itertools
import shutil
import subprocess
import time
from itertools import chain, islice

import numpy as np

from cardan.topics.bracket.calculix_file import (
    element_lines,
    material_lines,
    node_lines,
    node_set_lines,
    surface_lines,
)

# Six-point rule of degree 4 on the triangle (Dunavant 1985).
_A, _B = 0.445948490915965, 0.091576213509771
_RULE = [
    (w, place)
    for w, a in ((0.223381589678011, _A), (0.109951743655322, _B))
    for place in ((1 - 2 * a, a, a), (a, 1 - 2 * a, a), (a, a, 1 - 2 * a))
]


def installed():
    return shutil.which("ccx") is not None


def seat_loads(nodes, *, face="seat"):
    """Nodal loads (6, n, 3) of unit forces and moments about the origin, spread linearly."""
    faces = nodes.faces[nodes.face_names == face]
    X = nodes.points[faces]
    spread = np.zeros((6, len(nodes.points), 3))
    for w, (a, b, c) in _RULE:
        shape = np.array([a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1),
                          4 * a * b, 4 * b * c, 4 * c * a])  # fmt: skip
        by_r = np.array([1 - 4 * a, 4 * b - 1, 0, 4 * (a - b), 4 * c, -4 * c])
        by_s = np.array([1 - 4 * a, 0, 4 * c - 1, -4 * b, 4 * b, 4 * (a - c)])
        r, s, x = (np.einsum("k,fkx->fx", d, X) for d in (by_r, by_s, shape))
        area = np.linalg.norm(np.cross(r, s), axis=-1) / 2 * w
        for k in range(6):
            axis = np.eye(3)[k % 3]
            t = np.broadcast_to(axis, x.shape) if k < 3 else np.cross(axis, x)
            np.add.at(spread[k], faces, shape[None, :, None] * (area[:, None] * t)[:, None])
    moments = np.cross(nodes.points, spread).sum(axis=1)
    resultants = np.concatenate([spread.sum(axis=1), moments], axis=1).T
    return np.einsum("kj,knx->jnx", np.linalg.inv(resultants), spread)


def deck(nodes, material, *, held, loads=(), modes=0):
    """An input deck: static steps with nodal loads (n, 3) each, then natural frequencies."""
    fixed = np.unique(nodes.faces[np.isin(nodes.face_names, held)]) + 1
    lines = [
        *node_lines(nodes.points), *element_lines(nodes.elements),
        *node_set_lines("FIX", fixed), *material_lines(material), "*BOUNDARY", "FIX,1,3",
    ]  # fmt: skip
    for load in loads:
        lines += ["*STEP", "*STATIC", "*CLOAD,OP=NEW"]
        lines += [
            f"{n + 1},{c + 1},{load[n, c]:.12e}"
            for n, c in zip(*np.nonzero(np.abs(load) > 1e-14), strict=True)
        ]
        lines += ["*NODE FILE", "U", "*EL FILE", "S", "*END STEP"]
    if modes:
        lines += ["*STEP", "*FREQUENCY", str(modes), "*NODE FILE", "U", "*END STEP"]
    return "\n".join(lines) + "\n"


def bolted(plate, bolts, frames, material, *, under, loads, cooling, friction=0.15, firm=1.0):
    """An input deck: a plate that real bolts press against real frames, then nodal loads.

    Contact is one-sided, with friction, between plate and frames and between bolts' heads and
    plate. The bolts' far ends ("top") and the frames are fixed; bolts are cooled, which
    tightens them, and stay so. One static step to tighten, then one a load.

    `plate` and `bolts` are meshes; `frames` bricks (8, 3) whose first four corners face the plate,
    `under` the plate's triangles heads press on, `cooling` in K at 1e-5 a K.
    """
    solids = [plate, *bolts]
    node = np.cumsum([0, *(len(s.points) for s in solids)])
    element = np.cumsum([0, *(len(s.elements) for s in solids)])
    points = np.concatenate([*(s.points for s in solids), *frames])
    every = np.concatenate([s.elements + n for s, n in zip(solids, node[:-1], strict=True)])
    lines = [*node_lines(points), *element_lines(every), "*ELEMENT,TYPE=C3D8,ELSET=EALL"]
    for k in range(len(frames)):
        corners = ",".join(str(node[-1] + 8 * k + c) for c in range(1, 9))
        lines.append(f"{element[-1] + k + 1},{corners}")
    tops = [
        np.unique(b.faces[b.face_names == "top"]) + n + 1
        for b, n in zip(bolts, node[1:], strict=False)
    ]
    lines += node_set_lines("TOPS", tops[0])
    lines += node_set_lines(
        "FIX", [*chain.from_iterable(tops), *range(node[-1] + 1, len(points) + 1)]
    )
    lines += ["*NSET,NSET=BOLTS,GENERATE", f"{node[1] + 1},{node[-1]}"]
    E = material.youngs_modulus
    stiff = 3.3e3 * firm * E  # N/m3: what it lets in is far below what plate and bolts give
    pressed = np.char.startswith(plate.face_names.astype(str), "bolt")
    pressed &= ~np.char.endswith(plate.face_names.astype(str), "wall")
    lines += [
        "*MATERIAL,NAME=S", "*ELASTIC", f"{E:.12e},{material.poisson}", "*EXPANSION", "1e-5",
        "*SOLID SECTION,ELSET=EALL,MATERIAL=S", "*INITIAL CONDITIONS,TYPE=TEMPERATURE", "NALL,0.",
        *surface_lines("PLATE", plate, pressed | (plate.face_names == "mount")),
        "*SURFACE,NAME=FRAME,TYPE=ELEMENT",
        *(f"{element[-1] + k + 1},S1" for k in range(len(frames))),
        *surface_lines("UNDER", plate, under),
        "*SURFACE,NAME=HEADS,TYPE=ELEMENT",
    ]  # fmt: skip
    for bolt, e in zip(bolts, element[1:], strict=False):
        lines += islice(
            surface_lines("", bolt, bolt.face_names == "bearing", after=int(e)), 1, None
        )
    lines += [
        "*SURFACE INTERACTION,NAME=C", "*SURFACE BEHAVIOR,PRESSURE-OVERCLOSURE=LINEAR",
        f"{stiff:.4e},1e4,6e-7", "*FRICTION", f"{friction},{stiff / 20:.4e}",
        "*CONTACT PAIR,INTERACTION=C,TYPE=SURFACE TO SURFACE", "PLATE,FRAME",
        "*CONTACT PAIR,INTERACTION=C,TYPE=SURFACE TO SURFACE", "UNDER,HEADS",
        "*BOUNDARY", "FIX,1,3",
        "*STEP,INC=100", "*STATIC", "1.,1.", "*TEMPERATURE", f"BOLTS,{-cooling}",
        "*NODE FILE", "U", "*EL FILE", "S", "*NODE PRINT,NSET=TOPS,TOTALS=ONLY", "RF", "*END STEP",
    ]  # fmt: skip
    for load in loads:
        lines += ["*STEP,INC=100", "*STATIC", "1.,1.", "*CLOAD,OP=NEW"]
        lines += [
            f"{n + 1},{c + 1},{load[n, c]:.12e}"
            for n, c in zip(*np.nonzero(np.abs(load) > 1e-14), strict=True)
        ]
        lines += ["*NODE FILE", "U", "*EL FILE", "S", "*END STEP"]
    return "\n".join(lines) + "\n"


def pressed(plate, frame, material, *, heads, loads, friction=0.15, firm=5.0):
    """An input deck: forces (n, 3) that stay press a plate against a fixed brick, then nodal loads.

    As `bolted`, without bolts that give. Each load comes on top of what stays, in its turn.
    """
    n, e = len(plate.points), len(plate.elements)
    points = np.concatenate([plate.points, frame])
    names = plate.face_names.astype(str)
    flat = np.char.startswith(names, "bolt") & ~np.char.endswith(names, "wall")
    stiff = 3.3e3 * firm * material.youngs_modulus
    lines = [
        *node_lines(points), *element_lines(plate.elements), "*ELEMENT,TYPE=C3D8,ELSET=EALL",
        f"{e + 1}," + ",".join(str(n + c) for c in range(1, 9)),
        *node_set_lines("FIX", range(n + 1, n + 9)),
        "*MATERIAL,NAME=S", "*ELASTIC", f"{material.youngs_modulus:.12e},{material.poisson}",
        "*SOLID SECTION,ELSET=EALL,MATERIAL=S",
        *surface_lines("PLATE", plate, flat | (names == "mount")),
        "*SURFACE,NAME=FRAME,TYPE=ELEMENT", f"{e + 1},S1",
        "*SURFACE INTERACTION,NAME=C", "*SURFACE BEHAVIOR,PRESSURE-OVERCLOSURE=LINEAR",
        f"{stiff:.4e},1e4,6e-7", "*FRICTION", f"{friction},{stiff / 20:.4e}",
        "*CONTACT PAIR,INTERACTION=C,TYPE=SURFACE TO SURFACE", "PLATE,FRAME",
        "*BOUNDARY", "FIX,1,3",
    ]  # fmt: skip
    for load in (heads, *(heads + load for load in loads)):
        lines += ["*STEP,INC=100", "*STATIC", "1.,1.", "*CLOAD,OP=NEW"]
        lines += [
            f"{k + 1},{c + 1},{load[k, c]:.12e}"
            for k, c in zip(*np.nonzero(np.abs(load) > 1e-14), strict=True)
        ]
        lines += ["*NODE FILE", "U", "*EL FILE", "S", "*END STEP"]
    return "\n".join(lines) + "\n"


def nodal(solid, load):
    """Forces (n, 3) at the nodes of elements of second degree, of a load vector (unknowns,).

    Ours has straight functions of corners and bubbles of edges; theirs are Lagrange's.
    """
    f, nodes, corners = load.reshape(-1, 3), solid.nodes, solid.mesh.nv
    ends = np.array([sorted(v.nr for v in edge.vertices) for edge in solid.mesh.edges])
    sides = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
    pairs = np.sort(np.stack([nodes.elements[:, list(s)] for s in sides], axis=1), axis=-1)
    middle = dict(zip(map(tuple, pairs.reshape(-1, 2).tolist()),
                      nodes.elements[:, 4:].ravel().tolist(), strict=True))  # fmt: skip
    shape = np.array(solid.space.GetFE(next(iter(solid.mesh.Elements()))).CalcShape(0.5, 0.5, 0.0))
    bubble = 4 * float(shape[4:][np.abs(shape[4:]).argmax()])
    found = np.zeros((len(nodes.points), 3))
    found[:corners] = f[:corners]
    found[[middle[tuple(e)] for e in ends.tolist()]] = 4 / bubble * f[corners:]
    for end in (0, 1):
        np.add.at(found, ends[:, end], -2 / bubble * f[corners:])
    return found


def run(text, folder, *, threads=2):
    """Run a deck; return its static results [(u, stress), ...], frequencies Hz, seconds."""
    (folder / "job.inp").write_text(text)
    start = time.perf_counter()
    done = subprocess.run(
        ["ccx", "job"], cwd=folder, capture_output=True, text=True, check=False,
        env={"OMP_NUM_THREADS": str(threads), "PATH": "/usr/bin:/bin"},
    )  # fmt: skip
    seconds = time.perf_counter() - start
    assert (folder / "job.frd").exists(), done.stdout[-2000:]
    blocks = list(_blocks(folder / "job.frd"))
    static = [
        (u, s) for (a, u), (b, s) in itertools.pairwise(blocks)
        if a == "DISP" and b == "STRESS"
    ]  # fmt: skip
    return static[: text.count("*STATIC")], _frequencies(folder / "job.dat"), seconds


def _blocks(path):
    """Nodal results of a .frd file: name, and values in the order of the nodes."""
    name, rows = None, []
    for line in path.read_text().splitlines():
        if line.startswith(" -4"):
            name, rows = line[5:11].strip(), []
        elif line.startswith(" -1") and name:
            rows.append([float(line[k : k + 12]) for k in range(13, len(line.rstrip()), 12)])
        elif line.startswith(" -3") and name:
            yield name, np.array(rows)
            name = None


def _frequencies(path):
    if not path.exists():
        return np.array([])
    found = []
    for line in path.read_text().splitlines():
        parts = line.split()
        if len(parts) == 5 and parts[0].isdigit():
            found.append(float(parts[3]))
    return np.array(found)

"""Buckle a layered tube in CalculiX: a brick through every ply, no shell theory at all."""

import re
import subprocess

import numpy as np


def _solid_stiffness(ply, angle, *, poisson_across=0.4):
    """C (6, 6) Pa of a ply in (r, hoop, axial): 11 22 33 12 13 23, fibres `angle` off the axis.

    Across the fibres a ply is taken as isotropic; that and `poisson_across` act through the
    thickness alone, which a thin tube hardly feels.
    """
    e1, e2, g12, nu12 = ply.along, ply.across, ply.shear, ply.poisson
    g23 = e2 / (2 * (1 + poisson_across))
    # Axes of the ply: fibre, across in the wall, through the wall; shear 12, 13, 23.
    S = np.diag([1 / e1, 1 / e2, 1 / e2, 1 / g12, 1 / g12, 1 / g23])
    S[0, 1] = S[1, 0] = S[0, 2] = S[2, 0] = -nu12 / e1
    S[1, 2] = S[2, 1] = -poisson_across / e2
    pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
    full = np.zeros((3, 3, 3, 3))
    for i, (a, b) in enumerate(pairs):
        for j, (c, d) in enumerate(pairs):
            value = np.linalg.inv(S)[i, j]
            for p, q in {(a, b), (b, a)}:
                for r, s in {(c, d), (d, c)}:
                    full[p, q, r, s] = value
    # The ply's axes in (r, hoop, axial): fibre along cos·axial + sin·hoop.
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[0, s, c], [0, c, -s], [1, 0, 0]])
    turned = np.einsum("ia,jb,kc,ld,ijkl->abcd", R, R, R, R, full, optimize=True)
    return np.array([[turned[*pairs[i], *pairs[j]] for j in range(6)] for i in range(6)])


def deck(tube, length, *, around, along, torque=1000.0):
    """A tube between ends that keep their circle and turn as one; a brick a ply."""
    edges = tube.outer / 2 - tube.wall + np.concatenate([[0], np.cumsum(tube.thicknesses)])
    layers = len(edges) - 1
    grid = np.full((2 * layers + 1, 2 * around, 2 * along + 1), -1)
    points = []
    radii = np.empty(2 * layers + 1)
    radii[::2], radii[1::2] = edges, (edges[1:] + edges[:-1]) / 2
    for i, j, k in np.ndindex(grid.shape):
        if (i % 2) + (j % 2) + (k % 2) < 2:  # corners and the middles of edges
            t = np.pi * j / around
            grid[i, j, k] = len(points) + 1
            points.append((radii[i] * np.cos(t), radii[i] * np.sin(t), length * k / (2 * along)))
    lines = ["*NODE,NSET=NALL"]
    lines += [f"{n},{x:.10e},{y:.10e},{z:.10e}" for n, (x, y, z) in enumerate(points, 1)]
    corner = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2),
              (0, 2, 2)]  # fmt: skip
    middle = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5),
              (2, 6), (3, 7)]  # fmt: skip
    places = corner + [
        tuple((a + b) // 2 for a, b in zip(corner[p], corner[q], strict=True)) for p, q in middle
    ]
    number = 0
    for layer in range(layers):
        lines.append(f"*ELEMENT,TYPE=C3D20R,ELSET=PLY{layer}")
        for j in range(around):
            for k in range(along):
                number += 1
                nodes = [
                    grid[2 * layer + a, (2 * j + b) % (2 * around), 2 * k + c] for a, b, c in places
                ]
                lines.append(f"{number}," + ",".join(map(str, nodes[:15])) + ",")
                lines.append(",".join(map(str, nodes[15:])))
    lines += ["*ORIENTATION,NAME=ROUND,SYSTEM=CYLINDRICAL", "0,0,0,0,0,1"]
    order = [(0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2), (0, 3), (1, 3), (2, 3), (3, 3),
             (0, 4), (1, 4), (2, 4), (3, 4), (4, 4), (0, 5), (1, 5), (2, 5), (3, 5), (4, 5),
             (5, 5)]  # fmt: skip
    for layer, (ply, angle) in enumerate(zip(tube.plies, tube.angles, strict=True)):
        C = _solid_stiffness(ply, angle)
        values = [f"{C[i, j]:.8e}" for i, j in order]
        lines += [f"*MATERIAL,NAME=M{layer}", "*ELASTIC,TYPE=ANISO"]
        lines += [",".join(values[:8]) + ",", ",".join(values[8:16]) + ",",
                  ",".join(values[16:]) + ",293"]  # fmt: skip
        lines.append(f"*SOLID SECTION,ELSET=PLY{layer},MATERIAL=M{layer},ORIENTATION=ROUND")
    ends = [np.unique(grid[:, :, k][grid[:, :, k] > 0]) for k in (0, 2 * along)]
    for name, nodes in zip(("LEFT", "RIGHT"), ends, strict=True):
        lines += [f"*NSET,NSET={name}", *(f"{n}," for n in nodes)]
        # Local axes: 1 radial, 2 hoop, 3 axial.
        lines += [f"*TRANSFORM,NSET={name},TYPE=C", "0,0,0,0,0,1"]
    radius = {n: np.hypot(*points[n - 1][:2]) for n in ends[1]}
    first, *others = ends[1].tolist()
    for n in others:  # the right end turns as one
        lines += ["*EQUATION", "2", f"{n},2,1.,{first},2,{-radius[n] / radius[first]:.10e}"]
    lines += ["*BOUNDARY", "LEFT,1,2", "RIGHT,1,1", f"{ends[0][0]},3,3"]
    for sign in (1, -1):
        lines += ["*STEP", "*BUCKLE", "2", "*CLOAD,OP=NEW"]
        lines += [f"{first},2,{sign * torque / radius[first]:.10e}", "*END STEP"]
    return "\n".join(lines) + "\n"


def buckling_torques(tube, length, folder, *, around=32, along=40, torque=1000.0, threads=1):
    """The lowest torques, forward and backward, N m: ends pinned (circles that may lean)."""
    (folder / "tube.inp").write_text(deck(tube, length, around=around, along=along, torque=torque))
    done = subprocess.run(
        ["ccx", "tube"], cwd=folder, capture_output=True, text=True, check=False,
        env={"OMP_NUM_THREADS": str(threads), "PATH": "/usr/bin:/bin"},
    )  # fmt: skip
    text = (folder / "tube.dat").read_text()
    found = re.findall(r"^\s+1\s+([-+.\dE]+)\s*$", text, flags=re.MULTILINE)
    assert len(found) == 2, done.stdout[-2000:] + text
    return tuple(torque * float(f) for f in found)

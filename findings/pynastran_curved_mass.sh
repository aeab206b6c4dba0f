#!/usr/bin/env bash
# pyNastran 1.4.1: mass_properties leaves out the middle nodes of CTETRA and each element's own inertia.
#
# Valid input: an octant of a ball of radius 1 and density 6 as one CTETRA of ten nodes, whose middle
# nodes lie on the ball; then of 8 and of 64. Its mass is pi, its moment of inertia about an axis through
# the ball's centre 0.4 pi.
#
# Guess: integrals over the curved element, near 2.7 and 1.0 for one, as a solver has them from the same
# bulk data.
#
# Seen: the mass of the flat tetrahedron of the corners, 1, and of its inertia that of a mass in its
# centroid, 0.125. Both come closer like h^2 and stay too small where a body is curved outwards. No
# warning.
#
# Compare masses of decks with those that a solver prints, or integrate over the elements as the last
# columns do. The deck of a bracket by `cardan bracket --bdf` is 0.07 % off by it; a round one is more.
#
# Run by hand: bash findings/pynastran_curved_mass.sh. Needs Python 3.11 or later and a package index. It
# fails if the output is another one.
set -euo pipefail
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
python3 -m venv "$here/venv"
"$here/venv/bin/pip" install --quiet pyNastran==1.4.1 numpy==1.26.4 scipy==1.17.1
cd "$here"
"$here/venv/bin/python" -W ignore > seen <<'PYTHON'
import itertools

import numpy as np
from pyNastran.bdf.bdf import BDF
from pyNastran.bdf.mesh_utils.mass_properties import mass_properties

EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
DENSITY = 6.0


def on_ball(flat):
    """Return points of the tetrahedron x + y + z <= 1, moved out along their ray into the ball."""
    size = np.linalg.norm(flat, axis=-1, keepdims=True)
    return flat * flat.sum(axis=-1, keepdims=True) / np.where(size > 0, size, 1)


def divided(tetrahedra):
    """Return each tetrahedron (n, 4, 3) as eight."""
    a, b, c, d = (tetrahedra[:, k] for k in range(4))
    ab, bc, ac, ad, bd, cd = (tetrahedra[:, list(e)].mean(axis=1) for e in EDGES)
    parts = ((a, ab, ac, ad), (ab, b, bc, bd), (ac, bc, c, cd), (ad, bd, cd, d),
             (ab, ac, ad, cd), (ab, ac, bc, cd), (ab, ad, bd, cd), (ab, bc, bd, cd))
    found = np.concatenate([np.stack(p, axis=1) for p in parts])
    inside_out = np.linalg.det(found[:, 1:] - found[:, :1]) < 0
    found[inside_out] = found[inside_out][:, [0, 2, 1, 3]]
    return found


def integrated(x):
    """Return mass and inertia about z of ten-node elements (n, 10, 3), by Gauss points."""
    mass = inertia = 0.0
    points, weights = np.polynomial.legendre.leggauss(6)
    points, weights = (points + 1) / 2, weights / 2
    for (r, wr), (s, ws), (t, wt) in itertools.product(zip(points, weights), repeat=3):
        u, v, w = r, s * (1 - r), t * (1 - r) * (1 - s)
        scale = wr * ws * wt * (1 - u) * (1 - u - v)
        one = 1 - u - v - w
        shape = np.array([one * (2 * one - 1), u * (2 * u - 1), v * (2 * v - 1), w * (2 * w - 1),
                          4 * one * u, 4 * u * v, 4 * one * v, 4 * one * w, 4 * u * w, 4 * v * w])
        slope = np.array([
            [1 - 4 * one, 4 * u - 1, 0, 0, 4 * (one - u), 4 * v, -4 * v, -4 * w, 4 * w, 0],
            [1 - 4 * one, 0, 4 * v - 1, 0, -4 * u, 4 * u, 4 * (one - v), -4 * w, 0, 4 * w],
            [1 - 4 * one, 0, 0, 4 * w - 1, -4 * u, 0, -4 * v, 4 * (one - w), 4 * u, 4 * v],
        ])
        volume = np.abs(np.linalg.det(np.einsum("dk,nkx->ndx", slope, x))) * scale
        at = np.einsum("k,nkx->nx", shape, x)
        mass += DENSITY * volume.sum()
        inertia += DENSITY * (volume * (at[:, 0] ** 2 + at[:, 1] ** 2)).sum()
    return mass, inertia


flat = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]])
for _ in range(3):
    middles = np.stack([flat[:, list(e)].mean(axis=1) for e in EDGES], axis=1)
    elements = on_ball(np.concatenate([flat, middles], axis=1))
    model = BDF(debug=False)
    for k, point in enumerate(elements.reshape(-1, 3), 1):
        model.add_grid(k, point)
    for k in range(len(elements)):
        model.add_ctetra(k + 1, 1, list(range(10 * k + 1, 10 * k + 11)))
    model.add_psolid(1, 1)
    model.add_mat1(1, 2.0e5, None, 0.3, rho=DENSITY)
    model.cross_reference()
    mass, _, inertia = mass_properties(model, inertia_reference="ref")
    true_mass, true_inertia = integrated(elements)
    print(f"{len(elements)} elements: mass {mass:.3f}, inertia {inertia[2]:.3f}; "
          f"integrated {true_mass:.3f}, {true_inertia:.3f}")
    flat = divided(flat)
print(f"ball: mass {np.pi:.3f}, inertia {0.4 * np.pi:.3f}")
PYTHON
cat > expected <<'TEXT'
1 elements: mass 1.000, inertia 0.125; integrated 2.673, 0.965
8 elements: mass 2.207, inertia 0.630; integrated 3.100, 1.229
64 elements: mass 2.865, inertia 1.045; integrated 3.138, 1.254
ball: mass 3.142, inertia 1.257
TEXT
diff expected seen

"""What coarse elements elsewhere take from a stress: the error that no neighbour disagrees on.

By the reciprocal theorem the error of a stress at a place is the work that the error of the
field does on that of a second one: the field in which the place itself is strained, by a unit
of what is sought there. Both errors are estimated from stresses that jump from element to element.
Source: Cirak & Ramm, Comput. Methods Appl. Mech. Eng. 156 (1998) 351, after Zienkiewicz & Zhu.
"""

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.physics.fem.elasticity import ElasticSolid
from cardan.physics.fem.meshing import shape_functions
from cardan.physics.fem.stress import von_mises

_UNSEEN = 1.5
"""True over estimated: means over elements that meet are off themselves. 1.4 to 1.6 at a hole in a
sheet of elements far wider than it is thick (`ellipse` of
`tests/verify/test_bracket_maxima.py`)."""

_UNSEEN_WHOLE = 3.0
"""The same of a whole field: at rims of washers elements see least of what they miss, up to 1 of
1.8 by cubic ones on the same mesh, which miss some of it as well."""


def pollution_error(
    body: ElasticSolid,
    displacements: FloatArray,
    smooth: FloatArray,
    goals: Sequence[tuple[int, int]],
) -> FloatArray:
    """Return what each element may have put von Mises stress off by, (goals, elements) Pa.

    One more load case of the same factorisation for each goal. Signs are dropped, so the sum over
    the elements is the more careful number: they cancel, but by luck.

    Parameters
    ----------
    displacements : (c, unknowns)
    smooth : (n, c, 6) Pa
        Their stress at the nodes, the mean of the elements that meet.
    goals
        Node and case: whose stress is sought, the mean over the elements that meet there.
    """
    volumes = body.volumes.sum(axis=1)
    asked = sorted({c for _, c in goals})
    each = map(partial(_strains, body), _gaps(body, displacements[asked], smooth[:, asked]))
    strains = dict(zip(asked, each, strict=True))
    found = np.zeros((len(goals), len(volumes)))
    strained: list[tuple[int, FloatArray]] = []
    for k, (node, c) in enumerate(goals):
        stress = smooth[node, c]
        level = float(von_mises(stress))
        if not level > 0:
            continue
        mean = stress[:3].mean()
        # The derivative of von Mises stress by stress is 3/2 of the deviator over itself.
        slope = 1.5 * (stress - mean * np.array([1, 1, 1, 0, 0, 0])) / level
        meet = np.flatnonzero((body.nodes.elements == node).any(axis=1))
        share = np.zeros(len(volumes))
        share[meet] = 1 / volumes[meet].sum()
        strained.append((k, body.mean_stress_load(share, slope)))
    if not strained:
        return found
    second = body.solve(np.stack([load for _, load in strained]))
    jumps = _gaps(body, second, body.stress_at_nodes(second))
    for (k, _), jump in zip(strained, jumps, strict=True):
        found[k] = _UNSEEN * np.abs(np.einsum("eqi,eqi->e", jump, strains[goals[k][1]]))
    return found


def frequency_error(body: ElasticSolid, frequencies: FloatArray, shapes: FloatArray) -> FloatArray:
    """Return the share (k,) by which frequencies (k,) Hz of shapes (k, unknowns) may be too high.

    Half that of w², which is the stiffness against a shape of unit modal mass.
    """
    return stiffness_error(body, shapes, (2 * np.pi * frequencies) ** 2) / 2


def stiffness_error(body: ElasticSolid, fields: FloatArray, work: FloatArray) -> FloatArray:
    """Return the share (k,) by which a body may be too stiff against fields (k, unknowns).

    Their `work` (k,) is twice their energy. Elements are too stiff by that of what is wrong
    with the field, which jumps of stress show. Source: Strang & Fix, An Analysis of the Finite
    Element Method (1973), chapter 6.
    """
    gaps = _gaps(body, fields, body.stress_at_nodes(fields))
    energy = [float(np.vdot(gap, _strains(body, gap))) for gap in gaps]
    return _UNSEEN_WHOLE * np.array(energy) / work


def _gaps(
    body: ElasticSolid, displacements: FloatArray, smooth: FloatArray
) -> Iterator[FloatArray]:
    """Yield stress that runs through from node to node, less each element's own, (e, q, 6) Pa."""
    N = shape_functions(np.array([p.point for p in body.quadrature_rule()]))
    for c in range(len(displacements)):
        through = N @ smooth[:, c][body.nodes.elements]
        through -= body.within(displacements[c : c + 1])[:, :, 0]
        yield through


def _strains(body: ElasticSolid, stress: FloatArray) -> FloatArray:
    """Return what stress (e, q, 6) Pa strains, times the volume, (e, q, 6) m³.

    Shear counts twice: its product with a stress is work, N m.
    """
    E, nu = body.material.youngs_modulus, body.material.poisson
    give = (1 + nu) * np.diag([1.0, 1, 1, 2, 2, 2]) - np.pad(np.full((3, 3), nu), (0, 3))
    return (stress.reshape(-1, 6) @ (give / E)).reshape(stress.shape) * body.volumes[..., None]

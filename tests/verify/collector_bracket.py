"""The refuse collector's bracket as it is: unit loads in CalculiX, on a mesh of its own.

Writes `collector_bracket.json` beside this file: how the seat gives, what the four gauges read
and what the surface feels under 1 N along each axis. The washers' rings and the holes' walls
stand still and the rest of the flange is free: neither of the two ways in which the program
holds it.

    PYTHONPATH=src python tests/verify/collector_bracket.py     # needs NGSolve (mesh) and ccx
"""

import json
from pathlib import Path
from tempfile import TemporaryDirectory

import calculix
import numpy as np

from cardan.application.catalogue import find_shipped_part
from cardan.core.units import mm
from cardan.model.bracket import UShape
from cardan.physics.fem.elasticity import assemble_elastic_solid
from cardan.physics.fem.geometry import build_solid
from cardan.physics.fem.meshing import mesh

TABLE = Path(__file__).with_suffix(".json")
SHAPE = UShape(
    seat_diameter=120 * mm, width=64 * mm, thickness=5 * mm, height=120 * mm, flange=50 * mm,
    bend_radius=8 * mm, bolt_diameter=11 * mm, bolt_pitch=36 * mm,
)  # fmt: skip
MATERIAL = find_shipped_part("LNE380", "material")
GAUGES = {
    "S1": ((14, 65, 60), (0, 0, 1)),
    "S2": ((14, -65, 60), (0, 0, 1)),
    "S3": ((24, 65, 20), (0, 0, 1)),
    "S4": ((0, 0, -65), (0, 1, 0)),
}
"""Where (mm) and which way."""
APART = 5 * mm
"""Between places of the surface that are told."""
PLACES = 48
PLANES = 24


def solved(*, size: float, shape: UShape = SHAPE) -> dict:
    """Return the table of a bracket meshed with edges of `size` m."""
    drawn = build_solid(shape)
    held = drawn.fixed_faces("sliding")
    nodes = assemble_elastic_solid(
        mesh(drawn.shape, size=size, per_radius=3), MATERIAL, held=held
    ).nodes
    loads = calculix.seat_loads(nodes)[:3]
    deck = calculix.deck(nodes, MATERIAL, held=tuple(held), loads=loads)
    with TemporaryDirectory() as folder:
        static, _, _ = calculix.run(deck, Path(folder))
    compliance = [float((f * u).sum()) for f, (u, _) in zip(loads, static, strict=True)]
    stress = np.stack([s for _, s in static])  # (3, n, xx yy zz xy yz zx) Pa/N
    E, nu = MATERIAL.youngs_modulus, MATERIAL.poisson
    read = {}
    for name, (at, way) in GAUGES.items():
        far = np.linalg.norm(nodes.points[nodes.surface_nodes] - np.array(at) * mm, axis=-1)
        tensor = stress[:, nodes.surface_nodes[far < 2.5 * mm]].mean(1)
        along = tensor[:, int(np.argmax(way))]
        read[name] = (((1 + nu) * along - nu * tensor[:, :3].sum(-1)) / E).tolist()
    # Where a bolt's washer ends nothing but a structural stress makes sense.
    p = nodes.points[nodes.surface_nodes]
    off = np.linalg.norm(p[:, None] - np.array(shape.bolt_positions), axis=-1).min(-1)
    clear = nodes.surface_nodes[off > shape.bolt_diameter + shape.thickness]
    way = np.linspace(0, np.pi, PLANES, endpoint=False)
    pushed = np.einsum("ka,anc->knc", np.stack([np.cos(way), np.sin(way)], -1), stress[1:, clear])
    worst = np.abs(np.linalg.eigvalsh(tensors(pushed))).max((0, -1))
    told: list[int] = []
    for k in clear[np.argsort(-worst)]:
        if len(told) < PLACES and all(
            np.linalg.norm(nodes.points[k] - nodes.points[j]) > APART for j in told
        ):
            told.append(int(k))
    return {
        "nodes": len(nodes.points),
        "compliance_m_N": compliance,
        "strain_per_N": read,
        "places_mm": (nodes.points[told] / mm).round(2).tolist(),
        "stress_Pa_per_N": stress[:, told].swapaxes(0, 1).round(2).tolist(),
    }


def tensors(stress: np.ndarray) -> np.ndarray:
    """Tensors (..., 3, 3) of stresses (..., xx yy zz xy yz zx)."""
    return stress[..., [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]


if __name__ == "__main__":
    table = solved(size=3.5 * mm)
    TABLE.write_text(json.dumps(table) + "\n")

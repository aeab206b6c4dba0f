"""A bracket's mesh with displacements, stresses and damage as a VTK file."""

import base64
from typing import Any

import numpy as np
import numpy.typing as npt

from cardan.core.arrays import FloatArray
from cardan.physics.fem.stress import superpose, von_mises
from cardan.topics.bracket.shape_result import (
    CaseResult,
    LocatedDisplacement,
    ShapeAssessment,
    vector_as_tuple,
)


def displacement_and_stress_at_case_peak(
    v: ShapeAssessment, o: CaseResult
) -> tuple[FloatArray, FloatArray]:
    """Return displacement (n, 3) m and von Mises stress (n,) Pa at the nodes, when a case peaks."""
    u, stress = v.solved.displacement, v.solved.stress
    loads = peak_loads(v, o)
    return (
        superpose_unit_displacements(u, loads),
        von_mises(superpose(stress, loads[None]))[:, 0],
    )


def peak_loads(v: ShapeAssessment, o: CaseResult) -> FloatArray:
    """Return the loads (9,) of a case at the moment at which it stresses most."""
    return o.case.loads[_peak(v, o)]


def max_displacement_at_peak(v: ShapeAssessment, o: CaseResult) -> LocatedDisplacement:
    """Return the largest displacement when a case peaks, quasi-static, the flange sliding."""
    moved = superpose_unit_displacements(v.solved.displacement, peak_loads(v, o))
    size = np.linalg.norm(moved, axis=-1)
    return LocatedDisplacement(
        float(size.max()), vector_as_tuple(v.solved.nodes.points[int(size.argmax())])
    )


def _peak(v: ShapeAssessment, o: CaseResult) -> int:
    """Return the moment at which a case stresses most the place where it stresses most."""
    nodes = v.solved.nodes.surface_nodes
    gap = v.solved.nodes.points[nodes] - np.asarray(o.von_mises.point)
    near = nodes[np.linalg.norm(gap, axis=-1).argmin()]
    return int(von_mises(superpose(v.solved.stress[near], o.case.loads)).argmax())


def superpose_unit_displacements(unit: FloatArray, loads: FloatArray) -> FloatArray:
    """Return vectors (n, 3) of loads (9,) from unit vectors (n, 9, 3)."""
    return np.einsum("nux,u->nx", unit, loads)


def vtu_text(v: ShapeAssessment, *, said: str = "") -> str:
    """Return a VTK unstructured grid: the mesh with what each case does when it peaks.

    Quadratic tetrahedra; coordinates and displacements in metres, stresses in Pa. `said` is the
    verdict, a field of the whole: the file may be all that is passed on.
    """
    nodes = v.solved.nodes
    count, cells = len(nodes.points), len(nodes.elements)
    fields: list[str] = []
    for o in v.case_results:
        u, mises = displacement_and_stress_at_case_peak(v, o)
        fields.append(_array(f"{o.case.when}: displacement", u.astype("<f4"), components=3))
        fields.append(_array(f"{o.case.when}: von Mises", mises.astype("<f4")))
    unit = superpose(v.solved.stress, peak_loads(v, v.worst_case)[None])[:, 0]
    fields.append(_array(f"{v.worst_case.case.when}: stress", unit.astype("<f4"), components=6))
    if len(v.damage_map):
        worn_ = np.zeros(count)
        worn_[nodes.surface_nodes] = v.damage_map
        fields.append(_array("damage of an hour of duty", worn_.astype("<f4")))
    offsets = np.arange(1, cells + 1, dtype="<i8") * 10
    return "\n".join([
        '<?xml version="1.0"?>',
        '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '
        'header_type="UInt64">',
        "<UnstructuredGrid>", *([_verdict_field(said)] if said else []),
        f'<Piece NumberOfPoints="{count}" NumberOfCells="{cells}">',
        "<PointData>", *fields, "</PointData>",
        "<Points>", _array("Points", nodes.points.astype("<f8"), components=3), "</Points>",
        "<Cells>",
        _array("connectivity", nodes.elements.astype("<i8")),
        _array("offsets", offsets),
        _array("types", np.full(cells, 24, dtype="u1")),  # VTK_QUADRATIC_TETRA
        "</Cells>",
        "</Piece></UnstructuredGrid></VTKFile>", "",
    ])  # fmt: skip


def _verdict_field(said: str) -> str:
    """Return a text as a VTK file has it: the bytes of its letters, and a zero byte."""
    letters = " ".join(str(b) for b in (*said.encode(), 0))
    return (
        '<FieldData><DataArray type="String" Name="verdict" NumberOfTuples="1" format="ascii">'
        f"{letters}</DataArray></FieldData>"
    )


_VTK_TYPES = {"f4": "Float32", "f8": "Float64", "i8": "Int64", "u1": "UInt8"}


def _array(name: str, values: npt.NDArray[Any], *, components: int = 1) -> str:
    """Return one array of a VTK file: its size, then its bytes, in base 64."""
    from xml.sax.saxutils import quoteattr

    raw = np.ascontiguousarray(values).tobytes()
    data = base64.b64encode(np.uint64(len(raw)).astype("<u8").tobytes() + raw).decode()
    kind = _VTK_TYPES[values.dtype.str[1:]]
    return (
        f'<DataArray type="{kind}" Name={quoteattr(name)} NumberOfComponents="{components}" '
        f'format="binary">{data}</DataArray>'
    )

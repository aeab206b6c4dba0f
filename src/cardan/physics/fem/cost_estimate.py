"""How large a bracket's model will be, before any of it is meshed."""

import os
from dataclasses import dataclass, replace

from cardan.core.errors import DesignError
from cardan.core.units import Metre, mm

MAX_MEMORY_BYTES = 4e9
"""Bytes a solution may take at most; less where the machine has less."""
MAX_SOLVE_MINUTES = 15.0
"""It may take at most, on two threads."""

_UNKNOWNS = {1: 0.9, 2: 6.2, 3: 18.0, 4: 40.0}
"""To an element, by its degree, in a sheet one or two elements thick: counted."""
_COARSEST = 5.0
"""Times a sheet's thickness, elements of it that an estimate believes."""
_ADDED = 35e3
"""Unknowns that bends, ribs and refinement where it is worst add to those of plain sheet, whatever
its elements: on six brackets 14 to 57 thousand."""
_BEHIND, _BOLTED = 3.0, 7.0
"""Elements behind a triangle of a face that needs smaller ones than the rest; in contact, whose
heads are followed on each mesh: so unknowns of seven brackets are estimated to 0.73 to 1.28 of
them."""
_PLACES = 0.12
"""Of the unknowns, places where stress in contact is kept: six numbers of four bytes a force, and
as much again for the factors that solve for dozens of forces at once."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CostEstimate:
    """What a solution will take: good to a factor of two.

    Attributes
    ----------
    elements, unknowns
        Of the last mesh.
    memory
        Bytes.
    minutes
        For all meshes.
    """

    elements: float
    unknowns: float
    memory: float
    minutes: float

    def __str__(self) -> str:
        """Return it as people read it."""
        return (
            f"about {_rounded(self.unknowns)} unknowns, {_two(self.memory / 1e9)} GB and "
            f"{_two(max(self.minutes, 0.1))} minutes"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelSize:
    """A model as it is requested.

    Attributes
    ----------
    volume, area
        Of the solid, m³ and m² of its surface.
    element_size
        Edge of its elements, m.
    degree
        Of their displacements.
    fine_face_triangles
        Triangles of faces that need a smaller edge, washers above all.
    contact_forces
        Between flange and frame, in contact.
    """

    volume: float
    area: float
    element_size: Metre
    degree: int
    fine_face_triangles: float = 0.0
    contact_forces: float = 0.0

    @property
    def thickness(self) -> Metre:
        """Of a sheet of that volume and surface."""
        return 2 * self.volume / self.area


def triangle_count(area: float, edge: Metre) -> float:
    """Return how many triangles of an edge cover an area m²."""
    return area / (0.433 * edge**2)


def estimate_cost(of: ModelSize) -> CostEstimate:
    """Estimate what a model takes.

    A sheet is as many prisms of three tetrahedra as triangles of the edge cover one side of
    it, in as many layers as the edge goes into its thickness. Memory and time are those of
    sparse Cholesky factorisations of a sheet's stiffness, two of the last mesh, one for each way
    its flange is held: measured at 43, 72 and 260 thousand unknowns. In contact there is a third,
    for which these make room, and each force takes its time, solved for by dozens: 0.039 to 0.046 s
    of a processor on seven shapes, and all else 29 to 49, each as of 72,705 unknowns, next to other
    work on two cores; alone a fifth less.
    """
    layers = max(of.thickness / of.element_size, 1.0)
    behind = _BOLTED if of.contact_forces else _BEHIND
    elements = (
        1.3 * 3 * layers * triangle_count(of.area / 2, of.element_size)
        + behind * of.fine_face_triangles
    )
    unknowns = _ADDED + _UNKNOWNS[of.degree] * elements
    denser = (of.degree / 2) ** 1.0  # higher degrees couple more unknowns to each
    factor, plain = 20 * unknowns ** (4 / 3), 8e3 * unknowns
    contact = of.contact_forces * 48 * _PLACES * unknowns
    seconds = (35 + of.contact_forces * 0.040) * (unknowns / 72_705) ** 1.42
    return CostEstimate(
        elements=unknowns / _UNKNOWNS[of.degree],
        unknowns=unknowns,
        memory=0.2e9 + denser * (plain + 2 * factor) + contact,
        minutes=denser * seconds / 60,
    )


def check_affordable(model: ModelSize) -> CostEstimate:
    """Estimate a model, and refuse one that would take too much memory or time.

    Washers and bends need elements by the sheet's thickness, however large those requested are.

    Raises
    ------
    DesignError
        With the estimate, the limits and what to change.
    """
    coarsest = _COARSEST * model.thickness
    size, degree, forces = min(model.element_size, coarsest), model.degree, model.contact_forces

    def of(edge: Metre, forces: float) -> CostEstimate:
        return estimate_cost(replace(model, element_size=edge, contact_forces=forces))

    def fits(one: CostEstimate) -> bool:
        return one.memory <= memory and one.minutes <= MAX_SOLVE_MINUTES

    memory = min(MAX_MEMORY_BYTES, 0.6 * _installed())
    if fits(found := of(size, forces)):
        return found
    wanted = size
    while wanted < 1e3 * size and not fits(of(wanted, forces)):
        wanted *= 1.1
    lower = " or a lower `order`" if degree > 2 else ""
    msg = (
        f"elements of {size / mm:.3g} mm, degree {degree}, would make {found}; allowed are "
        f"{memory / 1e9:.2g} GB and {MAX_SOLVE_MINUTES:g} minutes: "
    )
    if wanted < coarsest:
        msg += f"try `element_mm: {wanted / mm:.2g}`{lower}, or check the bracket's sizes"
    elif forces and fits(of(coarsest, 0.0)):
        msg += "contact in its bolts takes that: leave out `bolts`, or check the bracket's sizes"
    else:
        msg += (
            f"a sheet of {model.thickness / mm:.2g} mm needs such elements at its bolts, bends "
            "and rounds, whatever `element_mm` says: check its thickness, how large it is, and "
            "whether small rounds need be drawn"
        )
    raise DesignError(msg, about="bracket")


def _installed() -> float:
    """Return the memory of this machine, bytes; infinite where it does not say."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, OSError, ValueError):
        return float("inf")


def _two(value: float) -> str:
    """Return a number to two digits, without a power of ten: 0.83, 1900."""
    return f"{float(f'{value:.2g}'):g}"


def _rounded(value: float) -> str:
    """Return a number of things to two digits: 57 thousand, 1.2 million."""
    for name, size in (("million", 1e6), ("thousand", 1e3)):
        if value >= size:
            digits = ".2g" if value < 100 * size else ".0f"
            return f"{value / size:{digits}} {name}"
    return f"{value:.0f}"

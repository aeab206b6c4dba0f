"""Virtual strain gauges: what they read under unit loads, and what their readings say back."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray
from cardan.core.errors import DesignError
from cardan.core.units import mm
from cardan.model.bracket import BracketStrainGauge
from cardan.physics.fem.bracket_solid import MOUNT_FACE_NAME, SEAT_FACE_NAME, WELDED_END_NAME_PREFIX
from cardan.physics.fem.surface import project_to_surface
from cardan.physics.fem.unit_loads import UnitSolutions

_STEPS = 4
"""Steps to either side that a grid is followed in, along a surface that may be bent."""
_OFF = 0.5
"""Of a step, how far off the surface it may end: over an edge it ends a whole one off."""

_FACTOR = 0.01
"""Share by which any gauge may read too much or too little: what is printed on a packet of them."""

MIN_SENSITIVITY_SHARE_OF_STRONGEST_LOAD = 0.2
"""Share of what the load that gauges feel most does to them, below which the least load is not read
back: what a wire has of noise would stand for it."""
_BETWEEN, _NOTHING = 101, 1e-9
"""Flanges between the two that are tried; and the share of what gauges read that is nothing."""

_ASTRAY = 0.45
"""Share of the sheet's thickness that a gauge's point may lie off its surface: in its middle the
side is unknown."""


def gauge_influence_matrix(
    units: UnitSolutions, gauges: Sequence[BracketStrainGauge]
) -> FloatArray:
    """Strains (g, 9) that gauges read under the unit loads.

    A reading is by how much the grid, which lies in the surface, grows longer, over its length:
    of how its ends move, whatever the strain is in the elements between.

    Raises
    ------
    DesignError
        If a gauge does not lie on the bracket, cannot be got at, or points into it.
    """
    if not gauges:
        return np.zeros((0, len(units.displacements)))
    motion = units.elastic.displacement_at_nodes(units.displacements)
    return np.stack([_reading(units, motion, gauge) for gauge in gauges])


def gauge_strain_error_by_misplacement(
    units: UnitSolutions, gauges: Sequence[BracketStrainGauge]
) -> FloatArray:
    """Strains (g, 9) by which gauges may read the unit loads wrong, by where they are glued.

    Each as far off its place, along its grid and across, and as much askew as it may be, all by
    chance; and the scatter of what gauges make of a strain. Where there is no place so far off, on
    the other side; on neither, none.
    """
    if not gauges:
        return np.zeros((0, len(units.displacements)))
    motion = units.elastic.displacement_at_nodes(units.displacements)
    nodes = units.elastic.nodes
    found: list[FloatArray] = []
    for gauge in gauges:
        right = _reading(units, motion, gauge)
        normal = project_to_surface(nodes, [gauge.point]).normals[0]
        along = _laid(gauge, np.asarray(gauge.direction), normal)
        across = np.cross(normal, along)
        wrong = [(gauge.off * way, 0.0) for way in (along, across)] + [(0 * along, gauge.askew)]
        off = [_FACTOR * right]
        for step, turn in wrong:
            for sign in (1, -1):
                x, y, z = np.asarray(gauge.point) + sign * step
                way = np.cos(turn) * along + sign * np.sin(turn) * across
                other = replace(gauge, point=(x, y, z), direction=tuple(way))
                with suppress(DesignError):
                    off.append(_reading(units, motion, other) - right)
                    break
        found.append(np.linalg.norm(off, axis=0))
    return np.stack(found)


def _reading(units: UnitSolutions, motion: FloatArray, gauge: BracketStrainGauge) -> FloatArray:
    """Strain (9,) one gauge reads as the nodes move, (n, 9, 3) m."""
    nodes = units.elastic.nodes
    middle = project_to_surface(nodes, [gauge.point, gauge.point])  # from where it goes both ways
    where = ", ".join(f"{v / mm:.2f}" for v in middle.points[0])
    if middle.distances[0] > _ASTRAY * units.solid.thickness:
        msg = (
            f"gauge {gauge.name} is {middle.distances[0] / mm:.3g} mm off the bracket's surface; "
            f"the nearest point of it is ({where}) mm"
        )
        raise DesignError(msg, about="bracket.gauges")
    hidden = _hidden(str(nodes.face_names[middle.faces[0]]))
    if hidden:
        msg = f"gauge {gauge.name}, at ({where}) mm, lies {hidden}: no gauge can be glued there"
        raise DesignError(msg, about="bracket.gauges")
    heading = _laid(gauge, np.asarray(gauge.direction), middle.normals[0])
    ways, step = np.stack([heading, -heading]), gauge.length / (2 * _STEPS)
    grid = [middle]
    for _ in range(_STEPS):
        here = grid[-1]
        # Each step lies in the surface where it starts.
        ways = ways - (ways * here.normals).sum(-1, keepdims=True) * here.normals
        size = np.linalg.norm(ways, axis=-1, keepdims=True)
        ways /= np.maximum(size, 1e-300)
        grid.append(project_to_surface(nodes, here.points + step * ways))
        if grid[-1].distances.max() > _OFF * step or size.min() < _OFF:
            msg = (
                f"the grid of gauge {gauge.name}, {gauge.length / mm:g} mm long, hangs over an "
                "edge: move or shorten it"
            )
            raise DesignError(msg, about="bracket.gauges")
    steps = np.diff([at.interpolate(nodes, nodes.points) for at in grid], axis=0)
    sizes = np.linalg.norm(steps, axis=-1)
    longer = np.diff([at.interpolate(nodes, motion) for at in grid], axis=0)
    grown = np.einsum("skx,skcx->c", steps / sizes[..., None], longer)
    return np.asarray(grown / sizes.sum(), dtype=float)


def _hidden(face: str) -> str:
    """Return what covers a face of a name; nothing where a gauge can lie on it."""
    if face == SEAT_FACE_NAME:
        return "under the bearing"
    return (
        "against the frame"
        if face == MOUNT_FACE_NAME or face.startswith(("bolt ", WELDED_END_NAME_PREFIX))
        else ""
    )


def _laid(gauge: BracketStrainGauge, direction: FloatArray, normal: FloatArray) -> FloatArray:
    """Lay a direction into the surface."""
    flat = direction - (direction @ normal) * normal
    size = float(np.linalg.norm(flat))
    if size < 0.1 * float(np.linalg.norm(direction)):
        msg = f"gauge {gauge.name} points into the surface: its direction is that of the normal"
        raise DesignError(msg, about="bracket.gauges")
    return flat / size


@dataclass(frozen=True)
class RecoveredLoads:
    """Bearing forces read back from strains.

    Attributes
    ----------
    loads : (..., c) N
    residual : (...) 1
        Root mean square strain that the loads do not explain: large where something else
        strains the gauges.
    condition : float
        Largest over smallest gain of the gauges: how much worse the worst-seen direction of
        load is seen than the best.
    noise : (c,) N
        Standard deviation of each load for readings with one microstrain of noise.
    inverse : (c, g) N
        What strain of each gauge makes of each load.
    influence : (g, c) 1/N
        Strain of each gauge under a unit of each load.
    influence_error : (g, c) 1/N
        Strain by which each gauge may read a unit of each load wrong.
    unexplained_share : float
        Share of what gauges read that their loads do not explain, its part in the loads with it;
        nothing where there are no more gauges than loads, and it is unknown.
    flange_fixity : float
        How it is held, between sliding, 0, and clamped, 1, as far as gauges show.
    fixity_error : (c, c)
        By how much each load may be off for a unit of each, for a flange held otherwise.
    """

    loads: FloatArray
    residual: FloatArray
    condition: float
    noise: FloatArray
    inverse: FloatArray
    influence: FloatArray
    influence_error: FloatArray
    unexplained_share: float
    flange_fixity: float
    fixity_error: FloatArray

    def strain_error(self, size: FloatArray) -> FloatArray:
        """Return the strain (g,) by which gauges may read loads (c,) N wrong, each load by chance.

        The more of what is predicted of each and what no load explains of all: of the same errors
        the one shows before what the other shows after.
        """
        left = self.unexplained_share * np.sqrt(np.mean(((self.influence * size) ** 2).sum(axis=1)))
        return np.maximum(np.linalg.norm(self.influence_error * size, axis=1), left)

    @property
    def load_error(self) -> FloatArray:
        """How much each load (c,) N may be off where they are largest."""
        return np.linalg.norm(
            self.load_error_components(np.abs(self.loads).reshape(-1, len(self.noise)).max(0)),
            axis=1,
        )

    def load_error_components(self, size: FloatArray) -> FloatArray:
        """Return how loads (c,) N may be off, (c, g + c) N: by each gauge, by each for the flange.

        One of them each is by chance.
        """
        return np.concatenate(
            [self.inverse * self.strain_error(size), self.fixity_error * size], axis=1
        )


def recover_loads(
    influence: ArrayLike,
    strains: ArrayLike,
    *,
    unsure: ArrayLike | None = None,
    worst: float = 1e3,
) -> RecoveredLoads:
    """Find the loads that explain measured strains best, by least squares.

    Parameters
    ----------
    influence : (g, c)
        Strain of each gauge under each unit load to be distinguished, such as the first three
        columns of `influence`: loads of one kind, so that their gains compare.
    strains : (..., g)
        Readings, whatever came before them: a history, a set of cases.
    unsure : (c,) or (g, c)
        Strain by which the influence of gauges may be off, by load; none where it is exact.
    worst
        Refuse to answer above this condition.

    Raises
    ------
    DesignError
        If the gauges are too few, or cannot separate the loads.
    """
    B, strains = np.asarray(influence, dtype=float), np.asarray(strains, dtype=float)
    gauges, loads = B.shape
    if strains.shape[-1] != gauges:
        msg = f"{gauges} gauges have an influence, {strains.shape[-1]} a reading"
        raise ValueError(msg)
    if gauges < loads:
        msg = f"{gauges} gauges cannot separate {loads} loads: add gauges or drop loads"
        raise DesignError(msg, about="bracket.gauges")
    U, gains, V = np.linalg.svd(B, full_matrices=False)
    condition = float(gains[0] / gains[-1]) if gains[-1] > 0 else np.inf
    if not condition <= worst:
        blind = ", ".join(f"{v:+.2f}" for v in V[-1])
        msg = (
            f"the gauges cannot separate these loads (condition {condition:.3g}, at most "
            f"{worst:g}): they hardly feel a load along ({blind}); move or add a gauge"
        )
        raise DesignError(msg, about="bracket.gauges")
    inverse = (V.T / gains) @ U.T
    found = strains @ inverse.T
    left = strains - found @ B.T
    spread = [float((np.square(s - s.mean(axis=0))).sum()) for s in (
        left.reshape(-1, gauges), strains.reshape(-1, gauges)
    )]  # fmt: skip
    spare = gauges - loads
    return RecoveredLoads(
        loads=found,
        residual=np.sqrt((left**2).mean(axis=-1)),
        condition=condition,
        noise=1e-6 * np.sqrt((inverse**2).sum(axis=-1)),
        inverse=inverse,
        influence=B,
        influence_error=np.broadcast_to(
            0.0 if unsure is None else np.asarray(unsure, float), B.shape
        ),
        unexplained_share=np.sqrt(spread[0] / spread[1] * gauges / spare)
        if spare and spread[1]
        else 0.0,
        flange_fixity=0.0,
        fixity_error=np.zeros((loads, loads)),
    )


def recover_loads_and_flange_clamping(
    sliding: FloatArray, clamped: FloatArray, strains: FloatArray, *, unsure: FloatArray
) -> RecoveredLoads:
    """Find loads by gauges on a flange held in an unknown way, between two ways.

    By that influence between both, (g, c) each, that leaves least of strains (t, g) unexplained;
    where there are no more gauges than loads, or nothing moves, by the sliding one. `unsure` (g, c)
    is that of either. What is off by chance may look like another flange: by so much it may be.
    """
    change, shares = clamped - sliding, np.linspace(0, 1, _BETWEEN)
    moves = np.cov(strains.T, bias=True)
    left = [float(np.trace(_unread(sliding + share * change) @ moves)) for share in shares]
    tells = left[0] > _NOTHING * np.trace(moves)
    share = float(shares[int(np.argmin(left))]) if tells else 0.0
    back = recover_loads(sliding + share * change, strains, unsure=unsure)
    swings = np.cov(back.loads.T, bias=True)
    seen = float(np.trace(_unread(back.influence) @ change @ swings @ change.T))
    chance = float(np.sqrt(np.mean(back.strain_error(np.sqrt(swings.diagonal())) ** 2)))
    off = min(1.0, chance / np.sqrt(seen)) if seen > _NOTHING * np.trace(moves) else 1.0
    return replace(back, flange_fixity=share, fixity_error=off * back.inverse @ change)


def _unread(influence: FloatArray) -> FloatArray:
    """Return what of strains (g, g) no load explains."""
    return np.eye(len(influence)) - influence @ np.linalg.pinv(influence)


def correct_loads_for_flange_clamping(
    sliding: FloatArray, clamped: FloatArray, loads: FloatArray, *, unsure: FloatArray
) -> RecoveredLoads:
    """Return loads (t, c) that were read by the sliding influence, and how they may be off.

    He read the least load that gauges feel, and had the rest from elsewhere. What gauges read is
    gone, so it is unknown what was left unexplained, or how the flange was held.
    """
    back = recover_loads(sliding, loads @ sliding.T, unsure=unsure)
    inverse = np.linalg.pinv(sliding, rcond=MIN_SENSITIVITY_SHARE_OF_STRONGEST_LOAD)
    return replace(back, loads=loads, inverse=inverse, fixity_error=inverse @ (clamped - sliding))

"""A line with its yokes put together in every way a spline allows by quarters: side by side."""

from itertools import product
from math import pi

import numpy as np

from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.core.arrays import FloatArray
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import Radian
from cardan.physics.kinematics.equivalent_angle import EquivalentSingleJoint, KinematicExcitation

MAX_PHASED_SHAFTS = 5
"""Shafts whose yokes are turned; 32 lines side by side are more than can be read."""


@dataclass(frozen=True, kw_only=True)
class YokePhasing:
    """A line with other yoke phases: 0 is aligned, a quarter turn crossed.

    Attributes
    ----------
    phases : (n-1,) rad
        Of every shaft.
    is_installed
        Whether that is how the application has it.
    state_names : (S,)
        Names of the states.
    exact_excitation, ae7_excitation
        What it excites in each of them, (S,): exactly, and by the field's addition of squares.
    """

    phases: tuple[Radian, ...]
    is_installed: bool
    state_names: tuple[str, ...]
    exact_excitation: KinematicExcitation
    ae7_excitation: KinematicExcitation


def yoke_phasings(response: LineResponse) -> tuple[YokePhasing, ...]:
    """Return a line with every shaft between two crosses aligned and crossed.

    The line as installed is among them, first if its phases are no quarters. A line without
    such a shaft, or one whose yokes are not to be chosen, has none.

    Notes
    -----
    Source: Souza (2014), figure 36 and tables 4 and 5, there for two shafts.
    """
    crosses, own = response.line.is_cross, tuple(float(p) for p in response.line.phases)
    free = [k for k in range(len(own)) if crosses[k] and crosses[k + 1]][-MAX_PHASED_SHAFTS:]
    if not free or np.ndim(response.phases) != 1:
        return ()
    found = [
        tuple(turned.get(k, p) for k, p in enumerate(own))
        for quarters in product((0.0, pi / 2), repeat=len(free))
        for turned in (dict(zip(free, quarters, strict=True)),)
    ]
    if not any(_same(own, one) for one in found):
        found.insert(0, own)
    several = compute_line_response(
        response.application,
        response.demand,
        lay=response.layout_for,
        phases=np.array(found)[:, None, :],
    )
    exact, ae7 = several.kinematics.excitation, several.kinematics.approximate_excitations["ae7"]
    return tuple(
        YokePhasing(
            phases=one,
            is_installed=_same(own, one),
            state_names=response.demand.states,
            exact_excitation=_one(exact, k),
            ae7_excitation=_one(ae7, k),
        )
        for k, one in enumerate(found)
    )


def _same(one: tuple[Radian, ...], other: tuple[Radian, ...]) -> bool:
    """Return whether yokes stand alike: half a turn on they are the same."""
    return all(abs((a - b + pi / 2) % pi - pi / 2) < 1e-9 for a, b in zip(one, other, strict=True))


def _one(of: KinematicExcitation, k: int) -> KinematicExcitation:
    """Return what one of several lines excites."""

    def joint(many: EquivalentSingleJoint) -> EquivalentSingleJoint:
        return EquivalentSingleJoint(
            angle=_at(many.angle, k), acceleration=_at(many.acceleration, k)
        )

    return KinematicExcitation(
        torsional=joint(of.torsional),
        drive=joint(of.drive),
        coast=joint(of.coast),
        drive_torque=None if of.drive_torque is None else _at(of.drive_torque, k),
        coast_torque=None if of.coast_torque is None else _at(of.coast_torque, k),
        irregularity=_at(of.irregularity, k),
    )


def _at(values: FloatArray, k: int) -> FloatArray:
    return values[k] if values.ndim > 1 else values

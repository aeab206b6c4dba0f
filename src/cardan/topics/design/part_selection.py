"""Which parts of a catalogue carry a torque: what each uses of its ratings, what fits first."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import inf

import numpy as np

from cardan.application.catalogue_rows import CatalogueRow
from cardan.core.errors import DesignError
from cardan.core.units import Metre, NewtonMetre, Radian, RadianPerSecond
from cardan.model.parts import JointSize, Tube
from cardan.physics.strength.bearing_life import rated_torque_from_catalogue
from cardan.physics.strength.critical_speed import slender_tube_critical_speed
from cardan.physics.strength.torsional_strength import (
    JointTorqueAndDutyDemand,
    joint_size_utilisations,
    smallest_joint_size,
    tube_utilisation,
)  # fmt: skip

MAX_CRITICAL_SPEED_RATIO = 0.75
"""Share of the critical speed that counts as used up. Source: SAE AE-7, p. 267, quoted."""


@dataclass(frozen=True, kw_only=True)
class PartRequirement:
    """What a part has to carry: a torque with its shocks, and what else is given.

    `speed` and `angle` are what a joint turns at, `life` how long it shall do so under the
    torque, `prime_mover_factor` K1 of that life, `length` a shaft's.
    """

    torque: NewtonMetre
    speed: RadianPerSecond | None = None
    angle: Radian | None = None
    life: float | None = None
    prime_mover_factor: float = 1.0
    length: Metre | None = None

    @property
    def has_life_data(self) -> bool:
        """Whether a joint's life can be computed."""
        return None not in (self.speed, self.angle, self.life)

    @property
    def joint_demand(self) -> JointTorqueAndDutyDemand:
        """It, as one point of a duty cycle."""
        return JointTorqueAndDutyDemand(
            peak_torque=self.torque,
            torque=np.array([self.torque]),
            speed=np.array([self.speed or 0.0]),
            angle=np.array([self.angle or 0.0]),
            shares=np.array([1.0]),
            life=self.life or 0.0,
            prime_mover_factor=self.prime_mover_factor,
        )


@dataclass(frozen=True, kw_only=True)
class PartCandidate:
    """A row, what is used of each of its part's ratings, and which ratings are not published.

    `size` is what rows are sorted by: a joint's peak torque, a tube's mass a metre.
    """

    row: CatalogueRow
    utilisations: dict[str, float]
    unknown_ratings: tuple[str, ...]
    sort_size: float

    @property
    def max_utilisation(self) -> float:
        """The largest share in use; infinite if a required rating is unknown."""
        return inf if self.unknown_ratings else max(self.utilisations.values())

    @property
    def is_sufficient(self) -> bool:
        """Whether it does."""
        return self.max_utilisation <= 1


def rank_candidates(
    rows: Iterable[CatalogueRow], asked: PartRequirement
) -> tuple[PartCandidate, ...]:
    """Return rows of joints or tubes: what fits, the smallest first; then the nearest to it."""
    found = [_joint(r, asked) if isinstance(r.part, JointSize) else _tube(r, asked) for r in rows]
    return tuple(
        sorted(
            found,
            key=lambda f: (
                not f.is_sufficient,
                f.sort_size if f.is_sufficient else f.max_utilisation,
            ),
        )
    )


def _joint(row: CatalogueRow, asked: PartRequirement) -> PartCandidate:
    size: JointSize = row.part
    used = joint_size_utilisations(size, asked.joint_demand)
    kept = {"joint_torque_utilisation"}
    kept |= {"joint_speed"} if asked.speed is not None else set()
    kept |= {"joint_angle"} if asked.angle is not None else set()
    kept |= {"n_beta"} if asked.speed is not None and asked.angle is not None else set()
    kept |= {"joint_life"} if asked.has_life_data else set()
    needed = {"joint_torque_utilisation", "joint_life"} & kept
    return PartCandidate(
        row=row,
        utilisations={k: v for k, v in used.items() if k in kept},
        unknown_ratings=tuple(sorted(needed - used.keys())),
        sort_size=size.peak_torque or inf,
    )


def _tube(row: CatalogueRow, asked: PartRequirement) -> PartCandidate:
    tube: Tube = row.part
    used: dict[str, float] = {}
    if tube.material.yield_strength is not None:
        used["tube_shear_utilisation"] = float(
            tube_utilisation(
                asked.torque, outer=tube.outer, inner=tube.inner,
                yield_strength=tube.material.yield_strength, shock_factor=1.0,
            )
        )  # fmt: skip
    if asked.speed is not None and asked.length is not None:
        whirls = slender_tube_critical_speed(
            asked.length, outer=tube.outer, inner=tube.inner,
            youngs_modulus=tube.material.youngs_modulus, density=tube.material.density,
        )  # fmt: skip
        used["critical_speed_ratio"] = float(asked.speed / whirls / MAX_CRITICAL_SPEED_RATIO)
    unknown = () if "tube_shear_utilisation" in used else ("tube_shear_utilisation",)
    return PartCandidate(
        row=row, utilisations=used, unknown_ratings=unknown, sort_size=tube.mass_per_length
    )


def smallest_joint_name(rows: Iterable[CatalogueRow], asked: PartRequirement) -> str:
    """Return the name of the joint of the least life rating that does; empty if none does.

    What is required must be `whole`: see
    `cardan.physics.strength.torsional_strength.smallest_joint_size`.
    """
    sizes = [r.part for r in rows if isinstance(r.part, JointSize)]
    try:
        return smallest_joint_size(
            (s for s in sizes if rated_torque_from_catalogue(s)), asked.joint_demand
        ).name
    except DesignError:
        return ""

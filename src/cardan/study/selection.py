"""Which parts of a catalogue carry a torque: what each uses of its ratings, what fits first."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import inf

import numpy as np

from cardan.base.errors import DesignError
from cardan.base.units import Metre, NewtonMetre, Radian, RadianPerSecond
from cardan.files.shelf import Row
from cardan.model.parts import JointSize, Tube
from cardan.shaft.life import life_rating
from cardan.shaft.strength import (
    JointDemand,
    size_utilisations,
    smallest_size,
    tube_utilisation,
)  # fmt: skip
from cardan.shaft.whirl import critical_speed

WHIRL = 0.75
"""Share of the critical speed that counts as used up. Source: SAE AE-7, p. 267, second hand."""


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What a part is looked for: a torque with its shocks, and what else somebody says.

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
    def whole(self) -> bool:
        """Whether a joint's life can be asked."""
        return None not in (self.speed, self.angle, self.life)

    @property
    def of_joint(self) -> JointDemand:
        """It, as one point of a duty cycle."""
        return JointDemand(
            peak_torque=self.torque,
            torque=np.array([self.torque]),
            speed=np.array([self.speed or 0.0]),
            angle=np.array([self.angle or 0.0]),
            shares=np.array([1.0]),
            life=self.life or 0.0,
            prime_mover_factor=self.prime_mover_factor,
        )


@dataclass(frozen=True, kw_only=True)
class Fit:
    """A row, what is used of each of its part's ratings, and what nobody publishes of it.

    `size` is what rows are sorted by: a joint's peak torque, a tube's mass a metre.
    """

    row: Row
    used: dict[str, float]
    unknown: tuple[str, ...]
    size: float

    @property
    def most(self) -> float:
        """The largest share in use; infinite where a rating that is asked for is not known."""
        return inf if self.unknown else max(self.used.values())

    @property
    def fits(self) -> bool:
        """Whether it does."""
        return self.most <= 1


def fits(rows: Iterable[Row], asked: Asked) -> tuple[Fit, ...]:
    """Return rows of joints or tubes: what fits, the smallest first; then the nearest to it."""
    found = [_joint(r, asked) if isinstance(r.part, JointSize) else _tube(r, asked) for r in rows]
    return tuple(sorted(found, key=lambda f: (not f.fits, f.size if f.fits else f.most)))


def _joint(row: Row, asked: Asked) -> Fit:
    size: JointSize = row.part
    used = size_utilisations(size, asked.of_joint)
    kept = {"joint_torque_utilisation"}
    kept |= {"joint_speed"} if asked.speed is not None else set()
    kept |= {"joint_angle"} if asked.angle is not None else set()
    kept |= {"n_beta"} if asked.speed is not None and asked.angle is not None else set()
    kept |= {"joint_life"} if asked.whole else set()
    needed = {"joint_torque_utilisation", "joint_life"} & kept
    return Fit(
        row=row,
        used={k: v for k, v in used.items() if k in kept},
        unknown=tuple(sorted(needed - used.keys())),
        size=size.peak_torque or inf,
    )


def _tube(row: Row, asked: Asked) -> Fit:
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
        whirls = critical_speed(
            asked.length, outer=tube.outer, inner=tube.inner,
            youngs_modulus=tube.material.youngs_modulus, density=tube.material.density,
        )  # fmt: skip
        used["critical_speed_ratio"] = float(asked.speed / whirls / WHIRL)
    unknown = () if "tube_shear_utilisation" in used else ("tube_shear_utilisation",)
    return Fit(row=row, used=used, unknown=unknown, size=tube.mass_per_length)


def smallest(rows: Iterable[Row], asked: Asked) -> str:
    """Return the name of the joint of the least life rating that does; empty if none does.

    What is asked for must be `whole`: see `cardan.shaft.strength.smallest_size`.
    """
    sizes = [r.part for r in rows if isinstance(r.part, JointSize)]
    try:
        return smallest_size((s for s in sizes if life_rating(s)), asked.of_joint).name
    except DesignError:
        return ""

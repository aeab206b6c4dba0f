"""Duty cycles by name: how vehicles of a kind spend their life, from data files."""

from functools import cache
from pathlib import Path
from typing import Annotated

from cardan.base.source import Source
from cardan.border.document import parse, text_of
from cardan.border.measure import Percent
from cardan.border.table import (
    PROSE,
    Choice,
    Here,
    Number,
    Reading,
    Table,
    Text,
    key,
)  # fmt: skip
from cardan.model.application import CyclePoint, DutyCycle

_SHARE = Number("percent", least=0, most=1)


class CyclePointTable(Table):
    """A share of the life."""

    share: Percent = key("of the time; all shares make 100")
    torque: Annotated[float, _SHARE] = key("of the line's largest torque")
    speed: Annotated[float, _SHARE] = key("of its top speed")

    def build(self) -> CyclePoint:
        """Return the share."""
        return CyclePoint(share=self.share, torque_share=self.torque, speed_share=self.speed)


class CycleTable(Table):
    """A duty cycle."""

    cycle: str = key("its name")
    says: Annotated[str, Text(PROSE)] = key("what such a vehicle does")
    source: Annotated[str, Text(PROSE)] = key("who says so")
    points: tuple[Annotated[CyclePoint, CyclePointTable], ...] = key("how its life is spent")

    def build(self) -> DutyCycle:
        """Return the cycle."""
        return DutyCycle(
            name=self.cycle, says=self.says, source=Source(self.source), points=self.points
        )


def names() -> tuple[str, ...]:
    """Return the names of the duty cycles that come with this package."""
    return tuple(sorted(p.stem for p in _FOLDER.glob("*.yaml")))


_FOLDER = Path(__file__).with_name("cycles")


@cache
def cycle(name: str) -> DutyCycle:
    """Return a duty cycle that comes with this package."""
    path = _FOLDER / f"{name}.yaml"
    root, problems = parse(text_of(path), path.name)
    return CycleTable.read(Here(root, "", Reading(problems=problems)))


class CycleName(Choice):
    """A duty cycle that comes with this package."""

    def __init__(self) -> None:
        super().__init__(*names())
        self.one = f"the name of a duty cycle ({', '.join(names())})"
        self.many = "names of duty cycles"

    def read(self, here: Here) -> DutyCycle:
        """Return the cycle."""
        return cycle(super().read(here))

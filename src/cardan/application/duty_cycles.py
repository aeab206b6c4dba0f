"""Duty cycles by name: how vehicles of a kind spend their life, from data files."""

from functools import cache
from pathlib import Path
from typing import Annotated

from cardan.core.provenance import Source
from cardan.model.application import DutyCycle, DutyPointInSharesOfMaximum
from cardan.schema.field_types import MAX_PROSE_CHARACTERS, EnumField, NumberField, TextField
from cardan.schema.fields import Percent
from cardan.schema.node_reader import NodeReader, TableReadContext
from cardan.schema.tables import Table, table_key_field
from cardan.schema.yaml_tree import parse_yaml, read_text

_SHARE = NumberField("percent", least=0, most=1)


class RelativeDutyPointTable(Table):
    """A share of the life."""

    share: Percent = table_key_field("of the time; all shares make 100")
    torque: Annotated[float, _SHARE] = table_key_field("of the line's largest torque")
    speed: Annotated[float, _SHARE] = table_key_field("of its top speed")

    def build(self) -> DutyPointInSharesOfMaximum:
        """Return the share."""
        return DutyPointInSharesOfMaximum(
            share=self.share, torque_share=self.torque, speed_share=self.speed
        )


class DutyCycleTable(Table):
    """A duty cycle."""

    cycle: str = table_key_field("its name")
    says: Annotated[str, TextField(MAX_PROSE_CHARACTERS)] = table_key_field(
        "what such a vehicle does"
    )
    source: Annotated[str, TextField(MAX_PROSE_CHARACTERS)] = table_key_field("who says so")
    points: tuple[Annotated[DutyPointInSharesOfMaximum, RelativeDutyPointTable], ...] = (
        table_key_field("how its life is spent")
    )

    def build(self) -> DutyCycle:
        """Return the cycle."""
        return DutyCycle(
            name=self.cycle, description=self.says, source=Source(self.source), points=self.points
        )


def duty_cycle_names() -> tuple[str, ...]:
    """Return the names of the duty cycles that come with this package."""
    return tuple(sorted(p.stem for p in _FOLDER.glob("*.yaml")))


_FOLDER = Path(__file__).with_name("cycles")


@cache
def load_duty_cycle(name: str) -> DutyCycle:
    """Return a duty cycle that comes with this package."""
    path = _FOLDER / f"{name}.yaml"
    root, problems = parse_yaml(read_text(path), path.name)
    return DutyCycleTable.read(NodeReader(root, "", TableReadContext(problems=problems)))


class DutyCycleNameField(EnumField):
    """A duty cycle that comes with this package."""

    def __init__(self) -> None:
        super().__init__(*duty_cycle_names())
        self.singular = f"the name of a duty cycle ({', '.join(duty_cycle_names())})"
        self.plural = "names of duty cycles"

    def read(self, here: NodeReader) -> DutyCycle:
        """Return the cycle."""
        return load_duty_cycle(super().read(here))

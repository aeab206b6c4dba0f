"""Typed names: what a number is of, and where it applies. Words are made where text is.

What a user calls a thing (an obstacle, a gauge, a state) is kept apart from what it is, so
no name can be taken for another kind of thing.
"""

from typing import Literal, TypeAlias

from cardan.core.lazy_dataclass import dataclass

PartKind: TypeAlias = Literal[
    "line", "joint", "shaft", "centre bearing", "bearing", "clearance", "mode", "zone",
    "hot spot", "gauge", "engine", "flywheel", "clutch", "clutch disc", "gearbox",
    "gearbox input", "pinion", "axle housing", "half shafts", "wheels", "tyres", "wind-up",
    "vehicle", "member", "front axle", "driven rear axle", "rear axle", "auxiliary axle",
    "sheet", "cut edge", "weld toe", "bolt border", "bolts",
]  # fmt: skip

EvaluationConditionKind: TypeAlias = Literal[
    "state", "gear", "speed", "case", "duty", "recording", "launch",
]  # fmt: skip


@dataclass(frozen=True, slots=True)
class Part:
    """A part of a line, of its vibration or of a bracket.

    `number` counts from 1, or is a catalogue's letter (bearing A). `other` is what stands
    next to it: the obstacle that a shaft must clear, the order that meets a mode, the second
    mode of a zone, the user's name of a gauge.
    """

    kind: PartKind
    number: int | str = 0
    other: int | str = ""

    def __str__(self) -> str:
        """Return the part as the JSON contract writes it, in English."""
        match self.kind:
            case "line":
                return "line"
            case "clearance":
                return f"shaft {self.number} to {self.other}"
            case "mode":
                return f"mode {self.number}, order {self.other}"
            case "zone" if self.number == self.other:
                return f"zone of mode {self.number}"
            case "zone":
                return f"zone of modes {self.number} + {self.other}"
            case "gauge":
                return str(self.other)
            case kind if not self.number:
                return kind
            case _:
                return f"{self.kind} {self.number}"


WHOLE_LINE = Part("line")
"""A line as a whole."""


@dataclass(frozen=True, slots=True)
class OperatingPoint:
    """An operating point of a line: torque and speed that it has together, SI.

    `direction` is `drive`, `coast`, `reverse` or `brake`; `gear` is "" where none gives the torque.
    `is_spline_stuck` is whether friction holds its spline there.
    """

    gear: str
    direction: str
    speed: float
    torque: float
    is_spline_stuck: bool = False


@dataclass(frozen=True, slots=True)
class OrderCrossing:
    """A mode of a line on its centre bearings that an order of its turning meets.

    `shape` is bounce, lateral, pitch, yaw, axial, bending, bracket or flange, `frequency` in rad/s.
    """

    shape: str
    frequency: float
    order: int


@dataclass(frozen=True, slots=True)
class EvaluationCondition:
    """Where a number applies: a state, a range of speed, a load case, a recording.

    `what` says which part of the loads of a state a load case takes: static, order 2; of a
    launch, whose name is its gear, how long its ramp is in s.
    """

    kind: EvaluationConditionKind
    name: str
    what: str = ""

    def __str__(self) -> str:
        """Return the occasion as the JSON contract writes it, in English."""
        if self.kind == "launch":
            return f"launch in gear {self.name}, {self.what} s"
        ahead = {"gear": "gear ", "duty": "duty cycle, "}.get(self.kind, "")
        return f"{ahead}{self.name}{': ' if self.what else ''}{self.what}"

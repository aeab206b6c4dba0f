"""The rows of catalogues that an application stands on, with how each was read."""

from collections.abc import Iterator
from typing import Literal, TypeAlias

from cardan.base.frozen import dataclass
from cardan.base.source import ASSUMED, Source
from cardan.model.application import Application
from cardan.model.parts import Line, Tube

Kind: TypeAlias = Literal["joint", "tube", "material"]


@dataclass(frozen=True, kw_only=True)
class Datum:
    """A row of a catalogue, and which joints or shafts of a line are of it."""

    line: str
    kind: Kind
    name: str
    parts: tuple[int, ...]
    source: Source
    note: str = ""


def data_of(application: Application) -> Iterator[Datum]:
    """Yield the rows that the lines of an application stand on, each once a line."""
    for installed in application.lines:
        line = installed.line
        found: dict[tuple[Kind, str, Source, str], list[int]] = {}
        for kind, name, source, note, part in _rows(line):
            if name and source != ASSUMED:
                found.setdefault((kind, name, source, note), []).append(part)
        for (kind, name, source, note), parts in found.items():
            yield Datum(
                line=line.name,
                kind=kind,
                name=name,
                parts=tuple(dict.fromkeys(parts)),
                source=source,
                note=note,
            )


def _rows(line: Line) -> Iterator[tuple[Kind, str, Source, str, int]]:
    """Yield name, source and note of what a line is made of, part by part."""
    for k, size in enumerate(line.joints, 1):
        if size is not None:
            yield "joint", size.name, size.source, size.note, k
    tubes = [(k, s.tube) for k, s in enumerate(line.shafts, 1) if s.tube is not None]
    for k, tube in tubes:
        yield "tube", tube.name, tube.source, "", k
    for k, tube in tubes:
        if isinstance(tube, Tube):
            yield "material", tube.material.name, tube.material.source, "", k
        else:
            for ply in tube.plies:
                yield "material", ply.name, ply.source, "", k

"""The rows of catalogues that an application stands on, with how each was read."""

from collections.abc import Collection, Iterator
from typing import Literal, TypeAlias

from cardan.approval.study import BRACKET_STUDY_NAME
from cardan.core.labels import PartKind
from cardan.core.lazy_dataclass import dataclass
from cardan.core.provenance import SOURCE_ASSUMED, Source
from cardan.model.application import Application
from cardan.model.parts import Line, Tube

PartKindWithProvenance: TypeAlias = Literal[
    "joint", "tube", "material", "bracket material", "fatigue detail"
]


@dataclass(frozen=True, kw_only=True)
class CatalogueDatum:
    """A row of a catalogue, and which joints or shafts of a line are of it.

    Of a bracket's material and fatigue details, `part_numbers` is its centre bearing's.
    """

    line: str
    kind: PartKindWithProvenance
    name: str
    part_numbers: tuple[int, ...]
    source: Source
    note: str = ""

    @property
    def part_kind(self) -> PartKind:
        """What its part numbers count: joints, shafts or centre bearings."""
        if self.kind in ("bracket material", "fatigue detail"):
            return "centre bearing"
        return "joint" if self.kind == "joint" else "shaft"


def catalogue_data_of(
    application: Application, studies: Collection[str] = ()
) -> Iterator[CatalogueDatum]:
    """Yield the rows that the lines of an application stand on, each once a line.

    Those of its bracket come last, if `studies`, those that the verdict is of, include it.
    """
    yield from _data_of_lines(application)
    if BRACKET_STUDY_NAME in studies:
        yield from _data_of_bracket(application)


def _data_of_lines(application: Application) -> Iterator[CatalogueDatum]:
    for installed in application.lines:
        line = installed.line
        found: dict[tuple[PartKindWithProvenance, str, Source, str], list[int]] = {}
        for kind, name, source, note, part in _rows(line):
            if name and source != SOURCE_ASSUMED:
                found.setdefault((kind, name, source, note), []).append(part)
        for (kind, name, source, note), parts in found.items():
            yield CatalogueDatum(
                line=line.name,
                kind=kind,
                name=name,
                part_numbers=tuple(dict.fromkeys(parts)),
                source=source,
                note=note,
            )


def _data_of_bracket(application: Application) -> Iterator[CatalogueDatum]:
    of = application.bracket
    if of is None:
        return
    found: dict[tuple[PartKindWithProvenance, str, Source], None] = {
        ("bracket material", of.material.name, of.material.source): None
    }
    for curve in of.details.values():
        found["fatigue detail", curve.name, curve.source] = None
    for kind, name, source in found:
        if name and source != SOURCE_ASSUMED:
            yield CatalogueDatum(
                line=of.line, kind=kind, name=name, part_numbers=(of.bearing,), source=source
            )


def _rows(line: Line) -> Iterator[tuple[PartKindWithProvenance, str, Source, str, int]]:
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

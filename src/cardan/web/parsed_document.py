"""A text that was read once, and numbers as they are sent."""

import os
from collections import OrderedDict
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from cardan.application import overrides, reader
from cardan.application.layout_writer import FileChanges
from cardan.application.yaml_edit import YamlEditor, format_as_yaml_value
from cardan.approval.approval import Approval
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.arrays import FloatArray
from cardan.core.errors import CardanError
from cardan.core.verdict import Check
from cardan.model.application import Application
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references
from cardan.render.check_texts import limit_text
from cardan.render.i18n import Translator
from cardan.render.phrases import check_location, citation
from cardan.schema.node_reader import ReferencedFile
from cardan.topics.design.suspension_travel import TravelRange, travel_range
from cardan.topics.recording import campaign_schema as campaign
from cardan.topics.recording.campaign_schema import CampaignSpec

if TYPE_CHECKING:
    from cardan.topics.torsion.vibration_result import VibrationResult

Json: TypeAlias = dict[str, Any]
PartialResultCallback: TypeAlias = Callable[[Json], None]
"""Receives what is known so far of a result that takes long."""

MAX_CACHED_DOCUMENTS = 6
"""Documents that are not read again when they are needed again."""


@dataclass(frozen=True, eq=False)
class ParsedDocument:
    """A text, read once."""

    text: str
    name: str
    folder: Path | None
    original: "ParsedDocument | None" = None
    """What it was before a hand took hold of it."""
    changed_numbers: Mapping[str, float] = field(default_factory=dict[str, float])
    """What the hand put in place of that one's."""
    referenced_files: list[ReferencedFile] = field(default_factory=list[ReferencedFile])
    """The files that it names, as they were when it was read."""

    @cached_property
    def manuscript(self) -> YamlEditor:
        """The text as it can be written in."""
        return YamlEditor(self.text, self.name)

    @cached_property
    def application(self) -> Application:
        """What it says; implausible values are not looked for during a drag."""
        if self.original:
            return overrides.change(self.original.application, self.changed_numbers, warn=False)
        self.referenced_files.clear()  # what could not be read is read again
        return reader.loads(
            self.text, name=self.name, folder=self.folder, beside=self.referenced_files
        )

    @cached_property
    def recording_campaign(self) -> CampaignSpec | None:
        """What it says as a campaign of recordings; None where it is an application."""
        if campaign.campaign_title(self.manuscript) is None:
            return None
        self.referenced_files.clear()
        return campaign.read_campaign_text(
            self.text, name=self.name, folder=self.folder, beside=self.referenced_files
        )

    @cached_property
    def stability(self) -> "VibrationResult":
        """How its vehicle vibrates: a matter of seconds."""
        from cardan.topics.torsion.study import analyse_vibration

        return analyse_vibration(self.application)

    @cached_property
    def responses(self) -> tuple[LineResponse, ...]:
        """What its lines do in their states."""
        app = self.application
        return tuple(
            compute_line_response(app, line_state_demand(resolve_line_references(app, i)))
            for i in app.lines
        )

    @cached_property
    def travel_ranges(self) -> tuple[TravelRange, ...]:
        """How far the axle of each line goes."""
        return tuple(travel_range(r) for r in self.responses)

    def referenced_paths(self, at: str) -> list[Path]:
        """Return the file that is named at an address, and those that that one names."""
        with suppress(CardanError):  # what cannot be read names what was found until then
            assert self.recording_campaign or self.application
        name = self.manuscript.scalar_text(at)
        own = [b.path for b in self.referenced_files if b.name == name and b.is_named_at(at)]
        return own[:1] + [
            b.path for b in self.referenced_files if own and b.name is None and b.address == at
        ]

    def with_edits(self, edits: FileChanges, *, held: bool = False) -> "ParsedDocument":
        """Return it with edits made; a dragged handle is given by numbers, and not read again."""
        text = self.manuscript.with_changes(edits)
        written = self.application.written if held else None
        if written and all(at in written.numbers for at in edits):
            numbers = {at: float(format_as_yaml_value(to, "")) for at, to in edits.items()}
            return ParsedDocument(
                text, self.name, self.folder, original=self, changed_numbers=numbers
            )
        return parse_document(text, self.name, self.folder)


_DOCUMENT_CACHE: OrderedDict[tuple[str, str, Path | None], ParsedDocument] = OrderedDict()


def parse_document(text: str, name: str, folder: Path | None) -> ParsedDocument:
    """Return a document, the same one if it was used a moment ago.

    It is another once a file that it names is another.
    """
    key = text, name, folder
    found = _DOCUMENT_CACHE.pop(key, None)
    if found is None or not all(b.is_unchanged for b in found.referenced_files):
        found = ParsedDocument(*key)
    _DOCUMENT_CACHE[key] = found
    while len(_DOCUMENT_CACHE) > MAX_CACHED_DOCUMENTS:
        _DOCUMENT_CACHE.popitem(last=False)
    return found


# --------------------------------------------------------------------------- numbers


def with_relative_file_names(said: str, folder: Path | None) -> str:
    """Return a text in which files of the folder go by their names in it."""
    return said.replace(f"{folder}{os.sep}", "") if folder else said


def round_decimals(value: float, digits: int = 3) -> float | None:
    """Return a number with some decimals; None where there is none."""
    return round(float(value), digits) + 0.0 if isfinite(value) else None


def round_significant(value: float) -> float | None:
    """Return a number with nine figures; None where there is none.

    The page shows four: rounded twice, one in some hundred would be another than a report's.
    """
    return float(f"{value:.9g}") if isfinite(value) else None


def round_significant_list(values: FloatArray) -> Any:
    """Return numbers as lists, with nine figures, as `g`; None where there is none."""
    some = np.where(np.isfinite(values) & (values != 0), values, 1.0)
    places = 8 - np.floor(np.log10(np.abs(some)))
    up, down = (np.power(10.0, np.maximum(p, 0.0)) for p in (places, -places))
    return _list_with_none(np.rint(values * up / down) / up * down)


def round_decimals_list(values: FloatArray, digits: int) -> Any:
    """Return numbers as lists, with some decimals."""
    return _list_with_none(np.round(np.asarray(values, dtype=float), digits))


def _list_with_none(values: Any) -> Any:
    """Return numbers as lists; None where there is none."""
    values = values + 0.0
    if (known := np.isfinite(values)).all():
        return values.tolist()
    told = values.astype(object)
    told[~known] = None
    return told.tolist()


# --------------------------------------------------------------------------- checks


def check_to_json(c: Check, found: Approval, say: Translator) -> Json:
    """Return one check by itself."""
    q = QUANTITIES[c.quantity]
    return {
        "quantity": c.quantity,
        "line": c.line,
        "name": say.name(c.quantity),
        "where": check_location(c, say, several=len(found.line_responses) > 1),
        "value": round_significant(c.value / q.si_factor),
        "bound": round_significant(c.bound / q.si_factor),
        "limit": limit_text(c, say),
        "sense": "band" if c.limit.band else c.limit.sense,
        "unit": q.unit_symbol,
        "margin": round_significant(c.margin),
        "grade": c.grade,
        "source": citation(c.limit.source, say),
    }

"""A text that was read once, and numbers as they are told."""

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

from cardan import files
from cardan.base.arrays import FloatArray
from cardan.base.errors import CardanError
from cardan.base.verdict import Check
from cardan.border.table import Beside
from cardan.demand.states import demand, resolve
from cardan.files import campaign
from cardan.files.campaign import Campaigned
from cardan.files.manuscript import Manuscript, token
from cardan.files.placing import Changes
from cardan.model.application import Application
from cardan.quantity.quantities import QUANTITIES
from cardan.quantity.response import Response, respond
from cardan.report.language import Language
from cardan.report.wording import cited, place
from cardan.study.approval import Approval
from cardan.study.ride import Reach, reach

if TYPE_CHECKING:
    from cardan.study.stability import Stability

Json: TypeAlias = dict[str, Any]
Tell: TypeAlias = Callable[[Json], None]
"""Told what is known so far of an answer that takes long."""

KEPT = 6
"""Documents that are not read again when they are asked about again."""


@dataclass(frozen=True, eq=False)
class Document:
    """A text, read once."""

    text: str
    name: str
    folder: Path | None
    was: "Document | None" = None
    """What it was before a hand took hold of it."""
    numbers: Mapping[str, float] = field(default_factory=dict[str, float])
    """What the hand put in place of that one's."""
    beside: list[Beside] = field(default_factory=list[Beside])
    """The files that it names, as they were when it was read."""

    @cached_property
    def manuscript(self) -> Manuscript:
        """The text as it can be written in."""
        return Manuscript(self.text, self.name)

    @cached_property
    def application(self) -> Application:
        """What it says; nobody asks what looks wrong while a hand holds it."""
        if self.was:
            return files.change(self.was.application, self.numbers, warn=False)
        self.beside.clear()  # what could not be read is read again
        return files.loads(self.text, name=self.name, folder=self.folder, beside=self.beside)

    @cached_property
    def recordings(self) -> Campaigned | None:
        """What it says as a campaign of recordings; None where it is an application."""
        if campaign.title(self.manuscript) is None:
            return None
        self.beside.clear()
        return campaign.loads(self.text, name=self.name, folder=self.folder, beside=self.beside)

    @cached_property
    def stability(self) -> "Stability":
        """How its vehicle vibrates: a matter of seconds."""
        from cardan.study.stability import stability

        return stability(self.application)

    @cached_property
    def responses(self) -> tuple[Response, ...]:
        """What its lines do in their states."""
        app = self.application
        return tuple(respond(app, demand(resolve(app, i))) for i in app.lines)

    @cached_property
    def reaches(self) -> tuple[Reach, ...]:
        """How far the axle of each line goes."""
        return tuple(reach(r) for r in self.responses)

    def named(self, at: str) -> list[Path]:
        """Return the file that is named at an address, and those that that one names."""
        with suppress(CardanError):  # what cannot be read names what was found until then
            assert self.recordings or self.application
        name = self.manuscript.written(at)
        own = [b.path for b in self.beside if b.name == name and b.stands(at)]
        return own[:1] + [b.path for b in self.beside if own and b.name is None and b.at == at]

    def edited(self, edits: Changes, *, held: bool = False) -> "Document":
        """Return it with edits made; what a hand holds is told by numbers, and not read again."""
        text = self.manuscript.with_(edits)
        written = self.application.written if held else None
        if written and all(at in written.numbers for at in edits):
            numbers = {at: float(token(to, "")) for at, to in edits.items()}
            return Document(text, self.name, self.folder, was=self, numbers=numbers)
        return document(text, self.name, self.folder)


_READ: OrderedDict[tuple[str, str, Path | None], Document] = OrderedDict()


def document(text: str, name: str, folder: Path | None) -> Document:
    """Return a document, the same one where it was asked about a moment ago.

    It is another once a file that it names is another.
    """
    key = text, name, folder
    found = _READ.pop(key, None)
    if found is None or not all(b.same for b in found.beside):
        found = Document(*key)
    _READ[key] = found
    while len(_READ) > KEPT:
        _READ.popitem(last=False)
    return found


# --------------------------------------------------------------------------- numbers


def here(said: str, folder: Path | None) -> str:
    """Return a text in which files of the folder go by their names in it."""
    return said.replace(f"{folder}{os.sep}", "") if folder else said


def f(value: float, digits: int = 3) -> float | None:
    """Return a number with some decimals; None where there is none."""
    return round(float(value), digits) + 0.0 if isfinite(value) else None


def g(value: float) -> float | None:
    """Return a number with nine figures; None where there is none.

    The page shows four: rounded twice, one in some hundred would be another than a report's.
    """
    return float(f"{value:.9g}") if isfinite(value) else None


def gs(values: FloatArray) -> Any:
    """Return numbers as lists, with nine figures, as `g`; None where there is none."""
    some = np.where(np.isfinite(values) & (values != 0), values, 1.0)
    places = 8 - np.floor(np.log10(np.abs(some)))
    up, down = (np.power(10.0, np.maximum(p, 0.0)) for p in (places, -places))
    return _told(np.rint(values * up / down) / up * down)


def fs(values: FloatArray, digits: int) -> Any:
    """Return numbers as lists, with some decimals."""
    return _told(np.round(np.asarray(values, dtype=float), digits))


def _told(values: Any) -> Any:
    """Return numbers as lists; None where there is none."""
    values = values + 0.0
    if (known := np.isfinite(values)).all():
        return values.tolist()
    told = values.astype(object)
    told[~known] = None
    return told.tolist()


# --------------------------------------------------------------------------- checks


def other(c: Check, found: Approval, say: Language) -> Json:
    """Return one check by itself."""
    q = QUANTITIES[c.quantity]
    return {
        "quantity": c.quantity,
        "line": c.line,
        "name": say.name(c.quantity),
        "where": place(c, say, several=len(found.responses) > 1),
        "value": g(c.value / q.factor),
        "bound": g(c.bound / q.factor),
        "sense": "band" if c.limit.band else c.limit.sense,
        "unit": q.unit_name,
        "margin": g(c.margin),
        "grade": c.grade,
        "source": cited(c.limit.source, say),
    }

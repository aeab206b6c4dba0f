"""A text that was read once, and numbers as they are told."""

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from cardan import files
from cardan.base.arrays import FloatArray
from cardan.base.verdict import Check
from cardan.demand.states import demand, resolve
from cardan.files.manuscript import Manuscript
from cardan.model.application import Application
from cardan.quantity.quantities import QUANTITIES
from cardan.quantity.response import Response, respond
from cardan.report.language import Language
from cardan.report.wording import cited, place
from cardan.study.approval import Approval

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
    hasty: bool = False
    """Whether a hand waits for it: then nobody asks what looks wrong."""

    @cached_property
    def manuscript(self) -> Manuscript:
        """The text as it can be written in."""
        return Manuscript(self.text, self.name)

    @cached_property
    def application(self) -> Application:
        """What it says."""
        return files.loads(self.text, name=self.name, folder=self.folder, warn=not self.hasty)

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


_READ: OrderedDict[tuple[str, str, Path | None, bool], Document] = OrderedDict()


def document(text: str, name: str, folder: Path | None, *, hasty: bool = False) -> Document:
    """Return a document, the same one where it was asked about a moment ago."""
    key = text, name, folder, hasty
    found = _READ.pop(key, None) or Document(*key)
    _READ[key] = found
    while len(_READ) > KEPT:
        _READ.popitem(last=False)
    return found


# --------------------------------------------------------------------------- numbers


def f(value: float, digits: int = 3) -> float | None:
    """Return a number with some decimals; None where there is none."""
    return round(float(value), digits) + 0.0 if isfinite(value) else None


def g(value: float) -> float | None:
    """Return a number with six figures; None where there is none."""
    return float(f"{value:.6g}") if isfinite(value) else None


def fs(values: FloatArray, digits: int) -> Any:
    """Return numbers as lists, with some decimals."""
    rounded = np.round(np.asarray(values, dtype=float), digits) + 0.0
    if np.isfinite(rounded).all():
        return rounded.tolist()
    told = rounded.astype(object)
    told[~np.isfinite(rounded)] = None
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

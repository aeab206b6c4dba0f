"""Numbers of an application by their address, the key that its errors print.

`driveline.shafts[2].tube.wall_mm` is the wall of the second shaft's tube, in the unit that the
key ends in; items count from 1. A part named in a catalogue has its numbers beneath its
name, as if its row stood in the file.
"""

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

import numpy as np

from cardan.application.reader import read_source_text
from cardan.core.arrays import ArrayLike
from cardan.core.errors import DesignError
from cardan.model.adjustments import permitted_adjustments_by_name
from cardan.model.application import Application, ApplicationSourceText
from cardan.model.variants import without_addresses_of_study_section


def addresses(application: Application) -> dict[str, ArrayLike]:
    """Return every number of the design by its address, in its key's unit.

    What was changed to variants is an array of them, (V,). Limits, ranges of `adjust` and
    the bracket are no part of the design.

    Raises
    ------
    DesignError
        If the application was not read from a file.
    """
    numbers = _written(application).numbers.items()
    return {
        at: number[:, 0] if isinstance(number, np.ndarray) else number for at, number in numbers
    }


def change(
    application: Application, changes: Mapping[str, ArrayLike], *, warn: bool = True
) -> Application:
    """Return the application with other numbers in place of its file's.

    Parameters
    ----------
    application
        As it was read, or changed before.
    changes : number or (V,)
        By address, in the unit of its key. Arrays are variants: all must be as long, and
        what follows from them is (V, ...).
    warn
        Whether to look for implausible values too.

    Raises
    ------
    InvalidFileError
        If there is no number at an address, or it cannot be what it is to become; the
        problems are those of a file that says so.
    DesignError
        If the application was not read from a file, or has had parts replaced since.
    """
    written = _written(application)
    columns = {at: np.asarray(to, dtype=float) for at, to in changes.items()}
    lengths = {c.shape for c in columns.values() if c.ndim}
    if len(lengths) > 1 or any(len(shape) > 1 for shape in lengths):
        msg = f"variants of several numbers must be arrays of one length, got {sorted(lengths)}"
        raise ValueError(msg)
    made = {at: c[:, None] if c.ndim else float(c) for at, c in columns.items()}
    return read_source_text(replace(written, changes=dict(written.changes) | made), warn=warn)


def application_with_input_values(
    application: Application, numbers: Mapping[str, Any]
) -> Application:
    """Return an application with other numbers, held against the limits that it has now."""
    was = application.written.application if application.written else None
    if not numbers:
        return application
    if was is None or application.limits is was.limits:
        return change(application, numbers)
    found = change(replace(application, limits=was.limits, profile=was.profile), numbers)
    return replace(found, limits=application.limits, profile=application.profile)


def nominal_variable_values(application: Application) -> dict[str, float]:
    """Return every number that may vary, as it is, by name.

    Raises
    ------
    ValueError
        If one has variants already.
    """
    written = application.written
    base = written.application if written else None
    numbers: dict[str, Any] = dict(
        addresses(replace(base, written=written) if base and written else application)
    )
    if written is not None:
        numbers |= written.fixed_numbers
    found: dict[str, float] = {}
    for at in without_addresses_of_study_section(numbers):
        if np.ndim(numbers[at]):
            msg = f"{at} has variants already: vary the application as it was read"
            raise ValueError(msg)
        found[at] = float(numbers[at])
    return found | dict.fromkeys(
        permitted_adjustments_by_name(i.line for i in application.lines), 0.0
    )


def _written(application: Application) -> ApplicationSourceText:
    """Return the text of an application that says all there is to say of it."""
    written = application.written
    if written is None or written.application is None:
        msg = f"application {application.title} was not read from a file: it has no addresses"
        raise DesignError(msg)
    # What was warned of follows from the text, and is found again with it.
    names = (f.name for f in fields(application) if f.name not in ("written", "warnings"))
    was = written.application
    if other := [n for n in names if not _same(getattr(application, n), getattr(was, n))]:
        msg = (
            f"application {application.title} has had its {', '.join(other)} replaced since it "
            "was read: change the numbers first"
        )
        raise DesignError(msg)
    return written


def _same(one: object, other: object) -> bool:
    """Return whether two parts are one; numbers and texts that came from another process equal."""
    return one is other or (isinstance(one, int | float | str) and one == other)

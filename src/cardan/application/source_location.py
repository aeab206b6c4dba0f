"""Where in its file something of an application stands, and errors that say so."""

from pathlib import Path

from cardan.core.errors import CardanError, DesignError, FileIssue, InvalidFileError, SourceLocation
from cardan.core.units import UNITS
from cardan.model.application import Application

_ENDS = {*UNITS, "rad_m", "m_s2", "g"}
"""What a key may end in."""


def locate_yaml_address(application: Application, *addresses: str) -> SourceLocation | None:
    """Return where the first of some addresses that the file gives stands.

    Parameters
    ----------
    application
        As it was read; one that never stood in a file has no places.
    addresses
        Keys as errors print them, with or without the unit; `drivelines.main.shafts[2]` is
        found where the file has one `driveline`. Where the file gives none of them, the
        nearest table or list that the first would stand in.
    """
    known = [found for a in addresses if (found := _given(application, a))]
    if known:
        return known[0]
    address = addresses[0] if addresses else ""
    while address:
        if found := _given(application, address):
            return found
        cut = address.rfind("[") if address.endswith("]") else address.rfind(".")
        address = address[: max(cut, 0)]
    return None


def _given(application: Application, address: str) -> SourceLocation | None:
    """Return where an address stands, whatever unit its key ends in."""
    origins = application.source_locations
    for installed in application.lines:
        line = f"drivelines.{installed.line.name}"
        if "driveline" in origins and (address == line or address.startswith((f"{line}.",))):
            address = f"driveline{address.removeprefix(line)}"
    ends = (f"{address}_{unit}" for unit in _ENDS)
    return origins.get(address) or next((origins[e] for e in ends if e in origins), None)


def error_with_location(error: CardanError, application: Application, file: str | Path) -> str:
    """Return an error's message with file, line, column and key, as far as they are known.

    A design that turns out impossible (a joint locks, a link is too short) is reported like
    anything else that is wrong in a file: `truck.yaml:47:27: suspension.linkage: a link ...`.
    """
    if isinstance(error, InvalidFileError):
        return str(error)
    about = error.about if isinstance(error, DesignError) else ""
    found = locate_yaml_address(application, about) if about else None
    if found is None:
        return f"{file}: {error}"
    problem = FileIssue(message=str(error), key=found.key, line=found.line, column=found.column)
    return problem.format_with_location(str(file))

"""A limit of a profile changed for one application: the file's text, and who is responsible.

The profile stays what it is. The file takes over every limit of that quantity, one of them with
other bounds and a source that says from what it deviates, why, who is responsible and since when.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from cardan.application.layout_writer import FileChanges
from cardan.application.limit_profiles import DEFAULT_PROFILE_NAME
from cardan.application.yaml_edit import RawYaml, YamlEditor, format_as_yaml_value
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.errors import FileIssue, InvalidFileError
from cardan.core.provenance import Source
from cardan.core.units import UNITS
from cardan.core.verdict import Limit

DEVIATION_RECORD_NAME_IN_ERRORS = "deviation"

LIMIT_SOURCE_SIGNATORY_SEPARATOR = "; signed "
"""What a source says before the name of the person responsible."""


@dataclass(frozen=True, kw_only=True)
class LimitDeviationRecord:
    """Other bounds of a limit, in the unit its quantity is shown in, and the person responsible."""

    normal: float | None
    maximum: float | None
    reason: str
    by: str
    on: str
    """The day, as 2026-11-22."""

    def __post_init__(self) -> None:
        problems = [
            FileIssue(message=f"a deviation needs {what}", key=key)
            for key, what in (("reason", "a reason"), ("by", "who answers for it"))
            if not getattr(self, key).strip()
        ]
        if self.normal is None and self.maximum is None:
            problems.append(
                FileIssue(message="a deviation needs a normal or a maximum", key="normal")
            )
        if problems:
            raise InvalidFileError(DEVIATION_RECORD_NAME_IN_ERRORS, tuple(problems))


def limit_deviation_file_changes(
    text: YamlEditor, limits: Sequence[Limit], which: int, to: LimitDeviationRecord, *, profile: str
) -> FileChanges:
    """Return the changes of a text that make one of its limits another, by address.

    Parameters
    ----------
    text
        The application's.
    limits
        Those it is held against now, in their order.
    which
        The place of the limit among them.
    to
        What it is to be.
    profile
        What the limits are called now; the source names it.

    Raises
    ------
    InvalidFileError
        If the limits stand in a way that cannot be changed in place, or a deviation is no
        limit that can be.
    """
    was = limits[which]
    if all(b > 0 for b in (was.normal, was.maximum) if b is not None):
        problems = tuple(
            FileIssue(message="must be above 0, as what it deviates from", key=k, value=f"{b:g}")
            for k, b in (("normal", to.normal), ("maximum", to.maximum)) if b is not None and b <= 0
        )  # fmt: skip
        if problems:
            raise InvalidFileError(DEVIATION_RECORD_NAME_IN_ERRORS, problems)
    source = _source(was, to, profile)
    alike = [k for k, m in enumerate(limits) if m.quantity == was.quantity]
    place = alike.index(which)
    if "limits" not in text or text.scalar_text("limits") is not None:
        name = text.scalar_text("limits") or DEFAULT_PROFILE_NAME
        rows = [_row(m, to if k == which else None, source) for k, m in _of(limits, alike)]
        whole = f"{{profile: {format_as_yaml_value(name, '')}, overrides: [{', '.join(rows)}]}}"
        return {"limits": RawYaml(whole)}
    at = "limits" if "limits[1]" in text else "limits.overrides"
    own = [k for k in range(1, 501) if text.scalar_text(f"{at}[{k}].quantity") == was.quantity]
    if own:
        return _rewritten(text, f"{at}[{own[place]}]", was, to, source)
    rows = [_row(m, to if k == which else None, source) for k, m in _of(limits, alike)]
    return {f"{at}[+]": [RawYaml(row) for row in rows]}


def _of(limits: Sequence[Limit], alike: list[int]) -> list[tuple[int, Limit]]:
    return [(k, limits[k]) for k in alike]


def _source(was: Limit, to: LimitDeviationRecord, profile: str) -> str:
    factor = QUANTITIES[was.quantity].si_factor
    bounds = " | ".join(f"{b / factor:.6g}" for b in (was.normal, was.maximum) if b is not None)
    before = str(was.source).partition("; before: ")[2] or str(was.source)
    reason, by = to.reason.strip(), to.by.strip()
    return (
        f"deviation from {profile}, {was.sense} {bounds}: {reason}"
        f"{LIMIT_SOURCE_SIGNATORY_SEPARATOR}{by}, {to.on}; before: {before}"
    )


def _row(limit: Limit, to: LimitDeviationRecord | None, source: str) -> str:
    """Return a limit as a row of a file, in the unit its quantity is shown in."""
    q = QUANTITIES[limit.quantity]
    if to is not None:
        normal, maximum = (None if b is None else b * q.si_factor for b in (to.normal, to.maximum))
        limit = replace(limit, normal=normal, maximum=maximum, source=Source(source))
    cells: list[str] = [f"quantity: {limit.quantity}"]
    for key, bound in (("normal", limit.normal), ("maximum", limit.maximum)):
        if bound is not None:
            cells.append(f"{key}: {bound / q.si_factor:.10g}")
    if limit.sense != q.sense:
        cells.append(f'sense: "{limit.sense}"')
    if limit.band is not None:
        cells.append(f"band: [{', '.join(f'{b / q.si_factor:.10g}' for b in limit.band)}]")
    if limit.above_angle is not None:
        cells.append(f"above_angle: {limit.above_angle / UNITS['deg']:.10g}")
    if limit.states is not None:
        cells.append(
            f"states: [{', '.join(format_as_yaml_value(s, '') for s in sorted(limit.states))}]"
        )
    if limit.points != "all":
        cells.append(f"points: {limit.points}")
    if limit.required:
        cells.append("required: true")
    cells.append(f"source: {format_as_yaml_value(str(limit.source), '')}")
    return "{" + ", ".join(cells) + "}"


def _rewritten(
    text: YamlEditor, at: str, was: Limit, to: LimitDeviationRecord, source: str
) -> FileChanges:
    """Return the changes of a row that stands in the file."""
    factor = QUANTITIES[was.quantity].si_factor
    unit = text.scalar_text(f"{at}.unit")
    worth = UNITS.get(unit or "", factor) if unit else factor
    found: FileChanges = {f"{at}.source": source}
    for key, bound in (("normal", to.normal), ("maximum", to.maximum)):
        if bound is not None:
            found[f"{at}.{key}"] = float(f"{bound * factor / worth:.10g}")
        elif f"{at}.{key}" in text:
            problem = FileIssue(
                message="stands in the file: take it out by hand", key=f"{at}.{key}"
            )
            raise InvalidFileError(text.name, (problem,))
    return found

"""`cardan new` from files of other tools: a VECTO job, its results, a table of hardpoints."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cardan.cli.common import announce_application, echo, locale_translator, write_output
from cardan.cli.exit_codes import raise_command_error


@dataclass(frozen=True, kw_only=True)
class ImportedFiles:
    """Files that an application is made of; None where none is given."""

    job: Path | None
    vmod: Path | None
    hardpoints: Path | None

    @property
    def any_given(self) -> bool:
        """Whether there is one."""
        return any((self.job, self.vmod, self.hardpoints))


def write_imported(
    out: Path, imports: ImportedFiles, *, kind: str | None, own: Path | None, replace: bool
) -> None:
    """Write an application with what files of other tools say, and print what was read."""
    from cardan.application import reader
    from cardan.application.hardpoint_table import read_hardpoints, text_with_hardpoints
    from cardan.application.relation_context import RelationContext
    from cardan.application.simulated_duty import (
        duty_section,
        read_simulated_duty,
        text_with_duty,
    )
    from cardan.schema.atomic_write import check_output_paths

    if sum(one is not None for one in (imports.job, own, kind)) > 1:
        raise_command_error("--vecto, --of and --kind are three bases: give one of them")
    if imports.vmod is not None and imports.job is None and own is None:
        raise_command_error("--vmod is the duty of a vehicle: give it with --vecto or --of")
    given = [one for one in (imports.job, imports.vmod, imports.hardpoints) if one is not None]
    check_output_paths({"FILE": out}, inputs=given)
    text, said = _base(imports, kind, own)
    source: dict[str, Any] = {} if own is None else {"folder": own.parent}
    application = reader.loads(
        text, name=str(own) if own else f"application of {imports.job or kind}", **source
    )
    if imports.hardpoints is not None:
        points = read_hardpoints(imports.hardpoints)
        text = text_with_hardpoints(text, application, points, source=str(imports.hardpoints))
        said.append(f"{imports.hardpoints.name}: {len(points)} points.")
    if imports.vmod is not None:
        axle, tyre = application.lines[0].axle, application.tyre
        most = float(RelationContext(application=application).largest_torque)
        duty = read_simulated_duty(
            imports.vmod,
            axle_ratio=None if axle is None else float(axle.ratio),
            dynamic_radius=None
            if tyre is None
            else float(tyre.dynamic_radius or tyre.static_radius),
            largest_torque=most if most > 0 else float("inf"),
        )
        text = text_with_duty(text, duty_section(duty))
        said.append(
            f"{duty.file}: {len(duty.share)} classes of {duty.duration:.0f} s, "
            f"{100 * duty.driving_share:.0f} % of it in motion; simulated, not measured."
        )
    left = reader.loads(text, name=str(out), **source).placeholders  # what is written can be read
    write_output(out, text, replace=replace)
    for line in said:
        echo(line)
    if left:
        say = locale_translator()
        echo(say("{file} is written; enter the values of: {keys}.", file=out, keys=", ".join(left)))
    else:
        announce_application(out)


def _base(imports: ImportedFiles, kind: str | None, own: Path | None) -> tuple[str, list[str]]:
    """Return the text that the files change, and what a job says that is not carried over."""
    if imports.job is not None:
        from cardan.application.vecto_application import application_of_job
        from cardan.application.vecto_job import read_job

        job = read_job(imports.job)
        return application_of_job(job), [f"{job.path.name}: {one}." for one in job.remarks]
    if own is not None:
        from cardan.schema.yaml_tree import read_text

        return read_text(own), []
    from cardan.application.templates import template_text

    return template_text(kind or "truck"), []

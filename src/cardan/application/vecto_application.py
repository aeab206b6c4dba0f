"""An application to fill in, from a job of VECTO: its powertrain, and placeholders for the rest."""

from collections.abc import Iterator, Sequence

from cardan.application.duty_collective import DUTY_HINT
from cardan.application.typical_values import vehicle_class_of
from cardan.application.vecto_job import VectoJob
from cardan.core.units import kW, mm, rpm

_PROFILES = {"van": "van", "medium truck": "medium-truck", "heavy truck": "heavy-truck"}
_WHEELBASE_MM = {"van": 3500, "medium truck": 4000, "heavy truck": 4800}
_LIMITED_SPEED_KM_H = 90
_COMMENT_COLUMN = 40
MAX_COMMENT = 160
"""Characters of a name or comment that come from a job."""


def application_text_of_vecto_job(job: VectoJob) -> str:
    """Return a commented application of a job's powertrain.

    Each value of the job stands with the file and the key that it came from. Geometry, of which a
    job says nothing, stands as placeholders, which `placeholders` lists: nothing is evaluated
    before they are replaced.
    """
    return "\n".join(_lines(job)) + "\n"


def _lines(job: VectoJob) -> Iterator[str]:
    mass = job.gross_mass.value if job.gross_mass else float("inf")
    of_class = vehicle_class_of(mass)
    two_axles = job.drive.value in ("6x4", "8x4")
    yield from _head(job)
    yield ""
    yield _row(f"title: {_quoted(f'VECTO job {job.path.stem}')}", "what reports call it")
    yield _row("placeholders:", "take out each key whose value you entered")
    yield from (f"  - {key}" for key in _placeholders(job, two_axles=two_axles))
    yield from _vehicle(job, _WHEELBASE_MM[of_class])
    yield from _powertrain(job, axle=not two_axles)
    yield from _tyre(job)
    yield ""
    if two_axles:
        yield _row("drivelines:", "gearbox to the forward axle, and from there to the second")
        yield "  main:"
        yield from _line("    ", ((0, 0, 0), (1000, 0, -55), (2150, 0, -130)), job)
        yield "  inter-axle:"
        yield from _line("    ", ((0, 0, 0), (650, 0, -40)), job, torque_share=0.5)
    else:
        yield "driveline:"
        yield from _line("  ", ((0, 0, 0), (1000, 0, -55), (2150, 0, -130)), job, axle=False)
    yield ""
    yield _row(f"limits: {_PROFILES[of_class]}", "a profile by the vehicle's mass")
    yield ""
    yield DUTY_HINT
    yield _row("prime_mover: diesel", "assumed; or petrol")
    yield _row("shock_factor: 1.3", "assumed: on the torque that the joints are sized for")
    yield "# suspension and states: `cardan new --kind truck` explains them"


def _head(job: VectoJob) -> Iterator[str]:
    yield f"# Powertrain of the VECTO job {_plain(job.path.name)}; geometry is still to be entered."
    yield "#"
    yield '# A comment with a file name and a key says where a value is from; "assumed" is usual; a'
    yield '# "placeholder" is no value of the vehicle. While `placeholders` lists keys, nothing is'
    yield "# evaluated."
    at = f"{job.largest_torque:.0f} Nm"
    yield f"# Largest torque at the gearbox output by these values: {at}"
    if job.dynamic_radius is not None:
        metres_per_second = _LIMITED_SPEED_KM_H / 3.6
        turns = metres_per_second / job.dynamic_radius.value * job.axle_ratio.value / rpm
        yield (
            f"# Its speed at {_LIMITED_SPEED_KM_H} km/h, where a limiter holds trucks: {turns:.0f} "
            "rpm; speed_rpm, if given, replaces the engine's"
        )
    if job.curb_mass is not None:
        mass = f"{job.curb_mass.value:g} kg, {_plain(str(job.curb_mass))}"
        yield f"# Curb mass {mass}: add a load state with its axle loads"
    yield from (f"# Remark: {_plain(str(remark))}" for remark in job.remarks)


def _placeholders(job: VectoJob, *, two_axles: bool) -> Iterator[str]:
    """Yield the keys that hold no value of the vehicle."""
    yield "vehicle.wheelbase_mm"
    if job.drive.value[0] in "68" and not two_axles and job.driven_share is None:
        yield "vehicle.driven_share"
    if job.gross_mass and job.front_share is None:
        yield "vehicle.loads.gvw.cg_behind_front_mm"
    if job.dynamic_radius is None:
        yield "tyre.static_radius_mm"
    for line in ("drivelines.main", "drivelines.inter-axle") if two_axles else ("driveline",):
        yield from (
            f"{line}.{key}" for key in ("points_mm", "gearbox_slope", "pinion_slope", "shafts")
        )
    if two_axles:
        yield "drivelines.inter-axle.output_joint"


def _vehicle(job: VectoJob, wheelbase: int) -> Iterator[str]:
    yield ""
    yield "vehicle:"
    yield _row(f"  drive: {job.drive.value}", job.drive.source)
    yield _row(f"  wheelbase_mm: {wheelbase}", "placeholder")
    if job.drive.value in ("6x2", "8x2"):
        share = job.driven_share
        yield _row(
            f"  driven_share: {share.value if share else 0.6:.4g}",
            share.source if share else "placeholder: share of the bogie's load on the driven axle",
        )
    if not (mass := job.gross_mass):
        yield "  # loads: {gvw: {front_axle_kg: ..., rear_axle_kg: ...}}   # not in the job"
        return
    yield "  loads:"
    if share := job.front_share:
        front = share.value * mass.value
        loads = f"front_axle_kg: {front:.0f}, rear_axle_kg: {mass.value - front:.0f}"
        yield _row(f"    gvw: {{{loads}}}", f"{mass}, by {share}")
    else:
        loads = f"mass_kg: {mass.value:g}, cg_behind_front_mm: {0.65 * wheelbase:.0f}"
        yield _row(f"    gvw: {{{loads}}}", f"{mass}; centre of gravity: placeholder")


def _powertrain(job: VectoJob, *, axle: bool) -> Iterator[str]:
    yield ""
    yield _row("engine:", job.engine_name or "full load")
    yield _row(f"  speed_rpm: {_list(job.engine_speed.value)}", job.engine_speed.source)
    yield _row(f"  torque_Nm: {_list(job.engine_torque.value)}", job.engine_torque.source)
    if power := job.rated_power:
        yield _row(f"  power_kW: {power.value / kW:g}", power.source)
    if drag := job.drag_torque:
        yield _row(
            f"  brake_torque_Nm: {drag.value:g}",
            f"{drag}, the most of it; an engine brake holds back more",
        )
    yield ""
    yield "gearbox:"
    yield _row(f"  ratios: {_list(job.ratios.value)}", job.ratios.source)
    yield _efficiency("  efficiency: ", job.gearbox_efficiency)
    if stall := job.converter_ratio:
        yield _row(f"  converter_ratio: {stall.value:g}", stall.source)
    if axle:
        yield ""
        yield "axle:"
        yield _row(f"  ratio: {job.axle_ratio.value:g}", job.axle_ratio.source)
        yield _efficiency("  efficiency: ", job.axle_efficiency)


def _efficiency(key: str, given: object) -> str:
    value = getattr(given, "value", 1.0)
    return _row(
        f"{key}{value:g}", str(given) if given else "assumed: no loss map in the job, no loss"
    )


def _tyre(job: VectoJob) -> Iterator[str]:
    yield ""
    yield "tyre:"
    radius = job.dynamic_radius
    if radius is None:
        yield _row("  static_radius_mm: 500", "placeholder: the job names no tyre that is known")
    else:
        yield _row(f"  dynamic_radius_mm: {radius.value / mm:.4g}", radius.source)
        yield _row(
            f"  static_radius_mm: {radius.value / mm:.4g}", "assumed: the dynamic one; loaded, less"
        )
    yield _row("  friction: 0.8", "assumed")


def _line(
    indent: str,
    points: Sequence[tuple[int, int, int]],
    job: VectoJob,
    *,
    axle: bool = True,
    torque_share: float = 1.0,
) -> Iterator[str]:
    """Yield a line through placeholders of its joints, one shaft between each two."""
    said = ", ".join(f"[{x}, {y}, {z}]" for x, y, z in points)
    yield _row(
        f"{indent}points_mm: [{said}]", "placeholder: joint centres; x rearward, y right, z up"
    )
    yield _row(
        f"{indent}gearbox_slope: {{side_deg: 3.5}}", "placeholder: down to the rear is positive"
    )
    yield _row(f"{indent}pinion_slope: {{side_deg: 3.5}}", "placeholder")
    if torque_share != 1:
        yield _row(
            f"{indent}torque_share: {torque_share:g}", "assumed: an open inter-axle differential"
        )
        yield _row(
            f"{indent}output_joint: {{behind_mm: 330, above_mm: 100}}",
            "placeholder: joint 1 rides on the forward axle, from its wheel centre",
        )
        yield _row(f"{indent}load_share: 0.5", "assumed: of the bogie's load, on the second axle")
    if axle:
        losses = job.axle_efficiency.value if job.axle_efficiency else 1.0
        yield _row(
            f"{indent}axle: {{ratio: {job.axle_ratio.value:g}, efficiency: {losses:g}}}",
            job.axle_ratio.source,
        )
    torque = job.largest_torque * torque_share
    proposal = f"`cardan catalogue joints --for {torque:.0f}Nm` proposes sizes"
    yield _row(f"{indent}# joints: ...", proposal)
    yield _row(f"{indent}shafts:", "placeholder: their number, yokes and bearings; add tube: ...")
    for k in range(1, len(points)):
        hung = ", centre_bearing: {from_rear_joint_mm: 150}" if k < len(points) - 1 else ""
        yield f"{indent}  - {{phase_deg: 0{hung}}}"


def _row(text: str, comment: str) -> str:
    """Return a line with its comment in a common column."""
    return f"{text:<{_COMMENT_COLUMN - 1}} # {_plain(comment)}" if comment else text


def _list(values: Sequence[float]) -> str:
    return f"[{', '.join(f'{v:g}' for v in values)}]"


def _plain(text: str) -> str:
    """Return a text that is safe in a comment: one line of printable letters."""
    return "".join(c if c.isprintable() else " " for c in text)[:MAX_COMMENT]


def _quoted(text: str) -> str:
    escaped = _plain(text).replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'

"""Sheet of inputs of the workbook: what belongs to no state."""

from collections.abc import Sequence

from cardan.checks.line_response import LineResponse
from cardan.core.labels import Part
from cardan.core.units import GPa, MPa, deg, mm, rpm
from cardan.model.application import Application
from cardan.physics.strength.bearing_life import rated_torque_from_catalogue
from cardan.render.xlsx import (
    ALLOW_FRICTION_COEFFICIENT,
    ALLOW_NON_NEGATIVE,
    ALLOW_PHASE_DEG,
    ALLOW_POSITIVE,
    ALLOW_SHARE,
    FIRST_STATE_COLUMN,
    CellValidation,
    CellValue,
    SheetWriter,
)


def write_general_inputs(sheet: SheetWriter, a: Application) -> int:
    """Write what all lines share; return the row, from 0, that is kept for the verdict."""
    say, book = sheet.book.say, sheet.book
    sheet.sheet.set_column(0, 0, 46)
    sheet.sheet.set_column(1, 3, 11)
    sheet.sheet.set_column(FIRST_STATE_COLUMN, FIRST_STATE_COLUMN + 12, 11)
    sheet.title(
        a.title,
        (
            say("Driveline workbook: change what is coloured, and every result follows."),
            say(
                "Limits: {profile}. Positive slopes run down and to the right going rearward.",
                profile=a.profile,
            ),
        ),
    )
    top = sheet.row
    sheet.row += 1

    def put(
        label: str,
        unit: str,
        cells: Sequence[CellValue],
        name: str,
        allow: CellValidation = ALLOW_POSITIVE,
    ) -> None:
        sheet.write_row(label, unit, cells, style=book.input, name=name, allow=allow)

    engine, gearbox, tyre = a.engine, a.gearbox, a.tyre
    sheet.section(say("Engine and gearbox"))
    turns, pulls = engine.full_load if engine else ((), ())
    put(say("engine speed"), "rpm", [float(v) / rpm for v in turns] or [None], "engine_speeds")
    put(say("engine torque"), "N·m", [float(v) for v in pulls] or [None], "engine_torques")
    put(say("gear ratios"), "", list(gearbox.ratios) if gearbox else [1.0], "gear_ratios")
    put(
        say("gearbox efficiency"),
        "",
        [gearbox.efficiency if gearbox else 1.0],
        "gearbox_efficiency",
        ALLOW_SHARE,
    )
    put(
        say("converter torque ratio"),
        "",
        [gearbox.converter_ratio if gearbox else 1.0],
        "converter_ratio",
    )
    put(
        say("transfer case, low range"),
        "",
        [gearbox.transfer_ratio if gearbox else 1.0],
        "transfer_ratio",
    )
    sheet.section(say("Application"))
    put(
        say("torque at the gearbox output, where given"),
        "N·m",
        [a.torque],
        "torque_given",
        ALLOW_NON_NEGATIVE,
    )
    put(
        say("speed of the gearbox output, where given"),
        "rpm",
        [None if a.speed is None else a.speed / rpm],
        "speed_given",
    )
    put(say("shock factor"), "", [a.shock_factor], "shock_factor")
    put(say("prime mover factor"), "", [a.prime_mover_factor], "prime_mover_factor")
    put(
        say("tyre, friction"),
        "",
        [tyre.friction if tyre else None],
        "tyre_friction",
        ALLOW_FRICTION_COEFFICIENT,
    )
    put(
        say("tyre, static radius"), "mm", [tyre.static_radius / mm if tyre else None], "tyre_radius"
    )
    if a.duty or a.duty_cycle:
        sheet.section(say("Duty cycle"))
        _write_duty_cycle(sheet, a)
    return top


def _write_duty_cycle(sheet: SheetWriter, a: Application) -> None:
    """Write the duty cycle.

    Points are of the gearbox output. Those of a named cycle are shares of what a line carries
    at most and of its top speed, which the line's own calculation says.
    """
    say, book, cycle = sheet.book.say, sheet.book, a.duty_cycle

    def put(label: str, unit: str, cells: Sequence[CellValue], name: str) -> None:
        sheet.write_row(label, unit, cells, style=book.input, name=name, allow=ALLOW_NON_NEGATIVE)

    shares = [100 * p.share for p in (cycle.points if cycle else a.duty)]
    put(say("share of the life"), "%", shares, "duty_shares")
    if cycle:
        torques = [100 * p.torque_share for p in cycle.points]
        speeds = [100 * p.speed_share for p in cycle.points]
        put(say("share of the line's largest torque"), "%", torques, "duty_torques")
        put(say("share of the line's top speed"), "%", speeds, "duty_speeds")
    else:
        torques, speeds = [p.torque for p in a.duty], [p.speed / rpm for p in a.duty]
        put(say("torque at the gearbox output"), "N·m", torques, "duty_torques")
        put(say("speed of the gearbox output"), "rpm", speeds, "duty_speeds")
    angles = [None if p.angle is None else p.angle / deg for p in a.duty]
    put(say("joint angle, where given"), "deg", angles or [None] * len(shares), "duty_angles")


def write_line_inputs(sheet: SheetWriter, r: LineResponse, *, tag: str) -> None:
    """Write what belongs to one line but not to a state of it."""
    say, book, line, installed = sheet.book.say, sheet.book, r.line, r.demand.installed
    axle, share = installed.axle, r.demand.static_state.line.max_torque_share

    def put(
        label: str,
        unit: str,
        cells: Sequence[CellValue],
        name: str,
        allow: CellValidation = ALLOW_POSITIVE,
    ) -> None:
        sheet.write_row(label, unit, cells, style=book.input, name=tag + name, allow=allow)

    sheet.section(say("Line {line}", line=line.name))
    put(say("share of the torque"), "", [share], "torque_share", ALLOW_NON_NEGATIVE)
    put(say("line speed over gearbox speed"), "", [installed.speed_ratio], "speed_ratio")
    put(say("axle ratio"), "", [axle.ratio if axle else None], "axle_ratio")
    put(
        say("axle efficiency"),
        "",
        [axle.efficiency if axle else None],
        "axle_efficiency",
        ALLOW_SHARE,
    )
    joints = [say.part(Part("joint", k)) for k in range(1, line.joint_count + 1)]
    sheet.section(say("Joints"), ["", "", "", "", *joints])
    ratings = [rated_torque_from_catalogue(size) if size else None for size in r.joint_sizes]
    put(say("bearing rating Td"), "N·m", ratings, "joint_ratings")
    peaks = [size.peak_torque if size else None for size in r.joint_sizes]
    put(say("elastic limit Tcs"), "N·m", peaks, "joint_peak_torques")
    shafts = [say.part(Part("shaft", k)) for k in range(1, line.joint_count)]
    sheet.section(say("Shafts"), ["", "", "", "", *shafts])
    tubes = [s.tube for s in line.shafts]
    put(
        say("tube, outside diameter"),
        "mm",
        [t.outer / mm if t else None for t in tubes],
        "tube_outer",
    )
    put(say("tube, wall"), "mm", [t.wall / mm if t else None for t in tubes], "tube_wall")
    put(
        say("Young's modulus"),
        "GPa",
        [t.material.youngs_modulus / GPa if t else None for t in tubes],
        "tube_modulus",
    )
    put(say("density"), "kg/m³", [t.material.density if t else None for t in tubes], "tube_density")
    strengths = [t.material.yield_strength if t else None for t in tubes]
    put(
        say("yield strength"),
        "MPa",
        [None if s is None else s / MPa for s in strengths],
        "tube_yield",
    )
    put(
        say("yoke phase"),
        "deg",
        [s.phase / deg for s in line.shafts],
        "yoke_phases",
        ALLOW_PHASE_DEG,
    )
    put(say("polar inertia"), "kg·m²", [s.polar_inertia for s in line.shafts], "polar_inertias")
    ahead = [
        s.centre_bearing.from_rear_joint / mm if s.centre_bearing else None for s in line.shafts
    ]
    put(
        say("centre bearing ahead of the rear joint"),
        "mm",
        ahead,
        "bearing_offsets",
        ALLOW_NON_NEGATIVE,
    )

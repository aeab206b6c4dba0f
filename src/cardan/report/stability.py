"""Show a line's vibration: terminal, JSON, and the chart of speeds against frequencies."""

from collections.abc import Iterator
from itertools import groupby
from math import pi
from typing import Any
from xml.sax.saxutils import escape

import numpy as np

from cardan import __version__
from cardan.base.quantities import QUANTITIES
from cardan.base.units import rpm
from cardan.base.verdict import GRADES, Check
from cardan.report.contract import check
from cardan.report.language import EN
from cardan.report.terminal import BOLD, COLOURS, PLAIN
from cardan.study.stability import ORDERS, Stability, Vibration


def text(of: Stability, *, every: bool = False) -> Iterator[str]:
    """Yield the verdict, the worst check of each part and each line's numbers.

    With `every` each check has its row.
    """
    counts = ", ".join(f"{sum(c.grade == g for c in of.checks)} {g}" for g in reversed(GRADES))
    yield f"{BOLD}{of.application.title}{PLAIN}: stability {_coloured(of.verdict)} ({counts})"
    yield from _assumed(of)
    rows = list(of.checks) if every else list(_worst_of_parts(of.checks))
    yield ""
    yield (
        f"{BOLD}{'':6}{'quantity':<34}{'part':<24}{'where it is worst':<24}"
        f"{'value':>9}  {'limit':<12}{PLAIN}"
    )
    for c in sorted(rows, key=lambda c: (-GRADES.index(c.grade), c.quantity, c.margin)):
        q = QUANTITIES[c.quantity]
        sense = "outside" if c.limit.band else c.limit.sense
        yield (
            f"{_coloured(c.grade, 6)}{q.name:<34.33}{c.part:<24.23}{c.state:<24.23}"
            f"{EN.number(c.value / q.factor):>9}  {sense} {EN.number(c.bound / q.factor)} "
            f"{q.unit_name}"
        )
    for line in of.lines:
        yield from _line(line)


def document(of: Stability) -> dict[str, Any]:
    """Return the JSON document: verdict, checks and each line's numbers, units in the keys."""
    s = of.surroundings
    return {
        "cardan": ".".join(__version__.split(".")[:2]),
        "application": of.application.title,
        "verdict": of.verdict,
        "assumed": {
            "axle_inertia_kgm2": s.axle_inertia,
            "axle_stiffness_Nm_rad": s.axle_stiffness,
            "gearbox_inertia_kgm2": s.gearbox_inertia,
            "gearbox_stiffness_Nm_rad": s.gearbox_stiffness,
            "damping_ratio": s.damping_ratio,
            "rubber_loss": s.rubber_loss,
        },
        "lines": [
            {
                "name": v.line.name,
                "torsional_frequencies_Hz": (v.frequencies / (2 * pi)).tolist(),
                "gears": [
                    {"name": name, "speed_rpm": (between / rpm).tolist()}
                    for name, between in zip(v.gears, v.ranges, strict=True)
                ],
                "zones": [
                    {
                        "modes": list(z.modes),
                        "speed_rpm": z.speed / rpm,
                        "growth_per_s": dict(zip(v.states, z.growth.tolist(), strict=True)),
                    }
                    for z in v.zones
                ],
                "forced": {
                    "speed_rpm": (v.speeds / rpm).tolist(),
                    "torque_Nm": {
                        state: {
                            f"order {o}": v.amplitudes[s, k].tolist() for k, o in enumerate(ORDERS)
                        }
                        for s, state in enumerate(v.states)
                    },
                },
            }
            for v in of.lines
        ],
        "checks": [check(c) for c in of.checks],
    }


WIDTH, HEIGHT, LEFT, BOTTOM, TOP = 760, 420, 60, 50, 20


def chart(of: Vibration) -> str:
    """Return the Campbell diagram of a line's torsion as an SVG.

    Slanted are the orders the joints excite, level the frequencies; where they cross is
    resonance. Bands at the foot are the gears' speeds, triangles the parametric zones.
    """
    top = 1.1 * float(of.ranges.max()) / rpm
    hertz = 1.1 * max(ORDERS) * top / 60

    def x(speed: float) -> float:
        return LEFT + (WIDTH - LEFT - 20) * speed / top

    def y(frequency: float) -> float:
        return HEIGHT - BOTTOM - (HEIGHT - BOTTOM - TOP) * frequency / hertz

    def line(x1: float, y1: float, x2: float, y2: float, style: str) -> str:
        return f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" {style}/>'

    def words(x: float, y: float, said: str, anchor: str = "start") -> str:
        return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(said)}</text>'

    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
        'font-family="sans-serif" font-size="12" fill="#222">',
        f"<title>{escape(of.line.name)}: speeds against torsional frequencies</title>",
        line(LEFT, y(0), WIDTH - 20, y(0), 'stroke="#222"'),
        line(LEFT, y(0), LEFT, TOP, 'stroke="#222"'),
        words(WIDTH - 20, HEIGHT - 8, "speed, rpm", "end"),
        words(8, TOP - 6, "frequency, Hz"),
    ]
    for tick in _ticks(top):
        parts.append(words(x(tick), y(0) + 30, f"{tick:g}", "middle"))
        parts.append(line(x(tick), y(0), x(tick), y(0) + 4, 'stroke="#222"'))
    parts += [words(LEFT - 6, y(tick) + 4, f"{tick:g}", "end") for tick in _ticks(hertz)]
    for order in ORDERS:
        parts.append(line(x(0), y(0), x(top), y(order * top / 60), 'stroke="#888"'))
        parts.append(words(x(top) - 4, y(order * top / 60) - 4, f"order {order}", "end"))
    for k, w in enumerate(of.frequencies, 1):
        frequency = float(w) / (2 * pi)
        if frequency < hertz:
            parts.append(
                line(
                    LEFT,
                    y(frequency),
                    WIDTH - 20,
                    y(frequency),
                    'stroke="#1f5fa8" stroke-width="2"',
                )
            )
            parts.append(words(LEFT + 6, y(frequency) - 5, f"mode {k}, {frequency:.1f} Hz"))
    for zone in of.zones:
        at = zone.speed / rpm
        if at < top:
            grows = bool(np.any(zone.growth > 0))
            fill = "#b00020" if grows else "#2e7d32"
            parts.append(
                f'<path d="M{x(at) - 5:.1f},{y(0):.1f} h10 l-5,-12 z" fill="{fill}">'
                f"<title>{escape(zone.name)}: {'grows' if grows else 'damped'}</title></path>"
            )
    for k, (name, (low, high)) in enumerate(zip(of.gears, of.ranges / rpm, strict=True)):
        wide = max(x(float(high)) - x(float(low)), 2.0)
        parts.append(
            f'<rect x="{x(float(low)):.1f}" y="{y(0) + 6 + 2 * (k % 4):.1f}" width="{wide:.1f}" '
            f'height="5" fill="#e08a00" fill-opacity="0.6"><title>{escape(name)}</title></rect>'
        )
    return "\n".join([*parts, "</svg>", ""])


def _ticks(top: float) -> list[float]:
    """Return about six round numbers from 0 up to `top`."""
    rough = top / 6
    size = 10 ** np.floor(np.log10(rough))
    step = float(size * min((1, 2, 5, 10), key=lambda m: abs(m * size - rough)))
    return [k * step for k in range(int(top / step) + 1)]


def _assumed(of: Stability) -> Iterator[str]:
    s = of.surroundings
    gearbox = (
        f"gearbox {EN.number(s.gearbox_inertia)} kg m² on {EN.number(s.gearbox_stiffness)} N m/rad"
        if s.gearbox_inertia is not None and s.gearbox_stiffness is not None
        else "gearbox turning uniformly"
    )
    spring = f" on {EN.number(s.axle_stiffness)} N m/rad" if s.axle_stiffness else ""
    yield (
        f"Assumed: {gearbox}; axle {EN.number(s.axle_inertia)} kg m²{spring}; damping ratio "
        f"{EN.number(s.damping_ratio)}; loss factor of the rubber {EN.number(s.rubber_loss)}."
    )


def _line(of: Vibration) -> Iterator[str]:
    """Yield a line's frequencies, resonances and largest torques."""
    yield ""
    yield f"{BOLD}Line {of.line.name}{PLAIN}"
    for k, w in enumerate(of.frequencies, 1):
        at = ", ".join(f"order {o} at {EN.number(float(w) / o / rpm)} rpm" for o in ORDERS)
        yield f"  mode {k}: {EN.number(float(w) / (2 * pi))} Hz; {at}"
    for z in of.zones:
        rate = EN.number(float(z.growth.max()))
        yield f"  {z.name}: at {EN.number(z.speed / rpm)} rpm, largest growth {rate} 1/s"
    for k, order in enumerate(ORDERS):
        at = np.unravel_index(of.amplitudes[:, k].argmax(), of.amplitudes[:, k].shape)
        yield (
            f"  order {order}: up to {EN.number(float(of.amplitudes[at[0], k, at[1]]))} N m, "
            f"{of.states[int(at[0])]} at {EN.number(float(of.speeds[at[1]]) / rpm)} rpm"
        )


def _worst_of_parts(checks: tuple[Check, ...]) -> Iterator[Check]:
    """Yield the worst check of each part."""
    for _, same in groupby(sorted(checks, key=_part), key=_part):
        yield min(same, key=lambda c: (-GRADES.index(c.grade), c.margin))


def _part(c: Check) -> tuple[str, str, str]:
    return c.quantity, c.line, c.part


def _coloured(grade: Any, width: int = 0) -> str:
    return f"{COLOURS[grade]}{grade.upper() if not width else f'{grade:<{width}}'}{PLAIN}"

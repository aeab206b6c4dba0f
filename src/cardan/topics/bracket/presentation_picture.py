"""A bracket's deformed mesh, coloured by stress and damage, as a picture."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from textwrap import wrap
from typing import BinaryIO

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray, IntArray
from cardan.core.units import MPa
from cardan.render import svg
from cardan.render.chart import ticks
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.pdf import figure_png
from cardan.topics.bracket.assessment import BracketResult
from cardan.topics.bracket.load_cases import BearingLoadCase
from cardan.topics.bracket.presentation_values import MAX_MARKED_FATIGUE_FEATURES
from cardan.topics.bracket.shape_result import CaseResult, ShapeAssessment
from cardan.topics.bracket.vtk_file import displacement_and_stress_at_case_peak

MIN_DAMAGE_COLOUR_SHARE_OF_MAX_DAMAGE = 1e-6
"""Share of the largest damage that the map's colours reach down to."""
_PANEL_WIDTH_PX, _PANEL_HEIGHT_PX, _TITLE_HEIGHT_PX, _SCALE_WIDTH_PX = 540.0, 460.0, 44.0, 90.0
_LINE_HEIGHT_PX = 16.0
_CHARACTERS_PER_PANEL = 75
_SCALE_STEPS = 96
_DEFORMATION_SHARE = 0.04
"""Largest displacement drawn, over the size of the bracket."""
_TURBO = np.array([
    [0.13572138, 4.61539260, -42.66032258, 132.13108234, -152.94239396, 59.28637943],
    [0.09140261, 2.19418839, 4.84296658, -14.18503333, 4.27729857, 2.82956604],
    [0.10667330, 12.64194608, -60.58204836, 110.36276771, -89.90310912, 27.34824973],
])  # fmt: skip
"""Red, green and blue of the colour map Turbo as polynomials of a value from 0 to 1.

Source: A. Mikhailov, Turbo, An Improved Rainbow Colormap, Google AI Blog (2019), his fit."""


def write_picture(
    of: BracketResult, path: Path | BinaryIO, *, say: Translator = ENGLISH, over: str = "",
    under: BearingLoadCase | None = None,
) -> None:  # fmt: skip
    """Draw each variant `under` a case, else the original's worst, by its stress, into a PNG.

    Where a duty cycle is known, the damage it does at every place of the surface: below, or next to
    it where one variant is all there is, which leaves no page of a document half empty.

    `over` stands above them: the verdict, if no page around the picture has it.

    Raises
    ------
    MissingDependencyError
        If typst is not installed.
    """
    drawn = figure_png(picture_figure(of, say=say, over=over, under=under))
    if isinstance(path, Path):
        path.write_bytes(drawn)
    else:
        path.write(drawn)


def picture_figure(
    of: BracketResult,
    *,
    say: Translator = ENGLISH,
    over: str = "",
    under: BearingLoadCase | None = None,
) -> svg.Figure:
    """Return the drawing that `write_picture` writes."""
    case = of.variants[0].worst_case.case.when if under is None else under.when
    shown = [next(o for o in v.case_results if o.case.when == case) for v in of.variants]
    has_damage = all(len(v.damage_map) and v.damage_map.max() > 0 for v in of.variants)
    blocks = [_stress_block(of, shown, say)]
    if has_damage:
        blocks.append(_damage_block(of, say))
    block_width = len(of.variants) * _PANEL_WIDTH_PX + _SCALE_WIDTH_PX
    block_height = _TITLE_HEIGHT_PX + _PANEL_HEIGHT_PX
    beside = len(blocks) > len(of.variants)
    wide, high = (len(blocks), 1) if beside else (1, len(blocks))
    lines = wrap(over, _CHARACTERS_PER_PANEL * wide * len(of.variants)) if over else []
    top = _LINE_HEIGHT_PX * (len(lines) + 0.5) if lines else 0.0
    width, height = wide * block_width, top + high * block_height
    placed = [
        svg.group(
            block,
            transform=f"translate({k * block_width if beside else 0:.0f} "
            f"{top + (0 if beside else k * block_height):.0f})",
        )
        for k, block in enumerate(blocks)
    ]
    headline = [
        svg.text(width / 2, _LINE_HEIGHT_PX * (k + 1), line, anchor="middle", font_size=14)
        for k, line in enumerate(lines)
    ]
    title = say("Stress where it is worst: {case}", case=say.occasion(case))
    background = svg.rect(0, 0, width, height, fill="#fff")
    return svg.Figure(
        title=title,
        svg=svg.svg_document(width, height, background, *headline, *placed, alt=title),
        alt=title,
    )


def _stress_block(of: BracketResult, shown: Sequence[CaseResult], say: Translator) -> list[str]:
    """Return each variant deformed under a case, coloured by stress, and the scale."""
    highest = max(o.von_mises.value for o in shown) / MPa
    parts: list[str] = []
    for column, (v, o) in enumerate(zip(of.variants, shown, strict=True)):
        u, mises = displacement_and_stress_at_case_peak(v, o)
        nodes = v.solved.nodes
        size = float(np.ptp(nodes.points, axis=0).max())
        times = _DEFORMATION_SHARE * size / max(float(np.abs(u).max()), 1e-12)
        titles = (
            f"{say(v.name)}: {say.occasion(o.case.when)}",
            say("deformed {times} times", times=f"{times:.0f}"),
        )
        gauges = [(gauge.name, np.asarray(gauge.point)) for gauge in of.bracket.gauges]
        values = mises[nodes.faces[:, :3]].mean(axis=1) / MPa / highest
        parts += _panel(v, nodes.points + times * u, values, titles, column, gauges)
    marks = [(value / highest, say.compact_number(value, 4)) for value in ticks(0.0, highest)]
    return [*parts, *_scale(marks, say("von Mises stress, MPa"), len(of.variants))]


def _damage_block(of: BracketResult, say: Translator) -> list[str]:
    """Return each variant coloured by the damage of an hour of duty, and the scale."""
    most = max(float(v.damage_map.max()) for v in of.variants)
    place = _logarithmic_place(most)
    parts: list[str] = []
    for column, v in enumerate(of.variants):
        nodes = v.solved.nodes
        damage = np.zeros(len(nodes.points))
        damage[nodes.surface_nodes] = v.damage_map
        titles = (say("{name}: damage of an hour of duty", name=say(v.name)),)
        values = place(damage[nodes.faces].max(axis=1))
        parts += _panel(v, nodes.points, values, titles, column)
    low, high = np.log10(MIN_DAMAGE_COLOUR_SHARE_OF_MAX_DAMAGE * most), np.log10(most)
    marks = [
        (float(place(10.0**k)), f"1e{k}") for k in range(int(np.ceil(low)), int(np.floor(high)) + 1)
    ]
    return [*parts, *_scale(marks, say("damage per hour"), len(of.variants))]


def _logarithmic_place(most: float) -> Callable[[ArrayLike], FloatArray]:
    """Return a function from damage to its place on a logarithmic scale, 0 to 1."""
    decades = -np.log10(MIN_DAMAGE_COLOUR_SHARE_OF_MAX_DAMAGE)

    def place(damage: ArrayLike) -> FloatArray:
        share = np.maximum(
            np.asarray(damage, dtype=float) / most, MIN_DAMAGE_COLOUR_SHARE_OF_MAX_DAMAGE
        )
        return 1 + np.log10(share) / decades

    return place


def _panel(
    v: ShapeAssessment,
    points: FloatArray,
    values: FloatArray,
    titles: Sequence[str],
    column: int,
    gauges: Sequence[tuple[str, FloatArray]] = (),
) -> Iterator[str]:
    """Yield one variant, its surface triangles (f,) coloured by values from 0 to 1."""
    flat, depth, shade, facing = _projected(points, v.solved.nodes.faces)
    order = facing[np.argsort(depth[facing])]
    seen = flat[order]
    low, high = seen.min(axis=(0, 1)), seen.max(axis=(0, 1))
    room = np.array([_PANEL_WIDTH_PX - 50, _PANEL_HEIGHT_PX - 30])
    scale = float((room / np.maximum(high - low, 1e-12)).min())
    middle = np.array([
        (column + 0.5) * _PANEL_WIDTH_PX, _TITLE_HEIGHT_PX + _PANEL_HEIGHT_PX / 2,
    ])  # fmt: skip

    def to_pixels(at: FloatArray) -> FloatArray:
        return middle + scale * (at - (low + high) / 2) * [1, -1]

    colours = _hex_colours(values[order], shade[order])
    for (a, b, c), colour in zip(to_pixels(seen).tolist(), colours, strict=True):
        corners = f"M{a[0]:.1f} {a[1]:.1f}L{b[0]:.1f} {b[1]:.1f}L{c[0]:.1f} {c[1]:.1f}Z"
        yield f'<path d="{corners}" fill="{colour}" stroke="{colour}" stroke-width=".4"/>'
    for k, said in enumerate(titles):
        yield svg.text(float(middle[0]), _LINE_HEIGHT_PX * (k + 1), said, anchor="middle")
    _, right, up = _view_directions()
    marked = [
        *(
            (f"H{k}", np.asarray(f.point), "#fff")
            for k, f in enumerate(v.listed_features[:MAX_MARKED_FATIGUE_FEATURES], 1)
        ),
        *((name, point, "#000") for name, point in gauges),
    ]
    for name, point, colour in marked:
        x, y = to_pixels(np.array([point @ right, point @ up])).tolist()
        yield svg.circle(x, y, 3, fill=colour, stroke="#000")
        # Dark where it is blue, and light next to the part.
        yield svg.text(
            x + 5, y - 5, name, paint_order="stroke", stroke="#fff", stroke_width=3,
            stroke_linejoin="round", font_size=11,
        )  # fmt: skip


def _scale(marks: Sequence[tuple[float, str]], label: str, columns: int) -> Iterator[str]:
    """Yield the colours from 0 to 1 next to the panels, with named places."""
    left, height = columns * _PANEL_WIDTH_PX + 6, 0.8 * _PANEL_HEIGHT_PX
    bottom = _TITLE_HEIGHT_PX + (_PANEL_HEIGHT_PX + height) / 2
    places = (np.arange(_SCALE_STEPS) + 0.5) / _SCALE_STEPS
    step = height / _SCALE_STEPS
    for k, colour in enumerate(_hex_colours(places, np.ones(_SCALE_STEPS))):
        # Each reaches a little under the next: no line of the page shows between them.
        yield svg.rect(left, bottom - (k + 1) * step, 14, step + 0.5, fill=colour)
    for share, said in marks:
        y = bottom - share * height
        yield svg.line(left + 14, y, left + 18, y)
        yield svg.text(left + 21, y + 4, said)
    x, y = left + 72, bottom - height / 2
    yield svg.text(x, y, label, anchor="middle", transform=f"rotate(-90 {x:.1f} {y:.1f})")


def _hex_colours(values: FloatArray, shade: FloatArray) -> list[str]:
    """Return the colours of values (n,) from 0 to 1, darkened by a shade (n,)."""
    powers = np.clip(values, 0.0, 1.0)[:, None] ** np.arange(_TURBO.shape[1])
    bytes_ = np.rint(255 * np.clip(powers @ _TURBO.T, 0.0, 1.0) * shade[:, None]).astype(int)
    return [f"#{r:02x}{g:02x}{b:02x}" for r, g, b in bytes_.tolist()]


def _view_directions() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the directions to the eye, to the right and up."""
    eye = np.array([0.75, -0.45, 0.35])
    eye = eye / np.linalg.norm(eye)
    right = np.cross([0.0, 0.0, 1.0], eye)
    right /= np.linalg.norm(right)
    return eye, right, np.cross(eye, right)


def _projected(
    points: FloatArray, faces: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray, IntArray]:
    """Return triangles as seen, how near and how bright each is, and which face the eye."""
    eye, right, up = _view_directions()
    corner = points[faces[:, :3]]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    flat = np.stack([corner @ right, corner @ up], axis=-1)
    facing = normal @ eye
    return (
        flat,
        (corner @ eye).mean(axis=1),
        0.65 + 0.35 * np.abs(facing),
        np.flatnonzero(facing > 0),
    )

"""One U bracket with its cut edges sharp, chamfered and rounded: its zones live alike.

FAT 125 of IIW's detail 122 asks for corners that are removed: what removes them must not make
another zone of the edge. A round of 1.2 mm had made it sheet, told to live 9,300 times as long.
"""

import numpy as np
import pytest

from cardan.application.catalogue import find_shipped_part
from cardan.core.units import MPa, mm
from cardan.model.bracket import Bracket, FaceSelector, FatigueCurve, StepFileShape, UShape
from cardan.physics.fem.geometry import _u
from cardan.topics.bracket.life import load_history_of_forces
from cardan.topics.bracket.load_cases import BearingLoadCase
from cardan.topics.bracket.shape_assessment import assess_shape
from cardan.topics.bracket.shape_result import ShapeAssessment

pytestmark = [pytest.mark.bracket, pytest.mark.long]

U = UShape(
    seat_diameter=60 * mm, width=48 * mm, thickness=6 * mm, height=60 * mm, flange=40 * mm,
    bend_radius=8 * mm, bolt_diameter=9 * mm, bolt_pitch=26 * mm,
)  # fmt: skip
BROKEN = {
    "sharp": ("", 0.0),
    "chamfered by 0.1 t": ("MakeChamfer", 0.6),
    "rounded by 0.3 t": ("MakeFillet", 1.8),
}
WAYS = {"along": (1, 0, 0), "across": (0, 1, 0)}


def drawn(how: str, size: float, path) -> StepFileShape:
    """Write the U with all edges of its two flanks broken by a size, mm."""
    raw, flank = _u(U), U.width / 2 / mm
    if how:
        on = [e for e in raw.edges if all(abs(abs(v.p.x) - flank) < 1e-6 for v in e.vertices)]
        raw = getattr(raw, how)([e for e in on if abs(abs(e.center.x) - flank) < 1e-6], size)
    raw.WriteStep(str(path))
    bolts = tuple(
        FaceSelector(near=(x, y + U.bolt_diameter / 2, z - U.thickness / 2))
        for x, y, z in U.bolt_positions
    )
    seat = (FaceSelector(near=(0, 0, -U.seat_diameter / 2)),)
    return StepFileShape(
        path=str(path), centre=(0, 0, 0), seat=seat, bolts=bolts, thickness=U.thickness
    )


@pytest.fixture(scope="module")
def found(tmp_path_factory) -> dict[str, ShapeAssessment]:
    wave = 1000 * np.sin(2 * np.pi * np.arange(16) / 16)[:, None]
    cases = [
        BearingLoadCase(
            name, load_history_of_forces(wave * np.array([way], dtype=float)), turns=1, duration=1
        )
        for name, way in WAYS.items()
    ]
    curve = FatigueCurve(amplitude=160 * MPa, cycles=1e6, slope=5)
    where = tmp_path_factory.mktemp("edges")
    judged = {}
    for k, (name, (how, size)) in enumerate(BROKEN.items()):
        shape = drawn(how, size, where / f"{k}.step")
        bracket = Bracket(
            shape=shape, material=find_shipped_part("S355MC", "material"), fatigue=curve
        )
        judged[name] = assess_shape(bracket, shape, cases)
    return judged


def of_zone(v: ShapeAssessment, zone: str, case: int) -> tuple[float, float, float]:
    """Return the use of the fatigue limit of a zone's worst, and between what it lies."""
    o = v.case_results[case]
    mine = [k for k, f in enumerate(v.features) if f.zone == zone]
    within = o.utilisation_bounds[mine]
    return float(o.utilisation[mine].max()), float(within[:, 0].max()), float(within[:, 1].max())


@pytest.mark.parametrize("zone", ["cut edge", "sheet"])
@pytest.mark.parametrize("case", range(len(WAYS)))
@pytest.mark.parametrize("broken", [name for name in BROKEN if name != "sharp"])
def test_zone_life_is_equal_for_sharp_chamfered_and_rounded_edges(found, broken, case, zone):
    """A chamfer's within what either leaves open and a tenth: lives within 1.6.

    A round of 0.3 t is told 13 % more at most (0.90 to 1.01), of a section 3 % weaker, on the safe
    side: a fifth at most, lives within 2.5.
    """
    sharp, mine = (of_zone(found[name], zone, case) for name in ("sharp", broken))
    chamfered = "chamfered" in broken
    assert mine[0] == pytest.approx(sharp[0], rel=0.1 if chamfered else 0.2)
    if chamfered:
        assert sharp[1] <= mine[0] <= sharp[2] * 1.02
        assert mine[1] <= sharp[0] <= mine[2] * 1.02

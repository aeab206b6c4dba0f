"""The picture of a bracket: panels of stress and damage, marks, scales."""

import re
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cardan.core.labels import EvaluationCondition
from cardan.topics.bracket import presentation_picture
from cardan.topics.bracket.presentation_picture import picture_figure, write_picture

CORNERS = np.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
"""A tetrahedron, its faces anticlockwise seen from outside."""


def answer(*names: str, damage: float = 1e-5) -> Any:
    outcome = SimpleNamespace(
        case=SimpleNamespace(when=EvaluationCondition("case", "gvw", "combined")),
        von_mises=SimpleNamespace(value=100e6),
    )
    nodes = SimpleNamespace(
        points=CORNERS, faces=np.hstack([FACES, FACES]), surface_nodes=np.arange(4)
    )
    variants = [
        SimpleNamespace(
            name=name, solved=SimpleNamespace(nodes=nodes), case_results=(outcome,),
            worst_case=outcome, damage_map=damage * np.array([1.0, 0.1, 0.01, 0]),
            listed_features=[SimpleNamespace(point=(0.1, 0, 0))],
        )
        for name in names
    ]  # fmt: skip
    gauges = [SimpleNamespace(name="S1", point=(0, 0, 0.1))]
    return SimpleNamespace(variants=variants, bracket=SimpleNamespace(gauges=gauges))


@pytest.fixture(autouse=True)
def _peak(monkeypatch):
    fields = np.zeros((4, 3)), np.array([100e6, 50e6, 0, 100e6])
    monkeypatch.setattr(
        presentation_picture, "displacement_and_stress_at_case_peak", lambda *_: fields
    )


@pytest.mark.parametrize("names", [("original",), ("original", "reinforced")])
def test_picture_shows_stress_and_damage_of_each_variant(names):
    drawn = picture_figure(answer(*names), over="Line: FAIL").svg
    triangles = len(re.findall(r"<path d=", drawn))
    assert triangles % (2 * len(names)) == 0
    assert 0 < triangles < 2 * len(names) * len(FACES)  # those that face the eye
    assert drawn.count(">S1<") == len(names)
    assert drawn.count(">H1<") == 2 * len(names)
    for said in ("Line: FAIL", "von Mises stress, MPa", "damage per hour", ">1e-5<"):
        assert said in drawn


def test_picture_without_duty_cycle_shows_stress_only():
    assert "damage per hour" not in picture_figure(answer("original", damage=0.0)).svg


def test_picture_is_written_as_png(tmp_path):
    pytest.importorskip("typst")
    write_picture(answer("original"), tmp_path / "a.png")
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")

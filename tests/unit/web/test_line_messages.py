"""What the workbench draws of a line: pin axes of each cross, as the exact chain has them."""

import numpy as np
import pytest
from repository import ROOT

from cardan.application import reader, templates
from cardan.model.layout import Layout
from cardan.model.parts import Line
from cardan.web.line_messages import layout_message


def message(text: str) -> tuple[dict, Layout, Line]:
    (installed,) = reader.loads(text).lines
    return layout_message(installed.layout, installed), installed.layout, installed.line


@pytest.mark.parametrize("phase", [0, 30, 90])
def test_pin_axes_of_crosses_follow_yoke_phase(phase):
    text = templates.template_text("truck").replace("phase_deg: 0 ", f"phase_deg: {phase} ")
    told, layout, line = message(text)
    pins = np.array(told["pins"])
    assert pins.shape == (line.joint_count, 2, 3)
    d = layout.directions
    np.testing.assert_allclose(np.linalg.norm(pins, axis=-1), 1, atol=2e-4)  # four decimals
    # Each pin is square to its member, and the two of a cross to each other.
    for members, axes in ((d[:-1], pins[:, 0]), (d[1:], pins[:, 1])):
        np.testing.assert_allclose((members * axes).sum(axis=-1), 0, atol=2e-4)
    np.testing.assert_allclose((pins[:, 0] * pins[:, 1]).sum(axis=-1), 0, atol=2e-4)
    assert abs(pins[0, 0, 2]) > 0.99  # the gearbox's yoke is upright
    # From the front yoke of shaft 1 to its rear yoke: its phase, right-handed about it.
    front, rear = pins[0, 1], pins[1, 0]
    turned = np.degrees(np.arctan2(np.cross(front, rear) @ d[1], front @ rear)) % 180
    assert min(abs(turned - phase), 180 - abs(turned - phase)) < 0.03


def test_joint_without_cross_has_no_pin_axes():
    kinds = {}
    for installed in reader.read(ROOT / "examples/pick-up-4x4.yaml").lines:
        told = layout_message(installed.layout, installed)
        for kind, pins in zip(installed.line.joint_kinds, told["pins"], strict=True):
            kinds.setdefault(kind, set()).add(len(pins))
    assert kinds.pop("cross") == {2}
    assert kinds
    assert set.union(*kinds.values()) == {0}

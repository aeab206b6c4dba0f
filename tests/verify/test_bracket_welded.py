"""A strip welded to the frame by its end, against a beam of Bernoulli and Timoshenko's shear."""

import pytest

from cardan.application import reader
from cardan.core.errors import InvalidFileError
from cardan.core.units import MPa, mm
from cardan.topics.bracket.assessment import analyse_bracket

pytestmark = pytest.mark.bracket

WIDE, THICK, LONG, BORE = 60.0, 8.0, 220.0, 30.0
"""mm: across, along the shaft, from the bearing up to the frame, and of the seat."""
FORCE = 1000.0
FILE = """
title: A strip welded to the cross-member
speed_rpm: 2000
torque_Nm: 1000
driveline:
  slopes: {side_deg: [3, 1, 4, 2]}
  shafts:
    - {length_mm: 1200, tube: 100x3, centre_bearing: {from_rear_joint_mm: 140}}
    - {length_mm: 1500, tube: 100x3}
limits: protractor
bracket:
  step:
    file: strip.step
    centre_mm: [0, 0, 0]
    thickness_mm: 8
    seat: [{near_mm: [0, 0, 15]}]
    welded: [{near_mm: [0, 0, 220]}]
  cases:
    - {name: along, force_N: [1000, 0, 0]}
    - {name: across, force_N: [0, 1000, 0]}
  fatigue: {amplitude_MPa: 169, cycles: 1.0e+6, slope: 5}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The strip as another program's STEP file: its faces have no names."""
    from netgen import occ

    where = tmp_path_factory.mktemp("strip")
    y = WIDE / 2
    plate = occ.Box(occ.Pnt(-THICK / 2, -y, -y), occ.Pnt(THICK / 2, y, LONG))
    bore = occ.Cylinder(occ.Pnt(-20, 0, 0), occ.X, r=BORE / 2, h=40)
    (plate - bore).WriteStep(str(where / "strip.step"))
    (where / "strip.yaml").write_text(FILE)
    return where


def test_strip_welded_at_end_bends_as_beam(folder):
    (judged,) = analyse_bracket(reader.read(folder / "strip.yaml")).variants
    E, nu = 210e9, 0.3
    t, b, L = THICK * mm, WIDE * mm, LONG * mm
    for k, (thick, wide) in enumerate(((t, b), (b, t))):
        bends, shears = E * wide * thick**3 / 12, 5 / 6 * E / 2 / (1 + nu) * wide * thick
        beam = 1 / (L**3 / 3 / bends + L / shears)
        # Stiffer, for the bore ends the beam before its middle; softer, for the wall about it.
        assert 1 / judged.compliance[k, k] == pytest.approx(beam, rel=0.1)
    along = next(o for o in judged.case_results if o.case.name == "along")
    toes = [k for k, f in enumerate(judged.features) if f.zone == "weld toe"]
    top = max(toes, key=lambda k: along.feature_stress[k])
    assert judged.features[top].point[2] == pytest.approx(L, abs=0.5 * mm)
    # M / W, and an eighth more: a frame that does not give is a sharp corner all round, in which
    # stress rises before 0.4 thicknesses. It holds the width as well: σ and ν σ, von Mises 0.889.
    bent = FORCE * L / (b * t**2 / 6)
    assert bent < along.max_principal.value < 1.15 * bent
    assert along.feature_stress[top] == pytest.approx(0.889 * along.max_principal.value, rel=0.02)
    assert not any(f.zone == "bolt border" for f in judged.features)
    assert bent / MPa > 300
    assert along.bolt_forces.size == 0


def test_welded_strip_rejects_bolt_preload(folder):
    text = FILE + "  bolts: {preload_kN: 30}\n"
    (folder / "bolted.yaml").write_text(text)
    with pytest.raises(InvalidFileError, match="only welded"):
        reader.read(folder / "bolted.yaml")
    (folder / "loose.yaml").write_text(text.replace("    welded: [{near_mm: [0, 0, 220]}]\n", ""))
    with pytest.raises(InvalidFileError, match="or one that is welded"):
        reader.read(folder / "loose.yaml")

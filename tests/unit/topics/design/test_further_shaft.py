"""A shaft that is too long for its critical speed is made two, with a joint and a bearing."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from cardan.application import reader, templates
from cardan.cli import cli
from cardan.core.units import mm
from cardan.model.parts import Tube
from cardan.topics.design.sizing import (
    application_with_proposal,
    propose_parts,
    smallest_sufficient_proposals,
)
from cardan.topics.design.sizing import resolvable_checks as checks_of

LONG = templates.template_text("small").replace("length_mm: 1500", "length_mm: 3000")


@pytest.fixture(scope="module")
def application():
    return reader.loads(LONG)


@pytest.fixture(scope="module")
def way(application):
    problem = next(c for c in checks_of(application) if c.quantity == "critical_speed_ratio")
    (answer,) = smallest_sufficient_proposals(application, problem, kinds=("further shaft",))
    return answer


def test_too_long_shaft_is_made_two(application, way):
    (was, now), *_ = way.resolved_checks
    assert (was.quantity, was.grade, now.grade) == ("critical_speed_ratio", "fail", "pass")
    (line,) = application_with_proposal(application, way.offer).lines
    (old,) = application.lines
    assert len(line.line.shafts) == len(old.line.shafts) + 1
    # Both ends stay, the gearbox's slope and the pinion's too; the joint between is new.
    assert line.layout.points[[0, 1, -1]] == pytest.approx(old.layout.points[[0, 1, -1]], abs=1e-9)
    assert line.layout.directions[[0, -1]] == pytest.approx(old.layout.directions[[0, -1]])
    front, rear = line.layout.lengths[1:]
    assert (front, rear) == pytest.approx(way.offer.further_shaft.lengths, rel=1e-6)
    assert [s.centre_bearing is not None for s in line.line.shafts] == [True, True, False]
    assert line.line.shafts[1].spline is None
    # METHOD 8: of half the length a tube turns four times as fast before it whirls.
    assert now.value < was.value / 2


def test_height_of_the_further_joint_gives_its_angle(application, way):
    d = application_with_proposal(application, way.offer).lines[0].layout.directions
    angle = np.arccos(np.clip(d[2] @ d[3], -1, 1))
    assert angle == pytest.approx(abs(way.offer.further_shaft.joint_angle), rel=1e-3)


@pytest.mark.slow
def test_today_stands_beside_the_proposal(tmp_path):
    file = tmp_path / "long.yaml"
    file.write_text(LONG, encoding="utf-8")
    done = CliRunner().invoke(cli, ["size", str(file), "-q"], catch_exceptions=False)
    assert "Line main, today and with the further shaft" in done.stdout
    table = done.stdout.partition("today and with the further shaft")[2].splitlines()
    row = next(x for x in table if x.strip().startswith("Speed / critical speed"))
    assert row.split()[4:6] == ["1.35", "exceeded"]
    assert row.split()[7:] == ["met", "≤", "0.650", "|", "0.750"]
    document = json.loads(
        CliRunner().invoke(cli, ["size", str(file), "-q", "--json"], catch_exceptions=False).stdout
    )
    (offer,) = (
        o["further_shaft"]
        for r in document["remedies"]
        for o in (r, *r["others"])
        if o["kind"] == "further shaft"
    )
    assert sum(offer["lengths_mm"]) == pytest.approx(3000, rel=1e-3)
    assert offer["bearing_from_rear_joint_mm"] == 140


def test_one_further_shaft_is_offered_only_where_one_fails():
    """Near its limit a shaft is not worth a joint and a bearing more."""
    warm = reader.loads(LONG.replace("3000", "2150"))
    about = [c for c in checks_of(warm) if c.quantity == "critical_speed_ratio"]
    assert {c.grade for c in about} == {"warn"}
    kinds = {
        a.offer.kind
        for a in smallest_sufficient_proposals(warm, about[0])
        if getattr(a, "offer", None)
    }
    assert "further shaft" not in kinds


@pytest.mark.slow
@pytest.mark.parametrize(("tube", "inches"), [("100x3", False), ("4.000x0.083in", True)])
def test_tubes_are_offered_metric_for_metric(tube, inches):
    text = LONG.replace("{outer_mm: 101.6, wall_mm: 3.2}", tube)
    application = reader.loads(text.replace("torque_Nm: 8000", "torque_Nm: 16000"))
    offered = [
        r.offer.part for r in propose_parts(application).remedies if isinstance(r.offer.part, Tube)
    ]
    assert offered
    assert {t.name.endswith("in") for t in offered} == {inches}
    assert all(t.outer > 100 * mm for t in offered)

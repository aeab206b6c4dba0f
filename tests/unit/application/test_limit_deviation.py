"""A limit changed for one application: written where it belongs, signed, all others as before."""

from collections import Counter
from dataclasses import replace

import pytest
from repository import ROOT

from cardan.application import reader
from cardan.application.limit_deviation import LimitDeviationRecord, limit_deviation_file_changes
from cardan.application.yaml_edit import YamlEditor
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.errors import DesignError, InvalidFileError
from cardan.core.provenance import Source

CHAIN = (ROOT / "examples" / "three-joint-chain.yaml").read_text("utf-8")
TRUCK = (ROOT / "examples" / "refuse-collector-6x2.yaml").read_text("utf-8")
BARE = "\n".join(line for line in TRUCK.splitlines() if not line.startswith("limits:")) + "\n"
WAYS = {
    "named": TRUCK,
    "none": BARE,
    "another overridden": TRUCK.replace(
        "limits: heavy-truck",
        "limits:  # ours\n  profile: heavy-truck\n  overrides:\n"
        "    - quantity: clearance\n      maximum: 10  # tight\n      source: us",
    ),
    "in a row": TRUCK.replace(
        "limits: heavy-truck",
        "limits: {profile: heavy-truck, "
        'overrides: [{quantity: clearance, maximum: 10, source: "us"}]}',
    ),
    "own": CHAIN.replace(
        "limits: protractor",
        "limits:\n  - {quantity: joint_angle, normal: 6, source: a}\n"
        "  - {quantity: joint_angle, unit: rad, maximum: 0.2, states: [riding], source: b}\n"
        "  - {quantity: torsional_acceleration, maximum: 500, source: c}",
    ),
}
SIGN = {"reason": "narrow frame: 3 mm", "by": 'Q. "Engineer"', "on": "2026-11-22"}


def signed(text, which, **bounds):
    app = reader.loads(text)
    script = YamlEditor(text)
    to = LimitDeviationRecord(**{"normal": None, "maximum": None, **bounds, **SIGN})
    return app, script.with_changes(
        limit_deviation_file_changes(script, app.limits, which, to, profile=app.profile)
    )


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
def test_one_limit_is_another_and_the_rest_is_as_it_was(way):
    text = WAYS[way]
    for which, limit in enumerate(reader.loads(text).limits):
        if limit.band is not None:
            continue
        q = QUANTITIES[limit.quantity]
        bounds = {
            key: 1.1 * b / q.si_factor
            for key in ("normal", "maximum") if (b := getattr(limit, key)) is not None
        }  # fmt: skip
        app, new = signed(text, which, **bounds)
        after = reader.loads(new)
        changed = [m for m in after.limits if "signed" in str(m.source)]
        assert len(changed) == 1
        (one,) = changed
        for key in ("normal", "maximum"):
            was = getattr(limit, key)
            assert getattr(one, key) == (
                None if was is None else pytest.approx(1.1 * was, rel=1e-9)
            )
        assert str(one.source).startswith(f"deviation from {app.profile}, ")
        told = f": {SIGN['reason']}; signed {SIGN['by']}, 2026-11-22; before: {limit.source}"
        assert told in str(one.source)

        def bare(m):
            keep = {
                k: round(v, 9) for k in ("normal", "maximum") if (v := getattr(m, k)) is not None
            }
            return replace(m, source=Source(""), **keep)

        others = [m for k, m in enumerate(app.limits) if k != which]
        rest = [m for m in after.limits if m is not one]
        assert Counter(map(bare, rest)) == Counter(map(bare, others))
        assert bare(replace(one, normal=limit.normal, maximum=limit.maximum)) == bare(limit)
        # And everything but the limits stays as it was written.
        gone = set(text.splitlines()) - set(new.splitlines())
        assert len(gone) <= 2


def test_a_second_deviation_remembers_the_first_source():
    _, once = signed(TRUCK, 0, normal=310, maximum=520)
    k = next(k for k, m in enumerate(reader.loads(once).limits) if "signed" in str(m.source))
    app, twice = signed(once, k, normal=320, maximum=540)
    (one,) = [m for m in reader.loads(twice).limits if "signed" in str(m.source)]
    assert str(one.source).count("before: ") == 1
    assert str(reader.loads(TRUCK).limits[0].source) in str(one.source)
    assert "310 | 520" in str(one.source)
    assert len(app.limits) == len(reader.loads(twice).limits)


def test_who_and_why_are_needed_and_a_limit_must_be_one():
    with pytest.raises(InvalidFileError) as found:
        LimitDeviationRecord(normal=None, maximum=None, reason=" ", by="", on="2026-11-22")
    assert {p.key for p in found.value.problems} == {"reason", "by", "normal"}
    with pytest.raises(DesignError, match="safe side"):
        signed(TRUCK, 0, normal=600, maximum=500)  # warns after it fails
    with pytest.raises(InvalidFileError, match="take it out by hand"):
        signed(WAYS["own"], 0, maximum=7)


def test_a_deviation_changes_the_verdict_as_any_limit_does():
    from cardan.approval.approval import approve_driveline

    app = reader.loads(CHAIN)
    k = next(k for k, m in enumerate(app.limits) if m.quantity == "torsional_acceleration")
    assert approve_driveline(app).verdict == "warn"
    _, new = signed(CHAIN, k, normal=340, maximum=500)
    assert approve_driveline(reader.loads(new)).verdict == "pass"


@pytest.mark.parametrize("bound", [-5.0, 0.0])
def test_no_bound_above_nothing_is_deviated_from_to_nothing_or_less(bound):
    """-5 rad/s² was taken: everything failed, by a ring of a negative radius."""
    which = next(k for k, m in enumerate(reader.loads(TRUCK).limits) if m.normal and m.maximum)
    with pytest.raises(InvalidFileError, match="must be above 0") as found:
        signed(TRUCK, which, normal=bound, maximum=1.0)
    assert [p.key for p in found.value.problems] == ["normal"]

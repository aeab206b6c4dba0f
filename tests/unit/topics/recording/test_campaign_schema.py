"""A campaign's file: many recordings, one question; the same answers as one by one."""

import json
import re
from dataclasses import dataclass, replace
from functools import partial

import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner

from cardan.cli.main import cli
from cardan.core.errors import DesignError, InvalidFileError
from cardan.documents.approval_schema import schema as described
from cardan.physics.fatigue.crack_growth import (
    constant_geometry_factor,
    paris,
    sequences_between_crack_lengths,
)
from cardan.physics.fatigue.damage import miner_damage, order_blocks_for_high_damage
from cardan.physics.fatigue.rainflow import four_point, half_cycles, rainflow, repeating
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.fatigue.strain_life import material_from_strain_life_curve
from cardan.physics.signals.attribution_result import JointAttribution
from cardan.physics.signals.recording import merge_recordings, recording_from_arrays, time_slice
from cardan.render.i18n import ENGLISH, Translator
from cardan.topics.recording.alternative_life_models import StrainLifeSettings, strain_life_damage
from cardan.topics.recording.campaign_schema import campaign_json_schema, read_campaign_file
from cardan.topics.recording.campaign_study import _crossed
from cardan.topics.recording.presentation import progress_text

RATE = 500.0
T = np.arange(20_000) / RATE


def table(path, **columns):
    names = list(columns)
    rows = np.stack(list(columns.values()), -1)
    np.savetxt(path, rows, "%.9g", delimiter=",", header=",".join(names), comments="")
    return path


def signal(seed, size=30.0):
    noise = np.random.default_rng(seed).normal(size=T.size)
    return size * np.sin(2 * np.pi * 11 * T) * (1 + 0.3 * np.sin(T / 3)) + noise


CAMPAIGN = """
campaign: Bracket on two routes
recordings:
  - {file: town.csv, times: 3}
  - file: hill.csv
    name: hill
    beside: [{file: can.csv, late_s: 2}]
    segments:
      - {name: up, to_s: 25}
      - {name: down, from_s: 25, to_s: 40, times: 2}
strength: {amplitude_MPa: 30, cycles: 2e6, slope: 5}
channels: {B1: {factor: 400, offset: 5, unit: MPa}}
gauges: [S1, B1]
target_hours: 1e-6
"""


@pytest.fixture
def folder(tmp_path):
    pytest.importorskip("pyarrow")
    a, b = signal(1), signal(2, 45.0)
    head = {"time": T}
    table(tmp_path / "town.csv", **head, **{"S1 [MPa]": a, "B1 [mV/V]": (a - 5) / 400})
    table(tmp_path / "hill.csv", **head, **{"S1 [MPa]": b, "B1 [mV/V]": (b - 5) / 400})
    table(tmp_path / "can.csv", time=T[::50], speed=1000 + 10 * T[::50])
    (tmp_path / "c.yaml").write_text(CAMPAIGN)
    return tmp_path


def run(*arguments):
    return CliRunner().invoke(cli, [str(a) for a in arguments])


def alone(path, *more):
    done = run("life", path, "--gauge", "S1", "--sn", "30,2e6,5", "--json", *more)
    assert done.exit_code == 0, done.output
    return json.loads(done.output)["gauges"][0]


@pytest.mark.slow
def test_campaign_damage_is_weighted_sum_of_recordings(folder):
    """Three towns, a hill up once and down twice: by hand from each by itself."""
    done = run("life", folder / "c.yaml", "--json")
    assert done.exit_code == 0, done.output
    document = json.loads(done.output)
    town = alone(folder / "town.csv")["damage"]
    rows = np.loadtxt(folder / "hill.csv", delimiter=",", skiprows=1)
    split = round(25 * RATE)
    damages = [3 * town]
    for times, part in ((1, rows[:split]), (2, rows[split:])):
        table(folder / "part.csv", time=part[:, 0], **{"S1 [MPa]": part[:, 1]})
        damages.append(times * alone(folder / "part.csv")["damage"])
    gauge, scaled = document["gauges"]
    # Nine digits are written.
    assert gauge["damage"] == pytest.approx(sum(damages), rel=1e-6)
    assert scaled["damage"] == pytest.approx(gauge["damage"], rel=1e-5)
    hours = (3 * 40 + 25 + 2 * 15) / 3600 / sum(damages)
    assert gauge["hours"] == pytest.approx(hours, rel=1e-6)
    shares = [r["share"] for r in gauge["recordings"]]
    assert shares == pytest.approx(np.array(damages) / sum(damages), rel=1e-6)
    assert [r["recording"] for r in gauge["recordings"]] == ["town.csv", "hill, up", "hill, down"]
    assert [r["recording"] for r in document["recordings"]] == [
        "town.csv",
        "hill, up",
        "hill, down",
    ]
    assert any("can.csv (10 Hz), 2 s later" in n for n in document["recordings"][1]["notes"])
    assert document["verdict"] == "pass"
    assert len(document["checks"]) == 2


@pytest.mark.slow
def test_segment_or_rule_beyond_recording_end_is_noted(folder):
    """A segment and a rule there were nothing, and nobody was told."""
    text = CAMPAIGN.replace("from_s: 25, to_s: 40", "from_s: 25, to_s: 90")
    (folder / "c.yaml").write_text(text)
    _, up, down = json.loads(run("life", folder / "c.yaml", "--json").output)["recordings"]
    assert not any("ends after" in note for note in up["notes"])
    assert down["notes"][-1] == "hill, down is of 65 s, and the recording ends after 15 s of them"
    (folder / "c.yaml").write_text(CAMPAIGN.replace("to_s: 25}", "from_s: 50, to_s: 60}"))
    done = run("life", folder / "c.yaml")
    assert done.exit_code == 2
    assert "hill.csv has nothing between 50 and 60 s: it ends at 40 s" in done.output
    notes = json.loads(
        run("life", folder / "town.csv", "--gauge", "S1", "--sn", "30,2e6,5", "--json",
            "--mask", "41..50", "--mask", "39..41", "--accept", "spike@40.5..44").output
    )["notes"]  # fmt: skip
    assert notes == [
        f"--{what} is of a time behind its end, 40 s: it does nothing"
        for what in ("mask 41..50", "accept spike@40.5..44")
    ]


@pytest.mark.slow
def test_campaign_distance_is_unknown_if_a_recording_has_none(folder):
    """A speed that never turned counted as nought kilometres: its damage was nobody's way."""
    turning = 1000 + 10 * T[::50]
    for name, speed in (("still", 0 * turning), ("back", -turning), ("can", turning)):
        table(folder / f"{name}.csv", time=T[::50], speed=speed)
    text = CAMPAIGN.replace(
        "{file: town.csv, times: 3}", "{file: town.csv, beside: [{file: OTHER}]}"
    )
    text += "speed: speed:rpm\naxle_ratio: 4.3\ntyre_radius_m: 0.5\n"
    kilometres = {}
    for other in ("can", "back", "still"):
        (folder / "c.yaml").write_text(text.replace("OTHER", f"{other}.csv"))
        done = run("life", folder / "c.yaml", "--json")
        assert done.exit_code in (0, 1), done.output
        kilometres[other] = json.loads(done.output)["gauges"][0]["km"]
    assert kilometres["back"] == pytest.approx(kilometres["can"], rel=1e-9)
    assert kilometres["can"] > 0
    assert kilometres["still"] is None


def test_rule_with_time_range_takes_precedence(folder):
    """`--accept spike --mask spike@12..12.5` masks the one and accepts the others."""
    x = signal(1)
    for at in (3000, 6100, 9000):
        x[at] += 500
    path = table(folder / "town.csv", time=T, **{"S1 [MPa]": x})
    once = ("--mask", "spike@12..12.5", "--accept", "spike")
    damage = {
        name: alone(path, *rules)["damage"]
        for name, rules in (("once", once), ("other way round", once[2:] + once[:2]),
                            ("all", ("--accept", "spike")), ("none", ("--mask", "spike")))
    }  # fmt: skip
    assert damage["once"] == damage["other way round"]
    assert damage["once"] - damage["none"] == pytest.approx(
        2 / 3 * (damage["all"] - damage["none"]), rel=0.2
    )


def test_target_life_applies_to_campaign_mix(folder):
    text = CAMPAIGN.replace("target_hours: 1e-6", "target_hours: 1e9")
    (folder / "c.yaml").write_text(text)
    done = run("life", folder / "c.yaml")
    assert done.exit_code == 1
    assert re.search(r"^Bracket on two routes +NOT APPROVED$", done.output, re.MULTILINE)
    assert ": 2 exceeded, 0 met;" in done.output
    whole = run("life", folder / "c.yaml", "--all")
    assert (
        "Bracket on two routes: NOT APPROVED (2 exceeded, 0 beyond recommended, 0 met)"
        in whole.output
    )
    assert "of the mix" in whole.output


@pytest.mark.slow
def test_rejected_recording_rejects_campaign_mix(folder):
    rows = np.loadtxt(folder / "town.csv", delimiter=",", skiprows=1)
    rows[5000, 1] = -9999
    table(folder / "town.csv", time=rows[:, 0], **{"S1 [MPa]": rows[:, 1], "B1 [mV/V]": rows[:, 2]})
    document = json.loads(run("life", folder / "c.yaml", "--json").output)
    assert document["verdict"] == "incomplete"
    assert document["gauges"][0]["vetoes"] == ["sentinel"]
    assert document["gauges"][0]["hours"] is None
    told = run("life", folder / "c.yaml")
    assert told.exit_code == 1
    assert "S1: DATA REJECTED" in told.output
    # The rule is kept in the file: for one recording, or for all.
    for mended in (
        CAMPAIGN.replace("times: 3}", "times: 3, mask: [S1=sentinel]}"),
        CAMPAIGN + "mask: [sentinel]\n",
    ):
        (folder / "c.yaml").write_text(mended)
        assert run("life", folder / "c.yaml").exit_code == 0


LEVELS = """
campaign: Empty and laden
recordings: [{drives}]
strength: {{amplitude_MPa: 30, cycles: 2e6, slope: 5}}
gauges: [S1]
between_samples: 'no'
"""
EMPTY, LADEN = signal(4, 12.0), signal(5, 12.0) + 90.0


def levels(tmp_path, drives, more=""):
    (tmp_path / "l.yaml").write_text(LEVELS.format(drives=drives) + more)
    done = run("life", tmp_path / "l.yaml", "--json")
    return done, json.loads(done.output)


def counted(*parts):
    """Damage of parts joined and driven again and again, cycle by cycle of the whole signal."""
    curve = SNCurve(amplitude=30e6, cycles=2e6, slope=5.0).modified()
    return miner_damage(rainflow(1e6 * np.concatenate(parts), rule=repeating), curve=curve)


@pytest.mark.slow
def test_campaign_counts_cycles_between_recordings(tmp_path):
    """The joined signal, laden after empty ten times over, counted whole."""
    pytest.importorskip("pyarrow")
    table(tmp_path / "e.csv", **{"time": T, "S1 [MPa]": EMPTY})
    table(tmp_path / "f.csv", **{"time": T, "S1 [MPa]": LADEN})
    drives = "{file: e.csv, times: 1000}, {file: f.csv, times: 1000}"
    _, found = levels(tmp_path, drives)
    (gauge,) = found["gauges"]
    contract = described()
    jsonschema.validate(found, {**contract["$defs"]["campaign"], "$defs": contract["$defs"]})
    want = 1000 * counted(*[EMPTY, LADEN] * 10) / 10
    assert gauge["damage_in_turn"] == pytest.approx(want, rel=0.02)
    assert want > 5 * gauge["damage"]
    # A target between the two lives is met by each part alone, and may not be.
    target = f"target_hours: {2 * gauge['hours_in_turn']}\n"
    done, found = levels(tmp_path, drives, target)
    (check,) = found["checks"]
    assert (done.exit_code, check["verdict"], check["may_be"]) == (0, "pass", "fail")
    assert check["value_within"] == pytest.approx([gauge["hours_in_turn"], gauge["hours"]])
    told = " ".join(run("life", tmp_path / "l.yaml", "--all").output.split())
    assert "driven in turn, cycles from one to the other bring it to" in told
    assert "by what was not recorded, by that it may be exceeded" in told
    # What is driven once in a hundred meets the other as seldom.
    _, seldom = levels(tmp_path, drives.replace("f.csv, times: 1000", "f.csv, times: 10"))
    often, rare = gauge, seldom["gauges"][0]
    gain = often["damage_in_turn"] - often["damage"]
    assert rare["damage_in_turn"] - rare["damage"] == pytest.approx(gain / 100, rel=0.01)
    # Parts of one level are told as they are.
    table(tmp_path / "f.csv", **{"time": T, "S1 [MPa]": LADEN - 90})
    assert "damage_in_turn" not in levels(tmp_path, drives)[1]["gauges"][0]


@pytest.mark.slow
def test_cycles_between_recordings_count_in_alternative_models(tmp_path):
    """Against the joined signal, laden after empty: its second passage, and all its cycles."""
    pytest.importorskip("pyarrow")
    empty, laden = signal(4, 60.0), signal(5, 60.0) + 250.0
    table(tmp_path / "e.csv", **{"time": T, "S1 [MPa]": empty})
    table(tmp_path / "f.csv", **{"time": T, "S1 [MPa]": laden})
    drives = "{file: e.csv, times: 1000}, {file: f.csv, times: 1000}"
    asks = (
        "strain_life: [900, -0.09, 0.6, -0.6]\ncrack: [0.5, 10, 6.9e-12, 3]\n"
        "residue: repeat\nservice_hours: 0.2\n"
    )
    _, found = levels(tmp_path, drives, asks)
    contract = described()
    jsonschema.validate(found, {**contract["$defs"]["campaign"], "$defs": contract["$defs"]})
    by_itself, turned = found["otherwise"]["S1"], found["otherwise"]["S1"]["in_turn"]
    joined = 1e6 * np.concatenate([empty, laden])
    steel = material_from_strain_life_curve(
        modulus=206e9, strength=900e6, exponent=-0.09, ductility=0.6, ductility_exponent=-0.6
    )
    ((damage, strain),) = strain_life_damage(
        lambda: [joined[None]],
        [np.abs(joined).max()],
        StrainLifeSettings(material=steel),
        rule=repeating,
    )
    assert turned["strain_life"]["damage"] == pytest.approx(1000 * damage, rel=0.02)
    assert turned["strain_life"]["largest_strain_amplitude"] == pytest.approx(strain, rel=1e-6)
    assert 1000 * damage > 1.2 * by_itself["strain_life"]["damage"]
    cycles = rainflow(joined / 1e6, rule=repeating)
    grows = sequences_between_crack_lengths(
        start=0.5e-3, end=10e-3, cycles=cycles, law=partial(paris, C=6.9e-12, m=3.0),
        shape=partial(constant_geometry_factor, Y=1.12),
    )  # fmt: skip
    assert turned["crack"]["repeats"] == pytest.approx(grows / 1000, rel=0.02)
    assert by_itself["crack"]["repeats"] > 1.01 * turned["crack"]["repeats"]
    # Lognormal damage at failure alone scatters, by 0.3.
    passages = 0.2 / (2 * T.size / RATE / 3600)
    beta = -np.log(passages * counted(empty, laden)) / np.sqrt(np.log(1 + 0.3**2))
    assert turned["odds"]["beta"] == pytest.approx(beta, abs=0.02)
    assert by_itself["odds"]["beta"] > beta + 0.3
    told = " ".join(run("life", tmp_path / "l.yaml", "--all").output.split())
    assert "S1, parts driven in turn: the crack grows to its end in" in told


def test_cycles_between_recordings_use_worst_order():
    """Against rainflow of the joined signal in sixty orders, of parts of any level and swing."""
    rng = np.random.default_rng(1)
    curve = SNCurve(amplitude=30e6, cycles=2e6, slope=5.0).elementary()
    for _ in range(40):
        many = int(rng.integers(2, 5))
        parts = [
            1e6 * (rng.uniform(2, 40) * rng.normal(size=60) + rng.uniform(-60, 60))
            for _ in range(many)
        ]
        times = rng.integers(1, 5, size=many)
        residues = [four_point(p)[1] for p in parts]
        order = order_blocks_for_high_damage(residues, times=list(map(float, times)), curve=curve)
        found = miner_damage(order.additional_cycles, curve=curve) + sum(
            n * miner_damage(rainflow(p, rule=repeating), curve=curve)
            for n, p in zip(times, parts, strict=True)
        )
        orders = (rng.permutation(np.repeat(np.arange(many), times)) for _ in range(60))
        joined = (np.concatenate([parts[k] for k in order]) for order in orders)
        worst = max(miner_damage(rainflow(x, rule=repeating), curve=curve) for x in joined)
        assert 0.85 < found / worst < 1.25


def test_repeated_recording_forms_cycles_with_its_own_end():
    """Against rainflow of itself joined a hundred times: up a hill, and at its foot again."""
    curve = SNCurve(amplitude=30e6, cycles=2e6, slope=5.0).elementary()
    up = 1e6 * (np.linspace(0, 100, 400) + 3 * np.random.default_rng(3).normal(size=400))
    residue = four_point(up)[1]
    by_itself = miner_damage(rainflow(up, rule=half_cycles), curve=curve)
    order = order_blocks_for_high_damage([residue], times=[100.0], curve=curve, rule=half_cycles)
    more = miner_damage(order.additional_cycles, curve=curve)
    joined = miner_damage(rainflow(np.tile(up, 100), rule=half_cycles), curve=curve)
    assert 100 * by_itself + more == pytest.approx(joined, rel=0.02)
    assert joined > 1.9 * 100 * by_itself
    # Counted as it follows itself, nothing is left to add.
    assert (
        miner_damage(
            order_blocks_for_high_damage([residue], times=[100.0], curve=curve).additional_cycles,
            curve=curve,
        )
        == 0
    )


@pytest.mark.slow
@pytest.mark.parametrize(("ramp", "kind"), [(2.0, "drift"), (0.0, "zero-step")])
def test_level_change_between_segments_rejects_like_whole_recording(tmp_path, ramp, kind):
    """The recording whole is vetoed; two segments of it said a life and no word."""
    pytest.importorskip("pyarrow")
    # From one level to the other, as from a cold gauge to a warm one.
    both = EMPTY + (np.interp(T, [20 - ramp, 20 + ramp], [0, 90.0]) if ramp else 90.0 * (T >= 20))
    table(tmp_path / "a.csv", **{"time": T, "S1 [MPa]": both})
    cut = "segments: [{name: empty, to_s: 20}, {name: laden, from_s: 20, to_s: 40}]"
    for drive in ("{file: a.csv}", f"{{file: a.csv, {cut}}}"):
        _, found = levels(tmp_path, drive)
        assert found["gauges"][0]["vetoes"] == [kind], drive
        assert (found["gauges"][0]["hours"], found["verdict"]) == (None, "incomplete")
    told = " ".join(run("life", tmp_path / "l.yaml", "--all").output.split())
    assert f"so far apart that as one its data would be rejected, for {kind}" in told
    _, felt = levels(tmp_path, f"{{file: a.csv, accept: [{kind}], {cut}}}")
    assert felt["gauges"][0]["hours_in_turn"] < felt["gauges"][0]["hours"]
    _, off = levels(tmp_path, f"{{file: a.csv, {cut}}}", "zero: drift\n")
    assert off["gauges"][0]["vetoes"] == []


def test_recurring_level_changes_are_not_drift(tmp_path):
    """Up the hill and down again, up the hill once more: whole it has an answer, and cut."""
    pytest.importorskip("pyarrow")
    hill = EMPTY + 40 * np.clip(8 * np.sin(2 * np.pi * T / 26.0), -1, 1)
    table(tmp_path / "a.csv", **{"time": T, "S1 [MPa]": hill})
    cut = "segments: [{name: up, to_s: 12}, {name: down, from_s: 14, to_s: 25}]"
    for drive in ("{file: a.csv}", f"{{file: a.csv, {cut}}}"):
        _, found = levels(tmp_path, drive)
        assert found["gauges"][0]["vetoes"] == [], drive
    assert found["gauges"][0]["damage_in_turn"] > 1.2 * found["gauges"][0]["damage"]


def test_overlapping_segments_are_noted(folder):
    text = CAMPAIGN.replace("from_s: 25, to_s: 40", "from_s: 20, to_s: 40")
    (folder / "c.yaml").write_text(text)
    _, up, down = json.loads(run("life", folder / "c.yaml", "--json").output)["recordings"]
    note = "down and up have 5 s in common, which count in both"
    assert note in down["notes"]
    assert note not in up["notes"]


@dataclass(frozen=True)
class Told:
    """As much of what was heard as says who was guilty in it."""

    recording: "Told | None" = None
    causes: "Told | None" = None
    gauges: tuple[str, ...] = ()
    joint_attributions: tuple[JointAttribution, ...] = ()
    notes: tuple[str, ...] = ()


GUILTY, INNOCENT, WIDE = (
    JointAttribution(damage_share=a, interval=(b, c), f_statistic=99.0)
    for a, b, c in ((0.9, 0.8, 1.0), (0.0, -0.1, 0.1), (0.5, 0.0, 1.0))
)


@pytest.mark.parametrize(
    ("first", "second", "crossed"),
    [
        ((GUILTY, INNOCENT), (INNOCENT, GUILTY), True),
        ((GUILTY, INNOCENT), (GUILTY, INNOCENT), False),
        ((GUILTY, INNOCENT), (INNOCENT, INNOCENT), False),
        ((GUILTY, GUILTY), (INNOCENT, GUILTY), False),
        ((GUILTY, WIDE), (INNOCENT, GUILTY), False),
    ],
)
def test_exchanged_findings_between_recordings_are_noted(first, second, crossed):
    """Two plugs exchanged between two files made the mix's damage 0.6 and 94 times what it was."""
    parts = [
        (
            name,
            1.0,
            Told(recording=Told(), causes=Told(gauges=("S1", "S2"), joint_attributions=told)),
        )
        for name, told in (("a", first), ("b", second))
    ]
    (_, _, a), (_, _, b) = _crossed(parts)
    assert a.recording.notes == ()
    assert (
        any("joints dominate at S2 here and not at S1, and in a" in n for n in b.recording.notes)
        == crossed
    )


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("slope: 5", "slop: 5", "c.yaml:11:44: strength.slop: unknown key"),
        ("times: 3", "times: 0", "c.yaml:4:29: recordings[1].times: must be a number above 0"),
        ("to_s: 25}", "to_s: 0}", "segments[1].to_s: must be later than from_s"),
        ("file: town.csv", "file: ../town.csv", "lies outside the folder"),
        ("gauges: [S1, B1]", "gauges: S1", "gauges: must be a list"),
        ("name: down, from_s: 25", "name: up, from_s: 25", "this name is above already"),
        ("name: hill", "name: town.csv", "this name is above already"),
        ("campaign: B", "campaigns: B", "unknown key"),
    ],
)
def test_invalid_campaign_file_is_rejected_with_line_and_key(folder, old, new, said):
    (folder / "c.yaml").write_text(CAMPAIGN.replace(old, new))
    done = run("life", folder / "c.yaml")
    assert done.exit_code == 2, done.output
    assert said in done.output


def test_command_option_of_campaign_key_is_rejected(folder):
    done = run("life", folder / "c.yaml", "--gauge", "S1")
    assert done.exit_code == 2
    assert "--gauges belongs in the campaign's file" in done.output
    (folder / "c.yaml").write_text(CAMPAIGN.replace("town.csv", "city.csv"))
    done = run("life", folder / "c.yaml")
    assert done.exit_code == 2
    assert "no such file" in done.output


@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("gauges: [S1, B1]", "", "c.yaml: name the gauges with gauges;"),
        ("[S1, B1]", "[S1, B1]\nmean_stress: goodman", "the tensile strength: ultimate_MPa"),
        ("[S1, B1]", "[S1, B1]\nmask: [0..99]", "c.yaml: mask leaves nothing of S1"),
        (
            "channels: {B1: {factor: 400, offset: 5, unit: MPa}}", "",
            "scale it: channels: {B1: {factor: FACTOR, offset: 0, unit: UNIT}}",
        ),
    ],
)  # fmt: skip
def test_campaign_error_names_keys_not_options(folder, old, new, said):
    (folder / "c.yaml").write_text(CAMPAIGN.replace(old, new))
    done = run("life", folder / "c.yaml")
    assert done.exit_code == 2
    assert said in done.output
    assert "--" not in done.output
    for lang in ("pt", "it"):
        other = run("life", folder / "c.yaml", "--lang", lang)
        assert other.exit_code == 2
        assert "--" not in other.output
        assert done.output.partition(": ")[2] != other.output.partition(": ")[2]


def test_progress_text_names_current_step():
    assert progress_text("look 12%", ENGLISH) == "reading: 12%"
    assert progress_text("count 7 s", ENGLISH) == "counting cycles: 7 s"
    assert progress_text("cause 100%", Translator("pt")) == "procurando causas"


def test_corrected_file_option_is_rejected_for_campaign(folder):
    done = run("life", folder / "c.yaml", "--corrected", folder / "new.yaml")
    assert done.exit_code == 2
    assert "--corrected and the histories are of one recording with identify" in done.output
    assert not (folder / "new.yaml").exists()
    # Before anything is read: it had come after the whole run.
    (folder / "town.csv").unlink()
    for option in ("--corrected", "--load-history", "--changed-history"):
        done = run("life", folder / "c.yaml", option, folder / "new.csv")
        assert "--corrected and the histories are of one recording" in done.output, option
    (folder / "c.yaml").write_text(CAMPAIGN + "application: none.yaml\n")
    done = run("life", folder / "c.yaml")
    assert done.exit_code == 2
    assert "none.yaml" in done.output


def test_campaign_schema_validates_campaign_file(folder):
    import yaml

    found = campaign_json_schema()
    jsonschema.validate(
        yaml.safe_load(CAMPAIGN.replace("1e-6", "1.0e-6").replace("2e6", "2.0e+6")), found
    )
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({"campaign": "x"}, found)
    printed = json.loads(run("schema", "--campaign").output)
    assert printed["title"] == "cardan campaign"
    assert read_campaign_file(folder / "c.yaml").title == "Bracket on two routes"
    with pytest.raises(InvalidFileError):
        read_campaign_file(folder / "d.yaml")


def test_python_life_of_campaign_equals_command(folder):
    import cardan

    found = cardan.life(folder / "c.yaml")
    document = json.loads(run("life", folder / "c.yaml", "--json").output)
    assert json.loads(json.dumps(found.to_dict())) == document
    assert found.verdict == "pass"
    assert "lives" in str(found)
    assert len(repr(found).splitlines()) <= 7
    frame = found.to_frame()
    assert list(frame["recording"][:3]) == ["town.csv", "hill, up", "hill, down"]
    with pytest.raises(DesignError, match="sn belongs in the campaign's file"):
        cardan.life(folder / "c.yaml", sn="30,2e6,5")


# --------------------------------------------------------------------------- recordings


def recording(name, rate, **channels):
    data = np.stack(list(channels.values()))
    return recording_from_arrays(data, rate=rate, names=list(channels), name=name)


def test_time_range_of_recording_is_extracted():
    whole = recording("a", 10.0, x=np.arange(100.0), y=-np.arange(100.0))
    part = time_slice(whole, 2.0, 5.0, name="b")
    assert (part.name, part.samples) == ("b", 30)
    assert part.read_all(["y"]).tolist() == [(-np.arange(20.0, 50.0)).tolist()]
    assert (
        time_slice(whole, 8.0, np.inf).read_all(["x"])[0].tolist()
        == np.arange(80.0, 100.0).tolist()
    )
    for first, last in ((5.0, 5.0), (10.0, 11.0)):
        with pytest.raises(DesignError, match="nothing between"):
            time_slice(whole, first, last)


def test_second_recording_is_resampled_and_joined():
    fast = recording("a", 100.0, x=np.arange(500.0))
    slow = recording("b", 10.0, v=np.arange(20.0))
    both = merge_recordings(fast, slow, late=1.0)
    assert both.names == ("x", "v")
    x, v = both.read_all()
    np.testing.assert_array_equal(x, np.arange(500.0))
    assert np.isnan(v[:100]).all()
    np.testing.assert_allclose(v[100:291], np.arange(191) / 10, atol=1e-9)
    assert np.isnan(v[291:]).all()
    np.testing.assert_array_equal(both.read_all(["v"])[0][150:200], v[150:200])
    with pytest.raises(DesignError, match="both have a channel 'x'"):
        merge_recordings(fast, recording("c", 10.0, x=np.arange(20.0)))
    for late in (5.0, -2.0):
        with pytest.raises(DesignError, match="no time in common"):
            merge_recordings(fast, slow, late=late)


@pytest.mark.parametrize("rate", [10.0, 7.0])
def test_joined_recordings_use_higher_sample_rate(rate):
    """A gauge of 100 Hz beside a slow bus that was named first keeps every sample."""
    rng = np.random.default_rng(3)
    slow, x = recording("b", rate, v=np.arange(50.0)), rng.normal(size=600)
    pieces = [[0, 1, 17], [17, 18], [18, 50]]
    cut = replace(
        slow,
        read=lambda of: (slow.read_all()[list(of), a[0] : a[-1]] for a in pieces),
        samples=None,
    )
    for first in (slow, cut):
        both = merge_recordings(first, recording("a", 100.0, x=x), late=-1.0)
        v, found = both.read_all()
        assert both.rate == 100.0
        assert v.size == int(49 / rate * 100) + 1
        np.testing.assert_allclose(v, np.arange(v.size) / 100 * rate, atol=1e-9)
        kept = min(v.size, 500)
        np.testing.assert_allclose(found[:kept], x[100 : 100 + kept], atol=1e-9)
        assert both.notes[-1].endswith("straight between the samples of b")


def test_segment_rules_use_time_of_recording_file(folder):
    """Masked from 30 to 32 s, of a segment that begins at 25: that is 5 to 7 s of it."""
    rules = "    mask: [S1=30..32, S1=dropout@26..]\n    segments:\n"
    plain = (folder / "c.yaml").read_text()
    (folder / "c.yaml").write_text(plain.replace("    segments:\n", rules))
    done = run("life", folder / "c.yaml", "--json")
    assert done.exit_code == 0, done.output
    up, down = json.loads(done.stdout)["recordings"][1:]
    assert up["rules"]["masked"] == []
    assert [(r["from_s"], r["to_s"]) for r in down["rules"]["masked"]] == [(30, 32), (26, None)]
    assert up["gauges"][0]["quality"]["live_s"] == pytest.approx(25, abs=0.01)
    assert down["gauges"][0]["quality"]["live_s"] == pytest.approx(13, abs=0.01)
    # What it lost is what stood there.
    whole = alone(folder / "hill.csv", "--mask", "0..25", "--mask", "30..32")
    assert down["gauges"][0]["damage"] == pytest.approx(whole["damage"], rel=0.02)


@pytest.mark.slow
def test_segment_times_are_reported_in_time_of_recording_file(folder):
    """A spike at 30 s, of a segment that begins at 25, and the stress that is the largest."""
    head, *rows = (folder / "hill.csv").read_text().splitlines()
    at = 1 + next(k for k, row in enumerate(rows) if float(row.split(",")[0]) >= 30.0)
    time, _, other = rows[at].split(",")
    rows[at] = f"{time},500,{other}"
    (folder / "hill.csv").write_text("\n".join([head, *rows]))
    (folder / "c.yaml").write_text((folder / "c.yaml").read_text() + "usage: true\n")
    down = json.loads(run("life", folder / "c.yaml", "--json").stdout)["recordings"][2]
    (spike,) = [s for s in down["channels"][0]["suspects"] if s["kind"] == "spike"]
    assert spike["places"][0]["from_s"] == pytest.approx(float(time), abs=1e-6)
    assert down["usage"]["S1"]["peaks"][0]["time_s"] == pytest.approx(float(time), abs=1e-6)


@pytest.mark.slow
def test_segment_by_distance_is_converted_to_time(tmp_path):
    """600 rpm for a minute, then 1200: at axle ratio 4 and 0.5 m the way is 7.854 m a second."""
    rng = np.random.default_rng(1)
    t = np.arange(24_000) / 200.0
    speed = np.where(t < 60, 600.0, 1200.0) + 0.1 * rng.normal(size=t.size)
    x = np.where(t < 60, 5.0, 20.0) * rng.normal(size=t.size)
    np.savetxt(
        tmp_path / "a.csv", np.stack([t, x, speed], -1), delimiter=",", comments="", fmt="%.6g",
        header="time,S1 [MPa],n [rpm]",
    )  # fmt: skip
    way = 60 * 10 / 4 * 2 * np.pi * 0.5 / 1e3

    def asked(segments, more="speed: n\naxle_ratio: 4\ntyre_radius_m: 0.5\n"):
        path = tmp_path / "plan.yaml"
        path.write_text(
            f"campaign: By place\nrecordings: [{{file: a.csv, segments: [{segments}]}}]\n"
            f"gauges: [S1]\nstrength: {{amplitude_MPa: 30, cycles: 2e6, slope: 5}}\n{more}"
        )
        return CliRunner().invoke(cli, ["life", str(path), "--json", str(tmp_path / "out.json")])

    done = asked(
        f"{{name: slow, to_km: {way:.6f}}}, {{name: quick, from_km: {way:.6f}, to_km: 1.2}}"
    )
    assert done.exit_code == 0, done.output
    slow, quick = json.loads((tmp_path / "out.json").read_text())["gauges"][0]["recordings"]
    assert slow["live_s"] == pytest.approx(60, abs=0.2)
    assert quick["live_s"] == pytest.approx((1.2 - way) / way * 30, rel=0.01)
    assert quick["damage_per_hour"] > 100 * slow["damage_per_hour"]
    assert "segment far begins at 9 km" in asked("{name: far, from_km: 9, to_km: 10}").output
    assert "needs the shaft's speed" in asked("{name: a, to_km: 1}", more="").output
    both = asked("{name: a, to_km: 1, to_s: 5}")
    assert both.exit_code == 2
    assert "by time or by place" in both.output
    assert "without an end" in asked("{name: a, from_s: 5}").output


def test_campaign_profile_path_is_relative_to_campaign_file(folder, monkeypatch):
    """It was looked for where the command was started, wherever that is."""
    (folder / "mine.yaml").write_text(
        "name: mine\nlimits:\n"
        "- {quantity: fatigue_life, unit: h, maximum: 9, sense: '>=', source: us}\n"
    )
    path = folder / "c.yaml"
    path.write_text(CAMPAIGN + "limits: mine.yaml\n")
    monkeypatch.chdir(folder.parent)
    assert read_campaign_file(path).options["limits"] == str(folder / "mine.yaml")
    path.write_text(CAMPAIGN + "limits: ../mine.yaml\n")
    with pytest.raises(InvalidFileError, match="limits: lies outside the folder"):
        read_campaign_file(path)

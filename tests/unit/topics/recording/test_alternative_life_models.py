"""Strain-life, crack growth and odds from the command line, each against its own sum."""

import json
import math
from statistics import NormalDist

import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner

from cardan.cli.life import life as command
from cardan.documents.approval_schema import schema

RATE = 1000.0
T = np.arange(20_000) / RATE
STRAIN = ("--strain-life", "900,-0.09,0.6,-0.6")
CRACK = ("--crack", "0.5,10,6.9e-12,3")


@pytest.fixture(scope="module")
def tone(tmp_path_factory):
    """200 cycles of 100 MPa about nought."""
    path = tmp_path_factory.mktemp("tone") / "tone.csv"
    rows = np.stack([T, 100 * np.sin(2 * np.pi * 10 * T)], -1)
    np.savetxt(path, rows, "%.9g", delimiter=",", header="time_s,S1_MPa", comments="")
    return path


def run(path, *more):
    base = ("--gauge", "S1_MPa:MPa", "--sn", "120,2e6,5", "--miner", "elementary")
    return CliRunner().invoke(command, ["--all", str(path), *base, *map(str, more)])


def told(path, *more):
    done = run(path, *more, "--json", "-q")
    assert done.exit_code == 0, done.output
    return json.loads(done.output)["otherwise"]["S1_MPa"]


def test_alternative_models_are_absent_if_not_requested(tone):
    done = run(tone, "--json", "-q")
    assert "otherwise" not in json.loads(done.output)


@pytest.mark.slow
@pytest.mark.parametrize(("more", "kt"), [((), 1.0), (("--notch", "2"), 2.0)])
def test_strain_life_of_sine_matches_closed_form(tone, more, kt):
    """Elastic to a per mille without a notch: σf'²/E (2N)^2b + σf' εf' (2N)^(b+c) = σmax εa."""
    from cardan.physics.fatigue.strain_life import material_from_strain_life_curve

    of = material_from_strain_life_curve(
        modulus=206e9, strength=900e6, exponent=-0.09, ductility=0.6, ductility_exponent=-0.6
    )
    stress = float(of.stress(np.array(100e6), notch=kt if more else None))
    amplitude = float(of.strain(np.array(stress)))
    n = float(of.cycles_to_failure(*map(np.array, (amplitude, 0.0, stress)), "swt"))
    found = told(tone, *STRAIN, *more)["strain_life"]
    assert found["damage"] == pytest.approx(200 / n, rel=0.02)  # the ends are half loops
    assert found["largest_strain_amplitude"] == pytest.approx(amplitude, rel=1e-3)
    assert found["hours"] == pytest.approx(20 / found["damage"] / 3600, rel=1e-9)


def test_paris_crack_growth_matches_closed_form(tone):
    """Closed form for m = 3, a fully reversed cycle open half: ΔS = 100 MPa."""
    found = told(tone, *CRACK, "--crack-shape", "1")["crack"]
    c = 6.9e-12 * (100 * math.sqrt(math.pi)) ** 3
    cycles = 2 / c * (0.5e-3**-0.5 - 10e-3**-0.5)
    assert found["repeats"] == pytest.approx(cycles / 200, rel=0.01)
    assert told(tone, *CRACK, "--crack-threshold", "90")["crack"]["hours"] is None
    assert (
        "the crack grows to its end in no end h"
        in run(tone, *CRACK, "--crack-threshold", "90").output
    )


def test_failure_probability_of_lognormal_inputs_is_exact(tone):
    """One slope: in logs the limit is a plane, and first order, second order and β are Φ's."""
    damage = json.loads(run(tone, "--json", "-q").output)["gauges"][0]["damage"]
    hours = 0.4 / damage * 20 / 3600
    found = told(
        tone, "--service-hours", hours, "--scatter", "0.05", "--gauge-error", "0.1",
        "--miner-scatter", "0.3",
    )["odds"]  # fmt: skip
    spread = math.hypot(
        5 * 0.05 * math.log(10), math.sqrt(math.log1p(0.3**2)), 5 * math.sqrt(math.log1p(0.1**2))
    )
    beta = math.log(1 / 0.4) / spread
    assert found["beta"] == pytest.approx(beta, rel=2e-3)
    failure = NormalDist().cdf(-beta)
    assert found["first_order"] == pytest.approx(failure, rel=5e-3)
    assert found["second_order"] == pytest.approx(failure, rel=5e-3)
    assert found["sampled"] == pytest.approx(failure, abs=4 * found["sampled_error"] + 1e-3)
    assert sum(found["shares"].values()) == pytest.approx(1)
    strength = (5 * 0.05 * math.log(10) / spread) ** 2
    assert found["shares"]["strength"] == pytest.approx(strength, rel=0.01)


def test_failure_probability_above_one_half_is_accurate(tone):
    """Drawn about the failures, parts that fail would weigh up to a hundredfold: 0.85 for 0.96."""
    damage = json.loads(run(tone, "--json", "-q").output)["gauges"][0]["damage"]
    found = told(
        tone, "--service-hours", 6 / damage * 20 / 3600, "--scatter", "0.05", "--gauge-error", "0.1"
    )["odds"]
    assert found["first_order"] > 0.9
    # A share of 2000 parts.
    error = math.sqrt(found["first_order"] * (1 - found["first_order"]) / 2000)
    assert found["sampled_error"] == pytest.approx(error, rel=0.2)
    assert found["sampled"] == pytest.approx(found["first_order"], abs=4 * error)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.1, 0.18, 0.24])
def test_failure_probability_with_knee_matches_integral(tmp_path, share):
    """Against the integral over strength, normal in logs: it had told 0.006 of 0.010.

    Cycles of all sizes about a knee each make a kink there, and one of them is no bend.
    """
    size = np.linspace(40, 56, T.size)
    path = tmp_path / "ramp.csv"
    np.savetxt(path, np.stack([T, size * np.sin(20 * np.pi * T)], -1), "%.9g", delimiter=",",
               header="time_s,S1_MPa", comments="")  # fmt: skip
    amplitudes = np.interp(np.arange(0.025, 20, 0.05), T, size)  # of its half cycles

    def damage(strength):
        s = amplitudes / 60 / strength[:, None]
        return (0.5 * s ** np.where(s > 1, 5, 9) / 2e6).sum(-1)

    hours = share / damage(np.ones(1))[0] * 20 / 3600
    asks = [str(path), "--gauge", "S1_MPa:MPa", "--sn", "60,2e6,5", "--between-samples", "no",
            "--scatter", "0.05", "--service-hours", str(hours), "--json", "-q"]  # fmt: skip
    done = CliRunner().invoke(command, ["--all", *asks])
    found = json.loads(done.output)["otherwise"]["S1_MPa"]["odds"]
    z = np.linspace(-8, 8, 4001)
    lived = share / damage(np.ones(1)) * damage(np.exp(0.05 * math.log(10) * z))
    beyond = [NormalDist().cdf(v / math.sqrt(math.log1p(0.3**2))) for v in np.log(lived)]
    truth = np.trapezoid(np.exp(-(z**2) / 2) / math.sqrt(2 * math.pi) * beyond, z)
    assert found["second_order"] == pytest.approx(truth, rel=0.06)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--strain-life", "900,-0.09,0.6"), "a strain-life curve is SIGMA_F_MPa"),
        (("--strain-life", "900,0.09,0.6,-0.6"), "exponent of a strain-life curve"),
        (("--strain-life", "900,-0.09,inf,-0.6"), "a strain-life curve is SIGMA_F_MPa"),
        ((*STRAIN, "--notch", "0.5"), "--notch must be at least 1"),
        (("--notch", "2"), "--notch does nothing by itself: it needs --strain-life"),
        (("--crack", "5,2,1e-12,3"), "a crack is FROM_mm,TO_mm"),
        (("--crack", "1,2,1,3"), "C of a crack's growth lies within (0, 1e-3)"),
        (("--crack", "1,2,1e-12,30"), "m within 1 to 10"),
        ((*CRACK, "--crack-threshold", "-1"), "--crack-threshold"),
        ((*CRACK, "--crack-shape", "0"), "--crack-shape"),
        (("--service-hours", "0"), "--service-hours must be above 0"),
        (("--service-hours", "1", "--miner-scatter", "0"), "odds need something that scatters"),
        (("--miner-scatter", "nan"), "--miner-scatter"),
    ],
)
def test_model_option_out_of_range_is_rejected(tone, more, said):
    done = run(tone, *more)
    assert done.exit_code == 2, done.output
    assert said in done.output


@pytest.mark.slow
@pytest.mark.parametrize(("code", "word"), [("en", "local strain"), ("pt", "deformação local"),
                                            ("it", "deformazione locale")])  # fmt: skip
def test_alternative_models_are_reported_in_every_language(tone, tmp_path, code, word):
    more = (*STRAIN, *CRACK, "--service-hours", "2000", "--scatter", "0.05", "--lang", code)
    page = tmp_path / "a.html"
    done = run(tone, *more, "--html", page, "-q")
    assert done.exit_code == 0, done.output
    assert word in done.output
    assert word in page.read_text()


@pytest.mark.slow
def test_campaign_evaluates_alternative_models(tone):
    (tone.parent / "c.yaml").write_text(
        "campaign: x\nrecordings: [{file: tone.csv}]\ngauges: ['S1_MPa:MPa']\n"
        "strength: {amplitude_MPa: 120, cycles: 2e6, slope: 5, miner: elementary}\n"
        "strain_life: [900, -0.09, 0.6, -0.6]\ncrack: [0.5, 10, 6.9e-12, 3]\nservice_hours: 100\n"
    )
    done = CliRunner().invoke(command, ["--all", str(tone.parent / "c.yaml"), "--json", "-q"])
    assert done.exit_code == 0, done.output
    (of,) = json.loads(done.output)["recordings"]
    own = told(tone, *STRAIN, *CRACK, "--service-hours", "100")
    assert of["otherwise"]["S1_MPa"] == own


@pytest.mark.slow
def test_alternative_models_evaluate_campaign_mix(tone, tmp_path):
    """100 MPa three times to 60 MPa once: damages add, a crack grows by all, odds are of all."""
    low = tmp_path / "low.csv"
    rows = np.stack([T, 60 * np.sin(2 * np.pi * 10 * T)], -1)
    np.savetxt(low, rows, "%.9g", delimiter=",", header="time_s,S1_MPa", comments="")
    (tmp_path / "tone.csv").write_bytes(tone.read_bytes())
    alone = {p: json.loads(run(p, "--json", "-q").output)["gauges"][0]["damage"]
             for p in (tone, low)}  # fmt: skip
    damage = 3 * alone[tone] + alone[low]
    hours = 0.4 / damage * 80 / 3600
    (tmp_path / "c.yaml").write_text(
        "campaign: x\nrecordings: [{file: tone.csv, times: 3}, {file: low.csv}]\n"
        "gauges: ['S1_MPa:MPa']\n"
        "strength: {amplitude_MPa: 120, cycles: 2e6, slope: 5, miner: elementary, scatter: 0.05}\n"
        "strain_life: [900, -0.09, 0.6, -0.6]\ncrack: [0.5, 10, 6.9e-12, 3]\ncrack_shape: 1\n"
        f"service_hours: {hours}\nminer_scatter: 0\n"
    )
    page = tmp_path / "a.html"
    out = tmp_path / "a.json"
    asks = [str(tmp_path / "c.yaml"), "--json", str(out), "--html", str(page), "-q"]
    done = CliRunner().invoke(command, ["--all", *asks])
    assert done.exit_code == 0, done.output
    whole = json.loads(out.read_text())
    contract = {"$defs": schema()["$defs"], "$ref": "#/$defs/campaign"}
    jsonschema.validate(whole, contract, jsonschema.Draft202012Validator)
    found = whole["otherwise"]["S1_MPa"]
    each = [told(p, *STRAIN)["strain_life"] for p in (tone, low)]
    strain = 3 * each[0]["damage"] + each[1]["damage"]
    assert found["strain_life"]["damage"] == pytest.approx(strain)
    assert found["strain_life"]["hours"] == pytest.approx(80 / strain / 3600)
    assert found["strain_life"]["largest_strain_amplitude"] == each[0]["largest_strain_amplitude"]
    # m = 3: each passage grows it by 200 C (3 ΔS₁³ + ΔS₂³), open half.
    c = 6.9e-12 * math.pi**1.5 * (3 * 100**3 + 60**3)
    repeats = 2 / c * (0.5e-3**-0.5 - 10e-3**-0.5) / 200
    assert found["crack"]["repeats"] == pytest.approx(repeats, rel=0.01)
    assert found["crack"]["hours"] == pytest.approx(repeats * 80 / 3600, rel=0.01)
    beta = math.log(1 / 0.4) / (5 * 0.05 * math.log(10))
    assert found["odds"]["beta"] == pytest.approx(beta, rel=2e-3)
    text = CliRunner().invoke(command, ["--all", str(tmp_path / "c.yaml"), "-q"]).output
    assert text.count("the crack grows to its end in") == 3  # the mix's, and each recording's
    assert page.read_text().count("Judged otherwise") >= 3


def test_rejected_gauge_has_no_alternative_life(tmp_path):
    x = 100 * np.sin(2 * np.pi * 10 * T)
    x[[3000, 9000]] = -9999
    np.savetxt(tmp_path / "a.csv", np.stack([T, x], -1), "%.9g", delimiter=",",
               header="time_s,S1_MPa", comments="")  # fmt: skip
    done = run(tmp_path / "a.csv", *STRAIN, "--json", "-q")
    assert "otherwise" not in json.loads(done.output)

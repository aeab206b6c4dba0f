"""A campaign's application contradicts itself: `cardan life` says so as `check` does, once."""

from click.testing import CliRunner
from repository import EXAMPLES

from cardan.cli import cli

CAMPAIGN = """\
campaign: odd
recordings: [{file: drive.csv}]
gauges: [S1:MPa]
strength: {amplitude_MPa: 60, cycles: 1.0e+6, slope: 5}
application: truck.yaml
state: gvw
bearing: 1
unit_stress_MPa_kN: {S1: [1, 2, 3]}
"""


def test_contradictions_of_the_application_are_named_once(tmp_path):
    truck = (EXAMPLES / "medium-truck-4x2.yaml").read_text("utf-8")
    truck = truck.replace("pitch_rate_deg_mm: 0.004 ", "pitch_rate_deg_mm: 0.0004 ")
    (tmp_path / "truck.yaml").write_text(truck, "utf-8")
    (tmp_path / "drive.csv").write_text("time_s,S1\n", "utf-8")  # of no rows: nothing to wait for
    (tmp_path / "campaign.yaml").write_text(CAMPAIGN, "utf-8")
    found = CliRunner().invoke(cli, ["life", str(tmp_path / "campaign.yaml")])
    assert found.exit_code == 2
    assert found.stderr.count("suspension.linkage.pitch_rate_deg_mm: the axle's pitch over") == 1
    line = 1 + truck[: truck.index("pitch_rate_deg_mm")].count("\n")
    assert f"truck.yaml:{line}:24" in found.stderr

"""`cardan new --kind campaign RECORDING`: a campaign that says what the printed command says."""

import shlex

import numpy as np
import pytest
import recording_files as known
from click.testing import CliRunner

from cardan.cli import cli
from cardan.core.errors import InvalidFileError
from cardan.topics.recording.campaign_schema import read_campaign_file
from cardan.topics.recording.recording_overview import next_command, survey_recording

AT_KNEE = " # at the knee\n  "
OPEN = f"amplitude_MPa:               {AT_KNEE}cycles:                      {AT_KNEE}slope: "
FILLED = "amplitude_MPa: 30\n  cycles: 2e6\n  slope: 5 "


def run(*arguments, code=0):
    done = CliRunner().invoke(cli, [*map(str, arguments)])
    assert done.exit_code == code, done.output
    return done.output


def options_of(command):
    """Return what a command line says, by option."""
    words = shlex.split(command)[3:]
    return {
        key: [v for k, v in zip(words[::2], words[1::2], strict=True) if k == f"--{key}"]
        for key in ("gauge", "speed", "engine", "torque", "scale")
    }


def test_campaign_says_what_the_command_says(tmp_path):
    recording = tmp_path / "drive one.h5"
    known.hdf5(recording)
    told = run("new", "--kind", "campaign", recording)
    campaign = tmp_path / "drive one.yaml"
    assert f"cardan life {campaign}" in told
    text = campaign.read_text()
    assert "S1: samples standing still: 500" in text
    assert "[S1=freeze]" in text
    told = run("life", campaign, code=2)
    for key in ("amplitude_MPa", "cycles", "slope"):
        assert f"strength.{key}: has no value" in told
    assert OPEN in text
    campaign.write_text(text.replace(OPEN, FILLED))
    found = read_campaign_file(campaign)
    said = options_of(next_command(survey_recording(recording), "x"))
    assert list(found.options["gauges"]) == said["gauge"] == ["S1:MPa"]
    assert [found.options["speed"]] == said["speed"] == ["speed:rpm"]
    assert [found.options["torque"]] == said["torque"] == ["torque:Nm"]
    assert found.options["engine"] is None
    assert [drive.file for drive in found.drives] == [recording]
    assert found.options["sn"] == "30.0,2000000.0,5.0"


def test_what_the_file_does_not_say_is_refused_until_filled_in(tmp_path):
    path, t = tmp_path / "a.csv", np.arange(400) / 200
    x = np.random.default_rng(2).standard_normal((400, 2))
    head = "time [s],yes [mV/V],strain: left"
    rows = np.column_stack([t, x])
    np.savetxt(path, rows, "%.9g", delimiter=",", header=head, comments="")
    run("new", "--kind", "campaign", path)
    campaign = tmp_path / "a.yaml"
    campaign.write_text(campaign.read_text().replace(OPEN, FILLED))
    with pytest.raises(InvalidFileError, match=r"channels\.yes\.factor: has no value"):
        read_campaign_file(campaign)
    campaign.write_text(campaign.read_text().replace("factor: ,", "factor: 400,"))
    found = read_campaign_file(campaign)
    assert found.options["gauges"] == ("yes", "strain: left:UNIT")
    assert found.options["scale"] == ("yes=400.0,0.0:MPa",)
    assert "'UNIT' is no unit" in run("life", campaign, code=2)


def test_campaign_is_not_written_over(tmp_path):
    path = tmp_path / "a.csv"
    known.csv(path)
    (tmp_path / "a.yaml").write_text("mine")
    assert "is there already" in run("new", "--kind", "campaign", path, code=2)
    assert (tmp_path / "a.yaml").read_text() == "mine"
    run("new", "--kind", "campaign", path, "--force")
    told = run("new", "--kind", "campaign", tmp_path / "a.yaml", code=2)
    assert "takes a recording" in told
    assert "no such file" in run("new", "--kind", "campaign", tmp_path / "b.csv", code=2)

"""The application before and after a change of wheelbase."""

import re

import numpy as np
import pytest
from click.testing import CliRunner
from repository import EXAMPLES

from cardan.application import reader, templates
from cardan.application.wheelbase import text_with_wheelbase
from cardan.cli import cli
from cardan.core.errors import DesignError
from cardan.core.units import mm

SMALL = templates.template_text("small")


def new(*arguments: object):
    return CliRunner().invoke(cli, ["new", *map(str, arguments)], catch_exceptions=False)


def both(folder, *options: object, sizes=(3600, 4500)):
    result = new(
        folder / "conversion.yaml", "--wheelbase-from", sizes[0], "--wheelbase-to", sizes[1],
        *options,
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    files = [folder / f"conversion-{size}.yaml" for size in sizes]
    return [reader.read(file) for file in files], result.stdout


@pytest.mark.parametrize(
    ("options", "sizes"),
    [
        (("--kind", "small"), (3600, 4500)),
        (("--kind", "truck"), (4800, 5700)),
        (("--kind", "bus"), (6000, 6600)),
        (("--of", EXAMPLES / "van.yaml"), (3000, 3400)),
        (("--of", EXAMPLES / "three-joint-chain.yaml"), (3600, 3000)),
    ],
)
def test_last_shaft_takes_up_the_change(tmp_path, options, sizes):
    (before, after), _ = both(tmp_path, *options, sizes=sizes)
    (was,), (now,) = before.lines, after.lines
    shift = (sizes[1] - sizes[0]) * mm
    moved = now.layout.points - was.layout.points
    assert moved[:-1] == pytest.approx(np.zeros_like(moved[:-1]), abs=1e-9)  # the frame holds it
    # Slopes are written in thousandths of a degree, lengths in hundredths of a millimetre.
    assert moved[-1] == pytest.approx([shift, 0, 0], abs=0.1 * mm)
    ends = was.layout.directions[[0, -1]]
    assert now.layout.directions[[0, -1]] == pytest.approx(ends, abs=2e-5)
    if after.vehicle is not None:
        assert (before.vehicle.wheelbase, after.vehicle.wheelbase) == pytest.approx(
            (sizes[0] * mm, sizes[1] * mm)
        )


def test_lines_between_axles_move_as_they_are(tmp_path):
    own = reader.loads(templates.template_text("6x4")).vehicle.wheelbase / mm
    (before, after), _ = both(tmp_path, "--kind", "6x4", sizes=(round(own), round(own) + 500))
    for was, now in zip(before.lines, after.lines, strict=True):
        longer = now.layout.lengths[-1] - was.layout.lengths[-1]
        assert longer == pytest.approx(0 if was.output_joint else 500 * mm, abs=2 * mm)


def test_tube_between_yokes_is_lengthened_with_its_shaft():
    text = SMALL.replace(
        "    - length_mm: 1500", "    - tube_length_mm: 1300\n      length_mm: 1500"
    )
    after = reader.loads(text_with_wheelbase(text, wheelbase=4.5, from_wheelbase=3.6))
    last = after.lines[0].line.shafts[-1]
    assert last.length - last.tube_length == pytest.approx(200 * mm, abs=0.1 * mm)


def test_shaft_beyond_its_critical_speed_is_told(tmp_path):
    _, said = both(tmp_path, "--kind", "small")
    (share,) = re.findall(r"turns at (\S+) times its critical speed, 0.75 at most", said)
    assert float(share) == pytest.approx(0.864, abs=1e-3)
    assert f"`cardan size {tmp_path / 'conversion-4500.yaml'}` proposes them" in said
    _, said = both(tmp_path, "--kind", "small", "--force", sizes=(3600, 3700))
    assert "too long" not in said


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--wheelbase-from", 3600), "are given together"),
        (("--wheelbase-from", 3600, "--wheelbase-to", "3600"), "are the same"),
        (("--wheelbase-from", 3600, "--wheelbase-to", "2000"), "one shaft less"),
        (("--of", EXAMPLES / "van.yaml"), "give --wheelbase-from and --wheelbase-to"),
        (("--of", EXAMPLES / "van.yaml", "--wheelbase-from", 3600, "--wheelbase-to", 4500),
         "vehicle.wheelbase is 3000 mm, --wheelbase-from is 3600 mm"),
    ],
)  # fmt: skip
def test_change_that_cannot_be_is_rejected(tmp_path, options, said):
    result = new(tmp_path / "conversion.yaml", "--kind", "small", *options)
    assert result.exit_code == 2
    assert said in " ".join(result.output.split())
    assert list(tmp_path.iterdir()) == []


def test_states_with_a_geometry_of_their_own_are_rejected():
    with pytest.raises(DesignError, match="by hand"):
        text_with_wheelbase(
            templates.template_text("industrial"), wheelbase=4.5, from_wheelbase=3.6
        )

"""Writing: whole or not at all, through links, into pipes, and never over what was read.

Devices are never written to here: a mistake would replace them. Pipes stand for them.
"""

import errno
import os
import stat
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner, Result
from repository import EXAMPLES

import cardan
from cardan.cli import cli
from cardan.core.errors import CardanError, InvalidFileError
from cardan.schema import atomic_write as writer
from cardan.schema.atomic_write import check_output_paths, same_file, write_atomically

EXAMPLE = EXAMPLES / "van.yaml"
unix = pytest.mark.skipif(os.name == "nt", reason="pipes, owners and rights of Unix")


def run(*arguments: object) -> Result:
    return CliRunner().invoke(cli, [str(a) for a in arguments], catch_exceptions=False)


@pytest.fixture
def truck(tmp_path):
    file = tmp_path / "truck.yaml"
    file.write_bytes(EXAMPLE.read_bytes())
    return file


# --------------------------------------------------------------------------- whole or not at all


def test_existing_file_is_not_overwritten_without_replace(tmp_path):
    file = tmp_path / "a.yaml"
    assert write_atomically(file, "a: 1\n") == file
    with pytest.raises(InvalidFileError) as error:
        write_atomically(file, "a: 2\n")
    assert str(error.value) == f"{file}: is there already; choose another name, or say --force"
    assert file.read_text(encoding="utf-8") == "a: 1\n"
    write_atomically(file, "é: 2\n", replace=True)
    assert file.read_bytes() == "é: 2\n".encode()
    assert list(tmp_path.iterdir()) == [file]


def test_write_works_on_disk_without_hard_links(tmp_path, monkeypatch):
    def refused(*_):
        raise PermissionError(errno.EPERM, "no links here")

    monkeypatch.setattr(os, "link", refused)
    assert write_atomically(tmp_path / "a", "1").read_text() == "1"
    with pytest.raises(InvalidFileError, match="is there already"):
        write_atomically(tmp_path / "a", "2")
    assert [p.name for p in tmp_path.iterdir()] == ["a"]

    def late(_, target):
        """Somebody else writes the file while ours was being written."""
        Path(target).write_text("theirs")
        refused()

    monkeypatch.setattr(os, "link", late)
    with pytest.raises(InvalidFileError, match="is there already"):
        write_atomically(tmp_path / "b", "ours")
    assert (tmp_path / "b").read_text() == "theirs"
    assert {p.name for p in tmp_path.iterdir()} == {"a", "b"}


def test_failed_write_leaves_no_file(tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").touch()
    for name, why in [
        ("nowhere/a.yaml", f"there is no folder {tmp_path / 'nowhere'}"),
        ("file/a.yaml", "Not a directory"),
        ("folder", "it is a folder; name a file in it"),
        (f"{'n' * 256}", "File name too long"),
    ]:
        for refuse in (
            lambda path: write_atomically(path, "a: 1\n", replace=True),
            lambda path: check_output_paths({"--json": path}),
        ):
            with pytest.raises(InvalidFileError, match=f"cannot be written: {why}"):
                refuse(tmp_path / name)
    with pytest.raises(InvalidFileError, match="line 2 holds half a letter"):
        write_atomically(tmp_path / "b.yaml", "a\n\ud800")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "folder"]


def test_longest_file_name_is_written(tmp_path):
    """The part's name is not made from it: 255 bytes and a letter more would be refused."""
    file = tmp_path / ("n" * 255)
    write_atomically(file, "1")
    write_atomically(file, "2", replace=True)
    assert file.read_text() == "2"


def test_full_disk_keeps_old_file(tmp_path, monkeypatch):
    file = tmp_path / "a"
    file.write_text("old")

    def full(_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InvalidFileError, match="cannot be written: No space left on device"):
        write_atomically(file, "new", replace=True)
    assert file.read_text() == "old"
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize(
    ("denied", "why"), [("a", "it is write-protected"), ("", "no permission to write in")]
)
def test_write_protected_file_is_kept(tmp_path, monkeypatch, denied, why):
    file = tmp_path / "a"
    file.write_text("old")
    allowed = os.access
    monkeypatch.setattr(
        os, "access", lambda p, mode: Path(p) != tmp_path / denied and allowed(p, mode)
    )
    for refuse in (
        lambda: write_atomically(file, "new", replace=True),
        lambda: check_output_paths({"--json": file}),
    ):
        with pytest.raises(InvalidFileError, match=why):
            refuse()
    assert file.read_text() == "old"


# --------------------------------------------------------------------------- what stays


@unix
@pytest.mark.parametrize("mode", [0o600, 0o640, 0o444, 0o755])
def test_replaced_file_keeps_its_permissions(tmp_path, mode, monkeypatch):
    monkeypatch.setattr(os, "access", lambda *_: True)  # as for root
    file = tmp_path / "a"
    file.write_text("old")
    file.chmod(mode)
    write_atomically(file, "new", replace=True)
    assert stat.S_IMODE(file.stat().st_mode) == mode
    assert file.read_bytes() == b"new"


@unix
def test_new_file_respects_umask(tmp_path):
    before = os.umask(0o027)
    try:
        write_atomically(tmp_path / "a", "1")
        write_atomically(tmp_path / "b", "1", replace=True)
    finally:
        os.umask(before)
    for name in "ab":
        assert stat.S_IMODE((tmp_path / name).stat().st_mode) == 0o640


@unix
def test_temporary_file_has_no_wider_permissions_than_target(tmp_path, monkeypatch):
    """Who may not read the file may not read what it will hold either."""
    file = tmp_path / "a"
    file.touch(mode=0o600)
    seen: list[int] = []
    monkeypatch.setattr(os, "fsync", lambda f: seen.append(stat.S_IMODE(os.fstat(f).st_mode)))
    write_atomically(file, "secret", replace=True)
    assert seen[0] == 0o600


@unix
def test_owner_is_kept_if_permitted(tmp_path, monkeypatch):
    file = tmp_path / "a"
    file.touch()
    file.chmod(0o2755)
    if os.geteuid() == 0:
        os.chown(file, 1234, 2345)
        file.chmod(0o2755)
        write_atomically(file, "1", replace=True)
        found = file.stat()
        assert (found.st_uid, found.st_gid, stat.S_IMODE(found.st_mode)) == (1234, 2345, 0o2755)

        def refused(*_):
            raise PermissionError(errno.EPERM, os.strerror(errno.EPERM))

        monkeypatch.setattr(os, "chown", refused)
        write_atomically(file, "2", replace=True)
        found = file.stat()
        assert (found.st_uid, stat.S_IMODE(found.st_mode)) == (os.geteuid(), 0o755)


@unix
def test_symbolic_link_is_kept_and_its_target_is_written(tmp_path):
    (tmp_path / "far").mkdir()
    file, link, far = tmp_path / "far" / "a", tmp_path / "link", tmp_path / "far" / "b"
    file.write_text("old")
    link.symlink_to(file)
    write_atomically(link, "new", replace=True)
    assert link.is_symlink()
    assert file.read_text() == "new"
    dangling = tmp_path / "dangling"
    dangling.symlink_to("far/b")
    write_atomically(dangling, "there")
    assert dangling.is_symlink()
    assert far.read_text() == "there"
    round_ = tmp_path / "round"
    round_.symlink_to(round_)
    with pytest.raises(InvalidFileError, match="symbolic links"):
        write_atomically(round_, "1", replace=True)


@unix
@pytest.mark.parametrize("replace", [True, False])
def test_named_pipe_is_written_and_kept(tmp_path, replace):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    link = tmp_path / "link"
    link.symlink_to(pipe)
    got: list[bytes] = []
    for name in (pipe, link):
        reader = threading.Thread(target=lambda: got.append(pipe.read_bytes()), daemon=True)
        reader.start()
        write_atomically(name, "through", replace=replace)
        reader.join(timeout=10)
    assert got == [b"through"] * 2
    assert stat.S_ISFIFO(pipe.lstat().st_mode)
    assert link.is_symlink()


@unix
def test_file_descriptor_path_is_written():
    """As a shell hands it over, `--json >(jq .)`: /dev/fd/63."""
    reading, writing = os.pipe()
    write_atomically(f"/dev/fd/{writing}", "through", replace=True)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        assert pipe.read() == b"through"
    with pytest.raises(InvalidFileError, match="Bad file descriptor"):
        check_output_paths({"--json": f"/dev/fd/{writing}"})


@unix
def test_device_is_not_written(tmp_path, monkeypatch):
    monkeypatch.setattr(stat, "S_ISREG", lambda _: False)  # as if it were one
    file = tmp_path / "disk"
    file.write_text("all my data")
    for refuse in (
        lambda: write_atomically(file, "1", replace=True),
        lambda: check_output_paths({"--json": file}),
    ):
        with pytest.raises(InvalidFileError, match="it is neither a file nor a pipe"):
            refuse()
    assert file.read_text() == "all my data"


# --------------------------------------------------------------------------- parts


def part(folder: Path, *, process: int, computer: str = "", age: float = 0.0) -> Path:
    name = f".cardan-{computer or writer._computer()}-{process}-0123abcd.part"
    file = folder / name
    file.touch()
    os.utime(file, (time.time() - age,) * 2)
    return file


@pytest.fixture(scope="module")
def dead():
    """The number of a process that has ended."""
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        process.wait()
    return process.pid


def test_temporary_files_of_dead_processes_only_are_removed(tmp_path, dead):
    part(tmp_path, process=dead)
    keeps = [
        part(tmp_path, process=os.getpid()),
        part(tmp_path, process=dead, computer="00000000"),  # who knows what runs over there
    ]
    here = writer._computer()
    for name in (f".a.{dead}.part", "thesis.part", f".cardan-{here}-{dead}-0123abcd.part.yaml"):
        keeps.append(tmp_path / name)
        keeps[-1].touch()
        os.utime(keeps[-1], (0, 0))
    keeps.append(tmp_path / f".cardan-{here}-{dead}-00000000.part")
    keeps[-1].mkdir()
    file = write_atomically(tmp_path / "a", "1")
    assert sorted(tmp_path.iterdir()) == sorted([*keeps, file])


@pytest.mark.parametrize("computer", ["", "00000000"])
def test_stale_temporary_file_is_removed_after_one_hour(tmp_path, computer):
    old = part(tmp_path, process=os.getpid(), computer=computer, age=writer.STALE_PART_AGE_S + 60)
    write_atomically(tmp_path / "a", "1")
    assert not old.exists()


@unix
def test_temporary_file_of_killed_run_is_removed_by_next_write(tmp_path):
    code = (
        "import os, sys; from cardan.schema import atomic_write as writer\n"
        "os.fsync = lambda _: os.kill(os.getpid(), 9)\n"
        "writer.write_atomically(sys.argv[1], 'new', replace=True)"
    )
    file = tmp_path / "a"
    file.write_text("old")
    subprocess.run([sys.executable, "-c", code, file], check=False)
    assert file.read_text() == "old"
    assert len(list(tmp_path.iterdir())) == 2
    write_atomically(file, "newer", replace=True)
    assert list(tmp_path.iterdir()) == [file]


# --------------------------------------------------------------------------- claims


def other_names(file: Path) -> dict[str, Path]:
    """More names of one file."""
    link, hard, folder = (file.with_name(n) for n in ("link", "hard", "folder"))
    link.symlink_to(file)
    hard.hardlink_to(file)
    folder.symlink_to(file.parent, target_is_directory=True)
    return {
        "itself": file, "dots": file.parent / "." / ".." / file.parent.name / file.name,
        "link": link, "hard link": hard, "through a folder": folder / file.name,
    }  # fmt: skip


@unix
@pytest.mark.parametrize("kind", ["itself", "dots", "link", "hard link", "through a folder"])
@pytest.mark.parametrize("option", ["--json", "--html", "--pdf", "--xlsx"])
def test_output_over_input_file_is_rejected(truck, kind, option):
    """`--json truck.yaml truck.yaml` replaced the application by its results, and ended well."""
    before = truck.read_bytes()
    result = run("check", truck, option, other_names(truck)[kind])
    assert result.exit_code == 2
    assert f"{option} would write over the file" in result.stderr
    assert result.stdout == ""
    assert truck.read_bytes() == before


def test_output_over_user_profile_is_rejected(truck, tmp_path):
    own = tmp_path / "ours.yaml"
    own.write_text(
        "profile: o\nlimits: [{quantity: joint_angle, unit: deg, maximum: 9, source: us}]"
    )
    result = run("check", truck, "--limits", own, "--json", own)
    assert result.exit_code == 2
    assert own.read_text().startswith("profile")


@pytest.mark.parametrize(
    "command",
    [
        ("fix", "FILE", "--json", "FILE"),
        ("stability", "FILE", "--chart", "FILE"),
        ("bracket", "FILE", "--vtu", "FILE"),
        ("check", "FILE", "FILE", "--json", "FILE"),
        ("life", "FILE", "--json", "FILE"),
        ("life", "x.csv", "--sn", "1,1,1", "--application", "FILE", "--json", "FILE"),
    ],
)
def test_every_command_rejects_output_over_its_input(truck, command):
    before = truck.read_bytes()
    result = run(*(truck if word == "FILE" else word for word in command))
    assert result.exit_code == 2
    assert "would write over the file that is read" in result.stderr
    assert truck.read_bytes() == before


@pytest.mark.parametrize("name", ["out", "./out", "there/../out"])
def test_two_outputs_to_one_file_are_rejected(truck, tmp_path, name):
    (tmp_path / "there").mkdir()
    out = tmp_path / "out"
    result = run("check", truck, "--html", out, "--json", f"{tmp_path}/{name}")
    assert result.exit_code == 2
    assert "--json and --html would write into one file" in result.stderr
    assert not out.exists()


def test_output_path_is_checked_before_computation(truck, tmp_path, monkeypatch):
    """The missing folder is not found after the search for corrections."""
    monkeypatch.setattr("cardan.application.reader.read", lambda *_: pytest.fail("it was read"))
    for option in ("--json", "--html", "--pdf", "--xlsx"):
        result = run("check", truck, option, tmp_path / "nowhere" / "out")
        assert result.exit_code == 2
        assert "there is no folder" in result.stderr


@pytest.mark.parametrize("option", ["--json", "--html"])
def test_empty_output_name_is_rejected(truck, option):
    assert run("check", truck, f"{option}=").exit_code == 2


def test_only_json_is_allowed_on_standard_output(truck):
    assert run("check", truck, "--json", "-", "-q").exit_code == 0
    result = run("check", truck, "--html", "-")
    assert "--html cannot go to standard output" in result.stderr


@unix
def test_file_names_differing_in_case_match_if_disk_folds_case(tmp_path):
    one, other = tmp_path / "Out.html", tmp_path / "OUT.HTML"
    assert not same_file(one, other)
    folder = tmp_path / "folder"
    folder.mkdir()
    (tmp_path / "FOLDER").symlink_to(folder)  # as a disk that folds case shows itself
    assert same_file(folder / "Out.html", folder / "OUT.HTML")
    assert same_file(folder / "à", folder / "à")
    assert not same_file(folder / "a", folder / "b")


@unix
def test_character_devices_do_not_conflict(tmp_path, monkeypatch):
    file = tmp_path / "tty"
    file.touch()
    assert same_file(file, file)
    monkeypatch.setattr(stat, "S_ISCHR", lambda _: True)
    check_output_paths({"--json": file, "--html": file}, inputs=[file])


PROFILE = "profile: o\nlimits: [{quantity: joint_angle, unit: deg, maximum: 9, source: us}]\n"


@pytest.fixture
def naming(truck, tmp_path):
    """A truck that names a profile and a catalogue, by what each is read as."""
    named = {kind: tmp_path / f"own.{kind}" for kind in ("yaml", "csv")}
    named["yaml"].write_text(PROFILE)
    named["csv"].write_text("name,outer_mm,wall_mm\nours,100,3\n")
    text = yaml.safe_load(truck.read_text()) | {"limits": "own.yaml", "catalogues": ["own.csv"]}
    truck.write_text(yaml.safe_dump(text))
    return truck, named


@pytest.mark.parametrize("kind", ["yaml", "csv"])
@pytest.mark.parametrize(
    "command",
    [("check", "FILE", "--html"), ("fix", "FILE", "--json"), ("stability", "FILE", "--chart"),
     ("bracket", "FILE", "--vtu"), ("life", "x.csv", "--sn", "1,1,1", "--application", "FILE",
                                    "--json")],
)  # fmt: skip
def test_output_over_file_named_by_application_is_rejected(naming, kind, command):
    """`cardan check truck.yaml --html own.yaml` replaced the truck's own limits by a page."""
    truck, named = naming
    before = named[kind].read_bytes()
    result = run(*(truck if word == "FILE" else word for word in command), named[kind])
    assert (result.exit_code, result.stdout) == (2, "")
    assert "would write over the file that is read" in result.stderr
    assert named[kind].read_bytes() == before


@pytest.mark.parametrize("own", ["drive.csv", "bus.csv", "own.yaml", "truck.yaml"])
@pytest.mark.parametrize(
    "command",
    [("life", "CAMPAIGN", "--json"), ("life", "CAMPAIGN", "--pdf"),
     ("check", "truck.yaml", "--recording", "CAMPAIGN", "--html")],
)  # fmt: skip
def test_output_over_file_named_by_campaign_is_rejected(naming, tmp_path, command, own):
    """`cardan life campaign.yaml --json bus.csv` replaced a recording by its answer."""
    for name in ("drive.csv", "bus.csv"):
        (tmp_path / name).write_text("time_s,S1\n0,1\n")
    campaign = tmp_path / "campaign.yaml"
    campaign.write_text(
        "campaign: c\nrecordings: [{file: drive.csv, beside: [{file: bus.csv}]}]\n"
        "gauges: ['S1:MPa']\nstrength: {amplitude_MPa: 30, cycles: 2e6, slope: 5}\n"
        "application: truck.yaml\n"
    )
    before = (tmp_path / own).read_bytes()
    words = (campaign if w == "CAMPAIGN" else naming[0] if w == "truck.yaml" else w
             for w in command)  # fmt: skip
    result = run(*words, tmp_path / own)
    assert (result.exit_code, result.stdout) == (2, "")
    assert "that is read" in result.stderr
    assert (tmp_path / own).read_bytes() == before


def test_python_report_over_input_file_is_rejected(naming):
    truck, named = naming
    named["yaml"].rename(named["yaml"].with_name("own.json"))
    truck.write_text(truck.read_text().replace("own.yaml", "own.json.yaml"))
    (truck.parent / "own.json.yaml").symlink_to("own.json")
    found = cardan.check(cardan.read(truck))
    with pytest.raises(
        CardanError, match=r"the report would write over the file .*own\.json\.yaml"
    ):
        found.report(truck.parent / "own.json")
    assert (truck.parent / "own.json").read_text() == PROFILE


def test_output_into_program_package_is_rejected(truck):
    """What comes with it is read as well, wherever no other limits are named."""
    profile = Path(cardan.__file__).parent / "application/profiles/heavy-truck.yaml"
    before = profile.read_bytes()
    result = run("check", truck, "--html", profile)
    assert result.exit_code == 2
    assert "would write into the program itself" in result.stderr
    assert profile.read_bytes() == before

"""What the workbench bounds, on loopback: memory, jobs that wait, a kill, files that are bombs."""

import os
import signal
import sys
import time
import zlib
from pathlib import Path

import numpy as np
import pytest
from compression_bombs import dictionary_bomb
from recording_upload import bring
from repository import ROOT
from websockets.exceptions import ConnectionClosed
from workbench import PATIENCE, page, running

from cardan.web import jobs, worker

TRUCK = (ROOT / "examples" / "refuse-collector-6x2.yaml").read_text("utf-8")
BOMB = "title: &a [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"k{n}: &{chr(98 + n)} [{', '.join(['*' + chr(97 + n)] * 10)}]\n" for n in range(12)
)
"""A million million texts in twelve lines."""
linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks into /proc")


@pytest.fixture
def own(tmp_path):
    (tmp_path / "truck.yaml").write_text(TRUCK, "utf-8")
    with running(tmp_path, tmp_path / "drafts") as found:
        yield found


def settled(one):
    """Open the truck and hear its verdict; return its text."""
    one.hello()
    text = one.open()["saved"]
    one.say("ask", id=1, text=text)
    one.hear("full")
    return text


@pytest.mark.slow
@linux
def test_job_beyond_memory_limit_is_ended_and_others_continue(own):
    """Held to 60 MB more than it has, a yield of 60,000 trucks ends; the next is answered."""
    import resource

    with page(own) as one:
        text = settled(one)
        sigmas = {"sigmas": [{"id": "bearing_height 1", "amount": "2.0"}], "count": 60_000}
        one.say("job", id=3, job="yield", text=text, args={**sigmas, "count": 16})
        assert "fault" not in one.hear("done")
        pid = own.workers.jobs.pid
        assert resource.prlimit(pid, resource.RLIMIT_AS)[0] == worker.MAX_MEMORY_BYTES
        has = int(Path(f"/proc/{pid}/statm").read_text().split()[0]) * resource.getpagesize()
        resource.prlimit(pid, resource.RLIMIT_AS, (has + 60_000_000, worker.MAX_MEMORY_BYTES))
        one.say("job", id=4, job="yield", text=text, args={**sigmas, "sought": True})
        assert one.hear("done")["fault"] == "MemoryError"
        # What the job loaded, as compiled loops, stays; its memory is given back.
        resource.prlimit(pid, resource.RLIMIT_AS, (worker.MAX_MEMORY_BYTES,) * 2)
        assert one.ask(text)["lines"]
        one.say("job", id=5, job="yield", text=text, args={**sigmas, "count": 16})
        assert "fault" not in one.hear("done")


def parquet(honest, bomb):
    """190 kB of a file, of which one page says that it holds 537 MB of numbers nobody uses."""
    dictionary_bomb(honest, bomb, values=1 << 26)


def hdf5(honest, bomb):
    """A chunk of 134 MB for a thousand samples."""
    h5py = pytest.importorskip("h5py")
    for path, chunk in ((honest, 1000), (bomb, 1 << 24)):
        with h5py.File(path, "w") as file:
            file.attrs["rate_Hz"] = 500.0
            file.create_dataset("S1", data=np.arange(1000.0), chunks=(chunk,), maxshape=(None,),
                                compression="gzip")  # fmt: skip


def mdf(honest, bomb, kind=0, pack=zlib.compress):
    """Half a megabyte that unpacks to half a gigabyte, and says it is 16 kB."""
    blocks = pytest.importorskip("test_mdf_blocks")
    data = blocks.written(honest)
    packed = pack(bytes(1 << 29))
    bomb.write_bytes(blocks.packed_by(data, kind, packed, claimed=16_000))


def mdf_zstd(honest, bomb):
    """17 kB that do."""
    mdf(honest, bomb, 2, pytest.importorskip("zstd").compress)


def tdms(honest, bomb):
    """16 kB in which rows of 16 GB are claimed."""
    blocks = pytest.importorskip("test_tdms_blocks")
    both = {"S1": blocks.S1, "S2": blocks.S1}
    honest.write_bytes(blocks.segment_samples(both, by_rows=True))
    bomb.write_bytes(blocks.segment_samples(both, by_rows=True, claimed=10**9))


@pytest.mark.slow
@linux
@pytest.mark.parametrize(
    ("ending", "made", "why"),
    [("parquet", parquet, "S1 claims more bytes than its samples take"),
     ("h5", hdf5, "S1 claims more bytes than its samples take"),
     ("mf4", mdf, "makes more than the 16000 bytes that it claims"),
     ("mf4", mdf_zstd, "makes more than the 16000 bytes that it claims"),
     ("tdms", tdms, "it claims more samples than it can hold")],
)  # fmt: skip
def test_decompression_bomb_recording_is_rejected_before_loading(own, tmp_path, ending, made, why):
    """That of Parquet had taken 1.15 GB here, that of HDF5 1.07; TDMS asked for 16."""
    honest, bomb = tmp_path / f"honest.{ending}", tmp_path / f"bomb.{ending}"
    made(honest, bomb)
    with page(own) as one:
        settled(one)
        bring(one, honest)
        one.say("job", id=3, job="recording", text="", args={})
        assert one.hear("done")["channels"][0]["name"] == "S1"
        was = most_memory(own.workers.jobs.pid)
        bring(one, bomb)
        one.say("job", id=4, job="recording", text="", args={})
        (problem,) = one.hear("done")["problems"]
        assert why in problem["message"]
        assert most_memory(own.workers.jobs.pid) - was < 100_000_000
        bring(one, honest)
        one.say("job", id=5, job="recording", text="", args={})
        assert one.hear("done")["channels"][0]["name"] == "S1"


def most_memory(pid):
    """Return the most bytes that a process has held."""
    said = Path(f"/proc/{pid}/status").read_text()
    return 1024 * int(said.split("VmHWM:")[1].split()[0])


@pytest.mark.slow
@linux
def test_job_beyond_cpu_time_limit_is_ended(own):
    """Each answer has its own: what the ones before took does not count."""
    import resource

    with page(own) as one:
        text = settled(one)
        one.say("job", id=2, job="torsion", text=text, args={})
        one.hear("part")
        pid = own.workers.jobs.pid
        soft, hard = resource.prlimit(pid, resource.RLIMIT_CPU)
        assert worker.MAX_CPU_S <= soft < worker.MAX_CPU_S + PATIENCE
        resource.prlimit(pid, resource.RLIMIT_CPU, (1, hard))
        assert one.hear("done")["fault"] == "too much work"
        one.say("job", id=3, job="limits", text=text, args={})
        assert "limits" in one.hear("done")


@pytest.mark.slow
@linux
def test_jobs_beyond_queue_limit_are_rejected(own):
    with page(own) as one:
        text = settled(one)
        one.say("job", id=2, job="torsion", text=text, args={})
        one.hear("part")
        pid = own.workers.jobs.pid
        os.kill(pid, signal.SIGSTOP)
        try:
            for number in range(3, 3 + jobs.MAX_JOBS_PER_PAGE):
                one.say("job", id=number, job="torsion", text=text, args={})
            told = one.hear("done")
            assert (told["id"], told["fault"]) == (2 + jobs.MAX_JOBS_PER_PAGE, "too many")
            one.say("cancel", id=3)
            assert one.hear("done")["id"] == 3
            one.say("job", id=99, job="limits", text=text, args={})
            assert "limits" in one.hear("done")
        finally:
            os.kill(pid, signal.SIGCONT)


@pytest.mark.slow
@linux
def test_killed_job_is_reported_and_next_job_gets_new_process(own):
    with page(own) as one:
        text = settled(one)
        one.say("job", id=2, job="torsion", text=text, args={})
        one.hear("part")
        was = own.workers.jobs.pid
        os.kill(was, signal.SIGKILL)
        assert one.hear("done") == {"type": "done", "id": 2, "job": "torsion", "fault": "ended"}
        assert one.ask(text)["lines"]
        one.say("job", id=3, job="torsion", text=text, args={})
        one.hear("part")
        assert own.workers.jobs.pid not in (None, was)
        one.say("cancel", id=3)
        assert one.hear("done")["fault"] == "cancelled"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "why"),
    [(BOMB, "over 200000 entries"), ("a: " + "[" * 100_000, "nested 32 deep"),
     ("{a: " * 50_000, "nested 32 deep"),
     ('{"a":' * 100_000 + "1" + "}" * 100_000, "nested 32 deep")],
    ids=["names", "lists", "tables", "json"],
)  # fmt: skip
def test_yaml_bomb_is_rejected_at_once(tmp_path, text, why):
    """Typed, opened and listed beside another: each is told what is wrong, in a second or two."""
    (tmp_path / "bomb.yaml").write_text(text, "utf-8")
    (tmp_path / "truck.yaml").write_text(TRUCK, "utf-8")
    with running(tmp_path, tmp_path / "drafts") as house, page(house) as one:
        assert one.hello()["files"] == ["bomb.yaml", "truck.yaml"]
        one.ask(TRUCK)  # what answers is there
        saved = one.open(0)["saved"]
        since = time.process_time()
        told = one.ask(saved)
        assert why in " ".join(p["message"] + p["key"] for p in told["problems"])
        one.say("job", id=9, job="library", text="", args={})
        rows = {row["name"]: row for row in one.hear("done")["rows"]}
        assert rows["truck.yaml"]["verdict"]
        assert not rows["bomb.yaml"].get("verdict")
        assert time.process_time() - since < PATIENCE / 6  # the server's own part
        assert one.ask(TRUCK)["lines"]


def test_deeply_nested_message_closes_only_its_connection(own):
    with page(own) as one:
        one.hello()
        one.socket.send('{"type": "ask", "edits": ' + "[" * 200_000 + "]" * 200_000 + "}")
        with pytest.raises(ConnectionClosed):
            one.hear("live")
    with page(own) as other:
        other.hello()
        assert other.ask(TRUCK)["lines"]


def test_deeply_nested_draft_is_ignored(own, tmp_path):
    with page(own) as one:
        settled(one)
        one.say("keep", file=0, text=TRUCK + "# more\n", mark="x")
        one.hear("kept")
        (draft,) = (tmp_path / "drafts").iterdir()
        draft.write_text("[" * 200_000, "utf-8")
        assert one.open()["draft"] is None

"""One socket: what a page sends, and what it receives, by messages of JSON.

    the page says                          it receives
    hello  lang, was                       welcome: texts, quantities, files
    open   file                            opened: text, draft
    ask    id, text, drag, edits, pose     live: what follows; then full: the verdict
           held                            moved: the line; graded: limits; then full
    pose   id, text, pose                  posed: where a slider has the line
    help   id, text                        helped: what would help
    bring  id, name, size                  brought: how much of a recording has come
    piece  at, data                        brought
    job    id, job, text, args             part: what is known so far; then done: the answer
    cancel id                              done, with a fault
    keep   file, text, mark                kept
    save   file, text, mark                saved, or conflict with the text on disk
    drop   file                            kept
    pin    file, variants                  kept
    freeze file, text, by, note            frozen: its revisions
    create title, text                     files: their names; then opened
                                           disk: a file is another than it was
                                           beside: one that it names is another

What is more than is taken is refused, in the place of its answer. What has the wrong shape ends
the socket: the page sends no such thing.
"""

import asyncio
import json
from collections.abc import Callable
from contextlib import suppress
from math import inf
from pathlib import Path
from typing import Any, Protocol, get_args

from cardan.application.limit_profiles import profile_names as profiles
from cardan.core.errors import CardanError
from cardan.core.version import __version__
from cardan.physics.vehicle.operating_points import DriveMode
from cardan.render.i18n import LANGUAGE_CODES, Translator
from cardan.schema.node_reader import FileChangeStamp, file_stamp
from cardan.topics.design.drag_handles import HANDLE_KINDS
from cardan.web import jobs
from cardan.web import ui_texts as words
from cardan.web.first_steps import bracket_example, missing_libraries
from cardan.web.jobs import InvalidMessageError, MessageTooLargeError
from cardan.web.upload import Upload
from cardan.web.worker_pool import LatestOnlyQueue, WorkerQueues
from cardan.web.workspace import (
    EditConflictError,
    Workspace,
    error_text_without_path,
    text_fingerprint,
)

DISK_POLL_INTERVAL_S = 1.0
"""Seconds between looks at the disk."""

SEND_TIMEOUT_S = 20.0
"""Seconds a page may take to accept a message."""

VERDICT_DELAY_AFTER_EDIT_S = 0.2
"""Seconds that a hand rests before the verdict is requested."""

RESPONSE_KIND_BY_JOB = {
    "live": "live", "held": "moved", "graded": "graded", "pose": "posed", "full": "full",
    "help": "helped",
}  # fmt: skip
"""What a page receives in reply to each request."""

RESPONSE_KIND_BY_MESSAGE = {"ask": "live", "pose": "posed", "help": "helped"}
"""What is sent in reply to each of these messages."""

MAX_MESSAGE_BYTES = 8_200_000
"""Bytes of a message: a text as long as a file may be, in letters of four bytes."""

MAX_DRAG_MM = 1e5
"""mm: nothing on a vehicle is moved farther."""

Json = dict[str, Any]


class Socket(Protocol):
    """What a session needs of a socket."""

    async def receive_text(self) -> str:
        """Return the next message."""
        ...

    async def send_text(self, data: str) -> None:
        """Send a message."""
        ...


class Session:
    """One page, from its hello to its end."""

    def __init__(self, socket: Socket, desk: Workspace, lanes: WorkerQueues, *, token: str) -> None:
        self.socket, self.workspace, self.workers, self.token = socket, desk, lanes, token
        self.quick, self.limits, self.slow = map(
            LatestOnlyQueue, (lanes.quick, lanes.limits, lanes.slow)
        )
        self._latest_question = 0
        self._background_tasks = set[asyncio.Task[None]]()
        self._jobs: dict[int, asyncio.Task[None]] = {}
        self.upload = Upload()
        self.lang = "en"
        self.draft_owner, self.reconnected = "", False
        """As whom this page keeps drafts, and whether it did so before it lost its socket."""
        self.file: int | None = None
        self._sending = asyncio.Lock()
        self._file_stamp: FileChangeStamp = (0, 0, 0)
        self._delayed_verdict: asyncio.Task[None] | None = None
        self._campaign_lives: dict[tuple[str, str], Json] = {}
        """Lives of campaigns that were evaluated, by text and language: to be held side by side."""
        self._referenced_stamps: dict[Path, FileChangeStamp] = {}
        """Files that the text on the page names, as they were when it was answered."""

    async def run(self) -> None:
        """Listen and answer until the page goes, or says what it should not."""
        answering = map(self._answer, (self.quick, self.limits, self.slow))
        doing = (self._listen(), *answering, self._watch())
        loops = [asyncio.create_task(c) for c in doing]
        try:
            done, _ = await asyncio.wait(loops, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        finally:
            rest = (
                *loops,
                *self._background_tasks,
                *self._jobs.values(),
                *filter(None, [self._delayed_verdict]),
            )
            for task in rest:
                task.cancel()
            await asyncio.gather(*rest, return_exceptions=True)
            self.workspace.release_owner(self.draft_owner)
            self.upload.close()

    # ------------------------------------------------------------------- what the page says

    async def _listen(self) -> None:
        while True:
            try:
                said = json.loads(await self.socket.receive_text())
            except (ValueError, RecursionError):
                raise InvalidMessageError from None
            if not isinstance(said, dict):
                raise InvalidMessageError
            await self._dispatch(said)

    async def _dispatch(self, said: Json) -> None:
        heard = {
            "hello": self._hello, "open": self._open, "ask": self._ask, "pose": self._ask_pose,
            "help": self._ask_help, "keep": self._keep, "drop": self._drop, "save": self._save,
            "create": self._create, "pin": self._pin, "freeze": self._freeze,
            "job": self._start, "cancel": self._cancel, "bring": self._bring, "piece": self._piece,
        }  # fmt: skip
        handle = heard.get(str(said.get("type")))
        if handle is None:
            raise InvalidMessageError
        try:
            if "bytes" in said:  # it stands for a message that is longer than any that is read
                size, most = (
                    jobs.bounded_number(said["bytes"], most=inf) / 1e6,
                    MAX_MESSAGE_BYTES / 1e6,
                )
                msg = f"the request takes {size:.0f} MB, more than the {most:.0f} MB that are read"
                raise MessageTooLargeError(msg)
            await handle(said)
        except MessageTooLargeError as error:
            await self._refuse(said, Translator(self.lang).with_minus_sign.error(str(error)))

    async def _refuse(self, said: Json, why: str) -> None:
        """Report that something is not done, if its reply was waited for."""
        kind, number = said["type"], said.get("id")
        if kind == "job":
            await self._send("done", id=number, job=said.get("job"), fault=why)
        elif kind in RESPONSE_KIND_BY_MESSAGE:
            held = kind == "ask" and said.get("held") is True
            await self._send(
                "moved" if held else RESPONSE_KIND_BY_MESSAGE[kind], id=number, fault=why
            )
        else:
            await self._send("refused", what=kind, file=said.get("file", 0), why=why)

    async def _hello(self, said: Json) -> None:
        self.lang = said["lang"] if said.get("lang") in LANGUAGE_CODES else "en"
        say = Translator(self.lang)
        if not self.draft_owner:
            was = jobs.text_field(said, "was", 40) if "was" in said else ""
            self.draft_owner = self.workspace.register_owner(was)
            self.reconnected = self.draft_owner == was
        await self._send(
            "welcome",
            version=__version__,
            who=self.draft_owner,
            token=self.token,
            lang=self.lang,
            languages=words.language_codes(),
            texts=words.translated_texts(say),
            quantities=words.quantity_explanations(say),
            catalogue=words.shipped_joints_and_tubes(),
            longest=MAX_MESSAGE_BYTES,
            profiles=list(profiles()),
            missing=missing_libraries(),
            bracket_example=bracket_example(say),
            files=[p.name for p in self.workspace.files],
        )

    async def _pin(self, said: Json) -> None:
        number, variants = self._file_number(said), jobs.variants_field(said, "variants")
        with suppress(CardanError, OSError):
            await asyncio.to_thread(
                self.workspace.keep_variants, number, variants, by=self.draft_owner
            )
            await self._send("kept", file=number)

    async def _create(self, said: Json) -> None:
        title, text = jobs.text_field(said, "title", 300), jobs.text_field(said, "text")
        try:
            number = await asyncio.to_thread(self.workspace.create, title, text)
        except (CardanError, OSError) as error:
            await self._send("refused", what="create", file=0, why=self._error_text(error))
            return
        await self._send("files", files=[p.name for p in self.workspace.files])
        await self._open({"file": number})

    async def _open(self, said: Json) -> None:
        number = self._file_number(said)
        self._note_file_stamp(number)
        self._referenced_stamps = {}
        try:
            word = Translator(self.lang)("not saved")
            opened = await asyncio.to_thread(
                self.workspace.open, number, by=self.draft_owner, back=self.reconnected, word=word
            )
        except CardanError as error:
            why = f"{self.workspace.files[number].name}: {self._error_text(error)}"
            await self._send("refused", what="open", file=number, why=why)
            return
        self.file = number
        await self._send("opened", **opened)

    def _note_file_stamp(self, number: int) -> None:
        """Take note of how a file is on disk, before it is read."""
        self._file_stamp = self.workspace.files[number].stamp()

    async def _ask(self, said: Json) -> None:
        if self._delayed_verdict:
            self._delayed_verdict.cancel()
        for lane in (self.limits, self.slow):
            lane.clear()
        held = said.get("held") is True
        question = self._question(said, "held" if held else "live")
        self._latest_question = question["id"]
        self.quick.put(question)
        if held:
            self.limits.put({**question, "job": "graded"})

    async def _ask_pose(self, said: Json) -> None:
        self.quick.put(self._question(said, "pose"))

    async def _ask_help(self, said: Json) -> None:
        self.slow.put(self._question(said, "help"))

    async def _start(self, said: Json) -> None:
        job = said.get("job")
        if not isinstance(job, str) or job not in jobs.JOB_ARGUMENTS:
            raise InvalidMessageError
        if len(self._jobs) >= jobs.MAX_JOBS_PER_PAGE:
            await self._send(
                "done", id=jobs.integer_field(said, "id", 2**53), job=job, fault="too many"
            )
            return
        question = self._question(said, job)
        question["args"] = args = jobs.read_arguments(job, said.get("args"))
        if job in ("recording", "life"):
            if self.upload.complete_file is None:
                await self._send("done", id=question["id"], job=job, fault="nothing brought")
                return
            args["recording"] = self.upload.complete_file
        elif job == "report" and self.file is not None:
            with suppress(CardanError):
                print_ = await asyncio.to_thread(
                    self.workspace.file_fingerprint, self.file, question["text"]
                )
                args["print"] = print_
        elif job == "library":
            args |= {"folder": question["folder"], "texts": await self._texts()}
        elif files := args.pop("files", []):
            every = {row["file"]: row for row in await self._texts()}
            if first := every.get(self._file_number(said)):
                question |= {"text": first["text"], "name": first["name"]}
            args["same"] = False
            args["variants"] = [
                {"name": every[k]["name"], "text": every[k]["text"]} for k in files if k in every
            ]
        if job == "compare":
            texts = question["text"], *(v["text"] for v in args.get("variants", []))
            args["lives"] = [self._campaign_lives.get((text, self.lang), {}) for text in texts]
        number = question["id"]
        if number in self._jobs:
            raise InvalidMessageError
        task = self._jobs[number] = asyncio.create_task(self._run_job(question))
        task.add_done_callback(lambda _: self._jobs.pop(number, None))
        await asyncio.sleep(0)  # it begins: cancelled before, it would report nothing

    async def _bring(self, said: Json) -> None:
        await self._continue_upload(self.upload.begin, said)

    async def _piece(self, said: Json) -> None:
        await self._continue_upload(self.upload.append_chunk, said)

    async def _continue_upload(self, how: Callable[[Json], None], said: Json) -> None:
        """Go on with a recording, and report how much of it has come, or why none does."""
        try:
            await asyncio.to_thread(how, said)
        except (CardanError, OSError) as error:
            self.upload.close()
            await self._send("refused", what="bring", file=0, why=self._error_text(error))
            return
        p = self.upload
        await self._send("brought", id=p.id, name=p.name, got=p.received_bytes, size=p.size)

    async def _texts(self) -> list[Json]:
        """Return what the files of the workspace say, a draft before what is saved."""
        return await asyncio.to_thread(self.workspace.current_texts)

    async def _freeze(self, said: Json) -> None:
        number, text = self._file_number(said), jobs.text_field(said, "text")
        by, note = jobs.text_field(said, "by", 100), jobs.text_field(said, "note", 300)
        task = asyncio.create_task(self._release_revision(number, text, by, note))
        self._background_tasks.add(task)
        task.add_done_callback(self._background_tasks.discard)

    async def _release_revision(self, number: int, text: str, by: str, note: str) -> None:
        """Release a text, while a drag goes on: what it names may be gigabytes to be read."""
        try:
            found = await asyncio.to_thread(self.workspace.freeze, number, text, by=by, note=note)
        except (CardanError, OSError) as error:
            await self._send("refused", what="freeze", file=number, why=self._error_text(error))
            return
        await self._send("frozen", file=number, revisions=found)

    async def _cancel(self, said: Json) -> None:
        task = self._jobs.get(jobs.integer_field(said, "id", 2**53))
        if task:
            task.cancel()

    async def _run_job(self, question: Json) -> None:
        """Answer a job, part by part; cancelling a long one ends the process it is in."""
        which = {"id": question["id"], "job": question["job"]}

        async def part(told: Json) -> None:
            await self._send("part", **which, part=told)

        try:
            if question["job"] in jobs.JOBS_RUN_WITHOUT_QUEUE:
                answer = await asyncio.shield(self.workers.limits.ask(question, part))
            else:
                beside = question["job"] in jobs.JOBS_QUEUED_SEPARATELY_FOR_VIEWS and not question[
                    "args"
                ].get("sought")
                lane = self.workers.view_jobs if beside else self.workers.jobs
                answer = await lane.ask(question, part)
        except asyncio.CancelledError:
            await self._send("done", **which, fault="cancelled")
            return
        answer.pop("text", None)
        if lives := answer.get("lives"):
            self._campaign_lives[question["text"], question["lang"]] = lives
            for old in list(self._campaign_lives)[: -jobs.MAX_VARIANTS - 1]:
                del self._campaign_lives[old]
        await self._send("done", **which, **answer)

    async def _keep(self, said: Json) -> None:
        number, text = self._file_number(said), jobs.text_field(said, "text")
        base = jobs.text_field(said, "mark")
        try:
            await asyncio.to_thread(
                self.workspace.keep_draft, number, text, base, by=self.draft_owner
            )
        except (CardanError, OSError) as error:
            await self._send("refused", what="keep", file=number, why=self._error_text(error))
        else:
            await self._send("kept", file=number)

    async def _drop(self, said: Json) -> None:
        with suppress(OSError):
            await asyncio.to_thread(
                self.workspace.discard_draft, self._file_number(said), by=self.draft_owner
            )

    async def _save(self, said: Json) -> None:
        number, text = self._file_number(said), jobs.text_field(said, "text")
        base = jobs.text_field(said, "mark")
        try:
            new = await asyncio.to_thread(
                self.workspace.save, number, text, base, by=self.draft_owner
            )
        except EditConflictError:
            await self._send_disk_state(number, conflict=True)
        except (CardanError, OSError) as error:
            await self._send("refused", what="save", file=number, why=self._error_text(error))
        else:
            self._note_file_stamp(number)
            await self._send("saved", file=number, mark=new, text=text)

    # ------------------------------------------------------------------- what it receives

    async def _answer(self, lane: LatestOnlyQueue) -> None:
        while True:
            question, answer = await lane.get()
            job, text = question["job"], answer.get("text")
            if (beside := answer.pop("beside", None)) is not None:
                self._referenced_stamps = {Path(path): (*of,) for path, *of in beside}
            if job != "live":
                answer.pop("text", None)  # the page has one: no other is kept before it lets go
            if job in RESPONSE_KIND_BY_JOB:
                await self._send(RESPONSE_KIND_BY_JOB[job], id=question["id"], **answer)
            told = {"problems", "fault", "campaign"} & answer.keys()
            whole = job in ("live", "graded") and not told
            if whole and question["id"] == self._latest_question:
                later = {k: question[k] for k in ("id", "name", "folder", "lang")}
                later |= {"job": "full", "text": text}
                # A hand that moves on has not requested it: it would only be slowed down.
                self._delayed_verdict = asyncio.create_task(
                    self._put_after(later, VERDICT_DELAY_AFTER_EDIT_S * (job == "graded"))
                )
            # The likely next request: a drag, or a job.
            if job == "live" and self.workers.limits.pid is None:
                await self.workers.limits.start()
            if job == "full" and question["id"] == self._latest_question:
                self.limits.put({**question, "job": "ready"})
            if lane is self.slow:
                for later in (self.workers.jobs, self.workers.view_jobs):
                    if later.pid is None:
                        await later.start()

    async def _put_after(self, question: Json, after: float) -> None:
        await asyncio.sleep(after)
        self.slow.put(question)

    async def _watch(self) -> None:
        while True:
            await asyncio.sleep(DISK_POLL_INTERVAL_S)
            number = self.file
            if number is not None and self.workspace.files[number].stamp() != self._file_stamp:
                await self._send_disk_state(number, conflict=False)
            if number is not None and any(
                file_stamp(p) != of for p, of in self._referenced_stamps.items()
            ):
                self._referenced_stamps = {}  # until it is requested again
                self._campaign_lives.clear()
                await self._send("beside", file=number)

    async def _send_disk_state(self, number: int, *, conflict: bool) -> None:
        """Send the state of a file on disk now."""
        self._note_file_stamp(number)
        try:
            text = await asyncio.to_thread(self.workspace.files[number].read)
        except CardanError as error:
            gone = not self.workspace.files[number].path.exists()
            why = "is no longer there" if gone else self._error_text(error)
            await self._send("refused", what="read", file=number, why=why)
            return
        await self._send(
            "disk", file=number, text=text, mark=text_fingerprint(text), conflict=conflict
        )

    def _error_text(self, error: CardanError | OSError) -> str:
        """Return why a file could not be read or written, in the page's language."""
        said = (
            error_text_without_path(error)
            if isinstance(error, CardanError)
            else str(error.strerror)
        )
        return Translator(self.lang).with_minus_sign.error(said)

    async def _send(self, kind: str, **what: Any) -> None:
        data = json.dumps({"type": kind, **what}, ensure_ascii=False, separators=(",", ":"))
        data = data.encode("utf-8", "replace").decode()
        async with self._sending, asyncio.timeout(SEND_TIMEOUT_S):
            await self.socket.send_text(data)

    # ------------------------------------------------------------------- shapes

    def _file_number(self, said: Json) -> int:
        number = jobs.integer_field(said, "file", 2**53)
        if number >= len(self.workspace.files):
            raise InvalidMessageError
        return number

    def _question(self, said: Json, job: str) -> Json:
        """Return what the page requests, as a worker takes it: nothing else gets through."""
        question: Json = {
            "job": job,
            "id": jobs.integer_field(said, "id", 2**53),
            "text": jobs.text_field(said, "text"),
            "name": self.workspace.files[self.file].name
            if self.file is not None
            else "application",
            "folder": str(self.workspace.folder),
            "lang": self.lang,
            "pose": _pose_field(said.get("pose")),
        }
        if (drag := said.get("drag")) is not None:
            question["drag"] = _drag_field(drag)
        if (edits := said.get("edits")) is not None:
            question["edits"] = _edits_field(edits)
        if (want := said.get("want")) is not None:
            question["want"] = [
                w for w in ("curves", "turn") if isinstance(want, list) and w in want
            ]
        return question


def _pose_field(said: Any) -> Json:
    """Return a pose: of a line, in a state or where sliders have it."""
    if said is None:
        return {}
    if not isinstance(said, dict):
        raise InvalidMessageError
    most = {"line": 100, "state": 1000}
    pose: Json = {
        k: jobs.integer_field(said, k, below)
        for k, below in most.items()
        if said.get(k) is not None
    }
    for key in ("travel_mm", "torque_Nm"):
        if said.get(key) is not None:
            pose[key] = jobs.bounded_number(said[key], most=1e9)
    if said.get("way") is not None:
        if said["way"] not in get_args(DriveMode):
            raise InvalidMessageError
        pose["way"] = said["way"]
    return pose


def _drag_field(said: Any) -> Json:
    """Return a drag: what is held, and how far it has been moved, mm."""
    if not isinstance(said, dict) or said.get("kind") not in HANDLE_KINDS:
        raise InvalidMessageError
    by = said.get("by_mm")
    if not isinstance(by, list) or len(by) != 3:
        raise InvalidMessageError
    return {
        "kind": said["kind"],
        "number": jobs.integer_field(said, "number", 10_000),
        "line": jobs.text_field(said, "line"),
        "by_mm": [jobs.bounded_number(b, most=MAX_DRAG_MM) for b in by],
    }


def _edits_field(said: Any) -> Json:
    """Return edits: numbers, names or lists of numbers by their addresses."""
    if not isinstance(said, dict):
        raise InvalidMessageError
    found: Json = {}
    for at in jobs.list_field({"changes": [*said]}, "changes", 200):
        to = said[jobs.text_field({"address": at}, "address", 300)]
        if isinstance(to, list):
            found[at] = [jobs.bounded_number(t, most=1e12) for t in jobs.list_field(said, at, 20)]
        elif isinstance(to, str):
            found[at] = jobs.text_field(said, at, 300)
            if not to.isprintable():
                msg = f"{at} would hold an invisible character"
                raise MessageTooLargeError(msg)
        else:
            found[at] = jobs.bounded_number(to, most=1e12)
    return found

"""One socket: what a page asks, and what it is told, by messages of JSON.

    the page says                          it is told
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

from cardan import __version__
from cardan.base.errors import CardanError
from cardan.border.table import Stamp, stamp
from cardan.demand.points import Direction
from cardan.files.limit import names as profiles
from cardan.report.language import CODES, Language
from cardan.study.drag import KINDS
from cardan.web import jobs, words
from cardan.web.desk import Conflict, Desk, mark, readable
from cardan.web.jobs import TooMuch, Wrong
from cardan.web.lanes import Lanes, Latest
from cardan.web.parcel import Parcel

WATCH = 1.0
"""Seconds between looks at the disk."""

SLOWEST = 20.0
"""Seconds a page may take to accept a message."""

REST = 0.2
"""Seconds that a hand rests before the verdict is asked for."""

ANSWERS = {
    "live": "live", "held": "moved", "graded": "graded", "pose": "posed", "full": "full",
    "help": "helped",
}  # fmt: skip
"""What a page is told in answer to each question."""

ASKED = {"ask": "live", "pose": "posed", "help": "helped"}
"""What is told in answer to each of these messages."""

MESSAGE = 8_200_000
"""Bytes of a message: a text as long as a file may be, in letters of four bytes."""

FARTHEST = 1e5
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

    def __init__(self, socket: Socket, desk: Desk, lanes: Lanes, *, token: str) -> None:
        self.socket, self.desk, self.lanes, self.token = socket, desk, lanes, token
        self.quick, self.limits, self.slow = map(Latest, (lanes.quick, lanes.limits, lanes.slow))
        self._asked = 0
        self._aside = set[asyncio.Task[None]]()
        self._jobs: dict[int, asyncio.Task[None]] = {}
        self.parcel = Parcel()
        self.lang = "en"
        self.who, self.back = "", False
        """As whom this page keeps drafts, and whether it did so before it lost its socket."""
        self.file: int | None = None
        self._sending = asyncio.Lock()
        self._seen: Stamp = (0, 0, 0)
        self._rest: asyncio.Task[None] | None = None
        self._lived: dict[tuple[str, str], Json] = {}
        """Lives of campaigns that were asked, by text and language: to be held side by side."""
        self._beside: dict[Path, Stamp] = {}
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
            rest = (*loops, *self._aside, *self._jobs.values(), *filter(None, [self._rest]))
            for task in rest:
                task.cancel()
            await asyncio.gather(*rest, return_exceptions=True)
            self.desk.leave(self.who)
            self.parcel.close()

    # ------------------------------------------------------------------- what the page says

    async def _listen(self) -> None:
        while True:
            try:
                said = json.loads(await self.socket.receive_text())
            except (ValueError, RecursionError):
                raise Wrong from None
            if not isinstance(said, dict):
                raise Wrong
            await self._hear(said)

    async def _hear(self, said: Json) -> None:
        heard = {
            "hello": self._hello, "open": self._open, "ask": self._ask, "pose": self._ask_pose,
            "help": self._ask_help, "keep": self._keep, "drop": self._drop, "save": self._save,
            "create": self._create, "pin": self._pin, "freeze": self._freeze,
            "job": self._start, "cancel": self._cancel, "bring": self._bring, "piece": self._piece,
        }  # fmt: skip
        handle = heard.get(str(said.get("type")))
        if handle is None:
            raise Wrong
        try:
            if "bytes" in said:  # it stands for a message that is longer than any that is read
                size, most = jobs.number(said["bytes"], most=inf) / 1e6, MESSAGE / 1e6
                msg = (
                    f"what is asked takes {size:.0f} MB, more than the {most:.0f} MB that are read"
                )
                raise TooMuch(msg)
            await handle(said)
        except TooMuch as error:
            await self._refuse(said, Language(self.lang).typeset.error(str(error)))

    async def _refuse(self, said: Json, why: str) -> None:
        """Tell that something is not done, where its answer was waited for."""
        kind, number = said["type"], said.get("id")
        if kind == "job":
            await self._tell("done", id=number, job=said.get("job"), fault=why)
        elif kind in ASKED:
            held = kind == "ask" and said.get("held") is True
            await self._tell("moved" if held else ASKED[kind], id=number, fault=why)
        else:
            await self._tell("refused", what=kind, file=said.get("file", 0), why=why)

    async def _hello(self, said: Json) -> None:
        self.lang = said["lang"] if said.get("lang") in CODES else "en"
        say = Language(self.lang)
        if not self.who:
            was = jobs.text(said, "was", 40) if "was" in said else ""
            self.who = self.desk.enter(was)
            self.back = self.who == was
        await self._tell(
            "welcome",
            version=__version__,
            who=self.who,
            token=self.token,
            lang=self.lang,
            languages=words.languages(),
            texts=words.texts(say),
            quantities=words.quantities(say),
            catalogue=words.catalogue(),
            longest=MESSAGE,
            profiles=list(profiles()),
            files=[p.name for p in self.desk.papers],
        )

    async def _pin(self, said: Json) -> None:
        number, variants = self._number(said), jobs.texts(said, "variants")
        with suppress(CardanError, OSError):
            await asyncio.to_thread(self.desk.pin, number, variants, by=self.who)
            await self._tell("kept", file=number)

    async def _create(self, said: Json) -> None:
        title, text = jobs.text(said, "title", 300), jobs.text(said, "text")
        try:
            number = await asyncio.to_thread(self.desk.create, title, text)
        except (CardanError, OSError) as error:
            await self._tell("refused", what="create", file=0, why=self._why(error))
            return
        await self._tell("files", files=[p.name for p in self.desk.papers])
        await self._open({"file": number})

    async def _open(self, said: Json) -> None:
        number = self._number(said)
        self._look(number)
        self._beside = {}
        try:
            word = Language(self.lang)("not saved")
            opened = await asyncio.to_thread(
                self.desk.open, number, by=self.who, back=self.back, word=word
            )
        except CardanError as error:
            why = f"{self.desk.papers[number].name}: {self._why(error)}"
            await self._tell("refused", what="open", file=number, why=why)
            return
        self.file = number
        await self._tell("opened", **opened)

    def _look(self, number: int) -> None:
        """Take note of how a file is on disk, before it is read."""
        self._seen = self.desk.papers[number].stamp()

    async def _ask(self, said: Json) -> None:
        if self._rest:
            self._rest.cancel()
        for lane in (self.limits, self.slow):
            lane.drop()
        held = said.get("held") is True
        question = self._question(said, "held" if held else "live")
        self._asked = question["id"]
        self.quick.put(question)
        if held:
            self.limits.put({**question, "job": "graded"})

    async def _ask_pose(self, said: Json) -> None:
        self.quick.put(self._question(said, "pose"))

    async def _ask_help(self, said: Json) -> None:
        self.slow.put(self._question(said, "help"))

    async def _start(self, said: Json) -> None:
        job = said.get("job")
        if not isinstance(job, str) or job not in jobs.ARGUMENTS:
            raise Wrong
        if len(self._jobs) >= jobs.MOST:
            await self._tell("done", id=jobs.whole(said, "id", 2**53), job=job, fault="too many")
            return
        question = self._question(said, job)
        question["args"] = args = jobs.arguments(job, said.get("args"))
        if job in ("recording", "life"):
            if self.parcel.here is None:
                await self._tell("done", id=question["id"], job=job, fault="nothing brought")
                return
            args["recording"] = self.parcel.here
        elif job == "report" and self.file is not None:
            with suppress(CardanError):
                print_ = await asyncio.to_thread(self.desk.print_of, self.file, question["text"])
                args["print"] = print_
        elif job == "library":
            args |= {"folder": question["folder"], "texts": await self._texts()}
        elif files := args.pop("files", []):
            every = {row["file"]: row for row in await self._texts()}
            if first := every.get(self._number(said)):
                question |= {"text": first["text"], "name": first["name"]}
            args["same"] = False
            args["variants"] = [
                {"name": every[k]["name"], "text": every[k]["text"]} for k in files if k in every
            ]
        if job == "compare":
            texts = question["text"], *(v["text"] for v in args.get("variants", []))
            args["lives"] = [self._lived.get((text, self.lang), {}) for text in texts]
        number = question["id"]
        if number in self._jobs:
            raise Wrong
        task = self._jobs[number] = asyncio.create_task(self._work(question))
        task.add_done_callback(lambda _: self._jobs.pop(number, None))
        await asyncio.sleep(0)  # it begins: who is cancelled before would tell nobody

    async def _bring(self, said: Json) -> None:
        await self._bear(self.parcel.begin, said)

    async def _piece(self, said: Json) -> None:
        await self._bear(self.parcel.take, said)

    async def _bear(self, how: Callable[[Json], None], said: Json) -> None:
        """Go on with a recording, and tell how much of it has come, or why none does."""
        try:
            await asyncio.to_thread(how, said)
        except (CardanError, OSError) as error:
            self.parcel.close()
            await self._tell("refused", what="bring", file=0, why=self._why(error))
            return
        p = self.parcel
        await self._tell("brought", id=p.id, name=p.name, got=p.got, size=p.size)

    async def _texts(self) -> list[Json]:
        """Return what the files on the desk say, a draft before what is saved."""
        return await asyncio.to_thread(self.desk.texts)

    async def _freeze(self, said: Json) -> None:
        number, text = self._number(said), jobs.text(said, "text")
        by, note = jobs.text(said, "by", 100), jobs.text(said, "note", 300)
        task = asyncio.create_task(self._frozen(number, text, by, note))
        self._aside.add(task)
        task.add_done_callback(self._aside.discard)

    async def _frozen(self, number: int, text: str, by: str, note: str) -> None:
        """Freeze a text, while a hand goes on: what it names may be gigabytes to be read."""
        try:
            found = await asyncio.to_thread(self.desk.freeze, number, text, by=by, note=note)
        except (CardanError, OSError) as error:
            await self._tell("refused", what="freeze", file=number, why=self._why(error))
            return
        await self._tell("frozen", file=number, revisions=found)

    async def _cancel(self, said: Json) -> None:
        task = self._jobs.get(jobs.whole(said, "id", 2**53))
        if task:
            task.cancel()

    async def _work(self, question: Json) -> None:
        """Answer a job, part by part; who cancels one that takes long ends the process it is in."""
        which = {"id": question["id"], "job": question["job"]}

        async def part(told: Json) -> None:
            await self._tell("part", **which, part=told)

        try:
            if question["job"] in jobs.LIGHT:
                answer = await asyncio.shield(self.lanes.limits.ask(question, part))
            else:
                beside = question["job"] in jobs.BESIDE and not question["args"].get("sought")
                lane = self.lanes.beside if beside else self.lanes.work
                answer = await lane.ask(question, part)
        except asyncio.CancelledError:
            await self._tell("done", **which, fault="cancelled")
            return
        answer.pop("text", None)
        if lives := answer.get("lives"):
            self._lived[question["text"], question["lang"]] = lives
            for old in list(self._lived)[: -jobs.VARIANTS - 1]:
                del self._lived[old]
        await self._tell("done", **which, **answer)

    async def _keep(self, said: Json) -> None:
        number, text = self._number(said), jobs.text(said, "text")
        base = jobs.text(said, "mark")
        try:
            await asyncio.to_thread(self.desk.keep, number, text, base, by=self.who)
        except (CardanError, OSError) as error:
            await self._tell("refused", what="keep", file=number, why=self._why(error))
        else:
            await self._tell("kept", file=number)

    async def _drop(self, said: Json) -> None:
        with suppress(OSError):
            await asyncio.to_thread(self.desk.drop, self._number(said), by=self.who)

    async def _save(self, said: Json) -> None:
        number, text = self._number(said), jobs.text(said, "text")
        base = jobs.text(said, "mark")
        try:
            new = await asyncio.to_thread(self.desk.save, number, text, base, by=self.who)
        except Conflict:
            await self._tell_disk(number, conflict=True)
        except (CardanError, OSError) as error:
            await self._tell("refused", what="save", file=number, why=self._why(error))
        else:
            self._look(number)
            await self._tell("saved", file=number, mark=new, text=text)

    # ------------------------------------------------------------------- what it is told

    async def _answer(self, lane: Latest) -> None:
        while True:
            question, answer = await lane.take()
            job, text = question["job"], answer.get("text")
            if (beside := answer.pop("beside", None)) is not None:
                self._beside = {Path(path): (*of,) for path, *of in beside}
            if job != "live":
                answer.pop("text", None)  # the page has one: no other is kept before it lets go
            if job in ANSWERS:
                await self._tell(ANSWERS[job], id=question["id"], **answer)
            told = {"problems", "fault", "campaign"} & answer.keys()
            whole = job in ("live", "graded") and not told
            if whole and question["id"] == self._asked:
                later = {k: question[k] for k in ("id", "name", "folder", "lang")}
                later |= {"job": "full", "text": text}
                # A hand that moves on has not asked for it: it would only be slowed down.
                self._rest = asyncio.create_task(self._later(later, REST * (job == "graded")))
            # What is asked for next: a hand takes hold of it, or a job.
            if job == "live" and self.lanes.limits.pid is None:
                await self.lanes.limits.start()
            if job == "full" and question["id"] == self._asked:
                self.limits.put({**question, "job": "ready"})
            if lane is self.slow:
                for later in (self.lanes.work, self.lanes.beside):
                    if later.pid is None:
                        await later.start()

    async def _later(self, question: Json, after: float) -> None:
        await asyncio.sleep(after)
        self.slow.put(question)

    async def _watch(self) -> None:
        while True:
            await asyncio.sleep(WATCH)
            number = self.file
            if number is not None and self.desk.papers[number].stamp() != self._seen:
                await self._tell_disk(number, conflict=False)
            if number is not None and any(stamp(p) != of for p, of in self._beside.items()):
                self._beside = {}  # until it is asked again
                self._lived.clear()
                await self._tell("beside", file=number)

    async def _tell_disk(self, number: int, *, conflict: bool) -> None:
        """Tell what a file is on disk now."""
        self._look(number)
        try:
            text = await asyncio.to_thread(self.desk.papers[number].read)
        except CardanError as error:
            gone = not self.desk.papers[number].path.exists()
            why = "is no longer there" if gone else self._why(error)
            await self._tell("refused", what="read", file=number, why=why)
            return
        await self._tell("disk", file=number, text=text, mark=mark(text), conflict=conflict)

    def _why(self, error: CardanError | OSError) -> str:
        """Return why a file could not be read or written, in the page's language."""
        said = readable(error) if isinstance(error, CardanError) else str(error.strerror)
        return Language(self.lang).typeset.error(said)

    async def _tell(self, kind: str, **what: Any) -> None:
        data = json.dumps({"type": kind, **what}, ensure_ascii=False, separators=(",", ":"))
        data = data.encode("utf-8", "replace").decode()
        async with self._sending, asyncio.timeout(SLOWEST):
            await self.socket.send_text(data)

    # ------------------------------------------------------------------- shapes

    def _number(self, said: Json) -> int:
        number = jobs.whole(said, "file", 2**53)
        if number >= len(self.desk.papers):
            raise Wrong
        return number

    def _question(self, said: Json, job: str) -> Json:
        """Return what the page asks, as a worker takes it: nothing else gets through."""
        question: Json = {
            "job": job,
            "id": jobs.whole(said, "id", 2**53),
            "text": jobs.text(said, "text"),
            "name": self.desk.papers[self.file].name if self.file is not None else "application",
            "folder": str(self.desk.folder),
            "lang": self.lang,
            "pose": _pose(said.get("pose")),
        }
        if (drag := said.get("drag")) is not None:
            question["drag"] = _drag(drag)
        if (edits := said.get("edits")) is not None:
            question["edits"] = _edits(edits)
        if (want := said.get("want")) is not None:
            question["want"] = [
                w for w in ("curves", "turn") if isinstance(want, list) and w in want
            ]
        return question


def _pose(said: Any) -> Json:
    """Return a pose: of a line, in a state or where sliders have it."""
    if said is None:
        return {}
    if not isinstance(said, dict):
        raise Wrong
    most = {"line": 100, "state": 1000}
    pose: Json = {
        k: jobs.whole(said, k, below) for k, below in most.items() if said.get(k) is not None
    }
    for key in ("travel_mm", "torque_Nm"):
        if said.get(key) is not None:
            pose[key] = jobs.number(said[key], most=1e9)
    if said.get("way") is not None:
        if said["way"] not in get_args(Direction):
            raise Wrong
        pose["way"] = said["way"]
    return pose


def _drag(said: Any) -> Json:
    """Return a drag: what is held, and how far it has been moved, mm."""
    if not isinstance(said, dict) or said.get("kind") not in KINDS:
        raise Wrong
    by = said.get("by_mm")
    if not isinstance(by, list) or len(by) != 3:
        raise Wrong
    return {
        "kind": said["kind"],
        "number": jobs.whole(said, "number", 10_000),
        "line": jobs.text(said, "line"),
        "by_mm": [jobs.number(b, most=FARTHEST) for b in by],
    }


def _edits(said: Any) -> Json:
    """Return edits: numbers, names or lists of numbers by their addresses."""
    if not isinstance(said, dict):
        raise Wrong
    found: Json = {}
    for at in jobs.several({"changes": [*said]}, "changes", 200):
        to = said[jobs.text({"address": at}, "address", 300)]
        if isinstance(to, list):
            found[at] = [jobs.number(t, most=1e12) for t in jobs.several(said, at, 20)]
        elif isinstance(to, str):
            found[at] = jobs.text(said, at, 300)
            if not to.isprintable():
                msg = f"{at} would hold a character that nobody sees"
                raise TooMuch(msg)
        else:
            found[at] = jobs.number(to, most=1e12)
    return found

"""The desk: the files that were opened, their drafts, and what changes on disk meanwhile.

The file is the truth. What is edited and not saved lies as a draft in a folder of the
user's, not beside the file; it is there again after a crash, and gone once it is saved.
A browser names a file by its number here, never by a path.
"""

import json
import os
import re
import unicodedata
from contextlib import suppress
from dataclasses import dataclass
from datetime import date
from hashlib import sha256
from pathlib import Path
from shutil import rmtree
from typing import Any

from cardan import files
from cardan.base.errors import BadFile, CardanError, Problem
from cardan.border.document import text_of, visible
from cardan.border.table import Beside, Stamp, stamp
from cardan.border.writer import encoded, write
from cardan.files import campaign
from cardan.files.manuscript import Manuscript

HEAVIEST = 64_000_000
"""Bytes of the files that a revision keeps copies of."""
_END = re.compile(r"\r\n|\r|\n")
MOST = 500
"""Files of a folder that are listed."""
ENDS = (".yaml", ".yml")


def mark(text: str) -> str:
    """Return what tells a text from another."""
    return sha256(text.encode("utf-8", "surrogatepass")).hexdigest()[:32]


def plain(text: str) -> str:
    """Return a text with its lines ended as a browser's editor has them."""
    return _END.sub("\n", text)


def ended(text: str, like: str) -> str:
    """Return a plain text with its lines ended as another's: unchanged ones at either end as there.

    Those between end as most of the other's do.
    """
    ends = _END.findall(like)
    if set(ends) <= {"\n"}:
        return text
    usual = max(set(ends), key=ends.count)
    old, new = _END.split(like), text.split("\n")
    pairs = min(len(old), len(new))
    front = next((k for k in range(pairs) if old[k] != new[k]), pairs)
    back = next((k for k in range(pairs - front) if old[-1 - k] != new[-1 - k]), pairs - front)
    first, moved = len(new) - back, len(old) - len(new)
    said: list[str] = []
    for k, line in enumerate(new[:-1]):
        at = k if k < front else k + moved if k >= first else len(ends)
        said += line, (*ends[at : at + 1], usual)[0]
    return "".join(said) + new[-1]


@dataclass(eq=False)
class Paper:
    """A file on the desk."""

    path: Path
    name: str
    marked: bool = False
    """Whether it begins with a byte order mark, which stays."""
    like: str = ""
    """Whose line ends stay where it is gone."""

    def read(self) -> str:
        """Return its text as it is on disk, its lines ended as a browser's editor has them.

        Raises
        ------
        BadFile
            If it cannot be read.
        """
        if not self.path.exists():
            raise BadFile(self.name, (Problem(message="is no longer there"),))
        text = text_of(self.path)
        with suppress(OSError), self.path.open("rb") as file:
            self.marked = file.read(3) == b"\xef\xbb\xbf"
        self.like = "".join(_END.findall(text)[:1])
        return plain(text)

    def stamp(self) -> Stamp:
        """Return what tells it from what it was before."""
        return stamp(self.path)


class Conflict(CardanError):  # noqa: N818  the name is the news
    """A file is another on disk than the one that was edited."""


class Desk:
    """The files that a face may open, by number.

    Parameters
    ----------
    opened
        A file, or a folder whose application files are listed.
    drafts
        Where drafts lie.

    Raises
    ------
    BadFile
        If there is nothing to open.
    """

    def __init__(self, opened: Path, *, drafts: Path | None = None) -> None:
        self.drafts = drafts or draft_folder()
        self._keepers: dict[int, object] = {}
        """Who keeps the draft of a file, and is there still."""
        path = Path(os.path.realpath(opened))
        if path.is_dir():
            self.folder: Path = path
            found = sorted(
                p for p in path.iterdir()
                if p.suffix.lower() in ENDS and p.is_file() and self._inside(p)
            )[:MOST]  # fmt: skip
        else:
            text_of(path)  # refuses what is no file, and says why
            found, self.folder = [path], path.parent
        self.papers = [Paper(path=p, name=p.name) for p in found]

    def open(self, number: int) -> dict[str, Any]:
        """Return a file's text, and its draft where there is one."""
        paper = self.papers[number]
        text = paper.read()
        draft = self._draft(paper)
        return {
            "file": number,
            "name": paper.name,
            "saved": text,
            "mark": mark(text),
            "draft": draft["text"] if draft and draft["text"] != text else None,
            "stale": bool(draft and draft["mark"] != mark(text)),
            "variants": self._variants(paper),
            "revisions": self.revisions(number),
        }

    def texts(self) -> list[dict[str, Any]]:
        """Return what the files that can be read say, a draft before what is saved."""
        found: list[dict[str, Any]] = []
        for number, paper in enumerate(self.papers):
            with suppress(CardanError):
                saved, draft = paper.read(), self._draft(paper)
                text = draft["text"] if draft else saved
                found.append(
                    {"file": number, "name": paper.name, "text": text, "draft": text != saved}
                )
        return found

    # ------------------------------------------------------------------ revisions

    def freeze(self, number: int, text: str, *, by: str, note: str) -> list[dict[str, str]]:
        """Keep a text as a revision that nothing writes over, and return all of them.

        It lies in the folder `revisions` beside the file, headed by who froze it and when. What
        an application names of the folder is copied beside it, so that it says for good what
        it said.
        """
        paper, folder = self.papers[number], self.folder / "revisions"
        folder.mkdir(exist_ok=True)
        if not self._inside(folder):
            problem = Problem(message="revisions is a link that leads out of the folder")
            raise BadFile(paper.name, (problem,))
        # A character that nobody sees would make a revision that nobody can read.
        said = "; ".join(" ".join(s.split()) for s in map(visible, (by, note)) if s)
        head = f"# frozen {date.today().isoformat()}: {said}\n"
        encoded(paper.path, text)  # refused by its own lines
        named = self._named(paper, text)
        for k in range(1, MOST):
            path = folder / f"{paper.path.stem}.{k}.yaml"
            own = _copies(path)
            if path.exists():
                continue
            try:
                if named:
                    own.mkdir()  # nobody else's: ours from here on
            except FileExistsError:
                continue
            try:
                for file in {rest: file for _, rest, file in named}.items():
                    _copy(*file, own)
                edits = {at: f"{own.name}/{rest}" for at, rest, _ in named}
                held = Manuscript(text, paper.name).with_(edits) if edits else text
                write(path, head + held)
            except BaseException as error:
                if named:
                    rmtree(own, ignore_errors=True)
                if isinstance(error, BadFile) and path.exists():
                    continue  # somebody else's, meanwhile
                raise
            return self.revisions(number)
        raise BadFile(paper.name, (Problem(message=f"has {MOST} revisions already"),))

    def _named(self, paper: Paper, text: str) -> list[tuple[str, str, Path]]:
        """Return where a text names files of the folder, how they are called from there, and them.

        Recordings of a campaign are not meant: no verdict is approved of them.
        """
        beside: list[Beside] = []
        try:
            manuscript = Manuscript(text, paper.name)
            if campaign.title(manuscript) is None:
                files.loads(text, name=paper.name, folder=self.folder, warn=False, beside=beside)
        except CardanError:
            if not beside:
                return []  # what cannot be read is kept as it is
            manuscript = Manuscript(text, paper.name)
        found = {
            at: (os.path.normpath(b.path), b.path)
            for b in beside if b.path.is_file()
            for at in manuscript.addresses
            if (at == b.at or at.startswith(f"{b.at}[")) and manuscript.written(at) == b.name
        }  # fmt: skip
        size = sum(path.stat().st_size for _, path in found.values())
        if size > HEAVIEST:
            problem = Problem(
                message=f"names files of {size / 1e6:.0f} MB, and a revision keeps copies of "
                f"{HEAVIEST / 1e6:.0f} MB at most"
            )
            raise BadFile(paper.name, (problem,))
        return [
            (at, Path(os.path.relpath(told, self.folder)).as_posix(), path)
            for at, (told, path) in found.items()
        ]

    @staticmethod
    def _restored(path: Path, text: str) -> str:
        """Return the text of a revision with its copies called as from the folder."""
        own = _copies(path)
        if own.is_dir():
            with suppress(CardanError):
                manuscript, copies = Manuscript(text, path.name), f"{own.name}/"
                said = {at: manuscript.written(at) or "" for at in manuscript.addresses}
                return manuscript.with_(
                    {at: f"{path.parent.name}/{to}" for at, to in said.items()
                     if to.startswith(copies)}
                )  # fmt: skip
        return text

    def revisions(self, number: int) -> list[dict[str, str]]:
        """Return the revisions of a file, the last one first: name, what its head says, text."""
        paper = self.papers[number]
        found: list[tuple[int, dict[str, str]]] = []
        folder = self.folder / "revisions"
        for path in folder.glob("*.yaml") if folder.is_dir() else ():
            stem, _, k = path.stem.rpartition(".")
            if stem == paper.path.stem and k.isdecimal() and self._inside(path):
                with suppress(CardanError):
                    head, _, text = plain(text_of(path)).partition("\n")
                    text = self._restored(path, text)
                    told = head.removeprefix("# frozen ")
                    found.append((int(k), {"name": k, "said": told, "text": text}))
        return [row for _, row in sorted(found, key=lambda r: -r[0])[:20]]

    def pin(self, number: int, variants: list[dict[str, str]]) -> None:
        """Keep variants of a file, each a name and a text, beside its draft."""
        paper = self.papers[number]
        if not variants:
            self._place(paper, "variants").unlink(missing_ok=True)
            return
        self.drafts.mkdir(parents=True, exist_ok=True, mode=0o700)
        held = json.dumps({"file": str(paper.path), "variants": variants}, ensure_ascii=False)
        write(self._place(paper, "variants"), held, replace=True)

    def create(self, title: str, text: str) -> int:
        """Write a text into a new file, named after its title, and return its number.

        Raises
        ------
        BadFile
            If it cannot be written, or there are too many files.
        """
        if len(self.papers) >= MOST:
            problem = Problem(message=f"a folder with more than {MOST} files is not listed")
            raise BadFile(str(self.folder), (problem,))
        plain = unicodedata.normalize("NFKD", title).encode("ascii", "ignore").decode().lower()
        stem = re.sub(r"[^a-z0-9]+", "-", plain).strip("-")[:40] or "driveline"
        names = (f"{stem}{f'-{k}' if k else ''}.yaml" for k in range(MOST))
        for path in (self.folder / name for name in names):
            if path.exists():
                continue
            try:
                write(path, text)
            except BadFile:
                if path.exists():  # somebody else's, meanwhile
                    continue
                raise
            self.papers.append(Paper(path=path, name=path.name))
            return len(self.papers) - 1
        raise BadFile(str(self.folder), (Problem(message=f"has {MOST} files named {stem}"),))

    def keep(self, number: int, text: str, base: str, *, by: object = None) -> None:
        """Keep an unsaved text; `base` marks the file's text that it was edited from.

        It is theirs `by` whom it is kept, until they leave: nobody else throws it away.
        """
        paper = self.papers[number]
        self.drafts.mkdir(parents=True, exist_ok=True, mode=0o700)
        held = {"file": str(paper.path), "mark": base, "text": text}
        write(self._place(paper), json.dumps(held), replace=True)  # half a letter too
        self._keepers[number] = by

    def drop(self, number: int, *, by: object = None) -> None:
        """Keep nothing of an unsaved text, unless it is somebody else's."""
        if self._keepers.get(number) in (None, by):
            self._keepers.pop(number, None)
            self._place(self.papers[number]).unlink(missing_ok=True)

    def leave(self, by: object) -> None:
        """Leave drafts behind, to whoever comes next."""
        self._keepers = {n: who for n, who in self._keepers.items() if who is not by}

    def save(self, number: int, text: str, base: str, *, by: object = None) -> str:
        """Write a text into its file, and return its mark.

        Raises
        ------
        Conflict
            If the file is another than the one marked `base`: nothing is written.
        BadFile
            If it cannot be written.
        """
        paper, text = self.papers[number], plain(text)
        if paper.path.exists() and mark(paper.read()) != base:  # what is gone is written anew
            msg = f"{paper.name} was changed on disk meanwhile"
            raise Conflict(msg)
        write(paper.path, self._whole(paper, text), replace=True)
        self.drop(number, by=by)
        return mark(text)

    def print_of(self, number: int, text: str) -> str:
        """Return the fingerprint that a text has in its file, where reports by command look."""
        whole = self._whole(self.papers[number], plain(text))
        return sha256(whole.encode("utf-8", "surrogatepass")).hexdigest()[:16]

    @staticmethod
    def _whole(paper: Paper, text: str) -> str:
        """Return a plain text as it stands in its file: with its mark and its ends of lines."""
        like = text_of(paper.path) if paper.path.exists() else paper.like
        return ("\ufeff" if paper.marked else "") + ended(text, like)

    def _inside(self, path: Path) -> bool:
        """Return whether a path stays in the folder, wherever links lead."""
        return Path(os.path.realpath(path)).is_relative_to(self.folder)

    def _draft(self, paper: Paper) -> dict[str, str] | None:
        held = self._held(paper, "draft")
        return held if held and isinstance(held.get("text"), str) else None

    def _variants(self, paper: Paper) -> list[dict[str, str]]:
        held = self._held(paper, "variants")
        found = held.get("variants") if held else None
        rows = found if isinstance(found, list) else []
        return [
            {"name": row["name"], "text": row["text"]} for row in rows
            if isinstance(row, dict) and all(isinstance(row.get(k), str) for k in ("name", "text"))
        ]  # fmt: skip

    def _held(self, paper: Paper, what: str) -> dict[str, Any] | None:
        """Return what is kept of a file; nothing where it is broken, or another file's."""
        try:
            held = json.loads(self._place(paper, what).read_text(encoding="utf-8"))
        except (OSError, ValueError, RecursionError):
            return None
        whole = isinstance(held, dict) and held.get("file") == str(paper.path)
        return held if whole else None

    def _place(self, paper: Paper, what: str = "draft") -> Path:
        name = sha256(os.fsencode(paper.path)).hexdigest()[:32]
        return self.drafts / f"{name}{'' if what == 'draft' else '.' + what}.json"


def _copies(path: Path) -> Path:
    """Return the folder of what a revision keeps beside it."""
    return path.with_name(f"{path.stem}.files")


def _copy(rest: str, file: Path, into: Path) -> None:
    """Copy a file into a folder, under the name it had from its own."""
    target = into / rest
    target.parent.mkdir(parents=True, exist_ok=True)
    write(target, file.read_bytes())


def draft_folder() -> Path:
    """Return where this user's drafts lie, as the system has it."""
    if os.name == "nt":
        base = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData/Local")
    else:
        base = Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local/state")
    return base / "cardan" / "drafts"


def readable(error: CardanError) -> str:
    """Return why a file could not be read or written, without the path that leads to it."""
    if isinstance(error, BadFile):
        return "; ".join(p.message + (f"; {p.hint}" if p.hint else "") for p in error.problems)
    return str(error)

"""The desk: the files that were opened, their drafts, and what changes on disk meanwhile.

The file is the truth. What is edited and not saved lies as a draft in a folder of the
user's, not beside the file; it is there again after a crash, and gone once it is saved.
A browser names a file by its number here, never by a path.
"""

import json
import os
import re
import secrets
import unicodedata
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from hashlib import sha256
from pathlib import Path
from typing import Any

from cardan.base.errors import BadFile, CardanError, Problem
from cardan.border.document import text_of
from cardan.border.table import Stamp, stamp
from cardan.border.writer import write
from cardan.web import revisions
from cardan.web.jobs import VARIANTS

_END = re.compile(r"\r\n|\r|\n")
MOST = 500
"""Files of a folder that are listed."""
ENDS = (".yaml", ".yml")
_NAME = re.compile("[0-9a-f]{16}")
"""As what somebody keeps drafts."""


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
        self._there = set[str]()
        """Who keeps drafts, each his own, and is there still."""
        self._left: dict[tuple[int, str], list[Path]] = {}
        """Drafts that others left, by the file and by whom they were seen among its variants."""
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

    def enter(self, was: str = "") -> str:
        """Return as whom a page keeps drafts: as before, unless somebody else is that by now."""
        known = _NAME.fullmatch(was) and was not in self._there
        who = was if known else secrets.token_hex(8)
        self._there.add(who)
        return who

    def leave(self, by: str) -> None:
        """Leave drafts behind, to whoever comes next."""
        self._there.discard(by)

    def open(
        self, number: int, *, by: str = "", back: bool = False, word: str = ""
    ) -> dict[str, Any]:
        """Return a file's text, and what was not saved of it by those who went.

        The last such draft is theirs `by` whom it is opened from now on; the others stand among
        the variants, each by a `word` and when it was kept. Who comes `back` has a text already.
        Where nobody left any, the last of somebody who is there is shown.
        """
        paper = self.papers[number]
        text = paper.read()
        drafts = [d for d in self._drafts(paper) if d["text"] != text]
        left = [d for d in drafts if d["by"] not in self._there and d["by"] != by]
        mine = next((d for d in drafts if d["by"] == by), None)
        if mine is None and left and not back:
            mine = left.pop(0)
            mine["path"].replace(self._place(paper, by))
        draft = mine or next(iter(drafts), None)
        variants = self._variants(paper)
        pinned = {v["text"] for v in variants}
        new = [d for d in left if d["text"] not in pinned and draft and d["text"] != draft["text"]]
        new = new[: VARIANTS - len(variants)]
        variants += ({"name": f"{word} {d['when']}".strip(), "text": d["text"]} for d in new)
        shown = {v["text"] for v in variants}
        self._left[number, by] = [d["path"] for d in left if d["text"] in shown]
        return {
            "file": number,
            "name": paper.name,
            "saved": text,
            "mark": mark(text),
            "draft": draft["text"] if draft else None,
            "stale": bool(draft and draft["mark"] != mark(text)),
            "base": str(draft["mark"]) if draft else "",
            "elsewhere": draft is not None and draft is not mine,
            "left": len(new),
            "variants": variants,
            "revisions": self.revisions(number),
        }

    def texts(self) -> list[dict[str, Any]]:
        """Return what the files that can be read say, a draft before what is saved."""
        found: list[dict[str, Any]] = []
        for number, paper in enumerate(self.papers):
            with suppress(CardanError):
                saved, drafts = paper.read(), self._drafts(paper)
                text = drafts[0]["text"] if drafts else saved
                found.append(
                    {"file": number, "name": paper.name, "text": text, "draft": text != saved}
                )
        return found

    def freeze(self, number: int, text: str, *, by: str, note: str) -> list[dict[str, str]]:
        """Keep a text as a revision of a file, and return all of them."""
        revisions.freeze(self.papers[number].path, text, by=by, note=note)
        return self.revisions(number)

    def revisions(self, number: int) -> list[dict[str, str]]:
        """Return the revisions of a file, the last one first: name, what its head says, text."""
        return revisions.listed(self.papers[number].path)

    def pin(self, number: int, variants: list[dict[str, str]], *, by: str = "") -> None:
        """Keep variants of a file, each a name and a text, beside its drafts.

        A draft that somebody left, was shown among them, and is not there any more is thrown away.
        """
        paper, texts = self.papers[number], {v["text"] for v in variants}
        for path in self._left.get((number, by), []):
            if (held := _held(path, paper)) and held.get("text") not in texts:
                path.unlink(missing_ok=True)
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

    def keep(self, number: int, text: str, base: str, *, by: str = "") -> None:
        """Keep an unsaved text, apart from all others'; `base` marks what it was edited from."""
        paper = self.papers[number]
        self.drafts.mkdir(parents=True, exist_ok=True, mode=0o700)
        held = {"file": str(paper.path), "mark": base, "text": text}
        write(self._place(paper, by), json.dumps(held), replace=True)  # half a letter too

    def drop(self, number: int, *, by: str = "") -> None:
        """Keep nothing of one's own unsaved text."""
        self._place(self.papers[number], by).unlink(missing_ok=True)

    def save(self, number: int, text: str, base: str, *, by: str = "") -> str:
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

    def _drafts(self, paper: Paper) -> list[dict[str, Any]]:
        """Return the drafts of a file, the last one first: text, mark, by whom, when and where."""
        found: list[tuple[int, dict[str, Any]]] = []
        stem = self._place(paper).stem
        for path in self.drafts.glob(f"{stem}*.json"):
            by = path.stem.removeprefix(stem).removeprefix(".")
            with suppress(OSError):
                held, when = _held(path, paper), path.stat().st_mtime_ns
                if held and by != "variants" and isinstance(held.get("text"), str):
                    said = datetime.fromtimestamp(when / 1e9).strftime("%Y-%m-%d %H:%M:%S")
                    mark = held.get("mark")
                    found.append(
                        (
                            when,
                            {
                                "text": held["text"],
                                "mark": mark,
                                "by": by,
                                "when": said,
                                "path": path,
                            },
                        )
                    )
        return [row for _, row in sorted(found, key=lambda r: -r[0])]

    def _variants(self, paper: Paper) -> list[dict[str, str]]:
        held = _held(self._place(paper, "variants"), paper)
        found = held.get("variants") if held else None
        rows = found if isinstance(found, list) else []
        return [
            {"name": row["name"], "text": row["text"]} for row in rows
            if isinstance(row, dict) and all(isinstance(row.get(k), str) for k in ("name", "text"))
        ]  # fmt: skip

    def _place(self, paper: Paper, what: str = "") -> Path:
        """Return where something of a file is kept: its variants, or somebody's draft."""
        name = sha256(os.fsencode(paper.path)).hexdigest()[:32]
        return self.drafts / f"{name}{what and '.' + what}.json"


def _held(path: Path, paper: Paper) -> dict[str, Any] | None:
    """Return what is kept of a file; nothing where it is broken, or another file's."""
    try:
        held = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    whole = isinstance(held, dict) and held.get("file") == str(paper.path)
    return held if whole else None


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

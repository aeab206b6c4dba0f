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
from typing import Any

from cardan.base.errors import BadFile, CardanError, Problem
from cardan.border.document import text_of, visible
from cardan.border.writer import write

MOST = 500
"""Files of a folder that are listed."""
ENDS = (".yaml", ".yml")


def mark(text: str) -> str:
    """Return what tells a text from another."""
    return sha256(text.encode("utf-8", "surrogatepass")).hexdigest()[:32]


@dataclass(eq=False)
class Paper:
    """A file on the desk."""

    path: Path
    name: str
    marked: bool = False
    """Whether it begins with a byte order mark, which stays."""

    def read(self) -> str:
        """Return its text as it is on disk.

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
        return text

    def stamp(self) -> tuple[int, int]:
        """Return when it was last changed, and how long it is: another where it is another."""
        try:
            status = self.path.stat()
        except OSError:
            return 0, -1
        return status.st_mtime_ns, status.st_size


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

        It lies in the folder `revisions` beside the file, headed by who froze it and when.
        """
        paper, folder = self.papers[number], self.folder / "revisions"
        folder.mkdir(exist_ok=True)
        if not self._inside(folder):
            problem = Problem(message="revisions is a link that leads out of the folder")
            raise BadFile(paper.name, (problem,))
        # A character that nobody sees would make a revision that nobody can read.
        said = "; ".join(" ".join(s.split()) for s in map(visible, (by, note)) if s)
        head = f"# frozen {date.today().isoformat()}: {said}\n"
        for k in range(1, MOST):
            path = folder / f"{paper.path.stem}.{k}.yaml"
            with suppress(FileExistsError):
                path.touch(exist_ok=False)
                write(path, head + text, replace=True)
                return self.revisions(number)
        raise BadFile(paper.name, (Problem(message=f"has {MOST} revisions already"),))

    def revisions(self, number: int) -> list[dict[str, str]]:
        """Return the revisions of a file, the last one first: name, what its head says, text."""
        paper = self.papers[number]
        found: list[tuple[int, dict[str, str]]] = []
        folder = self.folder / "revisions"
        for path in folder.glob("*.yaml") if folder.is_dir() else ():
            stem, _, k = path.stem.rpartition(".")
            if stem == paper.path.stem and k.isdecimal() and self._inside(path):
                with suppress(CardanError):
                    head, _, text = text_of(path).partition("\n")
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
            with suppress(FileExistsError):
                path.touch(exist_ok=False)  # nobody else's: ours from here on
                write(path, text, replace=True)
                self.papers.append(Paper(path=path, name=path.name))
                return len(self.papers) - 1
        raise BadFile(str(self.folder), (Problem(message=f"has {MOST} files named {stem}"),))

    def keep(self, number: int, text: str, base: str) -> None:
        """Keep an unsaved text; `base` marks the file's text that it was edited from."""
        paper = self.papers[number]
        self.drafts.mkdir(parents=True, exist_ok=True, mode=0o700)
        held = {"file": str(paper.path), "mark": base, "text": text}
        write(self._place(paper), json.dumps(held, ensure_ascii=False), replace=True)

    def drop(self, number: int) -> None:
        """Keep nothing of an unsaved text."""
        self._place(self.papers[number]).unlink(missing_ok=True)

    def save(self, number: int, text: str, base: str) -> str:
        """Write a text into its file, and return its mark.

        Raises
        ------
        Conflict
            If the file is another than the one marked `base`: nothing is written.
        BadFile
            If it cannot be written.
        """
        paper = self.papers[number]
        if paper.path.exists() and mark(paper.read()) != base:  # what is gone is written anew
            msg = f"{paper.name} was changed on disk meanwhile"
            raise Conflict(msg)
        head = "\ufeff" if paper.marked else ""
        write(paper.path, head + text, replace=True)
        self.drop(number)
        return mark(text)

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

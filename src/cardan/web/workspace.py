"""The workspace: the files that were opened, their drafts, and what changes on disk meanwhile.

The file is the truth. What is edited and not saved lies as a draft in a folder of the
user's, not next to the file; it is there again after a crash, and gone once it is saved.
A browser names a file by its number here, never by a path.
"""

import json
import os
import re
import secrets
import unicodedata
from collections.abc import Generator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import datetime
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from threading import RLock
from typing import Any

from cardan.core.errors import CardanError, FileIssue, InvalidFileError
from cardan.schema.atomic_write import check_within, write_atomically
from cardan.schema.node_reader import FileChangeStamp, file_stamp
from cardan.schema.yaml_tree import read_text
from cardan.web import revisions
from cardan.web.jobs import MAX_VARIANTS

_LINE_END = re.compile(r"\r\n|\r|\n")
MAX_FILES = 500
"""Files of a folder that are listed."""
FILE_SUFFIXES = (".yaml", ".yml")
_OWNER_PATTERN = re.compile("[0-9a-f]{16}")
"""As what a page keeps drafts."""


def text_fingerprint(text: str) -> str:
    """Return what distinguishes a text from another."""
    return sha256(text.encode("utf-8", "surrogatepass")).hexdigest()[:32]


def normalise_line_ends(text: str) -> str:
    """Return a text with its lines ended as a browser's editor has them."""
    return _LINE_END.sub("\n", text)


def restore_line_ends(text: str, like: str) -> str:
    """Return a plain text with its lines ended as another's: unchanged ones at either end as there.

    Those between end as most of the other's do.
    """
    ends = _LINE_END.findall(like)
    if set(ends) <= {"\n"}:
        return text
    usual = max(set(ends), key=ends.count)
    old, new = _LINE_END.split(like), text.split("\n")
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
class OpenFile:
    """A file of the workspace."""

    path: Path
    name: str
    folder: Path
    """Where links must not lead out of, whenever it is read or written."""
    has_bom: bool = False
    """Whether it begins with a byte order mark, which stays."""
    line_end: str = ""
    """Whose line ends stay where it is gone."""

    def read(self) -> str:
        """Return its text as it is on disk, its lines ended as a browser's editor has them.

        Raises
        ------
        InvalidFileError
            If it cannot be read, or is a link out of its folder by now.
        """
        if not self.path.exists():
            raise InvalidFileError(self.name, (FileIssue(message="is no longer there"),))
        target = Path(os.path.realpath(self.path))
        check_within(self.path, target, self.folder)
        text = read_text(target)
        with suppress(OSError), target.open("rb") as file:
            self.has_bom = file.read(3) == b"\xef\xbb\xbf"
        self.line_end = "".join(_LINE_END.findall(text)[:1])
        return normalise_line_ends(text)

    def stamp(self) -> FileChangeStamp:
        """Return what distinguishes it from what it was before."""
        return file_stamp(self.path)


class EditConflictError(CardanError):
    """A file is another on disk than the one that was edited."""


class Workspace:
    """The files that a face may open, by number.

    Parameters
    ----------
    opened
        A file, or a folder whose application files are listed.
    drafts
        Where drafts lie.

    Raises
    ------
    InvalidFileError
        If there is nothing to open.
    """

    def __init__(self, opened: Path, *, drafts: Path | None = None) -> None:
        self.drafts = drafts or draft_folder()
        self._lock = RLock()
        """Held from what is read of the disk until what follows from it is written."""
        self._present_owners = set[str]()
        """Pages that keep drafts of their own, and are still open."""
        self._abandoned_drafts: dict[tuple[int, str], list[Path]] = {}
        """Drafts that others left, by the file and by whom they were seen among its variants."""
        path = Path(os.path.realpath(opened))
        if path.is_dir():
            self.folder: Path = path
            found = sorted(
                p for p in path.iterdir()
                if p.suffix.lower() in FILE_SUFFIXES and p.is_file() and self._is_inside(p)
            )[:MAX_FILES]  # fmt: skip
        else:
            read_text(path)  # refuses what is no file, and says why
            found, self.folder = [path], path.parent
        self.files = [OpenFile(path=p, name=p.name, folder=self.folder) for p in found]

    def register_owner(self, was: str = "") -> str:
        """Return as whom a page keeps drafts: as before, unless another page is that by now."""
        known = _OWNER_PATTERN.fullmatch(was) and was not in self._present_owners
        who = was if known else secrets.token_hex(8)
        self._present_owners.add(who)
        return who

    def release_owner(self, by: str) -> None:
        """Leave drafts behind, to the next page that opens them."""
        self._present_owners.discard(by)

    def open(
        self, number: int, *, by: str = "", back: bool = False, word: str = ""
    ) -> dict[str, Any]:
        """Return a file's text, and what was not saved of it by closed pages.

        The last such draft belongs to the page `by` that opens it from now on; the others stand
        among the variants, each by a `word` and when it was kept. A page that comes `back` has a
        text already. If none was left, the last of a page still open is shown.
        """
        paper = self.files[number]
        text = paper.read()
        with self._lock:
            drafts = [d for d in self._drafts(paper) if d["text"] != text]
            left = [d for d in drafts if d["by"] not in self._present_owners and d["by"] != by]
            mine = next((d for d in drafts if d["by"] == by), None)
            if mine is None and left and not back:
                mine = left.pop(0)
                mine["path"].replace(self._stored_path(paper, by))
        draft = mine or next(iter(drafts), None)
        variants = self._variants(paper)
        pinned = {v["text"] for v in variants}
        new = [d for d in left if d["text"] not in pinned and draft and d["text"] != draft["text"]]
        new = new[: MAX_VARIANTS - len(variants)]
        variants += ({"name": f"{word} {d['when']}".strip(), "text": d["text"]} for d in new)
        shown = {v["text"] for v in variants}
        self._abandoned_drafts[number, by] = [d["path"] for d in left if d["text"] in shown]
        return {
            "file": number,
            "name": paper.name,
            "saved": text,
            "mark": text_fingerprint(text),
            "draft": draft["text"] if draft else None,
            "stale": bool(draft and draft["mark"] != text_fingerprint(text)),
            "base": str(draft["mark"]) if draft else "",
            "elsewhere": draft is not None and draft is not mine,
            "left": len(new),
            "variants": variants,
            "revisions": self.revisions(number),
        }

    def current_texts(self) -> list[dict[str, Any]]:
        """Return what the files that can be read say, a draft before what is saved."""
        found: list[dict[str, Any]] = []
        for number, paper in enumerate(self.files):
            with suppress(CardanError):
                saved, drafts = paper.read(), self._drafts(paper)
                text = drafts[0]["text"] if drafts else saved
                found.append(
                    {"file": number, "name": paper.name, "text": text, "draft": text != saved}
                )
        return found

    def freeze(self, number: int, text: str, *, by: str, note: str) -> list[dict[str, str]]:
        """Keep a text as a revision of a file, and return all of them."""
        revisions.release_revision(self.files[number].path, text, by=by, note=note)
        return self.revisions(number)

    def revisions(self, number: int) -> list[dict[str, str]]:
        """Return the revisions of a file, the last one first: name, what its head says, text."""
        return revisions.list_revisions(self.files[number].path)

    def keep_variants(self, number: int, variants: list[dict[str, str]], *, by: str = "") -> None:
        """Keep variants of a file, each a name and a text, next to its drafts.

        A draft that a page left, was shown among them, and is not there any more is thrown away.
        """
        paper, texts = self.files[number], {v["text"] for v in variants}
        for path in self._abandoned_drafts.get((number, by), []):
            if (held := _read_stored(path, paper)) and held.get("text") not in texts:
                path.unlink(missing_ok=True)
        if not variants:
            self._stored_path(paper, "variants").unlink(missing_ok=True)
            return
        self.drafts.mkdir(parents=True, exist_ok=True, mode=0o700)
        held = json.dumps({"file": str(paper.path), "variants": variants}, ensure_ascii=False)
        write_atomically(self._stored_path(paper, "variants"), held, replace=True)

    def create(self, title: str, text: str) -> int:
        """Write a text into a new file, named after its title, and return its number.

        Raises
        ------
        InvalidFileError
            If it cannot be written, or there are too many files.
        """
        if len(self.files) >= MAX_FILES:
            problem = FileIssue(message=f"a folder with more than {MAX_FILES} files is not listed")
            raise InvalidFileError(str(self.folder), (problem,))
        plain = unicodedata.normalize("NFKD", title).encode("ascii", "ignore").decode().lower()
        stem = re.sub(r"[^a-z0-9]+", "-", plain).strip("-")[:40] or "driveline"
        names = (f"{stem}{f'-{k}' if k else ''}.yaml" for k in range(MAX_FILES))
        for path in (self.folder / name for name in names):
            if path.exists():
                continue
            try:
                write_atomically(path, text, within=self.folder)
            except InvalidFileError:
                if path.exists():  # another process's, meanwhile
                    continue
                raise
            with self._lock:
                self.files.append(OpenFile(path=path, name=path.name, folder=self.folder))
                return len(self.files) - 1
        raise InvalidFileError(
            str(self.folder), (FileIssue(message=f"has {MAX_FILES} files named {stem}"),)
        )

    def keep_draft(self, number: int, text: str, base: str, *, by: str = "") -> None:
        """Keep an unsaved text, apart from all others'; `base` marks what it was edited from."""
        paper = self.files[number]
        self.drafts.mkdir(parents=True, exist_ok=True, mode=0o700)
        held = {"file": str(paper.path), "mark": base, "text": text}
        write_atomically(
            self._stored_path(paper, by), json.dumps(held), replace=True
        )  # half a letter too

    def discard_draft(self, number: int, *, by: str = "") -> None:
        """Keep nothing of one's own unsaved text."""
        self._stored_path(self.files[number], by).unlink(missing_ok=True)

    def save(self, number: int, text: str, base: str, *, by: str = "") -> str:
        """Write a text into its file, and return its mark.

        Raises
        ------
        EditConflictError
            If the file is another than the one marked `base`: nothing is written.
        InvalidFileError
            If it cannot be written.
        """
        paper, text = self.files[number], normalise_line_ends(text)
        with self._lock, _locked_folder(paper.path.parent):
            if (
                paper.path.exists() and text_fingerprint(paper.read()) != base
            ):  # what is gone is written anew
                msg = f"{paper.name} was changed on disk meanwhile"
                raise EditConflictError(msg)
            whole = self._file_text(paper, text)
            write_atomically(paper.path, whole, replace=True, within=self.folder)
        self.discard_draft(number, by=by)
        return text_fingerprint(text)

    def file_fingerprint(self, number: int, text: str) -> str:
        """Return the fingerprint that a text has in its file, where reports by command look."""
        whole = self._file_text(self.files[number], normalise_line_ends(text))
        return sha256(whole.encode("utf-8", "surrogatepass")).hexdigest()[:16]

    @staticmethod
    def _file_text(paper: OpenFile, text: str) -> str:
        """Return a plain text as it stands in its file: with its mark and its ends of lines."""
        like = read_text(paper.path) if paper.path.exists() else paper.line_end
        return ("\ufeff" if paper.has_bom else "") + restore_line_ends(text, like)

    def _is_inside(self, path: Path) -> bool:
        """Return whether a path stays in the folder, wherever links lead."""
        return Path(os.path.realpath(path)).is_relative_to(self.folder)

    def _drafts(self, paper: OpenFile) -> list[dict[str, Any]]:
        """Return the drafts of a file, the last one first: text, mark, by whom, when and where."""
        found: list[tuple[int, dict[str, Any]]] = []
        stem = self._stored_path(paper).stem
        for path in self.drafts.glob(f"{stem}*.json"):
            by = path.stem.removeprefix(stem).removeprefix(".")
            with suppress(OSError):
                held, when = _read_stored(path, paper), path.stat().st_mtime_ns
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

    def _variants(self, paper: OpenFile) -> list[dict[str, str]]:
        held = _read_stored(self._stored_path(paper, "variants"), paper)
        found = held.get("variants") if held else None
        rows = found if isinstance(found, list) else []
        return [
            {"name": row["name"], "text": row["text"]} for row in rows
            if isinstance(row, dict) and all(isinstance(row.get(k), str) for k in ("name", "text"))
        ]  # fmt: skip

    def _stored_path(self, paper: OpenFile, what: str = "") -> Path:
        """Return where something of a file is kept: its variants, or a page's draft."""
        name = sha256(os.fsencode(paper.path)).hexdigest()[:32]
        return self.drafts / f"{name}{what and '.' + what}.json"


@contextmanager
def _locked_folder(folder: Path) -> Generator[None, None, None]:
    """Keep another server of this computer from saving in a folder; nothing where none can.

    Windows and some network disks lock no folders.
    """
    try:
        lock, descriptor = import_module("fcntl"), os.open(folder, os.O_RDONLY)
    except (ModuleNotFoundError, OSError):
        yield
        return
    try:
        with suppress(OSError):
            lock.flock(descriptor, lock.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def _read_stored(path: Path, paper: OpenFile) -> dict[str, Any] | None:
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


def error_text_without_path(error: CardanError) -> str:
    """Return why a file could not be read or written, without the path that leads to it."""
    if isinstance(error, InvalidFileError):
        return "; ".join(p.message + (f"; {p.hint}" if p.hint else "") for p in error.problems)
    return str(error)

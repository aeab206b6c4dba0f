"""How results get into files: whole or not at all, and never over what they were made from.

A file that is replaced keeps its permissions, a link keeps pointing where it points, and
what is no regular file, a pipe or a terminal, is written into and stays what it is. What
is written appears at once under its name: until then it stands next to it as a part, whose
name says who is writing it.
"""

import errno
import os
import re
import stat
import time
import unicodedata
import zlib
from collections.abc import Iterable, Mapping
from contextlib import suppress
from functools import cache
from pathlib import Path

from cardan.core.errors import FileIssue, InvalidFileError

STALE_PART_AGE_S = 3600.0
"""s: a part not written to for longer has no owner."""

_PROGRAM = Path(os.path.realpath(__file__)).parents[1]
"""Profiles and catalogues that come with the program are read from there."""

_PAGE = (".html", ".htm")
OUTPUT_ENDINGS = {
    "--json": (".json",), "--pdf": (".pdf",), "--html": _PAGE, "--live": _PAGE,
    "--xlsx": (".xlsx",), "--junit": (".xml",), "--png": (".png",), "--vtu": (".vtu",),
    "--step": (".step", ".stp"), "--inp": (".inp",), "--bdf": (".bdf", ".nas"),
    "--sarif": (".sarif", ".json"),
}  # fmt: skip
"""Endings of what an option writes; any other ending is accepted."""

_KNOWN_ENDINGS = frozenset(e for endings in OUTPUT_ENDINGS.values() for e in endings)

_PART = re.compile(r"\.cardan-([0-9a-f]{8})-([0-9]{1,10})-[0-9a-f]{8}\.part")
_DESCRIPTOR = re.compile(r"/(?:dev|proc/self)/fd/([0-9]+)")
_STANDARD = {"/dev/stdin": 0, "/dev/stdout": 1, "/dev/stderr": 2}


def write_atomically(
    path: str | Path,
    content: str | bytes | Iterable[bytes],
    *,
    replace: bool = False,
    within: Path | None = None,
) -> Path:
    """Write a file whole or not at all, and return its path; text in UTF-8, chunks as they come.

    Raises
    ------
    InvalidFileError
        If the file is there already and `replace` is False, or cannot be written; also if its
        links lead out of the folder `within`, as they are at this moment.
    """
    path = Path(path)
    content = encode_text(path, content) if isinstance(content, str) else content
    data = (content,) if isinstance(content, bytes) else content
    try:
        target = _target(path)
        if within is not None:
            check_within(path, target, within)
        if isinstance(target, int):
            _stream(os.dup(target), data)
        elif _streams(target):
            _stream(os.open(target, os.O_WRONLY), data)
        else:
            _settle(target, data, replace=replace)
    except OSError as error:
        raise write_error(path, error) from None
    return path


def check_within(path: Path, target: Path | int, folder: Path) -> None:
    """Refuse what a name's links lead to if that is not in a folder, itself without links.

    Raises
    ------
    InvalidFileError
        If it is elsewhere.
    """
    if isinstance(target, int) or not target.is_relative_to(folder):
        raise _bad(path, "is a link that leads out of the folder")


def encode_text(path: Path, text: str) -> bytes:
    """Return a text as it stands in a file.

    Raises
    ------
    InvalidFileError
        If it holds half a letter, as browsers can: one of the two that make up a rare one.
    """
    try:
        return text.encode("utf-8")
    except UnicodeEncodeError as error:
        line = text.count("\n", 0, error.start) + 1
        raise _bad(path, f"line {line} holds half a letter, which no file can hold") from None


def check_output_paths(
    outputs: Mapping[str, str | Path | None], *, inputs: Iterable[Path] = ()
) -> None:
    """Refuse outputs that cannot be written or must not, before anything is computed.

    Parameters
    ----------
    outputs
        Where each option writes; None where it is not given, "-" for standard output.
    inputs
        What is read: by whatever name an output reaches one of them, it is refused.

    Raises
    ------
    InvalidFileError
        If an output is an input or a part of this program, if two outputs are one file, if a
        name ends as another option's files do, or if one has no place.
    """
    claimed: dict[str, Path] = {}
    read = tuple(inputs)
    for option, name in outputs.items():
        if name is None or name == "-":
            continue
        path = Path(name)
        if path == Path("-"):
            raise _bad(path, f"{option} cannot go to standard output; name a file")
        try:
            _place(path)
        except OSError as error:
            raise write_error(path, error) from None
        if Path(os.path.realpath(path)).is_relative_to(_PROGRAM):
            raise _bad(path, f"{option} would write into the program itself")
        for source in read:
            if same_file(path, source):
                raise _bad(path, f"{option} would write over {_called(source, path)} that is read")
        for other, there in claimed.items():
            if same_file(path, there):
                raise _bad(path, f"{other} and {option} would write into one file")
        kinds = OUTPUT_ENDINGS.get(option, ())
        ending = path.suffix.lower()
        if kinds and ending in _KNOWN_ENDINGS.difference(kinds):
            raise _bad(path, f"{option} writes no {ending} file; end its name in {kinds[0]}")
        claimed[option] = path


def same_file(one: Path, other: Path) -> bool:
    """Return whether two names are one file, through links of any kind and either case.

    A terminal or a null device has no owner: two may write into it.
    """
    with suppress(OSError):
        if stat.S_ISCHR(one.stat().st_mode):
            return False
        return one.samefile(other)
    a, b = (Path(os.path.realpath(p)) for p in (one, other))
    if _folded(a.name) != _folded(b.name):
        return False
    with suppress(OSError):
        return a.parent.samefile(b.parent) and (a.name == b.name or _folds(a.parent))
    return a == b


# --------------------------------------------------------------------------- where to


def _target(path: Path) -> Path | int:
    """Return the file behind a name and its links, or the descriptor that it is a name of."""
    text = str(path)
    if found := _DESCRIPTOR.fullmatch(text):
        return int(found[1])
    if text in _STANDARD:
        return _STANDARD[text]
    return Path(os.path.realpath(path))


def _streams(target: Path) -> bool:
    """Return whether a name stands for a pipe or a terminal, which are written into.

    Raises
    ------
    OSError
        If it stands for what a result has no business in: a folder, a disk.
    """
    try:
        mode = target.lstat().st_mode
    except FileNotFoundError:
        return False
    if stat.S_ISLNK(mode):  # of a circle, or put here since the name was resolved
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))
    if stat.S_ISDIR(mode):
        raise OSError(errno.EISDIR, "it is a folder; name a file in it")
    if stat.S_ISREG(mode):
        return False
    if stat.S_ISFIFO(mode) or stat.S_ISCHR(mode):
        return True
    raise OSError(errno.EINVAL, "it is neither a file nor a pipe")


def _place(path: Path) -> None:
    """Refuse a name that nothing can be written under, without writing anything.

    Raises
    ------
    OSError
        Which says why.
    """
    target = _target(path)
    if isinstance(target, int):
        os.fstat(target)
        return
    if _streams(target):
        return
    _writable(target)


def _writable(target: Path) -> None:
    """Refuse a file that may not be replaced, or a folder that takes none."""
    folder = target.parent
    if not folder.exists():
        raise OSError(errno.ENOENT, f"there is no folder {folder}")
    if not folder.is_dir():
        raise OSError(errno.ENOTDIR, f"{folder} is not a folder")
    if target.exists() and not os.access(target, os.W_OK):
        raise OSError(errno.EACCES, "it is write-protected")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OSError(errno.EACCES, f"no permission to write in {folder}")


def _folds(folder: Path) -> bool:
    """Return whether a folder's file system takes capital and small letters for the same."""
    for place in (folder, *folder.parents):
        swapped = place.name.swapcase()
        if swapped != place.name:
            with suppress(OSError):
                return place.with_name(swapped).samefile(place)
            return False
    return False


def _folded(name: str) -> str:
    return unicodedata.normalize("NFC", name).casefold()


# --------------------------------------------------------------------------- how


def _stream(descriptor: int, data: Iterable[bytes]) -> None:
    """Write into what stays what it is."""
    with os.fdopen(descriptor, "wb") as stream:
        stream.writelines(data)


def _settle(target: Path, data: Iterable[bytes], *, replace: bool) -> None:
    """Write a part next to a file and let it take its place."""
    if not replace and target.exists():
        raise FileExistsError
    _writable(target)
    _sweep(target.parent)
    part = target.with_name(f".cardan-{_computer()}-{os.getpid()}-{os.urandom(4).hex()}.part")
    try:
        with os.fdopen(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666), "wb") as file:
            if replace:
                _inherit(part, target)
            file.writelines(data)
            file.flush()
            os.fsync(file.fileno())
        if replace:
            part.replace(target)
        else:
            _appear(part, target)
        _remember(target.parent)
    finally:
        part.unlink(missing_ok=True)


def _inherit(part: Path, target: Path) -> None:
    """Give a part the owner, where that is permitted, and the permissions of a file."""
    try:
        old = target.lstat()
    except FileNotFoundError:
        return
    new, mode = part.stat(), stat.S_IMODE(old.st_mode)
    if (new.st_uid, new.st_gid) != (old.st_uid, old.st_gid):
        try:
            os.chown(part, old.st_uid, old.st_gid)
        except OSError:
            mode &= 0o777  # rights to act as its owner are not another's to have
    part.chmod(mode)


def _appear(part: Path, target: Path) -> None:
    """Let a finished file appear under its name, unless there is one already."""
    try:
        os.link(part, target)  # unlike a rename it fails where there is a file
    except FileExistsError:
        raise
    except OSError:  # a disk without links, like a memory stick's
        os.close(os.open(target, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
        part.replace(target)


def _remember(folder: Path) -> None:
    """Let a new name survive a power cut, where folders can be synchronised."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


@cache
def _computer() -> str:
    """Return what distinguishes parts of this computer from those of another on the same disk."""
    import platform

    return f"{zlib.crc32(platform.node().encode()):08x}"


def _sweep(folder: Path) -> None:
    """Remove parts that a run which was killed has left in a folder."""
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            found = _PART.fullmatch(entry.name)
            if found and _stale(entry, host=found[1], process=int(found[2])):
                with suppress(OSError):
                    Path(entry.path).unlink()


def _stale(entry: "os.DirEntry[str]", *, host: str, process: int) -> bool:
    """Return whether a part is no longer being written."""
    with suppress(OSError):
        if time.time() - entry.stat(follow_symlinks=False).st_mtime > STALE_PART_AGE_S:
            return True
        return host == _computer() and not _runs(process)
    return False


def _runs(process: int) -> bool:
    """Return whether a process of this computer runs, as far as one can know."""
    if os.name == "nt":  # there the question would end it
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True
    return True


# --------------------------------------------------------------------------- why not


def write_error(path: Path, error: OSError) -> InvalidFileError:
    """Return the error of a file that was not written."""
    if isinstance(error, FileExistsError):
        return _bad(path, "is there already", hint="choose another name, or say --force")
    return _bad(path, f"cannot be written: {error.strerror or error}")


def _bad(path: Path, message: str, *, hint: str = "") -> InvalidFileError:
    return InvalidFileError(str(path), (FileIssue(message=message, hint=hint),))


def _called(source: Path, path: Path) -> str:
    """Return what to call a file that is read: by its name where that is another."""
    return "the file" if source == path else f"the file {source}"

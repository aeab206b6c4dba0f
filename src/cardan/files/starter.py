"""Files to start from, and the safe way to write one."""

import os
from pathlib import Path

from cardan.base.errors import BadFile, Problem

_FOLDER = Path(__file__).with_name("starters")


def kinds() -> tuple[str, ...]:
    """Return the names of the starters."""
    return tuple(sorted(p.stem for p in _FOLDER.glob("*.yaml")))


def starter(kind: str = "small") -> str:
    """Return a commented application file to start from: `small` or `truck`.

    Raises
    ------
    ValueError
        If there is none of that kind.
    """
    if kind not in kinds():
        msg = f"there is no starter {kind}; there are: {', '.join(kinds())}"
        raise ValueError(msg)
    return (_FOLDER / f"{kind}.yaml").read_text(encoding="utf-8")


def write(path: str | Path, content: str | bytes, *, replace: bool = False) -> Path:
    """Write a file whole or not at all, and return its path; text in UTF-8.

    Raises
    ------
    BadFile
        If the file is there already and `replace` is False, or cannot be written.
    """
    path = Path(path)
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with part.open("xb") as file:
            file.write(content.encode("utf-8") if isinstance(content, str) else content)
            file.flush()
            os.fsync(file.fileno())
        if replace:
            part.replace(path)
        else:
            _appear(part, path)
    except FileExistsError:
        problem = Problem(message="is there already", hint="choose another name, or say --force")
        raise BadFile(str(path), (problem,)) from None
    except OSError as error:
        problem = Problem(message=f"cannot be written: {error.strerror}")
        raise BadFile(str(path), (problem,)) from None
    finally:
        part.unlink(missing_ok=True)
    return path


def _appear(part: Path, path: Path) -> None:
    """Let a finished file appear under its name, unless there is one already."""
    try:
        os.link(part, path)  # unlike a rename it fails where there is a file
    except FileExistsError:
        raise
    except OSError:  # a disk without links, like a memory stick's
        if path.exists():
            raise FileExistsError(path) from None
        part.replace(path)

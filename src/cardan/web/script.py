"""What was done to a file with a hand, as a script and as commands that do it again."""

import shlex
from math import isfinite

import numpy as np

from cardan.base.errors import CardanError
from cardan.files.change import addresses
from cardan.files.manuscript import Manuscript
from cardan.report.language import Language
from cardan.web.document import Document, Json, Tell


def script(read: Document, args: Json, say: Language, _: Tell) -> Json:
    """Return a Python script that makes of the saved file what is shown, and commands.

    Of a campaign they ask for its life. Numbers are changed by their addresses. What is no
    number, a part's name or a line that is new, cannot be said so: it is named, and the file
    has to be saved for it.

    The commands are for a POSIX shell. Where numbers are not saved yet the first of them is
    the script; those of `cardan` ask the file as it lies there.
    """
    name, drives = read.name, read.recordings is not None
    try:
        was, now = Manuscript(args.get("saved", ""), name), read.manuscript
        known = {} if drives else addresses(read.application)
        changed = {
            at: float(np.ravel(known[at])[0])
            for at in known
            if at in now and was.written(at) is not None and was.written(at) != now.written(at)
        }  # fmt: skip
        other = sorted(
            at
            for at in {*was.addresses, *now.addresses} - changed.keys()
            if was.written(at) != now.written(at)
        )
    except CardanError:
        changed, other = {}, [name]
    rows = "".join(f"    {at!r}: {v:.12g},\n" for at, v in changed.items() if isfinite(v))
    asked = f"cardan.life({name!r})" if drives else "cardan.check(app)"
    lines = ["import cardan", "", *([] if drives else [f"app = cardan.read({name!r})"])]
    if rows:
        lines.append("app = cardan.change(app, {\n" + rows + "})")
    text = "\n".join([*lines, f"found = {asked}", "print(found)", ""])
    quoted = argument(name)
    return {
        "script": text,
        "commands": [
            *([f"python -c {shlex.quote(text)}"] if rows else []),
            *(
                f"cardan {command} {quoted} --lang {say.code}"
                for command in (("life",) if drives else ("check", "fix"))
            ),
            f"cardan serve {quoted}",
        ],
        "other": other[:20],
    }


def argument(name: str) -> str:
    """Return a file's name for a POSIX shell: never an option, nor anything a shell does."""
    return shlex.quote(f"./{name}" if name.startswith("-") else name)

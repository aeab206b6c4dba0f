"""Files to start from."""

from pathlib import Path

_FOLDER = Path(__file__).with_name("starters")


def kinds() -> tuple[str, ...]:
    """Return the names of the starters."""
    return tuple(sorted(p.stem for p in _FOLDER.glob("*.yaml")))


def starter(kind: str = "small") -> str:
    """Return a commented application file to start from, one of `kinds`.

    Raises
    ------
    ValueError
        If there is none of that kind.
    """
    if kind not in kinds():
        msg = f"there is no starter {kind}; there are: {', '.join(kinds())}"
        raise ValueError(msg)
    return (_FOLDER / f"{kind}.yaml").read_text(encoding="utf-8")

"""Files to start from."""

from pathlib import Path

_FOLDER = Path(__file__).with_name("starters")
_EXAMPLES = next(
    (f for k in (1, 3) if (f := Path(__file__).parents[k] / "examples").is_dir()), _FOLDER
)
"""Where the worked examples are: within an installed package, or next to the source of one."""


def template_names() -> tuple[str, ...]:
    """Return the names of the starters."""
    return tuple(sorted(p.stem for p in _FOLDER.glob("*.yaml")))


def template_text(kind: str = "small") -> str:
    """Return a commented application file to start from, one of `template_names`.

    Raises
    ------
    ValueError
        If there is none of that kind.
    """
    if kind not in template_names():
        msg = f"there is no starter {kind}; there are: {', '.join(template_names())}"
        raise ValueError(msg)
    return (_FOLDER / f"{kind}.yaml").read_text(encoding="utf-8")


def example_names() -> tuple[str, ...]:
    """Return the names of the worked examples: applications, and folders of a whole case."""
    return tuple(sorted(p.stem for p in _EXAMPLES.iterdir() if p.is_dir() or p.suffix == ".yaml"))


def example_path(name: str) -> Path:
    """Return the application file of a worked example, or the folder of a case."""
    folder = _EXAMPLES / name
    return folder if folder.is_dir() else _EXAMPLES / f"{name}.yaml"

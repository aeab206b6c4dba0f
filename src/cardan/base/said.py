"""A sentence kept apart from what is filled in, so that each medium says it in its language."""

from cardan.base.frozen import dataclass


@dataclass(frozen=True)
class Said:
    """A sentence in English, with {names} for its values; several of them are a list."""

    text: str
    values: tuple[tuple[str, object], ...] = ()

    def __str__(self) -> str:
        """Return it in English."""
        values = {
            name: ", ".join(map(str, value)) if isinstance(value, tuple) else value
            for name, value in self.values
        }
        return self.text.format(**values) if values else self.text


def said(text: str, /, **values: object) -> Said:
    """Return a sentence with its values.

    >>> str(said("{count} samples missing", count=8))
    '8 samples missing'
    """
    return Said(text, tuple(values.items()))

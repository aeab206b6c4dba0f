"""A sentence kept apart from what is filled in, so that each medium says it in its language."""

from cardan.core.lazy_dataclass import dataclass


@dataclass(frozen=True)
class TranslatableMessage:
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


def translatable_message(text: str, /, **values: object) -> TranslatableMessage:
    """Return a sentence with its values.

    >>> str(translatable_message("{count} samples missing", count=8))
    '8 samples missing'
    """
    return TranslatableMessage(text, tuple(values.items()))

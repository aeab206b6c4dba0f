"""What an analysis found, by code and values: the presentation has the words."""

from cardan.core.lazy_dataclass import dataclass


@dataclass(frozen=True)
class Finding:
    """A finding by its code, with the numbers and names that it holds for, in SI units."""

    code: str
    values: tuple[tuple[str, object], ...] = ()

    def with_values(self, **values: object) -> "Finding":
        """Return the finding with its values.

        >>> Finding("samples-missing").with_values(samples=8)
        Finding(code='samples-missing', values=(('samples', 8),))
        """
        return Finding(self.code, tuple(values.items()))

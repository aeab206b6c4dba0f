"""Make Griffe treat `cardan.core.lazy_dataclass.dataclass` as a dataclass."""

from typing import Any

import griffe

OURS, THEIRS = "cardan.core.lazy_dataclass.dataclass", "dataclasses.dataclass"


class Signatures(griffe.Extension):
    """Frozen dataclasses show what their `__init__` takes."""

    def on_class_instance(self, *, cls: griffe.Class, **_: Any) -> None:
        """Take our decorator for the library's."""
        for decorator in cls.decorators:
            value = decorator.value
            if not isinstance(value, griffe.Expr) or value.canonical_path != OURS:
                continue
            if isinstance(value, griffe.ExprCall):
                value.function = griffe.ExprName(THEIRS)
            else:
                decorator.value = griffe.ExprName(THEIRS)

"""API pages take `cardan.base.frozen.dataclass` for what it is; Griffe goes by its name alone."""

from typing import Any

import griffe

OURS, THEIRS = "cardan.base.frozen.dataclass", "dataclasses.dataclass"


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

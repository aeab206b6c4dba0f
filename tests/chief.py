"""Cases of which one or two stand for all: the others are asked with what is slow."""

import pytest


def chief(cases, *kept, ids=None):
    """Return cases as parameters, all but those kept marked slow: they, or their ids if given."""
    return [
        pytest.param(
            *(case if isinstance(case, tuple) else (case,)),
            marks=() if (ids(case) if ids else case) in kept else pytest.mark.slow,
            **({"id": ids(case)} if ids else {}),
        )
        for case in cases
    ]

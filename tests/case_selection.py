"""Marks on parametrised cases: representatives in every run, the others by hand."""

import pytest


def select(cases, *kept, ids=None):
    """Return `cases` as parameters, each but those in `kept` marked `long`.

    `ids` gives the name of a case; `kept` then holds names.
    """
    return [
        pytest.param(
            *(case if isinstance(case, tuple) else (case,)),
            marks=() if (ids(case) if ids else case) in kept else pytest.mark.long,
            **({"id": ids(case)} if ids else {}),
        )
        for case in cases
    ]


def long(*cases):
    """Return `cases` as parameters of `make long`, which is run by hand."""
    return select(cases)

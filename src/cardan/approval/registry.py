"""Studies by name: each topic registers its own, which is imported when first needed."""

from functools import cache
from importlib import import_module
from typing import Any

from cardan.approval.study import Study, StudyRegistration

REGISTRATION_MODULES = (
    "cardan.approval.driveline_study",
    "cardan.topics.torsion.registration",
    "cardan.topics.bracket.registration",
    "cardan.topics.recording.registration",
)
"""Modules whose `REGISTRATION` announces a study, in the order of reports."""


@cache
def study_registrations() -> dict[str, StudyRegistration]:
    """Return what topics register, by the name of the study."""
    found: list[StudyRegistration] = [
        import_module(module).REGISTRATION for module in REGISTRATION_MODULES
    ]
    return {one.name: one for one in found}


@cache
def studies_of_application() -> dict[str, Study[Any]]:
    """Return the studies that need nothing but an application, by name."""
    return {name: one.study for name, one in study_registrations().items() if one.study is not None}

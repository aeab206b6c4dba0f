"""The bracket as the page turns it about: its mesh, what each case does to it, its zones."""

from cardan.approval.approval import approve_application, default_studies
from cardan.approval.study import BRACKET_STUDY_NAME
from cardan.core.errors import DesignError
from cardan.core.units import MPa, mm
from cardan.render.i18n import Translator
from cardan.topics.bracket.assessment import BracketResult
from cardan.topics.bracket.chapter import bracket_blocks_without_picture as chapter
from cardan.topics.bracket.presentation_values import (
    MAX_MARKED_FATIGUE_FEATURES,
    highest_stress,
    max_fatigue_utilisation,
    most_stressed_cases,
)
from cardan.topics.bracket.registration import BracketStudy
from cardan.topics.bracket.scene import variant_scene_data
from cardan.topics.bracket.shape_result import ShapeAssessment
from cardan.web.block_serialiser import report_blocks_to_messages
from cardan.web.parsed_document import (
    Json,
    ParsedDocument,
    PartialResultCallback,
    check_to_json,
    round_decimals,
    round_significant,
)


def assess_bracket(
    read: ParsedDocument, _: Json, say: Translator, tell: PartialResultCallback
) -> Json:
    """Return the bracket judged: its verdict, its limits, its scene and its chapter."""
    application = read.application
    if application.bracket is None:
        msg = "the file has no bracket: write one under bracket:"
        raise DesignError(msg)
    found = approve_application(
        application, (*default_studies(application), BracketStudy()),
        tell=lambda doing, done, of: tell(
            {"doing": say.error(doing), **({"done": done, "of": of} if of else {})}
        ),
    )  # fmt: skip
    finding = next(one for one in found.study_results if one.study == BRACKET_STUDY_NAME)
    if finding.answer is None:
        raise DesignError("; ".join(finding.failure_reasons), about=BRACKET_STUDY_NAME)
    of: BracketResult = finding.answer
    return {
        "verdict": found.verdict,
        "checks": [check_to_json(c, found, say) for c in finding.checks],
        "gauges": [{"name": gauge.name, "at": list(gauge.point)} for gauge in of.bracket.gauges],
        "variants": [
            {**variant_scene_data(v, most_stressed_cases(v), say), "zones": _zone_rows(v, say)}
            for v in of.variants
        ],
        "blocks": report_blocks_to_messages(chapter(finding, say)),
    }


def _zone_rows(v: ShapeAssessment, say: Translator) -> list[Json]:
    """Return where a crack may start: place, mm, highest stress, MPa, and use of its limit."""
    stress, cases = highest_stress(v)
    share = max_fatigue_utilisation(v)
    return [
        {
            "mark": f"H{k + 1}" if k < MAX_MARKED_FATIGUE_FEATURES else "",
            "said": say.part(one.part),
            "at": [round_decimals(x / mm, 4) for x in one.point],
            "MPa": round_significant(float(stress[k]) / MPa),
            "case": say.occasion(cases[k].case.when),
            "used": round_decimals(float(share[k]), 4),
        }
        for k, one in enumerate(v.listed_features)
    ]

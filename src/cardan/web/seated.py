"""The bracket as the page turns it about: its mesh, what each case does to it, its zones."""

from cardan.base.errors import DesignError
from cardan.base.units import MPa, mm
from cardan.report.bracket import MARKED, highest, telling_cases, used
from cardan.report.bracket_chapter import told as chapter
from cardan.report.bracket_scene import variant
from cardan.report.language import Language
from cardan.study.approval import approve, default_studies
from cardan.study.bracket import BracketAnswer
from cardan.study.bracket_judge import Judged
from cardan.study.finding import BRACKET
from cardan.study.studies import BracketStudy
from cardan.web.document import Document, Json, Tell, f, g, other
from cardan.web.told import told


def seated(read: Document, _: Json, say: Language, tell: Tell) -> Json:
    """Return the bracket judged: its verdict, its limits, its scene and its chapter."""
    application = read.application
    if application.bracket is None:
        msg = "the file has no bracket: write one under bracket:"
        raise DesignError(msg)
    found = approve(
        application, (*default_studies(application), BracketStudy()),
        tell=lambda doing, done, of: tell(
            {"doing": say.error(doing), **({"done": done, "of": of} if of else {})}
        ),
    )  # fmt: skip
    finding = next(one for one in found.findings if one.study == BRACKET)
    if finding.answer is None:
        raise DesignError("; ".join(finding.doubts), about=BRACKET)
    of: BracketAnswer = finding.answer
    return {
        "verdict": found.verdict,
        "checks": [other(c, found, say) for c in finding.checks],
        "gauges": [{"name": gauge.name, "at": list(gauge.point)} for gauge in of.bracket.gauges],
        "variants": [
            {**variant(v, telling_cases(v), say), "zones": _zones(v, say)} for v in of.variants
        ],
        "blocks": told(chapter(finding, say)),
    }


def _zones(v: Judged, say: Language) -> list[Json]:
    """Return where a crack may start: place, mm, highest stress, MPa, and use of its limit."""
    stress, cases = highest(v)
    share = used(v)
    return [
        {
            "mark": f"H{k + 1}" if k < MARKED else "", "said": say.part(one.part),
            "at": [f(x / mm, 4) for x in one.point], "MPa": g(float(stress[k]) / MPa),
            "case": say.occasion(cases[k].case.when), "used": f(float(share[k]), 4),
        }
        for k, one in enumerate(v.shown)
    ]  # fmt: skip

"""What a study of variants came to, and how far it has come."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from cardan.application.variant_sampling import SampledVariable, SamplingPlan
from cardan.approval.approval import Approval
from cardan.core.arrays import FloatArray
from cardan.core.verdict import VERDICTS, Limit, Verdict
from cardan.model.variants import VariantStudy
from cardan.topics.variants.evaluation import (
    EvaluatedVariants,
    VariantEvaluator,
    limit_names,
)
from cardan.topics.variants.rare_failure import RareFailureEstimate
from cardan.topics.variants.statistics import (
    StatisticState,
    YieldMap,
    clopper_pearson_interval,
    requested_statistics,
    wilson_interval,
)
from cardan.topics.variants.yield_surrogate import SurrogateYield

ProgressCallback: TypeAlias = Callable[["StudyProgress"], None]
"""Takes how far a study has come."""


@dataclass(frozen=True, kw_only=True)
class StudyProgress:
    """How far a study has come: variants done before this run and in all, and how many to do.

    With all of them done, of how many limits the failure rate is computed, and of how many in all.
    `idle` while no worker evaluates any: a cluster without workers waits for some.
    """

    done_before: int
    done: int
    count: int
    seconds: float
    rare: tuple[int, int] | None = None
    idle: bool = False
    damaged: int = 0
    """Shards of the folder that are damaged or hold no digest, and are computed again."""

    @property
    def rate(self) -> float:
        """Variants a second in this run."""
        return (self.done - self.done_before) / self.seconds if self.seconds > 0 else 0.0

    @property
    def seconds_left(self) -> float:
        """Seconds left; nan where unknown."""
        return (self.count - self.done) / self.rate if self.rate > 0 else float("nan")


@dataclass(frozen=True, kw_only=True)
class ChangedFile:
    """A file that changed while a study of its text ran: SHA-256 of its text then and now.

    `digest_after` is None if the file cannot be read any more.
    """

    name: str
    digest_before: str
    digest_after: str | None


@dataclass(frozen=True, kw_only=True)
class VariantStudyResult:
    """What a study of variants came to.

    Attributes
    ----------
    evaluator
        The application, and where its variants lie.
    variants
        What was evaluated.
    requested_count
        How many variants were requested; fewer are reported if the run was stopped.
    statistics
        Their statistics, by name (`cardan.topics.variants.statistics`); `pareto` of those bred
        besides.
    rows
        Each variant, where they were kept.
    rare_failures
        How often limits fail that variants hardly ever did, if requested.
    negligible_failures
        Those of them of which no failure was found that is near enough to count.
    surrogate_yield
        The yield of many more, predicted from those evaluated, if requested.
    seconds
        How long this run took.
    changed_files
        The files of the application and of the study that changed while it ran. The study is of
        what was read before.
    """

    evaluator: VariantEvaluator
    variants: VariantStudy
    requested_count: int
    statistics: Mapping[str, StatisticState]
    rows: EvaluatedVariants | None = None
    rare_failures: tuple[RareFailureEstimate, ...] = ()
    negligible_failures: tuple[RareFailureEstimate, ...] = ()
    surrogate_yield: SurrogateYield | None = None
    seconds: float = 0.0
    changed_files: tuple[ChangedFile, ...] = ()

    @property
    def installed(self) -> Approval:
        """The approval of the application as it stands."""
        return self.evaluator.installed

    @property
    def sampling_plan(self) -> SamplingPlan:
        """Where the variants lie."""
        return self.evaluator.sampling_plan

    @property
    def tolerance_factors(self) -> list[SampledVariable]:
        """Factors of the sampling that are tolerances."""
        return [f for f in self.sampling_plan.factors if f.tolerance]

    @property
    def limits(self) -> tuple[tuple[str, Limit], ...]:
        """Each limit with the line that it applies to."""
        return self.evaluator.limits

    @property
    def limit_names(self) -> tuple[str, ...]:
        """A name for each limit."""
        return limit_names(self.limits)

    @property
    def count(self) -> int:
        """How many variants were evaluated."""
        return int(self.statistics["counts"]["asked"])

    @property
    def independent_count(self) -> int:
        """How many of them are drawn by themselves: shares are of those."""
        return int(self.statistics["counts"]["count"])

    @property
    def shares(self) -> dict[Verdict, float]:
        """The share of variants that comes to each verdict."""
        counts = self.statistics["counts"]["verdicts"] / self.independent_count
        return dict(zip(VERDICTS, counts.tolist(), strict=True))

    @property
    def acceptable_count(self) -> int:
        """How many may be built: they pass or only warn."""
        return acceptable_and_independent(self.statistics["counts"])[0]

    @property
    def stopped_count(self) -> int:
        """How many failed a limit without rubber, and were not evaluated on rubber."""
        return int(self.statistics["counts"]["stopped"])

    @property
    def lower_bound_share(self) -> float:
        """The share of variants that do not fail, and have a value that is a lower bound alone."""
        return int(self.statistics["counts"]["bounded"]) / self.independent_count

    @property
    def lower_bound_shares(self) -> FloatArray:
        """The share of variants (L,) in which the value of each limit is a lower bound."""
        return self.statistics["counts"]["lower_bounds"] / self.independent_count

    @property
    def yield_(self) -> float:
        """The share of variants that may be built."""
        return self.acceptable_count / self.independent_count

    def interval(self, *, exact: bool = True) -> tuple[float, float]:
        """Return the interval of the yield: Clopper and Pearson's, or Wilson's."""
        of = clopper_pearson_interval if exact else wilson_interval
        return of(
            self.acceptable_count, self.independent_count, confidence=self.variants.ask.confidence
        )

    @property
    def maps(self) -> tuple[tuple[YieldMap, StatisticState], ...]:
        """The maps that were evaluated for, with their cells."""
        found = requested_statistics(self.evaluator, self.variants.ask)
        return tuple((m, self.statistics[n]) for n, m in found.items() if isinstance(m, YieldMap))


class StudyInterrupted(KeyboardInterrupt):
    """A study was stopped from the keyboard; `studied` is the result of what was done."""

    def __init__(self, studied: VariantStudyResult) -> None:
        super().__init__()
        self.result = studied


def acceptable_and_independent(counts: StatisticState) -> tuple[int, int]:
    """Return how many variants may be built, and of how many drawn by themselves."""
    found = dict(zip(VERDICTS, counts["verdicts"].tolist(), strict=True))
    return found["pass"] + found["warn"], int(counts["count"])

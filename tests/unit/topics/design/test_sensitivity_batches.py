"""Single corrections are evaluated together, each as by itself, and no more of them than needed."""

import numpy as np
import pytest
from repository import EXAMPLES

from cardan.application import reader
from cardan.approval.applied_adjustments import response_with_adjustments
from cardan.approval.approval import Approval, approve_driveline
from cardan.approval.driveline_study import evaluate_limits
from cardan.checks import worst_points
from cardan.topics.design import sensitivity
from cardan.topics.design.sensitivity import CheckSensitivity, check_sensitivities


@pytest.fixture(scope="module")
def truck() -> Approval:
    return approve_driveline(reader.read(EXAMPLES / "medium-truck-4x2.yaml"))


@pytest.mark.slow
def test_effect_of_a_move_in_the_batch_equals_the_move_alone(truck):
    """Its value is the worst of all states; the batch may only round otherwise.

    A bearing's force at its stop is solved of the move alone; the batch takes the crest over linear
    rubber's force to stay as it is.
    """
    (response,) = truck.line_responses
    moves = {}
    for one in check_sensitivities(truck):
        for effect in one.helpful_effects:
            move, value = one.best_adjustment(effect)
            moves.setdefault(move, []).append((one, value))
    assert len(moves) > 4
    for move, each in moves.items():
        alone = response_with_adjustments(response, (move.adjustable,), np.array([move.amount]))
        for one, value in each:
            at_stop = one.check.quantity.startswith("centre_bearing")
            expected = pytest.approx(worst_value(alone, one), rel=0.15 if at_stop else 1e-10)
            assert value == expected, one.check.quantity


def worst_value(response, one: CheckSensitivity) -> float:
    """The value of the limit of a check in the worst of all states."""
    check = one.check
    values = next(
        q.values[:, q.parts.index(check.part)]
        for q in evaluate_limits(response, quantities={check.quantity})
        if q.limit == check.limit and check.part in q.parts
    )
    values = values[~np.isnan(values)]
    to = "maximum" if check.grade == "fail" else "normal"
    return float(values[check.limit.margin(values, to=to).argmin()])


def test_half_moves_that_fail_cheaper_limits_are_not_searched_on_rubber(truck, monkeypatch):
    """Searched are all steps in one batch, and the end of a range that helps where no step does.

    Halves of this truck spoil angles, or the spline's compression.
    """
    searched, batches = [], []
    search, evaluate = worst_points.worst_bearing_forces, sensitivity.response_with_adjustments

    def counted_search(mounts, *given):
        searched.append(mounts)
        return search(mounts, *given)

    def counted_batch(response, movable, amounts):
        batches.append((len(response.demand.states), len(amounts)))
        return evaluate(response, movable, amounts)

    monkeypatch.setattr(worst_points, "worst_bearing_forces", counted_search)
    monkeypatch.setattr(sensitivity, "response_with_adjustments", counted_batch)
    check_sensitivities(truck)
    assert len(searched) == 2
    in_all_states = [count for states, count in batches if states == 7]
    assert in_all_states[0] == 10  # five things back and forth
    assert in_all_states[1] == 1  # softer rubber

"""Method of a ranking: an expectation over all poses, or over samples of them where poses and places are too many."""

from voa_core.errors import InvalidInput
from voa_msgs.rankings import Method
from voa_service.mapping.ranking_tasks import RankingTask

MOST_EXACT_WEIGHTS = 320_000_000
"""Product of places and squared poses up to which a ranking whose request does not say otherwise is exact."""


def ranking_method(task: RankingTask) -> Method:
    """Choose the method of a ranking: that of the request, else `sampled` where it has more than 320 million weights.

    Simulated scans are samples themselves, and outcomes are listed for every pose: both need the exact method.

    Raises:
        InvalidInput: the request demands samples of the poses, and also simulated scans or outcomes.
    """
    simulated, outcomes = task.samples is not None, task.request.outcomes
    if task.request.method == "sampled":
        if simulated:
            raise InvalidInput("method", '"exact" for simulated scans, or `scans` = "exact" with it', "'sampled'")
        if outcomes:
            raise InvalidInput(
                "method", '"exact" where `outcomes` are listed, for they are those of every pose', "'sampled'"
            )
    if task.request.method is not None:
        return task.request.method
    is_large = len(task.sensors) * task.weights_of_place > MOST_EXACT_WEIGHTS
    return "sampled" if is_large and not simulated and not outcomes else "exact"

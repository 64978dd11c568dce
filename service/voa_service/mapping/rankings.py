"""Rankings: from requests to the Value of Assistance of looks, and to messages that rank looks and grasps."""

from collections.abc import Sequence

from voa_core.assistance import Valuation
from voa_core.filtering import Belief
from voa_core.grasps import ranked
from voa_core.looks import Looks
from voa_core.ranking import OrderedMap, RankedLook, rank_looks
from voa_core.recommendation import Recommendation, recommend
from voa_core.sampled_ranking import Progress, rank_over_samples
from voa_core.scenario import Scenario
from voa_msgs.rankings import GraspNow, Look, Method, Outcome, RankedGrasp, RankedGrasps, RankedSensor, Ranking
from voa_service.mapping.estimates import absence_warnings
from voa_service.mapping.models import Precision
from voa_service.mapping.ranking_methods import ranking_method
from voa_service.mapping.ranking_tasks import RankingTask
from voa_service.mapping.ranking_weights import Weighing, looks_of, sampled_looks_of

ParallelMap = OrderedMap
"""A `map` that applies a function to items in several threads, and returns the results in the order of the items."""


def ranking_message(
    task: RankingTask, weighing: Weighing, parallel_map: ParallelMap, progress: Progress | None = None
) -> Ranking:
    """Rank looks by their Value of Assistance (Definition 5), as a message without the session's version.

    Args:
        task: checked request.
        weighing: choices by which the weights are computed.
        parallel_map: applies the computation of one look to all of them.
        progress: called after each value of a ranking over samples of the poses.

    Raises:
        VoaError: a prediction cannot be made, or the method of the request does not fit.
    """
    method = ranking_method(task)
    valuation = Valuation(
        task.belief,
        task.table,
        task.scenario.policy,
        task.definition,
        task.sensor_belief,
        check=weighing.check,
    )
    if method == "sampled":
        advice = _sampled_advice(task, sampled_looks_of(task, weighing), valuation, parallel_map, progress)
    else:
        advice = _exact_advice(task, *looks_of(task, weighing), valuation, parallel_map)
    return _message(task, advice, method, weighing.precision)


def _exact_advice(
    task: RankingTask, looks: Looks, fresh: Looks | None, valuation: Valuation, parallel_map: ParallelMap
) -> Recommendation:
    """Rank looks over all poses, and recommend one or two of them or a grasp."""
    return recommend(
        rank_looks(task.sensors, looks, valuation, driving=task.driving, ordered_map=parallel_map),
        looks,
        valuation,
        fresh=fresh,
        min_gain=task.min_gain,
        lookahead=task.request.lookahead,
        driving=task.driving,
        ordered_map=parallel_map,
    )


def _sampled_advice(
    task: RankingTask, looks: Looks, valuation: Valuation, parallel_map: ParallelMap, progress: Progress | None
) -> Recommendation:
    """Rank looks over samples of the poses, and recommend one of them or a grasp."""
    ranking = rank_over_samples(
        task.sensors,
        looks,
        valuation,
        seed=task.scenario.seed,
        driving=task.driving,
        ordered_map=parallel_map,
        progress=progress,
    )
    return recommend(ranking, looks, valuation, min_gain=task.min_gain, lookahead=1)


def ranked_grasps_message(
    scenario: Scenario, belief: Belief, names: Sequence[str] | None, version: int
) -> RankedGrasps:
    """Rank grasps by their expected score under a belief, as a message.

    Args:
        scenario: with the grasp table.
        belief: over its poses.
        names: of the grasps that are reachable, each possibly several names separated by commas; None: all.
        version: of the session whose belief it is.

    Raises:
        UnknownName: there is no such grasp.
    """
    table = scenario.table
    table = table.reachable(None if names is None else _separated(names, table.names))
    expected = table.expected_scores(belief.p)
    return RankedGrasps(
        version=version,
        grasps=[
            RankedGrasp(name=table.names[index], expected_score=float(expected[index])) for index in ranked(expected)
        ],
    )


def _separated(names: Sequence[str], known: Sequence[str]) -> list[str]:
    """Split names at commas, except where a name that exists contains the comma."""
    parts = ([name] if name in known else name.split(",") for name in names)
    return [part for some in parts for part in some]


def _message(task: RankingTask, advice: Recommendation, method: Method, precision: Precision) -> Ranking:
    ranking, before = advice.ranking, advice.ranking.before
    best = None if before.index is None else task.table.names[before.index]
    recommendation: Look | GraspNow
    if advice.look is not None and advice.net_value is not None:
        then = {} if advice.then is None else {"then": advice.then.sensor.name}
        recommendation = Look(action="look", sensor=advice.look.sensor.name, net_value=advice.net_value, **then)
    else:
        recommendation = GraspNow(action="grasp", grasp=best, expected_score=before.expected_score)
    return Ranking(
        version=None,
        definition=task.definition,
        scans=task.scans,
        samples=task.samples,
        lookahead=advice.lookahead,
        value_of_perfect_information=ranking.value_of_perfect_information,
        method=method,
        precision=precision,
        expected_score_before=before.expected_score,
        best_grasp_before=best,
        ranking=[_ranked_sensor(task, look, ranking.ties_with_first(look)) for look in ranking.looks],
        recommendation=recommendation,
        warnings=absence_warnings(task.absent),
    )


def _ranked_sensor(task: RankingTask, look: RankedLook, ties_with_first: bool) -> RankedSensor:
    assistance = look.assistance
    row = RankedSensor(
        sensor=look.sensor.name,
        voa=assistance.voa,
        standard_error=assistance.standard_error,
        score_standard_error=assistance.score_standard_error,
        cost=look.cost,
        net_value=look.net_value,
        expected_score_after=assistance.expected_score_after,
        ties_with_first=ties_with_first,
        looks_taken=task.looks_taken(look.sensor),
    )
    return row.model_copy(update={"outcomes": _outcomes(task, look)}) if task.request.outcomes else row


def _outcomes(task: RankingTask, look: RankedLook) -> list[Outcome]:
    assistance = look.assistance
    return [
        Outcome(
            pose=task.model.scenario.poses.names[pose],
            probability=float(task.outer.p[pose]),
            best_grasp=None if grasp < 0 else task.table.names[grasp],
            expected_score=float(score),
        )
        for pose, grasp, score in zip(assistance.outcomes, assistance.best_grasps, assistance.scores, strict=True)
    ]

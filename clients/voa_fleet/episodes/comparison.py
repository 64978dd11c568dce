"""Comparison of policies on the same drops: grasps with looks and without."""

from collections.abc import Callable
from dataclasses import dataclass, field

from voa_client import Client
from voa_fleet.episodes.bench import Bench
from voa_fleet.episodes.episode import Episode, Pair, run_episode
from voa_fleet.episodes.looks import client_channel
from voa_fleet.episodes.policies import policy_named
from voa_fleet.statistics import wilson
from voa_msgs.scenarios import Scenario


@dataclass(frozen=True)
class Tally:
    """Counts of the episodes of one policy.

    Attributes:
        policy: name of the policy.
        lifted: for each drop in order, True if the object was lifted.
        looks: number of looks in all episodes.
        expected: sum of the success probabilities that the service expected of the attempted grasps.
    """

    policy: str
    lifted: tuple[bool, ...] = ()
    looks: int = 0
    expected: float = 0.0

    def after(self, episode: Episode) -> "Tally":
        """Return the counts with one more episode."""
        return Tally(
            self.policy,
            (*self.lifted, episode.success),
            self.looks + len(episode.looks),
            self.expected + episode.expected_score,
        )

    @property
    def successes(self) -> int:
        """Number of episodes in which the object was lifted."""
        return sum(self.lifted)

    @property
    def attempts(self) -> int:
        """Number of episodes."""
        return len(self.lifted)

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval of the probability of success."""
        return wilson(self.successes, self.attempts)


@dataclass
class Comparison:
    """Drops that are each run once per policy. All policies have the same drops, also where a run is ended early.

    Attributes:
        policies: names.
        tallies: counts by policy, in order.
    """

    policies: tuple[str, ...] = ("none", "voa")
    tallies: dict[str, Tally] = field(init=False)

    def __post_init__(self) -> None:
        self.tallies = {policy: Tally(policy) for policy in self.policies}

    def run(
        self,
        client: Client,
        scenario: Scenario,
        bench: Bench,
        drops: range,
        most_looks: int,
        progress: Callable[[int], None],
    ) -> None:
        """Run every drop once per policy, and count.

        Args:
            client: of the service.
            scenario: of the sessions.
            bench: on which the drops are made.
            drops: their indices.
            most_looks: in an episode.
            progress: called with 1 after each episode.

        Raises:
            VoaClientError: the service refuses a request, or does not answer.
            FleetError: a drop cannot be made, or a device fails.
        """
        for index in drops:
            episodes = []
            for name in self.policies:
                prepared = bench.prepare(index)
                channel = client_channel(client, prepared.robot, scenario)
                pair = Pair(prepared.robot.name, client, prepared.robot, prepared.arm, channel, bench.scene.clock)
                episodes.append(run_episode(pair, scenario, policy_named(name), most_looks, seed=index))
                progress(1)
            self.tallies = {episode.policy: self.tallies[episode.policy].after(episode) for episode in episodes}

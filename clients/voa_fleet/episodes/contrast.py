"""The contrast: the same drops with looks and without."""

from collections.abc import Callable
from dataclasses import dataclass, field

from voa_client import Client
from voa_evaluation.grasp_scores import wilson
from voa_fleet.devices.session_looks import looking_by
from voa_fleet.episodes.policies import policy_named
from voa_fleet.episodes.stage import Stage
from voa_fleet.episodes.story import Pair, Story, play
from voa_msgs.scenarios import Scenario


@dataclass(frozen=True)
class Tally:
    """How often grasps succeeded.

    Attributes:
        policy: that chose the looks.
        lifted: of each drop, in order, whether the object was lifted.
        looks: taken in all of them.
        expected: the sum of what the service expected of the grasps that were tried.
    """

    policy: str
    lifted: tuple[bool, ...] = ()
    looks: int = 0
    expected: float = 0.0

    def after(self, story: Story) -> "Tally":
        """With one more story."""
        return Tally(
            self.policy,
            (*self.lifted, story.success),
            self.looks + len(story.looks),
            self.expected + story.expected_score,
        )

    @property
    def successes(self) -> int:
        """k of n."""
        return sum(self.lifted)

    @property
    def attempts(self) -> int:
        """n."""
        return len(self.lifted)

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval of the probability of success; needs an attempt."""
        return wilson(self.successes, self.attempts)


@dataclass
class Contrast:
    """Drops played once per policy. Grows drop by drop: whoever stops early has the same drops of every policy.

    Attributes:
        tallies: by policy, in order.
    """

    policies: tuple[str, ...] = ("none", "voa")
    tallies: dict[str, Tally] = field(init=False)

    def __post_init__(self) -> None:
        self.tallies = {policy: Tally(policy) for policy in self.policies}

    def play(
        self,
        client: Client,
        scenario: Scenario,
        stage: Stage,
        drops: range,
        most_looks: int,
        progress: Callable[[int], None],
    ) -> None:
        """Play every drop once per policy.

        Raises:
            VoaClientError: the service refuses something, or does not answer.
            FleetError: the stage cannot be set.
        """
        for index in drops:
            stories = []
            for name in self.policies:
                drop = stage.drop(index)
                looking = looking_by(client, drop.robot, scenario)
                pair = Pair(drop.robot.name, client, drop.robot, drop.arm, looking, stage.scene.clock)
                stories.append(play(pair, scenario, policy_named(name, index), most_looks))
                progress(1)
            self.tallies = {story.policy: self.tallies[story.policy].after(story) for story in stories}

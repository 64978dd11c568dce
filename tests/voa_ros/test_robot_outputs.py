import pytest

from voa_ros.outputs.selection import published
from voa_ros.robots import InvalidRobots, RobotMapping, load

ROBOT = '[[robot]]\nname = "tb3_1"\nsession = "s"\nplace = { from = "attachment" }\n'


def mapped(text: str) -> RobotMapping:
    return load(ROBOT + text)[0]


def test_nothing_is_published_and_nothing_received_unless_stated() -> None:
    assert (mapped("").outputs.topics, mapped("").inputs.topics) == ([], [])


def test_true_is_the_usual_topic_and_false_none() -> None:
    outputs = mapped("outputs = { belief = true, markers = false, numbers = true }").outputs
    assert outputs.topics == [
        "voa/belief",
        "voa/numbers/entropy_nats",
        "voa/numbers/expected_score",
        "voa/numbers/fit_rmsd_mm",
    ]
    assert outputs.markers is None


def test_topics_are_resolved_with_the_namespace_of_the_robot() -> None:
    mapping = mapped('outputs = { poses = true, place = "goal_pose", markers = "/voa/markers" }')
    assert published(mapping) == {
        "tb3_1/voa/poses": "geometry_msgs/msg/PoseArray",
        "voa/markers": "visualization_msgs/msg/MarkerArray",
        "tb3_1/goal_pose": "geometry_msgs/msg/PoseStamped",
    }


def test_only_places_and_markers_need_a_ranking() -> None:
    assert not mapped("outputs = { belief = true, grasps = true, numbers = true }").outputs.needs_ranking
    assert mapped("outputs = { place = true }").outputs.needs_ranking
    assert mapped("outputs = { markers = true }").outputs.needs_ranking


def test_an_address_has_no_slash_at_its_end() -> None:
    assert mapped('outputs = { meshes = "https://lab:8000/" }').outputs.meshes == "https://lab:8000"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("outputs = { markers = 3 }", "outputs.markers: expected true, false or a topic, got 3"),
        ("outputs = { marker = true }", "outputs.marker: no such field: expected one of belief, poses, markers"),
        ('outputs = { markers = "a b" }', "outputs.markers: expected a topic like"),
        ('outputs = { meshes = "lab" }', "outputs.meshes: expected an address such as http://lab:8000, got 'lab'"),
        ('inputs = { prior = true, outcome = "voa/prior" }', "'voa/prior' is used 2 times"),
        ('outputs = { belief = "voa/prior" }\ninputs = { prior = true }', "'voa/prior' is used 2 times"),
        ("inputs = { object_moved = 2.0 }", "inputs.object_moved: Input should be less than or equal to 1"),
    ],
)
def test_a_mistake_is_named_with_the_robot_and_the_field(text: str, said: str) -> None:
    with pytest.raises(InvalidRobots) as raised:
        mapped(text)
    assert "robot 'tb3_1'" in str(raised.value)
    assert said in str(raised.value)


OTHER = ROBOT.replace("tb3_1", "tb3_2")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('outputs = { place = "scan" }\n', "robot: 'tb3_1/scan' is an output of 'tb3_1': expected another topic"),
        (
            f'outputs = {{ markers = "/voa/markers" }}\n{OTHER}outputs = {{ markers = "/voa/markers" }}\n',
            "robot: the output 'voa/markers' of 'tb3_2' is one of 'tb3_1' too: expected another topic for each robot",
        ),
        (
            f'outputs = {{ belief = "/prior" }}\n{OTHER}inputs = {{ prior = "/prior" }}\n',
            "robot: 'prior' is an output of 'tb3_1': expected another topic for 'tb3_2'",
        ),
    ],
)
def test_no_topic_is_published_twice_or_received_again(text: str, said: str) -> None:
    with pytest.raises(InvalidRobots) as raised:
        load(ROBOT + text)
    assert said in str(raised.value)


def test_several_robots_may_receive_one_topic() -> None:
    both = load(f'{ROBOT}inputs = {{ prior = "/initialpose" }}\n{OTHER}inputs = {{ prior = "/initialpose" }}\n')
    assert [robot.topic(robot.inputs.topics[0]) for robot in both] == ["initialpose", "initialpose"]

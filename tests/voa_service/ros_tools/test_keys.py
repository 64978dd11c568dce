import zenoh

from voa_ros.robots import RobotMapping, load
from voa_ros.topics import BOOL, RmwAttachment
from voa_service.ros_tools.keys import Addresses, announcements


def mapped(middleware: str) -> RobotMapping:
    (mapping,) = load(
        '[[robot]]\nname = "tb3_1"\nsession = "s"\ndomain = 7\nplace = { from = "attachment" }\n'
        f'outputs = {{ belief = true, middleware = "{middleware}" }}\n'
    )
    return mapping


def addresses(middleware: str) -> Addresses:
    return Addresses(mapped(middleware), now_ns=lambda: 5)


def test_a_bridge_takes_the_bare_topic() -> None:
    address = addresses("bridge").next("tb3_1/voa/belief", BOOL)
    assert (address.key, address.attachment) == ("tb3_1/voa/belief", None)


def test_rmw_zenoh_counts_the_samples_of_each_topic() -> None:
    own = addresses("rmw_zenoh")
    sent = [own.next(topic, BOOL) for topic in ("a", "b", "a")]
    assert [address.key for address in sent[:2]] == [f"7/{t}/std_msgs::msg::dds_::Bool_/{BOOL.rihs}" for t in "ab"]
    attached = [RmwAttachment.decode(address.attachment or b"") for address in sent]
    assert [each.sequence for each in attached] == [1, 1, 2]
    assert [each.source_ns for each in attached] == [5, 5, 5]
    assert attached[0].gid == attached[2].gid != attached[1].gid


def test_topics_are_announced_as_a_bridge_announces_them() -> None:
    (token,) = announcements(mapped("bridge"), "ab12", {"tb3_1/voa/outcome": BOOL})
    assert token == f"@/ab12/@ros2_lv/MP/tb3_1§voa§outcome/std_msgs§msg§Bool/:1:0:0,10:typehash={BOOL.rihs};"
    zenoh.KeyExpr(token)


def test_topics_are_announced_as_a_node_of_rmw_zenoh_announces_them() -> None:
    node, topic = announcements(mapped("rmw_zenoh"), "ab12", {"tb3_1/voa/outcome": BOOL})
    assert node == "@ros2_lv/7/ab12/0/0/NN/%/%/voa"
    of_type = f"std_msgs::msg::dds_::Bool_/{BOOL.rihs}"
    assert topic == f"@ros2_lv/7/ab12/0/1/MP/%/%/voa/%tb3_1%voa%outcome/{of_type}/::,10:,:,:,,"
    zenoh.KeyExpr(topic)

"""The settings of Zenoh sessions: clients of given routers, without discovery or shared memory."""

from voa_msgs.links import session_config

ROUTER = "tcp/192.168.0.2:7447"


def test_a_session_is_a_client_of_its_routers_alone() -> None:
    config = session_config([ROUTER, "tcp/192.168.0.3:7447"])
    assert config["mode"] == "client"
    assert config["connect"]["endpoints"] == [ROUTER, "tcp/192.168.0.3:7447"]
    switched_off = ("scouting/multicast/enabled", "scouting/gossip/enabled", "transport/shared_memory/enabled")
    assert [config[entry] for entry in switched_off] == [False, False, False]


def test_opening_fails_at_once_or_after_the_stated_time() -> None:
    assert session_config([ROUTER])["connect"]["timeout_ms"] == 0
    assert session_config([ROUTER], open_ms=500)["connect"]["timeout_ms"] == 500
    assert session_config([ROUTER])["connect"]["exit_on_failure"] is True


def test_credentials_are_sent_only_where_there_is_a_user() -> None:
    assert "transport/auth/usrpwd" not in session_config([ROUTER], password="secret")  # noqa: S106 - not a secret
    assert session_config([ROUTER], "lab", "secret")["transport/auth/usrpwd"] == {"user": "lab", "password": "secret"}
    assert session_config([ROUTER], "lab")["transport/auth/usrpwd"] == {"user": "lab", "password": ""}

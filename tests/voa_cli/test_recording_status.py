"""The line that `voa record` shows, and what it says of messages that others cannot read."""

from collections import Counter

from voa_cli import recording_status as status


def test_what_others_cannot_read_is_said() -> None:
    unknown = Counter({"/rb/own": 2, "/rb/else": 1})
    said = status.shortcomings(unknown, {"/scan": 5_521, "/small": 360}, 4_096)
    assert said[0].startswith("3 messages have no type, since")
    assert said[0].endswith("/rb/else (1), /rb/own (2)")
    assert said[1].startswith("/scan has scans of 5521 beams: `voa serve` and `voa replay` read at most 4096, unless ")
    assert "VOA_LIMITS__BEAMS=5521" in said[1]
    assert len(said) == 2
    assert status.shortcomings(Counter(), {"/scan": 5_521}, 30_000) == []


def test_the_line_says_how_it_stands() -> None:
    counts = Counter({"/scan": 12, "/odom": 3})
    line = status.line(counts, 1_234_567, 2.0, 0, linked=True)
    assert line == "recording 15 messages, 1.2 MB, last 2 s ago  /scan 12  /odom 3"
    assert "no router  4 dropped" in status.line(counts, 0, None, 4, linked=False)
    assert "nothing received yet" in status.line(Counter(), 0, None, 0, linked=True)
    assert [status.size(count) for count in (999, 1000, 2_500_000_000_000)] == ["999 B", "1.0 kB", "2500.0 GB"]


def test_sessions_that_are_not_shown_completely_are_said() -> None:
    said = status.not_shown({"s1": "the mesh is gone"}, Counter({"s2": 3}))
    assert said[0] == "session s1 is not shown completely: the mesh is gone"
    assert said[1].startswith("session s2 has 3 versions without towers")
    assert "--rank always" in said[1]
    assert status.not_shown({}, Counter()) == []

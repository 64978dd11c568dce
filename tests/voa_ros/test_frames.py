"""Scans of several echoes or lidars on one topic."""

import pytest

from voa_ros.frames import RECENT, FrameFilter


def test_scans_of_one_frame_pass_whatever_its_name() -> None:
    own = FrameFilter(None)
    assert all(own.receive("base_scan") for _ in range(3 * RECENT))


def test_an_empty_frame_is_a_frame() -> None:
    own = FrameFilter(None)
    assert own.receive("")
    with pytest.raises(ValueError, match=r"2 frames on one topic \('', 'front'\)"):
        own.receive("front")


def test_two_frames_without_a_choice_are_refused_by_name() -> None:
    own = FrameFilter(None)
    own.receive("laser_1")
    for frame in ("laser_2", "laser_1", "laser_1"):
        with pytest.raises(ValueError, match=r"scans of 2 frames .*'laser_1', 'laser_2'.*frame_id = \.\.\."):
            own.receive(frame)


def test_a_frame_that_is_gone_is_forgotten() -> None:
    own = FrameFilter(None)
    own.receive("old")
    for _ in range(RECENT - 1):
        with pytest.raises(ValueError, match="2 frames"):
            own.receive("new")
    assert own.receive("new")


def test_the_frame_that_is_named_passes_alone() -> None:
    own = FrameFilter("echo_1")
    assert [own.receive(f"echo_{number % 3}") for number in range(6)] == [False, True, False, False, True, False]
    assert own.others == ["echo_0", "echo_2"]


def test_a_named_frame_that_does_not_come_is_missing() -> None:
    own = FrameFilter("echo_1")
    own.receive("echo_0")
    assert own.missing
    own.receive("echo_1")
    for _ in range(RECENT - 1):
        own.receive("echo_0")
        assert not own.missing
    own.receive("echo_0")
    assert own.missing
    assert own.others == ["echo_0"]


def test_without_a_choice_none_is_missing() -> None:
    own = FrameFilter(None)
    own.receive("a")
    assert not own.missing

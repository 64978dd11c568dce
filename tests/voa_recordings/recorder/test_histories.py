"""Histories of sessions that the recorder fetches from the service."""

from tests.support.waiting import wait_for
from tests.voa_recordings.recorder.samples import NEXT
from voa_client import Client
from voa_recordings.recorder.histories import Histories
from voa_recordings.recorder.inbox import Inbox


def test_a_history_that_cannot_be_fetched_is_reported() -> None:
    inbox = Inbox()
    with Client("http://127.0.0.1:1", timeout_s=0.1) as client:
        histories = Histories(client, inbox, lambda: NEXT, lambda *_, newest: None)
        histories.start()
        histories.want("s1")
        wait_for(lambda: histories.failed, "the attempt fails")
        histories.end()
    assert list(histories.failed) == ["s1"]
    assert inbox.get(0.0) is None

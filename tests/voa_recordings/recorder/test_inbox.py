"""The inbox between Zenoh's threads and the file: bounded, in order."""

from tests.voa_recordings.recorder.samples import received
from voa_recordings.recorder.inbox import Inbox


def test_an_inbox_that_is_full_drops_and_counts() -> None:
    inbox = Inbox(2)
    items = [received("a"), received("b"), received("c")]
    for item in items:
        inbox.put(item)
    assert (inbox.get(0.0), inbox.get(0.0), inbox.get(0.0), inbox.get(0.01)) == (*items[:2], None, None)
    assert inbox.dropped == 1

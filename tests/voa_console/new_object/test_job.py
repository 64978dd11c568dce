"""Job: its step and its progress, as the process reports them."""

from voa_console.new_object.draft import Draft
from voa_console.new_object.job import Job
from voa_console.new_object.messages import Reply


def test_a_step_begins_without_progress_and_then_has_some() -> None:
    job = Job(Draft(mesh="part.stl"), "made", 10.0)
    assert (job.state, job.share) == ("running", None)
    job.receive(Reply(text="scoring the grasps"))
    job.receive(Reply(done=3, total=12))
    assert (job.text, job.share) == ("scoring the grasps", 0.25)
    job.receive(Reply(text="drawing the page"))
    assert (job.text, job.share) == ("drawing the page", None)
    assert job.seconds(lambda: 12.5) == 2.5

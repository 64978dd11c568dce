"""Kernels are loaded before the service is ready, but a start does not wait for what takes long or fails."""

import threading

import structlog

from voa_service.runtime.kernels import load_before_ready


def test_the_start_waits_for_kernels_to_be_loaded() -> None:
    loaded = threading.Event()
    load_before_ready(loaded.set, seconds=60.0)
    assert loaded.is_set()


def test_the_start_goes_on_while_kernels_are_compiled() -> None:
    compiled = threading.Event()

    def compile_kernels() -> None:
        compiled.wait(60.0)

    load_before_ready(compile_kernels, seconds=0.0)
    assert "voa-kernels" in {thread.name for thread in threading.enumerate()}
    compiled.set()


def test_an_error_is_logged_and_does_not_end_the_start() -> None:
    def fail() -> None:
        raise OSError("the folder of kernels cannot be read")

    with structlog.testing.capture_logs() as lines:
        load_before_ready(fail, seconds=60.0)
    assert [(line["event"], line["log_level"]) for line in lines] == [("the kernels cannot be loaded", "error")]

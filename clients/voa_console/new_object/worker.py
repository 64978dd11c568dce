"""The process that does the work of a new object: `python -m voa_console.new_object.worker URL`.

It reads a task per line from stdin, and writes replies as lines to stdout. Mesh files are not trusted: memory, size of
files and core dumps are limited, and whoever started the process ends it where it takes too long. It ends with its
parent, whatever it does at that moment.
"""

import os
import queue
import resource
import signal
import sys
import threading
from typing import TYPE_CHECKING, TextIO

from voa_client import VoaClientError
from voa_client.installing import install_hint
from voa_console.new_object.messages import Reply, Task
from voa_console.sentences import sentence_of

if TYPE_CHECKING:
    from voa_console.new_object.tasks import Tasks

_MEBIBYTES = 6_144
"""Address space of each process: simulator, compiled functions and a mesh of the largest size need about half of it."""
_LARGEST_FILE_MEBIBYTES = 512


class Replies:
    """Replies to the parent, and the display of the steps that `voa_setup` reports to."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def begin(self, text: str) -> None:
        """Show that a step begins."""
        self.send(Reply(text=text))

    def advance(self, done: int, total: int) -> None:
        """Show how many parts of the current step are finished."""
        self.send(Reply(done=done, total=total))

    def send(self, reply: Reply) -> None:
        """Write a reply."""
        self._stream.write(f"{reply.model_dump_json(exclude_none=True)}\n")
        self._stream.flush()


def main(url: str) -> None:
    """Do the tasks on stdin, one after the other, until the parent closes it."""
    _limit()
    # Libraries may print: only replies go to the parent.
    replies = Replies(os.fdopen(os.dup(1), "w", encoding="utf-8"))
    os.dup2(2, 1)
    tasks: queue.SimpleQueue[str] = queue.SimpleQueue()
    threading.Thread(target=_read, args=(tasks,), daemon=True).start()
    try:
        from voa_console.new_object.tasks import Tasks  # noqa: PLC0415 - a console without the extra starts, too
    except ImportError as error:
        _refuse(tasks, replies, _missing(error))
        return
    with Tasks(url) as work:
        while True:
            task = Task.model_validate_json(tasks.get())
            replies.send(_reply(work, task, replies))


def _reply(work: "Tasks", task: Task, replies: Replies) -> Reply:
    """Do a task; return its result, or a sentence that says why it cannot be done."""
    try:
        return Reply(result=work.do(task, replies))
    except VoaClientError as error:
        return Reply(error=sentence_of(error))
    except work.refusals as error:
        return Reply(error=str(error))
    except ImportError as error:
        return Reply(error=_missing(error))
    except OSError as error:
        return Reply(error=f"{error.filename or task.folder} cannot be written: {error.strerror}.")
    except MemoryError:
        return Reply(error="The mesh needs too much memory: simplify it.")


def _missing(error: ImportError) -> str:
    """Say which extra has the part that is missing, and how to install it."""
    return f"Making a scenario needs the extra setup ({error}). Install it: {install_hint('setup')}"


def _refuse(tasks: "queue.SimpleQueue[str]", replies: Replies, sentence: str) -> None:
    """Answer every task with an error."""
    while True:
        tasks.get()
        replies.send(Reply(error=sentence))


def _limit() -> None:
    """Limit this process and those that it starts."""
    for kind, mebibytes in (
        (resource.RLIMIT_AS, _MEBIBYTES),
        (resource.RLIMIT_FSIZE, _LARGEST_FILE_MEBIBYTES),
        (resource.RLIMIT_CORE, 0),
    ):
        _, hard = resource.getrlimit(kind)
        size = mebibytes * 2**20
        least = size if hard == resource.RLIM_INFINITY else min(size, hard)
        resource.setrlimit(kind, (least, least))


def _read(tasks: "queue.SimpleQueue[str]") -> None:
    """Pass on the lines of stdin; at its end, end this process with all that it started."""
    for line in sys.stdin:
        tasks.put(line)
    if os.getpgrp() == os.getpid():
        os.killpg(os.getpid(), signal.SIGKILL)
    os._exit(0)


if __name__ == "__main__":
    main(sys.argv[1])

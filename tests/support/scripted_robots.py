"""Robots that send scans at 5 Hz until SIGTERM, as a program that imports nothing but the client.

    python -m tests.support.scripted_robots FILE URL=SESSION ...

One robot for each URL and session. Each writes a line `robot number` to FILE for every scan that got a response.
"""

import signal
import sys
import threading
from pathlib import Path
from typing import TextIO

from voa_client import Client
from voa_msgs.sessions import Scan, ScanRequest

PERIOD_S = 0.2


def drive(name: str, url: str, session: str, ended: threading.Event, answered: TextIO, lock: threading.Lock) -> None:
    """Send scans as one robot until `ended` is set, and log those with a response."""
    with Client(url) as client:
        number = 0
        while not ended.is_set():
            scan = Scan(ranges=[0.5, 0.5, None, 1.0], stamp=[name, number])
            client.apply_scan(session, ScanRequest(sensor="Q1", scan=scan))
            with lock:
                answered.write(f"{name} {number}\n")
                answered.flush()
            number += 1
            ended.wait(PERIOD_S)


def main() -> None:
    """Run all robots, each in a thread of its own."""
    ended, lock = threading.Event(), threading.Lock()
    signal.signal(signal.SIGTERM, lambda *_: ended.set())
    robots: list[threading.Thread] = []
    with Path(sys.argv[1]).open("w", encoding="utf-8") as answered:
        for index, robot in enumerate(sys.argv[2:]):
            url, _, session = robot.rpartition("=")
            work = (f"robot-{index}", url, session, ended, answered, lock)
            robots.append(threading.Thread(target=drive, args=work))
            robots[-1].start()
        for each in robots:
            each.join()


if __name__ == "__main__":
    main()

"""Records of sessions: requested once per version for all pages, and of a history only what is new."""

import asyncio
from collections.abc import AsyncIterator
from typing import cast

from tests.voa_console.session.test_moments import HISTORY, entry
from tests.voa_console.session.test_words import outcomes, ranking, row
from voa_client import AsyncClient, RankedGrasp, RankedGrasps, Ranking, UnreachableError, VoaRequest
from voa_console.session.records import Records, SessionRecord
from voa_msgs.sessions import HistoryEntry


class Source:
    """Client that counts its calls."""

    def __init__(self) -> None:
        self.calls: list[str] = []
        self.entries = list(HISTORY)
        self.fails = False

    async def history(self, session_id: str, *, beliefs: bool, after: int) -> AsyncIterator[HistoryEntry]:
        assert beliefs
        self.calls.append(f"history after {after}")
        for each in self.entries:
            if each.version > after:
                yield each

    async def rank_grasps(self, session_id: str) -> RankedGrasps:
        self.calls.append("grasps")
        await asyncio.sleep(0)
        if self.fails:
            raise UnreachableError("away")
        return RankedGrasps(version=2, grasps=[RankedGrasp(name="G1", expected_score=0.5)])

    async def rank_looks(self, session_id: str, request: VoaRequest) -> Ranking:
        assert request.outcomes
        self.calls.append("looks")
        return LOOK.model_copy(update={"ranking": [outcomes(("G1", 1.0))]})

    def record(self) -> SessionRecord:
        return SessionRecord("s", cast(AsyncClient, self))


LOOK = ranking({"action": "look", "sensor": "Q1", "net_value": 0.1}, row("Q1", 0.1, ties=True))


def test_pages_share_a_history_until_there_is_a_newer_version() -> None:
    async def run() -> Source:
        source = Source()
        record = source.record()
        both = await asyncio.gather(record.history(2), record.history(2))
        assert [len(each) for each in both] == [3, 3]
        source.entries.append(entry(3, [0.5, 0.5]))
        assert len(await record.history(3)) == 4
        return source

    assert asyncio.run(run()).calls == ["history after -1", "history after 2"]


def test_grasps_are_ranked_once_for_a_version_and_a_failure_is_not_kept() -> None:
    async def run() -> Source:
        source = Source()
        record = source.record()
        source.fails = True
        failures = await asyncio.gather(record.grasps(2), record.grasps(2), return_exceptions=True)
        assert [type(each) for each in failures] == [UnreachableError] * 2
        source.fails = False
        both = await asyncio.gather(record.grasps(2), record.grasps(2))
        assert list(both) == [[("G1", 0.5)]] * 2
        return source

    assert asyncio.run(run()).calls == ["grasps"] * 2


def test_outcomes_are_those_of_the_look_that_is_recommended() -> None:
    async def run() -> Source:
        source = Source()
        record = source.record()
        for _ in range(2):
            outcome = await record.outcomes(LOOK)
            assert outcome is not None
            assert outcome.outcomes
        grasp = ranking({"action": "grasp", "grasp": "G1", "expected_score": 0.9}, row("Q1", 0.0, ties=True))
        assert await record.outcomes(grasp) is None
        return source

    assert asyncio.run(run()).calls == ["looks"]


def test_the_least_recently_used_record_is_dropped() -> None:
    records = Records(cast(AsyncClient, Source()), most=2)
    one = records.of("one")
    records.of("two")
    assert records.of("one") is one
    records.of("three")
    assert records.of("one") is one

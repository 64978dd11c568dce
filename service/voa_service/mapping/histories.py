"""Histories: from stored versions of a session to messages."""

import json
from typing import Any

from voa_core.scenario import Scenario
from voa_msgs.sessions import HistoryEntry, UpdateReport
from voa_service.mapping.estimates import absent_of, belief_summary
from voa_service.mapping.looks import record_of
from voa_store import records


def history_message(entry: records.HistoryEntry, scenario: Scenario | None) -> HistoryEntry:
    """Convert a version to a message.

    Args:
        entry: as stored.
        scenario: of the session, if the message has the belief and the best grasp; None: it has neither.
    """
    absent = absent_of(record_of(entry.state.looks))
    estimate: dict[str, Any] = {"absent": absent}
    if scenario is not None:
        belief = entry.state.belief
        estimate = {"belief": belief.p.tolist()} | belief_summary(scenario, belief, absent)
    return HistoryEntry(
        version=entry.state.version,
        kind=entry.kind,
        at=entry.state.updated_at,
        request=json.loads(entry.request),
        update=None if entry.report is None else UpdateReport.model_validate_json(entry.report),
        **estimate,
    )

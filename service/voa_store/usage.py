"""Checks whether something needs a scenario or an object, before it is deleted."""

from sqlalchemy import Connection, bindparam, func, select

from voa_store.errors import InUse
from voa_store.tables import GONE, scenarios, sessions, summaries

_SESSIONS = select(sessions.c.id, sessions.c.version).where(sessions.c.scenario == bindparam("by_id")).limit(3)
_SCENARIOS = (
    select(scenarios.c.id, scenarios.c.name)
    .join(summaries, summaries.c.id == scenarios.c.id)
    .where(func.instr(summaries.c.summary, bindparam("by_id")) > 0)
    .limit(3)
)
_SCENARIOS_OF_POSTGRES = (
    select(scenarios.c.id, scenarios.c.name)
    .join(summaries, summaries.c.id == scenarios.c.id)
    .where(func.strpos(summaries.c.summary, bindparam("by_id")) > 0)
    .limit(3)
)


def check_scenario(connection: Connection, id_: str) -> None:
    """Return if no session is on a scenario; raises InUse with some of them."""
    rows = connection.execute(_SESSIONS, {"by_id": id_}).all()
    if not rows:
        return
    living = [session for session, version in rows if version > GONE]
    if living:
        raise InUse(f"sessions are on this scenario ({', '.join(living)}): delete them first")
    raise InUse("the rows of a deleted session on this scenario are still being removed: try again in some seconds")


def check_object(connection: Connection, id_: str) -> None:
    """Return if no scenario needs an object; raises InUse with some of them."""
    query = _SCENARIOS if connection.dialect.name == "sqlite" else _SCENARIOS_OF_POSTGRES
    rows = connection.execute(query, {"by_id": id_}).all()
    if rows:
        names = ", ".join(f"{name!r} ({scenario})" for scenario, name in rows)
        raise InUse(f"scenarios need this object ({names}): delete them first")

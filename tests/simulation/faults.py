"""Faults that are planted into the production code while a simulation runs; each must be attribute, and replayed."""

import importlib
import inspect
import textwrap
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from types import CodeType, FunctionType
from typing import Any


@dataclass(frozen=True)
class Change:
    """Replacement of some text in a function or method.

    Attributes:
        where: module and name, as "voa_store.sql:SqlStore.change".
        texts: each a text that stands there once, and the text that stands there instead.
    """

    where: str
    texts: tuple[tuple[str, str], ...]

    def function(self) -> FunctionType:
        """Find the function in its module, without its decorators."""
        module, _, path = self.where.partition(":")
        attribute: Any = importlib.import_module(module)
        for name in path.split("."):
            attribute = getattr(attribute, name)
        function: Any = inspect.unwrap(attribute)
        if not isinstance(function, FunctionType):
            raise TypeError(f"expected a function at {self.where}, got {type(function).__name__}")
        return function

    def code(self) -> CodeType:
        """Compile the function with the replacements.

        Raises:
            ValueError: a text to be replaced does not stand there once.
        """
        function = self.function()
        source = textwrap.dedent(inspect.getsource(function))
        for old, new in self.texts:
            if source.count(old) != 1:
                raise ValueError(f"expected {old!r} once in {self.where}, got it {source.count(old)} times")
            source = source.replace(old, new)
        namespace: dict[str, Any] = {}
        exec(compile(source, f"<planted: {self.where}>", "exec"), function.__globals__, namespace)  # noqa: S102 - source of this repository
        changed: FunctionType = inspect.unwrap(namespace[function.__name__])
        return changed.__code__


@dataclass(frozen=True)
class PlantedFault:
    """A fault that somebody might make.

    Attributes:
        name: what is wrong then.
        changes: of the code.
        seeds: number of seeds within which it must be found.
        first: a seed that found the fault in the short runs of CI, which try it first.
        rare: True if it needs more seeds than CI has time for.
    """

    name: str
    changes: tuple[Change, ...]
    seeds: int = 30
    first: int = 0
    rare: bool = False

    @contextmanager
    def planted(self) -> Iterator[None]:
        """Put the fault into the code within a `with` block, for everybody who has imported it."""
        with ExitStack() as stack:
            for change in self.changes:
                function = change.function()
                stack.callback(setattr, function, "__code__", function.__code__)
                function.__code__ = change.code()
            yield


def _change(where: str, *texts: tuple[str, str]) -> Change:
    return Change(where, texts)


_COMMIT = "voa_store.changing:SessionWriter._commit"
_BEGIN = "with transaction(self._engine) as connection:\n"
_UNLOCK = (
    f"{_BEGIN}        rows = _locked(connection, lock, group)\n",
    "with transaction(self._engine) as unlocked:\n        rows = _locked(unlocked, lock, group)\n    " + _BEGIN,
)
_REPLACE = (
    "self._add[table].execute(connection, added)",
    'connection.execute(insert(table).prefix_with("OR REPLACE"), added)',
)

PLANTED = (
    PlantedFault(
        "a session is read before its lock is taken",
        (_change(_COMMIT, _UNLOCK),),
        first=18,
    ),
    PlantedFault(
        "a lost lock: the second of two writers replaces the version of the first",
        (_change(_COMMIT, _UNLOCK), _change("voa_store.changing:SessionWriter._store", _REPLACE)),
    ),
    PlantedFault(
        "two writes of a group are to one session: the second replaces the version of the first",
        (
            _change(
                "voa_store.grouping:Groups._companions",
                ("member.item.id not in ids", "(member.item.id not in ids or True)"),
            ),
            _change("voa_store.changing:SessionWriter._store", _REPLACE),
        ),
        first=6,
    ),
    PlantedFault(
        "the idempotency key is not looked up",
        (
            _change("voa_store.responses:response_of", ("if key is None or", "if True or")),
            _change("voa_store.changing:_changed", ("if write.key is not None:", "if False:")),
            _change("voa_store.responses:keep_response", ("if key is not None:", "if False:")),
        ),
    ),
    PlantedFault(
        "the key is looked up before the lock is taken: a retry at the same moment applies twice",
        (
            _change(
                _COMMIT,
                (
                    _BEGIN,
                    "with transaction(self._engine) as earlier:\n"
                    "        before = stored_rows(earlier, [pending.write.key for pending in group])\n    " + _BEGIN,
                ),
                ("        before = stored_rows(connection, [pending.write.key for pending in group])\n", ""),
            ),
            _change("voa_store.changing:SessionWriter._store", _REPLACE),
        ),
    ),
    PlantedFault(
        "a response is stored under the wrong key",
        (
            _change("voa_store.responses:response_row", ("key.key", "key.key[:-1]")),
            _change("voa_store.responses:keep_response", ("_INSERT,", '_INSERT.prefix_with("OR REPLACE"),')),
            _change("voa_store.changing:SessionWriter._store", _REPLACE),
            _change("voa_store.responses:stored_rows", ("(key.scope, key.key)", "(key.scope, key.key[:-1])")),
            _change(
                "voa_store.responses:response_of",
                ("(key.scope, key.key)", "(key.scope, key.key[:-1])"),
                ("row.fingerprint != key.fingerprint", "row is None"),
            ),
        ),
    ),
    PlantedFault(
        "a write is answered before its commit",
        (
            _change(
                "voa_store.sql:transaction",
                (
                    "with _database_errors(engine), engine.begin() as connection:\n        yield connection",
                    "with _database_errors(engine):\n        connection = engine.connect()\n        try:\n"
                    "            begun = connection.begin()\n            yield connection\n"
                    "        except BaseException:\n            connection.close()\n            raise\n"
                    "        engine.pool.commit_delayed(begun, connection)",
                ),
            ),
        ),
    ),
    PlantedFault(
        "a version is published before its commit",
        (
            _change(
                "voa_service.usecases.updates:Updates._answer",
                (
                    "None if after is before else after, text)\n",
                    "None if after is before else after, text)\n    self._committed(before.id, change)\n",
                ),
            ),
        ),
    ),
    PlantedFault(
        "the version that a caller expects is not compared",
        (_change("voa_store.changing:check_version", ("version not in expected", "version < min(expected)")),),
    ),
    PlantedFault(
        "a read is answered from a stale cache",
        (
            _change(
                "voa_service.usecases.sessions:Sessions.response",
                ("mark.version, mark.updated_at,", "mark.version // 2,"),
            ),
        ),
    ),
    PlantedFault(
        "stored responses expire with the wrong sign",
        (_change("voa_store.sql:SqlStore.forget_responses", ("now - math.ceil", "now + math.ceil")),),
        first=18,
    ),
    PlantedFault(
        "announced looks expire with the wrong sign",
        (
            _change(
                "voa_service.mapping.under_way:announced_looks",
                ("now < look.expires_at <= now", "look.expires_at < now <= now"),
            ),
        ),
    ),
    PlantedFault(
        "an announced look replaces those of other robots",
        (
            _change(
                "voa_service.usecases.looks:AnnouncedLooks.announce",
                ("[*announced_looks(state.under_way, now), look]", "[look]"),
            ),
        ),
    ),
    PlantedFault(
        "a claim does not hold: a newer session takes the robot",
        (_change("voa_store.claims:_assignment", ("if session is not None:", "if session is None:")),),
        first=13,
    ),
    PlantedFault(
        "a look is lost where another process has used its number",
        (
            _change(
                "voa_service.zenoh.applying:apply_look",
                ("if outcome is not None:", "if outcome is None:\n            return None\n        if True:"),
            ),
        ),
        first=20,
    ),
    PlantedFault(
        "a look counts twice, because its digest is not compared",
        (_change("voa_service.zenoh.ledger:LookLedger._by_digest", ("look.digest == taken.digest", "False")),),
    ),
    PlantedFault(
        "a process that joins a session does not know the looks before",
        (_change("voa_service.zenoh.ledger:LookLedger._looks_before", ("look.number <= self._seen", "False")),),
        seeds=600,
        rare=True,
    ),
)

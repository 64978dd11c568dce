"""Faults of keys and roles that their tests must notice: each would let somebody in, or keep somebody out."""

from tests.mutants.mutant import Mutant

_RING = "service/voa_service/access/keyring.py"
_RING_TESTS = "tests/voa_service/access/test_keyring.py"
_GATE = "service/voa_service/access/gate.py"
_HTTP_TESTS = "tests/contract/test_keys.py"
_ZENOH_TESTS = "tests/contract/test_keys_on_zenoh.py"
_BINDING_TESTS = "tests/contract/test_bindings.py"
_CARRYING_TESTS = "tests/voa_store/test_carrying.py"

MUTANTS = (
    Mutant(
        name="a key is known by its id alone",
        file=_RING,
        old="known is None or not hmac.compare_digest(digest_of(text), known[0].digest)",
        new="known is None",
        tests=_RING_TESTS,
    ),
    Mutant(
        name="a revoked or expired key is valid",
        file=_RING,
        old="if not key.is_active(now):",
        new="if False:",
        tests=_RING_TESTS,
    ),
    Mutant(
        name="a service whose keys are gone opens again",
        file=_RING,
        old="self.is_closed = self.is_closed or bool(self._known)",
        new="self.is_closed = bool(self._known)",
        tests=_RING_TESTS,
    ),
    Mutant(
        name="every use is stored",
        file=_RING,
        old="at - key.last_used_at > _STORED_AFTER",
        new="at > key.last_used_at",
        tests=_RING_TESTS,
    ),
    Mutant(
        name="the first key does not end a stream of a caller without one",
        file=_RING,
        old="            return not self.is_closed\n",
        new="            return True\n",
        tests=_RING_TESTS,
    ),
    Mutant(
        name="a role is not checked",
        file=_GATE,
        old="        caller.check_role(call)\n",
        new="",
        tests=_HTTP_TESTS,
    ),
    Mutant(
        name="a key that is bound to a session is for every session",
        file=_GATE,
        old="        caller.check_subject(call, subject)\n",
        new="",
        tests=_HTTP_TESTS,
    ),
    Mutant(
        name="a request that is not in the table is for everybody",
        file="service/voa_service/access/roles.py",
        old='UNLISTED = Call("unlisted", OPERATORS)',
        new='UNLISTED = Call("unlisted", EVERYBODY)',
        tests="tests/voa_service/access/test_gate.py",
    ),
    Mutant(
        name="a remote call does not check the session that its key is for",
        file="service/voa_service/rpc/calls.py",
        old="        self.caller.check_session(taken.session)\n",
        new="",
        tests=_ZENOH_TESTS,
    ),
    Mutant(
        name="a scan that is put does not check what its key is for",
        file="service/voa_service/zenoh/scans.py",
        old="        scan.caller.check_acting(scan.session, scan.robot, self._services.acting)\n",
        new="",
        tests=_ZENOH_TESTS,
    ),
    Mutant(
        name="a remote call does not check the robots that its key is for",
        file="service/voa_service/rpc/calls.py",
        old="            self.caller.check_acting(session, robot, acting)\n",
        new="            pass\n",
        tests=_BINDING_TESTS,
    ),
    Mutant(
        name="a request does not check the robots that its key is for",
        file="service/voa_service/http/authentication.py",
        old="        caller.check_acting(session, robot, acting)\n",
        new="        pass\n",
        tests=_BINDING_TESTS,
    ),
    Mutant(
        name="every key withdraws announced looks",
        file="service/voa_service/usecases/looks.py",
        old="if by is not None and not is_marked(look, by):",
        new="if False:",
        tests=_BINDING_TESTS,
    ),
    Mutant(
        name="a list of sessions has those that a key is not for",
        file="service/voa_service/usecases/sessions.py",
        old="partial(self.store.list_sessions, only=only)",
        new="self.store.list_sessions",
        tests=_BINDING_TESTS,
    ),
    Mutant(
        name="a caller without a valid key is anybody, by HTTP",
        file=_GATE,
        old="            raise\n",
        new="            return ANONYMOUS\n",
        tests=_HTTP_TESTS,
    ),
    Mutant(
        name="a caller without a valid key is anybody, on Zenoh",
        file=_GATE,
        old="            raise\n",
        new="            return ANONYMOUS\n",
        tests=_ZENOH_TESTS,
    ),
    Mutant(
        name="calls without a valid key are not counted",
        file=_GATE,
        old="            self._rates.count_refused(origin, group)\n",
        new="",
        tests=_HTTP_TESTS,
    ),
    Mutant(
        name="calls that a key may not make are not counted",
        file=_GATE,
        old="        self._rates.count(caller)\n        caller.check_role(call)\n",
        new="        caller.check_role(call)\n        self._rates.count(caller)\n",
        tests="tests/voa_service/access/test_gate.py",
    ),
    Mutant(
        name="a service that requires keys is open until the first one",
        file=_RING,
        old="self.is_closed = required",
        new="self.is_closed = False",
        tests=_RING_TESTS,
    ),
    Mutant(
        name="a restored backup forgets the keys of the database before",
        file="service/voa_store/backups.py",
        old="carry_keys(kept, part)",
        new="carry_keys(None, part)",
        tests=_CARRYING_TESTS,
    ),
    Mutant(
        name="a restored key forgets that it was revoked",
        file="service/voa_store/carrying.py",
        old="if revoked is not None and",
        new="if False and",
        tests=_CARRYING_TESTS,
    ),
)

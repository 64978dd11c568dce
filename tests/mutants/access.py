"""Faults of keys and roles that their tests must notice: each would let somebody in, or keep somebody out."""

from tests.mutants.mutant import Mutant

_RING = "service/voa_service/access/keyring.py"
_RING_TESTS = "tests/voa_service/access/test_keyring.py"
_HTTP_TESTS = "tests/contract/test_keys.py"

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
        file="service/voa_service/access/gate.py",
        old="        caller.check_role(call)\n",
        new="",
        tests=_HTTP_TESTS,
    ),
    Mutant(
        name="a key that is bound to a session is for every session",
        file="service/voa_service/access/gate.py",
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
        tests="tests/contract/test_keys_on_zenoh.py",
    ),
    Mutant(
        name="a scan that is put does not check the robot that its key is for",
        file="service/voa_service/zenoh/scans.py",
        old="            caller.check_robot(robot)\n",
        new="",
        tests="tests/contract/test_keys_on_zenoh.py",
    ),
)

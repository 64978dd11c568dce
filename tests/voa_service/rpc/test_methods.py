"""The table of methods: the documented names, and for each the queue in which its calls wait."""

import re
from pathlib import Path

from tests.support.serving import Service
from voa_service.rpc.methods import methods_of

WRITES = {
    "belief.put",
    "look.announce",
    "look.cancel",
    "outcome.report",
    "scan.apply",
    "session.create",
    "session.delete",
    "object.delete",
    "scenario.delete",
}
HEAVY = {"ranking.compute", "scenario.create", "scenario.predict", "scenario.warnings", "voa.rank"}
RESTS = {"object.stable_poses", "object.mesh"}
CONTRACT = Path(__file__).resolve().parents[3] / "deploy" / "docs" / "contract.md"


def test_calls_wait_where_they_hold_up_nothing_that_is_quicker(service: Service) -> None:
    own = service.inside
    queues = {name: method.queue for name, method in methods_of(own).items()}
    assert {name for name, queue in queues.items() if queue is own.writes} == WRITES
    assert {name for name, queue in queues.items() if queue is own.heavy} == HEAVY
    assert {name for name, queue in queues.items() if queue is own.meshes} == {"object.create"}
    assert {name for name, queue in queues.items() if queue is own.rests} == RESTS
    assert {name for name, queue in queues.items() if queue is own.probes} == {"service.health"}
    others = {name for name, queue in queues.items() if queue is own.reads}
    assert others == set(queues) - WRITES - HEAVY - RESTS - {"object.create", "service.health"}


def test_every_method_is_documented(service: Service) -> None:
    documented = set(re.findall(r"`([a-z]+\.[a-z_]+)`", CONTRACT.read_text(encoding="utf-8")))
    assert set(methods_of(service.inside)) <= documented

"""Packed responses are read back byte for byte, are small, and every damage to them is noticed."""

import json
import secrets
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic_core import to_json
from sqlalchemy import text

from tests.support.serving import as_scan, box_obj, mesh_scenario, serving
from tests.voa_store.samples import (
    Open,
    Result,
    belief,
    change,
    create,
    engine_of,
    key,
    never,
    next_version,
    scenario,
    write,
)
from voa_store.drivers import sqlite_driver
from voa_store.errors import DamagedData
from voa_store.packing import is_packed, pack, unpack
from voa_store.records import SessionState, StoredResponse
from voa_store.rows import blob

NUMBERS = st.lists(st.floats(0.0, 1.0) | st.floats(1e-9, 1e-3), min_size=1, max_size=40)


def stored(p: list[float]) -> bytes:
    """A belief as the store has it, with logarithms that nobody reads here."""
    return np.array([p, p], dtype="<f8").tobytes()


@given(NUMBERS, st.text())
def test_a_packed_body_is_read_back(p: list[float], name: str) -> None:
    body = to_json({"poses": [name], "belief": p, "id": "x" * 80}).decode()
    assert unpack(pack(body, stored(p)), stored(p)) == body if is_packed(pack(body, stored(p))) else len(body) < 200
    other = pack(body, stored([0.5]))
    assert not is_packed(other) or unpack(other, stored([0.5])) == body, "a body with another belief"


@given(NUMBERS)
def test_the_numbers_of_a_belief_take_no_space(p: list[float]) -> None:
    """Stored beliefs are written as messages write them, and so are found in the response."""
    bodies = [
        to_json({"poses": ["P1"] * 9, "belief": each, "absent": None, "id": "x" * 40}).decode() for each in (p, [])
    ]
    lengths = [len(pack(body, stored(each))) for body, each in zip(bodies, (p, []), strict=True)]
    assert abs(lengths[0] - lengths[1]) <= 12


def test_what_would_be_longer_is_left_as_it_is() -> None:
    assert pack('{"id":"4f1c"}', stored([1.0])) == '{"id":"4f1c"}'
    assert not is_packed('{"id":"4f1c"}')


def flipped(data: bytes) -> Iterator[bytes]:
    """Every text that differs from `data` in one bit."""
    for place in range(8 * len(data)):
        other = bytearray(data)
        other[place // 8] ^= 1 << place % 8
        yield bytes(other)


def read(packed: str, held: bytes) -> str | None:
    """Unpack a response; None: damage was noticed."""
    try:
        return unpack(packed, held)
    except ValueError:
        return None


def test_every_flipped_bit_is_noticed() -> None:
    p = [0.25, 0.75]
    body = to_json({"poses": ["P1", "P2"], "belief": p, "best_grasp": "TOP", "expected_score": 0.123456}).decode()
    packed, held = pack(body, stored(p)), stored(p)
    assert is_packed(packed)
    texts = [other.decode("latin-1") for other in flipped(packed.encode("ascii"))]
    assert {read(text, held) for text in texts if is_packed(text)} <= {None, body}, "a bit of the padding may be unused"
    half = len(held) // 2  # the probabilities; the history's own checksum covers the logarithms
    assert {read(packed, other + held[half:]) for other in flipped(held[:half])} == {None}


RESPONSE = to_json({"scenario": "A", "belief": belief().p.tolist(), "warnings": [], "id": "S" * 99}).decode()


def test_a_repeated_call_gets_the_packed_response_until_its_history_is_gone(database_url: str, opened: Open) -> None:
    store = opened()
    store.put_scenario(scenario("A"))
    create(store, "S")

    def step(state: SessionState) -> Result:
        response, after, report = next_version(state)
        return Result(StoredResponse(RESPONSE, response.version), after, report)

    change(store, "S", write(key("K")), step)
    change(store, "S", write(), next_version)
    repeated = change(store, "S", write(key("K")), never)
    assert repeated == store.get_response(key("K")) == StoredResponse(RESPONSE, 1)
    engine = engine_of(database_url)
    with engine.begin() as connection:
        body = connection.execute(text("SELECT body FROM answers")).scalar_one()
        assert is_packed(body)
        wrong = blob(belief(0.3, 0.7))
        connection.execute(text("UPDATE history SET belief = :wrong WHERE version = 1"), {"wrong": wrong})
    with pytest.raises(DamagedData, match="version 1 of session 'S' differs"):
        store.get_response(key("K"))
    with engine.begin() as connection:
        connection.execute(text("DELETE FROM history"))
    engine.dispose()
    assert store.get_response(key("K")) is None


def size(file: Path) -> int:
    """Bytes of the pages of a database that are in use."""
    with closing(sqlite_driver().connect(str(file))) as connection:
        pages, free, each = (
            connection.execute(f"PRAGMA {name}").fetchone()[0] for name in ("page_count", "freelist_count", "page_size")
        )
    return int((pages - free) * each)


def test_a_key_makes_a_scan_of_360_beams_an_eighth_larger(tmp_path: Path) -> None:
    """The response was a third of it when it was stored as it was sent; with many poses, more than half."""
    scans, sizes = 60, {}
    for keyed in (False, True):
        folder = tmp_path / str(keyed)
        folder.mkdir()
        with serving(folder) as service:
            scenario = service.create(mesh_scenario(service.upload(box_obj())))
            session = service.open(scenario)
            seen = service.post(f"/v1/scenarios/{scenario}/predictions", {})["ranges"][0][0]
            seen = [0.123 if value is None else round(value, 3) for value in seen]
            before = size(service.database)
            for _ in range(scans):
                headers = {"Idempotency-Key": secrets.token_hex(16)} if keyed else {}
                answer = service.post(
                    f"/v1/sessions/{session}/scans", {"sensor": "E", "scan": as_scan(seen)}, **headers
                )
                assert answer["update"]["accepted"]
            sizes[keyed] = (size(service.database) - before) / scans
    assert sizes[True] < 1.2 * sizes[False], json.dumps(sizes)

"""The text of API keys: recognisable, random, and stored as a digest."""

import hashlib
import re

import pytest

from voa_service.access.keys import digest_of, id_of, new_key


def test_a_key_is_recognised_and_has_256_random_bits() -> None:
    keys = [new_key() for _ in range(50)]
    assert len({key.id for key in keys}) == len({key.text for key in keys}) == 50
    for key in keys:
        match = re.fullmatch(r"voa_([0-9a-f]{12})_([0-9a-f]{64})", key.text)
        assert match is not None
        assert match[1] == key.id == id_of(key.text)
        assert key.digest == hashlib.sha256(key.text.encode()).digest() == digest_of(key.text)
        assert match[2] not in key.id


@pytest.mark.parametrize("change", ["", " {}", "{} ", "{}0", "VOA{}", "voa_", "é", "\x00", "{}\n"])
def test_another_text_is_no_key(change: str) -> None:
    assert id_of(change.replace("{}", new_key().text)) is None

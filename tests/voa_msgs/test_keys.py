"""Keys on Zenoh: their form below a root, the roots that are valid, and the attachment beside a payload."""

import pytest
from pydantic import ValidationError

from voa_msgs.keys import CHUNK, ROOT, Attachment, Keys, check_root


def test_keys_have_the_documented_form_below_their_root() -> None:
    keys = Keys("voa/v1/lab")
    assert keys.scan("S", "r1") == "voa/v1/lab/scan/S/r1"
    assert keys.rpc("scan.apply") == "voa/v1/lab/rpc/scan.apply"
    assert keys.belief("*") == "voa/v1/lab/belief/*"
    assert keys.refused("S", "r1") == "voa/v1/lab/refused/S/r1"
    assert keys.replica("1") == "voa/v1/lab/replica/1"
    assert Keys().belief("S").startswith(f"{ROOT}/")


def test_the_last_chunk_names_the_subject_of_a_key() -> None:
    keys = Keys()
    assert [keys.last(keys.rpc("voa.rank")), keys.last(keys.belief("S"))] == ["voa.rank", "S"]


@pytest.mark.parametrize("root", [ROOT, "lab", "A-1/b_2/c.3"])
def test_a_root_of_valid_chunks_is_accepted(root: str) -> None:
    assert check_root(root) == root


@pytest.mark.parametrize("root", ["", "/voa", "voa/", "voa//v1", "voa/*", "voa/$*", "voa?x", "voa/ü", "a b"])
def test_a_root_with_another_chunk_is_refused_with_an_example(root: str) -> None:
    with pytest.raises(ValueError, match=f"expected a root like '{ROOT}'"):
        check_root(root)


def test_a_chunk_has_no_wildcard() -> None:
    assert CHUNK.fullmatch("tb3_1.lab-2")
    assert not any(CHUNK.fullmatch(text) for text in ("*", "**", "$*", "a/b", ""))


def test_an_attachment_names_at_most_one_place() -> None:
    pose = {"x": 0.0, "y": 0.0, "yaw_rad": 0.0}
    assert Attachment.model_validate({"sensor_pose": pose}).sensor is None
    with pytest.raises(ValidationError, match="at most one of 'sensor' and 'sensor_pose'"):
        Attachment.model_validate({"sensor": "Q1", "sensor_pose": pose})


@pytest.mark.parametrize("id_", ["", "a" * 256, "a\0"])
def test_an_idempotency_key_is_text_of_bounded_length(id_: str) -> None:
    assert Attachment(id="a" * 255).id == "a" * 255
    with pytest.raises(ValidationError):
        Attachment(id=id_)

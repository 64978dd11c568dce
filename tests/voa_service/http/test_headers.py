"""Headers of versions: an ETag that If-Match accepts again, and tags of another form that match no version."""

import pytest

from voa_service.http.headers import etag, versions


def test_the_etag_of_a_version_matches_that_version_alone() -> None:
    assert etag(3) == {"ETag": '"v3"'}
    assert versions(etag(3)["ETag"]) == frozenset({3})


@pytest.mark.parametrize("any_version", [None, "*", " * "])
def test_without_a_condition_any_version_matches(any_version: str | None) -> None:
    assert versions(any_version) is None


@pytest.mark.parametrize(
    ("if_match", "accepted"),
    [
        ('"v1", "v22"', {1, 22}),
        ("v7", {7}),
        ('W/"v1"', set()),
        ('"3"', set()),
        ('"v-1"', set()),
        ('"v1', set()),
        ('"v' + "9" * 19 + '"', set()),
        ("", set()),
        ('"other", "v2"', {2}),
    ],
)
def test_tags_of_another_form_match_no_version(if_match: str, accepted: set[int]) -> None:
    assert versions(if_match) == frozenset(accepted)

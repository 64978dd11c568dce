"""API keys of clients: where they come from, how they are sent, and that they are never shown."""

import asyncio
import os
from pathlib import Path

import httpx2
import pytest

from voa_client import (
    ApiKey,
    AsyncClient,
    AsyncHttpTransport,
    Client,
    DeniedError,
    HttpTransport,
    OverloadedError,
    Retries,
    UsageError,
)
from voa_client._api_key import attachment

ONE, TWO = f"voa_{'1' * 12}_{'a' * 64}", f"voa_{'2' * 12}_{'b' * 64}"
HERE = "http://service"
CALLER = '{"name":"a","role":"arm","key":"1","sessions":null,"robots":null,"expires_at":null,"calls":[]}'


@pytest.fixture
def file(tmp_path: Path) -> Path:
    file = tmp_path / "a.key"
    file.write_text(f"{TWO}\n")
    return file


def test_the_given_key_wins_over_the_environment_and_a_variable_over_a_file(file: Path) -> None:
    environment = {"VOA_KEY": ONE, "VOA_KEY_FILE": str(file)}
    assert ApiKey.given(TWO, None, environment).text() == TWO
    assert ApiKey.given(None, file, {"VOA_KEY": ONE}).text() == TWO
    assert ApiKey.given(None, None, environment).text() == ONE
    assert ApiKey.given(None, None, {"VOA_KEY": "", "VOA_KEY_FILE": str(file)}).text() == TWO
    none = ApiKey.given(None, None, {"VOA_KEY": " ", "VOA_KEY_FILE": ""})
    assert (none.text(), none.headers()) == (None, {})
    assert ApiKey(ONE).headers() == {"Authorization": f"Bearer {ONE}"}
    with pytest.raises(UsageError, match="got both"):
        ApiKey.given(ONE, file)


def test_a_key_is_not_shown(file: Path) -> None:
    for key in (ApiKey(ONE), ApiKey(file=file)):
        assert repr(key) == str(key) == "ApiKey(hidden)"
    assert repr(ApiKey()) == "ApiKey(none)"
    with Client(HERE, key=ONE) as client:
        assert ONE not in repr(client)
        assert ONE not in repr(vars(client))


@pytest.mark.parametrize("text", ["", " ", "a b", "ü", "a\nb: c", "a\x00", "a" * 513])
def test_a_text_that_cannot_be_sent_is_refused_without_being_shown(text: str, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="voa keys create") as refused:
        ApiKey(text)
    assert text.strip() == "" or text not in str(refused.value)
    (tmp_path / "wrong.key").write_text(text)
    if "\n" not in text:
        with pytest.raises(UsageError, match="voa keys create"):
            ApiKey(file=tmp_path / "wrong.key")


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"cannot read the key file .*none\.key: No such file"):
        Client(HERE, key_file=tmp_path / "none.key")
    (tmp_path / "picture").write_bytes(b"\xff\xfe")
    with pytest.raises(UsageError, match="it is not text"):
        ApiKey(file=tmp_path / "picture")


def test_a_file_is_read_again_when_it_changes(file: Path) -> None:
    key = ApiKey(file=file)
    assert key.text() == TWO
    file.write_text(ONE)
    os.utime(file, ns=(1, 1))
    assert key.text() == ONE
    file.write_text("not a key")
    os.utime(file, ns=(2, 2))
    assert key.text() == ONE, "it is being replaced"
    file.unlink()
    assert key.text() == ONE


def test_a_client_sends_its_key_with_every_request(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[str | None] = []

    def answer(request: httpx2.Request) -> httpx2.Response:
        seen.append(request.headers.get("authorization"))
        return httpx2.Response(200, text=CALLER)

    def caller_by(key: ApiKey | None) -> None:
        with Client(HttpTransport(HERE, httpx2.MockTransport(answer), key)) as client:
            assert client.caller().role == "arm"

        async def main() -> None:
            async with AsyncClient(AsyncHttpTransport(HERE, httpx2.MockTransport(answer), key)) as twin:
                assert (await twin.caller()).role == "arm"

        asyncio.run(main())

    monkeypatch.delenv("VOA_KEY", raising=False)
    monkeypatch.delenv("VOA_KEY_FILE", raising=False)
    caller_by(None)
    caller_by(ApiKey(ONE))
    monkeypatch.setenv("VOA_KEY_FILE", str(file))
    caller_by(None)
    assert seen == [None, None, *[f"Bearer {ONE}"] * 2, *[f"Bearer {TWO}"] * 2]


def test_an_attachment_has_the_key() -> None:
    assert attachment("id", ApiKey(ONE)) == f'{{"id":"id","key":"{ONE}","wire":1}}'
    assert attachment(None, ApiKey()) == '{"wire":1}'


def test_a_transport_has_a_key_of_its_own(file: Path) -> None:
    with pytest.raises(UsageError, match="give it to the transport"):
        Client(HttpTransport(HERE), key=ONE)
    with pytest.raises(UsageError, match="give it to the transport"):
        AsyncClient(AsyncHttpTransport(HERE), key_file=file)


@pytest.mark.parametrize(
    ("status", "kind", "error", "says"),
    [
        (401, "unauthenticated", DeniedError, "needs a key; name a file with a key in VOA_KEY_FILE"),
        (403, "forbidden", DeniedError, "Title: needs a key"),
        (429, "too-many-without-key", DeniedError, "needs a key; name a file with a key in VOA_KEY_FILE"),
        (429, "too-many-requests", OverloadedError, "Title: needs a key"),
    ],
)
def test_a_refusal_is_a_plain_sentence(status: int, kind: str, error: type[DeniedError], says: str) -> None:
    problem = {"type": f"urn:voa:problem:{kind}", "title": "Title", "status": status, "detail": "needs a key"}

    def answer(request: httpx2.Request) -> httpx2.Response:
        headers = {"content-type": "application/problem+json", "Retry-After": "7"}
        return httpx2.Response(status, json=problem, headers=headers)

    network = httpx2.MockTransport(answer)
    transport, once = HttpTransport(HERE, network, ApiKey(ONE)), Retries(within_s=0.0)
    with Client(transport, retries=once) as client, pytest.raises(error) as refused:
        client.caller()
    assert says in str(refused.value)
    assert ONE not in str(refused.value)

"""Sync and async clients have equal names and arguments, and Zenoh is imported only when it is used."""

import asyncio
import inspect
import pkgutil
import re
import subprocess
import sys
from typing import Any, get_args, get_type_hints

import pytest

import voa_client
from voa_client import ArmClient, AsyncArmClient, AsyncClient, AsyncSensorClient, Client, SensorClient, UsageError
from voa_client._http import AsyncHttpTransport, HttpTransport
from voa_client._in_process import AsyncInProcessTransport, InProcessTransport
from voa_client._transport import AsyncTransport, Transport
from voa_client._zenoh import AsyncZenohTransport, ZenohTransport
from voa_msgs.base import Message

TWINS: list[tuple[type[Any], type[Any]]] = [
    (Client, AsyncClient),
    (SensorClient, AsyncSensorClient),
    (ArmClient, AsyncArmClient),
    (HttpTransport, AsyncHttpTransport),
    (ZenohTransport, AsyncZenohTransport),
    (InProcessTransport, AsyncInProcessTransport),
    (Transport, AsyncTransport),
]


def surface(kind: type[Any]) -> dict[str, list[tuple[str, object, object]]]:
    """Public methods and constructor, with names, kinds and defaults of their arguments."""
    return {
        name: [
            (each.name, each.kind, None if each.name == "sleep" else each.default)
            for each in inspect.signature(method).parameters.values()
        ]
        for name, method in inspect.getmembers(kind, callable)
        if not name.startswith("_") or name == "__init__"
    }


@pytest.mark.parametrize(("sync", "twin"), TWINS, ids=lambda kind: kind.__name__)
def test_twins_have_the_same_surface(sync: type[Any], twin: type[Any]) -> None:
    assert surface(sync) == surface(twin)
    assert len(surface(sync)) > 3


@pytest.mark.parametrize(("sync", "twin"), [*TWINS[:3], TWINS[-1]], ids=lambda kind: kind.__name__)
def test_twins_have_the_same_documentation(sync: type[Any], twin: type[Any]) -> None:
    for name in surface(sync).keys() - {"__init__"}:
        assert getattr(twin, name).__doc__ == getattr(sync, name).__doc__, name


@pytest.mark.parametrize(("sync", "twin"), TWINS[:3], ids=lambda kind: kind.__name__)
def test_every_method_of_a_twin_is_awaited_or_iterated(sync: type[Any], twin: type[Any]) -> None:
    for name in surface(sync).keys() - {"__init__"}:
        method = getattr(twin, name)
        returns = inspect.signature(method).return_annotation
        awaited = inspect.iscoroutinefunction(method)
        assert awaited or str(returns).startswith("collections.abc.Async"), name
        assert not inspect.iscoroutinefunction(getattr(sync, name)), name


def test_everything_imports_without_zenoh_and_says_how_to_get_it() -> None:
    names = [f"voa_client.{module.name}" for module in pkgutil.iter_modules(voa_client.__path__)]
    assert "voa_client._zenoh" in names
    program = (
        "import sys, importlib\n"
        "sys.modules['zenoh'] = None\n"
        f"for name in {names!r}: importlib.import_module(name)\n"
        "from voa_client import Client, AsyncClient, VoaClientError\n"
        "for kind in (Client, AsyncClient):\n"
        "    try: kind('zenoh://127.0.0.1')\n"
        "    except VoaClientError as error: print(error)\n"
    )
    done = subprocess.run([sys.executable, "-W", "error", "-c", program], capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert done.stdout.count("pip install 'PATH_TO_CLONE[zenoh]'") == 2


PUBLIC_MODULES = {"formatting", "installing", "local", "message_files", "scenario_files", "zenoh_session"}
CLIENTS = {"ArmClient", "AsyncArmClient", "AsyncClient", "AsyncSensorClient", "Client", "SensorClient"}
OF_CLIENTS = {"ApiKey", "next_look", "poses_of", "Retries", "TakenLook", "Tour", "Waited", "ZenohAddress"}
TRANSPORTS = {f"{twin}{kind}Transport" for twin in ("", "Async") for kind in ("", "Http", "InProcess", "Zenoh")}
MESSAGES = {
    *(
        "BeliefRequest",
        "CandidateSensor",
        "GraspGeometry",
        "GraspNow",
        "Health",
        "HistoryEntry",
        "LidarPresets",
        "Look",
        "Object",
    ),
    *(
        "OutcomeRequest",
        "PoseUncertainty",
        "Predictions",
        "PredictionsRequest",
        "Problem",
        "RankedGrasp",
        "RankedGrasps",
        "RankedSensor",
        "Ranking",
    ),
    *("AnnouncedLook", "Caller", "GraspGeometry", "Location", "LookAnnouncement", "Place", "Spread"),
    *("RankingRequest", "RobotReport", "RobotScan", "Robots", "Scan", "ScanRequest", "Scenario", "ScenarioRequest"),
    *("ScenarioSummary", "SensorPose", "Session", "SessionRequest", "SessionSummary", "StablePoses"),
    *("UncertainSensorPose", "UpdateRequest", "UpdatedEstimate", "UpdatedSession", "VoaRequest", "Warnings"),
}
ERRORS = {
    *("ConflictError", "DeniedError", "InvalidRequestError", "NotFoundError", "OverloadedError", "ProblemError"),
    *("StaleVersionError", "TimedOutError", "UnavailableError", "UnexpectedResponseError", "UnreachableError"),
    *("UsageError", "VoaClientError", "WireVersionError"),
}


def test_the_public_names_are_these() -> None:
    assert set(voa_client.__all__) == CLIENTS | OF_CLIENTS | TRANSPORTS | MESSAGES | ERRORS
    assert len(voa_client.__all__) == len(set(voa_client.__all__))


@pytest.mark.parametrize("name", voa_client.__all__)
def test_a_public_name_says_what_it_is(name: str) -> None:
    assert getattr(voa_client, name).__doc__


def test_the_public_modules_are_these_and_listed_in_the_docstring_of_the_package() -> None:
    names = {module.name for module in pkgutil.iter_modules(voa_client.__path__)}
    assert {name for name in names if not name.startswith("_")} == PUBLIC_MODULES
    listed = re.findall(r"^\| `voa_client\.(\w+)` \|", voa_client.__doc__ or "", re.MULTILINE)
    assert sorted(listed) == sorted(PUBLIC_MODULES)


def messages_of(client: type[Any]) -> set[type[Message]]:
    """Messages in the signatures of a client's public methods."""
    kinds: set[type[Message]] = set()
    for name, method in inspect.getmembers(client, inspect.isfunction):
        if not name.startswith("_"):
            todo = list(get_type_hints(method).values())
            while todo:
                hint = todo.pop()
                todo.extend(get_args(hint))
                if isinstance(hint, type) and issubclass(hint, Message):
                    kinds.add(hint)
    return kinds


@pytest.mark.parametrize("client", [Client, SensorClient, ArmClient])
def test_every_message_that_a_client_takes_or_returns_is_public(client: type[Any]) -> None:
    messages = messages_of(client)
    assert len(messages) > 2
    assert {kind.__name__ for kind in messages} <= MESSAGES


@pytest.mark.parametrize(
    ("address", "kind"),
    [
        ("http://127.0.0.1:8000", HttpTransport),
        ("https://lab/voa", HttpTransport),
        ("zenoh://127.0.0.1:1", ZenohTransport),
        ("tcp/127.0.0.1:1", ZenohTransport),
    ],
)
def test_the_address_decides_on_the_transport(address: str, kind: type[Any]) -> None:
    with Client(address) as client:
        assert type(client._transport) is kind

    async def main() -> str:
        async with AsyncClient(address) as twin:
            return type(twin._transport).__name__

    assert asyncio.run(main()) == f"Async{kind.__name__}"


@pytest.mark.parametrize("address", ["ftp://lab", "127.0.0.1:8000", "", "lab", "mqtt/lab:1"])
@pytest.mark.parametrize("kind", [Client, AsyncClient])
def test_an_unknown_scheme_lists_those_that_exist(address: str, kind: type[Any]) -> None:
    with pytest.raises(UsageError, match=r"http://, https://, zenoh://, zenoh\+tls://"):
        kind(address)


@pytest.mark.parametrize(
    "address", ["http://", "http://lab:port", "zenoh://", "zenoh://lab:port", "zenoh://lab/*", "tcp/"]
)
def test_an_address_that_is_none_is_refused_here(address: str) -> None:
    with pytest.raises(UsageError), Client(address, timeout_s=0.5):
        raise AssertionError("a client of nothing")

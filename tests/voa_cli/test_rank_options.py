"""Options of `voa rank`: the request that they make, and options that are refused."""

import json
import math
from typing import Any

import pytest

from voa_cli.rank_options import process_options, read_options, request_of


def request(*arguments: str) -> Any:
    """The body of the request that some options make."""
    options = read_options(None, ["scenario.json", *arguments])
    return json.loads(request_of(options).model_dump_json(exclude_unset=True))


def test_without_options_the_service_decides() -> None:
    assert request() == {}


def test_every_option_is_a_field_of_the_request() -> None:
    given = [
        "--scans",
        "simulated",
        "--samples",
        "8",
        "--method",
        "exact",
        "--definition",
        "executed",
        "--sensor-std",
        "0.01,90",
    ]
    given += ["--lookahead", "1", "--from", "Q1", "--cost-per-m", "0.05", "--pending", "Q1", "Q2", "--grasps", "G1"]
    assert request(*given) == {
        "scans": "simulated",
        "samples": 8,
        "method": "exact",
        "definition": "executed",
        "sensor_std": {"xy_m": 0.01, "yaw_rad": pytest.approx(math.pi / 2.0)},
        "lookahead": 1,
        "from": "Q1",
        "cost_per_m": 0.05,
        "pending": ["Q1", "Q2"],
        "grasps": ["G1"],
    }


@pytest.mark.parametrize(
    ("text", "point"),
    [
        ("0.5,-0.2", {"x": 0.5, "y": -0.2}),
        ("-1,2", {"x": -1.0, "y": 2.0}),
        ("left", "left"),
        ("a,b", "a,b"),
        ("1,2,3", "1,2,3"),
        ("nan,0", "nan,0"),
    ],
)
def test_a_departure_is_a_point_or_a_name(text: str, point: object) -> None:
    assert request(f"--from={text}")["from"] == point


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--sensor-std", "0.01"], "expected metres and degrees"),
        (["--sensor-std=-0.01,1"], "expected metres and degrees"),
        (["--sensor-std", "0.01,inf"], "expected metres and degrees"),
        (["--samples", "0"], "expected a whole number from 1 to 4096, got '0'"),
        (["--samples", "4097"], "expected a whole number from 1 to 4096"),
        (["--samples", "many"], "expected a whole number"),
        (["--lookahead", "3"], "invalid choice"),
        (["--cost-per-m", "0.1"], "--cost-per-m needs --from"),
        (["--from", "Q1", "--cost-per-m=-1"], "expected a number of at least 0, got '-1'"),
        (["--from", "Q1", "--cost-per-m=nan"], "expected a number of at least 0"),
        (["--local", "--url", "http://127.0.0.1:9"], "it takes neither --session nor --url"),
        (["--local", "--picture", "ranking.png"], "--picture needs a service"),
        (["--cluster", "local:2", "--url", "http://127.0.0.1:9"], "it takes neither --session nor --url"),
    ],
)
def test_an_option_that_is_not_valid_is_a_usage_error(
    arguments: list[str], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        read_options(None, ["scenario.json", *arguments])
    assert ended.value.code == 2
    assert says in capsys.readouterr().err


def test_a_cluster_and_a_folder_of_results_are_options_of_the_process_that_ranks() -> None:
    options = read_options(None, ["scenario.json", "--cluster", "tcp://head:8786", "--resume", "parts"])
    assert options.local
    assert process_options(options) == ["--cluster", "tcp://head:8786", "--resume", "parts"]
    assert process_options(read_options(None, ["scenario.json", "--local"])) == []
    assert not read_options(None, ["scenario.json"]).local

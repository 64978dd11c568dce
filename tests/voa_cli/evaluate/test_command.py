"""`voa evaluate all` against the real service: the report agrees with its CSV files, and comes out again."""

import csv
import json
import os
import re
import shutil
from collections import Counter
from collections.abc import Iterator
from html import escape, unescape
from pathlib import Path
from typing import Any

import pytest

from tests.support import recorded
from tests.support.evaluations import FEW_SCANS
from voa_assets import path
from voa_cli.evaluate import command as evaluate
from voa_cli.evaluate.looks import QUICK_NOTICE
from voa_client import Client
from voa_evaluation.looks.requests import estimate_before_look, register
from voa_evaluation.looks.running import measure_scores
from voa_evaluation.looks.setting import BELIEFS, EVALUATED_RULES, Setting
from voa_fleet.episodes.policies import POLICIES
from voa_fleet.world.objects import FleetObject
from voa_recordings.selection import MATCHED, NOT_STATED, WHOLE

TINY = ("--drops", "1", "--attempts", "1", "--sensitivity-drops", "1", "--quick", "--seed", "5")
LAB = Path(os.environ.get("VOA_LAB_HOLDER", Path(__file__).resolve().parents[4] / "shared" / "lab-holder"))
needs_lab = pytest.mark.skipif(
    not LAB.is_dir(), reason=f"the lab's data are not at {LAB}; VOA_LAB_HOLDER names another place"
)


def rows_of(file: Path) -> list[dict[str, str]]:
    with file.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(lines))


@pytest.fixture(autouse=True, scope="module")
def few_scans() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("voa_cli.evaluate.values.QUICK", FEW_SCANS)
        yield


@pytest.fixture(scope="module")
def reported(tmp_path_factory: pytest.TempPathFactory, process: str) -> Path:
    """The page of the block, a few drops; its files."""
    folder: Path = tmp_path_factory.mktemp("all")
    assert evaluate.main(["all", "--object", "block", *TINY, "--url", process, "--out", str(folder)]) == 0
    return folder


def test_the_same_seed_gives_the_same_files_and_json_is_one_document(
    reported: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # Against a service of its own this time: nothing of the first run is left in it.
    assert evaluate.main(["all", "--object", "block", *TINY, "--out", str(tmp_path), "--json"]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    report = json.loads(said.out)
    assert set(report) == {"values", "grasp-score", "observation", "voa"}
    assert report["values"]["setting"]["seed"] == 5
    assert (report["voa"]["drops"], report["voa"]["seed"]) == (1, 5)
    assert len(report["voa"]["policies"]) == 2 * len(BELIEFS) * len(EVALUATED_RULES) * len(POLICIES)
    files = sorted(file.name for file in reported.iterdir())
    assert files == sorted(file.name for file in tmp_path.iterdir())
    assert {
        "report.html",
        "report.md",
        "values-ways.csv",
        "voa-looks.csv",
        "grasp-score-block.csv",
        "observation-block-sensors.csv",
    } <= set(files)
    different = [name for name in files if (reported / name).read_bytes() != (tmp_path / name).read_bytes()]
    assert different == []


def test_totals_of_the_page_are_those_of_the_rows(reported: Path) -> None:
    page = (reported / "report.html").read_text(encoding="utf-8")
    counted: Counter[tuple[str, str, str]] = Counter()
    drops: Counter[tuple[str, str, str]] = Counter()
    for row in rows_of(reported / "voa-choices.csv"):
        key = row["belief"], row["rule"], row["policy"]
        counted[key] += int(row["success"])
        drops[key] += 1
    policies = [row for row in rows_of(reported / "voa-policies.csv") if row["object"] == "all"]
    assert len(policies) == len(BELIEFS) * len(EVALUATED_RULES) * len(POLICIES)
    for row in policies:
        key = row["belief"], row["rule"], row["policy"]
        assert (int(row["successes"]), int(row["drops"])) == (counted[key], drops[key])
        assert f'<td class="number">{counted[key]}/{drops[key]} (' in page


def test_every_look_is_in_the_rows_and_counts_there(reported: Path) -> None:
    looks = rows_of(reported / "voa-looks.csv")
    assert len(looks) == len(BELIEFS) * len(EVALUATED_RULES) * 9
    by_place: Counter[tuple[str, str, str]] = Counter()
    for look in looks:
        by_place[look["belief"], look["rule"], look["sensor"]] += int(look["success"])
    for row in rows_of(reported / "voa-worth.csv"):
        own, blind = (by_place[row["belief"], row["rule"], sensor] for sensor in (row["sensor"], "none"))
        assert (int(row["successes_with"]), int(row["successes_without"])) == (own, blind)
        assert float(row["achieved"]) == pytest.approx((own - blind) / int(row["drops"]), abs=1e-6)
    points: Counter[tuple[str, str, str, str]] = Counter()
    for point in rows_of(reported / "voa-sensitivity-drops.csv"):
        points[point["disturbance"], point["level"], point["stated"], point["rule"]] += int(point["success"])
    for row in rows_of(reported / "voa-sensitivity.csv"):
        assert int(row["successes"]) == points[row["disturbance"], row["level"], row["stated"], row["rule"]]


def test_the_page_needs_nothing_beside_it(reported: Path) -> None:
    page = (reported / "report.html").read_text(encoding="utf-8")
    pictures = [file for file in reported.iterdir() if file.suffix == ".png"]
    assert page.count('src="data:image/png;base64,') == page.count("<img ") == len(pictures)
    assert "://" not in page
    assert "<script" not in page
    assert (
        "voa evaluate all --object block --seed 5 --drops 1 --attempts 1 --sensitivity-drops 1 --quick --out DIR"
        in page
    )
    assert "Negative" in page
    titles = re.findall("<h2>(.+?)</h2>", page)
    assert titles[0] == "The answer"
    assert titles[-1] == "The paper&#39;s own evaluation"
    paper = page.partition('<section id="paper">')[2]
    assert paper.index("comparisons of VOA with another policy") < paper.index("<details>")
    for title in ("Grasp scores", "Observation prediction", "Values of looks"):
        assert f"<details><summary>{title}</summary>" in paper
    assert page.index(f'<p class="notice">{escape(QUICK_NOTICE)}</p>') < page.index("<section")
    assert "figures mean nothing" in QUICK_NOTICE


def test_voa_is_what_the_services_answers_to_predicted_scans_give(
    process: str, targets: dict[str, FleetObject]
) -> None:
    """The ranking against equation 3 of the paper over updates by the predicted scans."""
    block = targets["block"]
    scores = measure_scores(block, Setting(attempts=1))
    belief = [0.4, 0.1, 0.1, 0.2, 0.1, 0.1]
    with Client(process) as client:
        registered = register(client, block, scores, ["beam", "inverse_rmsd"])
        for rule, scenario in registered.scenarios.items():
            before = estimate_before_look(client, scenario, belief)
            for place, voa in enumerate(before.voa):
                joint = registered.forecasts[rule].likelihoods[place] * belief
                after = joint / joint.sum(axis=1, keepdims=True)
                best = (after @ [[float(q) for q in row] for row in zip(*scores.successes, strict=True)]).max(axis=1)
                assert voa == pytest.approx(float(best @ belief) - before.score, abs=1e-9)


@needs_lab
def test_the_labs_error_comes_out(process: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["all", "--recorded", str(LAB), "--url", process, "--out", str(tmp_path), "--json"]
    assert evaluate.main(arguments) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["observation"]["overall"]["median_abs"] == pytest.approx(2.3, abs=0.05)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "differ by less than 2.3 mm" in page
    expected = json.loads((LAB / "expected.json").read_bytes())
    for row in rows_of(tmp_path / "voa-recorded.csv"):
        want = expected["rules"].get(row["rule"], {}).get(row["sensor"])
        if want is not None:
            assert float(row["voa"]) == pytest.approx(want["voa"], abs=1e-6)
            assert float(row["aecd"]) == pytest.approx(want["aecd"], abs=1e-6)


def test_a_recorded_experiment_of_names_alone_with_a_pair_missing(
    process: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scans = [row for row in recorded.rows() if row[:2] != ("Q2", "P2")]
    experiment: dict[str, Any] = recorded.experiment(name="lab 3/4: tiny")
    folder = recorded.write(tmp_path / "tiny", experiment, scans)
    out = tmp_path / "out"
    assert evaluate.main(["all", "--recorded", str(folder), "--url", process, "--out", str(out)]) == 0
    assert "report.html" in capsys.readouterr().out
    assert 'class="notice"' not in (out / "report.html").read_text(encoding="utf-8")
    rows = {(row["rule"], row["sensor"]): row for row in rows_of(out / "voa-recorded.csv")}
    assert {rule for rule, _ in rows} == set(EVALUATED_RULES)
    assert rows["exponential", "Q2"]["aecd"] == ""
    assert rows["exponential", "Q2"]["poses_measured"] == "1"
    page = (out / "report.html").read_text(encoding="utf-8")
    assert '<td class="number">1/2</td>' in page
    assert (out / "observation-lab-3-4-tiny-sensors.csv").is_file()


@pytest.mark.parametrize(
    ("stated", "says"),
    [({}, NOT_STATED), ({"selection": "whole"}, WHOLE), ({"selection": "matched"}, MATCHED)],
    ids=["not stated", "whole", "matched"],
)
def test_the_page_and_the_terminal_say_how_the_rows_were_chosen(
    process: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], stated: dict[str, str], says: str
) -> None:
    folder = recorded.write(tmp_path / "tiny", recorded.experiment(**stated))
    for part in ("all", "observation"):
        more = ["--url", process] if part == "all" else []
        assert evaluate.main([part, "--recorded", str(folder), "--out", str(tmp_path / "out"), *more]) == 0
        out = " ".join(capsys.readouterr().out.split())
        assert [sentence for sentence in (NOT_STATED, WHOLE, MATCHED) if sentence in out] == [says]
    page = unescape((tmp_path / "out" / "report.html").read_text(encoding="utf-8"))
    assert says in page
    assert ('class="notice"' in page) == (says == MATCHED)


def test_a_recorded_experiment_by_its_mesh(process: str, tmp_path: Path) -> None:
    folder = tmp_path / "mug"
    shutil.copytree(path("experiments/mug"), folder)
    rows = rows_of(folder / "scans.csv")
    with (folder / "scans.csv").open("w", encoding="utf-8", newline="") as lines:
        writer = csv.DictWriter(lines, list(rows[0]))
        writer.writeheader()
        writer.writerows(row | {"predicted": ""} for row in rows)
    assert evaluate.main(["all", "--recorded", str(folder), "--url", process, "--out", str(tmp_path / "out")]) == 0
    assert "Predictions are from the mesh" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def test_what_is_wrong_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert evaluate.main(["all", "--recorded", str(tmp_path), "--out", str(tmp_path / "out")]) == 1
    assert "experiment.json" in capsys.readouterr().err
    assert evaluate.main(["voa", "--object", "teapot", "--out", str(tmp_path / "out")]) == 1
    assert "no object 'teapot'; there are: mug, mallet, block, goblet, coupling, a folder" in capsys.readouterr().err

"""Rows of scans.csv come back as they were written."""

import csv
from pathlib import Path

from voa_recordings.experiment_parts import ExperimentLidar
from voa_recordings.experiment_rows import Beam, BeamRow, beam_row, raw_rows, rows_of_scan, write_rows


def test_rows_come_back_as_they_were_written(tmp_path: Path) -> None:
    lidar = ExperimentLidar(beams=1000, angle_min_deg=-180.0, angle_increment_deg=0.36)
    written = [
        BeamRow("N, far", "P 1", 0.05, Beam(index, round(0.123456 + index / 100, 6), None if index == 7 else 0.1))
        for index in range(999)
    ]
    file = tmp_path / "scans.csv"
    write_rows(file, written, lidar)
    with file.open(encoding="utf-8", newline="") as lines:
        assert [beam_row(cells, lidar, {"N, far"}, {"P 1"}) for _, cells in raw_rows(file, lines)] == written


def test_a_beam_without_any_range_has_a_row_only_in_the_window() -> None:
    rows = rows_of_scan("Q1", "P1", None, None, [None, 0.4, None, None], {2})
    assert [row.beam for row in rows] == [Beam(1, None, 0.4), Beam(2, None, None)]
    rows = rows_of_scan("Q1", "P1", None, [0.3, None, None, None], [None, 0.4, None, None])
    assert [row.beam for row in rows] == [Beam(0, 0.3, None), Beam(1, None, 0.4)]


def test_the_header_is_that_of_the_format(tmp_path: Path) -> None:
    write_rows(tmp_path / "scans.csv", [], ExperimentLidar())
    with (tmp_path / "scans.csv").open(encoding="utf-8", newline="") as lines:
        assert next(csv.reader(lines)) == ["sensor", "pose", "plane_height", "angle_deg", "measured", "predicted"]

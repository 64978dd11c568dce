"""An evaluation with so few scans that it takes seconds."""

from dataclasses import replace

from voa_evaluation.values.setting import QUICK, ROBOT_ERRORS

FEW_SCANS = replace(QUICK, scans=8, beliefs=2, sessions=3, drops=1, rules=("beam",), robot_errors=ROBOT_ERRORS[1:2])
"""Stands for `voa_cli.evaluate.values.QUICK`."""

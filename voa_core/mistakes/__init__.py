"""Probable mistakes in scenarios and scans that can be computed all the same; no result depends on them.

`scenarios.mistakes_of_scenario` searches a scenario, and `scans.mistakes_of_scan` a scan.
"""

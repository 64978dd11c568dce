"""Probable mistakes in scenarios and scans that can be computed all the same.

Nothing here changes a result. Scenarios: `scenarios.mistakes_of_scenario`; scans: `scans.mistakes_of_scan`.
"""

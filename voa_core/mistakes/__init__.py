"""What is probably a mistake in a scenario or a scan that can be computed all the same.

Nothing here changes a result. Scenarios: `scenarios.mistakes_of_scenario`; scans: `scans.mistakes_of_scan`.
"""

"""Page Robots: checks with advice, what each robot is doing, its last refusals, and its newest scan from above.

| module         | contents                                                                              |
|----------------|---------------------------------------------------------------------------------------|
| `watching`     | the checks and scans, once for all open pages                                         |
| `previews`     | the newest scan of each robot, with its scenario and comparison                       |
| `readings`     | a scan as measured, mirrored or turned                                                |
| `comparing`    | mirror and rotation test: the service compares each reading with the poses            |
| `repairs`      | repair of a lidar that is mirrored or turned                                          |
| `doing`        | sentences about a robot                                                               |
| `chart`        | chart of a scan from above                                                            |
| `scan_panel`   | the chart with the buttons of its readings, as elements                               |
| `checklists`   | lists of findings as elements                                                         |
| `wording`      | findings about the service in plain words                                             |
| `snippets`     | text that a person copies, as an element                                              |
| `sections`     | the section of a robot                                                                |
| `mapping_help` | help for a laboratory without robots                                                  |
| `page`         | the page                                                                              |
"""

from voa_console.robots import page


def register() -> None:
    """Declare the page `/robots`."""
    page.register()

"""The third evaluation of the paper: what looks are worth beforehand, and what they achieved.

| to                                                  | see                    |
|-----------------------------------------------------|------------------------|
| say what is evaluated                               | `setting`              |
| drop the object, take scans of it, attempt grasps   | `dropping`             |
| ask the service                                     | `asking`               |
| choose a look                                       | `policies`             |
| run it all and keep one row per look                | `running`, `rows`      |
| vary what goes wrong                                | `sensitivity`          |
| means, intervals, rank correlation, calibration     | `statistics`           |
| figures from rows                                   | `worth`, `outcomes`, `calibration` |
| say in words what came out                          | `findings`             |
| tables as CSV, pictures, the page                   | `tables`, `pictures`, `page`, `sections` |
| recorded experiments                                | `recorded`             |
"""

"""Load: how many sessions at 5 Hz a service carries, what a scan costs, and how it refuses more.

`make load` starts a service on SQLite, one on PostgreSQL, and two replicas behind HAProxy, and drives robots against
each until it refuses or is late. It prints a table and writes `build/load.json`; deploy/docs/load.md has figures.

| module     | purpose                                                                          |
|------------|----------------------------------------------------------------------------------|
| `services` | starts the services that are measured                                            |
| `scans`    | the bodies that robots send: scans of a shipped scenario, simulated              |
| `robots`   | a process of Locust that plays robots, which send scans by HTTP                  |
| `bus_robots` | a process of robots that put scans on Zenoh                                    |
| `rounds`   | one number of sessions after another, each measured for some seconds             |
| `steps`    | figures that were measured with one number of sessions                           |
| `usage`    | CPU time of processes                                                            |
| `report`   | the table, and the JSON                                                          |
"""

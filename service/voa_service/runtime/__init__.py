"""The running process: its threads, caches, memory, metrics, logs, and how it stops.

| file       | purpose                                                                                     |
|------------|---------------------------------------------------------------------------------------------|
| `queues`   | bounded queues in front of worker threads, and a pool for the parts of one ranking          |
| `workers`  | the threads behind the queues, which do not delay the end of the process                    |
| `cache`    | results that can be computed again, the least recently used dropped first                   |
| `changes`  | announces each commit to those who wait for a session to change                             |
| `feeds`    | reads the new versions of each followed session once, for all its followers                 |
| `periodic` | repeats work in the background                                                              |
| `steady`   | a clock by which nothing becomes old because a clock was set                                |
| `memory`   | divides the memory of the machine or container among the parts of the service               |
| `metrics`  | counters and gauges for Prometheus                                                          |
| `logs`     | structured logs on stderr                                                                   |
| `stopping` | ends the process some seconds after a signal, whatever its threads do                       |
"""

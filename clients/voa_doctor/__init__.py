"""Examination of the way between this machine, the service and the robots: checks that return findings with advice.

`examination.examine` runs all of them; `voa doctor` prints the findings, and the console shows them.

| module          | checks                                                                        |
|-----------------|-------------------------------------------------------------------------------|
| `examination`   | all of the below, in order                                                    |
| `findings`      | nothing: the findings themselves, and time limits                             |
| `reaching`      | that a host and port can be reached                                           |
| `over_http`     | that the service runs, is ready, and uses the same messages and time          |
| `memory`        | the limits of the service's parts against its memory                          |
| `over_zenoh`    | the router, the replicas, and their responses                                 |
| `robots`        | the robots, as the service reports them                                       |
| `remedies`      | nothing: advice on reasons that the service reports                           |
| `sessions`      | whether the object of a robot's session is there at all                       |
| `topics`        | that messages of mapped ROS 2 topics arrive                                   |
| `samples`       | nothing: collects messages for a few seconds                                  |
| `messages`      | type, use and clock of a topic's messages                                     |
| `scans`         | the scans among them                                                          |
| `stamps`        | the stamps of messages                                                        |
| `over_database` | every version of a database                                                   |
"""

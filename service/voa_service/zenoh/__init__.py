"""Zenoh in front of the use cases: queries, raw scans and ROS 2 topics come in, beliefs and refusals go out.

Functions that a Zenoh thread calls return at once: they put their work into a bounded queue, or refuse it.

| file           | purpose                                                                                   |
|----------------|-------------------------------------------------------------------------------------------|
| `entry`        | puts the parts together, and serves on Zenoh                                              |
| `link`         | the session with a router: opened as soon as a router answers, opened again after a loss  |
| `queries`      | answers queries on `rpc/<method>` by remote calls                                         |
| `scans`        | applies raw scans on `scan/<session>/<robot>`                                             |
| `ros2`         | subscribes to the ROS 2 topics of mapped robots, and applies their looks                  |
| `mapped_robot` | a mapped robot: gathers its messages into looks for the session that it belongs to        |
| `samples`      | a message on a topic of a mapped robot                                                    |
| `applying`     | applies a look to its session once, whichever replicas do so                              |
| `ledger`       | knows which looks of a robot its session has, so that each stop counts once               |
| `joining`      | the session that a robot joins and the looks in it, also where its messages are late      |
| `replicas`     | the replicas that are alive, and which of them is responsible for a sample                |
| `mailboxes`    | bounded queues of samples, one for each sender                                            |
| `deferred`     | work that waits in case the responsible replica does not do it                            |
| `outbox`       | publishes beliefs after commits, and refusals of scans                                    |
| `refusals`     | explains to a robot why its look was not accepted                                         |
"""

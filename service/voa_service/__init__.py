"""The VOA service: keeps beliefs over object poses, updates them by lidar scans, and ranks looks and grasps.

Entrypoints stand in front (HTTP, Zenoh, remote calls), use cases in the middle, the store and the reader of meshes
behind. The mathematics is `voa_core`, the messages are `voa_msgs`; only `mapping/` knows both.

| folder or file    | purpose                                                                                 |
|-------------------|-----------------------------------------------------------------------------------------|
| `serve`           | the command `voa serve`: options, sockets and signals of the process                    |
| `console`         | the console beside the service, which the command `voa serve` starts                    |
| `backup`, `restore` | the commands `voa backup` and `voa restore`; `backup_command` is what they share      |
| `settings`        | settings from the command line, from `VOA_*` in the environment, and their defaults     |
| `environment`     | finds variables `VOA_*` that are not settings, such as misspelt ones                    |
| `bootstrap`       | the composition root: builds the use cases, their queues and caches from the settings   |
| `services`        | the use cases and queues, as `bootstrap` hands them to every entrypoint                 |
| `http/`           | HTTP: resources, problem documents, limits, connections                                 |
| `zenoh/`          | Zenoh: queries, raw scans, ROS 2 topics of mapped robots; publishes beliefs             |
| `access/`         | API keys and roles: who may make which call, how often, and the record of writes        |
| `ros_tools/`      | outputs and inputs of mapped robots for RViz, Foxglove, PlotJuggler, MoveIt and Nav2    |
| `local/`          | rankings without HTTP, and without limits on sizes, for `voa rank --local`              |
| `cluster/`        | the parts of a ranking on a cluster of dask.distributed, for `voa rank --cluster`       |
| `versions`        | versions on which the digits of a ranking depend                                        |
| `rpc/`            | remote calls: methods by name, for Zenoh queries and for callers in this process        |
| `requests/`       | reads requests for every entrypoint: bodies, limits, attachments, idempotency keys      |
| `guard`           | turns every error that leaves an entrypoint's work into a failure                       |
| `failures`        | the failures that callers see: kind, status and title of each problem document          |
| `problem_schemas` | the schemas of these problem documents for the OpenAPI document                         |
| `usecases/`       | the operations of the service, without a protocol and without a database                |
| `mapping/`        | converts messages to the mathematics and back                                           |
| `ports`           | interfaces of the use cases to the store, the clock, ids and the reader of meshes       |
| `meshes/`         | reads untrusted mesh files in processes with limits                                     |
| `runtime/`        | queues, threads, caches, changes of sessions, memory, metrics, logs, the end            |
"""

"""The service: HTTP in front, a store behind, `voa_core` in the middle.

| folder or file | what it is                                                              |
|----------------|-------------------------------------------------------------------------|
| `bootstrap`    | the composition root: everything is built here, from `settings`         |
| `ports`        | what the use cases need from the world: store, clock, ids, mesh reader  |
| `usecases/`    | what the service does; knows neither HTTP nor a database                |
| `mapping`      | between messages (`voa_msgs`) and mathematics (`voa_core`)              |
| `http/`        | resources, problem documents, limits, request ids                       |
| `store/`       | SQLAlchemy Core                                                         |
| `meshes/`      | reads untrusted meshes in a process of their own                        |
"""

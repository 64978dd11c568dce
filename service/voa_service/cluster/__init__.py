"""Rankings on a cluster of dask.distributed: the parts of a ranking, computed by workers on other machines.

A ranking maps a function over its parts (places, or pairs of them). `Threads` does so on the threads of one process,
and `ClusterMap` on workers: the function is sent to them with names in the place of the scenario, which each worker
builds once from its stored form. What a part gives depends neither on the chunk it is in nor on the worker, so that
the answer is byte for byte that of one process. The extra `cluster` installs what this package needs; nothing else
imports it.

| module       | purpose                                                                                |
|--------------|----------------------------------------------------------------------------------------|
| `scene`      | a scenario in its stored form, from which workers build its mathematics                |
| `sending`    | functions as bytes, in which a scenario is named and not contained                     |
| `mapping`    | the map over the parts of a ranking, in chunks                                         |
| `connecting` | connects to a scheduler, or starts workers on this machine                             |
"""

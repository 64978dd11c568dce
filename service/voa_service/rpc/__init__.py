"""Remote calls: the service's methods by name, for callers without paths and verbs, such as queries on Zenoh.

| file         | purpose                                                                             |
|--------------|-------------------------------------------------------------------------------------|
| `entry`      | answers a call: finds its method, does its work, and writes the response            |
| `methods`    | the table of methods, each with its work and the queue in which its calls wait      |
| `calls`      | a call under way: its payload, of which each method takes the parts that it expects |
| `parameters` | messages for the parameters that HTTP has in the path or the query                  |
"""

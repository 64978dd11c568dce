"""Deterministic simulation of the use cases: replicas, clients, network, clocks and crashes, all from one seed.

The production's use cases (`voa_service.usecases`, `requests.idempotency`, `zenoh.applying` and `zenoh.ledger`) and its
store (`voa_store` on a real SQLite file) run unmodified. Each call is a task of its own, a greenlet, which pauses at
every connection, statement, commit and answer; a generator seeded by a number decides which task goes on. A process may
die at any of these steps: what was committed stays, and nothing else. The network delays, loses and repeats requests
and responses; the disk fails before or after a commit; clocks jump. A run is checked by `tests.support.histories` and
by `checks`; the same seed gives the same steps, byte for byte.

| module | contents |
|---|---|
| `plan` | from a seed to operations, troubles and crashes |
| `scheduler` | virtual time and tasks |
| `database` | the store's engines on the scheduler |
| `replica` | a process with its use cases |
| `robot` | the mapped robot in a process |
| `requests` | requests as the entrypoints make them |
| `clients` | what clients do |
| `world` | network, records, and all parts of a run |
| `run` | runs a plan |
| `replay` | replays a history without a store |
| `checks` | what must hold in the end |
| `announcements` | what must hold of announced looks |
| `faults` | faults that are planted to be found |
| `shrink` | the smallest plan that fails alike |

Not simulated: PostgreSQL, the loss of power, threads that are switched between two steps, HTTP and Zenoh themselves.
`python -m tests.simulation --help` runs it: many seeds, one seed, or all planted faults.
"""

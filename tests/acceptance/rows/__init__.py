"""Rows of the table, each a function of the service, the seed and the size of the run.

| module | rows |
|---|---|
| `random_objects` | one look at random objects: promises, share of the lead, standard errors |
| `designed` | scenes that were designed to separate ways of choosing a look |
| `shipped` | the three shipped objects: a random look, three looks from one place, three of the best looks |
| `rooms` | presence and absence in cluttered rooms |
| `holder` | the lab's scans of the HOLDER |
"""

"""Rankings without HTTP: the service's own computation in one process, on its threads or on a cluster.

`python -m voa_service.local` reads one document from standard input, and writes lines of JSON to standard output:

    {"scenario": {...}, "mesh": {"path": "/.../mug.stl", "scale": 0.001, "up": "+Z"}, "ranking": {"belief": null}}

    {"progress":{"done":3,"total":64}}          one for each finished part
    {"result":{"warnings":[...],"ranking":{...}}}   the last line of a success, exit status 0
    {"problem":{"type":"urn:voa:problem:...",...}}  the last line of a failure, exit status 1

`scenario` is the body of POST /v1/scenarios, `mesh` the file of its object (null: all predictions are data), and
`ranking` the body of POST /v1/rankings without its field `scenario`. The answer is byte for byte the body with which
that call would respond, and has none of its limits on sizes.

| module         | purpose                                                                         |
|----------------|---------------------------------------------------------------------------------|
| `document`     | the document on standard input                                                  |
| `ranking`      | stores scenario and mesh in a temporary database, and ranks as the service does |
| `reported`     | a map over the parts of a ranking that reports how many are finished            |
| `resumed`      | a map over the parts of a ranking that keeps its results in a folder            |
| `distributing` | where the parts of a ranking are computed: on threads or on a cluster           |
| `command`      | the process: its options, its lines, its signals and its exit status            |
"""

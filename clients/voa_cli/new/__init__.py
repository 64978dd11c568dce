"""`voa new`: from a mesh to a scenario.

| to                                                 | see         |
|----------------------------------------------------|-------------|
| run the command                                    | `command`   |
| read its options                                   | `options`   |
| show its steps and its result                      | `display`   |
"""

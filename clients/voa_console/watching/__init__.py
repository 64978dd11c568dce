"""Sessions and robots of the service, followed once for all open pages.

| module     | contents                                                                            |
|------------|-------------------------------------------------------------------------------------|
| `hub`      | the sessions that moved lately, the robots, and whether the service responds        |
| `watched`  | a session that is followed, with its scenario and its rankings, once per version    |
| `refusals` | why the scans of a robot are refused at the moment                                 |
| `news`     | callbacks of pages, called when something changed                                   |
"""

"""Console: the laboratory's web page, a customer of the service like any other.

| to                                                                      | see           |
|-------------------------------------------------------------------------|---------------|
| read the settings of a console                                          | `settings`    |
| put the console together: client, hub, pages                            | `application` |
| know what every page receives                                           | `context`     |
| serve the application as a process                                      | `serving`     |
| refuse other sites' pages                                               | `guard`       |
| draw the frame around a page: links, key, dark or light, banner         | `layout`      |
| let each browser call the service with its own key                      | `keys`        |
| say in a sentence why the service refused                               | `sentences`   |
| follow sessions and robots once for all open pages                      | `watching`    |
| page Now: the sessions that moved in the last hour                      | `now`         |
| page of a session: scene, advice, time line, actions                    | `session`     |
| page Robots: checks, what each robot is doing, and its newest scan      | `robots`      |
| page New object: from a mesh file to a scenario and a session           | `new_object`  |
| draw the shapes of a scene in three dimensions                          | `drawing`     |
"""

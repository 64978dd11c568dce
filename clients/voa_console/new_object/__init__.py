"""Page New object: from a mesh file to a scenario and a session, by the choices of `voa new`.

The page shows a draft and previews of it. The work itself, which is heavy and reads a file that is not trusted, is done
by processes of their own: `voa_setup` and the simulator are imported there alone.

| module            | contents                                                         |
|-------------------|------------------------------------------------------------------|
| `draft`           | the choices as plain values, and pure functions of them          |
| `wording`         | messages of the command line and of the service in words of a page |
| `messages`        | tasks and replies between page and process                       |
| `worker`          | the process: limits, tasks from stdin, replies to stdout         |
| `tasks`           | what the process does, by the functions of `voa new`             |
| `process`         | the process as the page sees it: started, given tasks, killed    |
| `previewing`      | previews that belong to a draft, and which is to be made next    |
| `job`             | the making of a scenario: step, progress, end                    |
| `bench`           | a new object with draft, previews and job                        |
| `workshop`        | all new objects of this console                                  |
| `folders`         | where a scenario may be written, and its archive                 |
| `files`           | pictures, page and archive for the browser                       |
| `pictures`        | map of places, outlines, and turning pictures                    |
| `fields`          | fields, headings and warnings                                    |
| `start`           | section: a mesh is dropped                                       |
| `mesh_section`    | section: unit and axis                                           |
| `rests_section`   | section: rests and yaws                                          |
| `places_section`  | section: places on their circle                                  |
| `plane_section`   | section: scan plane and warnings                                 |
| `grasps_section`  | section: gripper and scores                                      |
| `making_section`  | section: folder, progress, cancel                                |
| `result_section`  | section: files, page, session                                    |
| `page`            | the page                                                         |
"""

from voa_console.keys.access import Access
from voa_console.new_object import page


def register(access: Access) -> None:
    """Declare the page `/new`."""
    page.register(access)

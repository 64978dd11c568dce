"""Page of one session: scene, advice, belief, time line, and what a person can do about it.

| to                                                        | see                            |
|-----------------------------------------------------------|--------------------------------|
| declare the page, and put its parts together              | `page`                         |
| gather what the page shows when the session changes       | `gathering`                    |
| do work once that is requested often                      | `coalescing`                   |
| keep the facts that all pages of a session share          | `records`                      |
| choose now or a past version                              | `moments`                      |
| know what a page shows at a moment, and its scene         | `facts`                        |
| write advice, updates and reasons in words                | `words`                        |
| make charts of the belief and of the time line            | `charts`                       |
| score grasps under a past belief                          | `grasp_scores`                 |
| show the scene, and hide parts of it                      | `scene_panel`                  |
| show advice, grasps, belief, last update                  | `panels`                       |
| drag through the versions                                 | `timeline`                     |
| map the VOA around the table                              | `heat_map`, `heat_map_panel`   |
| value a look from a place of the person's choice          | `what_if`, `what_if_panel`     |
| confirm, act, and show errors as sentences                | `dialogs`, `action_context`    |
| draw the buttons of the actions                           | `actions`                      |
| request or announce a look, claim a robot                 | `robot_actions`                |
| report an outcome, reset the belief                       | `belief_actions`               |
| open, end and export sessions                             | `session_actions`              |
"""

from voa_console.session import page


def register() -> None:
    """Declare the page `/sessions/{id}`, and the route of the meshes that it shows."""
    page.register()

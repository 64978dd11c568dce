"""Presentation of episodes to a person: lines and tables in a terminal, pictures, videos, and HTML pages.

| to                                                    | see                                     |
|-------------------------------------------------------|-----------------------------------------|
| print events as lines and keep a table up to date     | `live_report`, `event_lines`, `tables`  |
| draw charts of an episode or a comparison             | `episode_pictures`, `figures`           |
| draw the scene, write a video, open MuJoCo's viewer   | `render`, `watching`                    |
| write HTML pages                                      | `page`, `demo_page`, `templates/`       |
| end early by Ctrl-C or after a time                   | `interruption`                          |
"""

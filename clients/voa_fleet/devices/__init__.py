"""Devices: a sensor robot and an arm.

| module      | contents                                                                     |
|-------------|------------------------------------------------------------------------------|
| `protocol`  | the methods that an episode needs of a sensor robot and of an arm            |
| `simulated` | devices in a MuJoCo scene                                                    |
| `example`   | a skeleton of real devices, with the places to fill in for your own hardware |

Devices know nothing of the service. To use your own, write classes with the methods of `protocol` (or copy
`example`), and give them to `voa_fleet.episodes.episode.Pair`.
"""

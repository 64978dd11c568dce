"""Previews of a scenario while a person still chooses: sizes, rests, poses, what the scan plane meets, and warnings.

| to                                                          | see         |
|-------------------------------------------------------------|-------------|
| read the previews as messages, without numpy or a simulator | `messages`  |
| measure a mesh file before its unit is known                | `measuring` |
| show each rest as a picture that turns                      | `rests`     |
| draw those pictures                                         | `turntable` |
| count poses, and show what places and scan plane see        | `planning`  |
| search the places for probable mistakes                     | `mistakes`  |
"""

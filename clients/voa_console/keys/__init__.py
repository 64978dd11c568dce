"""Keys of browsers: where the service needs a key, each browser gives its own, and its pages call the service with it.

| module      | contents                                                                             |
|-------------|--------------------------------------------------------------------------------------|
| `consoles`  | the console of the process's own key, and one for each key that browsers have given  |
| `visits`    | browsers that have given a key, by the secret in their cookie                        |
| `access`    | decision by which key a browser's page calls the service                             |
| `admission` | middleware that lets no request without a valid key reach a page                     |
| `forms`     | routes that receive a key, and that forget it                                        |
| `key_page`  | page on which a person gives a key                                                   |
| `header`    | name and role of the key in the header of each page, and the button that forgets it  |
| `leaving`   | departure of a page whose key is forgotten, or no longer accepted                    |
| `notices`   | sentences that a redirected browser shows                                            |
"""

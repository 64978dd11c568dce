"""API keys and roles: who calls, which calls that caller may make, how many per time, and the record of writes.

A service is open until its first key is made, unless its operator requires keys from the start, and closed from then on
for good: without a valid key only the calls about health are answered. Keys are made by the command `voa keys`, in the
database that all processes of the service share.

| file      | purpose                                                                                      |
|-----------|----------------------------------------------------------------------------------------------|
| `roles`   | the table of all calls, by HTTP and Zenoh, with the roles that may make each                 |
| `routing` | finds the call of an HTTP request by its method and path                                     |
| `keys`    | the text of keys, and their digests                                                          |
| `keyring` | the keys that this process knows: read from the store every two seconds                      |
| `callers` | a caller: name and role, and the sessions and robots that its key is for                     |
| `rates`   | calls per key and time                                                                       |
| `gate`    | admits a call, or refuses it, before its body is read                                        |
| `audit`   | a line in the log for each write                                                             |
| `command` | the command `voa keys`: makes, lists and revokes keys                                        |
| `listing` | the options and the output of that command                                                   |
"""

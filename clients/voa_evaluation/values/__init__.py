"""Evaluation of the value of looks over scans in thousands: promised against achieved.

| to                                                               | see                              |
|------------------------------------------------------------------|----------------------------------|
| choose the extent of an evaluation                               | `setting`                        |
| describe an object for the mathematics                           | `world`                          |
| draw noisy scans that the ranking does not know                  | `scans`                          |
| weigh scans once for many beliefs                                | `kept_weights`, `bench`          |
| draw beliefs and starts                                          | `cases`                          |
| compute what looks achieve                                       | `truth`                          |
| compute what looks promise                                       | `promises`                       |
| choose looks by entropy, beams, distance                         | `policies`                       |
| give means, differences and ratios of gains their intervals      | `samples`                        |
| compare orders of promised and achieved values                   | `measures`                       |
| evaluate one look                                                | `single_looks`, `single_tables`  |
| evaluate sessions of several looks                               | `several_looks`, `several_tables` |
| plan several looks together, and count drives                    | `together`, `driving`            |
| confirm by drops in MuJoCo                                       | `confirmation`                   |
| run everything                                                   | `benches`, `running`             |
| read the results                                                 | `results`, `single_results`, `several_results` |
| write the results as CSV and JSON                                | `tables`                         |
"""

"""Evaluation of looks: their Value of Assistance beforehand against what they achieved.

| to                                                             | see                                |
|----------------------------------------------------------------|------------------------------------|
| choose the extent of an evaluation                             | `setting`                          |
| drop the object, take scans, attempt grasps                    | `trials`                           |
| request rankings and updates from the service                  | `requests`                         |
| let each policy choose a look                                  | `choices`                          |
| run all trials and keep a row for each                         | `running`, `rows`                  |
| vary the imperfections of the world                            | `sensitivity`                      |
| compute figures from rows                                      | `worth`, `outcomes`, `calibration` |
| compare policies in words                                      | `findings`                         |
| run the whole evaluation                                       | `results`                          |
"""

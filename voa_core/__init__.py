"""The mathematics of Value of Assistance for grasping: numpy in, numpy out; no I/O, no clock, no network.

"Paper" is the preliminary evaluation, "longer" the longer version (arXiv 2310.14402); where a file implements neither,
its docstring names the source.

| to                                    | file                                   | of the paper                        |
|---------------------------------------|----------------------------------------|-------------------------------------|
| describe object, poses, lidar, places | `objects`, `poses`, `lidars`           | stable poses, sensing actions       |
| bound the table                       | `workspace`                            |                                     |
| propose stable poses of an object     | `stable_poses`, `toppling`, `winding`  | stable poses                        |
| hold grasp scores, choose a grasp     | `grasps`                               | Definitions 1 and 3, equation 1     |
| predict scans                         | `prediction`, `cutting`, `chains`      | Definition 5                        |
| enter contours into beams             | `window_rasterising`, `rasterising`    |                                     |
| read measured scans                   | `scans`                                |                                     |
| turn a scan into weights              | `rules`, `evidence`, `fits`            | fit by RMSD; longer: tau 1, 2 and 3 |
| displace the poses a little           | `displacements`                        |                                     |
| predict displaced poses               | `displaced_scans`, `copy_rasterising`, `outlines` |                          |
| compare scans with displaced poses    | `comparisons`                          |                                     |
| notice that the object is missing     | `sight`, `absence`                     |                                     |
| hold and update a belief              | `filtering`, `updating`                | Definition 4; longer: 1 and 2       |
| hold a belief and the looks behind it | `estimates`, `places`                  |                                     |
| make a prior                          | `priors`                               | longer: appendix                    |
| value a look, rank looks              | `weights`, `assistance`, `ranking`     | equations 2 and 3; longer: 3 and 4  |
| rank looks over samples of the poses  | `sampled_ranking`, `pose_samples`      |                                     |
| choose a grasp after each scan        | `choices`, `panels`                    | equation 1                          |
| say how far a value may be off        | `standard_errors`                      |                                     |
| simulate scans that are to be taken   | `simulation`, `scan_model`             |                                     |
| weigh simulated scans                 | `simulated_weights`, `copies`, `sample_sight` |                             |
| value several looks together          | `looks`, `joint_weights`               |                                     |
| know when to stop looking             | `recommendation`, `perfect_information` |                                    |
| join all of it for one object         | `scenario`                             |                                     |
| evaluate a recorded experiment        | `recorded`                             | evaluation 3: VOA against AECD      |
| find probable mistakes                | `mistakes`                             |                                     |

The other files serve these: `checks` and `errors` for input, `geometry` for rotations, `kernels`, `choice_kernels`,
`register_products`, `copy_kernels`, `mixture`, `mixture_kernels`, `mixture_likelihoods`, `mixture_pairs`, `vector_math`
and `jit` for compiled loops, and `warmup`, which compiles them all.
"""

"""Benchmarks: speed as ratios to named peers that are measured in the same run.

Each module here is one subject and offers `run() -> list[Result]`; to add one, write it and list it in
`__main__.SUBJECTS`. Run them with `make bench`, or `python -m tests.benchmarks --only weights`. `gates` holds what the
ratios must reach, `history` the runs that were kept, `plots` the growth of costs as pictures.
"""

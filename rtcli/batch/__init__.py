"""Many scenes to one folder: only what is needed, crash-proof, the same bytes each time.

    paths --find--> jobs --plan--> what is to do --work--> files and outcomes --record--> manifest.json
           jobs.py        run.py             pool.py, work.py                    manifest.py

`folder.py` keeps what several runs share of a folder apart: its lock, and the temporary files of each run.
"""

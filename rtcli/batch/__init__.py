"""Render scenes into a folder: skip results that are up to date, survive crashes, give the same bytes each time.

    paths --find--> jobs --plan--> steps --render--> files and outcomes --record--> manifest.json
           jobs.py        run.py          pool.py, worker.py             manifest.py

`folder.py` keeps runs in the same folder apart: its lock, and the temporary files of each run.
"""

"""Render scenes into a folder: skip results that are up to date, survive crashes, give the same bytes each time.

    paths --find--> jobs --plan--> steps --render--> files and outcomes --record--> manifest.json
          jobs.py         plan.py          pool.py, worker.py             manifest.py

`run.py` takes a plan through the last two stages, and `prune.py` deletes the results that no job makes any more.
`folder.py` keeps runs in the same folder apart: its lock, and the temporary files of each run.
"""

"""The report of a data set: one HTML page that needs no script, no other file and no network.

`histogram` counts the values that samples have, `page` fills `page.html` with them, and `rtcli.reports.page` puts
it into the frame of all pages.
"""

from rtcli.reports.dataset_page.page import ReportedSample, dataset_page

__all__ = ["ReportedSample", "dataset_page"]

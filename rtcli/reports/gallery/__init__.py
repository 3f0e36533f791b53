"""The report of a batch: one page of its pictures, for any browser, with nothing beside it and no network.

`page` writes it, from what `records` takes of the manifest and from the pictures in small of `thumbnails`. How it
looks is in `page.css`, and what it does in `page.js`, which are put into `page.html`.
"""

from rtcli.reports.gallery.page import gallery_page

__all__ = ["gallery_page"]

"""The report of a batch: one HTML page of its pictures that needs no other file and no network.

`page` fills `page.html` with the `records` of the manifest and the `thumbnails` of the pictures, and
`rtcli.reports.page` puts it into the frame of all pages, with the style `page.css` and the script `page.js`.
"""

from rtcli.reports.gallery.page import gallery_page

__all__ = ["gallery_page"]

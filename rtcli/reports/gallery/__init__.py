"""The report of a batch: one HTML page of its pictures that needs no other file and no network.

`page` fills `page.html` with the style `page.css`, the script `page.js`, the `records` of the manifest and the
`thumbnails` of the pictures.
"""

from rtcli.reports.gallery.page import gallery_page

__all__ = ["gallery_page"]

"""The page of a pixel's story, with a drawing: the modules `story.js` and `drawing.js` in one file.

Pages with a server of their own use the same modules, which need no build step: `story.js` says how.
"""

from rtcli.reports.story_page.page import story_page

__all__ = ["story_page"]

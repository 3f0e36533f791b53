"""The page of a golden check: what is not equal, golden and new pictures side by side or under a slider."""

from rtcli.reports.golden_page.page import golden_page

__all__ = ["golden_page"]

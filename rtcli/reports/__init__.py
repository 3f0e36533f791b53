"""Reports: problems as text for people, and in the formats that editors, CI and other programs read.

Each format has a module with a function `report`, which takes the file reports and yields text. The text has no
character that is unsafe to write to a terminal.
"""

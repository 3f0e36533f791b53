"""Reports: problems as text for people, and as the formats that editors, CI and other programs read.

One module for each format. Its `report` takes what was found in each file and yields text, in which there is no
character that a terminal cannot be trusted with.
"""

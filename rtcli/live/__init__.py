"""A scene shown while it is edited: each save becomes a picture, a list of problems, and answers about pixels.

    file --watch--> version --session--> state --server--> page

Nothing here prints or exits; `rtcli live` and `rtcli watch` do.
"""

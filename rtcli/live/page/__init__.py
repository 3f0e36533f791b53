"""The page of `rtcli live`: HTML, CSS and JavaScript modules that the server sends as they are."""

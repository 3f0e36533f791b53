"""The page of `rtcli live`: HTML, CSS and JavaScript, as the browser loads them."""

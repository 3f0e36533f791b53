"""Who may ask: the checks of a request before it is answered, and the headers of every answer.

The server is bound to the loopback, where any page in the user's browser and any program on the machine can reach
it. A page from elsewhere has no token, cannot set the headers that a POST needs, and is told apart by `Host` (DNS
rebinding), `Origin` and `Sec-Fetch-Site` (https://www.w3.org/TR/fetch-metadata/).
"""

from __future__ import annotations

import hmac
import re
import secrets
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from http import HTTPStatus
from typing import NamedTuple, Protocol

LOOPBACK = "127.0.0.1"
_NAMES = frozenset({"localhost", LOOPBACK, "[::1]"})
_HOST = re.compile(r"(\[[0-9a-f:]+\]|[^:\[\]/@\s]+)(?::[0-9]{1,5})?", re.IGNORECASE)

# The header that a POST must have: a page from elsewhere cannot set it without being asked for permission first.
OWN_HEADER = "X-Rtcli"
JSON_TYPE = "application/json"

HEADERS = {
    "Content-Security-Policy": "default-src 'self'; img-src 'self' blob:; object-src 'none'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
}


class Headers(Protocol):
    """The headers of a request, as `email.message.Message` has them."""

    def get_all(self, name: str) -> list[str] | None:
        """Return the values of a header."""


class Refusal(NamedTuple):
    """Why a request is refused."""

    status: HTTPStatus
    reason: str


@dataclass(frozen=True)
class Guard:
    """Decides which requests are answered.

    Parameters
    ----------
    port
        The port of the server; the cookie is named by it, since cookies of all ports are sent to each.
    allowed_hosts
        Names that `Host` may have besides those of the loopback.
    token
        The secret that the printed address holds.
    """

    port: int
    allowed_hosts: Collection[str] = ()
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24))

    @property
    def cookie_name(self) -> str:
        """The name of the cookie."""
        return f"rtcli_live_{self.port}"

    @property
    def cookie(self) -> str:
        """The value of `Set-Cookie` that holds the token."""
        return f"{self.cookie_name}={self.token}; Path=/; HttpOnly; SameSite=Strict"

    def refusal(self, method: str, path: str, headers: Headers, query: Mapping[str, str]) -> Refusal | None:
        """Return why a request is refused; None if it may be answered."""
        forbidden, host = HTTPStatus.FORBIDDEN, _single(headers, "Host")
        match = None if host is None else _HOST.fullmatch(host)
        if match is None or match[1].lower() not in {*_NAMES, *(name.lower() for name in self.allowed_hosts)}:
            return Refusal(forbidden, "this host is not allowed: use localhost, or start with --allow-host NAME")
        if headers.get_all("Origin") and _single(headers, "Origin") not in (f"http://{host}", f"https://{host}"):
            return Refusal(forbidden, "requests from other origins are refused")
        has_token = self._is_token(query.get("token", ""))
        if not self._is_from_here(path, headers, has_token):
            return Refusal(forbidden, "requests from other sites are refused")
        if not has_token and not self._is_token(self._cookie_of(headers)):
            return Refusal(forbidden, "open the address that rtcli printed: it holds the token")
        if method == "POST" and not _is_own_post(headers):
            reason = f"a POST needs `Content-Type: {JSON_TYPE}` and `{OWN_HEADER}: 1`"
            return Refusal(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, reason)
        return None

    def _is_from_here(self, path: str, headers: Headers, has_token: bool) -> bool:
        """Return whether a browser sends the request for this page or its user; another program says nothing.

        A link elsewhere that holds the token, in a terminal in the browser for example, may open the page.
        """
        site = headers.get_all("Sec-Fetch-Site")
        if site is None or _single(headers, "Sec-Fetch-Site") in ("same-origin", "none"):
            return True
        return path == "/" and has_token and _single(headers, "Sec-Fetch-Dest") == "document"

    def _cookie_of(self, headers: Headers) -> str:
        """Return the value of the cookie. Other servers of this machine may have set cookies of any form."""
        pairs = (pair.partition("=") for line in headers.get_all("Cookie") or [] for pair in line.split(";"))
        return next((value.strip() for name, _, value in pairs if name.strip() == self.cookie_name), "")

    def _is_token(self, text: str) -> bool:
        return hmac.compare_digest(text.encode(errors="replace"), self.token.encode())


def _single(headers: Headers, name: str) -> str | None:
    """Return the value of a header; None without it, or with several."""
    values = headers.get_all(name) or []
    return values[0].strip() if len(values) == 1 else None


def _is_own_post(headers: Headers) -> bool:
    type = (_single(headers, "Content-Type") or "").split(";")[0].strip().lower()
    return type == JSON_TYPE and _single(headers, OWN_HEADER) == "1"

"""Requests from anywhere but the page are refused."""

from email.message import Message

import pytest

from rtcli.live.security import HEADERS, Guard

GUARD = Guard(8765, ("lab.example.org",), token="the-token")
COOKIE = ("Cookie", "rtcli_live_8765=the-token")
HOST = ("Host", "127.0.0.1:8765")
POST = (HOST, COOKIE, ("Content-Type", "application/json"), ("X-Rtcli", "1"))


def status_of(method, path, *headers, query=None):
    """Return the status with which a request is refused; None if it is answered."""
    message = Message()
    for name, value in headers:
        message[name] = value
    refusal = GUARD.refusal(method, path, message, query or {})
    return None if refusal is None else refusal.status


@pytest.mark.parametrize(
    "host",
    ["127.0.0.1:8765", "localhost", "localhost:1", "LOCALHOST:99", "[::1]:8765", "lab.example.org:80"],
)
def test_names_of_the_loopback_and_allowed_ones_are_answered_on_any_port(host):
    assert status_of("GET", "/state", ("Host", host), COOKIE) is None


@pytest.mark.parametrize(
    "host",
    [
        "evil.example",
        "localhost.evil.example",
        "127.0.0.1.evil.example:8765",
        "evil@localhost",
        "0.0.0.0:8765",
        "",
        "[::1",
    ],
)
def test_foreign_or_rebound_hosts_are_refused(host):
    assert status_of("GET", "/state", ("Host", host), COOKIE) == 403


def test_missing_and_repeated_hosts_are_refused():
    assert status_of("GET", "/state", COOKIE) == 403
    assert status_of("GET", "/state", HOST, HOST, COOKIE) == 403


@pytest.mark.parametrize("origin", ["http://127.0.0.1:8765", "https://127.0.0.1:8765"])
def test_own_origin_is_answered(origin):
    assert status_of("GET", "/state", HOST, COOKIE, ("Origin", origin)) is None


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://127.0.0.1:3000", "http://localhost:8765", "file://", ""]
)
def test_other_origins_are_refused(origin):
    assert status_of("GET", "/state", HOST, COOKIE, ("Origin", origin)) == 403


@pytest.mark.parametrize("site", ["same-origin", "none"])
def test_requests_of_the_page_and_its_user_are_answered(site):
    assert status_of("GET", "/picture", HOST, COOKIE, ("Sec-Fetch-Site", site)) is None


@pytest.mark.parametrize("site", ["cross-site", "same-site", "strange"])
@pytest.mark.parametrize("path", ["/", "/picture", "/live.js"])
def test_requests_of_other_sites_are_refused(site, path):
    """A page on another port of this machine is of the same site, and its requests carry the cookie."""
    assert status_of("GET", path, HOST, COOKIE, ("Sec-Fetch-Site", site)) == 403


def test_link_elsewhere_that_holds_the_token_opens_the_page_and_nothing_else():
    elsewhere = (HOST, ("Sec-Fetch-Site", "cross-site"), ("Sec-Fetch-Dest", "document"))
    query = {"token": "the-token"}
    assert status_of("GET", "/", *elsewhere, query=query) is None
    assert status_of("GET", "/state", *elsewhere, query=query) == 403
    frame = (*elsewhere[:2], ("Sec-Fetch-Dest", "iframe"))
    assert status_of("GET", "/", *frame, query=query) == 403


def test_token_in_the_address_or_the_cookie_is_needed():
    assert status_of("GET", "/state", HOST) == 403
    assert status_of("GET", "/state", HOST, query={"token": "the-token"}) is None
    assert status_of("GET", "/state", HOST, query={"token": "another"}) == 403
    assert status_of("GET", "/state", HOST, query={"token": "\udcff"}) == 403


@pytest.mark.parametrize(
    "cookie", ["rtcli_live_8765=another", "rtcli_live_1=the-token", "rtcli_live_8765", "the-token", ""]
)
def test_other_cookies_are_refused(cookie):
    assert status_of("GET", "/state", HOST, ("Cookie", cookie)) == 403


def test_cookies_of_other_servers_do_no_harm():
    cookies = 'a="b; {x}=[1]; =; rtcli_live_1=no; rtcli_live_8765=the-token; c'
    assert status_of("GET", "/state", HOST, ("Cookie", cookies)) is None


def test_post_needs_json_and_a_header_of_its_own():
    assert status_of("POST", "/camera", *POST) is None
    assert status_of("POST", "/camera", *POST[:3]) == 415
    assert status_of("POST", "/camera", *POST[:2], POST[3]) == 415
    text = ("Content-Type", "text/plain")
    assert status_of("POST", "/camera", *POST[:2], text, POST[3]) == 415


def test_cookie_is_named_by_the_port_and_kept_from_scripts_and_other_sites():
    assert GUARD.cookie == "rtcli_live_8765=the-token; Path=/; HttpOnly; SameSite=Strict"


def test_tokens_are_random():
    assert len({Guard(1).token for _ in range(10)}) == 10
    assert len(Guard(1).token) >= 32


def test_answers_allow_nothing_from_elsewhere():
    assert HEADERS["Content-Security-Policy"].startswith("default-src 'self';")
    assert "unsafe" not in HEADERS["Content-Security-Policy"]
    assert HEADERS["Cross-Origin-Resource-Policy"] == "same-origin"
    assert HEADERS["X-Content-Type-Options"] == "nosniff"
    assert not [name for name in HEADERS if name.startswith("Access-Control")]

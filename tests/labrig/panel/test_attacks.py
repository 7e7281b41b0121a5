"""Who should not come in does not, and the panel lives on."""

from __future__ import annotations

import http.client
import json
import shutil
import socket
import time
from contextlib import suppress
from urllib.parse import urlsplit

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from tests.labrig.panel.page import Page

pytestmark = pytest.mark.slow  # a panel is a process
PATIENCE_S = 30.0  # with another process, on a busy computer
ACTING = [
    ("POST", "/api/control", {"do": "take", "name": "Eve"}),
    ("POST", "/api/run", {"session": "eve.h5"}),
    ("POST", "/api/stop", {}),
    ("PUT", "/api/files/eve.toml", {"kind": "protocol", "text": ""}),
    ("POST", "/api/answer", {"prompt": 1, "done": True}),
]
READING = [("GET", "/api/status", None), ("GET", "/api/files", None), ("GET", "/api/log", None)]


@pytest.mark.parametrize(("method", "path", "body"), ACTING + READING)
def test_without_a_token_nothing_is_done_or_told(server, method, path, body):
    status, answer = server.ask(method, path, body, {"Origin": server.origin}, as_browser=False)
    assert (status, list(answer)) == (401, ["error"])


@pytest.mark.parametrize("given", ["", "x", "é" * 40, "A" * 32])
def test_a_wrong_token_opens_nothing(server, given):
    for headers in (
        {"Cookie": f"labrig_token={given}".encode().decode("latin-1")},
        {"Authorization": f"Bearer {given}".encode().decode("latin-1")},
    ):
        status, _ = server.ask("GET", "/api/status", headers=headers, as_browser=False)
        assert status == 401


def test_a_wrong_token_in_the_address_sets_no_cookie(server):
    connection = http.client.HTTPConnection(server.netloc, timeout=PATIENCE_S)
    connection.request("GET", "/?token=wrong")
    answer = connection.getresponse()
    assert (answer.status, answer.getheader("Set-Cookie")) == (401, None)
    connection.close()


def test_the_right_token_sets_a_cookie_that_scripts_and_other_sites_do_not_get(server):
    connection = http.client.HTTPConnection(server.netloc, timeout=PATIENCE_S)
    connection.request("GET", f"/?token={server.token}")
    answer = connection.getresponse()
    cookie = answer.getheader("Set-Cookie", "").lower()
    assert answer.status == 303
    assert answer.getheader("Location") == "/"
    assert "httponly" in cookie
    assert "samesite=strict" in cookie
    connection.close()


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "https://127.0.0.1:1"])
@pytest.mark.parametrize(("method", "path", "body"), ACTING)
def test_a_page_of_somebody_else_may_not_act_though_the_browser_sends_the_cookie(
    server, origin, method, path, body
):
    status, _ = server.ask(method, path, body, {"Origin": origin})
    assert status == 403


def test_a_request_with_the_cookie_but_no_origin_may_not_act(server):
    headers = {"Cookie": f"labrig_token={server.token}"}
    status, _ = server.ask("POST", "/api/stop", {}, headers, as_browser=False)
    assert status == 403


def test_a_foreign_name_that_leads_here_is_refused(server):
    status, _ = server.ask("GET", "/api/status", headers={"Host": "evil.example"})
    assert status == 403


@pytest.mark.parametrize(
    ("token", "origin"),
    [("right", "http://evil.example"), ("right", None), ("wrong", "own"), (None, "own")],
)
@pytest.mark.parametrize("path", ["/ws", "/ws/replay?session=a.h5"])
def test_a_socket_needs_token_and_origin(server, token, origin, path):
    given = {"right": server.token, "wrong": "x" * 32}.get(token)
    headers = {} if given is None else {"Cookie": f"labrig_token={given}"}
    own = server.origin if origin == "own" else origin
    address = f"ws://{server.netloc}{path}"
    with (
        pytest.raises(InvalidStatus),
        connect(address, origin=own, additional_headers=headers),
    ):
        pass


@pytest.mark.parametrize(
    "name",
    [
        "../secret.toml", "..%2fsecret.toml", "%2e%2e/secret.toml", "..\\secret.toml",
        "/etc/passwd", "//etc/passwd", "C:\\secret.toml", "C:secret.toml", "a/../../secret.toml",
        ".labrig/job.json", ".labrig%2fjob.json", "link.toml", "secret.toml%00", "con.toml",
        "file:///etc/passwd", "~/secret.toml", "a" * 5000 + ".toml",
    ],
)  # fmt: skip
def test_no_file_outside_the_folder_can_be_named(server, rig_folder, name):
    secret = rig_folder.parent / "secret.toml"
    secret.write_text('text = "a secret"\n')
    link = rig_folder / "link.toml"
    if not link.is_symlink():
        link.symlink_to(secret)
    for path in (f"/api/files/{name}", f"/static/{name}", f"/static/../{name}", f"/{name}"):
        with suppress(http.client.InvalidURL):
            status, answer = server.ask("GET", path)
            assert status in {400, 404, 405}, path
            assert b"a secret" not in json.dumps(answer, default=repr).encode()


def test_a_proposed_protocol_is_read_from_beside_its_session_and_nowhere_else(server, rig_folder):
    secret = rig_folder.parent / "secret.toml"
    secret.write_text('text = "a secret"\n')
    for folder in (rig_folder, rig_folder.parent):
        (folder / "led.h5").touch()
    (rig_folder / "led.next.toml").symlink_to(secret)
    shutil.copy(secret, rig_folder.parent / "led.next.toml")
    for name in ("led.h5", "../led.h5", str(rig_folder / "led.h5"), "gone.h5", "led.next.toml"):
        status, answer = server.ask("GET", f"/api/next-protocol?session={name}")
        assert status in {400, 404}, name
        assert "a secret" not in json.dumps(answer)
    (rig_folder / "led.next.toml").unlink()
    (rig_folder / "led.next.toml").write_text((rig_folder / "protocol.toml").read_text())
    status, answer = server.ask("GET", "/api/next-protocol?session=led.h5")
    assert (status, answer["name"], answer["kind"]) == (200, "led.next.toml", "protocol")
    (rig_folder / "led.h5").unlink()


def test_no_file_outside_the_folder_can_be_written_or_run(server, rig_folder):
    page = Page(server)
    page.take_control(force=True)
    text = (rig_folder / "protocol.toml").read_text()
    for name in ("..%2fmade.toml", "made.h5", ".made.toml", "rig.toml", "link.toml"):
        status, _ = page.ask("PUT", f"/api/files/{name}", {"kind": "protocol", "text": text})
        assert status in {400, 404, 405}
    for session in ("../made.h5", "/tmp/made.h5", "a/../../made.h5", "made.toml", ".labrig/a.h5"):
        status, answer = page.ask("POST", "/api/run", {"session": session})
        assert status == 400, answer
    assert not list(rig_folder.parent.glob("made*"))
    page.close()


def test_a_watcher_learns_no_name_with_which_it_could_act_in_anothers_place(server):
    ann, eve = Page(server), Page(server)
    ann.take_control("Ann", force=True)
    ann.until(lambda m: m["type"] == "control" and m["holder"] == ann.client)
    seen = eve.until(lambda m: m["type"] == "control" and (m["name"] or "").startswith("Ann"))
    told = json.dumps([eve.hello, eve.messages, eve.ask("GET", "/api/status")[1]])
    assert ann.client not in told
    for name in (seen["holder"], "", "x" * 16):
        headers = {"X-Labrig-Client": name}
        assert server.ask("POST", "/api/stop_after_pulse", None, headers)[0] == 403
    ann.close()
    eve.until(lambda m: m["type"] == "control" and not m["here"])
    again = Page(server, f"/ws?client={seen['holder']}")
    assert again.ask("POST", "/api/stop_after_pulse")[0] == 403
    for page in (eve, again):
        page.close()


def test_what_is_too_large_is_not_taken_in(server):
    assert server.ask("POST", "/api/stop", b"x" * 300_000)[0] == 413
    assert server.ask("GET", "/api/status")[0] == 200


def answer_before_the_body(raw, head, body):
    """What is read by who sends the body of a request only when the answer is there already."""
    raw.sendall(head.encode())
    raw.settimeout(PATIENCE_S)
    assert raw.recv(1, socket.MSG_PEEK)
    raw.sendall(body)
    parts = []
    while part := raw.recv(65536):
        parts.append(part)
    return b"".join(parts)


def sent_until_refused(raw, head):
    """How many bytes of a body without an end are sent until the connection is closed."""
    sent = 0
    raw.sendall(head.encode())
    with suppress(ConnectionError):
        while sent < 1 << 30:
            sent += raw.send(b"x" * 65536)
    return sent


class TestWhoIsRefused:
    """Is told why, also while still sending; but is not listened to for ever."""

    @pytest.fixture(params=["panel", "stop"])
    def head(self, request, server):
        """Where a page of somebody else posts to, and how it begins."""
        url = server.ask("GET", "/api/status")[1]["stop_url"]
        netloc = server.netloc if request.param == "panel" else urlsplit(url).netloc
        path = "/api/stop" if request.param == "panel" else "/stop"
        head = f"POST {path} HTTP/1.1\r\nHost: {netloc}\r\nOrigin: http://evil.example\r\n"
        return netloc.split(":"), head

    @pytest.fixture
    def raw(self, head):
        """A connection that holds back little of what is sent on it."""
        with socket.create_connection(head[0], PATIENCE_S) as raw:
            raw.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
            yield raw

    def test_reads_the_sentence_though_the_body_is_sent_after_it(self, head, raw):
        body = b"x" * 200_000
        head = f"{head[1]}Content-Length: {len(body)}\r\n\r\n"
        told = answer_before_the_body(raw, head, body)
        assert b" 403 " in told.partition(b"\r\n")[0]
        assert b'"error": "' in told

    def test_is_not_listened_to_for_ever(self, head, raw):
        sent = sent_until_refused(raw, f"{head[1]}Content-Length: {1 << 30}\r\n\r\n")
        assert sent < 32 << 20  # what the sockets hold back included

    def test_is_not_waited_for_for_ever(self, head, raw):
        raw.sendall(f"{head[1]}Content-Length: 1000\r\n\r\n".encode())
        raw.settimeout(10)
        while raw.recv(65536):
            pass  # until it is closed

    def test_reads_that_a_body_is_too_large(self, server):
        for size in ("Content-Length: 600000", "Transfer-Encoding: chunked"):
            with socket.create_connection(server.netloc.split(":"), PATIENCE_S) as raw:
                head = f"POST /api/stop HTTP/1.1\r\nHost: {server.netloc}\r\n{size}\r\n"
                head += f"Authorization: Bearer {server.token}\r\n\r\n"
                chunk = b"" if "Content" in size else b"%x\r\n" % 600_000
                raw.sendall(head.encode() + chunk + b"x" * 600_000)
                assert b" 413 " in raw.recv(65536).partition(b"\r\n")[0], size
                assert server.ask("GET", "/api/status")[0] == 200


def test_bodies_that_make_no_sense_are_told_so_in_a_sentence(server):
    for body in (
        b"",
        b"{",
        b"[]",
        b'{"do": 3}',
        b'{"do": "take", "x": 1}',
        b"[" * 10_000,
        b"\xff\xfe",
    ):
        status, answer = server.ask("POST", "/api/control", body)
        assert status == 400, body[:10]
        assert isinstance(answer["error"], str)


def closing_code(page):
    """With which the server closes a page's socket."""
    try:
        while True:
            page.socket.recv(timeout=PATIENCE_S)
    except ConnectionClosed as closed:
        return closed.rcvd.code


@pytest.mark.parametrize("word", ["x" * 5000, "x" * 500_000, b"\x00" * 10])
def test_a_socket_that_says_too_much_is_closed(server, word):
    page = Page(server, reads=False)
    with suppress(ConnectionClosed):
        page.socket.send(word)
    assert closing_code(page) == 1009


def test_a_socket_that_says_too_often_is_closed(server):
    page = Page(server, reads=False)
    with suppress(ConnectionClosed):
        for _ in range(200):
            page.socket.send('{"do": "nothing"}')
    assert closing_code(page) == 1008


def test_words_that_make_no_sense_change_nothing(server):
    page = Page(server)
    for word in ("{", "[]", "3", '"x"', '{"do": {"do": []}}', "[" * 2000):
        page.socket.send(word)
    page.say(do="ping")
    page.until("pong", PATIENCE_S)
    page.close()


def test_a_flood_is_answered_with_a_refusal_and_ends(server):
    request = f"GET /favicon.ico HTTP/1.1\r\nHost: {server.netloc}\r\n\r\n".encode()
    seen = b""
    with socket.create_connection(server.netloc.split(":"), PATIENCE_S) as raw:
        raw.sendall(600 * request)
        while part := raw.recv(65536):  # a refusal closes the connection
            seen += part
    assert b" 404 " in seen
    assert b" 429 " in seen
    time.sleep(2)  # noqa: TID251 - the bucket fills in real time
    assert server.ask("GET", "/api/status")[0] == 200


def test_connections_that_say_nothing_do_not_keep_others_out(server):
    with_nothing_to_say = [
        socket.create_connection(server.netloc.split(":"), PATIENCE_S) for _ in range(100)
    ]
    try:
        assert server.ask("GET", "/api/status")[0] == 200
    finally:
        for connection in with_nothing_to_say:
            connection.close()


class TestStop:
    """The STOP process is as careful, and answers nobody else."""

    @pytest.fixture
    def stop(self, server):
        """Its address."""
        url = server.ask("GET", "/api/status")[1]["stop_url"]
        return urlsplit(url).netloc

    def test_token_and_origin_are_needed(self, server, stop):
        own = {"Origin": server.origin, "Cookie": f"labrig_token={server.token}"}
        refused = [
            ({}, 403),
            ({**own, "Cookie": "labrig_token=x"}, 401),
            ({"Origin": server.origin}, 401),
            ({**own, "Origin": "http://evil.example"}, 403),
            ({"Cookie": own["Cookie"]}, 403),
            ({**own, "Host": "evil.example"}, 403),
            ({"Authorization": "Bearer x"}, 403),
        ]
        for headers, wanted in refused:
            given = server.ask("POST", "/stop", {}, headers, as_browser=False, netloc=stop)
            assert given[0] == wanted, headers

    def test_other_sites_are_not_told_that_they_may(self, server, stop):
        for origin, wanted in (("http://evil.example", None), (server.origin, server.origin)):
            connection = http.client.HTTPConnection(stop, timeout=PATIENCE_S)
            connection.request("OPTIONS", "/stop", headers={"Origin": origin})
            answer = connection.getresponse()
            answer.read()
            assert answer.getheader("Access-Control-Allow-Origin") == wanted
            connection.close()

    def test_nonsense_with_the_token_is_a_stop_all_the_same(self, server, stop):
        for body in (b"", b"{", b"[]", b"\xff"):
            status, answer = server.ask("POST", "/stop", body, netloc=stop)
            assert status == 200
            assert answer["output"] == "safe"
            assert answer["told"].startswith("no run of this panel is going on; labrig safe: ")
        for length in ("-1", "x", "1e3", "99999999", "٣"):
            with socket.create_connection(stop.split(":"), PATIENCE_S) as raw:
                head = f"Host: {stop}\r\nAuthorization: Bearer {server.token}\r\n"
                head = f"POST /stop HTTP/1.1\r\n{head}Content-Length: {length}\r\n\r\n"
                raw.sendall(head.encode())
                assert b" 200 " in raw.recv(64)

    def test_it_answers_while_others_hold_connections_open(self, server, stop):
        held = [socket.create_connection(stop.split(":"), PATIENCE_S) for _ in range(40)]
        try:
            assert server.ask("POST", "/stop", {}, netloc=stop)[0] == 200
        finally:
            for connection in held:
                connection.close()

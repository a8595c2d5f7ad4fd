"""The server of a live page: accepted and rejected requests, sent through sockets as any program of the machine could."""

import json
import re
import socket

import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.viewer import live
from kinetostatics.viewer.live import serve


@pytest.fixture(scope="module")
def server():
    with serve(package_robots.robot("3rps").assemble(), ks.analyze) as server:
        yield server


def send_request(server, head, body=b"", **headers):
    """Send a request, in which ``KEY`` and ``PORT`` are the server's; return status and text of the answer."""
    port, key = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/(.+)/", server.url).groups()
    headers = {"Host": f"127.0.0.1:{port}", "Content_Length": len(body), **headers}
    lines = [f"{head} HTTP/1.1".replace("KEY", key)]
    lines += [f"{name.replace('_', '-')}: {value}".replace("PORT", port) for name, value in headers.items() if value is not None]
    with socket.create_connection(("127.0.0.1", int(port)), timeout=60) as connection:
        connection.sendall("\r\n".join([*lines, "", ""]).encode() + body)
        answer = b"".join(iter(lambda: connection.recv(1 << 16), b""))
    head, _, text = answer.partition(b"\r\n\r\n")
    return int(head.split()[1]), text.decode()


@pytest.mark.parametrize(
    ("head", "headers", "status"),
    [
        ("GET /KEY/", {}, 200),
        ("GET /KEY/", {"Host": "localhost:1234"}, 200),  # through a tunnel
        ("GET /favicon.ico", {}, 200),
        ("GET /", {}, 404),
        ("GET /KEY/", {"Host": "evil.example:PORT"}, 404),  # a foreign name that resolves to this machine
        ("GET /KEY/", {"Host": None}, 404),
        ("POST /KEY/analyze", {"Origin": "http://127.0.0.1:PORT"}, 200),
        ("POST /KEY/analyze", {"Origin": "http://evil.example"}, 404),
        ("POST /KEY/analyze", {"Origin": "null"}, 404),
        ("POST /KEY/analyze", {"Host": "evil.example", "Origin": "http://evil.example"}, 404),
        ("POST /analyze", {"Content_Length": 300_000_000}, 404),  # the key is checked before the length
        ("POST /analyze", {"Content_Length": -1}, 404),
        ("POST /KEY/analyze", {"Content_Length": live.LONGEST + 1}, 413),
        ("POST /KEY/analyze", {"Content_Length": -1}, 413),
        ("POST /KEY/analyze", {"Content_Length": None, "Transfer_Encoding": "chunked"}, 413),
        ("POST /KEY/analyze", {"Content_Length": "9" * 5000}, 413),
    ],
)
def test_request_needs_valid_key_host_origin_and_length(server, head, headers, status):
    assert send_request(server, head, **headers)[0] == status


@pytest.mark.parametrize(
    "question",
    [
        b"", b"{", b"{}", b"[]", b"null", b"\xff", b"[" * 50_000, b'{"kind":' * 8_000, b'{"kind": [[]], "values": {"z": 1}}',
        b'{"kind": "platform", "values": 3}', b'{"kind": "platform", "values": {"z": {}, "rx": 0, "ry": 0}}',
        b'{"kind": "platform", "values": {"z": 1' + b"0" * 400 + b', "rx": 0, "ry": 0}}',
        b'{"kind": "details", "groups": [[]]}' + b" " * 60_000 + b"?",
    ],
)  # fmt: skip
def test_malformed_request_bodies_are_answered_with_an_error(server, question):
    status, text = send_request(server, "POST /KEY/analyze", question)
    assert status == 200 and "request of the page is invalid" in json.loads(text)["error"]


@pytest.mark.few(2)
@pytest.mark.parametrize("z", ["1e7", "1e17", "1e300", "NaN", "1e999"])
def test_server_answers_after_an_unreachable_pose(server, z):
    """Unreachable or not finite: the pose gets an answer, and the next request gets one with numbers."""
    answer = json.loads(
        send_request(server, "POST /KEY/analyze", b'{"kind": "platform", "values": {"z": %b, "rx": 0, "ry": 0}}' % z.encode())[1]
    )
    assert "error" in answer or "stations" in answer
    assert json.loads(send_request(server, "POST /KEY/analyze", b'{"kind": "details"}')[1])["stations"]


def test_incomplete_request_times_out_and_used_port_is_an_error(monkeypatch):
    monkeypatch.setattr(live, "PATIENCE", 0.1)
    with serve(package_robots.robot("3rps").assemble(), ks.analyze) as server:
        with pytest.raises(IndexError):  # the connection ends without an answer
            send_request(server, "POST /KEY/analyze", b"{}", Content_Length=100)
        with pytest.raises(ks.KinetostaticsError, match="cannot serve"):
            serve(package_robots.robot("3rps").assemble(), ks.analyze, port=int(server.url.split(":")[2].split("/")[0]))

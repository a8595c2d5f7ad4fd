"""Firefox without a window, by its Marionette protocol: messages of JSON, each behind its length, on a local socket.

WebGL without a graphics card needs a display: that of Xvfb.
"""

import contextlib
import json
import os
import shutil
import socket
import subprocess
import time

FIREFOX = shutil.which("firefox-esr") or shutil.which("firefox")
PREFERENCES = 'user_pref("marionette.port", %d);\nuser_pref("webgl.force-enabled", true);\n'


@contextlib.contextmanager
def visited(address, profile, patience=120):
    """Open a page, and yield a function that runs a script in it and returns its value."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    profile.mkdir()
    (profile / "user.js").write_text(PREFERENCES % port)
    reading, writing = os.pipe()
    screen = subprocess.Popen(
        ["Xvfb", "-displayfd", str(writing), "+extension", "GLX"], pass_fds=[writing], stderr=subprocess.DEVNULL
    )
    os.close(writing)
    with os.fdopen(reading) as numbers:
        display = f":{numbers.readline().strip()}"
    command = [FIREFOX, "--headless", "--marionette", "--no-remote", "--profile", str(profile)]
    environment = {**os.environ, "DISPLAY": display, "LIBGL_ALWAYS_SOFTWARE": "1"}
    browser = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)
    try:
        with _connected(port, time.monotonic() + patience) as connection:
            _answer(connection)  # its greeting
            _ask(connection, "WebDriver:NewSession", {})
            _ask(connection, "WebDriver:Navigate", {"url": address})
            yield lambda script: _ask(connection, "WebDriver:ExecuteScript", {"script": script, "args": [], "sandbox": None})[
                "value"
            ]
    finally:
        for process in (browser, screen):
            process.terminate()
            process.wait()


def _connected(port, until):
    while True:
        try:
            return socket.create_connection(("127.0.0.1", port), timeout=120)
        except OSError:
            if time.monotonic() > until:
                raise
            time.sleep(0.2)


def _ask(connection, name, parameters):
    text = json.dumps([0, 1, name, parameters])
    connection.sendall(f"{len(text.encode())}:{text}".encode())
    _, _, error, answer = _answer(connection)
    assert error is None, error
    return answer


def _answer(connection):
    length = b""
    while not length.endswith(b":"):
        length += connection.recv(1)
    text = b""
    while len(text) < int(length[:-1]):
        text += connection.recv(int(length[:-1]) - len(text))
    return json.loads(text)

"""Connections to a running meshcat-server, or to a new one on this machine."""

from __future__ import annotations

import contextlib
import io
import subprocess
import sys
from collections.abc import Iterator

import zmq
from meshcat.visualizer import ViewerWindow, Visualizer

from kinetostatics.exceptions import ArgumentError, KinetostaticsError

#: Timeout of a server's response [ms].
PATIENCE = 10_000
#: Program that runs meshcat's server on the local address only; by default it serves its page to all networks.
LOCAL_SERVER = """
import functools, tornado.web
tornado.web.Application.listen = functools.partialmethod(tornado.web.Application.listen, address="127.0.0.1")
from meshcat.servers.zmqserver import main
main()
"""


@contextlib.contextmanager
def connected(url: str | None) -> Iterator[Visualizer]:
    """Yield the visualizer of the meshcat-server at a ZeroMQ address, or of a new local server, which ends with the context.

    Raises:
        KinetostaticsError: no server answers, or none can be started.
    """
    with contextlib.ExitStack() as stack:
        server, address = (None, url) if url else stack.enter_context(_local_server())
        with contextlib.redirect_stdout(io.StringIO()):  # it prints its address
            visualizer = _reached(address)
        visualizer.window.server_proc = server
        try:
            yield visualizer
        except zmq.ZMQError as error:
            raise KinetostaticsError(f"the meshcat-server does not answer any more: {error}") from None


@contextlib.contextmanager
def _local_server() -> Iterator[tuple[subprocess.Popen[str], str]]:
    """Run a server; yield its process and its ZeroMQ address."""
    command = [sys.executable, "-u", "-c", LOCAL_SERVER]
    server = subprocess.Popen(  # in a separate session, so that Ctrl+C does not reach it
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, start_new_session=True
    )
    try:
        assert server.stdout is not None
        answer = server.stdout.readline().strip()
        if not answer.startswith("zmq_url="):
            raise KinetostaticsError("meshcat's server does not start; for the reason, run python -m meshcat.servers.zmqserver")
        yield server, answer.removeprefix("zmq_url=")
    finally:
        server.terminate()
        server.wait()


def _reached(url: str) -> Visualizer:
    """Return the visualizer of a running server, with timeouts for its sockets."""
    limits = {zmq.RCVTIMEO: PATIENCE, zmq.SNDTIMEO: PATIENCE, zmq.LINGER: 0}
    before = ViewerWindow.context
    ViewerWindow.context = zmq.Context()
    for option, value in limits.items():
        ViewerWindow.context.setsockopt(option, value)
    try:
        return Visualizer(zmq_url=url)
    except zmq.ZMQError:
        raise ArgumentError(
            f"no meshcat-server answers at {url!r}; give the zmq_url that it printed, such as tcp://127.0.0.1:6000"
        ) from None
    finally:
        ViewerWindow.context = before

"""Live pages: a page sends the values of its sliders; Python analyses the pose and returns a new scene.

meshcat's own socket transmits commands in one direction only, to the page. The page therefore sends HTTP requests: each motion of
a slider is a POST to the address of the page, and the response contains the changes of the scene. The server listens on this
machine only, at an address with a random key. Key, origin and stated length of a request are checked before its body is read.
"""

from __future__ import annotations

import contextlib
import json
import re
import secrets
import threading
from collections.abc import Callable, Mapping, Sequence
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.arguments import Keyword
from kinetostatics.engine.programs import check_engine, compiled_statics
from kinetostatics.exceptions import (
    ArgumentError,
    AssemblyError,
    CoordinatesError,
    KinetostaticsError,
    RobotFileError,
    StaticsError,
)
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.report import Json
from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import WRENCH_COMPONENTS
from kinetostatics.results.result import Result
from kinetostatics.robot import Robot, robot_of
from kinetostatics.viewer.description import Scene
from kinetostatics.viewer.page import page_html
from kinetostatics.viewer.scene import describe_scene
from kinetostatics.viewer.single_poses import UnloadedPose
from kinetostatics.viewer.sliders import Sliders, written
from kinetostatics.viewer.visuals import link_visuals

#: Allowed host names; requests for others are refused, as a protection against DNS rebinding.
LOCAL_NAMES = ("127.0.0.1", "localhost")
#: Largest size of a request [bytes], and timeout for each part of it [s].
LONGEST, PATIENCE = 1 << 16, 10


class LiveRobot:
    """A robot whose pose and load are changed by sliders of actuators, platform coordinates and load components.

    A pose that cannot be analysed is drawn without loads; a note gives the reason.

    Attributes:
        configuration: the present pose, from which the next one is assembled; None, without sliders, if the loops cannot be
            closed.
        load: (6,) force and moment at o [N, N·m]; None if it is not changed by sliders.
    """

    def __init__(
        self,
        start: Configuration | Robot,
        analyze: Callable[..., Result],
        orientation: str | None = None,
        closure_tolerance: float = 1e-10,
        coordinates: Sequence[str] = (),
        load: ArrayLike | None = None,
        message: str | None = None,
    ) -> None:
        """Start at a pose; for the arguments see :func:`serve`."""
        if isinstance(start, Configuration) and start.shape != ():
            raise ArgumentError("a live page starts from one pose, not from a batch")
        self.configuration = start if isinstance(start, Configuration) else None
        self.robot = robot_of(start) if isinstance(start, Configuration) else start
        self.analyze, self.orientation, self.closure_tolerance = analyze, orientation, closure_tolerance
        self.visuals = link_visuals(self.robot.description)
        self.load = None if load is None else np.array(load, dtype=float)
        self.result: Result | UnloadedPose = UnloadedPose(start, message)
        self.sliders: Sliders | None = None
        if self.configuration is not None:
            self.result = self._analyzed(self.configuration, self.load)
        scene = describe_scene(self.result, visuals=self.visuals)
        if message and message not in scene.notes:
            scene.notes.insert(0, message)
        if self.configuration is not None:
            self.sliders = Sliders(self.configuration, orientation, coordinates, self.load, scene.size)
        scene.live = self._controls()
        self.first = scene.plain()

    def answer(self, question: Mapping[str, Json]) -> dict[str, object]:
        """Return the entries of the scene that a request of the page changes.

        If the requested coordinates cannot be reached, the robot moves to the last valid pose on the straight line to them, and
        the entry ``rim`` gives the reason.

        Args:
            question: the request. Its ``kind`` is "actuators", "platform" or "load", with values of sliders in ``values``; or
                "details", for notes and cards, which take longer. With ``details`` true, other kinds include notes and cards,
                too. If the new pose has other contributions than those in ``contributions``, the whole scene is returned.

        Raises:
            KinetostaticsError: the pose cannot be analysed; the robot stays at the last pose.
        """
        kind, rim = question["kind"], {}
        if kind != "details":
            rim = {"rim": self._move(kind, question["values"])}
        details = kind == "details" or bool(question.get("details")) or isinstance(self.result, UnloadedPose)
        scene = self._scene(details)
        if tuple(question.get("contributions", scene.stations.contribution_names)) != scene.stations.contribution_names:
            return {**self._scene().plain(), **rim}
        return {**scene.moving(), **(scene.details() if details else {}), **rim}

    def compile(self, go_on: Callable[[], bool]) -> None:
        """Compile the functions for requests, until ``go_on()`` is false; NumPy is used for functions not yet compiled."""
        if check_engine("auto") == "numpy" or self.configuration is None:
            return
        asked: list[dict[str, object]] = [{"actuators": self.configuration.actuators}] if self.robot.description.actuated else []
        if self.sliders is not None and self.sliders.coordinates:
            present = self.sliders.present(self.configuration, "platform")
            asked.insert(0, {"platform": {name: present[name] for name in self.sliders.coordinates}})
        if go_on():
            compiled_statics(self.robot, self.robot.statics)
        for coordinates in asked:
            if go_on():
                with contextlib.suppress(KinetostaticsError):
                    self._assembled(coordinates, engine="compiled")

    def reach(self) -> Mapping[str, object]:
        """Return :meth:`.Sliders.reach` at the present pose; an empty mapping if the pose changes during the computation."""
        pose = self.configuration
        if pose is None or self.sliders is None:
            return {}
        ranges = self.sliders.reach(pose, lambda: self.configuration is pose)
        return ranges if self.configuration is pose else {}

    def _move(self, kind: str, shown: Mapping[str, float]) -> str:
        """Move to the values of sliders; return the reason if they cannot be reached, else an empty text."""
        assert self.sliders is not None and self.configuration is not None
        values = {name: float(value) * self.sliders.factors[kind, name] for name, value in shown.items()}
        configuration, load, rim = self.configuration, self.load, ""
        if kind == "load":
            load = np.array([values[name] for name in WRENCH_COMPONENTS])
        else:
            with contextlib.suppress(AssemblyError):
                configuration = self._assembled({kind: values})
            if configuration is self.configuration or configuration.limits_exceeded.keys() - self.configuration.limits_exceeded:
                configuration, rim = self._rim(self.configuration, kind, values)
        self.result, self.configuration, self.load = self._analyzed(configuration, load), configuration, load
        return rim

    def _analyzed(self, configuration: Configuration, load: Array | None) -> Result | UnloadedPose:
        try:
            return self.analyze(configuration) if load is None else self.analyze(configuration, load=load)
        except (StaticsError, CoordinatesError, RobotFileError) as error:
            return UnloadedPose(configuration, str(error))

    def _assembled(self, asked: Mapping[str, Keyword], engine: str = "auto") -> Configuration:
        rules: dict[str, Keyword] = {
            "orientation": self.orientation,
            "near": self.configuration,
            "closure_tolerance": self.closure_tolerance,
        }
        return self.robot.assemble(**asked, **rules, engine=engine)

    def _rim(self, pose: Configuration, kind: str, values: Mapping[str, float]) -> tuple[Configuration, str]:
        """Return the last valid pose on the straight line from ``pose`` to coordinates, and why the line ends there."""
        assert self.sliders is not None
        present = {name: float(self.sliders.present(pose, kind)[name]) for name in values}
        lines = self.sliders.shortened({name: np.array([value - present[name]]) for name, value in values.items()}, kind)
        (end,) = self.sliders.ends(pose, kind, lines)
        reached = {name: present[name] + end.part * float(line[0]) for name, line in lines.items()}
        rim = pose
        with contextlib.suppress(AssemblyError):
            rim = self._assembled({kind: reached})
        moved = {name: self.sliders.factors[kind, name] for name, line in lines.items() if abs(float(line[0])) > 1e-6}
        words = [
            f"{name} stops at {written(float(self.sliders.present(rim, kind)[name]), factor)}" for name, factor in moved.items()
        ]
        return rim, f"{', '.join(words)}: {self.sliders.reason(end)}"

    def _scene(self, details: bool = True) -> Scene:
        scene = describe_scene(self.result, visuals=self.visuals, details=details)
        scene.live = self._controls()
        return scene

    def _controls(self) -> dict[str, object]:
        pose = self.result.configuration
        return {"url": "analyze", "controls": [] if self.sliders is None or pose is None else self.sliders.at(pose, self.load)}


class LiveServer:
    """Server of a live page on this machine; a context manager that closes it.

    Attributes:
        url: address of the page.
    """

    def __init__(self, robot: LiveRobot, port: int = 0) -> None:
        """Start the server in the background.

        Args:
            robot: robot that answers the requests.
            port: port of 127.0.0.1; 0: any free port.

        Raises:
            KinetostaticsError: the port cannot be used.
        """
        key = secrets.token_urlsafe(16)
        try:
            self._server = ThreadingHTTPServer(("127.0.0.1", port), _handler(robot, key))
        except OSError as error:
            raise KinetostaticsError(f"cannot serve on port {port}: {error.strerror or error}") from None
        self._server.daemon_threads = True
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)
        self._thread.start()
        self._closed = threading.Event()
        self._compiling = threading.Thread(target=robot.compile, args=[lambda: not self._closed.is_set()], daemon=True)
        self._compiling.start()
        self.url = f"http://127.0.0.1:{self._server.server_port}/{key}/"

    def __enter__(self) -> LiveServer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<LiveServer at {self.url}>"

    def _repr_html_(self) -> str:
        return f'<iframe src="{self.url}" style="width: 100%; height: 640px; border: 1px solid #d5d9df"></iframe>'

    def wait(self) -> None:
        """Wait until the program is interrupted or the server is closed."""
        self._thread.join()

    def close(self) -> None:
        self._closed.set()
        self._server.shutdown()
        self._server.server_close()
        self._compiling.join()  # ending the program during compilation would crash it


def _handler(robot: LiveRobot, key: str) -> type[BaseHTTPRequestHandler]:
    lock = threading.Lock()  # one analysis at a time
    page = page_html(robot.first)

    class Handler(BaseHTTPRequestHandler):
        timeout = PATIENCE

        def do_GET(self) -> None:
            if self._is_for(""):
                self._reply(200, page, "text/html")
            elif self.path == "/favicon.ico":
                self._reply(200, "", "image/x-icon")
            else:
                self._reply(404, "nothing here")

        def do_POST(self) -> None:
            length = self.headers.get("Content-Length", "")
            if not self._is_for("analyze"):
                self._reply(404, "nothing here")
            elif not re.fullmatch("[0-9]{1,9}", length) or int(length) > LONGEST:
                self._reply(413, f"a request must state its length, at most {LONGEST} bytes")
            else:
                self._reply(200, self._answer(self.rfile.read(int(length))), "application/json")

        def _is_for(self, name: str) -> bool:
            """Whether host and origin are this server, and the path is ``/KEY/name``."""
            host = self.headers.get("Host", "")
            here = host.partition(":")[0] in LOCAL_NAMES and self.headers.get("Origin", f"http://{host}") == f"http://{host}"
            return here and self.path == f"/{key}/{name}"

        def _answer(self, question: bytes) -> str:
            try:
                asked = json.loads(question)
                if asked["kind"] == "reach":  # outside the lock: analyses do not wait for it
                    return json.dumps(robot.reach(), allow_nan=False)
                with lock:
                    answer = robot.answer(asked)
                return json.dumps(answer, allow_nan=False)
            except KinetostaticsError as error:  # shown by the page
                return json.dumps({"error": str(error)})
            except Exception as error:  # every request gets a response
                return json.dumps({"error": f"the request of the page is invalid: {error!r}"})

        def _reply(self, status: int, text: str, kind: str = "text/plain") -> None:
            body = text.encode()
            with contextlib.suppress(ConnectionError):  # the page may have been closed
                self.send_response(status)
                self.send_header("Content-Type", f"{kind}; charset=utf-8")
                self.send_header("Content-Length", str(len(body)))
                self.send_header("Cache-Control", "no-store")
                self.end_headers()
                self.wfile.write(body)

        def log_message(self, format: str, *args: object) -> None:
            pass

    return Handler


def serve(
    start: Configuration | Robot,
    analyze: Callable[..., Result],
    *,
    orientation: str | None = None,
    closure_tolerance: float = 1e-10,
    coordinates: Sequence[str] = (),
    load: ArrayLike | None = None,
    port: int = 0,
    message: str | None = None,
) -> LiveServer:
    """Serve a page whose sliders move the robot.

    Args:
        start: the first pose; or a robot whose loops cannot be closed.
        analyze: function that analyses a pose, for example ``lambda pose: ks.analyze(pose, load=[0, 0, -500, 0, 0, 0])``.
        orientation, closure_tolerance: see :meth:`Robot.assemble`.
        coordinates: platform coordinates with sliders; default: well-conditioned ones that determine the pose.
        load: (6,) initial force and moment at o, world axes [N, N·m], changed by sliders. ``analyze`` is called with the sliders'
            values as ``load=``, for example ``lambda pose, load: ks.analyze(pose, load=load)``.
        port: port of 127.0.0.1; 0: any free port.
        message: note shown with the first pose.
    """
    return LiveServer(LiveRobot(start, analyze, orientation, closure_tolerance, coordinates, load, message), port)

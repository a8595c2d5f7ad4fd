"""Live pages: the page sends the values of its sliders, Python analyses that pose and returns a new scene.

meshcat's own socket only carries commands to the page. The page therefore sends requests by HTTP: moving a slider is a POST to
the address of the page, and the response contains the changes of the scene. The server is that of the standard library. It
listens on this machine only, at an address with a random key. Of a request the key and origin are checked first, then the stated
length, before its body is read.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import math
import re
import secrets
import threading
from collections.abc import Callable, Mapping, Sequence
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.argument_checks import Keyword
from kinetostatics.engine.programs import check_engine, compiled_statics
from kinetostatics.exceptions import ArgumentError, AssemblyError, KinetostaticsError
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.plain import Json
from kinetostatics.math.screws import WRENCH_COMPONENTS
from kinetostatics.results.result import Result
from kinetostatics.robot import robot_of
from kinetostatics.viewer.description import Scene
from kinetostatics.viewer.page import page_html
from kinetostatics.viewer.scene import describe_scene
from kinetostatics.viewer.visuals import link_visuals

#: How far sliders without limits reach from where they start: part of the robot's size, and radians.
REACH, TURN = 0.15, math.radians(30)
#: Parts of the way to the rim of reach where a pose is tried: on the rim itself actuators and platform part company.
NEARLY = (0.999, 0.99, 0.9)
#: Names by which this machine may be asked, or else a page elsewhere could let its own name lead here.
LOCAL_NAMES = ("127.0.0.1", "localhost")
#: The longest question [bytes], and how long the server waits for the next part of a request [s].
LONGEST, PATIENCE = 1 << 16, 10


class LiveRobot:
    """A pose that sliders change: of the actuators, of platform coordinates that determine the pose, and of the load.

    Attributes:
        configuration: the last pose that could be analysed; the next one starts there.
        load: (6,) force and moment at o [N, N·m], or None where ``analyze`` has its own.
    """

    def __init__(
        self,
        configuration: Configuration,
        analyze: Callable[..., Result],
        orientation: str | None = None,
        closure_tolerance: float = 1e-10,
        coordinates: Sequence[str] = (),
        load: ArrayLike | None = None,
    ) -> None:
        """Start at a pose.

        Args:
            configuration: one pose.
            analyze: how a pose is analysed: load and gravity are chosen there.
            orientation, closure_tolerance: as in :meth:`Robot.assemble`.
            coordinates: platform coordinates that get sliders; none: those that determine the pose best.
            load: (6,) at o [N, N·m], which gets sliders; ``analyze`` is given it as ``load=`` then.
        """
        if configuration.shape != ():
            raise ArgumentError("a live page starts from one pose, not from a batch")
        self.configuration, self.analyze = configuration, analyze
        self.robot, self.orientation, self.closure_tolerance = robot_of(configuration), orientation, closure_tolerance
        self.visuals = link_visuals(self.robot.description)
        self.load = None if load is None else np.array(load, dtype=float)
        self.result = self._analyzed(configuration)
        self.scene = describe_scene(self.result, visuals=self.visuals)
        self.size = self.scene.size
        self.coordinates = tuple(coordinates) or self._determining()
        self.controls = [self._actuator(name) for name in self.robot.description.driven]
        self.controls += [self._platform(name) for name in self.coordinates]
        if self.load is not None:
            self.controls += [self._load(k, name, self.result) for k, name in enumerate(WRENCH_COMPONENTS)]
        self.factors = {(item["kind"], item["coordinate"]): item.pop("factor") for item in self.controls}
        self._control(self.scene, self.result)
        self.first = self.scene.plain()

    def answer(self, question: Mapping[str, Json]) -> dict[str, object]:
        """Return what of the scene changes at ``{"kind": "actuators", "platform" or "load", "values": {name: shown value}}``.

        Notes and cards take as long as all the rest: they come along with ``"told": true``. ``"groups": [...]`` says which arrows
        are wanted, if not all. ``"kind": "told"`` asks for everything again, of the last pose.
        A pose that cannot be reached is answered with the last one on the straight way to it, and ``rim`` says why.

        Raises:
            KinetostaticsError: the pose cannot be analysed; the last one stays.
        """
        kind = question["kind"]
        if kind == "told":
            return {**self._scene(self.result), **self._told()}
        groups = question.get("groups")
        answer = self._moved(kind, question["values"], None if groups is None else set(groups))
        return {**answer, **self._told()} if question.get("told") else answer

    def compile(self, go_on: Callable[[], bool]) -> None:
        """Have compiled code made of what answers take, as long as one may go on: until it is there NumPy answers."""
        if check_engine("auto") == "numpy":
            return
        asked: list[dict[str, object]] = [{"actuators": self.configuration.actuators}] if self.robot.description.driven else []
        if self.coordinates:
            present = self.configuration.platform_coordinates(self.orientation)
            asked.insert(0, {"platform": {name: present[name] for name in self.coordinates}})
        if go_on():
            compiled_statics(self.robot, self.robot.statics)
        for coordinates in asked:
            if go_on():
                with contextlib.suppress(KinetostaticsError):
                    self._assembled(coordinates, engine="compiled")

    def _told(self) -> dict[str, object]:
        return describe_scene(self.result, visuals=self.visuals).told()

    def _moved(self, kind: str, shown: Mapping[str, float], groups: set[str] | None) -> dict[str, object]:
        values = {name: float(value) * self.factors[kind, name] for name, value in shown.items()}
        if kind == "load" and self.load is not None:
            before = self.load
            self.load = np.array([values[name] for name in WRENCH_COMPONENTS])
            try:
                return self._scene(self._analyzed(self.configuration), groups)
            except KinetostaticsError:
                self.load = before
                raise
        configuration, rim = self.configuration, ""
        try:
            configuration = self._assembled({kind: values})
        except AssemblyError as error:
            configuration = self._rim(kind, values, error)
            rim = self._rim_text(kind, values, configuration)
        scene = self._scene(self._analyzed(configuration), groups)
        self.configuration = configuration
        return {**scene, "rim": rim}

    def _analyzed(self, configuration: Configuration) -> Result:
        return self.analyze(configuration) if self.load is None else self.analyze(configuration, load=self.load)

    def _assembled(self, asked: Mapping[str, Keyword], engine: str = "auto") -> Configuration:
        rules: dict[str, Keyword] = {
            "orientation": self.orientation,
            "near": self.configuration,
            "closure_tolerance": self.closure_tolerance,
        }
        return self.robot.assemble(**asked, **rules, engine=engine)

    def _rim(self, kind: str, values: Mapping[str, float], error: AssemblyError) -> Configuration:
        """Return the last pose that is reached on the straight way to coordinates that are not; the present one if none is."""
        present = (
            self.configuration.platform_coordinates(self.orientation) if kind == "platform" else self.configuration.actuators
        )
        for part in ((error.reached or 0.0) * nearly for nearly in NEARLY):
            if part > 0:
                way = {name: float(present[name]) + part * (value - float(present[name])) for name, value in values.items()}
                with contextlib.suppress(KinetostaticsError):
                    return self._assembled({kind: way})
        return self.configuration

    def _rim_text(self, kind: str, values: Mapping[str, float], rim: Configuration) -> str:
        """Return which coordinates stay short of what was asked, in the units and digits of their sliders."""
        reached = rim.platform_coordinates(self.orientation) if kind == "platform" else rim.actuators
        words = []
        for name, unit in ((name, "mm" if self.factors[kind, name] == 1e-3 else "°") for name in values):
            asked, there = (float(value) / self.factors[kind, name] + 0.0 for value in (values[name], reached[name]))
            if abs(asked - there) > 0.05:
                words.append(f"{name} = {asked:.1f} {unit} (the robot stops at {there:.1f} {unit})")
        return f"cannot reach {', '.join(words)}" if words else "cannot reach this pose"

    def _scene(self, result: Result, groups: set[str] | None = None) -> dict[str, object]:
        scene = describe_scene(result, visuals=self.visuals, like=self.scene, groups=groups)
        self._control(scene, result)
        self.result = result
        return scene.moving()

    def _control(self, scene: Scene, result: Result) -> None:
        """Let the sliders of a scene stand where its pose is."""
        platform = result.configuration.platform_coordinates(self.orientation)
        for control in self.controls:
            kind, name = control["kind"], control["coordinate"]
            if kind == "load":
                value = result.load[WRENCH_COMPONENTS.index(name)]
            else:
                value = result.configuration.actuators[name] if kind == "actuators" else platform[name]
            control["value"] = float(value) / self.factors[kind, name]
        scene.live = {"url": "analyze", "controls": [dict(control) for control in self.controls]}

    # ---- sliders ----------------------------------------------------------------------------------------------------

    def _determining(self) -> tuple[str, ...]:
        """Return the platform coordinates that determine the pose best: those that the actuators move most independently."""
        robot, pose, step = self.robot, self.configuration, 1e-4
        actuators = list(robot.description.driven)
        steps = np.eye(len(actuators)) * step
        values = {name: float(pose.actuators[name]) + steps[k] for k, name in enumerate(actuators)}
        present = pose.platform_coordinates(self.orientation)
        try:
            near = robot.assemble(
                actuators=values, orientation=self.orientation, near=pose, closure_tolerance=self.closure_tolerance
            )
        except KinetostaticsError:
            return ()
        after = near.platform_coordinates(self.orientation)
        rates = {name: (after[name] - present[name]) / step / (self.size / 2 if name in "xyz" else 1.0) for name in present}
        if not actuators or not all(np.all(np.isfinite(rate)) for rate in rates.values()):
            return ()

        def independence(names: tuple[str, ...]) -> float:
            return float(np.linalg.svd(np.array([rates[name] for name in names]), compute_uv=False)[-1])

        sets = list(itertools.combinations(present, robot.mobility.platform))
        best = max((independence(names) for names in sets), default=0.0)
        good = [names for names in sets if independence(names) > 0.3 * best]
        return min(good, key=lambda names: sum(name in "xyz" for name in names), default=())  # angles are easier to grasp

    def _actuator(self, name: str) -> dict[str, Json]:
        connection = self.robot.mechanism.connections[name]
        slides = connection.type.is_slide
        value = float(self.configuration.actuators[name])
        return self._slider("actuators", name, f"actuator: {name}", slides, value, connection.lower, connection.upper)

    def _platform(self, name: str) -> dict[str, Json]:
        value = float(self.configuration.platform_coordinates(self.orientation)[name])
        return self._slider("platform", name, f"platform: {name}", name in "xyz", value, -math.inf, math.inf)

    def _load(self, k: int, name: str, result: Result) -> dict[str, Json]:
        """Return the slider of a component of the load: up to twice the given load, or to the robot's weight."""
        assert self.load is not None
        weight = float(np.nan_to_num(np.linalg.norm(result.base_wrench[:3] + result.load[:3])))
        force = max(2 * float(np.abs(self.load[:3]).max()), weight, 100.0)
        most = force if k < 3 else max(2 * float(np.abs(self.load[3:]).max()), 0.25 * force * self.size)
        step = 10.0 ** math.floor(math.log10(most) - 2)
        most = math.ceil(most / step) * step
        return {
            "kind": "load", "coordinate": name, "name": f"load: {name} [{'N' if k < 3 else 'N·m'}]", "factor": 1.0,
            "value": float(self.load[k]), "min": -most, "max": most, "step": step,
        }  # fmt: skip

    def _slider(
        self, kind: str, coordinate: str, title: str, is_length: bool, value: float, lower: float, upper: float
    ) -> dict[str, Json]:
        factor, unit, reach, step = (1e-3, "mm", REACH * self.size, 0.1) if is_length else (math.pi / 180, "°", TURN, 0.01)
        low, high = max(lower, value - reach), min(upper, value + reach)
        if not low < high:  # beyond its limits to begin with
            low, high = value - reach, value + reach
        return {
            "kind": kind, "coordinate": coordinate, "name": f"{title} [{unit}]", "factor": factor, "value": value / factor,
            "min": math.floor(low / factor + 1e-6), "max": math.ceil(high / factor - 1e-6), "step": step,
        }  # fmt: skip


class LiveServer:
    """Serves a live page on this machine; use it as a context, or :meth:`close` it.

    Attributes:
        url: address of the page.
    """

    def __init__(self, robot: LiveRobot, port: int = 0) -> None:
        """Start to serve in the background.

        Args:
            robot: what answers.
            port: of 127.0.0.1; 0 for any that is free.

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
        """Serve until the program is interrupted or the server closed."""
        self._thread.join()

    def close(self) -> None:
        """Stop serving."""
        self._closed.set()
        self._server.shutdown()
        self._server.server_close()
        self._compiling.join()  # the program would crash if it ended in the middle of that


def _handler(robot: LiveRobot, key: str) -> type[BaseHTTPRequestHandler]:
    lock = threading.Lock()  # one analysis at a time
    page = page_html(robot.first)

    class Handler(BaseHTTPRequestHandler):
        timeout = PATIENCE

        def do_GET(self) -> None:
            if self._is_asked_for(""):
                self._reply(200, page, "text/html")
            elif self.path == "/favicon.ico":
                self._reply(200, "", "image/x-icon")
            else:
                self._reply(404, "nothing here")

        def do_POST(self) -> None:
            length = self.headers.get("Content-Length", "")
            if not self._is_asked_for("analyze"):
                self._reply(404, "nothing here")
            elif not re.fullmatch("[0-9]{1,9}", length) or int(length) > LONGEST:
                self._reply(413, f"a question tells its length, of at most {LONGEST} bytes")
            else:
                self._reply(200, self._answer(self.rfile.read(int(length))), "application/json")

        def _is_asked_for(self, name: str) -> bool:
            """Return whether a page of this server asks for something by its key."""
            host = self.headers.get("Host", "")
            here = host.partition(":")[0] in LOCAL_NAMES and self.headers.get("Origin", f"http://{host}") == f"http://{host}"
            return here and self.path == f"/{key}/{name}"

        def _answer(self, question: bytes) -> str:
            try:
                asked = json.loads(question)
                with lock:
                    answer = robot.answer(asked)
                return json.dumps(answer, allow_nan=False)
            except KinetostaticsError as error:  # the page shows it; it is an answer like any other
                return json.dumps({"error": str(error)})
            except Exception as error:  # whatever was asked gets an answer
                return json.dumps({"error": f"the page asked for something that makes no sense: {error!r}"})

        def _reply(self, status: int, text: str, kind: str = "text/plain") -> None:
            body = text.encode()
            with contextlib.suppress(ConnectionError):  # who asked may have gone
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
    configuration: Configuration,
    analyze: Callable[..., Result],
    *,
    orientation: str | None = None,
    closure_tolerance: float = 1e-10,
    coordinates: Sequence[str] = (),
    load: ArrayLike | None = None,
    port: int = 0,
) -> LiveServer:
    """Serve a page whose sliders move the robot.

    Args:
        configuration: the pose to start from.
        analyze: how a pose is analysed, for example ``lambda pose: ks.analyze(pose, load=[0, 0, -500, 0, 0, 0])``.
        orientation, closure_tolerance: as in :meth:`Robot.assemble`.
        coordinates: platform coordinates that get sliders; none: those that determine the pose best.
        load: (6,) force and moment at o, world axes [N, N·m]: it gets sliders, and ``analyze`` is called with ``load=`` what they
            say, for example ``lambda pose, load: ks.analyze(pose, load=load)``.
        port: of 127.0.0.1; 0 for any that is free.
    """
    return LiveServer(LiveRobot(configuration, analyze, orientation, closure_tolerance, coordinates, load), port)

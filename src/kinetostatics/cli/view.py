"""Command view: the deformed robot in the browser, at one pose or as an animation."""

from __future__ import annotations

import argparse
import contextlib
import functools
from typing import TYPE_CHECKING

from kinetostatics.arguments import Keyword
from kinetostatics.cli.commands import Command
from kinetostatics.cli.inputs import (
    VALUES_HELP,
    assembled,
    coordinate_kind,
    given_of,
    load_robot,
    loads_of,
    option_of,
    parse_items,
    parse_range,
    payload_of,
    pose_of,
    swept_coordinates,
    value_of,
)
from kinetostatics.cli.options import LOADS, POSE, ROBOT, Argument
from kinetostatics.cli.output import print_warnings
from kinetostatics.exceptions import ArgumentError, AssemblyError, CoordinatesError, RobotFileError, StaticsError
from kinetostatics.progress import pausing, waiting

if TYPE_CHECKING:
    from kinetostatics.kinematics.configuration import Configuration
    from kinetostatics.results.dynamics import Modes
    from kinetostatics.results.result import Result
    from kinetostatics.robot import Robot
    from kinetostatics.viewer.single_poses import UnloadedPose

#: Default number of poses of an animation.
POSES = 21
#: Options with those that they exclude.
EXCLUDED = {
    "meshcat": ("sweep", "compare", "by_mechanism", "vary"),
    "screenshot": ("sweep", "by_mechanism", "vary"),
    "compare": ("sweep", "vary"),
    "vary": ("sweep",),
    "modes": ("meshcat", "vary", "sweep", "compare", "by_mechanism", "colour", "load", "point", "frame", "load_on", "gravity"),
}


def _view(args: argparse.Namespace) -> int:
    for option, others in EXCLUDED.items():
        for other in others:
            if _is_given(args, option) and _is_given(args, other):
                raise ArgumentError(f"{option_of(option)} and {option_of(other)} exclude one another")
    if args.screenshot is None and (args.colour or args.view):
        raise ArgumentError("--colour and --from apply to images: give --screenshot FILE.png too")
    return _page(args)


def _is_given(args: argparse.Namespace, name: str) -> bool:
    return getattr(args, name) not in (None, False, [])


def _page(args: argparse.Namespace) -> int:
    with waiting("making the page"):
        from kinetostatics import viewer

        robot = load_robot(args)
        result, warnings = _modes(robot, args) if args.modes is not None else _shown(robot, args, loads_of(args))
        options = {**given_of(("exaggeration",), args), "compare": _compared(robot, args) if args.compare else None}
        page_options = {**options, "by_mechanism": args.by_mechanism, "vary": _varied(args.vary)}
        with pausing():
            print_warnings(warnings)
        if args.screenshot is not None:
            viewer.save_image(result, args.screenshot, **options, **given_of(("colour", "view"), args))
            text = f"wrote {args.screenshot}"
        elif args.html is not None:
            viewer.save_html(result, args.html, **page_options)
            text = f"wrote {args.html}"
        elif args.meshcat is None:
            text = f"the page is in {VIEW.called()(result, **page_options).path}"
    if args.meshcat is not None:
        return _meshcat(result, args.meshcat or None, value_of("exaggeration", args))
    print(text)
    return 0


def _shown(robot: Robot, args: argparse.Namespace, loads: dict[str, Keyword]) -> tuple[Result | UnloadedPose, list[str]]:
    """Return (result, warnings). If pose or analysis fails, return the unloaded pose, with the error as the only warning."""
    from kinetostatics.analysis import analyze
    from kinetostatics.status import Status
    from kinetostatics.viewer.single_poses import UnloadedPose

    shown: Configuration | Robot = robot
    try:
        shown, warnings = (_animation_poses(robot, args), []) if args.sweep else pose_of(robot, args)
        result = analyze(shown, **loads)
    except (AssemblyError, CoordinatesError, StaticsError, RobotFileError) as error:
        if args.compare or args.sweep or args.vary:
            raise
        return UnloadedPose(shown, str(error)), [str(error)]
    if args.sweep and (result.status == Status.SINGULAR).all():
        raise StaticsError("--sweep: the robot is singular at every pose")
    return result, [*warnings, *result.warnings]


def _varied(items: list[str]) -> dict[str, str | None] | None:
    """Return the varied parameters with their values, None for values that are not given; None without parameters."""
    values = parse_items("--vary", [text if "=" in text else f"{text}=:" for text in items])
    return {name: None if text == ":" else text for name, text in values.items()} or None


def _modes(robot: Robot, args: argparse.Namespace) -> tuple[Modes, list[str]]:
    from kinetostatics.dynamics.vibrations import modes

    pose, warnings = pose_of(robot, args)
    return modes(pose, value_of("modes", args), **payload_of(args)), warnings


def _compared(robot: Robot, args: argparse.Namespace) -> Result:
    """Return the result of ``--compare``; coordinates that it does not give are those of the first result."""
    from kinetostatics.analysis import analyze

    names = [word for word in args.compare if "=" not in word]
    coordinates = [word for word in args.compare if "=" in word]
    if len(names) > 1:
        raise ArgumentError(
            f"--compare names {len(names)} robots, {' and '.join(names)}; it takes one, and coordinates NAME=VALUE"
        )
    other = argparse.Namespace(**vars(args))
    if names:
        other.robot, other.parameters, other.near, other.platform_link, other.base_link = names[0], [], [], None, None
        robot = load_robot(other)
    if coordinates:
        other.platform, other.actuators = coordinates, []
    pose, _ = pose_of(robot, other)
    return analyze(pose, **loads_of(other))


def _meshcat(result: Result | UnloadedPose | Modes, url: str | None, exaggeration: float | None) -> int:
    """Draw into the scene of the meshcat-server at ``url``; if None, start a server, which runs until Ctrl+C."""
    with contextlib.ExitStack() as stack:
        with waiting("drawing into meshcat"):
            from kinetostatics.viewer import open_browser, show
            from kinetostatics.viewer.running_meshcat import connected

            visualizer = stack.enter_context(connected(url))
            drawn: Keyword = show(result, visualizer=visualizer, exaggeration=exaggeration)
        with contextlib.suppress(KeyboardInterrupt):
            print(f"drawn at {drawn.path.lower()} of {visualizer.url()}" + ("" if url else " (Ctrl+C ends it)"), flush=True)
            if url is None:
                open_browser(visualizer.url())
                visualizer.window.server_proc.wait()
    return 0


def _animation_poses(robot: Robot, args: argparse.Namespace) -> Configuration:
    """Return the poses of the animation of ``--sweep``."""
    import numpy as np

    option, swept, constant = swept_coordinates(robot, args)
    kind = functools.partial(coordinate_kind, robot, option)
    ranges = {name: parse_range("--sweep", name, text, kind(name)) for name, text in swept.items()}
    counts = {count for _, _, count in ranges.values() if count is not None}
    if len(counts) > 1:
        raise ArgumentError(f"--sweep: the coordinates move together, but have {', '.join(map(str, sorted(counts)))} poses")
    count = counts.pop() if counts else POSES
    values: dict[str, object] = {name: np.linspace(first, last, count) for name, (first, last, _) in ranges.items()}
    for name, value in constant.items():
        if name in values:
            raise ArgumentError(f"--sweep: {name} is given by {option} too")
        values[name] = value
    if option == "--actuators":
        values = {**dict.fromkeys(robot.description.actuated, 0.0), **values}
    return assembled(robot, option, values, args)


VIEW = Command(
    _view,
    help="show the deformed robot in the browser",
    description="Show the deformed robot in the browser: bent beams, forces, and contributions of each weight and load.",
    arguments=(*ROBOT, *POSE, *LOADS, "modes"),
    own_arguments={
        "html": Argument("text", "write the page to a file that needs no server and no network", "FILE"),
        "screenshot": Argument("text", "write an image with its legend; needs Chromium or Chrome", "FILE.png"),
        "live": Argument("flag", "open the page in the browser, as without this option"),
        "meshcat": Argument(
            "optional text",
            "draw into the scene of a meshcat-server, below kinetostatics/ROBOT; URL is the zmq_url of a running server "
            "(default: a new server, until Ctrl+C)",
            "URL",
        ),
        "sweep": Argument(
            "items",
            "animation: coordinates of platform or actuators that vary together; the others are those of the pose "
            f"(default: {POSES} poses)",
            "NAME=FROM:TO[:POSES]",
        ),
        "vary": Argument(
            "items",
            "sliders that vary one to three parameters, named as in optimize; without values, from half to one and a half times "
            "the file's value",
            "NAME[=FROM:TO]",
        ),
        "by_mechanism": Argument(
            "flag", "two sliders for the weight of each limb: its effects by attached wrenches and by deformation of the limb"
        ),
        "compare": Argument(
            "texts",
            "second result on the page, as a ghost or beside the first: another robot, other coordinates, or both",
            "ROBOT|NAME=VALUE",
        ),
        "exaggeration": Argument("number", "factor of displacements (default: the largest is about a tenth of the robot)", "E"),
        "colour": Argument(
            "text",
            "quantity shown in colour on --screenshot (default: deflection)",
            choices=("deflection", "stress", "axial", "euler"),
        ),
        "view": Argument(
            "text", "view direction of --screenshot (default: home)", choices=("home", "front", "side", "top"), option="--from"
        ),
    },
    function="viewer:show",
    exclusive=("html", "screenshot", "live", "meshcat"),
    notes=VALUES_HELP,
    examples="""
view 3rps
view 3rps --platform z=500mm rx=2deg ry=-10deg --load 0 0 -500 0 0 0
view 3rps --html sag.html
view 3rps --platform z=500mm --sweep rx=-10deg:10deg:31 ry=0:5deg
view 3rps --modes 6
view 3rps --by-mechanism
view 3rps --vary rod_diameter=40mm:120mm platform_mass
view 3rps --platform z=500mm rx=0 ry=0 --compare z=550mm rx=5deg ry=0
view 3rps --compare 3prs
view 2pru_upr --screenshot stress.png --colour stress --from front
view 3rps --meshcat                                  # starts a meshcat-server
view 3rps --meshcat tcp://127.0.0.1:6000             # draws into one that runs, beside its objects
""",
)

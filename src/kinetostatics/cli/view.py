"""``kinetostatics view``: the deformed robot in the browser, at one pose, along a path, or live."""

from __future__ import annotations

import argparse
import contextlib
import functools
from typing import TYPE_CHECKING

from kinetostatics.argument_checks import Keyword
from kinetostatics.cli import answers, arguments, poses
from kinetostatics.exceptions import ArgumentError
from kinetostatics.printing.waiting import pausing, waiting

if TYPE_CHECKING:
    from kinetostatics.kinematics.configuration import Configuration
    from kinetostatics.results.result import Result
    from kinetostatics.robot import Robot
    from kinetostatics.viewer.live import LiveServer


#: What ``--colour`` and ``--from`` may be; a copy, as the command line starts without the viewer.
COLOURS, VIEWS = ("deflection", "stress", "axial", "euler"), ("home", "front", "side", "top")
#: Poses of a sweep that does not say how many.
POSES = 21

USAGE = None
HELP = "see the deformed robot in the browser"
DESCRIPTION = "Show the deformed robot in the browser: bent beams, forces, and what each weight and load contributes."
EXAMPLES = f"""\
{arguments.VALUES_HELP}
examples:
  kinetostatics view 3rps
  kinetostatics view 3rps --platform z=500mm rx=2deg ry=-10deg --load 0 0 -500 0 0 0
  kinetostatics view 3rps --html sag.html
  kinetostatics view 3rps --platform z=500mm --sweep rx=-10deg:10deg:31 ry=0:5deg
  kinetostatics view 3rps --ways
  kinetostatics view 3rps --platform z=500mm rx=0 ry=0 --compare z=550mm rx=5deg ry=0
  kinetostatics view 3rps --compare 3prs
  kinetostatics view 2pru_upr --screenshot stress.png --colour stress --from front
  kinetostatics view 2pru_upr --live
  kinetostatics view 3rps --meshcat                                  # starts a meshcat-server
  kinetostatics view 3rps --meshcat tcp://127.0.0.1:6000             # draws into one that runs, beside what it shows
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    arguments.add_robot_arguments(parser)
    poses.add_pose_arguments(parser)
    arguments.add_load_arguments(parser)
    group = parser.add_argument_group("view")
    group.add_argument(
        "--sweep",
        metavar="NAME=FROM:TO[:POSES]",
        **arguments.SEVERAL,
        help="an animation: coordinates of platform or actuators that move together, the others being those of the pose "
        f"(default: {POSES} poses)",
    )
    group.add_argument(
        "--ways",
        action="store_true",
        help="two sliders for each limb's weight: what it does by attached wrenches, and by deformation of the limb",
    )
    group.add_argument(
        "--compare",
        metavar="ROBOT|NAME=VALUE",
        **arguments.SEVERAL,
        help="a second result on the page, as a ghost or beside the first: of another robot, at other coordinates, or both",
    )
    either = group.add_mutually_exclusive_group()
    either.add_argument("--html", metavar="FILE", help="write the page to a file, which needs no server and no network")
    either.add_argument("--screenshot", metavar="FILE.png", help="write an image with its legend; needs Chromium or Chrome")
    either.add_argument(
        "--live", action="store_true", help="handles and sliders move platform, actuators and load; ends with Ctrl+C"
    )
    either.add_argument(
        "--meshcat",
        metavar="URL",
        nargs="?",
        const="",
        help="draw into the scene of a meshcat-server, below kinetostatics/ROBOT: of the running one whose zmq_url is given, or "
        "of a new one, until Ctrl+C",
    )
    group.add_argument(
        "--exaggeration", metavar="E", type=float, help="of displacements (default: the largest is about a tenth of the robot)"
    )
    group.add_argument("--colour", choices=COLOURS, help="what the colours of --screenshot tell (default: deflection)")
    group.add_argument("--from", choices=VIEWS, dest="seen_from", help="where --screenshot looks from (default: home)")
    group.add_argument("--port", metavar="P", type=int, default=0, help="of the live page (default: any that is free)")


def run(args: argparse.Namespace) -> int:
    """Show the page, or write it."""
    if args.live and args.exaggeration is not None:
        raise ArgumentError("--live has a slider for it and begins with its own: leave --exaggeration out")
    if args.screenshot is None and (args.colour or args.seen_from):
        raise ArgumentError("--colour and --from are of an image: give --screenshot FILE.png too")
    if args.compare and (args.live or args.sweep or args.meshcat is not None):
        raise ArgumentError("--compare shows two results on a page of their own, without --live, --sweep and --meshcat")
    if args.screenshot is not None and (args.ways or args.sweep):
        raise ArgumentError("--ways and --sweep are of a page, and --screenshot is one image: give one of them")
    if args.ways and args.meshcat is not None:
        raise ArgumentError("--ways makes sliders of a page and --meshcat has none: give one of them")
    if args.sweep and args.meshcat is not None:
        raise ArgumentError("--sweep makes an animation and --meshcat shows one pose: give one of them")
    return _live(args) if args.live else _page(args)


def _page(args: argparse.Namespace) -> int:
    with waiting("making the page"):
        from kinetostatics import viewer
        from kinetostatics.analysis import analyze

        options = arguments.load_options(args)
        robot = arguments.load(args)
        configuration, found = (_swept(robot, args), []) if args.sweep else poses.assemble(robot, args)
        result = analyze(configuration, **options)
        second = _second(robot, args) if args.compare else None
        with pausing():
            answers.print_warnings([*found, *result.warnings])
        if args.html is not None:
            viewer.save_html(result, args.html, exaggeration=args.exaggeration, ways=args.ways, compare=second)
            said = f"wrote {args.html}"
        elif args.screenshot is not None:
            colour, view = args.colour or COLOURS[0], args.seen_from or VIEWS[0]
            viewer.save_image(result, args.screenshot, exaggeration=args.exaggeration, compare=second, colour=colour, view=view)
            said = f"wrote {args.screenshot}"
        elif args.meshcat is None:
            said = f"the page is in {viewer.show(result, exaggeration=args.exaggeration, ways=args.ways, compare=second).path}"
    if args.meshcat is not None:
        return _meshcat(result, args.meshcat or None, args.exaggeration)
    print(said)
    return 0


def _second(robot: Robot, args: argparse.Namespace) -> Result:
    """Return the result that ``--compare`` asks for; where it names no coordinates the pose is that of the first."""
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
        robot = arguments.load(other)
    if coordinates:
        other.platform, other.actuators = coordinates, []
    pose, _ = poses.assemble(robot, other)
    return analyze(pose, **arguments.load_options(other))


def _meshcat(result: Result, url: str | None, exaggeration: float | None) -> int:
    """Draw into the scene of a running meshcat-server, or of a new one that runs until Ctrl+C."""
    with contextlib.ExitStack() as stack:
        with waiting("drawing into meshcat"):
            from kinetostatics.viewer import open_browser, show
            from kinetostatics.viewer.running import connected

            visualizer = stack.enter_context(connected(url))
            drawn = show(result, visualizer=visualizer, exaggeration=exaggeration)
        with contextlib.suppress(KeyboardInterrupt):
            print(f"drawn at {drawn.path.lower()} of {visualizer.url()}" + ("" if url else " (Ctrl+C ends it)"), flush=True)
            if url is None:
                open_browser(visualizer.url())
                visualizer.window.server_proc.wait()
    return 0


def _live(args: argparse.Namespace) -> int:
    if args.sweep:
        raise ArgumentError("--sweep makes an animation and --live moves the robot by hand: give one of them")
    with waiting("making the page"):
        from kinetostatics.viewer import open_browser

        server, found = _server(args)
    with server:
        answers.print_warnings(found)
        try:
            print(f"live at {server.url} (Ctrl+C ends it)", flush=True)
            open_browser(server.url)
            server.wait()
        except KeyboardInterrupt:
            print()
    return 0


def _server(args: argparse.Namespace) -> tuple[LiveServer, list[str]]:
    """Return what answers the live page, and warnings."""
    from kinetostatics.analysis import analyze
    from kinetostatics.viewer.live import serve

    options = arguments.load_options(args)
    configuration, found = poses.assemble(arguments.load(args), args)

    def analyzed(pose: Configuration, **changed: Keyword) -> Result:
        result = analyze(pose, **{**options, **changed})
        return result.by_mechanism if args.ways else result

    at_o = args.point is None and args.frame == "world"  # else the load goes with the platform, and sliders would not
    server = serve(
        configuration,
        analyzed,
        orientation=args.orientation,
        closure_tolerance=poses.closure_tolerance_of(args),
        coordinates=tuple(arguments.parse_items("--platform", args.platform)),
        load=options["load"] if at_o else None,
        port=args.port,
    )
    return server, found


def _swept(robot: Robot, args: argparse.Namespace) -> Configuration:
    """Return the poses of ``--sweep``."""
    import numpy as np

    swept = arguments.parse_items("--sweep", args.sweep)
    actuators = [name for name in swept if name in robot.description.driven]
    if actuators and len(actuators) < len(swept):
        raise ArgumentError("--sweep: coordinates of actuators and of the platform cannot move together")
    option, other = ("--actuators", "--platform") if actuators else ("--platform", "--actuators")
    kind = functools.partial(poses.coordinate_kind, robot, option)
    ranges = {name: arguments.parse_range("--sweep", name, text, kind(name)) for name, text in swept.items()}
    counts = {count for _, _, count in ranges.values() if count is not None}
    if len(counts) > 1:
        raise ArgumentError(f"--sweep: the coordinates move together, but have {', '.join(map(str, sorted(counts)))} poses")
    count = counts.pop() if counts else POSES
    values: dict[str, object] = {name: np.linspace(first, last, count) for name, (first, last, _) in ranges.items()}
    if getattr(args, other[2:]):
        raise ArgumentError(f"--sweep: the coordinates that stand still are given by {option}")
    for name, value in poses.single_values(robot, option, getattr(args, option[2:])).items():
        if name in values:
            raise ArgumentError(f"--sweep: {name} is given by {option} too")
        values[name] = value
    if actuators:
        values.update({name: 0.0 for name in robot.description.driven if name not in values})
    return poses.assembled(robot, option, values, args)

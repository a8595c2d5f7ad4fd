"""Commands about vibration: natural frequencies and frequency response."""

from __future__ import annotations

import argparse

from kinetostatics.arguments import POSE, ROBOT, Argument
from kinetostatics.cli.answers import answer, save_files
from kinetostatics.cli.commands import Command
from kinetostatics.cli.inputs import load_robot, payload_of, pose_of
from kinetostatics.cli.options import FIGURES, check_files, given_of
from kinetostatics.cli.typed_values import VALUES_HELP, parse_range
from kinetostatics.progress import waiting

#: Frequencies of a response, unless their number is given.
MOST = 400

# ---- modes ---------------------------------------------------------------------------------------------------------------


def _modes(args: argparse.Namespace) -> int:
    """Print frequencies, effective masses and shares of energy."""
    with waiting("computing modes"):
        options = {**payload_of(args), **given_of(("count", "drives"), args)}
        configuration, warnings = pose_of(load_robot(args), args)
        report = MODES.called()(configuration, **options).report()
        answered = report.to_dict() if args.json else report
    answer(answered, warnings)
    return 0


MODES = Command(
    _modes,
    help="compute natural frequencies and modes at one pose",
    description=(
        "Compute the lowest natural frequencies at one pose, with effective masses by direction and the shares of energy\n"
        "of every part. Beams vibrate as continuous rods: nothing is discretized, and no mode is missed."
    ),
    arguments=(*ROBOT, *POSE, "payload", "payload_center", "payload_link", "drives", "json"),
    own={"count": Argument("count", "number of modes (default: 6)", "N")},
    function="dynamics.vibrations:modes",
    notes=VALUES_HELP,
    examples="""
modes 3rps
modes 2pru_upr --platform z=600mm rx=-5deg ry=-6deg --orientation XYZ --count 10
modes delta --payload 2kg --payload-center 0 0 -50mm
modes ur10 --drives free --json
""",
)


# ---- response ------------------------------------------------------------------------------------------------------------


def _response(args: argparse.Namespace) -> int:
    """Print the largest responses, and write figures and tables."""
    with waiting("computing the frequency response"):
        import numpy as np

        check_files(args.out, ("csv", *FIGURES))
        first, last, count = parse_range("--frequencies", "frequencies", args.frequencies)
        options = {**payload_of(args), **given_of(("damping", "drives", "tool"), args)}
        configuration, warnings = pose_of(load_robot(args), args)
        found = RESPONSE.called()(configuration, np.geomspace(first, last, count or MOST), **options)
        drawn = given_of(("what", "components"), args)
        for path in args.out:
            save_files([path], "frequency_response", found, **drawn)
        shown = found.to_dict() if args.json else found.report()
    answer(shown, warnings, args.out)
    return 0


RESPONSE = Command(
    _response,
    help="compute the frequency response of the platform: compliance, and transmissibility from the floor",
    description=(
        "Compute the response of the platform to harmonic forces on it, and to harmonic motion of the floor, at one pose.\n"
        "The dynamic stiffness is solved at each frequency: no modes are left out."
    ),
    arguments=(*ROBOT, *POSE, "payload", "payload_center", "payload_link", "tool", "drives", "json"),
    own={
        "frequencies": Argument("text", f"frequencies [Hz], logarithmically spaced (COUNT: {MOST})", "FIRST:LAST[:COUNT]"),
        "damping": Argument("number", "damping ratio of all modes (default: 0.02)", "ZETA"),
        "what": Argument("text", "what a figure shows (default: compliance)", choices=("compliance", "transmissibility")),
        "components": Argument("texts", "directions in a figure (default: x y z)", "NAME"),
        "out": Argument("texts", "write a figure (.svg, .pdf, .png) or a table (.csv)", "FILE"),
    },
    function="dynamics.vibrations:frequency_response",
    required=("robot", "frequencies"),
    usage="ROBOT --frequencies FIRST:LAST[:COUNT] [options]",
    notes=VALUES_HELP,
    examples="""
response 3rps --frequencies 1:500 --out compliance.svg response.csv
response 3rps --frequencies 1:500:1000 --damping 0.01 --tool 0 0 200mm --what transmissibility --out floor.svg
response delta --frequencies 10:300 --payload 2kg --components rx ry rz --json
""",
)

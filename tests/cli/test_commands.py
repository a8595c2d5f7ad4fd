"""Every command against the function that it calls: names of options and arguments, defaults, help and examples."""

import inspect
import re
import shlex

import pytest

import kinetostatics as ks
from kinetostatics.cli.commands import COMMANDS, command
from kinetostatics.cli.inputs import option_of, parse_quantity
from kinetostatics.cli.main import make_parser
from kinetostatics.cli.options import ARGUMENTS, LOADS, ROBOT

#: Arguments of functions that the command line has no option for: what it does itself, and what only programs need.
PYTHON_ONLY = set(
    (
        "configuration on_failure engine assembly_errors robot analysis chunks progress parameter_units command_line path "
        "over workspace loads motion values result pose visualizer node title actuators"
    ).split()
)
#: Options that are no arguments of the function: they choose, write or show.
COMMAND_ONLY = set(
    (
        "full only json out near robot load_on payload_center payload_link top what components table hinge_axis quiet list "
        "copy pareto points plan load_case read readings sweep modes html screenshot live meshcat colour view source "
        "elastic joint_stiffness yaml types axes jacobian with_respect_to scalar name picture plane fmu fmi ros2"
    ).split()
)
#: Options whose argument has another name.
OTHER_NAMES = {"inputs": "platform", "section": "sections", "source": "path", "mass": "payload"}
#: Arguments of the robot, of its pose, and of what the command analyses itself.
BUILT = {*ROBOT, *LOADS, "platform", "actuators", "orientation", "closure_tolerance", "tool"}

COMPARED = [name for name in COMMANDS if command(name).function]


def arguments_of(name):
    found = inspect.signature(command(name).called()).parameters
    names = set(found)
    if any(item.kind is inspect.Parameter.VAR_KEYWORD for item in found.values()):
        names |= set(LOADS)
    if name == "analyze":  # the options of a path are arguments of another function
        names |= set(inspect.signature(ks.trajectory).parameters)
    if name == "modes":  # those of a state-space model are arguments of a method
        names |= set(inspect.signature(ks.results.Modes.state_space).parameters)
    return names, found


@pytest.mark.parametrize("name", COMPARED)
def test_options_are_the_arguments_of_the_function(name):
    accepted, parameters = arguments_of(name)
    options = set(command(name).options)
    assert {OTHER_NAMES.get(option, option) for option in options - COMMAND_ONLY} - accepted - BUILT == set()
    assert set(parameters) - PYTHON_ONLY - options - {OTHER_NAMES.get(option, option) for option in options} == set()


@pytest.mark.parametrize("name", COMPARED)
def test_defaults_in_the_help_are_those_of_the_function(name):
    """The command passes on only what is given, so that defaults are the function's."""
    _, parameters = arguments_of(name)
    for option, argument in command(name).options.items():
        told = re.search(r"\(default: ([\w.+-]+)\)", argument.help)
        default = getattr(parameters.get(OTHER_NAMES.get(option, option)), "default", None)
        if told and isinstance(default, (str, int, float)) and not isinstance(default, bool):
            assert told[1] == str(default) or parse_quantity(told[1]) == pytest.approx(default), option


def test_there_are_few_commands_and_each_has_examples():
    assert len(COMMANDS) <= 20
    for name in COMMANDS:
        lines = command(name).examples.strip().splitlines()
        assert len(lines) >= 2 and all(line.split()[0] in COMMANDS for line in lines)
        assert any(line.startswith(f"{name} ") or line == name for line in lines)


@pytest.mark.parametrize("name", COMMANDS)
def test_examples_are_parsed(name):
    parser = make_parser(COMMANDS)
    for line in command(name).examples.strip().splitlines():
        guarded = [f" {word}" if re.match(r"-\.?\d", word) else word for word in shlex.split(line, comments=True)]
        args = parser.parse_args(guarded)
        assert args.run


def test_options_of_one_name_are_the_same_argument():
    assert {option_of(name, argument) for name, argument in ARGUMENTS.items()} >= {
        "--set",
        "--platform-link",
        "--closure-tolerance",
    }
    for name in COMMANDS:
        for option, argument in command(name).options.items():
            if option in ARGUMENTS and option not in ("parameters", "outputs"):
                assert argument is ARGUMENTS[option] or name in ("new", "condense"), (name, option)

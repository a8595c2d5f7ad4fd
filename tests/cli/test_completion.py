"""Completion in shells: the program's answers to argcomplete."""

import os
import subprocess
import sys

import argcomplete
import pytest
from places import ROBOTS

from kinetostatics.cli import main
from kinetostatics.files.bundled import shipped_robots


@pytest.fixture(scope="module")
def finder():
    from kinetostatics.cli import completion

    parser = main.make_parser(main.COMMANDS)
    completion.attach(parser)
    return argcomplete.CompletionFinder(parser)


@pytest.fixture
def complete(finder, monkeypatch):
    """Return a function that gives the completions of the last word of a line."""
    monkeypatch.chdir(ROBOTS)

    def answer(line):
        found = []
        while (match := finder.rl_complete(line, len(found))) is not None:
            found.append(match.rstrip())
        return [match.rpartition(" ")[2] for match in found]

    return answer


@pytest.mark.parametrize(
    ("line", "answers"),
    [
        ("analyze 3rps --ori", "--orientation"),
        ("check spher", "spherical_3rrr spherical_3rrr.urdf.xacro"),
        ("check ../tests/cases/four", ""),
        ("check ../tests/cases/do", "../tests/cases/dog.urdf"),
        ("robots --copy tri", "tricept tripteron"),
        # coordinates that the pose can have
        ("analyze 3rps --platform ", "x= y= z= rx= ry= rz="),
        ("sweep 3rps --orientation tilt_torsion --platform z=0.5 t", "tilt= torsion="),
        ("analyze 2pru_upr --actuators ", "prismatic_1= prismatic_2= prismatic_3="),
        ("view 3rps --sweep pris", "prismatic_1= prismatic_2= prismatic_3="),
        # names in the file
        ("check 3rps --set rod_d", "rod_diameter="),
        ("analyze 3rps --hinge-axis ", "limb_1=x limb_2=x limb_3=x"),
        ("new --from ../tests/cases/parallelogram_plain.urdf --platform-link pl", "plate"),
        ("new --from ../tests/cases/parallelogram_plain.urdf --base-link gr", "ground"),
        ("calibrate 3rps mine.csv --unknowns rod_", "rod_1 rod_2 rod_3 rod_length_min rod_length_max rod_diameter"),
        ("calibrate 3rps mine.csv --unknowns payload.m", "payload.mass"),
        # files that are wrong
        ("analyze nowhere.urdf --actuators ", ""),
        ("analyze ../README.md --actuators ", ""),
        ("analyze 3rpss --actuators ", ""),
    ],
)
def test_last_word_of_a_line_is_completed(complete, line, answers):
    assert complete(line) == answers.split()


def test_commands_robots_and_orientations_are_completed(complete):
    assert [name for name in complete("") if not name.startswith("-")] == list(main.COMMANDS)
    assert set(shipped_robots()) <= set(complete("view ")) and "tilt_torsion" in complete("analyze 3rps --orientation ")


def test_program_answers_shells_on_file_descriptor_8():
    """Argcomplete's functions of shells read the answer there."""
    line = "kinetostatics tol"
    environment = {**os.environ, "_ARGCOMPLETE": "1", "COMP_LINE": line, "COMP_POINT": str(len(line))}
    read, write = os.pipe()

    def prepare():
        os.dup2(write, 8)
        os.dup2(write, 9)

    with os.fdopen(read, "rb") as answer:
        done = subprocess.run(
            [sys.executable, "-m", "kinetostatics"], env=environment, preexec_fn=prepare, close_fds=False, check=False, timeout=60
        )
        os.close(write)
        assert done.returncode == 0 and answer.read().startswith(b"tolerances")


def test_completion_without_argcomplete_prints_nothing(monkeypatch, capsys):
    monkeypatch.setenv("_ARGCOMPLETE", "1")
    monkeypatch.setitem(sys.modules, "argcomplete", None)
    assert main.main(["check", "3rps"]) == 1
    assert capsys.readouterr() == ("", "")

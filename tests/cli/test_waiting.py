"""Progress messages: on a terminal they appear within two seconds and are removed in the end; elsewhere there are none."""

from __future__ import annotations

import importlib
import os
import pty
import sys
import time
import warnings
from contextlib import contextmanager, redirect_stderr

import pytest
from finite_elements import element
from netgen import occ
from scipy.io import savemat

import kinetostatics as ks
import kinetostatics.progress
from kinetostatics.cli.main import COMMANDS, main
from kinetostatics.progress import pausing, waiting

#: For every command that computes: its arguments, a function to be slowed down, and the message.
SLOW = {
    "check": (["five_bar"], "kinetostatics.robot.load_robot", "checking"),
    "analyze": (["five_bar"], "kinetostatics.analysis.analyze", "analyzing"),
    "compensate": (["five_bar"], "kinetostatics.compensation.compensate", "compensating"),
    "optimize": (["five_bar", "--vary", "tool_mass=1,2"], "kinetostatics.design.optimize", "optimizing"),
    "calibrate": (
        ["five_bar", "--plan", "1", "--unknowns", "payload.mass"],
        "kinetostatics.calibration.plan_measurements",
        "calibrating",
    ),
    "sensitivities": (["five_bar", "--by", "tool_mass"], "kinetostatics.design.sensitivities", "changing parameters one by one"),
    "sweep": (
        ["five_bar", "--platform", "x=0,0.01", "y=0.3", "--out", "new.nc"],
        "kinetostatics.workspace.run.read_plan",
        "planning the sweep",
    ),
    "view": (["five_bar", "--html", "page.html"], "kinetostatics.viewer._page", "making the page"),
    "capacity": (["five_bar", "--mass"], "kinetostatics.capacity.capacity", "computing the capacity"),
    "modes": (["five_bar"], "kinetostatics.dynamics.vibrations.modes", "computing modes"),
    "response": (
        ["five_bar", "--frequencies", "1:9:3"],
        "kinetostatics.dynamics.vibrations.frequency_response",
        "computing the frequency response",
    ),
    "verify": (["five_bar"], "kinetostatics.verification.verify", "verifying"),
    "report": (["five_bar", "--out", "report.html"], "kinetostatics.report_page.save_report", "writing the report"),
    "tolerances": (["five_bar"], "kinetostatics.design.tolerances", "computing effects of tolerances"),
    "export": (["five_bar", "--out", "controller"], "kinetostatics.functions.function.export_c", "recording the robot"),
    "plot": (["map.nc", "--out", "figure.svg", "--kind", "line"], "kinetostatics.plot.save", "drawing"),
    "import-link": (
        ["arm.mat", "--interface", "a=1", "b=2", "--out", "arm.npz"],
        "kinetostatics.files.finite_elements.import_link",
        "importing the link",
    ),
    "condense": (
        [
            "bar.step",
            "--interface",
            "a=face near 15mm 15mm 0",
            "b=face near 15mm 15mm 1",
            "--within",
            "0.9",
            "--modes",
            "0",
            "--out",
            "it.npz",
        ],
        "kinetostatics.condensation.condense",
        "condensing the part",
    ),
    "new": (["3-RPS", "--out", "new.urdf.xacro"], "kinetostatics.authoring.by_name.new_robot", "building the robot"),
}


@contextmanager
def terminal():
    """Make standard error a terminal; yields a function that returns all that has been written to it."""
    ours, theirs = pty.openpty()
    os.set_blocking(ours, False)

    def read() -> str:
        sys.stderr.flush()
        found = b""
        while True:
            try:
                found += os.read(ours, 1 << 16)
            except BlockingIOError:
                return found.decode()

    with open(theirs, "w", encoding="utf-8", buffering=1) as stream, redirect_stderr(stream):
        yield read
    os.close(ours)


def screen(text: str) -> list[str]:
    """Return the lines that stay on a terminal."""
    lines = []
    for part in text.split("\n"):
        line = ""
        for piece in part.split("\r"):
            line = piece + line[len(piece) :]
        lines.append(line.rstrip())
    return lines


def make_slow(monkeypatch, name, seconds):
    """Delay every call of a function."""
    module, _, attribute = name.rpartition(".")
    function = getattr(importlib.import_module(module), attribute)

    def slow(*args, **options):
        time.sleep(seconds)
        return function(*args, **options)

    monkeypatch.setattr(sys.modules[module], attribute, slow)


@pytest.fixture
def place(request, tmp_path, monkeypatch):
    """Work in an empty folder; for ``plot`` it has a map, for commands on links a file."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("KINETOSTATICS_CACHE", str(tmp_path))
    if "import-link" in request.node.name:
        savemat("arm.mat", {"P": [[0, 0, 0], [1, 0, 0]], "K": element(1, 1, 1, 1, 1, 1, 1)})
    if "condense" in request.node.name:
        occ.Box(occ.Pnt(0, 0, 0), occ.Pnt(30, 30, 60)).WriteStep("bar.step")
    if "plot" in request.node.name:
        ks.sweep("five_bar", {"x": [0.0, 0.01], "y": 0.3}, out="map.nc").close()


def test_table_of_slow_commands_is_complete():
    assert set(SLOW) == set(COMMANDS) - {"robots"}


@pytest.mark.few(3)
@pytest.mark.parametrize("command", SLOW)
def test_commands_report_progress_within_two_seconds(command, place, monkeypatch):
    """All times are a tenth of the real ones."""
    arguments, name, words = SLOW[command]
    assert kinetostatics.progress.EVERY <= 1
    monkeypatch.setattr("kinetostatics.progress.EVERY", 0.1)
    make_slow(monkeypatch, name, 0.2)
    with terminal() as read:
        assert main([command, *arguments]) == 0
        text = read()
    assert f"{words} … 0 s" in text
    left = screen(text)
    assert left[-1] == "" and all(line.startswith("kinetostatics: warning:") for line in left[:-1]), left


def test_no_progress_is_printed_without_a_terminal(monkeypatch, capsys):
    monkeypatch.setattr("kinetostatics.progress.EVERY", 0.02)
    with waiting("thinking"):
        time.sleep(0.1)
    assert capsys.readouterr() == ("", "")


def test_sweep_reports_the_number_of_poses_done(place, monkeypatch, capsys):
    monkeypatch.setattr("kinetostatics.progress.EVERY", 0.05)
    make_slow(monkeypatch, "kinetostatics.workspace.block.compute_block", 0.15)
    grid, said = {"x": [0.0, 0.01], "y": 0.3}, "sweeping, 0 of 2 poses done … 0 s"
    with terminal() as read:
        ks.sweep("five_bar", grid)
        text = read()
        assert said in text and screen(text) == [""]
        assert main(["sweep", "five_bar", "--platform", "x=0,0.01", "y=0.3", "--out", "quiet.nc", "--quiet"]) == 0
        assert read() == ""
    monkeypatch.setattr("kinetostatics.workspace.run.in_notebook", lambda: True)
    ks.sweep("five_bar", grid)
    assert said in capsys.readouterr().err


def test_warnings_and_questions_have_lines_of_their_own(monkeypatch):
    monkeypatch.setattr("kinetostatics.progress.EVERY", 0.05)
    with terminal() as read, warnings.catch_warnings():
        warnings.simplefilter("always")
        warnings.showwarning = lambda message, *_more: print(f"warning: {message}", file=sys.stderr)
        with waiting("thinking"):
            time.sleep(0.15)
            warnings.warn("odd", stacklevel=1)
            time.sleep(0.15)
            with pausing():
                print("which one?", file=sys.stderr)
                time.sleep(0.15)
            time.sleep(0.15)
        text = read()
    first, second, third = text.split("\n")
    assert all("thinking … " in part for part in (first, second, third)), text
    assert screen(text) == ["warning: odd", "which one?", ""]


def test_progress_line_is_removed_after_an_error(monkeypatch):
    monkeypatch.setattr("kinetostatics.progress.EVERY", 0.05)
    with terminal() as read:
        with pytest.raises(ZeroDivisionError), waiting("dividing"):
            time.sleep(0.15)
            raise ZeroDivisionError
        text = read()
    assert "dividing … 0 s" in text and screen(text) == [""]

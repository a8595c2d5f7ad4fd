"""A process that takes robot files all the way to a result, so that a hang, a crash or a flood of memory is only its own.

:class:`Worker` starts it, hands it one file after another and says what came out; the process itself is this file run as a
script: a line of JSON in, a line of JSON out.
"""

import json
import os
import resource
import selectors
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from dataclasses import dataclass, replace

from places import ROOT

#: Address space [bytes] that a robot file may make us use.
MEMORY = 3 * 2**30


@dataclass(frozen=True)
class Outcome:
    """What became of a file.

    Attributes:
        kind: "result"; "error", one of ours; or what must not be: "failure" (any other exception, a warning of numpy, numbers
            that are not finite without a status that says so, output out of place), "crash" or "hang".
        text: the message, or the traceback.
        seconds: how long it took.
        stage: how far it got.
        touched: files and folders opened outside the folder of the file, programs started and the like.
    """

    kind: str
    text: str
    seconds: float
    stage: str = ""
    touched: tuple[str, ...] = ()


class Worker:
    """Runs the pipeline in a process of its own, which is replaced when it dies."""

    def __init__(self, seconds: float = 20.0) -> None:
        self.seconds = seconds
        self.process: subprocess.Popen[str] | None = None

    def run(self, path: str | os.PathLike[str], parameters: dict | None = None, how: str = "result") -> Outcome:
        """Take a file to a result; ``how`` = "read" stops once it is read."""
        if self.process is None:
            self.process = subprocess.Popen(
                [sys.executable, __file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, encoding="utf-8"
            )
            if self._line(120.0) != "ready\n":
                raise RuntimeError("the process does not start")
        request = json.dumps([os.fspath(path), parameters, how])
        start = time.monotonic()
        try:
            self.process.stdin.write(request + "\n")
            self.process.stdin.flush()
            line = self._line(self.seconds)
        except BrokenPipeError:
            line = ""
        seconds = time.monotonic() - start
        if line:
            answer = json.loads(line)
            return Outcome(answer["kind"], answer["text"], seconds, answer["stage"], tuple(answer["touched"]))
        code = self.process.poll()
        if line is None:
            self.close()
            return Outcome("hang", f"no answer within {self.seconds} s", seconds)
        code = self.process.wait()
        self.process = None
        return Outcome("crash", f"the process ended with code {code}", seconds)

    def _line(self, seconds: float) -> str | None:
        with selectors.DefaultSelector() as selector:
            selector.register(self.process.stdout, selectors.EVENT_READ)
            return self.process.stdout.readline() if selector.select(seconds) else None

    def close(self) -> None:
        """End the process."""
        if self.process is not None:
            self.process.kill()
            self.process.wait()
            self.process = None


# ---- the process -----------------------------------------------------------------------------------------------------------


def _finite(what: str, values) -> None:
    import numpy as np

    if not np.all(np.isfinite(np.asarray(values, dtype=float))):
        raise FloatingPointError(f"{what} is not finite although the status is OK")


def _pipeline(path: str, parameters: dict | None, how: str) -> None:
    import kinetostatics as ks
    from kinetostatics.checks.collect import robot_facts
    from kinetostatics.files.reader import parse_robot_text, read_robot_file
    from kinetostatics.reports.robot import facts_report

    global stage
    stage = "read"
    description = read_robot_file(path, parameters)
    for warning in description.warnings:
        _check_message(warning)
    stage = "write"
    again = parse_robot_text(description.urdf, path)
    if again != description or again.urdf != description.urdf or ks.files.validate(replace(description)) != description:
        raise ValueError("what is written does not read as the same robot")
    if how == "read":
        return
    stage = "build"
    robot = ks.Robot(description)
    stage = "report"
    facts = robot_facts(robot)
    facts_report(facts)
    for warning in (*facts.problems, *facts.warnings):
        _check_message(warning)
    stage = "assemble"
    configuration = robot.assemble()
    stage = "analyze"
    result = ks.analyze(configuration, load=[1, 2, -3, 0.1, 0.2, 0.3])
    status = int(result.status)
    stage = "result"
    str(result)
    result.to_dict()
    if status in (ks.Status.OK, ks.Status.LIMIT_EXCEEDED):
        _finite("the twist", result.twist)
        for name, value in result.actuator_forces.items():
            _finite(f"the force of {name}", value)
        for name, value in result.joint_wrenches.items():
            _finite(f"the wrench of {name}", value)
        for name, beam in result.beams.items():
            for attribute in ("mass", "length", "section_wrenches", "deflections", "stress", "strain_energy"):
                _finite(f"{attribute} of {name}", getattr(beam, attribute))
        for name, value in configuration.platform.items():
            _finite(f"platform {name}", value)


def _check_message(message: str) -> None:
    if not message.strip() or "\n" in message.strip() or "Traceback" in message or len(message) > 3000:
        raise ValueError(f"not one clear message ({len(message)} characters): {message[:500]!r}")


def _answer(path: str, parameters: dict | None, how: str) -> dict[str, str]:
    from kinetostatics.exceptions import KinetostaticsError

    try:
        _pipeline(path, parameters, how)
    except KinetostaticsError as error:
        try:
            _check_message(str(error))
        except ValueError as wrong:
            return {"kind": "failure", "text": str(wrong), "stage": stage}
        return {"kind": "error", "text": str(error), "stage": stage}
    except BaseException:
        text = traceback.format_exc()
        return {"kind": "failure", "text": text if len(text) < 6000 else text[:3000] + " … " + text[-3000:], "stage": stage}
    return {"kind": "result", "text": "", "stage": stage}


def _watch(event: str, arguments: tuple) -> None:
    """Note what a robot file must not do."""
    if event in ("open", "os.listdir", "os.scandir", "glob.glob"):
        name = arguments[0]
        if folder is None or not isinstance(name, (str, bytes, os.PathLike)):
            return
        path = os.path.abspath(os.fsdecode(name))
        if not path.startswith((folder, sys.prefix, sys.base_prefix, str(ROOT), os.devnull)):
            touched.append(path)
    elif event.startswith(("subprocess.", "os.system", "os.exec", "os.spawn", "os.fork", "os.remove", "os.rename", "socket.")):
        if folder is not None:
            touched.append(event)


def _serve() -> None:
    global folder
    sys.addaudithook(_watch)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    with tempfile.TemporaryFile() as printed:
        import kinetostatics as ks

        shipped = ROOT / "robots" / "3rps.urdf.xacro"
        ks.analyze(ks.load_robot(shipped).assemble())  # everything is imported
        os.dup2(printed.fileno(), 1)
        os.dup2(printed.fileno(), 2)
        warnings.simplefilter("error")
        print("ready", file=answers, flush=True)
        for line in sys.stdin:
            start = os.lseek(printed.fileno(), 0, os.SEEK_END)
            request = json.loads(line)
            touched.clear()
            folder = os.path.dirname(os.path.abspath(request[0]))
            answer = _answer(*request)
            folder = None
            sys.stdout.flush()
            sys.stderr.flush()
            end = os.lseek(printed.fileno(), 0, os.SEEK_END)
            if end > start:
                text = os.pread(printed.fileno(), min(end - start, 2000), start).decode(errors="replace")
                answer = {"kind": "failure", "text": f"printed: {text}\nand then: {answer}", "stage": stage}
            answer["touched"] = touched
            print(json.dumps(answer), file=answers, flush=True)


stage = ""
#: Folder of the file that is being read, None between files.
folder: str | None = None
touched: list[str] = []

if __name__ == "__main__":
    _serve()

"""Other processes that work on a sweep.

They are started as ``python -m kinetostatics.workspace.worker`` and talk through their standard input and output, so that neither
the operating system's way to start processes nor the caller's main module plays a part: scripts need no ``if __name__ ==
"__main__"``, notebooks and other threads are no obstacle. A worker that dies is replaced, and its piece of work is done again.
"""

from __future__ import annotations

import os
import pickle
import queue
import struct
import subprocess
import sys
import threading
from collections.abc import Iterable, Iterator
from typing import IO, Any

from kinetostatics import exceptions
from kinetostatics.exceptions import KinetostaticsError
from kinetostatics.workspace.plan import Plan
from kinetostatics.workspace.schema import Labels
from kinetostatics.workspace.tasks import Task

#: How often the same piece of work may take its worker with it.
ATTEMPTS = 3
#: One thread each: the processes share the cores among themselves.
SINGLE = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_HEAD = struct.Struct("<Q")


def send(stream: IO[bytes], value: Any) -> None:
    """Write a value to a pipe."""
    data = pickle.dumps(value, protocol=pickle.HIGHEST_PROTOCOL)
    stream.write(_HEAD.pack(len(data)))
    stream.write(data)
    stream.flush()


def receive(stream: IO[bytes]) -> Any:
    """Read a value from a pipe.

    Raises:
        EOFError: the other side is gone.
    """
    head = stream.read(_HEAD.size)
    if len(head) < _HEAD.size:
        raise EOFError
    (size,) = _HEAD.unpack(head)
    data = stream.read(size)
    if len(data) < size:
        raise EOFError
    return pickle.loads(data)


class Crew:
    """Processes that do pieces of work of one sweep; a context manager, which ends them."""

    def __init__(self, plan: Plan, labels: Labels, workers: int) -> None:
        self._start = pickle.dumps((plan, labels), protocol=pickle.HIGHEST_PROTOCOL)
        self._orders: queue.SimpleQueue[tuple[int, Task, int] | None] = queue.SimpleQueue()
        self._replies: queue.SimpleQueue[tuple[int, str, Any]] = queue.SimpleQueue()
        self._processes: dict[int, subprocess.Popen[bytes]] = {}
        self._ended = False
        self._threads = [threading.Thread(target=self._serve, args=(k,), daemon=True) for k in range(workers)]
        for item in self._threads:
            item.start()

    def __enter__(self) -> Crew:
        return self

    def __exit__(self, *_: object) -> None:
        self._ended = True
        for _thread in self._threads:
            self._orders.put(None)
        for process in list(self._processes.values()):
            process.kill()
        for thread in self._threads:
            thread.join(timeout=5)

    @property
    def pids(self) -> list[int]:
        """Process numbers of the workers."""
        return [process.pid for process in self._processes.values()]

    def perform(self, tasks: Iterable[Task]) -> Iterator[tuple[int, Any]]:
        """Yield the number and the outcome of each piece of work, in the order in which they come.

        Raises:
            KinetostaticsError: what a worker raised; or that a piece of work has ended its worker again and again.
        """
        waiting = iter(enumerate(tasks))
        out = 0
        for _ in range(2 * len(self._threads)):  # one in work and one at hand for each
            out += self._give(waiting)
        while out:
            number, outcome, value = self._replies.get()
            out -= 1
            if outcome != "done":
                raise value
            out += self._give(waiting)
            yield number, value

    def _give(self, waiting: Iterator[tuple[int, Task]]) -> int:
        for number, task in waiting:
            self._orders.put((number, task, 1))
            return 1
        return 0

    def _serve(self, which: int) -> None:
        """Hand orders to one process and its replies back, and replace it when it dies."""
        process: subprocess.Popen[bytes] | None = None
        while (order := self._orders.get()) is not None and not self._ended:
            number, task, attempt = order
            try:
                if process is None:
                    process = self._processes[which] = self._launch()
                assert process.stdin is not None and process.stdout is not None
                send(process.stdin, task)
                outcome, value = receive(process.stdout)
            except (EOFError, OSError, pickle.UnpicklingError) as error:
                if self._ended:
                    break
                if process is not None:
                    process.kill()
                    code = process.wait()
                    process = None
                    reason = f"a worker process has ended with code {code}"
                else:
                    reason = f"no worker process can be started: {error}"
                if attempt < ATTEMPTS:
                    self._orders.put((number, task, attempt + 1))
                else:
                    self._replies.put((number, "failed", KinetostaticsError(f"{reason}, {ATTEMPTS} times at the same block")))
                continue
            self._replies.put((number, "done", value) if outcome == "done" else (number, "failed", _error(*value)))
        if process is not None:
            process.kill()
            process.wait()

    def _launch(self) -> subprocess.Popen[bytes]:
        environment = {**os.environ, **dict.fromkeys(SINGLE, "1"), "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        process = subprocess.Popen(
            [sys.executable, "-m", "kinetostatics.workspace.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=environment,
        )
        assert process.stdin is not None
        process.stdin.write(_HEAD.pack(len(self._start)))
        process.stdin.write(self._start)
        process.stdin.flush()
        return process


def _error(kind: str, message: str) -> Exception:
    """Return an error as a worker has described it."""
    found = getattr(exceptions, kind, None)
    if found is exceptions.ArgumentError:
        return exceptions.ArgumentError(message)
    return KinetostaticsError(message if found is not None else f"a worker process failed: {message}")

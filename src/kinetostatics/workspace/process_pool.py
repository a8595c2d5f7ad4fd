"""Other processes that work on a sweep.

They are loky's, which starts them without the caller's main module: scripts need no ``if __name__ == "__main__"``, notebooks are
no obstacle. Where one dies, all are started anew, and their pieces of work are done again.
"""

from __future__ import annotations

import itertools
import os
import signal
import sys
import threading
import time
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from functools import partial
from typing import TYPE_CHECKING, TypeVar

from kinetostatics.exceptions import ArgumentError, KinetostaticsError
from kinetostatics.workspace.schema import Labels
from kinetostatics.workspace.sweep_spec import SweepSpec

if TYPE_CHECKING:
    from loky.process_executor import ProcessPoolExecutor

#: What comes of a piece of work: a partial function, called with what is asked for and the labels, maybe in another process.
T = TypeVar("T")
#: How often one after the other a process may die before any has done its work.
ATTEMPTS = 3
#: One thread each: the processes share the cores among themselves.
SINGLE = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class ProcessPool:
    """Processes that do pieces of work of one sweep; a context manager, which ends them."""

    def __init__(self, spec: SweepSpec, labels: Labels, workers: int) -> None:
        self._spec, self._labels, self._workers = spec, labels, workers
        self._executor = self._start()

    def __enter__(self) -> ProcessPool:
        return self

    def __exit__(self, *_: object) -> None:
        self._executor.shutdown(kill_workers=True)

    def perform(self, tasks: Iterable[partial[T]]) -> Iterator[tuple[int, T]]:
        """Yield the number and the outcome of each piece of work, in the order in which they come.

        Raises:
            KinetostaticsError: what a process raised; or that processes die again and again.
        """
        waiting: Iterator[tuple[int, partial[T]]] = enumerate(tasks)
        at_work: dict[Future[T], tuple[int, partial[T]]] = {}
        losses = 0
        while True:
            # one in work and one at hand for each
            for item in itertools.islice(waiting, 2 * self._workers - len(at_work)):
                at_work[self._submit(item[1])] = item
            if not at_work:
                return
            lost = []
            for future in wait(at_work, return_when=FIRST_COMPLETED).done:
                item = at_work.pop(future)
                try:
                    value = future.result()
                except BrokenExecutor:
                    lost.append(item)
                    continue
                losses = 0
                yield item[0], value
            if lost:
                losses += 1
                if losses == ATTEMPTS:
                    raise KinetostaticsError(f"worker processes have ended {ATTEMPTS} times without having done anything")
                waiting, at_work = itertools.chain(lost, at_work.values(), waiting), {}
                self._executor.shutdown(kill_workers=True)
                self._executor = self._start()

    def _start(self) -> ProcessPoolExecutor:
        from loky.process_executor import ProcessPoolExecutor

        environment = {**dict.fromkeys(SINGLE, "1"), "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        arguments = os.getpid(), self._spec, self._labels
        return ProcessPoolExecutor(self._workers, initializer=_begin, initargs=arguments, env=environment)

    def _submit(self, task: partial[T]) -> Future[T]:
        try:
            return self._executor.submit(_work, task)
        except BrokenExecutor as error:
            failed: Future[T] = Future()
            failed.set_exception(error)
            return failed


# ---- in the other process ----------------------------------------------------------------------------------------------

_spec: SweepSpec
_labels: Labels


def _begin(parent: int, spec: SweepSpec, labels: Labels) -> None:
    """Make a process ready for a sweep."""
    global _spec, _labels
    _spec, _labels = spec, labels
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl+C is the caller's business
    os.dup2(2, 1)  # what the caller prints stays as it is
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: int) -> None:
    """End this process soon after the one that has started it, however that ends."""
    while os.getppid() == parent:
        time.sleep(0.2)
    os._exit(1)


def _work(task: partial[T]) -> T | None:
    """Do a piece of work; what is in a file need not be returned.

    Raises:
        KinetostaticsError: what went wrong; errors of the robot's file with their place in the message.
    """
    try:
        found = task(_spec, _labels)
    except KinetostaticsError as error:
        raise (ArgumentError if isinstance(error, ArgumentError) else KinetostaticsError)(str(error)) from None
    except OSError as error:
        raise KinetostaticsError(f"{error.filename or 'a file'}: {error.strerror or error}") from None
    return None if task.keywords.get("path") is not None else found

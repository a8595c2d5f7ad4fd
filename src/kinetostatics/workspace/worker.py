"""A process that does pieces of work of a sweep: ``python -m kinetostatics.workspace.worker``, see :mod:`.crew`."""

from __future__ import annotations

import os
import signal
import sys
import traceback
from typing import Any


def main() -> None:
    """Work until standard input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl+C is the caller's business
    stdin, stdout = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever is printed must not come between the replies

    from kinetostatics.exceptions import KinetostaticsError
    from kinetostatics.workspace.process_pool import receive, send
    from kinetostatics.workspace.tasks import perform

    try:
        plan, labels = receive(stdin)
        while True:
            task = receive(stdin)
            reply: tuple[str, Any]
            try:
                found = perform(plan, labels, task)
                reply = "done", None if getattr(task, "path", None) is not None else found
            except KinetostaticsError as error:
                reply = "failed", (type(error).__name__, str(error))
            except OSError as error:
                reply = "failed", ("KinetostaticsError", f"{error.filename or 'a file'}: {error.strerror or error}")
            except Exception:
                reply = "failed", ("Exception", traceback.format_exc())
            send(stdout, reply)
    except (EOFError, BrokenPipeError):
        pass


if __name__ == "__main__":
    main()

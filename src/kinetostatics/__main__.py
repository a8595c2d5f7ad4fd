"""The program ``kinetostatics``, also as ``python -m kinetostatics``."""

import signal
import sys
from types import FrameType


def run() -> int:
    """Run the command line and return the exit code; an interruption (Ctrl+C) is one line, also while modules are imported."""
    interruptions = []

    def interrupt(number: int, _: FrameType | None) -> None:
        interruptions.append(number)
        raise KeyboardInterrupt

    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # it may be ignored
        signal.signal(signal.SIGINT, interrupt)
    try:
        from kinetostatics.cli.main import main

        return main()
    except BaseException:
        if not interruptions:  # otherwise any error: NumPy, for example, turns the interruption into an ImportError
            raise
        print("kinetostatics: interrupted", file=sys.stderr)
        return 130
    finally:
        if interruptions:
            signal.signal(signal.SIGINT, signal.SIG_IGN)


if __name__ == "__main__":
    sys.exit(run())

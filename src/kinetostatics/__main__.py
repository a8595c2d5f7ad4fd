"""``python -m kinetostatics``: the command line."""

import sys

from kinetostatics.cli.main import main

if __name__ == "__main__":
    sys.exit(main())

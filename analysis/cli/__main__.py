"""``python -m analysis.cli`` is ``lure``."""

import sys

from analysis.cli.entry import main

if __name__ == "__main__":
    sys.exit(main())

"""``python -m lure.analysis.cli`` is ``lure``."""

import sys

from lure.analysis.cli.entry import main

if __name__ == "__main__":
    sys.exit(main())

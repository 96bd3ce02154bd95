"""Settings shared by all tests.

The profile `dev` is the default: few examples, the same in every run.  `--hypothesis-profile=ci` draws many at random.
"""

import os

from hypothesis import settings

os.environ["MPLBACKEND"] = "agg"  # figures are files, also where a display is at hand

settings.register_profile("dev", max_examples=40, derandomize=True, deadline=None)
settings.register_profile("ci", max_examples=1000, deadline=None, print_blob=True)
settings.load_profile("dev")

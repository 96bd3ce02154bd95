"""Machine code that is compiled once on a computer, not once in each clone: numba takes 12 s for the kernel."""

import os
from pathlib import Path

from lure.rod.motion import compilation

HOME = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "lure-tests"


def share_compiled():
    """Let numba optimise half, and keep what it compiles where the tests of every clone find it.

    Its own caches have a folder for each path of a source file.  In one folder the names keep versions of the kernel
    apart, for :func:`lure.rod.motion.compilation.compiled_kernel` puts the hash of all its files into them; numba
    itself looks at its version, the processor and the text of the file.
    """
    os.environ.setdefault("NUMBA_OPT", "1")
    if os.environ.get("NUMBA_CACHE_DIR", str(HOME)) != str(HOME):  # processes that a process of tests starts have it
        return
    os.environ["NUMBA_CACHE_DIR"] = str(HOME)
    register = compilation._register

    def shared():
        """Before anything is compiled: until then numba, which takes long, is not imported."""
        from numba import config
        from numba.core.caching import UserProvidedCacheLocator

        class OneFolder(UserProvidedCacheLocator):
            """The folder, wherever the file lies."""

            @classmethod
            def get_suitable_cache_subpath(cls, py_file):
                return "kernel"

        globals()[OneFolder.__name__] = OneFolder
        config.CACHE_LOCATOR_CLASSES = f"{__name__}.{OneFolder.__name__}"
        register()

    compilation._register = shared

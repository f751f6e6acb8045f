"""The command ``rher``: the program that ``cargo`` builds, out of the compiled half of the package.

Importing ``rher`` itself would import NumPy and Gymnasium, which the program does not need.
"""

import importlib.machinery
import importlib.util
import signal
import sys
from types import ModuleType


def main() -> int:
    """Does what the command line says, and returns the exit status."""
    # Python answers Ctrl-C by an exception, which nobody would see here; where it is ignored, as in
    # the background of a script, it stays ignored.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    arguments = sys.argv[1:]
    # What started this program, such as `-m rher_command` or the path of a script.
    program = sys.orig_argv[1 : len(sys.orig_argv) - len(arguments)]
    return _compiled().main(["rher", *arguments], sys.executable, program)


def _compiled() -> ModuleType:
    """``rher._rher``, without ``rher``."""
    package = importlib.util.find_spec("rher")
    if package is None or package.submodule_search_locations is None:
        raise ImportError("the package `rher` is not installed beside its command; install it again")
    finder = importlib.machinery.PathFinder
    spec = finder.find_spec("rher._rher", package.submodule_search_locations)
    if spec is None or spec.loader is None:
        raise ImportError("the package `rher` has no compiled half; install it again")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


if __name__ == "__main__":
    sys.exit(main())

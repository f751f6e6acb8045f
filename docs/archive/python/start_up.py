"""CPU time that the command and the package take to start, beside what starts anyway.

Run with the interpreter of an environment in which the wheel is installed.
"""

import resource
import statistics
import subprocess
import sys
from pathlib import Path


def milliseconds(*command: str) -> float:
    """The median of 15 starts."""
    spent = []
    for _ in range(15):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, stdout=subprocess.DEVNULL, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        spent.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return 1000 * statistics.median(spent)


python = sys.executable
bare = milliseconds(python, "-c", "pass")
program = milliseconds(str(Path(python).with_name("rher")), "--version")
needed = milliseconds(python, "-c", "import numpy, gymnasium")
package = milliseconds(python, "-c", "import numpy, gymnasium, rher")
print(f"rher --version: {program - bare:.0f} ms over {bare:.0f}")
print(f"import rher: {package - needed:.0f} ms over {needed:.0f}")

"""Where a comparison was made: processor, load, versions."""

import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from rher.compare.part import Measured

PACKAGES = (
    "rher",
    "gymnasium",
    "gymnasium-robotics",
    "mujoco",
    "panda-gym",
    "stable-baselines3",
    "sb3-contrib",
    "torch",
)


def machine() -> Measured:
    """The machine as it is now."""
    cpu = platform.processor()
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        cpu = next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    return {
        "cpu": cpu,
        "cores": os.cpu_count(),
        "load": os.getloadavg()[0],
        "python": platform.python_version(),
        "packages": {name: found for name in PACKAGES if (found := _version(name)) is not None},
    }


def lines(about: Measured) -> list[str]:
    """One sentence about a machine."""
    packages = ", ".join(f"{name} {number}" for name, number in about["packages"].items())
    return [
        f"{about['cores']} cores of {about['cpu']}, load {about['load']:.1f} at the start; "
        f"Python {about['python']}, {packages}."
    ]


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None

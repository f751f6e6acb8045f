"""The command ``rher``, started by the interpreter that runs this."""

import subprocess
import sys

from rher.errors import (
    EnvError,
    FileError,
    InputError,
    PolicyError,
    RherError,
    SettingsError,
)

__all__ = ["command", "last_error", "output"]

#: What exit statuses mean, as ``rher --help`` has them; others are only a ``RherError``.
ERRORS: dict[int, type[RherError]] = {
    2: InputError,
    3: SettingsError,
    4: SettingsError,
    5: FileError,
    6: FileError,
    7: FileError,
    8: PolicyError,
    9: EnvError,
}


def command(*arguments: str) -> list[str]:
    """The command line."""
    return [sys.executable, "-m", "rher_command", *arguments]


def output(*arguments: str) -> str:
    """What the program prints.

    :raise RherError: what it says if it fails.
    """
    ended = subprocess.run(
        command(*arguments),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="replace",
    )
    if ended.returncode != 0:
        said = last_error(ended.stderr) or f"`rher` ended with {ended.returncode}"
        said = said.removeprefix("error: ").removeprefix("--set: ")
        raise ERRORS.get(ended.returncode, RherError)(said)
    return ended.stdout


def last_error(said: str) -> str:
    """The error among the lines that a program said, or else the last line."""
    lines = [line for line in said.splitlines() if line.strip()]
    errors = [line for line in lines if line.startswith("error: ")]
    return (errors or lines or [""])[-1]

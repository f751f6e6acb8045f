"""What goals of your own environments say of an object beside where it should be."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from rher._arguments import real, text
from rher.errors import InputError

__all__ = ["Angle", "Flag", "Number", "Quaternion", "Tail"]


@dataclass(frozen=True)
class Number:
    """One number, such as the opening of a gripper, that may differ by ``tolerance``."""

    name: str
    tolerance: float
    numbers: ClassVar[int] = 1
    metric: ClassVar[str] = "difference"


@dataclass(frozen=True)
class Angle:
    """One angle in radians, that may differ by ``tolerance`` in radians; full turns do not count."""

    name: str
    tolerance: float
    numbers: ClassVar[int] = 1
    metric: ClassVar[str] = "angle"


@dataclass(frozen=True)
class Quaternion:
    """An orientation in four numbers, that may be turned by ``tolerance`` in radians.

    ``q`` and ``-q`` are the same orientation. The numbers are those of ``(x, y, z, w)``; the angle
    between two orientations is the same for ``(w, x, y, z)``.
    """

    name: str
    tolerance: float
    numbers: ClassVar[int] = 4
    metric: ClassVar[str] = "rotation"


@dataclass(frozen=True)
class Flag:
    """A number that says yes (above 0.5) or no, and must be as the goal says."""

    name: str
    numbers: ClassVar[int] = 1
    metric: ClassVar[str] = "flag"
    tolerance: ClassVar[float] = 0.5


#: A part of what goals say of an object beside where it should be.
Tail = Number | Angle | Quaternion | Flag

#: The most numbers of an object beside its position.
MOST_NUMBERS = 8


def checked(tail: Sequence[Tail]) -> list[dict[str, Any]]:
    """The parts as the compiled half takes them."""
    parts = list(tail)
    for part in parts:
        if not isinstance(part, Tail):
            raise InputError(
                f"tail has {part!r}, expected rher.Number, rher.Angle, rher.Quaternion or rher.Flag"
            )
    names = [text("name of a part of tail", part.name) for part in parts]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"tail has two parts called {name!r}, expected different names")
    count = sum(part.numbers for part in parts)
    if count > MOST_NUMBERS:
        raise InputError(f"tail has {count} numbers, expected at most {MOST_NUMBERS}")
    largest = float(np.finfo(np.float32).max)
    return [
        {
            "name": part.name,
            "metric": part.metric,
            "tolerance": real(f"tolerance of {part.name}", part.tolerance, 0.0, largest),
        }
        for part in parts
    ]

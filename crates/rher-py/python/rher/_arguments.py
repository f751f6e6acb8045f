"""What users pass, as plain Python numbers: NumPy's numbers and arrays are taken everywhere.

Every message names the argument, what was expected and what came.
"""

import operator
import os
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from rher.errors import InputError


def whole(name: str, value: Any, least: int, most: int) -> int:
    """``value`` as an ``int`` within ``least`` and ``most``."""
    try:
        if isinstance(value, (bool, np.bool_)):
            raise TypeError
        number = operator.index(value)
    except TypeError:
        raise InputError(f"{name} is {value!r}, expected a whole number") from None
    if not least <= number <= most:
        raise InputError(f"{name} is {number}, expected {_limit(least)} to {_limit(most)}")
    return number


def real(name: str, value: Any, least: float, most: float) -> float:
    """``value`` as a ``float`` within ``least`` and ``most``."""
    try:
        if isinstance(value, (bool, np.bool_, str, bytes)):
            raise TypeError
        number = float(value)
    except (TypeError, ValueError):
        raise InputError(f"{name} is {value!r}, expected a number") from None
    if not least <= number <= most:
        raise InputError(f"{name} is {number}, expected {least} to {most}")
    return number


def _limit(number: int) -> str:
    """Powers of two by their exponent."""
    exponent = number.bit_length()
    return f"2**{exponent} - 1" if exponent > 31 and number == 2**exponent - 1 else str(number)


def text(name: str, value: Any) -> str:
    """``value``, if it is a string."""
    if not isinstance(value, str):
        raise InputError(f"{name} is {value!r}, expected a string")
    return str(value)


def path(name: str, value: Any) -> str:
    """``value`` as a string that names a file or folder."""
    try:
        return os.fsdecode(os.fspath(value))
    except TypeError:
        raise InputError(f"{name} is {value!r}, expected a path") from None


def _plain(name: str, value: Any) -> Any:
    """The same tree without anything of NumPy's."""
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if value is None or isinstance(value, (str, bool)):
        return value
    if isinstance(value, Mapping):
        return {
            text(f"a key of {name}", key): _plain(f"{name}[{key!r}]", part)
            for key, part in value.items()
        }
    if isinstance(value, Iterable):
        return [_plain(f"{name}[{index}]", part) for index, part in enumerate(value)]
    try:
        return operator.index(value)
    except TypeError:
        pass
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise InputError(f"{name} is {value!r}, expected numbers, strings or booleans") from None
    if not np.isfinite(number):
        raise InputError(f"{name} is {number}, expected a finite number")
    return number


def table(name: str, value: Any) -> dict[str, Any]:
    """A dictionary with plain values; None is an empty one."""
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        raise InputError(f"{name} is {value!r}, expected a dictionary")
    return _plain(name, value)

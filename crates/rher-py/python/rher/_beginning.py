"""How an episode begins, where ``reset(options=...)`` chooses it."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rher.errors import InputError

#: Bound of the spaces in meters, beyond any position: Gymnasium's checker warns of infinite spaces.
FAR = 100.0

#: Where each object starts ``[3 N]``, how far it is turned ``[N]``, where it should go ``[3 N]``.
Beginning = tuple[list[float] | None, list[float] | None, list[float] | None]


def beginning(options: Any, objects: int) -> Beginning | None:
    """What the options of a reset choose; None if they choose nothing."""
    rows = _rows(options, objects, None)
    if rows is None:
        return None
    layout, turns, goal = (None if row is None else row.tolist() for row in rows)
    return layout, turns, goal


def beginnings(options: Any, objects: int, envs: int) -> list[Beginning] | None:
    """The same for each of ``envs`` environments."""
    rows = _rows(options, objects, envs)
    if rows is None:
        return None
    lists = [[None] * envs if row is None else row.tolist() for row in rows]
    return list(zip(*lists, strict=True))


def _rows(
    options: Any, objects: int, envs: int | None
) -> tuple[NDArray[np.float64] | None, ...] | None:
    if options is None:
        return None
    if not isinstance(options, Mapping):
        raise InputError(f"options is {options!r}, expected a dictionary")
    widths = {"layout": 3 * objects, "turns": objects, "goal": 3 * objects}
    for key in options:
        if key not in widths:
            known = ", ".join(widths) if envs is None else ", ".join([*widths, "reset_mask"])
            raise InputError(f"reset has no option {key!r}, expected {known}")
    rows = tuple(
        None if options.get(name) is None else _numbers(name, options[name], width, envs)
        for name, width in widths.items()
    )
    return rows if any(row is not None for row in rows) else None


def _numbers(name: str, value: Any, width: int, envs: int | None) -> NDArray[np.float64]:
    """``value`` as numbers within the spaces: ``(width,)``, or ``(envs, width)``."""
    name = f"options[{name!r}]"
    shape = f"({width},)" if envs is None else f"({width},) or ({envs}, {width})"
    try:
        numbers = np.asarray(value)
        if numbers.dtype.kind not in "iuf":
            raise TypeError
        numbers = numbers.astype(np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{name} is {value!r}, expected numbers of shape {shape}") from None
    if numbers.shape != (width,) and numbers.shape != (envs, width):
        raise InputError(f"{name} has shape {numbers.shape}, expected {shape}")
    wrong = numbers[~(np.abs(numbers) <= FAR)]
    if wrong.size:
        raise InputError(f"{name} has the number {wrong[0]}, expected {-FAR} to {FAR}")
    return numbers if envs is None else np.broadcast_to(numbers, (envs, width))

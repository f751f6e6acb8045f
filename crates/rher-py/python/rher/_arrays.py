"""What the compiled half asks NumPy to do with arrays that it cannot read as they are."""

import numpy as np


def as_numbers(array: object) -> np.ndarray:
    """A copy of ``array`` in 32-bit numbers, in the order of its indices and aligned in memory.

    :raise TypeError: if it holds anything but real numbers and booleans.
    """
    found = np.asarray(array)
    if found.dtype.kind not in "biuf":
        raise TypeError(f"expected real numbers, got an array of {found.dtype}")
    return np.require(found, np.float32, ["C_CONTIGUOUS", "ALIGNED"])

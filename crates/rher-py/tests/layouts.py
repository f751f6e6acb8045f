"""Arrays with equal numbers in every arrangement of memory that NumPy can make."""

import numpy as np


def _fortran(array):
    return np.asfortranarray(array)


def _transposed(array):
    return np.ascontiguousarray(array.T).T


def _by_columns(array):
    return np.stack(list(np.moveaxis(array, -1, 0))).T if array.ndim == 2 else array


def _sliced(array):
    wide = np.full((*(3 * size for size in array.shape),), 7, array.dtype)
    window = wide[tuple(slice(1, None, 3) for _ in array.shape)]
    window[...] = array
    return window


def _reversed(array):
    backwards = tuple(slice(None, None, -1) for _ in array.shape)
    return array[backwards].copy()[backwards]


def _read_only(array):
    array = array.copy()
    array.flags.writeable = False
    return array


def _other_byte_order(array):
    return array.astype(array.dtype.newbyteorder())


def _unaligned(array):
    """A field behind one byte: neither aligned nor a multiple of its size apart."""
    table = np.zeros(array.shape, [("byte", np.uint8), ("number", array.dtype)])
    table["number"] = array
    return table["number"]


def _unaligned_block(array):
    """Contiguous, and one byte off."""
    memory = np.zeros(array.nbytes + 1, np.uint8)
    memory[1:] = np.ascontiguousarray(array).reshape(-1).view(np.uint8)
    return memory[1:].view(array.dtype).reshape(array.shape)


def _axes_moved(array):
    if array.ndim < 2:
        return array
    return np.moveaxis(np.moveaxis(array, 0, -1).copy(), -1, 0)


def _subclass(array):
    class Marked(np.ndarray):
        """A subclass without a behavior of its own."""

    return np.asfortranarray(array).view(Marked)


ARRANGEMENTS = [
    np.ascontiguousarray,
    _fortran,
    _transposed,
    _by_columns,
    _sliced,
    _reversed,
    _read_only,
    _other_byte_order,
    _unaligned,
    _unaligned_block,
    _axes_moved,
    _subclass,
    np.ndarray.tolist,
]

TYPES = [np.float32, np.float64, np.float16, np.longdouble, np.int64, np.int8, np.uint16]


def arranged(array, rng):
    """``array`` in one to three random arrangements, one after the other."""
    for arrange in rng.choice(ARRANGEMENTS[:-1], rng.integers(1, 4)):
        array = arrange(array)
    # An empty list has no width.
    return array.tolist() if array.size and rng.random() < 0.1 else array


def broadcast(row, shape):
    """``row`` seen ``shape`` times over the same memory: strides of zero."""
    return np.broadcast_to(row, (*shape, *row.shape))

"""Samples as Arrow tables with named, nested columns; needs pyarrow.

A sample within a sample is a struct, an array of numbers a list of fixed size, an array of characters a string.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pyarrow


def table(samples: np.ndarray) -> "pyarrow.Table":
    """The fields of the samples as columns, a row a sample."""
    import pyarrow

    return pyarrow.table({name: _array(np.asarray(samples[name])) for name in samples.dtype.names or ()})


def _array(column: np.ndarray) -> "pyarrow.Array":
    import pyarrow

    if column.ndim == 2 and column.dtype == np.uint8:
        return pyarrow.array([row.tobytes().rstrip(b"\0 ").decode("utf-8", "replace") for row in column], pyarrow.string())
    if column.ndim == 2:
        return pyarrow.FixedSizeListArray.from_arrays(_array(column.reshape(-1)), column.shape[1])
    if column.dtype.names:
        return pyarrow.StructArray.from_arrays([_array(column[name]) for name in column.dtype.names], column.dtype.names)
    return pyarrow.array(np.ascontiguousarray(column))

"""Tables: columns by name, as numpy arrays of equal length."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np


class Table(dict[str, np.ndarray]):
    """Columns by name, as numpy arrays of equal length. With pyarrow installed, readers of Arrow take a table, too.

    `summary` has the figures that the command prints with `--json`: rows read, rows left out, results.
    """

    summary: Mapping[str, Any] = {}

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        import pyarrow

        return pyarrow.table(dict(self)).__arrow_c_stream__(requested_schema)


def column_of(kind: str, values: bytearray | list[str]) -> np.ndarray:
    return np.frombuffer(values, kind) if isinstance(values, bytearray) else np.array(values, dtype=object)

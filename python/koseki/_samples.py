"""Samples: types, codes, and values by name."""

from __future__ import annotations

import numpy as np

from . import _koseki
from ._codes import CODES
from ._table import Table, column_of

_NUMBERS = {"f64": "<f8", "f32": "<f4"} | {f"{s}{8 * n}": f"<{s}{n}" for s in "ui" for n in (1, 2, 4, 8)}
_DOCS: dict[str, dict[str, str]] = {}
_AXES = 6
_DAY_NS = 86_400_000_000_000
#: Place of the element (row, column) of a covariance in the upper triangle.
_PLACES = np.zeros((_AXES, _AXES), int)
_PLACES[np.triu_indices(_AXES)] = np.arange(_AXES * (_AXES + 1) // 2)
_PLACES = np.maximum(_PLACES, _PLACES.T)


def _dtypes() -> dict[str, np.dtype]:
    """Memory maps of all samples; samples contained in others come first."""
    dtypes: dict[str, np.dtype] = {}
    for name, (fields, size) in _koseki.layouts():
        kinds = []
        for _, kind, _, octets, _ in fields:
            element = kind.lstrip("[ ").split(";")[0].split("]")[0].strip()
            base = np.dtype(_NUMBERS[element]) if element in _NUMBERS else dtypes[element]
            kinds.append(np.dtype((base, (octets // base.itemsize,))) if kind.startswith("[") else base)
        dtypes[name] = np.dtype({
            "names": [field[0] for field in fields],
            "formats": kinds,
            "offsets": [field[2] for field in fields],
            "itemsize": size,
        })
        _DOCS[name] = {field[0]: field[4] for field in fields}
    return dtypes


#: Types of the samples by name, such as `DTYPES["SystemTrack"]`.
DTYPES: dict[str, np.dtype] = _dtypes()


def describe(sample: str) -> dict[str, str]:
    """Unit and meaning of each field of a sample ("SystemTrack"), or of each value of a code ("TrackState")."""
    if sample in CODES:
        lines = (CODES[sample].__doc__ or "").splitlines()
        return dict(line.strip().split(": ", 1) for line in lines)
    return dict(_DOCS[sample])


def covariance(samples: np.ndarray) -> np.ndarray:
    """Covariances of position and velocity as symmetric matrices: 6 × 6 for a sample, n × 6 × 6 for n samples.

    Rows and columns are east, north, up (m), then velocities (m/s). `samples` have a field `covariance`.
    """
    return samples["covariance"]["upper"][..., _PLACES]


def upper(matrices: np.ndarray) -> np.ndarray:
    """The 21 elements of `covariance["upper"]` from symmetric 6 × 6 matrices: the inverse of `covariance`."""
    return np.asarray(matrices)[..., *np.triu_indices(_AXES)]


def table(samples: np.ndarray, *, origin: tuple[float, float, float] | None = None) -> Table:
    """Samples of a topic as a table with the columns of the recorder's CSV files, which the offline commands take.

    `samples` come from a subscription or from `read`. Times are seconds since midnight (UTC) of the first sample's day.
    With `origin`, the latitude and longitude (degrees) and height (m) of the system frame's origin, system tracks have
    columns `latitude`, `longitude` (WGS-84, degrees) and `flight_level`. A ValueError is raised for samples that have
    no table.
    """
    names = [name for name, dtype in DTYPES.items() if dtype == samples.dtype]
    if not names:
        raise ValueError(f"an array with the fields {samples.dtype.names} holds no samples of a topic")
    fields = samples.dtype.names or ()
    times = [name for name in ("reference_time_ns", "time_of_measurement_ns", "time_ns") if name in fields]
    first_ns = int(samples[times[0]][0]) if times and len(samples) else 0
    octets = np.ascontiguousarray(samples).tobytes()
    columns = _koseki.of_samples(names[0], octets, origin, first_ns // _DAY_NS * _DAY_NS)
    return Table((name, column_of(*column)) for name, column in columns)

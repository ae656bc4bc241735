"""Koseki's offline commands on tables, and recordings of ASTERIX as dicts and tables.

Each command runs in this process, by the functions of the executable `koseki`, so results equal the results of the
command line to the digit. Other Python threads run meanwhile, and Ctrl-C ends a command. `progress` is a function; each
pass over the tables calls the function several times a second with the share that is done.

A table is given as a path of a CSV file, a dict of columns, samples of a topic (from a subscription or from `read`), a
data frame of pandas or polars, a table of pyarrow, or another object with the Arrow C stream interface (which needs
pyarrow). A table is returned as a dict of numpy columns; `pandas.DataFrame`, `polars.DataFrame` and `pyarrow.table` take
such a dict. `koseki COMMAND --help` lists columns and units: a table with time, latitude and longitude will do, under the
names and in the units of many programs (`lat`, `SOG_knots`, `icao24`). `origin` is the latitude and longitude (degrees), and
the height (m) if it is not 0, from which metres count; without it, the first place in degrees is the origin.

A fault in a table or an option is a ValueError with the table, the line of a file (the first line has the columns'
names), the column, the value and a remedy. Rows left out are a warning.
"""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from . import _koseki, _samples
from ._table import Table, column_of

__all__ = ["Table", "compare", "decode", "decode_columns", "fuse", "locate", "score", "simulate", "smooth", "track"]

Origin = tuple[float, float] | tuple[float, float, float]
Editions = Mapping[int | str, str]
Progress = Callable[[float], object]


class _Command:
    """Words of a command, and the tables in memory by the names in these words."""

    def __init__(self, *words: str) -> None:
        self.words = list(words)
        self.tables: dict[str, Any] = {}

    def option(self, **options: object) -> _Command:
        for name, value in options.items():
            if value is not None:
                self.words += [f"--{name.replace('_', '-')}", str(value)]
        return self

    def origin(self, origin: Origin | None) -> _Command:
        """The place from which metres count."""
        return self.option(origin=None if origin is None else ",".join(map(str, origin)))

    def table(self, **tables: Any) -> _Command:
        """Options that take a table, or a list of tables."""
        for name, given in tables.items():
            if given is None:
                continue
            self.words.append(f"--{name.replace('_', '-')}")
            if isinstance(given, (list, tuple)):
                self.words += [self._name(table, f"{name}[{place}]") for place, table in enumerate(given)]
            else:
                self.words.append(self._name(given, name))
        return self

    def config(self, config: str | os.PathLike[str] | None) -> _Command:
        """The path of a configuration, or a configuration as a text of several lines."""
        if isinstance(config, str) and "\n" in config:
            self.tables["config"] = config
            return self.option(config="config")
        return self.option(config=config)

    def _name(self, table: Any, name: str) -> str:
        if isinstance(table, (str, os.PathLike)):
            return os.fspath(table)
        self.tables[name] = _columns(table)
        return name

    def run(self, progress: Progress | None) -> tuple[dict[str, Table], str, str]:
        """The written tables, the answer, and the messages of the command."""
        written, answer, said = _koseki.run(self.words, self.tables, progress)
        tables = {path: Table((name, column_of(*column)) for name, column in columns) for path, columns in written.items()}
        return tables, answer, said

    def out(self, progress: Progress | None) -> Table:
        """The only written table, with the summary."""
        written, answer, _ = self.option(out="out").run(progress)
        table, table.summary = written["out"], json.loads(answer)
        if refused := table.summary.get("rows_refused"):
            warnings.warn(f"{refused} rows left out: {table.summary['first_refused'][0]}", stacklevel=3)
        return table

    def figures(self, progress: Progress | None) -> dict[str, Any]:
        """The answer of a command that writes no table."""
        _, answer, said = self.run(progress)
        if said:
            warnings.warn(said.strip(), stacklevel=3)
        return json.loads(answer)


def _columns(table: Any) -> list[tuple[str, Any]]:
    if isinstance(table, np.ndarray) and table.dtype.names:
        table = _samples.table(table)
    is_frame = hasattr(table, "columns") and not (hasattr(table, "__arrow_c_stream__") and not hasattr(table, "__dataframe__"))
    if not isinstance(table, Mapping) and not is_frame:
        import pyarrow

        table = pyarrow.table(table)
    names = list(getattr(table, "column_names", None) or (table if isinstance(table, Mapping) else table.columns))
    return [(str(name), _values(np.asarray(table[name]))) for name in names]


def _values(column: np.ndarray) -> np.ndarray | list[str]:
    if column.dtype.kind == "f":
        return np.ascontiguousarray(column, np.float64)
    if column.dtype.kind in "iu" and np.can_cast(column.dtype, np.int64):
        return np.ascontiguousarray(column, np.int64)
    return [_text(value) for value in column.tolist()]


def _text(value: object) -> str:
    return "" if value is None or value != value else str(value)


def fuse(
    tracks: Any, *, config: Any = None, rule: str | None = None, refresh: float | None = None, origin: Origin | None = None,
    sigma: float | None = None, progress: Progress | None = None,
) -> Table:
    """System tracks from a table or tables of sensor tracks (metres or degrees), as `koseki fuse` makes system tracks.

    `sigma` is the standard deviation of positions in degrees without `sigma_m`, metres; `rule` is a fusion rule, such as
    "auto" or "best-source"; with `refresh` a row comes every so many seconds; `config`
    is a path or the text of a TOML file.
    """
    command = _Command("fuse", "--json").table(tracks=tracks).config(config).origin(origin)
    return command.option(rule=rule, refresh=refresh, sigma=sigma).out(progress)


def smooth(
    tracks: Any, *, config: Any = None, rule: str | None = None, refresh: float | None = None, origin: Origin | None = None,
    sigma: float | None = None, progress: Progress | None = None,
) -> Table:
    """The rows of `fuse` with the same arguments, smoothed with later measurements, as by `koseki smooth`."""
    command = _Command("smooth", "--json").table(tracks=tracks).config(config).origin(origin)
    return command.option(rule=rule, refresh=refresh, sigma=sigma).out(progress)


def track(
    detections: Any, *, wide_area: Any = None, emissions: Any = None, config: Any = None, period: float | None = None,
    origin: Origin | None = None, progress: Progress | None = None,
) -> Table:
    """Tracks from a table or tables of detections (metres and radians, or degrees), as by `koseki track`.

    `wide_area` is a table of counts, `emissions` a table of bearings; `period` is the time between rows, seconds.
    """
    command = _Command("track", "--json").table(detections=detections, wide_area=wide_area, emissions=emissions)
    return command.config(config).origin(origin).option(period=period).out(progress)


def locate(
    bearings: Any, *, filter: str | None = None, select: str | None = None, config: Any = None,
    origin: Origin | None = None, bearing_sigma_deg: float | None = None, date: str | None = None,
    progress: Progress | None = None,
) -> Table:
    """Places of emitters from a table of bearings (clockwise from north, at places in metres or degrees), as by `koseki locate`.

    `filter` is "auto", "fixed" or "straight"; `select` is "auto", "none", "interval", "minimum" or "staged". `bearings` may
    be the path of a recording of direction finders (ASTERIX), with a standard deviation of `bearing_sigma_deg` and the first
    day `date`, as "2024-06-06".
    """
    command = _Command("locate", "--json").table(bearings=bearings).config(config).origin(origin)
    command.option(filter=filter, select=select, bearing_sigma_deg=bearing_sigma_deg, date=date)
    return command.out(progress)


def compare(
    tracks: Any, *, truth: Any = None, config: Any = None, refresh: float | None = None, progress: Progress | None = None
) -> dict[str, Any]:
    """Figures of every fusion rule on the same sensor tracks, as printed by `koseki compare --json`."""
    command = _Command("compare", "--json").table(tracks=tracks, truth=truth).config(config)
    return command.option(refresh=refresh).figures(progress)


def score(
    truth: Any, tracks: Any, *, c: float | None = None, gate: float | None = None, max_age: float | None = None,
    t0: int | None = None, t1: int | None = None, standard: str | None = None, reference: str | None = None,
    origin: Origin | None = None,
) -> dict[str, Any]:
    """Figures of tracks against a truth (metres or degrees), as printed by `koseki score --json`.

    `c` is the cut-off of GOSPA and OSPA, `gate` the distance up to which a target keeps a track; a state older than
    `max_age` does not show; whole seconds from `t0` to `t1` are scored. `standard` adds the lines of standards, such as
    "ed-142,esassp"; `reference` is "truth", "independent" or "smoothed".
    """
    command = _Command("score", "--json").table(truth=truth, tracks=tracks).origin(origin)
    command.option(c=c, gate=gate, max_age=max_age, t0=t0, t1=t1, standard=standard, reference=reference)
    return command.figures(None)


def simulate(
    scenario: str | os.PathLike[str] = "demo", *, seed: int = 1, seconds: float = 120.0, progress: Progress | None = None
) -> dict[str, Table]:
    """Tables of a simulated world by name, such as "truth" and "sensor_tracks_1", as by `koseki simulate`."""
    command = _Command("simulate").option(scenario=scenario, seed=seed, out="out", **{"for": seconds})
    return {Path(path).stem: table for path, table in command.run(progress)[0].items()}


def decode(path: str | os.PathLike[str], *, editions: Editions | None = None) -> Iterator[dict[str, Any]]:
    """Records of a recording of ASTERIX, each as a dict by item number; "_c" is the category, "_ts" the time of recording.

    `editions` are editions other than the default, as in {21: "0.23"}, or {"48/RE": "1.13"} for an expansion field. What
    `koseki decode` would leave out is left out.
    """
    return iter(_koseki.records(path, _chosen(editions)))


def decode_columns(path: str | os.PathLike[str], *, editions: Editions | None = None) -> dict[int, Table]:
    """The same records as a table for each category: a column for each element, such as "042.X", a row for each record.

    Numbers are 64-bit floats in the document's units, NaN where a record lacks the element; whole numbers are exact up to 2^53.
    Texts are strings; a repeated element is a list, as in the dicts; an element that a record lacks is None.
    """
    return {
        category: Table((name, _decoded(values)) for name, values in columns)
        for category, (_, columns) in _koseki.columns(path, _chosen(editions)).items()
    }


def _chosen(editions: Editions | None) -> list[str]:
    return [f"{category}={edition}" for category, edition in (editions or {}).items()]


def _decoded(values: bytes | list) -> np.ndarray:
    if isinstance(values, bytes):
        return np.frombuffer(values)
    column = np.empty(len(values), dtype=object)
    column[:] = values
    return column

"""Koseki's offline commands on tables, and recordings of ASTERIX as dicts and tables.

Each command runs the executable `koseki` of the same version, found by $KOSEKI or in the PATH, on files in a folder of
its own, so results are those of the command line to the digit; other Python threads run meanwhile. Decoding needs none. A
table is given as a path of a CSV file, a dict of columns, a data frame of pandas or polars, a table of pyarrow, or
anything else with the Arrow C stream interface (that needs pyarrow). A table is returned as a dict of numpy columns, of
which `pandas.DataFrame`, `polars.DataFrame` and `pyarrow.table` make theirs. The columns, and their units, are those of
`koseki COMMAND --help`.
"""

from __future__ import annotations

import csv
import json
import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from . import _koseki
from ._errors import KosekiError

__all__ = ["Table", "compare", "decode", "decode_columns", "fuse", "locate", "score", "simulate", "track"]

Editions = Mapping[int | str, str]


class Table(dict[str, np.ndarray]):
    """Columns by name, as numpy arrays of one length: also what takes Arrow takes it, where pyarrow is installed."""

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        import pyarrow

        return pyarrow.table(dict(self)).__arrow_c_stream__(requested_schema)


#: Columns that stay text, whatever they look like: an address may look like a number.
_TEXTS = {"address", "callsign", "lambda", "mode_3a", "sources", "state", "type", "weights"}


def _executable() -> str:
    named = os.environ.get("KOSEKI") or shutil.which("koseki")
    if not named:
        raise KosekiError("no executable koseki in the PATH: install Koseki, or name the executable by $KOSEKI")
    return named


def _run(arguments: Sequence[object]) -> str:
    done = subprocess.run([_executable(), *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        said = done.stderr.strip().splitlines()
        text = said[-1].removeprefix("koseki: ") if said else f"exit code {done.returncode}"
        raise ValueError(text) if done.returncode == 2 else KosekiError(text)
    return done.stdout


def _options(**options: object) -> list[object]:
    given = [(f"--{name.replace('_', '-')}", value) for name, value in options.items() if value is not None]
    return [word for pair in given for word in pair]


def _text(value: object) -> object:
    if value is None or value != value:
        return ""
    # A column of whole numbers with gaps comes as floats.
    return int(value) if isinstance(value, float) and value.is_integer() and value != 0.0 else value


def _write(table: Any, path: Path) -> None:
    if not isinstance(table, Mapping) and not hasattr(table, "columns"):
        import pyarrow

        table = pyarrow.table(table)
    names = list(getattr(table, "column_names", None) or (table if isinstance(table, Mapping) else table.columns))
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(names)
        columns = [np.asarray(table[name]).tolist() for name in names]
        writer.writerows([_text(value) for value in row] for row in zip(*columns, strict=True))


def _file(table: Any, folder: Path, name: str) -> Path:
    """Path of a table, which is written where it is none."""
    if isinstance(table, (str, os.PathLike)):
        return Path(table)
    path = folder / f"{name}.csv"
    _write(table, path)
    return path


def _files(tables: Any, folder: Path, name: str) -> list[Path]:
    many = tables if isinstance(tables, (list, tuple)) else [tables]
    return [_file(table, folder, f"{name}_{number}") for number, table in enumerate(many)]


def _column(name: str, values: Sequence[str]) -> np.ndarray:
    for kind in () if name in _TEXTS else (np.int64, np.float64):
        try:
            filled = values if kind is np.int64 else [value or "nan" for value in values]
            return np.array(filled, dtype=object).astype(kind)
        except (ValueError, OverflowError):
            pass
    return np.array(values, dtype=object)


def _read(path: Path) -> Table:
    with path.open(newline="") as file:
        rows = csv.reader(file)
        names = next(rows)
        columns = list(zip(*rows, strict=True)) or [()] * len(names)
    return Table((name, _column(name, column)) for name, column in zip(names, columns, strict=True))


def _config(config: str | os.PathLike[str] | None, folder: Path) -> Path | None:
    """Path of a configuration; a text of several lines is one itself."""
    if isinstance(config, str) and "\n" in config:
        path = folder / "config.toml"
        path.write_text(config)
        return path
    return None if config is None else Path(config)


def fuse(tracks: Any, *, config: Any = None, rule: str | None = None, refresh: float | None = None) -> Table:
    """System tracks from tables of sensor tracks (metres, m/s, seconds), one or a list, as `koseki fuse` makes them.

    `rule` is a fusion rule, such as "auto" or "best-source"; with `refresh` a row comes every so many seconds; `config`
    is a path or the text of a TOML file.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        options = _options(config=_config(config, folder), rule=rule, refresh=refresh, out=folder / "out.csv")
        _run(["fuse", "--tracks", *_files(tracks, folder, "tracks"), *options])
        return _read(folder / "out.csv")


def track(
    detections: Any, *, wide_area: Any = None, emissions: Any = None, config: Any = None, period: float | None = None
) -> Table:
    """Tracks from tables of detections (metres, radians, seconds), one or a list, as `koseki track` makes them.

    `wide_area` is a table of counts, `emissions` one of bearings; with `period` rows come every so many seconds.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        options = _options(
            wide_area=None if wide_area is None else _file(wide_area, folder, "wide_area"),
            emissions=None if emissions is None else _file(emissions, folder, "emissions"),
            config=_config(config, folder), period=period, out=folder / "out.csv",
        )
        _run(["track", "--detections", *_files(detections, folder, "detections"), *options])
        return _read(folder / "out.csv")


def locate(bearings: Any, *, filter: str | None = None, select: str | None = None, config: Any = None) -> Table:
    """Places of emitters from a table of bearings (radians clockwise from north, metres), as `koseki locate` finds them.

    `filter` is "auto", "fixed" or "straight"; `select` is "auto", "none", "interval", "minimum" or "staged".
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        options = _options(filter=filter, select=select, config=_config(config, folder), out=folder / "out.csv")
        _run(["locate", "--bearings", _file(bearings, folder, "bearings"), *options])
        return _read(folder / "out.csv")


def compare(tracks: Any, *, truth: Any = None, config: Any = None, refresh: float | None = None) -> dict[str, Any]:
    """Figures of every fusion rule on the same sensor tracks, as `koseki compare --json` prints them."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        options = _options(
            truth=None if truth is None else _file(truth, folder, "truth"), config=_config(config, folder), refresh=refresh
        )
        return json.loads(_run(["compare", "--json", "--tracks", *_files(tracks, folder, "tracks"), *options]))


def score(
    truth: Any, tracks: Any, *, c: float | None = None, gate: float | None = None, max_age: float | None = None,
    t0: int | None = None, t1: int | None = None,
) -> dict[str, Any]:
    """Figures of tracks against a truth (metres, seconds), as `koseki score --json` prints them.

    `c` is the cut-off of GOSPA and OSPA, `gate` the distance up to which a target keeps its track; a state older than
    `max_age` does not show; whole seconds from `t0` to `t1` are scored.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        options = _options(truth=_file(truth, folder, "truth"), tracks=_file(tracks, folder, "tracks"))
        options += _options(c=c, gate=gate, max_age=max_age, t0=t0, t1=t1)
        return json.loads(_run(["score", "--json", *options]))


def simulate(scenario: str = "demo", *, seed: int = 1, seconds: float = 120.0) -> dict[str, Table]:
    """Tables of a simulated world by their names, such as "truth" and "sensor_tracks_1", as `koseki simulate` makes them."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "out"
        _run(["simulate", *_options(scenario=scenario, seed=seed, out=folder, **{"for": seconds})])
        return {path.stem: _read(path) for path in sorted(folder.glob("*.csv"))}


def decode(path: str | os.PathLike[str], *, editions: Editions | None = None) -> Iterator[dict[str, Any]]:
    """Records of a recording of ASTERIX, each as a dict by item number; "_c" is its category, "_ts" when it was recorded.

    `editions` are those that are not the default, as in {21: "0.23"}, or {"48/RE": "1.13"} for an expansion field. What
    `koseki decode` would leave out is left out.
    """
    return iter(_koseki.records(path, _chosen(editions)))


def decode_columns(path: str | os.PathLike[str], *, editions: Editions | None = None) -> dict[int, Table]:
    """The same records as a table for each category: a column for each element, such as "042.X", a row for each record.

    Numbers are 64-bit floats in the document's units, NaN where a record lacks them; whole ones are exact up to 2^53.
    Texts are strings; what is repeated is a list, as in the dicts; where a record lacks them there is None.
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

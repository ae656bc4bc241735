"""System tracks of a Koseki deployment as numpy record arrays, and reports into the deployment.

    import koseki

    for tracks in koseki.subscribe("demo"):
        print(tracks["track_number"], tracks["position_m"])

Positions are metres east, north and up in the system frame, velocities metres per second, times nanoseconds since 1970
(UTC), stamps nanoseconds of the machine's monotonic clock. `koseki.describe(dtype)` describes every field.
"""

from __future__ import annotations

import asyncio
import os
import time
import warnings
from collections.abc import AsyncIterator, Callable, Iterator
from importlib.metadata import version
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from . import _arrow
from . import _koseki
from . import offline
from .offline import Table, compare, decode, decode_columns, fuse, locate, score, simulate, smooth, track
from ._errors import AlreadyFed, BorrowLimit, Ended, KosekiError, NoPlaceLeft, NoSuchTopic, NotRunning, SchemaMismatch
from . import _codes
from ._codes import *
from ._codes import CODES
from ._samples import DTYPES, covariance, describe, table, upper

if TYPE_CHECKING:
    import pandas

__all__ = [
    "AlreadyFed", "BorrowLimit", "CODES", "Counts", "DTYPES", "Ended", "KosekiError", "NoPlaceLeft", "NoSuchTopic", "NotRunning",
    "Publisher", "SchemaMismatch", "Subscription", "Table", "Tracks", "compare", "covariance", "decode", "decode_columns",
    "describe", "fuse", "instances", "locate", "offline", "order", "origin", "publish", "read", "score", "simulate",
    "smooth", "sources", "subscribe", "table", "topics", "track", "upper",
]
__all__ += _codes.__all__

__version__: str = version("koseki")


def __dir__() -> list[str]:
    """The public names."""
    return sorted(__all__)


#: Seconds between two looks for a deployment that does not run yet.
_PAUSE = 0.2
#: Seconds for which a topic may be missing from a deployment that runs: the processes create topics one after another.
_TOPIC_PATIENCE = 5.0


class Tracks(np.ndarray):
    """A slice of samples: a record array with the count of samples missing before.

    `lost` is the number of samples missing between the slice before and this slice. `starts_epoch`: fusion has started
    anew, so that with recorded inputs track numbers begin again, or this is the first slice.
    """

    lost: int = 0
    starts_epoch: bool = False
    epoch: int = 0

    @property
    def __arrow_c_stream__(self) -> Callable[..., object]:
        """The samples for readers of Arrow, with nested columns; needs pyarrow. A single field has no such form."""
        if not self.dtype.names or self.ndim != 1:
            raise AttributeError("__arrow_c_stream__")
        return lambda requested_schema=None: _arrow.table(self).__arrow_c_stream__(requested_schema)


class Counts(NamedTuple):
    """Counts of a subscription since the opening, in samples; `epoch` is the start-up number of fusion."""

    taken: int
    lost: int
    of_older_epochs: int
    epoch: int


class Subscription:
    """Reader of one topic: see `subscribe`. Iteration ends with the deployment."""

    def __init__(
        self, instance: str, topic: str = "system/tracks", *, borrow: bool = False, wait: bool | float = False,
        reconnect: bool = False, queue: int | None = None,
    ) -> None:
        if queue is not None and queue < 1:
            raise ValueError(f"a queue of {queue} slices is refused: the length is 1 or more")
        self._names, self._borrow, self._reconnect = (instance, topic), borrow, reconnect
        self._queue = queue
        # When the topic was first missing from a deployment that runs.
        self._missing_since: float | None = None
        self._last_counts, self._is_closed = Counts(0, 0, 0, 0), False
        patience = float("inf") if wait is True else float(wait)
        # None between two runs of the deployment.
        self._inner: _koseki.Subscription | None = self._open(time.monotonic() + patience)
        self._dtype = DTYPES[self._inner.sample()]

    def _open(self, end: float) -> _koseki.Subscription:
        """Opens the topic, and waits until `end` for a deployment that does not run yet."""
        while True:
            now = time.monotonic()
            try:
                inner = _koseki.Subscription(*self._names, self._queue)
                self._missing_since = None
                return inner
            except NotRunning:
                self._missing_since = None
                if now >= end:
                    raise
            except NoSuchTopic:
                if self._missing_since is None:
                    self._missing_since = now
                if now >= end or self._is_topic_unknown():
                    raise
            time.sleep(min(_PAUSE, max(end - time.monotonic(), 0.0)))

    def _is_topic_unknown(self) -> bool:
        return self._missing_since is not None and time.monotonic() - self._missing_since >= _TOPIC_PATIENCE

    def _leave_ended(self) -> None:
        """Leaves a run of the deployment that has ended, so that the shared memory can be cleared."""
        self._last_counts = self.counts
        if self._inner is not None:
            self._inner.close()
        self._inner = None

    @property
    def dtype(self) -> np.dtype:
        """Type of the samples."""
        return self._dtype

    @property
    def counts(self) -> Counts:
        """Samples taken and samples lost; between two runs of the deployment, the counts of the run before."""
        return self._last_counts if self._inner is None else Counts(*self._inner.counts())

    def receive(self, timeout: float | None = None) -> Tracks | None:
        """The next slice; None if no slice comes within `timeout` seconds. 0 does not wait; None waits without limit.

        Raises Ended, SchemaMismatch, and BorrowLimit where two borrowed slices are held already. With `reconnect` the
        call waits for the next run of the deployment instead of raising Ended: the first slice has `starts_epoch`. The
        call raises NoSuchTopic if that run has had no such topic for 5 s.
        """
        end = float("inf") if timeout is None else time.monotonic() + timeout
        while True:
            if self._inner is None:
                self._reopen(end)
            if self._inner is None:
                return None
            try:
                piece = self._inner.receive(None if timeout is None else max(end - time.monotonic(), 0.0))
                break
            except Ended:
                if not self._reconnect:
                    raise
            self._leave_ended()
            if time.monotonic() >= end:
                return None
            time.sleep(min(_PAUSE, max(end - time.monotonic(), 0.0)))
        if piece is None:
            return None
        array = np.frombuffer(piece, dtype=self._dtype)
        if not self._borrow:
            array = array.copy()
        tracks = array.view(Tracks)
        tracks.lost, tracks.starts_epoch, tracks.epoch = piece.lost, piece.starts_epoch, piece.epoch
        return tracks

    def _reopen(self, end: float) -> None:
        """Waits until `end` for the next run of the deployment."""
        if self._is_closed:
            raise ValueError("the publisher or subscription is closed")
        try:
            self._inner = self._open(end)
        except NotRunning:
            pass
        except NoSuchTopic:
            if self._is_topic_unknown():
                raise

    def __iter__(self) -> Iterator[Tracks]:
        try:
            while (tracks := self.receive()) is not None:
                if len(tracks):
                    yield tracks
                del tracks
        except Ended:
            return

    async def __aiter__(self) -> AsyncIterator[Tracks]:
        while True:
            try:
                # Woken by the descriptor; a wake-up can be lost, so look now and then all the same.
                tracks = self.receive(0)
                if tracks is None and self._inner is None:
                    await asyncio.sleep(_PAUSE)
                elif tracks is None:
                    await self._readable(0.1)
                elif len(tracks):
                    yield tracks
                del tracks
            except Ended:
                return

    async def _readable(self, timeout: float) -> None:
        loop, ready, descriptor = asyncio.get_running_loop(), asyncio.Event(), self.fileno()
        loop.add_reader(descriptor, ready.set)
        try:
            await asyncio.wait_for(ready.wait(), timeout)
        except TimeoutError:
            pass
        finally:
            loop.remove_reader(descriptor)

    def to_dataframe(self, seconds: float, *, raw: bool = False) -> "pandas.DataFrame":
        """The samples of so many seconds, as a pandas data frame with a row for each sample.

        Columns are as in `table`, with latitude and longitude, for the offline commands. With `raw` each
        number has a column: arrays become columns such as `position_m_0`, samples within samples such as
        `stages.fused_ns`.
        """
        import pandas

        pieces, end = [np.zeros(0, self._dtype)], time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            if (tracks := self.receive(left)) is not None:
                pieces.append(np.asarray(tracks).copy())
        samples = np.concatenate(pieces)
        return pandas.DataFrame(dict(_columns(samples)) if raw else table(samples, origin=origin(self._names[0])))

    def fileno(self) -> int:
        """A descriptor that is readable when there is something to receive, for select and the like.

        Then receive with time-out 0 until None comes; do so every tenth of a second all the same. With `reconnect`,
        each run of the deployment has another descriptor, and between two runs NotRunning is raised.
        """
        if self._inner is None:
            if self._is_closed:
                raise ValueError("the publisher or subscription is closed")
            raise NotRunning(f"instance {self._names[0]} has ended and does not run again yet")
        return self._inner.fileno()

    def close(self) -> None:
        """Leaves the deployment. The shared memory can be cleared when all readers have left."""
        self._is_closed = True
        if self._inner is not None:
            self._inner.close()

    def __enter__(self) -> "Subscription":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _columns(array: np.ndarray, prefix: str = "") -> Iterator[tuple[str, np.ndarray]]:
    for name in array.dtype.names or ():
        column, path = array[name], prefix + name
        if column.dtype.names and column.ndim == 1:
            yield from _columns(column, path + ".")
        elif column.dtype.names:
            for index in range(column.shape[1]):
                yield from _columns(column[:, index], f"{path}_{index}.")
        elif column.ndim == 1:
            yield path, column
        elif column.dtype == np.uint8:
            yield path, np.array([row.tobytes().rstrip(b"\0 ").decode("utf-8", "replace") for row in column], dtype=object)
        else:
            for index in range(column.shape[1]):
                yield f"{path}_{index}", column[:, index]


def instances() -> list[str]:
    """Names of the instances that run on this machine, below KOSEKI_ROOT if that is set."""
    return _koseki.instances()


def topics(instance: str) -> list[str]:
    """Names of the topics of a running instance."""
    return _koseki.topics(instance)


def sources(instance: str) -> list[str]:
    """Names of the sources of a running instance, by number in samples; empty if the instance does not run."""
    return _koseki.sources(instance)


def origin(instance: str, timeout: float = 2.0) -> tuple[float, float, float] | None:
    """Latitude and longitude (degrees) and height (m) of the system frame's origin; None if the origin is not published."""
    with Subscription(instance, "system/frame-origin") as frame:
        piece = frame.receive(timeout)
        if piece is None or not len(piece):
            return None
        last = piece[-1]
        return float(last["latitude_deg"]), float(last["longitude_deg"]), float(last["height_m"])


def subscribe(
    instance: str, topic: str = "system/tracks", *, borrow: bool = False, wait: bool | float = False,
    reconnect: bool = False, queue: int | None = None,
) -> Subscription:
    """Reads a topic of the deployment called `instance` (of `koseki up --instance`, or the name in the configuration).

    Iterating yields record arrays, by default of system tracks; other topics are `system/alarms`,
    `system/alerts`, `sensor/NAME/tracks`, `sensor/NAME/detections`, `wide-area/NAME/reports`, `platform/NAME/state`, `health`. Arrays
    are copies; with `borrow`, arrays lie in shared memory, are read-only, and no more than two may be held at a time.
    `wait` waits for the deployment, for ever or so many seconds; `reconnect` continues with the next run after an end.
    A topic that is missing for 5 s from a deployment that runs raises NoSuchTopic all the same.

    `queue` is the number of slices that may wait before the oldest is lost, in place of the topic's usual number (256
    for tracks): from 1 to the usual number, for `system/tracks` to `[machine] queue_slices` of the configuration.
    Another number raises ValueError.
    """
    return Subscription(instance, topic, borrow=borrow, wait=wait, reconnect=reconnect, queue=queue)


def read(path: str | os.PathLike[str]) -> dict[str, Tracks]:
    """All samples of a recording of all topics (a file of MCAP that the recorder wrote), as a record array a topic.

    Raises SchemaMismatch for a recording of another version of the samples, ValueError for a file that is no recording.
    Damaged parts are skipped; a warning gives the number of such parts.
    """
    topics, damaged, damaged_bytes = _koseki.read(path)
    if damaged:
        warnings.warn(f"{os.fspath(path)}: damaged parts skipped: {damaged} ({damaged_bytes} bytes)", stacklevel=2)
    if not topics:
        raise ValueError(f"{os.fspath(path)} is no recording of all topics")
    return {topic: np.frombuffer(octets, DTYPES[sample]).view(Tracks) for topic, (sample, octets) in topics.items()}


class Publisher:
    """Writer of one topic: see `publish`."""

    def __init__(
        self, instance: str, topic: str = "", *, source: str | None = None, clock_limit_s: float | None = None
    ) -> None:
        self._inner = _koseki.Publisher(instance, topic) if source is None else _koseki.Publisher.feed(instance, source)
        self._dtype = DTYPES[self._inner.sample()]
        if clock_limit_s is not None:
            self._inner.limit_clock(clock_limit_s)

    @property
    def dtype(self) -> np.dtype:
        """Type of the samples."""
        return self._dtype

    @property
    def sent(self) -> int:
        """Number of samples published."""
        return self._inner.sent()

    def new(self, count: int) -> np.ndarray:
        """So many samples with zero ("unknown") in all fields."""
        return np.zeros(count, self._dtype)

    def send_detections(self, **columns: Any) -> None:
        """Publishes detections in degrees or metres, as arrays or single values of these columns:

        - `latitude`, `longitude` (WGS-84, degrees) and `height_m` (above the ellipsoid), or `east_m`, `north_m`, `up_m` in
          the system frame; `sigma_m` and `height_sigma_m`, standard deviations above 0;
        - in place of a position `bearing_deg`, with `range_m` and `elevation_deg` if measured, `bearing_sigma_deg`,
          `range_sigma_m`, `elevation_sigma_deg`, and the sensor's place: `sensor_latitude`, `sensor_longitude`,
          `sensor_height_m` (directions are clockwise from true north there), or `sensor_east_m`, `sensor_north_m`,
          `sensor_up_m` (from the system frame's north);
        - `range_rate_mps`, `range_rate_sigma_mps`; `address`, `mmsi` (integers), `callsign`;
        - `time_s` or `time_ns` (UTC since 1970), now if not given; `scan`: detections with the same time form a scan.

        The names of columns in `koseki fuse --help` and `koseki track --help` stand for the columns of the same quantity, in
        their own units: `lat`, `flight_level`, `bearing_rad`.

        NaN stands for an unknown value. If a detection has a fault, none is published, and a ValueError names the
        place, field, value, limit and remedy. The first call waits up to a fifth of a second for the frame's origin.
        """
        self._send(False, columns)

    def send_tracks(self, **columns: Any) -> None:
        """Publishes reports of tracks in degrees or metres, as arrays or single values of these columns:

        - `track`, the number of the track at the sensor, from 0 to 4294967295;
        - the columns of a position, an identity and a time of `send_detections`;
        - `speed_mps`, `course_deg` (clockwise from true north at the target) and `climb_mps`, or `velocity_east_mps`,
          `velocity_north_mps` and `velocity_up_mps` in the system frame; `velocity_sigma_mps`, a standard deviation. Not
          given, or with a deviation of 0, the velocity is unknown, not 0; `climb_mps` may be given alone;
        - `state`, a `TrackState`: confirmed if not given.

        Errors as for `send_detections`.
        """
        self._send(True, columns)

    def _send(self, are_tracks: bool, columns: dict[str, Any]) -> None:
        names = ("time_s", *_koseki.observation_numbers()[are_tracks])
        wholes = {"time_ns": np.int64, "address": np.int64, "mmsi": np.int64, "callsign": object}
        kinds = dict.fromkeys(names, np.float64) | wholes | dict.fromkeys(("track", "state") if are_tracks else ("scan",), np.int64)
        given: dict[str, np.ndarray] = {}
        for name, column in columns.items():
            known, scale = (name, 1.0) if name in kinds else _koseki.observation_column(name, are_tracks) or (name, 1.0)
            if known not in kinds:
                raise TypeError(f"{name} is no column of these observations; there are: {', '.join(kinds)}")
            if known in given:
                raise TypeError(f"{name} stands beside another column of {known}: leave one of them out")
            if column is not None:
                given[known] = np.asarray(column) if scale == 1.0 else np.asarray(column, np.float64) * scale
        for name, column in given.items():
            if kinds[name] is np.int64 and column.size and column.dtype.kind not in "iu":
                raise TypeError(f"{name} has values of {column.dtype}: give whole numbers")
        given = {name: column.astype(kinds[name]) for name, column in given.items()}
        shape = np.broadcast_shapes(*(column.shape for column in given.values()))
        if len(shape) > 1:
            raise ValueError(f"the columns have {len(shape)} dimensions: give arrays of one dimension, or single values")
        count = shape[0] if shape else 1
        filled = {name: np.ascontiguousarray(np.broadcast_to(column, (count,))) for name, column in given.items()}
        callsigns = filled.pop("callsign", None)
        self._inner.send_observations(
            are_tracks, count, [(name, column) for name, column in filled.items() if column.dtype == np.float64],
            [(name, column) for name, column in filled.items() if column.dtype == np.int64],
            None if callsigns is None else callsigns.tolist(),
        )

    def send(self, samples: np.ndarray | dict[str, Any]) -> None:
        """Publishes samples: an array of `dtype`, or a dict of columns; columns left out are zero.

        Sequence numbers and stamps are filled in.
        """
        if isinstance(samples, dict):
            count = max((np.shape(column)[0] for column in samples.values()), default=0)
            array = self.new(count)
            for name, column in samples.items():
                array[name] = column
            samples = array
        if samples.dtype != self._dtype:
            raise ValueError(f"samples are {samples.dtype.names}, not of the topic's type: make samples with new()")
        self._inner.publish(np.ascontiguousarray(samples).tobytes())

    def close(self) -> None:
        """Leaves the deployment."""
        self._inner.close()

    def __enter__(self) -> "Publisher":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def order(instance: str, kind: str, *, operator: str | None = None, lasts_s: float | None = None,
          timeout: float = 10.0, **parameters: object) -> np.void:
    """Gives an order to fusion and returns its state: a record with `number`, `status`, `refusal`, `text` and `order`.

        koseki.order("demo", "out", source="radar-south", operator="anna", lasts_s=600)

    `koseki order --help` lists kinds and parameters; `from` is given as `from_`. The order expires after `lasts_s`
    seconds; None: never. A refused order raises ValueError with the reason; KosekiError is raised if no answer comes
    within `timeout` seconds. The topic `system/order-states` lists the orders in force.
    """
    words = " ".join([kind, *(f"{name.rstrip('_')}={value}" for name, value in parameters.items())])
    octets = _koseki.order(instance, words, operator or os.environ.get("USER") or "python", lasts_s, timeout)
    if octets is None:
        raise KosekiError(f"fusion of instance {instance} has not answered within {timeout} s")
    state = np.frombuffer(octets, dtype=DTYPES["OrderState"])[0]
    if state["refusal"] != 0:
        raise ValueError(bytes(state["text"]).split(b"\0")[0].decode())
    return state


def publish(
    instance: str, source: str | None = None, *, topic: str | None = None, clock_limit_s: float | None = None
) -> Publisher:
    """Feeds the source called `source`, which the configuration calls external, with detections or sensor tracks.

    A sensor of a tracker is called `TRACKER.NAME`. `topic` names another topic: `sensor/TRACKER.NAME/detections` of a
    tracker's sensor, `wide-area/NAME/reports` or `platform/NAME/state`. Times farther than `clock_limit_s` seconds from
    this machine's clock are refused: above 0, by default 600; infinity permits all times.
    """
    if (source is None) == (topic is None):
        raise ValueError("name either a source or a topic")
    return Publisher(instance, topic or "", source=source, clock_limit_s=clock_limit_s)

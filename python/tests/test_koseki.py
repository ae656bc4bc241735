"""The package beside a live demonstration, and its offline functions against the command line."""

import asyncio
import csv
import gc
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
import pandas
import polars
import pyarrow
import pytest

import koseki

TOP = Path(__file__).parents[2]
PATIENCE = 60.0
EXECUTABLE = os.environ.get("KOSEKI") or shutil.which("koseki")


def _run(arguments: list[object]) -> str:
    """What the executable prints."""
    return subprocess.run([EXECUTABLE, *map(str, arguments)], capture_output=True, text=True, check=True).stdout


def _read(path: Path) -> dict[str, np.ndarray]:
    """A table that the executable wrote, read by means that are not the package's."""
    with path.open(newline="") as file:
        rows = csv.reader(file)
        names = next(rows)
        columns = list(zip(*rows, strict=True)) or [()] * len(names)
    return {name: _typed(name, column) for name, column in zip(names, columns, strict=True)}


def _typed(name: str, values: tuple[str, ...]) -> np.ndarray:
    texts = {"address", "callsign", "lambda", "mmsi", "mode_3a", "name", "sources", "state", "type", "weights"}
    for kind in () if name in texts else (np.int64, np.float64):
        try:
            filled = values if kind is np.int64 else [value or "nan" for value in values]
            return np.array(filled, dtype=object).astype(kind)
        except ValueError:
            pass
    return np.array(values, dtype=object)


def _assert_same(table: dict[str, np.ndarray], expected: dict[str, np.ndarray]) -> None:
    assert list(table) == list(expected)
    for name, column in expected.items():
        assert table[name].dtype == column.dtype, name
        np.testing.assert_array_equal(table[name], column, err_msg=name)


class Deployment:
    """A deployment of the command line in a folder of its own."""

    def __init__(self, *arguments: object) -> None:
        command = [EXECUTABLE, *map(str, arguments)]
        self.process = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        assert any(" runs" in line for line in self.process.stderr)

    def stop(self) -> None:
        self.process.terminate()
        self.process.communicate()


@pytest.fixture(autouse=True, scope="session")
def root():
    # Names of sockets must fit below it.
    with tempfile.TemporaryDirectory(prefix="k", dir="/tmp") as folder:
        os.environ["KOSEKI_ROOT"] = folder
        yield


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    deployment = Deployment("demo", "--out", tmp_path_factory.mktemp("out"))
    yield "demo"
    deployment.stop()


def test_slices_are_record_arrays_without_loss(demo):
    states = []
    for tracks in koseki.subscribe(demo):
        states.extend(tracks["sequence"].tolist())
        assert tracks["position_m"].shape == (len(tracks), 3) and tracks.lost == 0
        assert tracks.flags.writeable
        if len(states) > 200:
            break
    assert states == list(range(states[0], states[0] + len(states)))


def test_borrowed_slices_are_limited_and_given_back(demo):
    tracks = koseki.subscribe(demo, borrow=True)
    kept = [tracks.receive(PATIENCE), tracks.receive(PATIENCE)]
    assert not kept[0].flags.writeable
    view = kept.pop(0)["track_number"]
    gc.collect()
    with pytest.raises(koseki.BorrowLimit):
        while tracks.receive(PATIENCE) is not None:
            pass
    del view
    gc.collect()
    assert tracks.receive(PATIENCE) is not None


def test_readers_that_are_killed_while_they_hold_slices_harm_nobody(demo):
    other = koseki.subscribe(demo)
    program = """
import os, signal, sys, koseki
tracks = koseki.subscribe(sys.argv[1], borrow=True)
kept = [tracks.receive(), tracks.receive()]
os.kill(os.getpid(), signal.SIGKILL)
"""
    # More than a topic has places for readers.
    for _ in range(30):
        killed = subprocess.run([sys.executable, "-c", program, demo])
        assert killed.returncode == -signal.SIGKILL
        while other.receive(0) is not None:
            pass
    assert other.receive(PATIENCE) is not None
    assert other.counts.lost == 0


def test_a_fusion_that_starts_anew_is_told(demo):
    tracks = koseki.subscribe(demo)
    first = tracks.receive(PATIENCE)
    assert first.starts_epoch
    status = json.loads(_run(["status", "--instance", demo, "--json"]))
    fusion = next(child for child in status[0]["processes"] if child["name"] == "fusion")
    os.kill(fusion["pid"], signal.SIGKILL)
    end = time.monotonic() + PATIENCE
    while (piece := tracks.receive(PATIENCE)).epoch == first.epoch:
        assert not piece.starts_epoch and time.monotonic() < end
    assert piece.starts_epoch and piece.epoch > first.epoch
    assert not tracks.receive(PATIENCE).starts_epoch
    assert tracks.counts.epoch == piece.epoch


def test_loops_of_events_are_woken(demo):
    async def some():
        lengths = []
        async for tracks in koseki.subscribe(demo):
            lengths.append(len(tracks))
            if len(lengths) == 10:
                return lengths

    assert min(asyncio.run(some())) > 0


def test_a_data_frame_has_named_columns_or_a_column_a_number(demo):
    named = koseki.subscribe(demo).to_dataframe(2.0)
    assert len(named) > 0 and {"time_s", "system_track_id", "x", "latitude", "longitude"} <= set(named.columns)
    latitude, longitude, _ = koseki.origin(demo)
    assert np.all(np.abs(named["latitude"] - latitude) < 5) and np.all(np.abs(named["longitude"] - longitude) < 5)
    frame = koseki.subscribe(demo).to_dataframe(2.0, raw=True)
    assert len(frame) > 0 and frame["position_m_0"].dtype == np.float64
    assert {"stages.fused_ns", "identity.callsign", "contributions_0.weight"} <= set(frame.columns)


def test_codes_have_names_and_covariances_are_matrices(demo):
    assert koseki.TrackState.CONFIRMED in set(koseki.TrackState) and koseki.TrackState(1).name.isupper()
    both = koseki.SensorTrackBits.VELOCITY | koseki.SensorTrackBits.HEIGHT
    assert koseki.SensorTrackBits.HEIGHT in both and isinstance(both, int)
    assert set(koseki.describe("TrackState")) == {state.name for state in koseki.TrackState}
    tracks = koseki.subscribe(demo).receive(PATIENCE)
    matrices = koseki.covariance(tracks)
    assert matrices.shape == (len(tracks), 6, 6) and np.all(matrices == matrices.transpose(0, 2, 1))
    assert np.all(np.diagonal(matrices, axis1=1, axis2=2)[:, :2] > 0)
    assert np.all(koseki.upper(matrices) == tracks["covariance"]["upper"])
    assert koseki.covariance(tracks[0]).shape == (6, 6)


def test_instances_topics_and_sources_are_listed(demo):
    assert demo in koseki.instances()
    topics = koseki.topics(demo)
    assert {"system/tracks", "system/alarms", "health"} <= set(topics) and topics == sorted(topics)
    for source in koseki.sources(demo):
        assert f"sensor/{source}/tracks" in topics
    with pytest.raises(koseki.NotRunning, match=os.environ["KOSEKI_ROOT"]):
        koseki.topics("nosuch")
    assert koseki.__version__


def test_samples_are_tables_for_the_offline_commands(demo):
    source = koseki.sources(demo)[0]
    pieces, reader = [], koseki.subscribe(demo, f"sensor/{source}/tracks")
    while sum(map(len, pieces)) < 300:
        pieces.append(np.asarray(reader.receive(PATIENCE)))
    samples = np.concatenate(pieces)
    table = koseki.table(samples)
    # Rows state millimetres.
    assert len(table["time_s"]) == len(samples) and np.allclose(table["x"], samples["position_m"][:, 0], rtol=0, atol=6e-4)
    _assert_same(koseki.fuse(samples), koseki.fuse(table))
    with pytest.raises(ValueError, match="no samples of a topic"):
        koseki.fuse(np.zeros(3, [("a", "<f8")]))


def test_orders_are_given_and_listed(demo):
    state = koseki.order(demo, "out", source="radar-west", operator="anna", lasts_s=600)
    assert (state["number"], state["refusal"]) == (1, 0)
    for kind, wrong, why in [
        ("k", {"value": -1, "source": "radar-west"}, "between"),
        ("k", {"value": 2.5, "source": "radar-west"}, "chooses no best source"),
        ("out", {"source": "x"}, "source of this name"),
        ("drop", {"track": 4_000_000_000}, "no such system track"),
    ]:
        with pytest.raises(ValueError, match=why):
            koseki.order(demo, kind, **wrong)
    listed = koseki.subscribe(demo, topic="system/order-states").receive(10)
    assert b"anna" in bytes(listed[listed["number"] == 1]["order"]["operator_name"][0])
    koseki.order(demo, "cancel", number=1)


def test_failures_are_told_apart(demo):
    for error, arguments in [
        (koseki.NotRunning, ["nobody"]),
        (koseki.NoSuchTopic, [demo, "sensor/nobody/tracks"]),
        (ValueError, [demo, "nonsense"]),
        (ValueError, ["a/b"]),
    ]:
        with pytest.raises(error):
            koseki.subscribe(*arguments)
    with pytest.raises(ValueError):
        koseki.publish(demo)
    closed = koseki.subscribe(demo)
    closed.close()
    with pytest.raises(ValueError):
        closed.receive(0)


def _resident_octets() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def test_an_external_source_is_fed_and_the_end_is_told(tmp_path):
    deployment = Deployment("up", TOP / "examples/feed.toml", "--instance", "feed", "--out", tmp_path)
    publisher, tracks = koseki.publish("feed", "own"), koseki.subscribe("feed")
    report = publisher.new(1)
    report["track_number"], report["state"], report["valid"] = 1, 1, 0x1 | 0x2 | 0x4 | 0x8
    report["position_m"] = [1000.0, 2000.0, 3000.0]
    # The diagonal, in the upper triangle row by row.
    report["covariance"]["upper"][0, [0, 6, 11, 15, 18, 20]] = [900.0] * 3 + [9.0] * 3
    fused, end = None, time.monotonic() + PATIENCE
    while fused is None and time.monotonic() < end:
        report["time_of_measurement_ns"] = time.time_ns()
        publisher.send(report)
        fused = tracks.receive(0.5)
    assert np.hypot(*(fused["position_m"][0, :2] - [1000.0, 2000.0])) < 100.0
    with pytest.raises(ValueError):
        publisher.send(np.zeros(1))
    # A fault is named with its field and the remedy, and nothing of its send is published.
    for field, value, text in [
        ("time_of_measurement_ns", int(time.time()), "the number is in seconds; multiply it by 1000000000"),
        ("position_m", [np.nan, 0.0, 0.0], r"position_m\[0\] is NaN"),
        ("covariance", np.zeros(1, report["covariance"].dtype), "the variance east, is 0: must be above 0"),
    ]:
        wrong, sent = report.copy(), publisher.sent
        wrong[field] = value
        with pytest.raises(ValueError, match=text):
            publisher.send(wrong)
        assert publisher.sent == sent
    # A reader that takes nothing loses what its topic has no room for, and is told.
    slow = koseki.subscribe("feed", "sensor/own/tracks")
    publisher.send(report)
    assert slow.receive(PATIENCE).lost == 0
    for _ in range(300):
        publisher.send(report)
    assert slow.receive(PATIENCE).lost == 300 - 256
    assert slow.counts.lost == 300 - 256
    slow.close()
    slow = koseki.subscribe("feed", "sensor/own/tracks", queue=100)
    publisher.send(report)
    assert slow.receive(PATIENCE).lost == 0
    for _ in range(300):
        publisher.send(report)
    assert slow.receive(PATIENCE).lost == 300 - 100
    slow.close()
    # What was received and let go takes no memory: KOSEKI_SLICES=1000000 for a long look.
    slices, begun = int(os.environ.get("KOSEKI_SLICES", 50_000)), 0
    for borrow in (False, True):
        reader = koseki.subscribe("feed", "sensor/own/tracks", borrow=borrow)
        for slice in range(slices // 2):
            publisher.send(report)
            assert reader.receive(PATIENCE).lost == 0
            if slice == slices // 10:
                begun = _resident_octets()
        assert _resident_octets() - begun < 4 << 20
        reader.close()
    deployment.process.terminate()
    with pytest.raises(koseki.Ended):
        while True:
            tracks.receive(PATIENCE)
    tracks.close()
    publisher.close()
    deployment.stop()


def test_a_longer_queue_loses_nothing_where_the_usual_one_loses(tmp_path):
    site = tmp_path / "site.toml"
    site.write_text((TOP / "examples/feed.toml").read_text() + "\n[machine]\nqueue_slices = 1024\n")
    deployment = Deployment("up", site, "--instance", "queue", "--out", tmp_path / "out")
    for length, text in [(1025, r"a queue of 1025 slices is refused: .* 1 to 1024; .*\[machine\] queue_slices"), (0, "of 0 slices")]:
        with pytest.raises(ValueError, match=text):
            koseki.subscribe("queue", queue=length)
    publisher = koseki.publish("queue", "own")
    usual, longer, quick = koseki.subscribe("queue"), koseki.subscribe("queue", queue=1024), koseki.subscribe("queue")
    report = publisher.new(1)
    report["track_number"], report["state"], report["valid"] = 1, 1, 0x1 | 0x2 | 0x4 | 0x8
    report["position_m"] = [1000.0, 2000.0, 3000.0]
    report["covariance"]["upper"][0, [0, 6, 11, 15, 18, 20]] = [900.0] * 3 + [9.0] * 3
    end = time.monotonic() + PATIENCE
    published = 0
    while published <= 600 and time.monotonic() < end:
        report["time_of_measurement_ns"] = time.time_ns()
        publisher.send(report)
        published += (fused := quick.receive(0.5)) is not None
        if published == 1 and fused is not None:
            # Losses before a reader's first slice are not counted.
            assert len(usual.receive(PATIENCE)) and len(longer.receive(PATIENCE))
    for reader in (usual, longer):
        while reader.receive(0) is not None:
            pass
    assert quick.counts.lost == longer.counts.lost == 0 < usual.counts.lost
    assert longer.counts.taken == usual.counts.taken + usual.counts.lost
    for port in (publisher, usual, longer, quick):
        port.close()
    deployment.stop()


def _local(latitude: float, longitude: float, height_m: float, origin: tuple[float, float, float]) -> np.ndarray:
    """East, north and up of a place over the round Earth, by the formulas of WGS-84."""
    def ecef(latitude: float, longitude: float, height_m: float) -> np.ndarray:
        a, e2 = 6378137.0, (2 - 1 / 298.257223563) / 298.257223563
        n = a / np.sqrt(1 - e2 * np.sin(latitude) ** 2)
        flat = (n + height_m) * np.cos(latitude)
        return np.array([flat * np.cos(longitude), flat * np.sin(longitude), (n * (1 - e2) + height_m) * np.sin(latitude)])

    (lat, lon), (sin, cos) = np.radians(origin[:2]), (np.sin, np.cos)
    axes = [[-sin(lon), cos(lon), 0], [-sin(lat) * cos(lon), -sin(lat) * sin(lon), cos(lat)],
            [cos(lat) * cos(lon), cos(lat) * sin(lon), sin(lat)]]
    return np.array(axes) @ (ecef(*np.radians([latitude, longitude]), height_m) - ecef(lat, lon, origin[2]))


def test_detections_in_degrees_become_fused_tracks(tmp_path):
    deployment = Deployment("up", TOP / "examples/detections.toml", "--instance", "degrees", "--out", tmp_path)
    source, tracks = koseki.publish("degrees", "own"), koseki.subscribe("degrees")
    with koseki.subscribe("degrees", "sensor/own.input/detections") as sent:
        # 100 km from the origin the Earth has fallen away by 785 m.
        source.send_detections(latitude=[41.932, 41.4], longitude=[2.948, 2.1], height_m=[900.0, np.nan], sigma_m=20)
        arrived = sent.receive(PATIENCE)
    expected = _local(41.932, 2.948, 900.0, koseki.origin("degrees"))
    assert abs(np.hypot(*expected[:2]) - 100e3) < 1e3 and expected[2] < 200.0
    np.testing.assert_allclose(arrived["values"][0], expected, rtol=0, atol=1e-3)
    assert arrived["scan"].tolist() == [1, 1] and arrived["detection_id"].tolist() == [1, 2]
    assert arrived["kind"].tolist() == [koseki.DetectionKind.POSITION3, koseki.DetectionKind.POSITION2]
    place = {"latitude": 41.0, "longitude": 2.0, "sigma_m": 20}
    for error, text, columns in [
        (ValueError, "observation 1 is refused.*latitude is 91: must be from -90 to 90 degrees; latitude and longitude are "
         "exchanged", {"latitude": [41.0, 91.0]}),
        (ValueError, "latitude is missing", {"latitude": np.nan}),
        (ValueError, "sigma_m is 0: must be above 0", {"sigma_m": 0}),
        (ValueError, "within 600 s", {"time_s": time.time() - 700}),
        (ValueError, "mmsi is 0", {"mmsi": 0}),
        (ValueError, "callsign", {"callsign": "LUFTHANSA"}),
        (TypeError, "heigth_m is no column", {"heigth_m": 3}),
        (TypeError, "whole numbers", {"scan": 1.5}),
        (ValueError, "shape", {"latitude": [41.0, 42.0], "longitude": [2.0, 2.1, 2.2]}),
    ]:
        with pytest.raises(error, match=text):
            source.send_detections(**place | columns)
    with pytest.raises(ValueError, match="not reports of tracks"):
        source.send_tracks(track=1, **place)
    assert source.sent == 2
    source.send_detections(bearing_deg=[10, 20], bearing_sigma_deg=0.5, sensor_latitude=41.3, sensor_longitude=2.1,
                           callsign="DLH1", address=0x3C6589, time_ns=time.time_ns())
    begin, end, confirmed = time.time(), time.monotonic() + PATIENCE, set()
    while len(confirmed) < 3 and time.monotonic() < end:
        longitude = 2.10 + 5e-4 * (time.time() - begin)
        source.send_detections(latitude=[41.40, 41.43, 41.46], longitude=longitude, sigma_m=20)
        time.sleep(0.2)
        while (fused := tracks.receive(0)) is not None:
            confirmed.update(fused["track_number"][fused["state"] == koseki.TrackState.CONFIRMED].tolist())
    assert len(confirmed) >= 3
    source.close()
    with pytest.raises(ValueError, match="above 0"):
        koseki.publish("degrees", "own", clock_limit_s=0)
    with koseki.publish("degrees", "own", clock_limit_s=10) as source:
        with pytest.raises(ValueError, match="within 10 s"):
            source.send_detections(**place, time_s=time.time() - 60)
    tracks.close()
    deployment.stop()


def test_tracks_in_degrees_have_a_velocity_over_ground(tmp_path):
    deployment = Deployment("up", TOP / "examples/feed.toml", "--instance", "degrees", "--out", tmp_path)
    with koseki.publish("degrees", "own", clock_limit_s=np.inf) as source, koseki.subscribe("degrees", "sensor/own/tracks") as sent:
        source.send_tracks(track=[7, 8], latitude=41.3, longitude=[2.1, 5.1], height_m=0, sigma_m=30, speed_mps=100,
                           course_deg=90, velocity_sigma_mps=3, state=koseki.TrackState.TENTATIVE, time_s=0)
        arrived = sent.receive(PATIENCE)
    assert arrived["track_number"].tolist() == [7, 8] and set(arrived["state"]) == {koseki.TrackState.TENTATIVE}
    np.testing.assert_allclose(arrived["velocity_mps"][0], [100.0, 0.0, 0.0], atol=1e-5)
    # East of the origin, east is turned by the convergence of the meridians, and points down.
    assert arrived["velocity_mps"][1][1] > 3.0 and arrived["velocity_mps"][1][2] < -3.0
    np.testing.assert_allclose(np.linalg.norm(arrived["velocity_mps"], axis=1), 100.0, atol=1e-5)
    deployment.stop()


def test_samples_are_arrow_with_nested_columns():
    samples = np.zeros(3, koseki.DTYPES["SystemTrack"]).view(koseki.Tracks)
    samples["track_number"], samples["position_m"] = [7, 8, 9], np.arange(9.0).reshape(3, 3)
    samples["identity"]["callsign"][1] = list(b"DLH1    ")
    for table in pyarrow.table(samples), polars.from_arrow(pyarrow.RecordBatchReader.from_stream(samples)).to_arrow():
        assert table.column_names == list(samples.dtype.names)
        assert table["track_number"].to_pylist() == [7, 8, 9]
        assert table["position_m"].to_pylist() == samples["position_m"].tolist()
        assert table["identity"].to_pylist()[1]["callsign"] == "DLH1"
        assert len(table["contributions"].to_pylist()[0]) == samples.dtype["contributions"].shape[0]
    assert not hasattr(samples["position_m"], "__arrow_c_stream__")

    class Stream:
        """What has the stream alone, and columns of its own kind."""

        columns = ["no", "names"]

        def __init__(self, table):
            self.__arrow_c_stream__ = pyarrow.table(table).__arrow_c_stream__

    world = koseki.simulate(seconds=20)
    table = next(table for name, table in world.items() if name.startswith("sensor_tracks"))
    _assert_same(koseki.fuse(Stream(dict(table))), koseki.fuse(table))


@pytest.fixture
def again(tmp_path):
    """Starts a deployment, as often as it is called; a test that fails leaves none to the next test."""
    started = []

    def start() -> Deployment:
        started.append(Deployment("up", TOP / "examples/feed.toml", "--instance", "again", "--out", tmp_path))
        return started[-1]

    yield start
    for deployment in started:
        if deployment.process.poll() is None:
            deployment.stop()


def _report(publisher: koseki.Publisher) -> np.ndarray:
    """A report that fusion could use."""
    report = publisher.new(1)
    report["time_of_measurement_ns"] = time.time_ns()
    report["covariance"]["upper"] = koseki.upper(np.diag([900.0] * 3 + [9.0] * 3))
    return report


def _received(tracks: koseki.Subscription) -> koseki.Tracks:
    """What is received of a publisher that sends one sample, and stays until it is received."""
    with koseki.publish("again", "own") as publisher:
        publisher.send(_report(publisher))
        return tracks.receive(PATIENCE)


def test_a_reader_that_reconnects_waits_through_an_end_and_goes_on(again):
    deployment = again()
    tracks = koseki.subscribe("again", "sensor/own/tracks", reconnect=True)
    assert len(_received(tracks)) == 1
    deployment.stop()
    for _ in range(2):
        begun = time.monotonic()
        assert tracks.receive(0.1) is None
        assert time.monotonic() - begun < 5.0
    assert tracks.receive(0) is None
    assert tracks.counts.taken == 1
    with pytest.raises(koseki.NotRunning):
        tracks.fileno()
    deployment = again()
    # Opens the topic of the new run.
    assert tracks.receive(1.0) is None
    assert tracks.fileno() >= 0
    assert len(_received(tracks)) == 1
    deployment.stop()
    assert tracks.receive(0.1) is None
    tracks.close()
    for use in tracks.fileno, lambda: tracks.receive(0):
        with pytest.raises(ValueError):
            use()


def test_a_loop_of_events_that_reconnects_goes_on_with_the_next_run(again):
    async def some():
        deployment, slices = again(), asyncio.Queue()

        async def read():
            async for tracks in koseki.subscribe("again", "sensor/own/tracks", reconnect=True):
                slices.put_nowait(len(tracks))

        reader = asyncio.create_task(read())
        for is_last in False, True:
            # The reader has opened the topic of this run.
            await asyncio.sleep(1.0)
            with koseki.publish("again", "own") as publisher:
                publisher.send(_report(publisher))
                assert await asyncio.wait_for(slices.get(), PATIENCE) == 1
            await asyncio.to_thread(deployment.stop)
            await asyncio.sleep(0.5)
            assert not reader.done()
            if not is_last:
                deployment = await asyncio.to_thread(again)
        reader.cancel()

    asyncio.run(some())


def test_a_reader_that_may_reconnect_gives_up_a_topic_that_a_running_deployment_lacks(again):
    deployment = again()
    begun = time.monotonic()
    with pytest.raises(koseki.NoSuchTopic):
        koseki.subscribe("again", "sensor/nobody/tracks", wait=True, reconnect=True)
    assert 4.5 < time.monotonic() - begun < PATIENCE
    begun = time.monotonic()
    with pytest.raises(koseki.NoSuchTopic):
        koseki.subscribe("again", "sensor/nobody/tracks", wait=0.3)
    assert 0.25 < time.monotonic() - begun < 3.0
    deployment.stop()
    begun = time.monotonic()
    with pytest.raises(koseki.NotRunning):
        koseki.subscribe("again", wait=0.05)
    assert time.monotonic() - begun < 0.2


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    """A simulated world as the executable writes it."""
    folder = tmp_path_factory.mktemp("case")
    _run(["simulate", "--scenario", "demo", "--for", "20", "--out", folder])
    return folder


@pytest.mark.skipif("KOSEKI_OTHER_LAYOUT" not in os.environ, reason="c/examples/other_layout.rs is not built")
def test_samples_of_another_layout_are_refused(tmp_path):
    deployment = Deployment("up", TOP / "examples/feed.toml", "--instance", "stale", "--out", tmp_path)
    tracks = koseki.subscribe("stale", "sensor/own/tracks")
    stale = subprocess.Popen([os.environ["KOSEKI_OTHER_LAYOUT"], "stale", "own"])
    with pytest.raises(koseki.SchemaMismatch, match="another layout"):
        tracks.receive(PATIENCE)
    tracks.close()
    stale.kill()
    stale.wait()
    deployment.stop()


def test_simulating_equals_the_command_line(case):
    world = koseki.simulate(seconds=20)
    assert sorted(world) == sorted(file.stem for file in case.glob("*.csv"))
    for name, table in world.items():
        _assert_same(table, _read(case / f"{name}.csv"))


@pytest.mark.parametrize("options", [{}, {"refresh": 0.5, "rule": "best-source"}], ids=["all", "refreshed"])
def test_fusing_equals_the_command_line(case, tmp_path, options):
    files, out = sorted(case.glob("sensor_tracks_*.csv")), tmp_path / "fused.csv"
    words = [word for name, value in options.items() for word in (f"--{name}", value)]
    told = json.loads(_run(["fuse", "--json", "--tracks", *files, *words, "--out", out]))
    expected, tables = _read(out), [_read(file) for file in files]
    assert len(expected["time_s"]) > 100
    # Whatever the columns come in, and in whatever kind of numbers.
    kinds = [files, tables, [pandas.DataFrame(table) for table in tables], [polars.DataFrame(table) for table in tables]]
    kinds += [[pyarrow.table(table) for table in tables], [tables[0], *files[1:]]]
    for given in kinds:
        fused = koseki.fuse(given, **options)
        _assert_same(fused, expected)
        timed = {"engine_s", "reports_per_s", "out"}
        assert {name: value for name, value in fused.summary.items() if name not in timed} == {
            name: value for name, value in told.items() if name not in timed
        }
    assert pyarrow.table(fused).num_rows == len(fused["time_s"])


def test_smoothing_equals_the_command_line(case, tmp_path):
    files, out = sorted(case.glob("sensor_tracks_*.csv")), tmp_path / "smoothed.csv"
    _run(["smooth", "--refresh", "1", "--tracks", *files, "--out", out])
    smoothed = koseki.smooth([_read(file) for file in files], refresh=1.0)
    _assert_same(smoothed, _read(out))
    assert smoothed.summary["measurements"] > 100


def test_tracking_equals_the_command_line(case, tmp_path):
    files, out = sorted(case.glob("detections_*.csv")), tmp_path / "tracks.csv"
    _run(["track", "--detections", *files, "--period", "1", "--out", out])
    expected = _read(out)
    assert len(expected["time_s"]) > 100
    for given in files, [_read(file) for file in files], [pandas.DataFrame(_read(file)) for file in files]:
        _assert_same(koseki.track(given, period=1), expected)


def test_locating_equals_the_command_line(tmp_path):
    config = TOP / "config/coast.toml"
    _run(["simulate", "--scenario", config, "--for", "120", "--out", tmp_path])
    file, out = sorted(tmp_path.glob("bearings_*.csv"))[0], tmp_path / "fixes.csv"
    _run(["locate", "--bearings", file, "--filter", "fixed", "--out", out])
    assert len(_read(out)["time_s"]) > 10
    for given in file, _read(file), polars.DataFrame(_read(file)):
        _assert_same(koseki.locate(given, filter="fixed"), _read(out))


def test_figures_equal_those_of_the_command_line(case, tmp_path):
    truth, files, fused = case / "truth.csv", sorted(case.glob("sensor_tracks_*.csv")), tmp_path / "fused.csv"
    _run(["fuse", "--tracks", *files, "--refresh", "1", "--out", fused])
    expected = json.loads(_run(["score", "--json", "--truth", truth, "--tracks", fused, "--gate", "200"]))
    assert koseki.score(truth, fused, gate=200) == koseki.score(_read(truth), _read(fused), gate=200) == expected
    judged = ["--standard", "ed-142,esassp", "--reference", "smoothed"]
    expected = json.loads(_run(["score", "--json", "--truth", truth, "--tracks", fused, *judged]))
    assert koseki.score(_read(truth), _read(fused), standard="ed-142,esassp", reference="smoothed") == expected
    rules = json.loads(_run(["compare", "--json", "--tracks", *files, "--truth", truth]))["rules"]
    found = koseki.compare([_read(file) for file in files], truth=_read(truth))["rules"]
    for rule in rules + found:
        del rule["us_per_report"]
    assert found == rules and len(rules) > 3


def test_what_a_command_refuses_is_a_value_error(case):
    table = _read(case / "sensor_tracks_1.csv")
    with pytest.raises(ValueError, match="^tracks: header: column"):
        koseki.fuse({"time_s": [0.0]})
    with pytest.raises(ValueError, match="nonsense"):
        koseki.fuse(table, rule="nonsense")
    with pytest.raises(ValueError, match="between 0.001 and 3600"):
        koseki.fuse(table, refresh=0.0001)
    with pytest.raises(ValueError, match="^config:2: fusion.nonsense: unknown key"):
        koseki.fuse(table, config="[fusion]\nnonsense = 1\n")
    with pytest.raises(ValueError, match="nothing.csv: cannot be read"):
        koseki.fuse("nothing.csv")
    with pytest.raises(ValueError, match=r"tracks: column x has 1 values, time_s has"):
        koseki.fuse(table | {"x": [0.0]})
    with pytest.raises(ValueError, match=r"tracks\[1\]: line 3, column state: \"a,b\" holds a comma"):
        koseki.fuse([table, table | {"state": ["confirmed", "a,b"] + ["confirmed"] * (len(table["x"]) - 2)}])


def test_rows_that_are_left_out_are_a_warning_with_their_line(case):
    table = _read(case / "sensor_tracks_1.csv")
    table["x"][3] = np.inf
    with pytest.warns(UserWarning, match="^1 rows left out: tracks: line 5, column x"):
        assert koseki.fuse(table).summary["rows_refused"] == 1


def _many_reports(case) -> dict[str, np.ndarray]:
    """Reports for seconds of work."""
    table = _read(case / "sensor_tracks_1.csv")
    shifts = np.repeat(25.0 * np.arange(200), len(table["time_s"]))
    many = {name: np.tile(column, 200) for name, column in table.items()}
    return many | {"time_s": many["time_s"] + shifts}


def test_progress_is_told_and_may_end_the_command(case):
    table, shares = _many_reports(case), []
    koseki.fuse(table, progress=shares.append)
    assert shares[-1] == 1.0 and all(0.0 <= share <= 1.0 for share in shares)

    def end(share):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        koseki.fuse(table, progress=end)


def test_other_threads_run_meanwhile_and_ctrl_c_ends_the_command(case):
    table, turns, interrupted = _many_reports(case), 0, threading.Event()
    # Whoever runs this in the background of a shell has it ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)

    def count():
        nonlocal turns
        while not interrupted.is_set():
            turns += 1
            if turns == 20:
                os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.005)

    thread = threading.Thread(target=count)
    with pytest.raises(KeyboardInterrupt):
        thread.start()
        while True:
            koseki.fuse(table)
    interrupted.set()
    thread.join()
    signal.signal(signal.SIGINT, before)


def _chunks(octets: bytearray) -> list[tuple[int, int]]:
    """Start and length of each chunk of an MCAP file. Indexes lie between chunks, and a wrong bit in them costs nothing."""
    place, chunks = 8, []
    while place + 9 <= len(octets) - 8:
        code, length = octets[place], int.from_bytes(octets[place + 1 : place + 9], "little")
        place += 9
        if code == 6:
            chunks.append((place, length))
        place += length
    return chunks


def test_a_recording_of_all_topics_has_what_was_published(tmp_path):
    options = ["--for", "3", "--instance", "recorded", "--set", 'recorder.format=["mcap", "csv"]', "--set", "recorder.enabled=true"]
    _run(["demo", "--out", tmp_path, *options])
    states = [koseki.read(file)["system/tracks"] for file in sorted(tmp_path.glob("latest/*.mcap"))]
    states = np.concatenate(states)
    assert len(states) == len(_read(tmp_path / "latest/system_tracks.csv")["time_s"]) > 0
    np.testing.assert_array_equal(states["sequence"], np.arange(len(states)))
    with pytest.raises(ValueError):
        koseki.read(__file__)
    with pytest.raises(FileNotFoundError):
        koseki.read(tmp_path / "nothing.mcap")
    # A wrong bit costs the chunk that it is in.
    octets = bytearray(max(tmp_path.glob("latest/*.mcap"), key=lambda file: file.stat().st_size).read_bytes())
    start, length = max(_chunks(octets), key=lambda chunk: chunk[1])
    octets[start + length // 2] ^= 1
    (tmp_path / "damaged.mcap").write_bytes(octets)
    with pytest.warns(UserWarning, match=r"damaged\.mcap: damaged parts skipped: 1 \(\d+ bytes\)"):
        assert len(koseki.read(tmp_path / "damaged.mcap")["system/tracks"]) < len(states)


RECORDINGS = sorted((TOP / "examples/data").glob("*.ast"))


@pytest.mark.parametrize("recording", RECORDINGS, ids=lambda path: path.stem)
def test_records_of_a_recording_are_those_of_the_command_line(recording):
    lines = _run(["decode", recording, "--out", "-"]).splitlines()
    records = list(koseki.decode(recording))
    assert records == [json.loads(line) for line in lines] and len(records) > 10


@pytest.mark.parametrize("recording", RECORDINGS, ids=lambda path: path.stem)
def test_columns_of_a_recording_have_what_its_records_have(recording):
    def leaves(group, path=""):
        for name, value in group.items():
            yield from leaves(value, f"{path}{name}.") if isinstance(value, dict) else [(path + name, value)]

    tables, records = koseki.decode_columns(recording), list(koseki.decode(recording))
    assert sorted(tables) == sorted({record["_c"] for record in records})
    for category, table in tables.items():
        of_category = [record for record in records if record["_c"] == category]
        rows = [{name: value for name, value in leaves(record) if name != "_c"} for record in of_category]
        assert set(table) == {name for row in rows for name in row}
        for name, column in table.items():
            absent = np.nan if column.dtype == np.float64 else None
            expected = np.empty(len(rows), column.dtype)
            expected[:] = [row.get(name, absent) for row in rows]
            np.testing.assert_array_equal(column, expected, err_msg=name)
        assert pyarrow.table(table).num_rows == len(rows)


def test_editions_are_chosen_and_refused():
    assert not koseki.decode_columns(RECORDINGS[0], editions={48: "1.31"}).keys() ^ koseki.decode_columns(RECORDINGS[0]).keys()
    with pytest.raises(ValueError, match="there are"):
        koseki.decode(RECORDINGS[0], editions={48: "9.9"})
    with pytest.raises(FileNotFoundError):
        koseki.decode_columns("nothing.ast")


def test_a_file_of_another_kind_is_named(tmp_path):
    for text, kind in [("MSG,3,1,1,500001,1,,,,,,1000,,,41.4,2.1,,,,,,0\n" * 40, "SBS"), ('{"a": 1}\n', "JSON"), ("", "empty")]:
        path = tmp_path / "other"
        path.write_text(text)
        for decode in [koseki.decode, koseki.decode_columns]:
            with pytest.raises(ValueError, match=f"other: no record of ASTERIX can be read: .*{kind}"):
                decode(path)


def test_a_decoding_that_is_given_up_ends():
    before = len(os.listdir("/proc/self/task"))
    records = koseki.decode(max(RECORDINGS, key=lambda path: path.stat().st_size))
    next(records)
    del records
    end = time.monotonic() + PATIENCE
    while len(os.listdir("/proc/self/task")) > before:
        assert time.monotonic() < end

"""The package beside a live demonstration, and its offline functions against the command line."""

import asyncio
import gc
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pandas
import pyarrow
import pytest

import koseki
from koseki.offline import _executable, _read

TOP = Path(__file__).parents[2]
PATIENCE = 60.0


class Deployment:
    """A deployment of the command line in a folder of its own."""

    def __init__(self, *arguments: object) -> None:
        command = [_executable(), *map(str, arguments)]
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
    status = json.loads(koseki.offline._run(["status", "--instance", demo, "--json"]))
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


def test_a_data_frame_has_a_column_a_number(demo):
    frame = koseki.subscribe(demo).to_dataframe(2.0)
    assert len(frame) > 0 and frame["position_m_0"].dtype == np.float64
    assert {"stages.fused_ns", "identity.callsign", "contributions_0.weight"} <= set(frame.columns)


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
    # A reader that takes nothing loses what its topic has no room for, and is told.
    slow = koseki.subscribe("feed", "sensor/own/tracks")
    publisher.send(report)
    assert slow.receive(PATIENCE).lost == 0
    for _ in range(300):
        publisher.send(report)
    assert slow.receive(PATIENCE).lost == 300 - 256
    assert slow.counts.lost == 300 - 256
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


def test_fusing_tables_equals_the_command_line(tmp_path):
    world = koseki.simulate(seconds=20)
    folder, out = tmp_path / "case", tmp_path / "fused.csv"
    koseki.offline._run(["simulate", "--scenario", "demo", "--for", "20", "--out", folder])
    files = sorted(folder.glob("sensor_tracks_*.csv"))
    koseki.offline._run(["fuse", "--tracks", *files, "--out", out])
    expected = _read(out)
    assert len(expected["time_s"]) > 100
    for tables in (files, [pandas.DataFrame(world[file.stem]) for file in files], [world[file.stem] for file in files]):
        fused = koseki.fuse(tables)
        assert list(fused) == list(expected)
        for name, column in expected.items():
            np.testing.assert_array_equal(fused[name], column, err_msg=name)
    assert koseki.score(world["truth"], fused)
    assert koseki.compare(files, truth=world["truth"])


def test_what_a_command_refuses_is_a_value_error():
    with pytest.raises(ValueError, match="column"):
        koseki.fuse({"time_s": [0.0]})
    with pytest.raises(ValueError, match="nonsense"):
        koseki.fuse({"time_s": [0.0]}, rule="nonsense")


def test_a_recording_of_all_topics_has_what_was_published(tmp_path):
    options = ["--for", "3", "--instance", "recorded", "--set", 'recorder.format=["mcap", "csv"]', "--set", "recorder.enabled=true"]
    koseki.offline._run(["demo", "--out", tmp_path, *options])
    states = [koseki.read(file)["system/tracks"] for file in sorted(tmp_path.glob("latest/*.mcap"))]
    states = np.concatenate(states)
    assert len(states) == len(_read(tmp_path / "latest/system_tracks.csv")["time_s"]) > 0
    np.testing.assert_array_equal(states["sequence"], np.arange(len(states)))
    with pytest.raises(ValueError):
        koseki.read(__file__)
    with pytest.raises(FileNotFoundError):
        koseki.read(tmp_path / "nothing.mcap")


RECORDINGS = sorted((TOP / "examples/data").glob("*.ast"))


@pytest.mark.parametrize("recording", RECORDINGS, ids=lambda path: path.stem)
def test_records_of_a_recording_are_those_of_the_command_line(recording):
    lines = koseki.offline._run(["decode", recording, "--out", "-"]).splitlines()
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


def test_a_decoding_that_is_given_up_ends():
    before = len(os.listdir("/proc/self/task"))
    records = koseki.decode(max(RECORDINGS, key=lambda path: path.stat().st_size))
    next(records)
    del records
    end = time.monotonic() + PATIENCE
    while len(os.listdir("/proc/self/task")) > before:
        assert time.monotonic() < end

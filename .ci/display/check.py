#!/usr/bin/env python3
"""Drives the real page of `koseki demo` in headless Chromium without WebGL, as a person would, and compares what it
shows with what the recorder wrote. Then the same page shows that recording.

    .ci/display/check.py KOSEKI FOLDER [--picture docs/display.png]

FOLDER gets the recording and the screenshots. Needs Debian's `chromium` and PyPI's `playwright`.
"""

import argparse
import csv
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import time

import check_labels
from playwright.sync_api import sync_playwright

from engineer import drive_engineer, drive_guest, overlay_of

PATIENCE_S = 30
# Longest time from a measurement to the publication of its state: a tracker confirms a target by several turns.
LATE_S = 4

# Luminance (WCAG 2) of the brightest pixel of the canvas of tracks, over the ground below it.
BRIGHTEST = """() => {
  const [ground, tracks] = ["ground", "tracks"].map((id) => document.getElementById(id));
  const both = new OffscreenCanvas(tracks.width, tracks.height).getContext("2d");
  both.drawImage(tracks, 0, 0);
  const cover = both.getImageData(0, 0, tracks.width, tracks.height).data;
  both.globalCompositeOperation = "destination-over";
  both.drawImage(ground, 0, 0);
  const data = both.getImageData(0, 0, tracks.width, tracks.height).data;
  const linear = (v) => ((v /= 255) <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
  let most = 0, drawn = 0;
  for (let k = 0; k < data.length; k += 4) {
    if (cover[k + 3] === 0) continue;
    drawn++;
    most = Math.max(most, 0.2126 * linear(data[k]) + 0.7152 * linear(data[k + 1]) + 0.0722 * linear(data[k + 2]));
  }
  return { most, drawn };
}"""

# How much wider than its panel what the panel holds is, and the text of the innermost element that is too wide.
WIDTH = """() => {
  const panel = document.getElementById("panel");
  const over = Math.max(...[panel, document.body].map((e) => e.scrollWidth - e.clientWidth));
  const edge = panel.getBoundingClientRect().left + panel.clientWidth + 0.5;
  const out = [...panel.querySelectorAll("*")].filter(
    (e) => e.getBoundingClientRect().right > edge || e.scrollWidth > e.clientWidth + 1);
  return [over, out.at(-1)?.textContent.slice(0, 200) ?? ""];
}"""

# The same of an alarm that stands, and of one of the past, whose words are all longer than the panel is wide.
WIDTH_OF_LONG_ALARMS = f"""() => {{
  const {{ known, alarms }} = koseki;
  const text = "/sys/fs/cgroup/" + "a".repeat(105);
  const source = {{ ...known.sources[0], name: text }};
  const alarm = {{ id: 1, code: 1, severity: "warning", text, remedy: text, process: text, source: source.number,
    raised: 0, times: 1 }};
  const past = {{ event: "acknowledged", severity: "warning", time_s: 0, operator: text, text }};
  const held = [known.alarms, known.sources, alarms.past];
  [known.alarms, known.sources, alarms.past] = [[alarm], [source], [past]];
  alarms.show(document.getElementById("panel"));
  const wide = ({WIDTH})();
  [known.alarms, known.sources, alarms.past] = held;
  return wide;
}}"""

# What the page knows of its selected track at one instant.
SELECTED = """() => {
  const number = [...koseki.selected][0];
  const facts = koseki.facts.get(number);
  return facts && {
    number,
    stateTime: facts.stateTime,
    shares: koseki.shares.get(number).map(({ source, track, weight, accuracy }) =>
      ({ source, track, weight, accuracy: Number.isFinite(accuracy) ? accuracy : null })),
  };
}"""

TRACKS = """() => [...koseki.picture.system.values()].map(({ number, time, east, north, state }) =>
  ({ number, time, east, north, state }))"""


def until(page, expression, argument=None):
    """Waits until a JavaScript expression holds. Playwright's own way of waiting evaluates texts in the page, which its
    security policy forbids."""
    end = time.monotonic() + PATIENCE_S
    while not page.evaluate(expression, argument):
        if time.monotonic() > end:
            raise AssertionError(f"after {PATIENCE_S} s it still does not hold: {expression} {argument or ''}")
        time.sleep(0.1)


def check(holds, text):
    if not holds:
        raise AssertionError(text)
    print(f"  {text}")


class Recorded:
    """Rows of the recorder's system tracks by track number and time of day."""

    def __init__(self, path):
        self.rows = {}
        with open(path, newline="", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                self.rows.setdefault(int(row["system_track_id"]), []).append(row)

    def at(self, number, seconds):
        """Rows of a track at a time, seconds since 1970; the recording says the time of day."""
        day = seconds % 86400
        return [row for row in self.rows.get(number, []) if abs(float(row["time_s"]) - day) < 0.0015]

    def there(self, seconds):
        """Numbers of the tracks of which there was a state in the five seconds before the last LATE_S, and no end."""
        day = seconds % 86400
        there = set()
        for number, rows in self.rows.items():
            before = [row for row in rows if float(row["time_s"]) <= day - LATE_S]
            ended = any(row["state"] == "terminated" for row in rows if float(row["time_s"]) <= day + 1)
            if before and float(before[-1]["time_s"]) > day - LATE_S - 5 and not ended:
                there.add(number)
        return there


class Koseki:
    """A command that shows the picture, and what it prints."""

    def __init__(self, koseki, log, command):
        self.log = open(log, "w+", encoding="utf-8")
        self.process = subprocess.Popen([koseki, *command], stdout=self.log, stderr=subprocess.STDOUT)

    def address(self, but=""):
        """Address that it prints, except `but`."""
        end = time.monotonic() + 30
        while time.monotonic() < end:
            printed = pathlib.Path(self.log.name).read_text(encoding="utf-8")
            found = [each for each in re.findall(r"http://127\.0\.0\.1:\d+[^\s:,]*", printed) if each != but]
            if found:
                return found[0]
            if self.process.poll() is not None:
                break
            time.sleep(0.05)
        raise AssertionError("no address is printed: " + pathlib.Path(self.log.name).read_text()[-2000:])

    def stop(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        self.process.wait(timeout=60)
        self.log.close()


def check_width(page, what, measure=WIDTH):
    over, text = page.evaluate(measure)
    check(over <= 0, f"nothing is cut in the {what}" + (f": {over} pixels of {text!r}" if over > 0 else ""))


def drive(page, url, folder, demo):
    began = time.monotonic()
    page.goto(url)
    until(page, "globalThis.koseki?.picture.system.size >= 40")
    print(f"tracks on the map {time.monotonic() - began:.1f} s after the page was asked for")
    until(page, "koseki.ground.land.length > 0")

    print("the cursor's inverse formula against the projection in Rust")
    worst = page.evaluate("""async () => {
          const { placeOf } = await import("./geodesy.js");
          let worst = 0, count = 0;
          for (const { points } of [...koseki.ground.land, ...koseki.ground.borders])
            for (let k = 0; k < points.length; k += 2) {
              if (Math.hypot(points[k], points[k + 1]) > 1e6) continue;
              const place = placeOf(koseki.known.origin, points[k], points[k + 1]);
              // The file has whole steps of 0.0025 degrees; f32 metres and a sphere of a million metres spoil little.
              for (const degrees of [place.latitude_deg, place.longitude_deg]) {
                const steps = degrees / 0.0025;
                worst = Math.max(worst, Math.abs(steps - Math.round(steps)));
                count++;
              }
            }
          return [worst * 0.0025, count];
        }""")
    check(worst[1] > 1000 and worst[0] < 5e-6, f"{worst[1]} coordinates come back within {worst[0]:.1e} degrees")

    print("a track is clicked")
    # Let the picture settle: tracks confirmed, several sources each.
    until(
        page,
        "[...koseki.picture.system.values()].filter((t) => t.state === 'confirmed' && t.sourceCount >= 3).length >= 3",
    )
    page.wait_for_timeout(8000)
    # One that stands alone, so that the click is meant for it.
    spot = page.evaluate("""() => {
          const box = document.getElementById("tracks").getBoundingClientRect();
          const free = ({ track, x, y }) => track.sourceCount >= 3 && track.state === "confirmed" &&
            x > 60 && y > 60 && x < box.width - 60 && y < box.height - 80 &&
            koseki.painter.drawn.every((other) => other.track === track || Math.hypot(other.x - x, other.y - y) > 20);
          const found = koseki.painter.drawn.find(free);
          return found && { number: found.track.number, x: found.x + box.left, y: found.y + box.top };
        }""")
    check(spot is not None, "some track of three sources stands alone")
    page.mouse.click(spot["x"], spot["y"])
    until(page, "koseki.shares.size === 1")
    number = page.evaluate("[...koseki.selected][0]")
    check(number == spot["number"], f"system track {number} is selected")
    page.wait_for_selector("#panel tr[data-source]")
    seen = {}
    end = time.monotonic() + 6
    while time.monotonic() < end:
        said = page.evaluate(SELECTED)
        if said and said["shares"]:
            seen[said["stateTime"]] = said
        page.wait_for_timeout(100)
    check(len(seen) >= 5, f"its contributors were read at {len(seen)} instants")
    text = page.inner_text("#panel")
    check(
        all(title in text.upper() for title in ["CONTRIBUTORS", "HEIGHT", "WEIGHT OF EACH"]), "the panel has its parts"
    )

    print("labels and panels")
    said = page.evaluate(check_labels.LABELS)
    over = said["over"]
    check(said["labels"] + said["leftOut"] == said["tracks"], f"{said['leftOut']} of {said['tracks']} are left out")
    check(said["leftOut"] == 0, f"{said['labels']} tracks are labelled, {said['fanned']} of them in a fan")
    check(over["label"] == over["control"] == over["edge"] == 0, "no label lies on another, on a control, or off the map")
    page.evaluate("koseki.trackCanvas.focus()")
    page.keyboard.press("Control+ArrowUp")
    until(page, "koseki.painter.lettering.labels.some(({ wish }) => wish.spot.pinned)")
    page.keyboard.press("Control+Backspace")
    until(page, "koseki.painter.lettering.labels.every(({ wish }) => !wish.spot.pinned)")
    page.keyboard.press(".")
    texts = page.evaluate("(koseki.frame(), koseki.measure.notes.flatMap(({ texts }) => texts))")
    check("°T / " in texts[0], f"a measuring line of the selected track: {texts}")
    for tab in ["tracks", "track", "sources", "alarms", "latency", "system", "view"]:
        page.evaluate("tab => koseki.set({ tab })", tab)
        page.wait_for_timeout(700)
        check_width(page, f"panel {tab}")
    page.evaluate("koseki.set({ tab: 'alarms' })")
    until(page, "document.querySelector('#panel h2')?.textContent === 'Alarms'")
    check_width(page, "panel alarms with words of 120 letters", WIDTH_OF_LONG_ALARMS)
    page.evaluate("koseki.measure = null")

    print("sensor tracks are switched on")
    page.keyboard.press("Alt+c")
    page.evaluate("koseki.set({ labels: 0, trails: false, vector: 0 })")
    page.wait_for_timeout(400)
    bright = page.evaluate(BRIGHTEST)
    page.keyboard.press("Alt+n")
    until(page, "koseki.picture.sensor.size >= 40")
    page.evaluate("koseki.set({ filter: 'nothing-is-called-so' })")
    page.wait_for_timeout(400)
    dim = page.evaluate(BRIGHTEST)
    check(dim["drawn"] > 200, f"{dim['drawn']} pixels of sensor tracks")
    check(
        dim["most"] <= bright["most"] / 2,
        f"luminance {dim['most']:.3f} of sensor tracks, {bright['most']:.3f} of system tracks",
    )
    page.evaluate("koseki.set({ filter: '', sensors: false, labels: 2, trails: true, vector: 60 })")

    print("pause, scrub, resume")
    page.keyboard.press(" ")
    until(page, "document.getElementById('mode').textContent === 'PAUSED'")
    page.wait_for_timeout(800)
    held = page.evaluate("koseki.picture.time")
    page.wait_for_timeout(1500)
    check(page.evaluate("koseki.picture.time") == held, "time stands still")
    past = [page.evaluate(TRACKS)]
    for _ in range(4):
        page.keyboard.press("Shift+ArrowLeft")
    until(page, "held => koseki.picture.time < held - 3", argument=held)
    page.wait_for_timeout(300)
    past.append(page.evaluate(TRACKS))
    scrub = page.locator("#scrub")
    earliest = float(scrub.get_attribute("min"))
    scrub.evaluate(
        "(bar, at) => { bar.value = at; bar.dispatchEvent(new Event('input')); }", max(earliest, int(held) - 8)
    )
    until(page, "held => koseki.picture.time < held - 5", argument=held)
    page.wait_for_timeout(300)
    past.append(page.evaluate(TRACKS))
    ringed = page.evaluate("[...koseki.picture.system.values()].filter(({ handOver }) => handOver > 0).length")
    check(ringed == 0, "a leap through time is no hand-over")
    scrubbed = page.evaluate("koseki.picture.time")
    page.keyboard.press(" ")
    until(page, "then => koseki.picture.time > then + 1", argument=scrubbed)
    check("PLAY" in page.inner_text("#mode"), "the past is played")
    page.keyboard.press("Home")
    until(page, "held => koseki.picture.time > held", argument=held)
    check(page.inner_text("#mode") == "LIVE", "back to live")

    print("filters, address, keyboard")
    page.keyboard.press("/")
    page.keyboard.type("fl>50 sources>1")
    page.keyboard.press("Enter")
    page.wait_for_timeout(500)
    drawn = page.evaluate("koseki.painter.drawn.map(({ track }) => [track.height, track.sourceCount])")
    whole = page.evaluate("koseki.picture.system.size")
    check(
        0 < len(drawn) < whole and all(height > 50 * 30.48 and n > 1 for height, n in drawn),
        f"{len(drawn)} of {whole} tracks pass",
    )
    for key in ["Alt+o", "Alt+q", "]", "Alt+d"]:
        page.keyboard.press(key)
    page.wait_for_timeout(700)
    address = page.url
    check(
        "fl%3E50" in address and "labels=3" in address and "up=" in address,
        f"the address says it: {address.split('#')[1]}",
    )
    before = page.evaluate("JSON.stringify([koseki.settings, koseki.view.up])")
    other = page.context.browser.new_page(viewport=page.viewport_size)
    other.goto(address)
    until(other, "globalThis.koseki?.picture.system.size >= 20")
    other.wait_for_timeout(600)
    check(other.evaluate("JSON.stringify([koseki.settings, koseki.view.up])") == before, "another page shows the same")
    other.close()
    page.keyboard.press("?")
    check("range rings" in page.inner_text("#help"), "help")
    page.keyboard.press("Escape")
    page.evaluate("koseki.set({ filter: '', labels: 2, up: 0 })")

    print("fusion is killed")
    page.evaluate("koseki.set({ tab: 'system' })")
    until(page, "koseki.known.processes.some((p) => p.kind === 'fusion' && p.pid > 0)")
    pid = page.evaluate("koseki.known.processes.find((p) => p.kind === 'fusion').pid")
    page.evaluate("""() => {
          globalThis.said = [];
          const banner = document.getElementById("banner");
          const note = () => said.push(banner.hidden ? "" : banner.textContent);
          new MutationObserver(note).observe(banner, { attributes: true, childList: true });
        }""")
    killed = page.evaluate("koseki.picture.time")
    os.kill(int(pid), signal.SIGKILL)
    until(
        page,
        "pid => koseki.known.processes.some((p) => p.kind === 'fusion' && (p.restarts > 0 || p.pid !== pid))",
        argument=pid,
    )
    until(
        page,
        "then => [...koseki.picture.system.values()].filter((t) => t.time > then + 5).length >= 20 && "
        "document.getElementById('banner').hidden",
        argument=killed,
    )
    said = [text for text in page.evaluate("said") if text]
    print(f"  banner while it was away: {said[0] if said else 'none: it was back before a second had passed'}")
    check("restart" in page.inner_text("#pills"), "the page tells of the restart, and goes on without a reload")
    kept = """then => [...koseki.picture.system.values()].filter(({ trail }) =>
      trail.length > 0 && trail.timeOf(trail.at(0)) < then - 20).length >= 20"""
    check(page.evaluate(kept, killed), "trails go on over the restart")
    later = page.context.browser.new_page()
    later.goto(url)
    until(later, f"then => globalThis.koseki && ({kept})(then)", argument=killed)
    later.close()
    check(True, "and in a page that is opened after it")
    return seen, past, killed


def drive_recording(page, url):
    """Moments of a recording, as the page shows them: ahead, back, the end, and after a reload."""
    print("the recording in the same page")
    page.goto(url)
    until(page, "globalThis.koseki?.picture.system.size >= 20")
    check("recording" in page.inner_text("#instance"), "it says that it is a recording")
    began = page.evaluate("koseki.picture.time")
    until(page, "began => koseki.picture.time > began + 1", argument=began)
    check("PLAY" in page.inner_text("#mode"), "it is played")
    page.keyboard.press(" ")
    until(page, "document.getElementById('mode').textContent === 'PAUSED'")
    first, last = page.evaluate("[koseki.historyFrom, koseki.liveTime]")
    check(last - first > 20, f"{last - first:.0f} s can be seen")
    past = []
    for part in [0.5, 0.9, 0.3]:
        at = int(first + part * (last - first))
        page.locator("#scrub").evaluate(
            "(bar, at) => { bar.value = at; bar.dispatchEvent(new Event('input')); }", at
        )
        until(page, "at => Math.abs(koseki.picture.time - at) < 0.001", argument=at)
        past.append((at, page.evaluate(TRACKS)))
    page.wait_for_timeout(400)
    page.reload()
    until(page, "at => Math.abs((globalThis.koseki?.picture.time ?? 0) - at) < 0.001", argument=at)
    past.append((at, page.evaluate(TRACKS)))
    check(len(past[-1][1]) == len(past[-2][1]), "the address has the moment")
    longest = """() => Math.max(...[...koseki.picture.system.values()].map(({ trail }) =>
      trail.length > 0 ? koseki.picture.time - trail.timeOf(trail.at(0)) : 0))"""
    until(page, f"whole => ({longest})() > whole", argument=min(500, (at - first) / 2))
    check(True, f"trails begin {page.evaluate(longest):.0f} s before the moment")
    other = page.context.browser.new_page()
    other.goto(f"{url}#at={at + 5}&speed=0")
    until(other, "at => Math.abs((globalThis.koseki?.picture.time ?? 0) - at) < 0.001", argument=at + 5)
    page.wait_for_timeout(400)
    check(page.evaluate("koseki.picture.time") == at, "another window has another moment")
    other.close()
    page.keyboard.press(" ")
    until(page, "at => koseki.picture.time > at + 1", argument=at)
    page.keyboard.press("Home")
    until(page, "last => Math.abs(koseki.picture.time - last) < 0.001", argument=last)
    past.append((last, page.evaluate(TRACKS)))
    check(page.inner_text("#mode") == "PAUSED", "at its end it stands still")
    return past


def compare_recording(recorded, past, killed):
    """The pictures have exactly the tracks of the table, each in its latest state."""
    compare(recorded, {}, [tracks for _, tracks in past])
    for at, tracks in past:
        # A fusion that goes on from another one's tracks shows each when it is heard of again.
        if killed - 1 < at < killed + 10:
            continue
        shown = {track["number"] for track in tracks}
        there = recorded.there(at)
        check(there <= shown, f"{len(shown)} tracks are shown, among them the {len(there)} that were heard of lately")


def compare(recorded, seen, past):
    print("what the page showed, against the recording")
    shares = 0
    for said in seen.values():
        rows = recorded.at(said["number"], int(said["stateTime"]) / 1e9)
        check_row = [row for row in rows if same_shares(row, said["shares"])]
        if not check_row:
            raise AssertionError(f"shown {said}\nrecorded {[dict(r, **{}) for r in rows]}")
        shares += len(said["shares"])
    check(shares > 0 or not seen, f"contributors, weights and accuracy values of {len(seen)} instants are recorded ones")
    states = missing = 0
    for picture in past:
        for track in picture:
            rows = recorded.at(track["number"], track["time"])
            near = [
                r
                for r in rows
                if abs(float(r["x"]) - track["east"]) < 0.05 and abs(float(r["y"]) - track["north"]) < 0.05
            ]
            states += bool(near)
            missing += not near
    check(missing == 0 and states > 0, f"{states} states of {len(past)} paused pictures are recorded ones")


def same_shares(row, shares):
    if row["sources"] == "":
        return not shares
    sources, weights, accuracy = (listed_fields(row[key]) for key in ("sources", "weights", "lambda"))
    tracks = listed_fields(row["sensor_track_ids"])
    # Files number the sources from 1.
    if [int(s) - 1 for s in sources] != [share["source"] for share in shares]:
        return False
    for k, share in enumerate(shares):
        if abs(float(weights[k]) - share["weight"]) > 6e-5 or int(tracks[k]) != share["track"]:
            return False
        if (accuracy[k] == "") != (share["accuracy"] is None):
            return False
        if accuracy[k] != "" and abs(float(accuracy[k]) - share["accuracy"]) > 1e-3 * max(1.0, abs(share["accuracy"])):
            return False
    return True


def listed_fields(text):
    return text.split("|")


def pictures(page, url, folder, target, metres):
    """A screenshot of somebody at work: a track selected, sensor tracks beneath, so many metres a pixel."""
    page.goto(url)
    until(page, "globalThis.koseki?.ground.land.length > 0 && koseki.picture.system.size >= 40")
    page.wait_for_timeout(3000)
    page.evaluate(
        """(metres) => {
          const flying = [...koseki.picture.system.values()].filter((t) => t.state === "confirmed" && !t.onGround);
          const crowd = (t) => flying.filter((o) => Math.hypot(o.east - t.east, o.north - t.north) < 250 * metres).length;
          const chosen = flying.sort((a, b) => b.sourceCount - a.sourceCount || crowd(b) - crowd(a))[0];
          koseki.select(chosen.number);
          koseki.moved(() => Object.assign(koseki.view, { east: chosen.east, north: chosen.north, scale: metres }));
          koseki.set({ sensors: true, trail: 300, tab: "track" });
        }""",
        metres,
    )
    page.wait_for_timeout(9000)
    over = page.evaluate(check_labels.LABELS)["over"]
    check(over["label"] == 0, f"{target}: no label lies on another")
    page.screenshot(path=folder / target)


def watch(page, errors):
    """Collects what the page complains of, and what it asks other machines for."""
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
    page.on("request", lambda r: errors.append(f"asks for {r.url}") if "127.0.0.1" not in r.url else None)


def main():
    options = argparse.ArgumentParser()
    options.add_argument("koseki")
    options.add_argument("folder", type=pathlib.Path)
    options.add_argument("--picture", type=pathlib.Path)
    given = options.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    records = given.folder / "records"
    recorder = ["--set", "recorder.enabled=true", "--set", 'recorder.format=["csv", "mcap"]']
    maps = ["--set", f'display.overlays=["{overlay_of(given.folder)}"]', "--set", "display.declination_deg=1.5"]
    command = ["demo", "--instance", "ci-display", "--out", records, *recorder, *maps]
    demo = Koseki(given.koseki, given.folder / "demo.txt", command)
    player = guest = None
    try:
        url = demo.address()
        print(url)
        with sync_playwright() as play:
            browser = play.chromium.launch(
                executable_path="/usr/bin/chromium",
                args=["--no-sandbox", "--disable-gpu", "--disable-software-rasterizer"],
            )
            errors = []
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            watch(page, errors)
            check(page.evaluate("!document.createElement('canvas').getContext('webgl')"), "this browser has no WebGL")
            # Before fusion is killed: the picture of the README has no alarm.
            pictures(page, url, given.folder, "1280x800.png", 75)
            calm = page.evaluate("koseki.known.alarms.every(({ cleared }) => cleared)")
            page.close()
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            watch(page, errors)
            seen, past, killed = drive(page, url, given.folder, demo)
            began = time.monotonic()
            page.close()
            large = browser.new_page(viewport={"width": 1920, "height": 1080}, device_scale_factor=2)
            pictures(large, url, given.folder, "3840x2160.png", 60)
            large.close()
            drive_engineer(browser, url, given.folder, began, until, check)
            guest = Koseki(given.koseki, given.folder / "guest.txt", ["display", "--instance", "ci-display"])
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            page.on("pageerror", lambda error: errors.append(str(error)))
            drive_guest(page, guest.address(), until, check)
            page.close()
            demo.stop()
            check(guest.process.wait(timeout=30) == 0, "a display without the file ends with the instance")
            player = Koseki(given.koseki, given.folder / "recording.txt", ["display", "--recording", records / "latest"])
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            page.on("pageerror", lambda error: errors.append(str(error)))
            replayed = drive_recording(page, player.address())
            page.screenshot(path=given.folder / "recording.png")
            browser.close()
        if errors:
            raise AssertionError("the page complains: " + json.dumps(errors[:5]))
    finally:
        demo.stop()
        for other in filter(None, [guest, player]):
            other.stop()
    recorded = Recorded(records / "latest" / "system_tracks.csv")
    compare(recorded, seen, past)
    compare_recording(recorded, replayed, killed)
    if given.picture:
        check(calm, "the README's picture has no alarm")
        given.picture.write_bytes((given.folder / "1280x800.png").read_bytes())
        check(given.picture.stat().st_size <= 400_000, "the README's picture is small")


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Checks labels of the page, fed by synthetic.js, under a clock that the test turns on: nothing depends on speed.

    .ci/display/check_labels.py [--tracks 200] [--turning] [--size 1920x1080] [--screenshot FILE]

Prints shares of labels, and checks those of the default: every track has a label, at most 1 % of the labels overlap
another label, a symbol or a speed vector, at most 0.5 % move in a second.
"""

import argparse
import functools
import http.server
import sys
import threading

from measure import PAGE, Handler
from playwright.sync_api import sync_playwright

SECONDS = 60

# Labels of the picture, and how many of them lie over another label, a symbol, a speed vector or a control.
LABELS = """async () => {
  const { overlap } = await import("./placement.js");
  const { controlsOn } = await import("./nudge.js");
  const { painter, view, settings, map } = koseki;
  const labels = painter.lettering.labels;
  const inView = painter.drawn.filter(({ x, y }) => x >= 0 && y >= 0 && x <= view.width && y <= view.height);
  const m = view.matrix();
  const controls = controlsOn(map);
  const point = (x, y, side) => ({ left: x - side / 2, top: y - side / 2, width: side, height: side });
  const vector = ({ track, x, y }) => {
    const dx = settings.vector * (m.a * track.speedEast + m.c * track.speedNorth);
    const dy = settings.vector * (m.b * track.speedEast + m.d * track.speedNorth);
    return Array.from({ length: 41 }, (_, k) => point(x + (k * dx) / 40, y + (k * dy) / 40, 0.1));
  };
  const vectors = inView.map(vector);
  const over = { label: 0, symbol: 0, vector: 0, control: 0, edge: 0 };
  for (const label of labels) {
    over.label += labels.some((other) => other !== label && overlap(label, other));
    over.symbol += inView.some(({ x, y }) => overlap(label, point(x, y, 10)));
    over.vector += vectors.some((points) => points.some((one) => overlap(label, one)));
    over.control += controls.some((box) => overlap(label, box));
    over.edge += label.left < 0 || label.top < 0 ||
      label.left + label.width > view.width || label.top + label.height > view.height;
  }
  const places = labels.map(({ track, wish, lines }) => [track.number, `${wish.spot.place} ${lines}`]);
  const whole = labels.filter(({ lines }) => lines === settings.labels).length;
  const fanned = labels.filter(({ wish }) => wish.members).length;
  return { tracks: inView.length, labels: labels.length, whole, over, places, fanned,
    leftOut: painter.lettering.leftOut };
}"""


class Counts:
    """Sums over seconds."""

    def __init__(self):
        self.tracks = self.labels = self.whole = self.fanned = self.compared = self.moved = 0
        self.over = {}
        self.before = {}

    def add(self, said):
        if said["tracks"] != said["labels"] + said["leftOut"]:
            raise AssertionError(f"{said['leftOut']} are said to be left out: {said}")
        self.tracks += said["tracks"]
        self.labels += said["labels"]
        self.whole += said["whole"]
        self.fanned += said["fanned"]
        for kind, count in said["over"].items():
            self.over[kind] = self.over.get(kind, 0) + count
        places = dict(map(tuple, said["places"]))
        both = places.keys() & self.before.keys()
        self.compared += len(both)
        self.moved += sum(places[number] != self.before[number] for number in both)
        self.before = places

    def shares(self):
        return {
            "labelled": self.labels / self.tracks,
            "whole": self.whole / self.tracks,
            "in a fan": self.fanned / self.tracks,
            **{f"over a {kind}": count / self.labels for kind, count in self.over.items()},
            "moved in a second": self.moved / max(1, self.compared),
        }


def main():
    options = argparse.ArgumentParser()
    options.add_argument("--tracks", type=int, default=200)
    options.add_argument("--turning", action="store_true")
    options.add_argument("--size", default="1920x1080")
    options.add_argument("--screenshot")
    given = options.parse_args()
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Handler, directory=PAGE))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    width, height = map(int, given.size.split("x"))
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path="/usr/bin/chromium", args=["--no-sandbox", "--disable-gpu"])
        page = browser.new_page(viewport={"width": width, "height": height})
        errors = []
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.clock.install(time=1_700_000_000)
        page.goto(f"http://127.0.0.1:{server.server_port}/?tracks={given.tracks}{'' if given.turning else '&straight'}")
        page.clock.run_for(5000)
        counts = Counts()
        for _ in range(SECONDS):
            page.clock.run_for(1000)
            counts.add(page.evaluate(LABELS))
        if given.screenshot:
            page.screenshot(path=given.screenshot)
        browser.close()
    shares = counts.shares()
    print(f"{given.tracks} tracks, {given.size}: " + ", ".join(f"{100 * v:.2f} % {k}" for k, v in shares.items()))
    if errors:
        raise AssertionError(f"the page complains: {errors[:5]}")
    if given.tracks > 200 or given.turning:
        return
    over = [value for key, value in shares.items() if key.startswith("over")]
    if shares["labelled"] < 1 or max(over) > 0.01 or shares["moved in a second"] > 0.005:
        raise AssertionError("labels are worse than they have to be")


if __name__ == "__main__":
    sys.exit(main())

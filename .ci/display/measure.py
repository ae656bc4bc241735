#!/usr/bin/env python3
"""Measures the page: pictures a second, time a picture and memory, in Chromium without WebGL.

    .ci/display/measure.py [--tracks 5000] [--seconds 20] [--hash "labels=3&declutter=0"] [--screenshot FILE]
    .ci/display/measure.py --url http://127.0.0.1:8900/

Without an address it is fed by synthetic.js, which needs no server. `declutter=0` has every label drawn.
"""

import argparse
import functools
import http.server
import os
import pathlib
import threading
import time

from playwright.sync_api import sync_playwright

HERE = pathlib.Path(__file__).resolve().parent
PAGE = HERE.parent.parent / "services/display/page"


def processor_seconds(marker):
    """Processor time of the browser's processes, which have the marker in their command line or a parent that has."""
    parents, times, marked = {}, {}, set()
    for entry in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            # The name in brackets may hold blanks.
            fields = (entry / "stat").read_text().rpartition(")")[2].split()
            command = (entry / "cmdline").read_bytes()
        except OSError:
            continue
        number = int(entry.name)
        parents[number] = int(fields[1])
        times[number] = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
        if marker.encode() in command:
            marked.add(number)

    def belongs(number):
        while number in parents:
            if number in marked:
                return True
            number = parents[number]
        return False

    return sum(seconds for number, seconds in times.items() if belongs(number))


class Handler(http.server.SimpleHTTPRequestHandler):
    def translate_path(self, path):
        return str(HERE / "synthetic.js") if path == "/main.js" else super().translate_path(path)

    def log_message(self, *_):
        pass


def main():
    options = argparse.ArgumentParser()
    options.add_argument("--tracks", type=int, default=5000)
    options.add_argument("--seconds", type=float, default=20)
    options.add_argument("--hash", default="labels=3&declutter=0")
    options.add_argument("--size", default="1600x900")
    options.add_argument("--ratio", type=float, default=1)
    options.add_argument("--select", type=int)
    options.add_argument("--screenshot")
    options.add_argument("--url")
    given = options.parse_args()
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Handler, directory=PAGE))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    width, height = map(int, given.size.split("x"))
    marker = f"--koseki-measure={os.getpid()}"
    with sync_playwright() as play:
        browser = play.chromium.launch(
            executable_path="/usr/bin/chromium",
            args=[
                "--no-sandbox",
                "--disable-gpu",
                "--disable-software-rasterizer",
                "--enable-precise-memory-info",
                marker,
            ],
        )
        page = browser.new_page(viewport={"width": width, "height": height}, device_scale_factor=given.ratio)
        page.on("console", lambda message: print("page:", message.text))
        page.on("pageerror", lambda error: print("page:", error))
        url = given.url or f"http://127.0.0.1:{server.server_port}/?tracks={given.tracks}"
        page.goto(f"{url}#{given.hash}")
        page.wait_for_timeout(2000)
        if given.select:
            page.evaluate("number => koseki.select(number)", given.select)
        page.wait_for_timeout(2000)
        spent = processor_seconds(marker)
        began, end = time.monotonic(), time.monotonic() + given.seconds
        first = page.evaluate("koseki.stats.frames")
        session = page.context.new_cdp_session(page)
        while time.monotonic() < end:
            time.sleep(min(60, max(0.1, end - time.monotonic())))
            session.send("HeapProfiler.collectGarbage")
            used = page.evaluate("performance.memory.usedJSHeapSize") / 1e6
            times = sorted(page.evaluate("koseki.stats.frameMs"))
            frames = page.evaluate("koseki.stats.frames") - first
            cost = 1000 * (processor_seconds(marker) - spent) / max(1, frames)
            print(
                f"{time.monotonic() - began:6.0f} s: {frames / (time.monotonic() - began):.2f} pictures/s, script "
                f"{times[len(times) // 2]:.1f} ms a picture (longest {times[-1]:.0f}), browser {cost:.0f} ms of "
                f"processors a picture, heap {used:.1f} MB",
                flush=True,
            )
        if given.screenshot:
            page.screenshot(path=given.screenshot)
        browser.close()


if __name__ == "__main__":
    main()

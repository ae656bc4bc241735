#!/usr/bin/env python3
"""Opens a feed of each kind in an empty folder, and waits for confirmed tracks in the browser.

usage: open_feeds.py KOSEKI FOLDER

Prints the time from a target's second position to the confirmed tracks of all targets on the page. Exit status 1 if it
is longer than 15 s.
"""
import os
import pathlib
import sys
import time

from playwright.sync_api import sync_playwright

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent))
from check import Koseki, check  # noqa: E402
import sent_feeds  # noqa: E402

ASKED_S = 15
CONFIRMED = """() =>
  [...(globalThis.koseki?.picture.system.values() ?? [])].filter(({ state }) => state === "confirmed").length"""

STATIONS = '() => [...koseki.picture.stations.values()]'


def main():
    koseki, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path='/usr/bin/chromium', args=['--no-sandbox'])
        for kind in (sent_feeds.Beast, sent_feeds.Ais, sent_feeds.Json):
            empty = folder / kind.__name__
            empty.mkdir(parents=True)
            feed = kind()
            opened = Koseki(koseki, folder / f'{kind.__name__}.log', ['open', feed.what, '--root', str(empty / 'root'), '--out', str(empty / 'out')])
            page = browser.new_page()
            page.goto(opened.address(feed.what))
            end = time.monotonic() + 60
            while time.monotonic() < end and page.evaluate(CONFIRMED) < 5:
                time.sleep(0.1)
            passed = time.monotonic() - feed.second_s
            check(passed <= ASKED_S, f'{feed.what}: five confirmed tracks {passed:.1f} s after the second positions')
            if isinstance(feed, sent_feeds.Ais):
                stations = {station['mmsi']: station for station in page.evaluate(STATIONS)}
                check(sorted(stations) == [2111111, 992111840, 992116841], f'{feed.what}: a base station and two aids, {stations}')
                check(stations[992111840]['isOff'] and stations[992116841]['isVirtual'] and stations[2111111]['isBase'],
                      f'{feed.what}: one aid is off its position, one virtual')
                for theme in ('night', 'day'):
                    page.evaluate(f'koseki.set({{theme: "{theme}"}})')
                    page.screenshot(path=str(empty / f'{theme}.png'))
            page.close()
            opened.stop()
        browser.close()


main()

#!/usr/bin/env python3
"""Works the page of `koseki demo` as an operator does, without a mouse: finds a track, filters, walks through the table,
acknowledges an alarm, gives orders, keeps a view; at three sizes of screen. axe-core judges every panel.

    .ci/display/operate.py KOSEKI FOLDER AXE

FOLDER gets the screenshots; AXE is the file axe.min.js of npm's axe-core. Needs what check.py needs.
"""

import argparse
import os
import pathlib
import signal
import sys

from check import Koseki, check, until
from playwright.sync_api import sync_playwright

TOKEN = "0perator-of-the-test"
TABS = ["tracks", "track", "sources", "alarms", "latency", "system", "view", ""]

# A confirmed track with a callsign that no other track's names contain, which does not lie in the middle.
LONELY = """(() => {
  const all = [...koseki.picture.system.values()];
  const names = (t) => `${t.callsign} ${t.code} ${t.address}`;
  const found = all.find((t) => t.state === "confirmed" && t.callsign &&
    all.filter((o) => names(o).includes(t.callsign)).length === 1);
  return found && { number: found.number, callsign: found.callsign };
})()"""

# Pixels between a track and the middle of the map; the track moves on between picture and question.
OFF_CENTRE = """number => {
  const track = koseki.picture.system.get(number);
  const [x, y] = koseki.view.toScreen(track.east, track.north);
  return Math.hypot(x - koseki.view.width / 2, y - koseki.view.height / 2);
}"""


class Page:
    """A page, its keyboard, and what went wrong on it."""

    def __init__(self, browser, url, size=(1280, 800), hash=""):
        self.errors = []
        self.page = browser.new_page(viewport={"width": size[0], "height": size[1]})
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.goto(url + hash)
        until(self.page, "globalThis.koseki?.picture.system.size >= 40")

    def press(self, *keys):
        for key in keys:
            self.page.keyboard.press(key)

    def focus(self):
        return self.page.evaluate(
            "[document.activeElement.id, document.activeElement.getAttribute('role'), document.activeElement.textContent.slice(0, 40)]"
        )

    def tab_to(self, expression, most=60):
        """Presses Tab until what has the focus is such: `element` in the expression."""
        for _ in range(most):
            self.press("Tab")
            if self.page.evaluate(f"(() => {{ const element = document.activeElement; return {expression}; }})()"):
                return
        raise AssertionError(f"{most} times Tab do not lead to: {expression}; the focus is at {self.focus()}")

    def close(self):
        check(not self.errors, "no error on the page" if not self.errors else f"errors: {self.errors[:3]}")
        self.page.close()


def fitted(own):
    print("a page that is opened early")
    page = own.page
    page.evaluate("koseki.view.show(0, 0, 10, 10)")
    until(page, "koseki.view.scale > 5")
    check(True, "the map shows the tracks that appear after it")
    page.evaluate("koseki.moved(() => koseki.view.show(0, 0, 10, 10))")
    until(page, "count => koseki.stats.pictures > count + 5", page.evaluate("koseki.stats.pictures"))
    check(page.evaluate("koseki.view.scale") < 5, "and leaves alone what somebody has moved")
    own.press("Alt+h")
    check(page.evaluate("koseki.view.scale") > 5, "a key shows all tracks again")


def find(own):
    print("a track is found by typing")
    page = own.page
    until(page, LONELY)
    lonely = page.evaluate(LONELY)
    number, callsign = lonely["number"], lonely["callsign"]
    page.keyboard.type(callsign.lower())
    check(page.evaluate("document.querySelectorAll('#found li').length") == 1, "one suggestion")
    own.press("Enter")
    check(page.evaluate("[...koseki.selected]") == [number], f"{len(callsign) + 1} keys select {callsign}")
    check(page.evaluate(OFF_CENTRE, number) < 20, "the track is in the middle of the map")
    check(own.focus()[0] == "tracks", "the map has the focus again")
    own.press("Escape")
    check(page.evaluate("koseki.selected.size") == 0, "Escape selects nothing")
    own.press("Control+f")
    check(own.focus()[0] == "find", "Ctrl+F opens the search")
    page.keyboard.type("zzzz")
    check("No track" in page.inner_text("#search"), "what does not exist is not found")
    own.press("Escape")
    check(page.evaluate("document.getElementById('search').hidden"), "Escape closes the search")


def filters(own):
    print("a filter")
    page = own.page
    own.press("/")
    page.keyboard.type("state=coastd kt>1000")
    until(
        page,
        "document.getElementById('hidden').textContent.includes('hidden') && !document.getElementById('hidden').hidden",
    )
    whole = page.evaluate("koseki.picture.system.size")
    passing = page.evaluate("[...koseki.picture.system.values()].filter((t) => koseki.shows(t)).length")
    check(passing < whole, f"the line above the map says: {page.inner_text('#hidden')}")
    check("state=coasted" in page.inner_text("#faults"), "the wrong word is marked, with the nearest right one")
    check(page.get_attribute("#filter", "aria-invalid") == "true", "so is the field")
    emergency = """() => {
      const track = [...koseki.picture.system.values()].find((one) => !koseki.shows(one));
      const before = track.alerts;
      track.alerts = 2;
      const shown = koseki.shows(track);
      track.alerts = before;
      return shown;
    }"""
    check(page.evaluate(emergency), "an emergency passes")
    page.focus("#faults button")
    own.press("Enter")
    check(page.evaluate("koseki.settings.filter") == "state=coasted kt>1000", "a key takes the right word")
    page.focus("#tracks")
    own.press("Escape")
    check(page.evaluate("koseki.settings.filter") == "", "Escape ends the filter")
    until(page, "document.getElementById('hidden').hidden")


def keyboard(own):
    print("the keyboard alone")
    page = own.page
    page.focus("#tracks")
    before = page.evaluate("[koseki.view.east, koseki.view.scale]")
    own.press("ArrowRight", "+")
    after = page.evaluate("[koseki.view.east, koseki.view.scale, koseki.settings.at]")
    check(after[0] > before[0] and after[1] < before[1] and after[2] == 0, "arrows move the map, + enlarges it")
    own.press(" ")
    until(page, "document.getElementById('mode').textContent === 'PAUSED'")
    own.press("Home")
    until(page, "document.getElementById('mode').textContent === 'LIVE'")
    check(True, "space stops the picture, Home goes on")
    own.tab_to("element.closest('#tools') && element.textContent === '+'")
    scale = page.evaluate("koseki.view.scale")
    own.press(" ")
    check(page.evaluate("koseki.view.scale") < scale, "space presses the button that has the focus")
    check(page.evaluate("koseki.settings.at") == 0, "and does not stop the picture")
    framed = page.evaluate("getComputedStyle(document.activeElement).outlineStyle")
    check(framed == "solid", "the focus has a frame")
    own.tab_to("element.getAttribute('role') === 'tab'")
    own.press("Home")
    own.tab_to("element.getAttribute('role') === 'row'")
    own.press("ArrowDown", "ArrowDown", "End", "PageUp", "Home", "ArrowDown")
    row = page.evaluate("[document.activeElement.dataset.track, document.activeElement.getAttribute('aria-rowindex')]")
    check(int(row[1]) >= 3, "arrows move through the rows of the table")
    number = int(page.evaluate("document.activeElement.dataset.track"))
    own.press("Enter")
    check(page.evaluate("[...koseki.selected]") == [number], "Enter selects a row")
    check(page.evaluate(OFF_CENTRE, number) < 20, "and centres its track")
    own.press("?")
    check("range rings" in page.inner_text("#help"), "help")
    own.press("Escape")
    check(page.evaluate("koseki.selected.size") == 1, "Escape closes the help alone")
    own.press("Escape")


def letters(browser, url):
    print("letters as keys")
    own = Page(browser, url, hash="#letters=keys&labels=2")
    own.press("l")
    check(own.page.evaluate("koseki.settings.labels") == 0, "a letter is a key, where that is wanted")
    own.press("K")
    check(own.focus()[0] == "find", "a capital letter begins a search")
    own.press("Escape", "7")
    check(own.page.input_value("#find") == "7", "so does a digit")
    own.close()


def sign_in(own):
    page = own.page
    until(page, "document.getElementById('operator-name') !== null")
    page.focus("#operator-name")
    page.keyboard.type("anna")
    own.press("Tab")
    page.keyboard.type(TOKEN)
    own.press("Enter")
    until(page, "document.getElementById('operator-name') === null")


def alarms(own, other):
    print("an alarm")
    page = own.page
    until(page, "koseki.known.processes.some((p) => p.kind === 'adapter' && p.pid > 0)")
    os.kill(int(page.evaluate("koseki.known.processes.find((p) => p.kind === 'adapter').pid")), signal.SIGKILL)
    until(page, "koseki.known.alarms.some((alarm) => alarm.code === 15)")
    until(page, "document.querySelector('#pills button') !== null")
    page.evaluate("koseki.set({ sound: 'warning' })")
    until(page, "koseki.stats.sounds > 0")
    check(True, "it sounds, where that is wanted")
    page.focus("#pills button")
    own.press("Enter")
    check(page.evaluate("koseki.settings.tab") == "alarms", "the pill leads to the alarms")
    wanted = "[data-act='acknowledge'][data-alarm^='15/']"
    until(page, f'document.querySelector("{wanted}") !== null')
    page.focus(wanted)
    own.press("Enter")
    sign_in(own)
    until(page, "koseki.known.alarms.some((alarm) => alarm.code === 15 && alarm.acknowledged?.operator === 'anna')")
    until(
        other.page, "koseki.known.alarms.some((alarm) => alarm.code === 15 && alarm.acknowledged?.operator === 'anna')"
    )
    check(True, "it is acknowledged, on every page")
    until(page, "document.getElementById('panel').textContent.includes('acknowledged by anna')")
    until(
        page,
        "[...document.querySelectorAll('#panel tbody tr')].some((row) => row.textContent.includes('acknowledged'))",
    )
    check(True, "the history has it")
    page.focus("[data-act='restore'][data-alarm^='15/']")
    own.press("Enter")
    wanted = "[data-act='shelve'][data-alarm^='15/']"
    until(page, f'document.querySelector("{wanted}") !== null')
    page.focus(wanted)
    own.press("Enter")
    until(page, "koseki.known.alarms.some((alarm) => alarm.code === 15 && alarm.shelved?.operator === 'anna')")
    check(True, "it is shelved")
    pid = "(koseki.known.processes.find((p) => p.kind === 'display')?.pid ?? 0)"
    before = page.evaluate(pid)
    os.kill(int(before), signal.SIGKILL)
    until(page, f"before => {pid} > 0 && {pid} !== before", argument=before)
    until(page, "koseki.known.alarms.some((alarm) => alarm.code === 15 && alarm.shelved?.operator === 'anna')")
    check(True, "it is shelved after a restart of the display")
    shows = "[data-act='source']"
    until(page, f'document.querySelector("{shows}") !== null')
    name = page.inner_text(shows).removeprefix("Show ")
    page.focus(shows)
    own.press("Enter")
    check(page.evaluate("koseki.settings.tab") == "sources", "an alarm leads to its source")
    check(name in page.evaluate("document.activeElement.textContent"), f"which has the focus: {name}")


def orders(own):
    print("orders")
    page = own.page
    page.evaluate("koseki.set({ tab: 'sources' })")
    until(page, "document.querySelector('[data-order*=\"radar-south\"]') !== null")
    page.focus("[data-order*='radar-south']")
    own.press("Enter")
    until(page, "document.getElementById('order-kind') !== null")
    page.select_option("#order-kind", "out")
    page.focus("#order-for")
    page.keyboard.type("600")
    own.tab_to("element.textContent === 'Give the order'", 6)
    own.press("Enter")
    until(page, "document.querySelector('dialog [role=status]').textContent.includes('in-force')")
    check(True, page.inner_text("dialog [role=status]"))
    own.press("Enter")
    until(page, "document.querySelector('dialog') === null")
    page.evaluate("koseki.set({ tab: 'system' })")
    until(page, "document.querySelector('[data-order*=\"number\"]') !== null")
    page.focus("[data-order*='number']")
    own.press("Enter")
    until(page, "document.getElementById('order-kind') !== null")
    own.tab_to("element.textContent === 'Give the order'", 6)
    own.press("Enter")
    until(page, "koseki.known.orders.some((order) => order.state === 'cancelled')")
    own.press("Escape")
    check(True, "the order is cancelled")
    pair = page.evaluate(
        "[...koseki.picture.system.values()].filter((t) => t.sourceCount > 1).slice(0, 2).map((t) => t.number)"
    )
    page.evaluate(
        "pair => { koseki.select(pair[0]); koseki.select(pair[1], true); koseki.set({ tab: 'track' }); }", pair
    )
    until(page, "document.querySelectorAll('#panel [data-order]').length >= 4")
    subjects = page.evaluate(
        "[...document.querySelectorAll('#panel [data-order]')].map((b) => Object.keys(JSON.parse(b.dataset.order)).join())"
    )
    check(
        {"track", "track,with", "track,source,sensor_track", "place"} <= set(subjects),
        "a track, its sensor tracks and a pair have their orders",
    )
    page.focus("#panel [data-order]")
    own.press("Enter")
    until(page, "document.getElementById('order-kind') !== null")
    page.select_option("#order-kind", "renumber")
    own.tab_to("element.textContent === 'Give the order'", 6)
    own.press("Enter")
    until(page, "document.querySelector('dialog [role=status]').textContent.includes('done')")
    check(True, page.inner_text("dialog [role=status]"))
    own.press("Escape")
    page.evaluate("koseki.select(-1)")


def views(own, browser, url):
    print("kept views")
    page = own.page
    page.evaluate("koseki.set({ tab: 'view', theme: 'day', filter: 'kt>100' })")
    until(page, "document.getElementById('view-name') !== null")
    page.focus("#view-name")
    page.keyboard.type("fast by day")
    own.tab_to("element.textContent === 'Keep for all'", 4)
    own.press("Enter")
    until(page, "document.getElementById('panel').textContent.includes('kept for all')")
    guest = browser.new_context().new_page()
    guest.goto(url)
    until(guest, "globalThis.koseki?.picture.system.size >= 40")
    check(guest.evaluate("koseki.settings.vector") == 120, "a page without an address has the start view")
    guest.evaluate("koseki.set({ tab: 'view' })")
    until(guest, "[...document.querySelectorAll('.view button')].some((b) => b.textContent === 'fast by day')")
    guest.focus(".view button")
    guest.keyboard.press("Enter")
    until(guest, "koseki.settings.theme === 'day' && koseki.settings.filter === 'kt>100'")
    check(True, "a guest opens a view that an operator has kept")
    guest.evaluate("koseki.set({ theme: 'print' })")
    guest.wait_for_timeout(600)
    guest.goto("about:blank")
    guest.goto(url)
    until(guest, "globalThis.koseki?.picture.system.size >= 40")
    check(
        guest.evaluate("[koseki.settings.theme, koseki.settings.filter]") == ["print", ""],
        "the browser keeps habits, and no filter",
    )
    status = guest.evaluate(
        """async () => (await fetch("api/views", { method: "POST", headers: { "Content-Type": "application/json" },
             body: JSON.stringify({ name: "x", address: "", operator: "guest" }) })).status"""
    )
    check(status == 403, "a guest keeps none for others")
    guest.context.close()
    page.evaluate("koseki.set({ theme: 'night', filter: '', tab: 'tracks' })")


def accessible(own, axe):
    print("axe-core")
    page = own.page
    page.evaluate(f"{axe};0")
    count = 0

    def judge(what):
        nonlocal count
        count += 1
        found = page.evaluate("axe.run(document, { resultTypes: ['violations'] })")["violations"]
        told = [f"{v['id']}: {v['nodes'][0]['html'][:120]}" for v in found]
        if told:
            raise AssertionError(f"{what}: {told}")

    for theme in ["night", "day"]:
        for tab in TABS:
            page.evaluate(
                "([theme, tab]) => { koseki.select([...koseki.picture.system.keys()][0]); koseki.set({ theme, tab }); }",
                [theme, tab],
            )
            page.wait_for_timeout(1100)
            judge(f"{theme}, panel {tab}")
        page.focus("#tracks")
        page.keyboard.type("k")
        judge(f"{theme}, search")
        own.press("Escape", "?")
        judge(f"{theme}, help")
        own.press("Escape", "/")
        page.keyboard.type("stat=coasted")
        page.wait_for_timeout(700)
        judge(f"{theme}, filter with a wrong word")
        own.press("Escape")
        page.evaluate("koseki.set({ tab: 'system' })")
        until(page, "document.querySelector('[data-order]') !== null")
        page.focus("[data-order]")
        own.press("Enter")
        until(page, "document.getElementById('order-kind') !== null")
        judge(f"{theme}, order")
        own.press("Escape")
    page.evaluate("koseki.set({ theme: 'night', tab: 'tracks' })")
    check(True, f"0 violations in {count} states of the page")


def narrow(browser, url, folder, axe):
    print("a narrow screen, 390 x 844")
    own = Page(browser, url, (390, 844))
    page = own.page
    wide = page.evaluate("[document.documentElement.scrollWidth, koseki.view.width, koseki.view.height]")
    check(
        wide[0] == 390 and wide[1] == 390 and wide[2] > 300,
        f"the map is {wide[1]} x {wide[2]}, and nothing scrolls sideways",
    )
    for reached in ["#filter", "#pills .pill", "#live", "#mode", "#tab-alarms", "#tab-view", "#play"]:
        # At one instant: the header replaces its children twice a second.
        box = page.evaluate("wanted => document.querySelector(wanted).getBoundingClientRect().toJSON()", reached)
        inside = box["width"] > 0 and box["left"] >= 0 and box["right"] <= 390 and box["bottom"] <= 844
        check(inside, f"{reached} is on the screen")
    page.wait_for_timeout(1500)
    page.screenshot(path=folder / "390x844.png")
    page.evaluate(f"{axe};0")
    found = page.evaluate("axe.run(document, { resultTypes: ['violations'] })")["violations"]
    check(found == [], "axe-core finds nothing")
    own.close()


def large(browser, url, folder):
    print("a large screen, 3840 x 2160, text at 200 %")
    own = Page(browser, url, (3840, 2160), "#size=200&labels=2")
    page = own.page
    check(page.evaluate("document.documentElement.scrollWidth") == 3840, "nothing scrolls sideways")
    alone = """() => {
          const box = document.getElementById("tracks").getBoundingClientRect();
          const free = ({ x, y }) => x > 60 && y > 60 && x < koseki.view.width - 60 && y < koseki.view.height - 80 &&
            koseki.painter.drawn.every((o) => (o.x === x && o.y === y) || Math.hypot(o.x - x, o.y - y) > 20);
          const found = koseki.painter.drawn.find(free);
          return found && { number: found.track.number, x: box.left + 2 * found.x, y: box.top + 2 * found.y };
        }"""
    until(page, f"({alone})()")
    page.wait_for_timeout(1000)
    spot = page.evaluate(alone)
    page.mouse.click(spot["x"], spot["y"])
    check(page.evaluate("[...koseki.selected]") == [spot["number"]], "a click meets its track")
    page.screenshot(path=folder / "operate-3840x2160.png")
    own.close()


def main():
    options = argparse.ArgumentParser()
    options.add_argument("koseki")
    options.add_argument("folder", type=pathlib.Path)
    options.add_argument("axe", type=pathlib.Path)
    given = options.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    axe = given.axe.read_text(encoding="utf-8")
    file = (given.folder / "views.json").resolve()
    file.unlink(missing_ok=True)
    sets = {
        "display.views.file": f'"{file}"',
        "display.views.start": '"vector=120"',
    }
    os.environ["KOSEKI_DISPLAY_OPERATOR_TOKEN"] = TOKEN
    command = ["demo", "--instance", "ci-operate", "--out", given.folder / "operated"]
    for key, value in sets.items():
        command += ["--set", f"{key}={value}"]
    demo = Koseki(given.koseki, given.folder / "operate.txt", command)
    try:
        url = demo.address()
        with sync_playwright() as play:
            browser = play.chromium.launch(
                executable_path="/usr/bin/chromium",
                args=["--no-sandbox", "--disable-gpu", "--disable-software-rasterizer"],
            )
            own = Page(browser, url)
            fitted(own)
            find(own)
            filters(own)
            keyboard(own)
            letters(browser, url)
            other = Page(browser, url)
            alarms(own, other)
            other.close()
            orders(own)
            views(own, browser, url)
            accessible(own, axe)
            own.page.screenshot(path=given.folder / "operate-1280x800.png")
            own.close()
            narrow(browser, url, given.folder, axe)
            large(browser, url, given.folder)
            browser.close()
    finally:
        demo.stop()


if __name__ == "__main__":
    sys.exit(main())

"""What a surveillance engineer asks of the page: reasons, decisions and other rules of a track, trails at once, coverage,
layers of the map, and a display of the instance without its file. Used by check.py."""

import json
import pathlib
import subprocess
import sys
import time
import urllib.request

HERE = pathlib.Path(__file__).parent

# The selected track's reasons, as the page has them.
REASONS = """() => {
  const number = [...koseki.selected][0];
  const facts = koseki.facts.get(number);
  return facts && {
    shares: koseki.shares.get(number).map(({ name, age, sigmaLong, residualSigmas, reason }) =>
      ({ name, age, sigmaLong, residualSigmas, reason })),
    decisions: facts.why.decisions, rules: facts.why.rules, rule: facts.rule,
  };
}"""

# Ages of the oldest points of all trails, seconds before the picture.
TRAILS = """() => [...koseki.picture.system.values()].filter((t) => t.trail.length > 0)
  .map((t) => [koseki.picture.time - t.trail.timeOf(t.trail.at(0)), t.trail.timeOf(t.trail.at(t.trail.length - 1)) - koseki.picture.time])"""


def overlay_of(folder):
    """GeoJSON of a small aerodrome, by the converter."""
    made = folder / "airport.geojson"
    script = HERE / "../../services/display/aerodrome.py"
    subprocess.run([sys.executable, script, HERE / "aerodrome.json", "--out", made], check=True)
    return made.resolve()


def fetched(url, path):
    with urllib.request.urlopen(url.rstrip("/") + path, timeout=30) as answer:
        return json.load(answer)


def drive_engineer(browser, url, folder, began, until, check):
    """`began`: monotonic time since which fusion has run, seconds."""
    # Minutes of history must be there before the page is opened.
    time.sleep(max(0, began + 75 - time.monotonic()))
    page = browser.new_page(viewport={"width": 1920, "height": 1080})
    errors = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
    page.goto(url)
    until(page, "globalThis.koseki?.picture.system.size >= 40")
    print("trails, reasons and coverage")
    until(page, "[...koseki.picture.system.values()].some((t) => t.trail.length > 12)")
    trails = page.evaluate(TRAILS)
    old = sum(oldest > 45 for oldest, _ in trails)
    check(old >= 0.7 * len(trails), f"{old} of {len(trails)} trails are older than the page")
    at = page.evaluate("koseki.picture.time") - 25
    page.evaluate("at => koseki.set({ at, speed: 0 })", at)
    until(page, "at => Math.abs(koseki.picture.time - at) < 1", at)
    until(page, f"({TRAILS})().every(([, newest]) => newest < 2)")
    ahead = [trail for trail in page.evaluate(TRAILS) if trail[0] > 20]
    check(len(ahead) >= 20, f"{len(ahead)} trails end at the moment of the past")
    page.evaluate("koseki.set({ at: 0, speed: 0 })")
    until(page, "at => koseki.picture.time > at + 20", at)

    page.evaluate("""() => {
      const known = [...koseki.picture.system.values()].filter((t) => t.state === "confirmed" && !t.onGround);
      koseki.select(known.sort((a, b) => b.sourceCount - a.sourceCount)[0].number);
    }""")
    until(page, f"({REASONS})()?.shares.length >= 3")
    page.wait_for_timeout(1200)
    said = page.evaluate(REASONS)
    shares = said["shares"]
    check(all(share["reason"] for share in shares), f"{len(shares)} contributors have reasons: {shares[0]['reason']}")
    check(all(share["age"] is not None and 0 <= share["age"] < 30 for share in shares), "and ages")
    check(sum(share["sigmaLong"] is not None for share in shares) >= 2, "and ellipses")
    check(said["decisions"], f"{len(said['decisions'])} decisions: {said['decisions'][0]['text']}")
    names = [rule["rule"] for rule in said["rules"]]
    check("best-source" in names and len(names) >= 5, f"other rules: {', '.join(names)}")
    totals = [sum(share for *_, share in rule["shares"]) for rule in said["rules"]]
    check(all(abs(total - 1) < 1e-6 for total in totals), "whose shares sum to 1")
    panel = page.inner_text("#panel").upper()
    check(all(title in panel for title in ["DECISIONS", "OTHER RULES WOULD GIVE", "DETAILS"]), "the panel shows all of it")
    page.screenshot(path=folder / "reasons.png")

    page.evaluate("koseki.set({ tab: 'sources', pd: koseki.known.sources[0].name, coverage: true })")
    until(page, "koseki.coverage.sources.size > 0")
    page.wait_for_timeout(800)
    page.screenshot(path=folder / "coverage.png")
    cells = fetched(url, "/api/coverage.json")["sources"]
    tries = {source["name"]: sum(cell[4] for cell in source["cells"]) for source in cells}
    check(all(count > 20 for count in tries.values()), f"reports owed by source: { {k: round(v) for k, v in tries.items()} }")
    features = fetched(url, "/api/coverage.geojson")["features"]
    ring = features[0]["geometry"]["coordinates"][0]
    check(len(features) > 20 and ring[0] == ring[-1], f"{len(features)} cells as GeoJSON")

    print("layers of the map")
    page.evaluate("""() => {
      koseki.set({ tab: 'view', pd: '', coverage: false, siterings: true, sel: '' });
      koseki.select(-1);
      koseki.moved(() => Object.assign(koseki.view, { east: 0, north: 0, scale: 8 }));
    }""")
    until(page, "koseki.overlays.some(({ name }) => name === '06R/24L')")
    page.wait_for_timeout(800)
    page.screenshot(path=folder / "maps.png")
    before = page.evaluate(GROUND)
    page.click("[data-layer='airport.geojson']")
    until(page, "koseki.settings.maps.includes('-airport.geojson')")
    page.wait_for_timeout(500)
    check(page.evaluate(GROUND) != before, "a layer is switched off")
    check("maps=" in page.url, "and the address has it")
    course = page.evaluate("document.getElementById('panel') && koseki.known.declination")
    check(course == 1.5, "the declination is known")
    check(not errors, f"no error on the page: {errors[:3]}")
    page.close()


# Sum of the ground canvas's pixels.
GROUND = """() => {
  const canvas = document.getElementById("ground");
  const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
  copy.drawImage(canvas, 0, 0);
  return copy.getImageData(0, 0, canvas.width, canvas.height).data.reduce((sum, value) => sum + value, 0);
}"""


def drive_guest(page, url, until, check):
    """The same instance, by a display without its file."""
    print("the instance without its file")
    page.goto(url)
    until(page, "globalThis.koseki?.picture.system.size >= 40 && koseki.known.sources.length === 5")
    names = page.evaluate("koseki.known.sources.map(({ name }) => name).sort()")
    check(names == ["ads-b", "multilateration", "radar-east", "radar-south", "radar-west"], f"sources: {', '.join(names)}")
    page.evaluate("koseki.set({ sensors: true })")
    until(page, "koseki.picture.sensor.size >= 40")
    page.evaluate("koseki.select([...koseki.picture.system.values()].find((t) => t.sourceCount >= 3).number)")
    until(page, "document.getElementById('panel').textContent.includes('--config')")
    check(True, "reasons are there, and rules name what they need")

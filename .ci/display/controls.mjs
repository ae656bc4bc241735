/** Tests of what people work the page with, without a browser: filter and search. Run as modules.mjs is. */

import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";

const CONFIGURATIONS = new URL("../../config/", import.meta.url);
const page = new URL("../../services/display/page/", import.meta.url);
const module = (name) => import(new URL(name, page));
const { nearest, readFilter } = await module("filter.js");
const { blankTrack, sourcesOf } = await module("picture.js");
const { found, isNameKey } = await module("search.js");

const flight = (change = {}) =>
  Object.assign(blankTrack(), {
    number: 42,
    callsign: "BAW12",
    address: "4CA123",
    code: "2345",
    type: "A320",
    height: 3048,
    speedEast: 100,
    knowsVelocity: true,
    source: 1,
    sourceCount: 2,
    sourcesLow: 0b110,
    sourcesHigh: 1,
    ...change,
  });
const SOURCES = ["west", "mlat", "ads-b"];
const filter = (text) => readFilter(text, (source) => SOURCES[source] ?? "", SOURCES);

test("filters", () => {
  const passing = ["", "baw", "BAW 4ca", "#42", "fl>99 fl<101", "fl=100", "kt>190", "sources=2", "/^BAW\\d+$/", "-VLG"];
  const named = ["type=a320", "main=mlat", "source=ads-b", "-source=west", "state=confirmed", "kind=single"];
  for (const text of [...passing, ...named]) {
    assert.ok(filter(text).matches(flight()), text);
    assert.deepEqual(filter(text).faults, [], text);
  }
  for (const text of ["vlg", "fl>100", "-baw", "source=west", "state=coasted", "members>1"])
    assert.ok(!filter(text).matches(flight()), text);
  assert.deepEqual(sourcesOf(flight()), [1, 2, 32]);
  assert.ok(filter("fl=361").matches(flight({ height: 361 * 30.48 })), "by the level that is shown");
});

test("a word that cannot be read hides nothing, and comes back with the nearest that can be", () => {
  const advice = (text) => filter(text).faults.map(({ advice }) => advice);
  for (const [text, meant] of [
    ["state=coastd", "state=coasted"],
    ["-stat=coasted", "-state=coasted"],
    ["alt>100", "fl>100"],
    ["sorces>2", "sources>2"],
    ["main=msat", "main=mlat"],
    ["kind=grop", "kind=group"],
    ["fl>FL100", "fl>100"],
    ["/[/", ""],
    ["nonsense=3", ""],
    ["state>3", ""],
  ]) {
    assert.deepEqual(advice(text), [meant], text);
    assert.ok(filter(text).matches(flight()), text);
  }
  assert.ok(!filter("state=coastd vlg").matches(flight()), "the other words count");
  assert.deepEqual(readFilter("main=anything", () => "", []).faults, [], "before the sources are known");
});

test("the nearest word differs by an exchange, a change or a missing letter, and not by everything", () => {
  const words = ["confirmed", "tentative", "coasted"];
  assert.equal(nearest("caosted", words), "coasted");
  assert.equal(nearest("tent", words), "tentative");
  assert.equal(nearest("x", words), "");
  assert.equal(nearest("", words), "");
});

test("a search finds equal names first, then beginnings, then parts, and callsigns before codes", () => {
  const tracks = [
    flight({ number: 1, callsign: "VLG2345", code: "1000", address: "" }),
    flight({ number: 2, callsign: "", code: "2345", address: "" }),
    flight({ number: 3, callsign: "2345X", code: "", address: "" }),
    flight({ number: 4, callsign: "", code: "", address: "123456" }),
    flight({ number: 2345, callsign: "IBE1", code: "", address: "" }),
  ];
  const numbers = (text) => found(tracks, text).map((track) => track.number);
  assert.deepEqual(numbers("2345"), [2, 3, 1, 4, 2345]);
  assert.deepEqual(numbers("#2345"), [2345]);
  assert.deepEqual(numbers("vlg2345"), [1]);
  assert.deepEqual(numbers("  "), []);
  assert.equal(
    found(
      Array.from({ length: 99 }, (_, k) => flight({ number: k })),
      "baw",
    ).length,
    8,
  );
  assert.ok(["a", "Z", "7", "#"].every(isNameKey) && !["/", "?", "Enter", "Tab", " "].some(isNameKey));
});

test("what nobody has acknowledged sounds, the worst first, and what is shelved does not", async () => {
  const { soundOf, standing } = await module("alarms.js");
  const alarm = (severity, change = {}) => ({ severity, cleared: false, acknowledged: null, shelved: null, ...change });
  const who = { operator: "anna", time: 1 };
  const alarms = [
    alarm("warning"),
    alarm("major", { acknowledged: who }),
    alarm("critical", { shelved: { operator: "anna", until: 2 } }),
    alarm("critical", { cleared: true }),
  ];
  assert.deepEqual(
    [standing(alarms).shown.length, standing(alarms).open.map(({ severity }) => severity)],
    [2, ["warning"]],
  );
  assert.equal(soundOf(alarms, "warning"), "warning");
  assert.equal(soundOf(alarms, "major"), "");
  assert.equal(soundOf(alarms, "off"), "");
  assert.equal(soundOf([...alarms, alarm("major"), alarm("critical")], "major"), "critical");
});

test("a subject has the orders that take all of it and need nothing else that must be known", async () => {
  const { kindsFor } = await module("orders.js");
  const kind = (name, needs, may = []) => ({ kind: name, needs, may });
  const kinds = [
    kind("condition", ["name"], ["source"]),
    kind("out", ["source"]),
    kind("drop", ["track"]),
    kind("join", ["track", "with"]),
    kind("split", ["track", "source", "sensor_track"]),
    kind("cancel", ["number"]),
    kind("designate", ["tracker", "place", "sigma"]),
    kind("rule", ["name"]),
  ];
  const names = (subject) => kindsFor(kinds, subject).map(({ kind }) => kind);
  assert.deepEqual(names({}), ["condition", "out", "rule"]);
  assert.deepEqual(names({ source: "radar" }), ["condition", "out"]);
  assert.deepEqual(names({ track: 7 }), ["drop"]);
  assert.deepEqual(names({ track: 7, with: 8 }), ["join"]);
  assert.deepEqual(names({ track: 7, source: "radar", sensor_track: 3 }), ["split"]);
  assert.deepEqual(names({ number: 1 }), ["cancel"]);
  assert.deepEqual(names({ place: "1m,2m" }), ["designate"]);
});

test("a view is opened with the start view and the habits of the browser, and passing things are no habit", async () => {
  const kept = new Map();
  globalThis.localStorage = { getItem: (key) => kept.get(key) ?? null, setItem: (key, text) => kept.set(key, text) };
  const { addressOf, keepHabits, openingAddress, unknownIn } = await module("kept.js");
  const { DEFAULTS, read } = await module("settings.js");
  const opened = (start) => read(openingAddress(start));
  assert.deepEqual(opened(""), { ...DEFAULTS });
  assert.equal(opened("vector=360&units=maritime").vector, 360);
  keepHabits({ ...DEFAULTS, units: "maritime", vector: 60, theme: "day", filter: "baw", at: 5, sel: "7", scale: 9 });
  const again = opened("vector=360&units=maritime");
  assert.deepEqual(
    [again.vector, again.units, again.theme, again.filter, again.at, again.sel, again.scale],
    [60, "maritime", "day", "", 0, "", 0],
    "the default that was chosen outlasts the start view",
  );
  assert.equal(addressOf({ ...DEFAULTS, sel: "7", at: 5, filter: "baw" }), "filter=baw");
  assert.equal(unknownIn("vector=360&theme=day"), "");
  assert.match(unknownIn("vecor=360&xyzzy=1"), /does not know vecor \(perhaps vector\), xyzzy\./);
  for (const file of readdirSync(CONFIGURATIONS)) {
    const start = /^start = "(.*)"$/m.exec(readFileSync(new URL(file, CONFIGURATIONS), "utf8"))?.[1] ?? "";
    assert.equal(unknownIn(start), "", file);
  }
  kept.set("koseki.settings", "{nonsense");
  assert.deepEqual(opened(""), { ...DEFAULTS });
});

test("ships have no level", async () => {
  const { heightText, labelOf, speedText } = await module("labels.js");
  const ship = flight({ isShip: true, callsign: "MARU", height: 12, speedEast: 6 });
  assert.equal(heightText(ship, "aviation"), "");
  assert.equal(speedText(ship, "aviation"), "11.7");
  assert.deepEqual(labelOf(ship, "aviation", "coast").slice(0, 2), ["MARU", "11.7"]);
  assert.equal(heightText(flight(), "maritime"), "");
  assert.notEqual(heightText(flight(), "aviation"), "");
});

/** Tests of labels and their places, without a browser: node --test .ci/display/labels.mjs */

import assert from "node:assert/strict";
import { test } from "node:test";

const page = new URL("../../services/display/page/", import.meta.url);
const module = (name) => import(new URL(name, page));
const { blockOf, groupsOf } = await module("fans.js");
const { labelOf } = await module("labels.js");
const { blankTrack } = await module("picture.js");
const { leaderEnd, overlap, Placement } = await module("placement.js");

const WIDTH = 1480;
const HEIGHT = 1000;

/** A repeatable draw from 0 to 1 (xorshift, Marsaglia 2003). */
function drawer() {
  let seed = 2463534242;
  return () => {
    seed ^= seed << 13;
    seed ^= seed >>> 17;
    seed ^= seed << 5;
    return (seed >>> 0) / 4294967296;
  };
}

/** Symbol that wants a label of two lines. */
const wish = (x, y, change = {}) => ({
  spot: { place: -1, lines: 0, pinned: null },
  x,
  y,
  vx: 0,
  vy: 0,
  rank: 1,
  isBlock: false,
  widths: [56, 62],
  heights: [11, 24],
  ...change,
});

/** Lays wishes out on a map with vectors of a minute. */
function layOut(placement, wishes, boxes = [], width = WIDTH, height = HEIGHT) {
  placement.begin(width, height, wishes.length);
  for (const box of boxes) placement.keepOut(box);
  for (const { x, y, vx, vy } of wishes)
    if (vx !== 0 || vy !== 0) placement.keepOff(x, y, x + 60 * vx, y + 60 * vy, vx, vy);
  return placement.arrange(wishes);
}

/** Tracks uniformly over the map that fly straight on, 0.15 to 0.5 pixels a second. */
function traffic(count) {
  const draw = drawer();
  return Array.from({ length: count }, () => {
    const [x, y, way, speed] = [WIDTH * draw(), HEIGHT * draw(), 2 * Math.PI * draw(), 0.15 + 0.35 * draw()];
    return wish(x, y, { vx: speed * Math.sin(way), vy: -speed * Math.cos(way) });
  });
}

const isOn = ({ x, y }) => x >= 0 && y >= 0 && x <= WIDTH && y <= HEIGHT;
const symbolIn = (box, { x, y }) =>
  overlap(box, { left: x - 5, top: y - 5, width: 10, height: 10 });

test("two hundred tracks are all labelled, clear of each other, and their labels stay for a minute", () => {
  const placement = new Placement();
  const tracks = traffic(200);
  let [labels, wanted, moved, compared] = [0, 0, 0, 0];
  let before = new Map();
  for (let second = 0; second < 60; second++) {
    const shown = tracks.filter(isOn);
    const laid = layOut(placement, shown);
    wanted += shown.length;
    labels += laid.length;
    assert.equal(placement.leftOut, shown.length - laid.length);
    for (const label of laid) {
      assert.ok(!laid.some((other) => other !== label && overlap(other, label)), "labels are apart");
      assert.ok(!shown.some((track) => symbolIn(label, track)), "no label lies on a symbol");
      const [toX, toY] = leaderEnd(label.wish.x, label.wish.y, label);
      const most = label.lines > 1 ? 80 : 240;
      assert.ok(Math.hypot(toX - label.wish.x, toY - label.wish.y) < most + 0.01, `a leader is at most ${most} pixels long`);
      assert.ok(label.left >= 0 && label.top >= 0, "no label leaves the map");
      assert.ok(label.left + label.width <= WIDTH && label.top + label.height <= HEIGHT, "no label leaves the map");
      const place = `${label.wish.spot.place} ${label.lines}`;
      if (before.has(label.wish)) compared++;
      if (before.has(label.wish) && before.get(label.wish) !== place) moved++;
    }
    before = new Map(laid.map(({ wish: own, lines }) => [own, `${own.spot.place} ${lines}`]));
    for (const track of tracks) [track.x, track.y] = [track.x + track.vx, track.y + track.vy];
  }
  assert.ok(labels === wanted, `${labels} of ${wanted} have a label`);
  assert.ok(moved / compared <= 0.005, `${moved} of ${compared} moved in a second`);
});

test("the same tracks get the same places", () => {
  const places = () => {
    const tracks = traffic(300);
    layOut(new Placement(), tracks);
    return tracks.map(({ spot }) => spot.place);
  };
  assert.deepEqual(places(), places());
});

test("a label stays where it is until something comes there, and becomes whole again where there is room", () => {
  const placement = new Placement();
  const own = wish(500, 500);
  layOut(placement, [own]);
  const { place } = own.spot;
  const visitor = wish(600, 300);
  layOut(placement, [own, visitor]);
  assert.equal(own.spot.place, place);
  const [label] = layOut(placement, [own]);
  Object.assign(visitor, { x: label.left + 20, y: label.top + 10 });
  layOut(placement, [own, visitor]);
  assert.notEqual(own.spot.place, place);
  Object.assign(own.spot, { lines: 1 });
  layOut(placement, [own]);
  assert.equal(own.spot.lines, 2);
});

test("controls, names on the map and speed vectors are avoided", () => {
  const tools = { left: 510, top: 380, width: 200, height: 240 };
  const own = wish(500, 500, { vx: -1, vy: 0 });
  const [label] = layOut(new Placement(), [own], [tools]);
  assert.ok(!overlap(label, tools));
  assert.ok(!overlap(label, { left: 440, top: 499, width: 60, height: 2 }), "off its own vector");
});

test("a label at each edge of the map lies on the map", () => {
  for (const x of [1, WIDTH / 2, WIDTH - 1])
    for (const y of [1, HEIGHT / 2, HEIGHT - 1]) {
      const [{ left, top, width, height }] = layOut(new Placement(), [wish(x, y)]);
      assert.ok(left >= 0 && top >= 0 && left + width <= WIDTH && top + height <= HEIGHT, `${x}, ${y}`);
    }
});

test("a selected track has its label where there is room for none, and what it displaces is counted", () => {
  const placement = new Placement();
  const crowd = Array.from({ length: 800 }, (_, k) => wish(8 + (k % 40) * 10, 8 + Math.floor(k / 40) * 10));
  layOut(placement, crowd, [], 400, 200);
  const chosen = crowd.find(({ spot }) => spot.place < 0);
  chosen.rank = 3;
  const laid = layOut(placement, crowd, [], 400, 200);
  const label = laid.find((one) => one.wish === chosen);
  assert.equal(label.lines, 2);
  assert.ok(laid.every((other) => other === label || !overlap(other, label)));
  assert.equal(placement.leftOut, crowd.length - laid.length);
});

test("what interests is labelled first", () => {
  const crowd = traffic(1500);
  crowd.forEach((one, k) => (one.rank = k % 10 === 9 ? 2 : 1));
  const laid = layOut(new Placement(), crowd);
  const share = (rank) => laid.filter(({ wish: own }) => own.rank === rank).length / crowd.filter((own) => own.rank === rank).length;
  assert.ok(share(2) > 2 * share(1), `${share(2)} and ${share(1)}`);
});

test("the work of a picture is bounded, and every track has its turn", () => {
  const placement = new Placement();
  const crowd = Array.from({ length: 5000 }, (_, k) => wish((k * 37) % WIDTH, (k * 53) % HEIGHT));
  layOut(placement, crowd);
  assert.ok(placement.tests < 10_000, `${placement.tests} tests`);
  // One that comes late and has room.
  const late = wish(-200, HEIGHT / 2);
  const clear = crowd.filter(({ x, y }) => x > 300 || Math.abs(y - HEIGHT / 2) > 150);
  late.x = 100;
  for (let picture = 0; picture < 300 && late.spot.place < 0; picture++) layOut(placement, [...clear, late]);
  assert.ok(late.spot.place >= 0);
});

test("a label that was put by hand stays beside its symbol, on the map", () => {
  const placement = new Placement();
  const own = wish(500, 500, { spot: { place: -1, lines: 0, pinned: [100, 50] } });
  const other = wish(580, 560);
  const [label, next] = layOut(placement, [own, other]);
  assert.deepEqual([label.left, label.top], [600, 550]);
  assert.ok(!overlap(label, next));
  own.x = WIDTH - 5;
  assert.equal(layOut(placement, [own])[0].left, WIDTH - 62);
});

test("labels say the fields that are configured, and always alerts", () => {
  const track = Object.assign(blankTrack(), {
    callsign: "BAW12",
    code: "2345",
    height: 3048,
    isLevel: true,
    climb: -10.16,
    speedEast: 100,
    knowsVelocity: true,
    alerts: 2,
    sourceCount: 2,
  });
  assert.deepEqual(labelOf(track, "aviation", "west"), ["BAW12 EMERG", "100  194", "2 west"]);
  const lines = [["code", "address"], ["angle", "climb"]];
  assert.deepEqual(labelOf(track, "aviation", "west", lines), ["2345 EMERG", "090° −20"]);
  assert.ok(labelOf(blankTrack(), "aviation", "")[1].startsWith("---"), "unknown heights are no numbers");
});

/** Symbol of a target. */
const target = (number, x, y, vx = 0, vy = 0) => ({ number, x, y, vx, vy });

test("targets upon each other are a group, and those that only cross are not", () => {
  const parked = [target(5, 100, 100), target(3, 106, 100), target(9, 111, 102)];
  const groups = groupsOf([...parked, target(1, 104, 101, 3, 0), target(2, 300, 300)], new Map());
  assert.deepEqual([...groups].map(([lead, members]) => [lead, members.map(({ number }) => number)]), [[3, [3, 5, 9]]]);
  assert.equal(groupsOf(parked.slice(0, 2), new Map()).size, 0, "two have their own labels");
  const apart = [target(5, 100, 100), target(3, 112, 100), target(9, 124, 100)];
  assert.equal(groupsOf(apart, new Map()).size, 0);
  const before = new Map([[5, 5], [3, 5], [9, 5]]);
  assert.deepEqual([...groupsOf(apart, before).keys()], [5], "a group holds longer than it takes to make it, and keeps its lead");
  const crowd = Array.from({ length: 300 }, (_, k) => target(k, 100 + (k % 20), 100));
  assert.equal(groupsOf(crowd, new Map()).get(0).length, 60, "a block is bounded");
});

test("a block has columns of at most ten rows, and may lie far away where nothing nearer is free", () => {
  assert.deepEqual(blockOf(17, 50, 13), { rows: 9, step: 60, width: 110, height: 117 });
  const own = wish(500, 500, { isBlock: true, widths: [110], heights: [117] });
  const wall = { left: 330, top: 330, width: 340, height: 340 };
  const [block] = layOut(new Placement(), [own], [wall]);
  assert.ok(!overlap(block, wall));
  const [toX, toY] = leaderEnd(500, 500, block);
  assert.ok(Math.hypot(toX - 500, toY - 500) < 400.1);
});

test("a vector that passes is borne, and one that stays is not", () => {
  const placement = new Placement();
  const own = wish(500, 500);
  const [label] = layOut(placement, [own]);
  const { place } = own.spot;
  const under = (vy) => {
    placement.begin(WIDTH, HEIGHT, 1);
    placement.keepOff(label.left - 30, label.top + 12, label.left + 90, label.top + 12, 0, vy);
    placement.arrange([own]);
    return own.spot.place;
  };
  assert.equal(under(2), place);
  assert.notEqual(under(0), place);
});

test("a block that finds no free place displaces labels, and then stays", () => {
  const placement = new Placement();
  const crowd = Array.from({ length: 300 }, (_, k) => wish(20 + (k % 20) * 28, 20 + Math.floor(k / 20) * 28));
  layOut(placement, crowd, [], 600, 440);
  const block = wish(300, 220, { rank: 2, isBlock: true, widths: [200], heights: [100] });
  const all = [...crowd, block];
  const laid = layOut(placement, all, [], 600, 440);
  const [own] = laid.filter((one) => one.wish === block);
  assert.ok(laid.every((other) => other === own || !overlap(other, own)));
  assert.equal(placement.leftOut, all.length - laid.length);
  const { place } = block.spot;
  layOut(placement, all, [], 600, 440);
  assert.equal(block.spot.place, place);
});

test("a block that would cover another block or a selected label is left out and counted", () => {
  const placement = new Placement();
  const chosen = wish(150, 110, { rank: 3, widths: [200, 200], heights: [60, 60] });
  const blocks = [130, 170].map((x) => wish(x, 110, { rank: 2, isBlock: true, widths: [200], heights: [80] }));
  const all = [chosen, ...blocks];
  for (let picture = 0; picture < 3; picture++) {
    const laid = layOut(placement, all, [], 300, 220);
    assert.ok(laid.some((one) => one.wish === chosen));
    assert.equal(placement.leftOut, all.length - laid.length);
    assert.ok(placement.leftOut > 0);
    for (const one of laid) assert.ok(laid.every((other) => other === one || !overlap(one, other)));
  }
});

test("a label that is selected displaces a block", () => {
  const placement = new Placement();
  const block = wish(150, 110, { rank: 2, isBlock: true, widths: [200], heights: [80] });
  const other = wish(150, 150, { widths: [200, 200], heights: [60, 60] });
  layOut(placement, [block, other], [], 300, 220);
  assert.ok(block.spot.place >= 0);
  const laid = layOut(placement, [block, { ...other, rank: 3 }], [], 300, 220);
  assert.ok(laid.some(({ wish }) => wish.rank === 3));
  assert.ok(laid.length === 1 || !overlap(laid[0], laid[1]));
});

test("a place through which a symbol will pass within seconds is not taken", () => {
  const own = wish(500, 500);
  const [first] = layOut(new Placement(), [own]);
  const passes = wish(first.left + 30, first.top - 300, { vy: 31, widths: [1], heights: [1] });
  const again = wish(500, 500);
  const placement = new Placement();
  placement.begin(WIDTH, HEIGHT, 2);
  placement.arrange([again, passes]);
  assert.notEqual(again.spot.place, own.spot.place);
});

test("a label that must be shown covers a label or a vector before a control", () => {
  const controls = { left: 0, top: 0, width: 60, height: HEIGHT };
  const chosen = wish(190, 500, { rank: 3, widths: [300, 300], heights: [200, 200] });
  const crowd = Array.from({ length: 21 }, (_, k) => wish(400 + 160 * (k % 3), 80 + 140 * Math.floor(k / 3)));
  const placement = new Placement();
  const laid = layOut(placement, [chosen, ...crowd], [controls]);
  const label = laid.find(({ wish }) => wish === chosen);
  assert.ok(chosen.spot.isForced, "no place is free");
  assert.ok(label && !overlap(label, controls), JSON.stringify(label));
});

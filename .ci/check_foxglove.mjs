// Checks the WebSocket for Foxglove with npm's `@foxglove/ws-protocol` client and CDR reader, in both subprotocols.
//
//     node check_foxglove.mjs KOSEKI FOLDER NODE
//
// Runs a demonstration in FOLDER, reads system tracks, and compares each with the recorded states. NODE is the folder
// in which `npm install` placed @foxglove/ws-protocol, @foxglove/rosmsg, @foxglove/rosmsg2-serialization and ws.

import { spawn } from "node:child_process";
import fs from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";

const [koseki, folder, node] = process.argv.slice(2);
const require = createRequire(path.resolve(node, "package.json"));
const { FoxgloveClient } = require("@foxglove/ws-protocol");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");
const { WebSocket } = require("ws");

const SAMPLES_LEAST = 100;
const SUBPROTOCOLS = ["foxglove.websocket.v1", "foxglove.sdk.v1"];

/** Runs the demonstration; `meanwhile` gets the address of the display. */
async function run(meanwhile) {
  const config = path.join(import.meta.dirname, "..", "config", "demo.toml");
  const words = ["up", config, "--instance", "ci-foxglove", "--for", "12", "--out", path.join(folder, "run")];
  const keys = ["recorder.enabled=true", 'recorder.format=["csv"]', 'display.listen="127.0.0.1:8920"', "display.more_ports=50"];
  const deployment = spawn(koseki, [...words, ...keys.flatMap((key) => ["--set", key])]);
  let said = "";
  const address = new Promise((resolve) => {
    for (const stream of [deployment.stdout, deployment.stderr]) {
      stream.on("data", (text) => {
        said += text;
        const found = /the picture is at http:\/\/([^/]*)\//.exec(said);
        if (found) resolve(found[1]);
      });
    }
  });
  const ended = new Promise((resolve) => deployment.on("close", resolve));
  const result = await Promise.race([address.then(meanwhile), ended.then(() => null)]);
  const code = await ended;
  if (code !== 0 || result === null) throw new Error(said);
  return result;
}

/** The first samples of the system tracks, decoded. */
function samples(address, subprotocol) {
  return new Promise((resolve, reject) => {
    const socket = new WebSocket(`ws://${address}/foxglove`, [subprotocol]);
    const client = new FoxgloveClient({ ws: socket });
    const found = [];
    let reader;
    client.on("error", reject);
    client.on("status", (status) => reject(new Error(status.message)));
    client.on("close", () => reject(new Error(`${subprotocol}: closed after ${found.length} samples`)));
    client.on("advertise", (channels) => {
      const channel = channels.find(({ topic }) => topic === "system/tracks");
      if (socket.protocol !== subprotocol) reject(new Error(`${subprotocol}: ${socket.protocol} was selected`));
      if (channel.encoding !== "cdr" || channel.schemaName !== "koseki/msg/SystemTrack") {
        reject(new Error(`${channel.encoding} ${channel.schemaName}`));
      }
      reader = new MessageReader(parse(channel.schema, { ros2: true }));
      client.subscribe(channel.id);
    });
    client.on("message", ({ data }) => {
      found.push(reader.readMessage(data));
      if (found.length === SAMPLES_LEAST) {
        resolve(found);
        client.close();
      }
    });
  });
}

/** Recorded positions by track number and time in milliseconds. */
function recorded(file) {
  const [head, ...lines] = fs.readFileSync(file, "utf8").trim().split("\n");
  const columns = head.split(",");
  const at = (row, name) => Number(row[columns.indexOf(name)]);
  const states = new Map();
  for (const line of lines) {
    const row = line.split(",");
    const key = `${at(row, "system_track_id")} ${Math.trunc(at(row, "time_s") * 1000)}`;
    states.set(key, [...(states.get(key) ?? []), ["x", "y", "z"].map((name) => at(row, name))]);
  }
  return states;
}

const DAY_MS = 86_400_000;
fs.mkdirSync(folder, { recursive: true });
const all = await run((address) => Promise.all(SUBPROTOCOLS.map((subprotocol) => samples(address, subprotocol))));
const states = recorded(path.join(folder, "run", "latest", "system_tracks.csv"));
let wrong = 0;
for (const sample of all.flat()) {
  const time_ms = Number(sample.reference_time_ns / 1_000_000n) % DAY_MS;
  const near = [time_ms - 1, time_ms, time_ms + 1].flatMap((time) => states.get(`${sample.track_number} ${time}`) ?? []);
  const agrees = near.some((position) => position.every((value, axis) => Math.abs(value - sample.position_m[axis]) < 0.01));
  if (!agrees) wrong += 1;
}
console.log(`${all.flat().length} system tracks read in ${SUBPROTOCOLS.join(" and ")}, ${wrong} are not recorded so`);
process.exit(wrong === 0 ? 0 : 1);

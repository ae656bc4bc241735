/** Start of the page. */

import { App } from "./app.js";
import { Connection } from "./connection.js";
import { control } from "./controls.js";
import { groundOf } from "./ground.js";
import { openingAddress, unknownIn } from "./kept.js";
import { overlaysOf } from "./maps.js";
import { controlLabels } from "./nudge.js";
import { TrailRequests } from "./trails.js";

/** Start view of the configuration; none where the server does not answer. */
async function startView() {
  const answer = await fetch("api/views.json").catch(() => null);
  return answer?.ok ? String((await answer.json()).start) : "";
}

const start = await startView();
const opening = openingAddress(start);
if (location.hash.length <= 1) history.replaceState(null, "", opening);
const connection = new Connection();
const app = new App(() => connection.ask());
control(app);
controlLabels(app);
const trails = new TrailRequests(app);
app.onLeap = (time) => void trails.ask(time).catch((error) => console.error(error));
connection.start(app);
app.notice(unknownIn(start));
// For the browser's console, and for tests.
Object.assign(globalThis, { koseki: app });

/** Fetches what lies under the tracks; the page works without. */
async function fetchGround() {
  const ground = await fetch("coast");
  if (ground.ok) app.ground = groundOf(await ground.arrayBuffer());
  const overlays = await fetch("api/overlays.json");
  if (overlays.ok) app.overlays = (await overlays.json()).overlays.flatMap(overlaysOf);
  app.dirty = true;
}
app.onOrigin = () => void fetchGround().catch((error) => console.error(error));

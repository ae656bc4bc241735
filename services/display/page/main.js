/** Start of the page. */

import { App } from "./app.js";
import { Connection } from "./connection.js";
import { control } from "./controls.js";
import { groundOf } from "./ground.js";
import { overlaysOf } from "./maps.js";
import { TrailRequests } from "./trails.js";

const connection = new Connection();
const app = new App(() => connection.ask());
control(app);
const trails = new TrailRequests(app);
app.onLeap = (time) => void trails.ask(time).catch((error) => console.error(error));
connection.start(app);
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

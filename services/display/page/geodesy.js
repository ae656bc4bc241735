/**
 * Latitude and longitude of a point of the system frame, and bearings and distances for people.
 *
 * The frame is the plane that touches WGS-84 at the origin. A point of the map is taken to lie on the ellipsoid: the
 * line through it, parallel to the origin's vertical, meets the ellipsoid where a quadratic equation says.
 */

const SEMI_MAJOR_M = 6378137;
const FLATTENING = 1 / 298.257223563;
const SEMI_MINOR_M = SEMI_MAJOR_M * (1 - FLATTENING);
const ECCENTRICITY_2 = FLATTENING * (2 - FLATTENING);

export const NAUTICAL_MILE_M = 1852;
export const FOOT_M = 0.3048;
export const KNOT_MPS = NAUTICAL_MILE_M / 3600;

/** @typedef {{latitude_deg: number, longitude_deg: number, height_m: number}} Place */

/**
 * Place on the ellipsoid above or below a point of the system frame; `null` beyond the horizon of the map.
 * @param {Place} origin @param {number} east metres @param {number} north metres
 * @param {number} [height] Of the point above the ellipsoid, metres.
 * @returns {{latitude_deg: number, longitude_deg: number} | null}
 */
export function placeOf(origin, east, north, height = 0) {
  const latitude = (origin.latitude_deg * Math.PI) / 180;
  const longitude = (origin.longitude_deg * Math.PI) / 180;
  const [sinLat, cosLat] = [Math.sin(latitude), Math.cos(latitude)];
  const [sinLon, cosLon] = [Math.sin(longitude), Math.cos(longitude)];
  const prime = SEMI_MAJOR_M / Math.sqrt(1 - ECCENTRICITY_2 * sinLat * sinLat);
  const up = [cosLat * cosLon, cosLat * sinLon, sinLat];
  const point = [
    (prime + origin.height_m) * up[0] - sinLon * east - sinLat * cosLon * north,
    (prime + origin.height_m) * up[1] + cosLon * east - sinLat * sinLon * north,
    (prime * (1 - ECCENTRICITY_2) + origin.height_m) * up[2] + cosLat * north,
  ];
  // What is at a height lies on an ellipsoid that is so much larger.
  const axes = [SEMI_MAJOR_M + height, SEMI_MAJOR_M + height, SEMI_MINOR_M + height];
  let square = 0;
  let half = 0;
  let rest = -1;
  for (let k = 0; k < 3; k++) {
    const axis = axes[k] * axes[k];
    square += (up[k] * up[k]) / axis;
    half += (up[k] * point[k]) / axis;
    rest += (point[k] * point[k]) / axis;
  }
  const root = half * half - square * rest;
  if (!(root >= 0)) return null;
  const lift = (-half + Math.sqrt(root)) / square;
  const [x, y, z] = point.map((value, k) => value + lift * up[k]);
  return {
    latitude_deg: (Math.atan2(z * (axes[0] / axes[2]) ** 2, Math.hypot(x, y)) * 180) / Math.PI,
    longitude_deg: (Math.atan2(y, x) * 180) / Math.PI,
  };
}

/**
 * Path on the ellipsoid between two points of the system frame: its length, and the true bearings of each from the other
 * (normal sections, within 0.001° and a metre of the geodesic over 500 km); `null` beyond the horizon of the map.
 * @param {Place} origin @param {{east: number, north: number}} from @param {{east: number, north: number}} to
 * @param {number} [fromHeight] metres @param {number} [toHeight] metres
 * @returns {{range: number, there: number, back: number} | null} Metres, degrees.
 */
export function pathBetween(origin, from, to, fromHeight = 0, toHeight = 0) {
  const a = placeOf(origin, from.east, from.north, fromHeight);
  const b = placeOf(origin, to.east, to.north, toHeight);
  if (!a || !b) return null;
  const there = sectionOf(a, b);
  // Radius of curvature in the middle, in the direction of the path (Euler).
  const latitude = (((a.latitude_deg + b.latitude_deg) / 2) * Math.PI) / 180;
  const flat = 1 - ECCENTRICITY_2 * Math.sin(latitude) ** 2;
  const across = SEMI_MAJOR_M / Math.sqrt(flat);
  const along = (across * (1 - ECCENTRICITY_2)) / flat;
  const back = sectionOf(b, a).bearing;
  const middle = (((there.bearing + back + 180) / 2) * Math.PI) / 180;
  const radius = 1 / (Math.cos(middle) ** 2 / along + Math.sin(middle) ** 2 / across);
  return { range: 2 * radius * Math.asin(there.chord / (2 * radius)), there: there.bearing, back };
}

/**
 * Chord from one place on the ellipsoid to another, metres, and its bearing, degrees.
 * @param {{latitude_deg: number, longitude_deg: number}} from @param {{latitude_deg: number, longitude_deg: number}} to
 */
function sectionOf(from, to) {
  const [x, y, z] = earthCentred(to).map((value, k) => value - earthCentred(from)[k]);
  const latitude = (from.latitude_deg * Math.PI) / 180;
  const longitude = (from.longitude_deg * Math.PI) / 180;
  const outward = Math.cos(longitude) * x + Math.sin(longitude) * y;
  const east = -Math.sin(longitude) * x + Math.cos(longitude) * y;
  const north = -Math.sin(latitude) * outward + Math.cos(latitude) * z;
  return { chord: Math.hypot(x, y, z), bearing: bearing(east, north) };
}

/** @param {{latitude_deg: number, longitude_deg: number}} place @returns {number[]} metres */
function earthCentred({ latitude_deg, longitude_deg }) {
  const [latitude, longitude] = [(latitude_deg * Math.PI) / 180, (longitude_deg * Math.PI) / 180];
  const prime = SEMI_MAJOR_M / Math.sqrt(1 - ECCENTRICITY_2 * Math.sin(latitude) ** 2);
  return [
    prime * Math.cos(latitude) * Math.cos(longitude),
    prime * Math.cos(latitude) * Math.sin(longitude),
    prime * (1 - ECCENTRICITY_2) * Math.sin(latitude),
  ];
}

/**
 * Bearing, degrees clockwise from north in [0, 360), of a difference in metres.
 * @param {number} east @param {number} north
 */
export function bearing(east, north) {
  return ((Math.atan2(east, north) * 180) / Math.PI + 360) % 360;
}

const degreesText = (/** @type {number} */ degrees) => `${String(Math.round(degrees) % 360).padStart(3, "0")}°`;

/**
 * Magnetic bearing: 018°M.
 * @param {number} degrees True bearing. @param {number} declination Degrees, east positive.
 */
export function magneticText(degrees, declination) {
  return `${degreesText((degrees - declination + 720) % 360)}M`;
}

/**
 * True bearing, and the magnetic one where the declination is known: 020° / 018°M.
 * @param {number} degrees @param {number} declination NaN: unknown.
 */
export function courseText(degrees, declination) {
  const magnetic = Number.isFinite(declination) ? ` / ${magneticText(degrees, declination)}` : "";
  return degreesText(degrees) + magnetic;
}

/**
 * Degrees, minutes and seconds: 41°17′49″N.
 * @param {number} degrees @param {string} positive @param {string} negative
 */
export function sexagesimal(degrees, positive, negative) {
  const seconds = Math.round(Math.abs(degrees) * 3600);
  const two = (/** @type {number} */ n) => String(n).padStart(2, "0");
  const whole = `${Math.floor(seconds / 3600)}°${two(Math.floor(seconds / 60) % 60)}′${two(seconds % 60)}″`;
  return whole + (degrees >= 0 ? positive : negative);
}

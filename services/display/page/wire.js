/**
 * Reader of pictures. Written from the tables of crate `messages`; a test keeps it true, `UPDATE_GOLDEN=1` renews it.
 */

const LITTLE = true;

/** Bits. */
export const PICTURE = Object.freeze({
  /** The picture is complete and replaces all earlier data. */
  FULL: 1,
  /** The picture is of the past. */
  PAST: 2,
  /** Time stands still in it. */
  PAUSED: 4,
  /** Fusion is silent. */
  FUSION_SILENT: 8,
});

/** Bits. */
export const PICTURE_TRACK = Object.freeze({
  /** A source reports that the target is on the ground. */
  ON_GROUND: 1,
  /** The height is known. */
  HEIGHT: 2,
  /** The velocity is known. */
  VELOCITY: 4,
  /** The target climbs. */
  CLIMBS: 8,
  /** The target descends. */
  SINKS: 16,
  /** The height is that of the transponder's level: pressure altitude against 1013.25 hPa. */
  LEVEL: 32,
  /** The height is an altitude above mean sea level by the pressure of the region (QNH). */
  ALTITUDE: 64,
});

/** Bits. */
export const PICTURE_STATION = Object.freeze({
  /** The station is a base station; else an aid to navigation. */
  BASE: 1,
  /** The aid is not there: a station ashore sends for it. */
  VIRTUAL: 2,
  /** The aid, which floats, is off its position. */
  OFF_POSITION: 4,
});

/** Bits. */
export const IDENTITY = Object.freeze({
  /** `mode_3a` holds a Mode 3/A code. */
  MODE_3A: 1,
  /** `callsign` holds a callsign. */
  CALLSIGN: 2,
  /** `name` holds a name. */
  NAME: 4,
});

/** Bits. */
export const ALERT = Object.freeze({
  /** Special position identification: the pilot has pressed the button. */
  SPECIAL_IDENTIFICATION: 1,
  /** An emergency of any kind; Mode 3/A code 7700. */
  EMERGENCY: 2,
  /** Radio communication has failed; code 7600. */
  COMMUNICATION_FAILURE: 4,
  /** Unlawful interference; code 7500. */
  UNLAWFUL_INTERFERENCE: 8,
  /** Medical flight. */
  MEDICAL: 16,
  /** Minimum fuel. */
  MINIMUM_FUEL: 32,
  /** The Mode 3/A code was changed lately, or the transponder raises its alert for another reason. */
  TRANSPONDER_ALERT: 64,
  /** A collision avoidance system advises the crew to manoeuvre. */
  RESOLUTION_ADVISORY: 128,
});

/** Words by code. @type {Readonly<Record<number, string>>} */
export const TRACK_STATE = Object.freeze({
  /** Seen, not yet believed. */
  0: "tentative",
  /** Believed, and supported by recent reports. */
  1: "confirmed",
  /** Believed, but carried on by extrapolation for want of reports. */
  2: "coasted",
  /** Ended; the number is not used again soon. */
  3: "terminated",
  /** No longer reported by any source: not shown, while the number rests and may resume. */
  4: "suspended",
});

/** Words by code. @type {Readonly<Record<number, string>>} */
export const TRACK_KIND = Object.freeze({
  /** One target. */
  0: "single",
  /** Several unresolved targets (WA-7). */
  1: "group",
});

/** Words by code. @type {Readonly<Record<number, string>>} */
export const IDENTITY_KIND = Object.freeze({
  /** No number is known. */
  0: "none",
  /** 24-bit aircraft address. */
  1: "aircraft",
  /** 30-bit Maritime Mobile Service Identity (MMSI). */
  2: "ship",
});

/** Words by code. @type {Readonly<Record<number, string>>} */
export const PICTURE_AREA_KIND = Object.freeze({
  /** Count of targets around a place, by a wide-area sensor. */
  0: "count",
  /** Region in which a sensor should look for a track. */
  1: "cue",
});

/** Words by code. @type {Readonly<Record<number, string>>} */
export const AID_KIND = Object.freeze({
  /** Nothing is stated. */
  0: "unknown",
  /** Reference point. */
  1: "reference-point",
  /** Radar beacon. */
  2: "racon",
  /** Fixed structure off shore: oil platform, wind farm. */
  3: "structure",
  /** Emergency wreck marking buoy. */
  4: "wreck",
  /** Light without sectors. */
  5: "light",
  /** Light with sectors. */
  6: "sector-light",
  /** Front leading light. */
  7: "front-light",
  /** Rear leading light. */
  8: "rear-light",
  /** Beacon, cardinal north. */
  9: "north-beacon",
  /** Beacon, cardinal east. */
  10: "east-beacon",
  /** Beacon, cardinal south. */
  11: "south-beacon",
  /** Beacon, cardinal west. */
  12: "west-beacon",
  /** Beacon, port hand. */
  13: "port-beacon",
  /** Beacon, starboard hand. */
  14: "starboard-beacon",
  /** Beacon, preferred channel port hand. */
  15: "preferred-port-beacon",
  /** Beacon, preferred channel starboard hand. */
  16: "preferred-starboard-beacon",
  /** Beacon, isolated danger. */
  17: "danger-beacon",
  /** Beacon, safe water. */
  18: "safe-water-beacon",
  /** Beacon, special mark. */
  19: "special-beacon",
  /** Floating mark, cardinal north. */
  20: "north-mark",
  /** Floating mark, cardinal east. */
  21: "east-mark",
  /** Floating mark, cardinal south. */
  22: "south-mark",
  /** Floating mark, cardinal west. */
  23: "west-mark",
  /** Floating mark, port hand. */
  24: "port-mark",
  /** Floating mark, starboard hand. */
  25: "starboard-mark",
  /** Floating mark, preferred channel port hand. */
  26: "preferred-port-mark",
  /** Floating mark, preferred channel starboard hand. */
  27: "preferred-starboard-mark",
  /** Floating mark, isolated danger. */
  28: "danger-mark",
  /** Floating mark, safe water. */
  29: "safe-water-mark",
  /** Floating mark, special. */
  30: "special-mark",
  /** Light vessel, large navigational buoy, or rig. */
  31: "light-vessel",
});

/** Text of `length` octets without its padding. @param {DataView} view @param {number} at @param {number} length */
function text(view, at, length) {
  let out = "";
  for (let k = 0; k < length; k++) out += String.fromCharCode(view.getUint8(at + k));
  return out.replace(/[ \0]+$/, "");
}

/**
 * @typedef {object} PictureHeader
 * @property {number} time_ns Time of the picture, UTC, nanoseconds since 1970.
 * @property {number} sequence Sequence number among the pictures of one reader.
 * @property {number} flags Flags: see `picture_bits`.
 * @property {number} removed Numbers of system tracks that are terminated, or left the reader's selection.
 * @property {number} tracks Records `PictureTrack`.
 * @property {number} identities Records `PictureIdentity`.
 * @property {number} sensor_tracks Records `PictureSensorTrack`.
 * @property {number} detections Records `PictureDetection`.
 * @property {number} bearings Records `PictureBearing`.
 * @property {number} areas Records `PictureArea`.
 * @property {number} stations Records `PictureStation`.
 */

/** @param {DataView} view @param {number} at @returns {PictureHeader} */
export function readPictureHeader(view, at) {
  return {
    time_ns: Number(view.getBigInt64(at, LITTLE)),
    sequence: view.getUint32(at + 8, LITTLE),
    flags: view.getUint32(at + 12, LITTLE),
    removed: view.getUint32(at + 16, LITTLE),
    tracks: view.getUint32(at + 20, LITTLE),
    identities: view.getUint32(at + 24, LITTLE),
    sensor_tracks: view.getUint32(at + 28, LITTLE),
    detections: view.getUint32(at + 32, LITTLE),
    bearings: view.getUint32(at + 36, LITTLE),
    areas: view.getUint32(at + 40, LITTLE),
    stations: view.getUint32(at + 44, LITTLE),
  };
}

/**
 * @typedef {object} PictureTrack
 * @property {number} number System-track number.
 * @property {number} age_ms Age of the state, milliseconds.
 * @property {number} east_m Metres east.
 * @property {number} north_m Metres north.
 * @property {number} height_m Height that is shown, metres: the transponder's level, else the height above the ellipsoid; NaN: unknown.
 * @property {number} east_mps Speed east, metres per second.
 * @property {number} north_mps Speed north, metres per second.
 * @property {number} climb_mps Rate of the height above the ellipsoid, metres per second; NaN: unknown.
 * @property {number} semi_major_m Longer half axis of the ellipse of one standard deviation, metres; 0: unknown.
 * @property {number} semi_minor_m Shorter half axis, metres.
 * @property {number} semi_major_rad Direction of the longer one, radians clockwise from north, in [0, pi).
 * @property {number} sources_low Sources that contribute: bit n for number n, from 0 to 31.
 * @property {number} sources_high Sources that contribute: bit n for number 32 + n.
 * @property {number} main_source Source with the largest weight; 65535 if none contributes.
 * @property {number} source_count How many sources contribute.
 * @property {number} members Expected number of members of a group; 0 for a single target, 255: as many or more.
 * @property {number} state State: a `TrackState` code.
 * @property {number} kind Kind of the tracked object: a `TrackKind` code.
 * @property {number} alerts Alerts of the contributing sources: see `alert_bits`.
 * @property {number} flags Flags: see `picture_track_bits`.
 * @property {number} measured_age_ms Age of the latest measurement behind the state, milliseconds.
 */

/** @param {DataView} view @param {number} at @returns {PictureTrack} */
export function readPictureTrack(view, at) {
  return {
    number: view.getUint32(at, LITTLE),
    age_ms: view.getInt32(at + 4, LITTLE),
    east_m: view.getFloat32(at + 8, LITTLE),
    north_m: view.getFloat32(at + 12, LITTLE),
    height_m: view.getFloat32(at + 16, LITTLE),
    east_mps: view.getFloat32(at + 20, LITTLE),
    north_mps: view.getFloat32(at + 24, LITTLE),
    climb_mps: view.getFloat32(at + 28, LITTLE),
    semi_major_m: view.getFloat32(at + 32, LITTLE),
    semi_minor_m: view.getFloat32(at + 36, LITTLE),
    semi_major_rad: view.getFloat32(at + 40, LITTLE),
    sources_low: view.getUint32(at + 44, LITTLE),
    sources_high: view.getUint32(at + 48, LITTLE),
    main_source: view.getUint16(at + 52, LITTLE),
    source_count: view.getUint8(at + 54),
    members: view.getUint8(at + 55),
    state: view.getUint8(at + 56),
    kind: view.getUint8(at + 57),
    alerts: view.getUint8(at + 58),
    flags: view.getUint8(at + 59),
    measured_age_ms: view.getInt32(at + 60, LITTLE),
  };
}

/**
 * @typedef {object} PictureIdentity
 * @property {number} number System-track number.
 * @property {number} address 24-bit aircraft address or 30-bit MMSI (see `kind`), an integer.
 * @property {number} mode_3a Mode 3/A code, an integer of twelve bits.
 * @property {number} kind Kind of `address`: an `IdentityKind` code.
 * @property {number} valid Fields that hold something: see `identity_bits`.
 * @property {string} callsign Callsign in ASCII, padded with blanks.
 * @property {string} name Name in ASCII, padded with blanks.
 * @property {string} type_name Name of the type in ASCII, padded with blanks.
 * @property {number} type_confidence Probability that it is of that type, in (0, 1]; 0 where no type is known.
 */

/** @param {DataView} view @param {number} at @returns {PictureIdentity} */
export function readPictureIdentity(view, at) {
  return {
    number: view.getUint32(at, LITTLE),
    address: view.getUint32(at + 4, LITTLE),
    mode_3a: view.getUint16(at + 8, LITTLE),
    kind: view.getUint8(at + 10),
    valid: view.getUint8(at + 11),
    callsign: text(view, at + 12, 8),
    name: text(view, at + 20, 20),
    type_name: text(view, at + 40, 12),
    type_confidence: view.getFloat32(at + 52, LITTLE),
  };
}

/**
 * @typedef {object} PictureSensorTrack
 * @property {number} track_number Number of the sensor track at its source.
 * @property {number} age_ms Age of the report, milliseconds.
 * @property {number} east_m Metres east.
 * @property {number} north_m Metres north.
 * @property {number} height_m Height above the ellipsoid, metres; NaN: unknown.
 * @property {number} east_mps Speed east, metres per second.
 * @property {number} north_mps Speed north, metres per second.
 * @property {number} system_track System track to which it contributed last; 0: none is known.
 * @property {number} source Source.
 * @property {number} mode_3a Mode 3/A code; 65535: unknown.
 * @property {number} state State of the track at its source: a `TrackState` code.
 * @property {number} flags Flags: see `picture_track_bits`.
 */

/** @param {DataView} view @param {number} at @returns {PictureSensorTrack} */
export function readPictureSensorTrack(view, at) {
  return {
    track_number: view.getUint32(at, LITTLE),
    age_ms: view.getInt32(at + 4, LITTLE),
    east_m: view.getFloat32(at + 8, LITTLE),
    north_m: view.getFloat32(at + 12, LITTLE),
    height_m: view.getFloat32(at + 16, LITTLE),
    east_mps: view.getFloat32(at + 20, LITTLE),
    north_mps: view.getFloat32(at + 24, LITTLE),
    system_track: view.getUint32(at + 28, LITTLE),
    source: view.getUint16(at + 32, LITTLE),
    mode_3a: view.getUint16(at + 34, LITTLE),
    state: view.getUint8(at + 36),
    flags: view.getUint8(at + 37),
  };
}

/**
 * @typedef {object} PictureDetection
 * @property {number} age_ms Age of the detection, milliseconds.
 * @property {number} east_m Metres east.
 * @property {number} north_m Metres north.
 * @property {number} height_m Height above the ellipsoid, metres; NaN: unknown.
 * @property {number} source Source.
 */

/** @param {DataView} view @param {number} at @returns {PictureDetection} */
export function readPictureDetection(view, at) {
  return {
    age_ms: view.getInt32(at, LITTLE),
    east_m: view.getFloat32(at + 4, LITTLE),
    north_m: view.getFloat32(at + 8, LITTLE),
    height_m: view.getFloat32(at + 12, LITTLE),
    source: view.getUint16(at + 16, LITTLE),
  };
}

/**
 * @typedef {object} PictureBearing
 * @property {number} age_ms Age of the bearing, milliseconds.
 * @property {number} east_m Place from which it was measured, metres east.
 * @property {number} north_m Place from which it was measured, metres north.
 * @property {number} bearing_rad Direction, radians clockwise from north.
 * @property {number} sigma_rad Standard deviation of that, radians.
 * @property {number} source Source.
 */

/** @param {DataView} view @param {number} at @returns {PictureBearing} */
export function readPictureBearing(view, at) {
  return {
    age_ms: view.getInt32(at, LITTLE),
    east_m: view.getFloat32(at + 4, LITTLE),
    north_m: view.getFloat32(at + 8, LITTLE),
    bearing_rad: view.getFloat32(at + 12, LITTLE),
    sigma_rad: view.getFloat32(at + 16, LITTLE),
    source: view.getUint16(at + 20, LITTLE),
  };
}

/**
 * @typedef {object} PictureArea
 * @property {number} age_ms Age of the count, or of the time of the look, milliseconds; negative: that is to come.
 * @property {number} east_m Middle, metres east.
 * @property {number} north_m Middle, metres north.
 * @property {number} east_mps Speed east, metres per second.
 * @property {number} north_mps Speed north, metres per second.
 * @property {number} semi_major_m Longer half axis of a cue's region, metres.
 * @property {number} semi_minor_m Shorter half axis, metres.
 * @property {number} semi_major_rad Direction of the longer one, radians clockwise from north.
 * @property {number} number How many targets there were; of a cue, the number of the sensor track at its source.
 * @property {number} sensor Wide-area sensor; of a cue, the source that is to look.
 * @property {number} kind A `PictureAreaKind` code.
 */

/** @param {DataView} view @param {number} at @returns {PictureArea} */
export function readPictureArea(view, at) {
  return {
    age_ms: view.getInt32(at, LITTLE),
    east_m: view.getFloat32(at + 4, LITTLE),
    north_m: view.getFloat32(at + 8, LITTLE),
    east_mps: view.getFloat32(at + 12, LITTLE),
    north_mps: view.getFloat32(at + 16, LITTLE),
    semi_major_m: view.getFloat32(at + 20, LITTLE),
    semi_minor_m: view.getFloat32(at + 24, LITTLE),
    semi_major_rad: view.getFloat32(at + 28, LITTLE),
    number: view.getUint32(at + 32, LITTLE),
    sensor: view.getUint16(at + 36, LITTLE),
    kind: view.getUint8(at + 38),
  };
}

/**
 * @typedef {object} PictureStation
 * @property {number} age_ms Age of its latest report, milliseconds.
 * @property {number} east_m Metres east.
 * @property {number} north_m Metres north.
 * @property {number} length_m Length, metres; 0: unknown.
 * @property {number} width_m Width, metres; 0: unknown.
 * @property {number} mmsi MMSI.
 * @property {string} name Name in ASCII, padded with blanks; blank: unknown.
 * @property {number} source Source that has received the report.
 * @property {number} aid Kind of an aid to navigation: an `AidKind` code.
 * @property {number} flags Flags: see `picture_station_bits`.
 */

/** @param {DataView} view @param {number} at @returns {PictureStation} */
export function readPictureStation(view, at) {
  return {
    age_ms: view.getInt32(at, LITTLE),
    east_m: view.getFloat32(at + 4, LITTLE),
    north_m: view.getFloat32(at + 8, LITTLE),
    length_m: view.getFloat32(at + 12, LITTLE),
    width_m: view.getFloat32(at + 16, LITTLE),
    mmsi: view.getUint32(at + 20, LITTLE),
    name: text(view, at + 24, 20),
    source: view.getUint16(at + 44, LITTLE),
    aid: view.getUint8(at + 46),
    flags: view.getUint8(at + 47),
  };
}

/**
 * @typedef {object} PictureMessage
 * @property {PictureHeader} header
 * @property {number[]} removed Numbers of system tracks.
 * @property {PictureTrack[]} tracks
 * @property {PictureIdentity[]} identities
 * @property {PictureSensorTrack[]} sensor_tracks
 * @property {PictureDetection[]} detections
 * @property {PictureBearing[]} bearings
 * @property {PictureArea[]} areas
 * @property {PictureStation[]} stations
 */

/** @param {ArrayBuffer} octets @returns {PictureMessage} */
export function readPicture(octets) {
  const view = new DataView(octets);
  const header = readPictureHeader(view, 0);
  let at = 48;
  /**
   * @template T @param {number} count @param {number} size
   * @param {(view: DataView, at: number) => T} read @returns {T[]}
   */
  const block = (count, size, read) => {
    const records = [];
    for (let k = 0; k < count; k++, at += size) records.push(read(view, at));
    return records;
  };
  return {
    header,
    removed: block(header.removed, 4, (from, place) => from.getUint32(place, LITTLE)),
    tracks: block(header.tracks, 64, readPictureTrack),
    identities: block(header.identities, 56, readPictureIdentity),
    sensor_tracks: block(header.sensor_tracks, 40, readPictureSensorTrack),
    detections: block(header.detections, 20, readPictureDetection),
    bearings: block(header.bearings, 24, readPictureBearing),
    areas: block(header.areas, 40, readPictureArea),
    stations: block(header.stations, 52, readPictureStation),
  };
}

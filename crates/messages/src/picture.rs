//! Records of a picture for a display.
//!
//! A display shows thousands of tracks several times a second to distant users. The display therefore receives only
//! the visible attributes of each changed track. A picture consists of a [`PictureHeader`] and, one after another,
//! as many records of each kind as the header counts: numbers of removed tracks (`u32`), then [`PictureTrack`],
//! [`PictureIdentity`], [`PictureSensorTrack`], [`PictureDetection`], [`PictureBearing`], [`PictureArea`],
//! [`PictureStation`]. All numbers are little-endian. Times are ages: milliseconds from the time of the record to that
//! of the picture.

use std::fmt::Write as _;

use crate::codes::bits;
use crate::layout::{Layout, Sample, SampleField, sample};
use crate::{Constant, NO_SOURCE, codes};

bits! {
    /// Bits of [`PictureHeader::flags`].
    picture_bits: u32 {
        /// The picture is complete and replaces all earlier data.
        FULL = 1;
        /// The picture is of the past.
        PAST = 1 << 1;
        /// Time stands still in it.
        PAUSED = 1 << 2;
        /// Fusion is silent.
        FUSION_SILENT = 1 << 3;
    }
}

bits! {
    /// Bits of [`PictureTrack::flags`] and [`PictureSensorTrack::flags`].
    picture_track_bits: u8 {
        /// A source reports that the target is on the ground.
        ON_GROUND = 1;
        /// The height is known.
        HEIGHT = 1 << 1;
        /// The velocity is known.
        VELOCITY = 1 << 2;
        /// The target climbs.
        CLIMBS = 1 << 3;
        /// The target descends.
        SINKS = 1 << 4;
        /// The height is that of the transponder's level: pressure altitude against 1013.25 hPa.
        LEVEL = 1 << 5;
        /// The height is an altitude above mean sea level by the pressure of the region (QNH).
        ALTITUDE = 1 << 6;
    }
}

codes! {
    /// Kind of a [`PictureArea`].
    pub enum PictureAreaKind: u8 {
        /// Count of targets around a place, by a wide-area sensor.
        Count = 0, "count";
        /// Region in which a sensor should look for a track.
        Cue = 1, "cue";
    }
}

/// Value of [`PictureSensorTrack::mode_3a`] without a known code.
pub const NO_CODE: u16 = u16::MAX;

sample! {
    /// Start of a picture.
    PictureHeader, size 48 {
        /// Time of the picture, UTC, nanoseconds since 1970.
        time_ns: i64,
        /// Sequence number among the pictures of one reader.
        sequence: u32,
        /// Flags: see `picture_bits`.
        flags: u32,
        /// Numbers of system tracks that are terminated, or left the reader's selection.
        removed: u32,
        /// Records `PictureTrack`.
        tracks: u32,
        /// Records `PictureIdentity`.
        identities: u32,
        /// Records `PictureSensorTrack`.
        sensor_tracks: u32,
        /// Records `PictureDetection`.
        detections: u32,
        /// Records `PictureBearing`.
        bearings: u32,
        /// Records `PictureArea`.
        areas: u32,
        /// Records `PictureStation`.
        stations: u32,
    }
}

sample! {
    /// State of one system track.
    PictureTrack, size 64 {
        /// System-track number.
        number: u32,
        /// Age of the state, milliseconds.
        age_ms: i32,
        /// Metres east.
        east_m: f32,
        /// Metres north.
        north_m: f32,
        /// Height that is shown, metres: the transponder's level, else the height above the ellipsoid; NaN: unknown.
        height_m: f32,
        /// Speed east, metres per second.
        east_mps: f32,
        /// Speed north, metres per second.
        north_mps: f32,
        /// Rate of the height above the ellipsoid, metres per second; NaN: unknown.
        climb_mps: f32,
        /// Longer half axis of the ellipse of one standard deviation, metres; 0: unknown.
        semi_major_m: f32,
        /// Shorter half axis, metres.
        semi_minor_m: f32,
        /// Direction of the longer one, radians clockwise from north, in [0, pi).
        semi_major_rad: f32,
        /// Sources that contribute: bit n for number n, from 0 to 31.
        sources_low: u32,
        /// Sources that contribute: bit n for number 32 + n.
        sources_high: u32,
        /// Source with the largest weight; 65535 if none contributes.
        main_source: u16 = NO_SOURCE,
        /// How many sources contribute.
        source_count: u8,
        /// Expected number of members of a group; 0 for a single target, 255: as many or more.
        members: u8,
        /// State: a `TrackState` code.
        state: u8,
        /// Kind of the tracked object: a `TrackKind` code.
        kind: u8,
        /// Alerts of the contributing sources: see `alert_bits`.
        alerts: u8,
        /// Flags: see `picture_track_bits`.
        flags: u8,
        /// Age of the latest measurement behind the state, milliseconds.
        measured_age_ms: i32,
    }
}

sample! {
    /// Identity of one system track, sent on change.
    PictureIdentity, size 56 {
        /// System-track number.
        number: u32,
        /// 24-bit aircraft address or 30-bit MMSI (see `kind`), an integer.
        address: u32,
        /// Mode 3/A code, an integer of twelve bits.
        mode_3a: u16,
        /// Kind of `address`: an `IdentityKind` code.
        kind: u8,
        /// Fields that hold something: see `identity_bits`.
        valid: u8,
        /// Callsign in ASCII, padded with blanks.
        callsign: [u8; 8],
        /// Name in ASCII, padded with blanks.
        name: [u8; 20],
        /// Name of the type in ASCII, padded with blanks.
        type_name: [u8; 12],
        /// Probability that it is of that type, in (0, 1]; 0 where no type is known.
        type_confidence: f32,
    }
}

sample! {
    /// Report of one sensor track.
    PictureSensorTrack, size 40 {
        /// Number of the sensor track at its source.
        track_number: u32,
        /// Age of the report, milliseconds.
        age_ms: i32,
        /// Metres east.
        east_m: f32,
        /// Metres north.
        north_m: f32,
        /// Height above the ellipsoid, metres; NaN: unknown.
        height_m: f32,
        /// Speed east, metres per second.
        east_mps: f32,
        /// Speed north, metres per second.
        north_mps: f32,
        /// System track to which it contributed last; 0: none is known.
        system_track: u32,
        /// Source.
        source: u16,
        /// Mode 3/A code; 65535: unknown.
        mode_3a: u16 = NO_CODE,
        /// State of the track at its source: a `TrackState` code.
        state: u8,
        /// Flags: see `picture_track_bits`.
        flags: u8,
        /// Reserved, 0.
        reserved: u16,
    }
}

sample! {
    /// Position of one detection.
    PictureDetection, size 20 {
        /// Age of the detection, milliseconds.
        age_ms: i32,
        /// Metres east.
        east_m: f32,
        /// Metres north.
        north_m: f32,
        /// Height above the ellipsoid, metres; NaN: unknown.
        height_m: f32,
        /// Source.
        source: u16,
        /// Reserved, 0.
        reserved: u16,
    }
}

sample! {
    /// Bearing of a transmitter.
    PictureBearing, size 24 {
        /// Age of the bearing, milliseconds.
        age_ms: i32,
        /// Place from which it was measured, metres east.
        east_m: f32,
        /// Place from which it was measured, metres north.
        north_m: f32,
        /// Direction, radians clockwise from north.
        bearing_rad: f32,
        /// Standard deviation of that, radians.
        sigma_rad: f32,
        /// Source.
        source: u16,
        /// Reserved, 0.
        reserved: u16,
    }
}

sample! {
    /// Count of targets around a place, or region of a cue.
    PictureArea, size 40 {
        /// Age of the count, or of the time of the look, milliseconds; negative: that is to come.
        age_ms: i32,
        /// Middle, metres east.
        east_m: f32,
        /// Middle, metres north.
        north_m: f32,
        /// Speed east, metres per second.
        east_mps: f32,
        /// Speed north, metres per second.
        north_mps: f32,
        /// Longer half axis of a cue's region, metres.
        semi_major_m: f32,
        /// Shorter half axis, metres.
        semi_minor_m: f32,
        /// Direction of the longer one, radians clockwise from north.
        semi_major_rad: f32,
        /// How many targets there were; of a cue, the number of the sensor track at its source.
        number: u32,
        /// Wide-area sensor; of a cue, the source that is to look.
        sensor: u16,
        /// A `PictureAreaKind` code.
        kind: u8,
        /// Reserved, 0.
        reserved: u8,
    }
}

bits! {
    /// Bits of [`PictureStation::flags`].
    picture_station_bits: u8 {
        /// The station is a base station; else an aid to navigation.
        BASE = 1;
        /// The aid is not there: a station ashore sends for it.
        VIRTUAL = 1 << 1;
        /// The aid, which floats, is off its position.
        OFF_POSITION = 1 << 2;
    }
}

sample! {
    /// Station that is no target: base station or aid to navigation.
    PictureStation, size 52 {
        /// Age of its latest report, milliseconds.
        age_ms: i32,
        /// Metres east.
        east_m: f32,
        /// Metres north.
        north_m: f32,
        /// Length, metres; 0: unknown.
        length_m: f32,
        /// Width, metres; 0: unknown.
        width_m: f32,
        /// MMSI.
        mmsi: u32,
        /// Name in ASCII, padded with blanks; blank: unknown.
        name: [u8; 20],
        /// Source that has received the report.
        source: u16,
        /// Kind of an aid to navigation: an `AidKind` code.
        aid: u8,
        /// Flags: see `picture_station_bits`.
        flags: u8,
        /// Reserved, 0.
        reserved: u32,
    }
}

/// Record of a layer: sent on request, as it came, with its age.
pub trait LayerRecord: Sample {
    /// The layer.
    const LAYER: PictureLayer;

    /// Returns the record with this age, milliseconds.
    fn with_age(self, age_ms: i32) -> Self;

    /// Returns metres east and north, if only a reader whose view contains the place gets the record.
    fn place_m(&self) -> Option<[f32; 2]>;
}

/// Declares the layers in the order of their records in a picture: name, count in the header, record, and whether a
/// record belongs to a place of the view.
macro_rules! layers {
    ($( $(#[doc = $doc:literal])+ $layer:ident: $count:ident, $word:literal, $record:ident, $is_placed:literal; )+) => {
        codes! {
            /// Layer of a picture, shown on request.
            pub enum PictureLayer {
                $( $(#[doc = $doc])+ $layer, $word; )+
            }
        }

        $( impl LayerRecord for $record {
            const LAYER: PictureLayer = PictureLayer::$layer;

            fn with_age(self, age_ms: i32) -> Self {
                Self { age_ms, ..self }
            }

            fn place_m(&self) -> Option<[f32; 2]> {
                $is_placed.then_some([self.east_m, self.north_m])
            }
        } )+

        impl PictureLayer {
            /// Returns the size of a record, bytes.
            pub const fn size(self) -> usize {
                match self {
                    $( Self::$layer => size_of::<$record>(), )+
                }
            }
        }

        impl PictureHeader {
            /// Returns the number of records of a layer.
            pub fn count_mut(&mut self, layer: PictureLayer) -> &mut u32 {
                match layer {
                    $( PictureLayer::$layer => &mut self.$count, )+
                }
            }
        }

        /// Records of a picture: the header's count, and the layout.
        const BLOCKS: &[(&str, Layout)] = &[
            ("tracks", PictureTrack::LAYOUT),
            ("identities", PictureIdentity::LAYOUT),
            $( (stringify!($count), $record::LAYOUT), )+
        ];
    };
}

layers! {
    /// Latest report of each sensor track.
    SensorTracks: sensor_tracks, "sensor_tracks", PictureSensorTrack, true;
    /// Detections.
    Detections: detections, "detections", PictureDetection, true;
    /// Bearings, which reach beyond every view.
    Bearings: bearings, "bearings", PictureBearing, false;
    /// Counts of targets, and regions of cues.
    Areas: areas, "areas", PictureArea, false;
    /// Base stations and aids to navigation: few enough for every view to have all.
    Stations: stations, "stations", PictureStation, false;
}

/// Returns the reader of pictures in JavaScript, with the codes and bits in pictures.
pub fn javascript_module() -> String {
    let mut out = String::from(
        "/**\n * Reader of pictures. Written from the tables of crate `messages`; a test keeps it true, \
         `UPDATE_GOLDEN=1` renews it.\n */\n\nconst LITTLE = true;\n",
    );
    let bits: [(&str, &[Constant]); 5] = [
        ("PICTURE", picture_bits::CONSTANTS),
        ("PICTURE_TRACK", picture_track_bits::CONSTANTS),
        ("PICTURE_STATION", picture_station_bits::CONSTANTS),
        ("IDENTITY", crate::identity_bits::CONSTANTS),
        ("ALERT", crate::alert_bits::CONSTANTS),
    ];
    for (name, constants) in bits {
        let _ = writeln!(out, "\n/** Bits. */\nexport const {name} = Object.freeze({{");
        for constant in constants {
            let _ = writeln!(
                out,
                "  /** {} */\n  {}: {},",
                constant.doc, constant.word, constant.value
            );
        }
        out.push_str("});\n");
    }
    let codes = [
        ("TRACK_STATE", crate::TrackState::constants()),
        ("TRACK_KIND", crate::TrackKind::constants()),
        ("IDENTITY_KIND", crate::IdentityKind::constants()),
        ("PICTURE_AREA_KIND", PictureAreaKind::constants()),
        ("AID_KIND", crate::AidKind::constants()),
    ];
    for (name, constants) in codes {
        let _ = writeln!(
            out,
            "\n/** Words by code. @type {{Readonly<Record<number, string>>}} */\nexport const {name} = Object.freeze({{"
        );
        for constant in constants {
            let _ = writeln!(
                out,
                "  /** {} */\n  {}: \"{}\",",
                constant.doc, constant.value, constant.word
            );
        }
        out.push_str("});\n");
    }
    out.push_str(
        "\n/** Text of `length` octets without its padding. @param {DataView} view @param {number} at @param {number} length */\n\
         function text(view, at, length) {\n  let out = \"\";\n  for (let k = 0; k < length; k++) out += \
         String.fromCharCode(view.getUint8(at + k));\n  return out.replace(/[ \\0]+$/, \"\");\n}\n",
    );
    record(&PictureHeader::LAYOUT, &mut out);
    for (_, layout) in BLOCKS {
        record(layout, &mut out);
    }
    picture(&mut out);
    out
}

/// Writes the reader of one record, and its type.
fn record(layout: &Layout, out: &mut String) {
    let name = layout.name;
    let _ = writeln!(out, "\n/**\n * @typedef {{object}} {name}");
    for field in used(layout) {
        let kind = if field.kind.starts_with('[') {
            "string"
        } else {
            "number"
        };
        let _ = writeln!(out, " * @property {{{kind}}} {}{}", field.name, field.doc);
    }
    let _ = writeln!(
        out,
        " */\n\n/** @param {{DataView}} view @param {{number}} at @returns {{{name}}} */\nexport function \
         read{name}(view, at) {{\n  return {{"
    );
    for field in used(layout) {
        let (kind, count) = field.element();
        let at = match field.offset {
            0 => "at".to_owned(),
            offset => format!("at + {offset}"),
        };
        let value = match (kind, count) {
            ("u8", Some(count)) => format!("text(view, {at}, {count})"),
            ("u8", None) => format!("view.getUint8({at})"),
            ("i64", None) => format!("Number(view.getBigInt64({at}, LITTLE))"),
            ("i32", None) => format!("view.getInt32({at}, LITTLE)"),
            (float, None) if float.starts_with('f') => format!("view.getFloat{}({at}, LITTLE)", &float[1..]),
            (unsigned, _) => format!("view.getUint{}({at}, LITTLE)", &unsigned[1..]),
        };
        let _ = writeln!(out, "    {}: {value},", field.name);
    }
    out.push_str("  };\n}\n");
}

fn used(layout: &Layout) -> impl Iterator<Item = &SampleField> {
    layout.fields.iter().filter(|field| field.name != "reserved")
}

/// Writes the reader of a whole picture.
fn picture(out: &mut String) {
    out.push_str("\n/**\n * @typedef {object} PictureMessage\n * @property {PictureHeader} header\n");
    out.push_str(" * @property {number[]} removed Numbers of system tracks.\n");
    for (block, layout) in BLOCKS {
        let _ = writeln!(out, " * @property {{{}[]}} {block}", layout.name);
    }
    let _ = write!(
        out,
        " */\n\n/** @param {{ArrayBuffer}} octets @returns {{PictureMessage}} */\nexport function readPicture(octets) {{\n  \
         const view = new DataView(octets);\n  const header = readPictureHeader(view, 0);\n  let at = {};\n  \
         /**\n   * @template T @param {{number}} count @param {{number}} size\n   * @param {{(view: DataView, at: number) \
         => T}} read @returns {{T[]}}\n   */\n  const block = (count, size, read) => {{\n    const records = [];\n    for \
         (let k = 0; k < count; k++, at += size) records.push(read(view, at));\n    return records;\n  }};\n  return \
         {{\n    header,\n    removed: block(header.removed, 4, (from, place) => from.getUint32(place, LITTLE)),\n",
        PictureHeader::LAYOUT.size
    );
    for (block, layout) in BLOCKS {
        let _ = writeln!(
            out,
            "    {block}: block(header.{block}, {}, read{}),",
            layout.size, layout.name
        );
    }
    out.push_str("  };\n}\n");
}

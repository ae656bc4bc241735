//! Wire and file formats of sensors: bytes in, values out.
//!
//! A format is a pure function of its input: without files, sockets, clocks and threads. The same code serves the
//! live system, the replay of a recording and the command-line decoder, and every byte offset in an error is an
//! offset in the caller's bytes.
//!
//! - [`containers`]: containers of [`asterix`] recordings: network captures, recorders' frames;
//! - [`recording`]: a recording as a whole: its credible records, and statistics;
//! - [`foreign`]: kinds of files that are taken for recordings of ASTERIX and are none;
//! - [`observation`]: the meaning of ASTERIX target reports, as observations;
//! - [`feed`]: the data of a receiver in any of the following formats;
//! - [`sbs`]: lines of transponder receivers (SBS-1, BaseStation);
//! - [`ais`]: lines of receivers of ships' automatic identification (AIS);
//! - [`nmea`]: sentences of navigation receivers, compasses and radars on ships;
//! - [`mode_s`]: frames of transponders as radio receivers pass them on (Mode S, ADS-B);
//! - [`readsb`]: JSON of transponder receivers (readsb, dump1090, tar1090);
//! - [`remote_id`]: messages of unmanned aircraft about themselves (ASTM F3411);
//! - [`cot_events`]: events of Cursor on Target;
//! - [`target_message`]: the observations and statements of the last three;
//! - [`snapshot_datagram`]: snapshots of an antenna array in datagrams;
//! - [`autoferry`]: a public data set of detections;
//! - [`rows`]: tables of values, a row each, whatever their kind; each table declares its columns in one list;
//! - [`sensor_tracks_csv`], [`detections_csv`], [`bearings_csv`], [`emitter_rows_csv`], [`wide_area_csv`]:
//!   observations and sensor tracks as rows of text;
//! - [`named_columns`]: sensor tracks from tables in degrees, with the column names of others;
//! - [`plane`]: places in degrees in any of these tables, as places in the plane of a run;
//! - [`platform_states_csv`], [`cues_csv`], [`alarms_csv`], [`alerts_csv`], [`decisions_csv`], [`orders_csv`],
//!   [`statements_csv`]: what is written only;
//! - [`tracks_csv`]: system tracks, and tracks of a tracker, as output.

#![forbid(unsafe_code)]

pub mod ais;
pub mod alarms_csv;
pub mod alerts_csv;
pub mod autoferry;
pub mod bearings_csv;
mod cells;
mod columns;
pub mod containers;
pub mod cot_events;
pub mod cues_csv;
pub mod decisions_csv;
mod designated_velocity;
pub mod detections_csv;
pub mod emitter_rows_csv;
pub mod feed;
pub mod foreign;
mod identity_columns;
pub mod mode_s;
pub mod named_columns;
pub mod nmea;
pub mod observation;
mod on_board;
pub mod orders_csv;
mod parts;
pub mod plane;
pub mod platform_states_csv;
pub mod readsb;
pub mod recording;
pub mod remote_id;
mod replies;
pub mod rows;
pub mod sbs;
pub mod scan_rows_csv;
pub mod sensor_tracks_csv;
pub mod snapshot_datagram;
pub mod snapshots_csv;
pub mod statements_csv;
pub mod target_message;
mod text;
pub mod time_base;
pub mod tracks_csv;
pub mod wide_area_csv;

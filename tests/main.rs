//! Tests of the executable and of the repository as a whole, in one program: linking it is most of what they cost.
//!
//! One test at a time: `cargo test -p koseki --test integration NAME`, where NAME is a module's, or part of a test's.
//! They run side by side, so each has a folder, an instance and ports of its own (`common`).

mod common;

// The repository.
mod architecture;
mod dependencies;
mod documents;
mod requirements;

// Commands on files.
mod alerts;
mod bearings;
mod decode;
mod encode;
mod finder_reports;
mod foreign_inputs;
mod fuse;
mod golden;
mod helps;
mod identities;
mod late;
mod locate;
mod locate_arrivals;
mod locate_recordings;
mod mistakes;
mod named_columns;
mod named_rows;
mod on_board;
mod open;
mod processor;
mod score;
mod send;
mod simulate;
mod since_1970;
mod smooth;
mod track;
mod track_ferry;
mod track_with_counts;
mod worth_of_counts;

// Deployments: real processes.
mod alarms;
mod captures;
mod continuity;
mod deployment;
mod ended_sources;
mod feed_connections;
mod joint_tracker;
mod kills;
mod levels;
mod live_arrivals;
mod live_asterix;
mod live_bearings;
mod live_centres;
mod live_counts;
mod live_cues;
mod live_designations;
mod live_feed;
mod live_finder_on_board;
mod live_on_board;
mod live_plots;
mod live_refusals;
mod live_saved;
mod live_simulated_array;
mod live_snapshots;
mod normalised_errors;
mod orders;
mod planned_stop;
mod queues;
mod recording;
mod recordings_end;
mod replay;
mod report_truth;
mod supervision;
mod system_calls;
mod tap;
mod top;

// Recordings of real sensors.
mod held_out_sensor;
mod replay_barcelona;
mod round4;

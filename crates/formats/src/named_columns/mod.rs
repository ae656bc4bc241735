//! Sensor tracks and detections from tables whose columns bear the names that programs of the field use, in degrees or
//! metres.
//!
//! Archives of receivers have one report per row: time, latitude and longitude, speed and course, and the address of an
//! aircraft or the number of a ship. Each archive has names, units and marks of absent values of its own. Asking its
//! owner to convert the table to sensor tracks in metres (FM-5) means a plane, a covariance and a rotation of
//! velocities, before anything is seen.
//!
//! The list of the columns with names and units is [`csv_table::TARGET_COLUMNS`]; [`TableOutline`] shows what a table
//! states before all of it is read; [`NamedTrackReader`] makes a sensor track of each row:
//!
//! - degrees are placed in the system frame, and velocities turned from north and east at the target into the frame;
//! - a row without `sigma_m` has the accuracy that the caller assumes for its source;
//! - an absent value stays unknown, and is never 0; an absent time, position or target refuses the row;
//! - the track has the number of its target (module `targets`).
//!
//! [`crate::scan_rows_csv`] makes detections of such rows (module `detections`).
//!
//! Limits: heights by pressure are taken for heights above the ellipsoid. A position without a height is placed as if
//! the target were on the ellipsoid; a high target far from the origin is then off by its height times the distance,
//! over the Earth's radius. Rows are in the order of time, and each report arrives at its time.
//!
//! [`has_named_columns`] decides by the header which tables are read in this way.

pub(crate) mod detections;
mod header;
mod outline;
mod reader;
#[cfg(test)]
mod reader_tests;
mod targets;

pub use header::{TargetNames, has_named_columns};
pub use outline::TableOutline;
pub use reader::{HEIGHT_SIGMA_M, NamedTrackColumns, NamedTrackReader, RowSource, VELOCITY_SIGMA_MPS};

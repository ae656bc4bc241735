//! The plane of the files of a command whose tables may be in degrees.

use std::io::Read;
use std::path::Path;

use formats::plane::{InPlane, Plane};
use formats::rows::RowReader;
use frames::{Geodetic, SystemFrame};

/// A plane that all files of a command have in common: of the given origin, or of the first place in degrees.
#[derive(Debug, Default)]
pub(crate) struct FilePlane {
    plane: Plane,
    /// What was assumed, a sentence.
    pub(crate) assumed: Option<String>,
    /// Whether outputs have places in degrees, because an origin was asked for, or was needed.
    is_placed: bool,
}

impl FilePlane {
    /// The plane of a given origin, else that of a configuration, else an open one.
    pub(crate) fn new(origin: Option<Geodetic>, configured: Option<SystemFrame>) -> Self {
        let frame = origin.map(SystemFrame::at).or(configured);
        Self {
            plane: frame.map_or(Plane::Open, Plane::Given),
            assumed: None,
            is_placed: origin.is_some(),
        }
    }

    /// Lends the plane to the reader of a file before its first row.
    pub(crate) fn lend<R: Read, C: InPlane>(&self, reader: &mut RowReader<R, C>) {
        *reader.plane() = self.plane;
    }

    /// Takes the plane back from the reader of a file, after its first row or its last one.
    pub(crate) fn take<R: Read, C: InPlane>(&mut self, path: &Path, reader: &mut RowReader<R, C>) {
        self.plane = *reader.plane();
        if let (None, Plane::FirstPlace(_, place, line)) = (&self.assumed, self.plane) {
            self.assumed = Some(assumed_origin(place, path, line));
            self.is_placed = true;
        }
    }

    /// The frame in which outputs have places in degrees, too.
    pub(crate) fn of_outputs(&self) -> Option<SystemFrame> {
        self.plane.frame().filter(|_| self.is_placed)
    }

    /// What was assumed, a line; empty without assumptions.
    pub(crate) fn as_text(&self) -> String {
        self.assumed.iter().map(|what| format!("assumed: {what}\n")).collect()
    }
}

/// The sentence on an origin that was taken from a line of a file.
pub(crate) fn assumed_origin(place: Geodetic, path: &Path, line: u64) -> String {
    format!(
        "origin of the plane: latitude {:.6}, longitude {:.6}, the first position of {} (line {line}), because none is \
         given; --origin sets another",
        place.latitude_deg(),
        place.longitude_deg(),
        path.display()
    )
}

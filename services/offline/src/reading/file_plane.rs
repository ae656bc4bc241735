//! The plane of the files of a command whose tables may be in degrees.

use std::io::Read;
use std::path::Path;

use formats::plane::{InPlane, Plane};
use formats::rows::RowReader;
use frames::{Geodetic, SystemFrame};

use super::RowPlace;
use crate::files::InputError;

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
            self.assumed = Some(assumed_origin(place, path, RowPlace::Line(line)));
            self.is_placed = true;
        }
    }

    /// The frame for a recording: of a finder at the place `stated`, or whose first place is `first`, of the record
    /// with this number.
    ///
    /// # Errors
    /// If files before have places in metres, or no place is known.
    pub(crate) fn frame_of_recording(
        &mut self,
        path: &Path,
        stated: Option<Geodetic>,
        first: Option<(Geodetic, u64)>,
    ) -> Result<SystemFrame, InputError> {
        match self.plane {
            Plane::Given(frame) | Plane::FirstPlace(frame, ..) => return Ok(frame),
            Plane::Metres => {
                let what = "has places in degrees, files before in metres; give --origin, from which the metres count";
                return Err(InputError::new(path, what));
            }
            Plane::Open => {}
        }
        let (place, record, assumed) = match (stated, first) {
            (Some(place), _) => {
                let assumed = "origin of the plane: the place of --place, because none is given; --origin sets another";
                (place, 0, assumed.to_owned())
            }
            (None, Some((place, record))) => (place, record, assumed_origin(place, path, RowPlace::Record(record))),
            (None, None) => {
                let what = "states no latitude and longitude (I205/050); give the finder's place, --place LAT,LON";
                return Err(InputError::new(path, what));
            }
        };
        let origin = Geodetic::from_degrees(place.latitude_deg(), place.longitude_deg(), 0.0);
        let origin = origin.map_err(|error| InputError::new(path, error))?;
        let frame = SystemFrame::at(origin);
        self.plane = Plane::FirstPlace(frame, origin, record);
        self.assumed = Some(assumed);
        self.is_placed = true;
        Ok(frame)
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

/// The sentence on an origin that was taken from a row of a file.
pub(crate) fn assumed_origin(place: Geodetic, path: &Path, row: RowPlace) -> String {
    format!(
        "origin of the plane: latitude {:.6}, longitude {:.6}, the first position of {} ({row}), because none is \
         given; --origin sets another",
        place.latitude_deg(),
        place.longitude_deg(),
        path.display()
    )
}

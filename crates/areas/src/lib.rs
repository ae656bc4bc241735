//! Areas of the ground, with floors and ceilings.
//!
//! An area is a polygon with holes or several, a circle, or an airspace of an aeronautical file. It lies on the
//! ellipsoid: its outline becomes points of the plane of the system frame at height 0, and a target is compared by the
//! place [below](below()) it. At a height of 10 km, 200 km from the origin, a target lies 300 m further out in the
//! plane than the ground below it.
//!
//! Sources: RFC 7946, *The GeoJSON Format* (sides are straight in longitude and latitude); the OpenAir format of
//! airspaces, by crate `openair`.

#![forbid(unsafe_code)]

mod geojson;
mod ground;
mod limits;
mod openair;
mod outline;

use thiserror::Error;

pub use ground::{Ground, below};
pub use limits::{Level, VerticalLimits};
pub use outline::Outline;

/// An area.
#[derive(Clone, Debug, PartialEq)]
pub struct Area {
    /// Name; "area 3" for the third area of a file that names none.
    pub name: String,
    /// Property `kind` of GeoJSON.
    pub kind: Option<String>,
    /// The area on the ground.
    pub outline: Outline,
    /// Floor and ceiling.
    pub limits: VerticalLimits,
}

/// An area that cannot be used.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{0}")]
pub struct AreaError(pub String);

impl Area {
    /// A circle about a place, longitude and latitude in degrees, with a radius in metres.
    ///
    /// # Errors
    /// If the place is none, or the circle is too large or too far from the origin of the frame.
    pub fn circle(name: &str, centre_deg: [f64; 2], radius_m: f64, ground: &Ground) -> Result<Self, AreaError> {
        Self::of_corners(name, &ground.circle(centre_deg, radius_m)?, ground)
    }

    /// A polygon by its corners in turn, longitude and latitude in degrees.
    ///
    /// # Errors
    /// If there are fewer than three corners, or one is no place or too far from the origin of the frame.
    pub fn of_corners(name: &str, corners_deg: &[[f64; 2]], ground: &Ground) -> Result<Self, AreaError> {
        if corners_deg.len() < 3 {
            return Err(AreaError("a polygon has three corners or more".to_owned()));
        }
        Ok(Self {
            name: name.to_owned(),
            kind: None,
            outline: Outline::new(vec![vec![ground.ring(corners_deg)?]]),
            limits: VerticalLimits::default(),
        })
    }
}

impl AreaError {
    fn of(number: usize, fault: impl std::fmt::Display) -> Self {
        Self(format!("area {number}: {fault}"))
    }
}

/// Reads the areas of a file: GeoJSON if the text begins like a document of JSON, else OpenAir.
///
/// # Errors
/// If the text is neither, or an area cannot be used: with the number of the area, and the remedy.
pub fn read(text: &str, ground: &Ground) -> Result<Vec<Area>, AreaError> {
    let areas = match text.trim_start_matches('\u{feff}').trim_start().starts_with(['{', '[']) {
        true => geojson::read(text, ground)?,
        false => openair::read(text, ground)?,
    };
    match areas.is_empty() {
        true => Err(AreaError("has no area".to_owned())),
        false => Ok(areas),
    }
}

//! Place of a target in an order, as a text of at most 32 bytes.
//!
//! An order has one word and one number besides its source. A place has two or three numbers, so it is the word, in the
//! form of the command line: records, lists and the event log show it as the operator has written it, and no sample
//! changes its layout. Course and speed of the target may follow in the same word.

/// Place that an order names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DesignatedPlace {
    /// On the globe.
    Globe {
        /// Degrees north.
        latitude_deg: f64,
        /// Degrees east.
        longitude_deg: f64,
        /// Height above the ellipsoid, metres; `None` if it is not known.
        height_m: Option<f64>,
    },
    /// In the system frame.
    Frame {
        /// East and north of the origin, metres.
        plane_m: [f64; 2],
        /// Above the origin, metres; `None` if it is not known.
        up_m: Option<f64>,
    },
}

/// Course and speed of a target, behind its place in an order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DesignatedCourse {
    /// Course over ground, degrees clockwise from north at the place, or from the system frame's.
    pub course_deg: f64,
    /// Speed over ground, metres per second.
    pub speed_mps: f64,
    /// Standard deviation of the velocity east and north, metres per second; `None` if it is not stated.
    pub sigma_mps: Option<f64>,
}

/// Farthest coordinate of a place in the system frame, metres.
const FARTHEST_M: f64 = 1e6;
/// Greatest height of a place, metres.
const HIGHEST_M: f64 = 1e5;
/// Greatest speed, and greatest standard deviation of a velocity, metres per second.
const FASTEST_MPS: f64 = 1e4;
/// Least standard deviation of a velocity, metres per second.
const SIGMA_MIN_MPS: f64 = 1e-3;

impl DesignatedPlace {
    /// Form of a place on command lines.
    pub const WORDS: &str = "LATITUDE,LONGITUDE[,HEIGHT][@COURSE/SPEED[/SIGMA]]";
    /// Form of a place, in one sentence.
    pub const FORM: &str = "write LATITUDE,LONGITUDE[,HEIGHT] in degrees and metres, or EASTm,NORTHm[,UPm] with the \
                            letter m; @COURSE/SPEED[/SIGMA] in degrees and m/s may follow; at most 32 characters \
                            in all";

    /// Reads a place, with the target's course if one follows; `None` if the text is none.
    pub fn read(text: &str) -> Option<(Self, Option<DesignatedCourse>)> {
        match text.split_once('@') {
            None => Some((Self::read_place(text)?, None)),
            Some((place, course)) => Some((Self::read_place(place)?, Some(DesignatedCourse::read(course)?))),
        }
    }

    fn read_place(text: &str) -> Option<Self> {
        let mut words = text.split(',');
        let [first, second] = [words.next()?, words.next()?];
        let third = words.next();
        if words.next().is_some() {
            return None;
        }
        let is_frame = first.ends_with('m');
        let number = |word: &str| match is_frame {
            true => number(word.strip_suffix('m')?),
            false => number(word),
        };
        let [one, other] = [number(first)?, number(second)?];
        let height = third.map(|word| number(word).filter(|height| height.abs() <= HIGHEST_M));
        let height = match height {
            None => None,
            Some(height) => Some(height?),
        };
        let limits = if is_frame { [FARTHEST_M; 2] } else { [90.0, 180.0] };
        if one.abs() > limits[0] || other.abs() > limits[1] {
            return None;
        }
        Some(match is_frame {
            true => Self::Frame {
                plane_m: [one, other],
                up_m: height,
            },
            false => Self::Globe {
                latitude_deg: one,
                longitude_deg: other,
                height_m: height,
            },
        })
    }
}

impl DesignatedCourse {
    fn read(text: &str) -> Option<Self> {
        let mut words = text.split('/');
        let course_deg = number(words.next()?).filter(|course| (0.0..=360.0).contains(course))?;
        let speed_mps = number(words.next()?).filter(|speed| (0.0..=FASTEST_MPS).contains(speed))?;
        let sigma_mps = match words.next() {
            None => None,
            Some(word) => Some(number(word).filter(|sigma| (SIGMA_MIN_MPS..=FASTEST_MPS).contains(sigma))?),
        };
        words.next().is_none().then_some(Self {
            course_deg,
            speed_mps,
            sigma_mps,
        })
    }

    /// Velocity to the right of north and along north, metres per second.
    pub fn velocity_mps(&self) -> [f64; 2] {
        let (sine, cosine) = self.course_deg.to_radians().sin_cos();
        [self.speed_mps * sine, self.speed_mps * cosine]
    }

    /// Standard deviation of the velocity, metres per second; if none is stated, a tenth of the speed, at least 1 m/s.
    pub fn sigma_mps(&self) -> f64 {
        self.sigma_mps.unwrap_or_else(|| (0.1 * self.speed_mps).max(1.0))
    }
}

/// A number in plain digits: no `inf`, `nan` or exponent.
fn number(word: &str) -> Option<f64> {
    let is_plain = word.bytes().all(|byte| byte.is_ascii_digit() || b"+-.".contains(&byte));
    word.parse().ok().filter(|_| is_plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_read_in_degrees_and_in_metres() {
        let globe = |height_m| DesignatedPlace::Globe {
            latitude_deg: 59.43,
            longitude_deg: -10.65,
            height_m,
        };
        let read = |text| DesignatedPlace::read(text).map(|(place, _)| place);
        assert_eq!(read("59.43,-10.65"), Some(globe(None)));
        assert_eq!(read("59.43,-10.65,120"), Some(globe(Some(120.0))));
        let frame = |up_m| DesignatedPlace::Frame {
            plane_m: [1200.0, -300.5],
            up_m,
        };
        assert_eq!(read("1200m,-300.5m"), Some(frame(None)));
        assert_eq!(read("1200m,-300.5m,80m"), Some(frame(Some(80.0))));
    }

    #[test]
    fn a_course_may_follow_a_place() {
        let course = |text| DesignatedPlace::read(text).unwrap().1;
        assert_eq!(course("59.43,-10.65"), None);
        let stated = course("59.43123,-10.65123@270/8.5/1.5").unwrap();
        assert_eq!(
            (stated.course_deg, stated.speed_mps, stated.sigma_mps()),
            (270.0, 8.5, 1.5)
        );
        let [east, north] = stated.velocity_mps();
        assert!((east + 8.5).abs() < 1e-9 && north.abs() < 1e-9);
        assert_eq!(course("0m,0m,80m@90/200").unwrap().sigma_mps(), 20.0);
        assert_eq!(course("0m,0m@90/2").unwrap().sigma_mps(), 1.0);
    }

    #[test]
    fn other_texts_are_no_places() {
        for text in [
            "",
            "1",
            "1,",
            "91,0",
            "0,181",
            "1m,2",
            "1,2m",
            "1,2,3,4",
            "inf,0",
            "1e3,0",
            "nan,0",
            "1m,2m,3",
            "0,0,1e6",
            "2000000m,0m",
            "0,0,200000",
            "a,b",
            "1;2",
            "1,2@",
            "1,2@90",
            "1,2@90/",
            "1,2@361/5",
            "1,2@-1/5",
            "1,2@90/-5",
            "1,2@90/20000",
            "1,2@90/5/0",
            "1,2@90/5/1/1",
            "1,2@90/5@90/5",
        ] {
            assert_eq!(DesignatedPlace::read(text), None, "{text}");
        }
    }
}

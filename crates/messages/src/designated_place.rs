//! Place of a target in an order, as a text of at most 32 bytes.
//!
//! An order has one word and one number besides its source. A place has two or three numbers, so it is the word, in the
//! form of the command line: records, lists and the event log show it as the operator has written it, and no sample
//! changes its layout.

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

/// Farthest coordinate of a place in the system frame, metres.
const FARTHEST_M: f64 = 1e6;
/// Greatest height of a place, metres.
const HIGHEST_M: f64 = 1e5;

impl DesignatedPlace {
    /// Form of a place on command lines.
    pub const WORDS: &str = "LATITUDE,LONGITUDE[,HEIGHT]";
    /// Form of a place, in one sentence.
    pub const FORM: &str = "write LATITUDE,LONGITUDE[,HEIGHT] in degrees and metres, or EASTm,NORTHm[,UPm] with the \
                            letter m, in at most 32 characters";

    /// Reads a place; `None` if the text is none.
    pub fn read(text: &str) -> Option<Self> {
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
        assert_eq!(DesignatedPlace::read("59.43,-10.65"), Some(globe(None)));
        assert_eq!(DesignatedPlace::read("59.43,-10.65,120"), Some(globe(Some(120.0))));
        let frame = |up_m| DesignatedPlace::Frame {
            plane_m: [1200.0, -300.5],
            up_m,
        };
        assert_eq!(DesignatedPlace::read("1200m,-300.5m"), Some(frame(None)));
        assert_eq!(DesignatedPlace::read("1200m,-300.5m,80m"), Some(frame(Some(80.0))));
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
        ] {
            assert_eq!(DesignatedPlace::read(text), None, "{text}");
        }
    }
}

//! Values of rows, each written by its kind.
//!
//! Whole numbers, words and text are written as they are. An `f64` is written with as many decimals as it takes to get
//! it back. `None` is written as an empty value.

use std::io::{self, Write};

use messages::NO_SOURCE;

use crate::rows::Reference;

/// Value of one column.
pub(crate) trait Cell {
    /// Writes the value, without a separator.
    ///
    /// # Errors
    /// If `out` fails.
    fn write(self, out: &mut impl Write, reference: &Reference) -> io::Result<()>;
}

macro_rules! whole_numbers {
    ($($value:ty),*) => { $( impl Cell for $value {
        fn write(self, out: &mut impl Write, _: &Reference) -> io::Result<()> {
            csv_table::write_whole(out, u64::from(self))
        }
    } )* };
}

whole_numbers!(u8, u16, u32, u64);

macro_rules! as_they_are {
    ($($value:ty),*) => { $( impl Cell for $value {
        fn write(self, out: &mut impl Write, _: &Reference) -> io::Result<()> {
            write!(out, "{self}")
        }
    } )* };
}

as_they_are!(f32, f64, crate::rows::Utc, crate::rows::Milliseconds, messages::Spelled);

impl Cell for &str {
    fn write(self, out: &mut impl Write, _: &Reference) -> io::Result<()> {
        out.write_all(self.as_bytes())
    }
}

impl<C: Cell> Cell for Option<C> {
    fn write(self, out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        self.map_or(Ok(()), |cell| cell.write(out, reference))
    }
}

/// Time, UTC, nanoseconds since 1970: seconds since the first day, exact to the nanosecond.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Time(pub(crate) i64);

impl Cell for Time {
    fn write(self, out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        reference.write_time(out, self.0)
    }
}

/// Time, UTC, nanoseconds since 1970: seconds since the first day, rounded to milliseconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RoundedTime(pub(crate) i64);

impl Cell for RoundedTime {
    fn write(self, out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        let time_s = frames::time::seconds(reference.since_first_day_ns(self.0));
        csv_table::write_decimals(out, time_s, 3)
    }
}

/// Source number: the id under which the file shows the source.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SensorId(pub(crate) u16);

impl SensorId {
    /// Returns the source of this number; `None` for the number that stands for no source.
    pub(crate) fn known(source: u16) -> Option<Self> {
        (source != NO_SOURCE).then_some(Self(source))
    }
}

impl Cell for SensorId {
    fn write(self, out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        reference.sensor_id(self.0).write(out, reference)
    }
}

/// Number with fixed decimals.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rounded(pub(crate) f64, pub(crate) usize);

impl Rounded {
    /// Returns the number with so many decimals; `None` if it is no number.
    pub(crate) fn known(value: f64, decimals: usize) -> Option<Self> {
        (!value.is_nan()).then_some(Self(value, decimals))
    }
}

impl Cell for Rounded {
    fn write(self, out: &mut impl Write, _: &Reference) -> io::Result<()> {
        csv_table::write_decimals(out, self.0, self.1)
    }
}

/// Number with fixed decimals, and no minus sign before zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plain(pub(crate) f64, pub(crate) usize);

impl Cell for Plain {
    fn write(self, out: &mut impl Write, _: &Reference) -> io::Result<()> {
        csv_table::write_plain(out, self.0, self.1)
    }
}

/// Values joined with `|`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellList<I>(pub(crate) I);

impl<I: IntoIterator<Item: Cell>> Cell for CellList<I> {
    fn write(self, out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        for (index, cell) in self.0.into_iter().enumerate() {
            if index > 0 {
                out.write_all(b"|")?;
            }
            cell.write(out, reference)?;
        }
        Ok(())
    }
}

/// Text from outside: separators, and characters other than visible ones of ASCII, are written as `?`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Untrusted<'a> {
    pub(crate) text: &'a str,
    /// Whether blanks are kept.
    pub(crate) has_blanks: bool,
}

impl Cell for Untrusted<'_> {
    fn write(self, out: &mut impl Write, _: &Reference) -> io::Result<()> {
        let is_visible = |character: u8| character.is_ascii_graphic() || self.has_blanks && character == b' ';
        self.text.bytes().try_for_each(|character| {
            let is_kept = is_visible(character) && !b",|\"".contains(&character);
            out.write_all(&[if is_kept { character } else { b'?' }])
        })
    }
}

/// Text in quotation marks where a table needs them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Text<'a>(pub(crate) &'a str);

impl Cell for Text<'_> {
    fn write(self, out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        match self.0.contains([',', '"']) {
            true => Quoted(self.0).write(out, reference),
            false => out.write_all(self.0.as_bytes()),
        }
    }
}

/// Text in quotation marks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quoted<'a>(pub(crate) &'a str);

impl Cell for Quoted<'_> {
    fn write(self, out: &mut impl Write, _: &Reference) -> io::Result<()> {
        write!(out, "\"{}\"", self.0.replace('"', "\"\""))
    }
}

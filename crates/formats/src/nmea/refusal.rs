//! The sentence that was refused last, in words.

use std::fmt;

use super::sentence::{NmeaFault, SENTENCE_OCTETS_MAX};

/// Characters of a sentence that are shown.
const SHOWN_MAX: usize = 60;

/// Refused sentence.
#[derive(Clone, Debug)]
pub struct NmeaRefusal {
    /// Why it was refused.
    pub fault: NmeaFault,
    /// Number, from 1 behind the name, of the field at which it was refused; 0 for the sentence as a whole.
    pub place: usize,
    /// The sentence without its end, or its begin.
    pub line: Vec<u8>,
}

impl Default for NmeaRefusal {
    fn default() -> Self {
        Self {
            fault: NmeaFault::NoSentence,
            place: 0,
            line: Vec::with_capacity(SENTENCE_OCTETS_MAX),
        }
    }
}

impl fmt::Display for NmeaRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let line = String::from_utf8_lossy(&self.line);
        let shown: String = line.chars().take(SHOWN_MAX).collect();
        write!(f, "sentence {shown:?}")?;
        let body = line.split('*').next().unwrap_or_default();
        if self.fault == NmeaFault::Field && self.place > 0 {
            let value = body.split(',').nth(self.place).unwrap_or_default();
            write!(f, ", field {} {value:?},", self.place)?;
        }
        write!(f, " {}", self.fault.sentence())
    }
}

impl NmeaFault {
    /// Returns the fault, and what is permitted.
    pub fn sentence(self) -> &'static str {
        match self {
            Self::NoSentence => "is no sentence of NMEA 0183; one begins with $ and is ASCII text",
            Self::Partial => "was cut, or has no checksum; a sentence ends in * and two hexadecimal digits",
            Self::Checksum => "has another checksum than its characters give; check the line, its speed and its parity",
            Self::Talker => "has an unknown talker; satellite receivers (GP, GN, …), compasses and gyros are known",
            Self::TooLong => "is longer than 256 characters; check the speed of the line",
            Self::Field => "cannot be meant: another form, outside its range, or without its letter",
            Self::NoFix => "states no valid fix or value; wait for the receiver, or check its antenna",
            Self::NoDate => "is more than a day from the time of receipt, or its day is unknown; check both clocks",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::reader::{NmeaReader, NmeaSettings};

    /// The words for the refusal of a line, whose checksum is added where it has none.
    fn refused(line: &str) -> String {
        let mut reader = NmeaReader::new(NmeaSettings {
            receipt_sigma_s: 0.1,
            heading_sigma_rad: 0.01,
        });
        let sum = line.bytes().skip(1).fold(0, |sum, octet| sum ^ octet);
        let whole = match line.contains('*') {
            true => line.to_owned(),
            false => format!("{line}*{sum:02X}"),
        };
        reader.take(whole.as_bytes(), Some(1_750_000_000_000_000_000), |_| {});
        reader.end(Some(1_750_000_000_000_000_000), |_| {});
        reader.refused().map(ToString::to_string).unwrap_or_default()
    }

    #[test]
    fn each_fault_is_named_with_its_field_and_value() {
        for (line, words) in [
            (
                "$GPGGA,120000,4x18.5,N,00206.0,E,1,08,1,10,M,50,M,,",
                ["field 2 \"4x18.5\"", "outside its range"],
            ),
            (
                "$GPGGA,120000,4118.5,Q,00206.0,E,1,08,1,10,M,50,M,,",
                ["field 3 \"Q\"", "without its letter"],
            ),
            (
                "$GPGGA,126000,4118.5,N,00206.0,E,1,08,1,10,M,50,M,,",
                ["field 1 \"126000\"", "another form"],
            ),
            (
                "$GPRMC,120000,A,4118.5,N,00206.0,E,-3,10.0,010126,,,A",
                ["field 7 \"-3\"", "outside its range"],
            ),
            ("$HEHDT,361.0,T", ["field 1 \"361.0\"", "outside its range"]),
            (
                "$GPGGA,120000,4118.5,N,00206.0,E,0,08,1,10,M,50,M,,",
                ["sentence \"$GPGGA,120000", "no valid fix"],
            ),
            ("$XXHDT,10.0,T", ["sentence \"$XXHDT,10.0,T", "unknown talker"]),
            ("$HEHDT,10.0,T*00", ["$HEHDT,10.0,T*00", "checksum"]),
            ("$HEHDT,10.0,T*0", ["$HEHDT,10.0,T*0", "was cut"]),
            ("hello*00", ["sentence \"hello*00\"", "begins with $"]),
        ] {
            let found = refused(line);
            assert!(words.iter().all(|words| found.contains(words)), "{line}: {found}");
        }
        assert_eq!(refused("$HEHDT,10.0,T"), "");
        assert!(refused(&"x".repeat(300)).contains("longer than 256"));
        assert!(refused("$HEHDT,1\u{1b}[2J,T*00").contains("\\u{1b}"));
    }
}

//! Framing of sentences: start, talker, kind, checksum.

/// Longest sentence that is accepted, bytes. The standard allows 82; some devices write longer ones.
pub(super) const SENTENCE_OCTETS_MAX: usize = 256;

/// Talkers that are accepted: satellite receivers, compasses, gyros, integrated navigation.
const TALKERS: [&[u8; 2]; 17] = [
    b"GP", b"GN", b"GL", b"GA", b"GB", b"BD", b"GQ", b"QZ", b"GI", b"HE", b"HC", b"HN", b"HF", b"IN", b"II", b"TI",
    b"AG",
];

/// Reason for refusing a sentence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NmeaFault {
    /// The bytes begin no sentence, or are no text.
    NoSentence,
    /// The sentence has no checksum, or another begins within it: it was cut.
    Partial,
    /// The checksum is another.
    Checksum,
    /// The talker is not known.
    Talker,
    /// The sentence is longer than any.
    TooLong,
    /// A field has no value that can be meant.
    Field,
    /// The receiver states that it has no fix, or the instrument that its value is invalid.
    NoFix,
    /// The day of the time is not known, or more than a day from the time of receipt.
    NoDate,
}

/// Counts of sentences.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NmeaCounts {
    /// Used sentences.
    pub used: u64,
    /// Sentences of kinds that are not read.
    pub other: u64,
    /// Leap seconds.
    pub leap_seconds: u64,
    /// Refused: no sentence.
    pub no_sentence: u64,
    /// Refused: cut.
    pub partial: u64,
    /// Refused: wrong checksum.
    pub checksum: u64,
    /// Refused: unknown talker.
    pub talker: u64,
    /// Refused: too long.
    pub too_long: u64,
    /// Refused: a field without a possible value.
    pub field: u64,
    /// Refused: without a fix, or marked as invalid.
    pub no_fix: u64,
    /// Refused: day unknown.
    pub no_date: u64,
}

impl NmeaCounts {
    pub(super) fn count(&mut self, fault: NmeaFault) {
        let counter = match fault {
            NmeaFault::NoSentence => &mut self.no_sentence,
            NmeaFault::Partial => &mut self.partial,
            NmeaFault::Checksum => &mut self.checksum,
            NmeaFault::Talker => &mut self.talker,
            NmeaFault::TooLong => &mut self.too_long,
            NmeaFault::Field => &mut self.field,
            NmeaFault::NoFix => &mut self.no_fix,
            NmeaFault::NoDate => &mut self.no_date,
        };
        *counter += 1;
    }

    /// Number of refused sentences.
    pub fn refused(&self) -> u64 {
        self.no_sentence
            + self.partial
            + self.checksum
            + self.talker
            + self.too_long
            + self.field
            + self.no_fix
            + self.no_date
    }
}

/// Kind of a sentence that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SentenceKind {
    Gga,
    Gll,
    Rmc,
    Vtg,
    Hdt,
    Ths,
    Hdg,
    Pashr,
}

/// Checks a line without its end. Returns the kind and the fields behind the name; `None` of a kind that is not read.
pub(super) fn framed(line: &[u8]) -> Result<Option<(SentenceKind, &str)>, NmeaFault> {
    let body = line.strip_prefix(b"$").ok_or(NmeaFault::NoSentence)?;
    if body.len() >= SENTENCE_OCTETS_MAX {
        return Err(NmeaFault::TooLong);
    }
    let text = std::str::from_utf8(body).map_err(|_| NmeaFault::NoSentence)?;
    if !text.bytes().all(|octet| (0x20..0x7f).contains(&octet)) {
        return Err(NmeaFault::NoSentence);
    }
    let (text, behind) = summed(text)?;
    if !behind.is_empty() {
        return Err(NmeaFault::Partial);
    }
    let (name, fields) = text.split_once(',').ok_or(NmeaFault::Field)?;
    if name == "PASHR" {
        return Ok(Some((SentenceKind::Pashr, fields)));
    }
    if name.starts_with('P') {
        return Ok(None);
    }
    let (talker, kind) = name.as_bytes().split_at_checked(2).ok_or(NmeaFault::Field)?;
    if !TALKERS.iter().any(|known| known[..] == *talker) {
        return Err(NmeaFault::Talker);
    }
    let kind = match kind {
        b"GGA" => SentenceKind::Gga,
        b"GLL" => SentenceKind::Gll,
        b"RMC" => SentenceKind::Rmc,
        b"VTG" => SentenceKind::Vtg,
        b"HDT" => SentenceKind::Hdt,
        b"THS" => SentenceKind::Ths,
        b"HDG" => SentenceKind::Hdg,
        _ => return Ok(None),
    };
    Ok(Some((kind, fields)))
}

/// Checks the sum of a sentence without its first character, or of a tag block. Returns the summed characters, and
/// those behind the sum.
pub(crate) fn summed(text: &str) -> Result<(&str, &str), NmeaFault> {
    let (text, behind) = text.split_once('*').ok_or(NmeaFault::Partial)?;
    let (stated, behind) = behind.split_at_checked(2).ok_or(NmeaFault::Partial)?;
    let stated = u8::from_str_radix(stated, 16).map_err(|_| NmeaFault::Checksum)?;
    match text.bytes().fold(0, |sum, octet| sum ^ octet) == stated {
        true => Ok((text, behind)),
        false => Err(NmeaFault::Checksum),
    }
}

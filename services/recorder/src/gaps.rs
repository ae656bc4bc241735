//! File of the gaps in the sample numbers of a table.
//!
//! Samples of a replay are numbered from 0, and each becomes a row. Without missing samples, the number of rows is
//! the number of the next sample. Samples can be missing if they were lost with a recorder that had taken them. A
//! line in the file `gaps_<file>` then states that after `rows` rows, the next row holds the sample `sequence`. The
//! recorder writes this line before the row. A recorder killed in between leaves a line about absent rows; its
//! successor removes the line.

use std::fs::{File, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use crate::account::SampleNumbers;

/// Header line.
const HEADER: &str = "rows,sequence";

/// Gaps of a table.
#[derive(Debug)]
pub(crate) struct Gaps {
    path: PathBuf,
    /// Open once there is a gap.
    file: Option<File>,
    rows: u64,
    /// Difference between the sample number of the last row and its place.
    ahead: u64,
}

impl Gaps {
    /// Reads the gaps of the table `path`, which holds `rows` rows.
    ///
    /// # Errors
    /// If the file of gaps cannot be read or written.
    pub(crate) fn of(path: &Path, rows: u64) -> io::Result<Self> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let path = path.with_file_name(format!("gaps_{name}"));
        let text = match std::fs::read_to_string(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            read => read?,
        };
        let gap = |line: &str| {
            let (at, sequence) = line.split_once(',')?;
            Some((at.parse::<u64>().ok()?, sequence.parse::<u64>().ok()?))
        };
        // A line without an end is torn; its row was never written.
        let whole = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
        let stands: Vec<_> = whole.lines().filter_map(gap).filter(|(at, _)| *at < rows).collect();
        let ahead = stands.last().map_or(0, |(at, sequence)| sequence.saturating_sub(*at));
        let mut gaps = Self {
            path,
            file: None,
            rows,
            ahead,
        };
        if !text.is_empty() {
            std::fs::remove_file(&gaps.path)?;
            stands.iter().try_for_each(|(at, sequence)| gaps.note(*at, *sequence))?;
        }
        Ok(gaps)
    }

    fn note(&mut self, rows: u64, sequence: u64) -> io::Result<()> {
        let file = match &mut self.file {
            Some(file) => file,
            None => {
                let mut new = OpenOptions::new().create(true).append(true).open(&self.path)?;
                writeln!(new, "{HEADER}")?;
                self.file.insert(new)
            }
        };
        file.write_all(format!("{rows},{sequence}\n").as_bytes())
    }

    /// Records that the next row holds the sample `sequence`, which follows the sample of the last row.
    ///
    /// # Errors
    /// If a gap cannot be written.
    pub(crate) fn add_row(&mut self, sequence: u64) -> io::Result<()> {
        let ahead = sequence.saturating_sub(self.rows);
        if ahead != self.ahead {
            self.note(self.rows, sequence)?;
            self.ahead = ahead;
        }
        self.rows += 1;
        Ok(())
    }

    /// Returns the sample numbers after the last row.
    pub(crate) fn numbers(&self) -> SampleNumbers {
        SampleNumbers::after(self.rows + self.ahead, self.ahead)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_known_to_the_next_recorder_however_many_there_were() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.csv");
        let gaps = || std::fs::read_to_string(folder.path().join("gaps_rows.csv")).unwrap_or_default();
        let mut first = Gaps::of(&path, 0).unwrap();
        (0..3).for_each(|sequence| first.add_row(sequence).unwrap());
        assert_eq!((first.numbers(), gaps()), (SampleNumbers::after(3, 0), String::new()));
        [5, 6, 10].iter().for_each(|sequence| first.add_row(*sequence).unwrap());
        assert_eq!(first.numbers(), SampleNumbers::after(11, 5));
        assert_eq!(gaps(), "rows,sequence\n3,5\n5,10\n");
        // All six rows exist, or the last is missing, or only the first three exist.
        for (rows, next_sequence, missing, left) in [
            (6, 11, 5, "rows,sequence\n3,5\n5,10\n"),
            (5, 7, 2, "rows,sequence\n3,5\n"),
            (3, 3, 0, ""),
        ] {
            let next = Gaps::of(&path, rows).unwrap();
            let found = (next.numbers(), gaps());
            assert_eq!(
                found,
                (SampleNumbers::after(next_sequence, missing), left.to_owned()),
                "{rows}"
            );
        }
    }

    #[test]
    fn a_torn_line_counts_for_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.csv");
        std::fs::write(folder.path().join("gaps_rows.csv"), "rows,sequence\n3,5\n4,1").unwrap();
        let gaps = Gaps::of(&path, 9).unwrap();
        assert_eq!(gaps.numbers(), SampleNumbers::after(11, 2));
    }
}

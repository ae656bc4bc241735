//! What processes outside of a deployment refused, for the deployment's monitor: second publishers of a source, and
//! lines that `koseki feed` did not take.
//!
//! A refused process may end at once, and is no part of the deployment. It therefore adds a line to a file in the
//! folder of the instance, which the monitor reads. Each line is appended by one write, so that processes do not
//! disturb each other. A full file begins anew; what the monitor has not read by then is lost.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::PathBuf;

use bus::Root;
use messages::printable;

use crate::clock::mono_ns;

/// Folder, in that of an instance, of the files by which publishers from outside agree.
pub(crate) const FOLDER: &str = "publishers";
const FILE: &str = "refused";
/// Length at which the file begins anew, octets.
const FILE_MAX: u64 = 1 << 16;
/// Most characters of a word in the file, and of the latest refused line in words.
const WORD_MAX: usize = 48;
const LATEST_MAX: usize = 160;

/// Something that was refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// Name of the topic of a publisher; of the source of lines, empty for several sources.
    pub name: String,
    /// What was refused.
    pub refused: Refused,
}

/// Kind of what was refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refused {
    /// A second publisher.
    Publisher {
        /// Number of the refused process.
        process: u32,
        /// Who publishes.
        holder: String,
    },
    /// Lines of datagrams, or whole datagrams.
    Lines {
        /// How many.
        count: u64,
        /// Why: the name of a field, for example.
        reason: String,
        /// The latest of them in words; empty for whole datagrams and connections.
        latest: String,
    },
}

impl Refusal {
    fn line(&self) -> String {
        let (kind, number, text, latest) = match &self.refused {
            Refused::Publisher { process, holder } => ("publisher", u64::from(*process), holder, ""),
            Refused::Lines { count, reason, latest } => ("lines", *count, reason, latest.as_str()),
        };
        let [name, text] = [&self.name, text].map(|text| printable(text, WORD_MAX));
        let latest = printable(latest, LATEST_MAX);
        format!("{}\t{kind}\t{name}\t{number}\t{text}\t{latest}\n", mono_ns())
    }

    /// The refusal of a line, with its monotonic time, nanoseconds; `None` of a torn line.
    fn of_line(line: &str) -> Option<(i64, Self)> {
        let mut words = line.strip_suffix('\n')?.split('\t');
        let time_ns = words.next()?.parse().ok()?;
        let kind = words.next()?;
        let name = words.next()?.to_owned();
        let number: u64 = words.next()?.parse().ok()?;
        let [text, latest] = [words.next()?, words.next()?].map(str::to_owned);
        let refused = match kind {
            "publisher" => Refused::Publisher {
                process: u32::try_from(number).ok()?,
                holder: text,
            },
            "lines" => Refused::Lines {
                count: number,
                reason: text,
                latest,
            },
            _ => return None,
        };
        Some((time_ns, Self { name, refused }))
    }
}

fn path(root: &Root) -> PathBuf {
    root.path().join(FOLDER).join(FILE)
}

/// Notes what this process refused, or was refused, in the deployment at `root`.
///
/// # Errors
/// If the file in the folder of the instance cannot be written.
pub fn note(root: &Root, refusals: &[Refusal]) -> io::Result<()> {
    let path = path(root);
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let mut file = OpenOptions::new().create(true).append(true).open(path)?;
    if file.metadata()?.len() > FILE_MAX {
        file.set_len(0)?;
    }
    let lines: String = refusals.iter().map(Refusal::line).collect();
    file.write_all(lines.as_bytes())
}

/// Reader of what was refused.
#[derive(Debug)]
pub struct RefusalReader {
    path: PathBuf,
    /// Octets of the file that have been read.
    read: u64,
}

impl RefusalReader {
    /// Reads what is refused in the deployment at `root`.
    pub fn new(root: &Root) -> Self {
        Self {
            path: path(root),
            read: 0,
        }
    }

    /// Returns what was refused since the last call, and not before `since_ns` (monotonic, nanoseconds). Without the
    /// file, nothing was.
    pub fn take(&mut self, since_ns: i64) -> Vec<Refusal> {
        let Ok(text) = self.rest() else {
            return Vec::new();
        };
        let refusals = text.split_inclusive('\n').filter_map(Refusal::of_line);
        refusals
            .filter(|(time_ns, _)| *time_ns >= since_ns)
            .map(|(_, refusal)| refusal)
            .collect()
    }

    fn rest(&mut self) -> io::Result<String> {
        let mut file = File::open(&self.path)?;
        let length = file.metadata()?.len();
        if length < self.read {
            self.read = 0;
        }
        if length == self.read {
            return Ok(String::new());
        }
        file.seek(SeekFrom::Start(self.read))?;
        // A writer may be in the midst of beginning anew.
        let mut octets = Vec::new();
        let taken = file.take(2 * FILE_MAX).read_to_end(&mut octets)?;
        self.read += taken as u64;
        Ok(String::from_utf8_lossy(&octets).into_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(reason: &str, count: u64) -> Refusal {
        Refusal {
            name: "own".to_owned(),
            refused: Refused::Lines {
                count,
                reason: reason.to_owned(),
                latest: format!("{reason} is wrong"),
            },
        }
    }

    fn publisher() -> Refusal {
        Refusal {
            name: "sensor/own/tracks".to_owned(),
            refused: Refused::Publisher {
                process: 7,
                holder: "process 5".to_owned(),
            },
        }
    }

    #[test]
    fn what_is_noted_is_read_once_and_old_lines_are_passed_over() {
        let folder = tempfile::tempdir().unwrap();
        let root = Root::in_base(folder.path(), "t").unwrap();
        let mut reader = RefusalReader::new(&root);
        assert_eq!(reader.take(0), []);
        note(&root, &[publisher(), lines("latitude", 3)]).unwrap();
        assert_eq!(reader.take(0), [publisher(), lines("latitude", 3)]);
        assert_eq!(reader.take(0), []);
        note(&root, &[lines("line", 1)]).unwrap();
        assert_eq!(reader.take(i64::MAX), [], "before the time asked for");
        note(&root, &[lines("line", 2)]).unwrap();
        assert_eq!(reader.take(0), [lines("line", 2)]);
    }

    #[test]
    fn hostile_words_stay_in_their_line_and_the_file_stays_small() {
        let folder = tempfile::tempdir().unwrap();
        let root = Root::in_base(folder.path(), "t").unwrap();
        let mut reader = RefusalReader::new(&root);
        let hostile = "a\tb\nc".to_owned() + &"x".repeat(1000);
        note(&root, &[lines(&hostile, 1)]).unwrap();
        let read = reader.take(0);
        let [
            Refusal {
                refused: Refused::Lines { reason, latest, .. },
                ..
            },
        ] = &read[..]
        else {
            panic!("{read:?}")
        };
        assert!(reason.starts_with("a\\tb\\ncxx"), "{reason}");
        assert!(
            reason.len() == WORD_MAX + 2 && latest.len() == LATEST_MAX + 2,
            "{reason}"
        );
        for _ in 0..2000 {
            note(&root, &[lines(&hostile, 1)]).unwrap();
        }
        assert!(fs::metadata(path(&root)).unwrap().len() <= FILE_MAX + 400);
        reader.take(0);
        note(&root, &[publisher()]).unwrap();
        assert_eq!(reader.take(0), [publisher()], "read on in the file that began anew");
    }
}

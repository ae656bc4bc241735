//! Continuation of the files of a terminated recorder.
//!
//! A restart of the recorder must not lose a run's files. The successor keeps the rows of its predecessor and cuts
//! off a torn last line. It cuts off the incomplete last chunk of the file of all topics, ends the file, and continues
//! the tally of each topic. The file `run.txt` in the folder identifies the run. A folder of another run is rejected,
//! because a recording is never replaced.

use std::fs::{File, OpenOptions};
use std::io::{BufRead as _, BufReader, Seek as _, SeekFrom, Write as _};
use std::path::Path;

use anyhow::{Context as _, ensure};
use recording::{Survey, Tally};
use runtime::NumberedFiles;

/// Whether `folder` holds files of the run described by `run`; an empty folder is claimed for this run.
///
/// # Errors
/// If the files belong to another run, or the folder cannot be written.
pub(crate) fn claim(folder: &Path, run: &str) -> anyhow::Result<bool> {
    let path = folder.join("run.txt");
    match std::fs::read_to_string(&path) {
        Ok(text) => {
            ensure!(
                text == run,
                "{} holds the recording of another run ({}); name another folder",
                folder.display(),
                text.trim()
            );
            Ok(true)
        }
        Err(_) => {
            // Atomic: a partial line would identify another run.
            let new = folder.join(".run.txt");
            let write = || std::fs::write(&new, run).and_then(|()| std::fs::rename(&new, &path));
            write().with_context(|| format!("writing {}", path.display()))?;
            Ok(false)
        }
    }
}

/// Output file for rows.
#[derive(Debug)]
pub(crate) struct Opened {
    /// File, positioned for the next row.
    pub(crate) file: File,
    /// Number of existing rows; 0 if the file is empty.
    pub(crate) rows: u64,
}

/// Opens `path`: empty, or with `resume` as it is, up to its last complete line.
///
/// # Errors
/// If the file cannot be opened, or exists without `resume`.
pub(crate) fn open(path: &Path, resume: bool) -> std::io::Result<Opened> {
    if resume && path.exists() {
        resumed(path)
    } else {
        File::create_new(path).map(|file| Opened { file, rows: 0 })
    }
}

fn resumed(path: &Path) -> std::io::Result<Opened> {
    let mut file = OpenOptions::new().read(true).write(true).open(path)?;
    let (mut whole_bytes, mut lines, mut line) = (0u64, 0u64, Vec::new());
    let mut reader = BufReader::new(&file);
    while reader.read_until(b'\n', &mut line)? > 0 && line.ends_with(b"\n") {
        whole_bytes += line.len() as u64;
        lines += 1;
        line.clear();
    }
    // Without even a header, there is nothing to continue.
    let rows = lines.saturating_sub(1);
    let keep = if rows == 0 { 0 } else { whole_bytes };
    file.set_len(keep)?;
    file.seek(SeekFrom::End(0))?;
    Ok(Opened { file, rows })
}

/// Files of all topics left by earlier recorders.
#[derive(Debug, Default)]
pub(crate) struct Earlier {
    /// Number of the latest file; 0 without files.
    pub(crate) number: u32,
    latest: Survey,
}

impl Earlier {
    /// Ends the latest file, and reads the positions of the topics in it.
    ///
    /// # Errors
    /// If the folder or the latest file cannot be read.
    pub(crate) fn read(files: &NumberedFiles) -> anyhow::Result<Self> {
        let mut latest = Survey::default();
        let found = files.list()?;
        let number = found.last().map_or(0, |(number, _)| *number);
        for (_, path) in found.iter().rev() {
            if recording::whole(&mut File::open(path)?)?.bytes > 0 {
                end(path)?;
                latest.add(&mut File::open(path)?)?;
            }
            if !latest.facts.is_empty() {
                break;
            }
            // A recorder terminated before its first record, so the file before holds the positions of the topics.
            std::fs::remove_file(path)?;
        }
        Ok(Self { number, latest })
    }

    /// Returns the tally of a topic; without earlier files, of a recording that starts at this monotonic time,
    /// nanoseconds.
    pub(crate) fn tally(&self, topic: &str, since_ns: u64) -> Tally {
        let known = self.latest.topics.get(topic).map(|topic| topic.tally.clone());
        known.unwrap_or_else(|| match self.latest.facts.is_empty() {
            true => Tally::since(topic, since_ns),
            false => Tally::begin(topic, &self.latest.facts),
        })
    }
}

/// Ends a file of all topics that has no end record.
///
/// # Errors
/// If the file cannot be read or written.
pub(crate) fn end(path: &Path) -> std::io::Result<()> {
    let mut file = OpenOptions::new().read(true).append(true).open(path)?;
    let whole = recording::whole(&mut file)?;
    if !whole.is_ended {
        file.set_len(whole.bytes)?;
        file.write_all(&recording::closing())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(content: &str, resume: bool) -> (u64, String) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.csv");
        std::fs::write(&path, content).unwrap();
        let mut opened = open(&path, resume).unwrap();
        opened.file.write_all(b"+").unwrap();
        (opened.rows, std::fs::read_to_string(&path).unwrap())
    }

    #[test]
    fn a_file_is_continued_after_its_last_whole_line() {
        assert_eq!(after("header\n1\n2\n3", true), (2, "header\n1\n2\n+".to_owned()));
        assert_eq!(after("header\n1\n", true), (1, "header\n1\n+".to_owned()));
        assert_eq!(after("header\n", true), (0, "+".to_owned()));
        assert_eq!(after("hea", true), (0, "+".to_owned()));
        assert_eq!(after("", true), (0, "+".to_owned()));
    }

    #[test]
    fn a_folder_belongs_to_the_first_run_that_claimed_it() {
        let folder = tempfile::tempdir().unwrap();
        assert!(!claim(folder.path(), "first").unwrap());
        assert!(claim(folder.path(), "first").unwrap());
        let refused = claim(folder.path(), "second").unwrap_err().to_string();
        assert!(
            refused.contains("another run (first); name another folder"),
            "{refused}"
        );
        assert!(claim(folder.path(), "first").unwrap());
    }
}

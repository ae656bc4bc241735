//! Rows that the first pass over files has read, for the passes that follow.
//!
//! Reading a row costs more than fusing it. The first pass therefore keeps the rows of files of moderate size. Longer
//! files, files with stated arrivals (read in another order), and files with unreadable rows (a later pass must report
//! the refusals) are read again.

use std::collections::VecDeque;
use std::rc::Rc;

use super::arrivals::ArrivedReport;

/// Most memory for kept rows of all files, bytes.
const MEMORY_MAX: usize = 64 << 20;

/// Rows of a file, in the file's order.
#[derive(Debug)]
pub(super) struct KeptFile {
    rows: Vec<ArrivedReport>,
    rows_max: usize,
    /// Size of the file, bytes.
    octets: u64,
}

impl KeptFile {
    /// No rows yet, of a file among `files` files.
    pub(super) fn begin(files: usize, octets: u64) -> Self {
        Self {
            rows: Vec::new(),
            rows_max: MEMORY_MAX / size_of::<ArrivedReport>() / files.max(1),
            octets,
        }
    }

    /// Keeps another row; `None` if there are too many.
    pub(super) fn with(mut self, row: &ArrivedReport) -> Option<Self> {
        if self.rows.len() == self.rows_max {
            return None;
        }
        if self.rows.len() == self.rows.capacity() {
            let more = self.rows.len().max(1024).min(self.rows_max - self.rows.len());
            self.rows.reserve_exact(more);
        }
        self.rows.push(*row);
        Some(self)
    }
}

/// Rows of all files.
#[derive(Debug)]
pub(crate) struct KeptRows {
    files: Vec<Rc<KeptFile>>,
    /// `sensor_id` of each source number in the rows.
    sensor_ids: Vec<u32>,
}

impl KeptRows {
    pub(super) fn new(files: Vec<KeptFile>, sensor_ids: Vec<u32>) -> Self {
        Self {
            files: files.into_iter().map(Rc::new).collect(),
            sensor_ids,
        }
    }

    /// The rows of each file from the beginning, for sources with these ids; `None` if a sensor has another id.
    pub(super) fn again(&self, sensor_ids: &[u32]) -> Option<Vec<KeptReader>> {
        let source = |id: &u32| Some(sensor_ids.iter().position(|known| known == id)? as u16);
        let sources: Rc<[u16]> = self.sensor_ids.iter().map(source).collect::<Option<_>>()?;
        let reader = |file: &Rc<KeptFile>| KeptReader {
            file: Rc::clone(file),
            next: 0,
            sources: Rc::clone(&sources),
        };
        Some(self.files.iter().map(reader).collect())
    }
}

/// Reads the kept rows of a file.
#[derive(Debug)]
pub(super) struct KeptReader {
    file: Rc<KeptFile>,
    next: usize,
    /// Source of each number in the rows.
    sources: Rc<[u16]>,
}

impl KeptReader {
    /// Size of the file, bytes.
    pub(super) fn octets(&self) -> u64 {
        self.file.octets
    }

    /// The part of the file that a row stands for, bytes.
    pub(super) fn octets_of_row(&self) -> u64 {
        self.file.octets / (self.file.rows.len() as u64).max(1)
    }

    /// Appends the next row; `false` at the end.
    pub(super) fn next_into(&mut self, rows: &mut VecDeque<ArrivedReport>) -> bool {
        let Some(row) = self.file.rows.get(self.next) else {
            return false;
        };
        self.next += 1;
        rows.push_back(*row);
        if let Some(row) = rows.back_mut() {
            row.track.source = self.sources[usize::from(row.track.source)];
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use messages::SensorTrack;

    use super::*;

    fn row(source: u16, line: u64) -> ArrivedReport {
        let track = SensorTrack {
            source,
            ..SensorTrack::default()
        };
        ArrivedReport {
            track,
            arrival_ns: 0,
            line,
        }
    }

    #[test]
    fn kept_rows_come_again_under_the_numbers_of_their_sources() {
        let file = KeptFile::begin(1, 100);
        let file = file.with(&row(0, 2)).and_then(|file| file.with(&row(1, 3))).unwrap();
        let kept = KeptRows::new(vec![file], vec![70, 80]);
        assert!(kept.again(&[70]).is_none(), "sensor 80 is no source");
        for _ in 0..2 {
            let mut readers = kept.again(&[90, 80, 70]).unwrap();
            let mut read = VecDeque::new();
            while readers[0].next_into(&mut read) {}
            let read: Vec<_> = read.iter().map(|row| (row.track.source, row.line)).collect();
            assert_eq!(read, [(2, 2), (1, 3)]);
            assert_eq!(readers[0].octets_of_row(), 50);
        }
    }

    #[test]
    fn files_that_need_too_much_memory_are_not_kept() {
        let mut file = Some(KeptFile::begin(1 << 15, 100));
        let mut rows = 0;
        while let Some(fuller) = file.take().and_then(|file| file.with(&row(0, rows))) {
            (file, rows) = (Some(fuller), rows + 1);
        }
        assert!((1..10).contains(&rows), "{rows}");
    }
}

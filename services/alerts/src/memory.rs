//! Alerts in force, kept for a successor of a killed process.

use std::sync::Arc;

use kept::{Get, Kept, Memory, Picture, Put};
use messages::Alert;
use messages::layout::Sample as _;
use runtime::{Now, Process, Publication};

/// Name of the memory, and of its owner.
const NAME: &str = "alerts";
/// Most alerts that are kept.
const PLACES: usize = alerts::IN_FORCE_MAX;

/// Memory that outlasts the process.
#[derive(Debug)]
pub(crate) struct AlertMemory {
    picture: Picture<u64, KeptAlert>,
    publication: Option<Publication>,
    /// Alerts that a predecessor left, and the number of its last one.
    left: (u64, Vec<Alert>),
}

/// An alert as words.
#[derive(Debug)]
struct KeptAlert(Alert);

impl Kept for KeptAlert {
    const WORDS: usize = size_of::<Alert>() / 8;

    fn put(&self, to: &mut Put<'_>) {
        for octets in Alert::octets(std::slice::from_ref(&self.0)).chunks_exact(8) {
            to.word(octets.try_into().map_or(0, u64::from_ne_bytes));
        }
    }

    fn get(from: &mut Get<'_>) -> Option<Self> {
        let words: Option<Vec<u64>> = (0..Self::WORDS).map(|_| from.word()).collect();
        let octets: Vec<u8> = words?.into_iter().flat_map(u64::to_ne_bytes).collect();
        Alert::of_octets(&octets).map(Self)
    }
}

const _: () = assert!(size_of::<Alert>().is_multiple_of(8));

impl AlertMemory {
    /// Opens the memory of a deployment; reads what a predecessor left, unless recorded inputs begin anew.
    ///
    /// # Errors
    /// If the machine has no memory for it.
    pub(crate) fn open(process: &Process) -> anyhow::Result<Self> {
        let root = process.bus.root();
        let left = match root.outlasting(NAME) {
            Ok(Some(memory)) => {
                Picture::<u64, KeptAlert>::read(memory.words(), NAME, PLACES).map_err(|refused| refused.to_string())
            }
            Ok(None) => Ok(None),
            Err(error) => Err(error.to_string()),
        };
        let left = left.unwrap_or_else(|reason| {
            runtime::notice(format_args!("warning: the alerts kept are not used: {reason}"));
            None
        });
        let memory = Arc::new(root.make_outlasting(NAME, Picture::<u64, KeptAlert>::words(PLACES))?);
        let mut publication = Publication::new(Arc::clone(&memory), "the alerts in force".to_owned());
        let (last, alerts) = left.unwrap_or_default();
        let mut opened = Self::in_memory(Box::new(memory));
        opened.left = (last, alerts.into_iter().map(|KeptAlert(alert)| alert).collect());
        publication.tend(Now::read().mono_ns);
        opened.publication = Some(publication);
        Ok(opened)
    }

    /// In blank memory.
    pub(crate) fn in_memory(memory: Box<dyn Memory>) -> Self {
        Self {
            picture: Picture::begin(memory, NAME, PLACES),
            publication: None,
            left: (0, Vec::new()),
        }
    }

    /// Number of words of the memory.
    #[cfg(test)]
    pub(crate) fn words() -> usize {
        Picture::<u64, KeptAlert>::words(PLACES)
    }

    /// Takes the number of the last alert, and the alerts in force, that a predecessor left.
    pub(crate) fn take_left(&mut self) -> (u64, Vec<Alert>) {
        std::mem::take(&mut self.left)
    }

    /// Keeps the alerts in force, and the number of the last one.
    pub(crate) fn keep<'a>(&mut self, last: u64, in_force: impl Iterator<Item = &'a Alert>, mono_ns: i64) {
        let alerts: Vec<KeptAlert> = in_force.map(|alert| KeptAlert(*alert)).collect();
        self.picture.write(&last, alerts.iter());
        if let Some(publication) = &mut self.publication {
            publication.tend(mono_ns);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicU64;

    use super::*;

    #[derive(Debug)]
    struct Words(Arc<Vec<AtomicU64>>);

    impl Memory for Words {
        fn words(&self) -> &[AtomicU64] {
            &self.0
        }
    }

    #[test]
    fn alerts_come_back_to_the_bit() {
        let words: Arc<Vec<AtomicU64>> = Arc::new((0..AlertMemory::words()).map(|_| AtomicU64::new(0)).collect());
        let mut memory = AlertMemory::in_memory(Box::new(Words(Arc::clone(&words))));
        let alert = Alert {
            number: 12,
            tracks: [3, 9],
            probability: 0.71,
            ..Alert::default()
        };
        let alert = alert.with_texts("conflict", "", "A and B");
        memory.keep(14, [alert].iter(), 0);
        let (last, left) = Picture::<u64, KeptAlert>::read(&words, NAME, PLACES).unwrap().unwrap();
        assert_eq!((last, left.len()), (14, 1));
        assert_eq!(left[0].0, alert);
    }
}

//! Publication of memory for a successor, repeated while shared memory is full.

use std::sync::Arc;

use bus::Outlasting;

/// Time between two attempts, nanoseconds.
const AGAIN_NS: i64 = 1_000_000_000;

/// Memory for a successor that is published as soon as there is room.
#[derive(Debug)]
pub struct Publication {
    memory: Arc<Outlasting>,
    /// Time of the next attempt, monotonic, nanoseconds; `None` once the memory is published.
    due_ns: Option<i64>,
    has_failed: bool,
    /// Name of the contents in notices.
    what: String,
}

impl Publication {
    /// Creates the publication of `memory`, due with the first [`Self::tend`]; notices call the contents `what`.
    pub fn new(memory: Arc<Outlasting>, what: String) -> Self {
        Self {
            memory,
            due_ns: Some(i64::MIN),
            has_failed: false,
            what,
        }
    }

    /// Publishes the memory if an attempt is due at `now_ns`, monotonic. To be called by the thread that writes the
    /// memory.
    #[inline]
    pub fn tend(&mut self, now_ns: i64) {
        if self.due_ns.is_some_and(|due_ns| now_ns >= due_ns) {
            self.publish(now_ns);
        }
    }

    #[cold]
    fn publish(&mut self, now_ns: i64) {
        let what = &self.what;
        let published = self.memory.publish();
        match &published {
            Ok(()) if self.has_failed => crate::notice(format_args!("{what}: kept for a successor again")),
            Err(error) if !self.has_failed => {
                crate::notice(format_args!(
                    "warning: {what}: not kept for a successor until there is room: {error}"
                ));
            }
            _ => {}
        }
        self.has_failed |= published.is_err();
        self.due_ns = published.is_err().then(|| now_ns.saturating_add(AGAIN_NS));
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::Ordering::Relaxed;

    use bus::Root;

    use super::*;

    #[test]
    fn memory_is_published_a_second_after_a_failure_with_what_was_written_meanwhile() {
        let folder = tempfile::tempdir().unwrap();
        let base = folder.path().join("base");
        std::fs::create_dir(&base).unwrap();
        let root = Root::in_base(&base, "later").unwrap();
        let memory = Arc::new(root.make_outlasting("a", 1).unwrap());
        std::fs::rename(&base, folder.path().join("away")).unwrap();
        let mut publication = Publication::new(Arc::clone(&memory), "test".to_owned());
        publication.tend(5);
        std::fs::rename(folder.path().join("away"), &base).unwrap();
        memory.words()[0].store(7, Relaxed);
        publication.tend(5 + AGAIN_NS - 1);
        assert!(root.outlasting("a").unwrap().is_none());
        publication.tend(5 + AGAIN_NS);
        let found = root.outlasting("a").unwrap().unwrap();
        assert_eq!(found.words()[0].load(Relaxed), 7);
        // Published once: a successor's memory keeps the name.
        root.make_outlasting("a", 2).unwrap().publish().unwrap();
        publication.tend(5 + 3 * AGAIN_NS);
        assert_eq!(root.outlasting("a").unwrap().unwrap().words().len(), 2);
        root.remove_outlasting();
    }
}

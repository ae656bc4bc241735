//! Snapshot of an engine as bytes, from which another engine continues identically.
//!
//! A checkpoint has the state needed by a successor, and is written during operation. A snapshot has all state changed
//! by reports and time, taken at one moment: with the snapshot and each later report, another engine gives the same
//! system tracks to the bit. State derived from the settings alone and counters are not included. Making a snapshot
//! takes time in proportion to the tracks, and allocates: snapshots serve recorders that start.

use kept::mixed;

use crate::continuity::checkpoint::MemoryRefusal;
use crate::engine::Engine;
use crate::orders::order_table::OrderTable;

/// Version of the parts of an image. The version rises with every change of a serialised type, samples included: the
/// fingerprint of the checkpoint covers other types.
const FORMAT: u64 = 19;

impl Engine {
    /// Returns the fingerprint of images of this build with these settings.
    fn image_fingerprint(&self) -> u64 {
        mixed(self.checkpoint_layout().fingerprint() ^ FORMAT)
    }

    /// All that reports and time have changed so far.
    pub fn image(&self) -> Vec<u8> {
        let Self {
            settings,
            tracks,
            scans,
            life,
            publisher,
            schedule,
            host_clock,
            orders,
            outbox: _,
            sound_covariances: _,
            compared: _,
        } = self;
        let periods: Vec<_> = settings
            .sources
            .iter()
            .map(|source| (source.period_ns, source.fresh_ns))
            .collect();
        let of = self.image_fingerprint();
        let parts = (
            of, periods, tracks, scans, life, publisher, schedule, host_clock, orders,
        );
        // Memory always has room, and all parts have known lengths.
        postcard::to_stdvec(&parts).unwrap_or_default()
    }

    /// Continues from another engine's snapshot.
    ///
    /// # Errors
    /// If the snapshot has other settings or is from another build.
    pub fn resume_image(&mut self, image: &[u8]) -> Result<(), MemoryRefusal> {
        let (of, rest) = postcard::take_from_bytes::<u64>(image).map_err(|_| MemoryRefusal::Damaged(1))?;
        if of != self.image_fingerprint() {
            return Err(MemoryRefusal::Foreign);
        }
        let parts = postcard::take_from_bytes(rest)
            .map_err(|_| MemoryRefusal::Damaged(1))?
            .0;
        let checkpoint = self.tracks.checkpoint.take();
        let (periods, orders): (Vec<(i64, i64)>, OrderTable);
        (
            periods,
            self.tracks,
            self.scans,
            self.life,
            self.publisher,
            self.schedule,
            self.host_clock,
            orders,
        ) = parts;
        self.tracks.checkpoint = checkpoint;
        self.resume_order_table(orders);
        for (source, period) in self.settings.sources.iter_mut().zip(periods) {
            (source.period_ns, source.fresh_ns) = period;
        }
        Ok(())
    }
}

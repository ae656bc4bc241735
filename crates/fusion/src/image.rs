//! The whole of an engine as octets, so that another one goes on as this one would.
//!
//! A checkpoint has what a successor must know, and is written while the engine works. An image has all that reports
//! and time ever change, and is made at one moment: whoever has it, and each report from then on, gets the same system
//! tracks to the bit, as if it had been there from the beginning. What follows from the settings alone is not in it,
//! nor are counters. Making one takes as long as there are tracks, and allocates: it is for a recorder that starts.

use kept::mixed;

use crate::checkpoint::Refused;
use crate::engine::Engine;
use crate::order_table::Orders;

/// Version of the parts of an image. It rises with every change of a serialised type, the samples in it included:
/// the fingerprint of the checkpoint covers other types.
const FORMAT: u64 = 4;

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
            sources,
            points,
            scans,
            life,
            publisher,
            schedule,
            host_clock,
            orders,
            outbox: _,
        } = self;
        let periods: Vec<_> = settings
            .sources
            .iter()
            .map(|source| (source.period_ns, source.fresh_ns))
            .collect();
        let of = self.image_fingerprint();
        let parts = (
            of, periods, tracks, sources, points, scans, life, publisher, schedule, host_clock, orders,
        );
        // Into memory, where there is always room, and all of it is of a known length.
        postcard::to_stdvec(&parts).unwrap_or_default()
    }

    /// Goes on from another engine's image.
    ///
    /// # Errors
    /// If it is one of other settings or of another build.
    pub fn resume_image(&mut self, image: &[u8]) -> Result<(), Refused> {
        let (of, rest) = postcard::take_from_bytes::<u64>(image).map_err(|_| Refused::Damaged(1))?;
        if of != self.image_fingerprint() {
            return Err(Refused::Foreign);
        }
        let parts = postcard::take_from_bytes(rest).map_err(|_| Refused::Damaged(1))?.0;
        let checkpoint = self.tracks.checkpoint.take();
        let (periods, orders): (Vec<(i64, i64)>, Orders);
        (
            periods,
            self.tracks,
            self.sources,
            self.points,
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

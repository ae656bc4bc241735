//! The header of every slice.

use std::cmp::Ordering;

use crate::layout::sample;

sample! {
    /// Header before every slice on every topic.
    ///
    /// A slice may be empty: then it only reports the source's progress.
    BatchHeader, size 64 {
        /// Fingerprint of the layout the publisher was built with; others are rejected.
        schema: u64,
        /// Monotonic start time of the publisher, nanoseconds: a restart shows as a new value.
        incarnation: u64,
        /// Samples sent by this incarnation before this slice: the sequence number of its first sample.
        first_sequence: u64,
        /// Progress mark: no later sample will have a time of measurement before this (UTC, ns); i64::MIN if unknown.
        progress_ns: i64,
        /// Monotonic time of the send, nanoseconds.
        sent_ns: i64,
        /// Start-up number of fusion, rising with each start (see [`Epochs`]); tracks of smaller ones are not kept up.
        /// 0: not fusion.
        epoch: u64,
        /// Bit 0: the source has ended. Bit 1: this epoch of fusion continues the tracks of the previous epoch. Bits
        /// 16 to 31: identity of the machine's boot, 0: unknown.
        flags: u32,
        /// Identity of the sensor, the same in every deployment; 0: unknown, or no sensor.
        sensor_uid: u32,
        /// Original deployment of the samples, if another; 0: this deployment.
        origin: u32,
        /// Offset of the source's clock against the publisher's UTC, by the times at which its data are received,
        /// milliseconds; positive if the clock is ahead, 0 if it is not known.
        clock_offset_ms: i32,
    }
}

impl BatchHeader {
    /// Bit of [`BatchHeader::flags`]: the source has ended.
    pub const END: u32 = 1;
    /// Bit of [`BatchHeader::flags`]: this fusion continues the tracks of its predecessor under their numbers, or
    /// reports them as terminated. Without this bit, tracks of older epochs are lost.
    pub const GOES_ON: u32 = 2;
    /// First of the bits of [`BatchHeader::flags`] that hold the identity of the machine's boot.
    pub const BOOT_SHIFT: u32 = 16;

    /// Returns the boot identity of the publisher's machine; 0: unknown.
    pub fn boot(&self) -> u16 {
        (self.flags >> Self::BOOT_SHIFT) as u16
    }
}

/// Order of the starts of fusion from a reader's point of view.
///
/// An epoch is the UTC at which a fusion took the lead. It is greater than that of the fusion before, so epochs
/// rise across restarts and reboots. After a reboot the machine's UTC may be wrong, and the epoch smaller than the
/// previous epoch. Then a different boot identity shows that the start is later. Processes of a boot before the
/// previous one are no longer running.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Epochs {
    epoch: u64,
    boot: u16,
    /// Identity of the previous boot.
    boot_before: u16,
}

impl Epochs {
    /// Compares the start of a slice's publisher with the present start: later (`Greater`), the same, or earlier.
    pub fn compare(&self, header: &BatchHeader) -> Ordering {
        let is_of_another_boot = header.boot() != self.boot && header.boot() != 0 && self.boot != 0;
        match is_of_another_boot {
            true if header.boot() == self.boot_before => Ordering::Less,
            true => Ordering::Greater,
            false => header.epoch.cmp(&self.epoch),
        }
    }

    /// Makes the start of this slice, which must not be earlier, the present start.
    pub fn follow(&mut self, header: &BatchHeader) {
        if header.boot() != self.boot && header.boot() != 0 {
            (self.boot_before, self.boot) = (self.boot, header.boot());
        }
        self.epoch = header.epoch;
    }

    /// Returns the present epoch; 0 before the first slice, and on topics without epochs.
    pub fn epoch(&self) -> u64 {
        self.epoch
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(epoch: u64, boot: u16) -> BatchHeader {
        BatchHeader {
            epoch,
            flags: BatchHeader::END | u32::from(boot) << BatchHeader::BOOT_SHIFT,
            ..BatchHeader::default()
        }
    }

    #[test]
    fn a_rebooted_machine_is_later_whatever_its_clock_and_the_boot_before_is_over() {
        let mut epochs = Epochs::default();
        assert_eq!(epochs.compare(&header(0, 0)), Ordering::Equal, "a topic without");
        for (epoch, boot, standing) in [
            (100, 7, Ordering::Greater),
            (100, 7, Ordering::Equal),
            (90, 7, Ordering::Less),
            (200, 7, Ordering::Greater),
            // After a reboot, with a clock that is behind.
            (50, 8, Ordering::Greater),
            (60, 8, Ordering::Greater),
            (55, 8, Ordering::Less),
            (300, 7, Ordering::Less),
            // Publisher without a stated boot.
            (40, 0, Ordering::Less),
            (70, 0, Ordering::Greater),
            (65, 8, Ordering::Less),
        ] {
            let header = header(epoch, boot);
            assert_eq!(epochs.compare(&header), standing, "{epoch} of {boot}");
            if standing != Ordering::Less {
                epochs.follow(&header);
            }
        }
    }
}

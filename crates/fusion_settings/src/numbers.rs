//! Settings of the numbers of system tracks.

use settings::Seconds;

settings::settings! {
    /// Numbers of system tracks.
    #[derive(Copy)]
    pub struct NumbersSettings {
        /// Time for which the number of a track without reports rests after `life.terminate_s`, before the number ends.
        /// A target that comes back in that time keeps the number. 0: the number ends with the track.
        rest_s: Seconds = Seconds::of(120.0), in [0, 3600];
        /// The same for a target with an address or MMSI, by which it can come back, and for one that is reported less
        /// often than others, or was never confirmed here, by the number of its track at a source that has confirmed
        /// it. The longer of both holds. With `rest_s = 0`, no number rests.
        identity_rest_s: Seconds = Seconds::of(900.0), in [0, 86400];
    }
}

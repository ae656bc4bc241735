//! Settings of the numbers of system tracks.

use settings::Seconds;

settings::settings! {
    /// Numbers of system tracks.
    #[derive(Copy)]
    pub struct NumbersSettings {
        /// Time for which the number of a track without reports rests after `life.terminate_s`, before the number ends.
        /// A target that comes back in that time keeps the number. 0: the number ends with the track.
        rest_s: Seconds = Seconds::of(120.0), in [0, 3600];
    }
}

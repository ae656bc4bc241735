//! Kinds of process in a deployment.

use crate::codes;

codes! {
    /// Kind of a deployment's process (PL-1).
    pub enum ProcessKind: u8 {
        /// Turns one sensor's data into sensor tracks.
        Adapter = 0, "adapter";
        /// Fuses sensor tracks into system tracks.
        Fusion = 1, "fusion";
        /// Records latencies and counters.
        Monitor = 2, "monitor";
        /// Writes tracks to files.
        Recorder = 3, "recorder";
        /// Starts and watches the others.
        Launcher = 4, "launcher";
        /// Sends the observations of simulated sensors over the network.
        Simulator = 5, "simulator";
        /// Sends tracks to other systems over the network.
        Gateway = 6, "gateway";
        /// Holds the topics for the launcher, which maps no shared memory itself.
        Keeper = 7, "keeper";
        /// Shows the picture in browsers.
        Display = 8, "display";
        /// Exchanges topics with deployments on other hosts.
        Link = 9, "link";
        /// Finds events and dangers about targets.
        Alerts = 10, "alerts";
    }
}

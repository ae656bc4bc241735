//! Keys of the launcher.

use std::time::Duration;

use deployment::{Deployment, Parts};
use settings::{KeyTable, SettingsError};

settings::settings! {
    /// Keys of a deployment's file.
    pub struct Keys {
        /// The launcher, which starts and watches the others.
        launcher: Settings = Settings::default();
    }

    /// The launcher, which starts and watches the others.
    pub struct Settings {
        /// Time without a sign of life after which a process is killed and replaced; six times as much while it starts.
        watchdog_s: f64 = 5.0, in [1, 3600];
    }
}

impl Settings {
    /// Returns the time after which a process without a sign of life is replaced.
    pub(crate) fn watchdog(&self) -> Duration {
        Duration::from_secs_f64(self.watchdog_s)
    }
}

impl Parts for Keys {
    fn tables(&mut self) -> Vec<&mut dyn KeyTable> {
        vec![self]
    }

    fn join(&self, _: &mut Deployment) -> Result<(), SettingsError> {
        Ok(())
    }
}

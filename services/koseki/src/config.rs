//! The whole configuration of a deployment: the tables of every service, each declared by the service's crate.

use std::path::Path;

use configuration::{ConfigError, ConfigWith};
use deployment::{Deployment, Parts};
use settings::{KeyTable, SettingsError};

/// Configuration of a deployment with all services.
pub(crate) type Config = ConfigWith<Services>;

/// Settings of all services.
#[derive(Clone, Debug, Default)]
pub(crate) struct Services {
    /// Gateways.
    pub(crate) gateway: gateway::Keys,
    monitor: monitor::Keys,
    recorder: recorder::Keys,
    display: display::Keys,
    launcher: launcher::Keys,
}

impl Services {
    /// Returns the settings of the monitor.
    pub(crate) fn monitor(&self) -> &monitor::Settings {
        &self.monitor.monitor
    }

    /// Returns the settings of the recorder.
    pub(crate) fn recorder(&self) -> &recorder::Settings {
        &self.recorder.recorder
    }

    /// Returns the settings of the display.
    pub(crate) fn display(&self) -> &display::Settings {
        &self.display.display
    }

    /// Returns the settings of the launcher.
    pub(crate) fn launcher(&self) -> &launcher::Settings {
        &self.launcher.launcher
    }
}

impl Parts for Services {
    fn tables(&mut self) -> Vec<&mut dyn KeyTable> {
        let Self {
            gateway,
            monitor,
            recorder,
            display,
            launcher,
        } = self;
        vec![gateway, monitor, recorder, display, launcher]
    }

    fn join(&self, deployment: &mut Deployment) -> Result<(), SettingsError> {
        self.gateway.join(deployment)?;
        self.monitor.join(deployment)?;
        self.recorder.join(deployment)?;
        self.display.join(deployment)?;
        self.launcher.join(deployment)
    }
}

/// Reads a deployment for a command on tables: the keys of services are checked, too.
///
/// # Errors
/// If a key is refused.
pub(crate) fn read(path: &Path, text: &str, overrides: &[String]) -> Result<configuration::Config, ConfigError> {
    Config::parse(path, text, overrides).map(ConfigWith::without_services)
}

#[cfg(test)]
mod tests {
    use settings::Unread;

    use super::*;

    #[test]
    fn the_document_has_the_keys_of_every_service() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/configuration.md");
        let reference = configuration::reference::<Services>();
        assert!(
            !reference.contains(&settings::KeyValue::kind(&Unread)),
            "a service is missing"
        );
        test_support::assert_golden(&path, &reference);
    }
}

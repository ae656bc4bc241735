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
        /// Mode of the files that the deployment writes (recordings, captures, tables, reports, copies on disk), octal.
        /// Whoever may read the files may also enter their folders.
        file_mode: FileMode = FileMode(0o600);
    }
}

/// Mode of new files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileMode(u32);

impl Default for FileMode {
    fn default() -> Self {
        Self(0o600)
    }
}

impl FileMode {
    fn parse(text: String) -> Result<Self, String> {
        let mode = u32::from_str_radix(&text, 8).ok();
        let mode = mode.filter(|mode| mode & !0o666 == 0 && mode & 0o600 == 0o600);
        mode.map(Self).ok_or_else(|| {
            format!(
                "\"{text}\" is no mode of files that the deployment itself can read and write; write it as in \"600\" or \
                 \"640\""
            )
        })
    }

    /// Returns the mask of the process's new files and folders.
    pub(crate) fn mask(self) -> u32 {
        let enter = (self.0 & 0o444) >> 2;
        0o777 & !(self.0 | enter)
    }
}

settings::spelt_as!(FileMode, String, "text", Self::parse, |mode| format!("{:o}", mode.0));

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

    fn join(&self, deployment: &mut Deployment) -> Result<(), SettingsError> {
        let fusion = &deployment.fusion;
        check_cores(
            &[
                ("fusion.core", fusion.core),
                ("fusion.standby_core", fusion.standby_core),
            ],
            &runtime::cores::online(),
        )
    }
}

/// Checks that the machine, with these `cores`, has each core that a key names.
fn check_cores(named: &[(&str, Option<usize>)], cores: &[usize]) -> Result<(), SettingsError> {
    for (key, core) in named {
        if let Some(core) = core.filter(|core| !cores.contains(core)) {
            let what = format!("{core} does not exist or is switched off; this machine offers cores {cores:?}");
            return Err(SettingsError::new(*key, what));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_core_that_the_machine_lacks_is_refused_with_the_cores_that_it_has() {
        let named = |core| [("fusion.core", Some(1)), ("fusion.standby_core", core)];
        assert_eq!(check_cores(&named(None), &[0, 1]), Ok(()));
        let error = check_cores(&named(Some(4711)), &[0, 1]).unwrap_err();
        assert_eq!(error.key, "fusion.standby_core");
        assert!(error.what.contains("this machine offers cores [0, 1]"), "{error}");
    }

    #[test]
    fn whoever_may_read_a_file_may_enter_its_folder() {
        for (text, mask, file, folder) in [
            ("600", 0o077, 0o600, 0o700),
            ("0640", 0o027, 0o640, 0o750),
            ("644", 0o022, 0o644, 0o755),
            ("660", 0o007, 0o660, 0o770),
        ] {
            let mode = FileMode::parse(text.to_owned()).unwrap();
            assert_eq!(mode.mask(), mask, "{text}");
            assert_eq!((0o666 & !mask, 0o777 & !mask), (file, folder), "{text}");
        }
        for wrong in ["", "rw", "400", "060", "700", "1600", "-600", "689"] {
            assert!(
                FileMode::parse(wrong.to_owned()).unwrap_err().contains("is no mode"),
                "{wrong}"
            );
        }
    }
}

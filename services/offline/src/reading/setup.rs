//! Setup of an offline engine: from a configuration, and from the files themselves.

use std::path::Path;

use alerts::AlertRules;
use configuration::{Config, Offline};
use deployment::Deployment;
use frames::SystemFrame;
use fusion::Settings;
use fusion::settings::SOURCES_MAX;
use messages::FusionRule;

use super::arrivals::RowOrder;
use super::kept::KeptRows;
use super::merged::MergedRows;
use super::named::NamedTables;
use super::sensors::Sensors;
use super::survey::FileSurvey;
use crate::args::OfflineInput;
use crate::files::{InputError, Usage, named_twice};
use crate::host::Host;

/// Sources, settings and files.
pub(crate) struct Setup<'a> {
    host: &'a dyn Host,
    input: &'a OfflineInput,
    /// `sensor_id` of each source in the files.
    pub(crate) sensor_ids: Vec<u32>,
    pub(crate) settings: Settings,
    /// The deployment, if the configuration is a deployment's.
    pub(crate) deployment: Option<Deployment>,
    /// Rules of alerts, if the configuration is a deployment's.
    pub(crate) alerts: Option<AlertRules>,
    /// The tables of named columns among the files.
    pub(crate) named: NamedTables,
    /// Sensors with configured accuracy, so that the positions need no variances; `None`: all.
    accurate: Option<Vec<u32>>,
    /// The rows of the files, if kept by the first pass.
    kept: Option<KeptRows>,
}

/// Configuration given by `--config`.
enum FuseConfiguration {
    Deployment(Box<Config>),
    Offline(Box<Offline>),
}

impl FuseConfiguration {
    /// Sensors with configured accuracy; `None`: all, as in a deployment.
    fn accurate(&self) -> Option<Vec<u32>> {
        match self {
            Self::Deployment(_) => None,
            Self::Offline(config) => Some(config.accurate_sensors()),
        }
    }

    /// The system's plane on the Earth, and the names of the sensors with their ids, as far as they are configured.
    fn facts(&self) -> (Option<SystemFrame>, Vec<(String, u32)>) {
        match self {
            Self::Deployment(config) => {
                let sources = config.sources.iter();
                let named = sources.map(|source| (source.name.clone(), observations::sensor_id(source.number)));
                (Some(config.deployment.frame), named.collect())
            }
            Self::Offline(config) => (None, config.named_sensors()),
        }
    }
}

impl<'a> Setup<'a> {
    /// Reads the configuration, and the files once.
    ///
    /// # Errors
    /// If the configuration or a file cannot be used.
    pub(crate) fn of(host: &'a dyn Host, input: &'a OfflineInput) -> anyhow::Result<Self> {
        if let Some(file) = named_twice(&input.tracks) {
            return Err(Usage(format!("--tracks names {} twice; name it once", file.display())).into());
        }
        let given = match &input.config {
            Some(path) => given(host, path)?,
            None => FuseConfiguration::Offline(Box::default()),
        };
        let accurate = given.accurate();
        let named = NamedTables::of(host, input, given.facts())?;
        let survey = FileSurvey::of(host, (&input.tracks, &named), accurate.clone())?;
        let (sensor_ids, mut settings, deployment, alerts) = match given {
            FuseConfiguration::Deployment(config) => {
                let ids = config
                    .sources
                    .iter()
                    .map(|source| observations::sensor_id(source.number));
                (
                    ids.collect(),
                    config.engine,
                    Some(config.deployment),
                    Some(config.alerts),
                )
            }
            FuseConfiguration::Offline(config) => {
                check(input, &survey)?;
                let mut found = config.settings(&survey.sensors)?;
                for (id, source) in found.sensor_ids.iter().zip(&mut found.engine.sources) {
                    if let Some(name) = named.sensor_name(*id) {
                        source.name = name;
                    }
                }
                (found.sensor_ids, found.engine, None, None)
            }
        };
        if survey.has_arrivals {
            settings.expect_late_reports();
        } else {
            settings.late_window_s = None;
        }
        Ok(Self {
            host,
            input,
            sensor_ids,
            settings,
            deployment,
            alerts,
            named,
            accurate,
            kept: survey.kept,
        })
    }

    /// Opens the reports, from the beginning.
    ///
    /// # Errors
    /// If a file cannot be read.
    pub(crate) fn reports(&self) -> Result<MergedRows, InputError> {
        let sensors = Sensors {
            ids: self.sensor_ids.clone(),
            accurate: self.accurate.clone(),
            ..Sensors::default()
        };
        let files = (&self.input.tracks[..], &self.named);
        let kept = self.kept.as_ref();
        if let Some(kept) = kept
            .map(|kept| MergedRows::of_kept(files, kept, &sensors))
            .transpose()?
            .flatten()
        {
            return Ok(kept);
        }
        MergedRows::open(self.host, files, sensors, RowOrder::Arrival)
    }
}

fn check(input: &OfflineInput, survey: &FileSurvey) -> Result<(), InputError> {
    let file = &input.tracks[0];
    if let Some(id) = survey.excess {
        let what = format!("sensor_id {id} is one too many: fusion takes up to {SOURCES_MAX} sensors");
        return Err(InputError::new(file, what));
    }
    if survey.sensors.is_empty() {
        let why = survey
            .first_refusal
            .as_deref()
            .unwrap_or("the files have a header only");
        return Err(InputError::new(file, format!("no row can be used: {why}")));
    }
    Ok(())
}

/// Reads a configuration: a file with sources is a deployment; any other file configures file input.
fn given(host: &dyn Host, path: &Path) -> anyhow::Result<FuseConfiguration> {
    let text = host.text(path)?;
    let is_deployment = Config::is_deployment(&text);
    Ok(if is_deployment {
        FuseConfiguration::Deployment(Box::new(host.deployment(path, &text, &[])?))
    } else {
        FuseConfiguration::Offline(Box::new(Offline::parse(path, &text)?))
    })
}

/// Returns the rule called `name`.
///
/// # Errors
/// If the name is unknown; the message lists the known names.
pub(crate) fn rule(name: &str) -> Result<FusionRule, Usage> {
    FusionRule::from_word(name).ok_or_else(|| {
        let known = FusionRule::ALL.map(FusionRule::word);
        Usage(format!(
            "--rule {name}: there is no such rule; there are {}",
            known.join(", ")
        ))
    })
}

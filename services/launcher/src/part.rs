//! Processes of a deployment and command lines.

use std::ffi::OsString;
use std::path::Path;

use deployment::Deployment;
use messages::{NO_SOURCE, ProcessKind};
use runtime::{Options, Speed};

/// Process of a deployment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ProcessPart {
    /// Kind.
    pub(crate) kind: ProcessKind,
    /// Name, also in health messages: the name of the source or receiver for an adapter, an own name for a gateway,
    /// else the name of the kind.
    pub(crate) name: String,
    /// Number of the source, for an adapter of a single source.
    pub(crate) source: u16,
    /// Whether the deployment ends if the process cannot be kept running.
    pub(crate) required: bool,
}

/// Name of the standby fusion.
const STANDBY: &str = "standby";

/// Kinds in the order of the start: readers before publishers.
pub(crate) const START_ORDER: [&[ProcessKind]; 4] = [
    &[ProcessKind::Keeper],
    &[
        ProcessKind::Monitor,
        ProcessKind::Recorder,
        ProcessKind::Gateway,
        ProcessKind::Display,
        ProcessKind::Alerts,
        ProcessKind::Link,
        ProcessKind::Fusion,
    ],
    &[ProcessKind::Adapter],
    &[ProcessKind::Simulator],
];

/// Kinds in the order of the stop: sources first, then the monitor, which still observes the end of the others, and
/// last the keeper, which holds all topics.
pub(crate) const STOP_ORDER: [ProcessKind; 10] = [
    ProcessKind::Simulator,
    ProcessKind::Adapter,
    ProcessKind::Fusion,
    ProcessKind::Alerts,
    ProcessKind::Recorder,
    ProcessKind::Gateway,
    ProcessKind::Display,
    ProcessKind::Link,
    ProcessKind::Monitor,
    ProcessKind::Keeper,
];

/// Returns the processes of a deployment, in the order of the start.
pub(crate) fn parts(config: &Deployment) -> Vec<ProcessPart> {
    let service = ProcessPart::service;
    let mut parts = vec![service(ProcessKind::Keeper), service(ProcessKind::Monitor)];
    parts.extend(config.services.recorder.then(|| service(ProcessKind::Recorder)));
    let gateways = config.services.gateways.iter().map(|gateway| &gateway.name);
    parts.extend(gateways.map(|name| ProcessPart::named(ProcessKind::Gateway, name)));
    let links = config.links.iter().map(|link| &link.name);
    parts.extend(links.map(|name| ProcessPart::named(ProcessKind::Link, name)));
    parts.extend(config.services.alerts.then(|| service(ProcessKind::Alerts)));
    parts.extend(config.services.display.then(|| service(ProcessKind::Display)));
    parts.push(ProcessPart::leader());
    parts.extend(config.has_standby().then(|| ProcessPart {
        name: STANDBY.to_owned(),
        ..service(ProcessKind::Fusion)
    }));
    parts.extend(config.adapters().into_iter().map(|name| adapter(config, name)));
    parts.extend(config.is_simulated().then(|| service(ProcessKind::Simulator)));
    parts
}

fn adapter(config: &Deployment, name: &str) -> ProcessPart {
    let all = config.sources.iter().chain(&config.tracker_sensors);
    let mut sources = all.filter(|source| source.adapter == name);
    let required = sources.clone().any(|source| source.required);
    let source = match (sources.next(), sources.next()) {
        (Some(only), None) => only.number,
        _ => NO_SOURCE,
    };
    ProcessPart {
        kind: ProcessKind::Adapter,
        name: name.to_owned(),
        source,
        required,
    }
}

impl ProcessPart {
    /// Creates a service that exists once.
    fn service(kind: ProcessKind) -> Self {
        Self::named(kind, kind.word())
    }

    /// Creates a service that may exist several times.
    fn named(kind: ProcessKind, name: &str) -> Self {
        Self {
            kind,
            name: name.to_owned(),
            source: NO_SOURCE,
            required: false,
        }
    }

    /// Creates the leading fusion.
    pub(crate) fn leader() -> Self {
        Self::service(ProcessKind::Fusion)
    }

    /// Returns the name in messages.
    pub(crate) fn title(&self) -> String {
        match self.kind {
            ProcessKind::Adapter | ProcessKind::Gateway | ProcessKind::Link => {
                format!("{} {}", self.kind.word(), self.name)
            }
            _ => self.name.clone(),
        }
    }

    /// Returns the command line of the process.
    pub(crate) fn arguments(&self, config: &Path, options: &Options, launcher: u32) -> Vec<OsString> {
        let speed = match options.speed {
            Speed::Factor(factor) => factor.to_string(),
            Speed::Max => "max".to_owned(),
        };
        let mut arguments: Vec<OsString> = vec![self.kind.word().into()];
        // A single word for each option with the value, so that no value is taken for an option.
        let mut give = |option: &str, value: OsString| {
            let mut argument = OsString::from(option);
            argument.push("=");
            argument.push(value);
            arguments.push(argument);
        };
        give("--config", config.into());
        give("--name", (&self.name).into());
        give("--instance", (&options.instance).into());
        for each in &options.overrides {
            give("--set", each.into());
        }
        give("--data", (&options.data).into());
        give("--out", (&options.out).into());
        give("--speed", speed.into());
        give("--seed", options.seed.to_string().into());
        give("--scenario-start", options.scenario_start_ns.to_string().into());
        give("--launcher", launcher.to_string().into());
        arguments
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use configuration::{BUILT_IN_DEMO, Config};

    #[test]
    fn keeper_and_monitor_start_first_and_stop_last() {
        let mut config = Config::read(Path::new(BUILT_IN_DEMO), &[]).unwrap().deployment;
        // As set by the keys of recorder and display.
        (config.services.recorder, config.services.display) = (true, true);
        let kinds: Vec<ProcessKind> = parts(&config).iter().map(|part| part.kind).collect();
        use ProcessKind::{Adapter, Display, Fusion, Keeper, Monitor, Recorder};
        assert_eq!(kinds[..6], [Keeper, Monitor, Recorder, Display, Fusion, Adapter]);
        assert_eq!(kinds.len(), 5 + config.sources.len() + 1, "and the simulator");
        assert_eq!(STOP_ORDER[8..], [Monitor, Keeper]);
    }

    #[test]
    fn every_option_reaches_the_child() {
        let part = ProcessPart {
            kind: ProcessKind::Adapter,
            name: "radar".to_owned(),
            source: 0,
            required: false,
        };
        let options = Options {
            overrides: vec!["a.b=1".to_owned(), "c=\"-x\"".to_owned()],
            instance: "test".to_owned(),
            data: "data folder".into(),
            out: "-out".into(),
            speed: Speed::Factor(2.5),
            seed: 7,
            scenario_start_ns: -1,
            launcher: None,
        };
        assert_eq!(
            part.arguments(Path::new("a.toml"), &options, 4711),
            [
                "adapter",
                "--config=a.toml",
                "--name=radar",
                "--instance=test",
                "--set=a.b=1",
                "--set=c=\"-x\"",
                "--data=data folder",
                "--out=-out",
                "--speed=2.5",
                "--seed=7",
                "--scenario-start=-1",
                "--launcher=4711"
            ]
        );
    }
}

//! `koseki`: a single executable that contains every process of a deployment (PL-1).
//!
//! The crates of the services contain the processes. This crate contains the command line ([`args`]), the check of
//! recordings against the configuration ([`recordings`]), and commands: questions ([`check`], [`mod@doctor`],
//! [`status`], [`top`]), orders ([`order`]), files for the machine ([`mod@generate`]), and work on files
//! ([`mod@recording_info`], [`decode`], [`encode`], [`bearings`], [`send`]). Commands on tables are in [`offline`].
//! Rarely needed functions are in programs that are built separately, and executed by this program ([`programs`],
//! [`link`], [`lab`]). Before everything else the program becomes the one for this processor, if there is one
//! ([`processor`]).
//!
//! Every command ends with exit code 0, with 2 after wrong usage or configuration, or with 1 after a failure while
//! running or with a result that is worth nothing; the latter two after a line on standard error (FM-16).

#![forbid(unsafe_code)]

mod args;
mod bearings;
mod check;
mod check_trackers;
mod config;
mod decode;
mod doctor;
mod editions;
mod encode;
mod feed;
mod generate;
mod given;
mod instances;
mod kinds;
mod lab;
mod link;
mod new_config;
mod open;
mod order;
mod processor;
mod programs;
mod recording_copy;
mod recording_export;
mod recording_foxglove;
mod recording_info;
mod recording_paths;
mod recordings;
mod replay;
mod send;
mod status;
mod tap;
mod top;

use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use bus::BusError;
use clap::{CommandFactory as _, Parser as _};
use configuration::BUILT_IN_DEMO;
use launcher::RunOptions;
use messages::ProcessKind;
use offline::{Host, TableCommand, Terminal, Usage};
use runtime::{Now, Options, Process};
use scenario::VisibleTargets;

use args::{Cli, Command, Serve};
use command_line::{CODE_FAILED, CODE_REFUSED};
use config::Config;
use recordings::{Depth, UnusableRecording};

fn main() -> ExitCode {
    processor::become_fastest();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return command_line::refuse_usage(&error, &Cli::command()),
    };
    let root = cli.root;
    let done = match &root {
        Some(root) => command_line::with_root(root).map_err(|refused| Usage(refused).into()),
        None => Ok(()),
    };
    match done.and_then(|()| run(cli.command)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let code = match root.is_some_and(|root| is_about(&root, &error)) {
                true => CODE_REFUSED,
                false => exit_code(&error),
            };
            command_line::end_with(code, command_line::reason(error.as_ref()))
        }
    }
}

fn run(command: Command) -> anyhow::Result<()> {
    match command {
        Command::Demo(mut demo) => {
            demo.set
                .extend(demo.no_display.then(|| "display.listen=\"off\"".to_owned()));
            let config = Config::read(Path::new(BUILT_IN_DEMO), &demo.set)?;
            let options = Options {
                overrides: demo.set,
                data: args::data_folder(None),
                out: args::out_folder(demo.out, &demo.instance),
                speed: runtime::Speed::Factor(1.0),
                seed: demo.seed,
                scenario_start_ns: Now::read().utc_ns,
                launcher: None,
                instance: demo.instance,
            };
            launch(&config, options, demo.seconds, false)
        }
        Command::Up(up) => {
            let (config, options) = args::deployment(&up.config, up.shared)?;
            for found in recordings::inspect(&config, &options.data, Depth::Blocks)? {
                for doubt in &found.doubts {
                    runtime::notice(format_args!("koseki: {}: {doubt}", found.file.display()));
                }
            }
            display::check_maps(config.parts.display(), &config.frame, &options.data).map_err(Usage)?;
            display::check_views(config.parts.display(), &options.data).map_err(Usage)?;
            let areas = alerts_service::read_areas(&config.alerts, config.frame, &options.data);
            areas.map_err(|refusal| Usage(format!("{}: {refusal}", config.path.display())))?;
            launch(&config, options, up.seconds, up.fresh)
        }
        Command::Open(opened) => open::run(&opened),
        Command::New(new) => new_config::run(&new),
        Command::Check(check) => check::run(&check),
        Command::Doctor(doctor) => doctor::run(&doctor),
        Command::Generate(generate) => generate::run(&generate),
        Command::Status(status) => status::run(&status),
        Command::Top(top) => top::run(&top),
        Command::Recording(args::RecordingCommand::Info(info)) => recording_info::run(&info),
        Command::Recording(args::RecordingCommand::Cut(cut)) => recording_copy::cut(cut),
        Command::Recording(args::RecordingCommand::Merge(merge)) => recording_copy::merge(&merge),
        Command::Recording(args::RecordingCommand::Repair(repair)) => recording_copy::repair(&repair),
        Command::Recording(args::RecordingCommand::Export(export)) => recording_export::run(&export),
        Command::Replay(replay) => replay::run(&replay),
        Command::Tap(tap) => tap::run(&tap),
        Command::Feed(feed) => feed::run(&feed),
        Command::Order(order) => order::run(&order),
        Command::Condition(condition) => order::condition(&condition),
        Command::Decode(decode) => decode::run(&decode),
        Command::Encode(encode) => encode::run(&encode),
        Command::OnTables(TableCommand::Smooth(smooth)) if smooth.recording.is_some() => {
            replay::smoothing::run(&smooth, smooth.recording.as_deref().unwrap_or(Path::new("")))
        }
        Command::OnTables(command) => command.run(&Terminal::reading(config::read)),
        Command::Bearings(bearings) => bearings::run(&bearings),
        Command::Send(send) => send::run(&send),
        Command::Torture(passed) => lab::run("torture", passed),
        Command::Bench(passed) => lab::run("bench", passed),
        Command::Keeper(serve) => run_service(ProcessKind::Keeper, serve, |process, _| launcher::keeper::run(process)),
        Command::Adapter(serve) => run_service(ProcessKind::Adapter, serve, |process, config| {
            adapter::run(process, &config.readings)
        }),
        Command::Fusion(serve) => run_service(ProcessKind::Fusion, serve, |process, config| {
            fusion_service::run(process, &config.engine)
        }),
        Command::Monitor(serve) => run_service(ProcessKind::Monitor, serve, |process, config| {
            monitor::run(
                process,
                config.parts.monitor(),
                simulated_targets(config, &process.options)?,
            )
        }),
        Command::Recorder(serve) => run_service(ProcessKind::Recorder, serve, |process, config| {
            recorder::run(process, config.parts.recorder(), args::VERSION)
        }),
        Command::Gateway(serve) => run_service(ProcessKind::Gateway, serve, |process, config| {
            gateway::run(process, &config.parts.gateway)
        }),
        Command::Alerts(serve) => run_service(ProcessKind::Alerts, serve, |process, config| {
            alerts_service::run(process, &config.alerts)
        }),
        Command::Link(serve) => link::run(serve),
        Command::Display(command) => show_picture(command),
        Command::Simulator(serve) => run_service(ProcessKind::Simulator, serve, |process, config| {
            simulator::run(process, &config.world)
        }),
    }
}

/// Shows a recording, runs the display of a configuration, or shows a running instance without a configuration.
fn show_picture(command: args::DisplayArgs) -> anyhow::Result<()> {
    let listen = command.listen.as_deref();
    let unconfigured =
        || display::Settings::unconfigured(listen).map_err(|error| Usage(format!("--listen: {}", error.what)));
    if command.config.is_none() && !command.shared.set.is_empty() {
        return Err(Usage("--set replaces values of a configuration: give it with --config".to_owned()).into());
    }
    match (command.recording, command.config) {
        (Some(recording), config) => {
            let given = config.map(|path| args::deployment(&path, command.shared)).transpose()?;
            let given = given.as_ref().map(|(config, options)| (config, &*options.data));
            replay::show(&recording, unconfigured()?, given)
        }
        (None, Some(config)) => {
            let mut shared = command.shared;
            let listen = listen.map(|listen| format!("display.listen=\"{listen}\""));
            shared.set.extend(listen);
            let serve = Serve {
                config,
                name: command.name,
                shared,
                launcher: command.launcher,
            };
            run_service(ProcessKind::Display, serve, |process, config| {
                display::run(process, config.parts.display(), &config.engine)
            })
        }
        (None, None) => {
            let root = instances::running_or_only(command.shared.instance.as_deref())?;
            display::show_instance(&root, &unconfigured()?)
        }
    }
}

/// Creates the folder of recordings and tests writing there, before several processes fail for this reason.
fn make_out_folder(config: &Config, options: &Options) -> Result<(), Usage> {
    if !config.parts.recorder().enabled && !config.parts.monitor().files {
        return Ok(());
    }
    let out = options.out.display();
    std::fs::create_dir_all(&options.out)
        .map_err(|error| Usage(format!("--out {out}: the folder cannot be made: {error}; name another")))?;
    tempfile::tempfile_in(&options.out).map_err(|error| {
        Usage(format!(
            "--out {out}: nothing can be written there: {error}; name another"
        ))
    })?;
    Ok(())
}

fn launch(config: &Config, options: Options, run_for: Option<Duration>, fresh: bool) -> anyhow::Result<()> {
    instances::named(&options.instance)?;
    make_out_folder(config, &options)?;
    let orders = RunOptions {
        options,
        run_for,
        fresh,
    };
    launcher::run(config, config.parts.launcher(), &orders)
}

/// Runs a process of a deployment.
fn run_service(
    kind: ProcessKind,
    serve: Serve,
    service: impl FnOnce(&Process, &Config) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let (config, mut options) = args::deployment(&serve.config, serve.shared)?;
    options.launcher = serve.launcher;
    instances::named(&options.instance)?;
    let name = process_name(kind, serve.name, &config)?;
    let named = |error: anyhow::Error| match kind {
        ProcessKind::Adapter | ProcessKind::Gateway | ProcessKind::Link => {
            error.context(format!("{} {name}", kind.word()))
        }
        _ => error.context(name.clone()),
    };
    let is_child = options.launcher.is_some();
    let connected = Process::connect(config.deployment.clone(), options, kind, &name);
    let process = connected.map_err(|error| match error.downcast_ref() {
        // A launcher would take a refusal for a fault of the configuration.
        Some(BusError::NotRunning { .. }) if !is_child => Usage(format!("{name}: {error:#}")).into(),
        _ => named(error),
    })?;
    service(&process, &config).map_err(named)
}

/// Targets of the simulated world, for the monitor; `None` if no source is simulated.
fn simulated_targets(config: &Config, options: &Options) -> anyhow::Result<Option<monitor::SimulatedTargets>> {
    let Some(targets) = config
        .world
        .targets
        .as_ref()
        .filter(|_| !config.world.instruments.is_empty())
    else {
        return Ok(None);
    };
    let visible = VisibleTargets::new(&config.world, config.frame, options.seed, options.scenario_start_ns)?;
    let visible_at = |visible: VisibleTargets| {
        let seen = move |time_s, seen: &mut Vec<monitor::PictureTarget>| {
            seen.extend(visible.at(time_s).map(|target| monitor::PictureTarget {
                id: target.id,
                position_m: target.position_m,
                address: target.address,
            }));
        };
        monitor::VisibleAt(Box::new(seen))
    };
    Ok(Some(monitor::SimulatedTargets {
        count: targets.target_count(options.seed),
        visible: visible.map(visible_at),
    }))
}

/// Adapters, gateways and links have configured names; other processes may have any name, by default the name of the
/// kind.
fn process_name(kind: ProcessKind, given: Option<String>, config: &Config) -> Result<String, Usage> {
    let names: Vec<&str> = match kind {
        ProcessKind::Adapter => config.adapters(),
        ProcessKind::Link => config.links.iter().map(|link| link.name.as_str()).collect(),
        ProcessKind::Gateway => config.parts.gateway.names().map(|(_, name)| name.as_str()).collect(),
        _ => return Ok(given.unwrap_or_else(|| kind.word().to_owned())),
    };
    let (kind, path) = (kind.word(), config.path.display());
    let known = if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    };
    match given {
        Some(name) if names.contains(&name.as_str()) => Ok(name),
        Some(name) => Err(Usage(format!(
            "--name {name}: {path} has no {kind} of this name; there are: {known}"
        ))),
        None => Err(Usage(format!(
            "{kind} needs --name with one of the names in {path}: {known}"
        ))),
    }
}

fn exit_code(error: &anyhow::Error) -> u8 {
    let refused = offline::is_refused(error) || error.is::<UnusableRecording>() || error.is::<launcher::ChildRefused>();
    if refused { CODE_REFUSED } else { CODE_FAILED }
}

/// Whether the folder of `--root` cannot be used.
fn is_about(root: &Path, error: &anyhow::Error) -> bool {
    let root = std::path::absolute(root).unwrap_or_default();
    match error.downcast_ref() {
        Some(BusError::Io { path, .. }) => root.starts_with(path) || path.parent() == Some(&root),
        Some(BusError::BaseNotPrivate { .. }) => true,
        _ => false,
    }
}

/// Prints an answer.
fn print(text: &str) -> anyhow::Result<()> {
    Terminal::default().print(text)
}

/// Shows a summary: as JSON on standard output, else on standard error.
fn show(json: Option<serde_json::Value>, text: impl FnOnce() -> String) -> anyhow::Result<()> {
    let terminal: &dyn Host = &Terminal::default();
    terminal.show(json, text)
}

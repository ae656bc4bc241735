//! The scenario `on-board`: a rolling, turning ship with a radar, as files for `koseki track --platform`.

use std::io::Write as _;
use std::path::Path;

use anyhow::Context as _;
use formats::detections_csv::DetectionWriter;
use formats::platform_states_csv::PlatformStateWriter;
use messages::StageTimes;
use observations::Detection;
use scenario::{OnBoardSettings, SeaTarget};
use settings::Document;

use crate::args::Simulate;
use crate::files::{Usage, unwritable};
use crate::host::Host;

/// Name of the scenario.
pub(super) const NAME: &str = "on-board";

/// Writes the voyage's files.
///
/// # Errors
/// If a setting is not possible, or a file cannot be written.
pub(super) fn run(simulate: &Simulate, host: &dyn Host) -> anyhow::Result<()> {
    let settings: OnBoardSettings = Document::parse("", &simulate.set)
        .and_then(|document| document.read())
        .map_err(|error| Usage(format!("--set {error}")))?;
    let out = &simulate.out;
    host.make_folder(out).map_err(|error| unwritable(out, &error))?;
    let voyage = settings.voyage(simulate.seed, simulate.seconds.as_secs_f64());
    let unwritten = || format!("{} cannot be written", out.display());
    let mut states = PlatformStateWriter::begin(host.begin(&out.join("platform.csv"))?, 0).with_context(unwritten)?;
    for state in &voyage.states {
        states
            .write(&state.sample(0, StageTimes::default()))
            .with_context(unwritten)?;
    }
    states.into_inner().finish()?;
    write_detections(host, &out.join("detections.csv"), &voyage.on_board)?;
    write_detections(host, &out.join("at_rest.csv"), &voyage.at_rest)?;
    write_truth(host, &out.join("truth.csv"), &voyage.truth).with_context(unwritten)?;
    let [forward, right, up] = settings.lever_arm_m;
    let mut mounting = host.begin(&out.join("mounting.toml"))?;
    write!(
        mounting,
        "# Accelerations of ships; the usual ones are those of aircraft.\n\
         [motion]\nprocess_noise_m2ps3 = [{}, 0.001]\nslow_mps = 0.001\n\
         [motion.manoeuvres]\nenabled = false\n\n\
         # Targets at sea: without this, a tracker assumes them kilometres above and below the radar.\n\
         [initiation]\nheight_sigma_m = 30.0\nclimb_sigma_mps = 0.1\n\n\
         [platform]\n[[platform.sensor]]\nid = 1\nlever_arm_m = [{forward}, {right}, {up}]\n",
        settings.acceleration_m2ps3.max(1e-6)
    )
    .with_context(unwritten)?;
    mounting.finish()?;
    host.say(&format!(
        "platform: {} states; radar on board: {} detections; the same looks from a radar at rest: at_rest.csv\n\
         {} targets; files in {}\n",
        voyage.states.len(),
        voyage.on_board.len(),
        settings.targets,
        out.display()
    ));
    Ok(())
}

fn write_detections(host: &dyn Host, path: &Path, detections: &[Detection]) -> anyhow::Result<()> {
    let unwritten = || format!("{} cannot be written", path.display());
    let mut table = DetectionWriter::begin(host.begin(path)?, 0).with_context(unwritten)?;
    for detection in detections {
        table.write(detection).with_context(unwritten)?;
    }
    table.into_inner().finish()
}

fn write_truth(host: &dyn Host, path: &Path, truth: &[SeaTarget]) -> anyhow::Result<()> {
    let mut out = host.begin(path)?;
    writeln!(out, "time_s,target_id,x,y,z,vx,vy,vz")?;
    for target in truth {
        let ([x, y], [vx, vy]) = (target.position_m, target.velocity_mps);
        writeln!(out, "{},{},{x:.3},{y:.3},0,{vx:.4},{vy:.4},0", target.time_s, target.id)?;
    }
    out.finish()
}

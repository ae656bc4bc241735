//! `koseki condition`: tells a running deployment which condition (weather) holds from now on (TI-7).
//!
//! Sensor accuracies may depend on a named condition. The order goes to fusion on the control topic, again after a
//! second unless fusion's health messages show that it was obeyed or refused: repeating it changes nothing.

use std::time::Duration;

use anyhow::bail;
use bus::{Bus, Mark, SharedMemory, Subscriber};
use messages::{Control, Counter, Health, NO_SOURCE, ProcessKind};
use offline::Usage;
use runtime::clock::{instant, mono_ns};

use crate::args::Condition;
use crate::instances;

/// How long to wait for fusion's word.
const PATIENCE: Duration = Duration::from_secs(5);
/// Pause between two looks for it.
const PAUSE: Duration = Duration::from_millis(50);
/// Time after which the order is repeated: far longer than an answer takes.
const REPEAT: Duration = Duration::from_secs(1);

/// Orders the condition.
///
/// # Errors
/// If the instance does not run, or its fusion does not know the condition or does not answer.
pub(crate) fn run(condition: &Condition) -> anyhow::Result<()> {
    let root = instances::running(&condition.instance)?;
    let too_long = || {
        Usage(format!(
            "\"{}\" is no condition: names have at most 32 bytes",
            condition.name
        ))
    };
    let order = Control::condition(&condition.name).ok_or_else(too_long)?;
    let bus = Bus::<SharedMemory>::open(&root, "condition")?;
    let mut health = bus.subscriber(&messages::health(), || mono_ns() as u64)?;
    let mut control = bus.publisher(&messages::control(), mono_ns() as u64)?;
    let (start, mut before) = (instant(), None);
    let mut due = start;
    while instant() - start < PATIENCE {
        if let Some(now) = answer(&mut health)? {
            let (obeyed, refused) = before.get_or_insert(now);
            if now.0 > *obeyed {
                println!("{}: condition {} holds", condition.instance, condition.name);
                return Ok(());
            }
            if now.1 > *refused {
                bail!(Usage(format!(
                    "no source of instance {} has an accuracy for the condition \"{}\"; name one of its configuration's, \
                     or \"normal\"",
                    condition.instance, condition.name
                )));
            }
        }
        if before.is_some() && instant() >= due {
            due = instant() + REPEAT;
            control.send(
                Mark {
                    progress_ns: i64::MIN,
                    sent_ns: mono_ns(),
                    end: false,
                },
                1,
                |_, _| order,
            )?;
        }
        std::thread::sleep(PAUSE);
    }
    bail!("fusion of instance {} does not answer", condition.instance)
}

/// How many orders fusion has obeyed and refused, if it has said anything.
fn answer(health: &mut Subscriber<SharedMemory, Health>) -> anyhow::Result<Option<(u64, u64)>> {
    let mut latest = None;
    health.take(usize::MAX, |_, said| {
        for health in said
            .iter()
            .filter(|health| health.kind() == Some(ProcessKind::Fusion) && health.source == NO_SOURCE)
        {
            latest = Some((
                health.counters[Counter::OrdersObeyed],
                health.counters[Counter::OrdersRejected],
            ));
        }
    })?;
    Ok(latest)
}

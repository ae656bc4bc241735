//! `koseki order`: gives orders to the fusion of a running deployment, and lists the orders in force.
//!
//! Kinds and parameters come from the registry of orders ([`OrderKind`]). Names of sources come from the configuration
//! that the instance runs with.

use std::time::Duration;

use anyhow::bail;
use bus::{Bus, OrderPort, Root, SharedMemory};
use formats::rows::Utc;
use messages::{NO_SOURCE, NS_PER_S, Order, OrderKind, OrderState, OrderStatus, Parameter};
use offline::Usage;
use runtime::Now;
use runtime::clock::{instant, mono_ns};
use serde_json::{Value, json};
use telemetry::table::{Align, TextTable};

use crate::args::{ConditionArgs, GiveOrder};
use crate::config::Config;
use crate::instances;

/// Time to wait for the answer: with a standby, a take-over fits.
const PATIENCE: Duration = Duration::from_secs(10);
/// Time to wait for the list of orders: fusion publishes the list twice a second, unless the list is empty.
const LIST_PATIENCE: Duration = Duration::from_millis(1200);
/// Pause between two looks.
const PAUSE: Duration = Duration::from_millis(10);

/// Gives the order, or lists the orders.
///
/// # Errors
/// If the instance does not run, or the order is refused or not answered.
pub(crate) fn run(args: &GiveOrder) -> anyhow::Result<()> {
    let Some(kind) = &args.kind else {
        return list(&args.instance, args.json);
    };
    let pairs: Result<Vec<(&str, &str)>, Usage> = args.parameters.iter().map(|pair| split(pair)).collect();
    give(&args.instance, kind, &pairs?, args)
}

/// Gives the order that `koseki condition` stands for.
///
/// # Errors
/// As [`run`].
pub(crate) fn condition(condition: &ConditionArgs) -> anyhow::Result<()> {
    let args = GiveOrder {
        instance: condition.instance.clone(),
        ..GiveOrder::default()
    };
    give(
        &args.instance,
        OrderKind::Condition.word(),
        &[("name", &condition.name)],
        &args,
    )
}

fn split(pair: &str) -> Result<(&str, &str), Usage> {
    let found = pair.split_once('=');
    found.ok_or_else(|| {
        Usage(format!(
            "\"{pair}\" is no parameter: write NAME=VALUE, as in source=radar"
        ))
    })
}

fn give(instance: &str, kind: &str, pairs: &[(&str, &str)], args: &GiveOrder) -> anyhow::Result<()> {
    let root = instances::running(instance)?;
    let config = Config::of_running(root.path())?;
    let number = |name: &str| config.source(name).map(|source| source.number);
    let order = Order::parse(kind, pairs.iter().copied(), number).map_err(Usage)?;
    let now = Now::read();
    let lasts_ns = args.lasts.map(|lasts| lasts.as_nanos() as i64);
    let order = Order {
        ends_ns: lasts_ns.map_or(i64::MAX, |lasts_ns| now.utc_ns.saturating_add(lasts_ns)),
        ..order.with_operator(&args.operator.clone().unwrap_or_else(own_name))
    };
    let bus = Bus::<SharedMemory>::open(&root, "order")?;
    let mut port = OrderPort::open(&bus, mono_ns() as u64)?;
    port.give(&order, now.utc_ns);
    let start = instant();
    while instant() - start < PATIENCE {
        if let Some(state) = port.turn(mono_ns())? {
            return report(&state, &config, instance, args.json);
        }
        std::thread::sleep(PAUSE);
    }
    bail!("fusion of instance {instance} does not answer; `koseki status` shows its state")
}

/// Name of the user of this process.
fn own_name() -> String {
    let name = ["LOGNAME", "USER"]
        .into_iter()
        .find_map(|name| std::env::var(name).ok());
    name.filter(|name| !name.is_empty())
        .unwrap_or_else(|| format!("user {}", rustix::process::getuid().as_raw()))
}

fn report(state: &OrderState, config: &Config, instance: &str, is_json: bool) -> anyhow::Result<()> {
    if is_json {
        let text = serde_json::to_string_pretty(&in_json(state, config))?;
        crate::print(&(text + "\n"))?;
    }
    match state.status() {
        Some(OrderStatus::Refused) => Err(Usage(format!("refused: {}", state.text())).into()),
        _ if is_json => Ok(()),
        _ => crate::print(&format!(
            "{instance}: order {}, {}: {}\n",
            state.number,
            words(&state.order, Some(config)),
            state.text()
        )),
    }
}

fn list(instance: &str, is_json: bool) -> anyhow::Result<()> {
    let root = instances::running(instance)?;
    let config = Config::of_running(root.path())?;
    let states = listed(&root, LIST_PATIENCE)?;
    if is_json {
        let list: Vec<Value> = states.iter().map(|state| in_json(state, &config)).collect();
        return crate::print(&(serde_json::to_string_pretty(&list)? + "\n"));
    }
    if states.is_empty() {
        return crate::print(&format!("{instance}: no order is in force\n"));
    }
    crate::print(&table(&states, &config))
}

/// Returns the orders of a running instance, in force or ended recently.
///
/// # Errors
/// If shared memory fails.
fn listed(root: &Root, patience: Duration) -> anyhow::Result<Vec<OrderState>> {
    let bus = Bus::<SharedMemory>::open(root, "order")?;
    let mut states = bus.subscriber(&messages::order_states(), || mono_ns() as u64)?;
    let (start, mut list) = (instant(), Vec::new());
    while instant() - start < patience && list.is_empty() {
        states.take(usize::MAX, |_, slice| list = slice.to_vec())?;
        std::thread::sleep(PAUSE);
    }
    Ok(list)
}

/// Returns a line for each order.
fn table(states: &[OrderState], config: &Config) -> String {
    let mut table = TextTable::new(&[
        ("number", Align::Right),
        ("state", Align::Left),
        ("order", Align::Left),
        ("operator", Align::Left),
        ("since (UTC)", Align::Left),
        ("until (UTC)", Align::Left),
        ("reason", Align::Left),
    ]);
    for state in states {
        let time = |time_ns: i64| match time_ns {
            i64::MAX | i64::MIN => String::new(),
            time_ns => Utc(time_ns - time_ns.rem_euclid(NS_PER_S as i64)).to_string(),
        };
        let number = match state.number {
            0 => String::new(),
            number => number.to_string(),
        };
        let reason = state.refusal().map_or_else(String::new, |_| state.text().to_owned());
        table.row([
            number,
            state.status().map_or("", OrderStatus::word).replace('-', " "),
            words(&state.order, Some(config)),
            state.order.operator().to_owned(),
            time(state.changed_ns),
            time(state.order.ends_ns),
            reason,
        ]);
    }
    table.to_string()
}

/// Returns the order as written on a command line.
pub(crate) fn words(order: &Order, config: Option<&Config>) -> String {
    order.words(|number| Some(config?.sources.get(usize::from(number))?.name.as_str()))
}

/// Returns the name of the source that a parameter states.
fn name_of(parameter: Parameter, order: &Order, config: &Config) -> Option<String> {
    let number = match parameter {
        Parameter::Source | Parameter::Tracker => order.source,
        Parameter::From => order.other_source,
        _ => NO_SOURCE,
    };
    let source = config.sources.get(usize::from(number));
    source.map(|source| source.name.clone())
}

fn in_json(state: &OrderState, config: &Config) -> Value {
    let order = &state.order;
    let parameters = order.parameters().map(|(parameter, value)| {
        let value = match (parameter, name_of(parameter, order, config)) {
            (_, Some(name)) => json!(name),
            (Parameter::Name | Parameter::Place, None) => json!(value),
            // A number is JSON.
            (_, None) => value.parse().unwrap_or(Value::Null),
        };
        (parameter.word().to_owned(), value)
    });
    let time = |time_ns: i64| (!matches!(time_ns, i64::MAX | i64::MIN)).then(|| time_ns as f64 / NS_PER_S);
    json!({
        "number": (state.number != 0).then_some(state.number),
        "state": state.status().map(OrderStatus::word),
        "refusal": state.refusal().map(messages::Refusal::word),
        "text": state.text(),
        "kind": order.kind().map(OrderKind::word),
        "parameters": parameters.collect::<serde_json::Map<String, Value>>(),
        "operator": order.operator(),
        "changed_s": time(state.changed_ns),
        "ends_s": time(order.ends_ns),
    })
}

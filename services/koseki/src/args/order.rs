//! Arguments of `koseki order`.

use std::time::Duration;

use clap::Args;
use messages::OrderKind;
use offline::values::seconds;

/// `koseki order`.
#[derive(Debug, Default, Args)]
pub(crate) struct GiveOrder {
    /// Kind of the order; without a kind, the orders in force are listed
    pub(crate) kind: Option<String>,
    /// Parameters of the kind
    #[arg(value_name = "NAME=VALUE")]
    pub(crate) parameters: Vec<String>,
    /// The instance that receives the order
    #[arg(long, value_name = "NAME")]
    pub(crate) instance: String,
    /// Time after which the order expires, seconds [default: never]
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    pub(crate) lasts: Option<Duration>,
    /// Name of the operator, for the records [default: the user's]
    #[arg(long, value_name = "NAME")]
    pub(crate) operator: Option<String>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Returns the kinds of orders and examples.
pub(super) fn help() -> String {
    let kind = |kind: &OrderKind| format!("  {}\n      {}\n", kind.usage(), kind.summary());
    let kinds: String = OrderKind::ALL.iter().map(kind).collect();
    format!("Orders:\n{kinds}\n{ORDER_EXAMPLES}")
}

const ORDER_EXAMPLES: &str = "\
Examples:
  koseki order --instance barcelona
  koseki order eta value=0.3 source=radar --instance barcelona --for 600
  koseki order out source=mlat --instance barcelona --operator anna
  koseki order join track=12 with=15 --instance barcelona
  koseki order designate tracker=ship place=59.4312,10.6512 sigma=300 \\
      --instance ferry
  koseki order designate tracker=ship place=59.4312,10.6512@270/8.5 sigma=300 \\
      --instance ferry
  koseki order cancel number=3 --instance barcelona

An order holds until cancelled, replaced by a newer order for the same subject,
or expired. Orders survive kills of fusion, and end with the deployment.
Recordings contain each order and each change of its state. The owner of the
instance's folder gives orders; the file mode keeps other users out.";

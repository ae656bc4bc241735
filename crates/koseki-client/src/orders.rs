//! Orders to the fusion of a deployment.

use std::thread;
use std::time::Duration;

use bus::{OrderPort, Root};
use messages::{Order, OrderState};

use crate::clock::{mono_ns, utc_ns};
use crate::connection::{Connection, Medium};
use crate::directory;
use crate::error::Error;

/// Pause between two looks for the answer.
const PAUSE: Duration = Duration::from_millis(5);

/// Port for orders of one operator. The file mode of the instance's folder decides which users may open it.
///
/// ```no_run
/// # fn main() -> Result<(), koseki_client::Error> {
/// use koseki_client::messages::{Order, OrderKind};
///
/// let mut orders = koseki_client::Orders::open("demo", "anna")?;
/// let radar = orders.source("radar-west").expect("the demonstration has it");
/// let out = Order { source: radar, ..Order::new(OrderKind::Out) };
/// let answer = orders.give(&out, Some(600.0), std::time::Duration::from_secs(5))?;
/// match answer {
///     Some(state) => println!("{}", state.text()),
///     None => println!("fusion has not answered"),
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Orders {
    port: OrderPort<Medium>,
    operator: String,
    sources: Vec<String>,
    // After the port.
    connection: Connection,
}

impl Orders {
    /// Opens the port for `operator` in the deployment called `instance`.
    ///
    /// # Errors
    /// If the deployment does not run, was built from another version, or has no place left.
    pub fn open(instance: &str, operator: &str) -> Result<Self, Error> {
        Self::at(&Root::new(instance)?, operator)
    }

    /// As [`Orders::open`], in the deployment at `root`.
    ///
    /// # Errors
    /// As [`Orders::open`].
    pub fn at(root: &Root, operator: &str) -> Result<Self, Error> {
        let connection = Connection::open(root)?;
        Ok(Self {
            port: OrderPort::open(&connection.bus, mono_ns())?,
            operator: operator.to_owned(),
            sources: directory::sources(root),
            connection,
        })
    }

    /// Number of the source called `name`; `None` if the deployment has no such source.
    pub fn source(&self, name: &str) -> Option<u16> {
        let place = self.sources.iter().position(|source| source == name)?;
        u16::try_from(place).ok()
    }

    /// The order that these words state: those of `koseki order`, the kind and its parameters, such as
    /// `eta value=0.3 source=radar`.
    ///
    /// # Errors
    /// If the words are no order.
    pub fn of_words(&self, words: &str) -> Result<Order, Error> {
        self.read(words).map_err(|text| Error::Order { text })
    }

    /// Gives an order and waits for the answer: the state of the order, refused orders included; `None` if none comes
    /// within `timeout`. The order expires `lasts_s` seconds from now; `None`: never.
    ///
    /// # Errors
    /// If the deployment has ended.
    pub fn give(
        &mut self,
        order: &Order,
        lasts_s: Option<f64>,
        timeout: Duration,
    ) -> Result<Option<OrderState>, Error> {
        let now_ns = utc_ns();
        let lasts_ns = lasts_s.map(|lasts_s| (lasts_s.max(0.0) * messages::NS_PER_S) as i64);
        let order = Order {
            ends_ns: lasts_ns.map_or(i64::MAX, |lasts_ns| now_ns.saturating_add(lasts_ns)),
            ..(*order).with_operator(&self.operator)
        };
        self.port.give(&order, now_ns);
        let until_ns = mono_ns().saturating_add(u64::try_from(timeout.as_nanos()).unwrap_or(u64::MAX));
        loop {
            if let Some(state) = self.port.turn(mono_ns().cast_signed())? {
                return Ok(Some(state));
            }
            if self.connection.has_ended()? {
                return Err(self.connection.ended());
            }
            if mono_ns() >= until_ns {
                return Ok(None);
            }
            thread::sleep(PAUSE);
        }
    }

    fn read(&self, words: &str) -> Result<Order, String> {
        let mut words = words.split_whitespace();
        let kind = words.next().ok_or("an order begins with its kind")?;
        let pairs = words.map(|word| {
            let pair = word.split_once('=');
            pair.ok_or_else(|| format!("\"{word}\" is no parameter: write NAME=VALUE"))
        });
        let pairs = pairs.collect::<Result<Vec<_>, _>>()?;
        Order::parse(kind, pairs, |name| self.source(name))
    }

    /// Returns the orders in force and the orders that ended recently, as last published.
    ///
    /// # Errors
    /// If shared memory fails.
    pub fn list(&mut self) -> Result<&[OrderState], Error> {
        self.port.turn(mono_ns().cast_signed())?;
        Ok(self.port.list())
    }
}

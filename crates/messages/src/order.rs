//! Orders of operators to fusion, and their states.
//!
//! An order travels on the topic `orders`. Fusion writes the whole order into its event log before the effect, and
//! publishes the order with its state on `system/order-states`. [`OrderKind`] is the registry of kinds.

use crate::admission::REACH_M;
use crate::codes;
use crate::designated_place::DesignatedPlace;
use crate::health::{NO_SOURCE, fill, text};
use crate::layout::{Sample as _, sample};
use crate::order_kind::{OrderKind, Parameter};
use crate::{StepKind, WorkStep};

/// Track number that stands for none in [`Order::other_track`].
pub const NO_TRACK: u32 = u32::MAX;

codes! {
    /// State of an order at fusion.
    pub enum OrderStatus: u8 {
        /// The order has an effect that lasts.
        InForce = 1, "in-force";
        /// The effect has taken place, and nothing of it lasts.
        Done = 2, "done";
        /// Another order has cancelled this order.
        Cancelled = 3, "cancelled";
        /// The time of the order is over.
        Expired = 4, "expired";
        /// A newer order of this kind holds for the same subject.
        Replaced = 5, "replaced";
        /// The tracks no longer permit the effect: a track has ended, or the distance exceeded its limit.
        Ended = 6, "ended";
        /// The order has no effect: see `refusal`.
        Refused = 7, "refused";
    }
}

codes! {
    /// Reason of a refusal.
    pub enum Refusal: u8 {
        /// No such kind.
        UnknownKind = 1, "unknown-kind";
        /// A text is not UTF-8, the token is 0, or the expiry lies before 1970.
        Malformed = 2, "malformed";
        /// A parameter of the kind is missing.
        MissingParameter = 3, "missing-parameter";
        /// A parameter does not belong to the kind.
        ForeignParameter = 4, "foreign-parameter";
        /// The value lies outside its range.
        OutOfRange = 5, "out-of-range";
        /// The order was sent too long ago, or its expiry has passed.
        Expired = 6, "expired";
        /// Too many orders in a short time.
        TooMany = 7, "too-many";
        /// The table of orders in force is full.
        TableFull = 8, "table-full";
        /// No such source.
        UnknownSource = 9, "unknown-source";
        /// No source states a factor for the condition.
        UnknownCondition = 10, "unknown-condition";
        /// No such rule.
        UnknownRule = 11, "unknown-rule";
        /// The rule needs stored reports, which this deployment does not keep.
        RuleWithoutReports = 12, "rule-without-reports";
        /// No system track with this number is alive.
        UnknownTrack = 13, "unknown-track";
        /// Both parameters name the same system track.
        SameTrack = 14, "same-track";
        /// The two system tracks have different addresses.
        TwoAddresses = 15, "two-addresses";
        /// The sensor track is no member of the system track.
        UnknownSensorTrack = 16, "unknown-sensor-track";
        /// The sensor track is the only member of its system track.
        OnlyMember = 17, "only-member";
        /// Another order in force already binds the system track.
        BoundTrack = 18, "bound-track";
        /// No order in force has this number.
        UnknownOrder = 19, "unknown-order";
        /// The source is not out.
        NotOut = 20, "not-out";
        /// Fusion still publishes the previous snapshot or states.
        Busy = 21, "busy";
        /// The configuration has no `[[qnh]]` of this name.
        UnknownQnh = 22, "unknown-qnh";
        /// The tracker has no sensor that takes orders.
        TakesNoDesignations = 23, "takes-no-designations";
        /// The text is no place.
        NoPlace = 24, "no-place";
        /// The rule in force uses no such value.
        UnusedByRule = 25, "unused-by-rule";
        /// The place is too far from the origin of the system frame.
        FarPlace = 26, "far-place";
    }
}

sample! {
    /// Order of an operator to fusion. Absent parameters have the default value of their field.
    Order, size 120 {
        /// Number chosen by the sender, not 0: a repeated order with the same token has no further effect.
        token: u64,
        /// Time of sending, UTC, nanoseconds since 1970.
        sent_ns: i64,
        /// Time at which the order expires, UTC, nanoseconds since 1970; i64::MAX: never. In the event log and in
        /// states, on the engine's clock.
        ends_ns: i64 = i64::MAX,
        /// Number that the kind needs; NaN: none.
        value: f64 = f64::NAN,
        /// Number of a system track; 0: none.
        track: u32,
        /// Number of a second system track, or of a sensor track at its source; 4294967295: none.
        other_track: u32 = NO_TRACK,
        /// Number of another order; 0: none.
        number: u32,
        /// Kind of order: an `OrderKind` code.
        kind: u16,
        /// Source: its number in the configuration; 65535: none, or all.
        source: u16 = NO_SOURCE,
        /// Second source; 65535: none, or any.
        other_source: u16 = NO_SOURCE,
        /// Reserved, 0.
        reserved: [u8; 6],
        /// Word that the kind needs, UTF-8, padded with zeros.
        name: [u8; 32],
        /// Name of the operator, UTF-8, padded with zeros.
        operator_name: [u8; 32],
    }
}

/// Size of [`OrderState::text`], bytes.
pub const ORDER_TEXT_MAX: usize = 168;

sample! {
    /// State of one order. Each slice lists all orders in force and the orders that ended recently.
    OrderState, size 320 {
        /// The order.
        order: Order,
        /// Time of the latest change of state, on the engine's clock, nanoseconds since 1970.
        changed_ns: i64 = i64::MIN,
        /// Time of publication, UTC, nanoseconds since 1970.
        time_ns: i64,
        /// Sequence number at its publisher.
        sequence: u64,
        /// Number given by fusion, ascending; 0: refused before fusion.
        number: u32,
        /// State: an `OrderStatus` code.
        status: u8,
        /// Reason of a refusal: a `Refusal` code; 0: none.
        refusal: u8,
        /// 1: the state has changed since the previous slice; 0: it is repeated.
        has_changed: u8,
        /// Reserved, 0.
        reserved: u8,
        /// The state in one sentence, UTF-8, padded with zeros.
        text: [u8; 168] = [0; ORDER_TEXT_MAX],
    }
}

/// Number of words of eight bytes in an order.
pub const ORDER_WORDS: usize = size_of::<Order>() / size_of::<u64>();

impl Order {
    /// Returns an order of `kind` without parameters.
    pub fn new(kind: OrderKind) -> Self {
        Self {
            kind: kind.code(),
            ..Self::default()
        }
    }

    /// Returns the kind; `None` for a code of a later version.
    pub fn kind(&self) -> Option<OrderKind> {
        OrderKind::from_code(self.kind)
    }

    /// Returns the word that the kind needs.
    pub fn name(&self) -> &str {
        text(&self.name)
    }

    /// Returns the name of the operator.
    pub fn operator(&self) -> &str {
        text(&self.operator_name)
    }

    /// Returns this order with another word; `None` if the word exceeds 32 bytes.
    #[must_use]
    pub fn with_name(mut self, name: &str) -> Option<Self> {
        self.name = field(name)?;
        Some(self)
    }

    /// Returns this order in the name of an operator; a longer name is cut to 32 bytes.
    #[must_use]
    pub fn with_operator(mut self, operator: &str) -> Self {
        fill(&mut self.operator_name, operator);
        self
    }

    /// Returns the parameters that the order states, as words and values.
    pub fn parameters(&self) -> impl Iterator<Item = (Parameter, String)> {
        let kind = self.kind();
        let known = kind.map_or(&[][..], OrderKind::needs);
        let known = known.iter().chain(kind.map_or(&[][..], OrderKind::may));
        known.filter_map(|parameter| {
            let is_given = self.states(*parameter);
            is_given.then(|| (*parameter, self.text_of(*parameter)))
        })
    }

    /// Returns whether the order states the parameter.
    pub(crate) fn states(&self, parameter: Parameter) -> bool {
        match parameter {
            Parameter::Source | Parameter::Tracker => self.source != NO_SOURCE,
            Parameter::From => self.other_source != NO_SOURCE,
            Parameter::Track => self.track != 0,
            Parameter::With | Parameter::SensorTrack => self.other_track != NO_TRACK,
            Parameter::Value | Parameter::Sigma => !self.value.is_nan(),
            Parameter::Name | Parameter::Place => self.name[0] != 0,
            Parameter::Number => self.number != 0,
        }
    }

    fn text_of(&self, parameter: Parameter) -> String {
        match parameter {
            Parameter::Source | Parameter::Tracker => self.source.to_string(),
            Parameter::From => self.other_source.to_string(),
            Parameter::Track => self.track.to_string(),
            Parameter::With | Parameter::SensorTrack => self.other_track.to_string(),
            Parameter::Value | Parameter::Sigma => self.value.to_string(),
            Parameter::Name | Parameter::Place => self.name().to_owned(),
            Parameter::Number => self.number.to_string(),
        }
    }

    /// Returns the steps of the event log that store the order, for an effect at `time_ns` on the engine's clock.
    pub fn steps(&self, time_ns: i64) -> impl Iterator<Item = WorkStep> {
        let step = |kind: StepKind, sequence: usize, time_ns: i64| WorkStep {
            time_ns,
            sequence: sequence as u32,
            source: NO_SOURCE,
            kind: kind.code(),
            flags: 0,
        };
        let parts = self.to_words().into_iter().enumerate();
        let parts = parts.map(move |(place, word)| step(StepKind::OrderPart, place, word.cast_signed()));
        parts.chain(std::iter::once(step(StepKind::Order, ORDER_WORDS, time_ns)))
    }

    /// Returns the order of the parts that precede a step of kind [`StepKind::Order`]; `None` if parts are missing.
    pub fn of_parts(parts: &[WorkStep]) -> Option<Self> {
        let words: &[WorkStep; ORDER_WORDS] = parts.try_into().ok()?;
        let is_whole = (0..).zip(words).all(|(place, part)| part.sequence == place);
        is_whole.then(|| Self::of_words(&words.map(|part| part.time_ns.cast_unsigned())))
    }

    /// Returns the bytes of the order as words, low byte first.
    pub fn to_words(&self) -> [u64; ORDER_WORDS] {
        let mut words = [0; ORDER_WORDS];
        let (bytes, _) = Self::octets(std::slice::from_ref(self)).as_chunks();
        for (word, bytes) in words.iter_mut().zip(bytes) {
            *word = u64::from_le_bytes(*bytes);
        }
        words
    }

    /// Returns the order with these bytes.
    pub fn of_words(words: &[u64; ORDER_WORDS]) -> Self {
        let bytes = words.map(u64::to_le_bytes);
        Self::of_octets(bytes.as_flattened()).unwrap_or_default()
    }
}

/// Returns the text in a field; `None` if the text exceeds 32 bytes.
fn field(text: &str) -> Option<[u8; 32]> {
    let mut field = [0; 32];
    field.get_mut(..text.len())?.copy_from_slice(text.as_bytes());
    Some(field)
}

impl OrderState {
    /// Returns the state; `None` for a code of a later version.
    pub fn status(&self) -> Option<OrderStatus> {
        OrderStatus::from_code(self.status)
    }

    /// Returns the reason of a refusal.
    pub fn refusal(&self) -> Option<Refusal> {
        Refusal::from_code(self.refusal)
    }

    /// Returns the state of a refused order.
    pub fn refused(order: &Order, refusal: Refusal, changed_ns: i64) -> Self {
        Self {
            order: *order,
            changed_ns,
            status: OrderStatus::Refused.code(),
            refusal: refusal.code(),
            ..Self::default()
        }
    }

    /// Returns the state in one sentence.
    pub fn text(&self) -> &str {
        text(&self.text)
    }

    /// Returns this state with its sentence, cut to the available size.
    #[must_use]
    pub fn with_sentence(mut self) -> Self {
        let sentence = self.refusal().map_or_else(
            || self.status().map_or("", OrderStatus::word).replace("-", " "),
            |refusal| refusal.sentence(&self.order),
        );
        fill(&mut self.text, &sentence);
        self
    }
}

impl Refusal {
    /// Returns the reason in one sentence, with the remedy.
    pub fn sentence(self, order: &Order) -> String {
        let kind = order.kind();
        let word = kind.map_or("", OrderKind::word);
        let list = |parameters: &[Parameter]| {
            let words: Vec<&str> = parameters.iter().map(|each| each.word()).collect();
            words.join(", ")
        };
        match self {
            Self::UnknownKind => format!("there is no order of kind {}", order.kind),
            Self::Malformed => {
                "the order is malformed: a text is not UTF-8, its token is 0, or its end is no time".to_owned()
            }
            Self::MissingParameter => format!("{word} needs {}", list(kind.map_or(&[], OrderKind::needs))),
            Self::ForeignParameter => {
                let kind = kind.map_or((&[][..], &[][..]), |kind| (kind.needs(), kind.may()));
                format!("{word} takes {} and nothing else", list(&[kind.0, kind.1].concat()))
            }
            Self::OutOfRange => {
                let (low, high) = kind.map_or((0.0, 0.0), OrderKind::range);
                format!("{word} takes a value from {low} to {high}, not {}", order.value)
            }
            Self::Expired => "the order was sent too long ago, or its end has passed; send it again".to_owned(),
            Self::TooMany => "too many orders in a short time; send it again in some seconds".to_owned(),
            Self::TableFull => "so many orders are in force that the table is full; cancel one of them".to_owned(),
            Self::UnknownSource => "there is no such source; `koseki status` lists the sources".to_owned(),
            Self::UnknownCondition => format!(
                "no source has an accuracy for the condition \"{}\"; name one of the configuration's, or \"normal\"",
                order.name()
            ),
            Self::UnknownQnh => format!(
                "there is no [[qnh]] with the name \"{}\" in the configuration",
                order.name()
            ),
            Self::UnknownRule => format!(
                "there is no rule \"{}\"; `koseki fuse --help` lists the rules",
                order.name()
            ),
            Self::RuleWithoutReports => format!(
                "the rule \"{}\" needs stored reports; set fusion.rule.accuracy_values = true in the configuration",
                order.name()
            ),
            Self::UnknownTrack => "there is no such system track, or it has ended".to_owned(),
            Self::SameTrack => format!("track {} cannot be joined with itself", order.track),
            Self::TwoAddresses => format!(
                "tracks {} and {} have different addresses",
                order.track, order.other_track
            ),
            Self::UnknownSensorTrack => format!(
                "sensor track {} of that source is no part of system track {}",
                order.other_track, order.track
            ),
            Self::OnlyMember => format!("system track {} has no other sensor track", order.track),
            Self::BoundTrack => "another order in force binds the track; cancel that order first".to_owned(),
            Self::UnknownOrder => format!("no order in force has the number {}", order.number),
            Self::NotOut => "the source is not out".to_owned(),
            Self::TakesNoDesignations => {
                "the source is no tracker that takes designations by order; give its [[tracker]] \
                 a sensor with designates = true and [tracker.sensor.orders]"
                    .to_owned()
            }
            Self::NoPlace => format!("\"{}\" is no place; {}", order.name(), DesignatedPlace::FORM),
            Self::FarPlace => format!(
                "{} is more than {:.0} km from the origin of the system frame; check both degrees, and their order",
                order.name(),
                REACH_M / 1e3
            ),
            Self::UnusedByRule => format!(
                "the rule in force chooses no best source, so {word} would have no effect; it serves the rule \
                 \"best-source\" (order: rule name=best-source)"
            ),
            Self::Busy => "fusion still publishes the previous snapshot; send it again in a second".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::check_order;

    fn sound() -> Order {
        Order {
            token: 7,
            value: 0.3,
            source: 1,
            ..Order::new(OrderKind::Eta)
        }
    }

    #[test]
    fn an_order_is_the_same_after_its_way_through_the_event_log() {
        let order = sound().with_operator("anna").with_name("rain").unwrap();
        let steps: Vec<WorkStep> = order.steps(99).collect();
        let (last, parts) = steps.split_last().unwrap();
        assert_eq!((last.kind, last.time_ns), (StepKind::Order.code(), 99));
        let found = Order::of_parts(parts).unwrap();
        assert_eq!(
            Order::octets(std::slice::from_ref(&found)),
            Order::octets(std::slice::from_ref(&order))
        );
        assert!(Order::of_parts(&parts[1..]).is_none() && Order::of_parts(&steps).is_none());
    }

    #[test]
    fn what_an_order_states_of_itself_is_checked() {
        assert_eq!(check_order(&sound()), Ok(OrderKind::Eta));
        let wrong = |change: fn(&mut Order)| {
            let mut order = sound();
            change(&mut order);
            let refusal = check_order(&order).unwrap_err();
            assert!(!refusal.sentence(&order).is_empty());
            refusal
        };
        assert_eq!(wrong(|order| order.kind = 999), Refusal::UnknownKind);
        assert_eq!(wrong(|order| order.token = 0), Refusal::Malformed);
        assert_eq!(wrong(|order| order.operator_name[0] = 0xFF), Refusal::Malformed);
        assert_eq!(wrong(|order| order.name[5] = b'x'), Refusal::Malformed);
        assert_eq!(wrong(|order| order.ends_ns = -1), Refusal::Malformed);
        assert_eq!(wrong(|order| order.value = f64::NAN), Refusal::MissingParameter);
        assert_eq!(wrong(|order| order.track = 3), Refusal::ForeignParameter);
        assert_eq!(wrong(|order| order.value = 1.01), Refusal::OutOfRange);
        assert_eq!(wrong(|order| order.value = -0.1), Refusal::OutOfRange);
    }

    #[test]
    fn every_kind_has_a_word_of_its_own_and_accepts_what_it_needs() {
        for kind in OrderKind::ALL.iter().copied() {
            assert_eq!(OrderKind::from_word(kind.word()), Some(kind));
            assert_eq!(OrderKind::from_code(kind.code()), Some(kind));
            let mut order = Order {
                token: 1,
                ..Order::new(kind)
            };
            for parameter in kind.needs() {
                assert_eq!(check_order(&order), Err(Refusal::MissingParameter));
                match parameter {
                    Parameter::Source | Parameter::Tracker => order.source = 0,
                    Parameter::From => order.other_source = 0,
                    Parameter::Track => order.track = 1,
                    Parameter::With | Parameter::SensorTrack => order.other_track = 0,
                    Parameter::Value | Parameter::Sigma => order.value = kind.range().1,
                    Parameter::Name => order.name[0] = b'x',
                    Parameter::Place => order = order.with_name("1,2").unwrap(),
                    Parameter::Number => order.number = 1,
                }
            }
            assert_eq!(check_order(&order), Ok(kind));
            assert_eq!(order.parameters().count(), kind.needs().len());
        }
    }

    proptest! {
        #[test]
        fn any_bytes_are_accepted_or_refused(bytes in proptest::collection::vec(any::<u8>(), size_of::<Order>()), kind in 0u16..20) {
            let mut order = Order::of_octets(&bytes).unwrap();
            order.kind = kind;
            if let Err(refusal) = check_order(&order) {
                let _ = OrderState::refused(&order, refusal, 0).with_sentence().text();
            }
            let _ = (order.name(), order.operator(), order.parameters().count());
        }
    }
}

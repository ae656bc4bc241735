//! Live work, done again from its log.

use messages::layout::Sample as _;
use messages::{
    Counter, Covariance, FusionRule, Order, OrderKind, OrderState, SensorTrack, StepKind, SystemTrack, TrackState,
    WorkStep, sensor_track_bits,
};
use proptest::prelude::*;
use test_support::S;

use crate::continuity::event_log::{Event, EventLog, EventReader, UnreadableStep};
use crate::settings::{RuleName, Settings};
use crate::testing::test_settings;
use crate::{Driver, Engine, ReportNumber, Sink};

const SOURCES: u16 = 3;
const PUBLISHER: u64 = 1_700_000_000;

impl EventLog for Vec<WorkStep> {
    fn write(&mut self, step: &WorkStep) {
        self.push(*step);
    }
}

/// All that a driver hands out.
#[derive(Debug, Default)]
struct Published {
    states: Vec<SystemTrack>,
    orders: Vec<OrderState>,
}

impl Sink for Published {
    fn track(&mut self, track: &SystemTrack) {
        self.states.push(*track);
    }

    fn order(&mut self, state: &OrderState) {
        self.orders.push(*state);
    }
}

fn settings() -> Settings {
    let mut settings = test_settings(usize::from(SOURCES));
    settings.rule.name = RuleName(FusionRule::Auto);
    settings.registration.enabled = true;
    settings.association.scan_wait = 0.4;
    for source in &mut settings.sources {
        source.learns_period = true;
    }
    settings
}

/// Live action, at random.
#[derive(Clone, Debug)]
enum Action {
    Report {
        source: u16,
        target: u32,
        late_ms: i64,
        is_wild: bool,
    },
    Quarantine {
        source: u16,
    },
    Pass {
        ms: i64,
    },
    Restart {
        source: u16,
    },
    Order(Order),
    HostOffset {
        ms: i64,
    },
    SourceClock {
        source: u16,
        offset_ms: Option<i32>,
    },
    Numbers {
        first: u32,
    },
    Snapshot,
}

fn action() -> impl Strategy<Value = Action> {
    let source = 0..SOURCES;
    let report = (source.clone(), 0..4u32, -50..700i64, prop::bool::weighted(0.05)).prop_map(
        |(source, target, late_ms, is_wild)| Action::Report {
            source,
            target,
            late_ms,
            is_wild,
        },
    );
    let order = (1..1000u64, source.clone(), 0..6u32, 0..4u32).prop_map(|(token, source, track, kind)| {
        let kinds = [OrderKind::Out, OrderKind::Drop, OrderKind::In, OrderKind::Reset];
        let kind = kinds[kind as usize];
        let order = Order {
            token,
            ..Order::new(kind)
        };
        Action::Order(match kind {
            OrderKind::Drop => Order { track, ..order },
            _ => Order { source, ..order },
        })
    });
    prop_oneof![
        60 => report,
        1 => source.clone().prop_map(|source| Action::Quarantine { source }),
        10 => (1..3000i64).prop_map(|ms| Action::Pass { ms }),
        1 => source.clone().prop_map(|source| Action::Restart { source }),
        2 => order,
        1 => (-2000..2000i64).prop_map(|ms| Action::HostOffset { ms }),
        1 => (source, prop::option::of(-2000..2000i32))
            .prop_map(|(source, offset_ms)| Action::SourceClock { source, offset_ms }),
        1 => (1000..2000u32).prop_map(|first| Action::Numbers { first }),
        1 => Just(Action::Snapshot),
    ]
}

/// Live driver, and the reports that it has received.
struct Live {
    driver: Driver<Vec<WorkStep>>,
    published: Published,
    now_ns: i64,
    /// Epoch of the publisher, and number of the next report, of each source.
    numbers: [(u64, u64); SOURCES as usize],
    sent: Vec<(u16, ReportNumber, SensorTrack)>,
}

impl Live {
    fn new() -> Self {
        let engine = Engine::new(settings()).unwrap();
        Self {
            driver: Driver::begin(engine, Vec::new(), 7),
            published: Published::default(),
            now_ns: 1000 * S,
            numbers: [(PUBLISHER, 0); SOURCES as usize],
            sent: Vec::new(),
        }
    }

    fn next_report(&mut self, source: u16, target: u32, late_ms: i64, is_wild: bool) -> (ReportNumber, SensorTrack) {
        let time_ns = self.now_ns - late_ms * S / 1000;
        let seconds = time_ns as f64 / S as f64;
        let (publisher, next) = &mut self.numbers[usize::from(source)];
        let number = ReportNumber {
            publisher: *publisher,
            sequence: *next,
            is_wild,
        };
        *next += 1;
        let report = SensorTrack {
            time_of_measurement_ns: time_ns,
            source,
            track_number: target,
            valid: sensor_track_bits::VELOCITY,
            position_m: [
                3000.0 * f64::from(target) + 3.0 * f64::from(source),
                40.0 * seconds,
                0.0,
            ],
            velocity_mps: [0.0, 40.0, 0.0],
            covariance: Covariance::diagonal([10.0, 10.0, 100.0], [2.0; 3]),
            state: TrackState::Confirmed as u8,
            ..SensorTrack::default()
        };
        self.sent.push((source, number, report));
        (number, report)
    }

    fn act(&mut self, action: &Action) {
        self.now_ns += S / 20;
        let out = &mut self.published;
        match *action {
            Action::Report {
                source,
                target,
                late_ms,
                is_wild,
            } => {
                let (number, mut report) = self.next_report(source, target, late_ms, is_wild);
                self.driver
                    .report(&mut report, number, self.now_ns, &mut self.published);
            }
            Action::Quarantine { source } => {
                let (number, mut report) = self.next_report(source, 1, 0, false);
                self.driver.quarantine(&mut report, number);
            }
            Action::Pass { ms } => {
                self.now_ns += ms * S / 1000;
                self.driver.advance(self.now_ns, out);
            }
            Action::Restart { source } => {
                let (publisher, next) = self.numbers[usize::from(source)];
                self.numbers[usize::from(source)] = (publisher + 1, next % 2);
            }
            Action::Order(ref order) => {
                let passed_ns = self.driver.engine().now_ns();
                // Some are refused, and are then not in the log.
                let _ = self.driver.order(order, passed_ns, out);
            }
            Action::HostOffset { ms } => self.driver.set_host_offset(ms * S / 1000),
            Action::SourceClock { source, offset_ms } => self.driver.set_source_clock(source, offset_ms),
            Action::Numbers { first } => self.driver.start_numbers_at(first),
            Action::Snapshot => {
                self.driver.snapshot(self.now_ns);
            }
        }
    }
}

/// Drives another engine with the events of a log.
fn again(live: &Live) -> (Driver<()>, Published) {
    let mut driver = Driver::begin(Engine::new(settings()).unwrap(), (), 7);
    let mut published = Published::default();
    let out = &mut published;
    let mut reader = EventReader::default();
    for step in live.driver.log() {
        let Some(event) = reader.read(step).unwrap() else {
            continue;
        };
        match event {
            Event::Report {
                source,
                publisher,
                sequence,
                is_wild,
                passed_ns,
            } => {
                let number = ReportNumber {
                    publisher,
                    sequence: sequence.into(),
                    is_wild,
                };
                let wanted = |(of, sent, _): &&(u16, ReportNumber, SensorTrack)| *of == source && *sent == number;
                let mut report = live.sent.iter().find(wanted).unwrap().2;
                driver.report(&mut report, number, passed_ns, out);
            }
            Event::Time { passed_ns } => driver.advance(passed_ns, out),
            Event::Order { order, passed_ns } => driver.order(&order, passed_ns, out).unwrap(),
            Event::Numbers { first } => driver.start_numbers_at(first),
            Event::HostOffset { offset_ns } => driver.set_host_offset(offset_ns),
            Event::SourceClock { source, offset_ms, .. } => driver.set_source_clock(source, offset_ms),
            Event::Begin { epoch } => assert_eq!(epoch, 7),
            Event::Quarantine { .. } | Event::Snapshot { .. } => {}
            Event::Condition { .. } | Event::Restored => panic!("{event:?}"),
        }
    }
    (driver, published)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn a_driver_on_the_events_of_a_log_gives_the_same_states_to_the_bit(
        actions in prop::collection::vec(action(), 1..400),
    ) {
        let mut live = Live::new();
        actions.iter().for_each(|action| live.act(action));
        let (mut driver, published) = again(&live);
        prop_assert!(OrderState::octets(&published.orders) == OrderState::octets(&live.published.orders));
        prop_assert!(SystemTrack::octets(&published.states) == SystemTrack::octets(&live.published.states));
        // Time that passes without a state is in no event.
        driver.advance(live.now_ns, &mut |_: &SystemTrack| ());
        live.driver.advance(live.now_ns, &mut |_: &SystemTrack| ());
        prop_assert!(driver.engine().image() == live.driver.engine().image());
    }
}

fn step(kind: StepKind, source: u16, sequence: u32, time_ns: i64) -> WorkStep {
    WorkStep {
        time_ns,
        sequence,
        source,
        kind: kind as u8,
        flags: 0,
    }
}

#[test]
fn a_log_names_a_publisher_once_and_again_after_a_snapshot() {
    let mut live = Live::new();
    let report = Action::Report {
        source: 1,
        target: 0,
        late_ms: 0,
        is_wild: false,
    };
    let quarantine = Action::Quarantine { source: 1 };
    for action in [&report, &quarantine, &Action::Snapshot, &report] {
        live.act(action);
    }
    let kinds: Vec<_> = live.driver.log().iter().map(|step| step.kind).collect();
    let report = [StepKind::Publisher, StepKind::Report];
    let snapshot = [StepKind::Quarantine, StepKind::Image];
    let expected = [&[StepKind::Begin][..], &report, &snapshot, &report].concat();
    assert_eq!(live.driver.engine().counts().get(Counter::Quarantined), 1);
    assert_eq!(kinds, expected.iter().map(|kind| *kind as u8).collect::<Vec<_>>());
}

#[test]
fn an_order_without_all_its_parts_and_a_kind_of_a_later_version_are_unreadable() {
    let order = Order {
        token: 5,
        source: 2,
        ..Order::new(OrderKind::Out)
    };
    let steps: Vec<_> = order.steps(9).collect();
    let mut reader = EventReader::default();
    // A value of an order may be NaN: the words are compared.
    let mut read = |steps: &[WorkStep]| {
        let events: Vec<_> = steps.iter().map(|step| reader.read(step)).collect();
        match events[events.len() - 1] {
            Ok(Some(Event::Order { order, passed_ns: 9 })) => Ok(order.to_words()),
            _ => Err(UnreadableStep),
        }
    };
    assert_eq!(read(&steps), Ok(order.to_words()));
    assert_eq!(read(&steps[1..]), Err(UnreadableStep));
    assert_eq!(read(&steps), Ok(order.to_words()));
    let later = WorkStep { kind: 200, ..steps[0] };
    assert_eq!(read(&[later]), Err(UnreadableStep));
}

#[test]
fn events_of_former_builds_and_unknown_clocks_are_read() {
    let mut reader = EventReader::default();
    let condition = reader.read(&step(StepKind::Condition, messages::NO_SOURCE, 3, 8));
    assert_eq!(
        condition,
        Ok(Some(Event::Condition {
            condition: 3,
            passed_ns: 8
        }))
    );
    for offset_ms in [None, Some(-250)] {
        let written = offset_ms.unwrap_or(WorkStep::CLOCK_UNKNOWN).cast_unsigned();
        let clock = reader.read(&step(StepKind::SourceClock, 1, written, 8));
        let event = Event::SourceClock {
            source: 1,
            offset_ms,
            passed_ns: 8,
        };
        assert_eq!(clock, Ok(Some(event)));
    }
}

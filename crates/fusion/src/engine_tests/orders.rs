//! Orders of operators, and their effects on system tracks.

use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use frames::Geodetic;
use messages::layout::Sample as _;
use messages::{Decision, DecisionKind, FusionRule, Order, OrderKind, OrderState, OrderStatus, Refusal};

use super::*;
use crate::Sink;
use crate::continuity::checkpoint::{CheckpointClock, Memory, Snapshot};
use crate::settings::{RegionalQnh, RuleName};

/// Everything that the engine hands out.
#[derive(Debug, Default)]
struct Listener {
    tracks: Vec<SystemTrack>,
    orders: Vec<OrderState>,
    decisions: Vec<Decision>,
}

impl Sink for Listener {
    fn track(&mut self, track: &SystemTrack) {
        self.tracks.push(*track);
    }

    fn order(&mut self, state: &OrderState) {
        self.orders.push(*state);
    }

    fn decision(&mut self, decision: &Decision) {
        self.decisions.push(*decision);
    }
}

struct Desk {
    engine: Engine,
    heard: Listener,
    token: u64,
}

impl Desk {
    fn new(settings: Settings) -> Self {
        Self {
            engine: Engine::new(settings).unwrap(),
            heard: Listener::default(),
            token: 0,
        }
    }

    /// One scan of two sources that see targets at these places; the target at place `n` has number `n + 1` at both.
    fn scan(&mut self, time_s: f64, places: &[[f64; 2]]) {
        for source in 0..2 {
            for (number, place) in (1..).zip(places) {
                let time_s = time_s + 0.3 * f64::from(source);
                let aside = [place[0], place[1] + 4.0 * f64::from(source)];
                self.engine
                    .take(&report(source, number, time_s, aside, [50.0, 0.0]), &mut self.heard);
            }
        }
    }

    fn scans(&mut self, seconds: std::ops::Range<u32>, places: &[[f64; 2]]) {
        for second in seconds {
            self.scan(f64::from(second), places);
        }
    }

    fn order(&mut self, kind: OrderKind, change: impl FnOnce(&mut Order)) -> Result<OrderState, Refusal> {
        self.token += 1;
        let mut order = Order {
            token: self.token,
            ..Order::new(kind)
        };
        change(&mut order);
        self.engine.obey(&order, &mut self.heard)?;
        Ok(self.engine.order_of_token(order.token).unwrap())
    }

    fn named(&mut self, kind: OrderKind, name: &str) -> Result<OrderState, Refusal> {
        let name = Order::default().with_name(name).unwrap().name;
        self.order(kind, |order| order.name = name)
    }

    /// Latest state of each system track that lives, by number.
    fn live(&self) -> Vec<SystemTrack> {
        let mut latest: Vec<SystemTrack> = Vec::new();
        for track in &self.heard.tracks {
            latest.retain(|other| other.track_number != track.track_number);
            latest.push(*track);
        }
        latest.retain(|track| track.state != TrackState::Terminated as u8);
        latest.sort_by_key(|track| track.track_number);
        latest
    }

    fn numbers(&self) -> Vec<u32> {
        self.live().iter().map(|track| track.track_number).collect()
    }

    fn statuses(&self) -> Vec<OrderStatus> {
        self.heard.orders.iter().filter_map(OrderState::status).collect()
    }

    fn decided(&self, kind: DecisionKind) -> usize {
        let codes = self.heard.decisions.iter();
        codes.filter(|decision| decision.kind == kind.code()).count()
    }
}

fn weights(track: &SystemTrack) -> Vec<f64> {
    let weights = track.contributions().iter().map(|part| part.weight);
    weights.map(|weight| (weight * 1e6).round() / 1e6).collect()
}

#[test]
fn eta_entered_while_running_moves_the_weights_of_the_worked_check() {
    let mut desk = Desk::new(test_settings(2));
    desk.scans(0..6, &[[0.0; 2]]);
    let chosen = desk.heard.tracks.last().unwrap().selected_source;
    let other = 1 - chosen;
    desk.order(OrderKind::Eta, |order| order.value = 0.3).unwrap();
    // A coefficient k that is large makes the other source the best one.
    let large = desk.order(OrderKind::Adjustment, |order| {
        (order.source, order.value) = (chosen, 1e6);
    });
    let before = desk.heard.tracks.len();
    desk.scans(6..8, &[[0.0; 2]]);
    let passed: Vec<Vec<f64>> = desk.heard.tracks[before..before + 2].iter().map(weights).collect();
    let place = |weights: &[f64]| (weights[usize::from(chosen)], weights[usize::from(other)]);
    assert_eq!(place(&passed[0]), (0.7, 0.3), "eta_0 = 0.3 for one refresh (TI-13)");
    assert_eq!(place(&passed[1]), (0.0, 1.0));
    // Cancelled, the configured value holds again: the former source takes over at once, without a ramp.
    for number in [1, large.unwrap().number] {
        desk.order(OrderKind::Cancel, |order| order.number = number).unwrap();
    }
    let before = desk.heard.tracks.len();
    desk.order(OrderKind::Adjustment, |order| {
        (order.source, order.value) = (other, 1e6);
    })
    .unwrap();
    desk.scans(8..9, &[[0.0; 2]]);
    assert_eq!(place(&weights(&desk.heard.tracks[before])), (1.0, 0.0));
}

#[test]
fn of_two_orders_for_one_hand_over_the_newest_holds() {
    let mut desk = Desk::new(test_settings(2));
    desk.scans(0..6, &[[0.0; 2]]);
    let chosen = desk.heard.tracks.last().unwrap().selected_source;
    desk.order(OrderKind::Eta, |order| order.value = 0.3).unwrap();
    desk.order(OrderKind::Eta, |order| {
        (order.value, order.other_source) = (0.6, chosen)
    })
    .unwrap();
    desk.order(OrderKind::Adjustment, |order| {
        (order.source, order.value) = (chosen, 1e6)
    })
    .unwrap();
    let before = desk.heard.tracks.len();
    desk.scans(6..7, &[[0.0; 2]]);
    assert_eq!(weights(&desk.heard.tracks[before])[usize::from(1 - chosen)], 0.6);
}

#[test]
fn only_a_tracker_that_takes_designations_is_ordered_to_follow_a_target() {
    let mut settings = test_settings(2);
    settings.sources[1].designates_round = Some(Geodetic::from_degrees(59.0, 10.0, 0.0).unwrap());
    let mut desk = Desk::new(settings);
    let mut order = |source: u16, place: &str| {
        let named = Order::default().with_name(place).unwrap();
        desk.order(OrderKind::Designate, |order| {
            (order.source, order.name, order.value) = (source, named.name, 300.0);
        })
    };
    assert_eq!(order(0, "0m,0m").map(|_| ()), Err(Refusal::TakesNoDesignations));
    assert_eq!(order(2, "0m,0m").map(|_| ()), Err(Refusal::UnknownSource));
    assert_eq!(order(1, "port").map(|_| ()), Err(Refusal::NoPlace));
    // Two degrees, the other way round, and left at zero: the last lie 6,600 km away, and at the antipodes.
    for far in ["10.6,59.4", "0,0", "-59,-170"] {
        assert_eq!(order(1, far).map(|_| ()), Err(Refusal::FarPlace), "{far}");
    }
    assert_eq!(order(1, "59.4,10.6").unwrap().status(), Some(OrderStatus::Done));
}

#[test]
fn an_order_sets_the_pressure_of_a_region_until_it_is_cancelled() {
    let mut settings = test_settings(2);
    let regional = RegionalQnh::new("port".to_owned(), None, 60, vec![(i64::MIN, 1013.25)]);
    settings.qnh.push(regional);
    let mut desk = Desk::new(settings);
    let order = |desk: &mut Desk, name: &str, hpa: f64| {
        let name = Order::default().with_name(name).unwrap().name;
        desk.order(OrderKind::Qnh, |order| (order.name, order.value) = (name, hpa))
    };
    let shown = |desk: &mut Desk, second: f64| {
        let mut stated = report(0, 1, second, [0.0, 0.0], [0.0, 0.0]);
        stated.valid |= messages::sensor_track_bits::LEVEL;
        stated.level = 160;
        desk.engine.take(&stated, &mut desk.heard);
        let state = desk.heard.tracks.last().unwrap();
        (state.qnh_hpa, (f64::from(state.altitude_m) / 0.3048).round())
    };
    assert_eq!(order(&mut desk, "prot", 1003.25).map(|_| ()), Err(Refusal::UnknownQnh));
    assert_eq!(shown(&mut desk, 1.0), (1013.25, 4_000.0));
    order(&mut desk, "port", 1003.25).unwrap();
    assert_eq!(shown(&mut desk, 2.0), (1003.25, 3_726.0));
    let newer = order(&mut desk, "port", 1023.25).unwrap();
    assert_eq!(
        shown(&mut desk, 3.0),
        (1023.25, 4_272.0),
        "the newer order replaces the older one"
    );
    desk.order(OrderKind::Cancel, |order| order.number = newer.number)
        .unwrap();
    assert_eq!(shown(&mut desk, 4.0), (1013.25, 4_000.0));
}

#[test]
fn a_condition_holds_until_it_is_normal_again() {
    let mut settings = test_settings(2);
    settings.sources[0].accuracy.conditions = vec![("rain".to_owned(), 1e3)];
    let mut desk = Desk::new(settings);
    // A target that weaves: the residuals differ from 0.
    let weave = |desk: &mut Desk, seconds: std::ops::Range<u32>| {
        for second in seconds {
            desk.scan(f64::from(second), &[[0.0, 9.0 * f64::from(second % 3)]]);
        }
    };
    weave(&mut desk, 0..4);
    assert_eq!(desk.named(OrderKind::Condition, "ran"), Err(Refusal::UnknownCondition));
    let accuracy = |desk: &Desk| desk.heard.tracks.last().unwrap().contributions()[0].accuracy;
    let before = accuracy(&desk);
    desk.named(OrderKind::Condition, "rain").unwrap();
    weave(&mut desk, 4..6);
    assert!(accuracy(&desk) > 100.0 * before);
    let normal = desk.named(OrderKind::Condition, "normal").unwrap();
    assert_eq!(normal.status(), Some(OrderStatus::Done));
    weave(&mut desk, 6..8);
    assert!(accuracy(&desk) < 10.0 * before && desk.engine.orders_in_force().is_empty());
    assert!(desk.statuses().contains(&OrderStatus::Replaced));
}

#[test]
fn a_source_that_is_out_contributes_nothing_until_it_is_in() {
    let mut desk = Desk::new(test_settings(2));
    desk.scans(0..6, &[[0.0; 2]]);
    desk.order(OrderKind::Out, |order| order.source = 1).unwrap();
    desk.scans(6..10, &[[0.0; 2]]);
    assert_eq!(sources_of(desk.heard.tracks.last().unwrap()), [0]);
    assert_eq!(desk.engine.counts().get(Counter::RejectedByOrder), 4);
    assert_eq!(
        desk.order(OrderKind::In, |order| order.source = 0),
        Err(Refusal::NotOut)
    );
    desk.order(OrderKind::In, |order| order.source = 1).unwrap();
    desk.scans(10..14, &[[0.0; 2]]);
    assert_eq!(sources_of(desk.heard.tracks.last().unwrap()), [0, 1]);
    assert_eq!(desk.numbers(), [1], "the target kept its number");
}

#[test]
fn an_order_expires_at_its_time() {
    let mut desk = Desk::new(test_settings(2));
    desk.scans(0..4, &[[0.0; 2]]);
    desk.order(OrderKind::Out, |order| {
        (order.source, order.ends_ns) = (1, 6 * S + S / 2)
    })
    .unwrap();
    let late = desk.order(OrderKind::Out, |order| (order.source, order.ends_ns) = (0, 2 * S));
    assert_eq!(late, Err(Refusal::Expired));
    desk.scans(4..9, &[[0.0; 2]]);
    assert_eq!(desk.statuses(), [OrderStatus::InForce, OrderStatus::Expired]);
    assert_eq!(desk.heard.orders[1].changed_ns, 6 * S + S / 2);
    assert_eq!(desk.engine.counts().get(Counter::RejectedByOrder), 3, "seconds 4, 5, 6");
}

#[test]
fn a_dropped_track_comes_back_only_after_the_order() {
    let mut desk = Desk::new(test_settings(2));
    let places = [[0.0, 0.0], [0.0, 9000.0]];
    desk.scans(0..5, &places);
    let (kept, dropped) = (desk.numbers()[0], desk.numbers()[1]);
    let order = desk.order(OrderKind::Drop, |order| order.track = dropped).unwrap();
    assert_eq!(desk.numbers(), [kept]);
    let again = desk.order(OrderKind::Drop, |order| order.track = dropped);
    assert_eq!(again, Err(Refusal::UnknownTrack));
    desk.scans(5..40, &places);
    assert_eq!(desk.numbers(), [kept], "its sensor tracks start no other");
    desk.order(OrderKind::Cancel, |cancel| cancel.number = order.number)
        .unwrap();
    desk.scans(40..45, &places);
    let numbers = desk.numbers();
    assert_eq!((numbers.len(), numbers[0]), (2, kept));
    assert!(numbers[1] > dropped, "no number is given twice");
    assert_eq!(desk.decided(DecisionKind::Ordered), 1);
}

#[test]
fn a_drop_ends_with_its_sensor_tracks() {
    let mut desk = Desk::new(test_settings(2));
    let places = [[0.0, 0.0], [0.0, 9000.0]];
    desk.scans(0..5, &places);
    let dropped = desk.numbers()[1];
    desk.order(OrderKind::Drop, |order| order.track = dropped).unwrap();
    desk.scans(5..100, &places[..1]);
    assert_eq!(desk.statuses().last(), Some(&OrderStatus::Ended));
}

/// Two targets on parallel paths, so far apart that no gate joins them.
const SIDE_BY_SIDE: [[f64; 2]; 2] = [[0.0, 0.0], [0.0, 60.0]];

/// Sources of which the first sees the first target only, and the second the second.
fn one_each(desk: &mut Desk, seconds: std::ops::Range<u32>, places: &[[f64; 2]; 2]) {
    for second in seconds {
        for (source, place) in (0..).zip(places) {
            let time_s = f64::from(second) + 0.3 * f64::from(source);
            desk.engine
                .take(&report(source, 1, time_s, *place, [50.0, 0.0]), &mut desk.heard);
        }
    }
}

#[test]
fn joined_tracks_stay_together_until_they_are_too_far_apart() {
    let mut desk = Desk::new(test_settings(2));
    one_each(&mut desk, 0..6, &[[0.0, 0.0], [0.0, 60.0]]);
    let numbers = desk.numbers();
    assert_eq!(numbers.len(), 2, "{SIDE_BY_SIDE:?} are two");
    let join = |order: &mut Order| (order.track, order.other_track) = (numbers[1], numbers[0]);
    desk.order(OrderKind::Join, join).unwrap();
    assert_eq!(desk.numbers(), [numbers[0]], "the older number remains");
    // 60 m: 4.2 standard deviations of two positions of 10 m each.
    one_each(&mut desk, 6..40, &[[0.0, 0.0], [0.0, 60.0]]);
    assert_eq!(desk.numbers(), [numbers[0]]);
    assert_eq!(sources_of(desk.heard.tracks.last().unwrap()), [0, 1]);
    one_each(&mut desk, 40..60, &[[0.0, 0.0], [0.0, 400.0]]);
    assert_eq!(desk.statuses().last(), Some(&OrderStatus::Ended));
    let ended = desk.heard.decisions.iter();
    let ended: Vec<&Decision> = ended
        .filter(|decision| decision.kind == DecisionKind::OrderEnded.code())
        .collect();
    assert!(
        ended.len() == 1 && ended[0].value > 5.0 && ended[0].limit == 5.0,
        "{ended:?}"
    );
    let apart_s = ended[0].time_ns as f64 / S as f64;
    assert!((49.0..53.0).contains(&apart_s), "10 s after 40 s: {apart_s}");
    one_each(&mut desk, 60..70, &[[0.0, 0.0], [0.0, 400.0]]);
    assert_eq!(
        desk.numbers().len(),
        2,
        "free again, the second target has its own track"
    );
}

#[test]
fn a_join_of_two_targets_that_both_sources_see_ends_too() {
    let mut desk = Desk::new(test_settings(2));
    let places = [[0.0, 0.0], [0.0, 900.0]];
    desk.scans(0..6, &places);
    let numbers = desk.numbers();
    desk.order(OrderKind::Join, |order| {
        (order.track, order.other_track) = (numbers[0], numbers[1]);
    })
    .unwrap();
    desk.scans(6..20, &places);
    assert_eq!(desk.statuses().last(), Some(&OrderStatus::Ended));
    desk.scans(20..40, &places);
    assert_eq!(desk.numbers().len(), 2);
}

#[test]
fn parts_of_a_split_track_stay_apart_until_the_order_is_cancelled() {
    let mut desk = Desk::new(test_settings(2));
    desk.scans(0..6, &[[0.0; 2]]);
    let number = desk.numbers()[0];
    let split = |order: &mut Order| (order.track, order.source, order.other_track) = (number, 1, 1);
    let wrong = desk.order(OrderKind::Split, |order| {
        split(order);
        order.other_track = 77;
    });
    assert_eq!(wrong, Err(Refusal::UnknownSensorTrack));
    let order = desk.order(OrderKind::Split, split).unwrap();
    let live = desk.live();
    assert_eq!(live.len(), 2);
    assert_eq!(live[1].state, TrackState::Confirmed as u8, "shown at once");
    desk.scans(6..40, &[[0.0; 2]]);
    assert_eq!(desk.numbers().len(), 2);
    let more = desk.order(OrderKind::Renumber, |order| order.track = number);
    assert_eq!(more, Err(Refusal::BoundTrack));
    desk.order(OrderKind::Cancel, |cancel| cancel.number = order.number)
        .unwrap();
    desk.scans(40..60, &[[0.0; 2]]);
    assert_eq!(desk.numbers(), [number], "one target again");
}

#[test]
fn split_parts_with_one_address_stay_apart() {
    let mut desk = Desk::new(test_settings(2));
    let scan = |desk: &mut Desk, second: u32| {
        for source in 0..2 {
            let time_s = f64::from(second) + 0.3 * f64::from(source);
            let report = report(source, 1, time_s, [0.0; 2], [50.0, 0.0]);
            desk.engine.take(&with_address(report, 0xABC), &mut desk.heard);
        }
    };
    (0..6).for_each(|second| scan(&mut desk, second));
    let number = desk.numbers()[0];
    desk.order(OrderKind::Split, |order| {
        (order.track, order.source, order.other_track) = (number, 1, 1);
    })
    .unwrap();
    (6..30).for_each(|second| scan(&mut desk, second));
    assert_eq!(desk.numbers().len(), 2);
}

/// An order that would change nothing is refused, and not kept as if it were in force.
#[test]
fn first_weights_and_coefficients_are_ordered_only_where_a_rule_uses_them() {
    let mut settings = test_settings(2);
    settings.rule.accuracy_values = Some(true);
    for rule in FusionRule::ALL {
        settings.rule.name = RuleName(rule);
        let mut desk = Desk::new(settings.clone());
        desk.scans(0..6, &[[0.0; 2]]);
        let expected = match rule {
            FusionRule::BestSource => Ok(()),
            _ => Err(Refusal::UnusedByRule),
        };
        let eta = |order: &mut Order| order.value = 0.3;
        let adjustment = |order: &mut Order| (order.source, order.value) = (0, 1e9);
        assert_eq!(desk.order(OrderKind::Eta, eta).map(|_| ()), expected, "{rule:?}");
        assert_eq!(
            desk.order(OrderKind::Adjustment, adjustment).map(|_| ()),
            expected,
            "{rule:?}"
        );
        // The order for a rule comes first.
        desk.named(OrderKind::Rule, "best-source").unwrap();
        desk.order(OrderKind::Eta, eta).unwrap();
        desk.order(OrderKind::Adjustment, adjustment).unwrap();
    }
}

#[test]
fn a_renumbered_track_gets_a_number_that_was_never_given() {
    let mut desk = Desk::new(test_settings(2));
    desk.scans(0..6, &[[0.0; 2]]);
    let old = desk.numbers()[0];
    desk.order(OrderKind::Renumber, |order| order.track = old).unwrap();
    desk.scans(6..10, &[[0.0; 2]]);
    let new = desk.numbers()[0];
    assert!(new > old && desk.numbers().len() == 1);
    let ended = desk.heard.tracks.iter().rfind(|track| track.track_number == old);
    let ended = ended.unwrap();
    assert_eq!((ended.state, ended.merged_into), (TrackState::Terminated as u8, new));
}

#[test]
fn a_rule_is_ordered_where_its_memory_exists() {
    let mut settings = test_settings(2);
    settings.rule.name = RuleName(FusionRule::Auto);
    let mut desk = Desk::new(settings.clone());
    desk.scans(0..6, &[[0.0; 2]]);
    assert_eq!(desk.named(OrderKind::Rule, "no-such"), Err(Refusal::UnknownRule));
    assert_eq!(
        desk.named(OrderKind::Rule, "best-source"),
        Err(Refusal::RuleWithoutReports)
    );
    desk.named(OrderKind::Rule, "system-filter").unwrap();
    settings.rule.accuracy_values = Some(true);
    for rule in FusionRule::ALL.into_iter().filter(|rule| *rule != FusionRule::Mosaic) {
        let mut desk = Desk::new(settings.clone());
        desk.scans(0..6, &[[0.0; 2]]);
        let order = desk.named(OrderKind::Rule, rule.word()).unwrap();
        desk.scans(6..12, &[[0.0; 2]]);
        let last = desk.heard.tracks.last().unwrap();
        assert_eq!((last.rule, last.track_number), (rule.code(), 1), "{rule:?}");
        let sum: f64 = weights(last).iter().sum();
        assert!((sum - 1.0).abs() < 1e-5, "{rule:?}: {sum}");
        desk.order(OrderKind::Cancel, |cancel| cancel.number = order.number)
            .unwrap();
        desk.scans(12..14, &[[0.0; 2]]);
        assert_eq!(desk.heard.tracks.last().unwrap().rule, FusionRule::Auto.code());
    }
}

#[test]
fn a_reset_forgets_what_was_learned_of_the_source_alone() {
    let mut settings = test_settings(2);
    settings.registration.enabled = true;
    let mut desk = Desk::new(settings);
    let places: Vec<[f64; 2]> = (0..10).map(|n| [0.0, 4000.0 * f64::from(n)]).collect();
    desk.scans(0..60, &places);
    let samples = |desk: &Desk, source: u16| desk.engine.sources().source_errors(source).unwrap().samples;
    assert!(samples(&desk, 1) > 20.0);
    desk.order(OrderKind::Reset, |order| order.source = 1).unwrap();
    assert_eq!(samples(&desk, 1), 0.0);
    assert_eq!(desk.engine.sources().covariance_scale(1), Some(1.0));
    desk.scans(60..120, &places);
    assert!(samples(&desk, 1) > 20.0, "learned again");
    assert_eq!(desk.numbers().len(), 10);
}

#[test]
fn orders_that_make_no_sense_are_refused() {
    let mut desk = Desk::new(test_settings(2));
    let scan = |desk: &mut Desk, second: u32| {
        for target in 0..2u32 {
            for source in 0..2 {
                let time_s = f64::from(second) + 0.3 * f64::from(source);
                let place = [0.0, 500.0 * f64::from(target)];
                let report = report(source, 1 + target, time_s, place, [50.0, 0.0]);
                desk.engine.take(&with_address(report, 1 + target), &mut desk.heard);
            }
        }
    };
    (0..6).for_each(|second| scan(&mut desk, second));
    let numbers = desk.numbers();
    let mut refusal = |kind: OrderKind, change: fn(&mut Order, &[u32])| {
        desk.order(kind, |order| change(order, &numbers)).unwrap_err()
    };
    use OrderKind::{Adjustment, Cancel, Drop, Eta, Join, Out, Renumber, Split};
    assert_eq!(refusal(Out, |order, _| order.source = 2), Refusal::UnknownSource);
    assert_eq!(refusal(Eta, |order, _| order.value = 1.5), Refusal::OutOfRange);
    assert_eq!(
        refusal(Adjustment, |order, _| (order.source, order.value) = (0, 0.0)),
        Refusal::OutOfRange
    );
    assert_eq!(refusal(Drop, |order, _| order.track = 99), Refusal::UnknownTrack);
    assert_eq!(refusal(Renumber, |_, _| {}), Refusal::MissingParameter);
    let both = refusal(Join, |order, numbers| {
        (order.track, order.other_track) = (numbers[0], numbers[1])
    });
    assert_eq!(both, Refusal::TwoAddresses);
    let itself = refusal(Join, |order, numbers| {
        (order.track, order.other_track) = (numbers[0], numbers[0])
    });
    assert_eq!(itself, Refusal::SameTrack);
    let none = refusal(Join, |order, numbers| {
        (order.track, order.other_track) = (numbers[0], 99)
    });
    assert_eq!(none, Refusal::UnknownTrack);
    assert_eq!(
        refusal(Split, |order, numbers| {
            (order.track, order.source, order.other_track) = (numbers[0], 0, 2);
        }),
        Refusal::UnknownSensorTrack
    );
    assert_eq!(refusal(Cancel, |order, _| order.number = 7), Refusal::UnknownOrder);
    let images: Vec<u8> = desk.engine.image();
    let repeated = Order {
        token: 1,
        ..Order::new(OrderKind::Out)
    };
    assert!(desk.engine.obey(&repeated, &mut desk.heard).is_err());
    assert!(images == desk.engine.image(), "a refused order changes nothing");
    for source in 0..2 {
        for from in 0..2 {
            desk.order(Eta, |order| {
                (order.value, order.source, order.other_source) = (0.5, source, from)
            })
            .unwrap();
        }
    }
    assert_eq!(desk.engine.orders_in_force().len(), 4, "an order for each pair");
}

/// Memory that outlives the engine.
#[derive(Clone, Debug)]
struct Shared(Arc<Vec<AtomicU64>>);

impl Memory for Shared {
    fn words(&self) -> &[AtomicU64] {
        &self.0
    }
}

#[test]
fn orders_outlive_the_process_and_go_on_from_an_image() {
    let mut settings = test_settings(2);
    settings.rule.accuracy_values = Some(true);
    settings.sources[0].accuracy.conditions = vec![("rain".to_owned(), 1e3)];
    let mut desk = Desk::new(settings.clone());
    let words = desk.engine.checkpoint_layout().len();
    let memory = Shared(Arc::new((0..words).map(|_| AtomicU64::new(0)).collect()));
    desk.engine.keep_checkpoint(Box::new(memory.clone()));
    let places = [[0.0, 0.0], [0.0, 9000.0], [0.0, 18_000.0]];
    desk.scans(0..6, &places);
    let numbers = desk.numbers();
    desk.named(OrderKind::Condition, "rain").unwrap();
    desk.order(OrderKind::Eta, |order| (order.value, order.ends_ns) = (0.4, 1000 * S))
        .unwrap();
    desk.named(OrderKind::Rule, "inverse-trace").unwrap();
    desk.order(OrderKind::Drop, |order| order.track = numbers[1]).unwrap();
    desk.order(OrderKind::Split, |order| {
        (order.track, order.source, order.other_track) = (numbers[2], 1, 3);
    })
    .unwrap();
    desk.scans(6..12, &places);
    let split = desk.numbers()[2];
    assert_eq!(desk.numbers(), [numbers[0], numbers[2], split]);

    let mut other = Desk::new(settings.clone());
    other.engine.resume_image(&desk.engine.image()).unwrap();
    let before = desk.heard.tracks.len();
    desk.engine.keep_clock(CheckpointClock {
        epoch: 1,
        ..CheckpointClock::default()
    });
    let snapshot = Snapshot::read(&memory.0, &desk.engine.checkpoint_layout()).unwrap();
    for desk in [&mut desk, &mut other] {
        desk.scans(12..40, &places);
    }
    assert!(SystemTrack::octets(&desk.heard.tracks[before..]) == SystemTrack::octets(&other.heard.tracks));

    let mut next = Desk::new(settings);
    next.engine.resume(&snapshot, false, &mut next.heard);
    assert_eq!(next.heard.orders.len(), 5);
    let in_force = [&next, &desk].map(|desk| desk.engine.orders_in_force());
    assert!(OrderState::octets(&in_force[0]) == OrderState::octets(&in_force[1]));
    next.scans(12..40, &places);
    assert_eq!(
        next.numbers(),
        [numbers[0], numbers[2], split],
        "dropped stays dropped, split stays split"
    );
    assert_eq!(next.heard.tracks.last().unwrap().rule, FusionRule::InverseTrace.code());
    next.token = 100;
    let fresh = next
        .order(OrderKind::Renumber, |order| order.track = numbers[0])
        .unwrap();
    assert_eq!(fresh.number, 6, "numbers of orders go on");
    assert!(next.numbers().iter().all(|number| *number != numbers[0]));
}

#[test]
fn a_drop_that_has_lasted_for_long_outlives_the_process_too() {
    let settings = test_settings(2);
    let mut desk = Desk::new(settings.clone());
    let words = desk.engine.checkpoint_layout().len();
    let memory = Shared(Arc::new((0..words).map(|_| AtomicU64::new(0)).collect()));
    desk.engine.keep_checkpoint(Box::new(memory.clone()));
    let places = [[0.0, 0.0], [0.0, 9000.0]];
    desk.scans(0..6, &places);
    let (kept, dropped) = (desk.numbers()[0], desk.numbers()[1]);
    desk.order(OrderKind::Drop, |order| order.track = dropped).unwrap();
    // Far longer than a track lives without a report.
    desk.scans(6..600, &places);
    desk.engine.keep_clock(CheckpointClock {
        epoch: 1,
        ..CheckpointClock::default()
    });
    let snapshot = Snapshot::read(&memory.0, &desk.engine.checkpoint_layout()).unwrap();
    let mut next = Desk::new(settings);
    next.engine.resume(&snapshot, false, &mut next.heard);
    next.scans(600..640, &places);
    assert_eq!((next.numbers(), next.engine.orders_in_force().len()), (vec![kept], 1));
}

#[test]
fn the_table_of_orders_has_a_limit_and_forgets_ended_orders_first() {
    let mut desk = Desk::new(test_settings(2));
    desk.scans(0..40, &[[0.0; 2]]);
    // Ended orders never displace orders in force.
    let out = desk.order(OrderKind::Out, |order| order.source = 1).unwrap();
    for _ in 0..300 {
        desk.order(OrderKind::Eta, |order| order.value = 0.5).unwrap();
    }
    let in_force = desk.engine.orders_in_force();
    assert_eq!(in_force.len(), 2);
    assert_eq!((in_force[0].number, in_force[1].number), (out.number, 301));
}

//! Orders that change settings: condition, source in and out, eta, adjustment coefficient, rule, reset.

use frames::{Geodetic, SystemFrame};
use messages::admission::REACH_M;
use messages::{DesignatedPlace, FusionRule, NO_SOURCE, Order, OrderKind, Refusal};
use source_models::Fact;

use crate::engine::Engine;
use crate::rules::{self, RuleMethod};
use crate::settings::OrderedEta;
use crate::settings::qnh::RegionalQnh;
use crate::settings::{NORMAL, RuleName};
use crate::tables::sensor_tracks::SensorSlot;

/// Returns whether the place of a designation lies where sensors see anything.
fn is_near(order: &Order, frame: &SystemFrame) -> bool {
    let Some((place, _)) = DesignatedPlace::read(order.name()) else {
        return false;
    };
    let [east, north, up] = match place {
        DesignatedPlace::Frame {
            plane_m: [east, north],
            up_m,
        } => [east, north, up_m.unwrap_or_default()],
        DesignatedPlace::Globe {
            latitude_deg,
            longitude_deg,
            height_m,
        } => {
            let place = Geodetic::from_degrees(latitude_deg, longitude_deg, height_m.unwrap_or_default());
            let Ok(place) = place else { return false };
            frame.to_local(place)
        }
    };
    east.hypot(north).hypot(up) <= REACH_M
}

/// Returns whether two orders of `kind` concern the same subject, so that the newer one replaces the older one.
pub(super) fn is_same_subject(kind: OrderKind, old: &Order, new: &Order) -> bool {
    match kind {
        // An order for all sources replaces the orders for single sources.
        OrderKind::Condition => new.source == NO_SOURCE || new.source == old.source,
        OrderKind::Out | OrderKind::Adjustment => new.source == old.source,
        OrderKind::Eta => (new.source, new.other_source) == (old.source, old.other_source),
        OrderKind::Qnh => new.name() == old.name(),
        OrderKind::Rule => true,
        _ => false,
    }
}

/// Returns whether the order restores the normal condition of all sources, after which no condition is in force.
pub(super) fn ends_conditions(order: &Order) -> bool {
    order.source == NO_SOURCE && order.name() == NORMAL
}

impl Engine {
    /// Checks an order that changes settings.
    pub(super) fn examine_settings(&self, kind: OrderKind, order: &Order) -> Result<(), Refusal> {
        let is_accepted = match kind {
            OrderKind::Condition => {
                let named = |source: u16| {
                    let source = self.settings.sources.get(usize::from(source));
                    let mut names = source.into_iter().flat_map(|source| source.accuracy.condition_names());
                    order.name() == NORMAL || names.any(|name| name == order.name())
                };
                let is_known = match order.source {
                    NO_SOURCE => self.settings.conditions().any(|name| name == order.name()),
                    source => named(source),
                };
                return is_known.then_some(()).ok_or(Refusal::UnknownCondition);
            }
            OrderKind::Rule => {
                let rule = FusionRule::from_word(order.name()).ok_or(Refusal::UnknownRule)?;
                let is_filter = matches!(rules::entry(rule).method, RuleMethod::Filter);
                return (is_filter || self.tracks.looks_back())
                    .then_some(())
                    .ok_or(Refusal::RuleWithoutReports);
            }
            OrderKind::Eta | OrderKind::Adjustment => {
                let is_used = self.publisher.rule().chooses_by_accuracy;
                return is_used.then_some(()).ok_or(Refusal::UnusedByRule);
            }
            OrderKind::Qnh => {
                let is_known = self.settings.qnh.iter().any(|regional| regional.name == order.name());
                return is_known.then_some(()).ok_or(Refusal::UnknownQnh);
            }
            OrderKind::Designate => {
                let origin = self.settings.sources[usize::from(order.source)].designates_round;
                let frame = SystemFrame::at(origin.ok_or(Refusal::TakesNoDesignations)?);
                return is_near(order, &frame).then_some(()).ok_or(Refusal::FarPlace);
            }
            OrderKind::In => self.settings.sources[usize::from(order.source)].is_out,
            _ => true,
        };
        is_accepted.then_some(()).ok_or(Refusal::NotOut)
    }

    /// Applies the orders in force to the configured settings, in the order of their numbers.
    pub(super) fn apply_orders(&mut self) {
        let configured = &self.orders.configured;
        for (source, adjustment) in self.settings.sources.iter_mut().zip(&configured.adjustments) {
            (source.adjustment, source.is_out) = (*adjustment, false);
        }
        for regional in &mut self.settings.qnh {
            regional.ordered_hpa = None;
        }
        let mut rule = configured.rule;
        self.settings.rule.hand_over.ordered.clear();
        let accuracies = &mut self.publisher.accuracies;
        accuracies.set_condition(&self.settings.sources, NORMAL, None);
        let mut number = 0;
        while let Some(place) = self.orders.next_in_force(number) {
            let record = &self.orders.records[place];
            number = record.number;
            let order = record.order();
            let source = usize::from(order.source);
            match record.kind() {
                Some(OrderKind::Condition) => {
                    let only = (order.source != NO_SOURCE).then_some(order.source);
                    accuracies.set_condition(&self.settings.sources, order.name(), only);
                }
                Some(OrderKind::Out) => self.settings.sources[source].is_out = true,
                Some(OrderKind::Adjustment) => self.settings.sources[source].adjustment = order.value,
                Some(OrderKind::Eta) => self.settings.rule.hand_over.ordered.push(OrderedEta {
                    from: order.other_source,
                    to: order.source,
                    eta: [order.value],
                }),
                Some(OrderKind::Qnh) => {
                    let of_name = |regional: &&mut RegionalQnh| regional.name == order.name();
                    if let Some(regional) = self.settings.qnh.iter_mut().find(of_name) {
                        regional.ordered_hpa = Some(order.value);
                    }
                }
                Some(OrderKind::Rule) => rule = FusionRule::from_word(order.name()).or(rule),
                _ => {}
            }
        }
        if let Some(rule) = rule {
            self.settings.rule.name = RuleName(rule);
            self.publisher.set_rule(rules::entry(rule));
        }
    }

    /// Drops the sensor tracks of a source: its last reports contribute no longer.
    pub(super) fn drop_source(&mut self, source: u16) {
        for sensor in 0..self.tracks.sensors.capacity() as SensorSlot {
            if self.tracks.sensors.is_of(sensor, source) {
                self.tracks.drop_sensor_track(sensor);
            }
        }
    }

    /// Forgets everything learned of a source.
    pub(super) fn reset_source(&mut self, source: u16) {
        self.tracks.sources.learn(&self.settings, Fact::Order { source });
        *self.publisher.accuracies.mean_square_mut(usize::from(source)) = None;
    }
}

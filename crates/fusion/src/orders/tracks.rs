//! Orders that change system tracks: drop, join, split, renumber.
//!
//! A joined track stays together, and the parts of a split track stay apart, until the order ends. The order ends by
//! itself as soon as a track has ended, or the measured distance has exceeded [`APART_D2`] for [`APART_NS`]. A joined
//! track then consists of two targets, and split parts no longer need the order.

use estimation::{ComparedComponents, Gaussian, statistical_distance};
use messages::{Decision, DecisionKind, Order, OrderKind, OrderStatus, Refusal, TrackState};

use crate::associate::association_step::Search;
use crate::associate::linking::{Linking, Next};
use crate::engine::Engine;
use crate::explanation::Sink;
use crate::judge::life;
use crate::orders::order_table::OrderRecord;
use crate::publish::system_track_message::write;
use crate::tables::sensor_tracks::SensorSlot;
use crate::tables::system_tracks::{Bond, SystemSlot};
use crate::update::filter::TargetFilter;

/// Square of the distance, in standard deviations, beyond which tracks are different targets.
const APART_D2: f64 = 25.0;
/// Time for which the distance must exceed its limit, nanoseconds.
const APART_NS: i64 = 10_000_000_000;

impl Engine {
    /// Checks an order that changes system tracks.
    pub(crate) fn examine_tracks(&self, kind: OrderKind, order: &Order) -> Result<(), Refusal> {
        let live = |number: u32| self.live_track(number).ok_or(Refusal::UnknownTrack);
        let system = live(order.track)?;
        let entry = self.tracks.systems.get(system);
        let is_suspended = |life: TrackState| kind != OrderKind::Drop && life == TrackState::Suspended;
        if is_suspended(entry.life) {
            return Err(Refusal::UnknownTrack);
        }
        if kind != OrderKind::Drop && entry.bond != Bond::Free {
            return Err(Refusal::BoundTrack);
        }
        if kind == OrderKind::Join {
            let other_system = live(order.other_track)?;
            let other = self.tracks.systems.get(other_system);
            if is_suspended(other.life) {
                return Err(Refusal::UnknownTrack);
            }
            if other.number == entry.number {
                return Err(Refusal::SameTrack);
            }
            if other.bond != Bond::Free {
                return Err(Refusal::BoundTrack);
            }
            let search = Search {
                settings: &self.settings,
                tracks: &self.tracks,
            };
            if search.are_two_targets(system, other_system) {
                return Err(Refusal::TwoAddresses);
            }
        }
        if kind == OrderKind::Split {
            let sensor = self.tracks.sensors.find(order.source, order.other_track);
            let is_member = |sensor: &SensorSlot| self.tracks.sensors.get(*sensor).system == system;
            let sensor = sensor.filter(is_member).ok_or(Refusal::UnknownSensorTrack)?;
            if self.tracks.members(system).all(|member| member == sensor) {
                return Err(Refusal::OnlyMember);
            }
        }
        Ok(())
    }

    fn live_track(&self, number: u32) -> Option<SystemSlot> {
        let systems = &self.tracks.systems;
        systems.slots().find(|slot| {
            let entry = systems.get(*slot);
            entry.number == number && entry.life != TrackState::Terminated
        })
    }

    /// Returns the time of an effect on `system`: no state precedes the last one.
    fn effect_ns(&self, system: SystemSlot) -> i64 {
        self.schedule
            .now_ns()
            .max(self.tracks.systems.get(system).state.time_ns)
    }

    fn tell(&self, system: SystemSlot, record: &OrderRecord, sink: &mut impl Sink) {
        let time_ns = self.effect_ns(system);
        let value = f64::from(record.number);
        sink.decision(&self.tracks.decision_on(system, DecisionKind::Ordered, time_ns, value));
    }

    /// Ends a system track; its sensor tracks start no other.
    pub(super) fn drop_track(&mut self, order: &Order, record: &mut OrderRecord, sink: &mut impl Sink) {
        let Some(system) = self.live_track(order.track) else {
            return;
        };
        self.tell(system, record, sink);
        record.tracks = [order.track, 0];
        for (place, member) in record.blocked.iter_mut().zip(self.tracks.members(system)) {
            let entry = self.tracks.sensors.get(member);
            *place = (entry.source, entry.track_number);
            record.blocked_ns = record.blocked_ns.max(entry.time_ns);
            record.blocked_count += 1;
        }
        let time_ns = self.effect_ns(system);
        let out = &mut self.outbox.to(sink);
        life::end(&self.settings, &mut self.tracks, system, time_ns, 0, out);
    }

    /// Joins two system tracks and keeps the joined track together.
    pub(super) fn join_tracks(&mut self, order: &Order, record: &mut OrderRecord, sink: &mut impl Sink) {
        let (Some(one), Some(other)) = (self.live_track(order.track), self.live_track(order.other_track)) else {
            return;
        };
        self.tell(one, record, sink);
        let now_ns = self.effect_ns(one).max(self.effect_ns(other));
        let out = &mut self.outbox.to(sink);
        let mut linking = Linking {
            settings: &self.settings,
            tracks: &mut self.tracks,
        };
        if let Next::End(merged) = linking.merge(one, other, now_ns, f64::NAN, out) {
            life::end(&self.settings, &mut self.tracks, merged.ended, now_ns, merged.into, out);
            let left = if merged.ended == one { other } else { one };
            self.tracks.systems.get_mut(left).bond = Bond::Joined;
            record.tracks = [merged.into, 0];
        }
    }

    /// Gives a sensor track a system track of its own and keeps the two apart.
    pub(super) fn split_track(&mut self, order: &Order, record: &mut OrderRecord, sink: &mut impl Sink) {
        let system = self.live_track(order.track);
        let sensor = self.tracks.sensors.find(order.source, order.other_track);
        let (Some(system), Some(sensor)) = (system, sensor) else {
            return;
        };
        self.tell(system, record, sink);
        self.tracks.unlink(sensor);
        let latest = self.tracks.sensors.get(sensor).latest;
        let deadline_ns = self.life.first_deadline_ns(latest.time_of_measurement_ns);
        let out = &mut self.outbox.to(sink);
        let mut linking = Linking {
            settings: &self.settings,
            tracks: &mut self.tracks,
        };
        if !linking.start(sensor, deadline_ns, out) {
            return;
        }
        out.input(|| self.tracks.input(sensor, None));
        let new = self.tracks.sensors.get(sensor).system;
        record.tracks = [order.track, self.tracks.systems.get(new).number];
        self.bind(record);
        // The operator states that there are two targets.
        self.tracks.systems.set_life(new, TrackState::Confirmed);
        self.tracks.systems.get_mut(new).was_shown = true;
        self.update(sensor, &latest, None, sink);
        let left = self.tracks.members(system).next();
        if let Some(left) = left {
            self.tracks.assign_role(left);
        }
    }

    /// Gives a system track the next number; the old number ends.
    pub(super) fn renumber_track(&mut self, order: &Order, record: &mut OrderRecord, sink: &mut impl Sink) {
        let Some(system) = self.live_track(order.track) else {
            return;
        };
        self.tell(system, record, sink);
        let number = self.tracks.take_number();
        record.tracks = [order.track, number];
        let (settings, tracks) = (&self.settings, &mut self.tracks);
        let out = &mut self.outbox.to(sink);
        out.track(|message| {
            write(message, settings, tracks, system, None, None);
            (message.state, message.merged_into) = (TrackState::Terminated.code(), number);
        });
        tracks.renumber(system, number);
        life::publish(settings, tracks, system, out);
    }

    /// Sets the bonds of the tracks of an order.
    fn bind(&mut self, record: &OrderRecord) {
        let bonds = match record.kind() {
            Some(OrderKind::Join) => [Bond::Joined, Bond::Free],
            Some(OrderKind::Split) => [Bond::Apart(record.tracks[1]), Bond::Apart(record.tracks[0])],
            _ => return,
        };
        for (number, bond) in record.tracks.into_iter().zip(bonds) {
            if let Some(system) = self.live_track(number).filter(|_| number != 0) {
                self.tracks.systems.get_mut(system).bond = bond;
            }
        }
    }

    /// Sets the bonds of the tracks of all orders in force.
    pub(super) fn bind_tracks(&mut self) {
        for place in 0..self.orders.records.len() {
            let record = self.orders.records[place];
            if record.is_in_force() {
                self.bind(&record);
            }
        }
    }

    /// Releases the tracks of the order at `place`.
    pub(super) fn release_tracks(&mut self, place: usize) {
        let record = self.orders.records[place];
        for number in record.tracks.into_iter().filter(|number| *number != 0) {
            if let Some(system) = self.live_track(number) {
                self.tracks.systems.get_mut(system).bond = Bond::Free;
            }
        }
        for (source, number) in record.blocked() {
            if let Some(sensor) = self.tracks.sensors.find(*source, *number) {
                self.tracks.sensors.get_mut(sensor).blocked = false;
            }
        }
    }

    /// Returns whether an order keeps a sensor track that reports at `time_ns` from starting a system track.
    fn is_blocked(&mut self, source: u16, number: u32, time_ns: i64) -> bool {
        let terminate_ns = self.tracks.sources.terminate_ns();
        let mut is_blocked = false;
        for record in self.orders.records.iter_mut().filter(|record| record.is_in_force()) {
            let listed = record.blocked().contains(&(source, number));
            // After a longer silence, the source has reused the number for another target.
            if listed && time_ns.saturating_sub(record.blocked_ns) <= terminate_ns {
                record.blocked_ns = record.blocked_ns.max(time_ns);
                is_blocked = true;
            }
        }
        is_blocked
    }

    /// Blocks a sensor track without system track if an order in force requires it.
    #[cold]
    pub(crate) fn block(&mut self, sensor: SensorSlot) {
        let entry = self.tracks.sensors.get(sensor);
        let (source, number, time_ns) = (entry.source, entry.track_number, entry.time_ns);
        self.tracks.sensors.get_mut(sensor).blocked = self.is_blocked(source, number, time_ns);
    }

    /// Ends the orders on tracks that no longer permit the effect.
    pub(super) fn watch_tracks(&mut self, sink: &mut impl Sink) {
        let now_ns = self.schedule.now_ns();
        for place in 0..self.orders.records.len() {
            let record = self.orders.records[place];
            let Some(kind) = record.kind().filter(|_| record.is_in_force()) else {
                continue;
            };
            let apart_d2 = match kind {
                OrderKind::Join => self.live_track(record.tracks[0]).map(|one| self.spread_d2(one)),
                OrderKind::Split => {
                    let tracks = record.tracks.map(|number| self.live_track(number));
                    tracks[0]
                        .zip(tracks[1])
                        .map(|(one, other)| self.distance_d2(one, other))
                }
                OrderKind::Drop => {
                    let silent_ns = now_ns.saturating_sub(record.blocked_ns);
                    (silent_ns <= self.tracks.sources.terminate_ns()).then_some(0.0)
                }
                _ => continue,
            };
            let Some(apart_d2) = apart_d2 else {
                self.end_order(place, OrderStatus::Ended, sink);
                continue;
            };
            // A successor must have the time of the latest blocked report.
            if kind == OrderKind::Drop {
                self.keep_order(place);
            }
            let since_ns = &mut self.orders.records[place].apart_since_ns;
            *since_ns = if apart_d2 > APART_D2 {
                now_ns.min(*since_ns)
            } else {
                i64::MAX
            };
            if now_ns.saturating_sub(*since_ns) >= APART_NS && *since_ns != i64::MAX {
                sink.decision(&Decision {
                    time_ns: now_ns,
                    kind: DecisionKind::OrderEnded.code(),
                    system_track: record.tracks[0],
                    other_system_track: record.tracks[1],
                    value: apart_d2.sqrt(),
                    limit: APART_D2.sqrt(),
                    ..Decision::default()
                });
                self.end_order(place, OrderStatus::Ended, sink);
            }
        }
    }

    /// Returns the largest d² between the fresh sensor tracks of a system track, in the plane. Second tracks of a
    /// source count too: of two targets that all sources see, each source contributes one track.
    fn spread_d2(&self, system: SystemSlot) -> f64 {
        let now_ns = self.schedule.now_ns();
        let state = |member: SensorSlot| -> Gaussian {
            let filter = TargetFilter::of_report(&self.tracks.sensors.get(member).latest);
            filter.at(now_ns, self.tracks.sources.motion(filter.velocity_mps()))
        };
        let fresh = || {
            self.tracks
                .members(system)
                .filter(|member| self.tracks.is_fresh(self.tracks.sensors.get(*member), now_ns))
        };
        let mut largest = 0.0f64;
        for (place, one) in fresh().enumerate() {
            let own = state(one);
            for other in fresh().skip(place + 1) {
                let d2 = statistical_distance(&own, &state(other), ComparedComponents::HorizontalPosition);
                largest = largest.max(d2);
            }
        }
        largest
    }

    /// Returns d² between two system tracks, in the plane.
    fn distance_d2(&self, one: SystemSlot, other: SystemSlot) -> f64 {
        let now_ns = self.schedule.now_ns();
        let [own, theirs] = [one, other].map(|system| {
            let filter = &self.tracks.systems.get(system).filter;
            filter.at(now_ns, self.tracks.sources.motion(filter.velocity_mps()))
        });
        statistical_distance(&own, &theirs, ComparedComponents::HorizontalPosition)
    }
}

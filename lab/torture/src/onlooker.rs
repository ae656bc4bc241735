//! Subscriber through which the judge sees the deployment.

use std::collections::{BTreeMap, BTreeSet};

use bus::{Bus, Root, SharedMemory, Subscriber};
use messages::{BatchHeader, Counter, Health, NO_SOURCE, ProcessKind, SystemTrack, TrackState};
use runtime::clock::mono_ns;

use super::judge::event::{Event, Life, State, What};
use super::ledger::Ledger;
use super::resources::Latencies;

/// Time between two looks whether the deployment has replaced the memory, nanoseconds.
const LOOK_NS: i64 = 250_000_000;

/// See the module's documentation.
pub(super) struct Onlooker {
    locators: BTreeSet<u16>,
    bus: Bus<SharedMemory>,
    tracks: Subscriber<SharedMemory, SystemTrack>,
    health: Subscriber<SharedMemory, Health>,
    announced: u64,
    looked_ns: i64,
}

/// Take-overs, by process and start: the count, and the count of take-overs from a process that did not advance.
pub(super) type TakeOvers = BTreeMap<(u32, u64), [u64; 2]>;

impl Onlooker {
    /// Joins the deployment.
    ///
    /// # Errors
    /// If the deployment is being rebuilt, or the memory is unusable.
    pub(super) fn join(root: &Root, locators: &BTreeSet<u16>, ledger: &mut Ledger) -> anyhow::Result<Self> {
        let bus = Bus::open(root, "torture")?;
        let mut joined_ns = 0;
        let now_ns = || {
            joined_ns = mono_ns();
            joined_ns as u64
        };
        // Including older epochs: the judge detects a fusion process that continues after a replacement.
        let tracks = bus.subscriber(&messages::system_tracks(), now_ns)?.of_all_epochs();
        let health = bus.subscriber(&messages::health(), || mono_ns() as u64)?;
        ledger.take(&Event {
            at_ns: joined_ns,
            what: What::Joined,
        });
        Ok(Self {
            bus,
            tracks,
            health,
            locators: locators.clone(),
            announced: 0,
            looked_ns: joined_ns,
        })
    }

    /// Hands all received samples to the judge; `false` if the deployment has replaced the memory.
    ///
    /// # Errors
    /// If the memory cannot be read.
    pub(super) fn look(
        &mut self,
        ledger: &mut Ledger,
        latencies: &mut Latencies,
        take_overs: &mut TakeOvers,
    ) -> anyhow::Result<bool> {
        let at_ns = mono_ns();
        let locators = &self.locators;
        self.tracks.take(usize::MAX, |header, tracks| {
            for track in tracks {
                latencies.add(track.stages.fused_ns - track.stages.ingested_ns);
                let what = What::State(state(header, track, locators));
                // A state may have been sent after the look began.
                let at_ns = at_ns.max(mono_ns());
                ledger.take(&Event { at_ns, what });
            }
        })?;
        let lost = self.tracks.counts().lost;
        if lost > self.announced {
            ledger.now(What::Lost {
                samples: lost - self.announced,
            });
            self.announced = lost;
        }
        self.health.take(usize::MAX, |_, said| {
            let is_fusion = |said: &&Health| said.kind() == Some(ProcessKind::Fusion) && said.source == NO_SOURCE;
            for said in said.iter().filter(is_fusion) {
                let counts = [Counter::TakeOvers, Counter::TakeOversFromStill];
                let counts = counts.map(|counter| said.counters[counter]);
                take_overs.insert((said.process_id, said.incarnation), counts);
            }
        })?;
        if at_ns - self.looked_ns < LOOK_NS {
            return Ok(true);
        }
        self.looked_ns = at_ns;
        Ok(self.bus.goes_on()?)
    }

    /// Leaves. Where the memory was not `whole` to the end, the counts prove nothing.
    pub(super) fn leave(self, whole: bool, ledger: &mut Ledger) {
        let counts = self.tracks.counts();
        ledger.now(What::Left {
            lost: counts.lost,
            lost_at_end: counts.lost_at_end,
            whole,
        });
    }
}

/// Part of a system track that the judge looks at.
fn state(header: &BatchHeader, track: &SystemTrack, locators: &BTreeSet<u16>) -> State {
    let place = track.position_m.iter().chain(&track.velocity_mps);
    let is_finite = place.chain(&track.covariance.upper).all(|value| value.is_finite());
    State {
        sent_ns: track.stages.fused_ns,
        incarnation: header.incarnation,
        sequence: track.sequence,
        epoch: header.epoch,
        continues: header.flags & BatchHeader::GOES_ON != 0,
        number: track.track_number,
        life: match track.state {
            state if state == TrackState::Confirmed as u8 => Life::Confirmed,
            state if state == TrackState::Coasted as u8 => Life::Coasted,
            state if state == TrackState::Suspended as u8 => Life::Suspended,
            state if state == TrackState::Terminated as u8 => Life::Terminated,
            _ => Life::Tentative,
        },
        merged_into: track.merged_into,
        of_report: track.trigger_source != NO_SOURCE,
        of_locator: locators.contains(&track.trigger_source),
        address: track.identity.address(),
        time_ns: track.reference_time_ns,
        position_m: is_finite.then_some(track.position_m),
        velocity_mps: (is_finite && track.velocity_valid != 0).then_some(track.velocity_mps),
        has_height: track.height_valid != 0,
        sources: track.contributions().iter().map(|part| part.source).collect(),
    }
}

//! The clocks of other hosts, compared with this one's.
//!
//! Each link requests the clocks of all others once a second (Cristian's method): an answer with the round trip `d`
//! was written within this time, so that the other clock's offset is known to ± `d`/2. Of the last answers, the
//! answer with the shortest round trip is the most accurate.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use runtime::Now;
use zenoh::Wait as _;
use zenoh::query::{ConsolidationMode, Query, QueryTarget, Queryable};
use zenoh::{Session, bytes::ZBytes};

use crate::keys;

/// Answers among which the best is looked for.
const ANSWERS: usize = 16;
/// Time after which a link that does not answer is gone, nanoseconds.
const SILENCE_NS: i64 = 3_000_000_000;

/// Comparison of another host's clocks with this one's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Comparison {
    /// Time from question to answer, nanoseconds.
    pub(crate) round_trip_ns: i64,
    /// Its UTC less this host's, ± half of the round trip.
    pub(crate) utc_offset_ns: i64,
    /// Its monotonic clock less this host's, ± the same.
    pub(crate) mono_offset_ns: i64,
}

impl Comparison {
    /// Compares clocks by an answer with the times `theirs`, requested at `asked` and received at `answered`.
    fn of(asked: Now, theirs: Now, answered: Now) -> Self {
        let round_trip_ns = answered.mono_ns - asked.mono_ns;
        Self {
            round_trip_ns,
            utc_offset_ns: theirs.utc_ns - (answered.utc_ns - round_trip_ns / 2),
            mono_offset_ns: theirs.mono_ns - (answered.mono_ns - round_trip_ns / 2),
        }
    }
}

impl Comparison {
    /// Returns the certain part of the UTC offset, in either direction: the offset beyond half of the round trip,
    /// nanoseconds.
    pub(crate) fn certain_offset_ns(&self) -> i64 {
        (self.utc_offset_ns.abs() - self.round_trip_ns / 2).max(0)
    }
}

/// A link of another deployment.
#[derive(Clone, Debug)]
struct Peer {
    answers: Vec<Comparison>,
    next: usize,
    heard_ns: i64,
}

impl Peer {
    fn best(&self) -> Option<Comparison> {
        self.answers.iter().copied().min_by_key(|answer| answer.round_trip_ns)
    }
}

/// Links of other deployments that have answered, by deployment and name.
#[derive(Clone, Debug, Default)]
pub(crate) struct PeerClocks(Arc<Mutex<BTreeMap<(String, String), Peer>>>);

impl PeerClocks {
    fn lock(&self) -> MutexGuard<'_, BTreeMap<(String, String), Peer>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn take(&self, key: &str, comparison: Comparison, heard_ns: i64) {
        let Some((deployment, link)) = keys::of_clock(key) else {
            return;
        };
        let mut peers = self.lock();
        let peer = peers
            .entry((deployment.to_owned(), link.to_owned()))
            .or_insert_with(|| Peer {
                answers: Vec::with_capacity(ANSWERS),
                next: 0,
                heard_ns,
            });
        peer.heard_ns = heard_ns;
        match peer.answers.len() < ANSWERS {
            true => peer.answers.push(comparison),
            false => peer.answers[peer.next] = comparison,
        }
        peer.next = (peer.next + 1) % ANSWERS;
    }

    /// Best comparison with the clocks of `deployment`.
    pub(crate) fn of(&self, deployment: &str) -> Option<Comparison> {
        let peers = self.lock();
        let of_deployment = peers.iter().filter(|((name, _), _)| name == deployment);
        of_deployment
            .filter_map(|(_, peer)| peer.best())
            .min_by_key(|best| best.round_trip_ns)
    }

    /// Links that have answered lately: deployment, link and comparison.
    pub(crate) fn present(&self, now: Now) -> Vec<(String, String, Comparison)> {
        let peers = self.lock();
        let present = peers
            .iter()
            .filter(|(_, peer)| now.mono_ns - peer.heard_ns < SILENCE_NS);
        let all =
            present.filter_map(|((deployment, link), peer)| Some((deployment.clone(), link.clone(), peer.best()?)));
        all.collect()
    }

    /// Asks all links but the one at `own` key.
    pub(crate) fn ask(&self, session: &Session, own: &str) {
        let (clocks, own) = (self.clone(), own.to_owned());
        let asked = Now::read();
        let take = move |reply: zenoh::query::Reply| {
            let answered = Now::read();
            let Ok(sample) = reply.result() else { return };
            let key = sample.key_expr().as_str();
            if key != own
                && let Some(theirs) = read(&sample.payload().to_bytes())
            {
                clocks.take(key, Comparison::of(asked, theirs, answered), answered.mono_ns);
            }
        };
        let question = session.get(keys::CLOCKS).target(QueryTarget::All);
        // Without peers there is no answer; the missing peers are reported elsewhere.
        let _ = question.consolidation(ConsolidationMode::None).callback(take).wait();
    }
}

/// Answers questions for this host's clocks at `key`.
pub(crate) fn answer(session: &Session, key: &str) -> zenoh::Result<Queryable<()>> {
    let of_answers = key.to_owned();
    let answer = move |query: Query| {
        let now = Now::read();
        let octets = [now.mono_ns.to_le_bytes(), now.utc_ns.to_le_bytes()].concat();
        // A failure means that the requesting link is gone.
        let _ = query.reply(of_answers.as_str(), ZBytes::from(octets)).wait();
    };
    session.declare_queryable(key.to_owned()).callback(answer).wait()
}

fn read(octets: &[u8]) -> Option<Now> {
    let (mono, utc) = octets.split_at_checked(8)?;
    Some(Now {
        mono_ns: i64::from_le_bytes(mono.try_into().ok()?),
        utc_ns: i64::from_le_bytes(utc.try_into().ok()?),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(mono_ns: i64, utc_ns: i64) -> Now {
        Now { mono_ns, utc_ns }
    }

    #[test]
    fn the_offset_is_known_to_half_a_round_trip_and_the_shortest_says_most() {
        let clocks = PeerClocks::default();
        // The other's monotonic clock is 1000 ahead, its UTC 50 behind; 30 on the way there, 10 back.
        let slow = Comparison::of(at(0, 100_000), at(1030, 99_980), at(40, 100_040));
        assert_eq!(
            (slow.round_trip_ns, slow.mono_offset_ns, slow.utc_offset_ns),
            (40, 1010, -40)
        );
        let fast = Comparison::of(at(100, 100_100), at(1102, 100_052), at(104, 100_104));
        clocks.take("koseki-clock/west/out", slow, 40);
        clocks.take("koseki-clock/west/out", fast, 104);
        for _ in 0..ANSWERS - 2 {
            clocks.take("koseki-clock/west/out", slow, 200);
        }
        assert_eq!(clocks.of("west"), Some(fast));
        assert_eq!((slow.certain_offset_ns(), fast.certain_offset_ns()), (20, 48));
        assert_eq!(clocks.of("east"), None);
        clocks.take("koseki-clock/west/out", slow, 300);
        clocks.take("koseki-clock/west/out", slow, 300);
        assert_eq!(clocks.of("west"), Some(slow), "the fast one is too old");
        assert_eq!(clocks.present(at(400, 0)).len(), 1);
        assert!(clocks.present(at(400 + SILENCE_NS, 0)).is_empty());
    }
}

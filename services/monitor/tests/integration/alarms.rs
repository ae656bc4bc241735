//! Alarms, raised and cleared by what processes say, over the in-process transport and with a clock that the test sets.

use alarms::AlarmKind;
use bus::{InProcess, Subscriber};
use messages::{
    Alarm, AlarmEvent, Bias, BiasKind, Counter, Health, LifeState, NO_SOURCE, ProcessKind, Registration, SystemTrack,
    TrackState,
};

use crate::watched::{Bench, S};

/// Seconds that pass in one step: as often as processes speak, but for the patience of a test.
const STEP_NS: i64 = S / 2;

/// A monitor, whose processes speak and whose alarms are heard.
struct Site {
    bench: Bench,
    alarms: Subscriber<InProcess, Alarm>,
    /// What the last slice held.
    last: Vec<Alarm>,
    /// Events other than that something goes on standing.
    events: Vec<(AlarmKind, AlarmEvent)>,
    health: Vec<Health>,
}

impl Site {
    fn new(overrides: &[&str]) -> Self {
        let bench = Bench::new(overrides);
        let alarms = bench.bus.subscriber(&messages::alarms(), || 1).unwrap();
        Self {
            bench,
            alarms,
            last: Vec::new(),
            events: Vec::new(),
            health: Vec::new(),
        }
    }

    /// From now on, this is said in each step.
    fn say(&mut self, kind: ProcessKind, name: &str, source: u16) -> &mut Health {
        let health = Health {
            incarnation: 100 * S as u64,
            source,
            kind: kind as u8,
            life: LifeState::Running as u8,
            ..Health::default()
        }
        .with_name(name);
        let same = |said: &Health| (said.kind, said.name, said.source) == (health.kind, health.name, health.source);
        let index = self.health.iter().position(same).unwrap_or_else(|| {
            self.health.push(health);
            self.health.len() - 1
        });
        &mut self.health[index]
    }

    /// Time passes, and all speak.
    fn pass(&mut self, seconds: i64) {
        for _ in 0..seconds * S / STEP_NS {
            self.bench.pass(STEP_NS);
            let now_ns = self.bench.clock.get().mono_ns;
            for health in &self.health {
                self.bench.send_health(Health {
                    said_ns: now_ns,
                    ..*health
                });
            }
            let _ = self.bench.turn();
            let (last, events) = (&mut self.last, &mut self.events);
            self.alarms
                .take(usize::MAX, |_, slice| {
                    *last = slice.to_vec();
                    let changes = slice.iter().filter(|alarm| alarm.event() != Some(AlarmEvent::Standing));
                    events.extend(changes.map(|alarm| {
                        let kind = AlarmKind::from_code(alarm.code).unwrap();
                        (kind, alarm.event().unwrap())
                    }));
                })
                .unwrap();
        }
    }

    /// Sentences of the alarms in the last slice, each of them whole.
    fn standing(&self) -> Vec<String> {
        for alarm in &self.last {
            assert!(!alarm.text().contains(['{', '}']), "{}", alarm.text());
        }
        self.last.iter().map(|alarm| alarm.text().to_owned()).collect()
    }

    /// Raises by `begin`, and clears by `end`; the sentence. Whatever else was raised is a mistake.
    #[track_caller]
    fn raise_and_clear(&mut self, kind: AlarmKind, begin: impl Fn(&mut Self), end: impl Fn(&mut Self)) -> String {
        self.pass(1);
        assert_eq!(self.events, [], "nothing is wrong yet");
        begin(self);
        self.pass(kind.raise_after_ns() / S + 1);
        let [said] = &self.standing()[..] else {
            panic!("{:?}", self.standing())
        };
        end(self);
        self.pass(kind.clear_after_ns() / S + 2);
        assert_eq!(self.events, [(kind, AlarmEvent::Raised), (kind, AlarmEvent::Cleared)]);
        assert_eq!(self.standing(), [""; 0]);
        said.clone()
    }
}

/// Counter of a process that grows for a while.
#[track_caller]
fn growing(kind: AlarmKind, process: (ProcessKind, &str, u16), counter: Counter) -> String {
    let mut site = Site::new(&["source[3].silent_periods=0"]);
    let (of, name, source) = process;
    site.say(of, name, source);
    let begin = |site: &mut Site| site.say(of, name, source).counters[counter] = 1_234;
    site.raise_and_clear(kind, begin, |_| {})
}

#[test]
fn what_is_lost_dropped_or_does_not_fit_is_told() {
    let fusion = (ProcessKind::Fusion, "fusion", 3);
    assert_eq!(
        growing(AlarmKind::SamplesLost, fusion, Counter::Lost),
        "fusion has lost 1,234 samples of ads-b: fusion fell behind, or a connection between hosts was interrupted."
    );
    let recorder = (ProcessKind::Recorder, "recorder", NO_SOURCE);
    assert_eq!(
        growing(AlarmKind::RecordingIncomplete, recorder, Counter::RecordedLost),
        "The recording of recorder lacks 1,234 samples: it fell behind."
    );
    assert_eq!(
        growing(AlarmKind::RecordingFailed, recorder, Counter::RecordingFailures),
        "recorder cannot write its recording: 1,234 attempts failed (standard error has the cause)."
    );
    let link = (ProcessKind::Link, "in", NO_SOURCE);
    assert_eq!(
        growing(AlarmKind::LostOnTheWay, link, Counter::LostOnTheWay),
        "1,234 samples of another host did not reach link in: the connection was interrupted or is too slow."
    );
    assert_eq!(
        growing(AlarmKind::ReportQuarantined, fusion, Counter::Quarantined),
        "fusion died twice while processing the same report of a source, and skips this report: 1,234 reports so far."
    );
    assert_eq!(
        growing(AlarmKind::CapacityReached, fusion, Counter::DroppedTable),
        "fusion had no room for 1,234 reports of ads-b."
    );
    assert_eq!(
        growing(AlarmKind::LayoutMismatch, fusion, Counter::RejectedSchema),
        "fusion has rejected 1,234 slices of a publisher with another layout."
    );
    let adapter = (ProcessKind::Adapter, "ads-b", NO_SOURCE);
    assert_eq!(
        growing(AlarmKind::DatagramsDropped, adapter, Counter::DatagramsDropped),
        "The kernel dropped 1,234 datagrams before adapter ads-b read them."
    );
    let gateway = (ProcessKind::Gateway, "display", NO_SOURCE);
    assert_eq!(
        growing(AlarmKind::SendFailed, gateway, Counter::SendFailures),
        "gateway display could not send 1,234 datagrams."
    );
}

#[test]
fn what_fits_nothing_that_is_configured_is_named() {
    let quiet: Vec<String> = (0..5)
        .map(|number| format!("source[{number}].silent_periods=0"))
        .collect();
    let quiet: Vec<&str> = quiet.iter().map(String::as_str).collect();
    let mut site = Site::new(&quiet);
    let stranger = |site: &mut Site| {
        let health = site.say(ProcessKind::Adapter, "radar-west", NO_SOURCE);
        health.misfit = [40, 2, 0, 0];
        let whole = &mut health.counters;
        whole[Counter::UnknownSenderBlocks] = 24;
        whole[Counter::UnknownSenders] = 3;
        whole[Counter::RejectedSource] = 30;
    };
    assert_eq!(
        site.raise_and_clear(AlarmKind::SenderUnknown, stranger, |_| {}),
        "adapter radar-west receives data from senders without a configured source: SAC/SIC 40/2, 24 blocks, and 2 others."
    );
    let mut site = Site::new(&quiet);
    let other_edition = |site: &mut Site| {
        let health = site.say(ProcessKind::Adapter, "ads-b", 3);
        health.misfit = [21, 2, 4, 0];
        health.counters[Counter::BlocksOfOtherEdition] = 142;
    };
    assert_eq!(
        site.raise_and_clear(AlarmKind::EditionWrong, other_edition, |_| {}),
        "142 blocks of ads-b do not fit the configured edition, but fit category 021 edition 2.4."
    );
}

#[test]
fn a_source_whose_clock_is_wild_is_told() {
    let mut site = Site::new(&[]);
    site.say(ProcessKind::Fusion, "fusion", 2);
    let wild = |site: &mut Site, wild, taken| {
        let counters = &mut site.say(ProcessKind::Fusion, "fusion", 2).counters;
        (counters[Counter::RejectedClock], counters[Counter::Taken]) = (wild, taken);
    };
    // A sensor's hiccup, and the late reports of a centre.
    wild(&mut site, 1, 30);
    site.pass(2);
    wild(&mut site, 20, 1_000);
    site.pass(2);
    assert_eq!(site.events, []);
    let last_minute = |site: &mut Site| site.pass(60);
    assert_eq!(
        site.raise_and_clear(AlarmKind::SourceIsolated, |site| wild(site, 31, 1_100), last_minute),
        "multilateration is isolated: 2.8 % of its reports of the last minute (31 of 1,100 reports) have impossible times \
         and are not used."
    );
    // An hour of good ones does not excuse those that follow.
    wild(&mut site, 31, 1_000_000);
    site.pass(70);
    wild(&mut site, 61, 1_001_000);
    site.pass(1);
    assert_eq!(site.standing().len(), 1);
}

#[test]
fn reports_that_come_too_late_are_told() {
    let mut site = Site::new(&["source[3].silent_periods=0"]);
    let late = |site: &mut Site, late, used| {
        let counters = &mut site.say(ProcessKind::Adapter, "ads-b", NO_SOURCE).counters;
        (counters[Counter::RejectedLate], counters[Counter::Reports]) = (late, used);
    };
    late(&mut site, 9, 1_000);
    let last_minute = |site: &mut Site| site.pass(60);
    assert_eq!(
        site.raise_and_clear(AlarmKind::ReportsLate, |site| late(site, 230, 1_770), last_minute),
        "ads-b sends late: 11.5 % of its reports of the last minute (230 of 2,000 reports) arrived after later reports and are \
         not used."
    );
}

#[test]
fn stuck_alerts_are_told_for_a_while() {
    let mut site = Site::new(&["source[3].silent_periods=0"]);
    let stuck = |site: &mut Site| {
        site.say(ProcessKind::Adapter, "ads-b", NO_SOURCE).counters[Counter::AdvisoriesStuck] = 2;
    };
    site.say(ProcessKind::Adapter, "ads-b", NO_SOURCE);
    assert_eq!(
        site.raise_and_clear(AlarmKind::AlertStuck, stuck, |site| site.pass(700)),
        "2 targets of ads-b set the bit of an ACAS resolution advisory for more than 2 min without the advisory's text \
         (last 10 min). Fusion does not show this as an alert."
    );
}

#[test]
fn false_positions_are_told() {
    let mut site = Site::new(&["source[3].silent_periods=0"]);
    let rejected = |site: &mut Site, rejected, taken| {
        let counters = &mut site.say(ProcessKind::Fusion, "fusion", 3).counters;
        (counters[Counter::RejectedFalsePosition], counters[Counter::Taken]) = (rejected, taken);
    };
    rejected(&mut site, 0, 1_000);
    let last_minute = |site: &mut Site| site.pass(61);
    assert_eq!(
        site.raise_and_clear(AlarmKind::PositionFalse, |site| rejected(site, 40, 3_000), last_minute),
        "ads-b gives false positions of single targets: other sources measured the same targets elsewhere in 40 of 3,000 \
         reports of the last minute (1.3 %)."
    );
}

#[test]
fn a_tracker_that_makes_no_tracks_of_many_detections_is_told() {
    let mut site = Site::new(&["source[3].silent_periods=0"]);
    let work = |site: &mut Site, detections, scans, reports| {
        let counters = &mut site.say(ProcessKind::Adapter, "ads-b", NO_SOURCE).counters;
        (counters[Counter::Detections], counters[Counter::Scans]) = (detections, scans);
        (counters[Counter::Published], counters[Counter::ScanPeriodMs]) = (reports, 1_000);
    };
    // Few detections, and then a tracker that has only begun.
    work(&mut site, 100, 60, 0);
    site.pass(2);
    work(&mut site, 600, 9, 0);
    let tracks = |site: &mut Site| work(site, 3_500, 1_620, 170);
    assert_eq!(
        site.raise_and_clear(AlarmKind::TrackerIdle, |site| work(site, 3_456, 1_610, 3), tracks),
        "The tracker of ads-b made 3 reports of tracks from its last 3,456 detections, in 1,610 scans of 1.00 s."
    );
}

#[test]
fn a_recorded_source_has_made_more_tracks_than_are_due() {
    let mut site = Site::new(&["source[3].silent_periods=0"]);
    let work = |site: &mut Site, ahead| {
        let counters = &mut site.say(ProcessKind::Adapter, "ads-b", NO_SOURCE).counters;
        (counters[Counter::Detections], counters[Counter::Scans]) = (7_216, 905);
        (counters[Counter::Published], counters[Counter::ReportsAhead]) = (1, ahead);
    };
    work(&mut site, 128);
    site.pass(2);
    assert_eq!(site.standing(), [""; 0]);
    // The duration of a turn is not known.
    work(&mut site, 9);
    site.pass(1);
    assert_eq!(
        site.standing(),
        ["The tracker of ads-b made 10 reports of tracks from its last 7,216 detections, in 905 scans."]
    );
}

#[test]
fn what_had_been_counted_before_the_monitor_came_is_no_news() {
    let mut site = Site::new(&[]);
    let fusion = site.say(ProcessKind::Fusion, "fusion", 3);
    fusion.incarnation = 1;
    fusion.counters[Counter::Lost] = 7;
    site.pass(3);
    assert_eq!(site.standing(), [""; 0]);
    site.say(ProcessKind::Fusion, "fusion", 3).counters[Counter::Lost] = 8;
    site.pass(1);
    assert_eq!(site.standing().len(), 1);
}

#[test]
fn a_source_is_silent_after_some_of_its_own_periods() {
    let mut site = Site::new(&[]);
    let records =
        |site: &mut Site, count| site.say(ProcessKind::Adapter, "radar-west", 0).counters[Counter::Records] = count;
    records(&mut site, 5);
    site.pass(20);
    assert_eq!(site.standing(), [""; 0], "five periods of 4 s");
    site.pass(1);
    assert_eq!(
        site.standing(),
        ["radar-west has sent nothing for 20 s, 5 of its periods."]
    );
    site.pass(10);
    assert_eq!(
        site.standing(),
        ["radar-west has sent nothing for 30 s, 7 of its periods."]
    );
    records(&mut site, 6);
    site.pass(1);
    let (raised, cleared) = (AlarmEvent::Raised, AlarmEvent::Cleared);
    assert_eq!(
        site.events,
        [(AlarmKind::SourceSilent, raised), (AlarmKind::SourceSilent, cleared)]
    );
}

#[test]
fn a_source_whose_data_are_refused_is_not_silent() {
    let mut site = Site::new(&[]);
    let refuse = |site: &mut Site, count| {
        let health = site.say(ProcessKind::Adapter, "radar-west", 0);
        health.counters[Counter::BlocksRejected] = count;
        *health = health.with_refusal("07:08:09: line 2, column px: \"\" is empty; write a number");
    };
    for count in 1..=30 {
        refuse(&mut site, count);
        site.pass(1);
    }
    assert_eq!(
        site.standing(),
        [
            "radar-west: 10 of 10 items of the last 10 s were refused. 07:08:09: line 2, column px: \"\" is empty; write a number"
        ]
    );
    // Then nothing comes any more.
    site.pass(32);
    assert_eq!(
        site.standing(),
        ["radar-west has sent nothing for 23 s, 5 of its periods."]
    );
}

#[test]
fn a_source_of_whose_reports_fusion_uses_none_is_told_with_the_reason() {
    let mut site = Site::new(&[]);
    let far = |site: &mut Site, far, taken| {
        let counters = &mut site.say(ProcessKind::Fusion, "fusion", 2).counters;
        (counters[Counter::RejectedTooFar], counters[Counter::Taken]) = (far, taken);
    };
    // One in two, then all of them.
    far(&mut site, 50, 100);
    site.pass(2);
    assert_eq!(site.events, []);
    far(&mut site, 50, 100);
    site.pass(20);
    far(&mut site, 90, 140);
    site.pass(1);
    assert!(
        site.standing().iter().any(|text| text.starts_with(
            "multilateration: 40 of 40 reports of the last 10 s were refused. Reports further from their sensor than \
             `limits.range_m`."
        )),
        "{:?}",
        site.standing()
    );
    // Reports that an order keeps out are not refused.
    let mut site = Site::new(&[]);
    let counters = &mut site.say(ProcessKind::Fusion, "fusion", 2).counters;
    (counters[Counter::RejectedByOrder], counters[Counter::Taken]) = (40, 40);
    site.pass(1);
    assert_eq!(site.events, []);
}

#[test]
fn a_source_may_be_allowed_to_be_silent() {
    let mut site = Site::new(&["source[0].silent_periods=0"]);
    site.say(ProcessKind::Adapter, "radar-west", 0);
    site.pass(100);
    assert_eq!(site.standing(), [""; 0]);
}

#[test]
fn errors_that_fusion_has_learned_are_told() {
    let known = |site: &mut Site, registration| {
        site.say(ProcessKind::Fusion, "fusion", 3).registration = registration;
    };
    let clock_off = Registration {
        clock_offset_s: -29.75,
        clock_offset_sigma_s: 0.25,
        ..Registration::default()
    };
    let mut site = Site::new(&[]);
    let begin = |site: &mut Site| known(site, clock_off);
    let end = |site: &mut Site| known(site, Registration::default());
    assert_eq!(
        site.raise_and_clear(AlarmKind::ClockOff, begin, end),
        "The clock of ads-b is -29.75 s off, compared with the times of receipt of its reports."
    );
    // As the adapter of a live source has it: it is a little late, as all are.
    let mut site = Site::new(&["source[3].silent_periods=0"]);
    let judged = |site: &mut Site, clock_offset_s| {
        site.say(ProcessKind::Adapter, "ads-b", 3).registration = Registration {
            clock_offset_s,
            clock_offset_sigma_s: 0.1,
            ..Registration::default()
        };
    };
    judged(&mut site, -1.1);
    site.pass(10);
    let (ahead, again) = (
        |site: &mut Site| judged(site, 1.3),
        |site: &mut Site| judged(site, -0.3),
    );
    let said = site.raise_and_clear(AlarmKind::ClockOff, ahead, again);
    assert!(said.contains("+1.30 s off"), "{said}");
    let overstated = Registration {
        covariance_inflation: 9.0,
        ..Registration::default()
    };
    let mut site = Site::new(&[]);
    let begin = |site: &mut Site| known(site, overstated);
    assert_eq!(
        site.raise_and_clear(AlarmKind::AccuracyOverstated, begin, end),
        "The accuracy of ads-b is overstated: its covariances are enlarged 9.0 times."
    );
}

#[test]
fn an_offset_that_sources_share_is_the_machines() {
    let of_sources = |site: &mut Site, offsets_s: [f64; 2]| {
        for (number, offset_s) in [(1, offsets_s[0]), (3, offsets_s[1])] {
            site.say(ProcessKind::Fusion, "fusion", number).registration = Registration {
                clock_offset_s: offset_s,
                clock_offset_sigma_s: 0.1,
                ..Registration::default()
            };
        }
    };
    let of_fusion = |site: &mut Site, offset_s| {
        let said = site.say(ProcessKind::Fusion, "fusion", NO_SOURCE);
        said.registration.clock_offset_s = offset_s;
    };
    let mut site = Site::new(&[]);
    let begin = |site: &mut Site| {
        of_fusion(site, 6.0);
        of_sources(site, [5.9, 6.1]);
    };
    let end = |site: &mut Site| {
        of_fusion(site, 0.0);
        of_sources(site, [0.0, -0.1]);
    };
    let said = site.raise_and_clear(AlarmKind::MachineClockOff, begin, end);
    assert_eq!(
        said,
        "This machine's clock is -6.0 s off: the clocks of radar-east, ads-b agree with each other, but not with this machine."
    );
    // Below the limit from which fusion takes it off; no single source is blamed.
    let mut site = Site::new(&[]);
    of_sources(&mut site, [3.0, 3.2]);
    site.pass(10);
    assert!(matches!(&site.standing()[..], [said] if said.starts_with("This machine's clock is -3.")));
    // One alone shows nothing but a difference.
    let mut site = Site::new(&[]);
    site.say(ProcessKind::Fusion, "fusion", 3).registration = Registration {
        clock_offset_s: 30.0,
        clock_offset_sigma_s: 0.1,
        ..Registration::default()
    };
    of_fusion(&mut site, 30.0);
    site.pass(10);
    assert!(matches!(&site.standing()[..], [said] if said.starts_with("The clocks of ads-b and of this machine")));
}

#[test]
fn a_gross_error_is_told_with_what_to_correct() {
    let error = Bias {
        kind: BiasKind::Azimuth,
        value: [-0.00925, 0.0],
        partner: 3,
        is_certain: false,
        is_removed: false,
    };
    let told = |is_certain, is_removed| {
        let mut site = Site::new(&[]);
        let known = |site: &mut Site, error| {
            let said = site.say(ProcessKind::Fusion, "fusion", 0);
            said.registration.set_gross_error(error, None);
        };
        let error = Bias {
            is_certain,
            is_removed,
            ..error
        };
        let (begin, end) = (
            |site: &mut Site| known(site, Some(error)),
            |site: &mut Site| known(site, None),
        );
        site.raise_and_clear(AlarmKind::GrossError, begin, end)
    };
    let sentence = "radar-west has a bias of -0.53° in azimuth relative to the tracks of ads-b";
    assert_eq!(
        told(false, false),
        format!("{sentence}; or ads-b is off the other way.")
    );
    assert_eq!(told(true, false), format!("{sentence}."));
    assert_eq!(told(true, true), format!("{sentence}, and that is taken off."));
}

#[test]
fn a_source_beside_a_majority_is_named_and_of_two_alone_both() {
    let error = |is_certain| Bias {
        kind: BiasKind::Position,
        value: [4.0, 150.0],
        partner: 3,
        is_certain,
        is_removed: is_certain,
    };
    let told = |kind, is_certain| {
        let mut site = Site::new(&[]);
        let known = |site: &mut Site, error| {
            let said = site.say(ProcessKind::Fusion, "fusion", 0);
            said.registration.set_gross_error(None, error);
        };
        let (begin, end) = (
            |site: &mut Site| known(site, Some(error(is_certain))),
            |site: &mut Site| known(site, None),
        );
        site.raise_and_clear(kind, begin, end)
    };
    assert_eq!(
        told(AlarmKind::SourceOff, true),
        "radar-west is off by +4 m east and +150 m north: the reference or a majority, with ads-b, shows it; fusion \
         removes it."
    );
    assert_eq!(
        told(AlarmKind::SourcesContradict, false),
        "radar-west and ads-b contradict each other: radar-west is off by +4 m east and +150 m north relative to \
         ads-b, and no other source decides."
    );
}

#[test]
fn a_bias_that_changes_is_told_once_it_was_known() {
    let known = |site: &mut Site, range_bias_m, comparisons| {
        site.say(ProcessKind::Fusion, "fusion", 0).registration = Registration {
            comparisons,
            range_bias_m,
            range_bias_sigma_m: 3.0,
            ..Registration::default()
        };
    };
    let mut site = Site::new(&[]);
    known(&mut site, 500.0, 10.0);
    site.pass(20);
    known(&mut site, 12.0, 900.0);
    site.pass(20);
    assert_eq!(site.events, [], "it was not known before");
    known(&mut site, 30.0, 900.0);
    site.pass(20);
    assert_eq!(site.events, [], "that may be chance");
    let begin = |site: &mut Site| known(site, -90.0, 900.0);
    let end = |site: &mut Site| known(site, 12.0, 900.0);
    let said = site.raise_and_clear(AlarmKind::BiasChanged, begin, end);
    assert!(
        said.starts_with("The range bias of radar-west has changed from +1") && said.ends_with(" m to -90.00 m."),
        "{said}"
    );
}

#[test]
fn a_source_that_sees_less_than_before_is_told() {
    let sees = |site: &mut Site, taken, permille| {
        let counters = &mut site.say(ProcessKind::Fusion, "fusion", 1).counters;
        (counters[Counter::Taken], counters[Counter::DetectionPermille]) = (taken, permille);
    };
    let mut site = Site::new(&[]);
    sees(&mut site, 0, 900);
    site.pass(2);
    sees(&mut site, 1_000, 700);
    site.pass(60);
    sees(&mut site, 5_000, 950);
    site.pass(2);
    assert_eq!(site.events, [], "what it usually sees had to be learned first");
    let begin = |site: &mut Site| sees(site, 6_000, 700);
    let end = |site: &mut Site| sees(site, 7_000, 940);
    assert_eq!(
        site.raise_and_clear(AlarmKind::DetectionFell, begin, end),
        "radar-east detects its targets in 70 % of its scans, 95 % before."
    );
}

/// Ninety seconds of targets that two sources show apart.
fn apart(site: &mut Site) {
    for second in 0..90_i64 {
        let now = site.bench.clock.get();
        let mut states = Vec::new();
        for number in 0..6_u32 {
            let (heading, seconds) = (f64::from(number), second as f64);
            let velocity = [200.0 * heading.cos(), 200.0 * heading.sin()];
            for (source, east_m) in [(0, 0.0), (1, 9_000.0)] {
                let mut track = SystemTrack {
                    track_number: 10 * number + u32::from(source),
                    reference_time_ns: now.utc_ns,
                    state: TrackState::Confirmed.code(),
                    position_m: [
                        f64::from(number) * 3_000.0 + east_m + velocity[0] * seconds,
                        velocity[1] * seconds,
                        9_000.0,
                    ],
                    velocity_mps: [velocity[0], velocity[1], 0.0],
                    contribution_count: 1,
                    ..SystemTrack::default()
                };
                track.contributions[0].source = source;
                states.push(track);
            }
        }
        site.bench.publish(&states);
        site.pass(1);
    }
}

#[test]
fn a_bias_that_explains_the_pairs_is_told_instead_of_a_wrong_position() {
    let mut site = Site::new(&[]);
    let said = site.say(ProcessKind::Fusion, "fusion", 1);
    said.registration.set_gross_error(
        Some(Bias {
            kind: BiasKind::Azimuth,
            value: [0.03, 0.0],
            partner: 0,
            is_certain: false,
            is_removed: false,
        }),
        None,
    );
    apart(&mut site);
    assert!(
        matches!(&site.standing()[..], [told] if told.starts_with("radar-east has a bias of +1.72° in azimuth")),
        "{:?}",
        site.standing()
    );
}

#[test]
fn sources_that_see_the_same_and_never_join_are_told() {
    let mut site = Site::new(&[]);
    apart(&mut site);
    let text = "radar-west and radar-east have no common track, but 6 tracks of each move in parallel, all +9.0 km east and \
                +0.0 km north apart.";
    assert_eq!(site.standing(), [text]);
    assert_eq!((site.last[0].source, site.last[0].partner), (0, 1));
    // They are gone.
    site.pass(80);
    assert_eq!(site.standing(), [""; 0]);
}

#[test]
fn states_that_are_off_the_clock_are_told() {
    // Half a minute of states whose newest are so far off, and of others that are older; the silence of sources that
    // nobody speaks for here is not asked for. Half a second passes before the monitor takes them.
    let states = |site: &mut Site, off_ms: i64| {
        for _ in 0..30 {
            let utc_ns = site.bench.clock.get().utc_ns;
            let state = |track_number, off_ms: i64| SystemTrack {
                track_number,
                reference_time_ns: utc_ns + off_ms * S / 1_000,
                state: TrackState::Confirmed.code(),
                ..SystemTrack::default()
            };
            site.bench.publish(&[state(1, off_ms), state(2, off_ms - 20_000)]);
            site.pass(1);
        }
        site.standing()
    };
    let none: [String; 0] = [];
    let mut site = Site::new(&[]);
    assert_eq!(states(&mut site, -200), none, "on their way");
    assert_eq!(
        states(&mut site, 7_800),
        ["The newest system tracks are +7.3 s off this machine's clock."]
    );
    assert_eq!(states(&mut site, -200), none);
    // Every source takes a period to send what it has measured, and the quickest here a second.
    assert_eq!(states(&mut site, -3_000), none);
    assert_eq!(
        states(&mut site, -7_500),
        ["The newest system tracks are -8.0 s off this machine's clock."]
    );
    let mut lenient = Site::new(&["monitor.alarms.data_off_s=8"]);
    assert_eq!(states(&mut lenient, 7_800), none);
    assert_eq!(states(&mut lenient, 8_800).len(), 1);
}

#[test]
fn processes_that_end_and_come_back_are_told() {
    let launched = |site: &mut Site, life: LifeState, restarts, note: &str| {
        let child = site.say(ProcessKind::Launcher, "fusion", NO_SOURCE);
        *child = Health {
            life: life as u8,
            restarts,
            ..child.with_note(note)
        };
    };
    let mut site = Site::new(&[]);
    launched(&mut site, LifeState::Running, 0, "");
    site.pass(1);
    launched(&mut site, LifeState::Failed, 0, "was killed by SIGKILL");
    site.pass(2);
    assert_eq!(site.standing(), ["fusion does not run: was killed by SIGKILL."]);
    launched(&mut site, LifeState::Running, 1, "was killed by SIGKILL");
    site.pass(7);
    let restarted = "fusion was restarted, 1 time so far: the last process was killed by SIGKILL.";
    assert_eq!(site.standing(), [restarted]);
    site.pass(62);
    assert_eq!(site.standing(), [""; 0]);
}

#[test]
fn a_rebuilt_deployment_is_told_by_the_monitor_that_comes_after_it() {
    let mut site = Site::new(&[]);
    site.say(ProcessKind::Launcher, "launcher", NO_SOURCE).counters[Counter::Rebuilds] = 1;
    site.pass(1);
    let text = "The shared memory was corrupt; the deployment was rebuilt, 1 time so far.";
    assert_eq!(site.standing(), [text]);
    site.pass(62);
    assert_eq!(site.standing(), [""; 0]);
}

#[test]
fn each_fusion_that_takes_over_is_told() {
    let mut site = Site::new(&[]);
    site.say(ProcessKind::Fusion, "fusion", NO_SOURCE);
    site.pass(1);
    assert_eq!(site.standing(), [""; 0]);
    let take_over = |site: &mut Site, second: i64, still: u64| {
        let leader = site.say(ProcessKind::Fusion, "fusion", NO_SOURCE);
        leader.incarnation = (second * S) as u64;
        leader.counters[Counter::TakeOvers] = 1;
        leader.counters[Counter::TakeOversFromStill] = still;
        site.pass(1);
        site.standing()
    };
    let said = |words: &str| {
        [format!(
            "The standby fusion process has taken over, {words} because the active process did not advance."
        )]
    };
    assert_eq!(take_over(&mut site, 101, 0), said("1 time so far, 0"));
    site.pass(62);
    assert_eq!(site.standing(), [""; 0]);
    assert_eq!(take_over(&mut site, 170, 1), said("2 times so far, 1"));
}

#[test]
fn a_link_that_misses_a_peer_or_hears_a_wrong_clock_is_told() {
    let link = "name = \"in\"\nconnect = [\"tcp/127.0.0.1:7447\"]\n";
    let mut site = Site::new(&[&format!("link=[{{{}}}]", link.trim().replace('\n', ", "))]);
    let say = |site: &mut Site, missing: u64, off_us: u64, note: &str| {
        let said = site.say(ProcessKind::Link, "in", NO_SOURCE);
        said.counters[Counter::MissingPeers] = missing;
        said.counters[Counter::HostClockOffUs] = off_us;
        *said = said.with_note(note);
    };
    say(&mut site, 0, 19_000, "west 1.0 ms away");
    site.pass(5);
    assert_eq!(site.standing(), [""; 0]);
    say(&mut site, 1, 0, "west is not there");
    site.pass(5);
    let missing = "link in does not receive from all configured peers: west is not there.";
    assert_eq!(site.standing(), [missing]);
    say(&mut site, 0, 30_000, "west 1.0 ms away");
    site.pass(5);
    let off = "The clock of another host is 30 ms off, as compared by link in: west 1.0 ms away.";
    assert_eq!(site.standing(), [off]);
}

#[test]
fn a_certificate_of_a_link_that_ends_soon_is_told_until_it_is_renewed() {
    let link = "name = \"in\"\nconnect = [\"tcp/127.0.0.1:7447\"]\n";
    let mut site = Site::new(&[&format!("link=[{{{}}}]", link.trim().replace('\n', ", "))]);
    let say = |site: &mut Site, expiring: u64, note: &str| {
        let said = site.say(ProcessKind::Link, "in", NO_SOURCE);
        said.counters[Counter::ExpiringCertificates] = expiring;
        *said = said.with_note(note);
    };
    say(&mut site, 1, "certificate expires on 2026-12-24");
    site.pass(2);
    let ends = "A certificate of link in ends within 30 days, or has ended: certificate expires on 2026-12-24.";
    assert_eq!(site.standing(), [ends]);
    say(&mut site, 0, "west 1.0 ms away");
    site.pass(12);
    assert_eq!(site.standing(), [""; 0]);
}

#[test]
fn a_process_that_says_nothing_any_more_hangs() {
    let mut site = Site::new(&[]);
    let silent = |site: &mut Site| site.health.clear();
    let speaks = |site: &mut Site| {
        site.say(ProcessKind::Fusion, "fusion", NO_SOURCE);
    };
    speaks(&mut site);
    site.pass(1);
    silent(&mut site);
    site.pass(3);
    assert_eq!(site.standing(), [""; 0]);
    site.pass(1);
    assert_eq!(site.standing(), ["fusion has published no health for 4 s."]);
    speaks(&mut site);
    site.pass(3);
    assert_eq!(site.standing(), [""; 0]);
    silent(&mut site);
    // The machine stood still: nobody could say anything, and the monitor could not listen.
    site.bench.pass(60 * S);
    site.pass(2);
    assert_eq!(site.standing(), [""; 0]);
}

#[test]
fn a_guest_that_has_left_does_not_hang() {
    let mut child = std::process::Command::new("true").spawn().unwrap();
    child.wait().unwrap();
    let mut site = Site::new(&[]);
    for (name, pid) in [("left", child.id()), ("here", std::process::id())] {
        site.say(ProcessKind::Display, name, NO_SOURCE).process_id = pid;
    }
    site.pass(1);
    site.health.clear();
    site.pass(5);
    assert_eq!(site.standing(), ["display here has published no health for 5 s."]);
}

#[test]
fn an_ordered_stop_raises_no_alarm() {
    let mut site = Site::new(&["source[3].silent_periods=0"]);
    site.say(ProcessKind::Fusion, "fusion", NO_SOURCE);
    site.say(ProcessKind::Launcher, "launcher", NO_SOURCE);
    site.pass(1);
    site.say(ProcessKind::Launcher, "launcher", NO_SOURCE).counters[Counter::Stopping] = 1;
    site.health
        .retain(|health| health.kind() == Some(ProcessKind::Launcher));
    site.pass(10);
    assert_eq!(site.events, []);
}

#[test]
fn room_that_runs_out_is_told() {
    let mut site = Site::new(&["recorder.enabled=true", "monitor.alarms.disk_free_mb=1e9"]);
    site.pass(4);
    let [said] = &site.standing()[..] else {
        panic!("{:?}", site.standing())
    };
    assert!(said.contains(" MB are left on the disk of "), "{said}");
    let mut site = Site::new(&["monitor.alarms.memory_free_mb=1e9"]);
    site.pass(4);
    assert_eq!(
        site.standing().len(),
        2,
        "the machine's memory, and the shared memory: {:?}",
        site.standing()
    );
}

#[test]
fn alarms_are_said_once_in_the_log_and_stand_in_the_report() {
    let mut site = Site::new(&["monitor.files=true"]);
    site.say(ProcessKind::Gateway, "display", NO_SOURCE);
    site.pass(2);
    site.say(ProcessKind::Gateway, "display", NO_SOURCE).counters[Counter::SendFailures] = 3;
    site.pass(20);
    let text = "gateway display could not send 3 datagrams.";
    let said = site.bench.errors();
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines.len(), 2, "{said}");
    assert!(
        lines[0].starts_with(&format!("koseki: alarm, major: {text} Check the")),
        "{said}"
    );
    assert_eq!(lines[1], format!("koseki: alarm cleared: {text}"));
    for life in site.health.iter_mut() {
        life.life = LifeState::Finished as u8;
    }
    site.pass(1);
    let report = site.bench.close();
    assert!(
        report.contains("ALARMS that were raised, and what to do\nmajor ("),
        "{report}"
    );
    let alarm = &site.bench.report()["alarms"][0];
    assert_eq!((&alarm["alarm"], &alarm["times"]), (&"send-failed".into(), &1.into()));
    assert!(alarm["cleared_utc_ns"].as_i64() > alarm["raised_utc_ns"].as_i64());
}

#[test]
fn a_monitor_beside_the_first_one_keeps_its_alarms_to_itself() {
    let bench = Bench::new(&[]);
    let mut alarms: Subscriber<InProcess, Alarm> = bench.bus.subscriber(&messages::alarms(), || 1).unwrap();
    let mut second = bench.second_monitor("second");
    bench.pass(S);
    let _ = runtime::Agent::turn(&mut second, bench.clock.get()).unwrap();
    assert_eq!(alarms.take(usize::MAX, |_, _| {}).unwrap(), 0);
}

#[test]
fn limits_of_alarms_follow_their_keys() {
    let clock_off = Registration {
        clock_offset_s: -29.75,
        clock_offset_sigma_s: 0.25,
        ..Registration::default()
    };
    let overstated = Registration {
        covariance_inflation: 9.0,
        ..Registration::default()
    };
    for (kind, key, registration) in [
        (AlarmKind::ClockOff, "monitor.alarms.clock_off_s=60", clock_off),
        (AlarmKind::AccuracyOverstated, "monitor.alarms.inflation=20", overstated),
    ] {
        let raised = |overrides: &[&str]| {
            let mut site = Site::new(overrides);
            site.say(ProcessKind::Fusion, "fusion", 3).registration = registration;
            site.pass(kind.raise_after_ns() / S + 1);
            site.standing().len()
        };
        assert_eq!((raised(&[]), raised(&[key])), (1, 0), "{key}");
    }
    let mut site = Site::new(&["monitor.alarms.process_silent_s=10"]);
    site.say(ProcessKind::Fusion, "fusion", NO_SOURCE);
    site.pass(1);
    site.health.clear();
    site.pass(9);
    assert_eq!(site.standing(), [""; 0]);
    site.pass(3);
    assert_eq!(site.standing().len(), 1);
}

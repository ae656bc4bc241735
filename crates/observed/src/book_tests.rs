//! Checks of the book of health messages.

use proptest::prelude::*;
use test_support::S;

use super::*;

fn health(kind: ProcessKind, name: &str, incarnation: u64, said_ns: i64) -> Health {
    Health {
        kind: kind as u8,
        incarnation,
        said_ns,
        life: LifeState::Running as u8,
        ..Health::default()
    }
    .with_name(name)
}

fn counting(mut health: Health, taken: u64) -> Health {
    health.counters[Counter::Taken] = taken;
    health
}

fn only(book: &HealthBook, now_ns: i64) -> ObservedProcess {
    let mut processes = book.processes(&[], now_ns);
    assert_eq!(processes.len(), 1);
    processes.remove(0)
}

#[test]
fn counters_survive_a_restart_and_late_words_of_the_dead_change_nothing() {
    let mut book = HealthBook::new(2, i64::MAX);
    let said =
        |incarnation, said_s, taken| counting(health(ProcessKind::Fusion, "fusion", incarnation, said_s * S), taken);
    for health in [said(10, 1, 3), said(10, 2, 5), said(20, 4, 2), said(10, 3, 4)] {
        book.take(&health);
    }
    assert_eq!(book.service(ProcessKind::Fusion, NO_SOURCE)[Counter::Taken], 7);
    assert_eq!(only(&book, 4 * S).restarts, 1);
}

#[test]
fn a_process_that_takes_over_the_name_of_a_younger_one_is_heard_and_is_no_restart() {
    let mut book = HealthBook::new(0, i64::MAX);
    // A standby has the name of a standby until it leads; it started before the leader.
    book.take(&health(ProcessKind::Fusion, "standby", 20, S));
    for second in 2..5 {
        book.take(&health(ProcessKind::Fusion, "fusion", 20, second * S));
        book.take(&health(ProcessKind::Fusion, "standby", 10, second * S));
    }
    book.take(&Health {
        restarts: 0,
        ..health(ProcessKind::Launcher, "standby", 1, S)
    });
    let standby = |book: &HealthBook, now_s: i64| {
        let processes = book.processes(&[], now_s * S);
        processes.into_iter().find(|process| process.name == "standby").unwrap()
    };
    assert_eq!(standby(&book, 4).state, ProcessState::Life(LifeState::Running));
    assert_eq!(standby(&book, 4).restarts, 0);
    // Take-over.
    for second in 5..9 {
        book.take(&health(ProcessKind::Fusion, "fusion", 10, second * S));
    }
    let fusion = book
        .processes(&[], 8 * S)
        .into_iter()
        .find(|process| process.name == "fusion");
    assert_eq!(fusion.unwrap().state, ProcessState::Life(LifeState::Running));
}

#[test]
fn the_launchers_count_of_restarts_is_shown_with_the_reason() {
    let mut book = HealthBook::new(2, i64::MAX);
    book.take(&health(ProcessKind::Adapter, "radar", 10, S));
    let of_child = Health {
        restarts: 3,
        source: 1,
        ..health(ProcessKind::Launcher, "radar", 1, S)
    };
    book.take(&of_child.with_note("was killed by SIGKILL"));
    let process = only(&book, S);
    assert_eq!(
        (process.restarts, process.last_end.as_str()),
        (3, "was killed by SIGKILL")
    );
}

#[test]
fn silence_is_shown_unless_the_process_has_ended() {
    let mut book = HealthBook::new(0, i64::MAX);
    book.take(&health(ProcessKind::Fusion, "fusion", 10, S));
    assert_eq!(only(&book, 2 * S).state, ProcessState::Life(LifeState::Running));
    assert_eq!(only(&book, 3 * S).state, ProcessState::Silent { for_ns: 2 * S });
    book.take(&Health {
        life: LifeState::Finished as u8,
        ..health(ProcessKind::Fusion, "fusion", 10, S)
    });
    assert_eq!(only(&book, 30 * S).state, ProcessState::Life(LifeState::Finished));
}

#[test]
fn expected_processes_are_listed_before_they_speak() {
    let book = HealthBook::new(0, i64::MAX);
    let processes = book.processes(&[(ProcessKind::Fusion, "fusion".to_owned())], S);
    assert_eq!(processes[0].state, ProcessState::NotHeard);
}

#[test]
fn what_cannot_be_understood_is_counted_and_ignored() {
    let mut book = HealthBook::new(2, i64::MAX);
    let good = health(ProcessKind::Fusion, "fusion", 10, S);
    book.take(&Health { kind: 77, ..good });
    book.take(&Health { life: 9, ..good });
    book.take(&Health { source: 2, ..good });
    book.take(&health(ProcessKind::Fusion, "", 10, S));
    assert_eq!(book.rejected(), 4);
    assert!(book.processes(&[], S).is_empty());
    book.take(&Health { source: 1, ..good });
    assert_eq!((book.rejected(), book.processes(&[], S).len()), (4, 1));
}

#[test]
fn no_more_than_a_maximum_of_names_is_kept() {
    let mut book = HealthBook::new(0, i64::MAX);
    for number in 0..ENTRIES_MAX + 5 {
        book.take(&health(ProcessKind::Adapter, &format!("a{number}"), 1, S));
    }
    assert_eq!((book.processes(&[], S).len(), book.rejected()), (ENTRIES_MAX, 5));
}

#[test]
fn sources_are_named_by_their_adapters_or_by_the_launcher() {
    let mut book = HealthBook::new(9, i64::MAX);
    let of_child = |name: &str, source| Health {
        source,
        process_id: 77,
        ..health(ProcessKind::Launcher, name, 1, S)
    };
    book.take(&of_child("radar", 0));
    book.take(&of_child("antenna", NO_SOURCE));
    let said = Health {
        source: 3,
        ..health(ProcessKind::Adapter, "antenna", 1, S)
    };
    book.take(&counting(said.with_note("ads-b"), 8));
    book.take(&counting(health(ProcessKind::Adapter, "radar", 1, S), 5));
    assert_eq!(
        (book.source_name(0), book.source_name(3)),
        (Some("radar"), Some("ads-b"))
    );
    assert_eq!(book.source_name(4), None);
    let taken = |source| book.adapter_of(source)[Counter::Taken];
    assert_eq!((taken(0), taken(3), taken(4)), (5, 8, 0));
}

#[test]
fn children_without_a_message_are_listed_by_the_launchers_facts() {
    let mut book = HealthBook::new(9, i64::MAX);
    let of_child = |name: &str| Health {
        process_id: 77,
        restarts: 4,
        ..health(ProcessKind::Launcher, name, 1, S).with_note("was killed by SIGKILL")
    };
    book.take(&of_child("radar"));
    book.take(&of_child("antenna"));
    let names: Vec<&str> = book.children().map(|child| child.name).collect();
    assert_eq!(names, ["radar", "antenna"], "in the launcher's order");
    let radar = &book.processes(&[], S)[0];
    assert_eq!(
        (radar.title().as_str(), radar.pid, radar.restarts),
        ("radar", Some(77), 4)
    );
    assert_eq!(radar.remark(), "the last one was killed by SIGKILL; no health message");
    book.take(&health(ProcessKind::Adapter, "radar", 1, S));
    let processes = book.processes(&[], S);
    assert_eq!(processes.len(), 2);
    assert_eq!(
        (processes[0].title().as_str(), processes[0].pid),
        ("adapter radar", Some(77))
    );
}

#[test]
fn after_a_take_over_the_process_number_is_that_of_the_leader() {
    let mut book = HealthBook::new(0, i64::MAX);
    let of = |kind, name: &str, process_id| Health {
        process_id,
        ..health(kind, name, u64::from(process_id), S)
    };
    // The child "standby" leads; the restarted child "fusion" stands by.
    book.take(&of(ProcessKind::Launcher, "fusion", 30));
    book.take(&of(ProcessKind::Launcher, "standby", 20));
    book.take(&of(ProcessKind::Fusion, "fusion", 20));
    book.take(&of(ProcessKind::Fusion, "standby", 30));
    let pids = |book: &HealthBook| {
        let processes = book.processes(&[], S);
        processes.into_iter().map(|process| process.pid).collect::<Vec<_>>()
    };
    assert_eq!(pids(&book), [Some(20), Some(30)]);
    // Until the first message of its successor, the launcher's number holds.
    book.take(&of(ProcessKind::Launcher, "standby", 0));
    book.take(&of(ProcessKind::Launcher, "fusion", 31));
    assert_eq!(pids(&book)[0], Some(31));
}

#[test]
fn rates_are_those_of_the_last_closed_interval_by_the_times_of_the_messages() {
    let mut book = HealthBook::new(0, 100 * S);
    let take = |book: &mut HealthBook, incarnation_s: i64, half_s: i64, taken| {
        let of = health(
            ProcessKind::Fusion,
            "fusion",
            (incarnation_s * S) as u64,
            half_s * S / 2,
        );
        book.take(&counting(of, taken));
    };
    let closed = |book: &mut HealthBook| {
        book.close_interval();
        let fusion = book.whole(ProcessKind::Fusion, "fusion").unwrap();
        fusion.per_s(Counter::Taken)
    };
    // The reader started with the process: its counts began at 0.
    take(&mut book, 96, 194, 100);
    assert_eq!(closed(&mut book), Some(100.0));
    assert_eq!(closed(&mut book), None, "no message");
    take(&mut book, 96, 198, 400);
    assert_eq!(closed(&mut book), Some(150.0));
    take(&mut book, 99, 202, 50);
    assert_eq!(closed(&mut book), Some(25.0), "a restarted process");
    // The reader joined later: the first message is the begin.
    let mut book = HealthBook::new(0, 200 * S);
    take(&mut book, 96, 500, 1_000);
    assert_eq!(closed(&mut book), None);
    take(&mut book, 96, 501, 1_100);
    assert_eq!(closed(&mut book), Some(200.0));
}

#[test]
fn parts_of_a_former_round_are_gone() {
    let mut book = HealthBook::new(9, i64::MAX);
    let of = |source, said_ns, note: &str| Health {
        source,
        ..health(ProcessKind::Link, "in", 1, said_ns).with_note(note)
    };
    for peer in [(0, "north"), (1, "west")] {
        book.take(&of(peer.0, S, peer.1));
    }
    book.take(&of(NO_SOURCE, S, "both"));
    let notes = |book: &HealthBook| {
        let parts = book.parts(ProcessKind::Link, "in");
        parts.map(|part| part.note().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(notes(&book), ["north", "west"]);
    book.take(&of(1, 2 * S, "west"));
    book.take(&of(NO_SOURCE, 2 * S, "one"));
    assert_eq!(notes(&book), ["west"]);
}

#[test]
fn an_adapter_may_speak_of_itself_or_of_its_source() {
    let mut book = HealthBook::new(2, i64::MAX);
    book.take(&counting(health(ProcessKind::Adapter, "radar", 1, S), 4));
    let of_source = Health {
        source: 1,
        ..health(ProcessKind::Adapter, "radar", 1, S)
    };
    book.take(&counting(of_source, 6));
    assert_eq!(book.adapter("radar", 1)[Counter::Taken], 6);
}

#[test]
fn what_is_counted_for_a_source_is_not_counted_for_the_process_again() {
    let mut book = HealthBook::new(2, i64::MAX);
    let of = |kind, name: &str, source, taken, datagrams| {
        let mut said = counting(health(kind, name, 1, S), taken);
        said.counters[Counter::Datagrams] = datagrams;
        Health { source, ..said }
    };
    let apart = |book: &HealthBook, kind, name, stands_for_source| {
        let counters = book.apart_from_sources(kind, name, stands_for_source).unwrap();
        [Counter::Taken, Counter::Datagrams].map(|counter| counters[counter])
    };
    let (adapter, recorder) = (ProcessKind::Adapter, ProcessKind::Recorder);
    book.take(&of(adapter, "radar", NO_SOURCE, 9, 3));
    assert_eq!(apart(&book, adapter, "radar", true), [0, 3], "it speaks of its source");
    assert_eq!(apart(&book, adapter, "radar", false), [9, 3], "it has no source");
    book.take(&of(adapter, "radar", 0, 5, 0));
    book.take(&of(adapter, "radar", 1, 2, 0));
    assert_eq!(
        apart(&book, adapter, "radar", false),
        [2, 3],
        "of no source that is configured"
    );
    book.take(&of(recorder, "recorder", NO_SOURCE, 9, 0));
    book.take(&of(recorder, "recorder", 0, 50, 0));
    assert_eq!(apart(&book, recorder, "recorder", false), [9, 0], "system tracks");
}

/// Messages of one process over several epochs: start, time and count, in the order of time.
fn epochs() -> impl Strategy<Value = Vec<(u64, i64, u64)>> {
    // The start times have no order: a process that takes over may be older.
    let epoch = (any::<u64>(), prop::collection::vec(0_u64..100, 1..5));
    prop::collection::vec(epoch, 1..5).prop_map(|epochs| {
        let mut messages = Vec::new();
        for (number, (start, growths)) in epochs.into_iter().enumerate() {
            // Different for each epoch.
            let start = start / 8 * 8 + number as u64;
            let mut count = 0;
            for growth in growths {
                count += growth;
                messages.push((start, messages.len() as i64 * S, count));
            }
        }
        messages
    })
}

/// Messages: epoch, time and count.
type Messages = Vec<(u64, i64, u64)>;

fn with_shuffled() -> impl Strategy<Value = (Messages, Messages)> {
    epochs().prop_flat_map(|messages| (Just(messages.clone()), Just(messages).prop_shuffle()))
}

fn taken_of(book: &HealthBook) -> u64 {
    book.service(ProcessKind::Fusion, NO_SOURCE)[Counter::Taken]
}

proptest! {
    #[test]
    fn counts_and_restarts_hold_over_epochs_and_in_any_order((in_order, shuffled) in with_shuffled()) {
        let message = |(start, said_ns, taken): (u64, i64, u64)| {
            counting(health(ProcessKind::Fusion, "fusion", start, said_ns), taken)
        };
        let mut last_of: BTreeMap<u64, u64> = BTreeMap::new();
        let mut book = HealthBook::new(0, 0);
        for each in &in_order {
            book.take(&message(*each));
            last_of.insert(each.0, each.2);
        }
        let all: u64 = last_of.values().sum();
        let newest = in_order[in_order.len() - 1];
        prop_assert_eq!(taken_of(&book), all);
        prop_assert_eq!(only(&book, newest.1).restarts as usize, last_of.len() - 1);
        // Late messages change nothing.
        for each in &in_order[..in_order.len() - 1] {
            book.take(&message(*each));
        }
        prop_assert_eq!(taken_of(&book), all);

        let mut book = HealthBook::new(0, 0);
        let mut before = 0;
        for each in &shuffled {
            book.take(&message(*each));
            prop_assert!(taken_of(&book) >= before, "a count never falls");
            before = taken_of(&book);
        }
        prop_assert!((newest.2..=all).contains(&before));
        prop_assert!((only(&book, newest.1).restarts as usize) < last_of.len());
        let latest = book.whole(ProcessKind::Fusion, "fusion").unwrap();
        prop_assert_eq!((latest.incarnation(), latest.time_ns()), (newest.0, newest.1));
    }

    #[test]
    fn the_launchers_count_of_restarts_never_falls(counts in prop::collection::vec(0_u32..9, 1..9)) {
        let mut book = HealthBook::new(0, 0);
        for restarts in &counts {
            book.take(&Health { restarts: *restarts, ..health(ProcessKind::Launcher, "radar", 1, S) });
        }
        let child = book.children().next().unwrap();
        prop_assert_eq!(Some(child.restarts), counts.iter().copied().max());
    }
}

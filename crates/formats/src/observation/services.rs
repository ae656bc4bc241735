//! Messages of sensors about themselves: times, and starts of antenna turns.

use asterix::Category;
use asterix::categories::*;

use super::*;

/// A category of such messages.
struct Messages {
    editions: &'static [&'static Category],
    time: Elements<1>,
    /// The item of the message type, and the value at the start of a turn or update cycle.
    turn: Option<(Elements<1>, u64)>,
    /// Time that a turn of the antenna takes, 1/128 s.
    turn_time: Option<Elements<1>>,
}

const fn messages(editions: &'static [&'static Category]) -> Messages {
    Messages {
        editions,
        time: whole(editions, editions[0].times[0]),
        turn: None,
        turn_time: None,
    }
}

const fn of_antenna(editions: &'static [&'static Category]) -> Messages {
    Messages {
        turn_time: Some(whole(editions, "041")),
        ..with_turns(editions, 1)
    }
}

const fn with_turns(editions: &'static [&'static Category], turn_begins: u64) -> Messages {
    Messages {
        turn: Some((whole(editions, "000"), turn_begins)),
        ..messages(editions)
    }
}

/// The messages of radars begin a turn when the antenna points north.
const MESSAGES: &[Messages] = &[
    of_antenna(CAT002),
    with_turns(CAT019, 1),
    messages(CAT023),
    of_antenna(CAT034),
    messages(CAT063),
    messages(CAT065),
];

pub(super) fn read(record: &Record<'_>) -> Option<Reading> {
    let messages = MESSAGES
        .iter()
        .find(|messages| record.table().is_one_of(messages.editions))?;
    let turn_begins = messages
        .turn
        .is_some_and(|(kind, begins)| kind.number(record) == Some(begins));
    let turn_time = messages.turn_time.as_ref();
    let ticks = turn_time
        .and_then(|ticks| ticks.number(record))
        .filter(|ticks| *ticks > 0);
    Some(service(record, &messages.time, turn_begins, ticks.map(nanoseconds)))
}

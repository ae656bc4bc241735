//! Events of Cursor on Target (CoT, event schema 2.0 of the MITRE Corporation), as TAK clients and gateways send them.
//!
//! ```xml
//! <event version="2.0" uid="ANDROID-1" type="a-f-A-M-F-Q" how="m-g" time="2026-11-30T09:00:00Z"
//!        start="2026-11-30T09:00:00Z" stale="2026-11-30T09:01:00Z">
//!   <point lat="52.0" lon="13.0" hae="120.5" ce="4.0" le="9999999.0"/>
//!   <detail><contact callsign="EAGLE1"/><track course="90.0" speed="20.0"/></detail>
//! </event>
//! ```
//!
//! [`CotReader`] reads a stream of events, or a document with one, and gives a
//! [`TargetMessage`](crate::target_message::TargetMessage) for each event with news of a thing (type `a-…`). Other
//! events (markers, messages, pings, routes) are counted.
//!
//! | attribute | becomes |
//! | --- | --- |
//! | `uid` | number of the track: a hash |
//! | `type` | category where the letters name one; on the ground: `a-?-G` |
//! | `start`, else `time` | time |
//! | `stale` | not later than `start`: the end of the track |
//! | `how`, `opex` | simulated: `m-s`, `s…` |
//! | `lat`, `lon`, `hae` | position on and height above the ellipsoid of WGS-84 |
//! | `ce` | standard deviation along each horizontal axis |
//! | `callsign` | call sign of an aircraft if it has the form of one, else the name |
//! | `course`, `speed`, `slope` | velocity over ground, and rate of climb by the slope |
//!
//! # Errors of position
//!
//! The schema (`Event-PUBLIC.xsd`, MITRE case 11-3895) defines `ce` as a circular area around the point, and where the
//! area is an error, as the point of one sigma of a normal distribution with zero mean. Things have errors, no areas,
//! so the circle is one standard deviation along each axis, and no radius of 95 %. Events that Koseki sends mean the
//! same. A sender that writes the accuracy of a phone instead, a radius of 68 %, states 1.5 deviations: such an error
//! is taken too large, never too small. `le` is checked and not used, because observations have no error of height.
//!
//! Values from 999,999 on are unknown: the schema has 9999999, the binary form of TAK 999999. An error of 0 is none.
//! The place 0, 0 without an error is that of a phone without a fix.
//!
//! # Bounds
//!
//! An event of more than [`EVENT_OCTETS_MAX`] is refused, and so are more attributes of an element than any sender
//! writes. Entities cannot expand: the parser (`quick-xml`) never reads declarations of entities, a document type
//! inside an event refuses the event, one before it is outside of all events, and only the five entities of XML and
//! numbers of characters are replaced in attributes, each by one character.
//!
//! # Limits
//!
//! An event ends at the first `</event>`, as in TAK software, and before the next `<event`; a text that contains one of
//! these refuses its event. The binary form of TAK (protocol buffers) is not read. The affiliation (friend, hostile)
//! has no place in observations. Letters of types follow `CoTtypes.xml` of the schema, which has those of MIL-STD-2525.

mod event;
mod kind;
mod reader;
mod reason;
mod stream;

pub use reader::{CotCounters, CotReader, CotSettings, SILENCE_MAX_NS};
pub use reason::CotReason;
pub use stream::EVENT_OCTETS_MAX;

#[cfg(test)]
mod tests;

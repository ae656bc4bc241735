//! Publishes tracks of an external source in an unknown layout, like a program of another version: `other_layout
//! INSTANCE SOURCE`, until it is killed. Tests of the languages run it beside their readers.

use std::thread::sleep;
use std::time::Duration;

use bus::{Bus, Mark, Root, SharedMemoryAnyThread};
use messages::SensorTrack;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [instance, source] = words.as_slice() else {
        return Err("other_layout INSTANCE SOURCE".into());
    };
    let bus = Bus::<SharedMemoryAnyThread>::open(&Root::new(instance)?, "other-layout")?;
    let mut publisher = bus.publisher(&messages::sensor_tracks(source), 1)?;
    publisher.pretend_schema(1);
    let mark = Mark {
        progress_ns: i64::MIN,
        sent_ns: 0,
        end: false,
    };
    loop {
        publisher.send(mark, 1, |_, _| SensorTrack::default())?;
        sleep(Duration::from_millis(50));
    }
}

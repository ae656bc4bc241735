//! Numbers of the sensors in files: ids of tables in metres, and names of tables of named columns.
//!
//! A table in metres has the id of the sensor in each row. Other tables have names, or none; a name gets an id in the
//! order of the first appearance, so that summaries, outputs and configurations show all sensors in one form.

use std::cell::RefCell;
use std::rc::Rc;

use formats::named_columns::RowSource;
use fusion::settings::SOURCES_MAX;

/// Most names that tables may bring: more are a wrong column.
const NAMES_MAX: usize = 4096;
/// First id of a name, alone and beside tables that have ids of their own.
const FIRST_ID: u32 = 1;
const FIRST_ID_BESIDE_IDS: u32 = 1001;

/// Source of each `sensor_id`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sensors {
    /// By source number.
    pub(crate) ids: Vec<u32>,
    /// Whether unlisted sensors are added.
    pub(crate) open: bool,
    /// First sensor above the maximum number.
    pub(crate) excess: Option<u32>,
    /// Sensors with configured accuracy; `None`: all.
    pub(crate) accurate: Option<Vec<u32>>,
}

impl Sensors {
    pub(super) fn source(&mut self, id: u32) -> Option<u16> {
        if let Some(place) = self.ids.iter().position(|known| *known == id) {
            return Some(place as u16);
        }
        if !self.open {
            return None;
        }
        if self.ids.len() == SOURCES_MAX {
            self.excess = self.excess.or(Some(id));
            return None;
        }
        self.ids.push(id);
        Some((self.ids.len() - 1) as u16)
    }

    /// Whether the configuration states the accuracy of a sensor.
    fn is_accurate(&self, id: u32) -> bool {
        self.accurate.as_ref().is_none_or(|ids| ids.contains(&id))
    }
}

/// Ids of named sensors.
#[derive(Clone, Debug, Default)]
pub(crate) struct SensorNames {
    /// Names with their ids, in the order of appearance.
    known: Vec<(String, u32)>,
    first_id: u32,
}

impl SensorNames {
    /// The names of a configuration with their ids; `beside_ids`: other tables have ids of their own.
    pub(super) fn new(configured: Vec<(String, u32)>, beside_ids: bool) -> Self {
        Self {
            known: configured,
            first_id: if beside_ids { FIRST_ID_BESIDE_IDS } else { FIRST_ID },
        }
    }

    /// The id of a name: of a whole number, the number; `None` if there are too many names.
    fn id(&mut self, name: &str) -> Option<u32> {
        if let Some((_, id)) = self.known.iter().find(|(known, _)| known == name) {
            return Some(*id);
        }
        if let Ok(id) = name.parse() {
            return Some(id);
        }
        if self.known.len() == NAMES_MAX {
            return None;
        }
        let is_free = |id: &u32| self.known.iter().all(|(_, known)| known != id);
        let id = (self.first_id..).find(is_free)?;
        self.known.push((name.to_owned(), id));
        Some(id)
    }

    /// The name of an id that a table has brought.
    pub(crate) fn name(&self, id: u32) -> Option<&str> {
        let found = self.known.iter().find(|(_, known)| *known == id);
        found.map(|(name, _)| name.as_str())
    }
}

/// Gives the source of a named sensor, with the standard deviation of its positions: `sigma_m` metres, unless the
/// configuration states the accuracy of the sensor and the command line does not.
pub(super) fn named_source(
    names: Rc<RefCell<SensorNames>>,
    sensors: Rc<RefCell<Sensors>>,
    (sigma_m, is_given): (f64, bool),
) -> impl FnMut(&str) -> Option<RowSource> {
    move |name| {
        let id = names.borrow_mut().id(name)?;
        let mut sensors = sensors.borrow_mut();
        let is_configured = sensors.is_accurate(id) && !is_given;
        Some(RowSource {
            number: sensors.source(id)?,
            sigma_m: (!is_configured).then_some(sigma_m),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_ids_in_the_order_of_appearance() {
        let configured = vec![("tower".to_owned(), 1)];
        let mut names = SensorNames::new(configured.clone(), false);
        assert_eq!(
            ["solent", "tower", "17", "opensky"].map(|name| names.id(name)),
            [2, 1, 17, 3].map(Some)
        );
        assert_eq!((names.name(3), names.name(17)), (Some("opensky"), None));
        let mut beside = SensorNames::new(configured, true);
        assert_eq!(beside.id("solent"), Some(1001));
        for name in 0..2 * NAMES_MAX {
            let _ = names.id(&format!("wrong column {name}"));
        }
        assert_eq!((names.id("another"), names.id("solent")), (None, Some(2)));
    }

    #[test]
    fn an_accuracy_is_assumed_where_none_is_configured() {
        let names = || Rc::new(RefCell::new(SensorNames::new(Vec::new(), false)));
        let sensors = |accurate| {
            Rc::new(RefCell::new(Sensors {
                open: true,
                accurate,
                ..Sensors::default()
            }))
        };
        for (accurate, is_given, expected) in [
            (Some(vec![]), false, Some(30.0)),
            (Some(vec![1]), false, None),
            (None, false, None),
            (None, true, Some(30.0)),
        ] {
            let mut source = named_source(names(), sensors(accurate), (30.0, is_given));
            assert_eq!(source("radar").unwrap().sigma_m, expected);
        }
    }
}

//! Orders as words: from command lines and JSON.

use crate::designated_place::DesignatedPlace;
use crate::order::Order;
use crate::order_kind::{OrderKind, Parameter};

impl Order {
    /// Returns the order named by the word of its kind and by `words`: pairs of a parameter and its value. `source`
    /// returns the number of a source by its name.
    ///
    /// # Errors
    /// A sentence that names the wrong word and the remedy.
    pub fn parse<'a>(
        kind: &str,
        words: impl IntoIterator<Item = (&'a str, &'a str)>,
        source: impl Fn(&str) -> Option<u16>,
    ) -> Result<Self, String> {
        let Some(kind) = OrderKind::from_word(kind) else {
            let kinds: Vec<&str> = OrderKind::ALL.iter().map(|kind| kind.word()).collect();
            return Err(format!("there is no order \"{kind}\"; there are {}", kinds.join(", ")));
        };
        let mut order = Self::new(kind);
        for (name, value) in words {
            let mut known = kind.needs().iter().chain(kind.may());
            let Some(parameter) = known.find(|parameter| parameter.word() == name) else {
                return Err(format!(
                    "{} has no parameter \"{name}\"; it is {}",
                    kind.word(),
                    kind.usage()
                ));
            };
            let number = || {
                let number = value.parse::<u32>();
                number.map_err(|_| format!("{name}={value}: {name} must be a number from 0 to {}", u32::MAX))
            };
            let numbered = || source(value).ok_or_else(|| format!("{name}={value}: there is no source of this name"));
            match parameter {
                Parameter::Source | Parameter::Tracker => order.source = numbered()?,
                Parameter::From => order.other_source = numbered()?,
                Parameter::Track => order.track = number()?,
                Parameter::With | Parameter::SensorTrack => order.other_track = number()?,
                Parameter::Number => order.number = number()?,
                Parameter::Value | Parameter::Sigma => {
                    let (low, high) = kind.range();
                    let figure = value.parse().ok().filter(|figure| (low..=high).contains(figure));
                    order.value =
                        figure.ok_or_else(|| format!("{name}={value}: {name} must lie between {low} and {high}"))?;
                }
                Parameter::Place if DesignatedPlace::read(value).is_none() => {
                    return Err(format!("{name}={value}: {}", DesignatedPlace::FORM));
                }
                Parameter::Name | Parameter::Place => {
                    order = order
                        .with_name(value)
                        .ok_or_else(|| format!("{name}={value}: a {name} has at most 32 bytes"))?;
                }
            }
        }
        match kind.needs().iter().all(|parameter| order.states(*parameter)) {
            true => Ok(order),
            false => Err(format!("the order is incomplete; it is {}", kind.usage())),
        }
    }
}

impl Order {
    /// Returns the order as a command line states it, with the names of sources that `name` returns.
    pub fn words<'a>(&self, name: impl Fn(u16) -> Option<&'a str>) -> String {
        let kind = self.kind().map_or("?", OrderKind::word);
        let parameters = self.parameters().map(|(parameter, value)| {
            let source = match parameter {
                Parameter::Source | Parameter::Tracker => name(self.source),
                Parameter::From => name(self.other_source),
                _ => None,
            };
            format!(" {}={}", parameter.word(), source.unwrap_or(&value))
        });
        std::iter::once(kind.to_owned()).chain(parameters).collect()
    }
}

impl OrderKind {
    /// Returns the word with its parameters, optional ones in brackets.
    pub fn usage(self) -> String {
        let meant = |parameter: &Parameter| match parameter {
            Parameter::Source | Parameter::From | Parameter::Tracker => format!("{}=SOURCE", parameter.word()),
            Parameter::Value | Parameter::Sigma => {
                let (word, (low, high)) = (parameter.word(), self.range());
                match high < 1e6 {
                    true => format!("{word}={low}…{high}"),
                    false => format!("{word}={low:e}…{high:e}"),
                }
            }
            Parameter::Place => format!("place={}", DesignatedPlace::WORDS),
            Parameter::Name => "name=WORD".to_owned(),
            Parameter::Track | Parameter::With | Parameter::SensorTrack | Parameter::Number => {
                format!("{}=NUMBER", parameter.word())
            }
        };
        let needed = self.needs().iter().map(meant);
        let optional = self.may().iter().map(|parameter| format!("[{}]", meant(parameter)));
        let words: Vec<String> = std::iter::once(self.word().to_owned())
            .chain(needed)
            .chain(optional)
            .collect();
        words.join(" ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check_order;

    fn order(kind: &str, words: &[(&str, &str)]) -> Result<Order, String> {
        let sources = ["north", "south"];
        Order::parse(kind, words.iter().copied(), |name| {
            let place = sources.iter().position(|source| *source == name)?;
            Some(place as u16)
        })
    }

    #[test]
    fn words_become_an_order() {
        let found = order("eta", &[("value", "0.25"), ("source", "south"), ("from", "north")]).unwrap();
        assert_eq!((found.source, found.other_source, found.value), (1, 0, 0.25));
        assert_eq!(check_order(&Order { token: 1, ..found }), Ok(OrderKind::Eta));
        let found = order("split", &[("track", "7"), ("source", "north"), ("sensor_track", "0")]).unwrap();
        assert_eq!((found.track, found.source, found.other_track), (7, 0, 0));
        assert_eq!(
            found.words(|_| Some("north")),
            "split track=7 source=north sensor_track=0"
        );
        assert_eq!(order("rule", &[("name", "auto")]).unwrap().name(), "auto");
        let words = [("tracker", "south"), ("place", "59.43,10.65"), ("sigma", "300")];
        let found = order("designate", &words).unwrap();
        assert_eq!((found.source, found.value), (1, 300.0));
        assert_eq!(check_order(&Order { token: 1, ..found }), Ok(OrderKind::Designate));
        assert_eq!(
            found.words(|_| Some("south")),
            "designate tracker=south place=59.43,10.65 sigma=300"
        );
    }

    #[test]
    fn a_wrong_word_is_named_with_the_remedy() {
        for (kind, words, named) in [
            ("eat", &[][..], "condition, snapshot, out"),
            ("eta", &[("value", "1.5")], "between 0 and 1"),
            ("eta", &[("value", "x")], "value=x"),
            ("eta", &[("track", "1")], "eta value=0…1 [source=SOURCE] [from=SOURCE]"),
            ("out", &[("source", "west")], "no source of this name"),
            ("join", &[("track", "1")], "join track=NUMBER with=NUMBER"),
            ("drop", &[("track", "-1")], "track=-1"),
            (
                "designate",
                &[("place", "59.4,10.6")],
                "designate tracker=SOURCE place=LATITUDE,",
            ),
            ("designate", &[("place", "north")], "degrees"),
            ("designate", &[("sigma", "0")], "between 0.1 and 100000"),
            ("rule", &[("name", "a-name-of-more-than-thirty-two-bytes")], "32 bytes"),
        ] {
            let error = order(kind, words).unwrap_err();
            assert!(error.contains(named), "{kind} {words:?}: {error}");
        }
    }
}

//! Fields of a line: a JSON object. Fields are taken by name, and any field left over has no meaning.

use csv_table::NamedColumn;
use koseki_client::observation::{fault, time_ns_of};
use messages::IdentityText;
use messages::admission::Fault;
use serde_json::{Map, Value};

use crate::given::GivenLine;

/// The fields of a line that have not been taken yet.
#[derive(Debug)]
pub(super) struct Fields(Map<String, Value>);

impl Fields {
    pub(super) fn of_line(line: &[u8]) -> Result<Self, Fault> {
        let remedy = "write an object as in {\"latitude\": 41.3, \"longitude\": 2.1, \"sigma_m\": 20}";
        match GivenLine::read(line) {
            Ok(GivenLine {
                twice: Some((name, value)),
                ..
            }) => Err(fault(
                &name,
                shortened(&value.to_string()),
                "must be given once",
                "leave out all values but one",
            )),
            Ok(GivenLine {
                value: Value::Object(fields),
                ..
            }) => Ok(Self(fields)),
            Ok(other) => Err(fault(
                "line",
                shortened(&other.value.to_string()),
                "must be a JSON object",
                remedy,
            )),
            Err(error) => {
                let text = shortened(&String::from_utf8_lossy(line));
                Err(fault("line", text, &format!("must be JSON ({error})"), remedy))
            }
        }
    }

    /// Whether the line is a line of `koseki tap`.
    pub(super) fn is_tapped(&self) -> bool {
        self.0.contains_key(super::tapped::MARK)
    }

    /// The fields that have not been taken.
    pub(super) fn all(&self) -> &Map<String, Value> {
        &self.0
    }

    /// Takes a field; an unknown value (`null`) is no value.
    fn take(&mut self, name: &str) -> Option<Value> {
        self.0.remove(name).filter(|value| !value.is_null())
    }

    /// Gives fields that are none of `known` the known name of their quantity, and its unit.
    pub(super) fn rename(&mut self, known: &[&'static str]) -> Result<(), Fault> {
        /// Numbers that count milliseconds since 1970: from 1973 on.
        const MILLISECONDS_MIN: f64 = 1e11;
        let foreign: Vec<String> = self
            .0
            .keys()
            .filter(|name| !known.contains(&name.as_str()))
            .cloned()
            .collect();
        for name in foreign {
            let Some((mut of_quantity, scale)) = NamedColumn::among(&name, known) else {
                continue;
            };
            let Some(mut value) = self.take(&name) else { continue };
            let number = value.as_f64();
            if let ("time", Some(time)) = (of_quantity, number) {
                of_quantity = "time_s";
                if time >= MILLISECONDS_MIN {
                    value = (time / 1e3).into();
                }
            } else if let (true, Some(number)) = (scale != 1.0, number) {
                value = (number * scale).into();
            }
            if self.0.get(of_quantity).is_some_and(|value| !value.is_null()) {
                let limit = format!("must not stand beside {name}, which is the same");
                return Err(fault(of_quantity, "present", &limit, "leave one of them out"));
            }
            self.0.insert(of_quantity.to_owned(), value);
        }
        Ok(())
    }

    pub(super) fn text(&mut self, name: &str) -> Result<Option<String>, Fault> {
        match self.take(name) {
            None => Ok(None),
            Some(Value::String(text)) => Ok(Some(text)),
            Some(other) => Err(fault(name, other, "must be a text", "put it between quotation marks")),
        }
    }

    /// Takes a number of an identity: a text of its digits.
    pub(super) fn digits(&mut self, spelling: IdentityText) -> Result<Option<u32>, Fault> {
        let Some(value) = self.take(spelling.key) else {
            return Ok(None);
        };
        let number = match &value {
            Value::String(text) => spelling.read(text),
            // Decimal digits mean the same with and without quotation marks.
            Value::Number(number) if spelling.radix == 10 => number.as_u64().and_then(|number| number.try_into().ok()),
            _ => None,
        };
        let wrong = || {
            let remedy = format!("write it as in \"{}\"", spelling.example);
            fault(
                spelling.key,
                shortened(&value.to_string()),
                &format!("must be {}, as text", spelling.form),
                remedy,
            )
        };
        number.map(Some).ok_or_else(wrong)
    }

    pub(super) fn number(&mut self, name: &str) -> Result<Option<f64>, Fault> {
        let Some(value) = self.take(name) else { return Ok(None) };
        let number = value.as_f64().ok_or_else(|| wrong_number(name, &value))?;
        Ok(Some(number))
    }

    pub(super) fn whole(&mut self, name: &str) -> Result<Option<u32>, Fault> {
        let Some(value) = self.take(name) else { return Ok(None) };
        let whole = value.as_u64().and_then(|whole| u32::try_from(whole).ok());
        let limit = "must be a whole number from 0 to 4294967295";
        whole
            .map(Some)
            .ok_or_else(|| fault(name, &value, limit, "number the sensor's tracks or scans from 1"))
    }

    /// Takes an array of `least` to `N` numbers; the rest is 0. Returns the values and their number.
    pub(super) fn numbers<const N: usize>(
        &mut self,
        name: &str,
        least: usize,
    ) -> Result<Option<([f64; N], usize)>, Fault> {
        let Some(value) = self.take(name) else { return Ok(None) };
        let wrong = || {
            let limit = format!("must be an array of {least} to {N} numbers");
            fault(
                name,
                shortened(&value.to_string()),
                &limit,
                "write it as in [100.0, 200.0, 300.0]",
            )
        };
        let all: Option<Vec<f64>> = value.as_array().and_then(|all| all.iter().map(Value::as_f64).collect());
        let all = all.filter(|all| (least..=N).contains(&all.len())).ok_or_else(wrong)?;
        let mut numbers = [0.0; N];
        numbers[..all.len()].copy_from_slice(&all);
        Ok(Some((numbers, all.len())))
    }

    /// Takes the time, UTC, nanoseconds since 1970, with the field's name; `None` for a line without a time.
    pub(super) fn time_ns(&mut self) -> Result<Option<i64>, Fault> {
        let remedy = "write time as in \"2026-05-01T10:00:00.5Z\", or the UTC since 1970 as time_s or time_ns";
        if let Some(value) = self.take("time") {
            let parsed = value.as_str().map(str::parse::<formats::rows::Utc>);
            let Some(Ok(formats::rows::Utc(time_ns))) = parsed else {
                return Err(fault("time", value, "must be a text of UTC", remedy));
            };
            return Ok(Some(time_ns));
        }
        if let Some(seconds) = self.number("time_s")? {
            return time_ns_of(seconds).map(Some);
        }
        let Some(value) = self.take("time_ns") else {
            return Ok(None);
        };
        let time_ns = value.as_i64();
        time_ns.map(Some).ok_or_else(|| {
            fault(
                "time_ns",
                value,
                "must be a whole number of nanoseconds since 1970",
                remedy,
            )
        })
    }

    /// Takes a vector in the system frame: the array `name` of two or three numbers, in place of the fields `others`.
    pub(super) fn vector(&mut self, name: &str, others: &[&str]) -> Result<[Option<f64>; 3], Fault> {
        let Some((values, count)) = self.numbers::<3>(name, 2)? else {
            return Ok([None; 3]);
        };
        if others
            .iter()
            .any(|other| self.0.get(*other).is_some_and(|value| !value.is_null()))
        {
            let limit = format!("must not stand beside {}", others.join(" or "));
            return Err(fault(name, "present", &limit, "leave one of the two forms out"));
        }
        let [east, north, up] = values;
        Ok([Some(east), Some(north), (count == 3).then_some(up)])
    }

    /// Refuses fields that have not been taken.
    pub(super) fn end(self, known: &[&str]) -> Result<(), Fault> {
        let Some((name, value)) = self.0.into_iter().next() else {
            return Ok(());
        };
        let near = settings::nearest(&name, known).map(|near| format!("did you mean {near}? "));
        let remedy = format!("{}`koseki feed --help` lists the fields", near.unwrap_or_default());
        Err(fault(
            &name,
            shortened(&value.to_string()),
            "is no field of such a source",
            remedy,
        ))
    }
}

fn wrong_number(name: &str, value: &Value) -> Fault {
    fault(
        name,
        shortened(&value.to_string()),
        "must be a number",
        "write digits without quotation marks",
    )
}

/// The begin of a long text.
fn shortened(text: &str) -> String {
    const SHOWN: usize = 60;
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

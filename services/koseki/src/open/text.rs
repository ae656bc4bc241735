//! The configuration of what was opened.

use std::fmt::Write as _;

use super::opened::{Opened, OpenedInput};

/// Values of a configuration.
#[derive(Debug)]
pub(super) struct ConfigText<'a> {
    pub(super) name: &'a str,
    /// Origin of the system frame, degrees.
    pub(super) place_deg: [f64; 2],
    /// First day of recordings.
    pub(super) date: Option<String>,
    /// Address for browsers.
    pub(super) listen: Option<String>,
    pub(super) opened: &'a [Opened],
}

impl ConfigText<'_> {
    /// Returns the file.
    pub(super) fn text(&self) -> String {
        let [latitude, longitude] = self.place_deg;
        let mut out = format!(
            "# Written by `koseki open`; start it again by `koseki up`.\nname = \"{}\"\n\n[frame]\nlatitude_deg = \
             {latitude:?}\nlongitude_deg = {longitude:?}\n",
            self.name
        );
        if let Some(date) = &self.date {
            // By time of measurement: the same files give the same tracks, and the run ends with them.
            let _ = write!(out, "\n[time]\ndate = \"{date}\"\norder = \"time\"\n");
        }
        if let Some(listen) = &self.listen {
            let _ = write!(out, "\n[display]\nlisten = \"{listen}\"\n");
        }
        if self.date.is_some() {
            out.push_str("\n[recorder]\nformat = [\"mcap\"]\n");
        }
        let mut names = Vec::new();
        for opened in self.opened {
            opened.write(&mut names, &mut out);
        }
        out
    }
}

impl Opened {
    /// Appends the tables of the sources; `names` are those in use.
    fn write(&self, names: &mut Vec<String>, out: &mut String) {
        let receiver = match &self.input {
            OpenedInput::File(_) => None,
            OpenedInput::Feed(keys) => {
                let name = new_name(&format!("{}-in", self.label), names);
                let _ = write!(out, "\n[[receiver]]\nname = \"{name}\"\n{keys}");
                Some(name)
            }
        };
        for source in &self.sources {
            let label = match source.suffix.as_str() {
                "" => self.label.clone(),
                suffix => format!("{}-{suffix}", self.label),
            };
            let name = new_name(&label, names);
            let _ = write!(out, "\n[[source]]\nname = \"{name}\"\n{}", source.keys);
            match (&self.input, &receiver) {
                (OpenedInput::File(path), _) => {
                    let _ = write!(out, "[source.recorded]\nfile = {:?}\n", path.display().to_string());
                }
                (OpenedInput::Feed(_), name) => {
                    let _ = write!(
                        out,
                        "[source.live]\nreceiver = \"{}\"\n",
                        name.as_deref().unwrap_or_default()
                    );
                }
            }
            out.push_str(&source.input_keys);
            out.push_str(&source.tables);
        }
    }
}

/// Returns a name that is not in use, and notes it.
fn new_name(wanted: &str, names: &mut Vec<String>) -> String {
    let name = (1..)
        .map(|count| match count {
            1 => wanted.to_owned(),
            count => format!("{wanted}-{count}"),
        })
        .find(|name| !names.contains(name))
        .unwrap_or_default();
    names.push(name.clone());
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_is_given_twice() {
        let mut names = Vec::new();
        let given: Vec<String> = (0..3).map(|_| new_name("a", &mut names)).collect();
        assert_eq!(given, ["a", "a-2", "a-3"]);
    }
}

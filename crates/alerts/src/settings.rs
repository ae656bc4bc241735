//! Keys of `[[area]]` and `[[alert]]`.

use areas::Level;
use messages::{AlarmSeverity, AlertKind};
use settings::{Seconds, SettingsError};

/// Metres in a nautical mile.
pub(crate) const NAUTICAL_MILE_M: f64 = 1852.0;
/// Metres in a foot.
pub(crate) const FOOT_M: f64 = 0.3048;
/// Metres per second in a knot.
pub(crate) const KNOT_MPS: f64 = NAUTICAL_MILE_M / 3600.0;
/// Most `[[alert]]` tables.
pub(crate) const RULES_MAX: usize = 64;

settings::words! {
    /// Targets that a rule is about.
    pub enum Traffic {
        /// Aircraft in the air: with an aircraft's address, a level, or too fast for a vessel; faster than 49 knots and
        /// not on the ground, since vehicles of airports have addresses, too.
        Air = "air",
        /// Vessels, and what may be one.
        Sea = "sea",
        /// Every target.
        All = "all",
    }
}

/// Kind of an alert in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kind(pub AlertKind);

impl Default for Kind {
    fn default() -> Self {
        Self(AlertKind::Conflict)
    }
}

/// Severity of an alert in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Severity(pub AlarmSeverity);

impl Default for Severity {
    fn default() -> Self {
        Self(AlarmSeverity::Major)
    }
}

settings::settings! {
    /// An area, for rules of alerts: exactly one of `file`, `circle` and `corners_deg`.
    pub struct AreaSettings {
        check AreaSettings::check;
        /// Name. Of a file with several areas it stands for all of them.
        name: String;
        /// GeoJSON or OpenAir, relative to the data folder unless absolute.
        file: Option<String> = None;
        /// Circle about a place.
        circle: Option<CircleSettings> = None;
        /// Corners in turn, latitude and longitude (WGS-84), degrees. Sides are straight in latitude and longitude.
        corners_deg: Vec<[f64; 2]> = Vec::new();
        /// Lowest height, as in `"FL95"`, `"2500 ft"` or `"760 m"` above mean sea level. It goes before that of a file.
        floor: Option<String> = None, usually "unlimited";
        /// Greatest height.
        ceiling: Option<String> = None, usually "unlimited";
        /// Times of day (UTC) in which the area is active, as in `"06:00-22:00"`.
        active: Vec<String> = Vec::new(), usually "always";
    }

    /// A circle on the ground.
    pub struct CircleSettings {
        /// Latitude of the centre, −90 to 90.
        latitude_deg: f64, in [-90, 90];
        /// Longitude of the centre, −180 to 180.
        longitude_deg: f64, in [-180, 180];
        /// Radius, nautical miles.
        radius_nm: f64, in [0.001, 1_000];
    }

    /// A rule of alerts on targets.
    pub struct AlertSettings {
        check AlertSettings::check;
        /// Kind: `enter`, `leave`, `stay`, `conflict`, `approach`, `low`, `speed`, `level`, `lost` or `emergency`.
        kind: Kind;
        /// Name.
        name: Option<String> = None, usually "that of the kind";
        /// Names of areas. Only targets in one of them count; of `enter`, `leave` and `stay` they are what is entered.
        areas: Vec<String> = Vec::new(), usually "everywhere";
        /// Targets that count: `air`, `sea` or `all`.
        traffic: Option<Traffic> = None, usually "conflict, low: air; approach: sea; others: all";
        /// Severity: `warning`, `major` or `critical`.
        severity: Option<Severity> = None, usually "that of the kind";
        /// Probability from which the alert is raised. It is cleared below half of it.
        probability: f64 = 0.5, in [0.01, 0.99];
        /// Time for which motion is predicted.
        look_ahead_s: Option<Seconds> = None, in [0, 3600], usually "conflict: 120; approach: 900; low: 30; others: 0";
        /// Time for which a climb or descent is predicted to go on, where no selected altitude is known.
        vertical_look_ahead_s: Seconds = Seconds::of(15.0), in [0, 3600];
        /// `conflict`, `approach`: horizontal minimum, nautical miles.
        distance_nm: Option<f64> = None, in [0.001, 100], usually "conflict: 5; approach: 0.5";
        /// `conflict`: vertical minimum, feet.
        vertical_ft: f64 = 1_000.0, in [0, 100_000];
        /// `conflict`: vertical minimum where one of both is above FL 410, feet.
        vertical_high_ft: f64 = 2_000.0, in [0, 100_000];
        /// `conflict`: how far heights may be nearer than the vertical minimum, feet: two levels in steps of a hundred
        /// feet differ by so much from two true ones.
        vertical_tolerance_ft: f64 = 100.0, in [0, 1_000];
        /// `approach`: speed up to which a vessel lies still, knots. A speed below twice its standard deviation is
        /// none.
        still_kn: f64 = 1.0, in [0, 20];
        /// `stay`: time in the area.
        for_s: Seconds = Seconds::of(60.0), in [0, 86_400];
        /// `low`, `level`: lowest permitted height, as in `"FL95"` or `"2500 ft"` above mean sea level.
        above: Option<String> = None;
        /// `level`: greatest permitted height.
        below: Option<String> = None;
        /// `speed`: lowest permitted speed over ground, knots.
        faster_than_kn: Option<f64> = None, in [0, 10_000];
        /// `speed`: greatest permitted speed over ground, knots.
        slower_than_kn: Option<f64> = None, in [0, 10_000];
        /// `lost`: time without a report, in usual intervals of the target's reports.
        silent_intervals: f64 = 5.0, in [2, 1_000];
        /// `lost`: time for which the alert stays in force.
        keep_s: Seconds = Seconds::of(120.0), in [1, 86_400];
    }
}

settings::spelt_as!(
    Kind,
    String,
    "kind of an alert",
    |word| AlertKind::from_word(&word)
        .map(Self)
        .ok_or_else(|| settings::not_known(&word, &AlertKind::ALL.map(AlertKind::word))),
    |kind| kind.0.word().to_owned()
);

settings::spelt_as!(
    Severity,
    String,
    "severity",
    |word| AlarmSeverity::from_word(&word)
        .map(Self)
        .ok_or_else(|| settings::not_known(&word, &AlarmSeverity::ALL.map(AlarmSeverity::word))),
    |severity| severity.0.word().to_owned()
);

impl AreaSettings {
    fn check(&self) -> Result<(), SettingsError> {
        let forms = [self.file.is_some(), self.circle.is_some(), !self.corners_deg.is_empty()];
        if forms.iter().filter(|given| **given).count() != 1 {
            return Err(SettingsError::new(
                "",
                "give exactly one of file, circle and corners_deg",
            ));
        }
        if let Some(corner) = self.corners_deg.iter().flatten().find(|degrees| !degrees.is_finite()) {
            return Err(SettingsError::new("corners_deg", format!("{corner} is no angle")));
        }
        for (number, text) in self.active.iter().enumerate() {
            period_s(text).map_err(|what| SettingsError::new(format!("active[{number}]"), what))?;
        }
        for (key, text) in [("floor", &self.floor), ("ceiling", &self.ceiling)] {
            let (floor, ceiling) = match key {
                "floor" => (text.as_deref(), None),
                _ => (None, text.as_deref()),
            };
            areas::VerticalLimits::read(floor, ceiling).map_err(|error| SettingsError::new(key, error.0))?;
        }
        Ok(())
    }
}

/// Reads a time of day from and to, seconds; the second is smaller if the period contains midnight.
pub(crate) fn period_s(text: &str) -> Result<[u32; 2], String> {
    let time_s = |text: &str| {
        let (hours, minutes) = text.trim().split_once(':')?;
        let (hours, minutes): (u32, u32) = (hours.parse().ok()?, minutes.parse().ok()?);
        (hours < 24 && minutes < 60).then_some(hours * 3600 + minutes * 60)
    };
    let period = text
        .split_once('-')
        .and_then(|(from, to)| Some([time_s(from)?, time_s(to)?]));
    period.ok_or_else(|| format!("\"{text}\" is no period; write it as in \"06:00-22:00\" (UTC)"))
}

impl AlertSettings {
    fn check(&self) -> Result<(), SettingsError> {
        let kind = self.kind.0;
        let needs_area = matches!(kind, AlertKind::Enter | AlertKind::Leave | AlertKind::Stay);
        if needs_area && self.areas.is_empty() {
            let what = format!("kind \"{}\" needs the name of an [[area]]", kind.word());
            return Err(SettingsError::new("areas", what));
        }
        for (key, text) in [("above", &self.above), ("below", &self.below)] {
            let Some(text) = text else { continue };
            text.parse::<Level>()
                .map_err(|error| SettingsError::new(key, error.0))?;
        }
        let lacks = match kind {
            AlertKind::Low => self
                .above
                .is_none()
                .then_some(("above", "needs the lowest permitted height")),
            AlertKind::Level => (self.above.is_none() && self.below.is_none())
                .then_some(("above", "needs a permitted height: above, below or both")),
            AlertKind::Speed => (self.faster_than_kn.is_none() && self.slower_than_kn.is_none()).then_some((
                "slower_than_kn",
                "needs a permitted speed: faster_than_kn, slower_than_kn or both",
            )),
            _ => None,
        };
        match lacks {
            Some((key, what)) => Err(SettingsError::new(key, format!("kind \"{}\" {what}", kind.word()))),
            None => Ok(()),
        }
    }

    /// Name of the rule.
    pub fn title(&self) -> &str {
        self.name.as_deref().unwrap_or(self.kind.0.word())
    }

    pub(crate) fn traffic(&self) -> Traffic {
        self.traffic.unwrap_or(match self.kind.0 {
            AlertKind::Conflict | AlertKind::Low => Traffic::Air,
            AlertKind::Approach => Traffic::Sea,
            _ => Traffic::All,
        })
    }

    pub(crate) fn severity(&self) -> AlarmSeverity {
        self.severity.map(|severity| severity.0).unwrap_or(match self.kind.0 {
            AlertKind::Conflict | AlertKind::Approach | AlertKind::Emergency => AlarmSeverity::Critical,
            AlertKind::Lost | AlertKind::Speed | AlertKind::Level => AlarmSeverity::Warning,
            _ => AlarmSeverity::Major,
        })
    }

    pub(crate) fn look_ahead_s(&self) -> f64 {
        self.look_ahead_s.map_or(
            match self.kind.0 {
                AlertKind::Conflict => 120.0,
                AlertKind::Approach => 900.0,
                AlertKind::Low => 30.0,
                _ => 0.0,
            },
            Seconds::s,
        )
    }

    pub(crate) fn distance_m(&self) -> f64 {
        let usual_nm = match self.kind.0 {
            AlertKind::Approach => 0.5,
            _ => 5.0,
        };
        self.distance_nm.unwrap_or(usual_nm) * NAUTICAL_MILE_M
    }
}

/// Rules of alerts, and the areas that they name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AlertRules {
    /// The `[[alert]]` tables.
    pub rules: Vec<AlertSettings>,
    /// The `[[area]]` tables.
    pub areas: Vec<AreaSettings>,
}

impl AlertRules {
    /// Checks rules and areas together: their numbers, and that names are unique and known.
    ///
    /// # Errors
    /// The key, by its path in the file, with its value and the remedy.
    pub fn check(&self) -> Result<(), SettingsError> {
        check_rules(&self.rules, &self.areas)
    }
}

fn check_rules(rules: &[AlertSettings], areas: &[AreaSettings]) -> Result<(), SettingsError> {
    if rules.len() > RULES_MAX {
        return Err(SettingsError::new(
            "alert",
            format!("{} are more than {RULES_MAX}", rules.len()),
        ));
    }
    for (number, area) in areas.iter().enumerate() {
        if areas[..number].iter().any(|earlier| earlier.name == area.name) {
            let what = format!("\"{}\" is the name of an earlier area; give each its own", area.name);
            return Err(SettingsError::new(format!("area[{number}].name"), what));
        }
    }
    for (number, rule) in rules.iter().enumerate() {
        if rules[..number].iter().any(|earlier| earlier.title() == rule.title()) {
            let what = format!(
                "\"{}\" is the name of an earlier alert; give each its own",
                rule.title()
            );
            return Err(SettingsError::new(format!("alert[{number}].name"), what));
        }
        let names: Vec<&str> = areas.iter().map(|area| area.name.as_str()).collect();
        // A name of a single area of a file is known once the file has been read.
        let all_known = areas.iter().all(|area| area.file.is_none());
        if let Some(unknown) = rule
            .areas
            .iter()
            .find(|name| all_known && !names.contains(&name.as_str()))
        {
            let what = settings::not_known(unknown, &names);
            return Err(SettingsError::new(format!("alert[{number}].areas"), what));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> String {
        let document = settings::Document::parse(text, &[]).expect("well-formed");
        document.read::<AlertSettings>().expect_err("not usable").to_string()
    }

    #[test]
    fn a_rule_needs_what_its_kind_compares() {
        for (text, expected) in [
            (
                "kind = \"enter\"",
                "areas: kind \"enter\" needs the name of an [[area]]",
            ),
            (
                "kind = \"low\"",
                "above: kind \"low\" needs the lowest permitted height",
            ),
            (
                "kind = \"speed\"",
                "slower_than_kn: kind \"speed\" needs a permitted speed",
            ),
            (
                "kind = \"conflikt\"",
                "kind: \"conflikt\" is not known; there are: enter",
            ),
            (
                "kind = \"low\"\nabove = \"500 ft AGL\"",
                "above: the level 500 ft AGL is above ground",
            ),
        ] {
            let error = refused(text);
            assert!(error.starts_with(expected), "{error}");
        }
    }

    #[test]
    fn a_period_may_contain_midnight() {
        assert_eq!(period_s("22:00-05:30"), Ok([79_200, 19_800]));
        assert!(period_s("24:00-05:30").is_err() && period_s("6-7").is_err());
    }

    #[test]
    fn names_are_unique_and_areas_are_known() {
        let rule = |text: &str| {
            settings::Document::parse(text, &[])
                .unwrap()
                .read::<AlertSettings>()
                .unwrap()
        };
        let circle = AreaSettings {
            name: "range".to_owned(),
            circle: Some(CircleSettings::default()),
            ..AreaSettings::default()
        };
        let enter = rule("kind = \"enter\"\nareas = [\"rage\"]");
        let error = check_rules(&[enter], std::slice::from_ref(&circle))
            .unwrap_err()
            .to_string();
        assert!(error.starts_with("alert[0].areas: \"rage\" is not known"), "{error}");
        let twice = [rule("kind = \"conflict\""), rule("kind = \"conflict\"")];
        assert!(
            check_rules(&twice, &[])
                .unwrap_err()
                .to_string()
                .starts_with("alert[1].name")
        );
        assert!(check_rules(&[], &[circle.clone(), circle]).is_err());
    }
}

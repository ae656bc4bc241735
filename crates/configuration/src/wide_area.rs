//! The configuration of support by a wide-area sensor (WA): what a count may do, what is known beforehand, and which
//! detections are used at all.
//!
//! The tables stand in a configuration of `koseki track`, or, live, in `[source.tracker]`. All of it may be left out:
//!
//! ```toml
//! [wide_area]
//! correction = { share = 0.75 }   # or { factor = 4.0 }, or "off"
//! groups = { probability_min = 0.5 }
//! [[wide_area.type]]
//! name = "patrol"
//! emissions = [{ frequency_hz = [9.3e9, 9.5e9], pulse_interval_s = [5e-4, 2e-3] }]
//! [[wide_area.prior]]
//! sector = { from_m = [0.0, 0.0], bearings_deg = [20.0, 60.0] }
//! types = { patrol = 0.7 }
//! formations = { 4 = 0.8 }
//! [selection]
//! age_max_s = 5.0
//! ```
//!
//! Lengths and places are metres east and north in the frame of the detections.

use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;

use messages::{TYPE_NAME_MAX, TargetType};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserialize, Deserializer, Error, MapAccess, Visitor};
use tracking::selection::Selection;
use tracking::settings::{Confirmation, Deletion};
use tracking::wide_area::TARGETS_MAX;
use tracking::wide_area::correction::Rule;
use tracking::wide_area::distribution::Sharing;
use tracking::wide_area::group::Groups;
use tracking::wide_area::prior::{self, EmissionBand, Knowledge, Place, Prior};
use tracking::wide_area::settings::{Coverage, EarlyConfirmation, EarlyDeletion, WideArea};

use super::check::{Checked, nanoseconds, problem, within};
use super::tracker::count;

/// Farthest place and longest distance, metres.
const FAR_M: f64 = 1e7;
/// Shortest and longest time, seconds.
const TIMES_S: [f64; 2] = [1e-3, 86_400.0];
/// Probability that a cluster has fewer tracks than targets, from which on a group is favoured, where nobody says more.
const GROUP_PROBABILITY_MIN: f64 = 0.5;
/// The same for a formation that raises a report's number.
const FORMATION_PROBABILITY_MIN: f64 = 0.5;
/// A target that was missed so often would be given up early, where nobody says more: some three scans with a probability of
/// detection of 0.9.
const MISSED_PROBABILITY: f64 = 1e-3;
/// Rounding errors of a sum of probabilities.
const SUM_MORE: f64 = 1e-9;

/// `[wide_area]`.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawWideArea {
    correction: OffOr<RawCorrection>,
    corrects_confirmed_only: bool,
    held: OffOr<RawCorrection>,
    range_m: f64,
    tracks_min: f64,
    others_count: bool,
    sharing: OffOr<RawSharing>,
    confirmation: OffOr<RawEarlyConfirmation>,
    deletion: OffOr<RawEarlyDeletion>,
    groups: OffOr<RawGroups>,
    #[serde(rename = "type")]
    types: Vec<RawType>,
    #[serde(rename = "prior")]
    priors: Vec<RawPrior>,
    valid_s: f64,
    delay_max_s: f64,
}

/// WA-4: one of the two.
#[derive(Clone, Copy, Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct RawCorrection {
    share: Option<f64>,
    factor: Option<f64>,
}

/// WA-5.
#[derive(Clone, Copy, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RawSharing {
    whole: bool,
    by_tracks: bool,
    excess: f64,
    group_m: Option<f64>,
}

/// WA-6.
#[derive(Clone, Copy, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RawEarlyConfirmation {
    new_target_share: f64,
    beside_confirmed_only: bool,
    reliability_min: f64,
    detections_min: u32,
    log_likelihood_ratio_min: Option<f64>,
    company_min: f64,
}

/// WA-8.
#[derive(Clone, Copy, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RawEarlyDeletion {
    missed_probability: f64,
    silent_s: f64,
    coverage: Option<RawCircle>,
}

/// WA-7.
#[derive(Clone, Copy, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RawGroups {
    probability_min: f64,
}

#[derive(Clone, Copy, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct RawCircle {
    centre_m: [f64; 2],
    radius_m: f64,
}

#[derive(Clone, Copy, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSector {
    from_m: [f64; 2],
    bearings_deg: [f64; 2],
}

/// WA-10: a type of target.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct RawType {
    name: String,
    #[serde(default)]
    emissions: Vec<RawEmissions>,
}

#[derive(Clone, Copy, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct RawEmissions {
    frequency_hz: [f64; 2],
    pulse_interval_s: Option<[f64; 2]>,
}

/// WA-10: what is known of a place. The keys of `types` are names, those of `formations` numbers of members.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPrior {
    sector: Option<RawSector>,
    circle: Option<RawCircle>,
    #[serde(default)]
    types: BTreeMap<String, f64>,
    #[serde(default)]
    formations: BTreeMap<String, f64>,
    #[serde(default = "formation_probability_min")]
    formation_probability_min: f64,
}

fn formation_probability_min() -> f64 {
    FORMATION_PROBABILITY_MIN
}

/// `[selection]` (WA-1). The sensors' priorities are theirs.
#[derive(Clone, Copy, Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawSelection {
    age_max_s: Option<f64>,
    sigma_max_m: Option<f64>,
    same_time_s: f64,
    kept_weight: Option<f64>,
}

/// A table, or `"off"`. Unlike an untagged enumeration it says what is wrong inside the table.
#[derive(Clone, Copy, Debug)]
struct OffOr<T>(Option<T>);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for OffOr<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct TableOrOff<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for TableOrOff<T> {
            type Value = OffOr<T>;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a table, or \"off\"")
            }

            fn visit_str<E: Error>(self, word: &str) -> Result<Self::Value, E> {
                match word {
                    "off" => Ok(OffOr(None)),
                    other => Err(E::invalid_value(serde::de::Unexpected::Str(other), &self)),
                }
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
                T::deserialize(MapAccessDeserializer::new(map)).map(|table| OffOr(Some(table)))
            }
        }
        deserializer.deserialize_any(TableOrOff(PhantomData))
    }
}

impl<T: Copy> OffOr<T> {
    /// What `check` makes of the table.
    fn checked<C>(self, check: impl FnOnce(T) -> Checked<C>) -> Checked<Option<C>> {
        given(self.0, check)
    }
}

/// What `check` makes of a value, if one is given.
fn given<T, C>(value: Option<T>, check: impl FnOnce(T) -> Checked<C>) -> Checked<Option<C>> {
    value.map(check).transpose()
}

impl Default for RawWideArea {
    fn default() -> Self {
        let usual = WideArea::default();
        Self {
            correction: OffOr(usual.correction.map(RawCorrection::of)),
            corrects_confirmed_only: usual.corrects_confirmed_only,
            held: OffOr(usual.held.map(RawCorrection::of)),
            range_m: usual.range_m,
            tracks_min: usual.tracks_min,
            others_count: usual.others_count,
            sharing: OffOr(usual.sharing.map(RawSharing::of)),
            confirmation: OffOr(usual.confirmation.map(RawEarlyConfirmation::of)),
            deletion: OffOr(usual.deletion.map(|_| RawEarlyDeletion::default())),
            groups: OffOr(usual.groups.map(|_| RawGroups::default())),
            types: Vec::new(),
            priors: Vec::new(),
            valid_s: frames::time::seconds(usual.valid_ns),
            delay_max_s: frames::time::seconds(usual.delay_max_ns),
        }
    }
}

impl RawCorrection {
    fn of(rule: Rule) -> Self {
        match rule {
            Rule::Share(share) => Self {
                share: Some(share),
                factor: None,
            },
            Rule::Factor(factor) => Self {
                share: None,
                factor: Some(factor),
            },
        }
    }

    fn rule(self, key: &str) -> Checked<Rule> {
        match (self.share, self.factor) {
            (Some(share), None) => within(&format!("{key}.share"), share, 1e-6, 0.999_999).map(Rule::Share),
            (None, Some(factor)) => within(&format!("{key}.factor"), factor, 1.0, 1e12).map(Rule::Factor),
            _ => {
                let what = "needs exactly one of share and factor, like { share = 0.6 }; \"off\" is another choice";
                Err(problem(key, what))
            }
        }
    }
}

impl RawSharing {
    fn of(sharing: Sharing) -> Self {
        Self {
            whole: sharing.whole,
            by_tracks: sharing.by_tracks,
            excess: sharing.excess,
            group_m: sharing.group_m,
        }
    }
}

impl Default for RawSharing {
    fn default() -> Self {
        Self::of(Sharing::default())
    }
}

impl RawEarlyConfirmation {
    fn of(early: EarlyConfirmation) -> Self {
        Self {
            new_target_share: early.new_target_share,
            beside_confirmed_only: early.beside_confirmed_only,
            reliability_min: early.confirmation.reliability_min,
            detections_min: early.confirmation.detections_min,
            log_likelihood_ratio_min: early.confirmation.log_likelihood_ratio_min,
            company_min: early.company_min,
        }
    }
}

impl Default for RawEarlyConfirmation {
    fn default() -> Self {
        Self::of(EarlyConfirmation::default())
    }
}

impl Default for RawEarlyDeletion {
    fn default() -> Self {
        let usual = tracking::Settings::default().deletion;
        Self {
            missed_probability: MISSED_PROBABILITY,
            silent_s: frames::time::seconds(usual.silent_ns),
            coverage: None,
        }
    }
}

impl Default for RawGroups {
    fn default() -> Self {
        Self {
            probability_min: GROUP_PROBABILITY_MIN,
        }
    }
}

impl RawWideArea {
    /// Checks every value; keys begin with `prefix`.
    pub(crate) fn settings(&self, prefix: &str) -> Checked<WideArea> {
        let key = |part: &str| format!("{prefix}wide_area.{part}");
        let [shortest_s, longest_s] = TIMES_S;
        Ok(WideArea {
            correction: self.correction.checked(|raw| raw.rule(&key("correction")))?,
            corrects_confirmed_only: self.corrects_confirmed_only,
            held: self.held.checked(|raw| raw.rule(&key("held")))?,
            range_m: within(&key("range_m"), self.range_m, 1.0, FAR_M)?,
            tracks_min: within(&key("tracks_min"), self.tracks_min, 0.0, f64::from(TARGETS_MAX))?,
            others_count: self.others_count,
            sharing: self.sharing.checked(|raw| raw.checked(&key("sharing")))?,
            confirmation: self.confirmation.checked(|raw| raw.checked(&key("confirmation")))?,
            deletion: self.deletion.checked(|raw| raw.checked(&key("deletion")))?,
            groups: self.groups.checked(|raw| raw.checked(&key("groups.probability_min")))?,
            knowledge: knowledge(&self.types, &self.priors, &key)?,
            valid_ns: nanoseconds(within(&key("valid_s"), self.valid_s, shortest_s, longest_s)?),
            delay_max_ns: nanoseconds(within(&key("delay_max_s"), self.delay_max_s, 0.0, longest_s)?),
        })
    }
}

impl RawGroups {
    fn checked(self, key: &str) -> Checked<Groups> {
        let probability_min = within(key, self.probability_min, 1e-6, 1.0)?;
        Ok(Groups { probability_min })
    }
}

impl RawSharing {
    fn checked(self, key: &str) -> Checked<Sharing> {
        Ok(Sharing {
            whole: self.whole,
            by_tracks: self.by_tracks,
            excess: within(&format!("{key}.excess"), self.excess, 1.0, 100.0)?,
            group_m: given(self.group_m, |size_m| {
                within(&format!("{key}.group_m"), size_m, 1e-3, FAR_M)
            })?,
        })
    }
}

impl RawEarlyConfirmation {
    fn checked(self, key: &str) -> Checked<EarlyConfirmation> {
        let key = |part: &str| format!("{key}.{part}");
        Ok(EarlyConfirmation {
            new_target_share: within(&key("new_target_share"), self.new_target_share, 1e-6, 1e3)?,
            beside_confirmed_only: self.beside_confirmed_only,
            confirmation: Confirmation {
                reliability_min: within(&key("reliability_min"), self.reliability_min, 0.501, 1.0)?,
                detections_min: count(&key("detections_min"), self.detections_min as usize, 1, 1000)? as u32,
                log_likelihood_ratio_min: given(self.log_likelihood_ratio_min, |value| {
                    within(&key("log_likelihood_ratio_min"), value, -1e3, 1e3)
                })?,
            },
            company_min: within(&key("company_min"), self.company_min, 0.0, 1.0)?,
        })
    }
}

impl RawEarlyDeletion {
    fn checked(self, key: &str) -> Checked<EarlyDeletion> {
        let key = |part: &str| format!("{key}.{part}");
        let [shortest_s, longest_s] = TIMES_S;
        Ok(EarlyDeletion {
            deletion: Deletion {
                missed_probability: within(&key("missed_probability"), self.missed_probability, 1e-300, 0.99)?,
                silent_ns: nanoseconds(within(&key("silent_s"), self.silent_s, shortest_s, longest_s)?),
            },
            coverage: given(self.coverage, |circle| {
                let ([east, north], radius_m) = circle.checked(&key("coverage"))?;
                let centre_m = [east, north, 0.0];
                Ok(Coverage { centre_m, radius_m })
            })?,
        })
    }
}

impl RawCircle {
    /// Centre and radius, metres.
    fn checked(self, key: &str) -> Checked<([f64; 2], f64)> {
        let centre_m = point(&format!("{key}.centre_m"), self.centre_m)?;
        Ok((
            centre_m,
            within(&format!("{key}.radius_m"), self.radius_m, 1e-3, FAR_M)?,
        ))
    }
}

fn point(key: &str, [east, north]: [f64; 2]) -> Checked<[f64; 2]> {
    Ok([within(key, east, -FAR_M, FAR_M)?, within(key, north, -FAR_M, FAR_M)?])
}

/// WA-10. Each statement is checked with those before it, so that an error names the one that contradicts them.
fn knowledge(types: &[RawType], priors: &[RawPrior], key: &impl Fn(&str) -> String) -> Checked<Knowledge> {
    let mut knowledge = Knowledge::default();
    for (index, target) in types.iter().enumerate() {
        let key = |part: &str| key(&format!("type[{index}].{part}"));
        let name = target.name.as_str();
        // Names are columns of files that have no quotes.
        let fits = TargetType::new(name, 1.0).is_some() && name.trim() == name && !name.contains([',', '|', '"']);
        if !fits {
            let what = format!(
                "{name:?} cannot be a name: use 1 to {TYPE_NAME_MAX} printable ASCII characters, none of them , | or \", and \
                 no blank at either end"
            );
            return Err(problem(key("name"), what));
        }
        if types[..index].iter().any(|other| other.name == target.name) {
            let what = format!("{name:?} is the name of an earlier type; say everything of it there");
            return Err(problem(key("name"), what));
        }
        let emissions = target.emissions.iter().enumerate().map(|(place, bands)| {
            let key = |part: &str| key(&format!("emissions[{place}].{part}"));
            Ok(EmissionBand {
                frequency_hz: band(&key("frequency_hz"), bands.frequency_hz)?,
                pulse_interval_s: given(bands.pulse_interval_s, |interval| {
                    band(&key("pulse_interval_s"), interval)
                })?,
            })
        });
        knowledge.types.push(prior::TargetType {
            name: target.name.clone(),
            emissions: emissions.collect::<Checked<_>>()?,
        });
    }
    for (index, prior) in priors.iter().enumerate() {
        let key = key(&format!("prior[{index}]"));
        let prior = prior.checked(&key, &knowledge.types)?;
        knowledge.priors.push(prior);
        if let Some(fault) = knowledge.fault() {
            return Err(problem(key, fault));
        }
    }
    Ok(knowledge)
}

/// Lowest and highest value.
fn band(key: &str, [low, high]: [f64; 2]) -> Checked<[f64; 2]> {
    // Written so that NaN is refused.
    if low > 0.0 && low <= high && high.is_finite() {
        return Ok([low, high]);
    }
    let what = format!("[{low}, {high}]: write the lowest and the highest value, greater than 0");
    Err(problem(key, what))
}

impl RawPrior {
    fn checked(&self, key: &str, types: &[prior::TargetType]) -> Checked<Prior> {
        let place = match (self.sector, self.circle) {
            (Some(sector), None) => sector.checked(&format!("{key}.sector"))?,
            (None, Some(circle)) => {
                let (centre_m, radius_m) = circle.checked(&format!("{key}.circle"))?;
                Place::Circle { centre_m, radius_m }
            }
            _ => {
                return Err(problem(
                    key,
                    "needs exactly one of sector and circle: say of which place this is known",
                ));
            }
        };
        let mut of_types = Vec::new();
        for (name, probability) in &self.types {
            let key = format!("{key}.types.{name}");
            let Some(number) = types.iter().position(|target| target.name == *name) else {
                let what = format!("no [[wide_area.type]] is named {name:?}; describe it there, or correct the name");
                return Err(problem(key, what));
            };
            of_types.push((number, within(&key, *probability, 0.0, 1.0)?));
        }
        let mut formations: Vec<(u32, f64)> = Vec::new();
        for (size, probability) in &self.formations {
            let key = format!("{key}.formations.{size}");
            let members = size.parse().ok().filter(|members| (1..=TARGETS_MAX).contains(members));
            let Some(members) = members else {
                let what = format!("{size:?} is no number of members; it must lie between 1 and {TARGETS_MAX}");
                return Err(problem(key, what));
            };
            if formations.iter().any(|(other, _)| *other == members) {
                let what = format!("formations of {members} are stated twice; leave one of them out");
                return Err(problem(key, what));
            }
            formations.push((members, within(&key, *probability, 0.0, 1.0)?));
        }
        sum_to_1(&format!("{key}.types"), self.types.values())?;
        sum_to_1(&format!("{key}.formations"), self.formations.values())?;
        let least_key = format!("{key}.formation_probability_min");
        Ok(Prior {
            place,
            types: of_types,
            formations,
            formation_probability_min: within(&least_key, self.formation_probability_min, 1e-6, 1.0)?,
        })
    }
}

fn sum_to_1<'a>(key: &str, probabilities: impl Iterator<Item = &'a f64>) -> Checked<()> {
    let sum: f64 = probabilities.sum();
    if sum <= 1.0 + SUM_MORE {
        return Ok(());
    }
    let what = format!("the probabilities sum to {sum:.6}; lower them until they sum to 1 at most");
    Err(problem(key, what))
}

impl RawSector {
    fn checked(self, key: &str) -> Checked<Place> {
        let bearings_key = format!("{key}.bearings_deg");
        let bearing = |degrees: f64| within(&bearings_key, degrees, -360.0, 360.0);
        let [first, last] = self.bearings_deg;
        let bearings_deg = [bearing(first)?, bearing(last)?];
        if (last - first).rem_euclid(360.0) == 0.0 {
            let what = format!(
                "[{first}, {last}]: write two different bearings, clockwise from the first to the last; all around is a circle"
            );
            return Err(problem(bearings_key, what));
        }
        Ok(Place::Sector {
            from_m: point(&format!("{key}.from_m"), self.from_m)?,
            bearings_rad: bearings_deg.map(f64::to_radians),
        })
    }
}

impl RawSelection {
    /// Checks every value; keys begin with `prefix`. `priorities` are (sensor, priority).
    pub(crate) fn settings(&self, prefix: &str, priorities: Vec<(u32, u32)>) -> Checked<Selection> {
        let key = |part: &str| format!("{prefix}selection.{part}");
        let [_, longest_s] = TIMES_S;
        Ok(Selection {
            age_max_ns: given(self.age_max_s, |age_s| {
                within(&key("age_max_s"), age_s, 0.0, longest_s).map(nanoseconds)
            })?,
            sigma_max_m: given(self.sigma_max_m, |sigma_m| {
                within(&key("sigma_max_m"), sigma_m, 1e-3, FAR_M)
            })?,
            priorities,
            same_time_ns: nanoseconds(within(&key("same_time_s"), self.same_time_s, 0.0, longest_s)?),
            kept_weight: given(self.kept_weight, |weight| {
                within(&key("kept_weight"), weight, 0.0, 0.999_999)
            })?,
        })
    }
}

#[cfg(test)]
#[path = "wide_area_tests.rs"]
mod tests;

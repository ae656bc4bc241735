//! What traffic there is.

use serde::Deserialize;

use crate::error::{SettingsError, count_within, within};
use crate::formation::Formation;
use crate::formation_settings::FormationSettings;

/// Most targets of a scenario.
pub const TARGETS_MAX: u32 = 100_000;

/// The targets of a scenario. What is not given is as in `ScenarioSettings::default()`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ScenarioSettings {
    /// How many targets there are beside formations, 1 to 100,000, with formations also 0 (default 80). Those that no share
    /// speaks of fly en route.
    pub targets: u32,
    /// Half the side of the square in which en-route paths have their centres, metres, 40,000 to 400,000 (100,000).
    pub half_width_m: f64,
    /// Share of targets that depart from the airport at the origin and come back to land there (0.2).
    pub terminal_share: f64,
    /// Share of targets that fly holding patterns, several above each other (0.1).
    pub holding_share: f64,
    /// Share of targets that are vehicles on the airport's surface (0.2).
    pub surface_share: f64,
    /// Share of targets that are ships, which keep their course for hours (0).
    pub ship_share: f64,
    /// Greatest speed of ships, m/s, 0.1 to 30; the slowest goes a third of it (12).
    pub ship_speed_max_mps: f64,
    /// Share of the en-route targets that meet another one, crossing its path at the same time in every lap (0.3).
    pub crossing_share: f64,
    /// Formations, kind by kind (none). Their members have the numbers after those of all others.
    #[serde(rename = "formation")]
    pub formations: Vec<FormationSettings>,
}

impl Default for ScenarioSettings {
    fn default() -> Self {
        Self {
            targets: 80,
            half_width_m: 100_000.0,
            terminal_share: 0.2,
            holding_share: 0.1,
            surface_share: 0.2,
            ship_share: 0.0,
            ship_speed_max_mps: 12.0,
            crossing_share: 0.3,
            formations: Vec::new(),
        }
    }
}

impl ScenarioSettings {
    /// The usual settings with nothing but en-route targets.
    #[cfg(test)]
    pub(crate) fn without_others() -> Self {
        Self {
            terminal_share: 0.0,
            holding_share: 0.0,
            surface_share: 0.0,
            ..Self::default()
        }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// The first setting that cannot be used, with its value and what it has to be.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let least = u32::from(self.formations.is_empty());
        count_within("targets", self.targets, least, TARGETS_MAX)?;
        within("half_width_m", self.half_width_m, 40_000.0, 400_000.0)?;
        within("terminal_share", self.terminal_share, 0.0, 1.0)?;
        within("holding_share", self.holding_share, 0.0, 1.0)?;
        within("surface_share", self.surface_share, 0.0, 1.0)?;
        within("ship_share", self.ship_share, 0.0, 1.0)?;
        within("ship_speed_max_mps", self.ship_speed_max_mps, 0.1, 30.0)?;
        within("crossing_share", self.crossing_share, 0.0, 1.0)?;
        let sum = self.terminal_share + self.holding_share + self.surface_share + self.ship_share;
        if sum > 1.0 + 1e-9 {
            return Err(SettingsError::new(
                "terminal_share + holding_share + surface_share + ship_share",
                sum,
                "at most 1",
            ));
        }
        self.formations.iter().try_for_each(FormationSettings::validate)?;
        let members = |kind: &FormationSettings| kind.count.saturating_mul(kind.members_max());
        let most = self
            .formations
            .iter()
            .map(members)
            .fold(self.targets, u32::saturating_add);
        count_within("targets + members of formations", most, 1, TARGETS_MAX)
    }

    /// How many targets there are with this seed: those that are not in formation, and all members.
    pub fn target_count(&self, seed: u64) -> u32 {
        let members: u32 = self.drawn_formations(seed).map(|formation| formation.members).sum();
        self.targets + members
    }

    pub(crate) fn drawn_formations(&self, seed: u64) -> impl Iterator<Item = Formation> + '_ {
        let kinds = self.formations.iter().enumerate();
        kinds.flat_map(move |(kind, settings)| {
            (0..settings.count).map(move |index| Formation::draw(settings, seed, kind, index))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_key_value_and_limit() {
        ScenarioSettings::default().validate().expect("defaults are usable");
        let refused = |settings: &str| {
            toml::from_str::<ScenarioSettings>(settings)
                .expect("well-formed")
                .validate()
                .expect_err("not usable")
                .to_string()
        };
        assert_eq!(refused("targets = 0"), "targets = 0: must be between 1 and 100000");
        assert_eq!(
            refused("half_width_m = nan"),
            "half_width_m = NaN: must be between 40000 and 400000"
        );
        assert_eq!(
            refused("terminal_share = 0.75\nsurface_share = 0.5\nholding_share = 0"),
            "terminal_share + holding_share + surface_share + ship_share = 1.25: must be at most 1"
        );
        assert!(toml::from_str::<ScenarioSettings>("target = 3").is_err(), "unknown key");
    }
}

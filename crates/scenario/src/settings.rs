//! Settings of the traffic.

use settings::SettingsError;

use crate::formation::Formation;
use crate::formation_settings::FormationSettings;

/// Maximum number of targets of a scenario.
pub const TARGETS_MAX: u32 = 100_000;

settings::settings! {
    /// The targets of a scenario.
    pub struct ScenarioSettings {
        check ScenarioSettings::check;
        /// Number of targets beside formations, at least 1 without formations. Targets outside the configured shares
        /// fly en route.
        targets: u32 = 80, in [0, TARGETS_MAX];
        /// Half the side of the square in which en-route paths have their centres.
        half_width_m: f64 = 100_000.0, in [40_000, 400_000];
        /// Share of targets that depart from the airport at the origin and come back to land there.
        terminal_share: f64 = 0.2, in [0, 1];
        /// Share of targets that fly holding patterns, several above each other.
        holding_share: f64 = 0.1, in [0, 1];
        /// Share of targets that are vehicles on the airport's surface.
        surface_share: f64 = 0.2, in [0, 1];
        /// Share of targets that are ships, which keep their course for hours.
        ship_share: f64 = 0.0, in [0, 1];
        /// Greatest speed of ships; the least speed is a third of it.
        ship_speed_max_mps: f64 = 12.0, in [0.1, 30];
        /// Share of the en-route targets that meet another target, crossing its path at the same time in every lap.
        crossing_share: f64 = 0.3, in [0, 1];
        /// Formations of a kind. Their members have the numbers after all other targets.
        formations as "formation": Vec<FormationSettings> = Vec::new();
    }
}

impl ScenarioSettings {
    /// Returns the default settings with en-route targets only.
    #[cfg(test)]
    pub(crate) fn without_others() -> Self {
        Self {
            terminal_share: 0.0,
            holding_share: 0.0,
            surface_share: 0.0,
            ..Self::default()
        }
    }

    fn check(&self) -> Result<(), SettingsError> {
        let sum = self.terminal_share + self.holding_share + self.surface_share + self.ship_share;
        if sum > 1.0 + 1e-9 {
            let what = format!("with holding_share, surface_share and ship_share it is {sum}; at most 1 is possible");
            return Err(SettingsError::new("terminal_share", what));
        }
        let members = |kind: &FormationSettings| kind.count.saturating_mul(kind.members_max());
        let most = self
            .formations
            .iter()
            .map(members)
            .fold(self.targets, u32::saturating_add);
        if (1..=TARGETS_MAX).contains(&most) {
            return Ok(());
        }
        let what = format!("with members of formations there are {most}; it must lie between 1 and {TARGETS_MAX}");
        Err(SettingsError::new("targets", what))
    }

    /// Returns the number of targets for this seed: single targets, and all members of formations.
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
        settings::check(&ScenarioSettings::default()).expect("defaults are usable");
        let read = |text: &str| {
            let document = settings::Document::parse(text, &[]).expect("well-formed");
            document.read::<ScenarioSettings>().expect_err("not usable").to_string()
        };
        for (text, expected) in [
            (
                "targets = 0",
                "targets: with members of formations there are 0; it must lie between 1 and 100000",
            ),
            (
                "half_width_m = nan",
                "half_width_m: NaN is out of range; it must lie between 40000 and 400000",
            ),
            (
                "terminal_share = 0.75\nsurface_share = 0.5\nholding_share = 0",
                "terminal_share: with holding_share, surface_share and ship_share it is 1.25; at most 1 is possible",
            ),
            ("target = 3", "target: unknown key; there are: targets, half_width_m"),
        ] {
            let error = read(text);
            assert!(error.starts_with(expected), "{error}");
        }
    }
}

//! `koseki new`: a commented configuration to begin a site with.

use std::fs::OpenOptions;
use std::io::Write as _;

use anyhow::Context as _;
use offline::Usage;

use crate::args::{NewConfig, SiteKind};

impl SiteKind {
    /// The configuration of a site of this kind.
    pub(crate) const fn text(self) -> &'static str {
        match self {
            Self::Air => include_str!("../templates/air.toml"),
            Self::Sea => include_str!("../templates/sea.toml"),
            Self::Drones => include_str!("../templates/drones.toml"),
            Self::Range => include_str!("../templates/range.toml"),
            Self::Research => include_str!("../templates/research.toml"),
        }
    }
}

/// Writes the configuration to standard output, or into a file that does not exist yet.
///
/// # Errors
/// If the file exists or cannot be written.
pub(crate) fn run(new: &NewConfig) -> anyhow::Result<()> {
    let text = new.kind.text();
    let Some(path) = &new.out else {
        return crate::print(text);
    };
    let opened = OpenOptions::new().write(true).create_new(true).open(path);
    let mut file = match opened {
        Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {
            return Err(Usage(format!("{} exists: name another file", path.display())).into());
        }
        opened => opened.with_context(|| format!("{} cannot be written", path.display()))?,
    };
    file.write_all(text.as_bytes())
        .with_context(|| format!("{} cannot be written", path.display()))?;
    runtime::notice(format_args!(
        "koseki: {path}: put your places and addresses into it, then `koseki check {path}`",
        path = path.display()
    ));
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use clap::ValueEnum as _;

    use super::*;
    use crate::config::Config;

    #[test]
    fn every_configuration_is_sound_short_and_commented() {
        for kind in SiteKind::value_variants() {
            let text = kind.text();
            Config::parse(Path::new("new.toml"), text, &[]).unwrap_or_else(|error| panic!("{kind:?}: {error}"));
            assert!(text.lines().count() <= 25, "{kind:?}");
            assert!(text.starts_with("# ") && text.matches(" # ").count() >= 3, "{kind:?}");
        }
    }
}

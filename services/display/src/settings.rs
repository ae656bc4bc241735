//! Keys of the display.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use deployment::{Deployment, Parts, Secret};
use settings::{KeyTable, SettingsError};
use web::HostName;

use crate::label_settings::LabelSettings;
use crate::views::Views;

/// Fewest characters of a token: nobody may guess it.
const TOKEN_MIN: usize = 16;

settings::settings! {
    /// Keys of a deployment's file.
    pub struct Keys {
        /// Display process.
        display: Settings = Settings::default();
    }

    /// The display process.
    pub struct Settings {
        check Settings::check;
        /// Address and port at which browsers reach the display; off: no display process.
        listen: Option<String> = None;
        /// Number of further ports to try if the port is in use.
        more_ports: u32 = 0, in [0, 1000];
        /// Allow an address reachable by other machines, without encryption: every host on the path can read the
        /// track picture and the token. A proxy with TLS in front of a loopback address is better.
        insecure: bool = false;
        /// Token that every browser must present once, as `/?token=…`; needed on an address that other machines can
        /// reach. `KOSEKI_DISPLAY_TOKEN` in the environment replaces it, and `--set` does not.
        token: Option<String> = None;
        /// Token of the operators, who give orders. The display must listen on a loopback address; other machines
        /// connect through a proxy with TLS. `KOSEKI_DISPLAY_OPERATOR_TOKEN` in the environment replaces it, and
        /// `--set` does not.
        operator_token: Option<String> = None, usually "none: no orders";
        /// Further names of this machine in requests, besides its address and localhost.
        hosts: Vec<HostName> = Vec::new(), usually "none";
        /// Sites whose pages may open the WebSocket for Foxglove (`/foxglove`), as in "https://app.foxglove.dev";
        /// programs that are no browsers need none.
        foxglove_sites: Vec<String> = Vec::new(), usually "none";
        /// Length of the stored past of the picture.
        history_s: u32 = 600, in [0, 86_400];
        /// Greatest memory for the past, megabytes; the oldest states are dropped first.
        history_mb: u32 = 256, in [1, 65_536];
        /// GeoJSON files drawn under the tracks, relative to the data folder unless absolute.
        overlays: Vec<String> = Vec::new(), usually "none";
        /// GeoJSON file with polygons of land instead of the world's coast at 1:50 million, relative to the data folder
        /// unless absolute.
        coast: Option<String> = None, usually "the world's coast";
        /// Magnetic declination at the system origin, positive to the east: bearings are then shown magnetic, too.
        declination_deg: Option<f64> = None, in [-180, 180], usually "true bearings only";
        /// Labels of the tracks.
        labels: LabelSettings = LabelSettings::default();
        /// Views that all pages share.
        views: ViewSettings = ViewSettings::default();
    }

    /// Views of the page that all pages share.
    pub struct ViewSettings {
        /// View of a page that is opened without one: what follows `#` in the address of a page that shows it, as in
        /// "theme=day&vector=360".
        start: String = String::new(), usually "all tracks, at night";
        /// File in which operators keep named views for all pages, relative to the data folder unless absolute.
        file: Option<String> = None, usually "none: views are kept in each browser alone";
    }
}

impl ViewSettings {
    /// Reads the kept views; relative paths begin in the folder `data`.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub(crate) fn open(&self, data: &Path) -> anyhow::Result<Views> {
        Views::open(&self.start, self.file.as_ref().map(|file| data.join(file)))
    }
}

/// Files of the map under the tracks.
#[derive(Clone, Debug, Default)]
pub(crate) struct MapFiles {
    /// GeoJSON overlays.
    pub(crate) overlays: Vec<PathBuf>,
    /// Polygons of land; `None`: the world's coast.
    pub(crate) coast: Option<PathBuf>,
}

impl Settings {
    fn check(&self) -> Result<(), SettingsError> {
        let Some(listen) = &self.listen else { return Ok(()) };
        let listen: SocketAddr = listen.parse().map_err(|_| {
            let what = format!("\"{listen}\" is no address with a port; write it as in \"127.0.0.1:8900\"");
            SettingsError::new("listen", what)
        })?;
        if !listen.ip().is_loopback() {
            self.check_public(listen)?;
        }
        for (key, token) in [("token", &self.token), ("operator_token", &self.operator_token)] {
            let allowed = |letter: char| letter.is_ascii_alphanumeric() || letter == '-' || letter == '_';
            if let Some(token) = token
                && (token.len() < TOKEN_MIN || !token.chars().all(allowed))
            {
                let what =
                    format!("needs {TOKEN_MIN} letters, digits, - or _, or more; `openssl rand -hex 16` makes one");
                return Err(SettingsError::new(key, what));
            }
        }
        for site in &self.foxglove_sites {
            let parts = site.split_once("://");
            if !parts.is_some_and(|(scheme, name)| !scheme.is_empty() && !name.contains(['/', ' '])) {
                let what =
                    format!("\"{site}\" is no site; write it without a path, as in \"https://app.foxglove.dev\"");
                return Err(SettingsError::new("foxglove_sites", what));
            }
        }
        match &self.operator_token {
            Some(token) => self.check_operators(token, listen),
            None => Ok(()),
        }
    }

    /// Needs of a display that accepts orders.
    fn check_operators(&self, token: &str, listen: SocketAddr) -> Result<(), SettingsError> {
        if !listen.ip().is_loopback() {
            let what = format!(
                "orders need a loopback address, and {listen} can be reached from other machines without encryption; use \
                 127.0.0.1 behind a proxy that ends TLS"
            );
            return Err(SettingsError::new("operator_token", what));
        }
        if self.token.as_deref() == Some(token) {
            let what = "is the token of all viewers; give operators another one";
            return Err(SettingsError::new("operator_token", what));
        }
        Ok(())
    }

    /// Needs of an address that other machines can reach.
    fn check_public(&self, listen: SocketAddr) -> Result<(), SettingsError> {
        if !self.insecure {
            let what = format!(
                "{listen} can be reached from other machines, and nothing is encrypted; use 127.0.0.1 behind a proxy that \
                 ends TLS, or set insecure = true beside it"
            );
            return Err(SettingsError::new("listen", what));
        }
        if self.token.is_none() {
            let what = format!("{listen} can be reached from other machines; give a token that browsers have to show");
            return Err(SettingsError::new("token", what));
        }
        Ok(())
    }

    /// Returns the settings of a display that no configuration describes, at the address `listen` with a port; `None`:
    /// this machine alone, the first free port from 8900.
    ///
    /// # Errors
    /// If `listen` is no address with a port, or not one of this machine alone.
    pub fn unconfigured(listen: Option<&str>) -> Result<Self, SettingsError> {
        let settings = Self {
            listen: Some(listen.unwrap_or("127.0.0.1:8900").to_owned()),
            more_ports: if listen.is_some() { 0 } else { 100 },
            ..Self::default()
        };
        settings.check()?;
        Ok(settings)
    }

    /// Takes over how `other` shows tracks: labels, start view, declination.
    #[must_use]
    pub fn looking_like(self, other: &Self) -> Self {
        let views = ViewSettings {
            start: other.views.start.clone(),
            file: None,
        };
        Self {
            labels: other.labels.clone(),
            declination_deg: other.declination_deg,
            views,
            ..self
        }
    }

    /// Takes over the files of the map of `other`, whose paths begin in the folder `data`.
    #[must_use]
    pub fn with_maps(self, other: &Self, data: &Path) -> Self {
        let whole = |file: &String| data.join(file).to_string_lossy().into_owned();
        Self {
            overlays: other.overlays.iter().map(whole).collect(),
            coast: other.coast.as_ref().map(whole),
            ..self
        }
    }

    /// Returns the address and first port of the display; `None`: there is no display.
    pub fn address(&self) -> Option<SocketAddr> {
        self.listen.as_ref()?.parse().ok()
    }

    /// Returns the most memory of the past, bytes.
    pub(crate) fn history_bytes(&self) -> usize {
        self.history_mb as usize * 1_000_000
    }

    /// Returns the paths of the files of the map in the folder `data`.
    pub(crate) fn maps_in(&self, data: &Path) -> MapFiles {
        MapFiles {
            overlays: self.overlays.iter().map(|file| data.join(file)).collect(),
            coast: self.coast.as_ref().map(|file| data.join(file)),
        }
    }
}

impl Parts for Keys {
    fn tables(&mut self) -> Vec<&mut dyn KeyTable> {
        vec![self]
    }

    fn join(&self, deployment: &mut Deployment) -> Result<(), SettingsError> {
        let display = &self.display;
        deployment.services.display = display.listen.is_some();
        let tokens = [
            (&display.token, "hidden-token-"),
            (&display.operator_token, "hidden-order-token-"),
        ];
        let secrets = tokens.into_iter().filter_map(|(token, placeholder)| {
            Some(Secret {
                text: token.clone().filter(|_| display.listen.is_some())?,
                placeholder: format!("{placeholder}{}", "x".repeat(TOKEN_MIN)),
            })
        });
        deployment.services.secrets.extend(secrets);
        Ok(())
    }
}

//! Keys of gateways, and their place in a deployment.

use std::collections::BTreeSet;

use asterix::Category;
use deployment::{Deployment, NetworkOutput, Parts, Source, check_name};
use outgoing::HeightReference;
use settings::{KeyTable, Seconds, SettingsError};

use crate::cue_settings::CueOutletSettings;
use crate::destination::Destination;
use crate::outlet::{OutletKeys, OutletWay};

/// Categories that a gateway can send of a sensor.
const SENSOR_CATEGORIES: [u8; 4] = [10, 20, 21, 48];
/// Categories of status messages.
const STATUS_CATEGORIES: [u8; 2] = [65, 63];
/// Category that a gateway sends of the fused picture.
const SYSTEM_CATEGORY: u8 = 62;

settings::words! {
    /// Form of a gateway's output.
    pub enum OutputFormat {
        /// ASTERIX data blocks.
        Asterix = "asterix",
        /// Cursor on Target events of the fused picture.
        Cot = "cot",
    }
}

settings::settings! {
    /// Keys of a deployment's file.
    pub struct Keys {
        /// Network output: a gateway process.
        gateways as "gateway": Vec<Settings> = Vec::new();
        /// Cues to sensor controllers: a gateway process for rows.
        cue_outlets as "cue_outlet": Vec<CueOutletSettings> = Vec::new();
    }

    /// A part of the Earth between two parallels and two meridians (WGS-84).
    #[derive(Copy)]
    pub struct Area {
        check Area::check;
        /// Latitude of the southern edge, −90 to 90.
        south_deg: f64;
        /// Latitude of the northern edge, −90 to 90.
        north_deg: f64;
        /// Longitude of the western edge, −180 to 180.
        west_deg: f64;
        /// Longitude of the eastern edge, −180 to 180; smaller than the western longitude if the area crosses 180°.
        east_deg: f64;
    }

    /// Network output to a user.
    pub struct Settings {
        check Settings::check;
        /// Name of the gateway process.
        name: String;
        /// Multicast group or address, with the port, as destination of the datagrams.
        send_to: Option<Destination> = None, usually "none: clients connect";
        /// Address and port at which clients connect (TCP), for Cursor on Target.
        listen: Option<Destination> = None, usually "none: datagrams are sent";
        /// Permit a `listen` that other machines can reach: whoever reaches it reads everything, unencrypted.
        remote: bool = false;
        /// Form of the output.
        format: OutputFormat = OutputFormat::Asterix;
        /// Time until clients of Cursor on Target drop a track without a new event; longer than `refresh_s`.
        stale_s: Seconds = Seconds::of(30.0), in [1, 3600];
        /// Interface on which datagrams leave, by address, name or index.
        interface: Option<String> = None, usually "the machine's choice";
        /// Time to live of the datagrams. Without the key, 1 for a group: the datagrams stay in the local network.
        ttl: Option<u8> = None, usually "the machine's choice";
        /// Source of the sensor tracks to send.
        source: Option<String> = None, usually "none: the fused picture is sent";
        /// Send the track picture from local sources only, without data of other centres: for another centre, which
        /// must not get back its own data. Needs `fusion.exchange`.
        own: bool = false;
        /// ASTERIX category: 62 for the fused picture; 10, 20, 21 or 48 for sensor tracks.
        category: Option<u8> = None, usually "62 for the fused picture";
        /// Edition of the category.
        edition: Option<String> = None, usually "the newest one known";
        /// System area code of the sender.
        sac: Option<u8> = None, usually "must be given for ASTERIX";
        /// System identification code of the sender.
        sic: Option<u8> = None, usually "must be given for ASTERIX";
        /// Time between two reports of a track; 0: every report is sent.
        refresh_s: Seconds = Seconds::of(1.0), in [0, 3600];
        /// Time between two status messages.
        status_s: Seconds = Seconds::of(1.0), in [0.1, 3600];
        /// Categories of the status messages beside the fused picture: 65 for the system, 63 for its sensors.
        status: Vec<u8> = vec![65, 63];
        /// Area of the tracks that are sent to the user; a track that leaves the area is reported as ended. Needs
        /// `refresh_s` above 0.
        area: Option<Area> = None, usually "everywhere";
        /// Lowest and highest flight level (hundreds of feet, from the tracks' heights) of the tracks that are sent to
        /// the user; tracks of unknown height are always sent. Needs `refresh_s` above 0.
        levels: Option<[f64; 2]> = None, usually "all";
        /// Largest size of a datagram, bytes: by default the room of an Ethernet frame beside the headers of IPv4 and
        /// UDP, at most the limit of IPv4.
        block_bytes: usize = 1472, in [256, 65_507];
        /// Send the call sign in I062/245, too, for receivers that know an edition before 1.16 only. Later editions
        /// have the call sign in I062/380 alone.
        target_identification: bool = false;
        /// Reference of the heights of system tracks; selects the items for heights.
        heights: HeightReference = HeightReference::Barometric;
    }
}

/// Content that a gateway sends.
#[derive(Clone, Copy, Debug)]
pub(crate) enum GatewayContent<'a> {
    /// The fused picture.
    Fused,
    /// The fused picture from local sources only.
    Own,
    /// The sensor tracks of a source.
    OfSource(&'a Source),
}

impl Settings {
    fn check(&self) -> Result<(), SettingsError> {
        match (self.way()?, self.format) {
            (OutletWay::Lines(..), OutputFormat::Asterix) => {
                let what = "is for format = \"cot\"; ASTERIX leaves in datagrams: give send_to";
                return Err(SettingsError::new("listen", what));
            }
            (_, OutputFormat::Cot) => return self.check_cot(),
            (OutletWay::Datagrams(_), OutputFormat::Asterix) => self.codes().map(|_| ())?,
        }
        match (&self.source, self.category) {
            (Some(_), _) if self.own => {
                let what = "is about the fused picture; a source's sensor tracks are its own: leave one of the two out";
                return Err(SettingsError::new("own", what));
            }
            (None, Some(other)) if other != SYSTEM_CATEGORY => {
                let what =
                    format!("{other}: the fused picture goes out in category 62; for sensor tracks give a source");
                return Err(SettingsError::new("category", what));
            }
            (Some(_), category) if category.is_none_or(|number| !SENSOR_CATEGORIES.contains(&number)) => {
                let what = "sensor tracks go out in category 10, 20, 21 or 48: give one of them";
                return Err(SettingsError::new("category", what));
            }
            _ => {}
        }
        if let Some(other) = self
            .status
            .iter()
            .find(|category| !STATUS_CATEGORIES.contains(category))
        {
            let what = format!("{other}: status messages are of category 65 or 63");
            return Err(SettingsError::new("status", what));
        }
        self.check_selection()?;
        self.table().map(|_| ())
    }

    /// Checks area and levels of the tracks that are sent.
    fn check_selection(&self) -> Result<(), SettingsError> {
        if let Some([low, high]) = self.levels.filter(|[low, high]| !(*low..=*high).contains(low)) {
            let what = format!("{low} lies above {high}; write the lower level first");
            return Err(SettingsError::new("levels", what));
        }
        if self.refresh_s.ns() == 0 && (self.area.is_some() || self.levels.is_some()) {
            let what = "0: whether a track has left the area or the levels is known only of tracks that have turns; \
                        give a period";
            return Err(SettingsError::new("refresh_s", what));
        }
        Ok(())
    }

    /// Checks the keys of Cursor on Target.
    fn check_cot(&self) -> Result<(), SettingsError> {
        let given = [
            ("source", self.source.is_some()),
            ("category", self.category.is_some()),
            ("edition", self.edition.is_some()),
            ("sac", self.sac.is_some()),
            ("sic", self.sic.is_some()),
            ("target_identification", self.target_identification),
        ];
        if let Some((key, _)) = given.into_iter().find(|(_, is_given)| *is_given) {
            let what = "is for ASTERIX, and format = \"cot\" sends the fused picture: leave one of the two out";
            return Err(SettingsError::new(key, what));
        }
        if self.stale_s.ns() <= self.refresh_s.ns() {
            let what = format!("must be longer than refresh_s, {}", self.refresh_s.ns() as f64 / 1e9);
            return Err(SettingsError::new("stale_s", what));
        }
        self.check_selection()
    }

    /// Returns how blocks leave.
    ///
    /// # Errors
    /// If not exactly one way is given, or a key does not fit the way.
    pub(crate) fn way(&self) -> Result<OutletWay, SettingsError> {
        self.outlet().way()
    }

    fn outlet(&self) -> OutletKeys<'_> {
        OutletKeys {
            send_to: self.send_to,
            listen: self.listen,
            interface: self.interface.as_deref(),
            ttl: self.ttl,
            remote: self.remote,
        }
    }

    /// Returns system area code and system identification code.
    ///
    /// # Errors
    /// If one of them is not given.
    pub(crate) fn codes(&self) -> Result<[u8; 2], SettingsError> {
        let given = |key: &str, code: Option<u8>| {
            code.ok_or_else(|| SettingsError::new(key, "must be given for ASTERIX, 0 to 255"))
        };
        Ok([given("sac", self.sac)?, given("sic", self.sic)?])
    }

    /// Returns the category and edition in which the gateway sends.
    ///
    /// # Errors
    /// If the edition is not known.
    pub fn table(&self) -> Result<&'static Category, SettingsError> {
        let number = self.category.unwrap_or(SYSTEM_CATEGORY);
        asterix::stated(number, self.edition.as_deref()).map_err(|what| SettingsError::new("edition", what))
    }

    /// Returns the content that the gateway of `deployment` sends.
    ///
    /// # Errors
    /// If the deployment has no such source.
    pub(crate) fn content<'a>(&self, deployment: &'a Deployment) -> Result<GatewayContent<'a>, SettingsError> {
        match &self.source {
            None if self.own => Ok(GatewayContent::Own),
            None => Ok(GatewayContent::Fused),
            Some(name) => {
                let missing = || SettingsError::new("source", format!("there is no source named \"{name}\""));
                deployment
                    .source(name)
                    .map(GatewayContent::OfSource)
                    .ok_or_else(missing)
            }
        }
    }
}

impl Area {
    fn check(&self) -> Result<(), SettingsError> {
        let sides = [
            ("south_deg", self.south_deg, 90.0),
            ("north_deg", self.north_deg, 90.0),
            ("west_deg", self.west_deg, 180.0),
            ("east_deg", self.east_deg, 180.0),
        ];
        for (side, value, limit) in sides {
            if !(-limit..=limit).contains(&value) {
                let what = format!("{value} must lie between -{limit} and {limit}");
                return Err(SettingsError::new(side, what));
            }
        }
        if self.south_deg > self.north_deg {
            let what = format!("{} lies north of north_deg, {}", self.south_deg, self.north_deg);
            return Err(SettingsError::new("south_deg", what));
        }
        Ok(())
    }
}

impl Keys {
    /// Returns the gateway called `name`.
    pub fn gateway(&self, name: &str) -> Option<&Settings> {
        self.gateways.iter().find(|gateway| gateway.name == name)
    }

    /// Returns the cue outlet called `name`.
    pub fn cue_outlet(&self, name: &str) -> Option<&CueOutletSettings> {
        self.cue_outlets.iter().find(|outlet| outlet.name == name)
    }

    /// Names of the processes, each with the key of its name.
    pub fn names(&self) -> impl Iterator<Item = (String, &String)> {
        let gateways = self.gateways.iter().enumerate();
        let outlets = self.cue_outlets.iter().enumerate();
        let gateways = gateways.map(|(index, each)| (format!("gateway[{index}].name"), &each.name));
        gateways.chain(outlets.map(|(index, each)| (format!("cue_outlet[{index}].name"), &each.name)))
    }
}

impl Parts for Keys {
    fn tables(&mut self) -> Vec<&mut dyn KeyTable> {
        vec![self]
    }

    fn join(&self, deployment: &mut Deployment) -> Result<(), SettingsError> {
        let mut names = BTreeSet::new();
        for (key, name) in self.names() {
            check_name(&key, name)?;
            if !names.insert(name) {
                let what = format!("\"{name}\" is the name of an earlier gateway or cue outlet; give each its own");
                return Err(SettingsError::new(key, what));
            }
            let of_sources = deployment.sources.iter().map(|source| &source.adapter);
            let of_sensors = deployment.wide_area_sensors.iter().map(|sensor| &sensor.adapter);
            let of_platforms = deployment.platforms.iter().map(|platform| &platform.name);
            if of_sources
                .chain(of_sensors)
                .chain(of_platforms)
                .any(|adapter| adapter == name)
            {
                let what = format!("\"{name}\" is the name of an adapter process; give this one another");
                return Err(SettingsError::new(key, what));
            }
        }
        for (index, each) in self.gateways.iter().enumerate() {
            let key = |part: &str| format!("gateway[{index}].{part}");
            let content = each.content(deployment);
            let content = content.map_err(|error| error.under(&format!("gateway[{index}]")))?;
            if matches!(content, GatewayContent::Own) && !deployment.system_tracks.exchange {
                let what = "needs fusion.exchange = true, which says what the sensors here know";
                return Err(SettingsError::new(key("own"), what));
            }
        }
        let output = |gateway: &Settings| {
            Ok(NetworkOutput {
                name: gateway.name.clone(),
                sender: gateway.outlet().datagrams()?,
            })
        };
        let outputs: Result<Vec<_>, SettingsError> = self.gateways.iter().map(output).collect();
        deployment.services.gateways = outputs?;
        for (index, outlet) in self.cue_outlets.iter().enumerate() {
            let output = outlet.output(deployment);
            let output = output.map_err(|error| error.under(&format!("cue_outlet[{index}]")))?;
            deployment.services.gateways.push(output);
        }
        Ok(())
    }
}

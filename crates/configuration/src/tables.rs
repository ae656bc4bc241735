//! The tables of a deployment's file, as they are written: every key that belongs to no other crate. Services declare
//! their own tables ([`Unread`]).
//!
//! What is checked here is what one table says of itself; how tables fit together is checked in `check` and its like.

use std::collections::BTreeMap;

use alerts::{AlertSettings, AreaSettings};
use deployment::Technology;
use net::AllowedSenders;
use platform::{Assumed, JumpLimits, Mount};
use reception::{CovarianceModel, Method, PlausibilityLimits, PositionForm};
use settings::{Degrees, Seconds, SettingsError, Unread};
use tracking::cutting::Boundaries;
use tracking::settings::SensorModel;

use super::words::ExternalInput;
use deployment::{
    Checkpoint, FeedFormat, FeedOrigin, Fusion, Link, Machine, PlotFormat, RecordedFormat, ReportOrder, Truncated,
};

settings::settings! {
    /// A deployment.
    pub struct DeploymentTable {
        /// Name: 1 to 31 letters, digits, `-` and `_`, as all names.
        name: String;
        /// Number of the deployment among deployments that exchange tracks; 0: no exchange.
        origin: u32 = 0;
        /// Origin of the system frame.
        frame: PlaceTable;
        /// Time of recordings, and order of fusion.
        time: TimeTable = TimeTable::default();
        /// Network input: a socket with an adapter process.
        receivers as "receiver": Vec<ReceiverTable> = Vec::new();
        /// Source. The source's number is its position in the file, from 0.
        sources as "source": Vec<SourceTable> = Vec::new();
        /// Tracker process: joins the detections of several sensors (HT-12). Its tracks are a source of its name,
        /// behind the sources in the file.
        trackers as "tracker": Vec<TrackerTable> = Vec::new();
        /// Wide-area sensor: counts targets (WA).
        wide_area_sensors as "wide_area_sensor": Vec<WideAreaSensorTable> = Vec::new();
        /// Platform that carries sensors.
        platforms as "platform": Vec<PlatformTable> = Vec::new();
        /// Gateways.
        gateways as "gateway": Unread = Unread;
        /// Cues to sensor controllers.
        cue_outlets as "cue_outlet": Unread = Unread;
        /// Link to deployments on other hosts: one process, `koseki-link`.
        links as "link": Vec<Link> = Vec::new();
        /// Region of a centre, which owns the targets in the region.
        regions as "region": Vec<RegionTable> = Vec::new();
        /// Pressure at sea level in a region, for altitudes below the transition level.
        qnh: Vec<QnhTable> = Vec::new();
        /// Areas that alerts are about.
        areas as "area": Vec<AreaSettings> = Vec::new();
        /// Alerts on targets: events and dangers, found by a process of its own.
        alerts as "alert": Vec<AlertSettings> = Vec::new();
        /// World that simulated sources observe.
        scenario: Option<scenario::ScenarioSettings> = None;
        /// Fusion process.
        fusion: FusionTable = FusionTable::default();
        /// Monitor.
        monitor: Unread = Unread;
        /// Recorder.
        recorder: Unread = Unread;
        /// Memory of fusion for its successor.
        checkpoint: Checkpoint = Checkpoint::default();
        /// Machine.
        machine: Machine = Machine::default();
        /// Display.
        display: Unread = Unread;
        /// Launcher.
        launcher: Unread = Unread;
    }

    /// A region of a centre that exchanges tracks with others.
    pub struct RegionTable {
        /// Name.
        name: String;
        /// `origin` of the owning deployment.
        origin: u32, in [1, u32::MAX];
        /// Corners in turn, latitude and longitude (WGS-84), degrees. Sides are straight in the system frame.
        corners_deg: Vec<[f64; 2]>;
    }

    /// Pressure at mean sea level (QNH) in a region: tracks below the transition level get an altitude. Of several
    /// regions that contain a target the first one counts. An order `qnh` sets the pressure of a name.
    pub struct QnhTable {
        /// Name.
        name: String;
        /// Corners in turn, latitude and longitude (WGS-84), degrees. Sides are straight in the system frame.
        corners_deg: Vec<[f64; 2]> = Vec::new(), usually "everywhere";
        /// Pressure, hPa.
        hpa: f64, in [850, 1100];
        /// Lowest flight level in use, hundreds of feet.
        transition_level: u32 = 60, in [10, 300];
        /// Later pressures.
        later: Vec<LaterQnhTable> = Vec::new();
    }

    /// A pressure from a time on.
    pub struct LaterQnhTable {
        /// Time (UTC), as in `"2016-05-10T06:00:00Z"`.
        from: String;
        /// Pressure, hPa.
        hpa: f64, in [850, 1100];
    }

    /// A place on the Earth (WGS-84).
    pub struct PlaceTable {
        /// Latitude, −90 to 90.
        latitude_deg: f64;
        /// Longitude, −180 to 180.
        longitude_deg: f64;
        /// Height above the ellipsoid.
        height_m: f64 = 0.0;
        /// Direction of the sensor's own north, clockwise from true north.
        north_offset_deg: Degrees = Degrees::of(0.0), in [-360, 360];
    }

    /// Time of recordings, and order of fusion.
    pub struct TimeTable {
        /// Order in which fusion takes reports: `arrival`, lowest latency; `time`, by time of measurement, merged with
        /// each source's progress, so that the result does not depend on scheduling. For recordings only.
        order: ReportOrder = ReportOrder::Arrival;
        /// First day of the recordings (UTC), as in `"2016-05-10"`: recordings contain the time of day only.
        date: Option<String> = None, usually "must be given with recordings";
    }

    /// A network input: exactly one of `udp`, `tcp`, `feed` and `sbs`.
    pub struct ReceiverTable {
        check ReceiverTable::check;
        /// Name of the adapter process.
        name: String;
        /// ASTERIX, bearings or counts in datagrams.
        udp: Option<UdpTable> = None;
        /// Rows of detections from a server, for the sensors of trackers.
        tcp: Option<TcpTable> = None;
        /// Targets that state their own positions, from a receiver of transponders or of AIS.
        feed: Option<FeedTable> = None;
        /// Lines of SBS-1 (BaseStation) from a server: short for a `feed` with `format = "sbs"`.
        sbs: Option<SbsTable> = None;
    }

    /// A feed of a receiver: exactly one of `connect`, `udp` and `url`.
    pub struct FeedTable {
        /// Content: `mode-s` has the frames of Beast, AVR or hexadecimal lines; `ais` has lines of NMEA 0183; `readsb`
        /// is `aircraft.json`; `remote-id` has lines of JSON, `cot` events of Cursor on Target.
        format: FeedFormat;
        /// Address and port of a server: `"127.0.0.1:30005"` for Beast.
        connect: Option<String> = None;
        /// Datagrams: `"0.0.0.0:10110"` is usual for AIS.
        udp: Option<UdpTable> = None;
        /// Address of a document: `"http://192.168.1.7/data/aircraft.json"`.
        url: Option<String> = None;
        /// Time between two fetches of the document.
        period_s: Seconds = Seconds::of(1.0), in [0.1, 3600];
        /// Minutes by which the receiver's clock shows more than UTC, for lines of SBS-1.
        ahead_of_utc_min: i32 = 0, in [-840, 840];
    }

    /// Datagrams.
    pub struct UdpTable {
        /// Multicast group or address of this machine, with the port: `"239.1.2.3:8600"`.
        listen: String;
        /// Interface on which the group is joined, by address, name or index.
        interface: Option<String> = None, usually "needed for a group";
        /// Addresses and networks of accepted senders, as in `"10.0.0.0/8"`.
        senders: Vec<String> = Vec::new(), usually "all";
        /// Size of the kernel's receive buffer, which holds datagrams while the reader is busy, bytes.
        buffer_bytes: usize = 4 << 20, in [4 << 10, 1 << 30];
    }

    /// A server of rows: a header line, and rows as they come.
    pub struct TcpTable {
        /// Address and port of the server.
        connect: String;
    }

    /// A server of SBS-1.
    pub struct SbsTable {
        /// Address and port of the server.
        connect: String;
        /// Minutes by which the server's clock shows more than UTC.
        ahead_of_utc_min: i32 = 0, in [-840, 840];
    }

    /// A source: exactly one of `recorded`, `live`, `simulated`, `simulated_direction_finder`, `simulated_ais` and
    /// `external`.
    pub struct SourceTable with weighing: fusion_settings::Weighing {
        check SourceTable::check;
        /// Name, which is also part of its topic's name.
        name: String;
        /// Identity of the sensor, the same in every deployment. 0 stands for an unknown sensor.
        uid: Option<u32> = None, in [1, u32::MAX], usually "derived from the name";
        /// Whether the deployment ends if this source's adapter cannot be started. By default, the deployment
        /// continues, and the start is repeated.
        required: bool = false;
        /// Technology of observation.
        technology: Option<Technology> = None, usually "what it sends tells";
        /// Assumed height of targets without a height, for slant ranges: a compromise between low aircraft without
        /// transponder and high aircraft.
        assumed_height_m: f64 = 5000.0, in [-500, 20e3];
        /// Pressure at sea level, for pressure altitudes. The measured extremes are 870 and 1084 hPa.
        qnh_hpa: f64 = messages::STANDARD_PRESSURE_HPA, in [850, 1100];
        /// Place of the sensor.
        place: Option<PlaceTable> = None, usually "the frame's";
        /// Recording.
        recorded: Option<RecordedTable> = None;
        /// Sensor behind a receiver.
        live: Option<LiveTable> = None;
        /// Simulated sensor; its reports use the loopback network.
        simulated: Option<scenario::SensorSettings> = None;
        /// Simulated direction finder; the adapter locates the transmitters from its bearings.
        simulated_direction_finder: Option<scenario::DirectionFinderSettings> = None;
        /// Simulated receivers of AIS, which hear the ships of the scenario.
        simulated_ais: Option<scenario::AisSettings> = None;
        /// A process that is no part of the deployment publishes the source's topic.
        external: Option<SourceExternalTable> = None;
        /// Tracker for the source's detections.
        tracker: Option<SourceTrackerTable> = None;
        /// Locator for the source's bearings.
        locator: Option<locating::Settings> = None;
        /// Emitters that the platform dropped at a known place and time.
        dropped: Vec<locating::DroppedEmitter> = Vec::new();
        /// Antenna array whose snapshots arrive in place of bearings: the keys of `koseki bearings --array`. A
        /// simulated direction finder sends the snapshots of this array.
        array: Option<locating::music::ArraySettings> = None;
        /// Mounting of a direction finder on a platform that moves: its bearings are then from the nose.
        on_board: Option<FinderOnBoardTable> = None;
        /// Limits of the sensor's reports.
        limits: PlausibilityLimits = PlausibilityLimits::default();
        /// Covariance of the source's reports.
        covariance: CovarianceModel = CovarianceModel::default();
        /// Number of periods without a record after which the source is silent, with an alarm; 0: never.
        silent_periods: f64 = 5.0, in [0, 1e6];
    }

    /// A recording. Each time of day is assigned to the day nearest to the previous time.
    pub struct RecordedTable with sender: SenderTable {
        check RecordedTable::check;
        /// File, relative to the data folder unless absolute.
        file: String;
        /// Content of the file.
        format: RecordedFormat = RecordedFormat::Asterix;
        /// Greatest delay of a report behind newer reports; reports are put in order of time. Ground stations of ADS-B
        /// hold single messages back for seconds.
        reorder_s: Seconds = Seconds::of(10.0), in [0, 60];
        /// Use of a recording that ends within a data block, after a kill of the recorder or an incomplete copy.
        truncated: Truncated = Truncated::Refuse;
    }

    /// A sensor behind a receiver.
    pub struct LiveTable with sender: SenderTable {
        /// Name of the receiver.
        receiver: String;
    }

    /// Reading of a sender's ASTERIX records.
    pub struct SenderTable with identity: SacSicTable, reading: AsterixTable {
        /// Position item to use of a report with several.
        positions: PositionForm = PositionForm::Any;
        /// Reports of a radar used by this source, by method of observation (TI-2): a radar with a primary and a
        /// secondary antenna is two sources with the same SAC/SIC.
        method: Method = Method::Any;
        /// Positions of a feed used by this source, by their origin: the errors of multilateration have nothing in
        /// common with those of positions that targets state themselves.
        origin: FeedOrigin = FeedOrigin::Any;
    }

    /// Identity of a sender.
    pub struct SacSicTable {
        check SacSicTable::check;
        /// System area code of the sender, together with `sic`.
        sac: Option<u8> = None, usually "any sender";
        /// System identification code of the sender.
        sic: Option<u8> = None, usually "any sender";
    }

    /// Reading of ASTERIX records.
    pub struct AsterixTable {
        /// Editions by category: `{ "21" = "0.23" }`.
        editions: BTreeMap<String, String> = BTreeMap::new(), usually "the newest ones known";
        /// Refuse blocks with spare bits set, or with items that go on beyond their edition.
        strict: bool = false;
    }

    /// A source whose samples a separate process publishes.
    pub struct SourceExternalTable {
        check SourceExternalTable::check;
        /// Published samples: `tracks` at `sensor/<source>/tracks`, or `detections` at
        /// `sensor/<source>.input/detections`. A tracker process makes tracks of detections; [source.tracker] has its
        /// settings.
        input: ExternalInput = ExternalInput::Tracks;
        /// Standard deviations for detections without their own, of the measured quantities in order: 1 to 3 values.
        sigmas: Option<Vec<f64>> = None, in [1e-9, 1e6];
        /// Standard deviation of range rates of detections that state none; needs `sigmas` beside it.
        range_rate_sigma_mps: Option<f64> = None, in [1e-9, 1e6];
    }

    /// No key is needed for a process that publishes a topic itself.
    pub struct ExternalTable {}

    /// Tracks are made of a source's detections.
    pub struct SourceTrackerTable with tracker: tracking::Settings, model: SensorModel {
        check SourceTrackerTable::check;
        /// Names of the wide-area sensors with counts for this tracker (WA-2).
        wide_area_sensors: Vec<String> = Vec::new();
        /// Names of the on-board direction finders whose emissions identify tracks (WA-9).
        emissions: Vec<String> = Vec::new();
        /// Publish cues after each scan: places for the sensor's next look (WA-12).
        cues: bool = false;
        /// Time between two outputs of the tracks (WA-11).
        output_period_s: Option<Seconds> = None, in [0.01, 3600], usually "after each scan";
        /// Boundaries of scans: `turn`, as stated by the sensor; `period`, at whole multiples of the period.
        scans: Boundaries = Boundaries::Turn;
        /// Time for which a scan waits for late detections, at most a period.
        wait_s: Option<f64> = None, in [0, 3600], usually "0.1 periods";
    }

    /// A tracker process: its sensors' detections become the tracks of one source.
    pub struct TrackerTable with weighing: fusion_settings::Weighing {
        check TrackerTable::check;
        /// Name of the process and of the source of its tracks.
        name: String;
        /// Identity of the source, the same in every deployment.
        uid: Option<u32> = None, in [1, u32::MAX], usually "derived from the name";
        /// Whether the deployment ends if the process cannot be started.
        required: bool = false;
        /// Sensor, in the order of precedence at equal times.
        sensors as "sensor": Vec<TrackerSensorTable> = Vec::new();
        /// Longest time for which a complete scan waits for earlier scans of other sensors. A scan that comes later is
        /// used if scans are open for it (`settings.capacity.open_scans`), and is refused and counted otherwise.
        wait_s: Seconds = Seconds::of(0.5), in [0, 3600];
        /// Settings of the tracker, without sensors.
        settings: tracking::Settings = tracking::Settings::default();
        /// Names of the wide-area sensors with counts for this tracker (WA-2).
        wide_area_sensors: Vec<String> = Vec::new();
        /// Names of the on-board direction finders whose emissions identify tracks (WA-9).
        emissions: Vec<String> = Vec::new();
        /// Publish cues after each scan: places for each sensor's next look (WA-12).
        cues: bool = false;
        /// Time between two outputs of the tracks (WA-11).
        output_period_s: Option<Seconds> = None, in [0.01, 3600], usually "after each scan";
        /// Number of periods without a track or detection after which the tracker is silent, with an alarm; 0: never.
        silent_periods: f64 = 5.0, in [0, 1e6];
    }

    /// A sensor of a tracker process: exactly one of `live`, `recorded`, `external`, `orders` and `simulated`.
    pub struct TrackerSensorTable with model: SensorModel {
        check TrackerSensorTable::check;
        /// Name: its detections are at `sensor/<tracker>.<name>/detections`.
        name: String;
        /// Sensor behind a receiver.
        live: Option<LivePlotsTable> = None;
        /// Recording.
        recorded: Option<RecordedPlotsTable> = None;
        /// A process that is no part of the deployment publishes the topic.
        external: Option<ExternalTable> = None;
        /// Operators: targets designated by `koseki order designate`. Needs `designates`.
        orders: Option<ExternalTable> = None;
        /// Radar of the simulated platform that `on_board` names.
        simulated: Option<ExternalTable> = None;
        /// Boundaries of scans: `turn`, as stated by the sensor; `period`, at whole multiples of the period; `stated`,
        /// as numbered in its detections.
        scans: Option<Boundaries> = None, usually "turn for ASTERIX, else stated";
        /// Time between two scans.
        period_s: Option<f64> = None, in [0.0625, 3600], usually "as the data show";
        /// Time for which a scan waits for late detections of the sensor, at most a period.
        wait_s: Option<f64> = None, in [0, 3600], usually "0.1 periods; 0 for stated scans";
        /// Standard deviations for detections without their own, of the measured quantities in order: 1 to 3 values.
        sigmas: Option<Vec<f64>> = None, in [1e-9, 1e6];
        /// Standard deviation of range rates of detections that state none; needs `sigmas` beside it.
        range_rate_sigma_mps: Option<f64> = None, in [1e-9, 1e6];
        /// Priority: of scans at the same time (`selection.same_time_s`), only scans of the sensor with the highest
        /// priority are used.
        priority: u32 = 0;
        /// Place of the sensor, for ASTERIX.
        place: Option<PlaceTable> = None, usually "the frame's";
        /// Assumed height of targets without a height, for slant ranges.
        assumed_height_m: f64 = 5000.0, in [-500, 20e3];
        /// Limits of the sensor's reports.
        limits: PlausibilityLimits = PlausibilityLimits::default();
        /// Covariance of the sensor's reports, for ASTERIX.
        covariance: CovarianceModel = CovarianceModel::default();
        /// Number of periods without a detection after which the sensor is silent, with an alarm; 0: never.
        silent_periods: f64 = 0.0, in [0, 1e6];
        /// Mounting on a platform that moves.
        on_board: Option<OnBoardTable> = None;
    }

    /// Mounting of a direction finder on a platform.
    pub struct FinderOnBoardTable with mount: Mount {
        /// Name of the platform whose states place the bearings.
        platform: String;
    }

    /// Mounting of a tracker's sensor on a platform.
    pub struct OnBoardTable with mount: Mount {
        /// Name of the platform whose states place the detections.
        platform: Option<String> = None, usually "each row states its platform itself";
    }

    /// Detections behind a receiver.
    pub struct LivePlotsTable with sender: SenderTable {
        /// Name of the receiver.
        receiver: String;
        /// Content of the datagrams: `asterix` or `rows`.
        format: PlotFormat = PlotFormat::Asterix;
        /// Number of the sensor in rows.
        sensor_id: Option<u32> = None, usually "all rows";
    }

    /// Recorded detections.
    pub struct RecordedPlotsTable with sender: SenderTable {
        /// File, relative to the data folder unless absolute.
        file: String;
        /// Content of the file.
        format: PlotFormat = PlotFormat::Asterix;
        /// Number of the sensor in rows, or in a scenario of Autoferry.
        sensor_id: Option<u32> = None, usually "all rows";
    }

    /// A wide-area sensor: exactly one of `live`, `recorded`, `tracks`, `external` and `simulated`.
    pub struct WideAreaSensorTable {
        check WideAreaSensorTable::check;
        /// Name, which is also part of its topic's name.
        name: String;
        /// Rows of counts in datagrams.
        live: Option<RowsTable> = None;
        /// Rows of counts in a file.
        recorded: Option<RecordedRowsTable> = None;
        /// Another system's tracks, counted by place.
        tracks: Option<CountedTracksTable> = None;
        /// A process that is no part of the deployment publishes the topic.
        external: Option<ExternalTable> = None;
        /// Simulated sensor that observes the scenario.
        simulated: Option<scenario::WideAreaSettings> = None;
    }

    /// A platform that carries sensors: exactly one of `live`, `recorded`, `external` and `simulated`.
    pub struct PlatformTable with assumed: Assumed {
        check PlatformTable::check;
        /// Name, which is also part of its topic's name, and that of its process.
        name: String;
        /// Sentences of NMEA 0183, or rows of states, received by a process of its own.
        live: Option<PlatformLiveTable> = None;
        /// Rows of states in a file, for trackers of recorded sensors.
        recorded: Option<RecordedRowsTable> = None;
        /// A process that is no part of the deployment publishes the topic.
        external: Option<ExternalTable> = None;
        /// A simulated ship with a radar; the simulator sends its sentences.
        simulated: Option<scenario::OnBoardSettings> = None;
        /// Time by which a sensor's data may run ahead of the states, while a detection waits for a state.
        wait_s: Seconds = Seconds::of(2.0), in [0, 60];
        /// Standard deviation of the delay of sentences that state no time (HDT, THS).
        receipt_sigma_s: f64 = 0.05, in [0, 10];
        /// Time without a state after which the alarm `platform-silent` is raised.
        silent_s: Seconds = Seconds::of(5.0), in [0.1, 3600];
        /// Largest distance from the frame's origin. States beyond are refused and counted.
        range_m: f64 = 1e6, in [1e3, 2e7];
        /// Differences from the prediction by the states before that raise the alarm `platform-jumped`.
        jumps: JumpLimits = JumpLimits::default();
    }

    /// Input of a platform: exactly one of `udp`, `tcp` and `device`.
    pub struct PlatformLiveTable {
        check PlatformLiveTable::check;
        /// Sentences, or rows with a header in each datagram.
        udp: Option<UdpTable> = None;
        /// Address and port of a server of sentences.
        tcp: Option<String> = None;
        /// Serial device with sentences, set to its speed before, as in `"/dev/ttyUSB0"`; or another file.
        device: Option<String> = None;
    }

    /// Rows of counts in datagrams.
    pub struct RowsTable {
        /// Name of the receiver.
        receiver: String;
    }

    /// Rows in a file.
    pub struct RecordedRowsTable {
        /// File, relative to the data folder unless absolute.
        file: String;
    }

    /// Another system's tracks (ASTERIX CAT062), counted by place: exactly one of `receiver` and `file`.
    pub struct CountedTracksTable with identity: SacSicTable, reading: AsterixTable {
        check CountedTracksTable::check;
        /// Name of the receiver.
        receiver: Option<String> = None;
        /// Recording, relative to the data folder unless absolute.
        file: Option<String> = None;
        /// Time between two reports of a track: tracks within the same period are counted together.
        period_s: Seconds = Seconds::of(4.0), in [0.1, 600];
        /// Greatest distance between tracks that are counted in the same report.
        group_m: f64 = 500.0, in [0, 1e5];
        /// Place of the other system, for positions on its own plane.
        place: Option<PlaceTable> = None, usually "the frame's";
        /// Limits of the sensor's reports.
        limits: PlausibilityLimits = PlausibilityLimits::default();
    }

    /// The fusion process.
    pub struct FusionTable with engine: fusion_settings::Settings, process: Fusion {}
}

/// Refuses a table that has none or several of these keys.
fn exactly_one(table: &str, name: &str, keys: &[(&str, bool)]) -> Result<(), SettingsError> {
    if keys.iter().filter(|(_, is_given)| *is_given).count() == 1 {
        return Ok(());
    }
    let keys: Vec<String> = keys.iter().map(|(key, _)| format!("[{table}.{key}]")).collect();
    let (last, others) = keys.split_last().expect("there are keys");
    let what = format!("\"{name}\" needs exactly one of {} and {last}", others.join(", "));
    Err(SettingsError::new("name", what))
}

impl ReceiverTable {
    fn check(&self) -> Result<(), SettingsError> {
        exactly_one(
            "receiver",
            &self.name,
            &[
                ("udp", self.udp.is_some()),
                ("tcp", self.tcp.is_some()),
                ("feed", self.feed.is_some()),
                ("sbs", self.sbs.is_some()),
            ],
        )
    }
}

impl SourceTable {
    fn check(&self) -> Result<(), SettingsError> {
        let inputs = [
            ("recorded", self.recorded.is_some()),
            ("live", self.live.is_some()),
            ("simulated", self.simulated.is_some()),
            ("simulated_direction_finder", self.simulated_direction_finder.is_some()),
            ("simulated_ais", self.simulated_ais.is_some()),
            ("external", self.external.is_some()),
        ];
        exactly_one("source", &self.name, &inputs)?;
        if self.simulated.is_some() && self.place.is_some() {
            let what = "a simulated sensor stands where its position_m says; leave [source.place] out";
            return Err(SettingsError::new("place", what));
        }
        if self.locator.is_some() && self.tracker.is_some() {
            let what = "bearings are located, detections are tracked: leave one of locator and tracker out";
            return Err(SettingsError::new("locator", what));
        }
        let has_locator = self.locator.is_some() || self.simulated_direction_finder.is_some();
        if !self.dropped.is_empty() && !has_locator {
            let what = "names emitters for a locator, which is missing; add [source.locator]";
            return Err(SettingsError::new("dropped", what));
        }
        if self.array.is_some() && !has_locator {
            let what = "measures bearings for a locator, which is missing; add [source.locator]";
            return Err(SettingsError::new("array", what));
        }
        let wait_s = self.tracker.as_ref().and_then(|tracker| tracker.wait_s);
        // The longest turn that is found, where none is configured.
        let longest_s = self.weighing.period_s.unwrap_or(60.0);
        settings::within("tracker.wait_s", wait_s.unwrap_or(0.0), 0.0, longest_s)
    }

    /// Time between two reports of one target, seconds.
    pub(crate) fn period_s(&self) -> f64 {
        self.weighing.period_s.unwrap_or(1.0)
    }
}

impl RecordedTable {
    fn check(&self) -> Result<(), SettingsError> {
        let reading = &self.sender.reading;
        if self.format == RecordedFormat::Asterix || (reading.editions.is_empty() && !reading.strict) {
            return Ok(());
        }
        let what = "editions and strict are of ASTERIX files only; leave them out";
        Err(SettingsError::new("format", what))
    }
}

impl SacSicTable {
    fn check(&self) -> Result<(), SettingsError> {
        match self.sac.is_some() == self.sic.is_some() {
            true => Ok(()),
            false => Err(SettingsError::new("", "sac and sic go together: give both or neither")),
        }
    }

    /// Both codes; `None` for any sender.
    pub(crate) fn sac_sic(&self) -> Option<(u8, u8)> {
        self.sac.zip(self.sic)
    }
}

impl SourceTrackerTable {
    fn check(&self) -> Result<(), SettingsError> {
        if self.scans == Boundaries::Stated {
            let what = "\"stated\" needs numbered scans, which ASTERIX has not; write \"turn\" or \"period\"";
            return Err(SettingsError::new("scans", what));
        }
        if !self.tracker.sensors.is_empty() {
            let what = "the source is the only sensor; write its keys into [source.tracker] itself";
            return Err(SettingsError::new("sensor", what));
        }
        if !self.emissions.is_empty() && self.tracker.wide_area.knowledge.types.is_empty() {
            let what = "no type is described that an emission could be of; add [[source.tracker.wide_area.type]]";
            return Err(SettingsError::new("emissions", what));
        }
        Ok(())
    }
}

impl TrackerTable {
    fn check(&self) -> Result<(), SettingsError> {
        if !self.settings.sensors.is_empty() {
            let what = "the sensors of a tracker process are its [[tracker.sensor]]; move their keys there";
            return Err(SettingsError::new("settings.sensor", what));
        }
        if self.sensors.is_empty() {
            let what = "a tracker needs sensors; add [[tracker.sensor]]";
            return Err(SettingsError::new("name", what));
        }
        if !self.emissions.is_empty() && self.settings.wide_area.knowledge.types.is_empty() {
            let what = "no type is described that an emission could be of; add [[tracker.settings.wide_area.type]]";
            return Err(SettingsError::new("emissions", what));
        }
        Ok(())
    }
}

impl SourceExternalTable {
    fn check(&self) -> Result<(), SettingsError> {
        let has_sigmas = self.sigmas.is_some() || self.range_rate_sigma_mps.is_some();
        if has_sigmas && self.input == ExternalInput::Tracks {
            let what =
                "belongs to detections, and tracks have a covariance; write input = \"detections\", or leave it out";
            return Err(SettingsError::new("sigmas", what));
        }
        Ok(())
    }
}

impl TrackerSensorTable {
    fn check(&self) -> Result<(), SettingsError> {
        let inputs = [
            ("live", self.live.is_some()),
            ("recorded", self.recorded.is_some()),
            ("external", self.external.is_some()),
            ("orders", self.orders.is_some()),
            ("simulated", self.simulated.is_some()),
        ];
        exactly_one("tracker.sensor", &self.name, &inputs)?;
        self.check_orders()?;
        if self
            .live
            .as_ref()
            .is_some_and(|live| live.format == PlotFormat::Autoferry)
        {
            let what = "\"autoferry\" is a format of files; write \"asterix\" or \"rows\"";
            return Err(SettingsError::new("live.format", what));
        }
        if self.scans == Some(Boundaries::Stated) && self.format() == Some(PlotFormat::Asterix) {
            let what = "\"stated\" needs numbered scans, which ASTERIX has not; write \"turn\" or \"period\"";
            return Err(SettingsError::new("scans", what));
        }
        let longest_s = self.period_s.unwrap_or(60.0);
        settings::within("wait_s", self.wait_s.unwrap_or(0.0), 0.0, longest_s)
    }

    /// Orders are designations at rest, each a scan of its own.
    fn check_orders(&self) -> Result<(), SettingsError> {
        let refused = |key: &str, what: &str| Err(SettingsError::new(key, what.to_owned()));
        match &self.orders {
            None => Ok(()),
            Some(_) if !self.model.designates => refused("designates", "must be true: orders designate targets"),
            Some(_) if self.scans.is_some_and(|scans| scans != Boundaries::Stated) => {
                refused("scans", "must be \"stated\": each order is a scan; leave it out")
            }
            Some(_) if self.on_board.is_some() => refused("on_board", "orders state places on the globe; leave it out"),
            Some(_) => Ok(()),
        }
    }

    /// Format of the data; `None` for an external sensor.
    pub(crate) fn format(&self) -> Option<PlotFormat> {
        let live = self.live.as_ref().map(|live| live.format);
        live.or(self.recorded.as_ref().map(|recorded| recorded.format))
    }
}

impl WideAreaSensorTable {
    fn check(&self) -> Result<(), SettingsError> {
        let inputs = [
            ("live", self.live.is_some()),
            ("recorded", self.recorded.is_some()),
            ("tracks", self.tracks.is_some()),
            ("external", self.external.is_some()),
            ("simulated", self.simulated.is_some()),
        ];
        exactly_one("wide_area_sensor", &self.name, &inputs)
    }
}

impl PlatformTable {
    fn check(&self) -> Result<(), SettingsError> {
        let inputs = [
            ("live", self.live.is_some()),
            ("recorded", self.recorded.is_some()),
            ("external", self.external.is_some()),
            ("simulated", self.simulated.is_some()),
        ];
        exactly_one("platform", &self.name, &inputs)
    }
}

impl PlatformLiveTable {
    fn check(&self) -> Result<(), SettingsError> {
        let given = [self.udp.is_some(), self.tcp.is_some(), self.device.is_some()];
        match given.iter().filter(|given| **given).count() {
            1 => Ok(()),
            _ => Err(SettingsError::new(
                "",
                "give exactly one of udp = { listen = \"ADDRESS:PORT\" }, tcp = \"ADDRESS:PORT\" and device = \"/dev/…\"",
            )),
        }
    }
}

impl CountedTracksTable {
    fn check(&self) -> Result<(), SettingsError> {
        match self.receiver.is_some() == self.file.is_some() {
            true => Err(SettingsError::new(
                "",
                "give either receiver (live) or file (a recording)",
            )),
            false => Ok(()),
        }
    }
}

impl UdpTable {
    /// The senders that are accepted.
    pub(crate) fn allowed_senders(&self) -> Result<AllowedSenders, SettingsError> {
        let parsed = AllowedSenders::parse(self.senders.iter().map(String::as_str));
        parsed.map_err(|error| SettingsError::new("senders", error.to_string()))
    }
}

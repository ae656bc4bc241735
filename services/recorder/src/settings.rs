//! Keys of the recorder.

use deployment::{Deployment, Parts, Segments};
use settings::{KeyTable, Seconds, SettingsError};

settings::settings! {
    /// Keys of a deployment's file.
    pub struct Keys {
        /// Recorder process.
        recorder: Settings = Settings::default();
    }

    /// The recorder process.
    pub struct Settings {
        check Settings::check;
        /// Whether a recorder runs.
        enabled: bool = true;
        /// Written files: `csv`, rows of text, a file for each topic of data; `mcap`, containers with all samples of
        /// all topics, bit by bit; `pcapng`, captures of the datagrams and lines received from live sources.
        format: Vec<Format> = vec![Format::Csv];
        /// Compression of the containers: `zstd` makes them five to nine times smaller, `none` costs least.
        compression: Packing = Packing::Zstd;
        /// Interval at which containers of all topics are written: the largest loss of a killed recorder.
        flush_s: Seconds = Seconds::of(1.0), in [0.01, 3_600];
        /// Size at which the next container or capture begins, megabytes.
        segment_mb: u32 = 256, in [1, 65_536];
        /// Time after which the next container or capture begins.
        segment_s: Seconds = Seconds::of(3_600.0), in [1, 604_800];
        /// Size of all containers of a start beyond which the oldest are deleted, gigabytes; of the captures of each
        /// receiver likewise.
        keep_gb: Option<f64> = None, in [0.001, 1e6];
    }
}

settings::words! {
    /// Words for the forms of a recording.
    pub enum Format {
        /// Rows of text.
        Csv = "csv",
        /// Containers.
        Mcap = "mcap",
        /// Captures.
        Pcapng = "pcapng",
    }
}

settings::words! {
    /// Words for compressions of containers.
    pub enum Packing {
        /// Zstandard.
        Zstd = "zstd",
        /// As the samples are.
        None = "none",
    }
}

impl Packing {
    pub(crate) fn of_chunks(self) -> recording::Compression {
        match self {
            Self::Zstd => recording::Compression::Zstd,
            Self::None => recording::Compression::None,
        }
    }
}

impl Settings {
    fn check(&self) -> Result<(), SettingsError> {
        if self.has(Format::Csv) || self.has(Format::Mcap) {
            return Ok(());
        }
        let why = "the recorder would write nothing: name \"csv\" or \"mcap\", or say enabled = false";
        Err(SettingsError::new("format", why))
    }

    /// Whether the recording has files of this format.
    pub fn has(&self, format: Format) -> bool {
        self.format.contains(&format)
    }

    /// Returns the containers of all topics; `None`: there are none.
    pub(crate) fn containers(&self) -> Option<Segments> {
        self.has(Format::Mcap).then(|| self.segments())
    }

    fn segments(&self) -> Segments {
        Segments {
            flush_ns: self.flush_s.ns(),
            bytes: u64::from(self.segment_mb) * 1_000_000,
            length_ns: self.segment_s.ns(),
            keep_bytes: self.keep_gb.map(|gigabytes| (gigabytes * 1e9) as u64),
        }
    }
}

impl Parts for Keys {
    fn tables(&mut self) -> Vec<&mut dyn KeyTable> {
        vec![self]
    }

    fn join(&self, deployment: &mut Deployment) -> Result<(), SettingsError> {
        let settings = &self.recorder;
        deployment.services.recorder = settings.enabled;
        let captures = settings.enabled && settings.has(Format::Pcapng);
        deployment.services.captures = captures.then(|| settings.segments());
        Ok(())
    }
}

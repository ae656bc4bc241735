//! Tables of named columns among the input files, and what is assumed for them.
//!
//! Such a table comes without the facts that a configuration has: the place of the system's plane, the accuracy of the
//! positions, the names of the sensors. Each missing fact has a stated substitute. A substitute is a decision with a
//! reason, shown in the summary: the first position of the first table is the origin, and a target that states its own
//! place by satellite navigation is as accurate as such a receiver with the age of its report.

use std::cell::RefCell;
use std::io::Read;
use std::path::Path;
use std::rc::Rc;

use csv_table::TimeForm;
use formats::named_columns::{NamedTrackReader, TableOutline, TargetNames};
use frames::SystemFrame;

use super::RowPlace;
use super::begun::BegunFile;
use super::file_plane::assumed_origin;
use super::progress::CountingInput;
use super::reader::FileReader;
use super::sensors::{SensorNames, Sensors, named_source};
use crate::args::OfflineInput;
use crate::files::{InputError, Usage};
use crate::host::Host;

/// Names of heights whose unit differs between programs.
const UNITLESS: [&str; 3] = ["altitude", "alt", "height"];
/// Columns named in the summary.
const IGNORED_MAX: usize = 20;

type InputAndSize = (Box<dyn Read>, u64);

/// Tables of named columns.
pub(crate) struct NamedTables {
    /// By file; `None` for a table of sensor tracks in metres.
    outlines: Vec<Option<TableOutline>>,
    /// By file, until the first pass reads the file.
    begun: Vec<RefCell<Option<BegunFile>>>,
    /// The plane of positions in degrees; `None` if no table has any.
    pub(crate) frame: Option<SystemFrame>,
    /// Standard deviation of positions without a statement of their own, metres, as given on the command line.
    sigma_m: Option<f64>,
    names: Rc<RefCell<SensorNames>>,
    /// A sentence for each assumption.
    pub(crate) assumptions: Vec<String>,
}

impl NamedTables {
    /// Looks at each file. `frame` and `names` are the configured plane of the system, and the configured names of
    /// sensors with their ids.
    ///
    /// # Errors
    /// If a file cannot be read, or a header is contradictory; if tables in degrees stand beside others in metres
    /// without an origin.
    pub(crate) fn of(
        host: &dyn Host,
        input: &OfflineInput,
        (frame, names): (Option<SystemFrame>, Vec<(String, u32)>),
    ) -> anyhow::Result<Self> {
        let (mut outlines, mut begun) = (Vec::new(), Vec::new());
        for path in &input.tracks {
            let file = BegunFile::of(host, path)?;
            outlines.push(TableOutline::of(file.lines()).map_err(|error| InputError::new(path, error))?);
            begun.push(RefCell::new(Some(file)));
        }
        if input.sigma.is_some() && outlines.iter().all(Option::is_none) {
            let what = "--sigma is for tables of named columns; these files state their accuracies, or --config does";
            return Err(Usage(what.to_owned()).into());
        }
        let has_ids = outlines.iter().any(Option::is_none);
        let mut tables = Self {
            frame: None,
            sigma_m: input.sigma,
            names: Rc::new(RefCell::new(SensorNames::new(names, has_ids))),
            assumptions: Vec::new(),
            outlines,
            begun,
        };
        tables.place(input, frame)?;
        for (path, outline) in input.tracks.iter().zip(&tables.outlines) {
            let assumed = outline.iter().flat_map(|outline| assumptions(outline, input.sigma));
            let of_file = assumed.map(|what| format!("{}: {what}", path.display()));
            tables.assumptions.extend(of_file);
        }
        Ok(tables)
    }

    /// Whether a table has named columns.
    pub(crate) fn any(&self) -> bool {
        self.outlines.iter().any(Option::is_some)
    }

    /// The assumptions, a line each; empty without any.
    pub(crate) fn as_text(&self) -> String {
        let lines = self.assumptions.iter().map(|what| format!("assumed: {what}\n"));
        lines.collect()
    }

    /// Chooses the plane of positions in degrees.
    fn place(&mut self, input: &OfflineInput, configured: Option<SystemFrame>) -> anyhow::Result<()> {
        let files = || input.tracks.iter().zip(&self.outlines);
        let is_in_degrees =
            |outline: &Option<TableOutline>| outline.as_ref().is_some_and(|outline| outline.is_in_degrees);
        let mut in_degrees = files().filter(|(_, outline)| is_in_degrees(outline)).peekable();
        let Some((first, _)) = in_degrees.peek().copied() else {
            return match input.origin {
                Some(_) if input.needs_degrees => {
                    let what =
                        "--origin places tables in degrees, and CAT062 of `smooth --asterix`; the files have metres";
                    Err(Usage(what.to_owned()).into())
                }
                _ => Ok(()),
            };
        };
        if let Some(frame) = input.origin.map(SystemFrame::at).or(configured) {
            self.frame = Some(frame);
            return Ok(());
        }
        if let Some((other, _)) = files().find(|(_, outline)| !is_in_degrees(outline)) {
            let (first, other) = (first.display(), other.display());
            let what = format!(
                "{first} has positions in degrees, {other} in metres; give --origin LAT,LON, the place from which the \
                 metres count"
            );
            return Err(Usage(what).into());
        }
        let places = in_degrees.find_map(|(path, outline)| Some((path, outline.as_ref()?.first_place?)));
        let Some((path, (place, line))) = places else {
            let what = "no row has a time with a latitude and a longitude in degrees";
            return Err(InputError::new(first, what).into());
        };
        self.frame = Some(SystemFrame::at(place));
        self.assumptions.push(assumed_origin(place, path, RowPlace::Line(line)));
        Ok(())
    }

    /// File number `index`, and its size in bytes.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub(super) fn open(&self, host: &dyn Host, (index, path): (usize, &Path)) -> Result<InputAndSize, InputError> {
        match self.begun[index].take() {
            Some(file) => Ok(file.whole()),
            None => {
                let file = host.open(path)?;
                let length = file.length;
                Ok((Box::new(file), length))
            }
        }
    }

    /// The outline of file number `index`; `None` for a table of sensor tracks in metres.
    pub(super) fn outline(&self, index: usize) -> Option<&TableOutline> {
        self.outlines[index].as_ref()
    }

    /// The reader of a table of named columns.
    ///
    /// # Errors
    /// If the input cannot be read, or its header is contradictory.
    pub(super) fn reader(
        &self,
        (path, outline): (&Path, &TableOutline),
        input: CountingInput,
        sensors: &Rc<RefCell<Sensors>>,
    ) -> Result<FileReader, InputError> {
        let accuracy = (
            self.sigma_m.unwrap_or(outline.assumed_sigma_m()),
            self.sigma_m.is_some(),
        );
        let source_of = named_source(Rc::clone(&self.names), Rc::clone(sensors), accuracy);
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let reader = NamedTrackReader::new(input, self.frame, &name, Box::new(source_of) as _);
        let reader = reader.map_err(|error| InputError::new(path, error))?;
        Ok(FileReader::Named(Box::new(reader)))
    }

    /// Name of the column of the times of file number `index`.
    pub(super) fn time_column(&self, index: usize) -> &'static str {
        self.outlines[index]
            .as_ref()
            .map_or("time_s", |outline| outline.time_column)
    }

    /// The name of sensor `id`, if a table has brought it.
    pub(crate) fn sensor_name(&self, id: u32) -> Option<String> {
        self.any()
            .then(|| self.names.borrow().name(id).map(str::to_owned))
            .flatten()
    }
}

/// What is assumed for a table, a sentence each.
fn assumptions(outline: &TableOutline, given_sigma_m: Option<f64>) -> Vec<String> {
    let mut found = Vec::new();
    if given_sigma_m.is_none() {
        let sigma_m = outline.assumed_sigma_m();
        let why = match outline.target_names {
            TargetNames::Transponders => "the targets state their own places, by satellite navigation",
            TargetNames::Names | TargetNames::One => "nothing shows how they were measured",
        };
        let which = if outline.has_sigma {
            "positions without sigma_m"
        } else {
            "all positions"
        };
        found.push(format!(
            "{which} have a standard deviation of {sigma_m} m: {why}; --sigma, or [sensor.accuracy] in --config, sets \
             another"
        ));
    }
    match outline.time_form {
        Some(TimeForm::Unzoned) => found.push("times without a zone are taken for UTC".to_owned()),
        Some(TimeForm::OfDay) => found.push("times count from midnight of an unknown day: utc stays empty".to_owned()),
        _ => {}
    }
    if outline.target_names == TargetNames::One {
        let what =
            "no column names the targets: all rows are taken for one target; name a column track if there are more";
        found.push(what.to_owned());
    }
    if !outline.ignored.is_empty() {
        let shown = outline.ignored.iter().take(IGNORED_MAX);
        let names: Vec<_> = shown.map(|name| name.escape_debug().to_string()).collect();
        let more = match outline.ignored.len().saturating_sub(IGNORED_MAX) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        found.push(format!("columns that are not used: {}{more}", names.join(", ")));
    }
    let is_altitude = |name: &&String| UNITLESS.iter().any(|known| known.eq_ignore_ascii_case(name));
    if let Some(name) = outline.ignored.iter().find(is_altitude) {
        let what = "has no unit, so it is not used; name it altitude_m, or altitude_ft for pressure altitudes";
        found.push(format!("column {name} {what}"));
    }
    found
}

//! Tracks of a centre as CAT062: what is left of them where nothing but ASTERIX is understood.
//!
//! Positions are rounded, covariances are standard deviations without cross terms (I062/500), times are of the day, and
//! nothing says which sensors contributed.

use asterix::{Decoder, Mode, blocks, registry};
use formats::observation::{self, Reading};
use frames::{Geodetic, SensorFrame, SystemFrame};
use messages::{SensorTrack, SystemTrack};
use outgoing::SystemReports;
use reception::{
    ConversionModel, Converter, CovarianceFrom, CovarianceModel, Method, PlausibilityLimits, PositionForm,
};

/// One centre's way to another one: its gateway, and there the adapter of its source.
pub(crate) struct Line {
    gateway: SystemReports,
    decoder: Decoder,
    converter: Converter,
}

impl Line {
    /// To where it is the source with the number `source`.
    pub(crate) fn new(source: u16) -> Self {
        let place = Geodetic::from_degrees(41.0, 2.0, 0.0).unwrap();
        let system = SystemFrame::at(place);
        let table = registry::default_edition(62).unwrap();
        let model = ConversionModel {
            is_on_board: false,
            number: source,
            sac_sic: Some((1, 2)),
            method: Method::Any,
            positions: PositionForm::Any,
            frame: SensorFrame::new(&system, place, 0.0),
            system,
            height_m: 0.0,
            assumed_height_m: 0.0,
            qnh_hpa: messages::STANDARD_PRESSURE_HPA,
            limits: PlausibilityLimits::default(),
            covariance: CovarianceModel {
                from: CovarianceFrom::Report,
                // The floors of what is reported.
                position_sigma_m: 1.0,
                velocity_sigma_mps: 0.1,
                height_sigma_m: 1.0,
                ..CovarianceModel::default()
            },
        };
        Self {
            gateway: SystemReports::new(table, 1, 2, system, &[], 1400).unwrap(),
            decoder: Decoder::new(Mode::Strict),
            converter: Converter::new(model, 0),
        }
    }

    /// What comes of a state at the other end; `None` of one that is not sent, or not believed there.
    pub(crate) fn carry(&mut self, track: &SystemTrack) -> Option<SensorTrack> {
        let mut bytes = Vec::new();
        let mut send = |block: &[u8]| bytes.extend_from_slice(block);
        self.gateway.report(track, &mut send);
        self.gateway.flush(&mut send);
        let block = blocks(&bytes).next()?.unwrap();
        let record = self.decoder.records(block.bytes).next().unwrap().unwrap();
        let Reading::Target(observed) = observation::read(&record) else {
            panic!("{record:?}");
        };
        self.converter.convert(&observed, 0)
    }
}

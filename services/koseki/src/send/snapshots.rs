//! Rows of array snapshots (the input of `koseki bearings`) as datagrams for a live direction finder.

use csv_table::CsvError;
use formats::snapshot_datagram::each_datagram;
use formats::snapshots_csv::{ArraySnapshot, SnapshotReader};
use observations::SnapshotBlock;

/// Bytes that an Ethernet frame carries behind the headers of IPv4 and UDP: longer datagrams travel in pieces.
const DATAGRAM_OCTETS: usize = 1472;

/// Number of antennas, if `content` is a table of snapshots.
pub(super) fn antennas(content: &[u8]) -> Option<usize> {
    let header = std::str::from_utf8(content.split(|octet| *octet == b'\n').next()?).ok()?;
    let names = || header.split(',').map(str::trim);
    let antennas = names().filter(|name| name.starts_with("re_")).count();
    (antennas > 0 && names().any(|name| name == "time_s")).then_some(antennas)
}

/// Datagrams of the rows, with their times, nanoseconds since midnight; rows with the same time are a single
/// measurement.
///
/// # Errors
/// The first row that cannot be read.
pub(super) fn datagrams(content: &[u8], antennas: usize) -> Result<Vec<(i64, Vec<u8>)>, CsvError> {
    let mut rows = SnapshotReader::new(content, 0, antennas)?.peekable();
    let mut out = Vec::new();
    let mut number = 0;
    while let Some(row) = rows.next() {
        let mut measurement = vec![row?];
        let time_ns = measurement[0].time_ns;
        while let Some(next) = rows.next_if(|next| next.as_ref().is_ok_and(|next| next.time_ns == time_ns)) {
            measurement.push(next?);
        }
        push(&measurement, number, &mut out);
        number += 1;
    }
    Ok(out)
}

/// Appends the datagrams of a measurement.
fn push(rows: &[ArraySnapshot], measurement: u32, out: &mut Vec<(i64, Vec<u8>)>) {
    let at = &rows[0];
    let samples = rows.iter().flat_map(|row| &row.samples);
    let block = SnapshotBlock {
        time_ns: at.time_ns,
        measurement,
        total: rows.len() as u32,
        first: 0,
        antennas: at.samples.len() as u16,
        frequency_hz: at.frequency_hz,
        platform_m: Some(at.platform_m),
        heading_rad: Some(at.heading_rad),
        samples: samples.map(|[re, im]| [*re as f32, *im as f32]).collect(),
    };
    each_datagram(&block, DATAGRAM_OCTETS, |octets| {
        out.push((at.time_ns, octets.to_vec()))
    });
}

#[cfg(test)]
mod tests {
    use formats::snapshot_datagram::decode;

    use super::*;

    #[test]
    fn a_measurement_is_divided_into_datagrams_that_no_network_divides() {
        let header = "time_s,px,py,pz,heading_rad,frequency_hz,re_1,im_1,re_2,im_2\n";
        let rows: String = (0..90).map(|row| format!("5,1,2,3,0.5,1e9,{row},0,0,1\n")).collect();
        let table = format!("{header}{rows}6,1,2,3,0.5,1e9,7,0,0,1\n");
        assert_eq!(antennas(table.as_bytes()), Some(2));
        let found = datagrams(table.as_bytes(), 2).unwrap();
        let mut blocks = Vec::new();
        for (time_ns, octets) in &found {
            assert!(octets.len() <= DATAGRAM_OCTETS, "{}", octets.len());
            let mut block = SnapshotBlock::default();
            decode(octets, &mut block).unwrap();
            assert_eq!(block.time_ns, *time_ns);
            blocks.push((block.measurement, block.total, block.first, block.samples[0][0]));
        }
        assert_eq!(blocks, [(0, 90, 0, 0.0), (0, 90, 87, 87.0), (1, 1, 0, 7.0)]);
        let error = datagrams(table.replace("6,1,2", "x,1,2").as_bytes(), 2).unwrap_err();
        assert!(error.to_string().starts_with("line 92, column time_s"), "{error}");
        assert_eq!(antennas(b"time_s,emitter_id,bearing_rad\n"), None);
    }
}

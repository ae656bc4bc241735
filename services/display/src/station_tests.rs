//! Tests of base stations and aids to navigation, from the topic to the picture of a page.

use messages::layout::Sample as _;
use messages::picture::{PictureHeader, PictureStation, picture_station_bits};
use messages::{AidKind, FrameOrigin, Stream, TargetCategory, TargetStatement, target_statement_bits as bits};
use runtime::Now;

use crate::layers::DisplayedSample as _;
use crate::pages::tests::{header, later, now, track};
use crate::viewer::Viewer;
use crate::wire::{STATION_AGE_S, Wish};
use crate::world::World;

fn aid(mmsi: u32, time_ns: i64, latitude_deg: f64) -> TargetStatement {
    TargetStatement {
        time_ns,
        track_number: mmsi,
        category: TargetCategory::Aid.code(),
        valid: bits::STATION | bits::VIRTUAL | bits::SIZE,
        place_deg: [latitude_deg, 2.0],
        length_m: 6.0,
        width_m: 4.0,
        aid: AidKind::PortMark.code(),
        name: *b"BUOY 7              ",
        ..TargetStatement::default()
    }
}

fn world() -> World {
    let mut world = World::new("test", Vec::new(), 600, 1_000_000);
    world.place(&FrameOrigin {
        latitude_deg: 41.0,
        longitude_deg: 2.0,
        height_m: 0.0,
    });
    world
}

fn hear(world: &mut World, stated: &[TargetStatement], at: Now) {
    TargetStatement::put(world, (&header(1), stated), at);
    world.clean_up(at);
}

/// The stations in a page's next picture.
fn shown(viewer: &mut Viewer, world: &World, at: Now) -> Vec<PictureStation> {
    let octets = viewer.picture(world, at);
    let (head, rest) = octets.split_at(size_of::<PictureHeader>());
    let head = PictureHeader::of_octets(head).unwrap();
    let (_, stations) = rest.split_at(rest.len() - head.stations as usize * size_of::<PictureStation>());
    stations
        .chunks(size_of::<PictureStation>())
        .map(|octets| PictureStation::of_octets(octets).unwrap())
        .collect()
}

fn page() -> Viewer {
    let mut viewer = Viewer::default();
    // A view elsewhere: stations are few, and each page has all.
    let wish = r#"{"layers": ["stations"], "view": [5e5, 5e5, 6e5, 6e5]}"#;
    viewer.wish(Wish::read(wish).unwrap(), now());
    viewer
}

#[test]
fn a_page_has_what_came_before_it_joined_and_then_what_is_new() {
    let mut world = world();
    hear(&mut world, &[aid(992_111_840, now().utc_ns, 41.5)], now());
    let mut viewer = page();
    let [buoy] = shown(&mut viewer, &world, later(20))[..] else {
        panic!("one station");
    };
    assert_eq!(
        (buoy.mmsi, buoy.age_ms, &buoy.name[..6]),
        (992_111_840, 20_000, &b"BUOY 7"[..])
    );
    assert!(
        buoy.east_m.abs() < 1.0 && (buoy.north_m - 55_540.0).abs() < 100.0,
        "{buoy:?}"
    );
    assert_eq!(
        (buoy.flags, buoy.aid, buoy.length_m),
        (picture_station_bits::VIRTUAL, AidKind::PortMark.code(), 6.0)
    );
    assert!(shown(&mut viewer, &world, later(21)).is_empty(), "nothing is new");
    let base = TargetStatement {
        category: TargetCategory::BaseStation.code(),
        valid: bits::STATION,
        ..aid(2_111_111, later(30).utc_ns, 41.0)
    };
    // Another source has received an older report of the buoy.
    let older = TargetStatement {
        source: 1,
        ..aid(992_111_840, now().utc_ns - 1, 42.0)
    };
    let off = TargetStatement {
        valid: bits::STATION | bits::OFF_POSITION,
        ..aid(992_111_840, later(30).utc_ns, 41.6)
    };
    hear(&mut world, &[base, off, older], later(30));
    let found = shown(&mut viewer, &world, later(30));
    assert_eq!(
        found.iter().map(|station| station.mmsi).collect::<Vec<_>>(),
        [2_111_111, 992_111_840]
    );
    assert_eq!(
        found.iter().map(|station| station.flags).collect::<Vec<_>>(),
        [picture_station_bits::BASE, picture_station_bits::OFF_POSITION]
    );
    assert!(world.statements.is_empty(), "no target has stated anything");
}

#[test]
fn a_station_stays_between_its_reports_and_leaves_when_it_is_silent() {
    let mut world = world();
    hear(&mut world, &[aid(992_111_840, now().utc_ns, 41.5)], now());
    hear(&mut world, &[], later(STATION_AGE_S - 1));
    assert_eq!(shown(&mut page(), &world, later(STATION_AGE_S - 1)).len(), 1);
    hear(&mut world, &[], later(STATION_AGE_S + 1));
    assert_eq!(world.stations.len(), 0);
    // A place on no globe is not shown, and the stations are bounded.
    let all: Vec<TargetStatement> = (0..9_000).map(|mmsi| aid(mmsi, later(700).utc_ns, 95.0)).collect();
    hear(&mut world, &all, later(700));
    assert_eq!(world.stations.len(), 8_192);
    assert!(shown(&mut page(), &world, later(700)).is_empty());
}

/// The stations of a recording that is replayed come before the first track, by which the picture has its time.
#[test]
fn stations_wait_for_the_origin_and_for_the_time_of_recorded_data() {
    let mut world = World::new("test", Vec::new(), 600, 1_000_000);
    world.set_clock(crate::clock::PictureClock::of(true));
    let begun_ns = now().utc_ns - 86_400_000_000_000;
    hear(&mut world, &[aid(992_111_840, begun_ns, 41.5)], now());
    let mut viewer = page();
    assert!(shown(&mut viewer, &world, now()).is_empty());
    let first = messages::SystemTrack {
        reference_time_ns: begun_ns + 5_000_000_000,
        ..track(7, 0.0)
    };
    world.receive(&header(1), &[first], later(1));
    world.clean_up(later(2));
    assert!(
        shown(&mut viewer, &world, later(2)).is_empty(),
        "the place has no origin"
    );
    world.place(&FrameOrigin {
        latitude_deg: 41.0,
        longitude_deg: 2.0,
        height_m: 0.0,
    });
    let found = shown(&mut viewer, &world, later(2));
    assert_eq!(found.iter().map(|station| station.age_ms).collect::<Vec<_>>(), [6_000]);
    assert_eq!(
        crate::layers::stream_of("sensor/ais/statements"),
        Some((Stream::Statements, "ais"))
    );
}

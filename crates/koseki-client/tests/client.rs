//! A program of one's own beside a deployment, of which the test plays the processes.

use std::thread;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use bus::{Bus, Mark, Root, SharedMemory, TopicHold};
use koseki_client::{
    BORROWED_MAX, Detection, Error, ErrorKind, Geodetic, Publisher, Subscription, SystemFrame, by_name,
};
use messages::layout::Sample as _;
use messages::{Covariance, FrameOrigin, SensorTrack, SystemTrack};
use tempfile::TempDir;

const PATIENCE: Duration = Duration::from_secs(60);
const MARK: Mark = Mark {
    progress_ns: i64::MIN,
    sent_ns: 1,
    end: false,
};

/// A deployment whose keeper is this process.
struct Deployment {
    root: Root,
    bus: Bus<SharedMemory>,
    _held: Vec<TopicHold>,
    _claim: bus::Claim,
    _folder: TempDir,
}

impl Deployment {
    fn new() -> Self {
        Self::with_queues(messages::system_tracks().capacity.depth)
    }

    /// A deployment that permits queues of `length` slices to readers of its system tracks.
    fn with_queues(length: usize) -> Self {
        let mut system_tracks = messages::system_tracks();
        system_tracks.capacity.depth = length;
        let folder = tempfile::Builder::new().prefix("k").tempdir_in("/tmp").unwrap();
        let root = Root::in_base(folder.path().join("b"), "site").unwrap();
        let claim = root.claim().unwrap();
        let bus = Bus::open(&root, "keeper").unwrap();
        let held = vec![
            bus.hold(&system_tracks).unwrap(),
            bus.hold(&messages::sensor_tracks("own")).unwrap(),
            bus.hold(&messages::sensor_tracks("camera")).unwrap(),
            bus.hold(&messages::sensor_detections("camera")).unwrap(),
            bus.hold(&messages::sensor_detections("camera.input")).unwrap(),
            bus.hold(&messages::frame_origin()).unwrap(),
        ];
        Self {
            root,
            bus,
            _held: held,
            _claim: claim,
            _folder: folder,
        }
    }

    /// A publisher of system tracks, which fusion's incarnation number `epoch` would have.
    fn fusion(&self, epoch: u64) -> bus::Publisher<SharedMemory, SystemTrack> {
        let publisher = self.bus.publisher(&messages::system_tracks(), epoch).unwrap();
        publisher.with_epoch(epoch)
    }

    fn subscription(&self) -> Subscription {
        Subscription::at(&self.root, &messages::system_tracks()).unwrap()
    }
}

fn track(track_number: u32) -> SystemTrack {
    SystemTrack {
        track_number,
        ..SystemTrack::default()
    }
}

/// A report that fusion could use.
fn report(track_number: u32) -> SensorTrack {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    SensorTrack {
        track_number,
        time_of_measurement_ns: i64::try_from(since_1970.as_nanos()).unwrap(),
        covariance: Covariance::diagonal([30.0; 3], [3.0; 3]),
        ..SensorTrack::default()
    }
}

fn send(publisher: &mut bus::Publisher<SharedMemory, SystemTrack>, numbers: &[u32]) {
    publisher
        .send(MARK, numbers.len(), |index, _| track(numbers[index]))
        .unwrap();
}

fn numbers(subscription: &mut Subscription) -> Vec<u32> {
    let slice = subscription.next(PATIENCE).unwrap().expect("a slice was sent");
    slice.iter().map(|track| track.track_number).collect()
}

#[test]
fn slices_arrive_on_another_thread_and_empty_topics_time_out() {
    let deployment = Deployment::new();
    let mut subscription = deployment.subscription();
    assert!(subscription.next(Duration::ZERO).unwrap().is_none());
    assert!(subscription.next(Duration::from_millis(1)).unwrap().is_none());
    let mut fusion = deployment.fusion(1);
    let reader = thread::spawn(move || numbers(&mut subscription));
    send(&mut fusion, &[7, 8]);
    assert_eq!(reader.join().unwrap(), [7, 8]);
}

#[test]
fn slices_of_older_epochs_are_dropped_and_counted() {
    let deployment = Deployment::new();
    let mut subscription = deployment.subscription();
    let (mut old, mut new) = (deployment.fusion(1), deployment.fusion(2));
    send(&mut old, &[1]);
    assert!(subscription.next(PATIENCE).unwrap().unwrap().starts_epoch());
    send(&mut new, &[10]);
    assert!(subscription.next(PATIENCE).unwrap().unwrap().starts_epoch());
    send(&mut old, &[2, 3]);
    assert!(subscription.next(Duration::ZERO).unwrap().is_none());
    send(&mut new, &[11]);
    let slice = subscription.next(PATIENCE).unwrap().unwrap();
    assert!(!slice.starts_epoch() && slice[0].track_number == 11);
    let counts = subscription.counts();
    assert_eq!(
        (counts.taken, counts.lost, counts.of_older_epochs, counts.epoch),
        (3, 0, 2, 2)
    );
}

#[test]
fn slow_readers_are_told_with_the_next_slice_how_much_they_lost() {
    let deployment = Deployment::new();
    let mut subscription = deployment.subscription();
    let mut fusion = deployment.fusion(1);
    send(&mut fusion, &[0]);
    assert_eq!(subscription.next(PATIENCE).unwrap().unwrap().lost(), 0);
    let depth = messages::system_tracks().capacity.depth as u32;
    (1..=depth + 5).for_each(|number| send(&mut fusion, &[number]));
    let slice = subscription.next(PATIENCE).unwrap().unwrap();
    assert_eq!((slice.lost(), slice[0].track_number), (5, 6));
    drop(slice);
    assert_eq!(subscription.next(PATIENCE).unwrap().unwrap().lost(), 0);
}

#[test]
fn a_reader_with_a_longer_queue_loses_nothing_where_the_usual_one_loses() {
    const LENGTH: usize = 1024;
    let deployment = Deployment::with_queues(LENGTH);
    let topic = messages::system_tracks();
    let usual = deployment.subscription();
    let longer = Subscription::with_queue(&deployment.root, &topic, LENGTH).unwrap();
    let mut readers = [usual, longer];
    let mut fusion = deployment.fusion(1);
    send(&mut fusion, &[0]);
    assert_eq!(readers.each_mut().map(numbers), [[0], [0]]);
    (0..LENGTH as u32).for_each(|number| send(&mut fusion, &[number]));
    let read = readers.each_mut().map(|reader| {
        while reader.next(Duration::ZERO).unwrap().is_some() {}
        (reader.counts().taken - 1, reader.counts().lost)
    });
    let (usual, longest) = (topic.capacity.depth as u64, LENGTH as u64);
    assert_eq!(read, [(usual, longest - usual), (longest, 0)]);
    let by_name = |queue| by_name::subscribe(&deployment.root, "system/tracks", Some(queue));
    assert!(by_name(LENGTH).is_ok());
    for length in [0, LENGTH + 1] {
        let refused = by_name(length).unwrap_err();
        assert_eq!(refused.kind(), ErrorKind::Argument);
        let text = refused.to_string();
        assert!(
            text.contains(&format!("of {length} slices")) && text.contains("to 1024"),
            "{text}"
        );
        assert!(text.contains("[machine] queue_slices"), "{text}");
    }
}

#[test]
fn one_slice_too_many_is_an_error_that_ends_when_one_is_given_back() {
    let deployment = Deployment::new();
    let mut subscription = deployment.subscription();
    let mut fusion = deployment.fusion(1);
    (0..3).for_each(|number| send(&mut fusion, &[number]));
    let mut take = || subscription.next(PATIENCE);
    let mut kept: Vec<_> = (0..BORROWED_MAX).map(|_| take().unwrap().unwrap()).collect();
    assert_eq!(take().unwrap_err().kind(), ErrorKind::Borrowed);
    kept.remove(0);
    assert_eq!(take().unwrap().unwrap()[0].track_number, 2);
}

#[test]
fn what_does_not_run_or_exist_is_told_apart() {
    let deployment = Deployment::new();
    let kind = |root: &Root, topic: &str| by_name::subscribe(root, topic, None).unwrap_err().kind();
    let nobody = Root::in_base(deployment.root.base(), "nobody").unwrap();
    assert_eq!(kind(&nobody, "system/tracks"), ErrorKind::NotRunning);
    assert_eq!(kind(&deployment.root, "system/alarms"), ErrorKind::NoSuchTopic);
    assert_eq!(kind(&deployment.root, "sensor/a/b/tracks"), ErrorKind::Argument);
    assert_eq!(
        by_name::publisher(&deployment.root, "system/tracks")
            .unwrap_err()
            .kind(),
        ErrorKind::Argument
    );
    assert_eq!(Subscription::open("a/b").unwrap_err().kind(), ErrorKind::Argument);
}

#[test]
fn the_end_of_a_deployment_is_told_after_its_last_slice() {
    let deployment = Deployment::new();
    let mut subscription = deployment.subscription();
    let mut publisher = Publisher::<SensorTrack>::at(&deployment.root, "own").unwrap();
    let mut fusion = deployment.fusion(1);
    send(&mut fusion, &[8]);
    assert_eq!(numbers(&mut subscription), [8]);
    send(&mut fusion, &[9]);
    drop(fusion);
    drop(deployment);
    assert_eq!(numbers(&mut subscription), [9]);
    assert_eq!(subscription.next(PATIENCE).unwrap_err().kind(), ErrorKind::Ended);
    let refused = std::iter::repeat_with(|| publisher.publish(&[report(1)])).find_map(Result::err);
    assert_eq!(refused.unwrap().kind(), ErrorKind::Ended);
}

#[test]
fn samples_of_another_layout_are_an_error() {
    let deployment = Deployment::new();
    let mut subscription = deployment.subscription();
    let mut fusion = deployment.fusion(1);
    fusion.pretend_schema(1);
    send(&mut fusion, &[1]);
    assert_eq!(subscription.next(PATIENCE).unwrap_err().kind(), ErrorKind::Schema);
}

#[test]
fn what_is_published_by_name_is_read_with_its_numbers_and_stamps() {
    let deployment = Deployment::new();
    let topic = "sensor/own/tracks";
    let mut subscription = by_name::subscribe(&deployment.root, topic, None).unwrap();
    let mut publisher = by_name::publisher(&deployment.root, topic).unwrap();
    let tracks = [1, 2].map(report);
    let octets = SensorTrack::octets(&tracks);
    publisher.publish(octets).unwrap();
    publisher.publish(octets).unwrap();
    let refused = publisher.publish(&octets[1..]).unwrap_err();
    assert_eq!(refused.kind(), ErrorKind::Argument);
    assert_eq!(publisher.sent(), 4);
    subscription.next(PATIENCE).unwrap().unwrap();
    let slice = subscription.next(PATIENCE).unwrap().unwrap();
    let size = subscription.layout().size;
    let read = SensorTrack::of_octets(&slice.octets()[size..]).unwrap();
    assert_eq!((read.track_number, read.sequence), (2, 3));
    assert!(read.stages.ingested_ns > 0 && read.stages.published_ns >= read.stages.ingested_ns);
    assert_eq!(slice.header().sensor_uid, messages::sensor_uid("own"));
}

#[test]
fn a_sample_with_a_fault_is_refused_by_name_and_none_of_its_send_is_published() {
    let deployment = Deployment::new();
    let topic = messages::sensor_tracks("own");
    let mut subscription = Subscription::at(&deployment.root, &topic).unwrap();
    let mut publisher = Publisher::<SensorTrack>::at(&deployment.root, "own").unwrap();
    let mut in_seconds = report(2);
    in_seconds.time_of_measurement_ns /= 1_000_000_000;
    let refused = publisher.publish(&[report(1), in_seconds]).unwrap_err();
    assert_eq!(refused.kind(), ErrorKind::Argument);
    let text = refused.to_string();
    assert!(
        text.starts_with("sample 1 is refused, and none was published: time_of_measurement_ns is "),
        "{text}"
    );
    assert!(
        text.ends_with("the number is in seconds; multiply it by 1000000000"),
        "{text}"
    );
    assert_eq!(publisher.sent(), 0);
    assert!(subscription.next(Duration::ZERO).unwrap().is_none());
    publisher.publish(&[report(3)]).unwrap();
    assert_eq!(subscription.next(PATIENCE).unwrap().unwrap()[0].track_number, 3);
}

#[test]
fn the_limit_of_the_clock_can_be_changed() {
    let deployment = Deployment::new();
    let mut publisher = Publisher::<SensorTrack>::at(&deployment.root, "own").unwrap();
    let mut old = report(1);
    old.time_of_measurement_ns -= 3_600_000_000_000;
    let refused = publisher.publish(&[old]).unwrap_err().to_string();
    assert!(
        refused.contains("within 600 s") && refused.contains("3600 s behind"),
        "{refused}"
    );
    publisher.limit_clock(Some(Duration::from_secs(7200)));
    publisher.publish(&[old]).unwrap();
    publisher.limit_clock(None);
    old.time_of_measurement_ns = 1;
    publisher.publish(&[old]).unwrap();
}

#[test]
fn a_source_has_one_publisher_and_its_successor_is_accepted() {
    let deployment = Deployment::new();
    let open = || Publisher::<SensorTrack>::at(&deployment.root, "own");
    let mut first = open().unwrap();
    first.publish(&[report(1)]).unwrap();
    let refused = open().unwrap_err();
    assert_eq!(refused.kind(), ErrorKind::Fed);
    let text = refused.to_string();
    assert!(
        text.contains("sensor/own/tracks") && text.contains(&std::process::id().to_string()),
        "{text}"
    );
    drop(first);
    open().unwrap().publish(&[report(2)]).unwrap();
}

#[test]
fn an_adapter_of_the_source_is_a_publisher_too() {
    let deployment = Deployment::new();
    let adapter = deployment.bus.publisher(&messages::sensor_tracks("own"), 1).unwrap();
    let open = || Publisher::<SensorTrack>::at(&deployment.root, "own");
    assert_eq!(open().unwrap_err().kind(), ErrorKind::Fed);
    drop(adapter);
    open().unwrap();
}

#[test]
fn detections_in_degrees_arrive_in_metres_of_the_published_frame() {
    let deployment = Deployment::new();
    let mut sent = Subscription::at(&deployment.root, &messages::sensor_detections("camera.input")).unwrap();
    let mut origins = deployment.bus.publisher(&messages::frame_origin(), 1).unwrap();
    let mut camera = Publisher::at(&deployment.root, "camera").unwrap();
    // 100 km from the origin, where the Earth has fallen away by 785 m.
    let (latitude, longitude, height_m) = (41.632, 2.848, 900.0);
    let feeder = thread::spawn(move || {
        let far = Detection::at(latitude, longitude).height_m(height_m).sigma_m(20.0);
        camera.send(&[far, Detection::at(41.1, 2.1).sigma_m(20.0)]).unwrap();
        let refused = camera.send(&[far, Detection::at(91.0, 2.0).sigma_m(20.0)]);
        // It stays until its slice is received.
        (refused, camera)
    });
    while !feeder.is_finished() {
        let origin = FrameOrigin {
            latitude_deg: 41.0,
            longitude_deg: 2.0,
            height_m: 0.0,
        };
        origins.send(MARK, 1, |_, _| origin).unwrap();
        thread::sleep(Duration::from_millis(5));
    }
    let (refused, camera) = feeder.join().unwrap();
    let Err(Error::Observation { index: 1, fault }) = refused else {
        panic!("{refused:?}")
    };
    assert_eq!((fault.field.as_str(), camera.sent()), ("latitude", 2));
    let slice = sent.next(PATIENCE).unwrap().unwrap();
    let place = |latitude, longitude, height_m| Geodetic::from_degrees(latitude, longitude, height_m).unwrap();
    let expected = SystemFrame::at(place(41.0, 2.0, 0.0)).to_local(place(latitude, longitude, height_m));
    for (value, expected) in slice[0].values.iter().zip(expected) {
        assert!((value - expected).abs() < 1e-3, "{value} {expected}");
    }
    let numbers = [0, 1].map(|index| (slice[index].scan, slice[index].detection_id));
    assert_eq!(numbers, [(1, 1), (1, 2)]);
}

#[test]
fn a_source_is_fed_with_what_it_takes() {
    let deployment = Deployment::new();
    let mut camera = by_name::feed(&deployment.root, "camera").unwrap();
    assert_eq!(camera.layout().name, "SensorDetection");
    let refused = camera.send_tracks(&[]).unwrap_err();
    assert!(matches!(refused, Error::OtherKind { .. }), "{refused}");
    let own = by_name::feed(&deployment.root, "own").unwrap();
    assert_eq!(own.layout().name, "SensorTrack");
    let nobody = by_name::feed(&deployment.root, "nobody").unwrap_err();
    assert_eq!(nobody.kind(), ErrorKind::NoSuchTopic);
    assert_eq!(by_name::clock_limit(f64::INFINITY).unwrap(), None);
    assert_eq!(by_name::clock_limit(2.0).unwrap(), Some(Duration::from_secs(2)));
    for wrong in [0.0, -1.0, f64::NAN] {
        assert_eq!(by_name::clock_limit(wrong).unwrap_err().kind(), ErrorKind::Argument);
    }
}

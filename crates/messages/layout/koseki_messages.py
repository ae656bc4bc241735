"""Koseki's samples in shared memory, for ctypes and the iceoryx2 Python package.

Written by `cargo run -p messages --example layouts`; a test keeps it true.
"""

import ctypes

SCHEMA = 0x2c00644931801275  # Every BatchHeader.schema must equal this.
CONTRIBUTIONS_MAX = 0x10  # Length of SystemTrack.contributions.
COUNTERS_MAX = 0x50  # Length of Counters.values.
IDENTITY_ADDRESS = 0x1  # Bit of a flags or valid field.
IDENTITY_MODE_3A = 0x2  # Bit of a flags or valid field.
IDENTITY_CALLSIGN = 0x4  # Bit of a flags or valid field.
SENSOR_TRACK_HEIGHT = 0x1  # Bit of a flags or valid field.
SENSOR_TRACK_VELOCITY = 0x2  # Bit of a flags or valid field.
SENSOR_TRACK_VERTICAL_RATE = 0x4  # Bit of a flags or valid field.
SENSOR_TRACK_OWN_COVARIANCE = 0x8  # Bit of a flags or valid field.
SENSOR_TRACK_MEASURED = 0x10  # Bit of a flags or valid field.
SENSOR_TRACK_ON_GROUND = 0x20  # Bit of a flags or valid field.
SENSOR_TRACK_DERIVED_VELOCITY = 0x40  # Bit of a flags or valid field.
SENSOR_TRACK_TRACE = 0x80  # Bit of a flags or valid field.
SENSOR_DETECTION_RANGE_RATE = 0x1  # Bit of a flags or valid field.
SENSOR_DETECTION_SIGMAS = 0x2  # Bit of a flags or valid field.
SENSOR_BEARING_EMITTER = 0x1  # Bit of a flags or valid field.
SENSOR_BEARING_HEADING = 0x2  # Bit of a flags or valid field.
SENSOR_BEARING_FREQUENCY = 0x4  # Bit of a flags or valid field.
SENSOR_BEARING_PULSE_INTERVAL = 0x8  # Bit of a flags or valid field.
PLATFORM_STATE_VELOCITY = 0x1  # Bit of a flags or valid field.
PLATFORM_STATE_HEADING = 0x2  # Bit of a flags or valid field.
PLATFORM_STATE_ATTITUDE = 0x4  # Bit of a flags or valid field.
PLATFORM_STATE_POSITION_SIGMA = 0x8  # Bit of a flags or valid field.
PLATFORM_STATE_HEADING_SIGMA = 0x10  # Bit of a flags or valid field.
WIDE_AREA_ORIGIN = 0x1  # Bit of a flags or valid field.
CONTRIBUTION_FRESH = 0x1  # Bit of a flags or valid field.
CONTRIBUTION_SCORED = 0x2  # Bit of a flags or valid field.
ALERT_SPECIAL_IDENTIFICATION = 0x1  # Bit of a flags or valid field.
ALERT_EMERGENCY = 0x2  # Bit of a flags or valid field.
ALERT_COMMUNICATION_FAILURE = 0x4  # Bit of a flags or valid field.
ALERT_UNLAWFUL_INTERFERENCE = 0x8  # Bit of a flags or valid field.
ALERT_MEDICAL = 0x10  # Bit of a flags or valid field.
ALERT_MINIMUM_FUEL = 0x20  # Bit of a flags or valid field.
ALERT_TRANSPONDER_ALERT = 0x40  # Bit of a flags or valid field.
ALERT_RESOLUTION_ADVISORY = 0x80  # Bit of a flags or valid field.
REGISTRATION_EAST = 0x1  # Bit of a flags or valid field.
REGISTRATION_NORTH = 0x2  # Bit of a flags or valid field.
REGISTRATION_UP = 0x4  # Bit of a flags or valid field.
REGISTRATION_TIME = 0x8  # Bit of a flags or valid field.
REGISTRATION_RANGE = 0x10  # Bit of a flags or valid field.
REGISTRATION_AZIMUTH = 0x20  # Bit of a flags or valid field.
STATE_TENTATIVE = 0x0  # Value of a state field.
STATE_CONFIRMED = 0x1  # Value of a state field.
STATE_COASTED = 0x2  # Value of a state field.
STATE_TERMINATED = 0x3  # Value of a state field.
KIND_SINGLE = 0x0  # Value of a track's kind field.
KIND_GROUP = 0x1  # Value of a track's kind field.


class StageTimes(ctypes.Structure):
    _fields_ = [
        ("ingested_ns", ctypes.c_int64),  # The adapter had the report's last byte.
        ("published_ns", ctypes.c_int64),  # The adapter handed the report to shared memory.
        ("taken_ns", ctypes.c_int64),  # Fusion took the report from shared memory.
        ("fused_ns", ctypes.c_int64),  # Fusion handed the system track to shared memory.
    ]

    @staticmethod
    def type_name() -> str:
        return "StageTimes"


assert ctypes.sizeof(StageTimes) == 32
assert StageTimes.ingested_ns.offset == 0
assert StageTimes.published_ns.offset == 8
assert StageTimes.taken_ns.offset == 16
assert StageTimes.fused_ns.offset == 24


class Identity(ctypes.Structure):
    _fields_ = [
        ("address", ctypes.c_uint32),  # 24-bit aircraft address in the low bits.
        ("mode_3a", ctypes.c_uint16),  # Mode 3/A code, its four octal digits in twelve bits.
        ("valid", ctypes.c_uint16),  # Which fields hold something: see `identity_bits`.
        ("callsign", ctypes.c_uint8 * 8),  # Callsign in ASCII, padded with blanks.
    ]

    @staticmethod
    def type_name() -> str:
        return "Identity"


assert ctypes.sizeof(Identity) == 16
assert Identity.address.offset == 0
assert Identity.mode_3a.offset == 4
assert Identity.valid.offset == 6
assert Identity.callsign.offset == 8


class TargetType(ctypes.Structure):
    _fields_ = [
        ("name", ctypes.c_uint8 * 12),  # Name in ASCII, padded with blanks.
        ("confidence", ctypes.c_float),  # Probability that it is of that type, in (0, 1]; 0 where no type is known.
    ]

    @staticmethod
    def type_name() -> str:
        return "TargetType"


assert ctypes.sizeof(TargetType) == 16
assert TargetType.name.offset == 0
assert TargetType.confidence.offset == 12


class Covariance(ctypes.Structure):
    _fields_ = [
        ("upper", ctypes.c_double * 21),  # The 21 elements.
    ]

    @staticmethod
    def type_name() -> str:
        return "Covariance"


assert ctypes.sizeof(Covariance) == 168
assert Covariance.upper.offset == 0


class BatchHeader(ctypes.Structure):
    _fields_ = [
        ("schema", ctypes.c_uint64),  # Fingerprint of the layouts the publisher was built with; others are refused.
        ("incarnation", ctypes.c_uint64),  # Monotonic start time of the publisher, nanoseconds: a restart shows as a new value.
        ("first_sequence", ctypes.c_uint64),  # Samples sent by this incarnation before this slice: the sequence number of its first sample.
        ("progress_ns", ctypes.c_int64),  # Progress mark: no later sample will have a time of measurement before this (UTC, ns); i64::MIN if unknown.
        ("sent_ns", ctypes.c_int64),  # Monotonic time of the send, nanoseconds.
        ("flags", ctypes.c_uint32),  # Bit 0: the source has ended, and nothing follows.
        ("reserved", ctypes.c_uint32),  # Reserved, 0.
    ]

    @staticmethod
    def type_name() -> str:
        return "BatchHeader"


assert ctypes.sizeof(BatchHeader) == 48
assert BatchHeader.schema.offset == 0
assert BatchHeader.incarnation.offset == 8
assert BatchHeader.first_sequence.offset == 16
assert BatchHeader.progress_ns.offset == 24
assert BatchHeader.sent_ns.offset == 32
assert BatchHeader.flags.offset == 40
assert BatchHeader.reserved.offset == 44


class SensorTrack(ctypes.Structure):
    _fields_ = [
        ("time_of_measurement_ns", ctypes.c_int64),  # Time of measurement, UTC, nanoseconds since 1970.
        ("sequence", ctypes.c_uint64),  # The report's sequence number at its publisher.
        ("stages", StageTimes),  # Stages passed so far.
        ("track_number", ctypes.c_uint32),  # Number of the sensor track at its source.
        ("source", ctypes.c_uint16),  # Source: its number in the configuration (TI-2).
        ("valid", ctypes.c_uint16),  # Which fields hold something: see `sensor_track_bits`.
        ("identity", Identity),  # Who the target says it is.
        ("position_m", ctypes.c_double * 3),  # Position east, north, up, metres.
        ("velocity_mps", ctypes.c_double * 3),  # Velocity east, north, up, metres per second.
        ("covariance", Covariance),  # Covariance of position and velocity.
        ("measured_m", ctypes.c_double * 3),  # Measured position, before the source's own filter, metres.
        ("trace_m2", ctypes.c_double),  # Trace of the source's position covariance over east and north, square metres.
        ("state", ctypes.c_uint8),  # State of the track at its source: a `TrackState` code.
        ("method", ctypes.c_uint8),  # Observation method at the source, as numbered by its format; 0 if it has one only.
        ("alerts", ctypes.c_uint8),  # What the target or its source wants noticed: see `alert_bits`.
        ("kind", ctypes.c_uint8),  # What the track follows: a `TrackKind` code.
        ("members", ctypes.c_uint16),  # Expected number of members of a group; 0 for a single target.
        ("reserved", ctypes.c_uint16),  # Reserved, 0.
        ("target_type", TargetType),  # What type of target it is.
    ]

    @staticmethod
    def type_name() -> str:
        return "SensorTrack"


assert ctypes.sizeof(SensorTrack) == 344
assert SensorTrack.time_of_measurement_ns.offset == 0
assert SensorTrack.sequence.offset == 8
assert SensorTrack.stages.offset == 16
assert SensorTrack.track_number.offset == 48
assert SensorTrack.source.offset == 52
assert SensorTrack.valid.offset == 54
assert SensorTrack.identity.offset == 56
assert SensorTrack.position_m.offset == 72
assert SensorTrack.velocity_mps.offset == 96
assert SensorTrack.covariance.offset == 120
assert SensorTrack.measured_m.offset == 288
assert SensorTrack.trace_m2.offset == 312
assert SensorTrack.state.offset == 320
assert SensorTrack.method.offset == 321
assert SensorTrack.alerts.offset == 322
assert SensorTrack.kind.offset == 323
assert SensorTrack.members.offset == 324
assert SensorTrack.reserved.offset == 326
assert SensorTrack.target_type.offset == 328


class SensorDetection(ctypes.Structure):
    _fields_ = [
        ("time_of_measurement_ns", ctypes.c_int64),  # Time of measurement, UTC, nanoseconds since 1970.
        ("sequence", ctypes.c_uint64),  # The detection's sequence number at its publisher.
        ("stages", StageTimes),  # Stages passed so far.
        ("scan", ctypes.c_uint32),  # The sensor's scan, turn or frame; it rises with time.
        ("detection_id", ctypes.c_uint32),  # Number of the detection, unique within its scan.
        ("values", ctypes.c_double * 3),  # Measured values in the order of the kind: metres, radians; 0 beyond.
        ("range_rate_mps", ctypes.c_double),  # Speed away from the sensor, metres per second.
        ("sigmas", ctypes.c_double * 4),  # Standard deviations of the values and, last, of the range rate.
        ("platform_m", ctypes.c_double * 3),  # Where the sensor was, metres east, north and up.
        ("source", ctypes.c_uint16),  # Source: its number in the configuration (TI-2).
        ("kind", ctypes.c_uint8),  # Which quantities were measured: 0 position2, 1 position3, 2 range_bearing, 3 range_bearing_elevation, 4 bearing, 5 bearing_elevation.
        ("valid", ctypes.c_uint8),  # Which fields hold something: see `sensor_detection_bits`.
        ("reserved", ctypes.c_uint32),  # Reserved, 0.
    ]

    @staticmethod
    def type_name() -> str:
        return "SensorDetection"


assert ctypes.sizeof(SensorDetection) == 152
assert SensorDetection.time_of_measurement_ns.offset == 0
assert SensorDetection.sequence.offset == 8
assert SensorDetection.stages.offset == 16
assert SensorDetection.scan.offset == 48
assert SensorDetection.detection_id.offset == 52
assert SensorDetection.values.offset == 56
assert SensorDetection.range_rate_mps.offset == 80
assert SensorDetection.sigmas.offset == 88
assert SensorDetection.platform_m.offset == 120
assert SensorDetection.source.offset == 144
assert SensorDetection.kind.offset == 146
assert SensorDetection.valid.offset == 147
assert SensorDetection.reserved.offset == 148


class SensorBearing(ctypes.Structure):
    _fields_ = [
        ("time_of_measurement_ns", ctypes.c_int64),  # Time of measurement, UTC, nanoseconds since 1970.
        ("sequence", ctypes.c_uint64),  # The bearing's sequence number at its publisher.
        ("stages", StageTimes),  # Stages passed so far.
        ("bearing_rad", ctypes.c_double),  # Direction, radians clockwise from north.
        ("sigma_rad", ctypes.c_double),  # Standard deviation of that, radians.
        ("platform_m", ctypes.c_double * 3),  # Where the platform was, metres east, north and up.
        ("heading_rad", ctypes.c_double),  # Where its nose pointed, radians clockwise from north.
        ("frequency_hz", ctypes.c_double),  # Frequency of the emission, hertz.
        ("pulse_interval_s", ctypes.c_double),  # Time between its pulses, seconds.
        ("emitter_id", ctypes.c_uint32),  # Number of the transmitter at its source.
        ("source", ctypes.c_uint16),  # Source: its number in the configuration (TI-2).
        ("valid", ctypes.c_uint16),  # Which fields hold something: see `sensor_bearing_bits`.
    ]

    @staticmethod
    def type_name() -> str:
        return "SensorBearing"


assert ctypes.sizeof(SensorBearing) == 120
assert SensorBearing.time_of_measurement_ns.offset == 0
assert SensorBearing.sequence.offset == 8
assert SensorBearing.stages.offset == 16
assert SensorBearing.bearing_rad.offset == 48
assert SensorBearing.sigma_rad.offset == 56
assert SensorBearing.platform_m.offset == 64
assert SensorBearing.heading_rad.offset == 88
assert SensorBearing.frequency_hz.offset == 96
assert SensorBearing.pulse_interval_s.offset == 104
assert SensorBearing.emitter_id.offset == 112
assert SensorBearing.source.offset == 116
assert SensorBearing.valid.offset == 118


class PlatformState(ctypes.Structure):
    _fields_ = [
        ("time_ns", ctypes.c_int64),  # Time at which the platform was there, UTC, nanoseconds since 1970.
        ("sequence", ctypes.c_uint64),  # The state's sequence number at its publisher.
        ("stages", StageTimes),  # Stages passed so far.
        ("position_m", ctypes.c_double * 3),  # Position east, north, up in the system frame, metres.
        ("velocity_mps", ctypes.c_double * 3),  # Velocity east, north, up, metres per second.
        ("heading_rad", ctypes.c_double),  # Where its nose points, radians clockwise from north.
        ("pitch_rad", ctypes.c_double),  # Nose above the horizon, radians.
        ("roll_rad", ctypes.c_double),  # Right wing below the horizon, radians.
        ("position_sigma_m", ctypes.c_double),  # Standard deviation of each coordinate of the position, metres.
        ("heading_sigma_rad", ctypes.c_double),  # Standard deviation of the heading, radians.
        ("source", ctypes.c_uint16),  # Source whose sensor it carries: its number in the configuration (TI-2).
        ("valid", ctypes.c_uint16),  # Which fields hold something: see `platform_state_bits`.
        ("reserved", ctypes.c_uint32),  # Reserved, 0.
    ]

    @staticmethod
    def type_name() -> str:
        return "PlatformState"


assert ctypes.sizeof(PlatformState) == 144
assert PlatformState.time_ns.offset == 0
assert PlatformState.sequence.offset == 8
assert PlatformState.stages.offset == 16
assert PlatformState.position_m.offset == 48
assert PlatformState.velocity_mps.offset == 72
assert PlatformState.heading_rad.offset == 96
assert PlatformState.pitch_rad.offset == 104
assert PlatformState.roll_rad.offset == 112
assert PlatformState.position_sigma_m.offset == 120
assert PlatformState.heading_sigma_rad.offset == 128
assert PlatformState.source.offset == 136
assert PlatformState.valid.offset == 138
assert PlatformState.reserved.offset == 140


class WideArea(ctypes.Structure):
    _fields_ = [
        ("time_of_observation_ns", ctypes.c_int64),  # Time of observation, UTC, nanoseconds since 1970.
        ("arrival_ns", ctypes.c_int64),  # Time of arrival, UTC, nanoseconds since 1970; it is used from then on.
        ("sequence", ctypes.c_uint64),  # The report's sequence number at its publisher.
        ("stages", StageTimes),  # Stages passed so far.
        ("position_m", ctypes.c_double * 3),  # Middle of the targets at the time of observation, metres east, north and up.
        ("velocity_mps", ctypes.c_double * 3),  # Their mean velocity east, north, up, metres per second.
        ("origin_m", ctypes.c_double * 2),  # Where they came from, metres east and north.
        ("targets", ctypes.c_uint32),  # Number of targets; 0 says that there were none.
        ("sensor", ctypes.c_uint16),  # The wide-area sensor: its number in the configuration.
        ("valid", ctypes.c_uint16),  # Which fields hold something: see `wide_area_bits`.
    ]

    @staticmethod
    def type_name() -> str:
        return "WideArea"


assert ctypes.sizeof(WideArea) == 128
assert WideArea.time_of_observation_ns.offset == 0
assert WideArea.arrival_ns.offset == 8
assert WideArea.sequence.offset == 16
assert WideArea.stages.offset == 24
assert WideArea.position_m.offset == 56
assert WideArea.velocity_mps.offset == 80
assert WideArea.origin_m.offset == 104
assert WideArea.targets.offset == 120
assert WideArea.sensor.offset == 124
assert WideArea.valid.offset == 126


class Cue(ctypes.Structure):
    _fields_ = [
        ("time_ns", ctypes.c_int64),  # Time of the look, UTC, nanoseconds since 1970.
        ("sequence", ctypes.c_uint64),  # The cue's sequence number at its publisher.
        ("stages", StageTimes),  # Stages passed so far.
        ("position_m", ctypes.c_double * 3),  # Predicted position east, north, up, metres.
        ("velocity_mps", ctypes.c_double * 3),  # Predicted velocity east, north, up, metres per second.
        ("half_axes_m", ctypes.c_double * 2),  # Longer and shorter half axis of the region to be searched, metres.
        ("orientation_rad", ctypes.c_double),  # Direction of the longer one, radians clockwise from north, in [0, pi).
        ("track_number", ctypes.c_uint32),  # Number of the sensor track at its source.
        ("source", ctypes.c_uint16),  # The source that is to look: its number in the configuration (TI-2).
        ("reserved", ctypes.c_uint16),  # Reserved, 0.
    ]

    @staticmethod
    def type_name() -> str:
        return "Cue"


assert ctypes.sizeof(Cue) == 128
assert Cue.time_ns.offset == 0
assert Cue.sequence.offset == 8
assert Cue.stages.offset == 16
assert Cue.position_m.offset == 48
assert Cue.velocity_mps.offset == 72
assert Cue.half_axes_m.offset == 96
assert Cue.orientation_rad.offset == 112
assert Cue.track_number.offset == 120
assert Cue.source.offset == 124
assert Cue.reserved.offset == 126


class Contribution(ctypes.Structure):
    _fields_ = [
        ("time_of_measurement_ns", ctypes.c_int64),  # Time of measurement of the source's latest report, UTC, nanoseconds.
        ("track_number", ctypes.c_uint32),  # Number of the sensor track at its source.
        ("source", ctypes.c_uint16),  # Source number.
        ("flags", ctypes.c_uint16),  # See `contribution_bits`.
        ("weight", ctypes.c_double),  # Coefficient eta in [0, 1]; the weights of one system track sum to 1.
        ("accuracy", ctypes.c_double),  # Accuracy value lambda (TI-9), smaller is better; NaN where the rule has none.
    ]

    @staticmethod
    def type_name() -> str:
        return "Contribution"


assert ctypes.sizeof(Contribution) == 32
assert Contribution.time_of_measurement_ns.offset == 0
assert Contribution.track_number.offset == 8
assert Contribution.source.offset == 12
assert Contribution.flags.offset == 14
assert Contribution.weight.offset == 16
assert Contribution.accuracy.offset == 24


class SystemTrack(ctypes.Structure):
    _fields_ = [
        ("reference_time_ns", ctypes.c_int64),  # Reference time of the state, UTC, nanoseconds since 1970.
        ("time_of_measurement_ns", ctypes.c_int64),  # Time of measurement of the report that caused this state, UTC, nanoseconds; of the reference time, if none did.
        ("sequence", ctypes.c_uint64),  # The state's sequence number at its publisher.
        ("stages", StageTimes),  # Stages of the report that caused this state; all but `fused_ns` are 0 if none did.
        ("track_number", ctypes.c_uint32),  # System-track number, unique while fusion runs.
        ("trigger_source", ctypes.c_uint16),  # Source of the report that caused this state; 65535 if none did (coasting, ending).
        ("selected_source", ctypes.c_uint16),  # Source with the largest weight; 65535 if none contributes.
        ("identity", Identity),  # Who the target says it is.
        ("position_m", ctypes.c_double * 3),  # Position east, north, up, metres.
        ("velocity_mps", ctypes.c_double * 3),  # Velocity east, north, up, metres per second.
        ("covariance", Covariance),  # Covariance of position and velocity.
        ("contributions", Contribution * 16),  # Contributing sources in the order of their numbers; `contribution_count` of them hold something.
        ("source_count", ctypes.c_uint16),  # How many sources contribute.
        ("contribution_count", ctypes.c_uint16),  # How many of `contributions` hold something.
        ("state", ctypes.c_uint8),  # State of the track: a `TrackState` code.
        ("height_valid", ctypes.c_uint8),  # 1 if some source observes height; otherwise z says nothing.
        ("rule", ctypes.c_uint8),  # Fusion rule: its place in the registry of rules.
        ("alerts", ctypes.c_uint8),  # What a contributing source wants noticed: see `alert_bits`.
        ("merged_into", ctypes.c_uint32),  # Number of the system track into which this one was merged, where it ended by a merge; else 0.
        ("on_ground", ctypes.c_uint8),  # 1 if a contributing source says that the target is on the ground.
        ("kind", ctypes.c_uint8),  # What the track follows: a `TrackKind` code.
        ("members", ctypes.c_uint16),  # Expected number of members of a group; 0 for a single target.
        ("target_type", TargetType),  # What type of target it is.
    ]

    @staticmethod
    def type_name() -> str:
        return "SystemTrack"


assert ctypes.sizeof(SystemTrack) == 840
assert SystemTrack.reference_time_ns.offset == 0
assert SystemTrack.time_of_measurement_ns.offset == 8
assert SystemTrack.sequence.offset == 16
assert SystemTrack.stages.offset == 24
assert SystemTrack.track_number.offset == 56
assert SystemTrack.trigger_source.offset == 60
assert SystemTrack.selected_source.offset == 62
assert SystemTrack.identity.offset == 64
assert SystemTrack.position_m.offset == 80
assert SystemTrack.velocity_mps.offset == 104
assert SystemTrack.covariance.offset == 128
assert SystemTrack.contributions.offset == 296
assert SystemTrack.source_count.offset == 808
assert SystemTrack.contribution_count.offset == 810
assert SystemTrack.state.offset == 812
assert SystemTrack.height_valid.offset == 813
assert SystemTrack.rule.offset == 814
assert SystemTrack.alerts.offset == 815
assert SystemTrack.merged_into.offset == 816
assert SystemTrack.on_ground.offset == 820
assert SystemTrack.kind.offset == 821
assert SystemTrack.members.offset == 822
assert SystemTrack.target_type.offset == 824


class Registration(ctypes.Structure):
    _fields_ = [
        ("comparisons", ctypes.c_double),  # Comparisons with other sources that the estimates rest on, after forgetting; 0: nothing is known.
        ("offset_m", ctypes.c_double * 3),  # Estimated offset of the reports from the true positions (east, north, up), metres.
        ("offset_sigma_m", ctypes.c_double * 3),  # Standard deviations of the offset, metres.
        ("time_offset_s", ctypes.c_double),  # Estimated time offset, seconds; positive if the reports show where the target was earlier.
        ("time_offset_sigma_s", ctypes.c_double),  # Its standard deviation, seconds.
        ("range_bias_m", ctypes.c_double),  # Estimated range bias, metres.
        ("range_bias_sigma_m", ctypes.c_double),  # Its standard deviation, metres.
        ("azimuth_bias_rad", ctypes.c_double),  # Estimated azimuth bias, clockwise, radians.
        ("azimuth_bias_sigma_rad", ctypes.c_double),  # Its standard deviation, radians.
        ("covariance_inflation", ctypes.c_double),  # Factor by which the source's covariances are being inflated, since they claim too much; 1 if they do not.
        ("removed", ctypes.c_uint32),  # Which of the errors are being removed from the source's reports: `registration_bits`.
        ("reserved", ctypes.c_uint32),  # Reserved, 0.
    ]

    @staticmethod
    def type_name() -> str:
        return "Registration"


assert ctypes.sizeof(Registration) == 120
assert Registration.comparisons.offset == 0
assert Registration.offset_m.offset == 8
assert Registration.offset_sigma_m.offset == 32
assert Registration.time_offset_s.offset == 56
assert Registration.time_offset_sigma_s.offset == 64
assert Registration.range_bias_m.offset == 72
assert Registration.range_bias_sigma_m.offset == 80
assert Registration.azimuth_bias_rad.offset == 88
assert Registration.azimuth_bias_sigma_rad.offset == 96
assert Registration.covariance_inflation.offset == 104
assert Registration.removed.offset == 112
assert Registration.reserved.offset == 116


class Counters(ctypes.Structure):
    _fields_ = [
        ("values", ctypes.c_uint64 * 80),  # Counts since the process started, indexed by the codes of `Counter`; a few are levels.
    ]

    @staticmethod
    def type_name() -> str:
        return "Counters"


assert ctypes.sizeof(Counters) == 640
assert Counters.values.offset == 0


class Health(ctypes.Structure):
    _fields_ = [
        ("said_ns", ctypes.c_int64),  # When this was said, monotonic, nanoseconds.
        ("incarnation", ctypes.c_uint64),  # Monotonic start time of the process, nanoseconds.
        ("progress_ns", ctypes.c_int64),  # How far the process has got in the time of its data, UTC, nanoseconds; i64::MIN if unknown.
        ("process_id", ctypes.c_uint32),  # Operating system's process number.
        ("source", ctypes.c_uint16),  # Source that the counters speak of; 65535 for the process as a whole.
        ("kind", ctypes.c_uint8),  # What kind of process: a `ProcessKind` code.
        ("life", ctypes.c_uint8),  # A `LifeState` code.
        ("restarts", ctypes.c_uint32),  # Restarts of the process so far, as its launcher counts them.
        ("reserved", ctypes.c_uint32),  # Reserved, 0.
        ("name", ctypes.c_uint8 * 32),  # Name of the process, UTF-8, padded with zeros.
        ("note", ctypes.c_uint8 * 56),  # What is wrong, in a few words; empty if nothing is. Of an adapter's source: its name. UTF-8, padded with zeros.
        ("counters", Counters),  # Values of the counters.
        ("registration", Registration),  # Systematic errors of the source, where fusion speaks of one.
    ]

    @staticmethod
    def type_name() -> str:
        return "Health"


assert ctypes.sizeof(Health) == 888
assert Health.said_ns.offset == 0
assert Health.incarnation.offset == 8
assert Health.progress_ns.offset == 16
assert Health.process_id.offset == 24
assert Health.source.offset == 28
assert Health.kind.offset == 30
assert Health.life.offset == 31
assert Health.restarts.offset == 32
assert Health.reserved.offset == 36
assert Health.name.offset == 40
assert Health.note.offset == 72
assert Health.counters.offset == 128
assert Health.registration.offset == 768


class Progress(ctypes.Structure):
    _fields_ = [
        ("consumer_incarnation", ctypes.c_uint64),  # Monotonic start time of the consumer, nanoseconds: a restart shows as a new value.
        ("publisher_incarnation", ctypes.c_uint64),  # Monotonic start time of the publisher whose samples are counted.
        ("done_sequence", ctypes.c_uint64),  # Samples of that source worked off: all with a sequence number below this.
        ("done_batches", ctypes.c_uint64),  # Slices of that publisher taken since the consumer joined.
        ("progress_ns", ctypes.c_int64),  # How far the consumer has got in the time of the data, UTC, nanoseconds; i64::MIN if unknown.
        ("source", ctypes.c_uint16),  # Source number of the topic, plus 32768 for that of its detections; number of a wide-area
        ("consumer", ctypes.c_uint16),  # The consumer: a `ProcessKind` code.
        ("reserved", ctypes.c_uint16 * 2),  # Reserved, 0.
        ("said_ns", ctypes.c_int64),  # Monotonic time at which this was said, nanoseconds.
    ]

    @staticmethod
    def type_name() -> str:
        return "Progress"


assert ctypes.sizeof(Progress) == 56
assert Progress.consumer_incarnation.offset == 0
assert Progress.publisher_incarnation.offset == 8
assert Progress.done_sequence.offset == 16
assert Progress.done_batches.offset == 24
assert Progress.progress_ns.offset == 32
assert Progress.source.offset == 40
assert Progress.consumer.offset == 42
assert Progress.reserved.offset == 44
assert Progress.said_ns.offset == 48


class Control(ctypes.Structure):
    _fields_ = [
        ("kind", ctypes.c_uint32),  # Kind of order; 1: the condition (weather) named in `name` holds from now on (TI-7).
        ("reserved", ctypes.c_uint32),  # Reserved, 0.
        ("name", ctypes.c_uint8 * 32),  # Name that the order speaks of, UTF-8, padded with zeros.
    ]

    @staticmethod
    def type_name() -> str:
        return "Control"


assert ctypes.sizeof(Control) == 40
assert Control.kind.offset == 0
assert Control.reserved.offset == 4
assert Control.name.offset == 8

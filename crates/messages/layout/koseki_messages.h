/* Koseki's samples in shared memory. Written by `cargo run -p messages --example layouts`; a test keeps it true. */
#ifndef KOSEKI_MESSAGES_H
#define KOSEKI_MESSAGES_H

#include <assert.h>
#include <stddef.h>
#include <stdint.h>

#define KOSEKI_SCHEMA UINT64_C(0x2c00644931801275) /* Every BatchHeader.schema must equal this. */
#define KOSEKI_CONTRIBUTIONS_MAX UINT64_C(0x10) /* Length of SystemTrack.contributions. */
#define KOSEKI_COUNTERS_MAX UINT64_C(0x50) /* Length of Counters.values. */
#define KOSEKI_IDENTITY_ADDRESS UINT64_C(0x1) /* Bit of a flags or valid field. */
#define KOSEKI_IDENTITY_MODE_3A UINT64_C(0x2) /* Bit of a flags or valid field. */
#define KOSEKI_IDENTITY_CALLSIGN UINT64_C(0x4) /* Bit of a flags or valid field. */
#define KOSEKI_SENSOR_TRACK_HEIGHT UINT64_C(0x1) /* Bit of a flags or valid field. */
#define KOSEKI_SENSOR_TRACK_VELOCITY UINT64_C(0x2) /* Bit of a flags or valid field. */
#define KOSEKI_SENSOR_TRACK_VERTICAL_RATE UINT64_C(0x4) /* Bit of a flags or valid field. */
#define KOSEKI_SENSOR_TRACK_OWN_COVARIANCE UINT64_C(0x8) /* Bit of a flags or valid field. */
#define KOSEKI_SENSOR_TRACK_MEASURED UINT64_C(0x10) /* Bit of a flags or valid field. */
#define KOSEKI_SENSOR_TRACK_ON_GROUND UINT64_C(0x20) /* Bit of a flags or valid field. */
#define KOSEKI_SENSOR_TRACK_DERIVED_VELOCITY UINT64_C(0x40) /* Bit of a flags or valid field. */
#define KOSEKI_SENSOR_TRACK_TRACE UINT64_C(0x80) /* Bit of a flags or valid field. */
#define KOSEKI_SENSOR_DETECTION_RANGE_RATE UINT64_C(0x1) /* Bit of a flags or valid field. */
#define KOSEKI_SENSOR_DETECTION_SIGMAS UINT64_C(0x2) /* Bit of a flags or valid field. */
#define KOSEKI_SENSOR_BEARING_EMITTER UINT64_C(0x1) /* Bit of a flags or valid field. */
#define KOSEKI_SENSOR_BEARING_HEADING UINT64_C(0x2) /* Bit of a flags or valid field. */
#define KOSEKI_SENSOR_BEARING_FREQUENCY UINT64_C(0x4) /* Bit of a flags or valid field. */
#define KOSEKI_SENSOR_BEARING_PULSE_INTERVAL UINT64_C(0x8) /* Bit of a flags or valid field. */
#define KOSEKI_PLATFORM_STATE_VELOCITY UINT64_C(0x1) /* Bit of a flags or valid field. */
#define KOSEKI_PLATFORM_STATE_HEADING UINT64_C(0x2) /* Bit of a flags or valid field. */
#define KOSEKI_PLATFORM_STATE_ATTITUDE UINT64_C(0x4) /* Bit of a flags or valid field. */
#define KOSEKI_PLATFORM_STATE_POSITION_SIGMA UINT64_C(0x8) /* Bit of a flags or valid field. */
#define KOSEKI_PLATFORM_STATE_HEADING_SIGMA UINT64_C(0x10) /* Bit of a flags or valid field. */
#define KOSEKI_WIDE_AREA_ORIGIN UINT64_C(0x1) /* Bit of a flags or valid field. */
#define KOSEKI_CONTRIBUTION_FRESH UINT64_C(0x1) /* Bit of a flags or valid field. */
#define KOSEKI_CONTRIBUTION_SCORED UINT64_C(0x2) /* Bit of a flags or valid field. */
#define KOSEKI_ALERT_SPECIAL_IDENTIFICATION UINT64_C(0x1) /* Bit of a flags or valid field. */
#define KOSEKI_ALERT_EMERGENCY UINT64_C(0x2) /* Bit of a flags or valid field. */
#define KOSEKI_ALERT_COMMUNICATION_FAILURE UINT64_C(0x4) /* Bit of a flags or valid field. */
#define KOSEKI_ALERT_UNLAWFUL_INTERFERENCE UINT64_C(0x8) /* Bit of a flags or valid field. */
#define KOSEKI_ALERT_MEDICAL UINT64_C(0x10) /* Bit of a flags or valid field. */
#define KOSEKI_ALERT_MINIMUM_FUEL UINT64_C(0x20) /* Bit of a flags or valid field. */
#define KOSEKI_ALERT_TRANSPONDER_ALERT UINT64_C(0x40) /* Bit of a flags or valid field. */
#define KOSEKI_ALERT_RESOLUTION_ADVISORY UINT64_C(0x80) /* Bit of a flags or valid field. */
#define KOSEKI_REGISTRATION_EAST UINT64_C(0x1) /* Bit of a flags or valid field. */
#define KOSEKI_REGISTRATION_NORTH UINT64_C(0x2) /* Bit of a flags or valid field. */
#define KOSEKI_REGISTRATION_UP UINT64_C(0x4) /* Bit of a flags or valid field. */
#define KOSEKI_REGISTRATION_TIME UINT64_C(0x8) /* Bit of a flags or valid field. */
#define KOSEKI_REGISTRATION_RANGE UINT64_C(0x10) /* Bit of a flags or valid field. */
#define KOSEKI_REGISTRATION_AZIMUTH UINT64_C(0x20) /* Bit of a flags or valid field. */
#define KOSEKI_STATE_TENTATIVE UINT64_C(0x0) /* Value of a state field. */
#define KOSEKI_STATE_CONFIRMED UINT64_C(0x1) /* Value of a state field. */
#define KOSEKI_STATE_COASTED UINT64_C(0x2) /* Value of a state field. */
#define KOSEKI_STATE_TERMINATED UINT64_C(0x3) /* Value of a state field. */
#define KOSEKI_KIND_SINGLE UINT64_C(0x0) /* Value of a track's kind field. */
#define KOSEKI_KIND_GROUP UINT64_C(0x1) /* Value of a track's kind field. */

typedef struct KosekiStageTimes {
    int64_t ingested_ns; /* The adapter had the report's last byte. */
    int64_t published_ns; /* The adapter handed the report to shared memory. */
    int64_t taken_ns; /* Fusion took the report from shared memory. */
    int64_t fused_ns; /* Fusion handed the system track to shared memory. */
} KosekiStageTimes;
static_assert(sizeof(KosekiStageTimes) == 32, "size");
static_assert(offsetof(KosekiStageTimes, ingested_ns) == 0, "offset");
static_assert(offsetof(KosekiStageTimes, published_ns) == 8, "offset");
static_assert(offsetof(KosekiStageTimes, taken_ns) == 16, "offset");
static_assert(offsetof(KosekiStageTimes, fused_ns) == 24, "offset");

typedef struct KosekiIdentity {
    uint32_t address; /* 24-bit aircraft address in the low bits. */
    uint16_t mode_3a; /* Mode 3/A code, its four octal digits in twelve bits. */
    uint16_t valid; /* Which fields hold something: see `identity_bits`. */
    uint8_t callsign[8]; /* Callsign in ASCII, padded with blanks. */
} KosekiIdentity;
static_assert(sizeof(KosekiIdentity) == 16, "size");
static_assert(offsetof(KosekiIdentity, address) == 0, "offset");
static_assert(offsetof(KosekiIdentity, mode_3a) == 4, "offset");
static_assert(offsetof(KosekiIdentity, valid) == 6, "offset");
static_assert(offsetof(KosekiIdentity, callsign) == 8, "offset");

typedef struct KosekiTargetType {
    uint8_t name[12]; /* Name in ASCII, padded with blanks. */
    float confidence; /* Probability that it is of that type, in (0, 1]; 0 where no type is known. */
} KosekiTargetType;
static_assert(sizeof(KosekiTargetType) == 16, "size");
static_assert(offsetof(KosekiTargetType, name) == 0, "offset");
static_assert(offsetof(KosekiTargetType, confidence) == 12, "offset");

typedef struct KosekiCovariance {
    double upper[21]; /* The 21 elements. */
} KosekiCovariance;
static_assert(sizeof(KosekiCovariance) == 168, "size");
static_assert(offsetof(KosekiCovariance, upper) == 0, "offset");

typedef struct KosekiBatchHeader {
    uint64_t schema; /* Fingerprint of the layouts the publisher was built with; others are refused. */
    uint64_t incarnation; /* Monotonic start time of the publisher, nanoseconds: a restart shows as a new value. */
    uint64_t first_sequence; /* Samples sent by this incarnation before this slice: the sequence number of its first sample. */
    int64_t progress_ns; /* Progress mark: no later sample will have a time of measurement before this (UTC, ns); i64::MIN if unknown. */
    int64_t sent_ns; /* Monotonic time of the send, nanoseconds. */
    uint32_t flags; /* Bit 0: the source has ended, and nothing follows. */
    uint32_t reserved; /* Reserved, 0. */
} KosekiBatchHeader;
static_assert(sizeof(KosekiBatchHeader) == 48, "size");
static_assert(offsetof(KosekiBatchHeader, schema) == 0, "offset");
static_assert(offsetof(KosekiBatchHeader, incarnation) == 8, "offset");
static_assert(offsetof(KosekiBatchHeader, first_sequence) == 16, "offset");
static_assert(offsetof(KosekiBatchHeader, progress_ns) == 24, "offset");
static_assert(offsetof(KosekiBatchHeader, sent_ns) == 32, "offset");
static_assert(offsetof(KosekiBatchHeader, flags) == 40, "offset");
static_assert(offsetof(KosekiBatchHeader, reserved) == 44, "offset");

typedef struct KosekiSensorTrack {
    int64_t time_of_measurement_ns; /* Time of measurement, UTC, nanoseconds since 1970. */
    uint64_t sequence; /* The report's sequence number at its publisher. */
    KosekiStageTimes stages; /* Stages passed so far. */
    uint32_t track_number; /* Number of the sensor track at its source. */
    uint16_t source; /* Source: its number in the configuration (TI-2). */
    uint16_t valid; /* Which fields hold something: see `sensor_track_bits`. */
    KosekiIdentity identity; /* Who the target says it is. */
    double position_m[3]; /* Position east, north, up, metres. */
    double velocity_mps[3]; /* Velocity east, north, up, metres per second. */
    KosekiCovariance covariance; /* Covariance of position and velocity. */
    double measured_m[3]; /* Measured position, before the source's own filter, metres. */
    double trace_m2; /* Trace of the source's position covariance over east and north, square metres. */
    uint8_t state; /* State of the track at its source: a `TrackState` code. */
    uint8_t method; /* Observation method at the source, as numbered by its format; 0 if it has one only. */
    uint8_t alerts; /* What the target or its source wants noticed: see `alert_bits`. */
    uint8_t kind; /* What the track follows: a `TrackKind` code. */
    uint16_t members; /* Expected number of members of a group; 0 for a single target. */
    uint16_t reserved; /* Reserved, 0. */
    KosekiTargetType target_type; /* What type of target it is. */
} KosekiSensorTrack;
static_assert(sizeof(KosekiSensorTrack) == 344, "size");
static_assert(offsetof(KosekiSensorTrack, time_of_measurement_ns) == 0, "offset");
static_assert(offsetof(KosekiSensorTrack, sequence) == 8, "offset");
static_assert(offsetof(KosekiSensorTrack, stages) == 16, "offset");
static_assert(offsetof(KosekiSensorTrack, track_number) == 48, "offset");
static_assert(offsetof(KosekiSensorTrack, source) == 52, "offset");
static_assert(offsetof(KosekiSensorTrack, valid) == 54, "offset");
static_assert(offsetof(KosekiSensorTrack, identity) == 56, "offset");
static_assert(offsetof(KosekiSensorTrack, position_m) == 72, "offset");
static_assert(offsetof(KosekiSensorTrack, velocity_mps) == 96, "offset");
static_assert(offsetof(KosekiSensorTrack, covariance) == 120, "offset");
static_assert(offsetof(KosekiSensorTrack, measured_m) == 288, "offset");
static_assert(offsetof(KosekiSensorTrack, trace_m2) == 312, "offset");
static_assert(offsetof(KosekiSensorTrack, state) == 320, "offset");
static_assert(offsetof(KosekiSensorTrack, method) == 321, "offset");
static_assert(offsetof(KosekiSensorTrack, alerts) == 322, "offset");
static_assert(offsetof(KosekiSensorTrack, kind) == 323, "offset");
static_assert(offsetof(KosekiSensorTrack, members) == 324, "offset");
static_assert(offsetof(KosekiSensorTrack, reserved) == 326, "offset");
static_assert(offsetof(KosekiSensorTrack, target_type) == 328, "offset");

typedef struct KosekiSensorDetection {
    int64_t time_of_measurement_ns; /* Time of measurement, UTC, nanoseconds since 1970. */
    uint64_t sequence; /* The detection's sequence number at its publisher. */
    KosekiStageTimes stages; /* Stages passed so far. */
    uint32_t scan; /* The sensor's scan, turn or frame; it rises with time. */
    uint32_t detection_id; /* Number of the detection, unique within its scan. */
    double values[3]; /* Measured values in the order of the kind: metres, radians; 0 beyond. */
    double range_rate_mps; /* Speed away from the sensor, metres per second. */
    double sigmas[4]; /* Standard deviations of the values and, last, of the range rate. */
    double platform_m[3]; /* Where the sensor was, metres east, north and up. */
    uint16_t source; /* Source: its number in the configuration (TI-2). */
    uint8_t kind; /* Which quantities were measured: 0 position2, 1 position3, 2 range_bearing, 3 range_bearing_elevation, 4 bearing, 5 bearing_elevation. */
    uint8_t valid; /* Which fields hold something: see `sensor_detection_bits`. */
    uint32_t reserved; /* Reserved, 0. */
} KosekiSensorDetection;
static_assert(sizeof(KosekiSensorDetection) == 152, "size");
static_assert(offsetof(KosekiSensorDetection, time_of_measurement_ns) == 0, "offset");
static_assert(offsetof(KosekiSensorDetection, sequence) == 8, "offset");
static_assert(offsetof(KosekiSensorDetection, stages) == 16, "offset");
static_assert(offsetof(KosekiSensorDetection, scan) == 48, "offset");
static_assert(offsetof(KosekiSensorDetection, detection_id) == 52, "offset");
static_assert(offsetof(KosekiSensorDetection, values) == 56, "offset");
static_assert(offsetof(KosekiSensorDetection, range_rate_mps) == 80, "offset");
static_assert(offsetof(KosekiSensorDetection, sigmas) == 88, "offset");
static_assert(offsetof(KosekiSensorDetection, platform_m) == 120, "offset");
static_assert(offsetof(KosekiSensorDetection, source) == 144, "offset");
static_assert(offsetof(KosekiSensorDetection, kind) == 146, "offset");
static_assert(offsetof(KosekiSensorDetection, valid) == 147, "offset");
static_assert(offsetof(KosekiSensorDetection, reserved) == 148, "offset");

typedef struct KosekiSensorBearing {
    int64_t time_of_measurement_ns; /* Time of measurement, UTC, nanoseconds since 1970. */
    uint64_t sequence; /* The bearing's sequence number at its publisher. */
    KosekiStageTimes stages; /* Stages passed so far. */
    double bearing_rad; /* Direction, radians clockwise from north. */
    double sigma_rad; /* Standard deviation of that, radians. */
    double platform_m[3]; /* Where the platform was, metres east, north and up. */
    double heading_rad; /* Where its nose pointed, radians clockwise from north. */
    double frequency_hz; /* Frequency of the emission, hertz. */
    double pulse_interval_s; /* Time between its pulses, seconds. */
    uint32_t emitter_id; /* Number of the transmitter at its source. */
    uint16_t source; /* Source: its number in the configuration (TI-2). */
    uint16_t valid; /* Which fields hold something: see `sensor_bearing_bits`. */
} KosekiSensorBearing;
static_assert(sizeof(KosekiSensorBearing) == 120, "size");
static_assert(offsetof(KosekiSensorBearing, time_of_measurement_ns) == 0, "offset");
static_assert(offsetof(KosekiSensorBearing, sequence) == 8, "offset");
static_assert(offsetof(KosekiSensorBearing, stages) == 16, "offset");
static_assert(offsetof(KosekiSensorBearing, bearing_rad) == 48, "offset");
static_assert(offsetof(KosekiSensorBearing, sigma_rad) == 56, "offset");
static_assert(offsetof(KosekiSensorBearing, platform_m) == 64, "offset");
static_assert(offsetof(KosekiSensorBearing, heading_rad) == 88, "offset");
static_assert(offsetof(KosekiSensorBearing, frequency_hz) == 96, "offset");
static_assert(offsetof(KosekiSensorBearing, pulse_interval_s) == 104, "offset");
static_assert(offsetof(KosekiSensorBearing, emitter_id) == 112, "offset");
static_assert(offsetof(KosekiSensorBearing, source) == 116, "offset");
static_assert(offsetof(KosekiSensorBearing, valid) == 118, "offset");

typedef struct KosekiPlatformState {
    int64_t time_ns; /* Time at which the platform was there, UTC, nanoseconds since 1970. */
    uint64_t sequence; /* The state's sequence number at its publisher. */
    KosekiStageTimes stages; /* Stages passed so far. */
    double position_m[3]; /* Position east, north, up in the system frame, metres. */
    double velocity_mps[3]; /* Velocity east, north, up, metres per second. */
    double heading_rad; /* Where its nose points, radians clockwise from north. */
    double pitch_rad; /* Nose above the horizon, radians. */
    double roll_rad; /* Right wing below the horizon, radians. */
    double position_sigma_m; /* Standard deviation of each coordinate of the position, metres. */
    double heading_sigma_rad; /* Standard deviation of the heading, radians. */
    uint16_t source; /* Source whose sensor it carries: its number in the configuration (TI-2). */
    uint16_t valid; /* Which fields hold something: see `platform_state_bits`. */
    uint32_t reserved; /* Reserved, 0. */
} KosekiPlatformState;
static_assert(sizeof(KosekiPlatformState) == 144, "size");
static_assert(offsetof(KosekiPlatformState, time_ns) == 0, "offset");
static_assert(offsetof(KosekiPlatformState, sequence) == 8, "offset");
static_assert(offsetof(KosekiPlatformState, stages) == 16, "offset");
static_assert(offsetof(KosekiPlatformState, position_m) == 48, "offset");
static_assert(offsetof(KosekiPlatformState, velocity_mps) == 72, "offset");
static_assert(offsetof(KosekiPlatformState, heading_rad) == 96, "offset");
static_assert(offsetof(KosekiPlatformState, pitch_rad) == 104, "offset");
static_assert(offsetof(KosekiPlatformState, roll_rad) == 112, "offset");
static_assert(offsetof(KosekiPlatformState, position_sigma_m) == 120, "offset");
static_assert(offsetof(KosekiPlatformState, heading_sigma_rad) == 128, "offset");
static_assert(offsetof(KosekiPlatformState, source) == 136, "offset");
static_assert(offsetof(KosekiPlatformState, valid) == 138, "offset");
static_assert(offsetof(KosekiPlatformState, reserved) == 140, "offset");

typedef struct KosekiWideArea {
    int64_t time_of_observation_ns; /* Time of observation, UTC, nanoseconds since 1970. */
    int64_t arrival_ns; /* Time of arrival, UTC, nanoseconds since 1970; it is used from then on. */
    uint64_t sequence; /* The report's sequence number at its publisher. */
    KosekiStageTimes stages; /* Stages passed so far. */
    double position_m[3]; /* Middle of the targets at the time of observation, metres east, north and up. */
    double velocity_mps[3]; /* Their mean velocity east, north, up, metres per second. */
    double origin_m[2]; /* Where they came from, metres east and north. */
    uint32_t targets; /* Number of targets; 0 says that there were none. */
    uint16_t sensor; /* The wide-area sensor: its number in the configuration. */
    uint16_t valid; /* Which fields hold something: see `wide_area_bits`. */
} KosekiWideArea;
static_assert(sizeof(KosekiWideArea) == 128, "size");
static_assert(offsetof(KosekiWideArea, time_of_observation_ns) == 0, "offset");
static_assert(offsetof(KosekiWideArea, arrival_ns) == 8, "offset");
static_assert(offsetof(KosekiWideArea, sequence) == 16, "offset");
static_assert(offsetof(KosekiWideArea, stages) == 24, "offset");
static_assert(offsetof(KosekiWideArea, position_m) == 56, "offset");
static_assert(offsetof(KosekiWideArea, velocity_mps) == 80, "offset");
static_assert(offsetof(KosekiWideArea, origin_m) == 104, "offset");
static_assert(offsetof(KosekiWideArea, targets) == 120, "offset");
static_assert(offsetof(KosekiWideArea, sensor) == 124, "offset");
static_assert(offsetof(KosekiWideArea, valid) == 126, "offset");

typedef struct KosekiCue {
    int64_t time_ns; /* Time of the look, UTC, nanoseconds since 1970. */
    uint64_t sequence; /* The cue's sequence number at its publisher. */
    KosekiStageTimes stages; /* Stages passed so far. */
    double position_m[3]; /* Predicted position east, north, up, metres. */
    double velocity_mps[3]; /* Predicted velocity east, north, up, metres per second. */
    double half_axes_m[2]; /* Longer and shorter half axis of the region to be searched, metres. */
    double orientation_rad; /* Direction of the longer one, radians clockwise from north, in [0, pi). */
    uint32_t track_number; /* Number of the sensor track at its source. */
    uint16_t source; /* The source that is to look: its number in the configuration (TI-2). */
    uint16_t reserved; /* Reserved, 0. */
} KosekiCue;
static_assert(sizeof(KosekiCue) == 128, "size");
static_assert(offsetof(KosekiCue, time_ns) == 0, "offset");
static_assert(offsetof(KosekiCue, sequence) == 8, "offset");
static_assert(offsetof(KosekiCue, stages) == 16, "offset");
static_assert(offsetof(KosekiCue, position_m) == 48, "offset");
static_assert(offsetof(KosekiCue, velocity_mps) == 72, "offset");
static_assert(offsetof(KosekiCue, half_axes_m) == 96, "offset");
static_assert(offsetof(KosekiCue, orientation_rad) == 112, "offset");
static_assert(offsetof(KosekiCue, track_number) == 120, "offset");
static_assert(offsetof(KosekiCue, source) == 124, "offset");
static_assert(offsetof(KosekiCue, reserved) == 126, "offset");

typedef struct KosekiContribution {
    int64_t time_of_measurement_ns; /* Time of measurement of the source's latest report, UTC, nanoseconds. */
    uint32_t track_number; /* Number of the sensor track at its source. */
    uint16_t source; /* Source number. */
    uint16_t flags; /* See `contribution_bits`. */
    double weight; /* Coefficient eta in [0, 1]; the weights of one system track sum to 1. */
    double accuracy; /* Accuracy value lambda (TI-9), smaller is better; NaN where the rule has none. */
} KosekiContribution;
static_assert(sizeof(KosekiContribution) == 32, "size");
static_assert(offsetof(KosekiContribution, time_of_measurement_ns) == 0, "offset");
static_assert(offsetof(KosekiContribution, track_number) == 8, "offset");
static_assert(offsetof(KosekiContribution, source) == 12, "offset");
static_assert(offsetof(KosekiContribution, flags) == 14, "offset");
static_assert(offsetof(KosekiContribution, weight) == 16, "offset");
static_assert(offsetof(KosekiContribution, accuracy) == 24, "offset");

typedef struct KosekiSystemTrack {
    int64_t reference_time_ns; /* Reference time of the state, UTC, nanoseconds since 1970. */
    int64_t time_of_measurement_ns; /* Time of measurement of the report that caused this state, UTC, nanoseconds; of the reference time, if none did. */
    uint64_t sequence; /* The state's sequence number at its publisher. */
    KosekiStageTimes stages; /* Stages of the report that caused this state; all but `fused_ns` are 0 if none did. */
    uint32_t track_number; /* System-track number, unique while fusion runs. */
    uint16_t trigger_source; /* Source of the report that caused this state; 65535 if none did (coasting, ending). */
    uint16_t selected_source; /* Source with the largest weight; 65535 if none contributes. */
    KosekiIdentity identity; /* Who the target says it is. */
    double position_m[3]; /* Position east, north, up, metres. */
    double velocity_mps[3]; /* Velocity east, north, up, metres per second. */
    KosekiCovariance covariance; /* Covariance of position and velocity. */
    KosekiContribution contributions[16]; /* Contributing sources in the order of their numbers; `contribution_count` of them hold something. */
    uint16_t source_count; /* How many sources contribute. */
    uint16_t contribution_count; /* How many of `contributions` hold something. */
    uint8_t state; /* State of the track: a `TrackState` code. */
    uint8_t height_valid; /* 1 if some source observes height; otherwise z says nothing. */
    uint8_t rule; /* Fusion rule: its place in the registry of rules. */
    uint8_t alerts; /* What a contributing source wants noticed: see `alert_bits`. */
    uint32_t merged_into; /* Number of the system track into which this one was merged, where it ended by a merge; else 0. */
    uint8_t on_ground; /* 1 if a contributing source says that the target is on the ground. */
    uint8_t kind; /* What the track follows: a `TrackKind` code. */
    uint16_t members; /* Expected number of members of a group; 0 for a single target. */
    KosekiTargetType target_type; /* What type of target it is. */
} KosekiSystemTrack;
static_assert(sizeof(KosekiSystemTrack) == 840, "size");
static_assert(offsetof(KosekiSystemTrack, reference_time_ns) == 0, "offset");
static_assert(offsetof(KosekiSystemTrack, time_of_measurement_ns) == 8, "offset");
static_assert(offsetof(KosekiSystemTrack, sequence) == 16, "offset");
static_assert(offsetof(KosekiSystemTrack, stages) == 24, "offset");
static_assert(offsetof(KosekiSystemTrack, track_number) == 56, "offset");
static_assert(offsetof(KosekiSystemTrack, trigger_source) == 60, "offset");
static_assert(offsetof(KosekiSystemTrack, selected_source) == 62, "offset");
static_assert(offsetof(KosekiSystemTrack, identity) == 64, "offset");
static_assert(offsetof(KosekiSystemTrack, position_m) == 80, "offset");
static_assert(offsetof(KosekiSystemTrack, velocity_mps) == 104, "offset");
static_assert(offsetof(KosekiSystemTrack, covariance) == 128, "offset");
static_assert(offsetof(KosekiSystemTrack, contributions) == 296, "offset");
static_assert(offsetof(KosekiSystemTrack, source_count) == 808, "offset");
static_assert(offsetof(KosekiSystemTrack, contribution_count) == 810, "offset");
static_assert(offsetof(KosekiSystemTrack, state) == 812, "offset");
static_assert(offsetof(KosekiSystemTrack, height_valid) == 813, "offset");
static_assert(offsetof(KosekiSystemTrack, rule) == 814, "offset");
static_assert(offsetof(KosekiSystemTrack, alerts) == 815, "offset");
static_assert(offsetof(KosekiSystemTrack, merged_into) == 816, "offset");
static_assert(offsetof(KosekiSystemTrack, on_ground) == 820, "offset");
static_assert(offsetof(KosekiSystemTrack, kind) == 821, "offset");
static_assert(offsetof(KosekiSystemTrack, members) == 822, "offset");
static_assert(offsetof(KosekiSystemTrack, target_type) == 824, "offset");

typedef struct KosekiRegistration {
    double comparisons; /* Comparisons with other sources that the estimates rest on, after forgetting; 0: nothing is known. */
    double offset_m[3]; /* Estimated offset of the reports from the true positions (east, north, up), metres. */
    double offset_sigma_m[3]; /* Standard deviations of the offset, metres. */
    double time_offset_s; /* Estimated time offset, seconds; positive if the reports show where the target was earlier. */
    double time_offset_sigma_s; /* Its standard deviation, seconds. */
    double range_bias_m; /* Estimated range bias, metres. */
    double range_bias_sigma_m; /* Its standard deviation, metres. */
    double azimuth_bias_rad; /* Estimated azimuth bias, clockwise, radians. */
    double azimuth_bias_sigma_rad; /* Its standard deviation, radians. */
    double covariance_inflation; /* Factor by which the source's covariances are being inflated, since they claim too much; 1 if they do not. */
    uint32_t removed; /* Which of the errors are being removed from the source's reports: `registration_bits`. */
    uint32_t reserved; /* Reserved, 0. */
} KosekiRegistration;
static_assert(sizeof(KosekiRegistration) == 120, "size");
static_assert(offsetof(KosekiRegistration, comparisons) == 0, "offset");
static_assert(offsetof(KosekiRegistration, offset_m) == 8, "offset");
static_assert(offsetof(KosekiRegistration, offset_sigma_m) == 32, "offset");
static_assert(offsetof(KosekiRegistration, time_offset_s) == 56, "offset");
static_assert(offsetof(KosekiRegistration, time_offset_sigma_s) == 64, "offset");
static_assert(offsetof(KosekiRegistration, range_bias_m) == 72, "offset");
static_assert(offsetof(KosekiRegistration, range_bias_sigma_m) == 80, "offset");
static_assert(offsetof(KosekiRegistration, azimuth_bias_rad) == 88, "offset");
static_assert(offsetof(KosekiRegistration, azimuth_bias_sigma_rad) == 96, "offset");
static_assert(offsetof(KosekiRegistration, covariance_inflation) == 104, "offset");
static_assert(offsetof(KosekiRegistration, removed) == 112, "offset");
static_assert(offsetof(KosekiRegistration, reserved) == 116, "offset");

typedef struct KosekiCounters {
    uint64_t values[80]; /* Counts since the process started, indexed by the codes of `Counter`; a few are levels. */
} KosekiCounters;
static_assert(sizeof(KosekiCounters) == 640, "size");
static_assert(offsetof(KosekiCounters, values) == 0, "offset");

typedef struct KosekiHealth {
    int64_t said_ns; /* When this was said, monotonic, nanoseconds. */
    uint64_t incarnation; /* Monotonic start time of the process, nanoseconds. */
    int64_t progress_ns; /* How far the process has got in the time of its data, UTC, nanoseconds; i64::MIN if unknown. */
    uint32_t process_id; /* Operating system's process number. */
    uint16_t source; /* Source that the counters speak of; 65535 for the process as a whole. */
    uint8_t kind; /* What kind of process: a `ProcessKind` code. */
    uint8_t life; /* A `LifeState` code. */
    uint32_t restarts; /* Restarts of the process so far, as its launcher counts them. */
    uint32_t reserved; /* Reserved, 0. */
    uint8_t name[32]; /* Name of the process, UTF-8, padded with zeros. */
    uint8_t note[56]; /* What is wrong, in a few words; empty if nothing is. Of an adapter's source: its name. UTF-8, padded with zeros. */
    KosekiCounters counters; /* Values of the counters. */
    KosekiRegistration registration; /* Systematic errors of the source, where fusion speaks of one. */
} KosekiHealth;
static_assert(sizeof(KosekiHealth) == 888, "size");
static_assert(offsetof(KosekiHealth, said_ns) == 0, "offset");
static_assert(offsetof(KosekiHealth, incarnation) == 8, "offset");
static_assert(offsetof(KosekiHealth, progress_ns) == 16, "offset");
static_assert(offsetof(KosekiHealth, process_id) == 24, "offset");
static_assert(offsetof(KosekiHealth, source) == 28, "offset");
static_assert(offsetof(KosekiHealth, kind) == 30, "offset");
static_assert(offsetof(KosekiHealth, life) == 31, "offset");
static_assert(offsetof(KosekiHealth, restarts) == 32, "offset");
static_assert(offsetof(KosekiHealth, reserved) == 36, "offset");
static_assert(offsetof(KosekiHealth, name) == 40, "offset");
static_assert(offsetof(KosekiHealth, note) == 72, "offset");
static_assert(offsetof(KosekiHealth, counters) == 128, "offset");
static_assert(offsetof(KosekiHealth, registration) == 768, "offset");

typedef struct KosekiProgress {
    uint64_t consumer_incarnation; /* Monotonic start time of the consumer, nanoseconds: a restart shows as a new value. */
    uint64_t publisher_incarnation; /* Monotonic start time of the publisher whose samples are counted. */
    uint64_t done_sequence; /* Samples of that source worked off: all with a sequence number below this. */
    uint64_t done_batches; /* Slices of that publisher taken since the consumer joined. */
    int64_t progress_ns; /* How far the consumer has got in the time of the data, UTC, nanoseconds; i64::MIN if unknown. */
    uint16_t source; /* Source number of the topic, plus 32768 for that of its detections; number of a wide-area */
    uint16_t consumer; /* The consumer: a `ProcessKind` code. */
    uint16_t reserved[2]; /* Reserved, 0. */
    int64_t said_ns; /* Monotonic time at which this was said, nanoseconds. */
} KosekiProgress;
static_assert(sizeof(KosekiProgress) == 56, "size");
static_assert(offsetof(KosekiProgress, consumer_incarnation) == 0, "offset");
static_assert(offsetof(KosekiProgress, publisher_incarnation) == 8, "offset");
static_assert(offsetof(KosekiProgress, done_sequence) == 16, "offset");
static_assert(offsetof(KosekiProgress, done_batches) == 24, "offset");
static_assert(offsetof(KosekiProgress, progress_ns) == 32, "offset");
static_assert(offsetof(KosekiProgress, source) == 40, "offset");
static_assert(offsetof(KosekiProgress, consumer) == 42, "offset");
static_assert(offsetof(KosekiProgress, reserved) == 44, "offset");
static_assert(offsetof(KosekiProgress, said_ns) == 48, "offset");

typedef struct KosekiControl {
    uint32_t kind; /* Kind of order; 1: the condition (weather) named in `name` holds from now on (TI-7). */
    uint32_t reserved; /* Reserved, 0. */
    uint8_t name[32]; /* Name that the order speaks of, UTF-8, padded with zeros. */
} KosekiControl;
static_assert(sizeof(KosekiControl) == 40, "size");
static_assert(offsetof(KosekiControl, kind) == 0, "offset");
static_assert(offsetof(KosekiControl, reserved) == 4, "offset");
static_assert(offsetof(KosekiControl, name) == 8, "offset");

#endif

/* Koseki's samples in shared memory. Written by `cargo run -p koseki-messages --example layouts`; a test keeps it true. */
#ifndef KOSEKI_MESSAGES_H
#define KOSEKI_MESSAGES_H

#include <assert.h>
#include <stddef.h>
#include <stdint.h>

#define KOSEKI_SENSOR_TRACK_SCHEMA UINT64_C(0xd57b159a09bf25f1) /* BatchHeader.schema of its slices. */
#define KOSEKI_SENSOR_DETECTION_SCHEMA UINT64_C(0xb3d1d23463cd8924) /* BatchHeader.schema of its slices. */
#define KOSEKI_SENSOR_BEARING_SCHEMA UINT64_C(0x91e05a7e1c4e0342) /* BatchHeader.schema of its slices. */
#define KOSEKI_SENSOR_ARRIVAL_SCHEMA UINT64_C(0x131e74a726730982) /* BatchHeader.schema of its slices. */
#define KOSEKI_SENSOR_FIX_SCHEMA UINT64_C(0xc19ad4d762f53481) /* BatchHeader.schema of its slices. */
#define KOSEKI_TARGET_STATEMENT_SCHEMA UINT64_C(0x3e47c1c272437996) /* BatchHeader.schema of its slices. */
#define KOSEKI_SENSOR_SPECTRUM_SCHEMA UINT64_C(0x294141f134fd3cce) /* BatchHeader.schema of its slices. */
#define KOSEKI_PLATFORM_STATE_SCHEMA UINT64_C(0x8d494f0b5412852b) /* BatchHeader.schema of its slices. */
#define KOSEKI_WIDE_AREA_SCHEMA UINT64_C(0x3b99c7106b96bc51) /* BatchHeader.schema of its slices. */
#define KOSEKI_CUE_SCHEMA UINT64_C(0x628bf8748d0293cc) /* BatchHeader.schema of its slices. */
#define KOSEKI_SYSTEM_TRACK_SCHEMA UINT64_C(0xbb9fd7f5d50f9179) /* BatchHeader.schema of its slices. */
#define KOSEKI_ALARM_SCHEMA UINT64_C(0x2f65dffd42e7c22b) /* BatchHeader.schema of its slices. */
#define KOSEKI_ALERT_SCHEMA UINT64_C(0x58bd4799add0a0cd) /* BatchHeader.schema of its slices. */
#define KOSEKI_DECISION_SCHEMA UINT64_C(0x9f26827141266f51) /* BatchHeader.schema of its slices. */
#define KOSEKI_HEALTH_SCHEMA UINT64_C(0xf1efa5cf6695293f) /* BatchHeader.schema of its slices. */
#define KOSEKI_PROGRESS_SCHEMA UINT64_C(0x724a090fd5e41882) /* BatchHeader.schema of its slices. */
#define KOSEKI_ORDER_STATE_SCHEMA UINT64_C(0x75a8ec42ae46cfc0) /* BatchHeader.schema of its slices. */
#define KOSEKI_FRAME_ORIGIN_SCHEMA UINT64_C(0x7a0c5d4e9d39fa05) /* BatchHeader.schema of its slices. */
#define KOSEKI_WORK_STEP_SCHEMA UINT64_C(0x44541240a46ea825) /* BatchHeader.schema of its slices. */
#define KOSEKI_RESTORED_SCHEMA UINT64_C(0xb57ebe5154fb4a98) /* BatchHeader.schema of its slices. */
#define KOSEKI_CONTRIBUTIONS_MAX UINT64_C(0x10) /* Length of SystemTrack.contributions. */
#define KOSEKI_COUNTERS_MAX UINT64_C(0xa0) /* Length of Counters.values. */
#define KOSEKI_IDENTITY_MODE_3A UINT64_C(0x1) /* `mode_3a` holds a Mode 3/A code. */
#define KOSEKI_IDENTITY_CALLSIGN UINT64_C(0x2) /* `callsign` holds a callsign. */
#define KOSEKI_IDENTITY_NAME UINT64_C(0x4) /* `name` holds a name. */
#define KOSEKI_MOVEMENT_ACCELERATION UINT64_C(0x1) /* `acceleration_mps2` is known east and north. */
#define KOSEKI_MOVEMENT_VERTICAL_ACCELERATION UINT64_C(0x2) /* `acceleration_mps2` is known upwards. */
#define KOSEKI_SENSOR_TRACK_HEIGHT UINT64_C(0x1) /* Height (`position[2]`) was observed; otherwise z is 0 and its variance has no meaning. */
#define KOSEKI_SENSOR_TRACK_VELOCITY UINT64_C(0x2) /* Horizontal velocity was delivered or derived. */
#define KOSEKI_SENSOR_TRACK_VERTICAL_RATE UINT64_C(0x4) /* Vertical velocity was delivered or derived. */
#define KOSEKI_SENSOR_TRACK_OWN_COVARIANCE UINT64_C(0x8) /* The covariance is the source's own statement; otherwise it is derived from configured accuracies. */
#define KOSEKI_SENSOR_TRACK_MEASURED UINT64_C(0x10) /* `measured_m` holds the measurement from which the source updated its track. */
#define KOSEKI_SENSOR_TRACK_ON_GROUND UINT64_C(0x20) /* The source reports that the target is on the ground. */
#define KOSEKI_SENSOR_TRACK_DERIVED_VELOCITY UINT64_C(0x40) /* The velocity was derived by the adapter from successive positions. */
#define KOSEKI_SENSOR_TRACK_TRACE UINT64_C(0x80) /* `trace` holds the source's own covariance trace (TI-16). */
#define KOSEKI_SENSOR_TRACK_WILD_CLOCK UINT64_C(0x100) /* The time of measurement is not believed: it lies far from that of receipt, or the source's clock jumps. */
#define KOSEKI_SENSOR_TRACK_CONTRIBUTORS UINT64_C(0x200) /* `shared_sources` is known: the track is a system track of another centre, which names its sensors. */
#define KOSEKI_SENSOR_TRACK_LEVEL UINT64_C(0x400) /* `level` holds the level of the target's transponder. */
#define KOSEKI_SENSOR_TRACK_TURN_RATE UINT64_C(0x800) /* `turn_rate_radps` is known. */
#define KOSEKI_SENSOR_TRACK_PRESSURE_OFFSET UINT64_C(0x1000) /* `pressure_offset_m` is known: the report states its height in both ways. */
#define KOSEKI_SENSOR_TRACK_PLATFORM UINT64_C(0x2000) /* The sensors move: `measured_m` is the platform's place (east, north) and heading, no measurement. */
#define KOSEKI_SENSOR_DETECTION_RANGE_RATE UINT64_C(0x1) /* `range_rate_mps` was measured. */
#define KOSEKI_SENSOR_DETECTION_SIGMAS UINT64_C(0x2) /* `sigmas` hold standard deviations. */
#define KOSEKI_SENSOR_DETECTION_LEVEL UINT64_C(0x4) /* `level` holds the level of the target's transponder. */
#define KOSEKI_SENSOR_DETECTION_PLATFORM_VELOCITY UINT64_C(0x8) /* `platform_velocity_mps` is known. */
#define KOSEKI_SENSOR_DETECTION_PLATFORM_ATTITUDE UINT64_C(0x10) /* `platform_attitude_rad` and `attitude_sigmas_rad` are known. */
#define KOSEKI_SENSOR_DETECTION_PLATFORM_SIGMA UINT64_C(0x20) /* `platform_sigma_m` is known. */
#define KOSEKI_SENSOR_DETECTION_MARK UINT64_C(0x40) /* The sample is no detection but a mark of the sensor's time: `kind` holds a `DetectionMark` code. */
#define KOSEKI_SENSOR_DETECTION_TARGET_VELOCITY UINT64_C(0x80) /* Of a designation: `platform_velocity_mps` is the velocity of the target east and north, and the last of */
#define KOSEKI_SENSOR_BEARING_EMITTER UINT64_C(0x1) /* `emitter_id` is known: the sensor distinguishes transmitters. */
#define KOSEKI_SENSOR_BEARING_HEADING UINT64_C(0x2) /* `heading_rad` is known. */
#define KOSEKI_SENSOR_BEARING_FREQUENCY UINT64_C(0x4) /* `frequency_hz` was measured. */
#define KOSEKI_SENSOR_BEARING_PULSE_INTERVAL UINT64_C(0x8) /* `pulse_interval_s` was measured. */
#define KOSEKI_SENSOR_ARRIVAL_DIFFERENCE UINT64_C(0x1) /* `time_s` is a difference: arrival at the receiver minus arrival at the second one. */
#define KOSEKI_SENSOR_ARRIVAL_REFERENCE UINT64_C(0x2) /* `reference_m` is known: the transmission is of a reference emitter. */
#define KOSEKI_PLATFORM_STATE_VELOCITY UINT64_C(0x1) /* `velocity_mps` is known. */
#define KOSEKI_PLATFORM_STATE_HEADING UINT64_C(0x2) /* `heading_rad` is known. */
#define KOSEKI_PLATFORM_STATE_ATTITUDE UINT64_C(0x4) /* `pitch_rad` and `roll_rad` are known. */
#define KOSEKI_PLATFORM_STATE_POSITION_SIGMA UINT64_C(0x8) /* `position_sigma_m` is known. */
#define KOSEKI_PLATFORM_STATE_HEADING_SIGMA UINT64_C(0x10) /* `heading_sigma_rad` is known. */
#define KOSEKI_PLATFORM_STATE_VELOCITY_SIGMA UINT64_C(0x20) /* `velocity_sigma_mps` is known. */
#define KOSEKI_PLATFORM_STATE_ATTITUDE_SIGMA UINT64_C(0x40) /* `pitch_sigma_rad` and `roll_sigma_rad` are known. */
#define KOSEKI_PLATFORM_STATE_NO_POSITION UINT64_C(0x80) /* `position_m` is not known: a state of attitude or velocity alone. */
#define KOSEKI_WIDE_AREA_ORIGIN UINT64_C(0x1) /* `origin_m` is known. */
#define KOSEKI_CONTRIBUTION_FRESH UINT64_C(0x1) /* The source's latest report is within its expected period. */
#define KOSEKI_CONTRIBUTION_SCORED UINT64_C(0x2) /* The accuracy value exists: the source has delivered more than one report. */
#define KOSEKI_CONTRIBUTION_CENTRE UINT64_C(0x4) /* The contribution is a system track of another centre. If not fresh, it is listed for a while without */
#define KOSEKI_ALERT_SPECIAL_IDENTIFICATION UINT64_C(0x1) /* Special position identification: the pilot has pressed the button. */
#define KOSEKI_ALERT_EMERGENCY UINT64_C(0x2) /* An emergency of any kind; Mode 3/A code 7700. */
#define KOSEKI_ALERT_COMMUNICATION_FAILURE UINT64_C(0x4) /* Radio communication has failed; code 7600. */
#define KOSEKI_ALERT_UNLAWFUL_INTERFERENCE UINT64_C(0x8) /* Unlawful interference; code 7500. */
#define KOSEKI_ALERT_MEDICAL UINT64_C(0x10) /* Medical flight. */
#define KOSEKI_ALERT_MINIMUM_FUEL UINT64_C(0x20) /* Minimum fuel. */
#define KOSEKI_ALERT_TRANSPONDER_ALERT UINT64_C(0x40) /* The Mode 3/A code was changed lately, or the transponder raises its alert for another reason. */
#define KOSEKI_ALERT_RESOLUTION_ADVISORY UINT64_C(0x80) /* A collision avoidance system advises the crew to manoeuvre. */
#define KOSEKI_ALERT_VALUE_PREDICTED UINT64_C(0x1) /* `time_to_s` and `probability` are of the future: the event has not happened yet. */
#define KOSEKI_ALERT_VALUE_DISTANCE UINT64_C(0x2) /* `distance_m` and `least_distance_m` hold distances. */
#define KOSEKI_ALERT_VALUE_VERTICAL UINT64_C(0x4) /* `vertical_m` and `least_vertical_m` hold differences of height. */
#define KOSEKI_ALERT_VALUE_VALUE UINT64_C(0x8) /* `value` and `limit` hold what is compared: metres per second, metres or seconds by the kind. */
#define KOSEKI_ALERT_VALUE_ACKNOWLEDGED UINT64_C(0x10) /* An operator has acknowledged the alert. */
#define KOSEKI_REGISTRATION_EAST UINT64_C(0x1) /* The offset east is being removed from the source's reports. */
#define KOSEKI_REGISTRATION_NORTH UINT64_C(0x2) /* The offset north is. */
#define KOSEKI_REGISTRATION_UP UINT64_C(0x4) /* The offset up is. */
#define KOSEKI_REGISTRATION_TIME UINT64_C(0x8) /* The time offset is. */
#define KOSEKI_REGISTRATION_RANGE UINT64_C(0x10) /* The range bias is. */
#define KOSEKI_REGISTRATION_AZIMUTH UINT64_C(0x20) /* The azimuth bias is. */
#define KOSEKI_WORK_STEP_WILD_CLOCK UINT64_C(0x1) /* Fusion did not believe the time of the report. */
#define KOSEKI_TARGET_STATEMENT_SIZE UINT64_C(0x1) /* `length_m` and `width_m` hold a size. */
#define KOSEKI_TARGET_STATEMENT_SELECTED_ALTITUDE UINT64_C(0x2) /* `selected_altitude_m` holds an altitude. */
#define KOSEKI_TARGET_STATEMENT_OPERATOR UINT64_C(0x4) /* `place_deg` holds the place of the operator of an unmanned aircraft. */
#define KOSEKI_TARGET_STATEMENT_STATION UINT64_C(0x8) /* The sample is of a station that is no target: `place_deg` holds its own place, `name` its name. */
#define KOSEKI_TARGET_STATEMENT_VIRTUAL UINT64_C(0x10) /* The aid to navigation is not there: a station ashore sends for it. */
#define KOSEKI_TARGET_STATEMENT_OFF_POSITION UINT64_C(0x20) /* The aid to navigation, which floats, is off its position. */
#define KOSEKI_STATE_TENTATIVE UINT64_C(0x0) /* Seen, not yet believed. */
#define KOSEKI_STATE_CONFIRMED UINT64_C(0x1) /* Believed, and supported by recent reports. */
#define KOSEKI_STATE_COASTED UINT64_C(0x2) /* Believed, but carried on by extrapolation for want of reports. */
#define KOSEKI_STATE_TERMINATED UINT64_C(0x3) /* Ended; the number is not used again soon. */
#define KOSEKI_STATE_SUSPENDED UINT64_C(0x4) /* No longer reported by any source: not shown, while the number rests and may resume. */
#define KOSEKI_KIND_SINGLE UINT64_C(0x0) /* One target. */
#define KOSEKI_KIND_GROUP UINT64_C(0x1) /* Several unresolved targets (WA-7). */
#define KOSEKI_MODE_STEADY UINT64_C(0x0) /* Constant velocity in the plane. */
#define KOSEKI_MODE_AGILE UINT64_C(0x1) /* Nearly constant velocity in the plane with strong process noise. */
#define KOSEKI_MODE_LEFT_TURN UINT64_C(0x2) /* Coordinated turn to the left. */
#define KOSEKI_MODE_RIGHT_TURN UINT64_C(0x3) /* Coordinated turn to the right. */
#define KOSEKI_MODE_SPEED_CHANGE UINT64_C(0x4) /* Change of speed along the course. */
#define KOSEKI_MODE_LEVEL UINT64_C(0x5) /* Constant height. */
#define KOSEKI_MODE_CLIMB UINT64_C(0x6) /* Constant climb rate. */
#define KOSEKI_MODE_CLIMB_CHANGE UINT64_C(0x7) /* Change of the climb rate. */
#define KOSEKI_ERROR_MODEL_UNDECIDED UINT64_C(0x0) /* No model has sufficient evidence. */
#define KOSEKI_ERROR_MODEL_OFFSET UINT64_C(0x1) /* Constant offset in the system frame. */
#define KOSEKI_ERROR_MODEL_BODY UINT64_C(0x2) /* Offset fixed to the target's body: a reference point other than that of other sources. */
#define KOSEKI_ERROR_MODEL_POLAR UINT64_C(0x3) /* Offset that grows with range or azimuth. */
#define KOSEKI_ERROR_MODEL_TIME UINT64_C(0x4) /* Time offset. */
#define KOSEKI_RULE_AUTO UINT64_C(0x1) /* Filter of the target, with learned accuracies of the sources. */
#define KOSEKI_RULE_SYSTEM_FILTER UINT64_C(0x2) /* Filter of the target's own. */
#define KOSEKI_RULE_BEST_SOURCE UINT64_C(0x3) /* Source with the smallest accuracy value. */
#define KOSEKI_RULE_INVERSE_TRACE UINT64_C(0x4) /* Weights inverse to the covariance traces. */
#define KOSEKI_RULE_QUALITY_FACTOR UINT64_C(0x5) /* Weights by quality index. */
#define KOSEKI_RULE_MOSAIC UINT64_C(0x6) /* Source that the cell of a mosaic names. */
#define KOSEKI_RULE_INFORMATION UINT64_C(0x7) /* Information sum of independent errors. */
#define KOSEKI_RULE_COVARIANCE_INTERSECTION UINT64_C(0x8) /* Covariance intersection: bound for unknown correlations. */
#define KOSEKI_RULE_BAR_SHALOM_CAMPO UINT64_C(0x9) /* Bar-Shalom and Campo's combination of correlated errors. */
#define KOSEKI_IDENTITY_KIND_NONE UINT64_C(0x0) /* No number is known. */
#define KOSEKI_IDENTITY_KIND_AIRCRAFT UINT64_C(0x1) /* 24-bit aircraft address. */
#define KOSEKI_IDENTITY_KIND_SHIP UINT64_C(0x2) /* 30-bit Maritime Mobile Service Identity (MMSI). */
#define KOSEKI_HORIZONTAL_UNKNOWN UINT64_C(0x0) /* Not known. */
#define KOSEKI_HORIZONTAL_STRAIGHT UINT64_C(0x1) /* Constant course. */
#define KOSEKI_HORIZONTAL_TURN_LEFT UINT64_C(0x2) /* Turn to the left. */
#define KOSEKI_HORIZONTAL_TURN_RIGHT UINT64_C(0x3) /* Turn to the right. */
#define KOSEKI_VERTICAL_UNKNOWN UINT64_C(0x0) /* Not known. */
#define KOSEKI_VERTICAL_LEVEL UINT64_C(0x1) /* Constant height. */
#define KOSEKI_VERTICAL_CLIMB UINT64_C(0x2) /* Climb. */
#define KOSEKI_VERTICAL_DESCEND UINT64_C(0x3) /* Descent. */
#define KOSEKI_LONGITUDINAL_UNKNOWN UINT64_C(0x0) /* Not known. */
#define KOSEKI_LONGITUDINAL_CONSTANT UINT64_C(0x1) /* Constant speed over ground. */
#define KOSEKI_LONGITUDINAL_INCREASING UINT64_C(0x2) /* Increasing speed over ground. */
#define KOSEKI_LONGITUDINAL_DECREASING UINT64_C(0x3) /* Decreasing speed over ground. */
#define KOSEKI_DETECTION_KIND_POSITION2 UINT64_C(0x0) /* East and north in the system frame. */
#define KOSEKI_DETECTION_KIND_POSITION3 UINT64_C(0x1) /* East, north and up in the system frame. */
#define KOSEKI_DETECTION_KIND_RANGE_BEARING UINT64_C(0x2) /* Slant range and bearing from the sensor. */
#define KOSEKI_DETECTION_KIND_RANGE_BEARING_ELEVATION UINT64_C(0x3) /* Slant range, bearing and elevation from the sensor. */
#define KOSEKI_DETECTION_KIND_BEARING UINT64_C(0x4) /* Bearing from the sensor. */
#define KOSEKI_DETECTION_KIND_BEARING_ELEVATION UINT64_C(0x5) /* Bearing and elevation from the sensor. */
#define KOSEKI_DETECTION_MARK_PASSED UINT64_C(0x0) /* The sensor's time has come to the time of measurement. */
#define KOSEKI_DETECTION_MARK_EMPTY_SCAN UINT64_C(0x1) /* The scan `scan` at the time of measurement has no detections. */
#define KOSEKI_DETECTION_MARK_TURN_BEGINS UINT64_C(0x2) /* A turn of the sensor begins at the time of measurement. */
#define KOSEKI_DETECTION_MARK_UNPLACED UINT64_C(0x3) /* A detection at the time of measurement was refused: no state of the sensor's platform belongs to its time. */
#define KOSEKI_STREAM_SENSOR_TRACKS UINT64_C(0x1) /* Sensor tracks of a source. */
#define KOSEKI_STREAM_DETECTIONS UINT64_C(0x2) /* Detections of a source. */
#define KOSEKI_STREAM_BEARINGS UINT64_C(0x3) /* Bearings of a source. */
#define KOSEKI_STREAM_PLATFORM_STATES UINT64_C(0x4) /* States of the platform that carries a source's sensor. */
#define KOSEKI_STREAM_CUES UINT64_C(0x5) /* Cues for the sensor of a source. */
#define KOSEKI_STREAM_WIDE_AREA UINT64_C(0x6) /* Reports of a wide-area sensor. */
#define KOSEKI_STREAM_SYSTEM_TRACKS UINT64_C(0x7) /* System tracks. */
#define KOSEKI_STREAM_ALARMS UINT64_C(0x8) /* Alarms. */
#define KOSEKI_STREAM_DECISIONS UINT64_C(0x9) /* Decisions of fusion. */
#define KOSEKI_STREAM_ORDERS UINT64_C(0xa) /* States of orders. */
#define KOSEKI_STREAM_ARRIVALS UINT64_C(0xb) /* Arrival times of a source. */
#define KOSEKI_STREAM_FIXES UINT64_C(0xc) /* Ready-made fixes of a source. */
#define KOSEKI_STREAM_STATEMENTS UINT64_C(0xd) /* What the targets of a source state beside their motion. */
#define KOSEKI_STREAM_ALERTS UINT64_C(0xe) /* Alerts on targets. */
#define KOSEKI_STEP_BEGIN UINT64_C(0x1) /* Fusion starts from its configuration: `time_ns` is its epoch. */
#define KOSEKI_STEP_REPORT UINT64_C(0x2) /* The report of `source` with the number `sequence` is worked off, and time has passed up to `time_ns`. */
#define KOSEKI_STEP_PUBLISHER UINT64_C(0x3) /* The next reports of `source` come from the publisher with the incarnation `time_ns`. */
#define KOSEKI_STEP_TIME UINT64_C(0x4) /* Time has passed up to `time_ns` without a report. */
#define KOSEKI_STEP_CONDITION UINT64_C(0x5) /* Condition (weather) number `sequence` holds from now on, when time has passed up to `time_ns`. Written by */
#define KOSEKI_STEP_RESTORED UINT64_C(0x6) /* Fusion resumes from the data on `system/restored` for its epoch; tracks listed there are reported as */
#define KOSEKI_STEP_NUMBERS UINT64_C(0x7) /* Numbers of system tracks begin at `sequence`, because the numbers assigned before are unknown. */
#define KOSEKI_STEP_IMAGE UINT64_C(0x8) /* A snapshot of the engine's present state is published on `system/restored`, with the time `time_ns`. */
#define KOSEKI_STEP_HOST_OFFSET UINT64_C(0x9) /* The sources' time is ahead of the engine's by `time_ns` (nanoseconds) from now on: the host offset. */
#define KOSEKI_STEP_SOURCE_CLOCK UINT64_C(0xa) /* The clock of `source` is off by `sequence` milliseconds (as a signed number), as times of receipt show it. */
#define KOSEKI_STEP_QUARANTINE UINT64_C(0xb) /* The report of `source` with the number `sequence` is in quarantine and has no effect: fusion has died in the */
#define KOSEKI_STEP_ORDER_PART UINT64_C(0xc) /* Bytes 8·`sequence` to 8·`sequence` + 7 of the order that the next step of kind `Order` completes are */
#define KOSEKI_STEP_ORDER UINT64_C(0xd) /* The order of the preceding parts has its effect now, when time has passed up to `time_ns`. */
#define KOSEKI_PROCESS_ADAPTER UINT64_C(0x0) /* Turns one sensor's data into sensor tracks. */
#define KOSEKI_PROCESS_FUSION UINT64_C(0x1) /* Fuses sensor tracks into system tracks. */
#define KOSEKI_PROCESS_MONITOR UINT64_C(0x2) /* Records latencies and counters. */
#define KOSEKI_PROCESS_RECORDER UINT64_C(0x3) /* Writes tracks to files. */
#define KOSEKI_PROCESS_LAUNCHER UINT64_C(0x4) /* Starts and watches the others. */
#define KOSEKI_PROCESS_SIMULATOR UINT64_C(0x5) /* Sends the observations of simulated sensors over the network. */
#define KOSEKI_PROCESS_GATEWAY UINT64_C(0x6) /* Sends tracks to other systems over the network. */
#define KOSEKI_PROCESS_KEEPER UINT64_C(0x7) /* Holds the topics for the launcher, which maps no shared memory itself. */
#define KOSEKI_PROCESS_DISPLAY UINT64_C(0x8) /* Shows the picture in browsers. */
#define KOSEKI_PROCESS_LINK UINT64_C(0x9) /* Exchanges topics with deployments on other hosts. */
#define KOSEKI_PROCESS_ALERTS UINT64_C(0xa) /* Finds events and dangers about targets. */
#define KOSEKI_LIFE_STARTING UINT64_C(0x0) /* Opening its topics. */
#define KOSEKI_LIFE_RUNNING UINT64_C(0x1) /* Doing its work. */
#define KOSEKI_LIFE_FINISHED UINT64_C(0x2) /* Done: all its input is processed, and it will exit. */
#define KOSEKI_LIFE_FAILED UINT64_C(0x3) /* Unable to continue; the note states the reason. */
#define KOSEKI_ALARM_SEVERITY_WARNING UINT64_C(0x1) /* Nothing is wrong yet; it may become so. */
#define KOSEKI_ALARM_SEVERITY_MAJOR UINT64_C(0x2) /* Part of the picture is missing or wrong. */
#define KOSEKI_ALARM_SEVERITY_CRITICAL UINT64_C(0x3) /* The picture as a whole is not to be relied on. */
#define KOSEKI_ALARM_EVENT_RAISED UINT64_C(0x1) /* The alarm has just been raised. */
#define KOSEKI_ALARM_EVENT_STANDING UINT64_C(0x2) /* The alarm was raised before, and stands. */
#define KOSEKI_ALARM_EVENT_CLEARED UINT64_C(0x3) /* The alarm has just been cleared. */
#define KOSEKI_ALERT_KIND_ENTER UINT64_C(0x1) /* A target is in an area, or will be. */
#define KOSEKI_ALERT_KIND_LEAVE UINT64_C(0x2) /* A target has left an area, or will leave it. */
#define KOSEKI_ALERT_KIND_STAY UINT64_C(0x3) /* A target has been in an area for too long. */
#define KOSEKI_ALERT_KIND_CONFLICT UINT64_C(0x4) /* Two aircraft come nearer to each other than both minima. */
#define KOSEKI_ALERT_KIND_APPROACH UINT64_C(0x5) /* Two vessels come close to each other. */
#define KOSEKI_ALERT_KIND_LOW UINT64_C(0x6) /* A target is below a least height, or will be. */
#define KOSEKI_ALERT_KIND_SPEED UINT64_C(0x7) /* A target is too fast or too slow. */
#define KOSEKI_ALERT_KIND_LEVEL UINT64_C(0x8) /* A target is outside of a band of heights. */
#define KOSEKI_ALERT_KIND_LOST UINT64_C(0x9) /* A target is no longer reported. */
#define KOSEKI_ALERT_KIND_EMERGENCY UINT64_C(0xa) /* A target states an emergency. */
#define KOSEKI_DECISION_KIND_STARTED UINT64_C(0x1) /* A system track was started for a sensor track that fits none. */
#define KOSEKI_DECISION_KIND_JOINED UINT64_C(0x2) /* A sensor track joined a system track it fits: value d², limit the gate. */
#define KOSEKI_DECISION_KIND_JOINED_BY_ADDRESS UINT64_C(0x3) /* A sensor track joined the system track of its address. */
#define KOSEKI_DECISION_KIND_DUPLICATE UINT64_C(0x4) /* A sensor track was recognised as another part of a target that its source already follows: value metres. */
#define KOSEKI_DECISION_KIND_IDENTITY_CONFLICT UINT64_C(0x5) /* A sensor track left because its address contradicts the system track's. */
#define KOSEKI_DECISION_KIND_SPLIT UINT64_C(0x6) /* A sensor track left because it kept missing the others: value d², limit the gate. */
#define KOSEKI_DECISION_KIND_MERGED UINT64_C(0x7) /* A system track was found to be the same target as another, and merged into it: value d², limit the gate. */
#define KOSEKI_DECISION_KIND_CONFIRMED UINT64_C(0x8) /* A system track was confirmed: value the number of sources, or the log-likelihood ratio of a single */
#define KOSEKI_DECISION_KIND_WITHHELD UINT64_C(0x9) /* A system track is withheld: its sources report that they no longer detect the target. Value the sum of the */
#define KOSEKI_DECISION_KIND_COASTED UINT64_C(0xa) /* Nothing fresh contributes any more. */
#define KOSEKI_DECISION_KIND_ENDED UINT64_C(0xb) /* A system track has ended. */
#define KOSEKI_DECISION_KIND_HAND_OVER UINT64_C(0xc) /* The selected source has changed: value the new source's accuracy value, limit the previous source's. */
#define KOSEKI_DECISION_KIND_REFERENCE_POINT UINT64_C(0xd) /* The target's reference point is now that of this source. */
#define KOSEKI_DECISION_KIND_UNCROSSED UINT64_C(0xe) /* A sensor track has changed places with another track of its source: value the sum of log-likelihood */
#define KOSEKI_DECISION_KIND_ORDERED UINT64_C(0xf) /* An order of an operator has changed a system track: value the number of the order. */
#define KOSEKI_DECISION_KIND_ORDER_ENDED UINT64_C(0x10) /* An order on system tracks has ended, because the tracks are farther apart than permitted: value the */
#define KOSEKI_DECISION_KIND_SUSPENDED UINT64_C(0x11) /* A system track that was shown is no longer reported: its number rests. */
#define KOSEKI_DECISION_KIND_RESUMED UINT64_C(0x12) /* A target has come back under its former number: value the logarithm of the likelihood ratio of the same */
#define KOSEKI_ORDER_CONDITION UINT64_C(0x1) /* A weather condition holds for the accuracy of a source, or of all sources (TI-7). */
#define KOSEKI_ORDER_SNAPSHOT UINT64_C(0x2) /* Fusion publishes a snapshot of the engine, for a recorder. */
#define KOSEKI_ORDER_OUT UINT64_C(0x3) /* The reports of a source are counted and not used. */
#define KOSEKI_ORDER_IN UINT64_C(0x4) /* The reports of a source that is out are used again. */
#define KOSEKI_ORDER_ETA UINT64_C(0x5) /* First weight eta_0 of a hand-over to a source, from another source or from any (TI-13). */
#define KOSEKI_ORDER_K UINT64_C(0x6) /* Adjustment coefficient k of a source: smaller values are preferred (TI-8). */
#define KOSEKI_ORDER_RULE UINT64_C(0x7) /* A rule weighs the sources of all system tracks. */
#define KOSEKI_ORDER_DROP UINT64_C(0x8) /* A system track ends, and its sensor tracks start no other. */
#define KOSEKI_ORDER_JOIN UINT64_C(0x9) /* Two system tracks are one target: the older number remains. */
#define KOSEKI_ORDER_SPLIT UINT64_C(0xa) /* A sensor track leaves its system track and gets a system track of its own. */
#define KOSEKI_ORDER_RENUMBER UINT64_C(0xb) /* A system track gets a new number, and the old number ends. */
#define KOSEKI_ORDER_RESET UINT64_C(0xc) /* Everything learned of a source is forgotten: errors, accuracy, detection probability, dependence. */
#define KOSEKI_ORDER_CANCEL UINT64_C(0xd) /* An order in force ends. */
#define KOSEKI_ORDER_QNH UINT64_C(0xe) /* The pressure at mean sea level in a region, hPa, by the name of its `[[qnh]]`. */
#define KOSEKI_ORDER_DESIGNATE UINT64_C(0xf) /* A tracker follows the target at a place of this standard deviation, metres. */
#define KOSEKI_ORDER_STATUS_IN_FORCE UINT64_C(0x1) /* The order has an effect that lasts. */
#define KOSEKI_ORDER_STATUS_DONE UINT64_C(0x2) /* The effect has taken place, and nothing of it lasts. */
#define KOSEKI_ORDER_STATUS_CANCELLED UINT64_C(0x3) /* Another order has cancelled this order. */
#define KOSEKI_ORDER_STATUS_EXPIRED UINT64_C(0x4) /* The time of the order is over. */
#define KOSEKI_ORDER_STATUS_REPLACED UINT64_C(0x5) /* A newer order of this kind holds for the same subject. */
#define KOSEKI_ORDER_STATUS_ENDED UINT64_C(0x6) /* The tracks no longer permit the effect: a track has ended, or the distance exceeded its limit. */
#define KOSEKI_ORDER_STATUS_REFUSED UINT64_C(0x7) /* The order has no effect: see `refusal`. */
#define KOSEKI_REFUSAL_UNKNOWN_KIND UINT64_C(0x1) /* No such kind. */
#define KOSEKI_REFUSAL_MALFORMED UINT64_C(0x2) /* A text is not UTF-8, the token is 0, or the expiry lies before 1970. */
#define KOSEKI_REFUSAL_MISSING_PARAMETER UINT64_C(0x3) /* A parameter of the kind is missing. */
#define KOSEKI_REFUSAL_FOREIGN_PARAMETER UINT64_C(0x4) /* A parameter does not belong to the kind. */
#define KOSEKI_REFUSAL_OUT_OF_RANGE UINT64_C(0x5) /* The value lies outside its range. */
#define KOSEKI_REFUSAL_EXPIRED UINT64_C(0x6) /* The order was sent too long ago, or its expiry has passed. */
#define KOSEKI_REFUSAL_TOO_MANY UINT64_C(0x7) /* Too many orders in a short time. */
#define KOSEKI_REFUSAL_TABLE_FULL UINT64_C(0x8) /* The table of orders in force is full. */
#define KOSEKI_REFUSAL_UNKNOWN_SOURCE UINT64_C(0x9) /* No such source. */
#define KOSEKI_REFUSAL_UNKNOWN_CONDITION UINT64_C(0xa) /* No source states a factor for the condition. */
#define KOSEKI_REFUSAL_UNKNOWN_RULE UINT64_C(0xb) /* No such rule. */
#define KOSEKI_REFUSAL_RULE_WITHOUT_REPORTS UINT64_C(0xc) /* The rule needs stored reports, which this deployment does not keep. */
#define KOSEKI_REFUSAL_UNKNOWN_TRACK UINT64_C(0xd) /* No system track with this number is alive. */
#define KOSEKI_REFUSAL_SAME_TRACK UINT64_C(0xe) /* Both parameters name the same system track. */
#define KOSEKI_REFUSAL_TWO_ADDRESSES UINT64_C(0xf) /* The two system tracks have different addresses. */
#define KOSEKI_REFUSAL_UNKNOWN_SENSOR_TRACK UINT64_C(0x10) /* The sensor track is no member of the system track. */
#define KOSEKI_REFUSAL_ONLY_MEMBER UINT64_C(0x11) /* The sensor track is the only member of its system track. */
#define KOSEKI_REFUSAL_BOUND_TRACK UINT64_C(0x12) /* Another order in force already binds the system track. */
#define KOSEKI_REFUSAL_UNKNOWN_ORDER UINT64_C(0x13) /* No order in force has this number. */
#define KOSEKI_REFUSAL_NOT_OUT UINT64_C(0x14) /* The source is not out. */
#define KOSEKI_REFUSAL_BUSY UINT64_C(0x15) /* Fusion still publishes the previous snapshot or states. */
#define KOSEKI_REFUSAL_UNKNOWN_QNH UINT64_C(0x16) /* The configuration has no `[[qnh]]` of this name. */
#define KOSEKI_REFUSAL_TAKES_NO_DESIGNATIONS UINT64_C(0x17) /* The tracker has no sensor that takes orders. */
#define KOSEKI_REFUSAL_NO_PLACE UINT64_C(0x18) /* The text is no place. */
#define KOSEKI_REFUSAL_UNUSED_BY_RULE UINT64_C(0x19) /* The rule in force uses no such value. */
#define KOSEKI_REFUSAL_FAR_PLACE UINT64_C(0x1a) /* The place is too far from the origin of the system frame. */
#define KOSEKI_CATEGORY_UNKNOWN UINT64_C(0x0) /* Nothing is stated. */
#define KOSEKI_CATEGORY_LIGHT UINT64_C(0x1) /* Aircraft below 7,031 kg (15,500 lb). */
#define KOSEKI_CATEGORY_SMALL UINT64_C(0x2) /* Aircraft from 7,031 kg to 34,019 kg (75,000 lb). */
#define KOSEKI_CATEGORY_LARGE UINT64_C(0x3) /* Aircraft from 34,019 kg to 136,078 kg (300,000 lb). */
#define KOSEKI_CATEGORY_HIGH_VORTEX UINT64_C(0x4) /* Aircraft with a strong wake vortex. */
#define KOSEKI_CATEGORY_HEAVY UINT64_C(0x5) /* Aircraft above 136,078 kg. */
#define KOSEKI_CATEGORY_HIGH_PERFORMANCE UINT64_C(0x6) /* Aircraft with an acceleration above 5 g and a speed above 400 knots. */
#define KOSEKI_CATEGORY_ROTORCRAFT UINT64_C(0x7) /* Helicopter or gyroplane. */
#define KOSEKI_CATEGORY_GLIDER UINT64_C(0x8) /* Glider or sailplane. */
#define KOSEKI_CATEGORY_LIGHTER_THAN_AIR UINT64_C(0x9) /* Balloon or airship. */
#define KOSEKI_CATEGORY_PARACHUTIST UINT64_C(0xa) /* Parachutist or skydiver. */
#define KOSEKI_CATEGORY_ULTRALIGHT UINT64_C(0xb) /* Ultralight, hang glider or paraglider. */
#define KOSEKI_CATEGORY_UNMANNED UINT64_C(0xc) /* Unmanned aircraft. */
#define KOSEKI_CATEGORY_SPACE UINT64_C(0xd) /* Space vehicle. */
#define KOSEKI_CATEGORY_EMERGENCY_VEHICLE UINT64_C(0x14) /* Emergency vehicle on the ground. */
#define KOSEKI_CATEGORY_SERVICE_VEHICLE UINT64_C(0x15) /* Service vehicle on the ground. */
#define KOSEKI_CATEGORY_OBSTACLE UINT64_C(0x16) /* Obstacle, fixed or moored. */
#define KOSEKI_CATEGORY_SHIP UINT64_C(0x1e) /* Ship of a kind without a word of its own. */
#define KOSEKI_CATEGORY_WING_IN_GROUND UINT64_C(0x1f) /* Wing in ground effect. */
#define KOSEKI_CATEGORY_FISHING UINT64_C(0x20) /* Fishing vessel. */
#define KOSEKI_CATEGORY_TOWING UINT64_C(0x21) /* Vessel that tows. */
#define KOSEKI_CATEGORY_DREDGING UINT64_C(0x22) /* Vessel engaged in dredging or underwater work. */
#define KOSEKI_CATEGORY_DIVING UINT64_C(0x23) /* Vessel engaged in diving. */
#define KOSEKI_CATEGORY_MILITARY UINT64_C(0x24) /* Vessel engaged in military operations. */
#define KOSEKI_CATEGORY_SAILING UINT64_C(0x25) /* Sailing vessel. */
#define KOSEKI_CATEGORY_PLEASURE UINT64_C(0x26) /* Pleasure craft. */
#define KOSEKI_CATEGORY_HIGH_SPEED UINT64_C(0x27) /* High-speed craft. */
#define KOSEKI_CATEGORY_PILOT UINT64_C(0x28) /* Pilot vessel. */
#define KOSEKI_CATEGORY_RESCUE UINT64_C(0x29) /* Search and rescue vessel, or aircraft with an MMSI. */
#define KOSEKI_CATEGORY_TUG UINT64_C(0x2a) /* Tug. */
#define KOSEKI_CATEGORY_TENDER UINT64_C(0x2b) /* Port tender. */
#define KOSEKI_CATEGORY_ANTI_POLLUTION UINT64_C(0x2c) /* Vessel with anti-pollution facilities. */
#define KOSEKI_CATEGORY_LAW_ENFORCEMENT UINT64_C(0x2d) /* Law enforcement vessel. */
#define KOSEKI_CATEGORY_MEDICAL UINT64_C(0x2e) /* Medical transport. */
#define KOSEKI_CATEGORY_PASSENGER UINT64_C(0x2f) /* Passenger ship. */
#define KOSEKI_CATEGORY_CARGO UINT64_C(0x30) /* Cargo ship. */
#define KOSEKI_CATEGORY_TANKER UINT64_C(0x31) /* Tanker. */
#define KOSEKI_CATEGORY_AID UINT64_C(0x3c) /* Aid to navigation. */
#define KOSEKI_CATEGORY_BASE_STATION UINT64_C(0x3d) /* Base station ashore. */
#define KOSEKI_CATEGORY_RESCUE_TRANSMITTER UINT64_C(0x3e) /* Search and rescue transmitter (AIS-SART, MMSI 970…). */
#define KOSEKI_CATEGORY_MAN_OVERBOARD UINT64_C(0x3f) /* Man overboard device (MMSI 972…). */
#define KOSEKI_CATEGORY_RESCUE_BEACON UINT64_C(0x40) /* Emergency position-indicating radio beacon (MMSI 974…). */
#define KOSEKI_AID_UNKNOWN UINT64_C(0x0) /* Nothing is stated. */
#define KOSEKI_AID_REFERENCE_POINT UINT64_C(0x1) /* Reference point. */
#define KOSEKI_AID_RACON UINT64_C(0x2) /* Radar beacon. */
#define KOSEKI_AID_STRUCTURE UINT64_C(0x3) /* Fixed structure off shore: oil platform, wind farm. */
#define KOSEKI_AID_WRECK UINT64_C(0x4) /* Emergency wreck marking buoy. */
#define KOSEKI_AID_LIGHT UINT64_C(0x5) /* Light without sectors. */
#define KOSEKI_AID_SECTOR_LIGHT UINT64_C(0x6) /* Light with sectors. */
#define KOSEKI_AID_FRONT_LIGHT UINT64_C(0x7) /* Front leading light. */
#define KOSEKI_AID_REAR_LIGHT UINT64_C(0x8) /* Rear leading light. */
#define KOSEKI_AID_NORTH_BEACON UINT64_C(0x9) /* Beacon, cardinal north. */
#define KOSEKI_AID_EAST_BEACON UINT64_C(0xa) /* Beacon, cardinal east. */
#define KOSEKI_AID_SOUTH_BEACON UINT64_C(0xb) /* Beacon, cardinal south. */
#define KOSEKI_AID_WEST_BEACON UINT64_C(0xc) /* Beacon, cardinal west. */
#define KOSEKI_AID_PORT_BEACON UINT64_C(0xd) /* Beacon, port hand. */
#define KOSEKI_AID_STARBOARD_BEACON UINT64_C(0xe) /* Beacon, starboard hand. */
#define KOSEKI_AID_PREFERRED_PORT_BEACON UINT64_C(0xf) /* Beacon, preferred channel port hand. */
#define KOSEKI_AID_PREFERRED_STARBOARD_BEACON UINT64_C(0x10) /* Beacon, preferred channel starboard hand. */
#define KOSEKI_AID_DANGER_BEACON UINT64_C(0x11) /* Beacon, isolated danger. */
#define KOSEKI_AID_SAFE_WATER_BEACON UINT64_C(0x12) /* Beacon, safe water. */
#define KOSEKI_AID_SPECIAL_BEACON UINT64_C(0x13) /* Beacon, special mark. */
#define KOSEKI_AID_NORTH_MARK UINT64_C(0x14) /* Floating mark, cardinal north. */
#define KOSEKI_AID_EAST_MARK UINT64_C(0x15) /* Floating mark, cardinal east. */
#define KOSEKI_AID_SOUTH_MARK UINT64_C(0x16) /* Floating mark, cardinal south. */
#define KOSEKI_AID_WEST_MARK UINT64_C(0x17) /* Floating mark, cardinal west. */
#define KOSEKI_AID_PORT_MARK UINT64_C(0x18) /* Floating mark, port hand. */
#define KOSEKI_AID_STARBOARD_MARK UINT64_C(0x19) /* Floating mark, starboard hand. */
#define KOSEKI_AID_PREFERRED_PORT_MARK UINT64_C(0x1a) /* Floating mark, preferred channel port hand. */
#define KOSEKI_AID_PREFERRED_STARBOARD_MARK UINT64_C(0x1b) /* Floating mark, preferred channel starboard hand. */
#define KOSEKI_AID_DANGER_MARK UINT64_C(0x1c) /* Floating mark, isolated danger. */
#define KOSEKI_AID_SAFE_WATER_MARK UINT64_C(0x1d) /* Floating mark, safe water. */
#define KOSEKI_AID_SPECIAL_MARK UINT64_C(0x1e) /* Floating mark, special. */
#define KOSEKI_AID_LIGHT_VESSEL UINT64_C(0x1f) /* Light vessel, large navigational buoy, or rig. */
#define KOSEKI_NAVIGATION_UNKNOWN UINT64_C(0x0) /* Nothing is stated. */
#define KOSEKI_NAVIGATION_ENGINE UINT64_C(0x1) /* Under way using engine. */
#define KOSEKI_NAVIGATION_ANCHORED UINT64_C(0x2) /* At anchor. */
#define KOSEKI_NAVIGATION_NOT_UNDER_COMMAND UINT64_C(0x3) /* Not under command. */
#define KOSEKI_NAVIGATION_RESTRICTED UINT64_C(0x4) /* Restricted manoeuvrability. */
#define KOSEKI_NAVIGATION_CONSTRAINED UINT64_C(0x5) /* Constrained by the draught. */
#define KOSEKI_NAVIGATION_MOORED UINT64_C(0x6) /* Moored. */
#define KOSEKI_NAVIGATION_AGROUND UINT64_C(0x7) /* Aground. */
#define KOSEKI_NAVIGATION_FISHING UINT64_C(0x8) /* Engaged in fishing. */
#define KOSEKI_NAVIGATION_SAILING UINT64_C(0x9) /* Under way sailing. */
#define KOSEKI_NAVIGATION_RESCUE UINT64_C(0xf) /* Active transmitter of search and rescue: AIS-SART, man overboard or beacon. */
#define KOSEKI_EMERGENCY_UNKNOWN UINT64_C(0x0) /* Nothing is stated. */
#define KOSEKI_EMERGENCY_NONE UINT64_C(0x1) /* No emergency. */
#define KOSEKI_EMERGENCY_GENERAL UINT64_C(0x2) /* General emergency. */
#define KOSEKI_EMERGENCY_MEDICAL UINT64_C(0x3) /* Medical emergency. */
#define KOSEKI_EMERGENCY_MINIMUM_FUEL UINT64_C(0x4) /* Minimum fuel. */
#define KOSEKI_EMERGENCY_NO_COMMUNICATION UINT64_C(0x5) /* No communication. */
#define KOSEKI_EMERGENCY_UNLAWFUL_INTERFERENCE UINT64_C(0x6) /* Unlawful interference. */
#define KOSEKI_EMERGENCY_DOWNED UINT64_C(0x7) /* Downed aircraft. */
#define KOSEKI_EMERGENCY_DISTRESS UINT64_C(0x8) /* Distress at sea. */

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
    uint32_t address; /* 24-bit aircraft address or 30-bit MMSI (see `kind`), an integer in the low bits. */
    uint16_t mode_3a; /* Mode 3/A code, an integer of twelve bits: 2300 in octal digits is 1216. */
    uint8_t kind; /* Kind of `address`: an `IdentityKind` code. */
    uint8_t valid; /* Fields that hold something: see `identity_bits`. */
    uint8_t callsign[8]; /* Callsign in ASCII, padded with blanks. */
    uint8_t name[20]; /* Name in ASCII, padded with blanks: that of a ship, for example. */
    uint32_t reserved; /* Reserved, 0. */
} KosekiIdentity;
static_assert(sizeof(KosekiIdentity) == 40, "size");
static_assert(offsetof(KosekiIdentity, address) == 0, "offset");
static_assert(offsetof(KosekiIdentity, mode_3a) == 4, "offset");
static_assert(offsetof(KosekiIdentity, kind) == 6, "offset");
static_assert(offsetof(KosekiIdentity, valid) == 7, "offset");
static_assert(offsetof(KosekiIdentity, callsign) == 8, "offset");
static_assert(offsetof(KosekiIdentity, name) == 16, "offset");
static_assert(offsetof(KosekiIdentity, reserved) == 36, "offset");

typedef struct KosekiIdentityAges {
    uint32_t address_ms; /* Age of `address`, milliseconds. */
    uint32_t mode_3a_ms; /* Age of `mode_3a`, milliseconds. */
    uint32_t callsign_ms; /* Age of `callsign`, milliseconds. */
} KosekiIdentityAges;
static_assert(sizeof(KosekiIdentityAges) == 12, "size");
static_assert(offsetof(KosekiIdentityAges, address_ms) == 0, "offset");
static_assert(offsetof(KosekiIdentityAges, mode_3a_ms) == 4, "offset");
static_assert(offsetof(KosekiIdentityAges, callsign_ms) == 8, "offset");

typedef struct KosekiExtent {
    float length_m; /* Length of the longer side, metres; 0: unknown. */
    float width_m; /* Length of the shorter side, metres; 0: unknown. */
    float orientation_rad; /* Direction of the longer side, radians clockwise from north, in [0, 2 pi). */
    float length_sigma_m; /* Standard deviation of the length, metres; 0: unknown. */
    float width_sigma_m; /* Standard deviation of the width, metres; 0: unknown. */
    float orientation_sigma_rad; /* Standard deviation of the orientation, radians; 0: the orientation is unknown. */
} KosekiExtent;
static_assert(sizeof(KosekiExtent) == 24, "size");
static_assert(offsetof(KosekiExtent, length_m) == 0, "offset");
static_assert(offsetof(KosekiExtent, width_m) == 4, "offset");
static_assert(offsetof(KosekiExtent, orientation_rad) == 8, "offset");
static_assert(offsetof(KosekiExtent, length_sigma_m) == 12, "offset");
static_assert(offsetof(KosekiExtent, width_sigma_m) == 16, "offset");
static_assert(offsetof(KosekiExtent, orientation_sigma_rad) == 20, "offset");

typedef struct KosekiMovement {
    float acceleration_mps2[3]; /* Acceleration east, north, up, metres per second squared. */
    uint8_t horizontal; /* Mode in the horizontal plane: a `HorizontalMovement` code. */
    uint8_t vertical; /* Mode in the vertical: a `VerticalMovement` code. */
    uint8_t longitudinal; /* Mode along the track: a `LongitudinalMovement` code. */
    uint8_t valid; /* Components of the acceleration that are known: see `movement_bits`. */
} KosekiMovement;
static_assert(sizeof(KosekiMovement) == 16, "size");
static_assert(offsetof(KosekiMovement, acceleration_mps2) == 0, "offset");
static_assert(offsetof(KosekiMovement, horizontal) == 12, "offset");
static_assert(offsetof(KosekiMovement, vertical) == 13, "offset");
static_assert(offsetof(KosekiMovement, longitudinal) == 14, "offset");
static_assert(offsetof(KosekiMovement, valid) == 15, "offset");

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
    uint64_t schema; /* Fingerprint of the layout the publisher was built with; others are rejected. */
    uint64_t incarnation; /* Monotonic start time of the publisher, nanoseconds: a restart shows as a new value. */
    uint64_t first_sequence; /* Samples sent by this incarnation before this slice: the sequence number of its first sample. */
    int64_t progress_ns; /* Progress mark: no later sample will have a time of measurement before this (UTC, ns); i64::MIN if unknown. */
    int64_t sent_ns; /* Monotonic time of the send, nanoseconds. */
    uint64_t epoch; /* Start-up number of fusion, rising with each start (see [`Epochs`]); tracks of smaller ones are not kept up. */
    uint32_t flags; /* Bit 0: the source has ended. Bit 1: this epoch of fusion continues the tracks of the previous epoch. Bits */
    uint32_t sensor_uid; /* Identity of the sensor, the same in every deployment; 0: unknown, or no sensor. */
    uint32_t origin; /* Original deployment of the samples, if another; 0: this deployment. */
    int32_t clock_offset_ms; /* Offset of the source's clock against the publisher's UTC, by the times at which its data are received, */
} KosekiBatchHeader;
static_assert(sizeof(KosekiBatchHeader) == 64, "size");
static_assert(offsetof(KosekiBatchHeader, schema) == 0, "offset");
static_assert(offsetof(KosekiBatchHeader, incarnation) == 8, "offset");
static_assert(offsetof(KosekiBatchHeader, first_sequence) == 16, "offset");
static_assert(offsetof(KosekiBatchHeader, progress_ns) == 24, "offset");
static_assert(offsetof(KosekiBatchHeader, sent_ns) == 32, "offset");
static_assert(offsetof(KosekiBatchHeader, epoch) == 40, "offset");
static_assert(offsetof(KosekiBatchHeader, flags) == 48, "offset");
static_assert(offsetof(KosekiBatchHeader, sensor_uid) == 52, "offset");
static_assert(offsetof(KosekiBatchHeader, origin) == 56, "offset");
static_assert(offsetof(KosekiBatchHeader, clock_offset_ms) == 60, "offset");

typedef struct KosekiSensorTrack {
    int64_t time_of_measurement_ns; /* Time of measurement, UTC, nanoseconds since 1970. */
    uint64_t sequence; /* The report's sequence number at its publisher. */
    KosekiStageTimes stages; /* Stages passed so far. */
    uint32_t track_number; /* Number of the sensor track at its source. */
    uint16_t source; /* Source: its number in the configuration (TI-2). */
    uint16_t valid; /* Which fields hold something: see `sensor_track_bits`. */
    KosekiIdentity identity; /* Identity of the target, as far as it is known. */
    double position_m[3]; /* Position east, north, up, metres. */
    double velocity_mps[3]; /* Velocity east, north, up, metres per second. A component with a variance of 0 is unknown. */
    KosekiCovariance covariance; /* Covariance of position and velocity; all 0 where the source gives its `trace_m2` instead. A variance of 0 */
    double measured_m[3]; /* Measured position, before the source's own filter, metres. See the bit `PLATFORM`. */
    double trace_m2; /* Trace of the source's position covariance over east and north, square metres. */
    uint8_t state; /* State of the track at its source: a `TrackState` code. */
    uint8_t method; /* Observation method at the source, as numbered by its format; 0 for a single method. */
    uint8_t alerts; /* Alerts of the target or its source: see `alert_bits`. */
    uint8_t kind; /* Kind of the tracked object: a `TrackKind` code. */
    uint16_t members; /* Expected number of members of a group; 0 for a single target. */
    int16_t level; /* Level that the transponder stated last, in steps of 25 feet at 1013.25 hPa; 0 without the bit `LEVEL`. */
    KosekiTargetType target_type; /* Type of the target. */
    KosekiExtent extent; /* Size of the target, as stated or measured by its source. */
    KosekiMovement movement; /* Modes of movement and acceleration, as the source states them. */
    uint64_t shared_sources; /* Local sources whose sensors have contributed to a system track of another centre, as bits by number; sources */
    uint32_t origin; /* Original deployment of a system track of another centre; else 0. */
    uint32_t level_age_ms; /* Age of `level` at the time of measurement, milliseconds. */
    KosekiIdentityAges identity_ages; /* Ages of the values of `identity` at the time of measurement. */
    float existence; /* Probability that the target exists according to the source, in (0, 1]; 0: not stated. */
    float turn_rate_radps; /* Rate of turn according to the source, clockwise from above, radians per second. */
    float pressure_offset_m; /* Height by pressure, as in `position_m`, minus the height above the ellipsoid that the report states, metres. */
} KosekiSensorTrack;
static_assert(sizeof(KosekiSensorTrack) == 448, "size");
static_assert(offsetof(KosekiSensorTrack, time_of_measurement_ns) == 0, "offset");
static_assert(offsetof(KosekiSensorTrack, sequence) == 8, "offset");
static_assert(offsetof(KosekiSensorTrack, stages) == 16, "offset");
static_assert(offsetof(KosekiSensorTrack, track_number) == 48, "offset");
static_assert(offsetof(KosekiSensorTrack, source) == 52, "offset");
static_assert(offsetof(KosekiSensorTrack, valid) == 54, "offset");
static_assert(offsetof(KosekiSensorTrack, identity) == 56, "offset");
static_assert(offsetof(KosekiSensorTrack, position_m) == 96, "offset");
static_assert(offsetof(KosekiSensorTrack, velocity_mps) == 120, "offset");
static_assert(offsetof(KosekiSensorTrack, covariance) == 144, "offset");
static_assert(offsetof(KosekiSensorTrack, measured_m) == 312, "offset");
static_assert(offsetof(KosekiSensorTrack, trace_m2) == 336, "offset");
static_assert(offsetof(KosekiSensorTrack, state) == 344, "offset");
static_assert(offsetof(KosekiSensorTrack, method) == 345, "offset");
static_assert(offsetof(KosekiSensorTrack, alerts) == 346, "offset");
static_assert(offsetof(KosekiSensorTrack, kind) == 347, "offset");
static_assert(offsetof(KosekiSensorTrack, members) == 348, "offset");
static_assert(offsetof(KosekiSensorTrack, level) == 350, "offset");
static_assert(offsetof(KosekiSensorTrack, target_type) == 352, "offset");
static_assert(offsetof(KosekiSensorTrack, extent) == 368, "offset");
static_assert(offsetof(KosekiSensorTrack, movement) == 392, "offset");
static_assert(offsetof(KosekiSensorTrack, shared_sources) == 408, "offset");
static_assert(offsetof(KosekiSensorTrack, origin) == 416, "offset");
static_assert(offsetof(KosekiSensorTrack, level_age_ms) == 420, "offset");
static_assert(offsetof(KosekiSensorTrack, identity_ages) == 424, "offset");
static_assert(offsetof(KosekiSensorTrack, existence) == 436, "offset");
static_assert(offsetof(KosekiSensorTrack, turn_rate_radps) == 440, "offset");
static_assert(offsetof(KosekiSensorTrack, pressure_offset_m) == 444, "offset");

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
    uint8_t kind; /* Quantities that were measured: a `DetectionKind` code. */
    uint8_t valid; /* Which fields hold something: see `sensor_detection_bits`. */
    uint32_t level_age_ms; /* Age of `level` at the time of measurement, milliseconds. */
    KosekiIdentity identity; /* Identity of the target in the detection, as far as it is known. */
    KosekiIdentityAges identity_ages; /* Ages of the values of `identity` at the time of measurement. */
    int16_t level; /* Level of the transponder, in steps of 25 feet at 1013.25 hPa; 0 without the bit `LEVEL`. */
    uint16_t reserved; /* Reserved, 0. */
    float platform_velocity_mps[3]; /* Velocity of the sensor's platform east, north, up, metres per second. */
    float platform_attitude_rad[3]; /* Heading (clockwise from north), pitch (nose up) and roll (right wing down) of the platform, radians. */
    float platform_sigma_m; /* Standard deviation of each coordinate of `platform_m`, metres. */
    float attitude_sigmas_rad[3]; /* Standard deviations of heading, pitch and roll, radians. */
} KosekiSensorDetection;
static_assert(sizeof(KosekiSensorDetection) == 248, "size");
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
static_assert(offsetof(KosekiSensorDetection, level_age_ms) == 148, "offset");
static_assert(offsetof(KosekiSensorDetection, identity) == 152, "offset");
static_assert(offsetof(KosekiSensorDetection, identity_ages) == 192, "offset");
static_assert(offsetof(KosekiSensorDetection, level) == 204, "offset");
static_assert(offsetof(KosekiSensorDetection, reserved) == 206, "offset");
static_assert(offsetof(KosekiSensorDetection, platform_velocity_mps) == 208, "offset");
static_assert(offsetof(KosekiSensorDetection, platform_attitude_rad) == 220, "offset");
static_assert(offsetof(KosekiSensorDetection, platform_sigma_m) == 232, "offset");
static_assert(offsetof(KosekiSensorDetection, attitude_sigmas_rad) == 236, "offset");

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

typedef struct KosekiSensorArrival {
    int64_t time_of_measurement_ns; /* Time of the transmission, UTC, nanoseconds since 1970. */
    uint64_t sequence; /* The arrival's sequence number at its publisher. */
    KosekiStageTimes stages; /* Stages passed so far. */
    double time_s; /* Arrival by the receiver's clock, seconds since midnight (UTC), or a difference of two arrivals, seconds. */
    double sigma_s; /* Standard deviation of that, seconds. */
    double receiver_m[3]; /* Where the receiver is, metres east, north and up. */
    double receiver_2_m[3]; /* Where the second receiver of a difference is. */
    double reference_m[3]; /* Where the reference emitter is. */
    uint8_t receiver[16]; /* Name of the receiver in ASCII, unused bytes 0. */
    uint8_t receiver_2[16]; /* Name of the second receiver of a difference. */
    uint32_t emitter_id; /* Number of the transmitter at its source. */
    uint16_t source; /* Source: its number in the configuration (TI-2). */
    uint16_t valid; /* Which fields hold something: see `sensor_arrival_bits`. */
} KosekiSensorArrival;
static_assert(sizeof(KosekiSensorArrival) == 176, "size");
static_assert(offsetof(KosekiSensorArrival, time_of_measurement_ns) == 0, "offset");
static_assert(offsetof(KosekiSensorArrival, sequence) == 8, "offset");
static_assert(offsetof(KosekiSensorArrival, stages) == 16, "offset");
static_assert(offsetof(KosekiSensorArrival, time_s) == 48, "offset");
static_assert(offsetof(KosekiSensorArrival, sigma_s) == 56, "offset");
static_assert(offsetof(KosekiSensorArrival, receiver_m) == 64, "offset");
static_assert(offsetof(KosekiSensorArrival, receiver_2_m) == 88, "offset");
static_assert(offsetof(KosekiSensorArrival, reference_m) == 112, "offset");
static_assert(offsetof(KosekiSensorArrival, receiver) == 136, "offset");
static_assert(offsetof(KosekiSensorArrival, receiver_2) == 152, "offset");
static_assert(offsetof(KosekiSensorArrival, emitter_id) == 168, "offset");
static_assert(offsetof(KosekiSensorArrival, source) == 172, "offset");
static_assert(offsetof(KosekiSensorArrival, valid) == 174, "offset");

typedef struct KosekiSensorFix {
    int64_t time_of_measurement_ns; /* Time of the fix, UTC, nanoseconds since 1970. */
    uint64_t sequence; /* The fix's sequence number at its publisher. */
    KosekiStageTimes stages; /* Stages passed so far. */
    double position_m[3]; /* Position, metres east, north and up. */
    double covariance_m2[3]; /* Covariance in the plane: east, east with north, north, m². */
    uint32_t emitter_id; /* Number of the transmitter at its source. */
    uint16_t source; /* Source: its number in the configuration (TI-2). */
    uint16_t reserved; /* Reserved, 0. */
} KosekiSensorFix;
static_assert(sizeof(KosekiSensorFix) == 104, "size");
static_assert(offsetof(KosekiSensorFix, time_of_measurement_ns) == 0, "offset");
static_assert(offsetof(KosekiSensorFix, sequence) == 8, "offset");
static_assert(offsetof(KosekiSensorFix, stages) == 16, "offset");
static_assert(offsetof(KosekiSensorFix, position_m) == 48, "offset");
static_assert(offsetof(KosekiSensorFix, covariance_m2) == 72, "offset");
static_assert(offsetof(KosekiSensorFix, emitter_id) == 96, "offset");
static_assert(offsetof(KosekiSensorFix, source) == 100, "offset");
static_assert(offsetof(KosekiSensorFix, reserved) == 102, "offset");

typedef struct KosekiTargetStatement {
    int64_t time_ns; /* Time of the target's latest transmission, UTC, nanoseconds since 1970. */
    uint64_t sequence; /* The sample's sequence number at its publisher. */
    KosekiStageTimes stages; /* Stages passed so far. */
    double place_deg[2]; /* Latitude and longitude (WGS-84), degrees: of the operator of an unmanned aircraft, or of a station itself. */
    float length_m; /* Length, metres. */
    float width_m; /* Width, metres. */
    float selected_altitude_m; /* Altitude selected in the autopilot, metres of the standard atmosphere. */
    uint32_t track_number; /* Number of the target's track at its source; of a station, the number of its transponder. */
    uint16_t source; /* Source: its number in the configuration (TI-2). */
    uint8_t category; /* Category: a `TargetCategory` code. */
    uint8_t navigation; /* Navigation status: a `NavigationStatus` code. */
    uint8_t emergency; /* Emergency: an `Emergency` code. */
    uint8_t valid; /* Fields that hold something, and flags: see `target_statement_bits`. */
    uint8_t aid; /* Kind of the aid to navigation: an `AidKind` code. */
    uint8_t name[20]; /* Name of a station in ASCII, padded with blanks; blank: none is known. */
    uint8_t reserved[5]; /* Reserved, 0. */
} KosekiTargetStatement;
static_assert(sizeof(KosekiTargetStatement) == 112, "size");
static_assert(offsetof(KosekiTargetStatement, time_ns) == 0, "offset");
static_assert(offsetof(KosekiTargetStatement, sequence) == 8, "offset");
static_assert(offsetof(KosekiTargetStatement, stages) == 16, "offset");
static_assert(offsetof(KosekiTargetStatement, place_deg) == 48, "offset");
static_assert(offsetof(KosekiTargetStatement, length_m) == 64, "offset");
static_assert(offsetof(KosekiTargetStatement, width_m) == 68, "offset");
static_assert(offsetof(KosekiTargetStatement, selected_altitude_m) == 72, "offset");
static_assert(offsetof(KosekiTargetStatement, track_number) == 76, "offset");
static_assert(offsetof(KosekiTargetStatement, source) == 80, "offset");
static_assert(offsetof(KosekiTargetStatement, category) == 82, "offset");
static_assert(offsetof(KosekiTargetStatement, navigation) == 83, "offset");
static_assert(offsetof(KosekiTargetStatement, emergency) == 84, "offset");
static_assert(offsetof(KosekiTargetStatement, valid) == 85, "offset");
static_assert(offsetof(KosekiTargetStatement, aid) == 86, "offset");
static_assert(offsetof(KosekiTargetStatement, name) == 87, "offset");
static_assert(offsetof(KosekiTargetStatement, reserved) == 107, "offset");

typedef struct KosekiSensorSpectrum {
    int64_t time_of_measurement_ns; /* Time of measurement, UTC, nanoseconds since 1970. */
    uint64_t sequence; /* The spectrum's sequence number at its publisher. */
    KosekiStageTimes stages; /* Stages passed so far. */
    double forward_rad; /* Direction of the forward axis, radians clockwise from north; from the bow if the snapshots state no heading. */
    double frequency_hz; /* Frequency of the measurement, hertz. */
    double noise_variance; /* Variance of the noise at one antenna, in squares of the samples' unit. */
    uint32_t snapshots; /* Number of snapshots of the measurement. */
    uint32_t transmitters; /* Number of transmitters, as given or estimated. */
    uint16_t source; /* Source: its number in the configuration (TI-2). */
    uint16_t reserved[7]; /* Reserved, 0. */
    float spectrum_db[360]; /* From k to k + 1 degrees clockwise from the forward axis, decibels: 0 where no wave comes from. */
} KosekiSensorSpectrum;
static_assert(sizeof(KosekiSensorSpectrum) == 1536, "size");
static_assert(offsetof(KosekiSensorSpectrum, time_of_measurement_ns) == 0, "offset");
static_assert(offsetof(KosekiSensorSpectrum, sequence) == 8, "offset");
static_assert(offsetof(KosekiSensorSpectrum, stages) == 16, "offset");
static_assert(offsetof(KosekiSensorSpectrum, forward_rad) == 48, "offset");
static_assert(offsetof(KosekiSensorSpectrum, frequency_hz) == 56, "offset");
static_assert(offsetof(KosekiSensorSpectrum, noise_variance) == 64, "offset");
static_assert(offsetof(KosekiSensorSpectrum, snapshots) == 72, "offset");
static_assert(offsetof(KosekiSensorSpectrum, transmitters) == 76, "offset");
static_assert(offsetof(KosekiSensorSpectrum, source) == 80, "offset");
static_assert(offsetof(KosekiSensorSpectrum, reserved) == 82, "offset");
static_assert(offsetof(KosekiSensorSpectrum, spectrum_db) == 96, "offset");

typedef struct KosekiPlatformState {
    int64_t time_ns; /* Time at which the platform was there, UTC, nanoseconds since 1970. */
    uint64_t sequence; /* The state's sequence number at its publisher. */
    KosekiStageTimes stages; /* Stages passed so far. */
    double position_m[3]; /* Position east, north, up in the system frame, metres; 0 with the bit `NO_POSITION`. */
    double velocity_mps[3]; /* Velocity east, north, up, metres per second. */
    double heading_rad; /* Where its nose points, radians clockwise from the system frame's north. */
    double pitch_rad; /* Nose above the horizon, radians. */
    double roll_rad; /* Right wing below the horizon, radians. */
    double position_sigma_m; /* Standard deviation of each coordinate of the position, metres. */
    double heading_sigma_rad; /* Standard deviation of the heading, radians. */
    double velocity_sigma_mps; /* Standard deviation of each component of the velocity, metres per second. */
    double pitch_sigma_rad; /* Standard deviation of the pitch, radians. */
    double roll_sigma_rad; /* Standard deviation of the roll, radians. */
    uint16_t source; /* Source of the sensor on the platform: its number in the configuration (TI-2). */
    uint16_t valid; /* Which fields hold something: see `platform_state_bits`. */
    uint32_t reserved; /* Reserved, 0. */
} KosekiPlatformState;
static_assert(sizeof(KosekiPlatformState) == 168, "size");
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
static_assert(offsetof(KosekiPlatformState, velocity_sigma_mps) == 136, "offset");
static_assert(offsetof(KosekiPlatformState, pitch_sigma_rad) == 144, "offset");
static_assert(offsetof(KosekiPlatformState, roll_sigma_rad) == 152, "offset");
static_assert(offsetof(KosekiPlatformState, source) == 160, "offset");
static_assert(offsetof(KosekiPlatformState, valid) == 162, "offset");
static_assert(offsetof(KosekiPlatformState, reserved) == 164, "offset");

typedef struct KosekiWideArea {
    int64_t time_of_observation_ns; /* Time of observation, UTC, nanoseconds since 1970. */
    int64_t arrival_ns; /* Time of arrival, UTC, nanoseconds since 1970; it is used from then on. */
    uint64_t sequence; /* The report's sequence number at its publisher. */
    KosekiStageTimes stages; /* Stages passed so far. */
    double position_m[3]; /* Middle of the targets at the time of observation, metres east, north and up. */
    double velocity_mps[3]; /* Mean velocity of the targets east, north, up, metres per second. */
    double origin_m[2]; /* Where they came from, metres east and north. */
    uint32_t targets; /* Number of targets, possibly 0. */
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
    int64_t made_ns; /* Time of the scan after which it was made, UTC, nanoseconds since 1970. */
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
static_assert(sizeof(KosekiCue) == 136, "size");
static_assert(offsetof(KosekiCue, time_ns) == 0, "offset");
static_assert(offsetof(KosekiCue, made_ns) == 8, "offset");
static_assert(offsetof(KosekiCue, sequence) == 16, "offset");
static_assert(offsetof(KosekiCue, stages) == 24, "offset");
static_assert(offsetof(KosekiCue, position_m) == 56, "offset");
static_assert(offsetof(KosekiCue, velocity_mps) == 80, "offset");
static_assert(offsetof(KosekiCue, half_axes_m) == 104, "offset");
static_assert(offsetof(KosekiCue, orientation_rad) == 120, "offset");
static_assert(offsetof(KosekiCue, track_number) == 128, "offset");
static_assert(offsetof(KosekiCue, source) == 132, "offset");
static_assert(offsetof(KosekiCue, reserved) == 134, "offset");

typedef struct KosekiContribution {
    int64_t time_of_measurement_ns; /* Time of measurement of the source's latest report, UTC, nanoseconds. */
    double weight; /* Coefficient eta in [0, 1]; the weights of one system track sum to 1. */
    double accuracy; /* Accuracy value lambda (TI-9), smaller is better; NaN where the rule has none. */
    uint32_t track_number; /* Number of the sensor track at its source. */
    uint32_t sensor_uid; /* Identity of the sensor, the same in every deployment; 0: unknown. */
    uint32_t origin; /* Original deployment of the sensor track, if another; 0: this deployment. */
    uint16_t source; /* Source number. */
    uint16_t flags; /* Flags: see `contribution_bits`. */
    float axis_weights[3]; /* Coefficient eta by axis, east, north, up; their mean is `weight`. */
    float axis_accuracies[3]; /* Accuracy value lambda by axis, east, north, up; 0 where the rule has none for the axis. */
} KosekiContribution;
static_assert(sizeof(KosekiContribution) == 64, "size");
static_assert(offsetof(KosekiContribution, time_of_measurement_ns) == 0, "offset");
static_assert(offsetof(KosekiContribution, weight) == 8, "offset");
static_assert(offsetof(KosekiContribution, accuracy) == 16, "offset");
static_assert(offsetof(KosekiContribution, track_number) == 24, "offset");
static_assert(offsetof(KosekiContribution, sensor_uid) == 28, "offset");
static_assert(offsetof(KosekiContribution, origin) == 32, "offset");
static_assert(offsetof(KosekiContribution, source) == 36, "offset");
static_assert(offsetof(KosekiContribution, flags) == 38, "offset");
static_assert(offsetof(KosekiContribution, axis_weights) == 40, "offset");
static_assert(offsetof(KosekiContribution, axis_accuracies) == 52, "offset");

typedef struct KosekiSystemTrack {
    int64_t reference_time_ns; /* Reference time of the state, UTC, nanoseconds since 1970. */
    int64_t time_of_measurement_ns; /* Time of measurement of the report that caused this state, else the reference time; UTC, nanoseconds. */
    uint64_t sequence; /* The state's sequence number at its publisher. */
    uint64_t epoch; /* Start-up number of the fusion that made it, rising with each start; 0: unknown. */
    KosekiStageTimes stages; /* Stages of the report that caused this state; all but `fused_ns` are 0 if none did. */
    uint32_t track_number; /* System-track number: not assigned to another target within a day, across all restarts. */
    uint32_t origin; /* Deployment of the track: `origin` of its configuration; 0: not stated. */
    uint32_t owner_track_number; /* Number of the track at the deployment that owns the target, where another does; else 0. */
    uint32_t merged_into; /* Number of the system track into which this track was merged, if merged; else 0. */
    uint16_t trigger_source; /* Source of the report that caused this state; 65535 if none did (coasting, ending). */
    uint16_t selected_source; /* Source with the largest weight; 65535 if none contributes. */
    uint16_t source_count; /* How many sources contribute. */
    uint16_t contribution_count; /* How many of `contributions` hold something. */
    uint8_t state; /* State of the track: a `TrackState` code. */
    uint8_t height_valid; /* 1 if a source observes height; otherwise z has no meaning. */
    uint8_t rule; /* Fusion rule: a `FusionRule` code; 0: unknown. */
    uint8_t alerts; /* Alerts of the contributing sources: see `alert_bits`. */
    uint8_t on_ground; /* 1 if a contributing source reports the target on the ground. */
    uint8_t kind; /* Kind of the tracked object: a `TrackKind` code. */
    uint16_t members; /* Expected number of members of a group; 0 for a single target. */
    KosekiIdentity identity; /* Identity of the target, as far as known to its sources. */
    KosekiTargetType target_type; /* Type of the target. */
    double position_m[3]; /* Position east, north, up, metres. */
    double velocity_mps[3]; /* Velocity east, north, up, metres per second. */
    KosekiMovement movement; /* Modes of movement and acceleration. */
    KosekiExtent extent; /* Size of the target. */
    KosekiCovariance covariance; /* Covariance of position and velocity. */
    KosekiContribution contributions[16]; /* Contributing sources in the order of their numbers; the first `contribution_count` are used. */
    float nis; /* Normalised innovation squared (NIS) of the report that caused this state, in the plane; 0 if there was none. */
    int16_t level; /* Newest level of the target's transponder, in steps of 25 feet at 1013.25 hPa; 0 if there is none. */
    uint8_t level_valid; /* 1 if `level` is known, and no older than two periods of the source that has it. */
    uint8_t velocity_valid; /* 1 if the horizontal velocity is known: a source states it, or positions have shown it; else `velocity_mps` */
    uint32_t level_age_ms; /* Age of `level` at the reference time, milliseconds. */
    KosekiIdentityAges identity_ages; /* Ages of the values of `identity` at the reference time. */
    float existence; /* Probability that the target exists, in (0, 1]; 0: not estimated. */
    float altitude_m; /* Altitude above mean sea level by `qnh_hpa`, metres, of a target below the transition level. */
    float qnh_hpa; /* Pressure at mean sea level in the target's region, hPa; 0: no altitude, the flight level counts. */
    float pressure_offset_m; /* Height by pressure minus height above the ellipsoid in the region and layer of the target, metres, as */
    float pressure_offset_sigma_m; /* Standard deviation of `pressure_offset_m` for one aircraft, metres; 0: unknown. */
    float climb_rate_mps; /* Rate of climb by the vertical filter, metres per second; 0 if it is unknown. */
    float climb_rate_variance; /* Variance of `climb_rate_mps`, square metres per square second; 0: unknown. */
    float turn_rate_radps; /* Rate of turn, clockwise from above, radians per second. */
    float turn_rate_sigma_radps; /* Standard deviation of `turn_rate_radps`, radians per second; 0: unknown. */
    float mode_probabilities[8]; /* Probabilities of the motion models in the order of `MotionMode`; all 0: not estimated. */
    uint32_t updates; /* Number of reports in the state since the start of the track. */
    uint32_t extrapolations; /* Number of published extrapolations since the last report. */
    uint32_t held_us; /* Wait of the report that caused this state for the end of its scan, microseconds; 0: the report did not wait. */
    float steady_velocity_covariance[3]; /* Covariance of `velocity_mps` in straight flight: xx, xy, yy of the axes east and north, m²/s²; 0: unknown. */
    float steady_climb_variance; /* Variance of the climb rate in `velocity_mps` in level flight or in a constant climb, m²/s²; 0: unknown. */
} KosekiSystemTrack;
static_assert(sizeof(KosekiSystemTrack) == 1552, "size");
static_assert(offsetof(KosekiSystemTrack, reference_time_ns) == 0, "offset");
static_assert(offsetof(KosekiSystemTrack, time_of_measurement_ns) == 8, "offset");
static_assert(offsetof(KosekiSystemTrack, sequence) == 16, "offset");
static_assert(offsetof(KosekiSystemTrack, epoch) == 24, "offset");
static_assert(offsetof(KosekiSystemTrack, stages) == 32, "offset");
static_assert(offsetof(KosekiSystemTrack, track_number) == 64, "offset");
static_assert(offsetof(KosekiSystemTrack, origin) == 68, "offset");
static_assert(offsetof(KosekiSystemTrack, owner_track_number) == 72, "offset");
static_assert(offsetof(KosekiSystemTrack, merged_into) == 76, "offset");
static_assert(offsetof(KosekiSystemTrack, trigger_source) == 80, "offset");
static_assert(offsetof(KosekiSystemTrack, selected_source) == 82, "offset");
static_assert(offsetof(KosekiSystemTrack, source_count) == 84, "offset");
static_assert(offsetof(KosekiSystemTrack, contribution_count) == 86, "offset");
static_assert(offsetof(KosekiSystemTrack, state) == 88, "offset");
static_assert(offsetof(KosekiSystemTrack, height_valid) == 89, "offset");
static_assert(offsetof(KosekiSystemTrack, rule) == 90, "offset");
static_assert(offsetof(KosekiSystemTrack, alerts) == 91, "offset");
static_assert(offsetof(KosekiSystemTrack, on_ground) == 92, "offset");
static_assert(offsetof(KosekiSystemTrack, kind) == 93, "offset");
static_assert(offsetof(KosekiSystemTrack, members) == 94, "offset");
static_assert(offsetof(KosekiSystemTrack, identity) == 96, "offset");
static_assert(offsetof(KosekiSystemTrack, target_type) == 136, "offset");
static_assert(offsetof(KosekiSystemTrack, position_m) == 152, "offset");
static_assert(offsetof(KosekiSystemTrack, velocity_mps) == 176, "offset");
static_assert(offsetof(KosekiSystemTrack, movement) == 200, "offset");
static_assert(offsetof(KosekiSystemTrack, extent) == 216, "offset");
static_assert(offsetof(KosekiSystemTrack, covariance) == 240, "offset");
static_assert(offsetof(KosekiSystemTrack, contributions) == 408, "offset");
static_assert(offsetof(KosekiSystemTrack, nis) == 1432, "offset");
static_assert(offsetof(KosekiSystemTrack, level) == 1436, "offset");
static_assert(offsetof(KosekiSystemTrack, level_valid) == 1438, "offset");
static_assert(offsetof(KosekiSystemTrack, velocity_valid) == 1439, "offset");
static_assert(offsetof(KosekiSystemTrack, level_age_ms) == 1440, "offset");
static_assert(offsetof(KosekiSystemTrack, identity_ages) == 1444, "offset");
static_assert(offsetof(KosekiSystemTrack, existence) == 1456, "offset");
static_assert(offsetof(KosekiSystemTrack, altitude_m) == 1460, "offset");
static_assert(offsetof(KosekiSystemTrack, qnh_hpa) == 1464, "offset");
static_assert(offsetof(KosekiSystemTrack, pressure_offset_m) == 1468, "offset");
static_assert(offsetof(KosekiSystemTrack, pressure_offset_sigma_m) == 1472, "offset");
static_assert(offsetof(KosekiSystemTrack, climb_rate_mps) == 1476, "offset");
static_assert(offsetof(KosekiSystemTrack, climb_rate_variance) == 1480, "offset");
static_assert(offsetof(KosekiSystemTrack, turn_rate_radps) == 1484, "offset");
static_assert(offsetof(KosekiSystemTrack, turn_rate_sigma_radps) == 1488, "offset");
static_assert(offsetof(KosekiSystemTrack, mode_probabilities) == 1492, "offset");
static_assert(offsetof(KosekiSystemTrack, updates) == 1524, "offset");
static_assert(offsetof(KosekiSystemTrack, extrapolations) == 1528, "offset");
static_assert(offsetof(KosekiSystemTrack, held_us) == 1532, "offset");
static_assert(offsetof(KosekiSystemTrack, steady_velocity_covariance) == 1536, "offset");
static_assert(offsetof(KosekiSystemTrack, steady_climb_variance) == 1548, "offset");

typedef struct KosekiAlarm {
    int64_t time_ns; /* Time of this statement, UTC, nanoseconds since 1970. */
    int64_t raised_ns; /* When the alarm was raised, UTC, nanoseconds since 1970. */
    uint64_t sequence; /* The sample's sequence number at its publisher. */
    uint32_t times; /* Times that the alarm has been raised since its publisher started. */
    uint16_t code; /* Code of the alarm; docs/alarms.md lists them. */
    uint16_t source; /* Source concerned: its number in the configuration; 65535 for none. */
    uint16_t partner; /* Second source concerned; 65535 for none. */
    uint8_t severity; /* An `AlarmSeverity` code. */
    uint8_t event; /* An `AlarmEvent` code. */
    uint32_t reserved; /* Reserved, 0. */
    uint8_t process[32]; /* Name of the process concerned, UTF-8, padded with zeros; empty for none. */
    uint8_t text[312]; /* One sentence, UTF-8, padded with zeros. */
} KosekiAlarm;
static_assert(sizeof(KosekiAlarm) == 384, "size");
static_assert(offsetof(KosekiAlarm, time_ns) == 0, "offset");
static_assert(offsetof(KosekiAlarm, raised_ns) == 8, "offset");
static_assert(offsetof(KosekiAlarm, sequence) == 16, "offset");
static_assert(offsetof(KosekiAlarm, times) == 24, "offset");
static_assert(offsetof(KosekiAlarm, code) == 28, "offset");
static_assert(offsetof(KosekiAlarm, source) == 30, "offset");
static_assert(offsetof(KosekiAlarm, partner) == 32, "offset");
static_assert(offsetof(KosekiAlarm, severity) == 34, "offset");
static_assert(offsetof(KosekiAlarm, event) == 35, "offset");
static_assert(offsetof(KosekiAlarm, reserved) == 36, "offset");
static_assert(offsetof(KosekiAlarm, process) == 40, "offset");
static_assert(offsetof(KosekiAlarm, text) == 72, "offset");

typedef struct KosekiAlert {
    int64_t time_ns; /* Reference time of the state from which this statement follows, UTC, nanoseconds since 1970. */
    int64_t raised_ns; /* Reference time of the state that raised the alert, UTC, nanoseconds since 1970. */
    uint64_t sequence; /* The sample's sequence number at its publisher. */
    uint64_t number; /* Number of the alert: 1, 2, … in the order of raising, across restarts of the process. */
    uint32_t tracks[2]; /* System-track numbers of the target, and of the other target; 0 for none. */
    float probability; /* Probability of the event in [0, 1]; 1 once it has happened. */
    float time_to_s; /* Time until the event, seconds; 0 once it has happened. */
    float distance_m; /* Present horizontal distance from the other target, or from the area's border, metres. */
    float least_distance_m; /* Least horizontal distance ahead, metres. */
    float vertical_m; /* Present difference of height from the other target, metres. */
    float least_vertical_m; /* Difference of height at the least distance, metres. */
    float value; /* What is compared with `limit`: metres per second, metres or seconds by the kind. */
    float limit; /* The limit that `value` has passed. */
    uint16_t valid; /* Values that are known: see `alert_value_bits`. */
    uint8_t kind; /* An `AlertKind` code. */
    uint8_t event; /* An `AlarmEvent` code. */
    uint8_t severity; /* An `AlarmSeverity` code. */
    uint8_t reserved[3]; /* Reserved, 0. */
    uint8_t rule[32]; /* Name of the rule, UTF-8, padded with zeros. */
    uint8_t area[32]; /* Name of the area, UTF-8, padded with zeros; empty for none. */
    uint8_t text[160]; /* One sentence, UTF-8, padded with zeros. */
} KosekiAlert;
static_assert(sizeof(KosekiAlert) == 304, "size");
static_assert(offsetof(KosekiAlert, time_ns) == 0, "offset");
static_assert(offsetof(KosekiAlert, raised_ns) == 8, "offset");
static_assert(offsetof(KosekiAlert, sequence) == 16, "offset");
static_assert(offsetof(KosekiAlert, number) == 24, "offset");
static_assert(offsetof(KosekiAlert, tracks) == 32, "offset");
static_assert(offsetof(KosekiAlert, probability) == 40, "offset");
static_assert(offsetof(KosekiAlert, time_to_s) == 44, "offset");
static_assert(offsetof(KosekiAlert, distance_m) == 48, "offset");
static_assert(offsetof(KosekiAlert, least_distance_m) == 52, "offset");
static_assert(offsetof(KosekiAlert, vertical_m) == 56, "offset");
static_assert(offsetof(KosekiAlert, least_vertical_m) == 60, "offset");
static_assert(offsetof(KosekiAlert, value) == 64, "offset");
static_assert(offsetof(KosekiAlert, limit) == 68, "offset");
static_assert(offsetof(KosekiAlert, valid) == 72, "offset");
static_assert(offsetof(KosekiAlert, kind) == 74, "offset");
static_assert(offsetof(KosekiAlert, event) == 75, "offset");
static_assert(offsetof(KosekiAlert, severity) == 76, "offset");
static_assert(offsetof(KosekiAlert, reserved) == 77, "offset");
static_assert(offsetof(KosekiAlert, rule) == 80, "offset");
static_assert(offsetof(KosekiAlert, area) == 112, "offset");
static_assert(offsetof(KosekiAlert, text) == 144, "offset");

typedef struct KosekiDecision {
    int64_t time_ns; /* Time of the data, UTC, nanoseconds since 1970. */
    uint64_t sequence; /* The sample's sequence number at its publisher. */
    uint64_t epoch; /* Start of the process that decided, monotonic, nanoseconds: system tracks of the same `epoch` are meant. */
    double value; /* Value that was compared; NaN if nothing was. */
    double limit; /* Limit that the value was compared with; NaN if there was none. */
    uint32_t system_track; /* System track of the decision; 0 if none. */
    uint32_t other_system_track; /* The other system track, where there is one; else 0. */
    uint32_t sensor_track; /* Sensor track of the decision, at its source; 0 if none. */
    uint16_t source; /* Source of the decision: its number in the configuration; 65535 for none. */
    uint16_t other_source; /* The other source, if any (at a hand-over the previous source); 65535 for none. */
    uint8_t kind; /* A `DecisionKind` code. */
    uint8_t reserved[7]; /* Reserved, 0. */
} KosekiDecision;
static_assert(sizeof(KosekiDecision) == 64, "size");
static_assert(offsetof(KosekiDecision, time_ns) == 0, "offset");
static_assert(offsetof(KosekiDecision, sequence) == 8, "offset");
static_assert(offsetof(KosekiDecision, epoch) == 16, "offset");
static_assert(offsetof(KosekiDecision, value) == 24, "offset");
static_assert(offsetof(KosekiDecision, limit) == 32, "offset");
static_assert(offsetof(KosekiDecision, system_track) == 40, "offset");
static_assert(offsetof(KosekiDecision, other_system_track) == 44, "offset");
static_assert(offsetof(KosekiDecision, sensor_track) == 48, "offset");
static_assert(offsetof(KosekiDecision, source) == 52, "offset");
static_assert(offsetof(KosekiDecision, other_source) == 54, "offset");
static_assert(offsetof(KosekiDecision, kind) == 56, "offset");
static_assert(offsetof(KosekiDecision, reserved) == 57, "offset");

typedef struct KosekiRegistration {
    double comparisons; /* Comparisons with other sources that the estimates rest on, after forgetting; 0: nothing is known. */
    double offset_m[3]; /* Estimated offset of the reports from the true positions (east, north, up), metres. */
    double offset_sigma_m[3]; /* Standard deviations of the offset, metres. */
    double time_offset_s; /* Estimated time offset, seconds; positive if the reports show where the target was earlier. */
    double time_offset_sigma_s; /* Standard deviation of the time offset, seconds. */
    double range_bias_m; /* Estimated range bias, metres. */
    double range_bias_sigma_m; /* Standard deviation of the range bias, metres. */
    double azimuth_bias_rad; /* Estimated azimuth bias, clockwise, radians. */
    double azimuth_bias_sigma_rad; /* Standard deviation of the azimuth bias, radians. */
    double covariance_inflation; /* Factor of covariance scaling for a source that overstates its accuracy; otherwise 1. */
    uint32_t removed; /* Which of the errors are being removed from the source's reports: `registration_bits`. */
    uint32_t gross; /* Gross bias, 0 for none: its kind in the lowest byte, whether it is certain (1), removed (2) and an error */
    double clock_offset_s; /* Offset of the source's clock against times of receipt, seconds; 0 with a standard deviation of 0: unknown. */
    double clock_offset_sigma_s; /* Standard deviation of the clock offset, seconds; 0: unknown. */
    double gross_value[2]; /* Amount of the gross error, in the unit of its kind. */
    float long_sigma_m; /* Standard deviation of the measurements of a smoothed source along the long axis of the error ellipse, */
    float short_sigma_m; /* The same along the short axis, metres. */
    float height_sigma_m; /* The same of the height, metres; 0: not learned. */
    float shape_ratio; /* Standard deviation across the line of sight over that along it, relative to the stated covariances; 0: as */
    float target_share; /* Share of the source's new tracks that turned out to be targets, in (0, 1]; 0: not learned. */
    float lateness_s; /* Delay of the reports, exceeded by one report in ten, seconds. */
    float detection_probability; /* Probability that a scan detects a target that the source tracks, in (0, 1]; 0: not learned. */
    uint32_t error_model; /* Model of the source's error with the best evidence: an `ErrorModel` code. */
    uint16_t dependent_sources[4]; /* Sources with errors that depend on the errors of this source, if `dependence` is not 0. */
    float dependence[4]; /* Correlation of the errors of this source and of `dependent_sources`, in (0, 1]; 0: none. */
    float stamp_step_s; /* Step of which all time stamps of the source are multiples, if it enters the states, seconds; 0: the stamps */
    float stamp_sigma_s; /* Standard deviation of the time offset that the step implies, seconds. */
} KosekiRegistration;
static_assert(sizeof(KosekiRegistration) == 216, "size");
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
static_assert(offsetof(KosekiRegistration, gross) == 116, "offset");
static_assert(offsetof(KosekiRegistration, clock_offset_s) == 120, "offset");
static_assert(offsetof(KosekiRegistration, clock_offset_sigma_s) == 128, "offset");
static_assert(offsetof(KosekiRegistration, gross_value) == 136, "offset");
static_assert(offsetof(KosekiRegistration, long_sigma_m) == 152, "offset");
static_assert(offsetof(KosekiRegistration, short_sigma_m) == 156, "offset");
static_assert(offsetof(KosekiRegistration, height_sigma_m) == 160, "offset");
static_assert(offsetof(KosekiRegistration, shape_ratio) == 164, "offset");
static_assert(offsetof(KosekiRegistration, target_share) == 168, "offset");
static_assert(offsetof(KosekiRegistration, lateness_s) == 172, "offset");
static_assert(offsetof(KosekiRegistration, detection_probability) == 176, "offset");
static_assert(offsetof(KosekiRegistration, error_model) == 180, "offset");
static_assert(offsetof(KosekiRegistration, dependent_sources) == 184, "offset");
static_assert(offsetof(KosekiRegistration, dependence) == 192, "offset");
static_assert(offsetof(KosekiRegistration, stamp_step_s) == 208, "offset");
static_assert(offsetof(KosekiRegistration, stamp_sigma_s) == 212, "offset");

typedef struct KosekiCounters {
    uint64_t values[160]; /* Counts since the process started, indexed by the codes of `Counter`; a few are levels. */
} KosekiCounters;
static_assert(sizeof(KosekiCounters) == 1280, "size");
static_assert(offsetof(KosekiCounters, values) == 0, "offset");

typedef struct KosekiHealth {
    int64_t said_ns; /* Time of this message, monotonic, nanoseconds. */
    uint64_t incarnation; /* Monotonic start time of the process, nanoseconds. */
    int64_t progress_ns; /* How far the process has got in the time of its data, UTC, nanoseconds; i64::MIN if unknown. */
    uint32_t process_id; /* Operating system's process number. */
    uint16_t source; /* Source of the counters; 65535 for the process as a whole. */
    uint8_t kind; /* Kind of the process: a `ProcessKind` code. */
    uint8_t life; /* A `LifeState` code. */
    uint32_t restarts; /* Restarts of the process so far, as its launcher counts them. */
    uint8_t misfit[4]; /* Input outside an adapter's configuration. Of the process: SAC and SIC of the unknown sender with the most */
    uint8_t name[32]; /* Name of the process, UTF-8, padded with zeros. */
    uint8_t note[56]; /* Fault in a few words, empty if there is none; of an adapter's source its name. UTF-8, padded with zeros. */
    uint8_t refusal[256]; /* Input that was refused last, one text for each reason, the latest first: time of day (UTC), line or item, */
    KosekiCounters counters; /* Values of the counters. */
    KosekiRegistration registration; /* Biases of the source, if estimated by fusion. */
} KosekiHealth;
static_assert(sizeof(KosekiHealth) == 1880, "size");
static_assert(offsetof(KosekiHealth, said_ns) == 0, "offset");
static_assert(offsetof(KosekiHealth, incarnation) == 8, "offset");
static_assert(offsetof(KosekiHealth, progress_ns) == 16, "offset");
static_assert(offsetof(KosekiHealth, process_id) == 24, "offset");
static_assert(offsetof(KosekiHealth, source) == 28, "offset");
static_assert(offsetof(KosekiHealth, kind) == 30, "offset");
static_assert(offsetof(KosekiHealth, life) == 31, "offset");
static_assert(offsetof(KosekiHealth, restarts) == 32, "offset");
static_assert(offsetof(KosekiHealth, misfit) == 36, "offset");
static_assert(offsetof(KosekiHealth, name) == 40, "offset");
static_assert(offsetof(KosekiHealth, note) == 72, "offset");
static_assert(offsetof(KosekiHealth, refusal) == 128, "offset");
static_assert(offsetof(KosekiHealth, counters) == 384, "offset");
static_assert(offsetof(KosekiHealth, registration) == 1664, "offset");

typedef struct KosekiProgress {
    uint64_t consumer_incarnation; /* Monotonic start time of the consumer, nanoseconds: a restart shows as a new value. */
    uint64_t publisher_incarnation; /* Monotonic start time of the publisher whose samples are counted. */
    uint64_t done_sequence; /* Samples of that source worked off: all with a sequence number below this. */
    uint64_t done_batches; /* Slices of that publisher taken since the consumer joined. */
    int64_t progress_ns; /* How far the consumer has got in the time of the data, UTC, nanoseconds; i64::MIN if unknown. */
    uint16_t number; /* Number of the source, or of the wide-area sensor; 0 for the system tracks. */
    uint8_t stream; /* Kind of topic: a `Stream` code. */
    uint8_t consumer; /* Kind of the consumer: a `ProcessKind` code. */
    uint32_t reserved; /* Reserved, 0. */
    int64_t said_ns; /* Monotonic time of this statement, nanoseconds. */
} KosekiProgress;
static_assert(sizeof(KosekiProgress) == 56, "size");
static_assert(offsetof(KosekiProgress, consumer_incarnation) == 0, "offset");
static_assert(offsetof(KosekiProgress, publisher_incarnation) == 8, "offset");
static_assert(offsetof(KosekiProgress, done_sequence) == 16, "offset");
static_assert(offsetof(KosekiProgress, done_batches) == 24, "offset");
static_assert(offsetof(KosekiProgress, progress_ns) == 32, "offset");
static_assert(offsetof(KosekiProgress, number) == 40, "offset");
static_assert(offsetof(KosekiProgress, stream) == 42, "offset");
static_assert(offsetof(KosekiProgress, consumer) == 43, "offset");
static_assert(offsetof(KosekiProgress, reserved) == 44, "offset");
static_assert(offsetof(KosekiProgress, said_ns) == 48, "offset");

typedef struct KosekiOrder {
    uint64_t token; /* Number chosen by the sender, not 0: a repeated order with the same token has no further effect. */
    int64_t sent_ns; /* Time of sending, UTC, nanoseconds since 1970. */
    int64_t ends_ns; /* Time at which the order expires, UTC, nanoseconds since 1970; i64::MAX: never. In the event log and in */
    double value; /* Number that the kind needs; NaN: none. */
    uint32_t track; /* Number of a system track; 0: none. */
    uint32_t other_track; /* Number of a second system track, or of a sensor track at its source; 4294967295: none. */
    uint32_t number; /* Number of another order; 0: none. */
    uint16_t kind; /* Kind of order: an `OrderKind` code. */
    uint16_t source; /* Source: its number in the configuration; 65535: none, or all. */
    uint16_t other_source; /* Second source; 65535: none, or any. */
    uint8_t reserved[6]; /* Reserved, 0. */
    uint8_t name[32]; /* Word that the kind needs, UTF-8, padded with zeros. */
    uint8_t operator_name[32]; /* Name of the operator, UTF-8, padded with zeros. */
} KosekiOrder;
static_assert(sizeof(KosekiOrder) == 120, "size");
static_assert(offsetof(KosekiOrder, token) == 0, "offset");
static_assert(offsetof(KosekiOrder, sent_ns) == 8, "offset");
static_assert(offsetof(KosekiOrder, ends_ns) == 16, "offset");
static_assert(offsetof(KosekiOrder, value) == 24, "offset");
static_assert(offsetof(KosekiOrder, track) == 32, "offset");
static_assert(offsetof(KosekiOrder, other_track) == 36, "offset");
static_assert(offsetof(KosekiOrder, number) == 40, "offset");
static_assert(offsetof(KosekiOrder, kind) == 44, "offset");
static_assert(offsetof(KosekiOrder, source) == 46, "offset");
static_assert(offsetof(KosekiOrder, other_source) == 48, "offset");
static_assert(offsetof(KosekiOrder, reserved) == 50, "offset");
static_assert(offsetof(KosekiOrder, name) == 56, "offset");
static_assert(offsetof(KosekiOrder, operator_name) == 88, "offset");

typedef struct KosekiOrderState {
    KosekiOrder order; /* The order. */
    int64_t changed_ns; /* Time of the latest change of state, on the engine's clock, nanoseconds since 1970. */
    int64_t time_ns; /* Time of publication, UTC, nanoseconds since 1970. */
    uint64_t sequence; /* Sequence number at its publisher. */
    uint32_t number; /* Number given by fusion, ascending; 0: refused before fusion. */
    uint8_t status; /* State: an `OrderStatus` code. */
    uint8_t refusal; /* Reason of a refusal: a `Refusal` code; 0: none. */
    uint8_t has_changed; /* 1: the state has changed since the previous slice; 0: it is repeated. */
    uint8_t reserved; /* Reserved, 0. */
    uint8_t text[168]; /* The state in one sentence, UTF-8, padded with zeros. */
} KosekiOrderState;
static_assert(sizeof(KosekiOrderState) == 320, "size");
static_assert(offsetof(KosekiOrderState, order) == 0, "offset");
static_assert(offsetof(KosekiOrderState, changed_ns) == 120, "offset");
static_assert(offsetof(KosekiOrderState, time_ns) == 128, "offset");
static_assert(offsetof(KosekiOrderState, sequence) == 136, "offset");
static_assert(offsetof(KosekiOrderState, number) == 144, "offset");
static_assert(offsetof(KosekiOrderState, status) == 148, "offset");
static_assert(offsetof(KosekiOrderState, refusal) == 149, "offset");
static_assert(offsetof(KosekiOrderState, has_changed) == 150, "offset");
static_assert(offsetof(KosekiOrderState, reserved) == 151, "offset");
static_assert(offsetof(KosekiOrderState, text) == 152, "offset");

typedef struct KosekiFrameOrigin {
    double latitude_deg; /* Latitude on the WGS-84 ellipsoid, degrees, north positive. */
    double longitude_deg; /* Longitude, degrees, east positive. */
    double height_m; /* Height above the ellipsoid, metres. */
} KosekiFrameOrigin;
static_assert(sizeof(KosekiFrameOrigin) == 24, "size");
static_assert(offsetof(KosekiFrameOrigin, latitude_deg) == 0, "offset");
static_assert(offsetof(KosekiFrameOrigin, longitude_deg) == 8, "offset");
static_assert(offsetof(KosekiFrameOrigin, height_m) == 16, "offset");

typedef struct KosekiWorkStep {
    int64_t time_ns; /* Engine's time up to which time has passed with this step, nanoseconds; i64::MIN: unknown. Other meanings: */
    uint32_t sequence; /* Number of the report, modulo 2^32: its index among the samples of its publisher; in order `time` its own */
    uint16_t source; /* Number of the source; 65535 if the step is of none. */
    uint8_t kind; /* Kind of step: a `StepKind` code. */
    uint8_t flags; /* Flags: see `work_step_bits`. */
} KosekiWorkStep;
static_assert(sizeof(KosekiWorkStep) == 16, "size");
static_assert(offsetof(KosekiWorkStep, time_ns) == 0, "offset");
static_assert(offsetof(KosekiWorkStep, sequence) == 8, "offset");
static_assert(offsetof(KosekiWorkStep, source) == 12, "offset");
static_assert(offsetof(KosekiWorkStep, kind) == 14, "offset");
static_assert(offsetof(KosekiWorkStep, flags) == 15, "offset");

typedef struct KosekiRestored {
    uint64_t epoch; /* Start-up number of the fusion. */
    int64_t time_ns; /* UTC at the start, or at which the image was made, nanoseconds since 1970. */
    uint32_t part; /* Place of this part among all, from 0. */
    uint32_t parts; /* Number of parts. */
    uint32_t count; /* How many of `words` hold something. */
    uint32_t ends; /* 1 if the tracks were too old to continue, and each is reported as terminated; 2 for a snapshot. */
    uint64_t sequence; /* Sequence number at its publisher. */
    uint64_t words[120]; /* Words of a `fusion::checkpoint::Snapshot`, after those of the parts before; of an image the number of the */
} KosekiRestored;
static_assert(sizeof(KosekiRestored) == 1000, "size");
static_assert(offsetof(KosekiRestored, epoch) == 0, "offset");
static_assert(offsetof(KosekiRestored, time_ns) == 8, "offset");
static_assert(offsetof(KosekiRestored, part) == 16, "offset");
static_assert(offsetof(KosekiRestored, parts) == 20, "offset");
static_assert(offsetof(KosekiRestored, count) == 24, "offset");
static_assert(offsetof(KosekiRestored, ends) == 28, "offset");
static_assert(offsetof(KosekiRestored, sequence) == 32, "offset");
static_assert(offsetof(KosekiRestored, words) == 40, "offset");

#endif

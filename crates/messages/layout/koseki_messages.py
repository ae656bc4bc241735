"""Koseki's samples in shared memory, for ctypes and the iceoryx2 Python package.

To join an instance, set iceoryx2's root-path to the folder that `koseki status` names, and its prefix to the line in
the file koseki-instance there, which is another one at each start.

Written by `cargo run -p koseki-messages --example layouts`; a test keeps it true.
"""

import ctypes

SENSOR_TRACK_SCHEMA = 0xd57b159a09bf25f1  # BatchHeader.schema of its slices.
SENSOR_DETECTION_SCHEMA = 0xb3d1d23463cd8924  # BatchHeader.schema of its slices.
SENSOR_BEARING_SCHEMA = 0x91e05a7e1c4e0342  # BatchHeader.schema of its slices.
SENSOR_ARRIVAL_SCHEMA = 0x131e74a726730982  # BatchHeader.schema of its slices.
SENSOR_FIX_SCHEMA = 0xc19ad4d762f53481  # BatchHeader.schema of its slices.
TARGET_STATEMENT_SCHEMA = 0x3e47c1c272437996  # BatchHeader.schema of its slices.
SENSOR_SPECTRUM_SCHEMA = 0x294141f134fd3cce  # BatchHeader.schema of its slices.
PLATFORM_STATE_SCHEMA = 0x8d494f0b5412852b  # BatchHeader.schema of its slices.
WIDE_AREA_SCHEMA = 0x3b99c7106b96bc51  # BatchHeader.schema of its slices.
CUE_SCHEMA = 0x628bf8748d0293cc  # BatchHeader.schema of its slices.
SYSTEM_TRACK_SCHEMA = 0xbb9fd7f5d50f9179  # BatchHeader.schema of its slices.
ALARM_SCHEMA = 0x2f65dffd42e7c22b  # BatchHeader.schema of its slices.
ALERT_SCHEMA = 0x58bd4799add0a0cd  # BatchHeader.schema of its slices.
DECISION_SCHEMA = 0x9f26827141266f51  # BatchHeader.schema of its slices.
HEALTH_SCHEMA = 0xf1efa5cf6695293f  # BatchHeader.schema of its slices.
PROGRESS_SCHEMA = 0x724a090fd5e41882  # BatchHeader.schema of its slices.
ORDER_STATE_SCHEMA = 0x75a8ec42ae46cfc0  # BatchHeader.schema of its slices.
FRAME_ORIGIN_SCHEMA = 0x7a0c5d4e9d39fa05  # BatchHeader.schema of its slices.
WORK_STEP_SCHEMA = 0x44541240a46ea825  # BatchHeader.schema of its slices.
RESTORED_SCHEMA = 0xb57ebe5154fb4a98  # BatchHeader.schema of its slices.
CONTRIBUTIONS_MAX = 0x10  # Length of SystemTrack.contributions.
COUNTERS_MAX = 0xa0  # Length of Counters.values.
IDENTITY_MODE_3A = 0x1  # `mode_3a` holds a Mode 3/A code.
IDENTITY_CALLSIGN = 0x2  # `callsign` holds a callsign.
IDENTITY_NAME = 0x4  # `name` holds a name.
MOVEMENT_ACCELERATION = 0x1  # `acceleration_mps2` is known east and north.
MOVEMENT_VERTICAL_ACCELERATION = 0x2  # `acceleration_mps2` is known upwards.
SENSOR_TRACK_HEIGHT = 0x1  # Height (`position[2]`) was observed; otherwise z is 0 and its variance has no meaning.
SENSOR_TRACK_VELOCITY = 0x2  # Horizontal velocity was delivered or derived.
SENSOR_TRACK_VERTICAL_RATE = 0x4  # Vertical velocity was delivered or derived.
SENSOR_TRACK_OWN_COVARIANCE = 0x8  # The covariance is the source's own statement; otherwise it is derived from configured accuracies.
SENSOR_TRACK_MEASURED = 0x10  # `measured_m` holds the measurement from which the source updated its track.
SENSOR_TRACK_ON_GROUND = 0x20  # The source reports that the target is on the ground.
SENSOR_TRACK_DERIVED_VELOCITY = 0x40  # The velocity was derived by the adapter from successive positions.
SENSOR_TRACK_TRACE = 0x80  # `trace` holds the source's own covariance trace (TI-16).
SENSOR_TRACK_WILD_CLOCK = 0x100  # The time of measurement is not believed: it lies far from that of receipt, or the source's clock jumps.
SENSOR_TRACK_CONTRIBUTORS = 0x200  # `shared_sources` is known: the track is a system track of another centre, which names its sensors.
SENSOR_TRACK_LEVEL = 0x400  # `level` holds the level of the target's transponder.
SENSOR_TRACK_TURN_RATE = 0x800  # `turn_rate_radps` is known.
SENSOR_TRACK_PRESSURE_OFFSET = 0x1000  # `pressure_offset_m` is known: the report states its height in both ways.
SENSOR_TRACK_PLATFORM = 0x2000  # The sensors move: `measured_m` is the platform's place (east, north) and heading, no measurement.
SENSOR_DETECTION_RANGE_RATE = 0x1  # `range_rate_mps` was measured.
SENSOR_DETECTION_SIGMAS = 0x2  # `sigmas` hold standard deviations.
SENSOR_DETECTION_LEVEL = 0x4  # `level` holds the level of the target's transponder.
SENSOR_DETECTION_PLATFORM_VELOCITY = 0x8  # `platform_velocity_mps` is known.
SENSOR_DETECTION_PLATFORM_ATTITUDE = 0x10  # `platform_attitude_rad` and `attitude_sigmas_rad` are known.
SENSOR_DETECTION_PLATFORM_SIGMA = 0x20  # `platform_sigma_m` is known.
SENSOR_DETECTION_MARK = 0x40  # The sample is no detection but a mark of the sensor's time: `kind` holds a `DetectionMark` code.
SENSOR_DETECTION_TARGET_VELOCITY = 0x80  # Of a designation: `platform_velocity_mps` is the velocity of the target east and north, and the last of
SENSOR_BEARING_EMITTER = 0x1  # `emitter_id` is known: the sensor distinguishes transmitters.
SENSOR_BEARING_HEADING = 0x2  # `heading_rad` is known.
SENSOR_BEARING_FREQUENCY = 0x4  # `frequency_hz` was measured.
SENSOR_BEARING_PULSE_INTERVAL = 0x8  # `pulse_interval_s` was measured.
SENSOR_ARRIVAL_DIFFERENCE = 0x1  # `time_s` is a difference: arrival at the receiver minus arrival at the second one.
SENSOR_ARRIVAL_REFERENCE = 0x2  # `reference_m` is known: the transmission is of a reference emitter.
PLATFORM_STATE_VELOCITY = 0x1  # `velocity_mps` is known.
PLATFORM_STATE_HEADING = 0x2  # `heading_rad` is known.
PLATFORM_STATE_ATTITUDE = 0x4  # `pitch_rad` and `roll_rad` are known.
PLATFORM_STATE_POSITION_SIGMA = 0x8  # `position_sigma_m` is known.
PLATFORM_STATE_HEADING_SIGMA = 0x10  # `heading_sigma_rad` is known.
PLATFORM_STATE_VELOCITY_SIGMA = 0x20  # `velocity_sigma_mps` is known.
PLATFORM_STATE_ATTITUDE_SIGMA = 0x40  # `pitch_sigma_rad` and `roll_sigma_rad` are known.
PLATFORM_STATE_NO_POSITION = 0x80  # `position_m` is not known: a state of attitude or velocity alone.
WIDE_AREA_ORIGIN = 0x1  # `origin_m` is known.
CONTRIBUTION_FRESH = 0x1  # The source's latest report is within its expected period.
CONTRIBUTION_SCORED = 0x2  # The accuracy value exists: the source has delivered more than one report.
CONTRIBUTION_CENTRE = 0x4  # The contribution is a system track of another centre. If not fresh, it is listed for a while without
ALERT_SPECIAL_IDENTIFICATION = 0x1  # Special position identification: the pilot has pressed the button.
ALERT_EMERGENCY = 0x2  # An emergency of any kind; Mode 3/A code 7700.
ALERT_COMMUNICATION_FAILURE = 0x4  # Radio communication has failed; code 7600.
ALERT_UNLAWFUL_INTERFERENCE = 0x8  # Unlawful interference; code 7500.
ALERT_MEDICAL = 0x10  # Medical flight.
ALERT_MINIMUM_FUEL = 0x20  # Minimum fuel.
ALERT_TRANSPONDER_ALERT = 0x40  # The Mode 3/A code was changed lately, or the transponder raises its alert for another reason.
ALERT_RESOLUTION_ADVISORY = 0x80  # A collision avoidance system advises the crew to manoeuvre.
ALERT_VALUE_PREDICTED = 0x1  # `time_to_s` and `probability` are of the future: the event has not happened yet.
ALERT_VALUE_DISTANCE = 0x2  # `distance_m` and `least_distance_m` hold distances.
ALERT_VALUE_VERTICAL = 0x4  # `vertical_m` and `least_vertical_m` hold differences of height.
ALERT_VALUE_VALUE = 0x8  # `value` and `limit` hold what is compared: metres per second, metres or seconds by the kind.
ALERT_VALUE_ACKNOWLEDGED = 0x10  # An operator has acknowledged the alert.
REGISTRATION_EAST = 0x1  # The offset east is being removed from the source's reports.
REGISTRATION_NORTH = 0x2  # The offset north is.
REGISTRATION_UP = 0x4  # The offset up is.
REGISTRATION_TIME = 0x8  # The time offset is.
REGISTRATION_RANGE = 0x10  # The range bias is.
REGISTRATION_AZIMUTH = 0x20  # The azimuth bias is.
WORK_STEP_WILD_CLOCK = 0x1  # Fusion did not believe the time of the report.
TARGET_STATEMENT_SIZE = 0x1  # `length_m` and `width_m` hold a size.
TARGET_STATEMENT_SELECTED_ALTITUDE = 0x2  # `selected_altitude_m` holds an altitude.
TARGET_STATEMENT_OPERATOR = 0x4  # `place_deg` holds the place of the operator of an unmanned aircraft.
TARGET_STATEMENT_STATION = 0x8  # The sample is of a station that is no target: `place_deg` holds its own place, `name` its name.
TARGET_STATEMENT_VIRTUAL = 0x10  # The aid to navigation is not there: a station ashore sends for it.
TARGET_STATEMENT_OFF_POSITION = 0x20  # The aid to navigation, which floats, is off its position.
STATE_TENTATIVE = 0x0  # Seen, not yet believed.
STATE_CONFIRMED = 0x1  # Believed, and supported by recent reports.
STATE_COASTED = 0x2  # Believed, but carried on by extrapolation for want of reports.
STATE_TERMINATED = 0x3  # Ended; the number is not used again soon.
STATE_SUSPENDED = 0x4  # No longer reported by any source: not shown, while the number rests and may resume.
KIND_SINGLE = 0x0  # One target.
KIND_GROUP = 0x1  # Several unresolved targets (WA-7).
MODE_STEADY = 0x0  # Constant velocity in the plane.
MODE_AGILE = 0x1  # Nearly constant velocity in the plane with strong process noise.
MODE_LEFT_TURN = 0x2  # Coordinated turn to the left.
MODE_RIGHT_TURN = 0x3  # Coordinated turn to the right.
MODE_SPEED_CHANGE = 0x4  # Change of speed along the course.
MODE_LEVEL = 0x5  # Constant height.
MODE_CLIMB = 0x6  # Constant climb rate.
MODE_CLIMB_CHANGE = 0x7  # Change of the climb rate.
ERROR_MODEL_UNDECIDED = 0x0  # No model has sufficient evidence.
ERROR_MODEL_OFFSET = 0x1  # Constant offset in the system frame.
ERROR_MODEL_BODY = 0x2  # Offset fixed to the target's body: a reference point other than that of other sources.
ERROR_MODEL_POLAR = 0x3  # Offset that grows with range or azimuth.
ERROR_MODEL_TIME = 0x4  # Time offset.
RULE_AUTO = 0x1  # Filter of the target, with learned accuracies of the sources.
RULE_SYSTEM_FILTER = 0x2  # Filter of the target's own.
RULE_BEST_SOURCE = 0x3  # Source with the smallest accuracy value.
RULE_INVERSE_TRACE = 0x4  # Weights inverse to the covariance traces.
RULE_QUALITY_FACTOR = 0x5  # Weights by quality index.
RULE_MOSAIC = 0x6  # Source that the cell of a mosaic names.
RULE_INFORMATION = 0x7  # Information sum of independent errors.
RULE_COVARIANCE_INTERSECTION = 0x8  # Covariance intersection: bound for unknown correlations.
RULE_BAR_SHALOM_CAMPO = 0x9  # Bar-Shalom and Campo's combination of correlated errors.
IDENTITY_KIND_NONE = 0x0  # No number is known.
IDENTITY_KIND_AIRCRAFT = 0x1  # 24-bit aircraft address.
IDENTITY_KIND_SHIP = 0x2  # 30-bit Maritime Mobile Service Identity (MMSI).
HORIZONTAL_UNKNOWN = 0x0  # Not known.
HORIZONTAL_STRAIGHT = 0x1  # Constant course.
HORIZONTAL_TURN_LEFT = 0x2  # Turn to the left.
HORIZONTAL_TURN_RIGHT = 0x3  # Turn to the right.
VERTICAL_UNKNOWN = 0x0  # Not known.
VERTICAL_LEVEL = 0x1  # Constant height.
VERTICAL_CLIMB = 0x2  # Climb.
VERTICAL_DESCEND = 0x3  # Descent.
LONGITUDINAL_UNKNOWN = 0x0  # Not known.
LONGITUDINAL_CONSTANT = 0x1  # Constant speed over ground.
LONGITUDINAL_INCREASING = 0x2  # Increasing speed over ground.
LONGITUDINAL_DECREASING = 0x3  # Decreasing speed over ground.
DETECTION_KIND_POSITION2 = 0x0  # East and north in the system frame.
DETECTION_KIND_POSITION3 = 0x1  # East, north and up in the system frame.
DETECTION_KIND_RANGE_BEARING = 0x2  # Slant range and bearing from the sensor.
DETECTION_KIND_RANGE_BEARING_ELEVATION = 0x3  # Slant range, bearing and elevation from the sensor.
DETECTION_KIND_BEARING = 0x4  # Bearing from the sensor.
DETECTION_KIND_BEARING_ELEVATION = 0x5  # Bearing and elevation from the sensor.
DETECTION_MARK_PASSED = 0x0  # The sensor's time has come to the time of measurement.
DETECTION_MARK_EMPTY_SCAN = 0x1  # The scan `scan` at the time of measurement has no detections.
DETECTION_MARK_TURN_BEGINS = 0x2  # A turn of the sensor begins at the time of measurement.
DETECTION_MARK_UNPLACED = 0x3  # A detection at the time of measurement was refused: no state of the sensor's platform belongs to its time.
STREAM_SENSOR_TRACKS = 0x1  # Sensor tracks of a source.
STREAM_DETECTIONS = 0x2  # Detections of a source.
STREAM_BEARINGS = 0x3  # Bearings of a source.
STREAM_PLATFORM_STATES = 0x4  # States of the platform that carries a source's sensor.
STREAM_CUES = 0x5  # Cues for the sensor of a source.
STREAM_WIDE_AREA = 0x6  # Reports of a wide-area sensor.
STREAM_SYSTEM_TRACKS = 0x7  # System tracks.
STREAM_ALARMS = 0x8  # Alarms.
STREAM_DECISIONS = 0x9  # Decisions of fusion.
STREAM_ORDERS = 0xa  # States of orders.
STREAM_ARRIVALS = 0xb  # Arrival times of a source.
STREAM_FIXES = 0xc  # Ready-made fixes of a source.
STREAM_STATEMENTS = 0xd  # What the targets of a source state beside their motion.
STREAM_ALERTS = 0xe  # Alerts on targets.
STEP_BEGIN = 0x1  # Fusion starts from its configuration: `time_ns` is its epoch.
STEP_REPORT = 0x2  # The report of `source` with the number `sequence` is worked off, and time has passed up to `time_ns`.
STEP_PUBLISHER = 0x3  # The next reports of `source` come from the publisher with the incarnation `time_ns`.
STEP_TIME = 0x4  # Time has passed up to `time_ns` without a report.
STEP_CONDITION = 0x5  # Condition (weather) number `sequence` holds from now on, when time has passed up to `time_ns`. Written by
STEP_RESTORED = 0x6  # Fusion resumes from the data on `system/restored` for its epoch; tracks listed there are reported as
STEP_NUMBERS = 0x7  # Numbers of system tracks begin at `sequence`, because the numbers assigned before are unknown.
STEP_IMAGE = 0x8  # A snapshot of the engine's present state is published on `system/restored`, with the time `time_ns`.
STEP_HOST_OFFSET = 0x9  # The sources' time is ahead of the engine's by `time_ns` (nanoseconds) from now on: the host offset.
STEP_SOURCE_CLOCK = 0xa  # The clock of `source` is off by `sequence` milliseconds (as a signed number), as times of receipt show it.
STEP_QUARANTINE = 0xb  # The report of `source` with the number `sequence` is in quarantine and has no effect: fusion has died in the
STEP_ORDER_PART = 0xc  # Bytes 8·`sequence` to 8·`sequence` + 7 of the order that the next step of kind `Order` completes are
STEP_ORDER = 0xd  # The order of the preceding parts has its effect now, when time has passed up to `time_ns`.
PROCESS_ADAPTER = 0x0  # Turns one sensor's data into sensor tracks.
PROCESS_FUSION = 0x1  # Fuses sensor tracks into system tracks.
PROCESS_MONITOR = 0x2  # Records latencies and counters.
PROCESS_RECORDER = 0x3  # Writes tracks to files.
PROCESS_LAUNCHER = 0x4  # Starts and watches the others.
PROCESS_SIMULATOR = 0x5  # Sends the observations of simulated sensors over the network.
PROCESS_GATEWAY = 0x6  # Sends tracks to other systems over the network.
PROCESS_KEEPER = 0x7  # Holds the topics for the launcher, which maps no shared memory itself.
PROCESS_DISPLAY = 0x8  # Shows the picture in browsers.
PROCESS_LINK = 0x9  # Exchanges topics with deployments on other hosts.
PROCESS_ALERTS = 0xa  # Finds events and dangers about targets.
LIFE_STARTING = 0x0  # Opening its topics.
LIFE_RUNNING = 0x1  # Doing its work.
LIFE_FINISHED = 0x2  # Done: all its input is processed, and it will exit.
LIFE_FAILED = 0x3  # Unable to continue; the note states the reason.
ALARM_SEVERITY_WARNING = 0x1  # Nothing is wrong yet; it may become so.
ALARM_SEVERITY_MAJOR = 0x2  # Part of the picture is missing or wrong.
ALARM_SEVERITY_CRITICAL = 0x3  # The picture as a whole is not to be relied on.
ALARM_EVENT_RAISED = 0x1  # The alarm has just been raised.
ALARM_EVENT_STANDING = 0x2  # The alarm was raised before, and stands.
ALARM_EVENT_CLEARED = 0x3  # The alarm has just been cleared.
ALERT_KIND_ENTER = 0x1  # A target is in an area, or will be.
ALERT_KIND_LEAVE = 0x2  # A target has left an area, or will leave it.
ALERT_KIND_STAY = 0x3  # A target has been in an area for too long.
ALERT_KIND_CONFLICT = 0x4  # Two aircraft come nearer to each other than both minima.
ALERT_KIND_APPROACH = 0x5  # Two vessels come close to each other.
ALERT_KIND_LOW = 0x6  # A target is below a least height, or will be.
ALERT_KIND_SPEED = 0x7  # A target is too fast or too slow.
ALERT_KIND_LEVEL = 0x8  # A target is outside of a band of heights.
ALERT_KIND_LOST = 0x9  # A target is no longer reported.
ALERT_KIND_EMERGENCY = 0xa  # A target states an emergency.
DECISION_KIND_STARTED = 0x1  # A system track was started for a sensor track that fits none.
DECISION_KIND_JOINED = 0x2  # A sensor track joined a system track it fits: value d², limit the gate.
DECISION_KIND_JOINED_BY_ADDRESS = 0x3  # A sensor track joined the system track of its address.
DECISION_KIND_DUPLICATE = 0x4  # A sensor track was recognised as another part of a target that its source already follows: value metres.
DECISION_KIND_IDENTITY_CONFLICT = 0x5  # A sensor track left because its address contradicts the system track's.
DECISION_KIND_SPLIT = 0x6  # A sensor track left because it kept missing the others: value d², limit the gate.
DECISION_KIND_MERGED = 0x7  # A system track was found to be the same target as another, and merged into it: value d², limit the gate.
DECISION_KIND_CONFIRMED = 0x8  # A system track was confirmed: value the number of sources, or the log-likelihood ratio of a single
DECISION_KIND_WITHHELD = 0x9  # A system track is withheld: its sources report that they no longer detect the target. Value the sum of the
DECISION_KIND_COASTED = 0xa  # Nothing fresh contributes any more.
DECISION_KIND_ENDED = 0xb  # A system track has ended.
DECISION_KIND_HAND_OVER = 0xc  # The selected source has changed: value the new source's accuracy value, limit the previous source's.
DECISION_KIND_REFERENCE_POINT = 0xd  # The target's reference point is now that of this source.
DECISION_KIND_UNCROSSED = 0xe  # A sensor track has changed places with another track of its source: value the sum of log-likelihood
DECISION_KIND_ORDERED = 0xf  # An order of an operator has changed a system track: value the number of the order.
DECISION_KIND_ORDER_ENDED = 0x10  # An order on system tracks has ended, because the tracks are farther apart than permitted: value the
DECISION_KIND_SUSPENDED = 0x11  # A system track that was shown is no longer reported: its number rests.
DECISION_KIND_RESUMED = 0x12  # A target has come back under its former number: value the logarithm of the likelihood ratio of the same
ORDER_CONDITION = 0x1  # A weather condition holds for the accuracy of a source, or of all sources (TI-7).
ORDER_SNAPSHOT = 0x2  # Fusion publishes a snapshot of the engine, for a recorder.
ORDER_OUT = 0x3  # The reports of a source are counted and not used.
ORDER_IN = 0x4  # The reports of a source that is out are used again.
ORDER_ETA = 0x5  # First weight eta_0 of a hand-over to a source, from another source or from any (TI-13).
ORDER_K = 0x6  # Adjustment coefficient k of a source: smaller values are preferred (TI-8).
ORDER_RULE = 0x7  # A rule weighs the sources of all system tracks.
ORDER_DROP = 0x8  # A system track ends, and its sensor tracks start no other.
ORDER_JOIN = 0x9  # Two system tracks are one target: the older number remains.
ORDER_SPLIT = 0xa  # A sensor track leaves its system track and gets a system track of its own.
ORDER_RENUMBER = 0xb  # A system track gets a new number, and the old number ends.
ORDER_RESET = 0xc  # Everything learned of a source is forgotten: errors, accuracy, detection probability, dependence.
ORDER_CANCEL = 0xd  # An order in force ends.
ORDER_QNH = 0xe  # The pressure at mean sea level in a region, hPa, by the name of its `[[qnh]]`.
ORDER_DESIGNATE = 0xf  # A tracker follows the target at a place of this standard deviation, metres.
ORDER_STATUS_IN_FORCE = 0x1  # The order has an effect that lasts.
ORDER_STATUS_DONE = 0x2  # The effect has taken place, and nothing of it lasts.
ORDER_STATUS_CANCELLED = 0x3  # Another order has cancelled this order.
ORDER_STATUS_EXPIRED = 0x4  # The time of the order is over.
ORDER_STATUS_REPLACED = 0x5  # A newer order of this kind holds for the same subject.
ORDER_STATUS_ENDED = 0x6  # The tracks no longer permit the effect: a track has ended, or the distance exceeded its limit.
ORDER_STATUS_REFUSED = 0x7  # The order has no effect: see `refusal`.
REFUSAL_UNKNOWN_KIND = 0x1  # No such kind.
REFUSAL_MALFORMED = 0x2  # A text is not UTF-8, the token is 0, or the expiry lies before 1970.
REFUSAL_MISSING_PARAMETER = 0x3  # A parameter of the kind is missing.
REFUSAL_FOREIGN_PARAMETER = 0x4  # A parameter does not belong to the kind.
REFUSAL_OUT_OF_RANGE = 0x5  # The value lies outside its range.
REFUSAL_EXPIRED = 0x6  # The order was sent too long ago, or its expiry has passed.
REFUSAL_TOO_MANY = 0x7  # Too many orders in a short time.
REFUSAL_TABLE_FULL = 0x8  # The table of orders in force is full.
REFUSAL_UNKNOWN_SOURCE = 0x9  # No such source.
REFUSAL_UNKNOWN_CONDITION = 0xa  # No source states a factor for the condition.
REFUSAL_UNKNOWN_RULE = 0xb  # No such rule.
REFUSAL_RULE_WITHOUT_REPORTS = 0xc  # The rule needs stored reports, which this deployment does not keep.
REFUSAL_UNKNOWN_TRACK = 0xd  # No system track with this number is alive.
REFUSAL_SAME_TRACK = 0xe  # Both parameters name the same system track.
REFUSAL_TWO_ADDRESSES = 0xf  # The two system tracks have different addresses.
REFUSAL_UNKNOWN_SENSOR_TRACK = 0x10  # The sensor track is no member of the system track.
REFUSAL_ONLY_MEMBER = 0x11  # The sensor track is the only member of its system track.
REFUSAL_BOUND_TRACK = 0x12  # Another order in force already binds the system track.
REFUSAL_UNKNOWN_ORDER = 0x13  # No order in force has this number.
REFUSAL_NOT_OUT = 0x14  # The source is not out.
REFUSAL_BUSY = 0x15  # Fusion still publishes the previous snapshot or states.
REFUSAL_UNKNOWN_QNH = 0x16  # The configuration has no `[[qnh]]` of this name.
REFUSAL_TAKES_NO_DESIGNATIONS = 0x17  # The tracker has no sensor that takes orders.
REFUSAL_NO_PLACE = 0x18  # The text is no place.
REFUSAL_UNUSED_BY_RULE = 0x19  # The rule in force uses no such value.
REFUSAL_FAR_PLACE = 0x1a  # The place is too far from the origin of the system frame.
CATEGORY_UNKNOWN = 0x0  # Nothing is stated.
CATEGORY_LIGHT = 0x1  # Aircraft below 7,031 kg (15,500 lb).
CATEGORY_SMALL = 0x2  # Aircraft from 7,031 kg to 34,019 kg (75,000 lb).
CATEGORY_LARGE = 0x3  # Aircraft from 34,019 kg to 136,078 kg (300,000 lb).
CATEGORY_HIGH_VORTEX = 0x4  # Aircraft with a strong wake vortex.
CATEGORY_HEAVY = 0x5  # Aircraft above 136,078 kg.
CATEGORY_HIGH_PERFORMANCE = 0x6  # Aircraft with an acceleration above 5 g and a speed above 400 knots.
CATEGORY_ROTORCRAFT = 0x7  # Helicopter or gyroplane.
CATEGORY_GLIDER = 0x8  # Glider or sailplane.
CATEGORY_LIGHTER_THAN_AIR = 0x9  # Balloon or airship.
CATEGORY_PARACHUTIST = 0xa  # Parachutist or skydiver.
CATEGORY_ULTRALIGHT = 0xb  # Ultralight, hang glider or paraglider.
CATEGORY_UNMANNED = 0xc  # Unmanned aircraft.
CATEGORY_SPACE = 0xd  # Space vehicle.
CATEGORY_EMERGENCY_VEHICLE = 0x14  # Emergency vehicle on the ground.
CATEGORY_SERVICE_VEHICLE = 0x15  # Service vehicle on the ground.
CATEGORY_OBSTACLE = 0x16  # Obstacle, fixed or moored.
CATEGORY_SHIP = 0x1e  # Ship of a kind without a word of its own.
CATEGORY_WING_IN_GROUND = 0x1f  # Wing in ground effect.
CATEGORY_FISHING = 0x20  # Fishing vessel.
CATEGORY_TOWING = 0x21  # Vessel that tows.
CATEGORY_DREDGING = 0x22  # Vessel engaged in dredging or underwater work.
CATEGORY_DIVING = 0x23  # Vessel engaged in diving.
CATEGORY_MILITARY = 0x24  # Vessel engaged in military operations.
CATEGORY_SAILING = 0x25  # Sailing vessel.
CATEGORY_PLEASURE = 0x26  # Pleasure craft.
CATEGORY_HIGH_SPEED = 0x27  # High-speed craft.
CATEGORY_PILOT = 0x28  # Pilot vessel.
CATEGORY_RESCUE = 0x29  # Search and rescue vessel, or aircraft with an MMSI.
CATEGORY_TUG = 0x2a  # Tug.
CATEGORY_TENDER = 0x2b  # Port tender.
CATEGORY_ANTI_POLLUTION = 0x2c  # Vessel with anti-pollution facilities.
CATEGORY_LAW_ENFORCEMENT = 0x2d  # Law enforcement vessel.
CATEGORY_MEDICAL = 0x2e  # Medical transport.
CATEGORY_PASSENGER = 0x2f  # Passenger ship.
CATEGORY_CARGO = 0x30  # Cargo ship.
CATEGORY_TANKER = 0x31  # Tanker.
CATEGORY_AID = 0x3c  # Aid to navigation.
CATEGORY_BASE_STATION = 0x3d  # Base station ashore.
CATEGORY_RESCUE_TRANSMITTER = 0x3e  # Search and rescue transmitter (AIS-SART, MMSI 970…).
CATEGORY_MAN_OVERBOARD = 0x3f  # Man overboard device (MMSI 972…).
CATEGORY_RESCUE_BEACON = 0x40  # Emergency position-indicating radio beacon (MMSI 974…).
AID_UNKNOWN = 0x0  # Nothing is stated.
AID_REFERENCE_POINT = 0x1  # Reference point.
AID_RACON = 0x2  # Radar beacon.
AID_STRUCTURE = 0x3  # Fixed structure off shore: oil platform, wind farm.
AID_WRECK = 0x4  # Emergency wreck marking buoy.
AID_LIGHT = 0x5  # Light without sectors.
AID_SECTOR_LIGHT = 0x6  # Light with sectors.
AID_FRONT_LIGHT = 0x7  # Front leading light.
AID_REAR_LIGHT = 0x8  # Rear leading light.
AID_NORTH_BEACON = 0x9  # Beacon, cardinal north.
AID_EAST_BEACON = 0xa  # Beacon, cardinal east.
AID_SOUTH_BEACON = 0xb  # Beacon, cardinal south.
AID_WEST_BEACON = 0xc  # Beacon, cardinal west.
AID_PORT_BEACON = 0xd  # Beacon, port hand.
AID_STARBOARD_BEACON = 0xe  # Beacon, starboard hand.
AID_PREFERRED_PORT_BEACON = 0xf  # Beacon, preferred channel port hand.
AID_PREFERRED_STARBOARD_BEACON = 0x10  # Beacon, preferred channel starboard hand.
AID_DANGER_BEACON = 0x11  # Beacon, isolated danger.
AID_SAFE_WATER_BEACON = 0x12  # Beacon, safe water.
AID_SPECIAL_BEACON = 0x13  # Beacon, special mark.
AID_NORTH_MARK = 0x14  # Floating mark, cardinal north.
AID_EAST_MARK = 0x15  # Floating mark, cardinal east.
AID_SOUTH_MARK = 0x16  # Floating mark, cardinal south.
AID_WEST_MARK = 0x17  # Floating mark, cardinal west.
AID_PORT_MARK = 0x18  # Floating mark, port hand.
AID_STARBOARD_MARK = 0x19  # Floating mark, starboard hand.
AID_PREFERRED_PORT_MARK = 0x1a  # Floating mark, preferred channel port hand.
AID_PREFERRED_STARBOARD_MARK = 0x1b  # Floating mark, preferred channel starboard hand.
AID_DANGER_MARK = 0x1c  # Floating mark, isolated danger.
AID_SAFE_WATER_MARK = 0x1d  # Floating mark, safe water.
AID_SPECIAL_MARK = 0x1e  # Floating mark, special.
AID_LIGHT_VESSEL = 0x1f  # Light vessel, large navigational buoy, or rig.
NAVIGATION_UNKNOWN = 0x0  # Nothing is stated.
NAVIGATION_ENGINE = 0x1  # Under way using engine.
NAVIGATION_ANCHORED = 0x2  # At anchor.
NAVIGATION_NOT_UNDER_COMMAND = 0x3  # Not under command.
NAVIGATION_RESTRICTED = 0x4  # Restricted manoeuvrability.
NAVIGATION_CONSTRAINED = 0x5  # Constrained by the draught.
NAVIGATION_MOORED = 0x6  # Moored.
NAVIGATION_AGROUND = 0x7  # Aground.
NAVIGATION_FISHING = 0x8  # Engaged in fishing.
NAVIGATION_SAILING = 0x9  # Under way sailing.
NAVIGATION_RESCUE = 0xf  # Active transmitter of search and rescue: AIS-SART, man overboard or beacon.
EMERGENCY_UNKNOWN = 0x0  # Nothing is stated.
EMERGENCY_NONE = 0x1  # No emergency.
EMERGENCY_GENERAL = 0x2  # General emergency.
EMERGENCY_MEDICAL = 0x3  # Medical emergency.
EMERGENCY_MINIMUM_FUEL = 0x4  # Minimum fuel.
EMERGENCY_NO_COMMUNICATION = 0x5  # No communication.
EMERGENCY_UNLAWFUL_INTERFERENCE = 0x6  # Unlawful interference.
EMERGENCY_DOWNED = 0x7  # Downed aircraft.
EMERGENCY_DISTRESS = 0x8  # Distress at sea.


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
        ("address", ctypes.c_uint32),  # 24-bit aircraft address or 30-bit MMSI (see `kind`), an integer in the low bits.
        ("mode_3a", ctypes.c_uint16),  # Mode 3/A code, an integer of twelve bits: 2300 in octal digits is 1216.
        ("kind", ctypes.c_uint8),  # Kind of `address`: an `IdentityKind` code.
        ("valid", ctypes.c_uint8),  # Fields that hold something: see `identity_bits`.
        ("callsign", ctypes.c_uint8 * 8),  # Callsign in ASCII, padded with blanks.
        ("name", ctypes.c_uint8 * 20),  # Name in ASCII, padded with blanks: that of a ship, for example.
        ("reserved", ctypes.c_uint32),  # Reserved, 0.
    ]

    @staticmethod
    def type_name() -> str:
        return "Identity"


assert ctypes.sizeof(Identity) == 40
assert Identity.address.offset == 0
assert Identity.mode_3a.offset == 4
assert Identity.kind.offset == 6
assert Identity.valid.offset == 7
assert Identity.callsign.offset == 8
assert Identity.name.offset == 16
assert Identity.reserved.offset == 36


class IdentityAges(ctypes.Structure):
    _fields_ = [
        ("address_ms", ctypes.c_uint32),  # Age of `address`, milliseconds.
        ("mode_3a_ms", ctypes.c_uint32),  # Age of `mode_3a`, milliseconds.
        ("callsign_ms", ctypes.c_uint32),  # Age of `callsign`, milliseconds.
    ]

    @staticmethod
    def type_name() -> str:
        return "IdentityAges"


assert ctypes.sizeof(IdentityAges) == 12
assert IdentityAges.address_ms.offset == 0
assert IdentityAges.mode_3a_ms.offset == 4
assert IdentityAges.callsign_ms.offset == 8


class Extent(ctypes.Structure):
    _fields_ = [
        ("length_m", ctypes.c_float),  # Length of the longer side, metres; 0: unknown.
        ("width_m", ctypes.c_float),  # Length of the shorter side, metres; 0: unknown.
        ("orientation_rad", ctypes.c_float),  # Direction of the longer side, radians clockwise from north, in [0, 2 pi).
        ("length_sigma_m", ctypes.c_float),  # Standard deviation of the length, metres; 0: unknown.
        ("width_sigma_m", ctypes.c_float),  # Standard deviation of the width, metres; 0: unknown.
        ("orientation_sigma_rad", ctypes.c_float),  # Standard deviation of the orientation, radians; 0: the orientation is unknown.
    ]

    @staticmethod
    def type_name() -> str:
        return "Extent"


assert ctypes.sizeof(Extent) == 24
assert Extent.length_m.offset == 0
assert Extent.width_m.offset == 4
assert Extent.orientation_rad.offset == 8
assert Extent.length_sigma_m.offset == 12
assert Extent.width_sigma_m.offset == 16
assert Extent.orientation_sigma_rad.offset == 20


class Movement(ctypes.Structure):
    _fields_ = [
        ("acceleration_mps2", ctypes.c_float * 3),  # Acceleration east, north, up, metres per second squared.
        ("horizontal", ctypes.c_uint8),  # Mode in the horizontal plane: a `HorizontalMovement` code.
        ("vertical", ctypes.c_uint8),  # Mode in the vertical: a `VerticalMovement` code.
        ("longitudinal", ctypes.c_uint8),  # Mode along the track: a `LongitudinalMovement` code.
        ("valid", ctypes.c_uint8),  # Components of the acceleration that are known: see `movement_bits`.
    ]

    @staticmethod
    def type_name() -> str:
        return "Movement"


assert ctypes.sizeof(Movement) == 16
assert Movement.acceleration_mps2.offset == 0
assert Movement.horizontal.offset == 12
assert Movement.vertical.offset == 13
assert Movement.longitudinal.offset == 14
assert Movement.valid.offset == 15


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
        ("schema", ctypes.c_uint64),  # Fingerprint of the layout the publisher was built with; others are rejected.
        ("incarnation", ctypes.c_uint64),  # Monotonic start time of the publisher, nanoseconds: a restart shows as a new value.
        ("first_sequence", ctypes.c_uint64),  # Samples sent by this incarnation before this slice: the sequence number of its first sample.
        ("progress_ns", ctypes.c_int64),  # Progress mark: no later sample will have a time of measurement before this (UTC, ns); i64::MIN if unknown.
        ("sent_ns", ctypes.c_int64),  # Monotonic time of the send, nanoseconds.
        ("epoch", ctypes.c_uint64),  # Start-up number of fusion, rising with each start (see [`Epochs`]); tracks of smaller ones are not kept up.
        ("flags", ctypes.c_uint32),  # Bit 0: the source has ended. Bit 1: this epoch of fusion continues the tracks of the previous epoch. Bits
        ("sensor_uid", ctypes.c_uint32),  # Identity of the sensor, the same in every deployment; 0: unknown, or no sensor.
        ("origin", ctypes.c_uint32),  # Original deployment of the samples, if another; 0: this deployment.
        ("clock_offset_ms", ctypes.c_int32),  # Offset of the source's clock against the publisher's UTC, by the times at which its data are received,
    ]

    @staticmethod
    def type_name() -> str:
        return "BatchHeader"


assert ctypes.sizeof(BatchHeader) == 64
assert BatchHeader.schema.offset == 0
assert BatchHeader.incarnation.offset == 8
assert BatchHeader.first_sequence.offset == 16
assert BatchHeader.progress_ns.offset == 24
assert BatchHeader.sent_ns.offset == 32
assert BatchHeader.epoch.offset == 40
assert BatchHeader.flags.offset == 48
assert BatchHeader.sensor_uid.offset == 52
assert BatchHeader.origin.offset == 56
assert BatchHeader.clock_offset_ms.offset == 60


class SensorTrack(ctypes.Structure):
    _fields_ = [
        ("time_of_measurement_ns", ctypes.c_int64),  # Time of measurement, UTC, nanoseconds since 1970.
        ("sequence", ctypes.c_uint64),  # The report's sequence number at its publisher.
        ("stages", StageTimes),  # Stages passed so far.
        ("track_number", ctypes.c_uint32),  # Number of the sensor track at its source.
        ("source", ctypes.c_uint16),  # Source: its number in the configuration (TI-2).
        ("valid", ctypes.c_uint16),  # Which fields hold something: see `sensor_track_bits`.
        ("identity", Identity),  # Identity of the target, as far as it is known.
        ("position_m", ctypes.c_double * 3),  # Position east, north, up, metres.
        ("velocity_mps", ctypes.c_double * 3),  # Velocity east, north, up, metres per second. A component with a variance of 0 is unknown.
        ("covariance", Covariance),  # Covariance of position and velocity; all 0 where the source gives its `trace_m2` instead. A variance of 0
        ("measured_m", ctypes.c_double * 3),  # Measured position, before the source's own filter, metres. See the bit `PLATFORM`.
        ("trace_m2", ctypes.c_double),  # Trace of the source's position covariance over east and north, square metres.
        ("state", ctypes.c_uint8),  # State of the track at its source: a `TrackState` code.
        ("method", ctypes.c_uint8),  # Observation method at the source, as numbered by its format; 0 for a single method.
        ("alerts", ctypes.c_uint8),  # Alerts of the target or its source: see `alert_bits`.
        ("kind", ctypes.c_uint8),  # Kind of the tracked object: a `TrackKind` code.
        ("members", ctypes.c_uint16),  # Expected number of members of a group; 0 for a single target.
        ("level", ctypes.c_int16),  # Level that the transponder stated last, in steps of 25 feet at 1013.25 hPa; 0 without the bit `LEVEL`.
        ("target_type", TargetType),  # Type of the target.
        ("extent", Extent),  # Size of the target, as stated or measured by its source.
        ("movement", Movement),  # Modes of movement and acceleration, as the source states them.
        ("shared_sources", ctypes.c_uint64),  # Local sources whose sensors have contributed to a system track of another centre, as bits by number; sources
        ("origin", ctypes.c_uint32),  # Original deployment of a system track of another centre; else 0.
        ("level_age_ms", ctypes.c_uint32),  # Age of `level` at the time of measurement, milliseconds.
        ("identity_ages", IdentityAges),  # Ages of the values of `identity` at the time of measurement.
        ("existence", ctypes.c_float),  # Probability that the target exists according to the source, in (0, 1]; 0: not stated.
        ("turn_rate_radps", ctypes.c_float),  # Rate of turn according to the source, clockwise from above, radians per second.
        ("pressure_offset_m", ctypes.c_float),  # Height by pressure, as in `position_m`, minus the height above the ellipsoid that the report states, metres.
    ]

    @staticmethod
    def type_name() -> str:
        return "SensorTrack"


assert ctypes.sizeof(SensorTrack) == 448
assert SensorTrack.time_of_measurement_ns.offset == 0
assert SensorTrack.sequence.offset == 8
assert SensorTrack.stages.offset == 16
assert SensorTrack.track_number.offset == 48
assert SensorTrack.source.offset == 52
assert SensorTrack.valid.offset == 54
assert SensorTrack.identity.offset == 56
assert SensorTrack.position_m.offset == 96
assert SensorTrack.velocity_mps.offset == 120
assert SensorTrack.covariance.offset == 144
assert SensorTrack.measured_m.offset == 312
assert SensorTrack.trace_m2.offset == 336
assert SensorTrack.state.offset == 344
assert SensorTrack.method.offset == 345
assert SensorTrack.alerts.offset == 346
assert SensorTrack.kind.offset == 347
assert SensorTrack.members.offset == 348
assert SensorTrack.level.offset == 350
assert SensorTrack.target_type.offset == 352
assert SensorTrack.extent.offset == 368
assert SensorTrack.movement.offset == 392
assert SensorTrack.shared_sources.offset == 408
assert SensorTrack.origin.offset == 416
assert SensorTrack.level_age_ms.offset == 420
assert SensorTrack.identity_ages.offset == 424
assert SensorTrack.existence.offset == 436
assert SensorTrack.turn_rate_radps.offset == 440
assert SensorTrack.pressure_offset_m.offset == 444


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
        ("kind", ctypes.c_uint8),  # Quantities that were measured: a `DetectionKind` code.
        ("valid", ctypes.c_uint8),  # Which fields hold something: see `sensor_detection_bits`.
        ("level_age_ms", ctypes.c_uint32),  # Age of `level` at the time of measurement, milliseconds.
        ("identity", Identity),  # Identity of the target in the detection, as far as it is known.
        ("identity_ages", IdentityAges),  # Ages of the values of `identity` at the time of measurement.
        ("level", ctypes.c_int16),  # Level of the transponder, in steps of 25 feet at 1013.25 hPa; 0 without the bit `LEVEL`.
        ("reserved", ctypes.c_uint16),  # Reserved, 0.
        ("platform_velocity_mps", ctypes.c_float * 3),  # Velocity of the sensor's platform east, north, up, metres per second.
        ("platform_attitude_rad", ctypes.c_float * 3),  # Heading (clockwise from north), pitch (nose up) and roll (right wing down) of the platform, radians.
        ("platform_sigma_m", ctypes.c_float),  # Standard deviation of each coordinate of `platform_m`, metres.
        ("attitude_sigmas_rad", ctypes.c_float * 3),  # Standard deviations of heading, pitch and roll, radians.
    ]

    @staticmethod
    def type_name() -> str:
        return "SensorDetection"


assert ctypes.sizeof(SensorDetection) == 248
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
assert SensorDetection.level_age_ms.offset == 148
assert SensorDetection.identity.offset == 152
assert SensorDetection.identity_ages.offset == 192
assert SensorDetection.level.offset == 204
assert SensorDetection.reserved.offset == 206
assert SensorDetection.platform_velocity_mps.offset == 208
assert SensorDetection.platform_attitude_rad.offset == 220
assert SensorDetection.platform_sigma_m.offset == 232
assert SensorDetection.attitude_sigmas_rad.offset == 236


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


class SensorArrival(ctypes.Structure):
    _fields_ = [
        ("time_of_measurement_ns", ctypes.c_int64),  # Time of the transmission, UTC, nanoseconds since 1970.
        ("sequence", ctypes.c_uint64),  # The arrival's sequence number at its publisher.
        ("stages", StageTimes),  # Stages passed so far.
        ("time_s", ctypes.c_double),  # Arrival by the receiver's clock, seconds since midnight (UTC), or a difference of two arrivals, seconds.
        ("sigma_s", ctypes.c_double),  # Standard deviation of that, seconds.
        ("receiver_m", ctypes.c_double * 3),  # Where the receiver is, metres east, north and up.
        ("receiver_2_m", ctypes.c_double * 3),  # Where the second receiver of a difference is.
        ("reference_m", ctypes.c_double * 3),  # Where the reference emitter is.
        ("receiver", ctypes.c_uint8 * 16),  # Name of the receiver in ASCII, unused bytes 0.
        ("receiver_2", ctypes.c_uint8 * 16),  # Name of the second receiver of a difference.
        ("emitter_id", ctypes.c_uint32),  # Number of the transmitter at its source.
        ("source", ctypes.c_uint16),  # Source: its number in the configuration (TI-2).
        ("valid", ctypes.c_uint16),  # Which fields hold something: see `sensor_arrival_bits`.
    ]

    @staticmethod
    def type_name() -> str:
        return "SensorArrival"


assert ctypes.sizeof(SensorArrival) == 176
assert SensorArrival.time_of_measurement_ns.offset == 0
assert SensorArrival.sequence.offset == 8
assert SensorArrival.stages.offset == 16
assert SensorArrival.time_s.offset == 48
assert SensorArrival.sigma_s.offset == 56
assert SensorArrival.receiver_m.offset == 64
assert SensorArrival.receiver_2_m.offset == 88
assert SensorArrival.reference_m.offset == 112
assert SensorArrival.receiver.offset == 136
assert SensorArrival.receiver_2.offset == 152
assert SensorArrival.emitter_id.offset == 168
assert SensorArrival.source.offset == 172
assert SensorArrival.valid.offset == 174


class SensorFix(ctypes.Structure):
    _fields_ = [
        ("time_of_measurement_ns", ctypes.c_int64),  # Time of the fix, UTC, nanoseconds since 1970.
        ("sequence", ctypes.c_uint64),  # The fix's sequence number at its publisher.
        ("stages", StageTimes),  # Stages passed so far.
        ("position_m", ctypes.c_double * 3),  # Position, metres east, north and up.
        ("covariance_m2", ctypes.c_double * 3),  # Covariance in the plane: east, east with north, north, m².
        ("emitter_id", ctypes.c_uint32),  # Number of the transmitter at its source.
        ("source", ctypes.c_uint16),  # Source: its number in the configuration (TI-2).
        ("reserved", ctypes.c_uint16),  # Reserved, 0.
    ]

    @staticmethod
    def type_name() -> str:
        return "SensorFix"


assert ctypes.sizeof(SensorFix) == 104
assert SensorFix.time_of_measurement_ns.offset == 0
assert SensorFix.sequence.offset == 8
assert SensorFix.stages.offset == 16
assert SensorFix.position_m.offset == 48
assert SensorFix.covariance_m2.offset == 72
assert SensorFix.emitter_id.offset == 96
assert SensorFix.source.offset == 100
assert SensorFix.reserved.offset == 102


class TargetStatement(ctypes.Structure):
    _fields_ = [
        ("time_ns", ctypes.c_int64),  # Time of the target's latest transmission, UTC, nanoseconds since 1970.
        ("sequence", ctypes.c_uint64),  # The sample's sequence number at its publisher.
        ("stages", StageTimes),  # Stages passed so far.
        ("place_deg", ctypes.c_double * 2),  # Latitude and longitude (WGS-84), degrees: of the operator of an unmanned aircraft, or of a station itself.
        ("length_m", ctypes.c_float),  # Length, metres.
        ("width_m", ctypes.c_float),  # Width, metres.
        ("selected_altitude_m", ctypes.c_float),  # Altitude selected in the autopilot, metres of the standard atmosphere.
        ("track_number", ctypes.c_uint32),  # Number of the target's track at its source; of a station, the number of its transponder.
        ("source", ctypes.c_uint16),  # Source: its number in the configuration (TI-2).
        ("category", ctypes.c_uint8),  # Category: a `TargetCategory` code.
        ("navigation", ctypes.c_uint8),  # Navigation status: a `NavigationStatus` code.
        ("emergency", ctypes.c_uint8),  # Emergency: an `Emergency` code.
        ("valid", ctypes.c_uint8),  # Fields that hold something, and flags: see `target_statement_bits`.
        ("aid", ctypes.c_uint8),  # Kind of the aid to navigation: an `AidKind` code.
        ("name", ctypes.c_uint8 * 20),  # Name of a station in ASCII, padded with blanks; blank: none is known.
        ("reserved", ctypes.c_uint8 * 5),  # Reserved, 0.
    ]

    @staticmethod
    def type_name() -> str:
        return "TargetStatement"


assert ctypes.sizeof(TargetStatement) == 112
assert TargetStatement.time_ns.offset == 0
assert TargetStatement.sequence.offset == 8
assert TargetStatement.stages.offset == 16
assert TargetStatement.place_deg.offset == 48
assert TargetStatement.length_m.offset == 64
assert TargetStatement.width_m.offset == 68
assert TargetStatement.selected_altitude_m.offset == 72
assert TargetStatement.track_number.offset == 76
assert TargetStatement.source.offset == 80
assert TargetStatement.category.offset == 82
assert TargetStatement.navigation.offset == 83
assert TargetStatement.emergency.offset == 84
assert TargetStatement.valid.offset == 85
assert TargetStatement.aid.offset == 86
assert TargetStatement.name.offset == 87
assert TargetStatement.reserved.offset == 107


class SensorSpectrum(ctypes.Structure):
    _fields_ = [
        ("time_of_measurement_ns", ctypes.c_int64),  # Time of measurement, UTC, nanoseconds since 1970.
        ("sequence", ctypes.c_uint64),  # The spectrum's sequence number at its publisher.
        ("stages", StageTimes),  # Stages passed so far.
        ("forward_rad", ctypes.c_double),  # Direction of the forward axis, radians clockwise from north; from the bow if the snapshots state no heading.
        ("frequency_hz", ctypes.c_double),  # Frequency of the measurement, hertz.
        ("noise_variance", ctypes.c_double),  # Variance of the noise at one antenna, in squares of the samples' unit.
        ("snapshots", ctypes.c_uint32),  # Number of snapshots of the measurement.
        ("transmitters", ctypes.c_uint32),  # Number of transmitters, as given or estimated.
        ("source", ctypes.c_uint16),  # Source: its number in the configuration (TI-2).
        ("reserved", ctypes.c_uint16 * 7),  # Reserved, 0.
        ("spectrum_db", ctypes.c_float * 360),  # From k to k + 1 degrees clockwise from the forward axis, decibels: 0 where no wave comes from.
    ]

    @staticmethod
    def type_name() -> str:
        return "SensorSpectrum"


assert ctypes.sizeof(SensorSpectrum) == 1536
assert SensorSpectrum.time_of_measurement_ns.offset == 0
assert SensorSpectrum.sequence.offset == 8
assert SensorSpectrum.stages.offset == 16
assert SensorSpectrum.forward_rad.offset == 48
assert SensorSpectrum.frequency_hz.offset == 56
assert SensorSpectrum.noise_variance.offset == 64
assert SensorSpectrum.snapshots.offset == 72
assert SensorSpectrum.transmitters.offset == 76
assert SensorSpectrum.source.offset == 80
assert SensorSpectrum.reserved.offset == 82
assert SensorSpectrum.spectrum_db.offset == 96


class PlatformState(ctypes.Structure):
    _fields_ = [
        ("time_ns", ctypes.c_int64),  # Time at which the platform was there, UTC, nanoseconds since 1970.
        ("sequence", ctypes.c_uint64),  # The state's sequence number at its publisher.
        ("stages", StageTimes),  # Stages passed so far.
        ("position_m", ctypes.c_double * 3),  # Position east, north, up in the system frame, metres; 0 with the bit `NO_POSITION`.
        ("velocity_mps", ctypes.c_double * 3),  # Velocity east, north, up, metres per second.
        ("heading_rad", ctypes.c_double),  # Where its nose points, radians clockwise from the system frame's north.
        ("pitch_rad", ctypes.c_double),  # Nose above the horizon, radians.
        ("roll_rad", ctypes.c_double),  # Right wing below the horizon, radians.
        ("position_sigma_m", ctypes.c_double),  # Standard deviation of each coordinate of the position, metres.
        ("heading_sigma_rad", ctypes.c_double),  # Standard deviation of the heading, radians.
        ("velocity_sigma_mps", ctypes.c_double),  # Standard deviation of each component of the velocity, metres per second.
        ("pitch_sigma_rad", ctypes.c_double),  # Standard deviation of the pitch, radians.
        ("roll_sigma_rad", ctypes.c_double),  # Standard deviation of the roll, radians.
        ("source", ctypes.c_uint16),  # Source of the sensor on the platform: its number in the configuration (TI-2).
        ("valid", ctypes.c_uint16),  # Which fields hold something: see `platform_state_bits`.
        ("reserved", ctypes.c_uint32),  # Reserved, 0.
    ]

    @staticmethod
    def type_name() -> str:
        return "PlatformState"


assert ctypes.sizeof(PlatformState) == 168
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
assert PlatformState.velocity_sigma_mps.offset == 136
assert PlatformState.pitch_sigma_rad.offset == 144
assert PlatformState.roll_sigma_rad.offset == 152
assert PlatformState.source.offset == 160
assert PlatformState.valid.offset == 162
assert PlatformState.reserved.offset == 164


class WideArea(ctypes.Structure):
    _fields_ = [
        ("time_of_observation_ns", ctypes.c_int64),  # Time of observation, UTC, nanoseconds since 1970.
        ("arrival_ns", ctypes.c_int64),  # Time of arrival, UTC, nanoseconds since 1970; it is used from then on.
        ("sequence", ctypes.c_uint64),  # The report's sequence number at its publisher.
        ("stages", StageTimes),  # Stages passed so far.
        ("position_m", ctypes.c_double * 3),  # Middle of the targets at the time of observation, metres east, north and up.
        ("velocity_mps", ctypes.c_double * 3),  # Mean velocity of the targets east, north, up, metres per second.
        ("origin_m", ctypes.c_double * 2),  # Where they came from, metres east and north.
        ("targets", ctypes.c_uint32),  # Number of targets, possibly 0.
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
        ("made_ns", ctypes.c_int64),  # Time of the scan after which it was made, UTC, nanoseconds since 1970.
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


assert ctypes.sizeof(Cue) == 136
assert Cue.time_ns.offset == 0
assert Cue.made_ns.offset == 8
assert Cue.sequence.offset == 16
assert Cue.stages.offset == 24
assert Cue.position_m.offset == 56
assert Cue.velocity_mps.offset == 80
assert Cue.half_axes_m.offset == 104
assert Cue.orientation_rad.offset == 120
assert Cue.track_number.offset == 128
assert Cue.source.offset == 132
assert Cue.reserved.offset == 134


class Contribution(ctypes.Structure):
    _fields_ = [
        ("time_of_measurement_ns", ctypes.c_int64),  # Time of measurement of the source's latest report, UTC, nanoseconds.
        ("weight", ctypes.c_double),  # Coefficient eta in [0, 1]; the weights of one system track sum to 1.
        ("accuracy", ctypes.c_double),  # Accuracy value lambda (TI-9), smaller is better; NaN where the rule has none.
        ("track_number", ctypes.c_uint32),  # Number of the sensor track at its source.
        ("sensor_uid", ctypes.c_uint32),  # Identity of the sensor, the same in every deployment; 0: unknown.
        ("origin", ctypes.c_uint32),  # Original deployment of the sensor track, if another; 0: this deployment.
        ("source", ctypes.c_uint16),  # Source number.
        ("flags", ctypes.c_uint16),  # Flags: see `contribution_bits`.
        ("axis_weights", ctypes.c_float * 3),  # Coefficient eta by axis, east, north, up; their mean is `weight`.
        ("axis_accuracies", ctypes.c_float * 3),  # Accuracy value lambda by axis, east, north, up; 0 where the rule has none for the axis.
    ]

    @staticmethod
    def type_name() -> str:
        return "Contribution"


assert ctypes.sizeof(Contribution) == 64
assert Contribution.time_of_measurement_ns.offset == 0
assert Contribution.weight.offset == 8
assert Contribution.accuracy.offset == 16
assert Contribution.track_number.offset == 24
assert Contribution.sensor_uid.offset == 28
assert Contribution.origin.offset == 32
assert Contribution.source.offset == 36
assert Contribution.flags.offset == 38
assert Contribution.axis_weights.offset == 40
assert Contribution.axis_accuracies.offset == 52


class SystemTrack(ctypes.Structure):
    _fields_ = [
        ("reference_time_ns", ctypes.c_int64),  # Reference time of the state, UTC, nanoseconds since 1970.
        ("time_of_measurement_ns", ctypes.c_int64),  # Time of measurement of the report that caused this state, else the reference time; UTC, nanoseconds.
        ("sequence", ctypes.c_uint64),  # The state's sequence number at its publisher.
        ("epoch", ctypes.c_uint64),  # Start-up number of the fusion that made it, rising with each start; 0: unknown.
        ("stages", StageTimes),  # Stages of the report that caused this state; all but `fused_ns` are 0 if none did.
        ("track_number", ctypes.c_uint32),  # System-track number: not assigned to another target within a day, across all restarts.
        ("origin", ctypes.c_uint32),  # Deployment of the track: `origin` of its configuration; 0: not stated.
        ("owner_track_number", ctypes.c_uint32),  # Number of the track at the deployment that owns the target, where another does; else 0.
        ("merged_into", ctypes.c_uint32),  # Number of the system track into which this track was merged, if merged; else 0.
        ("trigger_source", ctypes.c_uint16),  # Source of the report that caused this state; 65535 if none did (coasting, ending).
        ("selected_source", ctypes.c_uint16),  # Source with the largest weight; 65535 if none contributes.
        ("source_count", ctypes.c_uint16),  # How many sources contribute.
        ("contribution_count", ctypes.c_uint16),  # How many of `contributions` hold something.
        ("state", ctypes.c_uint8),  # State of the track: a `TrackState` code.
        ("height_valid", ctypes.c_uint8),  # 1 if a source observes height; otherwise z has no meaning.
        ("rule", ctypes.c_uint8),  # Fusion rule: a `FusionRule` code; 0: unknown.
        ("alerts", ctypes.c_uint8),  # Alerts of the contributing sources: see `alert_bits`.
        ("on_ground", ctypes.c_uint8),  # 1 if a contributing source reports the target on the ground.
        ("kind", ctypes.c_uint8),  # Kind of the tracked object: a `TrackKind` code.
        ("members", ctypes.c_uint16),  # Expected number of members of a group; 0 for a single target.
        ("identity", Identity),  # Identity of the target, as far as known to its sources.
        ("target_type", TargetType),  # Type of the target.
        ("position_m", ctypes.c_double * 3),  # Position east, north, up, metres.
        ("velocity_mps", ctypes.c_double * 3),  # Velocity east, north, up, metres per second.
        ("movement", Movement),  # Modes of movement and acceleration.
        ("extent", Extent),  # Size of the target.
        ("covariance", Covariance),  # Covariance of position and velocity.
        ("contributions", Contribution * 16),  # Contributing sources in the order of their numbers; the first `contribution_count` are used.
        ("nis", ctypes.c_float),  # Normalised innovation squared (NIS) of the report that caused this state, in the plane; 0 if there was none.
        ("level", ctypes.c_int16),  # Newest level of the target's transponder, in steps of 25 feet at 1013.25 hPa; 0 if there is none.
        ("level_valid", ctypes.c_uint8),  # 1 if `level` is known, and no older than two periods of the source that has it.
        ("velocity_valid", ctypes.c_uint8),  # 1 if the horizontal velocity is known: a source states it, or positions have shown it; else `velocity_mps`
        ("level_age_ms", ctypes.c_uint32),  # Age of `level` at the reference time, milliseconds.
        ("identity_ages", IdentityAges),  # Ages of the values of `identity` at the reference time.
        ("existence", ctypes.c_float),  # Probability that the target exists, in (0, 1]; 0: not estimated.
        ("altitude_m", ctypes.c_float),  # Altitude above mean sea level by `qnh_hpa`, metres, of a target below the transition level.
        ("qnh_hpa", ctypes.c_float),  # Pressure at mean sea level in the target's region, hPa; 0: no altitude, the flight level counts.
        ("pressure_offset_m", ctypes.c_float),  # Height by pressure minus height above the ellipsoid in the region and layer of the target, metres, as
        ("pressure_offset_sigma_m", ctypes.c_float),  # Standard deviation of `pressure_offset_m` for one aircraft, metres; 0: unknown.
        ("climb_rate_mps", ctypes.c_float),  # Rate of climb by the vertical filter, metres per second; 0 if it is unknown.
        ("climb_rate_variance", ctypes.c_float),  # Variance of `climb_rate_mps`, square metres per square second; 0: unknown.
        ("turn_rate_radps", ctypes.c_float),  # Rate of turn, clockwise from above, radians per second.
        ("turn_rate_sigma_radps", ctypes.c_float),  # Standard deviation of `turn_rate_radps`, radians per second; 0: unknown.
        ("mode_probabilities", ctypes.c_float * 8),  # Probabilities of the motion models in the order of `MotionMode`; all 0: not estimated.
        ("updates", ctypes.c_uint32),  # Number of reports in the state since the start of the track.
        ("extrapolations", ctypes.c_uint32),  # Number of published extrapolations since the last report.
        ("held_us", ctypes.c_uint32),  # Wait of the report that caused this state for the end of its scan, microseconds; 0: the report did not wait.
        ("steady_velocity_covariance", ctypes.c_float * 3),  # Covariance of `velocity_mps` in straight flight: xx, xy, yy of the axes east and north, m²/s²; 0: unknown.
        ("steady_climb_variance", ctypes.c_float),  # Variance of the climb rate in `velocity_mps` in level flight or in a constant climb, m²/s²; 0: unknown.
    ]

    @staticmethod
    def type_name() -> str:
        return "SystemTrack"


assert ctypes.sizeof(SystemTrack) == 1552
assert SystemTrack.reference_time_ns.offset == 0
assert SystemTrack.time_of_measurement_ns.offset == 8
assert SystemTrack.sequence.offset == 16
assert SystemTrack.epoch.offset == 24
assert SystemTrack.stages.offset == 32
assert SystemTrack.track_number.offset == 64
assert SystemTrack.origin.offset == 68
assert SystemTrack.owner_track_number.offset == 72
assert SystemTrack.merged_into.offset == 76
assert SystemTrack.trigger_source.offset == 80
assert SystemTrack.selected_source.offset == 82
assert SystemTrack.source_count.offset == 84
assert SystemTrack.contribution_count.offset == 86
assert SystemTrack.state.offset == 88
assert SystemTrack.height_valid.offset == 89
assert SystemTrack.rule.offset == 90
assert SystemTrack.alerts.offset == 91
assert SystemTrack.on_ground.offset == 92
assert SystemTrack.kind.offset == 93
assert SystemTrack.members.offset == 94
assert SystemTrack.identity.offset == 96
assert SystemTrack.target_type.offset == 136
assert SystemTrack.position_m.offset == 152
assert SystemTrack.velocity_mps.offset == 176
assert SystemTrack.movement.offset == 200
assert SystemTrack.extent.offset == 216
assert SystemTrack.covariance.offset == 240
assert SystemTrack.contributions.offset == 408
assert SystemTrack.nis.offset == 1432
assert SystemTrack.level.offset == 1436
assert SystemTrack.level_valid.offset == 1438
assert SystemTrack.velocity_valid.offset == 1439
assert SystemTrack.level_age_ms.offset == 1440
assert SystemTrack.identity_ages.offset == 1444
assert SystemTrack.existence.offset == 1456
assert SystemTrack.altitude_m.offset == 1460
assert SystemTrack.qnh_hpa.offset == 1464
assert SystemTrack.pressure_offset_m.offset == 1468
assert SystemTrack.pressure_offset_sigma_m.offset == 1472
assert SystemTrack.climb_rate_mps.offset == 1476
assert SystemTrack.climb_rate_variance.offset == 1480
assert SystemTrack.turn_rate_radps.offset == 1484
assert SystemTrack.turn_rate_sigma_radps.offset == 1488
assert SystemTrack.mode_probabilities.offset == 1492
assert SystemTrack.updates.offset == 1524
assert SystemTrack.extrapolations.offset == 1528
assert SystemTrack.held_us.offset == 1532
assert SystemTrack.steady_velocity_covariance.offset == 1536
assert SystemTrack.steady_climb_variance.offset == 1548


class Alarm(ctypes.Structure):
    _fields_ = [
        ("time_ns", ctypes.c_int64),  # Time of this statement, UTC, nanoseconds since 1970.
        ("raised_ns", ctypes.c_int64),  # When the alarm was raised, UTC, nanoseconds since 1970.
        ("sequence", ctypes.c_uint64),  # The sample's sequence number at its publisher.
        ("times", ctypes.c_uint32),  # Times that the alarm has been raised since its publisher started.
        ("code", ctypes.c_uint16),  # Code of the alarm; docs/alarms.md lists them.
        ("source", ctypes.c_uint16),  # Source concerned: its number in the configuration; 65535 for none.
        ("partner", ctypes.c_uint16),  # Second source concerned; 65535 for none.
        ("severity", ctypes.c_uint8),  # An `AlarmSeverity` code.
        ("event", ctypes.c_uint8),  # An `AlarmEvent` code.
        ("reserved", ctypes.c_uint32),  # Reserved, 0.
        ("process", ctypes.c_uint8 * 32),  # Name of the process concerned, UTF-8, padded with zeros; empty for none.
        ("text", ctypes.c_uint8 * 312),  # One sentence, UTF-8, padded with zeros.
    ]

    @staticmethod
    def type_name() -> str:
        return "Alarm"


assert ctypes.sizeof(Alarm) == 384
assert Alarm.time_ns.offset == 0
assert Alarm.raised_ns.offset == 8
assert Alarm.sequence.offset == 16
assert Alarm.times.offset == 24
assert Alarm.code.offset == 28
assert Alarm.source.offset == 30
assert Alarm.partner.offset == 32
assert Alarm.severity.offset == 34
assert Alarm.event.offset == 35
assert Alarm.reserved.offset == 36
assert Alarm.process.offset == 40
assert Alarm.text.offset == 72


class Alert(ctypes.Structure):
    _fields_ = [
        ("time_ns", ctypes.c_int64),  # Reference time of the state from which this statement follows, UTC, nanoseconds since 1970.
        ("raised_ns", ctypes.c_int64),  # Reference time of the state that raised the alert, UTC, nanoseconds since 1970.
        ("sequence", ctypes.c_uint64),  # The sample's sequence number at its publisher.
        ("number", ctypes.c_uint64),  # Number of the alert: 1, 2, … in the order of raising, across restarts of the process.
        ("tracks", ctypes.c_uint32 * 2),  # System-track numbers of the target, and of the other target; 0 for none.
        ("probability", ctypes.c_float),  # Probability of the event in [0, 1]; 1 once it has happened.
        ("time_to_s", ctypes.c_float),  # Time until the event, seconds; 0 once it has happened.
        ("distance_m", ctypes.c_float),  # Present horizontal distance from the other target, or from the area's border, metres.
        ("least_distance_m", ctypes.c_float),  # Least horizontal distance ahead, metres.
        ("vertical_m", ctypes.c_float),  # Present difference of height from the other target, metres.
        ("least_vertical_m", ctypes.c_float),  # Difference of height at the least distance, metres.
        ("value", ctypes.c_float),  # What is compared with `limit`: metres per second, metres or seconds by the kind.
        ("limit", ctypes.c_float),  # The limit that `value` has passed.
        ("valid", ctypes.c_uint16),  # Values that are known: see `alert_value_bits`.
        ("kind", ctypes.c_uint8),  # An `AlertKind` code.
        ("event", ctypes.c_uint8),  # An `AlarmEvent` code.
        ("severity", ctypes.c_uint8),  # An `AlarmSeverity` code.
        ("reserved", ctypes.c_uint8 * 3),  # Reserved, 0.
        ("rule", ctypes.c_uint8 * 32),  # Name of the rule, UTF-8, padded with zeros.
        ("area", ctypes.c_uint8 * 32),  # Name of the area, UTF-8, padded with zeros; empty for none.
        ("text", ctypes.c_uint8 * 160),  # One sentence, UTF-8, padded with zeros.
    ]

    @staticmethod
    def type_name() -> str:
        return "Alert"


assert ctypes.sizeof(Alert) == 304
assert Alert.time_ns.offset == 0
assert Alert.raised_ns.offset == 8
assert Alert.sequence.offset == 16
assert Alert.number.offset == 24
assert Alert.tracks.offset == 32
assert Alert.probability.offset == 40
assert Alert.time_to_s.offset == 44
assert Alert.distance_m.offset == 48
assert Alert.least_distance_m.offset == 52
assert Alert.vertical_m.offset == 56
assert Alert.least_vertical_m.offset == 60
assert Alert.value.offset == 64
assert Alert.limit.offset == 68
assert Alert.valid.offset == 72
assert Alert.kind.offset == 74
assert Alert.event.offset == 75
assert Alert.severity.offset == 76
assert Alert.reserved.offset == 77
assert Alert.rule.offset == 80
assert Alert.area.offset == 112
assert Alert.text.offset == 144


class Decision(ctypes.Structure):
    _fields_ = [
        ("time_ns", ctypes.c_int64),  # Time of the data, UTC, nanoseconds since 1970.
        ("sequence", ctypes.c_uint64),  # The sample's sequence number at its publisher.
        ("epoch", ctypes.c_uint64),  # Start of the process that decided, monotonic, nanoseconds: system tracks of the same `epoch` are meant.
        ("value", ctypes.c_double),  # Value that was compared; NaN if nothing was.
        ("limit", ctypes.c_double),  # Limit that the value was compared with; NaN if there was none.
        ("system_track", ctypes.c_uint32),  # System track of the decision; 0 if none.
        ("other_system_track", ctypes.c_uint32),  # The other system track, where there is one; else 0.
        ("sensor_track", ctypes.c_uint32),  # Sensor track of the decision, at its source; 0 if none.
        ("source", ctypes.c_uint16),  # Source of the decision: its number in the configuration; 65535 for none.
        ("other_source", ctypes.c_uint16),  # The other source, if any (at a hand-over the previous source); 65535 for none.
        ("kind", ctypes.c_uint8),  # A `DecisionKind` code.
        ("reserved", ctypes.c_uint8 * 7),  # Reserved, 0.
    ]

    @staticmethod
    def type_name() -> str:
        return "Decision"


assert ctypes.sizeof(Decision) == 64
assert Decision.time_ns.offset == 0
assert Decision.sequence.offset == 8
assert Decision.epoch.offset == 16
assert Decision.value.offset == 24
assert Decision.limit.offset == 32
assert Decision.system_track.offset == 40
assert Decision.other_system_track.offset == 44
assert Decision.sensor_track.offset == 48
assert Decision.source.offset == 52
assert Decision.other_source.offset == 54
assert Decision.kind.offset == 56
assert Decision.reserved.offset == 57


class Registration(ctypes.Structure):
    _fields_ = [
        ("comparisons", ctypes.c_double),  # Comparisons with other sources that the estimates rest on, after forgetting; 0: nothing is known.
        ("offset_m", ctypes.c_double * 3),  # Estimated offset of the reports from the true positions (east, north, up), metres.
        ("offset_sigma_m", ctypes.c_double * 3),  # Standard deviations of the offset, metres.
        ("time_offset_s", ctypes.c_double),  # Estimated time offset, seconds; positive if the reports show where the target was earlier.
        ("time_offset_sigma_s", ctypes.c_double),  # Standard deviation of the time offset, seconds.
        ("range_bias_m", ctypes.c_double),  # Estimated range bias, metres.
        ("range_bias_sigma_m", ctypes.c_double),  # Standard deviation of the range bias, metres.
        ("azimuth_bias_rad", ctypes.c_double),  # Estimated azimuth bias, clockwise, radians.
        ("azimuth_bias_sigma_rad", ctypes.c_double),  # Standard deviation of the azimuth bias, radians.
        ("covariance_inflation", ctypes.c_double),  # Factor of covariance scaling for a source that overstates its accuracy; otherwise 1.
        ("removed", ctypes.c_uint32),  # Which of the errors are being removed from the source's reports: `registration_bits`.
        ("gross", ctypes.c_uint32),  # Gross bias, 0 for none: its kind in the lowest byte, whether it is certain (1), removed (2) and an error
        ("clock_offset_s", ctypes.c_double),  # Offset of the source's clock against times of receipt, seconds; 0 with a standard deviation of 0: unknown.
        ("clock_offset_sigma_s", ctypes.c_double),  # Standard deviation of the clock offset, seconds; 0: unknown.
        ("gross_value", ctypes.c_double * 2),  # Amount of the gross error, in the unit of its kind.
        ("long_sigma_m", ctypes.c_float),  # Standard deviation of the measurements of a smoothed source along the long axis of the error ellipse,
        ("short_sigma_m", ctypes.c_float),  # The same along the short axis, metres.
        ("height_sigma_m", ctypes.c_float),  # The same of the height, metres; 0: not learned.
        ("shape_ratio", ctypes.c_float),  # Standard deviation across the line of sight over that along it, relative to the stated covariances; 0: as
        ("target_share", ctypes.c_float),  # Share of the source's new tracks that turned out to be targets, in (0, 1]; 0: not learned.
        ("lateness_s", ctypes.c_float),  # Delay of the reports, exceeded by one report in ten, seconds.
        ("detection_probability", ctypes.c_float),  # Probability that a scan detects a target that the source tracks, in (0, 1]; 0: not learned.
        ("error_model", ctypes.c_uint32),  # Model of the source's error with the best evidence: an `ErrorModel` code.
        ("dependent_sources", ctypes.c_uint16 * 4),  # Sources with errors that depend on the errors of this source, if `dependence` is not 0.
        ("dependence", ctypes.c_float * 4),  # Correlation of the errors of this source and of `dependent_sources`, in (0, 1]; 0: none.
        ("stamp_step_s", ctypes.c_float),  # Step of which all time stamps of the source are multiples, if it enters the states, seconds; 0: the stamps
        ("stamp_sigma_s", ctypes.c_float),  # Standard deviation of the time offset that the step implies, seconds.
    ]

    @staticmethod
    def type_name() -> str:
        return "Registration"


assert ctypes.sizeof(Registration) == 216
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
assert Registration.gross.offset == 116
assert Registration.clock_offset_s.offset == 120
assert Registration.clock_offset_sigma_s.offset == 128
assert Registration.gross_value.offset == 136
assert Registration.long_sigma_m.offset == 152
assert Registration.short_sigma_m.offset == 156
assert Registration.height_sigma_m.offset == 160
assert Registration.shape_ratio.offset == 164
assert Registration.target_share.offset == 168
assert Registration.lateness_s.offset == 172
assert Registration.detection_probability.offset == 176
assert Registration.error_model.offset == 180
assert Registration.dependent_sources.offset == 184
assert Registration.dependence.offset == 192
assert Registration.stamp_step_s.offset == 208
assert Registration.stamp_sigma_s.offset == 212


class Counters(ctypes.Structure):
    _fields_ = [
        ("values", ctypes.c_uint64 * 160),  # Counts since the process started, indexed by the codes of `Counter`; a few are levels.
    ]

    @staticmethod
    def type_name() -> str:
        return "Counters"


assert ctypes.sizeof(Counters) == 1280
assert Counters.values.offset == 0


class Health(ctypes.Structure):
    _fields_ = [
        ("said_ns", ctypes.c_int64),  # Time of this message, monotonic, nanoseconds.
        ("incarnation", ctypes.c_uint64),  # Monotonic start time of the process, nanoseconds.
        ("progress_ns", ctypes.c_int64),  # How far the process has got in the time of its data, UTC, nanoseconds; i64::MIN if unknown.
        ("process_id", ctypes.c_uint32),  # Operating system's process number.
        ("source", ctypes.c_uint16),  # Source of the counters; 65535 for the process as a whole.
        ("kind", ctypes.c_uint8),  # Kind of the process: a `ProcessKind` code.
        ("life", ctypes.c_uint8),  # A `LifeState` code.
        ("restarts", ctypes.c_uint32),  # Restarts of the process so far, as its launcher counts them.
        ("misfit", ctypes.c_uint8 * 4),  # Input outside an adapter's configuration. Of the process: SAC and SIC of the unknown sender with the most
        ("name", ctypes.c_uint8 * 32),  # Name of the process, UTF-8, padded with zeros.
        ("note", ctypes.c_uint8 * 56),  # Fault in a few words, empty if there is none; of an adapter's source its name. UTF-8, padded with zeros.
        ("refusal", ctypes.c_uint8 * 256),  # Input that was refused last, one text for each reason, the latest first: time of day (UTC), line or item,
        ("counters", Counters),  # Values of the counters.
        ("registration", Registration),  # Biases of the source, if estimated by fusion.
    ]

    @staticmethod
    def type_name() -> str:
        return "Health"


assert ctypes.sizeof(Health) == 1880
assert Health.said_ns.offset == 0
assert Health.incarnation.offset == 8
assert Health.progress_ns.offset == 16
assert Health.process_id.offset == 24
assert Health.source.offset == 28
assert Health.kind.offset == 30
assert Health.life.offset == 31
assert Health.restarts.offset == 32
assert Health.misfit.offset == 36
assert Health.name.offset == 40
assert Health.note.offset == 72
assert Health.refusal.offset == 128
assert Health.counters.offset == 384
assert Health.registration.offset == 1664


class Progress(ctypes.Structure):
    _fields_ = [
        ("consumer_incarnation", ctypes.c_uint64),  # Monotonic start time of the consumer, nanoseconds: a restart shows as a new value.
        ("publisher_incarnation", ctypes.c_uint64),  # Monotonic start time of the publisher whose samples are counted.
        ("done_sequence", ctypes.c_uint64),  # Samples of that source worked off: all with a sequence number below this.
        ("done_batches", ctypes.c_uint64),  # Slices of that publisher taken since the consumer joined.
        ("progress_ns", ctypes.c_int64),  # How far the consumer has got in the time of the data, UTC, nanoseconds; i64::MIN if unknown.
        ("number", ctypes.c_uint16),  # Number of the source, or of the wide-area sensor; 0 for the system tracks.
        ("stream", ctypes.c_uint8),  # Kind of topic: a `Stream` code.
        ("consumer", ctypes.c_uint8),  # Kind of the consumer: a `ProcessKind` code.
        ("reserved", ctypes.c_uint32),  # Reserved, 0.
        ("said_ns", ctypes.c_int64),  # Monotonic time of this statement, nanoseconds.
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
assert Progress.number.offset == 40
assert Progress.stream.offset == 42
assert Progress.consumer.offset == 43
assert Progress.reserved.offset == 44
assert Progress.said_ns.offset == 48


class Order(ctypes.Structure):
    _fields_ = [
        ("token", ctypes.c_uint64),  # Number chosen by the sender, not 0: a repeated order with the same token has no further effect.
        ("sent_ns", ctypes.c_int64),  # Time of sending, UTC, nanoseconds since 1970.
        ("ends_ns", ctypes.c_int64),  # Time at which the order expires, UTC, nanoseconds since 1970; i64::MAX: never. In the event log and in
        ("value", ctypes.c_double),  # Number that the kind needs; NaN: none.
        ("track", ctypes.c_uint32),  # Number of a system track; 0: none.
        ("other_track", ctypes.c_uint32),  # Number of a second system track, or of a sensor track at its source; 4294967295: none.
        ("number", ctypes.c_uint32),  # Number of another order; 0: none.
        ("kind", ctypes.c_uint16),  # Kind of order: an `OrderKind` code.
        ("source", ctypes.c_uint16),  # Source: its number in the configuration; 65535: none, or all.
        ("other_source", ctypes.c_uint16),  # Second source; 65535: none, or any.
        ("reserved", ctypes.c_uint8 * 6),  # Reserved, 0.
        ("name", ctypes.c_uint8 * 32),  # Word that the kind needs, UTF-8, padded with zeros.
        ("operator_name", ctypes.c_uint8 * 32),  # Name of the operator, UTF-8, padded with zeros.
    ]

    @staticmethod
    def type_name() -> str:
        return "Order"


assert ctypes.sizeof(Order) == 120
assert Order.token.offset == 0
assert Order.sent_ns.offset == 8
assert Order.ends_ns.offset == 16
assert Order.value.offset == 24
assert Order.track.offset == 32
assert Order.other_track.offset == 36
assert Order.number.offset == 40
assert Order.kind.offset == 44
assert Order.source.offset == 46
assert Order.other_source.offset == 48
assert Order.reserved.offset == 50
assert Order.name.offset == 56
assert Order.operator_name.offset == 88


class OrderState(ctypes.Structure):
    _fields_ = [
        ("order", Order),  # The order.
        ("changed_ns", ctypes.c_int64),  # Time of the latest change of state, on the engine's clock, nanoseconds since 1970.
        ("time_ns", ctypes.c_int64),  # Time of publication, UTC, nanoseconds since 1970.
        ("sequence", ctypes.c_uint64),  # Sequence number at its publisher.
        ("number", ctypes.c_uint32),  # Number given by fusion, ascending; 0: refused before fusion.
        ("status", ctypes.c_uint8),  # State: an `OrderStatus` code.
        ("refusal", ctypes.c_uint8),  # Reason of a refusal: a `Refusal` code; 0: none.
        ("has_changed", ctypes.c_uint8),  # 1: the state has changed since the previous slice; 0: it is repeated.
        ("reserved", ctypes.c_uint8),  # Reserved, 0.
        ("text", ctypes.c_uint8 * 168),  # The state in one sentence, UTF-8, padded with zeros.
    ]

    @staticmethod
    def type_name() -> str:
        return "OrderState"


assert ctypes.sizeof(OrderState) == 320
assert OrderState.order.offset == 0
assert OrderState.changed_ns.offset == 120
assert OrderState.time_ns.offset == 128
assert OrderState.sequence.offset == 136
assert OrderState.number.offset == 144
assert OrderState.status.offset == 148
assert OrderState.refusal.offset == 149
assert OrderState.has_changed.offset == 150
assert OrderState.reserved.offset == 151
assert OrderState.text.offset == 152


class FrameOrigin(ctypes.Structure):
    _fields_ = [
        ("latitude_deg", ctypes.c_double),  # Latitude on the WGS-84 ellipsoid, degrees, north positive.
        ("longitude_deg", ctypes.c_double),  # Longitude, degrees, east positive.
        ("height_m", ctypes.c_double),  # Height above the ellipsoid, metres.
    ]

    @staticmethod
    def type_name() -> str:
        return "FrameOrigin"


assert ctypes.sizeof(FrameOrigin) == 24
assert FrameOrigin.latitude_deg.offset == 0
assert FrameOrigin.longitude_deg.offset == 8
assert FrameOrigin.height_m.offset == 16


class WorkStep(ctypes.Structure):
    _fields_ = [
        ("time_ns", ctypes.c_int64),  # Engine's time up to which time has passed with this step, nanoseconds; i64::MIN: unknown. Other meanings:
        ("sequence", ctypes.c_uint32),  # Number of the report, modulo 2^32: its index among the samples of its publisher; in order `time` its own
        ("source", ctypes.c_uint16),  # Number of the source; 65535 if the step is of none.
        ("kind", ctypes.c_uint8),  # Kind of step: a `StepKind` code.
        ("flags", ctypes.c_uint8),  # Flags: see `work_step_bits`.
    ]

    @staticmethod
    def type_name() -> str:
        return "WorkStep"


assert ctypes.sizeof(WorkStep) == 16
assert WorkStep.time_ns.offset == 0
assert WorkStep.sequence.offset == 8
assert WorkStep.source.offset == 12
assert WorkStep.kind.offset == 14
assert WorkStep.flags.offset == 15


class Restored(ctypes.Structure):
    _fields_ = [
        ("epoch", ctypes.c_uint64),  # Start-up number of the fusion.
        ("time_ns", ctypes.c_int64),  # UTC at the start, or at which the image was made, nanoseconds since 1970.
        ("part", ctypes.c_uint32),  # Place of this part among all, from 0.
        ("parts", ctypes.c_uint32),  # Number of parts.
        ("count", ctypes.c_uint32),  # How many of `words` hold something.
        ("ends", ctypes.c_uint32),  # 1 if the tracks were too old to continue, and each is reported as terminated; 2 for a snapshot.
        ("sequence", ctypes.c_uint64),  # Sequence number at its publisher.
        ("words", ctypes.c_uint64 * 120),  # Words of a `fusion::checkpoint::Snapshot`, after those of the parts before; of an image the number of the
    ]

    @staticmethod
    def type_name() -> str:
        return "Restored"


assert ctypes.sizeof(Restored) == 1000
assert Restored.epoch.offset == 0
assert Restored.time_ns.offset == 8
assert Restored.part.offset == 16
assert Restored.parts.offset == 20
assert Restored.count.offset == 24
assert Restored.ends.offset == 28
assert Restored.sequence.offset == 32
assert Restored.words.offset == 40

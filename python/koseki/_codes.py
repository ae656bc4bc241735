"""Codes and bits of the samples, as enumerations.

Written by `cargo run -p koseki-messages --example layouts`; a test keeps the file true.
"""

from __future__ import annotations

import enum


class IdentityBits(enum.IntFlag):
    """MODE_3A: `mode_3a` holds a Mode 3/A code.
    CALLSIGN: `callsign` holds a callsign.
    NAME: `name` holds a name."""

    MODE_3A = 1
    CALLSIGN = 2
    NAME = 4


class MovementBits(enum.IntFlag):
    """ACCELERATION: `acceleration_mps2` is known east and north.
    VERTICAL_ACCELERATION: `acceleration_mps2` is known upwards."""

    ACCELERATION = 1
    VERTICAL_ACCELERATION = 2


class SensorTrackBits(enum.IntFlag):
    """HEIGHT: Height (`position[2]`) was observed; otherwise z is 0 and its variance has no meaning.
    VELOCITY: Horizontal velocity was delivered or derived.
    VERTICAL_RATE: Vertical velocity was delivered or derived.
    OWN_COVARIANCE: The covariance is the source's own statement; otherwise it is derived from configured accuracies.
    MEASURED: `measured_m` holds the measurement from which the source updated its track.
    ON_GROUND: The source reports that the target is on the ground.
    DERIVED_VELOCITY: The velocity was derived by the adapter from successive positions.
    TRACE: `trace` holds the source's own covariance trace (TI-16).
    WILD_CLOCK: The time of measurement is not believed: it lies far from that of receipt, or the source's clock jumps.
    CONTRIBUTORS: `shared_sources` is known: the track is a system track of another centre, which names its sensors.
    LEVEL: `level` holds the level of the target's transponder.
    TURN_RATE: `turn_rate_radps` is known.
    PRESSURE_OFFSET: `pressure_offset_m` is known: the report states its height in both ways.
    PLATFORM: The sensors move: `measured_m` is the platform's place (east, north) and heading, no measurement."""

    HEIGHT = 1
    VELOCITY = 2
    VERTICAL_RATE = 4
    OWN_COVARIANCE = 8
    MEASURED = 16
    ON_GROUND = 32
    DERIVED_VELOCITY = 64
    TRACE = 128
    WILD_CLOCK = 256
    CONTRIBUTORS = 512
    LEVEL = 1024
    TURN_RATE = 2048
    PRESSURE_OFFSET = 4096
    PLATFORM = 8192


class SensorDetectionBits(enum.IntFlag):
    """RANGE_RATE: `range_rate_mps` was measured.
    SIGMAS: `sigmas` hold standard deviations.
    LEVEL: `level` holds the level of the target's transponder.
    PLATFORM_VELOCITY: `platform_velocity_mps` is known.
    PLATFORM_ATTITUDE: `platform_attitude_rad` and `attitude_sigmas_rad` are known.
    PLATFORM_SIGMA: `platform_sigma_m` is known.
    MARK: The sample is no detection but a mark of the sensor's time: `kind` holds a `DetectionMark` code.
    TARGET_VELOCITY: Of a designation: `platform_velocity_mps` is the velocity of the target east and north, and the last of"""

    RANGE_RATE = 1
    SIGMAS = 2
    LEVEL = 4
    PLATFORM_VELOCITY = 8
    PLATFORM_ATTITUDE = 16
    PLATFORM_SIGMA = 32
    MARK = 64
    TARGET_VELOCITY = 128


class SensorBearingBits(enum.IntFlag):
    """EMITTER: `emitter_id` is known: the sensor distinguishes transmitters.
    HEADING: `heading_rad` is known.
    FREQUENCY: `frequency_hz` was measured.
    PULSE_INTERVAL: `pulse_interval_s` was measured."""

    EMITTER = 1
    HEADING = 2
    FREQUENCY = 4
    PULSE_INTERVAL = 8


class SensorArrivalBits(enum.IntFlag):
    """DIFFERENCE: `time_s` is a difference: arrival at the receiver minus arrival at the second one.
    REFERENCE: `reference_m` is known: the transmission is of a reference emitter."""

    DIFFERENCE = 1
    REFERENCE = 2


class PlatformStateBits(enum.IntFlag):
    """VELOCITY: `velocity_mps` is known.
    HEADING: `heading_rad` is known.
    ATTITUDE: `pitch_rad` and `roll_rad` are known.
    POSITION_SIGMA: `position_sigma_m` is known.
    HEADING_SIGMA: `heading_sigma_rad` is known.
    VELOCITY_SIGMA: `velocity_sigma_mps` is known.
    ATTITUDE_SIGMA: `pitch_sigma_rad` and `roll_sigma_rad` are known.
    NO_POSITION: `position_m` is not known: a state of attitude or velocity alone."""

    VELOCITY = 1
    HEADING = 2
    ATTITUDE = 4
    POSITION_SIGMA = 8
    HEADING_SIGMA = 16
    VELOCITY_SIGMA = 32
    ATTITUDE_SIGMA = 64
    NO_POSITION = 128


class WideAreaBits(enum.IntFlag):
    """ORIGIN: `origin_m` is known."""

    ORIGIN = 1


class ContributionBits(enum.IntFlag):
    """FRESH: The source's latest report is within its expected period.
    SCORED: The accuracy value exists: the source has delivered more than one report.
    CENTRE: The contribution is a system track of another centre. If not fresh, it is listed for a while without"""

    FRESH = 1
    SCORED = 2
    CENTRE = 4


class AlertBits(enum.IntFlag):
    """SPECIAL_IDENTIFICATION: Special position identification: the pilot has pressed the button.
    EMERGENCY: An emergency of any kind; Mode 3/A code 7700.
    COMMUNICATION_FAILURE: Radio communication has failed; code 7600.
    UNLAWFUL_INTERFERENCE: Unlawful interference; code 7500.
    MEDICAL: Medical flight.
    MINIMUM_FUEL: Minimum fuel.
    TRANSPONDER_ALERT: The Mode 3/A code was changed lately, or the transponder raises its alert for another reason.
    RESOLUTION_ADVISORY: A collision avoidance system advises the crew to manoeuvre."""

    SPECIAL_IDENTIFICATION = 1
    EMERGENCY = 2
    COMMUNICATION_FAILURE = 4
    UNLAWFUL_INTERFERENCE = 8
    MEDICAL = 16
    MINIMUM_FUEL = 32
    TRANSPONDER_ALERT = 64
    RESOLUTION_ADVISORY = 128


class AlertValueBits(enum.IntFlag):
    """PREDICTED: `time_to_s` and `probability` are of the future: the event has not happened yet.
    DISTANCE: `distance_m` and `least_distance_m` hold distances.
    VERTICAL: `vertical_m` and `least_vertical_m` hold differences of height.
    VALUE: `value` and `limit` hold what is compared: metres per second, metres or seconds by the kind.
    ACKNOWLEDGED: An operator has acknowledged the alert."""

    PREDICTED = 1
    DISTANCE = 2
    VERTICAL = 4
    VALUE = 8
    ACKNOWLEDGED = 16


class RegistrationBits(enum.IntFlag):
    """EAST: The offset east is being removed from the source's reports.
    NORTH: The offset north is.
    UP: The offset up is.
    TIME: The time offset is.
    RANGE: The range bias is.
    AZIMUTH: The azimuth bias is."""

    EAST = 1
    NORTH = 2
    UP = 4
    TIME = 8
    RANGE = 16
    AZIMUTH = 32


class WorkStepBits(enum.IntFlag):
    """WILD_CLOCK: Fusion did not believe the time of the report."""

    WILD_CLOCK = 1


class TargetStatementBits(enum.IntFlag):
    """SIZE: `length_m` and `width_m` hold a size.
    SELECTED_ALTITUDE: `selected_altitude_m` holds an altitude.
    OPERATOR: `place_deg` holds the place of the operator of an unmanned aircraft.
    STATION: The sample is of a station that is no target: `place_deg` holds its own place, `name` its name.
    VIRTUAL: The aid to navigation is not there: a station ashore sends for it.
    OFF_POSITION: The aid to navigation, which floats, is off its position."""

    SIZE = 1
    SELECTED_ALTITUDE = 2
    OPERATOR = 4
    STATION = 8
    VIRTUAL = 16
    OFF_POSITION = 32


class TrackState(enum.IntEnum):
    """TENTATIVE: Seen, not yet believed.
    CONFIRMED: Believed, and supported by recent reports.
    COASTED: Believed, but carried on by extrapolation for want of reports.
    TERMINATED: Ended; the number is not used again soon.
    SUSPENDED: No longer reported by any source: not shown, while the number rests and may resume."""

    TENTATIVE = 0
    CONFIRMED = 1
    COASTED = 2
    TERMINATED = 3
    SUSPENDED = 4


class TrackKind(enum.IntEnum):
    """SINGLE: One target.
    GROUP: Several unresolved targets (WA-7)."""

    SINGLE = 0
    GROUP = 1


class MotionMode(enum.IntEnum):
    """STEADY: Constant velocity in the plane.
    AGILE: Nearly constant velocity in the plane with strong process noise.
    LEFT_TURN: Coordinated turn to the left.
    RIGHT_TURN: Coordinated turn to the right.
    SPEED_CHANGE: Change of speed along the course.
    LEVEL: Constant height.
    CLIMB: Constant climb rate.
    CLIMB_CHANGE: Change of the climb rate."""

    STEADY = 0
    AGILE = 1
    LEFT_TURN = 2
    RIGHT_TURN = 3
    SPEED_CHANGE = 4
    LEVEL = 5
    CLIMB = 6
    CLIMB_CHANGE = 7


class ErrorModel(enum.IntEnum):
    """UNDECIDED: No model has sufficient evidence.
    OFFSET: Constant offset in the system frame.
    BODY: Offset fixed to the target's body: a reference point other than that of other sources.
    POLAR: Offset that grows with range or azimuth.
    TIME: Time offset."""

    UNDECIDED = 0
    OFFSET = 1
    BODY = 2
    POLAR = 3
    TIME = 4


class FusionRule(enum.IntEnum):
    """AUTO: Filter of the target, with learned accuracies of the sources.
    SYSTEM_FILTER: Filter of the target's own.
    BEST_SOURCE: Source with the smallest accuracy value.
    INVERSE_TRACE: Weights inverse to the covariance traces.
    QUALITY_FACTOR: Weights by quality index.
    MOSAIC: Source that the cell of a mosaic names.
    INFORMATION: Information sum of independent errors.
    COVARIANCE_INTERSECTION: Covariance intersection: bound for unknown correlations.
    BAR_SHALOM_CAMPO: Bar-Shalom and Campo's combination of correlated errors."""

    AUTO = 1
    SYSTEM_FILTER = 2
    BEST_SOURCE = 3
    INVERSE_TRACE = 4
    QUALITY_FACTOR = 5
    MOSAIC = 6
    INFORMATION = 7
    COVARIANCE_INTERSECTION = 8
    BAR_SHALOM_CAMPO = 9


class IdentityKind(enum.IntEnum):
    """NONE: No number is known.
    AIRCRAFT: 24-bit aircraft address.
    SHIP: 30-bit Maritime Mobile Service Identity (MMSI)."""

    NONE = 0
    AIRCRAFT = 1
    SHIP = 2


class HorizontalMovement(enum.IntEnum):
    """UNKNOWN: Not known.
    STRAIGHT: Constant course.
    TURN_LEFT: Turn to the left.
    TURN_RIGHT: Turn to the right."""

    UNKNOWN = 0
    STRAIGHT = 1
    TURN_LEFT = 2
    TURN_RIGHT = 3


class VerticalMovement(enum.IntEnum):
    """UNKNOWN: Not known.
    LEVEL: Constant height.
    CLIMB: Climb.
    DESCEND: Descent."""

    UNKNOWN = 0
    LEVEL = 1
    CLIMB = 2
    DESCEND = 3


class LongitudinalMovement(enum.IntEnum):
    """UNKNOWN: Not known.
    CONSTANT: Constant speed over ground.
    INCREASING: Increasing speed over ground.
    DECREASING: Decreasing speed over ground."""

    UNKNOWN = 0
    CONSTANT = 1
    INCREASING = 2
    DECREASING = 3


class DetectionKind(enum.IntEnum):
    """POSITION2: East and north in the system frame.
    POSITION3: East, north and up in the system frame.
    RANGE_BEARING: Slant range and bearing from the sensor.
    RANGE_BEARING_ELEVATION: Slant range, bearing and elevation from the sensor.
    BEARING: Bearing from the sensor.
    BEARING_ELEVATION: Bearing and elevation from the sensor."""

    POSITION2 = 0
    POSITION3 = 1
    RANGE_BEARING = 2
    RANGE_BEARING_ELEVATION = 3
    BEARING = 4
    BEARING_ELEVATION = 5


class DetectionMark(enum.IntEnum):
    """PASSED: The sensor's time has come to the time of measurement.
    EMPTY_SCAN: The scan `scan` at the time of measurement has no detections.
    TURN_BEGINS: A turn of the sensor begins at the time of measurement.
    UNPLACED: A detection at the time of measurement was refused: no state of the sensor's platform belongs to its time."""

    PASSED = 0
    EMPTY_SCAN = 1
    TURN_BEGINS = 2
    UNPLACED = 3


class Stream(enum.IntEnum):
    """SENSOR_TRACKS: Sensor tracks of a source.
    DETECTIONS: Detections of a source.
    BEARINGS: Bearings of a source.
    PLATFORM_STATES: States of the platform that carries a source's sensor.
    CUES: Cues for the sensor of a source.
    WIDE_AREA: Reports of a wide-area sensor.
    SYSTEM_TRACKS: System tracks.
    ALARMS: Alarms.
    DECISIONS: Decisions of fusion.
    ORDERS: States of orders.
    ARRIVALS: Arrival times of a source.
    FIXES: Ready-made fixes of a source.
    STATEMENTS: What the targets of a source state beside their motion.
    ALERTS: Alerts on targets."""

    SENSOR_TRACKS = 1
    DETECTIONS = 2
    BEARINGS = 3
    PLATFORM_STATES = 4
    CUES = 5
    WIDE_AREA = 6
    SYSTEM_TRACKS = 7
    ALARMS = 8
    DECISIONS = 9
    ORDERS = 10
    ARRIVALS = 11
    FIXES = 12
    STATEMENTS = 13
    ALERTS = 14


class StepKind(enum.IntEnum):
    """BEGIN: Fusion starts from its configuration: `time_ns` is its epoch.
    REPORT: The report of `source` with the number `sequence` is worked off, and time has passed up to `time_ns`.
    PUBLISHER: The next reports of `source` come from the publisher with the incarnation `time_ns`.
    TIME: Time has passed up to `time_ns` without a report.
    CONDITION: Condition (weather) number `sequence` holds from now on, when time has passed up to `time_ns`. Written by
    RESTORED: Fusion resumes from the data on `system/restored` for its epoch; tracks listed there are reported as
    NUMBERS: Numbers of system tracks begin at `sequence`, because the numbers assigned before are unknown.
    IMAGE: A snapshot of the engine's present state is published on `system/restored`, with the time `time_ns`.
    HOST_OFFSET: The sources' time is ahead of the engine's by `time_ns` (nanoseconds) from now on: the host offset.
    SOURCE_CLOCK: The clock of `source` is off by `sequence` milliseconds (as a signed number), as times of receipt show it.
    QUARANTINE: The report of `source` with the number `sequence` is in quarantine and has no effect: fusion has died in the
    ORDER_PART: Bytes 8·`sequence` to 8·`sequence` + 7 of the order that the next step of kind `Order` completes are
    ORDER: The order of the preceding parts has its effect now, when time has passed up to `time_ns`."""

    BEGIN = 1
    REPORT = 2
    PUBLISHER = 3
    TIME = 4
    CONDITION = 5
    RESTORED = 6
    NUMBERS = 7
    IMAGE = 8
    HOST_OFFSET = 9
    SOURCE_CLOCK = 10
    QUARANTINE = 11
    ORDER_PART = 12
    ORDER = 13


class ProcessKind(enum.IntEnum):
    """ADAPTER: Turns one sensor's data into sensor tracks.
    FUSION: Fuses sensor tracks into system tracks.
    MONITOR: Records latencies and counters.
    RECORDER: Writes tracks to files.
    LAUNCHER: Starts and watches the others.
    SIMULATOR: Sends the observations of simulated sensors over the network.
    GATEWAY: Sends tracks to other systems over the network.
    KEEPER: Holds the topics for the launcher, which maps no shared memory itself.
    DISPLAY: Shows the picture in browsers.
    LINK: Exchanges topics with deployments on other hosts.
    ALERTS: Finds events and dangers about targets."""

    ADAPTER = 0
    FUSION = 1
    MONITOR = 2
    RECORDER = 3
    LAUNCHER = 4
    SIMULATOR = 5
    GATEWAY = 6
    KEEPER = 7
    DISPLAY = 8
    LINK = 9
    ALERTS = 10


class LifeState(enum.IntEnum):
    """STARTING: Opening its topics.
    RUNNING: Doing its work.
    FINISHED: Done: all its input is processed, and it will exit.
    FAILED: Unable to continue; the note states the reason."""

    STARTING = 0
    RUNNING = 1
    FINISHED = 2
    FAILED = 3


class AlarmSeverity(enum.IntEnum):
    """WARNING: Nothing is wrong yet; it may become so.
    MAJOR: Part of the picture is missing or wrong.
    CRITICAL: The picture as a whole is not to be relied on."""

    WARNING = 1
    MAJOR = 2
    CRITICAL = 3


class AlarmEvent(enum.IntEnum):
    """RAISED: The alarm has just been raised.
    STANDING: The alarm was raised before, and stands.
    CLEARED: The alarm has just been cleared."""

    RAISED = 1
    STANDING = 2
    CLEARED = 3


class AlertKind(enum.IntEnum):
    """ENTER: A target is in an area, or will be.
    LEAVE: A target has left an area, or will leave it.
    STAY: A target has been in an area for too long.
    CONFLICT: Two aircraft come nearer to each other than both minima.
    APPROACH: Two vessels come close to each other.
    LOW: A target is below a least height, or will be.
    SPEED: A target is too fast or too slow.
    LEVEL: A target is outside of a band of heights.
    LOST: A target is no longer reported.
    EMERGENCY: A target states an emergency."""

    ENTER = 1
    LEAVE = 2
    STAY = 3
    CONFLICT = 4
    APPROACH = 5
    LOW = 6
    SPEED = 7
    LEVEL = 8
    LOST = 9
    EMERGENCY = 10


class DecisionKind(enum.IntEnum):
    """STARTED: A system track was started for a sensor track that fits none.
    JOINED: A sensor track joined a system track it fits: value d², limit the gate.
    JOINED_BY_ADDRESS: A sensor track joined the system track of its address.
    DUPLICATE: A sensor track was recognised as another part of a target that its source already follows: value metres.
    IDENTITY_CONFLICT: A sensor track left because its address contradicts the system track's.
    SPLIT: A sensor track left because it kept missing the others: value d², limit the gate.
    MERGED: A system track was found to be the same target as another, and merged into it: value d², limit the gate.
    CONFIRMED: A system track was confirmed: value the number of sources, or the log-likelihood ratio of a single
    WITHHELD: A system track is withheld: its sources report that they no longer detect the target. Value the sum of the
    COASTED: Nothing fresh contributes any more.
    ENDED: A system track has ended.
    HAND_OVER: The selected source has changed: value the new source's accuracy value, limit the previous source's.
    REFERENCE_POINT: The target's reference point is now that of this source.
    UNCROSSED: A sensor track has changed places with another track of its source: value the sum of log-likelihood
    ORDERED: An order of an operator has changed a system track: value the number of the order.
    ORDER_ENDED: An order on system tracks has ended, because the tracks are farther apart than permitted: value the
    SUSPENDED: A system track that was shown is no longer reported: its number rests.
    RESUMED: A target has come back under its former number: value the logarithm of the likelihood ratio of the same"""

    STARTED = 1
    JOINED = 2
    JOINED_BY_ADDRESS = 3
    DUPLICATE = 4
    IDENTITY_CONFLICT = 5
    SPLIT = 6
    MERGED = 7
    CONFIRMED = 8
    WITHHELD = 9
    COASTED = 10
    ENDED = 11
    HAND_OVER = 12
    REFERENCE_POINT = 13
    UNCROSSED = 14
    ORDERED = 15
    ORDER_ENDED = 16
    SUSPENDED = 17
    RESUMED = 18


class OrderKind(enum.IntEnum):
    """CONDITION: A weather condition holds for the accuracy of a source, or of all sources (TI-7).
    SNAPSHOT: Fusion publishes a snapshot of the engine, for a recorder.
    OUT: The reports of a source are counted and not used.
    IN: The reports of a source that is out are used again.
    ETA: First weight eta_0 of a hand-over to a source, from another source or from any (TI-13).
    K: Adjustment coefficient k of a source: smaller values are preferred (TI-8).
    RULE: A rule weighs the sources of all system tracks.
    DROP: A system track ends, and its sensor tracks start no other.
    JOIN: Two system tracks are one target: the older number remains.
    SPLIT: A sensor track leaves its system track and gets a system track of its own.
    RENUMBER: A system track gets a new number, and the old number ends.
    RESET: Everything learned of a source is forgotten: errors, accuracy, detection probability, dependence.
    CANCEL: An order in force ends.
    QNH: The pressure at mean sea level in a region, hPa, by the name of its `[[qnh]]`.
    DESIGNATE: A tracker follows the target at a place of this standard deviation, metres."""

    CONDITION = 1
    SNAPSHOT = 2
    OUT = 3
    IN = 4
    ETA = 5
    K = 6
    RULE = 7
    DROP = 8
    JOIN = 9
    SPLIT = 10
    RENUMBER = 11
    RESET = 12
    CANCEL = 13
    QNH = 14
    DESIGNATE = 15


class OrderStatus(enum.IntEnum):
    """IN_FORCE: The order has an effect that lasts.
    DONE: The effect has taken place, and nothing of it lasts.
    CANCELLED: Another order has cancelled this order.
    EXPIRED: The time of the order is over.
    REPLACED: A newer order of this kind holds for the same subject.
    ENDED: The tracks no longer permit the effect: a track has ended, or the distance exceeded its limit.
    REFUSED: The order has no effect: see `refusal`."""

    IN_FORCE = 1
    DONE = 2
    CANCELLED = 3
    EXPIRED = 4
    REPLACED = 5
    ENDED = 6
    REFUSED = 7


class Refusal(enum.IntEnum):
    """UNKNOWN_KIND: No such kind.
    MALFORMED: A text is not UTF-8, the token is 0, or the expiry lies before 1970.
    MISSING_PARAMETER: A parameter of the kind is missing.
    FOREIGN_PARAMETER: A parameter does not belong to the kind.
    OUT_OF_RANGE: The value lies outside its range.
    EXPIRED: The order was sent too long ago, or its expiry has passed.
    TOO_MANY: Too many orders in a short time.
    TABLE_FULL: The table of orders in force is full.
    UNKNOWN_SOURCE: No such source.
    UNKNOWN_CONDITION: No source states a factor for the condition.
    UNKNOWN_RULE: No such rule.
    RULE_WITHOUT_REPORTS: The rule needs stored reports, which this deployment does not keep.
    UNKNOWN_TRACK: No system track with this number is alive.
    SAME_TRACK: Both parameters name the same system track.
    TWO_ADDRESSES: The two system tracks have different addresses.
    UNKNOWN_SENSOR_TRACK: The sensor track is no member of the system track.
    ONLY_MEMBER: The sensor track is the only member of its system track.
    BOUND_TRACK: Another order in force already binds the system track.
    UNKNOWN_ORDER: No order in force has this number.
    NOT_OUT: The source is not out.
    BUSY: Fusion still publishes the previous snapshot or states.
    UNKNOWN_QNH: The configuration has no `[[qnh]]` of this name.
    TAKES_NO_DESIGNATIONS: The tracker has no sensor that takes orders.
    NO_PLACE: The text is no place.
    UNUSED_BY_RULE: The rule in force uses no such value.
    FAR_PLACE: The place is too far from the origin of the system frame."""

    UNKNOWN_KIND = 1
    MALFORMED = 2
    MISSING_PARAMETER = 3
    FOREIGN_PARAMETER = 4
    OUT_OF_RANGE = 5
    EXPIRED = 6
    TOO_MANY = 7
    TABLE_FULL = 8
    UNKNOWN_SOURCE = 9
    UNKNOWN_CONDITION = 10
    UNKNOWN_RULE = 11
    RULE_WITHOUT_REPORTS = 12
    UNKNOWN_TRACK = 13
    SAME_TRACK = 14
    TWO_ADDRESSES = 15
    UNKNOWN_SENSOR_TRACK = 16
    ONLY_MEMBER = 17
    BOUND_TRACK = 18
    UNKNOWN_ORDER = 19
    NOT_OUT = 20
    BUSY = 21
    UNKNOWN_QNH = 22
    TAKES_NO_DESIGNATIONS = 23
    NO_PLACE = 24
    UNUSED_BY_RULE = 25
    FAR_PLACE = 26


class TargetCategory(enum.IntEnum):
    """UNKNOWN: Nothing is stated.
    LIGHT: Aircraft below 7,031 kg (15,500 lb).
    SMALL: Aircraft from 7,031 kg to 34,019 kg (75,000 lb).
    LARGE: Aircraft from 34,019 kg to 136,078 kg (300,000 lb).
    HIGH_VORTEX: Aircraft with a strong wake vortex.
    HEAVY: Aircraft above 136,078 kg.
    HIGH_PERFORMANCE: Aircraft with an acceleration above 5 g and a speed above 400 knots.
    ROTORCRAFT: Helicopter or gyroplane.
    GLIDER: Glider or sailplane.
    LIGHTER_THAN_AIR: Balloon or airship.
    PARACHUTIST: Parachutist or skydiver.
    ULTRALIGHT: Ultralight, hang glider or paraglider.
    UNMANNED: Unmanned aircraft.
    SPACE: Space vehicle.
    EMERGENCY_VEHICLE: Emergency vehicle on the ground.
    SERVICE_VEHICLE: Service vehicle on the ground.
    OBSTACLE: Obstacle, fixed or moored.
    SHIP: Ship of a kind without a word of its own.
    WING_IN_GROUND: Wing in ground effect.
    FISHING: Fishing vessel.
    TOWING: Vessel that tows.
    DREDGING: Vessel engaged in dredging or underwater work.
    DIVING: Vessel engaged in diving.
    MILITARY: Vessel engaged in military operations.
    SAILING: Sailing vessel.
    PLEASURE: Pleasure craft.
    HIGH_SPEED: High-speed craft.
    PILOT: Pilot vessel.
    RESCUE: Search and rescue vessel, or aircraft with an MMSI.
    TUG: Tug.
    TENDER: Port tender.
    ANTI_POLLUTION: Vessel with anti-pollution facilities.
    LAW_ENFORCEMENT: Law enforcement vessel.
    MEDICAL: Medical transport.
    PASSENGER: Passenger ship.
    CARGO: Cargo ship.
    TANKER: Tanker.
    AID: Aid to navigation.
    BASE_STATION: Base station ashore.
    RESCUE_TRANSMITTER: Search and rescue transmitter (AIS-SART, MMSI 970…).
    MAN_OVERBOARD: Man overboard device (MMSI 972…).
    RESCUE_BEACON: Emergency position-indicating radio beacon (MMSI 974…)."""

    UNKNOWN = 0
    LIGHT = 1
    SMALL = 2
    LARGE = 3
    HIGH_VORTEX = 4
    HEAVY = 5
    HIGH_PERFORMANCE = 6
    ROTORCRAFT = 7
    GLIDER = 8
    LIGHTER_THAN_AIR = 9
    PARACHUTIST = 10
    ULTRALIGHT = 11
    UNMANNED = 12
    SPACE = 13
    EMERGENCY_VEHICLE = 20
    SERVICE_VEHICLE = 21
    OBSTACLE = 22
    SHIP = 30
    WING_IN_GROUND = 31
    FISHING = 32
    TOWING = 33
    DREDGING = 34
    DIVING = 35
    MILITARY = 36
    SAILING = 37
    PLEASURE = 38
    HIGH_SPEED = 39
    PILOT = 40
    RESCUE = 41
    TUG = 42
    TENDER = 43
    ANTI_POLLUTION = 44
    LAW_ENFORCEMENT = 45
    MEDICAL = 46
    PASSENGER = 47
    CARGO = 48
    TANKER = 49
    AID = 60
    BASE_STATION = 61
    RESCUE_TRANSMITTER = 62
    MAN_OVERBOARD = 63
    RESCUE_BEACON = 64


class AidKind(enum.IntEnum):
    """UNKNOWN: Nothing is stated.
    REFERENCE_POINT: Reference point.
    RACON: Radar beacon.
    STRUCTURE: Fixed structure off shore: oil platform, wind farm.
    WRECK: Emergency wreck marking buoy.
    LIGHT: Light without sectors.
    SECTOR_LIGHT: Light with sectors.
    FRONT_LIGHT: Front leading light.
    REAR_LIGHT: Rear leading light.
    NORTH_BEACON: Beacon, cardinal north.
    EAST_BEACON: Beacon, cardinal east.
    SOUTH_BEACON: Beacon, cardinal south.
    WEST_BEACON: Beacon, cardinal west.
    PORT_BEACON: Beacon, port hand.
    STARBOARD_BEACON: Beacon, starboard hand.
    PREFERRED_PORT_BEACON: Beacon, preferred channel port hand.
    PREFERRED_STARBOARD_BEACON: Beacon, preferred channel starboard hand.
    DANGER_BEACON: Beacon, isolated danger.
    SAFE_WATER_BEACON: Beacon, safe water.
    SPECIAL_BEACON: Beacon, special mark.
    NORTH_MARK: Floating mark, cardinal north.
    EAST_MARK: Floating mark, cardinal east.
    SOUTH_MARK: Floating mark, cardinal south.
    WEST_MARK: Floating mark, cardinal west.
    PORT_MARK: Floating mark, port hand.
    STARBOARD_MARK: Floating mark, starboard hand.
    PREFERRED_PORT_MARK: Floating mark, preferred channel port hand.
    PREFERRED_STARBOARD_MARK: Floating mark, preferred channel starboard hand.
    DANGER_MARK: Floating mark, isolated danger.
    SAFE_WATER_MARK: Floating mark, safe water.
    SPECIAL_MARK: Floating mark, special.
    LIGHT_VESSEL: Light vessel, large navigational buoy, or rig."""

    UNKNOWN = 0
    REFERENCE_POINT = 1
    RACON = 2
    STRUCTURE = 3
    WRECK = 4
    LIGHT = 5
    SECTOR_LIGHT = 6
    FRONT_LIGHT = 7
    REAR_LIGHT = 8
    NORTH_BEACON = 9
    EAST_BEACON = 10
    SOUTH_BEACON = 11
    WEST_BEACON = 12
    PORT_BEACON = 13
    STARBOARD_BEACON = 14
    PREFERRED_PORT_BEACON = 15
    PREFERRED_STARBOARD_BEACON = 16
    DANGER_BEACON = 17
    SAFE_WATER_BEACON = 18
    SPECIAL_BEACON = 19
    NORTH_MARK = 20
    EAST_MARK = 21
    SOUTH_MARK = 22
    WEST_MARK = 23
    PORT_MARK = 24
    STARBOARD_MARK = 25
    PREFERRED_PORT_MARK = 26
    PREFERRED_STARBOARD_MARK = 27
    DANGER_MARK = 28
    SAFE_WATER_MARK = 29
    SPECIAL_MARK = 30
    LIGHT_VESSEL = 31


class NavigationStatus(enum.IntEnum):
    """UNKNOWN: Nothing is stated.
    ENGINE: Under way using engine.
    ANCHORED: At anchor.
    NOT_UNDER_COMMAND: Not under command.
    RESTRICTED: Restricted manoeuvrability.
    CONSTRAINED: Constrained by the draught.
    MOORED: Moored.
    AGROUND: Aground.
    FISHING: Engaged in fishing.
    SAILING: Under way sailing.
    RESCUE: Active transmitter of search and rescue: AIS-SART, man overboard or beacon."""

    UNKNOWN = 0
    ENGINE = 1
    ANCHORED = 2
    NOT_UNDER_COMMAND = 3
    RESTRICTED = 4
    CONSTRAINED = 5
    MOORED = 6
    AGROUND = 7
    FISHING = 8
    SAILING = 9
    RESCUE = 15


class Emergency(enum.IntEnum):
    """UNKNOWN: Nothing is stated.
    NONE: No emergency.
    GENERAL: General emergency.
    MEDICAL: Medical emergency.
    MINIMUM_FUEL: Minimum fuel.
    NO_COMMUNICATION: No communication.
    UNLAWFUL_INTERFERENCE: Unlawful interference.
    DOWNED: Downed aircraft.
    DISTRESS: Distress at sea."""

    UNKNOWN = 0
    NONE = 1
    GENERAL = 2
    MEDICAL = 3
    MINIMUM_FUEL = 4
    NO_COMMUNICATION = 5
    UNLAWFUL_INTERFERENCE = 6
    DOWNED = 7
    DISTRESS = 8


__all__ = [
    "IdentityBits",
    "MovementBits",
    "SensorTrackBits",
    "SensorDetectionBits",
    "SensorBearingBits",
    "SensorArrivalBits",
    "PlatformStateBits",
    "WideAreaBits",
    "ContributionBits",
    "AlertBits",
    "AlertValueBits",
    "RegistrationBits",
    "WorkStepBits",
    "TargetStatementBits",
    "TrackState",
    "TrackKind",
    "MotionMode",
    "ErrorModel",
    "FusionRule",
    "IdentityKind",
    "HorizontalMovement",
    "VerticalMovement",
    "LongitudinalMovement",
    "DetectionKind",
    "DetectionMark",
    "Stream",
    "StepKind",
    "ProcessKind",
    "LifeState",
    "AlarmSeverity",
    "AlarmEvent",
    "AlertKind",
    "DecisionKind",
    "OrderKind",
    "OrderStatus",
    "Refusal",
    "TargetCategory",
    "AidKind",
    "NavigationStatus",
    "Emergency",
]

#: Codes and bits by name, such as `CODES["TrackState"]`.
CODES: dict[str, type[enum.IntEnum] | type[enum.IntFlag]] = {
    "IdentityBits": IdentityBits,
    "MovementBits": MovementBits,
    "SensorTrackBits": SensorTrackBits,
    "SensorDetectionBits": SensorDetectionBits,
    "SensorBearingBits": SensorBearingBits,
    "SensorArrivalBits": SensorArrivalBits,
    "PlatformStateBits": PlatformStateBits,
    "WideAreaBits": WideAreaBits,
    "ContributionBits": ContributionBits,
    "AlertBits": AlertBits,
    "AlertValueBits": AlertValueBits,
    "RegistrationBits": RegistrationBits,
    "WorkStepBits": WorkStepBits,
    "TargetStatementBits": TargetStatementBits,
    "TrackState": TrackState,
    "TrackKind": TrackKind,
    "MotionMode": MotionMode,
    "ErrorModel": ErrorModel,
    "FusionRule": FusionRule,
    "IdentityKind": IdentityKind,
    "HorizontalMovement": HorizontalMovement,
    "VerticalMovement": VerticalMovement,
    "LongitudinalMovement": LongitudinalMovement,
    "DetectionKind": DetectionKind,
    "DetectionMark": DetectionMark,
    "Stream": Stream,
    "StepKind": StepKind,
    "ProcessKind": ProcessKind,
    "LifeState": LifeState,
    "AlarmSeverity": AlarmSeverity,
    "AlarmEvent": AlarmEvent,
    "AlertKind": AlertKind,
    "DecisionKind": DecisionKind,
    "OrderKind": OrderKind,
    "OrderStatus": OrderStatus,
    "Refusal": Refusal,
    "TargetCategory": TargetCategory,
    "AidKind": AidKind,
    "NavigationStatus": NavigationStatus,
    "Emergency": Emergency,
}

for _group in CODES.values():
    _group.__module__ = "koseki"

/* Koseki for C: read the topics of a deployment, and feed sources.
 *
 *   koseki_subscription *tracks;
 *   if (koseki_subscribe("demo", "system/tracks", KOSEKI_SYSTEM_TRACK_SCHEMA, &tracks))
 *     return fprintf(stderr, "%s\n", koseki_error()), 1;
 *   koseki_slice slice;
 *   while (koseki_receive(tracks, -1, &slice) == KOSEKI_OK) {
 *     const KosekiSystemTrack *track = slice.samples;
 *     for (size_t i = 0; i < slice.count; i++)
 *       printf("%u\n", track[i].track_number);
 *     koseki_release(&slice);
 *   }
 *   koseki_unsubscribe(tracks);
 *
 * Samples and their constants are in koseki_messages.h: units, ranges, frames. A handle may move to another
 * thread; two threads must not use a handle at the same time. Link with -lkoseki (pkg-config koseki; CMake: koseki::koseki). */
#ifndef KOSEKI_H
#define KOSEKI_H

#include "koseki_messages.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Outcomes. */
enum {
  KOSEKI_OK = 0,
  KOSEKI_NOT_RUNNING = 1,   /* No such deployment runs: start it, or wait for it. */
  KOSEKI_ENDED = 2,         /* The deployment has ended or was replaced: close, and open anew. */
  KOSEKI_SCHEMA = 3,        /* Header, library and deployment have different versions. */
  KOSEKI_NO_SUCH_TOPIC = 4, /* The deployment has no such topic. */
  KOSEKI_FULL = 5,          /* The topic has no place left for another reader or writer. */
  KOSEKI_BORROWED = 6,      /* Two slices are kept, the most allowed: release a slice. */
  KOSEKI_ARGUMENT = 7,      /* An argument makes no sense. */
  KOSEKI_SYSTEM = 8,        /* The system has refused something. */
  KOSEKI_NOTHING = 9,       /* Nothing came in time, or a signal did. */
  KOSEKI_FED = 10           /* Another process publishes on the topic: end it. */
};

typedef struct koseki_subscription koseki_subscription;
typedef struct koseki_publisher koseki_publisher;

/* A slice in shared memory: valid and unchanged until the slice is released. */
typedef struct {
  const void *samples;       /* `count` samples of the topic's type. */
  size_t count;              /* May be 0: then the header is all there is. */
  const KosekiBatchHeader *header; /* Publisher's statement about the samples. */
  uint64_t lost;             /* Samples missing between the slice before and this slice. */
  int starts_epoch;          /* 1: fusion has started anew (of recorded inputs: numbers begin again), or the first slice. */
  void *handle;              /* Of the slice, for koseki_release(). */
} koseki_slice;

/* Counts of a subscription since its opening. */
typedef struct {
  uint64_t taken;           /* Samples. */
  uint64_t lost;            /* Samples missing: the reader was too slow, or the publisher died. */
  uint64_t of_older_epochs; /* Samples dropped because they came from a fusion that has been replaced since. */
  uint64_t epoch;           /* Start-up number of the fusion that wrote the latest slice; 0: none yet. */
} koseki_counters;

/* Reads a topic of the deployment called `instance` (the name given with `koseki up --instance`, or the name in the
 * configuration). `schema` is the constant of the topic's type, such as KOSEKI_SYSTEM_TRACK_SCHEMA for system/tracks.
 * The constant shows whether header and library have the same version. */
int koseki_subscribe(const char *instance, const char *topic, uint64_t schema, koseki_subscription **handle);

/* Reads like koseki_subscribe, with a queue of `queue` slices in place of the topic's usual number (256 for tracks): a reader
 * that falls behind by more slices loses the oldest. From 1 to the usual number; for system/tracks, to `[machine]
 * queue_slices` of the configuration. Another number gives KOSEKI_ARGUMENT. */
int koseki_subscribe_with_queue(const char *instance, const char *topic, uint64_t schema, size_t queue,
                                koseki_subscription **handle);

/* Takes the next slice, and waits up to `timeout_ms` milliseconds for a slice; 0: no wait; -1: no limit. The former
 * content of `slice` is overwritten: release the former slice first. */
int koseki_receive(koseki_subscription *subscription, int64_t timeout_ms, koseki_slice *slice);

/* Gives a slice back. An empty slice has no effect. */
void koseki_release(koseki_slice *slice);

/* A descriptor for poll, select or epoll, readable when there is something to receive. Then receive with time-out 0
 * until KOSEKI_NOTHING; receive every tenth of a second in any case, since a wake-up can be lost. Do not close the
 * descriptor. */
int koseki_descriptor(const koseki_subscription *subscription);

koseki_counters koseki_counts(const koseki_subscription *subscription);

/* Ends a subscription; kept slices stay valid until released. The handle is invalid afterwards. */
void koseki_unsubscribe(koseki_subscription *subscription);

/* Writes the topic of a source (sensor/NAME/tracks, KosekiSensorTrack), sensor of a tracker (sensor/TRACKER.NAME/detections,
 * KosekiSensorDetection), wide-area sensor (wide-area/NAME/reports, KosekiWideArea) or platform (platform/NAME/state,
 * KosekiPlatformState) that the configuration calls external. */
int koseki_advertise(const char *instance, const char *topic, uint64_t schema, koseki_publisher **handle);

/* Publishes `count` samples of the topic's type. Sequence numbers and stamps are filled in. If a sample has a fault
 * (no finite number, a time in seconds, a variance of 0, …), none is published, and the code is KOSEKI_ARGUMENT:
 * koseki_error() names the sample, field, value, limit and remedy. */
int koseki_publish(koseki_publisher *publisher, const void *samples, size_t count);

/* Observations, as koseki_send_detections and koseki_send_track_reports take them: places in degrees, or in metres of the
 * system frame. Make an observation with the functions below, then state further known values; NAN
 * stands for an unknown number. */
typedef struct {
  size_t size;           /* Of this struct: filled in by the functions below. */
  int64_t time_ns;       /* Time of measurement, UTC, nanoseconds since 1970; 0: now. */
  int64_t scan;          /* Number of the scan; -1: detections with the same time form a scan. */
  uint32_t address;      /* 24-bit address of ICAO; 0: unknown. */
  uint32_t mmsi;         /* 0: unknown. */
  char callsign[16];     /* Up to eight characters; "": unknown. */
  double latitude;                /* Latitude of the target, WGS-84, degrees, from -90 to 90, north positive. */
  double longitude;               /* Longitude of the target, WGS-84, degrees, from -180 to 180, east positive. */
  double height_m;                /* Height of the target above the ellipsoid, metres, from -1e5 to 1e5. */
  double east_m;                  /* Place of the target in the system frame, metres east; in place of latitude and longitude. */
  double north_m;                 /* Place of the target in the system frame, metres north. */
  double up_m;                    /* Place of the target in the system frame, metres up. */
  double sigma_m;                 /* Standard deviation of the position along each horizontal axis, metres, above 0. */
  double height_sigma_m;          /* Standard deviation of the height, metres; that of the position if not stated. 0: the height is
                                     unknown. */
  double range_m;                 /* Slant range from the sensor, metres. */
  double bearing_deg;             /* Direction from the sensor, degrees clockwise, from -360 to 360: from true north at a
                                     sensor in latitude and longitude, from the system frame's north at a sensor in metres. */
  double elevation_deg;           /* Direction above the horizontal of the same place, degrees. */
  double range_sigma_m;           /* Standard deviation of the range, metres, above 0. */
  double bearing_sigma_deg;       /* Standard deviation of the bearing, degrees, above 0. */
  double elevation_sigma_deg;     /* Standard deviation of the elevation, degrees, above 0. */
  double sensor_latitude;         /* Latitude of the sensor, degrees. */
  double sensor_longitude;        /* Longitude of the sensor, degrees. */
  double sensor_height_m;         /* Height of the sensor above the ellipsoid, metres. */
  double sensor_east_m;           /* Place of the sensor in the system frame, metres east; in place of latitude and longitude. */
  double sensor_north_m;          /* Place of the sensor in the system frame, metres north. */
  double sensor_up_m;             /* Place of the sensor in the system frame, metres up. */
  double range_rate_mps;          /* Rate of the range, metres per second, positive away from the sensor. */
  double range_rate_sigma_mps;    /* Standard deviation of the rate, metres per second, above 0. */
} koseki_detection;

typedef struct {
  size_t size;           /* Of this struct: filled in by the functions below. */
  int64_t time_ns;       /* Time of measurement, UTC, nanoseconds since 1970; 0: now. */
  int64_t track;         /* Number of the track at the sensor. */
  int64_t state;         /* KOSEKI_STATE_…; -1: confirmed. */
  uint32_t address;      /* 24-bit address of ICAO; 0: unknown. */
  uint32_t mmsi;         /* 0: unknown. */
  char callsign[16];     /* Up to eight characters; "": unknown. */
  double latitude;                /* Latitude of the target, WGS-84, degrees, from -90 to 90, north positive. */
  double longitude;               /* Longitude of the target, WGS-84, degrees, from -180 to 180, east positive. */
  double height_m;                /* Height of the target above the ellipsoid, metres, from -1e5 to 1e5. */
  double east_m;                  /* Place of the target in the system frame, metres east; in place of latitude and longitude. */
  double north_m;                 /* Place of the target in the system frame, metres north. */
  double up_m;                    /* Place of the target in the system frame, metres up. */
  double sigma_m;                 /* Standard deviation of the position along each horizontal axis, metres, above 0. */
  double height_sigma_m;          /* Standard deviation of the height, metres; that of the position if not stated. 0: the height is
                                     unknown. */
  double speed_mps;               /* Speed over ground, metres per second. */
  double course_deg;              /* Direction of the motion, degrees clockwise from true north at the target, from -360 to 360. */
  double climb_mps;               /* Rate of climb, metres per second. */
  double velocity_east_mps;       /* Velocity in the system frame, metres per second east; in place of speed and course. */
  double velocity_north_mps;      /* Velocity in the system frame, metres per second north. */
  double velocity_up_mps;         /* Velocity in the system frame, metres per second up. */
  double velocity_sigma_mps;      /* Standard deviation of the velocity along each axis, metres per second. 0: the velocity is
                                     unknown. */
} koseki_track_report;

/* Fill an observation in that states nothing; `size` is that of the struct. */
void koseki_begin_detection(koseki_detection *detection, size_t size);
void koseki_begin_track_report(koseki_track_report *report, size_t size);

/* A detection at a latitude and a longitude (WGS-84, degrees), with the standard deviation of the position. */
static inline koseki_detection koseki_detection_at(double latitude, double longitude, double sigma_m) {
  koseki_detection detection;
  koseki_begin_detection(&detection, sizeof detection);
  detection.latitude = latitude;
  detection.longitude = longitude;
  detection.sigma_m = sigma_m;
  return detection;
}

/* A bearing from a sensor at a latitude and a longitude (WGS-84, degrees), with the standard deviation of
 * the bearing. */
static inline koseki_detection koseki_bearing_from(double latitude, double longitude, double bearing_deg,
                                                   double sigma_deg) {
  koseki_detection detection;
  koseki_begin_detection(&detection, sizeof detection);
  detection.sensor_latitude = latitude;
  detection.sensor_longitude = longitude;
  detection.bearing_deg = bearing_deg;
  detection.bearing_sigma_deg = sigma_deg;
  return detection;
}

/* A report of the track `track` at a latitude and a longitude (WGS-84, degrees), with the standard deviation of the
 * position. */
static inline koseki_track_report koseki_track_at(uint32_t track, double latitude, double longitude, double sigma_m) {
  koseki_track_report report;
  koseki_begin_track_report(&report, sizeof report);
  report.track = track;
  report.latitude = latitude;
  report.longitude = longitude;
  report.sigma_m = sigma_m;
  return report;
}

/* Feeds the source called `source` with detections or sensor tracks, as the configuration states. A sensor of a tracker
 * is called TRACKER.NAME. End the feed with koseki_unadvertise. */
int koseki_feed(const char *instance, const char *source, koseki_publisher **handle);

/* Publishes `count` observations; an observation without a time is of the present. If an observation has a fault (a
 * latitude beyond 90 degrees, a standard deviation of 0, …), none is published, and the code is KOSEKI_ARGUMENT:
 * koseki_error() names the observation, field, value, limit and remedy. The first call waits up to a fifth of a second for the origin of the system frame. */
int koseki_send_detections(koseki_publisher *publisher, const koseki_detection *detections, size_t count);
int koseki_send_track_reports(koseki_publisher *publisher, const koseki_track_report *reports, size_t count);

/* Sets the largest distance of a sample's time from this machine's clock, seconds above 0, by default 600; INFINITY: there
 * is no limit. */
int koseki_limit_clock(koseki_publisher *publisher, double limit_s);

/* Ends a publisher. The handle is invalid afterwards. */
void koseki_unadvertise(koseki_publisher *publisher);

/* Gives an order to the fusion of the deployment called `instance`, and waits for the answer up to `timeout_ms`
 * milliseconds; -1: without limit. `order` has the words of `koseki order`: kind and parameters, such as
 * "out source=radar-south". The order expires after `lasts_s` seconds; 0: never. `state` gets the answer, also of an
 * order that is refused (status KOSEKI_ORDER_STATUS_REFUSED, with the reason in `text`); null: no answer is wanted. Orders in force
 * are on the topic system/order-states. */
int koseki_order(const char *instance, const char *order, const char *operator_name, double lasts_s,
                 int64_t timeout_ms, KosekiOrderState *state);

/* Text of this thread's latest failure, with the remedy; valid until the thread's next failure. */
const char *koseki_error(void);

#ifdef __cplusplus
}
#endif
#endif

/* Koseki for C: read what a deployment publishes, and feed sources of your own.
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
 * Samples and their constants are in koseki_messages.h: units, ranges, frames. A handle may move to another thread, and
 * is used by one at a time. Link with -lkoseki (pkg-config koseki; CMake: koseki::koseki). */
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
  KOSEKI_SCHEMA = 3,        /* Header, library and deployment are not of one version. */
  KOSEKI_NO_SUCH_TOPIC = 4, /* The deployment has no such topic. */
  KOSEKI_FULL = 5,          /* The topic has no place left for another reader or writer. */
  KOSEKI_BORROWED = 6,      /* Two slices are kept, and that is the limit: release one. */
  KOSEKI_ARGUMENT = 7,      /* An argument makes no sense. */
  KOSEKI_SYSTEM = 8,        /* The system has refused something. */
  KOSEKI_NOTHING = 9,       /* Nothing came in time, or a signal did. */
  KOSEKI_FED = 10           /* Another process publishes on the topic: end it. */
};

typedef struct koseki_subscription koseki_subscription;
typedef struct koseki_publisher koseki_publisher;

/* A slice in shared memory. It is valid, and is not written to, until it is released. */
typedef struct {
  const void *samples;       /* `count` samples of the topic's type. */
  size_t count;              /* May be 0: then only the header says something. */
  const KosekiBatchHeader *header; /* What their publisher says of them. */
  uint64_t lost;             /* Samples missing between the slice before and this one. */
  int starts_epoch;          /* 1: fusion has started anew (of recorded inputs: numbers begin again), or the first slice. */
  void *kept;                /* The library's own. */
} koseki_slice;

/* Counts of a subscription since it was opened. */
typedef struct {
  uint64_t taken;           /* Samples. */
  uint64_t lost;            /* Samples missing: the reader was too slow, or they died with their publisher. */
  uint64_t of_older_epochs; /* Samples dropped because they came from a fusion that has been replaced since. */
  uint64_t epoch;           /* Start-up number of the fusion that wrote the latest slice; 0: none yet. */
} koseki_counters;

/* Reads a topic of the deployment called `instance` (that of `koseki up --instance`, or the name in its
 * configuration). `schema` is the constant of the topic's type, such as KOSEKI_SYSTEM_TRACK_SCHEMA for system/tracks:
 * it shows whether this header is that of the library. */
int koseki_subscribe(const char *instance, const char *topic, uint64_t schema, koseki_subscription **handle);

/* Takes the next slice, and waits for it up to `timeout_ms` milliseconds; 0: not at all; -1: as long as it takes.
 * Whatever was in `slice` is overwritten: release it before. */
int koseki_receive(koseki_subscription *subscription, int64_t timeout_ms, koseki_slice *slice);

/* Gives a slice back. Does nothing with one that holds nothing. */
void koseki_release(koseki_slice *slice);

/* A descriptor for poll, select or epoll, readable when there is something to receive. Then receive with time-out 0
 * until KOSEKI_NOTHING; do so every tenth of a second all the same, since a wake-up can be lost. Do not close it. */
int koseki_descriptor(const koseki_subscription *subscription);

koseki_counters koseki_counts(const koseki_subscription *subscription);

/* Ends a subscription; slices that are kept stay valid until they are released. The handle is invalid afterwards. */
void koseki_unsubscribe(koseki_subscription *subscription);

/* Writes the topic of a source (sensor/NAME/tracks, KosekiSensorTrack), sensor of a tracker (sensor/TRACKER.NAME/detections,
 * KosekiSensorDetection), wide-area sensor (wide-area/NAME/reports, KosekiWideArea) or platform (platform/NAME/state,
 * KosekiPlatformState) that the configuration calls external. */
int koseki_advertise(const char *instance, const char *topic, uint64_t schema, koseki_publisher **handle);

/* Publishes `count` samples of the topic's type. Their sequence numbers and stamps are filled in. If a sample has a fault
 * (no finite number, a time in seconds, a variance of 0, …), none is published, and the code is KOSEKI_ARGUMENT:
 * koseki_error() names the sample, field, value, limit and remedy. */
int koseki_publish(koseki_publisher *publisher, const void *samples, size_t count);

/* Ends a publisher. The handle is invalid afterwards. */
void koseki_unadvertise(koseki_publisher *publisher);

/* Gives an order to the fusion of the deployment called `instance`, and waits for the answer up to `timeout_ms`
 * milliseconds; -1: without limit. `order` has the words of `koseki order`: the kind and its parameters, such as
 * "eta value=0.3 source=radar". The order expires after `lasts_s` seconds; 0: never. `state` gets the answer, also of an
 * order that is refused (status KOSEKI_ORDER_STATUS_REFUSED, with the reason in `text`); it may be null. Orders in force
 * are on the topic system/order-states. */
int koseki_order(const char *instance, const char *order, const char *operator_name, double lasts_s,
                 int64_t timeout_ms, KosekiOrderState *state);

/* Text of this thread's latest failure, with what to do about it; valid until its next one. */
const char *koseki_error(void);

#ifdef __cplusplus
}
#endif
#endif

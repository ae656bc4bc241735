/* Shows each outcome that a program can meet: errors INSTANCE. The deployment runs, and has system tracks. Returns the
 * number of the first step that did not end as it should. errors INSTANCE SOURCE: somebody publishes the tracks of this
 * source in another layout. */
#include <koseki.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TRACKS "system/tracks", KOSEKI_SYSTEM_TRACK_SCHEMA

/* More than a topic holds. */
#define SLICES 400

static int step;

static void expect(int outcome, int expected) {
  printf("step %d: outcome %d%s%s\n", ++step, outcome, outcome ? ": " : "", outcome ? koseki_error() : "");
  if (outcome != expected) {
    fprintf(stderr, "step %d: outcome %d, not %d\n", step, outcome, expected);
    _Exit(step);
  }
}

static int of_another_layout(const char *instance, const char *source) {
  char topic[64];
  koseki_subscription *tracks;
  koseki_slice slice;
  snprintf(topic, sizeof topic, "sensor/%s/tracks", source);
  expect(koseki_subscribe(instance, topic, KOSEKI_SENSOR_TRACK_SCHEMA, &tracks), KOSEKI_OK);
  expect(koseki_receive(tracks, 20000, &slice), KOSEKI_SCHEMA);
  koseki_unsubscribe(tracks);
  return 0;
}

int main(int count, char **arguments) {
  const char *instance = count > 1 ? arguments[1] : "demo";
  if (count > 2)
    return of_another_layout(instance, arguments[2]);
  koseki_subscription *tracks;
  koseki_publisher *publisher;
  koseki_slice none;
  expect(koseki_receive(NULL, 0, &none), KOSEKI_ARGUMENT);
  expect(koseki_publish(NULL, "", 0), KOSEKI_ARGUMENT);
  expect(koseki_descriptor(NULL), -1);
  koseki_release(NULL);
  koseki_unsubscribe(NULL);
  koseki_unadvertise(NULL);
  expect(koseki_subscribe("nobody", TRACKS, &tracks), KOSEKI_NOT_RUNNING);
  expect(koseki_subscribe("a/b", TRACKS, &tracks), KOSEKI_ARGUMENT);
  expect(koseki_subscribe(NULL, TRACKS, &tracks), KOSEKI_ARGUMENT);
  expect(koseki_subscribe(instance, "nonsense", 1, &tracks), KOSEKI_ARGUMENT);
  expect(koseki_subscribe(instance, "sensor/nobody/tracks", KOSEKI_SENSOR_TRACK_SCHEMA, &tracks), KOSEKI_NO_SUCH_TOPIC);
  expect(koseki_subscribe(instance, "system/tracks", KOSEKI_SENSOR_TRACK_SCHEMA, &tracks), KOSEKI_SCHEMA);
  expect(koseki_subscribe_with_queue(instance, TRACKS, 0, &tracks), KOSEKI_ARGUMENT);
  expect(koseki_subscribe_with_queue(instance, TRACKS, 100000, &tracks), KOSEKI_ARGUMENT);
  expect(koseki_subscribe_with_queue(instance, TRACKS, 10, &tracks), KOSEKI_OK);
  koseki_unsubscribe(tracks);
  expect(koseki_advertise(instance, TRACKS, &publisher), KOSEKI_ARGUMENT);
  expect(koseki_subscribe(instance, TRACKS, &tracks), KOSEKI_OK);
  koseki_slice kept[3];
  expect(koseki_receive(tracks, -1, &kept[0]), KOSEKI_OK);
  expect(koseki_receive(tracks, -1, &kept[1]), KOSEKI_OK);
  KosekiSystemTrack before = {0};
  if (kept[0].count > 0)
    memcpy(&before, kept[0].samples, sizeof before);
  int outcome;
  while ((outcome = koseki_receive(tracks, 1000, &kept[2])) == KOSEKI_NOTHING) {
  }
  expect(outcome, KOSEKI_BORROWED);
  /* What is kept is not written to, and outlives its subscription. */
  koseki_release(&kept[1]);
  koseki_unsubscribe(tracks);
  expect(kept[0].count > 0 && memcmp(&before, kept[0].samples, sizeof before), 0);
  koseki_release(&kept[0]);
  koseki_release(&kept[0]);
  /* A reader that takes nothing while more comes than the topic holds is told how much it lost. */
  koseki_subscription *quick;
  expect(koseki_subscribe(instance, TRACKS, &tracks), KOSEKI_OK);
  expect(koseki_subscribe(instance, TRACKS, &quick), KOSEKI_OK);
  expect(koseki_receive(tracks, -1, &kept[0]), KOSEKI_OK);
  koseki_release(&kept[0]);
  for (int slices = 0; slices < SLICES; ++slices) {
    if (koseki_receive(quick, -1, &kept[0]) != KOSEKI_OK)
      return step + 1;
    slices -= kept[0].count == 0;
    koseki_release(&kept[0]);
  }
  uint64_t lost = 0;
  while (lost == 0 && koseki_receive(tracks, 0, &kept[0]) == KOSEKI_OK) {
    lost = kept[0].lost;
    koseki_release(&kept[0]);
  }
  expect(lost > 0 && koseki_counts(tracks).lost >= lost, 1);
  koseki_unsubscribe(quick);
  koseki_unsubscribe(tracks);
  return 0;
}

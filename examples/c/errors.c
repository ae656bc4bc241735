/* Shows each outcome that a program can meet: errors INSTANCE. The deployment runs, and has system tracks. Returns the
 * number of the first step that did not end as it should. */
#include <koseki.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TRACKS "system/tracks", KOSEKI_SYSTEM_TRACK_SCHEMA

static int step;

static void expect(int outcome, int expected) {
  printf("step %d: outcome %d%s%s\n", ++step, outcome, outcome ? ": " : "", outcome ? koseki_error() : "");
  if (outcome != expected) {
    fprintf(stderr, "step %d: outcome %d, not %d\n", step, outcome, expected);
    _Exit(step);
  }
}

int main(int count, char **arguments) {
  const char *instance = count > 1 ? arguments[1] : "demo";
  koseki_subscription *tracks;
  koseki_publisher *publisher;
  expect(koseki_subscribe("nobody", TRACKS, &tracks), KOSEKI_NOT_RUNNING);
  expect(koseki_subscribe("a/b", TRACKS, &tracks), KOSEKI_ARGUMENT);
  expect(koseki_subscribe(NULL, TRACKS, &tracks), KOSEKI_ARGUMENT);
  expect(koseki_subscribe(instance, "nonsense", 1, &tracks), KOSEKI_ARGUMENT);
  expect(koseki_subscribe(instance, "sensor/nobody/tracks", KOSEKI_SENSOR_TRACK_SCHEMA, &tracks), KOSEKI_NO_SUCH_TOPIC);
  expect(koseki_subscribe(instance, "system/tracks", KOSEKI_SENSOR_TRACK_SCHEMA, &tracks), KOSEKI_SCHEMA);
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
  return 0;
}

/* Detections of three moving targets, in degrees, to fused tracks: start `koseki up examples/detections.toml` first. */
#include <koseki.h>
#include <poll.h>
#include <stdio.h>

int main(void) {
  koseki_publisher *source;
  koseki_subscription *tracks;
  koseki_slice slice;
  if (koseki_feed("feed", "own", &source) || koseki_subscribe("feed", "system/tracks", KOSEKI_SYSTEM_TRACK_SCHEMA, &tracks))
    return puts(koseki_error());
  for (double longitude = 2.10;; longitude += 2.5e-4) {
    koseki_detection seen[] = {koseki_detection_at(41.40, longitude, 20), koseki_detection_at(41.43, longitude, 20),
                               koseki_detection_at(41.46, longitude, 20)};
    if (koseki_send_detections(source, seen, 3))
      return puts(koseki_error());
    for (poll(NULL, 0, 500); koseki_receive(tracks, 0, &slice) == KOSEKI_OK; koseki_release(&slice))
      for (const KosekiSystemTrack *t = slice.samples, *end = t + slice.count; t < end; t++)
        if (t->state == KOSEKI_STATE_CONFIRMED)
          printf("track %u at %f %f\n", t->track_number, t->position_m[0], t->position_m[1]);
  }
}

/* Prints system tracks for a while: subscribe INSTANCE [SLICES]. It waits with poll, as a program that waits for other
 * things would. */
#include <koseki.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>

int main(int count, char **arguments) {
  const char *instance = count > 1 ? arguments[1] : "demo";
  long left = count > 2 ? atol(arguments[2]) : -1;
  koseki_subscription *tracks;
  int outcome = koseki_subscribe(instance, "system/tracks", KOSEKI_SYSTEM_TRACK_SCHEMA, &tracks);
  while (outcome == KOSEKI_OK && left != 0) {
    struct pollfd ready = {.fd = koseki_descriptor(tracks), .events = POLLIN};
    poll(&ready, 1, 100);
    koseki_slice slice;
    while (left != 0 && (outcome = koseki_receive(tracks, 0, &slice)) == KOSEKI_OK) {
      const KosekiSystemTrack *track = slice.samples;
      for (size_t i = 0; i < slice.count; i++)
        printf("track %u at %.0f %.0f %.0f m\n", track[i].track_number, track[i].position_m[0], track[i].position_m[1],
               track[i].position_m[2]);
      if (slice.lost > 0)
        fprintf(stderr, "too slow: %llu updates lost\n", (unsigned long long)slice.lost);
      koseki_release(&slice);
      left -= left > 0;
    }
    if (outcome == KOSEKI_NOTHING)
      outcome = KOSEKI_OK;
  }
  if (outcome != KOSEKI_OK)
    fprintf(stderr, "%s\n", koseki_error());
  koseki_unsubscribe(tracks);
  return outcome;
}

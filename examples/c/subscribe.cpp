// Prints system tracks for a while: subscribe INSTANCE [SLICES].
#include <iostream>
#include <koseki.hpp>

int main(int count, char **arguments) try {
  koseki::Subscription<KosekiSystemTrack> tracks(count > 1 ? arguments[1] : "demo");
  for (long left = count > 2 ? std::stol(arguments[2]) : -1; left != 0; left -= left > 0) {
    const auto slice = tracks.receive();
    for (const KosekiSystemTrack &track : slice)
      std::cout << "track " << track.track_number << " at " << track.position_m[0] << ' ' << track.position_m[1] << " m\n";
    if (slice.lost() > 0)
      std::cerr << "too slow: " << slice.lost() << " updates lost\n";
  }
} catch (const koseki::Error &error) {
  std::cerr << error.what() << '\n';
  return error.code;
}

// Shows that each failure is an exception with its code, and that a slow reader is told what it lost: errors INSTANCE.
// errors INSTANCE SOURCE: somebody publishes the tracks of this source in another layout.
#include <iostream>
#include <koseki.hpp>

using Tracks = koseki::Subscription<KosekiSystemTrack>;

// System tracks of another version.
struct Stale {};
template <> struct koseki::Topic<Stale> {
  static constexpr std::uint64_t schema = 1;
  static std::string name(const std::string &) { return "system/tracks"; }
};

// More than a topic holds.
constexpr int SLICES = 400;

template <class Work> void expect(int code, Work work) {
  int found = KOSEKI_OK;
  try {
    work();
  } catch (const koseki::Error &error) {
    found = error.code;
    std::cout << error.what() << '\n';
  }
  if (found != code)
    throw std::logic_error("outcome " + std::to_string(found) + ", not " + std::to_string(code));
}

int main(int count, char **arguments) try {
  const std::string instance = count > 1 ? arguments[1] : "demo";
  if (count > 2) {
    expect(KOSEKI_SCHEMA, [&] {
      koseki::Subscription<KosekiSensorTrack> tracks(instance, arguments[2]);
      tracks.receive(std::chrono::seconds(20));
    });
    return 0;
  }
  expect(KOSEKI_NOT_RUNNING, [] { Tracks("nobody"); });
  expect(KOSEKI_ARGUMENT, [] { Tracks("a/b"); });
  expect(KOSEKI_SCHEMA, [&] { koseki::Subscription<Stale>{instance}; });
  expect(KOSEKI_ARGUMENT, [&] { Tracks(instance, "", 0); });
  expect(KOSEKI_ARGUMENT, [&] { Tracks(instance, "", 100000); });
  expect(KOSEKI_OK, [&] { Tracks(instance, "", 10); });
  expect(KOSEKI_NO_SUCH_TOPIC, [&] { koseki::Subscription<KosekiSensorTrack>(instance, "nobody"); });
  expect(KOSEKI_BORROWED, [&] {
    Tracks tracks(instance);
    const auto first = tracks.receive(), second = tracks.receive();
    while (true)
      tracks.receive();
  });
  // One reader takes a slice, and then none of more slices than a topic holds.
  Tracks slow(instance), quick(instance);
  slow.receive();
  for (int published = 0; published < SLICES; published += quick.receive().size() > 0) {
  }
  std::uint64_t lost = 0;
  for (auto slice = slow.receive(); slice && lost == 0; slice = slow.receive(std::chrono::milliseconds(0)))
    lost = slice.lost();
  std::cout << lost << " samples lost\n";
  return lost > 0 && slow.counts().lost >= lost ? 0 : 1;
} catch (const std::exception &error) {
  std::cerr << error.what() << '\n';
  return 1;
}

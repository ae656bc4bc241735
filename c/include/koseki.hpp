// Koseki for C++17: the functions of koseki.h as types that release slices and handles by themselves.
//
//   koseki::Subscription<KosekiSystemTrack> tracks("demo");
//   for (;;)
//     for (const KosekiSystemTrack &track : tracks.receive())
//       std::cout << track.track_number << '\n';
#ifndef KOSEKI_HPP
#define KOSEKI_HPP

#include <chrono>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "koseki.h"

namespace koseki {

// A failure: `code` is an outcome of koseki.h, and the text states the remedy.
class Error : public std::runtime_error {
public:
  explicit Error(int code) : std::runtime_error(koseki_error()), code(code) {}
  const int code;
};

// Schema and topic of a type of sample.
template <class Sample> struct Topic;
template <> struct Topic<KosekiSystemTrack> {
  static constexpr std::uint64_t schema = KOSEKI_SYSTEM_TRACK_SCHEMA;
  static std::string name(const std::string &) { return "system/tracks"; }
};
template <> struct Topic<KosekiAlarm> {
  static constexpr std::uint64_t schema = KOSEKI_ALARM_SCHEMA;
  static std::string name(const std::string &) { return "system/alarms"; }
};
template <> struct Topic<KosekiAlert> {
  static constexpr std::uint64_t schema = KOSEKI_ALERT_SCHEMA;
  static std::string name(const std::string &) { return "system/alerts"; }
};
template <> struct Topic<KosekiOrderState> {
  static constexpr std::uint64_t schema = KOSEKI_ORDER_STATE_SCHEMA;
  static std::string name(const std::string &) { return "system/order-states"; }
};
template <> struct Topic<KosekiSensorTrack> {
  static constexpr std::uint64_t schema = KOSEKI_SENSOR_TRACK_SCHEMA;
  static std::string name(const std::string &source) { return "sensor/" + source + "/tracks"; }
};
// Of a sensor of a tracker, called "tracker.sensor".
template <> struct Topic<KosekiSensorDetection> {
  static constexpr std::uint64_t schema = KOSEKI_SENSOR_DETECTION_SCHEMA;
  static std::string name(const std::string &sensor) { return "sensor/" + sensor + "/detections"; }
};
template <> struct Topic<KosekiWideArea> {
  static constexpr std::uint64_t schema = KOSEKI_WIDE_AREA_SCHEMA;
  static std::string name(const std::string &sensor) { return "wide-area/" + sensor + "/reports"; }
};
template <> struct Topic<KosekiPlatformState> {
  static constexpr std::uint64_t schema = KOSEKI_PLATFORM_STATE_SCHEMA;
  static std::string name(const std::string &platform) { return "platform/" + platform + "/state"; }
};

// A slice in shared memory; empty without samples. A subscription can hold two slices at a time.
template <class Sample> class Slice {
public:
  Slice() noexcept = default;
  Slice(Slice &&other) noexcept : slice_(std::exchange(other.slice_, {})) {}
  Slice &operator=(Slice &&other) noexcept {
    std::swap(slice_, other.slice_);
    return *this;
  }
  ~Slice() { koseki_release(&slice_); }

  const Sample *begin() const noexcept { return static_cast<const Sample *>(slice_.samples); }
  const Sample *end() const noexcept { return begin() + slice_.count; }
  std::size_t size() const noexcept { return slice_.count; }
  explicit operator bool() const noexcept { return slice_.header != nullptr; }
  const KosekiBatchHeader &header() const noexcept { return *slice_.header; }
  std::uint64_t lost() const noexcept { return slice_.lost; }
  bool starts_epoch() const noexcept { return slice_.starts_epoch != 0; }

private:
  template <class> friend class Subscription;
  koseki_slice slice_ = {};
};

// Reader of a topic.
template <class Sample> class Subscription {
public:
  // `of` is the source's, sensor's or platform's name where there is a topic for each.
  explicit Subscription(const std::string &instance, const std::string &of = "") {
    const auto topic = Topic<Sample>::name(of);
    if (const int code = koseki_subscribe(instance.c_str(), topic.c_str(), Topic<Sample>::schema, &handle_))
      throw Error(code);
  }
  // With a queue of `queue` slices: see koseki_subscribe_with_queue.
  Subscription(const std::string &instance, const std::string &of, std::size_t queue) {
    const auto topic = Topic<Sample>::name(of);
    if (const int code = koseki_subscribe_with_queue(instance.c_str(), topic.c_str(), Topic<Sample>::schema, queue, &handle_))
      throw Error(code);
  }
  Subscription(Subscription &&other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  Subscription &operator=(Subscription &&other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Subscription() { koseki_unsubscribe(handle_); }

  // The next slice; an empty slice if none comes in time. A negative time-out has no limit.
  Slice<Sample> receive(std::chrono::milliseconds timeout = std::chrono::milliseconds(-1)) {
    Slice<Sample> slice;
    const int code = koseki_receive(handle_, timeout.count(), &slice.slice_);
    if (code != KOSEKI_OK && code != KOSEKI_NOTHING)
      throw Error(code);
    return slice;
  }
  int descriptor() const noexcept { return koseki_descriptor(handle_); }
  koseki_counters counts() const noexcept { return koseki_counts(handle_); }

private:
  koseki_subscription *handle_ = nullptr;
};

// Writer of a topic that the configuration calls external.
template <class Sample> class Publisher {
public:
  Publisher(const std::string &instance, const std::string &of) {
    const auto topic = Topic<Sample>::name(of);
    if (const int code = koseki_advertise(instance.c_str(), topic.c_str(), Topic<Sample>::schema, &handle_))
      throw Error(code);
  }
  Publisher(Publisher &&other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  Publisher &operator=(Publisher &&other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Publisher() { koseki_unadvertise(handle_); }

  void publish(const Sample *samples, std::size_t count) {
    if (const int code = koseki_publish(handle_, samples, count))
      throw Error(code);
  }

  // See koseki_limit_clock.
  void limit_clock(std::chrono::duration<double> limit) {
    if (const int code = koseki_limit_clock(handle_, limit.count()))
      throw Error(code);
  }

private:
  koseki_publisher *handle_ = nullptr;
};

// Writer of a source that the configuration calls external, in degrees or metres: see koseki_feed.
class Source {
public:
  Source(const std::string &instance, const std::string &source) {
    if (const int code = koseki_feed(instance.c_str(), source.c_str(), &handle_))
      throw Error(code);
  }
  Source(Source &&other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  Source &operator=(Source &&other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Source() { koseki_unadvertise(handle_); }

  void send(const std::vector<koseki_detection> &detections) {
    if (const int code = koseki_send_detections(handle_, detections.data(), detections.size()))
      throw Error(code);
  }
  void send(const std::vector<koseki_track_report> &reports) {
    if (const int code = koseki_send_track_reports(handle_, reports.data(), reports.size()))
      throw Error(code);
  }
  // See koseki_limit_clock.
  void limit_clock(std::chrono::duration<double> limit) {
    if (const int code = koseki_limit_clock(handle_, limit.count()))
      throw Error(code);
  }

private:
  koseki_publisher *handle_ = nullptr;
};

// Gives an order, such as "out source=radar", and returns the order's state; see koseki_order. Throws without an answer in time.
inline KosekiOrderState order(const std::string &instance, const std::string &words, const std::string &operator_name,
                              std::chrono::duration<double> lasts = {},
                              std::chrono::milliseconds timeout = std::chrono::seconds(10)) {
  KosekiOrderState state = {};
  if (const int code = koseki_order(instance.c_str(), words.c_str(), operator_name.c_str(), lasts.count(),
                                    timeout.count(), &state))
    throw Error(code);
  return state;
}

} // namespace koseki
#endif

// odom::Client: the car's pose from odomd, for C++17 and later. A header over libodom.
//
//   odom::Result<odom::Client> client = odom::Client::open();
//   odom::Pose last{};
//   while (client) {
//     const auto pose = client->wait(last, std::chrono::milliseconds(100));
//     if (!pose) break;  // silent, or ended: see pose.status
//     last = *pose;      // check mode and odom::position_sigma() before you steer
//   }
//
// Nothing here throws, allocates (except open) or locks: every call returns a Result, which is true
// only when it is fresh. Use has_value() to accept stale values. Thread-safety is that of libodom:
// a Client belongs to one thread at a time. Errors, units and ranges are documented in
// <odom/odom.h>.
#ifndef ODOM_ODOM_HPP
#define ODOM_ODOM_HPP

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include <odom/odom.h>

namespace odom {

using Status = odom_status;
using Pose = odom_pose;
using Details = odom_details;
using Info = odom_info;
using Beat = odom_beat;
using CameraMessage = odom_camera_message;

/// A value with its status.
template <class Value>
struct Result {
  Status status = ODOM_INVALID;
  Value value{};

  /// The value exists and is fresh.
  explicit operator bool() const noexcept { return status == ODOM_OK; }
  /// The value exists, but its daemon may be silent.
  [[nodiscard]] bool has_value() const noexcept {
    return status == ODOM_OK || status == ODOM_STALE;
  }
  [[nodiscard]] const char* message() const noexcept { return odom_strstatus(status); }

  Value& operator*() noexcept { return value; }
  const Value& operator*() const noexcept { return value; }
  Value* operator->() noexcept { return &value; }
  const Value* operator->() const noexcept { return &value; }
};

/// A pose with the details of the same tick.
struct DetailedPose {
  Pose pose{};
  Details details{};
};

/// A pose in the segment. Valid only inside Client::read_in_place().
class View {
 public:
  explicit View(const odom_view& view) noexcept : view_(&view) {}

  [[nodiscard]] std::uint64_t tick() const noexcept { return word(ODOM_WORD_TICK); }
  [[nodiscard]] std::int64_t time_ns() const noexcept {
    return static_cast<std::int64_t>(word(ODOM_WORD_TIME));
  }
  [[nodiscard]] double x() const noexcept { return number(ODOM_WORD_X); }
  [[nodiscard]] double y() const noexcept { return number(ODOM_WORD_Y); }
  [[nodiscard]] double yaw() const noexcept { return number(ODOM_WORD_YAW); }
  [[nodiscard]] double odom_x() const noexcept { return number(ODOM_WORD_ODOM_X); }
  [[nodiscard]] double odom_y() const noexcept { return number(ODOM_WORD_ODOM_Y); }
  [[nodiscard]] double odom_yaw() const noexcept { return number(ODOM_WORD_ODOM_YAW); }
  [[nodiscard]] double vx() const noexcept { return number(ODOM_WORD_VX); }
  [[nodiscard]] double vy() const noexcept { return number(ODOM_WORD_VY); }
  [[nodiscard]] double yaw_rate() const noexcept { return number(ODOM_WORD_YAW_RATE); }
  [[nodiscard]] double steering() const noexcept { return number(ODOM_WORD_STEERING); }
  [[nodiscard]] odom_mode mode() const noexcept {
    return static_cast<odom_mode>(static_cast<std::uint32_t>(word(ODOM_WORD_MODE)));
  }
  [[nodiscard]] std::uint32_t conditions() const noexcept {
    return static_cast<std::uint32_t>(word(ODOM_WORD_MODE) >> 32U);
  }
  [[nodiscard]] std::uint32_t reset_count() const noexcept {
    return static_cast<std::uint32_t>(word(ODOM_WORD_RESETS));
  }
  [[nodiscard]] std::uint32_t health() const noexcept {
    return static_cast<std::uint32_t>(word(ODOM_WORD_RESETS) >> 32U);
  }

  /// Any word of the slot, by its ODOM_WORD_ position.
  [[nodiscard]] std::uint64_t word(std::size_t index) const noexcept {
    return odom_view_word(view_, index);
  }
  [[nodiscard]] double number(std::size_t index) const noexcept {
    return odom_view_double(view_, index);
  }

 private:
  const odom_view* view_;
};

/// `from` at a time up to 100 ms ahead of it. See odom_predict().
[[nodiscard]] inline Result<Pose> predict(const Pose& from, std::int64_t time_ns) noexcept {
  Result<Pose> result;
  result.status = odom_predict(&from, time_ns, &result.value);
  return result;
}

/// The name of Pose::mode: "dead_reckoning". See odom_mode_name().
[[nodiscard]] inline const char* mode_name(std::uint32_t mode) noexcept {
  return odom_mode_name(mode);
}

/// Largest standard deviation of the position over all directions [m]. See odom_position_sigma().
[[nodiscard]] inline double position_sigma(const Pose& pose) noexcept {
  return odom_position_sigma(&pose);
}

/// Attached to a segment, or to none (then every call returns ODOM_INVALID).
class Client {
 public:
  Client() noexcept = default;

  /// See odom_open(). Allocates: not for the control loop.
  [[nodiscard]] static Result<Client> open(const char* name = nullptr) noexcept {
    Result<Client> result;
    odom_client* client = nullptr;
    result.status = odom_open(name, &client);
    result.value.client_.reset(client);
    return result;
  }

  [[nodiscard]] Result<Pose> latest() noexcept {
    Result<Pose> result;
    result.status = odom_latest(client_.get(), &result.value, sizeof result.value);
    return result;
  }

  [[nodiscard]] Result<DetailedPose> latest_details() noexcept {
    Result<DetailedPose> result;
    result.status = odom_latest_details(client_.get(), &result.value.pose, sizeof(Pose),
                                        &result.value.details, sizeof(Details));
    return result;
  }

  /// The newest pose, predicted to a time up to 100 ms ahead of it. An earlier time is looked up in
  /// the history.
  [[nodiscard]] Result<Pose> predict(std::int64_t time_ns) noexcept {
    Result<Pose> result = latest();
    if (!result.has_value()) return result;
    if (time_ns <= result.value.time_ns) return at(time_ns);
    const Status predicted = odom_predict(&result.value, time_ns, &result.value);
    if (predicted != ODOM_OK) result.status = predicted;
    return result;
  }

  [[nodiscard]] Result<Pose> at(std::int64_t time_ns) noexcept {
    Result<Pose> result;
    result.status = odom_at(client_.get(), time_ns, &result.value, sizeof result.value);
    return result;
  }

  /// Sleeps until a pose newer than `last` is published; see odom_wait(). With a value-initialised
  /// `last` waits for the next one.
  [[nodiscard]] Result<Pose> wait(const Pose& last, std::chrono::nanoseconds timeout) noexcept {
    Result<Pose> result;
    result.value = last;
    const std::int64_t timeout_ns = timeout.count() < 0 ? 0 : timeout.count();
    result.status = odom_wait(client_.get(), &result.value, sizeof result.value, timeout_ns);
    return result;
  }

  /// Calls `read(View)` on the newest pose in place, and again if the writer has overtaken it,
  /// three times at most. The values that `read` has read are valid only when this returns ODOM_OK
  /// or ODOM_STALE.
  template <class Read>
  [[nodiscard]] Status read_in_place(Read&& read) {
    for (int attempt = 0; attempt < 3; ++attempt) {
      odom_view view{};
      const Status status = odom_begin(client_.get(), &view);
      if (status != ODOM_OK && status != ODOM_STALE) return status;
      read(View(view));
      if (odom_validate(&view) != 0) return status;
    }
    return ODOM_BUSY;
  }

  [[nodiscard]] Result<Info> info() noexcept {
    Result<Info> result;
    result.status = odom_get_info(client_.get(), &result.value, sizeof result.value);
    return result;
  }

  [[nodiscard]] Result<Beat> beat() noexcept {
    Result<Beat> result;
    result.status = odom_get_beat(client_.get(), &result.value, sizeof result.value);
    return result;
  }

  [[nodiscard]] Result<std::int64_t> to_clock(odom_clock clock, std::int64_t time_ns) noexcept {
    Result<std::int64_t> result;
    result.status = odom_to_clock(client_.get(), clock, time_ns, &result.value);
    return result;
  }

 private:
  struct Close {
    void operator()(odom_client* client) const noexcept { odom_close(client); }
  };
  std::unique_ptr<odom_client, Close> client_;
};

/// Sends camera poses to the daemon. Errors are negative errnos, 0 is success.
class CameraSender {
 public:
  /// See odom_camera_open(). Closes an earlier connection.
  [[nodiscard]] int open(const char* path = nullptr) noexcept {
    odom_camera* camera = nullptr;
    const int error = odom_camera_open(path, &camera);
    camera_.reset(camera);
    return error;
  }

  /// Never blocks; see odom_camera_send().
  [[nodiscard]] int send(const CameraMessage& message) noexcept {
    return odom_camera_send(camera_.get(), &message);
  }

  /// See odom_camera_flush().
  [[nodiscard]] int flush(std::int64_t timeout_ns) noexcept {
    return odom_camera_flush(camera_.get(), timeout_ns);
  }

 private:
  struct Close {
    void operator()(odom_camera* camera) const noexcept { odom_camera_close(camera); }
  };
  std::unique_ptr<odom_camera, Close> camera_;
};

}  // namespace odom

#endif

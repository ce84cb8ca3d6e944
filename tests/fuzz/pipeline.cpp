// Any sequence of frames, camera messages and ticks through the pipeline: no tick publishes NaN or
// infinity, a negative variance, or an earlier time.
//
// The input is a model (one byte) and then commands: a frame (0-5: the signal; two signed bytes:
// the stamp relative to the clock in units of 0.1 ms; eight bytes of payload), a camera message (6:
// its bytes on the wire), or a tick (all others).
#include <algorithm>
#include <array>

#include "daemon/sockets/camera_server.hpp"
#include "tests/fuzz/bare_car.hpp"

using odomd::fuzz::Input;
using odomd::fuzz::period_ns;
using odomd::fuzz::signals;
using odomd::fuzz::start_ns;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Input input(data, size);
  const auto model = static_cast<odomd::estimator::Model>(input.take<std::uint8_t>() %
                                                          odomd::estimator::model_names.size());
  const auto pipeline = odomd::fuzz::pipeline_of(odomd::fuzz::config(model), true);
  const odomd::WallClock wall = odomd::fuzz::wall_clock();
  const odomd::daemon::MessageClocks clocks{wall, start_ns / 2};

  std::uint64_t number = 1;
  std::int64_t now = start_ns;
  while (!input.empty()) {
    const auto command = input.take<std::uint8_t>();
    if (command < signals.size()) {
      odomd::can::Frame frame;
      frame.id = 256U + command;
      frame.length = 8;
      frame.time_ns = now + std::int64_t{input.take<std::int16_t>()} * 100'000;
      const auto payload = input.take<std::array<std::uint8_t, 8>>();
      std::copy(payload.begin(), payload.end(), frame.data.begin());
      pipeline->take(frame, now);
    } else if (command == signals.size()) {
      const auto bytes = input.take<std::array<std::byte, sizeof(odom_camera_message)>>();
      const auto message =
          odomd::daemon::read_camera_message(bytes, sizeof(odom_camera_message), clocks, now);
      if (message.cause == odomd::daemon::MalformedCause::none)
        pipeline->take(message.pose);
      else
        pipeline->take_malformed_camera_message();
    } else {
      now += period_ns;
      odomd::fuzz::check(pipeline->tick(number++, now), now);
    }
  }
  return 0;
}

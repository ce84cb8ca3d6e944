#include "daemon/housekeeping/controller_watch.hpp"

#include <pthread.h>

#include <algorithm>
#include <chrono>
#include <utility>

namespace odomd::daemon {
namespace {

constexpr std::chrono::milliseconds look_every{1000};
constexpr std::chrono::milliseconds look_at_most_every{100};  // even if there are many events

}  // namespace

ControllerWatch::ControllerWatch(std::vector<std::string> interfaces)
    : interfaces_(std::move(interfaces)), seen_(interfaces_.size()) {
  const bool any = std::ranges::any_of(interfaces_, [](const auto& name) { return !name.empty(); });
  if (any) thread_ = std::thread([this] { run(); });
}

ControllerWatch::~ControllerWatch() {
  {
    const std::scoped_lock lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
}

std::optional<can::Controller> ControllerWatch::latest(std::size_t bus) const {
  const std::scoped_lock lock(mutex_);
  return seen_[bus];
}

void ControllerWatch::look_again() {
  {
    const std::scoped_lock lock(mutex_);
    asked_ = true;
  }
  wake_.notify_one();
}

void ControllerWatch::run() {
  ::pthread_setname_np(::pthread_self(), "odomd-buses");
  std::unique_lock lock(mutex_);
  while (!stop_) {
    asked_ = false;
    for (std::size_t bus = 0; bus < interfaces_.size() && !stop_; ++bus) {
      if (interfaces_[bus].empty()) continue;
      lock.unlock();
      auto controller = can::read_controller(interfaces_[bus]);
      lock.lock();
      seen_[bus] = std::move(controller);
    }
    wake_.wait_for(lock, look_at_most_every, [this] { return stop_; });
    wake_.wait_for(lock, look_every - look_at_most_every, [this] { return stop_ || asked_; });
  }
}

}  // namespace odomd::daemon

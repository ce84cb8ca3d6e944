#include "estimator/full/sample_window.hpp"

namespace odomd::estimator::full {

Insertion SampleWindow::insert(const Sample& sample) noexcept {
  if (end_ - begin_ == capacity) {
    lost_until_ns_ = samples_[begin_].time_ns;
    ++begin_;
  }
  if (end_ == samples_.size()) {
    std::copy(samples_.begin() + static_cast<std::ptrdiff_t>(begin_), samples_.end(),
              samples_.begin());
    end_ -= begin_;
    begin_ = 0;
  }
  // From the back: nearly always the newest.
  std::size_t at = end_;
  while (at > begin_ && sample < samples_[at - 1]) {
    --at;
  }
  const auto same = [&](const Sample& other) {
    return other.time_ns == sample.time_ns && other.source == sample.source;
  };
  if (at > begin_ && same(samples_[at - 1])) {
    return Insertion::duplicate;
  }
  if (at < end_ && same(samples_[at])) {
    samples_[at] = sample;
    return Insertion::replaced;
  }
  std::move_backward(samples_.begin() + static_cast<std::ptrdiff_t>(at),
                     samples_.begin() + static_cast<std::ptrdiff_t>(end_),
                     samples_.begin() + static_cast<std::ptrdiff_t>(end_ + 1));
  samples_[at] = sample;
  ++end_;
  return Insertion::inserted;
}

void SampleWindow::forget(std::int64_t time_ns) noexcept {
  while (begin_ < end_ && samples_[begin_].time_ns <= time_ns) {
    ++begin_;
  }
}

std::span<Sample> SampleWindow::after(std::int64_t time_ns) noexcept {
  std::size_t first = end_;
  while (first > begin_ && samples_[first - 1].time_ns > time_ns) {
    --first;
  }
  return {samples_.data() + first, end_ - first};
}

}  // namespace odomd::estimator::full

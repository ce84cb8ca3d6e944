// docs/model.md, "Late samples".
#include "estimator/ekf/sample_window.hpp"

#include <algorithm>

namespace odomd::estimator::full {

Insertion SampleWindow::insert(const Sample& sample) noexcept {
  // From the back: most samples are the newest.
  std::size_t at = end_;
  while (at > begin_ && sample < samples_[at - 1]) {
    --at;
  }
  const auto same = [&](const Sample& other) {
    // Several cameras may take pictures at the same instant.
    return other.time_ns == sample.time_ns && other.source == sample.source &&
           (sample.source != Source::camera || other.value == sample.value);
  };
  if (at > begin_ && same(samples_[at - 1])) {
    return Insertion::duplicate;
  }
  if (at < end_ && same(samples_[at])) {
    const bool judged = samples_[at].judged;
    samples_[at] = sample;
    samples_[at].judged = judged;
    return Insertion::replaced;
  }
  if (end_ - begin_ == capacity) {
    if (at == begin_) {
      dropped_until_ns_ = std::max(dropped_until_ns_, sample.time_ns);
      return Insertion::dropped;
    }
    const Sample& oldest = samples_[begin_];
    dropped_until_ns_ = oldest.time_ns;
    dropped_[index_of(oldest.source)] += oldest.judged ? 0 : 1;
    ++begin_;
  }
  if (end_ == samples_.size()) {
    std::copy(samples_.begin() + static_cast<std::ptrdiff_t>(begin_), samples_.end(),
              samples_.begin());
    at -= begin_;
    end_ -= begin_;
    begin_ = 0;
  }
  std::move_backward(samples_.begin() + static_cast<std::ptrdiff_t>(at),
                     samples_.begin() + static_cast<std::ptrdiff_t>(end_),
                     samples_.begin() + static_cast<std::ptrdiff_t>(end_ + 1));
  samples_[at] = sample;
  ++end_;
  return Insertion::inserted;
}

std::size_t SampleWindow::end_of(std::int64_t time_ns) const noexcept {
  const auto first = samples_.begin() + static_cast<std::ptrdiff_t>(begin_);
  const auto last = samples_.begin() + static_cast<std::ptrdiff_t>(end_);
  return static_cast<std::size_t>(
      std::ranges::upper_bound(first, last, time_ns, {}, &Sample::time_ns) - samples_.begin());
}

}  // namespace odomd::estimator::full

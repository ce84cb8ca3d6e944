// Any segment of a predecessor: it is refused in one line, or ignored, or each model can resume
// from its last pose without publishing NaN or infinity.
//
// The input is a model (one byte), whether the newest slot gets its correct checksum (one byte: if
// odd), the length to cut off the file (two bytes, in words) and then changes of a valid segment: a
// word's index (two bytes) and its new value (eight bytes).
#include <sys/stat.h>

#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "shm_api/layout/segment.h"
#include "shm_api/layout/slot.h"
#include "shm_api/writer.hpp"
#include "tests/fuzz/bare_car.hpp"
#include "tests/scratch.hpp"

namespace odomd::fuzz {
namespace {

constexpr std::uint64_t slots = 4;
constexpr std::uint64_t ticks = 6;

/// All signals are 1.
void drive(daemon::Pipeline& pipeline, std::int64_t now_ns) {
  constexpr double one = 1.0;
  for (std::size_t i = 0; i < signals.size(); ++i) {
    can::Frame frame{
        .time_ns = now_ns - 1'000'000, .id = 256U + static_cast<std::uint32_t>(i), .length = 8};
    std::memcpy(frame.data.data(), &one, sizeof one);
    pipeline.take(frame, now_ns);
  }
}

/// A segment on disk, and its words as a correct predecessor left them.
class Predecessor {
 public:
  Predecessor() {
    odom_info info{};
    info.period_ns = period_ns;
    const auto pipeline = pipeline_of(config(estimator::Model::full), false);
    shm::Writer writer(settings_, info);
    for (std::uint64_t i = 1; i <= ticks; ++i) {
      const std::int64_t now = start_ns + static_cast<std::int64_t>(i) * period_ns;
      drive(*pipeline, now);
      const auto& record = pipeline->tick(i, now);
      require(record.pose.mode != ODOM_INITIALISING, "the predecessor knows where it is");
      require(writer.publish(record.pose, record.details), "a tick is published");
    }
    const std::string bytes = contents(settings_.name);
    words_.resize(bytes.size() / sizeof(std::uint64_t));
    std::memcpy(words_.data(), bytes.data(), bytes.size());
  }

  [[nodiscard]] const shm::SegmentSettings& settings() const { return settings_; }
  [[nodiscard]] const std::vector<std::uint64_t>& words() const { return words_; }

  void leave(const std::vector<std::uint64_t>& words) const {
    std::ofstream file(settings_.name, std::ios::binary | std::ios::trunc);
    file.write(reinterpret_cast<const char*>(words.data()),
               static_cast<std::streamsize>(words.size() * sizeof(std::uint64_t)));
    file.close();
    require(file.good(), "the segment is written");
    require(::chmod(settings_.name.c_str(), 0600) == 0, "chmod");
  }

 private:
  Scratch directory_;
  shm::SegmentSettings settings_{.name = directory_.path("segment"), .slots = slots, .mode = 0600};
  std::vector<std::uint64_t> words_;
};

/// Gives the newest slot the checksum of its contents.
void seal(std::vector<std::uint64_t>& words) {
  const std::uint64_t newest = odomi_tick(words[ODOM_HEADER_HEAD]) & (slots - 1);
  std::uint64_t* slot = words.data() + ODOM_SEGMENT_HEADER_WORDS + newest * ODOM_SLOT_WORDS;
  slot[ODOM_SLOT_CHECKSUM] =
      odomi_checksum(slot + ODOM_SLOT_POSE, ODOM_POSE_WORDS + ODOM_DETAILS_WORDS);
}

void go_on_from(const shm::Inheritance& last, estimator::Model model) {
  const auto pipeline = pipeline_of(config(model), false);
  std::int64_t now = start_ns + static_cast<std::int64_t>(ticks) * period_ns + 1'000'000;
  if (const auto age_ns = daemon::resumable_pose_age(last.pose, now)) {
    require(*age_ns >= 0 && *age_ns < daemon::inheritance_ns, "its age is in range");
    static_cast<void>(pipeline->resume(last.pose, last.details, *age_ns));
  }
  for (std::uint64_t i = 1; i <= 3; ++i) {
    now += period_ns;
    check(pipeline->tick(i, now), now);
  }
}

void run(Input input) {
  static const Predecessor predecessor;
  const auto model =
      static_cast<estimator::Model>(input.take<std::uint8_t>() % estimator::model_names.size());
  const bool sealed = (input.take<std::uint8_t>() & 1U) != 0;
  std::vector<std::uint64_t> words = predecessor.words();
  const std::size_t cut = input.take<std::uint16_t>();
  while (!input.empty()) {
    const std::size_t index = input.take<std::uint16_t>() % words.size();
    words[index] = input.take<std::uint64_t>();
  }
  if (sealed) seal(words);
  words.resize(words.size() - cut % words.size());
  predecessor.leave(words);
  try {
    const shm::Claim claim(predecessor.settings());
    require(!claim.predecessor() || !claim.predecessor_is_damaged(),
            "what is damaged is not given");
    if (claim.predecessor()) go_on_from(*claim.predecessor(), model);
  } catch (const std::runtime_error& error) {
    require_one_line(error.what());
  }
}

}  // namespace
}  // namespace odomd::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  odomd::fuzz::run({data, size});
  return 0;
}

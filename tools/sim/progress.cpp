#include "tools/sim/progress.hpp"

#include <unistd.h>

#include <chrono>

#include <fmt/format.h>

#include "tools/cli/output.hpp"

namespace odomd::sim {
namespace {

std::int64_t steady_ns() {
  return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

}  // namespace

std::string progress_text(const Simulation& simulation) {
  const Driver& driver = simulation.driver();
  return fmt::format("{:.1f} s, {:.1f} of {:.1f} m ({:.0f} %), {:.2f} m/s",
                     1e-9 * static_cast<double>(simulation.time_ns()), driver.progress(),
                     driver.total(), 100.0 * driver.progress() / driver.total(),
                     simulation.plant().output().v_x);
}

Progress::Progress(ShowProgress show, ShowProgress otherwise) {
  if (show == ShowProgress::never) return;
  if (::isatty(STDERR_FILENO) != 0)
    style_ = Style::one_line;
  else if (show == ShowProgress::always || otherwise == ShowProgress::always)
    style_ = Style::lines;
}

void Progress::update(const Simulation& simulation) {
  if (style_ == Style::silent) return;
  const std::int64_t now = steady_ns();
  if (now < next_ns_) return;
  next_ns_ = now + (style_ == Style::one_line ? 100'000'000 : 1'000'000'000);
  show(simulation);
}

void Progress::finish(const Simulation& simulation) {
  if (style_ == Style::silent) return;
  show(simulation);
  if (style_ == Style::one_line) tools::draw("\n");
}

void Progress::show(const Simulation& simulation) {
  if (style_ == Style::one_line)
    tools::draw('\r' + progress_text(simulation) + "\x1b[K");
  else
    tools::say("odom sim: " + progress_text(simulation));
}

}  // namespace odomd::sim

// odom watch: a daemon live on the terminal.
#include <poll.h>
#include <unistd.h>

#include <thread>
#include <tuple>

#include "tools/commands/commands.hpp"
#include "tools/live/watch/observer.hpp"
#include "tools/live/watch/page.hpp"
#include "tools/live/watch/terminal.hpp"

namespace odomd::tools {
namespace {

using std::chrono::steady_clock;

struct WatchOptions {
  watch::Target target;
  double interval_s = 0.5;
  bool once = false;
};

steady_clock::duration interval_of(const WatchOptions& options) {
  return std::chrono::duration_cast<steady_clock::duration>(
      std::chrono::duration<double>(options.interval_s));
}

void scroll(watch::Key key, std::size_t most, watch::View& view) {
  const auto page = std::max<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(view.rows / 2), 1);
  const std::ptrdiff_t step = key == watch::Key::up          ? -1
                              : key == watch::Key::down      ? 1
                              : key == watch::Key::page_up   ? -page
                              : key == watch::Key::page_down ? page
                                                             : 0;
  const auto last = static_cast<std::ptrdiff_t>(most);
  const auto first = static_cast<std::ptrdiff_t>(std::min(view.scrolled, most));
  view.scrolled = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(first + step, 0, last));
}

void watch_on_screen(const WatchOptions& options, watch::Observer& observer) {
  watch::Terminal terminal{watch::colour_wanted()};
  watch::View view;
  auto next = steady_clock::now();
  while (true) {
    if (!view.paused && steady_clock::now() >= next) {
      observer.look();
      next = std::max(next + interval_of(options), steady_clock::now());
    }
    std::tie(view.columns, view.rows) = watch::Terminal::size();
    const watch::Picture picture = draw(observer.state(), view);
    terminal.show(screen(picture, view));

    constexpr auto while_paused = std::chrono::seconds{10};
    const auto happened = terminal.wait(view.paused ? steady_clock::now() + while_paused : next);
    if (happened.ended) return;
    for (const watch::Key key : happened.keys) {
      if (key == watch::Key::quit) return;
      if (key == watch::Key::pause) view.paused = !view.paused;
      scroll(key, most_scrolled(picture, view), view);
    }
  }
}

void print(const watch::State& state) {
  const watch::Picture picture = draw(state, {.columns = 100, .rows = 40});
  std::cout << as_text(picture.head) << as_text(picture.body) << std::flush;
}

// Nothing is written meanwhile, so only poll() shows that the reader of a pipe has gone.
bool has_reader() {
  pollfd output{STDOUT_FILENO, 0, 0};
  return ::poll(&output, 1, 0) <= 0 || (output.revents & (POLLERR | POLLHUP)) == 0;
}

std::string why_absent(const watch::State& state) {
  return state.segment_problem.empty() ? state.status_problem
                                       : state.segment_name + ": " + state.segment_problem;
}

std::string why_waiting(const watch::State& state) {
  if (state.segment)
    return "the daemon has stopped publishing: this was its last state; waiting for it or the next "
           "one";
  const std::string why = why_absent(state);
  return why + (why.ends_with('?') ? "" : ".") + " Waiting for it; --once does not";
}

// Prints a snapshot per interval; without a daemon only one, and a line on standard error.
void watch_on_paper(const WatchOptions& options, watch::Observer& observer) {
  Interrupt interrupt;
  bool waiting = false;
  for (auto next = steady_clock::now(); std::cout && has_reader() && !interrupt.requested();
       next += interval_of(options)) {
    observer.look();
    const bool silent = !observer.state().segment || observer.state().segment->silent;
    if (silent && !waiting) say("odom watch: " + why_waiting(observer.state()));
    if (!silent || !waiting) {
      print(observer.state());
      std::cout << '\n' << std::flush;
    }
    waiting = silent;
    constexpr auto nap = std::chrono::milliseconds{50};
    while (steady_clock::now() < next + interval_of(options) && has_reader() &&
           !interrupt.requested()) {
      std::this_thread::sleep_for(std::min<steady_clock::duration>(nap, interval_of(options)));
    }
  }
}

void print_once(watch::Observer& observer) {
  constexpr auto between = std::chrono::milliseconds{500};
  observer.look();
  if (observer.state().segment || observer.state().status) {
    std::this_thread::sleep_for(between);  // for current rates, not averages since the start
    observer.look();
  }
  if (!observer.state().segment) {
    throw std::runtime_error(why_absent(observer.state()));
  }
  print(observer.state());
  if (observer.state().segment->silent) {
    throw std::runtime_error("the daemon has stopped publishing: this was its last state");
  }
}

void run(const WatchOptions& options) {
  watch::Observer observer{options.target};
  if (options.once) {
    print_once(observer);
  } else if (watch::is_screen()) {
    watch_on_screen(options, observer);
  } else {
    watch_on_paper(options, observer);
  }
}

}  // namespace

void add_watch(Command odom) {
  auto options = std::make_shared<WatchOptions>();
  Command command = odom.add_subcommand("watch", "Watch the daemon live on the terminal");
  add_segment_option(command, options->target.segment, SegmentElse::of_socket);
  add_socket_option(command, options->target.socket, "status");
  command.add("--interval", "S", options->interval_s,
              "Interval between updates [s], 0.05 to 3600; default: 0.5",
              {within(0.05, 3600.0, Bounds::in_text)});
  command.add_flag("--once", options->once, "Print one snapshot and exit");
  command.footer(
      "Examples:\n"
      "  odom watch\n"
      "  odom watch --interval 0.1\n"
      "  odom watch --interval 60 >> drive.txt\n"
      "Keys: q ends, p pauses and continues, arrows and page keys scroll. If no daemon is\n"
      "running, it waits for one; it continues when the daemon restarts. If standard output is\n"
      "not a terminal, a plain snapshot is printed every interval; while it waits, it says so\n"
      "on standard error. NO_COLOR=1 turns colours off.");
  command.callback([options] { run(*options); });
}

}  // namespace odomd::tools

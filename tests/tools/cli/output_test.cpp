// Standard output and error under adverse conditions: pipes that nobody empties, and external text
// with control characters for a terminal.
#include "tools/cli/output.hpp"

#include <fcntl.h>
#include <unistd.h>

#include "base/file_descriptor.hpp"
#include "tests/tools/child.hpp"
#include "tests/tools/own_daemon.hpp"
#include "tests/tools/scratch.hpp"

namespace odomd::tools::output_test {
namespace {

using std::chrono::steady_clock;

/// A pipe that is full, with both ends open.
class StuckPipe {
 public:
  StuckPipe() {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("pipe2");
    reader_ = FileDescriptor{ends[0]};
    writer_ = FileDescriptor{ends[1]};
    const std::string page(4096, '\n');
    ::fcntl(ends[1], F_SETFL, O_NONBLOCK);
    while (::write(ends[1], page.data(), page.size()) > 0) {
    }
    ::fcntl(ends[1], F_SETFL, 0);
  }
  [[nodiscard]] int writer() const { return writer_.get(); }

 private:
  FileDescriptor reader_;
  FileDescriptor writer_;
};

class StuckOutput : public ::testing::Test {
 protected:
  /// The outcome after SIGTERM, which is sent once the program has had time to block on its output.
  Outcome end_of(std::vector<std::string> arguments, int stuck) {
    daemon_.tick();
    const StuckPipe pipe;
    Child odom(scratch_, "odom", std::move(arguments), {stuck, pipe.writer()});
    const auto guard = steady_clock::now() + std::chrono::seconds{60};
    while (!holds_term_back(odom) && steady_clock::now() < guard) tick();
    for (int i = 0; i < 200; ++i) tick();
    return odom.terminate();
  }

  Scratch scratch_;
  std::string segment_ = scratch_.path("pose").string();

 private:
  /// Whether the program blocks SIGTERM. Until then, SIGTERM would kill it.
  static bool holds_term_back(const Child& odom) {
    const std::string status = contents("/proc/" + std::to_string(odom.pid()) + "/status");
    const std::size_t at = status.find("SigBlk:");
    return at != std::string::npos &&
           (std::stoull(status.substr(at + 7), nullptr, 16) >> (SIGTERM - 1) & 1U) != 0;
  }
  void tick() {
    daemon_.tick();
    std::this_thread::sleep_for(std::chrono::milliseconds{5});
  }

  SlowDaemon daemon_{segment_, 5'000'000};
};

TEST_F(StuckOutput, IsNotWaitedForOnceTermHasCome) {
  using Arguments = std::vector<std::string>;
  for (const Arguments& arguments : {Arguments{"sim", "--live"},
                                     {"pose", "--follow", "--csv", "--shm", segment_},
                                     {"watch", "--interval", "0.05", "--shm", segment_}})
    EXPECT_THAT(end_of(arguments, STDOUT_FILENO),
                Ends(1, EndsWith("nobody was reading when INT or TERM came; the rest is lost\n")))
        << arguments.front();
  EXPECT_EQ(end_of({"sim", "--live", "--progress"}, STDERR_FILENO).status, 0);
}

TEST(OutputBuffer, WritesWholeLinesAndWhatIsFlushed) {
  const Scratch scratch;
  const FileDescriptor file{
      ::open(scratch.path("out").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600)};
  OutputBuffer buffer(file.get());
  std::ostream out(&buffer);
  out << "kg·m² " << 'x' << "\x1b[2J\t\r\n";
  EXPECT_EQ(scratch.text("out"), "");
  out.flush();
  EXPECT_EQ(scratch.text("out"), "kg·m² x\\u001b[2J\t\\u000d\n");
  const std::string line = std::string(1000, 'a') + "²\n";
  for (int i = 0; i < 100; ++i) out << line.substr(0, 1001) << line.substr(1001);
  out.flush();
  EXPECT_EQ(scratch.text("out").size(), 26 + 100 * line.size());
  EXPECT_THAT(scratch.text("out"), Not(HasSubstr("\\x")));
}

TEST(OutputBuffer, FailsForGood) {
  const FileDescriptor full{::open("/dev/full", O_WRONLY | O_CLOEXEC)};
  OutputBuffer buffer(full.get());
  std::ostream out(&buffer);
  out << "text" << std::flush;
  EXPECT_FALSE(out);
  out.clear();
  out << "more" << std::flush;
  EXPECT_FALSE(out);
}

// Input that a message repeats stays on one line, without control characters.

constexpr const char* nasty =
    R"sh("$(printf 'a\033[2J\033]0;x\007\nodom: \302\233all is well\r')")sh";
constexpr const char* huge = R"sh("$(head -c 100000 /dev/zero | tr '\0' x)")sh";

TEST(Messages, AreOneHarmlessLine) {
  const std::vector<std::string> commands{
      "odom ",
      "odom --",
      "odom pose --shm /",
      "odom pose --clock ",
      "odom pose --wait ",
      "odom replay --can x --config ",
      "odom dbc show ",
      "odom plot x.csv --what ",
      "odom sim --out x --scenario ",
      "odom sim --out x --fix ",
      "odom status --socket ",
      "odom export --drive ",
      "odom bridge --ros --frame-map ",
      "odomd --config ",
      "odomd --config car.toml --model ",
      "odomd --config car.toml --",
  };
  for (const std::string& command : commands) {
    for (const char* given : {nasty, huge}) {
      const Outcome outcome = run_shell(command + given);
      EXPECT_NE(outcome.status, 0) << command;
      EXPECT_LT(outcome.err.size(), 1100U) << command;
      EXPECT_EQ(outcome.err.find('\n'), outcome.err.size() - 1) << command << outcome.err;
      EXPECT_THAT(outcome.err, AllOf(Not(HasSubstr("\x1b")), Not(HasSubstr("\x07")),
                                     Not(HasSubstr("\r")), Not(HasSubstr("\xC2\x9B"))))
          << command;
    }
  }
}

TEST(Messages, RepeatNothingHarmfulOfAFile) {
  const Scratch scratch;
  scratch.write("car.dbc",
                "BO_ 1 M: 8 X\n SG_ S : 0|8@1+ (1,0) [0|0] \"\xC2\x9B"
                "1m\" X\nCM_ SG_ 1 S \"a\xC2\x9B"
                "2Jb\";\n");
  EXPECT_THAT(must_run("odom dbc show " + scratch.path("car.dbc").string()),
              AllOf(HasSubstr("\\u009b"), Not(HasSubstr("\xC2\x9B"))));
  scratch.write("pose.csv", "t,x,y,\x1b[2Jyaw\n");
  const Outcome refused = run_shell("odom plot --out " + scratch.path("x.svg").string() + " " +
                                    scratch.path("pose.csv").string());
  EXPECT_THAT(refused.err, AllOf(HasSubstr("\\u001b[2J"), Not(HasSubstr("\x1b"))));
}

}  // namespace
}  // namespace odomd::tools::output_test

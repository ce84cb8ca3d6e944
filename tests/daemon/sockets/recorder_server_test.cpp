// The recorder socket with recorders that read nothing, or slowly; odomd_record_test.cpp has those
// that read everything. The test sets the clock and makes the ticks.
#include "daemon/sockets/recorder_server.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <optional>

#include "daemon/core/pipeline.hpp"
#include "tests/daemon/core/one_wheel.hpp"
#include "tests/tools/scratch.hpp"
#include "tests/unix_socket.hpp"

namespace odomd::daemon::recorder_server_test {
namespace {

constexpr std::int64_t period_ns = 5'000'000;
constexpr std::int64_t turn_ns = 20'000'000;
constexpr std::int64_t second = 1'000'000'000;

/// A recorder's end of the connection. The test decides when it reads, and how much.
class Recorder {
 public:
  explicit Recorder(const std::filesystem::path& path)
      : connection_(connected_socket(path, SOCK_STREAM)) {
    EXPECT_TRUE(connection_);
  }

  /// Reads the bytes that have arrived, up to `most`; returns whether the connection has ended.
  bool read(std::size_t most = SIZE_MAX) const {
    std::array<char, 65536> piece{};
    for (std::size_t total = 0; total < most;) {
      const auto got = ::recv(connection_.get(), piece.data(), std::min(piece.size(), most - total),
                              MSG_DONTWAIT);
      if (got <= 0) return got == 0;
      total += static_cast<std::size_t>(got);
    }
    return false;
  }

 private:
  FileDescriptor connection_;
};

class RecorderServerTest : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::permissions(directory_, std::filesystem::perms{0755});
    config_.can.bindings = one_wheel::bindings();
    pipeline_ =
        std::make_unique<Pipeline>(config_, one_wheel::bus(), std::vector<std::string>{}, false);
    tap_ = std::make_unique<RecordingTap>(*pipeline_);
    static_cast<void>(buses_.index_of("can0"));
    journal_.emplace(LogConfig{directory_ / "log", "info"});
    server_.emplace(Recorded{config_, buses_, 0xABCDEF, *tap_},
                    LocalSocket({{directory_ / "record.sock", 0600}, SocketType::stream}),
                    std::vector<RecordingFile>{{"car.toml", "# a car\n"}});
  }
  Recorder connect() {
    Recorder recorder(directory_ / "record.sock");
    server_->accept(now_ns_, *journal_);
    return recorder;
  }

  /// Runs housekeeping periodically, and the beat's ticks in between.
  void run(std::int64_t duration_ns) {
    for (const std::int64_t end_ns = now_ns_ + duration_ns; now_ns_ < end_ns;) {
      for (int i = 0; i < turn_ns / period_ns; ++i) {
        const auto& record = pipeline_->tick(++tick_, now_ns_ += period_ns);
        tap_->tick_done(record, {now_ns_, 0, 0}, *pipeline_);
      }
      server_->serve(now_ns_, *journal_);
    }
  }

  /// Like run(), with a recorder that reads after each turn of housekeeping.
  void run_reading(const Recorder& recorder, std::int64_t duration_ns) {
    for (const std::int64_t end_ns = now_ns_ + duration_ns; now_ns_ < end_ns;) {
      run(turn_ns);
      recorder.read();
    }
  }

  [[nodiscard]] std::string log() const { return tools::contents(directory_ / "log"); }

  const tools::Scratch scratch_;
  const std::filesystem::path directory_ = scratch_.path("");
  Config config_;
  can::BusNames buses_;
  std::unique_ptr<Pipeline> pipeline_;
  std::unique_ptr<RecordingTap> tap_;
  std::optional<Journal> journal_;
  std::optional<RecorderServer> server_;
  std::int64_t now_ns_ = second;
  std::uint64_t tick_ = 0;
};

TEST_F(RecorderServerTest, DropsARecorderThatNeverReadsAndAcceptsTheNext) {
  const auto silent = connect();
  run(9 * second);
  EXPECT_THAT(log(), Not(HasSubstr("ended")));
  run(5 * second);  // the first messages still fitted into the socket
  const std::string said = log();
  EXPECT_THAT(said, HasSubstr("ticks: the recorder read nothing for 10 s"));
  EXPECT_EQ(said.find("ended after"), said.rfind("ended after")) << said;
  EXPECT_EQ(tap_->state(), RecordingTap::State::idle);

  const auto next = connect();
  run_reading(next, second);
  EXPECT_EQ(tap_->state(), RecordingTap::State::running);
  EXPECT_TRUE(silent.read());
  EXPECT_FALSE(next.read());
}

TEST_F(RecorderServerTest, KeepsARecorderThatReadsSeldomButEverything) {
  const auto slow = connect();
  for (int i = 0; i < 5; ++i) {
    run(8 * second);
    run_reading(slow, second);  // the rings empty as the socket gets room
    EXPECT_EQ(tap_->state(), RecordingTap::State::running);
  }
  EXPECT_THAT(log(), Not(HasSubstr("ended")));
}

// A recorder that reads too slowly falls behind until the rings are full. Then it has ten seconds
// for everything that is left; reading only a part does not extend them.
TEST_F(RecorderServerTest, DropsARecorderThatFallsBehind) {
  const auto dripping = connect();
  for (int i = 0; i < 30; ++i) {
    dripping.read(8192);
    run(second);
  }
  EXPECT_THAT(log(), HasSubstr("the recorder did not keep up"));
  EXPECT_EQ(tap_->state(), RecordingTap::State::idle);
}

}  // namespace
}  // namespace odomd::daemon::recorder_server_test

// The recorder socket with recorders that read everything, nothing, or slowly. The test sets the
// clock and makes the ticks.
#include "daemon/sockets/recorder_door.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>

#include "daemon/core/pipeline.hpp"
#include "tests/daemon/core/one_wheel.hpp"
#include "tests/tools/scratch.hpp"

namespace odomd::daemon::recorder_door_test {
namespace {

constexpr std::int64_t period_ns = 5'000'000;
constexpr std::int64_t turn_ns = 20'000'000;
constexpr std::int64_t second = 1'000'000'000;

/// A recorder's end of the connection. The test decides when it reads, and how much.
class Recorder {
 public:
  explicit Recorder(const std::filesystem::path& path)
      : connection_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.native().copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(
        ::connect(connection_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address),
        0);
  }

  /// The bytes that have arrived, up to `most`.
  void read(std::size_t most = SIZE_MAX) {
    std::array<char, 65536> piece{};
    for (std::size_t total = 0; total < most;) {
      const auto got = ::recv(connection_.get(), piece.data(), std::min(piece.size(), most - total),
                              MSG_DONTWAIT);
      ended_ = got == 0;
      if (got <= 0) return;
      bytes_.append(piece.data(), static_cast<std::size_t>(got));
      total += static_cast<std::size_t>(got);
    }
  }
  [[nodiscard]] bool ended() const { return ended_; }

  struct Message {
    RecordingMessage kind{};
    std::string bytes;
  };
  /// The next complete message of those bytes.
  std::optional<Message> next() {
    RecordingHeader header;
    if (bytes_.size() - at_ < sizeof header) return std::nullopt;
    std::memcpy(&header, bytes_.data() + at_, sizeof header);
    if (bytes_.size() - at_ < sizeof header + header.size) return std::nullopt;
    Message message{header.kind, bytes_.substr(at_ + sizeof header, header.size)};
    at_ += sizeof header + header.size;
    return message;
  }
  Message last() {
    Message newest;
    while (auto message = next()) newest = std::move(*message);
    return newest;
  }

 private:
  FileDescriptor connection_;
  std::string bytes_;
  std::size_t at_ = 0;
  bool ended_ = false;
};

class RecorderDoorTest : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::permissions(directory_, std::filesystem::perms{0755});
    config_.can.bindings = one_wheel::bindings();
    pipeline_ =
        std::make_unique<Pipeline>(config_, one_wheel::bus(), std::vector<std::string>{}, false);
    tap_ = std::make_unique<RecordingTap>(*pipeline_);
    static_cast<void>(buses_.index_of("can0"));
    journal_.emplace(LogConfig{directory_ / "log", "info"});
    door_.emplace(Recorded{config_, buses_, 0xABCDEF, *tap_},
                  LocalSocket({directory_ / "record.sock", SocketType::stream, 0600, ""}),
                  std::vector<RecordingFile>{{"car.toml", "# a car\n"}});
  }
  Recorder connect() {
    Recorder recorder(directory_ / "record.sock");
    door_->accept(now_ns_, *journal_);
    return recorder;
  }

  /// Runs housekeeping periodically, and the beat's ticks in between.
  void run(std::int64_t duration_ns) {
    for (const std::int64_t end_ns = now_ns_ + duration_ns; now_ns_ < end_ns;) {
      for (int i = 0; i < turn_ns / period_ns; ++i) {
        const auto& record = pipeline_->tick(++tick_, now_ns_ += period_ns);
        tap_->tick_done(record, {now_ns_, 0, 0}, *pipeline_);
      }
      door_->serve(now_ns_, *journal_);
    }
  }

  /// The same, with a recorder that reads after each turn.
  void run_reading(Recorder& recorder, std::int64_t duration_ns) {
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
  std::optional<RecorderDoor> door_;
  std::int64_t now_ns_ = second;
  std::uint64_t tick_ = 0;
};

TEST_F(RecorderDoorTest, SendsWhatAReplayNeedsAndThenEveryTick) {
  auto recorder = connect();
  run_reading(recorder, second);
  std::vector<RecordingMessage> kinds;
  std::size_t ticks = 0;
  while (const auto message = recorder.next()) {
    if (message->kind == RecordingMessage::tick && ++ticks > 1) continue;
    kinds.push_back(message->kind);
    if (message->kind == RecordingMessage::hello) {
      EXPECT_THAT(message->bytes, HasSubstr("0000000000abcdef"));
    }
  }
  EXPECT_THAT(kinds,
              ElementsAre(RecordingMessage::hello, RecordingMessage::file, RecordingMessage::buses,
                          RecordingMessage::state, RecordingMessage::tick));
  EXPECT_GT(ticks, 180U);
  EXPECT_EQ(tap_->state(), RecordingTap::State::running);
}

TEST_F(RecorderDoorTest, LetsOneInAtATime) {
  auto first = connect();
  auto second_one = connect();
  run(turn_ns);
  second_one.read();
  EXPECT_EQ(second_one.last().kind, RecordingMessage::refused);
  EXPECT_TRUE(second_one.ended());
  first.read();
  EXPECT_FALSE(first.ended());
}

TEST_F(RecorderDoorTest, LetsTheNextOneInWhereOneWentAway) {
  {
    auto first = connect();
    run(second);
  }
  run(turn_ns);
  EXPECT_THAT(log(), HasSubstr("the recorder disconnected"));
  auto next = connect();
  run_reading(next, second);
  EXPECT_EQ(next.last().kind, RecordingMessage::tick);
}

TEST_F(RecorderDoorTest, DropsOneThatNeverReads) {
  auto silent = connect();
  run(9 * second);
  EXPECT_THAT(log(), Not(HasSubstr("ended")));
  run(5 * second);  // the first messages still fitted into the socket
  const std::string said = log();
  EXPECT_THAT(said, HasSubstr("ticks: the recorder read nothing for 10 s"));
  EXPECT_EQ(said.find("ended after"), said.rfind("ended after")) << said;
  EXPECT_EQ(tap_->state(), RecordingTap::State::idle);

  auto next = connect();
  run_reading(next, second);
  EXPECT_EQ(next.last().kind, RecordingMessage::tick);
  silent.read();
  EXPECT_TRUE(silent.ended());
}

TEST_F(RecorderDoorTest, KeepsOneThatReadsSeldomButAll) {
  auto slow = connect();
  for (int i = 0; i < 5; ++i) {
    run(8 * second);
    run_reading(slow, second);  // the rings empty as the socket gets room
    EXPECT_EQ(slow.last().kind, RecordingMessage::tick);
  }
  EXPECT_THAT(log(), Not(HasSubstr("ended")));
}

// A recorder that reads too slowly falls behind until the rings are full. Then it has ten seconds
// for everything that is left; reading only a part does not extend them.
TEST_F(RecorderDoorTest, DropsOneThatReadsTooLittleForEver) {
  auto dripping = connect();
  for (int i = 0; i < 30; ++i) {
    dripping.read(8192);
    run(second);
  }
  EXPECT_THAT(log(), HasSubstr("the recorder did not keep up"));
  EXPECT_EQ(tap_->state(), RecordingTap::State::idle);
}

TEST_F(RecorderDoorTest, ReportsTheReasonToARecorderThatFellBehind) {
  auto slow = connect();
  run_reading(slow, second);
  while (tap_->state() == RecordingTap::State::running) {
    run(second);
    slow.read(4096);
  }
  run_reading(slow, 2 * second);
  const auto last = slow.last();
  EXPECT_EQ(last.kind, RecordingMessage::end);
  EXPECT_EQ(last.bytes, "the recorder did not keep up");
  EXPECT_TRUE(slow.ended());
}

TEST_F(RecorderDoorTest, ReportsTheEndOfTheDaemonToTheRecorder) {
  auto recorder = connect();
  run_reading(recorder, second);
  door_->close(*journal_);
  recorder.read();
  const auto last = recorder.last();
  EXPECT_EQ(last.kind, RecordingMessage::end);
  EXPECT_EQ(last.bytes, "odomd has ended");
}

}  // namespace
}  // namespace odomd::daemon::recorder_door_test

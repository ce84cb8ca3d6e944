// odom bridge --udp as a command, on the test's own segment.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "base/file_descriptor.hpp"
#include "tests/tools/bridge/network.hpp"
#include "tests/tools/on_a_terminal.hpp"
#include "tools/bridge/bridge.hpp"

namespace odomd::tools::udp_test {
namespace {

// Listens on a free port of the loopback.
class Receiver {
 public:
  Receiver() : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* const general = reinterpret_cast<sockaddr*>(&address);
    if (::bind(socket_.get(), general, size) != 0 ||
        ::getsockname(socket_.get(), general, &size) != 0)
      throw std::runtime_error("cannot bind to the loopback");
    address_ = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
  }
  [[nodiscard]] const std::string& address() const { return address_; }

  /// Takes the datagrams that have arrived.
  std::vector<nlohmann::json> take() {
    std::vector<nlohmann::json> all;
    char buffer[65536];
    for (ssize_t size = 0; (size = ::recv(socket_.get(), buffer, sizeof buffer, MSG_DONTWAIT)) > 0;)
      all.push_back(nlohmann::json::parse(buffer, buffer + size));
    return all;
  }

 private:
  FileDescriptor socket_;
  std::string address_;
};

class UdpBridge : public ::testing::Test {
 protected:
  Child start(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"bridge", "--shm", segment_, "--rate", "1000"});
    return {scratch_, "odom", std::move(arguments)};
  }
  Child start() const { return start({"--udp", receiver_.address(), "--json"}); }

  // Ticks until datagrams arrive; returns them.
  std::vector<nlohmann::json> tick_until_received(SlowDaemon& daemon) {
    std::vector<nlohmann::json> received;
    EXPECT_TRUE(eventually(
        [&] {
          daemon.tick();
          received = receiver_.take();
          return !received.empty();
        },
        between_ticks));
    return received;
  }

  Scratch scratch_;
  std::string segment_ = scratch_.path("pose").string();
  Receiver receiver_;
};

TEST_F(UdpBridge, SendsEveryFieldAsNestedJson) {
  SlowDaemon daemon(segment_);
  Child bridge = start();
  daemon.pose.x = 1.25;
  daemon.pose.yaw = 7.5;
  daemon.pose.odom_y = -2.0;
  daemon.pose.vx = 3.5;
  daemon.pose.covariance[3] = 0.25;
  daemon.pose.mode = ODOM_DEAD_RECKONING;
  daemon.pose.conditions = ODOM_COND_BUS_DOWN;
  daemon.details.gyro_bias = 0.0125;
  daemon.details.velocity_covariance[14] = 0.0625;
  daemon.details.execution_ns = 42'000;
  const auto received = tick_until_received(daemon);
  ASSERT_FALSE(received.empty());

  const nlohmann::json& first = received.front();
  EXPECT_EQ(first.size(), 2U);
  const nlohmann::json& odomd = first["odomd"];
  const std::int64_t time_ns = daemon.time_of(odomd["tick"].get<std::uint64_t>());
  EXPECT_NEAR(first["timestamp"].get<double>(),
              static_cast<double>(time_ns + realtime_offset_ns) * 1e-9, 1e-6);
  EXPECT_THAT(odomd, Includes(R"({
    "map": {"x": 1.25, "yaw": 7.5}, "odom": {"y": -2.0}, "velocity": {"x": 3.5},
    "sigma": {"y": 0.5}, "velocity_sigma": {"yaw": 0.25}, "mode": 2,
    "mode_name": "dead_reckoning", "calibration": {"gyro_bias": 0.0125}})"));
  EXPECT_EQ(odomd["conditions"], ODOM_COND_BUS_DOWN);
  EXPECT_DOUBLE_EQ(odomd["beat"]["execution"].get<double>(), 42e-6);

  const Outcome outcome = bridge.terminate();
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const auto summary = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(summary["sinks"][0]["name"], "udp " + receiver_.address());
  EXPECT_EQ(summary["sinks"][0]["dropped"], 0);
  EXPECT_EQ(summary["sinks"][0]["sent"], summary["ticks"]);
}

TEST_F(UdpBridge, WaitsForTheDaemonAndContinuesWithItsSuccessor) {
  Child bridge = start();
  EXPECT_TRUE(eventually([&] { return bridge.errors().find("waiting") != std::string::npos; }));
  auto daemon = std::make_unique<SlowDaemon>(segment_, 5'000'000);
  tick_until_received(*daemon);
  daemon.reset();
  EXPECT_TRUE(
      eventually([&] { return bridge.errors().find("stopped publishing") != std::string::npos; }));
  static_cast<void>(receiver_.take());

  SlowDaemon successor(segment_);
  successor.pose.x = 77.0;
  const auto received = tick_until_received(successor);
  EXPECT_EQ(received.back()["odomd"]["map"]["x"], 77.0);
  const Outcome outcome = bridge.terminate();
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(nlohmann::json::parse(outcome.out)["restarts"], 1);
}

TEST_F(UdpBridge, ShowsItsStatusOnATerminalUntilControlC) {
  SlowDaemon daemon(segment_);
  daemon.pose.x = 1.5;
  OnATerminal bridge("bridge --shm " + segment_ + " --udp " + receiver_.address(), 200);
  const auto show = [&](const std::string& text) {
    EXPECT_TRUE(eventually(
        [&] {
          daemon.tick();
          return bridge.has_shown(text);
        },
        between_ticks))
        << text << bridge.seen();
  };
  show("\rtracking  x 1.50 m  y 0.00 m");
  show("udp " + receiver_.address() + ": ");
  show(" sent");
  bridge.press("\x03");
  EXPECT_TRUE(bridge.shows("\r\nodom bridge: "));  // the summary, on a line of its own
  EXPECT_TRUE(bridge.shows("withheld (fault)\r\n"));
}

TEST_F(UdpBridge, ShowsNothingWithoutATerminal) {
  SlowDaemon daemon(segment_);
  Child bridge{scratch_, "odom", {"bridge", "--shm", segment_, "--udp", receiver_.address()}};
  tick_until_received(daemon);
  const Outcome outcome = bridge.terminate();
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.err.find('\n'), outcome.err.size() - 1) << outcome.err;  // the summary
  EXPECT_EQ(outcome.err.find('\r'), std::string::npos);
}

TEST_F(UdpBridge, SendsTheFirstTickOfEveryPeriod) {
  SlowDaemon daemon(segment_, 5'000'000);  // 50 of the 200 ticks per second
  Child bridge{scratch_, "odom", {"bridge", "--shm", segment_, "--udp", receiver_.address()}};
  std::vector<nlohmann::json> received = tick_until_received(daemon);
  for (int i = 0; i < 20; ++i) daemon.tick();
  EXPECT_TRUE(eventually([&] {
    for (const auto& one : receiver_.take()) received.push_back(one);
    return received.back()["odomd"]["tick"].get<std::uint64_t>() / 4 == daemon.pose.tick / 4;
  }));
  for (std::size_t i = 1; i < received.size(); ++i)
    EXPECT_EQ(received[i]["odomd"]["tick"].get<int>(),
              (received[i - 1]["odomd"]["tick"].get<int>() / 4 + 1) * 4);
}

TEST_F(UdpBridge, SendsNothingWhileThePoseIsInitialising) {
  SlowDaemon daemon(segment_);
  daemon.pose.mode = ODOM_INITIALISING;
  daemon.tick();
  Child bridge = start();
  for (int i = 0; i < 20; ++i) daemon.tick();
  daemon.pose.mode = ODOM_FAULT;
  const auto received = tick_until_received(daemon);
  EXPECT_EQ(received.front()["odomd"]["mode_name"], "fault");
}

TEST_F(UdpBridge, EndsAfterItsDurationWithOrWithoutAListener) {
  SlowDaemon daemon(segment_);
  std::string nobody;
  {
    const Receiver gone;
    nobody = gone.address();
  }
  Child bridge = start({"--udp", nobody, "--duration", "0.5"});
  Outcome outcome;
  for (int i = 0; i < 10; ++i) daemon.tick();
  outcome = bridge.wait();
  EXPECT_THAT(outcome, Ends(0, HasSubstr("odom bridge: ")));
  EXPECT_THAT(outcome.err, HasSubstr("; udp " + nobody + ": "));
}

TEST_F(UdpBridge, FailsAfterItsDurationWithoutADaemon) {
  Child bridge = start({"--udp", receiver_.address(), "--duration", "0.2"});
  EXPECT_THAT(bridge.wait(), Ends(1, HasSubstr("no such segment: is odomd running?")));
}

TEST(BridgeCommand, RefusesInvalidOptions) {
  const Scratch scratch;
  expect_answers(scratch, 2, "timeout 20 odom bridge", R"(
--udp 9870 -> not HOST:PORT
--udp host: -> not HOST:PORT
--udp :9870 -> not HOST:PORT
--udp 127.0.0.1:0 -> not HOST:PORT
--udp 127.0.0.1:65536 -> not HOST:PORT
--udp 127.0.0.1:98x -> not HOST:PORT
--udp ::1:9870 -> not HOST:PORT
--udp --shm nonsense -> not a name of a segment
--ros --rate nan -> bridge: --rate: "
--ros --rate 0 -> bridge: --rate: "
--ros --rate=-3 -> bridge: --rate: "
--ros --rate inf -> bridge: --rate: "
--ros --frame moon -> bridge: --frame: "
--ros --frame-base '' -> bridge: --frame-base: "
--ros --frame-map 'my map' -> bridge: --frame-map: "
--ros --domain ten -> not a domain
--pose-topic pose -> is not a topic with its namespace
--pose-topic /odom -> must not measure its own pose
--pose-topic /p --pose-sigma 0,1,1 -> greater than 0
--pose-topic /p --no-publish --udp -> excludes
--pose-frame world -> requires --pose-topic
--domain 233 -> a number from 0 to 232
--frame-map odom -> two frames of one name
--frame-odom map -> two frames of one name
)");
  EXPECT_EQ(run_shell("ROS_DOMAIN_ID=ten odom bridge").status, 2);
}

TEST(SampleJson, IsOneValidObjectForAnyValues) {
  BridgeSample sample;
  sample.realtime_ns = 1'700'000'000'000'000'005;
  sample.pose.x = std::numeric_limits<double>::quiet_NaN();
  sample.pose.mode = 77;
  const std::string text = sample_json(sample);
  EXPECT_THAT(text, HasSubstr("{\"timestamp\":1700000000.000000005,"));
  const auto json = nlohmann::json::parse(text);
  EXPECT_TRUE(json["odomd"]["map"]["x"].is_null());
  EXPECT_EQ(json["odomd"]["mode_name"], "mode 77");
}

}  // namespace
}  // namespace odomd::tools::udp_test

// odom bridge as a subscriber: publishers of ROS 2's pose types on one side, the daemon's camera
// socket on the other.
#include <dds/dds.h>
#include <odom/odom.h>

#include <chrono>
#include <set>

#include "ros_poses.h"
#include "tests/tools/bridge/network.hpp"

namespace odomd::tools::pose_in_test {
namespace {

using CovarianceStamped = geometry_msgs_msg_dds__PoseWithCovarianceStamped_;

std::int64_t realtime_now_ns() {
  return std::chrono::nanoseconds{std::chrono::system_clock::now().time_since_epoch()}.count();
}

template <typename Message>
Message filled(const char* frame = "map") {
  Message message{};
  const std::int64_t stamp_ns = realtime_now_ns() - 30'000'000;
  message.sec = static_cast<std::int32_t>(stamp_ns / 1'000'000'000);
  message.nanosec = static_cast<std::uint32_t>(stamp_ns % 1'000'000'000);
  message.frame = const_cast<char*>(frame);
  message.position[0] = 3.0;
  message.position[1] = -4.0;
  // roll 0.3, then yaw 2 [rad], as a quaternion whose norm is 0.5 % too large
  const double q[]{std::cos(1.0) * std::sin(0.15), std::sin(1.0) * std::sin(0.15),
                   std::sin(1.0) * std::cos(0.15), std::cos(1.0) * std::cos(0.15)};
  for (int i = 0; i < 4; ++i) message.rotation[i] = 1.005 * q[i];
  if constexpr (requires { message.covariance; })
    message.covariance[0] = message.covariance[7] = message.covariance[35] = 4.0;
  if constexpr (requires { message.child_frame; })
    message.child_frame = const_cast<char*>("base_link");
  return message;
}

class PoseIn : public ::testing::Test {
 protected:
  void SetUp() override { ::setenv("CYCLONEDDS_URI", loopback_only().c_str(), 1); }
  void TearDown() override { dds_delete(participant_); }

  // Each writer has a participant of its own.
  [[nodiscard]] dds_entity_t writer(const dds_topic_descriptor_t& type,
                                    dds_reliability_kind_t reliability = DDS_RELIABILITY_RELIABLE) {
    dds_delete(
        std::exchange(participant_, dds_create_participant(test_domain(), nullptr, nullptr)));
    dds_qos_t* const qos = dds_create_qos();
    dds_qset_reliability(qos, reliability, DDS_SECS(1));
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
    const auto topic = dds_create_topic(participant_, &type, "rt/pose", nullptr, nullptr);
    const dds_entity_t writer = dds_create_writer(participant_, topic, qos, nullptr);
    dds_delete_qos(qos);
    EXPECT_GE(writer, 0) << dds_strretcode(-writer);
    return writer;
  }

  Child start(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"bridge", "--pose-topic", "/pose", "--socket", socket_,
                                         "--domain", std::to_string(test_domain()), "--json"});
    return {scratch_, "odom", std::move(arguments)};
  }

  void publish(dds_entity_t writer, const auto& message) {
    stamps_ns_.insert(message.sec * std::int64_t{1'000'000'000} + message.nanosec);
    dds_write(writer, &message);
  }

  // Publishes until a newly started daemon has a pose.
  template <typename Message>
  void expect_received(dds_entity_t writer, double sigma, const char* frame = "map") {
    std::filesystem::remove(socket_);
    const auto daemon = listening_socket(socket_, SOCK_SEQPACKET | SOCK_NONBLOCK);
    FileDescriptor connection;
    odom_camera_message pose{};
    EXPECT_TRUE(eventually([&] {
      publish(writer, filled<Message>(frame));
      if (!connection) connection = FileDescriptor{::accept(daemon.get(), nullptr, nullptr)};
      return ::recv(connection.get(), &pose, sizeof pose, MSG_DONTWAIT) == sizeof pose;
    }));
    EXPECT_EQ(pose.clock, ODOM_CLOCK_REALTIME);
    EXPECT_TRUE(stamps_ns_.contains(pose.capture_ns)) << pose.capture_ns;
    EXPECT_EQ(pose.x, 3.0);
    EXPECT_EQ(pose.y, -4.0);
    EXPECT_NEAR(pose.yaw, 2.0, 1e-12);
    EXPECT_EQ(pose.sigma_x, sigma);
    EXPECT_EQ(pose.sigma_yaw, sigma);
  }

  Scratch scratch_;
  std::string socket_ = scratch_.path("camera.sock").string();
  dds_entity_t participant_ = 0;
  std::set<std::int64_t> stamps_ns_;  // of all poses published
};

TEST_F(PoseIn, OfEachTypeReachesTheDaemonAndItsSuccessor) {
  const auto check = [this]<typename Message>(const Message&, const dds_topic_descriptor_t& type,
                                              dds_reliability_kind_t reliability, double sigma) {
    const Child bridge = start({"--no-publish"});
    const auto publisher = writer(type, reliability);
    for (int life = 0; life < 2; ++life) expect_received<Message>(publisher, sigma);
  };
  check(geometry_msgs_msg_dds__PoseStamped_{}, geometry_msgs_msg_dds__PoseStamped__desc,
        DDS_RELIABILITY_BEST_EFFORT, 0.01);
  check(CovarianceStamped{}, geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc,
        DDS_RELIABILITY_RELIABLE, 2.0);
  check(nav_msgs_msg_dds__Odometry_{}, nav_msgs_msg_dds__Odometry__desc, DDS_RELIABILITY_RELIABLE,
        2.0);
}

TEST_F(PoseIn, IsRefusedWithReasonIfItIsBadWhileTheBridgePublishes) {
  const std::string segment = scratch_.path("pose").string();
  SlowDaemon ticks(segment, 5'000'000);
  Child bridge = start({"--shm", segment, "--pose-frame", "world"});
  const auto publisher = writer(geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc);
  EXPECT_TRUE(eventually([&] {
    ticks.tick();
    publish(publisher, filled<CovarianceStamped>("world"));
    return bridge.errors().find("no such socket") != std::string::npos;
  }));
  auto unstamped = filled<CovarianceStamped>("world");
  unstamped.sec = 0;
  unstamped.nanosec = 0;
  auto early = filled<CovarianceStamped>("world");
  early.sec += 100;
  auto bare = filled<CovarianceStamped>("world");
  bare.covariance[7] = 0.0;
  for (const auto& message : {filled<CovarianceStamped>("moon\x1b[2J"), unstamped,
                              filled<CovarianceStamped>("map"), early, bare})
    for (int i = 0; i < 2; ++i) publish(publisher, message);
  // This later pose arrives only after the others.
  expect_received<CovarianceStamped>(publisher, 2.0, "world");
  const Outcome outcome = bridge.terminate();
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const auto summary = nlohmann::json::parse(outcome.out);
  for (const char* name : {"refused_no_stamp", "refused_future", "without_sigma"})
    EXPECT_EQ(summary["input"][name], 2) << summary;
  EXPECT_EQ(summary["input"]["refused_frame"], 4) << summary;
  EXPECT_GT(summary["input"]["unsent"], 0) << summary;
  EXPECT_GT(summary["sinks"][0]["sent"], 0) << summary;
  for (const char* text : {"waiting for a publisher", "from PoseWithCovarianceStamped",
                           R"("moon\u001b[2J", not "world")", R"(is "map", not)", "stamp is 0",
                           "s ahead", "--pose-sigma"}) {
    const std::size_t first = outcome.err.find(text);
    EXPECT_NE(first, std::string::npos) << text << '\n' << outcome.err;
    EXPECT_EQ(outcome.err.find(text, first + 1), std::string::npos) << outcome.err;
  }
}

TEST_F(PoseIn, OfAnotherTypeIsLeftOut) {
  const Child bridge = start({"--no-publish"});
  static_cast<void>(writer(geometry_msgs_msg_dds__Pose__desc));
  EXPECT_TRUE(eventually(
      [&] { return bridge.errors().find(R"("Pose" is left out)") != std::string::npos; }));
}

}  // namespace
}  // namespace odomd::tools::pose_in_test

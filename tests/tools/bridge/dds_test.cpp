// odom bridge as ROS 2 sees it: a subscriber to rt/odom and rt/tf, and a comparison of the bytes on
// the wire with the message definitions.
#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <unistd.h>

#include <bit>
#include <optional>

#include "ros.h"
#include "tests/tools/bridge/network.hpp"

namespace odomd::tools::dds_test {
namespace {

const std::string domain = std::to_string(test_domain());

// Parses XCDR1: every number is aligned to its own size, counted from the end of the four-byte
// header.
class Cdr {
 public:
  explicit Cdr(std::vector<unsigned char> bytes) : bytes_(std::move(bytes)) {}

  [[nodiscard]] std::uint16_t encoding() const {
    return static_cast<std::uint16_t>(bytes_.at(0) << 8U | bytes_.at(1));
  }
  std::int32_t int32() { return static_cast<std::int32_t>(number<std::uint32_t>()); }
  std::uint32_t uint32() { return number<std::uint32_t>(); }
  double float64() { return std::bit_cast<double>(number<std::uint64_t>()); }
  std::string string() {
    const std::uint32_t size = uint32();  // with its terminating zero
    std::string text;
    for (std::uint32_t i = 0; i < size; ++i) text += static_cast<char>(bytes_.at(at_++));
    EXPECT_TRUE(text.ends_with('\0'));
    text.pop_back();
    return text;
  }
  std::vector<double> float64s(std::size_t count) {
    std::vector<double> all;
    while (count-- > 0) all.push_back(float64());
    return all;
  }
  /// Number of unread bytes; the writer may have padded to a multiple of four.
  [[nodiscard]] std::size_t rest() const { return bytes_.size() - at_; }

 private:
  template <typename T>
  T number() {
    constexpr std::size_t header = 4;
    while ((at_ - header) % sizeof(T) != 0) ++at_;
    T value = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i)
      value |= static_cast<T>(bytes_.at(at_ + i)) << (8 * i);
    at_ += sizeof(T);
    return value;
  }

  std::vector<unsigned char> bytes_;
  std::size_t at_ = 4;
};

class DdsBridge : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    ::setenv("CYCLONEDDS_URI", loopback_only().c_str(), 1);
    ::unsetenv("ROS_DOMAIN_ID");
  }

  void SetUp() override {
    participant_ = dds_create_participant(test_domain(), nullptr, nullptr);
    ASSERT_GE(participant_, 0) << dds_strretcode(-participant_);
    odometry_ = reader(nav_msgs_msg_dds__Odometry__desc, "rt/odom");
    transforms_ = reader(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf");
  }
  void TearDown() override { dds_delete(participant_); }

  // Subscribes with the defaults of a ROS 2 node.
  [[nodiscard]] dds_entity_t reader(const dds_topic_descriptor_t& type, const char* name) const {
    dds_qos_t* const qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
    dds_qset_durability(qos, DDS_DURABILITY_VOLATILE);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
    const dds_entity_t topic = dds_create_topic(participant_, &type, name, qos, nullptr);
    const dds_entity_t reader = dds_create_reader(participant_, topic, qos, nullptr);
    dds_delete_qos(qos);
    EXPECT_GE(reader, 0) << dds_strretcode(-reader);
    return reader;
  }

  Child start(std::vector<std::string> arguments = {}) const {
    arguments.insert(arguments.begin(),
                     {"bridge", "--shm", segment_, "--rate", "1000", "--domain", domain, "--json"});
    return {scratch_, "odom", std::move(arguments)};
  }

  // The next sample, as it came over the wire.
  static std::optional<Cdr> take(dds_entity_t reader) {
    ddsi_serdata* data = nullptr;
    dds_sample_info_t info{};
    if (dds_takecdr(reader, &data, 1, &info, DDS_ANY_STATE) != 1) return std::nullopt;
    std::vector<unsigned char> bytes(ddsi_serdata_size(data));
    ddsi_serdata_to_ser(data, 0, bytes.size(), bytes.data());
    ddsi_serdata_unref(data);
    if (!info.valid_data) return std::nullopt;
    return Cdr(std::move(bytes));
  }

  // Ticks until a sample arrives.
  static Cdr tick_until(SlowDaemon& daemon, dds_entity_t reader) {
    std::optional<Cdr> cdr;
    EXPECT_TRUE(eventually(
        [&] {
          daemon.tick();
          cdr = take(reader);
          return cdr.has_value();
        },
        between_ticks));
    return cdr.value_or(Cdr(std::vector<unsigned char>(4096)));
  }

  // x of the pose in an Odometry message.
  static double x_of(Cdr odometry) {
    static_cast<void>(odometry.int32());
    static_cast<void>(odometry.uint32());
    static_cast<void>(odometry.string());
    static_cast<void>(odometry.string());
    return odometry.float64();
  }

  static void fill(SlowDaemon& daemon) {
    odom_pose& pose = daemon.pose;
    pose.x = 10.0;
    pose.y = -4.0;
    pose.yaw = 1.0;
    pose.odom_x = 9.0;
    pose.odom_y = -5.5;
    pose.odom_yaw = 0.75;
    pose.vx = 3.0;
    pose.vy = -0.25;
    pose.yaw_rate = 0.5;
    pose.covariance[0] = pose.covariance[3] = 0.04;  // a circle, so equal in every frame
    pose.covariance[5] = 0.0016;
    for (int i = 0; i < 15; ++i) daemon.details.velocity_covariance[i] = 100.0 + i;
  }

  // std_msgs/Header: builtin_interfaces/Time stamp (int32 sec, uint32 nanosec), string frame_id
  static void expect_header(Cdr& cdr, const SlowDaemon& daemon, const std::string& frame) {
    const std::int64_t sec = cdr.int32();
    const std::int64_t time_ns = sec * 1'000'000'000 + cdr.uint32();
    const std::int64_t offset_ns = time_ns - realtime_offset_ns - daemon.time_of(0);
    EXPECT_EQ(offset_ns % 1'000'000'000, 0) << "not the time of a tick";
    EXPECT_GT(offset_ns, 0);
    EXPECT_LE(time_ns - realtime_offset_ns, daemon.pose.time_ns);
    EXPECT_EQ(cdr.string(), frame);
  }
  static void expect_vector(Cdr& cdr, double x, double y, double z) {
    EXPECT_NEAR(cdr.float64(), x, 1e-12);
    EXPECT_NEAR(cdr.float64(), y, 1e-12);
    EXPECT_NEAR(cdr.float64(), z, 1e-12);
  }
  static void expect_quaternion(Cdr& cdr, double yaw) {
    expect_vector(cdr, 0.0, 0.0, std::sin(yaw / 2.0));
    EXPECT_NEAR(cdr.float64(), std::cos(yaw / 2.0), 1e-12);
  }

  Scratch scratch_;
  std::string segment_ = scratch_.path("pose").string();
  dds_entity_t participant_ = 0;
  dds_entity_t odometry_ = 0;
  dds_entity_t transforms_ = 0;
};

// nav_msgs/Odometry: Header header, string child_frame_id, PoseWithCovariance pose (Point position,
// Quaternion orientation, float64[36] covariance), TwistWithCovariance twist (Vector3 linear,
// Vector3 angular, float64[36] covariance)
TEST_F(DdsBridge, SendsOdometryByteForByteAsRosDefinesIt) {
  SlowDaemon daemon(segment_);
  fill(daemon);
  const Child bridge = start();
  Cdr cdr = tick_until(daemon, odometry_);
  EXPECT_EQ(cdr.encoding(), 0x0001);  // CDR, little-endian: version 1, no parameter list
  expect_header(cdr, daemon, "odom");
  EXPECT_EQ(cdr.string(), "base_link");
  expect_vector(cdr, 9.0, -5.5, 0.0);
  expect_quaternion(cdr, 0.75);
  const std::vector<double> pose = cdr.float64s(36);
  EXPECT_NEAR(pose[0], 0.04, 1e-12);
  EXPECT_NEAR(pose[7], 0.04, 1e-12);
  EXPECT_EQ(pose[14], 1e6);
  EXPECT_EQ(pose[35], 0.0016);
  expect_vector(cdr, 3.0, -0.25, 0.0);
  expect_vector(cdr, 0.0, 0.0, 0.5);
  const std::vector<double> twist = cdr.float64s(36);
  EXPECT_EQ(twist[0], 109.0);
  EXPECT_EQ(twist[1], 110.0);
  EXPECT_EQ(twist[5], 111.0);
  EXPECT_EQ(twist[7], 112.0);
  EXPECT_EQ(twist[11], 113.0);
  EXPECT_EQ(twist[35], 114.0);
  EXPECT_LT(cdr.rest(), 4U);
}

// tf2_msgs/TFMessage: TransformStamped[] transforms (Header header, string child_frame_id,
// Transform transform: Vector3 translation, Quaternion rotation)
TEST_F(DdsBridge, SendsTransformsByteForByteAsRosDefinesThem) {
  SlowDaemon daemon(segment_);
  fill(daemon);
  const Child bridge = start({"--frame-map", "world", "--frame-base", "cog"});
  Cdr cdr = tick_until(daemon, transforms_);
  EXPECT_EQ(cdr.encoding(), 0x0001);
  ASSERT_EQ(cdr.uint32(), 2U);
  expect_header(cdr, daemon, "odom");
  EXPECT_EQ(cdr.string(), "cog");
  expect_vector(cdr, 9.0, -5.5, 0.0);
  expect_quaternion(cdr, 0.75);
  expect_header(cdr, daemon, "world");
  EXPECT_EQ(cdr.string(), "odom");
  // The odometry frame is rotated by 0.25 rad in the map.
  expect_vector(cdr, 10.0 - (std::cos(0.25) * 9.0 + std::sin(0.25) * 5.5),
                -4.0 - (std::sin(0.25) * 9.0 - std::cos(0.25) * 5.5), 0.0);
  expect_quaternion(cdr, 0.25);
  EXPECT_LT(cdr.rest(), 4U);
}

TEST_F(DdsBridge, CanLeaveTheMapTransformToAnotherPublisher) {
  SlowDaemon daemon(segment_);
  fill(daemon);
  const Child bridge = start({"--tf", "odom", "--frame", "map"});
  Cdr cdr = tick_until(daemon, transforms_);
  ASSERT_EQ(cdr.uint32(), 1U);
  expect_header(cdr, daemon, "odom");
  EXPECT_EQ(cdr.string(), "base_link");
  cdr = tick_until(daemon, odometry_);
  expect_header(cdr, daemon, "map");
  EXPECT_EQ(cdr.string(), "base_link");
  expect_vector(cdr, 10.0, -4.0, 0.0);
  expect_quaternion(cdr, 1.0);
}

TEST_F(DdsBridge, UsesTheNamesAndQosOfRos) {
  SlowDaemon daemon(segment_);
  const Child bridge = start();
  static_cast<void>(tick_until(daemon, odometry_));
  dds_instance_handle_t writers[2]{};
  ASSERT_EQ(dds_get_matched_publications(odometry_, writers, 2), 1);
  dds_builtintopic_endpoint_t* const writer =
      dds_get_matched_publication_data(odometry_, writers[0]);
  ASSERT_NE(writer, nullptr);
  EXPECT_STREQ(writer->topic_name, "rt/odom");
  EXPECT_STREQ(writer->type_name, "nav_msgs::msg::dds_::Odometry_");
  dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
  EXPECT_TRUE(dds_qget_reliability(writer->qos, &reliability, nullptr));
  EXPECT_EQ(reliability, DDS_RELIABILITY_RELIABLE);
  dds_durability_kind_t durability = DDS_DURABILITY_PERSISTENT;
  EXPECT_TRUE(dds_qget_durability(writer->qos, &durability));
  EXPECT_EQ(durability, DDS_DURABILITY_VOLATILE);
  dds_builtintopic_free_endpoint(writer);
}

TEST_F(DdsBridge, WithholdsAPoseInTheModeFault) {
  SlowDaemon daemon(segment_);
  Child bridge = start();
  static_cast<void>(tick_until(daemon, odometry_));
  daemon.pose.mode = ODOM_FAULT;
  daemon.tick();
  daemon.pose.mode = ODOM_TRACKING;
  daemon.pose.odom_x = 5.0;  // this pose is later than the faulty one
  EXPECT_TRUE(eventually([&] { return x_of(tick_until(daemon, odometry_)) == 5.0; }));
  const Outcome outcome = bridge.terminate();
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const auto summary = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(summary["sinks"][0]["withheld"], 1) << outcome.out;
  EXPECT_EQ(summary["sinks"][0]["dropped"], 0) << outcome.out;
  EXPECT_EQ(summary["sinks"][0]["name"], "dds domain " + domain);
}

TEST_F(DdsBridge, TakesTheDomainOfRosFromTheEnvironment) {
  SlowDaemon daemon(segment_);
  ::setenv("ROS_DOMAIN_ID", domain.c_str(), 1);
  const Child bridge{scratch_, "odom", {"bridge", "--shm", segment_, "--rate", "1000"}};
  ::unsetenv("ROS_DOMAIN_ID");
  Cdr cdr = tick_until(daemon, odometry_);
  EXPECT_EQ(cdr.encoding(), 0x0001);
}

}  // namespace
}  // namespace odomd::tools::dds_test

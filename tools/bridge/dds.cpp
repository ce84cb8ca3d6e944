// The bridge's ROS 2 topics: publishes odometry and transforms, and receives the car's pose in any
// of the message types that carry a pose.
#include <dds/dds.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <ratio>
#include <stdexcept>
#include <string>

#include "base/wall_clock.hpp"
#include "ros.h"
#include "tools/bridge/bridge.hpp"
#include "tools/bridge/odometry.hpp"
#include "tools/bridge/pose_intake.hpp"
#include "tools/cli/csv.hpp"

namespace odomd::tools {
namespace {

using Header = std_msgs_msg_dds__Header_;
using OdometryMessage = nav_msgs_msg_dds__Odometry_;
using TransformStamped = geometry_msgs_msg_dds__TransformStamped_;
using TransformMessage = tf2_msgs_msg_dds__TFMessage_;

dds_entity_t made(dds_entity_t entity, const std::string& what) {
  if (entity < 0)
    throw std::runtime_error(fmt::format("{}: {}; CYCLONEDDS_URI sets the network it uses", what,
                                         dds_strretcode(-entity)));
  return entity;
}

// Deletes its entities when it is destroyed.
struct Participant {
  explicit Participant(const BridgeOptions& options)
      : entity(made(dds_create_participant(domain_of(options), nullptr, nullptr),
                    fmt::format("DDS domain {}", domain_of(options)))) {}
  ~Participant() { dds_delete(entity); }
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;
  dds_entity_t entity;
};

struct Qos {
  explicit Qos(std::int32_t depth) : qos(dds_create_qos()) {
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, depth);
  }
  ~Qos() { dds_delete_qos(qos); }
  Qos(const Qos&) = delete;
  Qos& operator=(const Qos&) = delete;
  dds_qos_t* qos;
};

class DdsSink : public Sink {
 public:
  explicit DdsSink(const BridgeOptions& options)
      : frames_(options.names),
        frame_(options.frame),
        transforms_wanted_(options.transforms),
        participant_(options) {
    name_ = fmt::format("dds domain {}", domain_of(options));
    odometry_ = writer(nav_msgs_msg_dds__Odometry__desc, "rt/odom", 10);
    if (transforms_wanted_ != Transforms::none)
      transforms_ = writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf", 100);
  }

  void send(const BridgeSample& sample) override {
    if (sample.pose.mode == ODOM_FAULT) {
      ++counts_.withheld;
      return;
    }
    const bool both =
        send_odometry(sample) == DDS_RETCODE_OK && send_transforms(sample) == DDS_RETCODE_OK;
    ++(both ? counts_.sent : counts_.dropped);
  }

 private:
  [[nodiscard]] dds_entity_t writer(const dds_topic_descriptor_t& type, const char* name,
                                    std::int32_t depth) const {
    const Qos wanted(depth);
    // The defaults of ROS 2. A reader that does not keep up blocks a write for at most 5 ms.
    dds_qset_reliability(wanted.qos, DDS_RELIABILITY_RELIABLE, DDS_MSECS(5));
    dds_qset_durability(wanted.qos, DDS_DURABILITY_VOLATILE);
    const dds_entity_t topic =
        made(dds_create_topic(participant_.entity, &type, name, wanted.qos, nullptr), name);
    return made(dds_create_writer(participant_.entity, topic, wanted.qos, nullptr), name);
  }

  // The message points into `frame`: dds_write() copies the text.
  static Header header(std::int64_t time_ns, std::string& frame) {
    constexpr auto second = std::nano::den;
    return {
        {static_cast<std::int32_t>(time_ns / second), static_cast<std::uint32_t>(time_ns % second)},
        frame.data()};
  }

  dds_return_t send_odometry(const BridgeSample& sample) {
    const Odometry odometry = odometry_of(sample, frame_);
    const PlanarQuaternion q = quaternion_of(odometry.pose.yaw);
    OdometryMessage message{};
    message.header =
        header(sample.realtime_ns, frame_ == PoseFrame::map ? frames_.map : frames_.odom);
    message.child_frame_id = frames_.base.data();
    message.pose.pose.position = {odometry.pose.x, odometry.pose.y, 0.0};
    message.pose.pose.orientation = {0.0, 0.0, q.z, q.w};
    std::ranges::copy(odometry.pose_covariance, message.pose.covariance);
    message.twist.twist.linear = {odometry.vx, odometry.vy, 0.0};
    message.twist.twist.angular = {0.0, 0.0, odometry.yaw_rate};
    std::ranges::copy(odometry.twist_covariance, message.twist.covariance);
    return dds_write(odometry_, &message);
  }

  dds_return_t send_transforms(const BridgeSample& sample) {
    if (transforms_wanted_ == Transforms::none) return DDS_RETCODE_OK;
    const odom_pose& pose = sample.pose;
    std::array both{transform(sample.realtime_ns, frames_.odom, frames_.base,
                              {pose.odom_x, pose.odom_y, pose.odom_yaw}),
                    transform(sample.realtime_ns, frames_.map, frames_.odom, correction_of(pose))};
    const std::uint32_t wanted = transforms_wanted_ == Transforms::all ? 2 : 1;
    TransformMessage message{};
    message.transforms._maximum = wanted;
    message.transforms._length = wanted;
    message.transforms._buffer = both.data();
    return dds_write(transforms_, &message);
  }

  static TransformStamped transform(std::int64_t time_ns, std::string& parent, std::string& child,
                                    const estimator::Pose2& pose) {
    const PlanarQuaternion q = quaternion_of(pose.yaw);
    return {header(time_ns, parent), child.data(), {{pose.x, pose.y, 0.0}, {0.0, 0.0, q.z, q.w}}};
  }

  FrameNames frames_;
  PoseFrame frame_;
  Transforms transforms_wanted_;
  Participant participant_;
  dds_entity_t odometry_ = 0;
  dds_entity_t transforms_ = 0;
};

template <typename Message>
RosPose pose_of(const void* sample) {
  const auto& message = *static_cast<const Message*>(sample);
  const auto& stamp = message.header.stamp;
  RosPose common;
  common.stamp_ns = std::int64_t{stamp.sec} * std::nano::den + stamp.nanosec;
  common.frame = message.header.frame_id;
  const auto take = [&common](const geometry_msgs_msg_dds__Pose_& pose) {
    const auto& q = pose.orientation;
    common.x = pose.position.x;
    common.y = pose.position.y;
    common.rotation = {q.x, q.y, q.z, q.w};
  };
  if constexpr (requires { message.pose.covariance; }) {
    take(message.pose.pose);
    common.covariance = message.pose.covariance;
  } else {
    take(message.pose);
  }
  if constexpr (requires { message.child_frame_id; }) common.child_frame = message.child_frame_id;
  return common;
}

struct MessageType {
  const dds_topic_descriptor_t* descriptor;
  RosPose (*read)(const void* sample);
};
constexpr std::array<MessageType, 3> message_types{{
    {&geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc,
     pose_of<geometry_msgs_msg_dds__PoseWithCovarianceStamped_>},
    {&geometry_msgs_msg_dds__PoseStamped__desc, pose_of<geometry_msgs_msg_dds__PoseStamped_>},
    {&nav_msgs_msg_dds__Odometry__desc, pose_of<nav_msgs_msg_dds__Odometry_>},
}};

// "geometry_msgs::msg::dds_::PoseStamped_" -> "PoseStamped"
std::string short_name(const std::string& type) {
  const std::string name = type.substr(type.rfind(':') + 1);
  return name.substr(0, name.rfind('_'));
}

class DdsIntake : public PoseIntake {
 public:
  explicit DdsIntake(const BridgeOptions& options)
      : PoseIntake(options.input), topic_("rt" + options.input.topic), participant_(options) {
    note("waiting", fmt::format("waiting for a publisher in DDS domain {}", domain_of(options)));
  }

  void poll(std::chrono::milliseconds wait) override {
    dds_waitset_wait(waitset_, nullptr, 0, DDS_MSECS(wait.count()));
    take_all(publications_, [this](const void* sample) {
      const auto& publisher = *static_cast<const dds_builtintopic_endpoint_t*>(sample);
      if (publisher.topic_name == topic_) subscribe(publisher.type_name);
    });
    if (type_ != nullptr)
      take_all(reader_, [this](const void* sample) {
        take(type_->read(sample), read_clock(CLOCK_REALTIME));
      });
  }

 private:
  template <typename Use>
  static void take_all(dds_entity_t reader, const Use& use) {
    dds_sample_info_t info{};
    for (void* sample = nullptr; dds_take(reader, &sample, &info, 1, 1) == 1; sample = nullptr) {
      if (info.valid_data) use(sample);
      dds_return_loan(reader, &sample, 1);
    }
  }

  void subscribe(const std::string& type) {
    const auto* const found = std::ranges::find_if(message_types, [&](const MessageType& known) {
      return known.descriptor->m_typename == type;
    });
    if (type_ != nullptr && found == type_) return;
    if (type_ != nullptr || found == message_types.end())
      return note(type, "a publisher of " + tools::quoted(short_name(type)) +
                            " is left out; one of PoseWithCovarianceStamped, PoseStamped and "
                            "Odometry is needed");
    // Best effort and volatile by default, which matches every publisher.
    const Qos wanted(100);
    reader_ = dds_create_reader(
        participant_.entity,
        dds_create_topic(participant_.entity, found->descriptor, topic_.c_str(), nullptr, nullptr),
        wanted.qos, nullptr);
    if (reader_ < 0)
      return note(type, fmt::format("cannot subscribe: {}", dds_strretcode(-reader_)));
    dds_set_status_mask(reader_, DDS_DATA_AVAILABLE_STATUS);
    dds_waitset_attach(waitset_, reader_, 0);
    type_ = found;
    note(type, "camera poses from " + short_name(type));
  }

  std::string topic_;  // name in DDS
  Participant participant_;
  dds_entity_t waitset_ = dds_create_waitset(participant_.entity);
  dds_entity_t publications_ =  // reports publishers
      dds_create_reader(participant_.entity, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr);
  const MessageType* type_ = nullptr;  // set with reader_
  dds_entity_t reader_ = 0;
};

}  // namespace

std::unique_ptr<Sink> open_dds(const BridgeOptions& options) {
  return std::make_unique<DdsSink>(options);
}

std::unique_ptr<PoseIntake> open_pose_topic(const BridgeOptions& options) {
  return std::make_unique<DdsIntake>(options);
}

}  // namespace odomd::tools

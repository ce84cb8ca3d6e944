#include "tools/bridge/options.hpp"
#include "tools/bridge/sink.hpp"

#include <dds/dds.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <ratio>
#include <stdexcept>
#include <string>

#include "ros.h"
#include "tools/bridge/odometry.hpp"

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

// The defaults of ROS 2. A reader that does not keep up blocks a write for at most 5 ms.
struct WriterQos {
  explicit WriterQos(std::int32_t depth) : qos(dds_create_qos()) {
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_MSECS(5));
    dds_qset_durability(qos, DDS_DURABILITY_VOLATILE);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, depth);
  }
  ~WriterQos() { dds_delete_qos(qos); }
  WriterQos(const WriterQos&) = delete;
  WriterQos& operator=(const WriterQos&) = delete;
  dds_qos_t* qos;
};

class DdsSink : public Sink {
 public:
  explicit DdsSink(const BridgeOptions& options)
      : frames_(options.names), frame_(options.frame), transforms_wanted_(options.transforms) {
    const std::uint32_t domain = domain_of(options);
    const std::string where = fmt::format("DDS domain {}", domain);
    name_ = fmt::format("dds domain {}", domain);
    participant_ = made(dds_create_participant(domain, nullptr, nullptr), where);
    try {
      odometry_ = writer(nav_msgs_msg_dds__Odometry__desc, "rt/odom", 10);
      if (transforms_wanted_ != Transforms::none)
        transforms_ = writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf", 100);
    } catch (...) {
      dds_delete(participant_);
      throw;
    }
  }
  ~DdsSink() override { dds_delete(participant_); }
  DdsSink(const DdsSink&) = delete;
  DdsSink& operator=(const DdsSink&) = delete;

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
    const WriterQos wanted(depth);
    const dds_entity_t topic =
        made(dds_create_topic(participant_, &type, name, wanted.qos, nullptr), name);
    return made(dds_create_writer(participant_, topic, wanted.qos, nullptr), name);
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
  dds_entity_t participant_ = 0;
  dds_entity_t odometry_ = 0;
  dds_entity_t transforms_ = 0;
};

}  // namespace

std::unique_ptr<Sink> open_dds(const BridgeOptions& options) {
  return std::make_unique<DdsSink>(options);
}

}  // namespace odomd::tools

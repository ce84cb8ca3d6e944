// Receives the car's pose from a ROS 2 topic, in any of the message types that carry a pose.
#include <dds/dds.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <ratio>
#include <stdexcept>

#include "base/wall_clock.hpp"
#include "ros.h"
#include "tools/bridge/pose_intake.hpp"
#include "tools/bridge/sink.hpp"
#include "tools/cli/csv.hpp"

namespace odomd::tools {
namespace {

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
      : PoseIntake(options.input), topic_("rt" + options.input.topic) {
    const std::uint32_t domain = domain_of(options);
    participant_ = dds_create_participant(domain, nullptr, nullptr);
    if (participant_ < 0)
      throw std::runtime_error(
          fmt::format("DDS domain {}: {}; CYCLONEDDS_URI sets the network it uses", domain,
                      dds_strretcode(-participant_)));
    waitset_ = dds_create_waitset(participant_);
    publications_ =
        dds_create_reader(participant_, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr);
    note("waiting", fmt::format("waiting for a publisher in DDS domain {}", domain));
  }
  ~DdsIntake() override { dds_delete(participant_); }
  DdsIntake(const DdsIntake&) = delete;
  DdsIntake& operator=(const DdsIntake&) = delete;

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
    dds_qos_t* const qos = dds_create_qos();
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 100);
    reader_ = dds_create_reader(
        participant_,
        dds_create_topic(participant_, found->descriptor, topic_.c_str(), nullptr, nullptr), qos,
        nullptr);
    dds_delete_qos(qos);
    if (reader_ < 0)
      return note(type, fmt::format("cannot subscribe: {}", dds_strretcode(-reader_)));
    dds_set_status_mask(reader_, DDS_DATA_AVAILABLE_STATUS);
    dds_waitset_attach(waitset_, reader_, 0);
    type_ = found;
    note(type, "camera poses from " + short_name(type));
  }

  std::string topic_;  // name in DDS
  dds_entity_t participant_ = 0;
  dds_entity_t waitset_ = 0;
  dds_entity_t publications_ = 0;      // reports publishers
  const MessageType* type_ = nullptr;  // set with reader_
  dds_entity_t reader_ = 0;
};

}  // namespace

std::unique_ptr<PoseIntake> open_pose_topic(const BridgeOptions& options) {
  return std::make_unique<DdsIntake>(options);
}

}  // namespace odomd::tools

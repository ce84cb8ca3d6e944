// A localiser for systemd/bridge.sh: vague poses at the map's origin on the ROS 2 topic /pose.
#include <dds/dds.h>

#include <chrono>
#include <thread>

#include "ros_poses.h"

int main() {
  const auto& type = geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc;
  const dds_entity_t participant = dds_create_participant(DDS_DOMAIN_DEFAULT, nullptr, nullptr);
  const dds_entity_t topic = dds_create_topic(participant, &type, "rt/pose", nullptr, nullptr);
  const dds_entity_t writer = dds_create_writer(participant, topic, nullptr, nullptr);
  char frame[] = "map";
  geometry_msgs_msg_dds__PoseWithCovarianceStamped_ message{.frame = frame};
  message.rotation[3] = 1.0;
  message.covariance[0] = message.covariance[7] = 25.0;
  message.covariance[35] = 4.0;
  do {
    const std::chrono::nanoseconds now = std::chrono::system_clock::now().time_since_epoch();
    message.sec = static_cast<std::int32_t>(now.count() / 1'000'000'000);
    message.nanosec = static_cast<std::uint32_t>(now.count() % 1'000'000'000);
    std::this_thread::sleep_for(std::chrono::milliseconds{50});
  } while (dds_write(writer, &message) == 0);
  return 1;
}

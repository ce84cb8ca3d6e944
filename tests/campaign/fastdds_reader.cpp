// Reads /odom and /tf as a ROS 2 node on Fast DDS does, and prints every sample's bytes: the topic
// and the serialised payload in hexadecimal, a line a sample. fastdds_reader DOMAIN SECONDS
//
// It knows the types by name only: what is in the bytes the caller decodes, by the definitions of
// the messages.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using Bytes = std::vector<unsigned char>;

class AnyBytes : public fast::TopicDataType {
 public:
  explicit AnyBytes(const std::string& name) {
    setName(name.c_str());
    m_typeSize = 65536;
    m_isGetKeyDefined = false;
  }
  bool serialize(void*, rtps::SerializedPayload_t*) override { return false; }
  bool deserialize(rtps::SerializedPayload_t* payload, void* sample) override {
    static_cast<Bytes*>(sample)->assign(payload->data, payload->data + payload->length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void*) override {
    return [] { return 0U; };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* sample) override { delete static_cast<Bytes*>(sample); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

fast::DataReader* reader_of(fast::DomainParticipant& participant, fast::Subscriber& subscriber,
                            const char* topic, const char* type, int depth) {
  fast::TypeSupport(new AnyBytes(type)).register_type(&participant);
  fast::DataReaderQos qos;  // what a node subscribes with by default
  qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = fast::VOLATILE_DURABILITY_QOS;
  qos.history().kind = fast::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = depth;
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  return subscriber.create_datareader(
      participant.create_topic(topic, type, fast::TOPIC_QOS_DEFAULT), qos);
}

void print_what_came(fast::DataReader& reader, const char* topic) {
  Bytes bytes;
  fast::SampleInfo info;
  while (reader.take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK) {
    if (!info.valid_data) continue;
    std::printf("%s ", topic);
    for (const unsigned char byte : bytes) std::printf("%02x", byte);
    std::printf("\n");
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const auto domain = static_cast<std::uint32_t>(std::atoi(argv[1]));
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(std::atoi(argv[2]));
  fast::DomainParticipant* const participant =
      fast::DomainParticipantFactory::get_instance()->create_participant(
          domain, fast::PARTICIPANT_QOS_DEFAULT);
  if (participant == nullptr) return 1;
  fast::Subscriber* const subscriber = participant->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT);
  fast::DataReader* const odom =
      reader_of(*participant, *subscriber, "rt/odom", "nav_msgs::msg::dds_::Odometry_", 10);
  fast::DataReader* const tf =
      reader_of(*participant, *subscriber, "rt/tf", "tf2_msgs::msg::dds_::TFMessage_", 100);
  while (std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    print_what_came(*odom, "rt/odom");
    print_what_came(*tf, "rt/tf");
  }
  return 0;
}

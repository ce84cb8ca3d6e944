// A node on Fast DDS, as in ROS 2. It knows only the names of types; its caller encodes and decodes
// the bytes according to the message definitions.
//
// fastdds_node DOMAIN SECONDS: reads /odom and /tf and prints a line per sample: the topic and the
// serialised payload in hexadecimal.
// fastdds_node DOMAIN TOPIC TYPE reliable|best_effort: sends the lines of standard input, each with
// its time of sending on CLOCK_MONOTONIC [ns] and the payload.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
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
  bool serialize(void* sample, rtps::SerializedPayload_t* payload) override {
    const Bytes& bytes = *static_cast<Bytes*>(sample);
    std::copy(bytes.begin(), bytes.end(), payload->data);
    payload->length = static_cast<std::uint32_t>(bytes.size());
    payload->encapsulation = CDR_LE;
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* sample) override {
    static_cast<Bytes*>(sample)->assign(payload->data, payload->data + payload->length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* sample) override {
    return [sample] { return static_cast<std::uint32_t>(static_cast<Bytes*>(sample)->size()); };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* sample) override { delete static_cast<Bytes*>(sample); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

fast::DataReader* reader_of(fast::DomainParticipant& participant, fast::Subscriber& subscriber,
                            const char* topic, const char* type, int depth) {
  fast::TypeSupport(new AnyBytes(type)).register_type(&participant);
  fast::DataReaderQos qos;  // a node's defaults for subscriptions
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

int read(fast::DomainParticipant& participant, int seconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
  fast::Subscriber* const subscriber = participant.create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT);
  fast::DataReader* const odom =
      reader_of(participant, *subscriber, "rt/odom", "nav_msgs::msg::dds_::Odometry_", 10);
  fast::DataReader* const tf =
      reader_of(participant, *subscriber, "rt/tf", "tf2_msgs::msg::dds_::TFMessage_", 100);
  while (std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    print_what_came(*odom, "rt/odom");
    print_what_came(*tf, "rt/tf");
  }
  return 0;
}

int write(fast::DomainParticipant& participant, const char* topic, const char* type,
          bool reliable) {
  fast::TypeSupport(new AnyBytes(type)).register_type(&participant);
  fast::DataWriterQos qos;
  qos.reliability().kind =
      reliable ? fast::RELIABLE_RELIABILITY_QOS : fast::BEST_EFFORT_RELIABILITY_QOS;
  qos.history().depth = 10;
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  fast::DataWriter* const writer =
      participant.create_publisher(fast::PUBLISHER_QOS_DEFAULT)
          ->create_datawriter(participant.create_topic(topic, type, fast::TOPIC_QOS_DEFAULT), qos);
  if (writer == nullptr) return 1;
  std::int64_t due_ns = 0;
  for (std::string hex; std::cin >> due_ns >> hex;) {
    Bytes bytes;
    for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
      bytes.push_back(static_cast<unsigned char>(std::stoi(hex.substr(i, 2), nullptr, 16)));
    std::this_thread::sleep_until(
        std::chrono::steady_clock::time_point(std::chrono::nanoseconds(due_ns)));
    if (!writer->write(&bytes)) return 1;
  }
  std::this_thread::sleep_for(std::chrono::seconds(1));  // time to repeat the last samples
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3 && argc != 5) return 2;
  fast::DomainParticipant* const participant =
      fast::DomainParticipantFactory::get_instance()->create_participant(
          static_cast<std::uint32_t>(std::atoi(argv[1])), fast::PARTICIPANT_QOS_DEFAULT);
  if (participant == nullptr) return 1;
  if (argc == 3) return read(*participant, std::atoi(argv[2]));
  return write(*participant, argv[2], argv[3], std::string(argv[4]) == "reliable");
}

// Values read from frames and written into them, according to a configuration.
#include "tools/fault/car_signals.hpp"
#include "tests/gtest.hpp"

namespace odomd::fault::car_signals_test {
namespace {

using estimator::Source;

constexpr const char* database_text = R"(BU_: CAR
BO_ 100 GEAR: 2 CAR
 SG_ Gear : 0|4@1+ (1,0) [0|15] "" CAR
BO_ 101 SPEED: 8 CAR
 SG_ Speed : 7|16@0+ (0.01,0) [0|655] "km/h" CAR
 SG_ Valid : 16|1@1+ (1,0) [0|1] "" CAR
 SG_ Other : 24|8@1+ (1,0) [0|255] "" CAR
BO_ 102 STEER: 4 CAR
 SG_ Coarse : 0|8@1- (1,0) [-128|127] "deg" CAR
 SG_ Fine : 8|8@1+ (0.01,0) [0|2.55] "deg" CAR
)";

struct Car {
  std::vector<can::Database> databases{can::parse_dbc(database_text, "car.dbc")};
  daemon::CanConfig config;

  Car() {
    config.bindings.resize(3);
    config.bindings[0] = {.channel = static_cast<std::uint16_t>(Source::direction),
                          .role = "direction",
                          .message = "GEAR",
                          .signals = {"Gear"},
                          .forward = 4.0,
                          .reverse = 2.0};
    config.bindings[1] = {.channel = static_cast<std::uint16_t>(Source::wheel_rear),
                          .role = "wheel_rear",
                          .message = "SPEED",
                          .signals = {"Speed"},
                          .unit = can::Unit::km_per_h,
                          .scale = 1.02,
                          .valid_when = {{"Valid", 1.0}}};
    config.bindings[2] = {.channel = static_cast<std::uint16_t>(Source::steering),
                          .role = "steering",
                          .message = "STEER",
                          .signals = {"Coarse", "Fine"},
                          .unit = can::Unit::deg,
                          .scale = -1.0,
                          .offset = 0.01};
  }
  [[nodiscard]] CarSignals signals() const {
    return {config, databases, std::vector<std::string>{"can0"}};
  }
};

can::Frame frame_of(std::uint32_t id, std::vector<std::uint8_t> bytes) {
  can::Frame frame;
  frame.id = id;
  frame.length = static_cast<std::uint8_t>(bytes.size());
  std::ranges::copy(bytes, frame.data.begin());
  return frame;
}

Reading only_reading(const CarSignals& signals, const can::Frame& frame) {
  std::array<Reading, can::max_samples_per_frame> readings{};
  const auto message = signals.message_of(frame);
  EXPECT_TRUE(message);
  EXPECT_EQ(signals.read(message.value_or(0), frame, readings), 1U);
  return readings[0];
}

// 1000 * 0.01 km/h, big-endian; the neighbouring bits stay.
TEST(CarSignals, ValuesAreReadAndWrittenInSi) {
  const CarSignals signals = Car{}.signals();
  can::Frame frame = frame_of(101, {0x03, 0xE8, 0x01, 0xAB, 0, 0, 0, 0});
  const Reading reading = only_reading(signals, frame);
  EXPECT_EQ(reading.source, Source::wheel_rear);
  EXPECT_NEAR(reading.value, 1.02 * 10.0 / 3.6, 1e-12);
  signals.write(reading.binding, 1.02 * 20.0 / 3.6, frame);
  EXPECT_EQ(frame.data[0], 0x07);
  EXPECT_EQ(frame.data[1], 0xD0);
  EXPECT_EQ(frame.data[2], 0x01);
  EXPECT_EQ(frame.data[3], 0xAB);
  // A value out of range becomes the nearest that the bits can hold.
  signals.write(reading.binding, -5.0, frame);
  EXPECT_EQ(only_reading(signals, frame).value, 0.0);
}

TEST(CarSignals, AnInvalidValueIsNotRead) {
  const CarSignals signals = Car{}.signals();
  std::array<Reading, can::max_samples_per_frame> readings{};
  const can::Frame frame = frame_of(101, {0x03, 0xE8, 0x00, 0, 0, 0, 0, 0});
  EXPECT_EQ(signals.read(signals.message_of(frame).value_or(0), frame, readings), 0U);
  const can::Frame cut = frame_of(101, {0x03});
  EXPECT_EQ(signals.read(signals.message_of(cut).value_or(0), cut, readings), 0U);
}

TEST(CarSignals, ASumIsDistributedAmongItsSignals) {
  const CarSignals signals = Car{}.signals();
  can::Frame frame = frame_of(102, {10, 50, 0x77, 0x88});  // 10.5°
  const Reading reading = only_reading(signals, frame);
  constexpr double degree = 3.14159265358979323846 / 180.0;
  EXPECT_NEAR(reading.value, -10.5 * degree + 0.01, 1e-12);
  for (const double angle : {-0.3, 0.0, 0.01, 0.5}) {
    signals.write(reading.binding, angle, frame);
    EXPECT_NEAR(only_reading(signals, frame).value, angle, 0.006 * degree) << angle;
  }
  EXPECT_EQ(frame.data[2], 0x77);
}

TEST(CarSignals, ASignIsWrittenToItsOwnSignal) {
  Car car;
  car.databases = {
      can::parse_dbc("BO_ 104 GYRO: 4 CAR\n"
                     " SG_ Rate : 0|16@1+ (0.01,0) [0|0] \"\" CAR\n"
                     " SG_ Minus : 16|1@1+ (1,0) [0|0] \"\" CAR\n",
                     "car.dbc")};
  car.config.bindings = {{.channel = static_cast<std::uint16_t>(Source::yaw_rate),
                          .role = "yaw_rate",
                          .message = "GYRO",
                          .signals = {"Rate"},
                          .sign = can::SignSignal{"Minus", 1.0}}};
  const CarSignals signals = car.signals();
  can::Frame frame = frame_of(104, {0, 0, 0, 0});
  for (const double rate : {-2.0, 3.0, -0.5, 0.0}) {
    signals.write(0, rate, frame);
    EXPECT_NEAR(only_reading(signals, frame).value, rate, 1e-12);
  }
}

// Writing the mean of an axle's two wheels changes both by the same amount.
TEST(CarSignals, AMeanIsSharedEqually) {
  Car car;
  car.databases = {can::parse_dbc(R"(BU_: CAR
BO_ 103 REAR: 4 CAR
 SG_ Left : 0|16@1+ (0.01,0) [0|655] "m/s" CAR
 SG_ Right : 16|16@1+ (0.01,0) [0|655] "m/s" CAR
)",
                                  "car.dbc")};
  car.config.bindings = {{.channel = static_cast<std::uint16_t>(Source::wheel_rear),
                          .role = "wheel_rear",
                          .message = "REAR",
                          .signals = {"Left", "Right"},
                          .scale = 0.5}};
  const CarSignals signals = car.signals();
  can::Frame frame = frame_of(103, {100, 0, 200, 0});  // 1 and 2 m/s
  const Reading reading = only_reading(signals, frame);
  EXPECT_NEAR(reading.value, 1.5, 1e-12);
  signals.write(reading.binding, 1.8, frame);
  EXPECT_EQ(frame.data[0], 130);
  EXPECT_EQ(frame.data[2], 230);
}

TEST(CarSignals, ADirectionIsWrittenAsOneOfItsValues) {
  const CarSignals signals = Car{}.signals();
  can::Frame frame = frame_of(100, {0xF4, 0xFF});
  const Reading reading = only_reading(signals, frame);
  EXPECT_EQ(reading.value, 1.0);
  signals.write(reading.binding, -1.0, frame);
  EXPECT_EQ(frame.data[0], 0xF2);
  EXPECT_EQ(only_reading(signals, frame).value, -1.0);
  signals.write(reading.binding, 0.0, frame);
  EXPECT_EQ(only_reading(signals, frame).value, 0.0);
}

TEST(CarSignals, OneBitOfTheSignalIsFlipped) {
  const CarSignals signals = Car{}.signals();
  for (std::uint64_t draw = 0; draw < 200; ++draw) {
    can::Frame frame = frame_of(101, {0, 0, 0x01, 0, 0, 0, 0, 0});
    signals.flip_bit(only_reading(signals, frame).binding, draw, frame);
    EXPECT_EQ(std::popcount(static_cast<unsigned>(frame.data[0] << 8U | frame.data[1])), 1);
    EXPECT_EQ(frame.data[2], 0x01);
  }
}

}  // namespace
}  // namespace odomd::fault::car_signals_test

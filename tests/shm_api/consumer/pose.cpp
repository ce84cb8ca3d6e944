// Follows the pose: as it comes, predicted to when it takes effect, and in place.
#include <cstdio>
#include <odom/odom.hpp>

int main(int argc, char** argv) {
  auto client = odom::Client::open(argc > 1 ? argv[1] : nullptr);
  if (!client) {
    std::fprintf(stderr, "pose: %s\n", client.message());
    return 1;
  }

  odom::Pose last{};
  for (int i = 0; i < 10; ++i) {
    const auto pose = client->wait(last, std::chrono::milliseconds(100));
    if (!pose) {  // stop the car: nobody knows where it is
      std::fprintf(stderr, "pose: %s\n", pose.message());
      return 1;
    }
    last = *pose;
    const auto ahead = client->predict(pose->time_ns + 35'000'000);
    if (ahead) std::printf("%.3f m, in 35 ms %.3f m\n", pose->x, ahead->x);
  }

  double x = 0.0;
  double y = 0.0;
  const auto status = client->read_in_place([&](const odom::View& view) {
    x = view.x();
    y = view.y();
  });
  if (status != ODOM_OK) return 1;
  std::printf("in place: %.3f m, %.3f m\n", x, y);
  return 0;
}

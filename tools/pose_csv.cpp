#include "tools/pose_csv.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <ostream>

#include "estimator/estimate.hpp"
#include "tools/csv.hpp"

namespace odomd::tools {
namespace {

// More than twice that of 18 numbers of 24 characters, a mode and three counts.
constexpr std::size_t longest_row = 1024;

double sigma_of(double variance) {
  return std::sqrt(variance > 0.0 ? variance : 0.0);
}

}  // namespace

void write_pose_header(std::ostream& out) {
  out << "t,x,y,yaw,vx,vy,yaw_rate,sigma_x,sigma_y,sigma_yaw,mode,"
         "tick,odom_x,odom_y,odom_yaw,reset_count,conditions,cov_xy,cov_xyaw,cov_yyaw,"
         "steering,accel_x,accel_y\n";
}

void append_pose_row(std::string& out, const odom_pose& pose, std::int64_t t_ns) {
  append_seconds(out, t_ns);
  // Straight into place, one number behind the other.
  const std::size_t begin = out.size();
  out.resize(begin + longest_row);
  char* end = out.data() + begin;
  char* const limit = end + longest_row;
  const auto number = [&](auto value) {
    *end++ = ',';
    end = std::to_chars(end, limit, value).ptr;
  };
  const auto numbers = [&](std::initializer_list<double> values) {
    for (const double value : values) number(value);
  };
  const auto& P = pose.covariance;  // xx, xy, xyaw, yy, yyaw, yawyaw
  numbers({pose.x, pose.y, pose.yaw, pose.vx, pose.vy, pose.yaw_rate});
  numbers({sigma_of(P[0]), sigma_of(P[3]), sigma_of(P[5])});
  *end++ = ',';
  end = std::ranges::copy(mode_name(pose.mode), end).out;
  number(pose.tick);
  numbers({pose.odom_x, pose.odom_y, pose.odom_yaw});
  number(pose.reset_count);
  number(pose.conditions);
  numbers({P[1], P[2], P[4], pose.steering, pose.accel_x, pose.accel_y});
  *end++ = '\n';
  out.resize(static_cast<std::size_t>(end - out.data()));
}

std::string mode_name(std::uint32_t mode) {
  return mode < estimator::mode_names.size() ? std::string{estimator::mode_names[mode]}
                                             : "mode " + std::to_string(mode);
}

}  // namespace odomd::tools

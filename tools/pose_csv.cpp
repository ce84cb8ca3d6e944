#include "tools/pose_csv.hpp"

#include <cmath>
#include <ostream>

#include "estimator/estimate.hpp"
#include "tools/csv.hpp"

namespace odomd::tools {
namespace {

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
  const auto number = [&out](double value) {
    out += ',';
    append_number(out, value);
  };
  const auto& P = pose.covariance;  // xx, xy, xyaw, yy, yyaw, yawyaw
  append_seconds(out, t_ns);
  for (const double value : {pose.x, pose.y, pose.yaw, pose.vx, pose.vy, pose.yaw_rate,
                             sigma_of(P[0]), sigma_of(P[3]), sigma_of(P[5])}) {
    number(value);
  }
  out += ',' + mode_name(pose.mode) + ',' + std::to_string(pose.tick);
  for (const double value : {pose.odom_x, pose.odom_y, pose.odom_yaw}) {
    number(value);
  }
  out += ',' + std::to_string(pose.reset_count) + ',' + std::to_string(pose.conditions);
  for (const double value : {P[1], P[2], P[4], pose.steering, pose.accel_x, pose.accel_y}) {
    number(value);
  }
  out += '\n';
}

std::string mode_name(std::uint32_t mode) {
  return mode < estimator::mode_names.size() ? std::string{estimator::mode_names[mode]}
                                             : "mode " + std::to_string(mode);
}

}  // namespace odomd::tools

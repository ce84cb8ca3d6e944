#include "tools/sim/drive_folder.hpp"

#include <array>
#include <charconv>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/text.hpp"

namespace odomd::sim {
namespace {

// A tenth of a micrometre is plenty.
void append_decimal(std::string& out, double value, int decimals) {
  std::array<char, 64> text{};
  const auto [end, status] = std::to_chars(text.data(), text.data() + text.size(), value,
                                           std::chars_format::fixed, decimals);
  if (status != std::errc{}) throw std::runtime_error("the simulated car has left the world");
  out.append(1, ',').append(text.data(), end);
}

void write_whole(const std::filesystem::path& file, std::string_view text) {
  tools::WholeFile whole(file);
  whole.stream() << text;
  whole.finish();
}

}  // namespace

void make_drive_folder(const std::filesystem::path& folder, Existing existing) {
  std::error_code error;
  if (std::filesystem::exists(folder, error) && !std::filesystem::is_directory(folder, error))
    throw std::invalid_argument(folder.string() + ": is not a directory");
  std::filesystem::create_directories(folder, error);
  if (error)
    throw std::invalid_argument(folder.string() + ": cannot be created: " + error.message());
  const bool empty = std::filesystem::is_empty(folder, error);
  if (error) throw std::invalid_argument(folder.string() + ": " + error.message());
  if (!empty && existing == Existing::keep)
    throw std::invalid_argument(folder.string() +
                                ": is not empty; give another directory, or replace the drive in "
                                "it with --force");
}

void write_car_files(const std::filesystem::path& folder, const RunPlan& plan,
                     const Wiring& wiring) {
  write_whole(folder / "car.dbc", bus_database_text(plan.truth));
  write_whole(folder / "car.toml", configuration_text(plan, wiring));
  write_whole(folder / "plant.json", describe(plan).dump(2) + "\n");
}

DriveWriter::DriveWriter(const std::filesystem::path& folder, std::string interface,
                         can::StampDecimals decimals, FilmMarkers film)
    : folder_(folder),
      interface_(std::move(interface)),
      decimals_(decimals),
      log_(tools::open_output(folder / "drive.log")),
      camera_(tools::open_output(folder / "camera.csv")),
      truth_(tools::open_output(folder / "truth.csv")) {
  camera_ << "t_arrival,t_capture,x,y,yaw,sigma_x,sigma_y,sigma_yaw\n";
  truth_ << "t,x,y,yaw,vx,vy,yaw_rate\n";
  if (film == FilmMarkers::leave_out) return;
  film_ = tools::open_output(folder / "markers.csv");
  film_ << "t,x_front,y_front,x_rear,y_rear\n";
}

void DriveWriter::write(const Happenings& happenings) {
  text_.clear();
  for (const can::Frame& frame : happenings.frames)
    can::append_candump_line(text_, frame, interface_, decimals_);
  log_ << text_;

  text_.clear();
  for (const estimator::CameraPose& pose : happenings.camera) {
    tools::append_seconds(text_, pose.arrival_ns);
    text_ += ',';
    tools::append_seconds(text_, pose.capture_ns);
    for (const double value :
         {pose.x, pose.y, pose.yaw, pose.sigma_x, pose.sigma_y, pose.sigma_yaw})
      append_decimal(text_, value, 6);
    text_ += '\n';
  }
  camera_ << text_;

  text_.clear();
  for (const TruthRow& row : happenings.truth) {
    tools::append_seconds(text_, row.time_ns);
    for (const double value : {row.x, row.y, row.yaw, row.v_x, row.v_y, row.yaw_rate})
      append_decimal(text_, value, 7);
    text_ += '\n';
  }
  truth_ << text_;

  text_.clear();
  for (const FilmFrame& frame : happenings.film) {
    text_ += tools::fixed(frame.t_s, 6);
    for (const auto& marker : frame.markers) {
      if (!marker) {
        text_ += ",,";
        continue;
      }
      for (const double value : *marker) append_decimal(text_, value, 3);
    }
    text_ += '\n';
  }
  if (film_.is_open()) film_ << text_;
  if (!film_ || !log_ || !camera_ || !truth_)
    throw std::runtime_error(folder_.string() + ": cannot be written to; is the disk full?");
}

void DriveWriter::close() {
  tools::close_output(log_, folder_ / "drive.log");
  tools::close_output(camera_, folder_ / "camera.csv");
  tools::close_output(truth_, folder_ / "truth.csv");
  if (film_.is_open()) tools::close_output(film_, folder_ / "markers.csv");
}

}  // namespace odomd::sim

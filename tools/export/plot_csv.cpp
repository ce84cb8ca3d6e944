// The poses as CSV: PlotJuggler makes a tree of names with slashes.
#include <ostream>
#include <stdexcept>
#include <string>

#include "tools/cli/csv.hpp"
#include "tools/export/formats.hpp"

namespace odomd::tools {

void write_plot_csv(const PoseTable& poses, ExportTime time, std::ostream& out) {
  if (poses.times_ns.empty())
    throw std::invalid_argument("there is no pose to export; give a pose file with --pose");
  std::string text = "time";
  for (const PoseField* field : poses.fields) text.append(",").append(field->path);
  text += '\n';
  const std::int64_t zero_ns = time == ExportTime::relative ? poses.times_ns.front() : 0;
  for (std::size_t i = 0; i < poses.times_ns.size(); ++i) {
    append_seconds(text, poses.times_ns[i] - zero_ns);
    for (const double value : poses.row(i)) {
      text += ',';
      append_number(text, value);
    }
    text += '\n';
    constexpr std::size_t batch = 1U << 20U;
    if (text.size() < batch) continue;
    out << text;
    text.clear();
  }
  out << text;
}

}  // namespace odomd::tools

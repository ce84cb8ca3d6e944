// Writes the completions of odom and odomd into a directory: bash/odom, zsh/_odom, fish/odom.fish,
// and the same for odomd. Run by the build.
#include <exception>
#include <filesystem>
#include <iostream>
#include <string>

#include "daemon/options.hpp"
#include "tools/cli/files.hpp"
#include "tools/commands/commands.hpp"
#include "tools/completion/scripts.hpp"

namespace odomd::completion {
namespace {

void write(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::create_directories(file.parent_path());
  auto output = tools::open_output(file);
  output << text;
  tools::close_output(output, file);
}

void write_all(const std::filesystem::path& directory, const CLI::App& program) {
  const CommandSpec spec = spec_of(program);
  const std::string& name = spec.path.front();
  write(directory / "bash" / name, bash_script(spec));
  write(directory / "zsh" / ("_" + name), zsh_script(spec));
  write(directory / "fish" / (name + ".fish"), fish_script(spec));
}

}  // namespace
}  // namespace odomd::completion

int main(int argc, char** argv) {
  try {
    if (argc != 2) throw std::invalid_argument("usage: odom_completions DIRECTORY");
    CLI::App odom;
    odomd::tools::describe(odomd::tools::Command(odom));
    odomd::completion::write_all(argv[1], odom);
    CLI::App odomd;
    odomd::daemon::Options options;
    odomd::daemon::add_options(odomd, options);
    odomd::completion::write_all(argv[1], odomd);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "odom_completions: " << error.what() << '\n';
    return 1;
  }
}

// Emulates a serial CAN adapter: a pseudo-terminal with the kernel's slcan line discipline. Each
// line of standard input is sent as the adapter's message in the language of slcan:
// `t1A280102030405060708` is a frame, `sp140000` error-passive with counters tx 140 and rx 0,
// `sb255000` bus-off, `e1a` a missing acknowledgement. First prints the interface's name; ends with
// its input.
#include <fcntl.h>
#include <linux/tty.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <string>
#include <thread>

namespace {

int fail(const char* what) {
  std::perror(what);
  return EXIT_FAILURE;
}

}  // namespace

int main() {
  const int adapter = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (adapter < 0 || ::grantpt(adapter) != 0 || ::unlockpt(adapter) != 0) return fail("pty");
  const int serial = ::open(::ptsname(adapter), O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (serial < 0) return fail("pty");
  termios raw{};
  ::cfmakeraw(&raw);
  const int discipline = N_SLCAN;
  std::array<char, IFNAMSIZ> name{};
  if (::tcsetattr(serial, TCSANOW, &raw) != 0 || ::ioctl(serial, TIOCSETD, &discipline) != 0 ||
      ::ioctl(serial, SIOCGIFNAME, name.data()) != 0)
    return fail("slcan");
  std::cout << name.data() << std::endl;

  // Commands to the adapter ("O": open) are read and not answered.
  std::thread([adapter] {
    std::array<char, 256> commands{};
    while (::read(adapter, commands.data(), commands.size()) > 0) {
    }
  }).detach();
  for (std::string line; std::getline(std::cin, line);) {
    line += '\r';
    if (::write(adapter, line.data(), line.size()) != static_cast<ssize_t>(line.size()))
      return fail("write");
  }
  return EXIT_SUCCESS;
}

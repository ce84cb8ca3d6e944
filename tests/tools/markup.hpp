// Whether a text is well-formed XML, as our own pages and pictures are.
#pragma once

#include "tests/tools/scratch.hpp"

namespace odomd::tools {

/// The first error; empty if there is none.
inline std::string markup_fault(std::string_view text) {
  const Scratch scratch;
  return run_shell(
             "python3 -c 'import sys, xml.etree.ElementTree as xml; xml.parse(sys.argv[1])' " +
             scratch.write("page", text).string() + " 2>&1 | tail -n 1")
      .out;
}

}  // namespace odomd::tools

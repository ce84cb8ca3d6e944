// The layout is a contract with programs that were built years ago: a change that fails here breaks
// them.
#include <cstddef>

#include "shm_api/layout/segment.h"
#include "tests/gtest.hpp"
#include "tests/shm_api/pinned_layout.h"

namespace {

TEST(Abi, StructsArePinned) {
#define FIELD(name, offset) EXPECT_EQ(offsetof(Struct, name), std::size_t{offset});
#define STRUCT(name, size, FIELDS)                \
  {                                               \
    using Struct = name;                          \
    EXPECT_EQ(sizeof(Struct), std::size_t{size}); \
    FIELDS(FIELD)                                 \
  }
  PINNED_STRUCTS(STRUCT)
}

// A new value may be appended to an enum (ODOM_SOURCE_COUNT rises); existing values never change.
TEST(Abi, NumbersArePinned) {
#define CONSTANT(name, value) EXPECT_EQ(ODOM_##name, value);
  PINNED_CONSTANTS(CONSTANT)
  PINNED_WORDS(CONSTANT)
}

}  // namespace

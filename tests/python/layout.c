/* Prints the layout of the public headers, a fact per line, to compare with the Python module:
 *   struct NAME SIZE
 *   field STRUCT NAME OFFSET SIZE
 *   constant NAME VALUE
 */
#include <stdio.h>

#include <odom/odom.h>

#include "tests/shm_api/pinned_layout.h"

#define FIELD(name, offset) \
  printf("field %s %s %zu %zu\n", type, #name, offsetof(Struct, name), sizeof(((Struct*)0)->name));
#define STRUCT(name, size, FIELDS)                   \
  {                                                  \
    typedef name Struct;                             \
    const char* const type = #name;                  \
    printf("struct %s %zu\n", type, sizeof(Struct)); \
    FIELDS(FIELD)                                    \
  }
#define CONSTANT(name, value) printf("constant ODOM_%s %lld\n", #name, (long long)(ODOM_##name));

int main(void) {
  PINNED_STRUCTS(STRUCT)
  PINNED_CONSTANTS(CONSTANT)
  return 0;
}

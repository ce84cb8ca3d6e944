# Cross-compiles for 64-bit ARM with Debian's compiler, and runs the programs under qemu-aarch64.
#
# Libraries come from ODOMD_SYSROOT, a directory of unpacked arm64 packages: tests/campaign/aarch64.sh
# fills one and starts the build. The C and C++ runtime is that of Debian's cross compiler.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)

set(ODOMD_SYSROOT "" CACHE PATH "Unpacked arm64 packages of what the build depends on")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES ODOMD_SYSROOT)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64;-L;${ODOMD_SYSROOT})

set(CMAKE_FIND_ROOT_PATH ${ODOMD_SYSROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${ODOMD_SYSROOT})
set(ENV{PKG_CONFIG_LIBDIR}
  ${ODOMD_SYSROOT}/usr/lib/aarch64-linux-gnu/pkgconfig:${ODOMD_SYSROOT}/usr/share/pkgconfig)

# Dependencies between shared libraries, for the linker.
set(CMAKE_EXE_LINKER_FLAGS_INIT
  "-Wl,-rpath-link,${ODOMD_SYSROOT}/usr/lib/aarch64-linux-gnu:${ODOMD_SYSROOT}/lib/aarch64-linux-gnu")
set(CMAKE_SHARED_LINKER_FLAGS_INIT ${CMAKE_EXE_LINKER_FLAGS_INIT})

# Settings of all targets: the language level, the warnings, the sanitizers.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_C_STANDARD 11)
set(CMAKE_C_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib)
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib)

# For quick rebuilds, ccache and mold are used if they are installed.
if(ODOMD_REBUILD_FAST)
  find_program(ODOMD_CCACHE ccache)
  find_program(ODOMD_MOLD mold)
  mark_as_advanced(ODOMD_CCACHE ODOMD_MOLD)
  if(ODOMD_CCACHE)
    set(CMAKE_C_COMPILER_LAUNCHER ${ODOMD_CCACHE})
    set(CMAKE_CXX_COMPILER_LAUNCHER ${ODOMD_CCACHE})
  endif()
  if(ODOMD_MOLD)
    add_link_options(-fuse-ld=mold)
  endif()
endif()

# Folder of the programs that tests start. In a cross build it contains scripts that start an emulator.
set(ODOMD_TEST_PROGRAMS ${CMAKE_RUNTIME_OUTPUT_DIRECTORY} CACHE PATH "Programs that the tests start")
mark_as_advanced(ODOMD_TEST_PROGRAMS)

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

add_library(odomd_options INTERFACE)
target_include_directories(odomd_options INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(odomd_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wcast-qual -Wformat=2
  -Wundef -Wvla -Werror
  # Designated initialisers omit default members.
  -Wno-missing-field-initializers
  # For bit-identical results: no fused multiply-add, which depends on the target.
  -ffp-contract=off
  # GCC 12 warns of overlaps in "literal" + std::string that do not exist (GCC bug 105651).
  $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-restrict>
  # Clang also warns of local names that another file of the folder has in a namespace.
  $<$<AND:$<BOOL:${ODOMD_UNITY}>,$<COMPILE_LANG_AND_ID:CXX,Clang>>:-Wno-shadow>
  $<$<COMPILE_LANGUAGE:CXX>:-Wnon-virtual-dtor -Woverloaded-virtual -Wold-style-cast>)
target_compile_definitions(odomd_options INTERFACE
  _GNU_SOURCE
  $<$<CONFIG:Debug>:_GLIBCXX_ASSERTIONS>)
if(ODOMD_SANITIZE)
  target_compile_options(odomd_options INTERFACE
    -fsanitize=${ODOMD_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(odomd_options INTERFACE -fsanitize=${ODOMD_SANITIZE})
  # Under AddressSanitizer Eigen aligns memory itself, but libceres, which is not sanitized, does not: neither could
  # free the memory of the other.
  target_compile_definitions(odomd_options INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
endif()

add_library(odomd_without_ubsan INTERFACE)
target_compile_options(odomd_without_ubsan INTERFACE -fno-sanitize=undefined)

# odomd_library(NAME sources...): a static library. Compiling the headers takes longer than compiling the sources, so
# the sources of each folder are compiled together.
function(odomd_library name)
  add_library(${name} STATIC ${ARGN})
  target_link_libraries(${name} PUBLIC odomd_options)
  set_target_properties(${name} PROPERTIES UNITY_BUILD ${ODOMD_UNITY} UNITY_BUILD_MODE GROUP)
  foreach(source ${ARGN})
    get_filename_component(folder ${source} DIRECTORY)
    if(NOT IS_ABSOLUTE ${source}) # a generated file is compiled alone
      string(MAKE_C_IDENTIFIER "of_${folder}" group)
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${group})
    endif()
  endforeach()
endfunction()

# odomd_test(NAME sources... [LIBRARIES libs...]): one GoogleTest binary per room. Several files are compiled together,
# so the tests of each file have a namespace of their own. With ODOMD_TESTS_WITHOUT_UBSAN, UBSan instruments the tested
# code but not the tests, which saves a third of the compile time.
function(odomd_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "LIBRARIES")
  add_executable(${name} ${arg_UNPARSED_ARGUMENTS})
  target_link_libraries(${name} PRIVATE ${arg_LIBRARIES} odomd_options GTest::gmock GTest::gtest_main)
  target_compile_definitions(${name} PRIVATE
    ODOMD_TEST_DATA="${PROJECT_SOURCE_DIR}/tests/data"
    ODOMD_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
    ODOMD_BIN_DIR="${ODOMD_TEST_PROGRAMS}")
  set_target_properties(${name} PROPERTIES UNITY_BUILD ${ODOMD_UNITY} UNITY_BUILD_BATCH_SIZE 6)
  if(ODOMD_REBUILD_FAST)
    target_precompile_headers(${name} PRIVATE <gtest/gtest.h> <gmock/gmock.h>)
  endif()
  # The tested code is optimised as in a release; the tests themselves compile faster without optimisation.
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
  if(ODOMD_TESTS_WITHOUT_UBSAN AND ODOMD_SANITIZE MATCHES "undefined")
    target_link_libraries(${name} PRIVATE odomd_without_ubsan) # linked last, so that its options come last
  endif()
  set(timeout 300)
  if(CMAKE_CROSSCOMPILING OR ODOMD_SANITIZE)
    set(timeout 1500)  # an emulator is slow, and so are sanitizers
  endif()
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT ${timeout})
endfunction()

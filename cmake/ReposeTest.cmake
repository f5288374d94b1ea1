# repose_test(NAME LABEL fast|physics|mpi|slurm|validation SOURCES file... LINK lib... [TIMEOUT seconds]
#             [PROPERTIES name value...])
# A GoogleTest program; each of its tests is known to ctest under its own name and label, with these properties.
include(GoogleTest)
function(repose_test name)
  cmake_parse_arguments(ARG "" "LABEL;TIMEOUT" "SOURCES;LINK;DEFINES;PROPERTIES" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE repose_options ${ARG_LINK} fmt::fmt-header-only GTest::gtest_main)
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)  # their time goes into compiling
  target_compile_definitions(${name} PRIVATE
    REPOSE_TEST_DATA="${PROJECT_SOURCE_DIR}/tests/data" REPOSE_BIN="${PROJECT_BINARY_DIR}/bin"
    REPOSE_SOURCE_DIR="${PROJECT_SOURCE_DIR}" ${ARG_DEFINES})
  set(processors 1)
  if(ARG_LABEL STREQUAL mpi)
    set(processors 2)
  endif()
  gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60
    PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT} PROCESSORS ${processors} ${ARG_PROPERTIES})
endfunction()

# What `cmake --install` copies: each library as a component of the package repose, the programs, and the files with
# which find_package(repose COMPONENTS ...) finds the libraries wherever the prefix lies.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(REPOSE_INSTALL_CMAKEDIR "${CMAKE_INSTALL_LIBDIR}/cmake/repose")

# repose_install_library(NAME LIBRARIES lib... PACKAGES "find_package arguments"...): called by repose_library(), so
# that REPOSE_COMPONENTS lists the components bottom up.
function(repose_install_library name)
  cmake_parse_arguments(ARG "" "" "LIBRARIES;PACKAGES" ${ARGN})
  set_target_properties(repose_${name} PROPERTIES EXPORT_NAME ${name})
  install(TARGETS repose_${name} EXPORT repose-${name}
    ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}"
    INCLUDES DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}")
  install(DIRECTORY include/ DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" FILES_MATCHING PATTERN "*.hpp")
  install(EXPORT repose-${name} NAMESPACE repose:: DESTINATION "${REPOSE_INSTALL_CMAKEDIR}"
    FILE repose-${name}-targets.cmake)

  set(needs ${ARG_LIBRARIES})
  list(FILTER needs INCLUDE REGEX "^repose::")
  list(TRANSFORM needs REPLACE "^repose::" "")
  list(TRANSFORM ARG_PACKAGES REPLACE "(.+)" "\"\\1\"")
  list(JOIN needs " " needs)
  list(JOIN ARG_PACKAGES " " packages)
  set_property(GLOBAL APPEND PROPERTY REPOSE_COMPONENTS ${name})
  set_property(GLOBAL APPEND_STRING PROPERTY REPOSE_COMPONENT_NEEDS
    "set(_repose_${name}_needs ${needs})\nset(_repose_${name}_packages ${packages})\n")
endfunction()

# repose_fix_eigen_alignment(target): matrices cross the border to code that users compile for other processors or with
# a sanitizer, where Eigen would allocate and free them otherwise. Both sides keep to 16 bytes, which malloc gives.
include(CheckCXXSourceCompiles)
function(repose_fix_eigen_alignment target)
  get_target_property(CMAKE_REQUIRED_INCLUDES Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
  if(REPOSE_SANITIZE)
    set(CMAKE_REQUIRED_FLAGS "-fsanitize=${REPOSE_SANITIZE}")
  endif()
  check_cxx_source_compiles("#include <Eigen/Core>
    static_assert(EIGEN_DEFAULT_ALIGN_BYTES == 16 && EIGEN_MALLOC_ALREADY_ALIGNED);
    int main() {}" REPOSE_EIGEN_USES_MALLOC)
  set(definitions EIGEN_MAX_ALIGN_BYTES=16 EIGEN_MALLOC_ALREADY_ALIGNED=1)
  if(NOT REPOSE_EIGEN_USES_MALLOC)
    target_compile_definitions(${target} PUBLIC ${definitions})
  else()
    target_compile_definitions(${target} INTERFACE "$<INSTALL_INTERFACE:${definitions}>")
  endif()
endfunction()

# repose_install_programs(target...)
function(repose_install_programs)
  install(TARGETS ${ARGN} RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}")
endfunction()

# Called once, after all libraries.
function(repose_install_package)
  get_property(REPOSE_COMPONENTS GLOBAL PROPERTY REPOSE_COMPONENTS)
  get_property(REPOSE_COMPONENT_NEEDS GLOBAL PROPERTY REPOSE_COMPONENT_NEEDS)
  configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/repose-config.cmake.in"
    "${PROJECT_BINARY_DIR}/cmake/repose-config.cmake" INSTALL_DESTINATION "${REPOSE_INSTALL_CMAKEDIR}"
    NO_SET_AND_CHECK_MACRO NO_CHECK_REQUIRED_COMPONENTS_MACRO)
  # Before version 1 a new minor version may change an interface.
  write_basic_package_version_file("${PROJECT_BINARY_DIR}/cmake/repose-config-version.cmake"
    COMPATIBILITY SameMinorVersion)
  install(FILES "${PROJECT_BINARY_DIR}/cmake/repose-config.cmake"
    "${PROJECT_BINARY_DIR}/cmake/repose-config-version.cmake" "${PROJECT_SOURCE_DIR}/cmake/FindLIBSVM.cmake"
    DESTINATION "${REPOSE_INSTALL_CMAKEDIR}")
  install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}")
endfunction()

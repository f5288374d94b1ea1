# repose_library(NAME SOURCES file... [PUBLIC lib...] [PRIVATE lib...] [HEADER_ONLY lib...]
#                [PACKAGES "find_package arguments"...] [INTERNAL])
# A static library repose_NAME, alias repose::NAME, with public headers in ./include. It is installed as the
# component NAME of the package repose (cmake/ReposeInstall.cmake) unless it is INTERNAL.
#   PUBLIC       libraries that the public headers include
#   PRIVATE      libraries that only the sources include; a program that uses this one links them
#   HEADER_ONLY  of the sources as well, but nothing to link: a user of the installed library never needs them
#   PACKAGES     where a user's CMake finds the third-party libraries among PUBLIC and PRIVATE
function(repose_library name)
  cmake_parse_arguments(ARG "INTERNAL" "" "SOURCES;PUBLIC;PRIVATE;HEADER_ONLY;PACKAGES" ${ARGN})
  add_library(repose_${name} STATIC ${ARG_SOURCES})
  add_library(repose::${name} ALIAS repose_${name})
  target_include_directories(repose_${name}
    PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>
    PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/src)
  target_link_libraries(repose_${name}
    PUBLIC ${ARG_PUBLIC}
    PRIVATE $<BUILD_INTERFACE:repose_options> ${ARG_PRIVATE})
  foreach(library IN LISTS ARG_HEADER_ONLY)
    target_link_libraries(repose_${name} PRIVATE $<BUILD_INTERFACE:${library}>)
  endforeach()
  target_compile_features(repose_${name} PUBLIC cxx_std_20)
  set_target_properties(repose_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  if(NOT ARG_INTERNAL)
    repose_install_library(${name} LIBRARIES ${ARG_PUBLIC} ${ARG_PRIVATE} PACKAGES ${ARG_PACKAGES})
  endif()
endfunction()

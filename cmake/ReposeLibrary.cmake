# repose_library(NAME SOURCES file... [PUBLIC lib...] [PRIVATE lib...])
# A static library repose_NAME, alias repose::NAME, with public headers in ./include.
function(repose_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(repose_${name} STATIC ${ARG_SOURCES})
  add_library(repose::${name} ALIAS repose_${name})
  target_include_directories(repose_${name}
    PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>
    PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/src)
  target_link_libraries(repose_${name}
    PUBLIC ${ARG_PUBLIC}
    PRIVATE $<BUILD_INTERFACE:repose_options> ${ARG_PRIVATE})
  target_compile_features(repose_${name} PUBLIC cxx_std_20)
  set_target_properties(repose_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
endfunction()

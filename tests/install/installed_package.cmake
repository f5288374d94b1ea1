# One step of the tests of the installed package; see CMakeLists.txt beside it.
set(prefix "${WORK}/moved")

# run(RESULT name OUTPUT name command...): in `RESULT` the exit code, in `OUTPUT` everything printed.
function(run result output)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE text ERROR_VARIABLE text)
  set(${result} "${code}" PARENT_SCOPE)
  set(${output} "${text}" PARENT_SCOPE)
endfunction()

function(must_succeed)
  run(code text ${ARGN})
  if(NOT code EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "exit code ${code} of ${command}:\n${text}")
  endif()
endfunction()

# configure(RESULT name OUTPUT name source_dir build_dir argument...)
function(configure result output source binary)
  run(code text ${CMAKE_COMMAND} -S "${source}" -B "${binary}" -G "${GENERATOR}"
    -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_FLAGS=${FLAGS} -DCMAKE_BUILD_TYPE=Debug
    -DCMAKE_PREFIX_PATH=${prefix} ${ARGN})
  set(${result} "${code}" PARENT_SCOPE)
  set(${output} "${text}" PARENT_SCOPE)
endfunction()

function(build source binary)
  configure(code text "${source}" "${binary}")
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${source} cannot be configured:\n${text}")
  endif()
  must_succeed(${CMAKE_COMMAND} --build "${binary}")
endfunction()

# A project of the given find_package arguments must be refused with a text that matches `sentence`.
function(must_refuse sentence arguments)
  file(WRITE "${WORK}/asking/CMakeLists.txt"
    "cmake_minimum_required(VERSION 3.25)\nproject(asking CXX)\nfind_package(repose ${arguments})\n")
  file(REMOVE_RECURSE "${WORK}/asking/build")
  configure(code text "${WORK}/asking" "${WORK}/asking/build" ${ARGN})
  string(REGEX REPLACE "[ \n]+" " " text "${text}")
  if(code EQUAL 0)
    message(FATAL_ERROR "find_package(repose ${arguments}) was not refused")
  endif()
  if(NOT text MATCHES "${sentence}")
    message(FATAL_ERROR "find_package(repose ${arguments}) does not say \"${sentence}\" but:\n${text}")
  endif()
endfunction()

if(STEP STREQUAL "install")
  file(REMOVE_RECURSE "${WORK}")
  must_succeed(${CMAKE_COMMAND} --install "${REPOSE_BUILD}" --prefix "${WORK}/first")
  file(RENAME "${WORK}/first" "${prefix}")

elseif(STEP STREQUAL "places")
  file(GLOB_RECURSE files "${prefix}/*.cmake" "${prefix}/*.hpp")
  list(LENGTH files count)
  if(count LESS 30)
    message(FATAL_ERROR "only ${count} headers and CMake files are installed")
  endif()
  foreach(file IN LISTS files)
    file(READ "${file}" text)
    foreach(place IN ITEMS "${REPOSE_BUILD}" "${REPOSE_SOURCE}" "${WORK}")
      string(FIND "${text}" "${place}" found)
      if(NOT found EQUAL -1)
        message(FATAL_ERROR "${file} names ${place}")
      endif()
    endforeach()
  endforeach()

elseif(STEP STREQUAL "programs")
  foreach(program IN ITEMS repose repose-dem)
    run(code text "${prefix}/bin/${program}" --version)
    if(NOT code EQUAL 0 OR NOT text MATCHES "${VERSION}")
      message(FATAL_ERROR "${program} --version: exit code ${code}, ${text}")
    endif()
  endforeach()

elseif(STEP STREQUAL "consumer")
  build("${CMAKE_CURRENT_LIST_DIR}/consumer" "${WORK}/consumer")
  must_succeed("${WORK}/consumer/consumer" "${WORK}/consumer/design.h5")
  must_succeed("${prefix}/bin/repose" table show "${WORK}/consumer/design.h5")

elseif(STEP STREQUAL "readme")
  # The project of the section "Use as a library", as it is printed.
  file(READ "${REPOSE_SOURCE}/README.md" text)
  string(REGEX MATCH "    # CMakeLists.txt[^\n]*\n(    [^\n]+\n)+" lists "${text}")
  string(REGEX MATCH "    // plan.cpp[^\n]*\n(    [^\n]+\n|\n)+" program "${text}")
  string(REGEX REPLACE "(^|\n)    " "\\1" lists "${lists}")
  string(REGEX REPLACE "(^|\n)    " "\\1" program "${program}")
  file(WRITE "${WORK}/readme_project/CMakeLists.txt"
    "cmake_minimum_required(VERSION 3.25)\nproject(plan CXX)\n${lists}")
  file(WRITE "${WORK}/readme_project/plan.cpp" "${program}")
  build("${WORK}/readme_project" "${WORK}/readme_project/build")
  must_succeed(${CMAKE_COMMAND} -E chdir "${WORK}" "${WORK}/readme_project/build/plan")
  run(code text "${prefix}/bin/repose" table show "${WORK}/design.h5")
  if(NOT code EQUAL 0 OR NOT text MATCHES "30 rows, 2 columns")
    message(FATAL_ERROR "the README's program wrote: ${text}")
  endif()

elseif(STEP STREQUAL "headers")
  build("${CMAKE_CURRENT_LIST_DIR}/headers" "${WORK}/headers")

elseif(STEP STREQUAL "refusals")
  must_refuse("component tabel of repose does not exist; the components are base, plot, table"
    "REQUIRED COMPONENTS doe tabel")
  must_refuse("requested version \"0\\.99" "0.99 REQUIRED")
  must_refuse("component table of repose needs the package \"HDF5" "REQUIRED COMPONENTS table"
    -DCMAKE_DISABLE_FIND_PACKAGE_HDF5=ON)
  must_refuse("component surrogate of repose needs its component opt, which needs the package \"NLopt"
    "REQUIRED COMPONENTS surrogate" -DCMAKE_DISABLE_FIND_PACKAGE_NLopt=ON)
  # Who asks for neither tables nor optimisers needs no HDF5 and no NLopt.
  file(WRITE "${WORK}/small/CMakeLists.txt" [[
cmake_minimum_required(VERSION 3.25)
project(small CXX)
find_package(repose REQUIRED COMPONENTS doe OPTIONAL_COMPONENTS table)
if(NOT TARGET repose::doe OR TARGET repose::table OR repose_table_FOUND)
  message(FATAL_ERROR "repose::doe must be there and repose::table not")
endif()
]])
  configure(code text "${WORK}/small" "${WORK}/small/build" -DCMAKE_DISABLE_FIND_PACKAGE_HDF5=ON
    -DCMAKE_DISABLE_FIND_PACKAGE_NLopt=ON)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "repose::doe is not found without HDF5 and NLopt:\n${text}")
  endif()

else()
  message(FATAL_ERROR "there is no step \"${STEP}\"")
endif()

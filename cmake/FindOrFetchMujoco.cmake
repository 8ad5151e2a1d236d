# Target mujoco::mujoco, from the first of: MUJOCO_ROOT (folder of a release tarball or of the unpacked
# Python wheel), an installed CMake package, the pinned wheel downloaded into the build tree.

set(FRICID_MUJOCO_VERSION 4.0.1)
set(FRICID_MUJOCO_HASHES
    "sha256:efbfb6e8f2bd63c5f19473f8093f01696937ef453d647b3c7a92620f5873b845" # x86_64
    "sha256:a401eaea5295a29d50c6fdfdb8df8d73c525ab2153751f91c36bd6ccdff95822") # aarch64
set(MUJOCO_ROOT "" CACHE PATH "Folder of a MuJoCo release or unpacked wheel; wins over all else")

# Imports mujoco::mujoco from a folder; sets found_var.
function(fricid_import_mujoco root found_var)
  set(${found_var} FALSE PARENT_SCOPE)
  find_path(include_dir mujoco/mujoco.h PATHS ${root}/include ${root}/mujoco/include
            NO_DEFAULT_PATH NO_CACHE)
  file(GLOB library ${root}/lib/libmujoco.so* ${root}/mujoco/libmujoco.so* ${root}/libmujoco.so*)
  if(NOT include_dir OR NOT library)
    return()
  endif()
  list(GET library 0 library)
  add_library(mujoco::mujoco SHARED IMPORTED GLOBAL)
  set_target_properties(mujoco::mujoco PROPERTIES IMPORTED_LOCATION ${library})
  target_include_directories(mujoco::mujoco SYSTEM INTERFACE ${include_dir})
  set(${found_var} TRUE PARENT_SCOPE)
endfunction()

# Downloads and unpacks the pinned wheel; pip refuses a wrong hash.
function(fricid_fetch_mujoco root)
  if(EXISTS ${root}/mujoco/include/mujoco/mujoco.h)
    return()
  endif()
  find_package(Python3 REQUIRED COMPONENTS Interpreter)
  set(stage ${CMAKE_BINARY_DIR}/_mujoco)
  list(JOIN FRICID_MUJOCO_HASHES " --hash=" hashes)
  file(WRITE ${stage}/requirements.txt "mujoco-core==${FRICID_MUJOCO_VERSION} --hash=${hashes}\n")
  message(STATUS "Downloading mujoco-core ${FRICID_MUJOCO_VERSION}")
  execute_process(
    COMMAND ${Python3_EXECUTABLE} -m pip download -q --disable-pip-version-check --no-deps --require-hashes
            --only-binary=:all: --platform manylinux_2_28_${CMAKE_SYSTEM_PROCESSOR} --implementation cp
            --python-version 3.12 --abi cp312 -d ${stage} -r ${stage}/requirements.txt
    RESULT_VARIABLE failed ERROR_VARIABLE reason)
  if(failed)
    message(FATAL_ERROR "MuJoCo not found. Tried MUJOCO_ROOT (\"${MUJOCO_ROOT}\"), find_package(mujoco) and "
                        "the wheel mujoco-core ${FRICID_MUJOCO_VERSION} by pip:\n${reason}")
  endif()
  file(GLOB wheel ${stage}/mujoco_core-*.whl)
  file(ARCHIVE_EXTRACT INPUT ${wheel} DESTINATION ${root})
endfunction()

if(MUJOCO_ROOT)
  fricid_import_mujoco(${MUJOCO_ROOT} found)
  if(NOT found)
    message(FATAL_ERROR "MUJOCO_ROOT = ${MUJOCO_ROOT} holds no include/mujoco/mujoco.h and lib/libmujoco.so")
  endif()
else()
  find_package(mujoco CONFIG QUIET)
  if(NOT TARGET mujoco::mujoco)
    fricid_fetch_mujoco(${CMAKE_BINARY_DIR}/_deps/mujoco)
    fricid_import_mujoco(${CMAKE_BINARY_DIR}/_deps/mujoco found)
    if(NOT found)
      message(FATAL_ERROR "the wheel in ${CMAKE_BINARY_DIR}/_deps/mujoco has an unknown layout")
    endif()
  endif()
endif()

# The compiler cache, for the project that is configured, not for one that this one is a part of.
if(CMAKE_CXX_COMPILER_LAUNCHER)
  return()
endif()
find_program(FRICID_CCACHE ccache)
mark_as_advanced(FRICID_CCACHE)
if(FRICID_CCACHE)
  # without these ccache would not look at what includes a precompiled header
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env
      CCACHE_SLOPPINESS=pch_defines,time_macros ${FRICID_CCACHE})
  set(CMAKE_C_COMPILER_LAUNCHER ${FRICID_CCACHE})
  add_compile_options($<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fpch-preprocess>)
endif()

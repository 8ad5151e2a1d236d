# cmake --install: program, libraries, headers, models, scenes, MuJoCo beside them, find_package(fricid).
include(CMakePackageConfigHelpers)
include(MujocoLicences)

get_property(libraries GLOBAL PROPERTY FRICID_LIBRARIES)
get_property(include_dirs GLOBAL PROPERTY FRICID_INCLUDE_DIRS)
set_target_properties(fricid PROPERTIES INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}")

install(TARGETS fricid fricid_abi ${libraries} EXPORT fricidTargets)
install(TARGETS fricid_mujoco LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/fricid)
foreach(dir IN LISTS include_dirs)
  install(DIRECTORY ${dir}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
endforeach()
install(DIRECTORY models scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/fricid
        PATTERN real_logs EXCLUDE PATTERN __pycache__ EXCLUDE)
install(FILES LICENSE NOTICE.md DESTINATION ${CMAKE_INSTALL_DATADIR}/fricid)

# The shared library under the name it is linked by, and its headers.
get_target_property(mujoco_library mujoco::mujoco IMPORTED_LOCATION)
get_target_property(mujoco_include mujoco::mujoco INTERFACE_INCLUDE_DIRECTORIES)
if(mujoco_library)
  install(FILES ${mujoco_library} DESTINATION ${CMAKE_INSTALL_LIBDIR})
  fricid_mujoco_licences(${mujoco_library} mujoco_licences)
  cmake_path(GET mujoco_library FILENAME mujoco_name)
  install(FILES ${mujoco_licences} DESTINATION ${CMAKE_INSTALL_DATADIR}/fricid/licences/${mujoco_name})
  install(DIRECTORY ${mujoco_include}/mujoco DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/fricid/third_party
          FILES_MATCHING PATTERN "*.h")
endif()

install(EXPORT fricidTargets NAMESPACE fricid:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/fricid)
configure_package_config_file(cmake/fricidConfig.cmake.in ${CMAKE_BINARY_DIR}/fricidConfig.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/fricid)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/fricidConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/fricidConfig.cmake ${CMAKE_BINARY_DIR}/fricidConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/fricid)

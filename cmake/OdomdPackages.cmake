# Debian packages, one per component: cpack --config build/release/CPackConfig.cmake
# puts them into build/release/packages. Every install rule names its component.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME odomd)
set(ODOMD_PACKAGE_VERSION ${PROJECT_VERSION} CACHE STRING "Version of the Debian packages")
mark_as_advanced(ODOMD_PACKAGE_VERSION)
set(CPACK_PACKAGE_VERSION ${ODOMD_PACKAGE_VERSION})
set(CPACK_PACKAGE_CONTACT "odomd developers <odomd@example.org>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "") # each package has its own
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_COMPONENTS_ALL daemon library development tools python)
if(ODOMD_HAS_DDS)
  list(APPEND CPACK_COMPONENTS_ALL bridge)
endif()
if(ODOMD_HAS_OPENCV)
  list(APPEND CPACK_COMPONENTS_ALL track)
endif()
if(ODOMD_HAS_CERES)
  list(APPEND CPACK_COMPONENTS_ALL fit)
endif()
if(ODOMD_HAS_HTTPLIB)
  list(APPEND CPACK_COMPONENTS_ALL web)
endif()
set(CPACK_STRIP_FILES ON)
# The unit and the configuration contain the paths of the installation.
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

set(CPACK_DEB_COMPONENT_INSTALL ON)
if(CMAKE_CROSSCOMPILING)
  execute_process(COMMAND dpkg-architecture -qDEB_HOST_ARCH --host-type ${CMAKE_LIBRARY_ARCHITECTURE}
    OUTPUT_VARIABLE CPACK_DEBIAN_PACKAGE_ARCHITECTURE OUTPUT_STRIP_TRAILING_WHITESPACE)
endif()
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION misc)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY >=)
set(debian ${PROJECT_SOURCE_DIR}/debian)

set(CPACK_COMPONENT_DAEMON_DESCRIPTION "real-time odometry daemon for cars with a CAN bus
Computes a car's pose from its CAN bus (wheel speeds, IMU, steering) and the
late poses of a camera, every 5 ms, and writes it to shared memory that
controllers read without a copy. Contains the daemon and its systemd service.")
set(CPACK_DEBIAN_DAEMON_PACKAGE_NAME odomd)
set(CPACK_DEBIAN_DAEMON_PACKAGE_SECTION net)
set(CPACK_DEBIAN_DAEMON_PACKAGE_DEPENDS "systemd, udev")
set(CPACK_DEBIAN_DAEMON_PACKAGE_RECOMMENDS "odom-tools, iproute2")
set(CPACK_DEBIAN_DAEMON_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_DAEMON_PACKAGE_CONTROL_EXTRA
  ${debian}/conffiles ${debian}/postinst ${debian}/prerm ${debian}/postrm)

set(CPACK_COMPONENT_LIBRARY_DESCRIPTION "client library of the odomd odometry daemon
Reads the car's pose that odomd publishes in shared memory: the newest pose
copied or in place, past and predicted poses. Needs only libc and libm.")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libodom0)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${debian}/triggers)

set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "client library of the odomd odometry daemon, for building
Headers for C and C++, the static library, and what pkg-config and CMake's
find_package need to build programs that read the car's pose.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libodom-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libodom0 (= ${ODOMD_PACKAGE_VERSION})")

set(CPACK_COMPONENT_TOOLS_DESCRIPTION "command-line tools of the odomd odometry daemon
Shows a running daemon, replays and evaluates recorded drives, simulates a
car, and shows CAN databases.")
set(CPACK_DEBIAN_TOOLS_PACKAGE_NAME odom-tools)
set(CPACK_DEBIAN_TOOLS_PACKAGE_SECTION utils)
set(CPACK_DEBIAN_TOOLS_PACKAGE_RECOMMENDS odomd)

set(CPACK_COMPONENT_PYTHON_DESCRIPTION "Python module of the odomd odometry daemon
Reads the car's pose that odomd publishes in shared memory, through libodom.")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-odom)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3, libodom0 (>= ${ODOMD_PACKAGE_VERSION})")

set(CPACK_COMPONENT_BRIDGE_DESCRIPTION "ROS 2 topics from the odomd odometry daemon
Publishes the car's pose as the ROS 2 topics /odom and /tf, and receives poses
of a localisation or motion capture from a topic, using Cyclone DDS, without
ROS. Contains the program and a systemd service for it.")
set(CPACK_DEBIAN_BRIDGE_PACKAGE_NAME odom-bridge)
set(CPACK_DEBIAN_BRIDGE_PACKAGE_SECTION net)
set(CPACK_DEBIAN_BRIDGE_PACKAGE_DEPENDS odomd)
set(CPACK_DEBIAN_BRIDGE_PACKAGE_RECOMMENDS odom-tools)
set(CPACK_DEBIAN_BRIDGE_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_BRIDGE_PACKAGE_CONTROL_EXTRA
  ${debian}/bridge/postinst ${debian}/bridge/prerm ${debian}/bridge/postrm)

set(CPACK_COMPONENT_TRACK_DESCRIPTION "markers in films for the odomd odometry daemon
Tracks two markers on a car in a film from above, using OpenCV. odom identify
stiffness measures the tyres from these tracks.")
set(CPACK_DEBIAN_TRACK_PACKAGE_NAME odom-track)
set(CPACK_DEBIAN_TRACK_PACKAGE_SECTION utils)
set(CPACK_DEBIAN_TRACK_PACKAGE_DEPENDS odom-tools)

set(CPACK_COMPONENT_FIT_DESCRIPTION "parameter fit for the odomd odometry daemon
Determines a car's parameters from a drive with camera poses, using Ceres: odom
identify fit.")
set(CPACK_DEBIAN_FIT_PACKAGE_NAME odom-fit)
set(CPACK_DEBIAN_FIT_PACKAGE_SECTION utils)
set(CPACK_DEBIAN_FIT_PACKAGE_DEPENDS odom-tools)

set(CPACK_COMPONENT_WEB_DESCRIPTION "web page of the odomd odometry daemon
Shows a running daemon in a browser, also on a phone, and provides metrics for
Prometheus: odom serve. Contains the program and a systemd service.")
set(CPACK_DEBIAN_WEB_PACKAGE_NAME odom-web)
set(CPACK_DEBIAN_WEB_PACKAGE_SECTION net)
set(CPACK_DEBIAN_WEB_PACKAGE_DEPENDS odomd)
set(CPACK_DEBIAN_WEB_PACKAGE_RECOMMENDS odom-tools)
set(CPACK_DEBIAN_WEB_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_WEB_PACKAGE_CONTROL_EXTRA
  ${debian}/web/postinst ${debian}/web/prerm ${debian}/web/postrm)

# Every package contains its licence and its changes.
set(changes ${PROJECT_BINARY_DIR}/changelog.gz)
execute_process(COMMAND gzip -9nc ${PROJECT_SOURCE_DIR}/CHANGELOG.md OUTPUT_FILE ${changes})
foreach(component ${CPACK_COMPONENTS_ALL})
  string(TOUPPER ${component} upper)
  install(FILES ${debian}/copyright ${changes} COMPONENT ${component}
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
endforeach()

include(CPack)

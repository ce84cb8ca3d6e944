/* The default places of odomd's segment and sockets, for the daemon and its clients. Those of the
 * service are in a directory for each interface below "/run/odomd"; the sockets of a daemon that is
 * started by hand are in "/run/odomd" itself or, if its user may not write there, in
 * "$XDG_RUNTIME_DIR/odomd". Paths are malloc'ed; every function returns ODOM_OK or ODOM_SYSTEM. */
#ifndef ODOMD_LIBODOM_SERVICE_H
#define ODOMD_LIBODOM_SERVICE_H

/* C that C++ reads too. NOLINTBEGIN(modernize-*) */

#include <odom/odom.h>

#ifdef __cplusplus
extern "C" {
#endif

#define ODOMI_SERVICE_DIRECTORY "/run/odomd"

/* DIRECTORY/INSTANCE/LEAF of the first instance by name that has it, or DIRECTORY/LEAF. */
odom_status odomi_service_path(const char* directory, const char* leaf, char** path);

/* A client's socket: $XDG_RUNTIME_DIR/odomd/LEAF if a process serves it, otherwise
 * odomi_service_path(). A runtime directory that is not the user's own is ignored. */
odom_status odomi_socket_path(const char* directory, const char* leaf, char** path);

/* The directory for the sockets of a daemon that is started by hand: $XDG_RUNTIME_DIR/odomd if it
 * is usable and this process may neither write to DIRECTORY nor make it, otherwise DIRECTORY. */
odom_status odomi_socket_directory(const char* directory, char** path);

#ifdef __cplusplus
}
#endif

/* NOLINTEND(modernize-*) */

#endif

/* Where odomd has its segment and sockets when no name is given, for the daemon and its clients:
 * the service in a directory for each interface below "/run/odomd"; the sockets of a daemon that is
 * started by hand in "/run/odomd" itself or, where its user may not write, in
 * "$XDG_RUNTIME_DIR/odomd". Paths are malloc'ed; every function returns ODOM_OK or ODOM_SYSTEM. */
#ifndef ODOMD_LIBODOM_SERVICE_H
#define ODOMD_LIBODOM_SERVICE_H

/* C that C++ reads too. NOLINTBEGIN(modernize-*) */

#include <odom/odom.h>

#ifdef __cplusplus
extern "C" {
#endif

#define ODOMI_SERVICE_DIRECTORY "/run/odomd"

/* DIRECTORY/INSTANCE/LEAF of the first instance, by name, that has one, else DIRECTORY/LEAF. */
odom_status odomi_service_path(const char* directory, const char* leaf, char** path);

/* A client's socket: $XDG_RUNTIME_DIR/odomd/LEAF if a process serves it, else that of
 * odomi_service_path(). A runtime directory that is not the user's own is ignored. */
odom_status odomi_socket_path(const char* directory, const char* leaf, char** path);

/* The directory for the sockets of a daemon that is started by hand: DIRECTORY if this process may
 * write there or make it, or if there is no other, else $XDG_RUNTIME_DIR/odomd. */
odom_status odomi_socket_directory(const char* directory, char** path);

#ifdef __cplusplus
}
#endif

/* NOLINTEND(modernize-*) */

#endif

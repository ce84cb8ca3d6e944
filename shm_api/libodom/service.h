/* The places of the service where clients look when no name is given. */
#ifndef ODOMD_LIBODOM_SERVICE_H
#define ODOMD_LIBODOM_SERVICE_H

/* C that C++ reads too. NOLINTBEGIN(modernize-*) */

#include <odom/odom.h>

#ifdef __cplusplus
extern "C" {
#endif

#define ODOMI_SERVICE_DIRECTORY "/run/odomd"

/* DIRECTORY/INSTANCE/LEAF of the first instance, by name, that has one, else DIRECTORY/LEAF. The
 * path is malloc'ed. ODOM_OK or ODOM_SYSTEM. */
odom_status odomi_service_path(const char* directory, const char* leaf, char** path);

#ifdef __cplusplus
}
#endif

/* NOLINTEND(modernize-*) */

#endif

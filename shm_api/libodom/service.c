/* Finds the segment and the sockets of the service and of daemons that are started by hand. */
#include "shm_api/libodom/service.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

/* Whether the file exists; opening it later reports whether it is accessible. */
static int has(DIR* directory, const char* instance, const char* leaf) {
  char path[NAME_MAX + 64];
  const int length = snprintf(path, sizeof path, "%s/%s", instance, leaf);
  struct stat status;
  return length > 0 && (size_t)length < sizeof path &&
         fstatat(dirfd(directory), path, &status, AT_SYMLINK_NOFOLLOW) == 0;
}

static void first_instance(const char* directory, const char* leaf, char first[NAME_MAX + 1]) {
  first[0] = '\0';
  DIR* opened = opendir(directory);
  if (opened == NULL) return;
  for (const struct dirent* entry = readdir(opened); entry != NULL; entry = readdir(opened)) {
    const char* name = entry->d_name;
    if (name[0] == '.' || (first[0] != '\0' && strcmp(name, first) >= 0)) continue;
    if (has(opened, name, leaf)) memcpy(first, name, strlen(name) + 1);
  }
  closedir(opened);
}

/* DIRECTORY/NAME, or DIRECTORY/BETWEEN/NAME if BETWEEN is not empty. */
static odom_status join(const char* directory, const char* between, const char* name, char** path) {
  const size_t bytes = strlen(directory) + strlen(between) + strlen(name) + 3;
  *path = malloc(bytes);
  if (*path == NULL) return ODOM_SYSTEM;
  (void)snprintf(*path, bytes, "%s/%s%s%s", directory, between, between[0] == '\0' ? "" : "/",
                 name);
  return ODOM_OK;
}

odom_status odomi_service_path(const char* directory, const char* leaf, char** path) {
  char instance[NAME_MAX + 1];
  first_instance(directory, leaf, instance);
  return join(directory, instance, leaf, path);
}

/* As the XDG Base Directory Specification requires: absolute, and owned by the user. Nobody else
 * may write there, since they could pose as the daemon. */
static int is_usable(const char* runtime) {
  struct stat status;
  return runtime != NULL && runtime[0] == '/' && stat(runtime, &status) == 0 &&
         S_ISDIR(status.st_mode) && status.st_uid == geteuid() &&
         (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

/* Whether a process has this socket open; a killed process leaves its file. Connecting a datagram
 * socket fails and so disturbs nobody, and the error shows whether the socket is served. */
static int is_served(const char* path) {
  struct sockaddr_un address = {.sun_family = AF_UNIX};
  if (strlen(path) >= sizeof address.sun_path) return 0;
  memcpy(address.sun_path, path, strlen(path) + 1);
  const int probe = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (probe < 0) return 0;
  const int served = connect(probe, (const struct sockaddr*)&address, sizeof address) == 0 ||
                     (errno != ENOENT && errno != ECONNREFUSED);
  close(probe);
  return served;
}

odom_status odomi_socket_path(const char* directory, const char* leaf, char** path) {
  const char* runtime = secure_getenv("XDG_RUNTIME_DIR");
  if (is_usable(runtime)) {
    if (join(runtime, "odomd", leaf, path) != ODOM_OK) return ODOM_SYSTEM;
    if (is_served(*path)) return ODOM_OK;
    free(*path);
  }
  return odomi_service_path(directory, leaf, path);
}

static int may_write(const char* directory) {
  return faccessat(AT_FDCWD, directory, W_OK | X_OK, AT_EACCESS) == 0;
}

static int may_write_or_make(const char* directory) {
  if (may_write(directory)) return 1;
  const char* slash = strrchr(directory, '/');
  if (errno != ENOENT || slash == NULL) return 0;
  char* parent = strndup(directory, (size_t)(slash - directory));
  const int may = parent != NULL && may_write(parent);
  free(parent);
  return may;
}

odom_status odomi_socket_directory(const char* directory, char** path) {
  const char* runtime = getenv("XDG_RUNTIME_DIR"); /* works with file capabilities, too */
  if (is_usable(runtime) && !may_write_or_make(directory)) return join(runtime, "", "odomd", path);
  *path = strdup(directory);
  return *path != NULL ? ODOM_OK : ODOM_SYSTEM;
}

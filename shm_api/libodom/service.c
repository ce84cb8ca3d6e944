/* Finds the service's segment and sockets: a directory for each interface that it serves. */
#include "shm_api/libodom/service.h"

#include <dirent.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* It may not be accessible; opening it reports that. */
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

odom_status odomi_service_path(const char* directory, const char* leaf, char** path) {
  char instance[NAME_MAX + 1];
  first_instance(directory, leaf, instance);
  const size_t bytes = strlen(directory) + strlen(instance) + strlen(leaf) + 3;
  *path = malloc(bytes);
  if (*path == NULL) return ODOM_SYSTEM;
  if (instance[0] == '\0') {
    (void)snprintf(*path, bytes, "%s/%s", directory, leaf);
  } else {
    (void)snprintf(*path, bytes, "%s/%s/%s", directory, instance, leaf);
  }
  return ODOM_OK;
}

/* Sends camera poses: one SOCK_SEQPACKET message per pose, never blocking. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include <odom/odom.h>

#include "shm_api/libodom/service.h"

_Static_assert(sizeof(odom_camera_message) == 80, "the wire format is pinned");

struct odom_camera {
  struct sockaddr_un address;
  int socket; /* -1: not connected */
  uint64_t sequence;
};

static int connect_to(odom_camera* camera) {
  const int connection = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (connection < 0) return -errno;
  if (connect(connection, (const struct sockaddr*)&camera->address, sizeof camera->address) != 0) {
    const int error = errno;
    close(connection);
    return -error;
  }
  camera->socket = connection;
  return 0;
}

static void disconnect(odom_camera* camera) {
  if (camera->socket >= 0) close(camera->socket);
  camera->socket = -1;
}

static int open_at(const char* path, odom_camera** camera) {
  odom_camera* opened = calloc(1, sizeof *opened);
  if (opened == NULL) return -ENOMEM;
  opened->socket = -1;
  opened->address.sun_family = AF_UNIX;
  const size_t length = strlen(path);
  int error = length == 0 ? -EINVAL : 0;
  if (length >= sizeof opened->address.sun_path) error = -ENAMETOOLONG;
  if (error == 0) {
    memcpy(opened->address.sun_path, path, length + 1);
    error = connect_to(opened);
  }
  if (error != 0) {
    free(opened);
    return error;
  }
  *camera = opened;
  return 0;
}

int odom_camera_open(const char* path, odom_camera** camera) {
  if (camera == NULL) return -EINVAL;
  *camera = NULL;
  if (path != NULL) return open_at(path, camera);
  char* found = NULL;
  if (odomi_socket_path(ODOMI_SERVICE_DIRECTORY, "camera.sock", &found) != ODOM_OK) return -ENOMEM;
  const int error = open_at(found, camera);
  free(found);
  return error;
}

static int is_usable(const odom_camera_message* m) {
  return m->clock <= ODOM_CLOCK_LOG && isfinite(m->x) && isfinite(m->y) && isfinite(m->yaw) &&
         isfinite(m->sigma_x) && isfinite(m->sigma_y) && isfinite(m->sigma_yaw) &&
         m->sigma_x > 0.0 && m->sigma_y > 0.0 && m->sigma_yaw > 0.0;
}

static int send_once(odom_camera* camera, const odom_camera_message* message) {
  if (send(camera->socket, message, sizeof *message, MSG_NOSIGNAL | MSG_DONTWAIT) >= 0) return 0;
  return -errno;
}

/* The reason that the daemon sent before it closed the connection; 0: none. */
static int refusal_of(const odom_camera* camera) {
  int32_t reason = 0;
  /* The first call may return the error that the poses in the closed connection are lost. */
  for (int attempt = 0; attempt < 2; ++attempt)
    if (recv(camera->socket, &reason, sizeof reason, MSG_DONTWAIT) == (ssize_t)sizeof reason)
      return reason < 0 ? reason : 0;
  return 0;
}

int odom_camera_send(odom_camera* camera, const odom_camera_message* message) {
  if (camera == NULL || message == NULL || !is_usable(message)) return -EINVAL;
  odom_camera_message filled = *message;
  filled.magic = ODOM_CAMERA_MAGIC;
  filled.version = ODOM_CAMERA_VERSION;
  filled.sequence = ++camera->sequence; /* counts dropped poses too: the daemon sees the loss */
  filled.reserved = 0;

  /* Two attempts: the daemon may have ended since the last pose, or closed an idle connection. */
  int error = -ENOTCONN;
  for (int attempt = 0; attempt < 2; ++attempt) {
    if (camera->socket < 0) {
      error = connect_to(camera);
      if (error != 0) return error;
    }
    error = send_once(camera, &filled);
    if (error == 0 || error == -EAGAIN || error == -EINTR || error == -ENOBUFS) return error;
    const int refused = refusal_of(camera);
    disconnect(camera);
    if (refused != 0) return refused;
  }
  return error;
}

int odom_camera_flush(odom_camera* camera, int64_t timeout_ns) {
  if (camera == NULL) return -EINVAL;
  if (camera->socket < 0) return -ENOTCONN;
  const struct timespec pause = {0, 1000000};
  for (int64_t left_ns = timeout_ns;; left_ns -= pause.tv_nsec) {
    int unread = 0;
    if (ioctl(camera->socket, TIOCOUTQ, &unread) != 0) return -errno;
    if (unread == 0) break;
    if (left_ns <= 0) return -EAGAIN;
    nanosleep(&pause, NULL);
  }
  /* Poses in the queue of a connection that the daemon closed are lost, not read. */
  int lost = 0;
  socklen_t size = sizeof lost;
  if (getsockopt(camera->socket, SOL_SOCKET, SO_ERROR, &lost, &size) != 0) lost = errno;
  const int refused = refusal_of(camera);
  const int error = refused != 0 ? refused : -lost;
  if (error != 0) disconnect(camera);
  return error;
}

void odom_camera_close(odom_camera* camera) {
  if (camera == NULL) return;
  disconnect(camera);
  free(camera);
}

/* Follows the pose: the newest, one predicted to the time when it takes effect, and a past one. */
#include <odom/odom.h>
#include <stdio.h>

int main(int argc, char** argv) {
  odom_client* client;
  odom_status status = odom_open(argc > 1 ? argv[1] : NULL, &client);
  if (status != ODOM_OK) {
    fprintf(stderr, "pose: %s\n", odom_strstatus(status));
    return 1;
  }

  odom_pose pose = {0};
  for (int i = 0; i < 10; ++i) {
    status = odom_wait(client, &pose, sizeof pose, 100000000); /* 100 ms */
    if (status == ODOM_STALE) fprintf(stderr, "odomd is silent, this is its last pose\n");
    if (status != ODOM_OK) break; /* stop the car: nobody knows where it is */

    odom_pose ahead; /* where the car is when a command given now arrives: 35 ms later */
    odom_pose past;  /* where it was when the picture was taken: 20 ms ago */
    if (odom_predict(&pose, pose.time_ns + 35000000, &ahead) == ODOM_OK &&
        odom_at(client, pose.time_ns - 20000000, &past, sizeof past) == ODOM_OK)
      printf("%llu: x %.3f m, then %.3f m, was %.3f m\n", (unsigned long long)pose.tick, pose.x,
             ahead.x, past.x);
  }

  odom_view view; /* without a copy: only the words that are needed */
  double x, y;
  int attempts = 0;
  do {
    status = odom_begin(client, &view);
    if (status != ODOM_OK && status != ODOM_STALE) break;
    x = odom_view_double(&view, ODOM_WORD_X);
    y = odom_view_double(&view, ODOM_WORD_Y);
    if (odom_validate(&view)) {
      printf("in place: %.3f m, %.3f m\n", x, y);
      break;
    }
  } while (++attempts < 3);

  odom_close(client);
  return status == ODOM_OK ? 0 : 1;
}

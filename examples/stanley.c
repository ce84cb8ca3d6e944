/* A path-following controller that uses odomd's pose, in C. Shows what to check before steering.
 *
 *   stanley_c --path FILE [--shm NAME] [--cycles N] [--delay S] [--speed V]
 *             [--max-sigma M] [--max-sigma-yaw RAD]
 *
 * For each pose it prints one command:
 *   tick,state,steering,speed,cross_track,reset_count,instance        [rad, m/s, m]
 * A car would send steering and speed to its actuators instead. The path is a CSV file with the
 * columns x and y and, optionally, speed or vx, such as truth.csv of `odom sim`.
 *
 * Stanley's law steers the front axle onto the path. It uses the pose predicted to the time at
 * which the steering will have moved:  steering = heading error - atan(gain * cross_track / speed).
 */
#include <getopt.h>
#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <odom/odom.h>

static const double pi = 3.14159265358979323846;
static const double gain = 2.0;          /* 1/s */
static const double softening = 0.5;     /* m/s, added to the speed: smoother steering when slow */
static const double max_steering = 0.4;  /* rad */
static const double max_distance = 1.0;  /* m from the path; above it, the car is lost */
static const double min_spacing = 0.02;  /* m between points */
static const double closing_gap = 0.5;   /* m from end to start; below it, the path is a loop */
static const double degraded_part = 0.5; /* fraction of the speed while the pose is degraded */
/* Stop above these sigmas: the car may have left its lane. */
static const double lane_sigma = 0.3;     /* m, --max-sigma: the lane has 3 sigma on each side */
static const double lane_sigma_yaw = 0.2; /* rad, --max-sigma-yaw */
enum { POINTS_BEHIND = 10, POINTS_AHEAD = 50, MAX_POINTS = 100000 }; /* of the path */

typedef struct {
  double x, y, yaw, speed;
} point;

typedef struct {
  point* points;
  int count;
  bool closed;
} path;

typedef struct {
  const char* state;
  double steering, speed, cross_track;
} command;

static void fail(const char* file, const char* why) {
  fprintf(stderr, "stanley: %s: %s\n", file, why);
  exit(2);
}

static double distance(const point* a, const point* b) {
  return sqrt((a->x - b->x) * (a->x - b->x) + (a->y - b->y) * (a->y - b->y));
}

/* The `index`-th field of a line, counted from 0; NULL if there are fewer. */
static const char* field(const char* line, int index) {
  while (line != NULL && index-- > 0)
    if ((line = strchr(line, ',')) != NULL) ++line;
  return line;
}

static int column(const char* header, const char* name) {
  const char* text = NULL;
  for (int i = 0; (text = field(header, i)) != NULL; ++i)
    if (strcspn(text, ",\r\n") == strlen(name) && strncmp(text, name, strlen(name)) == 0) return i;
  return -1;
}

static double number(const char* file, const char* text) {
  char* end = NULL;
  const double value = text == NULL ? NAN : strtod(text, &end);
  if (end == text || !isfinite(value)) fail(file, "a row lacks a number");
  return value;
}

/* Leaves out rows of a stationary car, and rows too close to the one before. */
static path read_path(const char* name, double speed) {
  char line[1024];
  FILE* file = fopen(name, "r");
  if (file == NULL || fgets(line, sizeof line, file) == NULL) fail(name, "cannot be read");
  const int x = column(line, "x"), y = column(line, "y");
  const int v = column(line, "speed") >= 0 ? column(line, "speed") : column(line, "vx");
  if (x < 0 || y < 0) fail(name, "the first line has no columns x and y");

  path route = {calloc(MAX_POINTS, sizeof(point)), 0, false};
  if (route.points == NULL) fail(name, "no memory");
  while (fgets(line, sizeof line, file) != NULL) {
    const point p = {number(name, field(line, x)), number(name, field(line, y)), 0.0,
                     v < 0 ? speed : number(name, field(line, v))};
    if (p.speed < 0.1) continue;
    if (route.count > 0 && distance(&p, &route.points[route.count - 1]) < min_spacing) continue;
    if (route.count == MAX_POINTS) fail(name, "the path is too long");
    route.points[route.count++] = p;
  }
  fclose(file);
  if (route.count < 2) fail(name, "a path needs two points");

  route.closed = distance(&route.points[0], &route.points[route.count - 1]) < closing_gap;
  for (int i = 0; i < route.count; ++i) { /* yaw towards the next point; last: as the one before */
    const point* p = &route.points[i + 1 < route.count ? i : i - 1];
    route.points[i].yaw = atan2(p[1].y - p[0].y, p[1].x - p[0].x);
  }
  return route;
}

/* The point of the path nearest to `at`: searched around `last`, or everywhere if `last` < 0. */
static int nearest(const path* route, const point* at, int last) {
  const bool anywhere = last < 0 || route->count <= POINTS_BEHIND + POINTS_AHEAD;
  const int first = anywhere ? 0 : last - POINTS_BEHIND;
  const int end = anywhere ? route->count : last + POINTS_AHEAD;
  int best = last < 0 ? 0 : last;
  double best_distance = INFINITY;
  for (int i = first; i < end; ++i) {
    if (!route->closed && (i < 0 || i >= route->count)) continue;
    const int index = (i + route->count) % route->count;
    const double d = distance(&route->points[index], at);
    if (d < best_distance) {
      best = index;
      best_distance = d;
    }
  }
  return best;
}

static command follow(const path* route, int* last, const odom_pose* pose, double front_axle) {
  const point front = {pose->x + front_axle * cos(pose->yaw), pose->y + front_axle * sin(pose->yaw),
                       pose->yaw, pose->vx};
  *last = nearest(route, &front, *last);
  const point* p = &route->points[*last];
  if (!route->closed && *last == route->count - 1) return (command){.state = "arrived"};
  if (!(distance(p, &front) <= max_distance)) return (command){.state = "lost"};

  /* Positive if the front axle is to the left of the path. */
  const double cross_track = cos(p->yaw) * (front.y - p->y) - sin(p->yaw) * (front.x - p->x);
  const double heading_error = remainder(p->yaw - front.yaw, 2.0 * pi);
  double steering = heading_error - atan2(gain * cross_track, softening + fabs(front.speed));
  steering = fmax(-max_steering, fmin(max_steering, steering));
  if (pose->mode == ODOM_DEGRADED) /* a condition bit shows why: drive carefully */
    return (command){"degraded", steering, degraded_part * p->speed, cross_track};
  return (command){"drive", steering, p->speed, cross_track};
}

int main(int argc, char** argv) {
  const struct option options[] = {
      {"path", required_argument, NULL, 'p'},          {"shm", required_argument, NULL, 's'},
      {"cycles", required_argument, NULL, 'c'},        {"delay", required_argument, NULL, 'd'},
      {"speed", required_argument, NULL, 'v'},         {"max-sigma", required_argument, NULL, 'm'},
      {"max-sigma-yaw", required_argument, NULL, 'y'}, {NULL, 0, NULL, 0}};
  const char *path_name = NULL, *shm = NULL;
  long cycles = -1;                 /* no limit */
  double delay = 0.02, speed = 1.0; /* s from pose to moved steering; m/s if the path has none */
  double max_sigma = lane_sigma, max_sigma_yaw = lane_sigma_yaw;
  for (int option; (option = getopt_long(argc, argv, "", options, NULL)) != -1;) {
    if (option == 'p') path_name = optarg;
    if (option == 's') shm = optarg;
    if (option == 'c') cycles = strtol(optarg, NULL, 10);
    if (option == 'd') delay = strtod(optarg, NULL);
    if (option == 'v') speed = strtod(optarg, NULL);
    if (option == 'm') max_sigma = strtod(optarg, NULL);
    if (option == 'y') max_sigma_yaw = strtod(optarg, NULL);
    if (option == '?') return 2;
  }
  if (path_name == NULL || optind != argc) fail("usage", "--path FILE is needed");
  const path route = read_path(path_name, speed);
  setvbuf(stdout, NULL, _IOLBF, 0);

  odom_client* client = NULL; /* the daemon may start later */
  for (odom_status status; (status = odom_open(shm, &client)) != ODOM_OK;) {
    fprintf(stderr, "stanley: waiting: %s\n", odom_strstatus(status));
    nanosleep(&(struct timespec){.tv_nsec = 200000000}, NULL);
  }

  odom_pose pose = {0};
  odom_info info;
  odom_get_info(client, &info, sizeof info);
  uint32_t resets = 0;
  int last = -1; /* index on the path; -1: unknown */
  printf("tick,state,steering,speed,cross_track,reset_count,instance\n");
  for (; cycles != 0; cycles -= cycles > 0) {
    command now = {.state = "silent"}; /* all zero: stops if there is no fresh pose */
    const uint64_t instance = info.instance_id;
    const odom_status status = odom_wait(client, &pose, sizeof pose, 10 * info.period_ns);
    odom_get_info(client, &info, sizeof info);
    /* After a restart or a jump of the map pose, the car may be anywhere along the path. */
    if (info.instance_id != instance || pose.reset_count != resets) last = -1;
    resets = pose.reset_count;

    odom_pose ahead;
    if (status != ODOM_OK)
      last = -1; /* stale, timed out or no pose yet; the client re-attaches by itself */
    else if (pose.mode == ODOM_INITIALISING || pose.mode == ODOM_FAULT)
      now.state = odom_mode_name(pose.mode);
    else if (odom_predict(&pose, pose.time_ns + (int64_t)(delay * 1e9), &ahead) != ODOM_OK)
      now.state = "unpredictable"; /* the delay is longer than 100 ms */
    else if (!(odom_position_sigma(&ahead) <= max_sigma &&
               sqrt(ahead.covariance[5]) <= max_sigma_yaw)) {
      now.state = "uncertain"; /* in any mode */
      last = -1;
    } else
      now = follow(&route, &last, &ahead, info.front_axle);
    printf("%" PRIu64 ",%s,%.4f,%.4f,%.4f,%" PRIu32 ",%016" PRIx64 "\n", pose.tick, now.state,
           now.steering, now.speed, now.cross_track, pose.reset_count, info.instance_id);
  }
  odom_close(client);
  free(route.points);
  return 0;
}

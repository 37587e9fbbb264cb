// A straight way over a surface, on from triangle to triangle as if they were laid flat. In the dialect of
// kernel_language.inl, behind flight_kernel.inl.

enum { kMostTriangles = 16, kMostCorners = 6, kNoEdge = 3 };
PATINATE_CONSTANT(double, kSteepest, 0.70710678118654752);  // Cosine of the steepest rise that is walked up.

// Where something runs on a surface, and how.
typedef struct Runner {
  SurfacePlace at;
  bool is_front;
  Vector normal;    // Of the triangle, on the side it is on; unit.
  Vector ahead;     // Unit, tangential.
  Vector velocity;  // mm/s, tangential.
} Runner;

// What lies above the way, as a chain of straight pieces: from a height that falls evenly to 0 at the way's end.
typedef struct WalkCorner {
  Vector position;
  Runner runner;  // Below it.
} WalkCorner;

enum {
  kHasArrived = 0,
  kIsStopped = 1,  // At the edge of the last triangle: the surface ends there, or rises by more than 45 degrees.
  kIsTooFar = 2    // Over more triangles than kMostTriangles, or more than kMostCorners sharp edges.
};

typedef struct Walk {
  Runner runner;  // At the end of the way; stopped: where it came onto the last triangle.
  u32 end;
  double height;        // There, mm.
  double slope;         // By which pieces sink.
  double least_cosine;  // Of the angle by which the surface may fall off below a piece.
  // From the beginning on; the way leads from the last one straight to the end, and all pieces are free of the
  // triangles that were walked on, since there is one wherever the surface falls off by more than a piece sinks.
  WalkCorner corners[kMostCorners];
  i32 num_corners;
  i32 triangles[kMostTriangles];
  i32 num_triangles;
  i32 entered_over;  // Corner of the triangle across from the edge that it came over; kNoEdge: none.
} Walk;

// Velocity along one surface as it is along another that meets it: turned with the normal, the shortest way.
static inline Vector turned(Vector velocity, Vector from, Vector to) {
  const double cosine = inner(from, to);
  if (cosine < -0.999) return opposite(velocity);  // Round the edge of a thin plate.
  const Vector axis = outer(from, to), across = outer(axis, velocity);
  const double share = inner(axis, velocity) / (1.0 + cosine);
  return vector_of(velocity.x * cosine + across.x + axis.x * share, velocity.y * cosine + across.y + axis.y * share,
                   velocity.z * cosine + across.z + axis.z * share);
}

// Velocity after `way` along the unit direction: t solves direction . (v t + a t^2 / 2) = way.
static inline Vector velocity_after(double way, Vector direction, Vector velocity, Vector acceleration) {
  const double b = inner(direction, velocity), a = 0.5 * inner(direction, acceleration);
  const double root = PATINATE_SQRT(greater(0.0, b * b + 4.0 * a * way));
  const double time = b + root > 0.0 ? 2.0 * way / (b + root) : 0.0;
  return plus(velocity, times(time, acceleration));
}

static inline void add_corner(Walk* w, Vector position) {
  w->corners[w->num_corners].position = position;
  w->corners[w->num_corners].runner = w->runner;
  ++w->num_corners;
}

static inline bool has_walked_on(const Walk* w, i32 triangle) {
  for (i32 i = 0; i < w->num_triangles; ++i) {
    if (w->triangles[i] == triangle) return true;
  }
  return false;
}

// Onto the triangle across from corner k, after `way` on this one. Returns whether it can.
static inline bool cross_edge(const Surroundings* s, Walk* w, i32 k, const double* weights, double way) {
  const i32 i = (k + 1) % 3, j = (k + 2) % 3;
  const u32 code = s->links[w->runner.at.triangle].across[i];
  if (code == kNoLink) return false;
  const i32 triangle = (i32)(code >> 3), edge = (i32)(code >> 1 & 3u);
  const bool is_turned = (code & 1u) != 0u;
  const bool is_front = w->runner.is_front != is_turned;
  const Vector normal = normal_toward(s, triangle, is_front);
  if (is_zero(normal)) return false;
  const bool falls = inner(normal, w->runner.ahead) >= 0.0;
  if (!falls && inner(normal, w->runner.normal) < kSteepest) return false;

  const double sum = weights[i] + weights[j];
  const double share = sum > 0.0 ? weights[j] / sum : 0.5;
  const Vector before = w->runner.normal;
  const Vector velocity = velocity_after(way, w->runner.ahead, w->runner.velocity, within(s->facts->gravity, before));
  const Vector ahead = within(turned(w->runner.ahead, before, normal), normal);
  const double length = size_of(ahead);
  if (!(length > 0.5)) return false;

  // The corner `edge` is this edge's end, or its beginning where the other triangle is turned.
  double there[3] = {0.0, 0.0, 0.0};
  there[edge] = is_turned ? 1.0 - share : share;
  there[(edge + 1) % 3] = is_turned ? share : 1.0 - share;
  const Vector was_ahead = w->runner.ahead;
  w->runner.at = place_of(triangle, there[1], there[2]);
  w->runner.is_front = is_front;
  w->runner.normal = normal;
  w->runner.ahead = over(ahead, length);
  w->runner.velocity = within(falls ? turned(velocity, before, normal) : velocity, normal);
  w->entered_over = (edge + 2) % 3;
  w->height -= w->slope * way;
  w->triangles[w->num_triangles++] = triangle;
  // A piece falls by its slope. What bends down by more than that would be cut.
  if (falls && inner(w->corners[w->num_corners - 1].runner.normal, normal) < w->least_cosine) {
    const Vector middle = plus(before, normal);
    const double middle_length = size_of(middle);
    add_corner(w, plus(point_of(s, w->runner.at),
                       times(w->height, middle_length > 0.1 ? over(middle, middle_length) : was_ahead)));
  }
  return true;
}

// Runs `length` mm (> 0) straight ahead, over any edge that falls off, and over edges that rise by at most 45 degrees:
// beyond that more of what runs into the slope is stopped by it than goes up. hover: height at the beginning, mm.
static inline void walk_over(const Surroundings* s, const Runner* from, double length, double hover, Walk* w) {
  w->runner = *from;
  w->end = kHasArrived;
  w->height = hover;
  w->slope = hover / length;
  w->least_cosine = 1.0 / PATINATE_SQRT(1.0 + w->slope * w->slope);
  w->num_corners = w->num_triangles = 0;
  w->entered_over = kNoEdge;
  add_corner(w, plus(point_of(s, from->at), times(hover, from->normal)));
  w->triangles[w->num_triangles++] = from->at.triangle;
  double left = length;
  for (;;) {
    const SurfacePlace at = w->runner.at;
    const double rate_1 = change_of_b1(s, at.triangle, w->runner.ahead),
                 rate_2 = change_of_b2(s, at.triangle, w->runner.ahead);
    const double rates[3] = {-rate_1 - rate_2, rate_1, rate_2};
    double weights[3] = {1.0 - at.b1 - at.b2, at.b1, at.b2};
    i32 exit = kNoEdge;
    double way = left;
    for (i32 k = 0; k < 3; ++k) {
      if (!(rates[k] < 0.0) || k == w->entered_over) continue;
      const double until = greater(0.0, weights[k] / -rates[k]);
      if (until < way) {
        way = until;
        exit = k;
      }
    }
    for (i32 k = 0; k < 3; ++k) weights[k] = greater(0.0, weights[k] + way * rates[k]);
    if (exit == kNoEdge) {
      w->runner.velocity =
          velocity_after(way, w->runner.ahead, w->runner.velocity, within(s->facts->gravity, w->runner.normal));
      w->runner.at = moved_inside(place_of(at.triangle, weights[1], weights[2]));
      w->height = 0.0;
      return;
    }
    if (w->num_triangles == kMostTriangles || w->num_corners == kMostCorners) {
      w->end = kIsTooFar;
      return;
    }
    if (!cross_edge(s, w, exit, weights, way)) {
      w->end = kIsStopped;
      return;
    }
    left -= way;
  }
}

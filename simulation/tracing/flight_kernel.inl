// Flight, and what flight and floating share, in the dialect of kernel_language.inl and behind ray_kernel.inl and
// vectors.inl: pieces.h says what it does.

// Where gammatons move: numbers, and arrays of the scene's triangles.
typedef struct Surroundings {
  const MotionFacts* facts;
  PATINATE_GLOBAL const BvhNode* nodes;
  PATINATE_GLOBAL const TriangleBlock* blocks;
  PATINATE_GLOBAL const TriangleFrame* frames;
  PATINATE_GLOBAL const CornerNormals* corner_normals;
  PATINATE_GLOBAL const TriangleLinks* links;
  PATINATE_GLOBAL const u8* empty_cells;
  // Whoever includes this has is_clear() and wet_amount(), which read these.
  Clear clear;
  Wet wet;
} Surroundings;

PATINATE_CONSTANT(double, kEdge,
                  1e-6);  // Of barycentric weights: rounding of gradients, and what moved_inside() takes back.
PATINATE_CONSTANT(double, kNever, -1.0);

static inline Vector wide(PATINATE_GLOBAL const float* v) {
  return vector_of((double)v[0], (double)v[1], (double)v[2]);
}
static inline Vector normal_of(const Surroundings* s, i32 triangle) { return wide(s->frames[triangle].normal); }
// On the side it is on.
static inline Vector normal_toward(const Surroundings* s, i32 triangle, bool is_front) {
  const Vector n = normal_of(s, triangle);
  return is_front ? n : opposite(n);
}
static inline Vector corner_of(const Surroundings* s, i32 triangle, i32 k) {
  return plus(wide(s->frames[triangle].corner[k]), s->facts->center);
}
static inline Vector point_of(const Surroundings* s, SurfacePlace at) {
  return plus(
      plus(times(1.0 - at.b1 - at.b2, corner_of(s, at.triangle, 0)), times(at.b1, corner_of(s, at.triangle, 1))),
      times(at.b2, corner_of(s, at.triangle, 2)));
}
// Change of b1 and b2 over a step along the triangle.
static inline double change_of_b1(const Surroundings* s, i32 triangle, Vector step) {
  return inner(step, wide(s->frames[triangle].gradient_1));
}
static inline double change_of_b2(const Surroundings* s, i32 triangle, Vector step) {
  return inner(step, wide(s->frames[triangle].gradient_2));
}

static inline TriangleHit first_hit_from(const Surroundings* s, Vector origin, Vector direction, double max_distance) {
  const double o[3] = {origin.x, origin.y, origin.z}, d[3] = {direction.x, direction.y, direction.z};
  if (s->facts->has_nodes == 0) {
    TriangleHit nothing;
    nothing.triangle = -1;
    nothing.b1 = nothing.b2 = nothing.distance = 0.0;
    nothing.is_front = true;
    return nothing;
  }
  return first_hit_along(&s->facts->rays, s->nodes, s->blocks, o, d, 0.0, max_distance);
}

// Smallest time > 0 at which v t + a t^2 / 2 = way > 0; kNever if there is none.
static inline double time_to(double way, double v, double a) {
  const double discriminant = v * v + 2.0 * a * way;
  if (discriminant < 0.0) return kNever;
  const double root = PATINATE_SQRT(discriminant);
  if (v > 0.0) return 2.0 * way / (v + root);
  return a > 0.0 ? (root - v) / a : kNever;
}

// Until a coordinate is at most `margin` outside; 0 where it is, or nearly.
static inline double time_to_side(double below, double above, double margin, double velocity, double gravity) {
  double wait = 0.0;
  if (below > 2.0 * margin) wait = time_to(below - margin, velocity, gravity);
  if (above > 2.0 * margin) wait = time_to(above - margin, -velocity, -gravity);
  return wait;
}

// Time until it can be in the grown box of all triangles: 0 inside, kNever when it will not be again.
static inline double time_to_box(const MotionFacts* f, const Drop* g) {
  const double margin = 1e-3 * f->box_diagonal + 1e-6;
  const Vector low = f->box_low, high = f->box_high, p = g->position, v = g->velocity, a = f->gravity;
  const double x = time_to_side(low.x - p.x, p.x - high.x, margin, v.x, a.x);
  const double y = time_to_side(low.y - p.y, p.y - high.y, margin, v.y, a.y);
  const double z = time_to_side(low.z - p.z, p.z - high.z, margin, v.z, a.z);
  if (x == kNever || y == kNever || z == kNever) return kNever;
  return greater(greater(greater(0.0, x), y), z);
}

static inline Vector way_after(Vector velocity, Vector acceleration, double time) {
  return plus(times(time, velocity), times(0.5 * time * time, acceleration));
}

static inline void advance(Drop* g, Vector gravity, double time) {
  g->position = plus(g->position, way_after(g->velocity, gravity, time));
  g->velocity = plus(g->velocity, times(time, gravity));
}

// Puts it onto the triangle that its chord has hit, at `time` or, on the parabola, at about that.
static inline void touch_in_flight(const Surroundings* s, Drop* g, const TriangleHit* hit, double time,
                                   double duration) {
  const Vector gravity = s->facts->gravity, n = normal_of(s, hit->triangle), first = corner_of(s, hit->triangle, 0);
  g->state = kIsInContact;
  g->is_front = hit->is_front;
  g->at = place_of(hit->triangle, hit->b1, hit->b2);
  const double c = inner(minus(g->position, first), n), b = inner(n, g->velocity), a = 0.5 * inner(n, gravity);
  double exact = time;
  for (i32 k = 0; k < 3; ++k) {
    const double slope = b + 2.0 * a * exact;
    if (slope != 0.0) exact -= (c + (b + a * exact) * exact) / slope;
  }
  if (exact >= 0.0 && exact <= duration) {
    const Vector p = plus(plus(g->position, times(exact, g->velocity)), times(0.5 * exact * exact, gravity));
    const Vector off = minus(p, first);
    const double b1 = change_of_b1(s, hit->triangle, off), b2 = change_of_b2(s, hit->triangle, off);
    if (b1 >= -kEdge && b2 >= -kEdge && b1 + b2 <= 1.0 + kEdge) {
      g->at.b1 = b1;
      g->at.b2 = b2;
      time = exact;
    }
  }
  g->velocity = plus(g->velocity, times(time, gravity));
  g->at = moved_inside(g->at);
  g->position = point_of(s, g->at);
}

static inline bool is_finite(Vector a) { return a.x - a.x == 0.0 && a.y - a.y == 0.0 && a.z - a.z == 0.0; }

// One piece of flight.
static inline u32 fly_on(const Surroundings* s, Drop* g) {
  const MotionFacts* f = s->facts;
  const double wait = time_to_box(f, g);
  if (wait == kNever || !is_finite(g->position) || !is_finite(g->velocity)) return kEndLeft;
  if (wait > 0.0) {
    advance(g, f->gravity, wait);
    return kEndFlying;
  }
  const double pull = size_of(f->gravity), speed = size_of(g->velocity);
  if (pull == 0.0 && speed == 0.0) return kEndRested;
  // No longer than to the other end of the scene.
  const double size = 2.0 * f->box_diagonal + 1e-6;
  double duration = pull > 0.0 ? PATINATE_SQRT(8.0 * f->epsilon / pull) : size / speed;
  if (speed * duration > size) duration = size / speed;
  const double way = free_distance(&f->space, s->empty_cells, g->position);
  if (way > 0.0) {
    const double v = largest_part(g->velocity), a = largest_part(f->gravity);
    const double time = 2.0 * way / (v + PATINATE_SQRT(v * v + 2.0 * a * way));
    if (time >= duration) {
      advance(g, f->gravity, time);
      return kEndFlying;
    }
  }
  const TriangleHit hit = first_hit_from(s, g->position, way_after(g->velocity, f->gravity, duration), 1.0);
  if (hit.triangle < 0) {
    advance(g, f->gravity, duration);
    return kEndFlying;
  }
  touch_in_flight(s, g, &hit, hit.distance * duration, duration);
  return kEndContact;
}

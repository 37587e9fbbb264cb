// A floating gammaton's way to its next contact, in the dialect of kernel_language.inl, behind walk_kernel.inl:
// pieces.h says what it does.

// How far one gets along the tangent plane, and which way.
typedef struct Step {
  Vector ahead;              // Unit; 0 when nothing moves it.
  Vector velocity, gravity;  // Tangential.
} Step;

static inline void touch_floating(const Surroundings* s, Drop* g, const TriangleHit* hit, Vector velocity) {
  g->state = kIsInContact;
  g->is_front = hit->is_front;
  g->at = moved_inside(place_of(hit->triangle, hit->b1, hit->b2));
  g->position = point_of(s, g->at);
  g->velocity = velocity;
}

// The direction in which it is after about `length`: as long as that takes, and no longer than gravity alone would
// need.
static inline Step step_of(const Surroundings* s, const Drop* g, Vector n, double length) {
  Step step;
  step.ahead = vector_of(0.0, 0.0, 0.0);
  step.velocity = within(g->velocity, n);
  step.gravity = within(s->facts->gravity, n);
  const double speed = size_of(step.velocity), pull = size_of(step.gravity);
  double duration = pull > 0.0 ? PATINATE_SQRT(2.0 * length / pull) : 0.0;
  if (speed > 0.0) {
    const double discriminant = speed * speed + 2.0 * length * inner(step.velocity, step.gravity) / speed;
    const double needed = discriminant >= 0.0 ? 2.0 * length / (speed + PATINATE_SQRT(discriminant)) : duration;
    if (pull == 0.0 || needed < duration) duration = needed;
  }
  const Vector way = way_after(step.velocity, step.gravity, duration);
  const double way_length = size_of(way);
  if (way_length > 1e-9 * length) step.ahead = over(way, way_length);
  return step;
}

// Lands on the triangle that it is on, if all of its way is above that one.
static inline bool stays_above(const Surroundings* s, Drop* g, const Step* step, double length) {
  const Vector way = times(length, step->ahead);
  const double b1 = g->at.b1 + change_of_b1(s, g->at.triangle, way);
  const double b2 = g->at.b2 + change_of_b2(s, g->at.triangle, way);
  if (!(b1 >= kMinWeight && b2 >= kMinWeight && b1 + b2 <= 1.0 - kMinWeight)) return false;
  g->at = place_of(g->at.triangle, b1, b2);
  return true;
}

// Where nothing can be walked on: ahead and down until something is hit, or back below the place it came from; flies
// when nothing is there either. p: point of the surface below it.
static inline u32 glide(const Surroundings* s, Drop* g, const Runner* runner, Vector p, double hover, double epsilon,
                        i64* num_pieces) {
  const MotionFacts* f = s->facts;
  const Vector n = runner->normal;
  const Vector from = plus(p, times(f->skin + hover, n)), way = minus(runner->ahead, times(f->pull, n));
  const TriangleHit hit = first_hit_from(s, from, way, f->reach);
  if (hit.triangle >= 0) {
    touch_floating(s, g, &hit, velocity_after(hit.distance, runner->ahead, runner->velocity, within(f->gravity, n)));
    return kEndContact;
  }
  const Vector end = plus(from, times(f->reach, way));
  if (f->pull * f->reach > hover) {
    ++*num_pieces;
    const Vector back = minus(minus(p, times(0.25 * epsilon, n)), end);
    const TriangleHit round = first_hit_from(s, end, back, 1.0);
    if (round.triangle >= 0) {
      touch_floating(s, g, &round, runner->velocity);
      const Vector normal = normal_toward(s, round.triangle, g->is_front);
      // What it falls by.
      const double square = inner(runner->velocity, runner->velocity) + 2.0 * inner(f->gravity, minus(g->position, p));
      const double speed = size_of(runner->velocity);
      g->velocity = times(PATINATE_SQRT(greater(0.0, square)),
                          turned(speed > 0.0 ? over(runner->velocity, speed) : runner->ahead, n, normal));
      return kEndContact;
    }
  }
  g->state = kIsFlying;
  g->position = from;
  g->velocity = runner->velocity;
  return kEndFlying;
}

// What is in the way of a piece that ends on the surface, or above it.
static inline bool is_stopped(const Surroundings* s, Drop* g, const Walk* walk, const WalkCorner* from, Vector to) {
  const Vector way = minus(to, from->position);
  const TriangleHit hit = first_hit_from(s, from->position, way, 1.0);
  if (hit.triangle < 0 || has_walked_on(walk, hit.triangle)) return false;
  const Runner* runner = &from->runner;
  const double length = greater(0.0, hit.distance * inner(way, runner->ahead));
  touch_floating(s, g, &hit,
                 velocity_after(length, runner->ahead, runner->velocity, within(s->facts->gravity, runner->normal)));
  return true;
}

// Along the surface, unless something else is in the way.
static inline u32 walk_on(const Surroundings* s, Drop* g, const Runner* from, double length, double hover,
                          double epsilon, i64* num_pieces) {
  Walk walk;
  walk_over(s, from, length, hover, &walk);
  if (walk.end == kIsTooFar) return glide(s, g, from, point_of(s, from->at), hover, epsilon, num_pieces);
  for (i32 i = 0; i + 1 < walk.num_corners; ++i) {
    if (is_stopped(s, g, &walk, &walk.corners[i], walk.corners[i + 1].position)) return kEndContact;
    ++*num_pieces;
  }
  const Runner* end = &walk.runner;
  const WalkCorner* last = &walk.corners[walk.num_corners - 1];
  const Vector p = point_of(s, end->at);
  if (walk.end == kIsStopped) {
    if (last->runner.at.triangle != end->at.triangle) {
      if (is_stopped(s, g, &walk, last, plus(p, times(s->facts->skin + walk.height, end->normal)))) return kEndContact;
      ++*num_pieces;
    }
    return glide(s, g, end, p, walk.height, epsilon, num_pieces);
  }
  if (is_stopped(s, g, &walk, last, p)) return kEndContact;
  g->state = kIsInContact;
  g->is_front = end->is_front;
  g->at = end->at;
  g->position = p;
  g->velocity = end->velocity;
  return kEndContact;
}

static inline u32 float_along(const Surroundings* s, Drop* g, u32 random, i64* num_pieces) {
  const MotionFacts* f = s->facts;
  const double epsilon = f->epsilon * (0.5 + (double)random * 0x1p-33);
  const Vector n = normal_toward(s, g->at.triangle, g->is_front);
  const bool comes_down = f->pull * f->reach >= epsilon;
  const double length = comes_down ? epsilon / f->pull : f->reach;
  ++*num_pieces;
  const Step step = step_of(s, g, n, length);
  if (is_zero(step.ahead)) return kEndRested;  // Nothing moves it.
  const bool clear = is_clear(s, g->at.triangle, g->is_front);
  if (comes_down && clear && stays_above(s, g, &step, length)) {
    g->state = kIsInContact;
    g->velocity = velocity_after(length, step.ahead, step.velocity, step.gravity);
    g->position = point_of(s, g->at);
    return kEndContact;
  }

  // Up from the surface, but through nothing.
  const Vector p = point_of(s, g->at);
  double hover = epsilon;
  if (!clear) {
    const TriangleHit above = first_hit_from(s, plus(p, times(f->skin, n)), n, epsilon);
    if (above.triangle >= 0) hover = 0.5 * above.distance;
  }
  Runner runner;
  runner.at = g->at;
  runner.is_front = g->is_front;
  runner.normal = n;
  runner.ahead = step.ahead;
  runner.velocity = step.velocity;
  if (!comes_down) return glide(s, g, &runner, p, hover, epsilon, num_pieces);
  return walk_on(s, g, &runner, length, hover, epsilon, num_pieces);
}

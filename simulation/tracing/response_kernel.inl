// What a gammaton does where it has hit: Russian roulette between bouncing, floating and being absorbed. In
// the dialect of kernel_language.inl, behind philox.inl, random_direction.inl and flight_kernel.inl: pieces.h says what
// it does.

enum { kMostTries = 8 };
PATINATE_CONSTANT(double, kDry, 0.05);  // Amounts well below that attract little: less than a film.
PATINATE_CONSTANT(u32, kResponsePurpose, 0x726f756cu);
PATINATE_CONSTANT(u32, kStridePurpose, 0x73747264u);

// Four random words of a gammaton in an iteration, other ones for each attempt and purpose.
static inline void words_of(const MotionCall* call, u32 gammaton, u32 purpose, u32 first, u32* words) {
  words[0] = first;
  words[1] = purpose;
  words[2] = gammaton;
  words[3] = (u32)call->iteration;
  philox4x32_10(words, (u32)call->seed, (u32)(call->seed >> 32));
}
static inline void response_words(const MotionCall* call, u32 gammaton, u32 attempt, u32* words) {
  words_of(call, gammaton, kResponsePurpose, attempt | (u32)(call->iteration >> 32) << 8, words);
}

// The mesh's normals interpolated; unit; the triangle's where these cancel.
static inline Vector shading_normal_of(const Surroundings* s, SurfacePlace at) {
  if (s->facts->has_normals == 0) return normal_of(s, at.triangle);
  PATINATE_GLOBAL const CornerNormals* n = s->corner_normals + at.triangle;
  const Vector sum = plus(plus(times(1.0 - at.b1 - at.b2, wide(n->corner[0])), times(at.b1, wide(n->corner[1]))),
                          times(at.b2, wide(n->corner[2])));
  const double length = size_of(sum);
  return length > 1e-3 ? over(sum, length) : normal_of(s, at.triangle);
}

// Tangent of the angle by which a floating drop turns toward `side` (unit, tangential, across its way): wet_paths.h.
static inline double turn_to_wet(const Surroundings* s, SurfacePlace at, Vector side) {
  const Vector quarter = times(0.25 * s->facts->rivulet, side);
  const double b1 = change_of_b1(s, at.triangle, quarter), b2 = change_of_b2(s, at.triangle, quarter);
  if (!(greater(PATINATE_MAGNITUDE(b1), PATINATE_MAGNITUDE(b2)) < 1e6)) return 0.0;  // A triangle without an area.
  double wet[4];
  for (i32 k = 0; k < 4; ++k) {
    const double steps = k < 2 ? 1.0 + k : 1.0 - k;  // 1, 2 and -1, -2.
    wet[k] = wet_amount(s, at.triangle, at.b1 + steps * b1, at.b2 + steps * b2);
  }
  const double there = wet[0] + wet[1], away = wet[2] + wet[3];
  return s->facts->wet_attraction * (there - away) / (there + away + kDry);
}

// Nearly level ground below it (1), or above it, on which it hangs (-1).
static inline i32 levelness(const MotionFacts* f, Vector normal) {
  const double gravity = size_of(f->gravity);
  if (gravity == 0.0) return 1;
  const double up = -inner(normal, f->gravity) / gravity;
  return up >= f->rest_cosine ? 1 : (up <= -f->rest_cosine ? -1 : 0);
}

// front_normal: for bounces to reflect about, unit, for the triangle's front.
static inline u32 respond_to(const Surroundings* s, const MotionCall* call, u32 gammaton, Drop* g,
                             Vector front_normal) {
  const MotionFacts* f = s->facts;
  const double side = g->is_front ? 1.0 : -1.0;
  const Vector ground = times(side, normal_of(s, g->at.triangle));
  u32 first[4];
  response_words(call, gammaton, 0u, first);
  const double roulette = (first[0] + 0.5) * 0x1.0p-32;
  if (roulette >= f->bounce + f->floating) return kIsAbsorbed;
  const bool is_bounce = roulette < f->bounce;

  const double speed = size_of(g->velocity);
  Vector heading = speed > 0.0 ? over(g->velocity, speed) : ground;
  Vector normal = is_bounce ? times(side, front_normal) : ground;
  if (inner(heading, normal) >= 0.0) normal = ground;  // Seen from behind the shading normal.
  const double into = inner(heading, normal);
  if (into < 0.0) heading = minus(heading, times(2.0 * into, normal));
  if (is_bounce) {
    Vector chosen = direction_in_lobe(heading, f->lobe_bounce, first[1], first[2]);
    for (u32 k = 1u; k < kMostTries && !(inner(chosen, ground) > 0.0); ++k) {
      u32 w[4];
      response_words(call, gammaton, k, w);
      chosen = direction_in_lobe(heading, f->lobe_bounce, w[1], w[2]);
    }
    const double up = inner(chosen, ground);
    if (!(up > 0.0)) chosen = minus(chosen, times(2.0 * up, ground));
    g->velocity = times(speed * (1.0 - f->deceleration_bounce), chosen);
    g->state = kIsFlying;
    g->position = plus(point_of(s, g->at), times(f->skin, ground));
  } else {
    const Vector chosen = speed > 0.0 ? direction_in_lobe(heading, f->lobe_float, first[1], first[2]) : ground;
    Vector along = within(chosen, ground);
    const double length = size_of(along);
    if (f->wet_attraction > 0.0 && length > 1e-9) {
      const Vector across = over(outer(ground, along), length);
      const double turn = turn_to_wet(s, g->at, across);
      along = over(plus(along, times(length * turn, across)), PATINATE_SQRT(1.0 + turn * turn));
    }
    if (f->is_slowed_tangentially == 0 && length > 1e-9) along = over(along, length);
    g->velocity = times(speed * (1.0 - f->deceleration_float), along);
    g->state = kIsFloating;
    g->position = plus(point_of(s, g->at), times(f->epsilon, ground));
  }
  const i32 level = levelness(f, ground);
  const double left = size_of(g->velocity);
  if (level > 0 && (left < f->rest_speed || left == 0.0)) return kHasRested;
  if (level < 0 && !is_bounce) {
    // Downhill by less than 1 degree is no longer downhill.
    const double downhill = inner(g->velocity, f->gravity) / size_of(f->gravity);
    if (downhill <= 0.02 * left) {
      g->state = kIsFlying;
      g->position = plus(point_of(s, g->at), times(f->skin, ground));
    }
  }
  return kStaysAlive;
}

// Of one gammaton: it is born where that is due, then flies or floats until it hits something or has left for good.
// emitter: its own. num_births: of this gammaton, counted here.
static inline Told trace_one(const Surroundings* s, const MotionCall* call, PATINATE_GLOBAL const EmitterFacts* emitter,
                             u32 gammaton, Drop* g, u32* num_births) {
  Told told;
  told.end = kEndWaiting;
  told.is_born = told.is_landing = told.num_pieces = 0u;
  if (g->state == kIsWaiting) {
    const bool is_due = ((i64)gammaton - call->begin) % call->num_shares == call->born_share;
    if (emitter->is_on == 0u || gammaton >= emitter->end_born || !is_due) return told;
    const EmitterFacts from = *emitter;
    give_birth(&from, call->seed, gammaton, (*num_births)++, g);
    told.is_born = 1u;
  }
  i64 num_pieces = 0;
  u32 end = kEndFlying;
  if (g->state == kIsFloating) {
    u32 words[4];
    words_of(call, gammaton, kStridePurpose, (u32)(call->iteration >> 32), words);
    end = float_along(s, g, words[0], &num_pieces);
  }
  told.is_landing = end == kEndFlying ? 1u : 0u;
  while (end == kEndFlying && num_pieces < s->facts->max_segments) {
    end = fly_on(s, g);
    ++num_pieces;
  }
  told.num_pieces = (u32)num_pieces;
  told.end = end;
  if (end == kEndLeft || end == kEndRested) g->state = kIsWaiting;
  return told;
}

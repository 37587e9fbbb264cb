// Births of gammatons, in the dialect of kernel_language.inl, behind philox.inl and random_direction.inl: emitter.h
// says what it gives.

PATINATE_CONSTANT(u32, kBirthPurpose, 0x62697274u);

static inline double random_uniform(RandomState* random) {
  const u64 high = random_next(random) >> 5;
  const u64 low = random_next(random) >> 6;
  return (double)(high << 26 | low) * 0x1.0p-53;
}

// The `number`-th birth of a gammaton.
static inline void give_birth(const EmitterFacts* e, u64 seed, u32 gammaton, u32 number, Drop* g) {
  RandomState random = random_state(seed, (u64)number << 32 | gammaton, kBirthPurpose);
  Vector position = e->center, axis = e->direction;
  if (e->shape == kBornOnDisk) {
    const double radius = PATINATE_SQRT(random_uniform(&random));
    const SineCosine turn = sine_cosine_of_turns(random_next(&random));
    position = plus(position, times(radius * e->half_u, plus(times(turn.cosine, e->u), times(turn.sine, e->v))));
  } else if (e->shape == kBornOnRectangle) {
    const double a = 2.0 * random_uniform(&random) - 1.0, b = 2.0 * random_uniform(&random) - 1.0;
    position = plus(position, plus(times(a * e->half_u, e->u), times(b * e->half_v, e->v)));
  } else if (e->shape == kBornOnSphere) {
    const u32 a = random_next(&random);
    axis = direction_in_cone(vector_of(0.0, 0.0, 1.0), -1.0, a, random_next(&random));
    position = plus(position, times(e->half_u, axis));
  }
  const u32 a = random_next(&random);
  g->state = kIsFlying;
  g->is_front = true;
  g->at = place_of(-1, 0.0, 0.0);
  g->position = position;
  g->velocity = times(e->speed, direction_in_cone(axis, e->spread_cosine, a, random_next(&random)));
}

// Philox 4x32-10 [Salmon, Moraes, Dror, Shaw 2011], and draws from a stream of it. In the dialect of
// kernel_language.inl.

// What one item has left of its stream.
typedef struct RandomState {
  u32 key[2];
  u32 counter[4];
  u32 block[4];
  i32 used;  // Of the block.
} RandomState;

PATINATE_INLINE void philox4x32_10(u32* counter, u32 key0, u32 key1) {
  for (int round = 0; round < 10; ++round) {
    const u64 p0 = (u64)0xD2511F53u * counter[0];
    const u64 p1 = (u64)0xCD9E8D57u * counter[2];
    const u32 c0 = (u32)(p1 >> 32) ^ counter[1] ^ key0, c2 = (u32)(p0 >> 32) ^ counter[3] ^ key1;
    counter[0] = c0;
    counter[1] = (u32)p1;
    counter[2] = c2;
    counter[3] = (u32)p0;
    key0 += 0x9E3779B9u;
    key1 += 0xBB67AE85u;
  }
}

PATINATE_INLINE RandomState random_state(u64 seed, u64 item, u32 purpose) {
  RandomState state;
  state.key[0] = (u32)seed;
  state.key[1] = (u32)(seed >> 32);
  state.counter[0] = 0u;
  state.counter[1] = purpose;
  state.counter[2] = (u32)item;
  state.counter[3] = (u32)(item >> 32);
  for (int i = 0; i < 4; ++i) state.block[i] = 0u;
  state.used = 4;
  return state;
}

PATINATE_INLINE u32 random_next(RandomState* state) {
  if (state->used == 4) {
    for (int i = 0; i < 4; ++i) state->block[i] = state->counter[i];
    philox4x32_10(state->block, state->key[0], state->key[1]);
    ++state->counter[0];
    state->used = 0;
  }
  return state->block[state->used++];
}

// As random_state() is after `num` words of it.
PATINATE_INLINE RandomState random_state_after(u64 seed, u64 item, u32 purpose, u32 num) {
  RandomState state = random_state(seed, item, purpose);
  state.counter[0] = num / 4u;
  for (u32 i = 0u; i < num % 4u; ++i) (void)random_next(&state);
  return state;
}

// How many words it has given, as long as they are fewer than 2^32.
PATINATE_INLINE u32 random_words_used(const RandomState* state) {
  return 4u * state->counter[0] - 4u + (u32)state->used;
}

// What a word says of [0, n), n > 0; -1: to be drawn again. Without bias: the first 2^32 mod n products are rejected
// [Lemire 2019].
PATINATE_INLINE i64 word_below(u32 word, u32 n) {
  const u64 product = (u64)word * n;
  return (u32)product < (0u - n) % n ? -1 : (i64)(product >> 32);
}

// Uniform in [0, n), n > 0.
PATINATE_INLINE u32 random_below(RandomState* state, u32 n) {
  for (;;) {
    const i64 value = word_below(random_next(state), n);
    if (value >= 0) return (u32)value;
  }
}

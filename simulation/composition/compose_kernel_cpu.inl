// What is the CPU's own around compose_kernel.inl: whole tiles, and the kernels of one instruction set. Included behind
// it.

namespace {

void compose_tile(const ComposeTask& task, u32* rgba, i32* height) { compose_lanes(&task, rgba, height); }

void fill_slopes(const NormalTask& task, SlopeTile& out) {
  alignas(64) i32 across[kTile];
  alignas(64) i32 down[kTile];
  // Rows are 8 long: the first and last of each are put right after.
  const i32* here = task.here;
  across[0] = across[kTile - 1] = 0;
  for (int l = 1; l < kTile - 1; ++l) across[l] = within(here[l + 1] - here[l - 1], -kMaxStep, kMaxStep);
  for (int l = 0; l < kTile; l += 8) {
    across[l] = within(here[l + 1] - task.left[l + 7], -kMaxStep, kMaxStep);
    across[l + 7] = within(task.right[l] - here[l + 6], -kMaxStep, kMaxStep);
  }
  for (int l = 0; l < 8; ++l) down[l] = within(here[l + 8] - task.above[l + 56], -kMaxStep, kMaxStep);
  for (int l = 8; l < 56; ++l) down[l] = within(here[l + 8] - here[l - 8], -kMaxStep, kMaxStep);
  for (int l = 56; l < kTile; ++l) down[l] = within(task.below[l - 56] - here[l - 8], -kMaxStep, kMaxStep);
  // Frames by pairs of 32 bits, each two of 16: t, bt; b, shift.
  alignas(64) i32 frame[2 * kTile];
  for (int l = 0; l < kTile; ++l) __builtin_memcpy(frame + 2 * l, task.frame + task.triangle[l] + 1, sizeof(Frame));
  for (int l = 0; l < kTile; ++l) {
    const Frame own{static_cast<i16>(frame[2 * l]), static_cast<i16>(frame[2 * l] >> 16),
                    static_cast<i16>(frame[2 * l + 1]), static_cast<i16>(frame[2 * l + 1] >> 16)};
    slopes_of_steps(own, across[l], down[l], out.along_t + l, out.along_b + l);
  }
}

void encode_normals(const SlopeTile& slopes, u8* normal) { encode_lanes(slopes.along_t, slopes.along_b, normal); }

bool replace_words(u32* __restrict to, const u32* __restrict from, int num_words) {
  u32 difference = 0;
  for (int l = 0; l < (num_words & ~15); ++l) {
    difference |= to[l] ^ from[l];
    to[l] = from[l];
  }
  return difference != 0;
}

}  // namespace

extern const Kernels kKernels;
const Kernels kKernels{compose_tile, fill_slopes, encode_normals, slope_at_border, replace_words};

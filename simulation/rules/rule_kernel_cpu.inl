// What is the CPU's own around rule_kernel.inl: whole tiles, and the kernels of one instruction set. Included behind
// it.

namespace {

void load(const u16* __restrict stored, i32* __restrict quanta, float* __restrict amounts) {
  for (int i = 0; i < PATINATE_LANES; ++i) {
    quanta[i] = stored[i];
    amounts[i] = amount_of(quanta[i]);
  }
}

void store(const i32* __restrict quanta, u16* __restrict stored) {
  for (int i = 0; i < PATINATE_LANES; ++i) stored[i] = static_cast<u16>(quanta[i]);
}

int apply(const KernelRule& rule, const float* driver, const float* covered, u32 first_texel, i32* quanta,
          float* amounts, i32* changes) {
  return apply_rule(&rule, driver, covered, first_texel, quanta, amounts, changes);
}

i64 weigh(const i32* changes, const u32* weights) {
  u64 sum = 0;
  for (int i = 0; i < PATINATE_LANES; ++i) sum += static_cast<u64>(static_cast<u32>(changes[i])) * weights[i];
  return static_cast<i64>(sum);
}

}  // namespace

extern const RuleKernel kKernel;
const RuleKernel kKernel = {load, store, apply, weigh};

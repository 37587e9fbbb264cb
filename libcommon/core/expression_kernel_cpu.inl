// What is the CPU's own around expression_kernel.inl: blocks of 64 values. Included behind it, for one instruction set.

namespace {

constexpr int kBlock = 64;

void add(const float* a, const float* b, const float*, float* out) {
  for (int i = 0; i < kBlock; ++i) out[i] = step_add(a[i], b[i]);
}
void subtract(const float* a, const float* b, const float*, float* out) {
  for (int i = 0; i < kBlock; ++i) out[i] = step_subtract(a[i], b[i]);
}
void multiply(const float* a, const float* b, const float*, float* out) {
  for (int i = 0; i < kBlock; ++i) out[i] = step_multiply(a[i], b[i]);
}
void divide(const float* a, const float* b, const float*, float* out) {
  for (int i = 0; i < kBlock; ++i) out[i] = step_divide(a[i], b[i]);
}
void negate(const float* a, const float*, const float*, float* out) {
  for (int i = 0; i < kBlock; ++i) out[i] = step_negate(a[i]);
}
void invert(const float* a, const float*, const float*, float* out) {
  for (int i = 0; i < kBlock; ++i) out[i] = step_invert(a[i]);
}
void least(const float* a, const float* b, const float*, float* out) {
  for (int i = 0; i < kBlock; ++i) out[i] = step_min(a[i], b[i]);
}
void greatest(const float* a, const float* b, const float*, float* out) {
  for (int i = 0; i < kBlock; ++i) out[i] = step_max(a[i], b[i]);
}
void absolute(const float* a, const float*, const float*, float* out) {
  for (int i = 0; i < kBlock; ++i) out[i] = step_abs(a[i]);
}
void clamp(const float* x, const float* low, const float* high, float* out) {
  for (int i = 0; i < kBlock; ++i) out[i] = step_clamp(x[i], low[i], high[i]);
}
void smoothstep(const float* from, const float* to, const float* x, float* out) {
  for (int i = 0; i < kBlock; ++i) out[i] = step_smoothstep(from[i], to[i], x[i]);
}

}  // namespace

extern const ExpressionKernel kKernel;
const ExpressionKernel kKernel = {{nullptr, nullptr, add, subtract, multiply, divide, negate, invert, least, greatest,
                                   absolute, nullptr, clamp, smoothstep}};

// The steps of expressions, in the dialect of kernel_language.inl. Values stay within +-1e30 (kExpressionHuge).

// By ExpressionNode::Kind, those that have a step; kStepPow stands apart (expression_power.inl).
enum {
  kStepAdd = 2,
  kStepSubtract,
  kStepMultiply,
  kStepDivide,
  kStepNegate,
  kStepInvert,
  kStepMin,
  kStepMax,
  kStepAbs,
  kStepPow,
  kStepClamp,
  kStepSmoothstep
};

static inline float bounded(float x) {
  const float low = x < -1e30f ? -1e30f : x;
  return low > 1e30f ? 1e30f : low;
}

static inline float step_add(float a, float b) { return bounded(a + b); }
static inline float step_subtract(float a, float b) { return bounded(a - b); }
static inline float step_multiply(float a, float b) { return bounded(a * b); }
static inline float step_divide(float a, float b) {
  const float quotient = bounded(a / (b == 0.0f ? 1.0f : b));
  return b == 0.0f ? 0.0f : quotient;
}
static inline float step_negate(float a) { return -a; }
static inline float step_invert(float a) { return bounded(1.0f - a); }
static inline float step_min(float a, float b) { return b < a ? b : a; }
static inline float step_max(float a, float b) { return a < b ? b : a; }
static inline float step_abs(float a) { return a < 0.0f ? -a : a; }
static inline float step_clamp(float x, float low, float high) {
  const float below = high < x ? high : x;
  return below < low ? low : below;
}
static inline float step_smoothstep(float from, float to, float x) {
  const float width = to - from;
  const bool is_step = width == 0.0f;
  const float raw = (x - from) / (is_step ? 1.0f : width);
  const float low = raw < 0.0f ? 0.0f : raw;
  const float t = low > 1.0f ? 1.0f : low;
  const float smooth = t * t * (3.0f - 2.0f * t);
  return is_step ? (x < from ? 0.0f : 1.0f) : smooth;
}

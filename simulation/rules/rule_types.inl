// What rules work with, as C++ and devices have it (kernel_language.inl).

// A material that a rule makes or uses.
typedef struct RuleTerm {
  i32 material;  // Slot of its amounts, and of its quanta.
  float share;   // > 0; amount by extent.
} RuleTerm;

// A rule. Its extent at a texel is scale * driver, less where there is not enough of what it uses.
typedef struct KernelRule {
  float scale;  // rate * time.
  i32 num_makes;
  i32 num_terms;       // Uses follow the makes.
  RuleTerm terms[16];  // kMaxRuleTerms
  u32 keys[2];         // Of random numbers: of (seed, rule, time).
} KernelRule;

// Codes of a surface's parameter in tile order, in bytes of all parameters: low + code * step. In `bytes_each` of 4
// they are floats, as they are.
typedef struct ParameterCodes {
  u64 first;  // Byte.
  i32 bytes_each;
  float low;
  float step;
} ParameterCodes;

// A step of a driver's expression, of values. Those from kFirstShared on are the same at all texels.
typedef struct DriverStep {
  u32 kind;  // ExpressionNode::Kind
  u32 out;
  u32 a;
  u32 b;
  u32 c;
} DriverStep;

// A rule with its driver.
typedef struct PackedRule {
  KernelRule form;
  i32 first_step;
  i32 end_step;
  u32 result;   // Value that its driver has.
  u32 changes;  // A bit for each slot of its terms.
} PackedRule;

PATINATE_CONSTANT(u32, kFirstShared, 64u);  // A texel has at most so many values of its own.

PATINATE_INLINE float decoded(i32 code, float low, float step) { return low + (float)code * step; }

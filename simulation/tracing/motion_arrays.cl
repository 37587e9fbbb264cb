// What the kernels of gammatons' ways leave to whoever includes them: on a device all is in arrays.

typedef global const uchar* Clear;  // By triangle, its front first: whether nothing is above it.
typedef struct Wet {
  Places places;
  global const ushort* amounts;  // By texel.
} Wet;

struct Surroundings;
static bool is_clear(const struct Surroundings* s, i32 triangle, bool is_front);
static double wet_amount(const struct Surroundings* s, i32 triangle, double b1, double b2);

// What gammatons move through and how they are, as C++ and devices have it (kernel_language.inl, ray_types.inl).

typedef struct Vector {
  PATINATE_MEMBER(double, x, 0.0);
  PATINATE_MEMBER(double, y, 0.0);
  PATINATE_MEMBER(double, z, 0.0);
} Vector;

// A place on a triangle.
typedef struct SurfacePlace {
  PATINATE_MEMBER(i32, triangle, -1);
  PATINATE_MEMBER(double, b1, 0.0);  // Barycentric weights of corners 1 and 2.
  PATINATE_MEMBER(double, b2, 0.0);
} SurfacePlace;

// A triangle's plane, and how barycentric weights change along it. 72 bytes.
typedef struct TriangleFrame {
  float corner[3][3];   // Relative to MotionFacts::center.
  float normal[3];      // Unit; 0 without an area.
  float gradient_1[3];  // Of b1, per mm.
  float gradient_2[3];
} TriangleFrame;
typedef struct CornerNormals {
  float corner[3][3];
} CornerNormals;

// Across the edges of a triangle, from corner k to the next: triangle << 3 | edge << 1 | is_turned.
PATINATE_CONSTANT(u32, kNoLink, 0xFFFFFFFFu);
typedef struct TriangleLinks {
  u32 across[3];
} TriangleLinks;

// Of GammatonState.
enum { kIsWaiting = 0, kIsFlying = 1, kIsFloating = 2, kIsInContact = 3 };
// How a piece of a way ends.
enum { kEndFlying = 0, kEndContact = 1, kEndLeft = 2, kEndRested = 3, kEndWaiting = 4 };
// What becomes of what has hit.
enum { kStaysAlive = 0, kIsAbsorbed = 1, kHasRested = 2 };

// A gammaton taken out of its arrays.
typedef struct Drop {
  PATINATE_MEMBER(u32, state, 1u);
  PATINATE_MEMBER(bool, is_front, true);
  PATINATE_MEMBER(SurfacePlace, at, {});
  PATINATE_MEMBER(Vector, position, {});
  PATINATE_MEMBER(Vector, velocity, {});
} Drop;

// Of a grid over a scene's box (FreeSpace).
typedef struct SpaceFacts {
  PATINATE_MEMBER(Vector, low, {});
  PATINATE_MEMBER(double, cell, 1.0);
  PATINATE_MEMBER(double, inverse_cell, 1.0);
  PATINATE_ARRAY(i32, size, 4);  // Of x, y, z.
} SpaceFacts;

// Of PlacedEmitter; Point, Surface and what has become of Sky are born at a place, on a disk, or on a rectangle.
enum { kBornAtPoint = 0, kBornOnDisk = 1, kBornOnRectangle = 2, kBornOnSphere = 3 };
typedef struct EmitterFacts {
  Vector center, u, v, direction;
  double half_u, half_v, spread_cosine, speed;
  u32 shape;
  u32 is_on;
  u32 end_born;  // Behind the last gammaton that may be born.
  u32 padding;
} EmitterFacts;

// Of one iteration.
typedef struct MotionCall {
  u64 iteration;
  u64 seed;
  i64 begin;  // GammatonRange.
  i64 num_shares, born_share;
} MotionCall;

// What is told of one gammaton.
typedef struct Told {
  u32 end;  // kEndFlying and so on.
  u32 is_born;
  u32 is_landing;
  u32 num_pieces;
} Told;

// Numbers that all gammatons of a call share.
typedef struct MotionFacts {
  RayFrame rays;
  Vector box_low, box_high;  // Of all triangles, mm, world.
  double box_diagonal;
  Vector center;   // That of TriangleFrame.
  Vector gravity;  // mm/s^2.
  double skin;     // mm: what starts on a surface starts this far from it.
  double rest_cosine;
  double epsilon, pull, reach;  // TracingOptions.
  double lobe_bounce, lobe_float, rest_speed;
  double bounce, floating, deceleration_bounce, deceleration_float;  // Behavior.
  double wet_attraction, rivulet;                                    // 0: none.
  SpaceFacts space;
  i32 max_segments;
  i32 is_slowed_tangentially;
  i32 has_nodes, has_normals;
} MotionFacts;

// A gammaton on a device. 88 bytes.
typedef struct DropRecord {
  double b1, b2;
  Vector position, velocity;
  i32 triangle;
  u32 state;
  u32 is_front;
  u32 emitter;
  u32 num_births;
  u32 padding;
} DropRecord;

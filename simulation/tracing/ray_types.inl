// What rays are traced through, as C++ and devices have it (kernel_language.inl).

// Four boxes, by lane, relative to RayFrame::center. 128 bytes.
typedef struct PATINATE_ALIGNED_TO(64) BvhNode {
  float bounds[2][3][4];  // [low, high][axis][lane]; low > high in a lane without child.
  i32 child[4];           // >= 0: a node. < 0: block -1 - child. Unused lanes: 0.
  i32 padding[4];
} BvhNode;

// Up to four triangles, by lane, relative to RayFrame::center. 160 bytes.
typedef struct PATINATE_ALIGNED_TO(32) TriangleBlock {
  float corner[3][3][4];  // [corner][axis][lane]; unused lanes repeat the first triangle.
  i32 triangle[4];        // Index in the mesh; unused lanes -1.
} TriangleBlock;

// Where a hierarchy stands.
typedef struct RayFrame {
  double center[3];
  double low[3], high[3];  // The box of all triangles, a little larger, relative to center.
  float slack;             // What rounding to float may move a coordinate by.
} RayFrame;

typedef struct TriangleHit {
  PATINATE_MEMBER(i32, triangle, -1);  // -1: nothing was hit.
  PATINATE_MEMBER(double, b1, 0.0);    // Barycentric weights of corners 1 and 2; with that of corner 0 all in [0, 1].
  PATINATE_MEMBER(double, b2, 0.0);
  PATINATE_MEMBER(double, distance, 0.0);  // In lengths of the direction.
  PATINATE_MEMBER(bool, is_front, true);   // The triangle's normal faces the ray.
} TriangleHit;

// What a device is asked for, and its answer.
typedef struct RayQuery {
  double origin[3], direction[3];
  PATINATE_MEMBER(double, min_distance, 0.0);
  PATINATE_MEMBER(double, max_distance, 0.0);
} RayQuery;
typedef struct RayAnswer {
  PATINATE_MEMBER(double, b1, 0.0);
  PATINATE_MEMBER(double, b2, 0.0);
  PATINATE_MEMBER(double, distance, 0.0);
  PATINATE_MEMBER(i32, triangle, -1);
  PATINATE_MEMBER(i32, is_front, 1);
} RayAnswer;

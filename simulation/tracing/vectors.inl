// Vectors of three doubles, and places on triangles, in the dialect of kernel_language.inl. Sums of products go from
// left to right.

PATINATE_INLINE Vector vector_of(double x, double y, double z) {
  Vector v;
  v.x = x;
  v.y = y;
  v.z = z;
  return v;
}
PATINATE_INLINE Vector plus(Vector a, Vector b) { return vector_of(a.x + b.x, a.y + b.y, a.z + b.z); }
PATINATE_INLINE Vector minus(Vector a, Vector b) { return vector_of(a.x - b.x, a.y - b.y, a.z - b.z); }
PATINATE_INLINE Vector times(double s, Vector a) { return vector_of(s * a.x, s * a.y, s * a.z); }
PATINATE_INLINE Vector over(Vector a, double s) { return vector_of(a.x / s, a.y / s, a.z / s); }
PATINATE_INLINE Vector opposite(Vector a) { return vector_of(-a.x, -a.y, -a.z); }
PATINATE_INLINE double inner(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
PATINATE_INLINE Vector outer(Vector a, Vector b) {
  return vector_of(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
PATINATE_INLINE double size_of(Vector a) { return PATINATE_SQRT(inner(a, a)); }
PATINATE_INLINE bool is_zero(Vector a) { return a.x == 0.0 && a.y == 0.0 && a.z == 0.0; }
// What is left of it in the plane across a unit normal.
PATINATE_INLINE Vector within(Vector a, Vector normal) { return minus(a, times(inner(a, normal), normal)); }
PATINATE_INLINE double largest_part(Vector a) {
  const double x = PATINATE_MAGNITUDE(a.x), y = PATINATE_MAGNITUDE(a.y), z = PATINATE_MAGNITUDE(a.z);
  const double xy = x < y ? y : x;
  return xy < z ? z : xy;
}

PATINATE_INLINE SurfacePlace place_of(i32 triangle, double b1, double b2) {
  SurfacePlace at;
  at.triangle = triangle;
  at.b1 = b1;
  at.b2 = b2;
  return at;
}

// Contacts keep this far, in barycentric weights, from the edges of their triangles: what starts there is on the right
// side of all triangles around.
PATINATE_CONSTANT(double, kMinWeight, 1e-6);

PATINATE_INLINE SurfacePlace moved_inside(SurfacePlace at) {
  at.b1 = at.b1 > kMinWeight ? at.b1 : kMinWeight;
  at.b2 = at.b2 > kMinWeight ? at.b2 : kMinWeight;
  const double sum = at.b1 + at.b2;
  if (sum > 1.0 - kMinWeight) {
    at.b1 *= (1.0 - kMinWeight) / sum;
    at.b2 *= (1.0 - kMinWeight) / sum;
  }
  return at;
}

// Nothing lies nearer to p than this along any axis, mm; 0 where something may, and outside of the grid (FreeSpace).
// empty: cells that are empty on all sides of each.
PATINATE_INLINE double free_distance(const SpaceFacts* f, PATINATE_GLOBAL const u8* empty, Vector p) {
  const double x = (p.x - f->low.x) * f->inverse_cell, y = (p.y - f->low.y) * f->inverse_cell,
               z = (p.z - f->low.z) * f->inverse_cell;
  if (!(x >= 0.0 && y >= 0.0 && z >= 0.0 && x < f->size[0] && y < f->size[1] && z < f->size[2])) return 0.0;
  return empty[((i32)z * f->size[1] + (i32)y) * f->size[0] + (i32)x] * f->cell;
}

// Out of a device's record of a gammaton, and back.
PATINATE_INLINE Drop drop_of(PATINATE_GLOBAL const DropRecord* record) {
  Drop drop;
  drop.state = record->state;
  drop.is_front = record->is_front != 0u;
  drop.at = place_of(record->triangle, record->b1, record->b2);
  drop.position = record->position;
  drop.velocity = record->velocity;
  return drop;
}
PATINATE_INLINE void put_drop(const Drop* drop, PATINATE_GLOBAL DropRecord* record) {
  record->state = drop->state;
  record->is_front = drop->is_front ? 1u : 0u;
  record->triangle = drop->at.triangle;
  record->b1 = drop->at.b1;
  record->b2 = drop->at.b2;
  record->position = drop->position;
  record->velocity = drop->velocity;
}

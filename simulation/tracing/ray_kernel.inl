// The first triangle that a ray hits, in the dialect of kernel_language.inl and behind ray_types.inl and
// four_lanes.inl: boxes and triangles four at once in float, on the safe side, what may be hit in double.

enum { kRayStack = 224 };  // 3 a level; the builder keeps trees below 40 + 31 levels.

static inline double lesser(double a, double b) { return b < a ? b : a; }
static inline double greater(double a, double b) { return a < b ? b : a; }

// A ray as blocks need it: permuted so that its direction's largest part comes third, sheared onto that axis.
typedef struct Shear {
  u32 axis[3];  // kx, ky, kz.
  double x, y, z;
} Shear;

static inline Shear shear_of(const double* d) {
  u32 z = 0u;
  if (PATINATE_MAGNITUDE(d[1]) > PATINATE_MAGNITUDE(d[0])) z = 1u;
  if (PATINATE_MAGNITUDE(d[2]) > PATINATE_MAGNITUDE(d[z])) z = 2u;
  const double inverse = 1.0 / d[z];
  // Exchanged where it looks down: keeps the winding.
  const u32 next = z == 2u ? 0u : z + 1u, last = z == 0u ? 2u : z - 1u;
  const u32 x = inverse < 0.0 ? last : next, y = inverse < 0.0 ? next : last;
  Shear shear;
  shear.axis[0] = x;
  shear.axis[1] = y;
  shear.axis[2] = z;
  shear.x = d[x] * inverse;
  shear.y = d[y] * inverse;
  shear.z = inverse;
  return shear;
}

typedef struct RayLanes {
  Lanes origin[3], inverse[3];
  Lanes shear_x, shear_y, shear_z, slack, z_slack, from, to;
  u32 near_side[3];
  u32 axis[3];
} RayLanes;

static inline float safe_inverse(double d) {
  const double least = PATINATE_DOUBLE_BITS(d) >> 63 != 0u ? -1e-30 : 1e-30;
  return (float)(1.0 / (PATINATE_MAGNITUDE(d) < 1e-30 ? least : d));
}

static inline float rounded_up(double x) {
  const double wide = x * (1.0 + 1e-6);
  return wide > 3e38 ? 3e38f : (float)wide;
}

static inline void make_lanes(const Shear* shear, const double* origin, const double* direction, float slack,
                              RayLanes* ray) {
  const float z = (float)shear->z;
  ray->shear_x = lanes_of((float)shear->x);
  ray->shear_y = lanes_of((float)shear->y);
  ray->shear_z = lanes_of(z);
  ray->slack = lanes_of(4.0f * slack);
  ray->z_slack = lanes_of(4.0f * slack * (z < 0.0f ? -z : z));
  for (i32 a = 0; a < 3; ++a) {
    const float inverse = safe_inverse(direction[a]);
    ray->axis[a] = shear->axis[a];
    ray->origin[a] = lanes_of((float)origin[a]);
    ray->inverse[a] = lanes_of(inverse);
    ray->near_side[a] = inverse < 0.0f ? 1u : 0u;
  }
}

// A bit for each box that the ray may enter, and where. 3 roundings each: [Ize 2013].
static inline u32 boxes_hit(const RayLanes* ray, PATINATE_GLOBAL const BvhNode* n, float* distance) {
  Lanes near = ray->from, far = ray->to;
  for (i32 a = 0; a < 3; ++a) {
    const u32 side = ray->near_side[a];
    near = lanes_most(near, lanes_mul(lanes_sub(load_lanes(n->bounds[side][a]), ray->origin[a]), ray->inverse[a]));
    far = lanes_least(far, lanes_mul(lanes_sub(load_lanes(n->bounds[1u - side][a]), ray->origin[a]), ray->inverse[a]));
  }
  store_lanes(near, distance);
  return which_not_above(near, lanes_mul(far, lanes_of(1.0f + 8.0f * 0x1.0p-23f)));
}

// A bit for each triangle that the ray may hit within the interval.
static inline u32 triangles_maybe_hit(const RayLanes* ray, PATINATE_GLOBAL const TriangleBlock* block) {
  const u32 kx = ray->axis[0], ky = ray->axis[1], kz = ray->axis[2];
  Lanes x[3], y[3], z[3];
  for (i32 c = 0; c < 3; ++c) {
    z[c] = lanes_sub(load_lanes(block->corner[c][kz]), ray->origin[kz]);
    x[c] = lanes_sub(lanes_sub(load_lanes(block->corner[c][kx]), ray->origin[kx]), lanes_mul(ray->shear_x, z[c]));
    y[c] = lanes_sub(lanes_sub(load_lanes(block->corner[c][ky]), ray->origin[ky]), lanes_mul(ray->shear_y, z[c]));
    z[c] = lanes_mul(ray->shear_z, z[c]);
  }
  const Lanes size = lanes_add(lanes_add(lanes_add(lanes_magnitude(x[0]), lanes_magnitude(y[0])),
                                         lanes_add(lanes_magnitude(x[1]), lanes_magnitude(y[1]))),
                               lanes_add(lanes_magnitude(x[2]), lanes_magnitude(y[2])));
  const Lanes most_off = lanes_mul(ray->slack, lanes_add(size, ray->slack));
  const Lanes u = lanes_sub(lanes_mul(x[2], y[1]), lanes_mul(y[2], x[1]));
  const Lanes v = lanes_sub(lanes_mul(x[0], y[2]), lanes_mul(y[0], x[2]));
  const Lanes w = lanes_sub(lanes_mul(x[1], y[0]), lanes_mul(y[1], x[0]));
  const Lanes lowest = lanes_least(lanes_least(u, v), w), highest = lanes_most(lanes_most(u, v), w);
  const u32 is_inside =
      which_not_above(lanes_sub(lanes_of(0.0f), most_off), lowest) | which_not_above(highest, most_off);
  const Lanes first = lanes_least(lanes_least(z[0], z[1]), z[2]), last = lanes_most(lanes_most(z[0], z[1]), z[2]);
  const u32 is_in_reach = which_not_above(lanes_sub(first, ray->z_slack), ray->to) &
                          which_not_above(ray->from, lanes_add(last, ray->z_slack));
  return is_inside & is_in_reach;
}

// One triangle, in double. Signs of u, v, w are right or zero, since rounding keeps the order of the two products.
static inline bool hits(PATINATE_GLOBAL const TriangleBlock* block, u32 lane, const double* origin, const Shear* s,
                        double min_distance, TriangleHit* best) {
  const u32 kx = s->axis[0], ky = s->axis[1], kz = s->axis[2];
  double x[3], y[3], z[3];
  for (i32 c = 0; c < 3; ++c) {
    z[c] = (double)block->corner[c][kz][lane] - origin[kz];
    x[c] = (double)block->corner[c][kx][lane] - origin[kx] - s->x * z[c];
    y[c] = (double)block->corner[c][ky][lane] - origin[ky] - s->y * z[c];
  }
  const double u = x[2] * y[1] - y[2] * x[1];
  const double v = x[0] * y[2] - y[0] * x[2];
  const double w = x[1] * y[0] - y[1] * x[0];
  if ((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0)) return false;
  const double det = u + v + w;
  if (det == 0.0) return false;
  const double distance = s->z * (u * z[0] + v * z[1] + w * z[2]) / det;
  const i32 triangle = block->triangle[lane];
  if (!(distance > min_distance) || distance > best->distance ||
      (distance == best->distance && best->triangle >= 0 && triangle >= best->triangle))
    return false;
  best->triangle = triangle;
  best->b1 = v / det;
  best->b2 = w / det;
  best->distance = distance;
  best->is_front = det > 0.0;
  return true;
}

static inline bool is_usable(const double* origin, const double* d) {
  const double sum = origin[0] + origin[1] + origin[2] + d[0] + d[1] + d[2];
  const double square = d[0] * d[0] + (d[1] * d[1] + d[2] * d[2]);
  return sum - sum == 0.0 && square > 1e-200 && square < 1e200;
}

// The part of the ray inside the box, so that float numbers do not grow with the distance of the origin (relative to
// the center). Returns whether there is one.
static inline bool cut_to_box(const RayFrame* frame, const double* o, const double* direction, double* begin,
                              double* end) {
  if (o[0] >= frame->low[0] && o[1] >= frame->low[1] && o[2] >= frame->low[2] && o[0] <= frame->high[0] &&
      o[1] <= frame->high[1] && o[2] <= frame->high[2])
    return true;
  for (i32 a = 0; a < 3; ++a) {
    const double low = frame->low[a] - o[a], high = frame->high[a] - o[a];
    if (direction[a] == 0.0) {
      if (low > 0.0 || high < 0.0) return false;
      continue;
    }
    const double t0 = low / direction[a], t1 = high / direction[a];
    *begin = greater(*begin, lesser(t0, t1));
    *end = lesser(*end, greater(t0, t1));
  }
  return *begin <= *end;
}

typedef struct RayEntry {
  i32 node;
  float distance;
} RayEntry;

// Children that are hit onto the stack, from far to near: at most four, sorted as they come. Returns its new end.
static inline RayEntry* push_children(const RayLanes* ray, PATINATE_GLOBAL const BvhNode* nodes,
                                      PATINATE_GLOBAL const TriangleBlock* blocks, i32 node, RayEntry* end) {
  PATINATE_GLOBAL const BvhNode* n = nodes + node;
  PATINATE_ALIGNED_TO(16) float distance[4];
  RayEntry* const first = end;
  for (u32 hit = boxes_hit(ray, n, distance); hit != 0u; hit &= hit - 1u) {
    const u32 lane = PATINATE_LOWEST_BIT(hit);
    RayEntry* at = end++;
    for (; at > first && at[-1].distance < distance[lane]; --at) *at = at[-1];
    const i32 child = n->child[lane];
    at->node = child;
    at->distance = distance[lane];
    if (child >= 0) {
      PATINATE_PREFETCH(nodes + child);
      PATINATE_PREFETCH(nodes[child].bounds[1][1]);
    } else {
      PATINATE_PREFETCH(blocks + (-1 - child));
      PATINATE_PREFETCH(blocks[-1 - child].corner[1][1]);
    }
  }
  return end;
}

// Of origin and direction of three coordinates each; see RayTracer. There are nodes.
static inline TriangleHit first_hit_along(const RayFrame* frame, PATINATE_GLOBAL const BvhNode* nodes,
                                          PATINATE_GLOBAL const TriangleBlock* blocks, const double* origin,
                                          const double* direction, double min_distance, double max_distance) {
  TriangleHit nothing, best;
  nothing.triangle = -1;
  nothing.b1 = nothing.b2 = nothing.distance = 0.0;
  nothing.is_front = true;
  if (!is_usable(origin, direction)) return nothing;
  best = nothing;
  best.distance = max_distance;
  double o[3], near[3], begin = min_distance, end = max_distance;
  for (i32 a = 0; a < 3; ++a) o[a] = origin[a] - frame->center[a];
  if (!cut_to_box(frame, o, direction, &begin, &end)) return nothing;
  const double shift = begin > min_distance ? begin : 0.0;
  for (i32 a = 0; a < 3; ++a) near[a] = o[a] + shift * direction[a];
  const Shear shear = shear_of(direction);
  RayLanes ray;
  make_lanes(&shear, near, direction, frame->slack, &ray);
  const float least = (float)((min_distance - shift) * (1.0 - 1e-6));
  float to = rounded_up(end - shift);
  ray.from = lanes_of(0.0f < least ? least : 0.0f);
  ray.to = lanes_of(to);

  RayEntry stack[kRayStack];
  RayEntry* top = stack;  // Behind the last.
  i32 node = 0;
  for (;;) {
    if (node >= 0) {
      RayEntry* const before = top;
      top = push_children(&ray, nodes, blocks, node, top);
      if (top != before) {
        node = (--top)->node;
        continue;
      }
    } else {
      PATINATE_GLOBAL const TriangleBlock* block = blocks + (-1 - node);
      bool is_nearer = false;
      for (u32 maybe = triangles_maybe_hit(&ray, block); maybe != 0u; maybe &= maybe - 1u) {
        const u32 lane = PATINATE_LOWEST_BIT(maybe);
        if (block->triangle[lane] >= 0 && hits(block, lane, o, &shear, min_distance, &best)) is_nearer = true;
      }
      if (is_nearer) {
        const float nearest = rounded_up(best.distance - shift);
        to = nearest < to ? nearest : to;
        ray.to = lanes_of(to);
      }
    }
    do {
      if (top == stack) return best.triangle >= 0 ? best : nothing;
      --top;
    } while (top->distance > to);
    node = top->node;
  }
}

// Which texel shows a place of a triangle, in the dialect of kernel_language.inl: SurfaceAtlas::texel_of().

// What it reads of an atlas.
typedef struct PlaceFacts {
  PATINATE_MEMBER(i32, width, 0);  // Texels.
  PATINATE_MEMBER(i32, height, 0);
} PlaceFacts;
typedef struct Places {
  PlaceFacts facts;
  PATINATE_GLOBAL const float* corners;    // By triangle: x, y of the three corners, in texels.
  PATINATE_GLOBAL const i32* charts;       // By triangle; -1 where it shows in no texel.
  PATINATE_GLOBAL const u32* fallbacks;    // By triangle: the texel of its middle.
  PATINATE_GLOBAL const i32* tile_charts;  // By tile: what all of its texels show; -1 where there is none.
  PATINATE_GLOBAL const i32* triangles;    // By texel; -1 outside of the charts.
} Places;

enum { kSearchRadius = 2 };  // Texels: a place lies at most 0.71 from the middle of one that its chart may not own.
PATINATE_CONSTANT(u32, kNowhere, 0xFFFFFFFFu);  // kNoTexel.

// TileGrid::index().
static inline u32 texel_index(const PlaceFacts* f, i32 x, i32 y) {
  const u32 ux = (u32)x, uy = (u32)y, page = (uy >> 6) * (u32)((f->width + 63) / 64) + (ux >> 6);
  return page << 12 | (uy >> 3 & 7u) << 9 | (ux >> 3 & 7u) << 6 | (uy & 7u) << 3 | (ux & 7u);
}

// floor(v), cut to [0, size): |v| < 2^31.
static inline i32 nearest_below(double v, i32 size) {
  const i32 cut = (i32)v, floor_of = cut - (v < cut ? 1 : 0);
  return floor_of < 0 ? 0 : (floor_of >= size ? size - 1 : floor_of);
}

static inline bool shows_chart_of(const Places* p, u32 texel, i32 triangle) {
  const i32 shown = p->triangles[texel];
  return shown >= 0 && p->charts[shown] == p->charts[triangle];
}

static inline u32 texel_near(const Places* p, i32 triangle, double px, double py) {
  const PlaceFacts* f = &p->facts;
  const i32 x = nearest_below(px + 0.5, f->width), y = nearest_below(py + 0.5, f->height);
  const u32 here = texel_index(f, x, y);
  // Most tiles show one chart; which one takes far less memory than what each texel shows.
  const i32 chart = p->charts[triangle];
  if (chart >= 0 && p->tile_charts[here >> 6] == chart) return here;
  if (shows_chart_of(p, here, triangle)) return here;
  u32 best = kNowhere;
  double best_distance = 1e30;
  const i32 y0 = y - kSearchRadius < 0 ? 0 : y - kSearchRadius, x0 = x - kSearchRadius < 0 ? 0 : x - kSearchRadius;
  for (i32 ny = y0; ny <= y + kSearchRadius && ny < f->height; ++ny) {
    for (i32 nx = x0; nx <= x + kSearchRadius && nx < f->width; ++nx) {
      const double distance = (nx - px) * (nx - px) + (ny - py) * (ny - py);
      if (distance >= best_distance || !shows_chart_of(p, texel_index(f, nx, ny), triangle)) continue;
      best = texel_index(f, nx, ny);
      best_distance = distance;
    }
  }
  return best != kNowhere ? best : p->fallbacks[triangle];
}

static inline u32 texel_at(const Places* p, i32 triangle, double b1, double b2) {
  PATINATE_GLOBAL const float* c = p->corners + 6 * (u64)triangle;
  const double b0 = 1.0 - b1 - b2;
  const double px = b0 * (double)c[0] + b1 * (double)c[2] + b2 * (double)c[4];
  const double py = b0 * (double)c[1] + b1 * (double)c[3] + b2 * (double)c[5];
  return texel_near(p, triangle, px, py);
}

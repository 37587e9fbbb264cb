// The entries of gammatons' ways: an item a gammaton.

static bool is_clear(const struct Surroundings* s, i32 triangle, bool is_front) {
  return s->clear[2 * triangle + (is_front ? 0 : 1)] != 0;
}

static double wet_amount(const struct Surroundings* s, i32 triangle, double b1, double b2) {
  const u32 texel = texel_at(&s->wet.places, triangle, b1, b2);
  return texel == kNowhere ? 0.0 : (double)s->wet.amounts[texel] / 16384.0;  // kAmountOne
}

#define SCENE_ARRAYS                                                                                              \
  const MotionFacts facts, global const BvhNode *nodes, global const TriangleBlock *blocks,                       \
      global const TriangleFrame *frames, global const CornerNormals *corner_normals,                             \
      global const TriangleLinks *links, global const uchar *empty_cells, global const uchar *clear,              \
      const PlaceFacts place_facts, global const float *corner_texels, global const int *charts,                  \
      global const uint *fallbacks, global const int *tile_charts, global const int *triangles,                   \
      global const ushort *amounts, const ulong first_wet

// `s` and `places` from the arguments.
#define SCENE_OF_ARRAYS                   \
  Places places;                          \
  places.facts = place_facts;             \
  places.corners = corner_texels;         \
  places.charts = charts;                 \
  places.fallbacks = fallbacks;           \
  places.tile_charts = tile_charts;       \
  places.triangles = triangles;           \
  Surroundings s;                         \
  s.facts = &facts;                       \
  s.nodes = nodes;                        \
  s.blocks = blocks;                      \
  s.frames = frames;                      \
  s.corner_normals = corner_normals;      \
  s.links = links;                        \
  s.empty_cells = empty_cells;            \
  s.clear = clear;                        \
  s.wet.places = places;                  \
  s.wet.amounts = amounts + first_wet

kernel void trace_drops(SCENE_ARRAYS, const MotionCall call, global const EmitterFacts* emitters, const uint first,
                        const uint num, global DropRecord* drops) {
  const uint item = (uint)get_global_id(0);
  if (item >= num) return;
  SCENE_OF_ARRAYS;
  global DropRecord* record = drops + item;
  Drop g = drop_of(record);
  uint num_births = record->num_births;
  const Told told = trace_one(&s, &call, emitters + record->emitter, first + item, &g, &num_births);
  put_drop(&g, record);
  record->num_births = num_births;
  record->texel = told.end == kEndContact ? texel_at(&places, g.at.triangle, g.at.b1, g.at.b2) : kNowhere;
  record->end = told.end;
  record->is_born = told.is_born;
  record->is_landing = told.is_landing;
  record->num_pieces = told.num_pieces;
}

kernel void respond_drops(SCENE_ARRAYS, const MotionCall call, const uint first, const uint num,
                          global DropRecord* drops) {
  const uint item = (uint)get_global_id(0);
  if (item >= num) return;
  SCENE_OF_ARRAYS;
  global DropRecord* record = drops + item;
  record->end = kStaysAlive;
  if (record->state != kIsInContact) return;
  Drop g = drop_of(record);
  const Vector normal = shading_normal_of(&s, g.at);
  const uint outcome = respond_to(&s, &call, first + item, &g, normal);
  if (outcome != kStaysAlive) g.state = kIsWaiting;
  put_drop(&g, record);
  record->end = outcome;
}

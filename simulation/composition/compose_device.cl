// The entries of compose_kernel.inl: a group of 64 items a tile, an item a texel.

kernel void compose_tiles(global const PackedTask* tasks, global const QuantizedAppearance* looks,
                          global const ushort* amounts, global const ushort* originals, global const uchar* grains,
                          global const ushort* pictures, global const BaseTile* bases, global const int* heights,
                          global const uchar* srgb, global uint* codes, global int* new_heights) {
  const ulong item = get_global_id(0);
  global const PackedTask* packed = tasks + item / 64u;
  ComposeTask task;
  task.num_materials = packed->num_materials;
  for (int k = 0; k < packed->num_materials; ++k) {
    task.look[k] = looks + packed->look[k];
    task.amount[k] = amounts + (long)packed->amount[k] * 64;
    task.original[k] = originals + (long)packed->original[k] * 64;
    task.grain[k] = packed->grain[k] < 0 ? 0 : grains + (long)packed->grain[k] * 64;
    task.picture[k] = packed->picture[k] < 0 ? 0 : pictures + (long)packed->picture[k] * 192;
  }
  task.base = bases + packed->base;
  task.height = heights + (long)packed->height * 64;
  task.srgb = srgb;
  task.first_texel = packed->first_texel;
  task.is_published_form = packed->is_published_form;
  uint rgba[1];
  int height[1];
  compose_lanes(&task, rgba, height);
  codes[item] = task.num_materials == 0 ? task.base->code[item & 63u] : rgba[0];
  new_heights[item] = height[0];
}

kernel void compose_normals(global const PackedNormal* tiles, global const int* heights, global const int* triangles,
                            global const Frame* frames, global const BorderTexel* border, global uchar* normals) {
  const ulong item = get_global_id(0);
  global const PackedNormal* tile = tiles + item / 64u;
  const int l = (int)(item & 63u), x = l & 7, y = l >> 3;
  const ulong first = (ulong)tile->tile * 64u;
  const int right = x < 7 ? heights[first + l + 1] : heights[(ulong)tile->beside[0] * 64u + l - 7];
  const int left = x > 0 ? heights[first + l - 1] : heights[(ulong)tile->beside[1] * 64u + l + 7];
  const int below = y < 7 ? heights[first + l + 8] : heights[(ulong)tile->beside[2] * 64u + l - 56];
  const int above = y > 0 ? heights[first + l - 8] : heights[(ulong)tile->beside[3] * 64u + l + 56];
  int along_t[1], along_b[1];
  slopes_of_steps(frames[triangles[first + l] + 1], within(right - left, -kMaxStep, kMaxStep),
                  within(below - above, -kMaxStep, kMaxStep), along_t, along_b);
  for (uint b = tile->border_begin; b < tile->border_end; ++b) {
    if (border[b].texel != first + l) continue;
    along_t[0] = slope_at_border(border + b, border[b].along_t, heights);
    along_b[0] = slope_at_border(border + b, border[b].along_b, heights);
  }
  encode_lanes(along_t, along_b, normals + item / 64u * 192u);
}
